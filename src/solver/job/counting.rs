//! Jobs that count chains from luminaires.

use std::time::Instant;

use super::{CHAINS_OF_BALANCE, Engine, Job};
use crate::maps::MapKind;
use crate::solver::context::Context;
use crate::solver::passes::{self, ScoredArrivals};
use crate::solver::spending::Activity;

impl Job {
    pub(super) fn chains_until(&mut self, context: &Context, until: u64, scored: ScoredArrivals) {
        let chains = self.map.indirect_samples.complete..until;
        let traced =
            passes::chains(context, &self.elements, &mut self.map, self.adapting.adaptive.as_mut(), chains, scored);
        for (replica, (rays, ends)) in traced.into_iter().enumerate() {
            self.work.rays += rays;
            self.ends[replica] += ends;
        }
        self.map.indirect_samples.complete = until;
    }

    /// Lets chains count direct light too. An element map uses this if its first pass over direct light would take longer than the time
    /// left. The unfinished part of that pass is discarded. Counting takes about `most_s` seconds at most, or one slice of chains.
    pub fn count_all_by_chains(&mut self, context: &Context, chains_per_replica: u64, most_s: f64) {
        let (rays, started) = (self.work.rays, Instant::now());
        self.map.direct.iter_mut().for_each(|slab| slab.fill(0.0));
        let goal = chains_per_replica.max(1);
        while self.map.indirect_samples.complete < goal {
            let slice_started = Instant::now();
            let slice = context.pace.rays_of_next(&self.work.slices, Activity::Chains) / self.rays_per_sample();
            let until = goal.min(self.map.indirect_samples.complete + slice.ceil() as u64);
            self.chains_until(context, until, ScoredArrivals::DirectToo);
            context.pace.note(&mut self.work.slices, Activity::Chains, slice_started.elapsed());
            if started.elapsed().as_secs_f64() > most_s {
                break;
            }
        }
        self.map.direct_samples = self.map.indirect_samples;
        self.samples = self.map.indirect_samples.complete;
        self.work.spending.add(Activity::Chains, self.work.rays - rays, started.elapsed());
    }

    /// Traces chains that only show whether flux gets lost, for elements that gather and count no chains.
    pub fn balance_flux(&mut self, context: &Context) {
        if self.kind != MapKind::Elements || self.engine != Engine::Gather || self.gathering.progress.is_none() {
            return;
        }
        let started = Instant::now();
        let traced = passes::ends_of_chains(context, CHAINS_OF_BALANCE);
        let rays = traced.iter().map(|(rays, _)| rays).sum();
        self.work.rays += rays;
        self.ends = std::array::from_fn(|replica| traced[replica].1);
        self.work.spending.add(Activity::Chains, rays, started.elapsed());
    }
}
