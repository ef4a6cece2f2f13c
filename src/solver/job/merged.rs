//! Jobs done by shares of a run: their sums are added, and judged like those of any other job.

use super::{Engine, Job};
use crate::control::accepts;
use crate::maps::{MapKind, Unit, judge};
use crate::scene::Elements;
use crate::solver::context::Context;

impl Job {
    /// Creates a job for sums that are added later, without pilot or plan.
    pub fn to_merge(context: &Context, kind: MapKind, bound: bool, engine: Engine, counts_packets: bool) -> Job {
        let (mut map, weights, elements) = match kind {
            MapKind::Elements => {
                let (map, weights) = super::element_map(context, &context.world.elements, None);
                (map, weights, context.world.elements.clone())
            }
            MapKind::Receivers(set) => {
                let (map, weights) = super::receiver_map(context, set);
                (map, weights, Elements::default())
            }
        };
        if !counts_packets {
            map.indirect_unit = Unit::Scores;
        }
        Job::bare(context, kind, elements, (map, weights), bound, engine)
    }

    /// Judges sums that `chains` chains have made. Shares are independent of each other, so the looks after each share form a history.
    pub fn judge_merged(&mut self, context: &Context, chains: u64) {
        let map = &self.map;
        self.samples = if self.black { map.direct_samples.complete } else { map.indirect_samples.complete };
        self.looks.judged_samples = self.samples;
        self.judgement = judge(map, self.weights.iter().copied().enumerate());
        self.bound_unseen(context, chains.max(1));
        self.note_judgement();
    }

    /// Compares merged sums with the target and runs the statistical checks.
    pub fn settle_merged(&mut self, target_error: Option<f64>) {
        let passes = self.run_checks(target_error);
        let accepted = target_error.is_some_and(|target| accepts(target, &self.judgement));
        self.met = accepted && passes;
        self.looks.refused = accepted && !passes;
        self.looks.refusals = u64::from(self.looks.refused);
    }
}
