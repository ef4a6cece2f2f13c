//! Jobs for light that leaves the scene, and the test whether a job is for what is seen.

use super::Job;
use crate::maps::{MapKind, REPLICAS};
use crate::scene::{IntensityTable, Quantity};
use crate::solver::context::Context;
use crate::solver::passes::leaving_chains;

impl Job {
    /// Does one slice of chains, counted by the direction in which they leave the scene, towards `goal` chains.
    pub(super) fn chains_out_until(&mut self, context: &Context, set: usize, table: &IntensityTable, goal: u64) {
        let done = self.map.indirect_samples.complete;
        let rays = self.share.rays_per_indirect.max(1.0) * REPLICAS as f64;
        let until = goal.min(done + (context.pace.rays_per_slice() / rays).ceil() as u64);
        let traced = leaving_chains(context, set, table, &mut self.map, done..until);
        for (replica, (rays, ends)) in traced.into_iter().enumerate() {
            self.work.rays += rays;
            self.ends[replica] += ends;
        }
        self.map.indirect_samples.complete = until;
    }

    /// Whether the map is a luminance or an intensity (seen by an eye or from afar). Gathering cannot compute these.
    pub fn is_seen(&self, context: &Context) -> bool {
        match self.kind {
            MapKind::Receivers(set) => {
                matches!(context.scene.receivers[set].quantity, Quantity::Luminance | Quantity::Intensity { .. })
            }
            MapKind::Elements => false,
        }
    }
}
