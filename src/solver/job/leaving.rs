//! Jobs for light that leaves the scene, and the test whether a job is for what is seen.

use super::Job;
use crate::maps::MapKind;
use crate::scene::Quantity;
use crate::solver::context::Context;
use crate::solver::passes::leaving_chains;

impl Job {
    /// Traces chains until `until` are done, counted by the direction in which they leave the scene.
    pub(super) fn chains_out_until(&mut self, context: &Context, set: usize, until: u64) {
        let Some(table) = context.scene.receivers[set].intensity_table() else { return };
        let chains = self.map.indirect_samples.complete..until;
        let traced = leaving_chains(context, set, table, &mut self.map, chains);
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
