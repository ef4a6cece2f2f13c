//! Local estimation of receiver sets: rounds of chains that serve all receivers of a set, and of walks for what the bounded kernel leaves
//! out.
//! A round is B chains, whose vertices score at every receiver, and W walks from every receiver. A pilot chooses B to W, the bound that
//! follows from it, and the thinning of connections, by counted rays.

use std::sync::atomic::AtomicBool;
use std::sync::atomic::Ordering::Relaxed;

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::context::Context;
use super::pace::TimeLeft;
use super::passes::merged;
use super::pilot::PartCost;
use super::streams::{emission_shift, spread_choice};
use crate::estimators::local::{Anchors, BRANCHES, ChainVertex, Connecting};
use crate::maps::{MapKind, PartScores, ReplicaMap};
use crate::sampling::emitter_tree::Cut;
use crate::sampling::random::{Purpose, Stream};
use crate::transport::World;

mod plan;

/// Bits of a stream's index that count walks. The bits above them give the entry.
const WALK_BITS: u32 = 40;

/// Marks the indices of the random numbers that thin a chain's scores.
const THINNING: u64 = 1 << 63;

/// Rays of a task between two readings of the clock.
const RAYS_BETWEEN_LOOKS: u64 = 10_000;

/// Parameters of a set's rounds.
#[derive(Serialize, Deserialize)]
pub struct LocalPlan {
    /// Points at which vertices score.
    anchors: Anchors,
    connecting: Connecting,
    /// Chains of a round.
    pub chains_per_round: u64,
    /// Walks of a round from every entry.
    walks_per_round: u64,
    /// Rays of a round in one replica, as counted by the pilot.
    pub rays_per_round: f64,
    /// Weighted variance that one round leaves, summed over the set.
    pub variance_per_round: f64,
    /// Approximate ratio of the variance of independent chains to that of the run's chains, which start from quasi-random points.
    pub quasi_gain: f64,
    /// Factor by which the expected error of a run must be below the target: all entries of a map share the few degrees of freedom of its
    /// chains.
    pub margin: f64,
    /// Ratio of the light from the pilot's chains to what walks find for the same light. Connections count as unobstructed unless the pilot
    /// traces them.
    pub found: f64,
    /// Chains of the pilot.
    pub pilot_chains: usize,
    /// Rays that the pilot took.
    pub pilot_rays: u64,
    /// Mean of the indirect light that the pilot found.
    mean: f64,
    /// Whether chains start from scrambled Sobol points.
    quasi: bool,
}

/// The kernel that connects vertices and receivers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Kernel {
    /// Bounded, with the rest estimated by walks: finite variance everywhere.
    Bounded,
    /// Unbounded, with the full 1/d²; paths by lobes and mirrors are missing.
    Naive,
}

impl LocalPlan {
    /// Plans the rounds of a receiver set with a pilot, whose samples enter no result. The pilot is larger if more work is at stake
    /// (`at_stake`). It assumes that all connections are unobstructed.
    pub fn of(context: &Context, set: usize, kernel: Kernel, at_stake: f64) -> LocalPlan {
        plan::plan(context, set, kernel, LocalPlan::anchors(context, set), at_stake, false)
    }

    /// Plans the rounds with a pilot that traces its connections, and so includes obstructions.
    pub fn by_tracing(context: &Context, set: usize, at_stake: f64) -> LocalPlan {
        plan::plan(context, set, Kernel::Bounded, LocalPlan::anchors(context, set), at_stake, true)
    }

    fn anchors(context: &Context, set: usize) -> Anchors {
        Anchors::of(context.world, &context.scene.receivers[set], context.seed, MapKind::Receivers(set).number())
    }

    /// Cost of a round per entry, and its scatter. `weights` are those of the entries.
    pub fn cost(&self, weights: &[f64]) -> PartCost {
        let entries = weights.len().max(1) as f64;
        let weight = weights.iter().sum::<f64>().max(f64::MIN_POSITIVE);
        PartCost {
            variance: self.variance_per_round / weight,
            rays: self.rays_per_round / entries,
            sharing_rays: 0.0,
            choosing: 0.0,
            mean: self.mean,
            pilot_rays: self.pilot_rays,
        }
    }

    /// Weighted variance of a single chain relative to the squared mean of indirect light, approximately.
    pub fn scatter(&self, weights: &[f64]) -> f64 {
        self.cost(weights).variance * self.chains_per_round as f64 / (self.mean * self.mean).max(f64::MIN_POSITIVE)
    }

