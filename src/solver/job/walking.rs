//! Jobs that walk from points.

use std::ops::Range;

use super::parts::WalkingState;
use super::{Engine, Job, Tally, after_passes, slice_of_passes};
use crate::maps::{MapKind, half_squares};
use crate::solver::context::Context;
use crate::solver::passes::{self, PointWalks};
use crate::solver::pilot::{DirectShare, PartCost};
use crate::solver::regions::{Groups, POINTS_OF_A_BLOCK};

/// Walks are shared out anew where the work to the target is this many times the work so far. Earlier, little is known of rare bright
/// walks; later, too much work is given up.
const WORK_LEFT: Range<f64> = 8.0..20.0;
/// A second condition: the passes to come are at least this many times those to a first look.
const FEWEST_LOOKS: f64 = 2.0;
/// Lowest of the bits of a stream's number that count how often walks have begun anew.
const BEGINNINGS_BIT: u32 = 24;

impl Job {
    /// Does one slice of walks from the points of a receiver set, towards `goal` passes over them.
    pub(super) fn walk_from_points(&mut self, context: &Context, set: usize, goal: u64) {
        let rays = self.share.rays_per_indirect;
        let (entries, times) = slice_of_passes(context, self.map.indirect_samples, goal, self.map.len(), rays);
        // Neighbours are in one block, and their walks in one slice.
        let end = if self.walking.sharing.neighbours > 1 {
            entries.end.next_multiple_of(POINTS_OF_A_BLOCK)
        } else {
            entries.end
        };
        let entries = entries.start..end.min(self.map.len());
        let part = (entries.clone(), times.clone());
        let number = MapKind::Receivers(set).number() | self.walking.beginnings << BEGINNINGS_BIT;
        let (sharing, expected_lx) = (self.walking.sharing, self.costs.indirect.mean_lx);
        self.divide_into_groups(context, set);
        let WalkingState { allotment, groups, .. } = &self.walking;
        let walks = PointWalks { set, number, allotment, sharing, groups: groups.as_ref(), expected_lx };
        self.work.rays += passes::walks_from_points(context, walks, &mut self.map, part.0, part.1);
        self.map.indirect_samples = after_passes(entries, times, self.map.len());
    }

    /// Finds the groups of neighbours that share walks, if walks are shared and the groups are not known yet.
    fn divide_into_groups(&mut self, context: &Context, set: usize) {
        let most = self.walking.sharing.neighbours;
        if most > 1 && self.walking.groups.is_none() {
            let points = &context.scene.receivers[set].points;
            self.walking.groups = Some(Groups::of(points, 0..points.len(), most));
        }
    }

    /// Shares walks out anew if some points scatter far more than others and the target takes `needed` times the work so far. That work is
    /// given up and walks begin anew. Direct light keeps its samples.
    pub fn share_out_walks(&mut self, context: &Context, needed: f64) {
        self.walking.to_come = 1.0;
        let MapKind::Receivers(set) = self.kind else {
            return;
        };
        let can = self.engine == Engine::Walk;
        if !can || self.met || self.looks.refused || !needed.is_finite() || needed < WORK_LEFT.start {
            return;
        }
        self.divide_into_groups(context, set);
        let variances = self.variances_of_walks();
        if needed >= WORK_LEFT.end {
            let gain = self.walking.allotment.gain(&variances);
            self.walking.to_come = (1.0 / gain + 1.0 / WORK_LEFT.end).min(1.0);
            return;
        }
        let Some((better, gain)) = self.walking.allotment.improved(&variances, 1.0 / needed) else {
            return;
        };
        let variance = better.variance_of_a_pass(&variances);
        let passes = needed * self.samples as f64 * variance / self.walking.allotment.variance_of_a_pass(&variances);
        if passes < FEWEST_LOOKS * self.first_samples() as f64 {
            return;
        }
        self.walking.to_come = 1.0 / gain;
        self.adapting.before_cut = self.before_cut(context);
        self.walking.to_come = 1.0;
        self.walking.brought /= gain;
        self.begin_walks_anew();
        let points = self.map.len();
        let rays = self.costs.indirect.rays * better.of_all(points) as f64 / points as f64;
        let pass = PartCost { rays, variance_lx2: self.costs.indirect.variance_lx2 * variance, ..self.costs.indirect };
        self.share = DirectShare::of(self.costs.direct, pass, [points; 2]);
        self.walking.allotment = better;
        self.walking.beginnings += 1;
        self.next_judgement = self.first_samples();
    }

    /// Gives up all walks so far.
    pub(super) fn begin_walks_anew(&mut self) {
        self.map.indirect.iter_mut().for_each(|slab| slab.fill(0.0));
        self.map.indirect_samples = Tally::default();
        self.map.forget_indirect_scores();
        self.forget_looks();
        self.give_up_samples();
        self.samples = 0;
    }

    /// Variance of one walk from every point times the point's weight, up to a common factor, for the even and the odd half. Neighbours
    /// that share walks have equally many walks, so each gets the mean of its group.
    fn variances_of_walks(&self) -> Vec<[f64; 2]> {
        let variances = |entry: usize| {
            let of_passes = half_squares(|replica| self.map.indirect[replica][entry]);
            of_passes.map(|of_a_pass| self.weights[entry] * self.walking.allotment.of(entry) as f64 * of_a_pass)
        };
        let mut variances: Vec<[f64; 2]> = (0..self.map.len()).map(variances).collect();
        for group in self.walking.groups.iter().flat_map(Groups::iter) {
            let sum = |half: usize| group.iter().map(|entry| variances[*entry as usize][half]).sum::<f64>();
            let mean = [0, 1].map(|half| sum(half) / group.len() as f64);
            group.iter().for_each(|entry| variances[*entry as usize] = mean);
        }
        variances
    }
}
