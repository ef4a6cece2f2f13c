//! Local estimation of receiver sets: rounds of chains that serve all receivers of a set, and of walks for what the
//! bounded kernel leaves out.
//!
//! A round is B chains, whose vertices score at every receiver, and W walks from every receiver. B to W, the bound that
//! follows from it and the thinning of connections are chosen from a pilot by counted rays.

use rayon::prelude::*;

use super::job::Context;
use super::pilot::PartCost;
use super::sweep::{emission_shift, merged, spread_choice};
use crate::chain::Stage;
use crate::estimators::local::{Anchors, ChainVertex, Connecting};
use crate::maps::{PartScores, ReplicaMap};
use crate::sampling::emitter_tree::Cut;
use crate::sampling::random::{Purpose, Stream};

mod plan;

/// What a set's rounds are made of.
pub struct LocalPlan {
    /// Where vertices score.
    anchors: Anchors,
    connecting: Connecting,
    /// Chains of a round.
    pub chains_per_round: u64,
    /// Walks of a round from every entry.
    walks_per_round: u64,
    /// Rays of a round in one replica, as the pilot counted them.
    pub rays_per_round: f64,
    /// Weighted variance that one round leaves, summed over the set.
    pub variance_per_round: f64,
    /// Mean of the indirect light that the pilot found.
    mean_lx: f64,
    /// Whether chains start from scrambled Sobol points.
    quasi: bool,
}

/// Which kernel connects vertices and receivers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kernel {
    /// Bounded, its rest by walks: finite variance everywhere.
    Bounded,
    /// As it stands, 1/d² and all; paths by lobes and mirrors are missing.
    Naive,
}

impl LocalPlan {
    /// Plans the rounds of a receiver set, by a pilot whose samples enter no result.
    pub fn of(context: &Context, set: usize, kernel: Kernel) -> LocalPlan {
        let anchors = Anchors::of(context.stage, &context.scene.receivers[set], context.seed, set as u32 + 1);
        plan::plan(context, set, kernel, anchors)
    }

    /// What a round costs an entry and how it scatters; the weights are those of the entries.
    pub fn cost(&self, weights: &[f64]) -> PartCost {
        let entries = weights.len().max(1) as f64;
        let weight = weights.iter().sum::<f64>().max(f64::MIN_POSITIVE);
        PartCost {
            variance: self.variance_per_round / weight,
            rays: self.rays_per_round / entries,
            mean_lx: self.mean_lx,
        }
    }

    /// Does some rounds in every replica; returns the rays traced.
    pub fn rounds(&self, context: &Context, set: usize, map: &mut ReplicaMap, rounds: std::ops::Range<u64>) -> u64 {
        let whole = &map.scores[1];
        let done: Vec<(u64, PartScores)> = map
            .indirect
            .par_iter_mut()
            .enumerate()
            .map(|(replica, sums)| {
                let chains = rounds.start * self.chains_per_round..rounds.end * self.chains_per_round;
                let walks = rounds.start * self.walks_per_round..rounds.end * self.walks_per_round;
                let mut task = Task { replica: replica as u32, sums, scores: PartScores::for_task(whole) };
                let chain_rays = self.chains(context, set, chains, &mut task);
                let walk_rays = self.walks(context, set, walks, &mut task);
                (chain_rays + walk_rays, task.scores)
            })
            .collect();
        merged(&mut map.scores[1], done)
    }

    fn chains(&self, context: &Context, set: usize, chains: std::ops::Range<u64>, task: &mut Task) -> u64 {
        let (stage, points) = (context.stage, &context.scene.receivers[set].points);
        let flux_lm = stage.emitters.luminous_flux_lm() / self.chains_per_round as f64;
        let mut stream = Stream::new(context.seed, Purpose::Chains, set as u32 + 1, task.replica);
        let shift = emission_shift(&mut stream);
        let mut vertices = Vec::new();
        let mut scores = Vec::new();
        let mut rays = 0;
        for chain in chains {
            let choice = if self.quasi {
                stream.seek_quasi(chain, 0, chain);
                stream.fine_unit()
            } else {
                stream.seek(chain);
                spread_choice(chain, shift)
            };
            rays += trace(&self.anchors, stage, choice, &mut stream, &mut vertices);
            for vertex in &vertices {
                let variate = stream.unit();
                rays += self.anchors.connect(stage, vertex, &self.connecting, variate, &mut scores, |entry, score| {
                    task.add(entry, points[entry].weight, flux_lm * score);
                });
            }
        }
        rays
    }

    fn walks(&self, context: &Context, set: usize, walks: std::ops::Range<u64>, task: &mut Task) -> u64 {
        let receivers = &context.scene.receivers[set];
        let mut stream = Stream::new(context.seed, Purpose::Walks, set as u32 + 1, task.replica);
        let mut cut = Cut::default();
        let mut rays = 0;
        for (entry, point) in receivers.points.iter().enumerate() {
            for walk in walks.clone() {
                stream.seek_quasi((entry as u64) << 32 | walk, entry as u64, walk);
                let bound = self.connecting.bound;
                let (value, walk_rays) =
                    self.anchors.sample_rest(context.stage, receivers, entry, bound, &mut cut, &mut stream);
                task.add(entry, point.weight, value / self.walks_per_round as f64);
                rays += walk_rays;
            }
        }
        rays
    }
}

/// One replica's part of some rounds.
struct Task<'a> {
    replica: u32,
    sums: &'a mut [f64],
    scores: PartScores,
}

impl Task<'_> {
    #[inline]
    fn add(&mut self, entry: usize, weight: f64, value: f64) {
        self.sums[entry] += value;
        self.scores.add(weight.sqrt() * value);
    }
}

/// Traces a chain and lists its vertices; returns the rays.
fn trace(anchors: &Anchors, stage: &Stage, choice: f64, stream: &mut Stream, vertices: &mut Vec<ChainVertex>) -> u64 {
    vertices.clear();
    stage.trace_chain(choice, stream, |arrival| vertices.extend(anchors.vertex(stage, arrival))).1
}