    /// Does some rounds in every replica and returns the rays traced. A single round takes long in a nearly white room. It is given up if
    /// the run should have ended long ago: then the result is `None`, and the map is unchanged.
    pub fn rounds(
        &self,
        context: &Context,
        set: usize,
        map: &mut ReplicaMap,
        rounds: std::ops::Range<u64>,
    ) -> Option<u64> {
        let before = (rounds.end - rounds.start == 1).then(|| map.indirect.clone());
        let patience = RoundPatience { context, may_end: before.is_some(), given_up: AtomicBool::new(false) };
        let whole = &map.scores[1];
        let done: Vec<(u64, PartScores)> = map
            .indirect
            .par_iter_mut()
            .with_max_len(1)
            .enumerate()
            .map(|(replica, sums)| {
                let chains = rounds.start * self.chains_per_round..rounds.end * self.chains_per_round;
                let mut task = RoundsTask { replica: replica as u32, sums, scores: PartScores::for_task(whole) };
                let chain_rays = self.chains(&patience, set, chains, &mut task);
                let walk_rays = self.walks(&patience, set, rounds.clone(), &mut task);
                (chain_rays + walk_rays, task.scores)
            })
            .collect();
        if let (true, Some(before)) = (patience.given_up.load(Relaxed), before) {
            map.indirect = before;
            return None;
        }
        Some(merged(&mut map.scores[1], done))
    }

    fn chains(&self, patience: &RoundPatience, set: usize, chains: std::ops::Range<u64>, task: &mut RoundsTask) -> u64 {
        let context = patience.context;
        let (world, points) = (context.world, &context.scene.receivers[set].points);
        let flux_lm = world.emitters.luminous_flux_lm() / self.chains_per_round as f64;
        let mut stream = Stream::new(context.seed, Purpose::Chains, MapKind::Receivers(set).number(), task.replica);
        let shift = emission_shift(&mut stream);
        let mut vertices = Vec::new();
        let mut chosen = Vec::new();
        let (mut rays, mut read_at) = (0, 0);
        for chain in chains {
            if patience.is_at_an_end(rays, &mut read_at) {
                break;
            }
            rays += if self.quasi {
                let rays = trace(&self.anchors, world, chain, &mut stream, &mut vertices);
                // The unused coordinates of the last branch's point are related, by shifted digits, to the vertices of the other branches.
                // So thinning uses its own random numbers.
                stream.seek(THINNING | chain);
                rays
            } else {
                stream.seek(chain);
                trace_plain(&self.anchors, world, spread_choice(chain, shift), &mut stream, &mut vertices)
            };
            for vertex in &vertices {
                let variate = stream.unit();
                rays += self.anchors.connect(world, vertex, &self.connecting, variate, &mut chosen, |entry, score| {
                    task.add(entry, points[entry].weight, flux_lm * score);
                });
            }
        }
        rays
    }

    /// Does the walks of some rounds. An entry with less than one walk per round gets one every few rounds. The round of its first walk is
    /// random, so that the mean is right after any number of rounds.
    fn walks(&self, patience: &RoundPatience, set: usize, rounds: std::ops::Range<u64>, task: &mut RoundsTask) -> u64 {
        let context = patience.context;
        let receivers = &context.scene.receivers[set];
        let mut stream = Stream::new(context.seed, Purpose::Walks, MapKind::Receivers(set).number(), task.replica);
        let mut cut = Cut::default();
        let (mut rays, mut read_at) = (0, 0);
        for (entry, point) in receivers.points.iter().enumerate() {
            let a_round = self.walks_per_round as f64 * self.anchors.walk_rate(entry);
            stream.seek(u64::MAX - entry as u64);
            let phase = stream.unit();
            let until = |round: u64| (round as f64 * a_round + phase) as u64;
            if patience.is_at_an_end(rays, &mut read_at) {
                break;
            }
            for walk in until(rounds.start)..until(rounds.end) {
                stream.seek_quasi((entry as u64) << WALK_BITS | walk, entry as u64, walk);
                let bound = self.connecting.bound;
                let rest = self.anchors.sample_rest(context.world, receivers, entry, bound, &mut cut, &mut stream);
                task.add(entry, point.weight, rest.value / a_round);
                rays += rest.rays;
            }
        }
        rays
    }
}

