//! Jobs that walk from points.

use super::parts::WalkingState;
use super::{Engine, Job, Tally, after_passes, slice_of_passes};
use crate::control::next_judgement;
use crate::maps::{MapKind, half_squares};
use crate::solver::allotment::{Allotment, Carried};
use crate::solver::context::Context;
use crate::solver::passes::{self, PointWalks};
use crate::solver::pilot::{DirectShare, PartCost};
use crate::solver::regions::{Groups, POINTS_OF_A_BLOCK};

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
        let (sharing, expected) = (self.walking.sharing, self.costs.indirect.mean);
        self.divide_into_groups(context, set);
        let WalkingState { allotment, groups, carried, .. } = &self.walking;
        let walks = PointWalks { set, allotment, carried, sharing, groups: groups.as_ref(), expected };
        self.work.rays += passes::walks_from_points(context, walks, &mut self.map, part.0, part.1);
        self.map.indirect_samples = after_passes(entries, times, self.map.len());
    }

    /// Walks in every replica.
    pub(super) fn walks_of_a_replica(&self) -> u64 {
        let WalkingState { allotment, carried, .. } = &self.walking;
        carried.walks() + (self.samples - carried.passes) * allotment.of_all(self.map.len())
    }

    /// Finds the groups of neighbours that share walks, if walks are shared and the groups are not known yet.
    fn divide_into_groups(&mut self, context: &Context, set: usize) {
        let most = self.walking.sharing.neighbours;
        if most > 1 && self.walking.groups.is_none() {
            let points = &context.scene.receivers[set].points;
            self.walking.groups = Some(Groups::of(points, 0..points.len(), most));
        }
    }

    /// Shares walks out anew if some points scatter far more than others and the target takes `needed` times the work so far. The walks so
    /// far stay in the map.
    pub fn share_out_walks(&mut self, context: &Context, needed: f64) {
        self.walking.to_come = 1.0;
        let MapKind::Receivers(set) = self.kind else {
            return;
        };
        let can = self.engine == Engine::Walk;
        if !can || self.met || self.looks.refused || !needed.is_finite() || needed <= 1.0 {
            return;
        }
        self.divide_into_groups(context, set);
        let variances = self.variances_of_walks();
        let passes = (needed - 1.0) * self.samples as f64;
        if let Some((better, gain)) = self.walking.allotment.improved(&variances, self.samples, passes) {
            self.walking.brought /= gain;
            self.adopt_allotment(better, &variances);
            self.next_judgement = next_judgement(self.samples, needed);
        }
        self.walking.to_come = self.walking.allotment.gain_to_come(&variances).recip();
    }

    /// Walks on with another allotment. `variances` are those of walks from the points.
    fn adopt_allotment(&mut self, better: Allotment, variances: &[[f64; 2]]) {
        let variance = better.variance_of_a_pass(variances);
        let ratio = variance / self.walking.allotment.variance_of_a_pass(variances);
        self.carry_walks(better, ratio);
        let points = self.map.len();
        let rays = self.costs.indirect.rays * self.walking.allotment.of_all(points) as f64 / points as f64;
        let pass = PartCost { rays, variance: self.costs.indirect.variance * variance, ..self.costs.indirect };
        self.share = DirectShare::of(self.costs.direct, pass, [points; 2]);
    }

    /// Makes the walks so far count as passes of a new allotment, a pass of which leaves `ratio` times the variance of one of the present
    /// allotment. Their number is the same for all points: docs/methods.md (53).
    fn carry_walks(&mut self, better: Allotment, ratio: f64) {
        let points = self.map.len();
        let samples = (ratio * self.samples as f64).round() as u64;
        let scale = samples as f64 / self.samples as f64;
        self.map.indirect.iter_mut().flatten().for_each(|sum| *sum *= scale);
        self.map.indirect_samples = Tally { complete: samples, partial: 0 };
        self.map.forget_indirect_scores();
        // A kept ray for each ray that the new passes would take, so that rays per sample are those of the passes to come.
        let rays = (self.kept_rays() - self.work.direct_rays) as f64;
        let walks = better.of_all(points) as f64 / self.walking.allotment.of_all(points) as f64;
        self.work.given_up_rays += (rays - rays * scale * walks).max(0.0) as u64;
        let walking = &mut self.walking;
        walking.carried = walking.carried.counted_as(samples, (&walking.allotment, points, self.samples));
        walking.allotment = better;
        self.samples = samples;
        let latest = self.looks.latest.map(|(judgement, _)| (judgement, samples));
        self.forget_looks();
        self.looks.latest = latest;
        self.looks.judged_samples = samples;
    }

    /// Gives up all walks so far.
    pub(super) fn begin_walks_anew(&mut self) {
        self.map.indirect.iter_mut().for_each(|slab| slab.fill(0.0));
        self.map.indirect_samples = Tally::default();
        self.map.forget_indirect_scores();
        self.forget_looks();
        self.give_up_samples();
        self.samples = 0;
        self.walking.carried = Carried::default();
    }

    /// Variance of one walk from every point times the point's weight, up to a common factor, for the even and the odd half. Neighbours
    /// that share walks have equally many walks, so each gets the mean of its group.
    fn variances_of_walks(&self) -> Vec<[f64; 2]> {
        let WalkingState { allotment, carried, .. } = &self.walking;
        let variances = |entry: usize| {
            let of_sums = half_squares(|replica| self.map.indirect[replica][entry]);
            let of_a_walk = carried.scatter(allotment, entry, self.samples);
            of_sums.map(|of_sum| self.weights[entry] * of_sum / of_a_walk)
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
