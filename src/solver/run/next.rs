//! Which map a run goes on with, and whether all are done.

use super::{FIRST_LOOK_RAYS, Run, UNBOUND_SHARE};
use crate::solver::StopReason;
use crate::solver::job::Job;

impl Run<'_> {
    /// The job to go on with: of those that still have work, the bound one of whose work the least share is done, so that the largest of
    /// them is known early; an unbound one where its share allows.
    pub(super) fn next_job(&self) -> Option<usize> {
        let open = |job: &&(usize, &Job)| !self.is_done(job.1);
        let jobs: Vec<(usize, &Job)> = self.jobs.iter().enumerate().collect();
        let bound = jobs.iter().filter(|(_, job)| job.bound).filter(open);
        let bound = bound.map(|one| (self.share_done(one.1), one));
        let bound = bound.min_by(|(share, (_, job)), (other_share, (_, other))| {
            share.total_cmp(other_share).then(job.rays.cmp(&other.rays))
        });
        let bound = bound.map(|(_, one)| one);
        let unbound = jobs.iter().filter(|(_, job)| !job.bound).filter(open).min_by_key(|(_, job)| job.rays);
        match (bound, unbound) {
            (Some((index, _)), Some((other, unbound))) => {
                let next_rays = unbound.rays_to(self.goal(unbound));
                let within_share = self.rays_of(false) + next_rays <= UNBOUND_SHARE * self.rays_of(true);
                Some(if within_share { *other } else { *index })
            }
            (Some((index, _)), None) => Some(*index),
            // Every map gets a first look, if that is not much more than what the bound ones needed.
            (None, Some((index, job))) if self.settings.chains.is_some() || self.affords_first_look(job) => {
                Some(*index)
            }
            (None, _) => None,
        }
    }

    /// Share of its work that is done, as far as that can be forecast: else a half of what has begun.
    fn share_done(&self, job: &Job) -> f64 {
        let rays = job.rays as f64;
        match self.left_of(job) {
            _ if job.rays == 0 => 0.0,
            Some(left) if left.expected.is_finite() => rays / (rays + left.expected),
            _ => 0.5,
        }
    }

    pub(super) fn is_done(&self, job: &Job) -> bool {
        if self.settings.chains.is_some_and(|chains| job.samples >= job.samples_for(chains)) {
            return true;
        }
        if job.finest {
            return true;
        }
        let stays_dark = self.target_error.is_some_and(|target| job.stays_dark(target));
        job.met || stays_dark || job.is_exact() || job.map.is_empty() || job.weights.iter().all(|weight| *weight <= 0.0)
    }

    pub(super) fn why_all_is_done(&self) -> StopReason {
        if self.jobs.iter().all(|job| job.is_exact()) {
            StopReason::Exact
        } else if self.target_error.is_some()
            && self.jobs.iter().filter(|job| job.bound).all(|job| job.met || (job.judgement.dark && job.is_black()))
        {
            StopReason::TargetMet
        } else if self.jobs.iter().any(|job| job.bound && job.finest) {
            StopReason::FinestMesh
        } else {
            StopReason::Chains
        }
    }

    fn affords_first_look(&self, job: &Job) -> bool {
        let started = job.samples > 0 || job.rays > 0;
        let share = (UNBOUND_SHARE * self.rays_of(true)).max(FIRST_LOOK_RAYS);
        !job.is_judged() && (started || job.rays_to(job.first_samples()) <= share)
    }
}