/// Whether tasks go on with a round.
struct RoundPatience<'a> {
    context: &'a Context<'a>,
    /// Whether the round may be given up.
    may_end: bool,
    /// Whether it was given up.
    given_up: AtomicBool,
}

impl RoundPatience<'_> {
    /// Whether the round is given up. It reads the clock every `RAYS_BETWEEN_LOOKS` rays of a task.
    fn is_at_an_end(&self, rays: u64, read_at: &mut u64) -> bool {
        if self.may_end && rays > *read_at + RAYS_BETWEEN_LOOKS {
            *read_at = rays;
            if (self.context.time_left)() == TimeLeft::LongOver {
                self.given_up.store(true, Relaxed);
            }
        }
        self.given_up.load(Relaxed)
    }
}

/// One replica's part of some rounds.
struct RoundsTask<'a> {
    replica: u32,
    sums: &'a mut [f64],
    scores: PartScores,
}

impl RoundsTask<'_> {
    #[inline]
    fn add(&mut self, entry: usize, weight: f64, value: f64) {
        self.sums[entry] += value;
        self.scores.add(weight.sqrt() * value);
    }
}

/// A variate that chooses the emitter. If there is only one emitter, no variate is drawn: the first coordinates of a quasi-random point,
/// which are spread best, then give the direction.
fn choice_of_emitter(world: &World, stream: &mut Stream) -> f64 {
    if world.emitters.list().len() == 1 { 0.0 } else { stream.fine_unit() }
}

/// Traces a chain from quasi-random points and lists its vertices. Returns the rays.
/// Its branches continue from one point by shifted digits. The branches of one chain are spread evenly, and each branch number is spread
/// evenly over all chains.
fn trace(anchors: &Anchors, world: &World, chain: u64, stream: &mut Stream, vertices: &mut Vec<ChainVertex>) -> u64 {
    let first_index = chain * (u64::from(BRANCHES) + 1);
    stream.seek_quasi(first_index, 0, chain);
    let choice = choice_of_emitter(world, stream);
    vertices.clear();
    // The first arrival is shared by all branches.
    let mut share = 1.0;
    world.trace_branches(choice, stream, BRANCHES, first_index + 1, |arrival| {
        vertices.extend(anchors.vertex(world, arrival, share));
        share = 1.0 / f64::from(BRANCHES);
    })
}

