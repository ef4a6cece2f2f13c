//! Which map a run continues with, and whether all maps are done.

use super::map_states::MapState;
use super::state::{FIRST_LOOK_RAYS, Run, UNBOUND_SHARE};
use crate::solver::StopReason;
use crate::solver::job::Job;

impl Run<'_> {
    /// The job to continue with. Among bound maps with work left, it is the one with the least share of its work done. So the largest is
    /// known early. An unbound map is chosen if its share of rays allows it.
    pub(super) fn next_job(&mut self) -> Option<usize> {
        if !self.map_states.is_known() {
            let states: Vec<MapState> = self.jobs.iter().map(|job| self.state_of(job)).collect();
            self.map_states.note_all(states.into_iter());
        }
        match self.map_states.next() {
            [Some(index), Some(other)] => {
                let unbound = &self.jobs[other];
                let next_rays = unbound.rays_to(self.goal(unbound));
                Some(if next_rays <= self.rays_for_unbound(0.0) { other } else { index })
            }
            [Some(index), None] => Some(index),
            // Every map gets a first look, if that is not much more than what the bound ones needed.
            [None, Some(index)] if self.settings.chains.is_some() || self.affords_first_look(&self.jobs[index]) => {
                Some(index)
            }
            [None, _] => None,
        }
    }

    /// Records the state of a map that has changed.
    pub(super) fn note(&mut self, index: usize) {
        let state = self.state_of(&self.jobs[index]);
        self.map_states.note(index, state);
    }

    fn state_of(&self, job: &Job) -> MapState {
        let open = !self.is_done(job);
        let turn = if open && job.bound { self.turn_of(job) } else { 0.0 };
        let (rays, all_rays, bytes) = (job.work.rays, job.all_rays(), job.bytes_of_gathering());
        MapState { bound: job.bound, open, turn, rays, all_rays, bytes }
    }

    /// Rays so far of all bound, or of all unbound maps.
    pub(super) fn rays_of(&self, bound: bool) -> f64 {
        let sum = || self.jobs.iter().filter(|job| job.bound == bound).map(|job| job.work.rays).sum::<u64>();
        self.map_states.rays_of(bound).unwrap_or_else(sum) as f64
    }

    /// Rays that unbound maps may still take, given the rays of bound maps so far and `bound_rays_to_come` more.
    pub(super) fn rays_for_unbound(&self, bound_rays_to_come: f64) -> f64 {
        UNBOUND_SHARE * (self.rays_of(true) + bound_rays_to_come) - self.rays_of(false)
    }

    /// All rays so far.
    pub(super) fn all_rays(&self) -> u64 {
        let sum = || self.jobs.iter().map(Job::all_rays).sum::<u64>();
        self.context.world.selection_rays() + self.map_states.all_rays().unwrap_or_else(sum)
    }

    /// Order of a map's turn, lowest first: the share of its work that is done if that can be forecast, else one half. A first look takes
    /// little and shows far more than a pilot. So maps before their first look come before all others, ordered by the most forecast work
    /// per ray to the look.
    fn turn_of(&self, job: &Job) -> f64 {
        let left = self.left_of(job).map(|left| left.expected).filter(|left| left.is_finite());
        if !job.has_been_judged() {
            return -left.unwrap_or(1.0) / job.rays_to_look(self.context).max(1.0);
        }
        let rays = job.work.rays as f64;
        left.map_or(0.5, |left| rays / (rays + left))
    }

    pub(super) fn is_done(&self, job: &Job) -> bool {
        if self.settings.chains.is_some_and(|chains| job.samples >= job.samples_for(chains)) {
            return true;
        }
        if job.adapting.finest {
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
        } else if self.jobs.iter().any(|job| job.bound && job.adapting.finest) {
            StopReason::FinestMesh
        } else {
            StopReason::Chains
        }
    }

    fn affords_first_look(&self, job: &Job) -> bool {
        let started = job.samples > 0 || job.work.rays > 0;
        let share = (UNBOUND_SHARE * self.rays_of(true)).max(FIRST_LOOK_RAYS);
        !job.is_judged() && (started || job.rays_to(job.first_samples()) <= share)
    }
}
