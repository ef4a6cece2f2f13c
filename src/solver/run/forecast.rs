//! Forecast of the work that a run still takes.

use super::progress::SlowestMap;
use super::state::{FIRST_LOOK_RAYS, Run};
use crate::control::Forecast;
use crate::solver::choice;
use crate::solver::job::{Hindrance, Job};
use crate::solver::sparse::rays_to_fill;

/// Standard deviation of the logarithm of the rays of maps that are not bound by the target.
const DEVIATION_OF_UNBOUND: f64 = 0.3;
/// Standard deviation of the logarithm of all work, before methods other than walks and counts are considered. The forecast was 4.9 times
/// too long at most in ten made-up rooms.
const DEVIATION_BEFORE_CHOICE: f64 = 0.9;

/// Work that is left to do.
#[derive(Default)]
pub(super) struct WorkLeft {
    pub rays: Forecast,
    /// Rays whose kinds were timed, and the seconds that they will take.
    timed: (f64, f64),
    /// The map that takes the most of it, and its rays.
    pub slowest: Option<(SlowestMap, f64)>,
}

impl WorkLeft {
    /// Records the part of a map in it.
    fn note(&mut self, map: SlowestMap, rays: Forecast) {
        // A map whose target is out of reach ranks before one that only takes long.
        let is_worse = |(slowest, most): &(SlowestMap, f64)| {
            let ranks = [&map, slowest].map(|map| map.hindrance.as_ref().is_some_and(Hindrance::is_out_of_reach));
            if ranks[0] == ranks[1] { rays.expected > *most } else { ranks[0] }
        };
        if self.slowest.as_ref().is_none_or(is_worse) {
            self.slowest = Some((map, rays.expected));
        }
    }
}

impl Run<'_> {
    /// Rays and seconds to the end, whichever rule ends the run. `None` if only the user ends it.
    pub(super) fn remaining(&self, rays: u64, wall_s: f64) -> Option<(WorkLeft, Forecast)> {
        let to_limit_s = self.settings.time_limit_s.map(|limit_s| (limit_s - wall_s).max(0.0));
        let to_limit_rays = to_limit_s.map(|seconds| seconds * self.clock.rays_per_s(rays, wall_s));
        if self.target_error.is_none() && self.settings.chains.is_none() {
            let left = WorkLeft { rays: Forecast::known(to_limit_rays?), ..WorkLeft::default() };
            return Some((left, Forecast::known(to_limit_s?)));
        }
        let mut left = self.left()?;
        if self.is_undecided() {
            left.rays = left.rays.times(1.0, DEVIATION_BEFORE_CHOICE);
        }
        let mut seconds = self.clock.seconds_of(left.rays, left.timed, rays, wall_s);
        if let (Some(limit_rays), Some(limit_s)) = (to_limit_rays, to_limit_s) {
            left.rays = left.rays.at_most(limit_rays);
            seconds = seconds.at_most(limit_s);
        }
        Some((left, seconds))
    }

    /// Whether methods other than walks and counts are still to be considered.
    fn is_undecided(&self) -> bool {
        self.may_gather() && !self.clock.has_piloted()
    }

    /// What all maps still take. `None` if nothing is known about one of them.
    fn left(&self) -> Option<WorkLeft> {
        let mut left = WorkLeft::default();
        let mut by_pilots = Forecast::default();
        // In about one of four runs a check refuses a map once. This is inside the interval.
        let (mut refused, mut filling) = (0.0f64, 0.0);
        for job in self.jobs.iter().filter(|job| job.bound && !self.is_done(job)) {
            let rays = self.left_of(job)?;
            let hindrance = self.target_error.and_then(|target| job.hindrance(target));
            if let Some(seconds_per_ray) = job.seconds_per_ray() {
                left.timed.0 += rays.expected;
                left.timed.1 += rays.expected * seconds_per_ray;
            }
            left.note(SlowestMap { name: job.name.clone(), error: job.stated_error(), hindrance }, rays);
            // If the pilots of one map overestimate, those of the others probably do too.
            if job.is_judged() {
                left.rays = left.rays.plus(rays)
            } else {
                by_pilots = by_pilots.plus_alike(rays)
            }
            refused = job.rays_if_refused(rays.expected).max(refused);
            filling += rays_to_fill(self.context, job, job.work.rays as f64 + rays.expected);
        }
        left.rays = left.rays.plus(by_pilots).plus(Forecast::known(filling));
        if self.settings.chains.is_none() {
            left.rays = left.rays.plus(Forecast { expected: 0.0, low: 0.0, high: refused });
        }
        let unbound = self.left_of_unbound(left.rays.expected);
        left.rays = left.rays.plus(unbound);
        Some(left)
    }

    /// Rays that a map still takes to the target, or to the requested number of chains.
    pub(super) fn left_of(&self, job: &Job) -> Option<Forecast> {
        let to_chains = |chains: u64| Forecast::known(job.rays_to(job.samples_for(chains)));
        match (self.settings.chains, self.target_error) {
            (Some(chains), None) => Some(to_chains(chains)),
            (Some(chains), Some(target)) => {
                let most = to_chains(chains).expected;
                Some(job.rays_left(self.context, target).map_or(Forecast::known(most), |left| left.at_most(most)))
            }
            (None, Some(target)) if self.is_undecided() && choice::is_about_to_gather(self.context, job, target) => {
                Some(job.rays_left_by_cells(self.context, target))
            }
            (None, Some(target)) => job.rays_left(self.context, target),
            (None, None) => None,
        }
    }

    /// Rays that unbound maps still take, given the rays that bound maps still take: a first look, and the rays to the target if these fit
    /// into the share of unbound maps. The chains that show where the flux goes are added.
    fn left_of_unbound(&self, bound_rays: f64) -> Forecast {
        let mut share = self.rays_for_unbound(bound_rays);
        let mut sum = 0.0;
        for job in self.jobs.iter().filter(|job| !job.bound && !self.is_done(job)) {
            let rays = if job.is_judged() || self.settings.chains.is_some() {
                let needed = self.left_of(job).map_or(0.0, |left| left.expected);
                if needed <= share { needed } else { 0.0 }
            } else {
                let look = job.rays_to_look(self.context);
                if job.work.rays > 0 || look <= share.max(FIRST_LOOK_RAYS) { look } else { 0.0 }
            };
            share -= rays;
            sum += rays + rays_to_fill(self.context, job, job.work.rays as f64 + rays);
        }
        // These chains come at the end of the run.
        let balance: f64 = self.jobs.iter().map(Job::rays_of_balance).sum();
        Forecast::spread(sum + balance, DEVIATION_OF_UNBOUND)
    }
}