/// Traces a chain from random numbers, without branches, and lists its vertices. Returns the rays.
fn trace_plain(
    anchors: &Anchors,
    world: &World,
    choice: f64,
    stream: &mut Stream,
    vertices: &mut Vec<ChainVertex>,
) -> u64 {
    vertices.clear();
    world.trace_chain(choice, stream, |arrival| vertices.extend(anchors.vertex(world, arrival, 1.0))).1
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::check::scene_from_json;
    use crate::maps::{REPLICAS, Unit};
    use crate::solver::Method;

    const CUBE: &str = r#"{ "version": 1, "materials": { "grey": { "type": "diffuse", "reflectance": 0.5 } },
      "geometry": [ { "name": "cube", "type": "box", "min": [0,0,0], "max": [1,1,1], "facing": "inward", "material": "grey" } ],
      "luminaires": [ { "name": "source", "type": "point", "position": [0.5, 0.5, 0.5], "luminous_flux_lm": 1000 } ],
      "receivers": [ { "name": "row", "type": "grid", "origin": [0.1, 0.5, 0.2], "u": [0.8, 0, 0], "v": [0, 0.1, 0], "columns": 5, "rows": 1 } ] }"#;

    const UNDER_A_TABLE: &str = r#"{ "version": 1, "materials": { "grey": { "type": "diffuse", "reflectance": 0.5 } },
      "geometry": [ { "name": "room", "type": "box", "min": [0,0,0], "max": [4,4,3], "facing": "inward", "material": "grey" },
        { "name": "top", "type": "box", "min": [0.15,0.15,0.3], "max": [3.85,3.85,0.35], "material": "grey" } ],
      "luminaires": [ { "name": "source", "type": "point", "position": [2, 2, 2], "luminous_flux_lm": 1000 } ],
      "receivers": [ { "name": "row", "type": "grid", "origin": [1.5, 1.5, 0.01], "u": [1, 0, 0], "v": [0, 1, 0], "columns": 5, "rows": 5 } ] }"#;

    fn context<'a>(scene: &'a crate::scene::Scene, world: &'a World, seed: u64) -> Context<'a> {
        Context { method: Method::Local, ..Context::of_a_test(scene, world, seed) }
    }

    /// A table hides most of a floor from the lamp's spot. A pilot that traces its connections finds as much light as walks. The test takes
    /// the mean of the logarithm of the ratio over seeds 0 to 63, since pilots differ by factors: within 4 standard errors (α = 6e-5) and a
    /// fifth. Planted fault: a pilot that assumes unobstructed connections finds more.
    #[test]
    fn a_pilot_that_traces_knows_what_stands_in_the_way() {
        const SEEDS: u64 = 64;
        let scene = scene_from_json(UNDER_A_TABLE, None, Path::new(".")).expect("a scene");
        let world = World::new(&scene);
        let off_by = |plan: &dyn Fn(&Context) -> LocalPlan| {
            let found: Vec<f64> = (0..SEEDS).map(|seed| plan(&context(&scene, &world, seed)).found.ln()).collect();
            let mean = found.iter().sum::<f64>() / SEEDS as f64;
            let squares: f64 = found.iter().map(|found| (found - mean).powi(2)).sum();
            (mean, (squares / (SEEDS * (SEEDS - 1)) as f64).sqrt())
        };
        let (traced, error) = off_by(&|context| LocalPlan::by_tracing(context, 0, 4e6));
        assert!(traced.abs() < (4.0 * error).min(0.2), "{traced} ± {error}");
        let (free, error) = off_by(&|context| LocalPlan::of(context, 0, Kernel::Bounded, 4e6));
        assert!(free > (4.0 * error).max(0.2), "the fault passed: {free} ± {error}");
    }

    /// Indices on both sides of 2³² chains and of 2³² walks. Rounds done in one call give the same sums as rounds done one by one. No round
    /// is done twice, and the means equal those of the first rounds. 16 replicas of 512 rounds; the mean of five receivers is within 4.5
    /// standard errors of the difference. Planted fault: 2% more light is outside of it.
    #[test]
    #[allow(clippy::single_range_in_vec_init)]
    fn rounds_past_two_to_the_32nd_are_as_good_as_the_first() {
        let scene = scene_from_json(CUBE, None, Path::new(".")).expect("a scene");
        let world = World::new(&scene);
        let context = context(&scene, &world, 3);
        let plan = LocalPlan::of(&context, 0, Kernel::Bounded, 0.0);
        let done = |ranges: &[std::ops::Range<u64>]| {
            let mut map = ReplicaMap::new(5, Unit::Scores);
            let rays: u64 = ranges
                .iter()
                .map(|range| plan.rounds(&context, 0, &mut map, range.clone()).expect("time enough"))
                .sum();
            let means = map.indirect.iter().map(|slab| slab.iter().sum::<f64>() / 5.0);
            (means.collect::<Vec<f64>>(), rays)
        };
        let per_round = plan.chains_per_round;
        let past = (1u64 << 32) / per_round;
        let (in_one, rays) = done(&[past - 8..past + 8]);
        let (one_by_one, rays_again) =
            done(&(past - 8..past + 8).map(|round| round..round + 1).collect::<Vec<std::ops::Range<u64>>>());
        assert_eq!(rays, rays_again);
        assert!(in_one.iter().zip(&one_by_one).all(|(one, other)| (one / other - 1.0).abs() < 1e-12));
        let (before, _) = done(&[past - 8..past]);
        let (after, _) = done(&[past..past + 8]);
        assert!(before.iter().zip(&after).all(|(one, other)| one != other), "the same rounds twice");

        const ROUNDS: u64 = 512;
        let judged = |first: u64| {
            let (means, _) = done(&[first..first + ROUNDS]);
            let means: Vec<f64> = means.iter().map(|mean| mean / ROUNDS as f64).collect();
            let mean = means.iter().sum::<f64>() / REPLICAS as f64;
            (mean, crate::maps::standard_error(|replica| means[replica]))
        };
        let (first, first_error) = judged(0);
        for start in [past - ROUNDS / 2, 1 << 33, 1 << 40] {
            let (mean, error) = judged(start);
            let error = error.hypot(first_error);
            assert!((mean - first).abs() < 4.5 * error, "from {start}: {mean} {first} ± {error}");
            assert!((1.02 * mean - first).abs() > 4.5 * error, "from {start}: the fault passed, ± {error}");
        }
    }
}
