//! How a run stands, and what it is still to take.

use super::{Progress, Run};
use crate::control::needed_work;
use crate::solver::ConvergenceRow;
use crate::solver::job::{Engine, Job};

/// Work that is left to do.
#[derive(Default)]
struct Left {
    chains: f64,
    rays: f64,
    seconds: f64,
    /// The map that takes the most of it, and its seconds.
    slowest: Option<(String, f64)>,
}

impl Left {
    fn add(&mut self, map: &str, chains: f64, rays: f64, seconds: f64) {
        if self.slowest.as_ref().is_none_or(|(_, most)| seconds > *most) {
            self.slowest = Some((map.to_owned(), seconds));
        }
        self.chains += chains;
        self.rays += rays;
        self.seconds += seconds;
    }
}

impl Run<'_> {
    /// How the run stands as a row of its history, once a map has been judged.
    pub(super) fn convergence_row(&self) -> Option<ConvergenceRow> {
        let progress = self.progress();
        Some(ConvergenceRow {
            wall_s: progress.wall_s,
            chains: progress.chains,
            estimated_error: progress.estimated_error?,
            forecast_wall_s: progress.wall_s + progress.remaining_s.unwrap_or(0.0),
            forecast_chains: progress.forecast_chains.unwrap_or(progress.chains as f64),
            rays: progress.rays,
            forecast_rays: progress.forecast_rays.unwrap_or(progress.rays as f64),
        })
    }

    /// How the run stands, with a forecast once a look has told what the target takes.
    pub(super) fn progress(&self) -> Progress {
        let judged = || self.jobs.iter().filter(|job| job.bound && job.judgement.mean_lx > 0.0);
        let chains: u64 = self.jobs.iter().map(Job::chains).sum::<u64>();
        let rays = self.context.stage.outlook_rays() + self.jobs.iter().map(Job::all_rays).sum::<u64>();
        let wall_s = self.observer.wall_s();
        let left = self.left(rays as f64 / (wall_s - self.started_wall_s).max(f64::MIN_POSITIVE));
        let time_fraction = self.settings.time_limit_s.map_or(0.0, |limit_s| wall_s / limit_s);
        let work_fraction = rays as f64 / (rays as f64 + left.rays).max(1.0);
        // What gathers has a plan before its first look.
        let is_judged = |job: &Job| job.judged_samples() > 0;
        let has_plan = |job: &Job| job.engine == Engine::Gathering;
        let is_known = |job: &Job| is_judged(job) || job.map.is_empty() || has_plan(job);
        let bound = || self.jobs.iter().filter(|job| job.bound);
        let known = bound().all(is_known)
            && bound().any(is_judged)
            && (self.target_error.is_some() || self.settings.chains.is_some());
        Progress {
            estimated_error: judged().map(|job| job.judgement.stated_error()).reduce(f64::max),
            target_error: self.target_error,
            chains,
            rays,
            forecast_chains: known.then_some(chains as f64 + left.chains),
            forecast_rays: known.then_some(rays as f64 + left.rays),
            remaining_s: known.then_some(left.seconds),
            slowest_map: left.slowest.filter(|_| known).map(|(name, _)| name),
            fraction: if known { work_fraction.max(time_fraction) } else { time_fraction }.min(1.0),
            wall_s,
        }
    }

    /// What the bound maps are still to take, by their latest looks and plans, at a rate of all rays so far.
    fn left(&self, rays_per_s: f64) -> Left {
        let mut left = Left::default();
        for job in self.jobs.iter().filter(|job| job.bound && !job.met && !job.finest) {
            if job.engine == Engine::Gathering {
                let rays = self.rays_to_ask(job);
                left.add(&job.name, 0.0, rays, rays / rays_per_s);
            } else if job.samples > 0 {
                let more = self.more_samples(job);
                let share = more / job.samples as f64;
                left.add(
                    &job.name,
                    share * job.chains() as f64,
                    job.rays_to(job.samples + more as u64),
                    share * job.spending.all_seconds(),
                );
            } else if let Some(target) = self.target_error {
                let rays = job.rays_without_gathering(self.context, target * job.mean_without_gathering_lx());
                left.add(&job.name, 0.0, rays, rays / rays_per_s);
            }
        }
        left
    }

    /// Rays that a map which asks cells still takes: by its latest plan, before its first look by its pilot.
    fn rays_to_ask(&self, job: &Job) -> f64 {
        match (job.rays_to_ask(), self.target_error) {
            (Some(rays), _) => rays,
            (None, Some(target)) if self.settings.chains.is_none() => {
                (job.work_by_cells(self.context, target) - job.rays as f64).max(0.0)
            }
            _ => 0.0,
        }
    }

    /// Samples that a bound job which has not met the target still needs, by its own latest judgement or by the chains asked for.
    fn more_samples(&self, job: &Job) -> f64 {
        let done = job.samples as f64;
        let to_target = match self.target_error {
            Some(_) if job.refused => job.next_judgement as f64 - done,
            Some(target) if job.judgement.mean_lx > 0.0 => {
                // The judgement is of the last look; samples have been added since.
                (needed_work(target, &job.judgement, job.error_exponent()) * job.judged_samples() as f64 - done)
                    .max(0.0)
            }
            _ => f64::INFINITY,
        };
        let to_chains = self
            .settings
            .chains
            .map_or(f64::INFINITY, |chains| job.samples_for(chains).saturating_sub(job.samples) as f64);
        let more = to_target.min(to_chains);
        if more.is_finite() { more } else { 0.0 }
    }
}
