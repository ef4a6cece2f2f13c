//! The pilot of local estimation: how many walks stand beside the chains, which bound follows from that, and how many
//! connections are made.
//!
//! Walks get about twice the rays of chains, which is never far from the best. With B chains to
//! W walks from every receiver a place of illuminance E is met by chains B E/Φ times per area, by walks W K/π times: the
//! bound c = π B E/(Φ W) leaves each what it meets more often (Veach and Guibas 1995).

use std::f64::consts::PI;

use super::{Kernel, LocalPlan, trace};
use crate::estimators::local::{Anchors, ChainVertex, Connecting};
use crate::sampling::emitter_tree::Cut;
use crate::sampling::random::{Purpose, Stream};
use crate::solver::job::Context;

/// Chains of the pilot, fewer where they meet very many receivers.
const CHAINS: u64 = 256;
const FEWEST_CHAINS: u64 = 32;
/// Scores that the pilot works out at a time, about.
const SCORES: u64 = 1 << 18;
/// Entries from which the pilot walks, and walks from each.
const SITES: usize = 64;
const WALKS: u64 = 8;
/// Thresholds that are tried, each a quarter of the one before.
const THRESHOLDS: u32 = 8;
const STEP: f64 = 4.0;
/// Chains from quasi-random points may vary by so much less than the pilot's, and what thinning adds must not drown that.
const QUASI_GAIN: f64 = 16.0;
/// Working out a score takes this many rays' time.
const RAYS_PER_SCORE: f64 = 0.02;
/// Bounds are set higher than the balance says: chains of many vertices and from quasi-random points vary less than single
/// hits, walks that go on vary more. Measured on Sobolev's planes and on edges: 4 does better than 1 and than 16.
const IN_FAVOUR_OF_CHAINS: f64 = 4.0;
/// Rays of the walks over those of the chains.
const WALKS_PER_CHAIN: f64 = 2.0;
/// Chains or walks that a round holds at most for each of the other.
const MOST_PER_ROUND: f64 = 64.0;

/// Weighted variance and rays of one sample of a part, summed over the set.
#[derive(Clone, Copy, Debug, Default)]
struct Part {
    variance: f64,
    rays: f64,
}

struct Pilot<'a> {
    context: &'a Context<'a>,
    set: usize,
    anchors: &'a Anchors,
    /// Vertices, chain by chain.
    chains: Vec<Vec<ChainVertex>>,
    path_rays: f64,
}

pub(super) fn plan(context: &Context, set: usize, kernel: Kernel, mut anchors: Anchors) -> LocalPlan {
    let (whole, mean) = walks(context, set, &anchors, 0.0);
    anchors.set_levels(context.stage, mean / anchors.mean_scale().max(f64::MIN_POSITIVE));
    let pilot = Pilot::new(context, set, &anchors);
    if kernel == Kernel::Naive {
        let chains = pilot.chains(&Connecting { bound: f64::INFINITY, threshold: 0.0 });
        return LocalPlan {
            connecting: Connecting { bound: f64::INFINITY, threshold: 0.0 },
            chains_per_round: 1,
            walks_per_round: 0,
            rays_per_round: chains.rays,
            variance_per_round: chains.variance,
            mean_lx: mean,
            quasi: false,
            anchors,
        };
    }
    // The bound follows from the ratio, the thinning from the bound, and the ratio from the rays that thinning leaves.
    let chain_rays = pilot.chains(&Connecting { bound: 1.0, threshold: 0.0 }).rays;
    let [_, bound] = ratio_and_bound(context, whole.rays, chain_rays);
    let (_, thinned) = pilot.thin(bound);
    let [ratio, bound] = ratio_and_bound(context, whole.rays, thinned.rays);
    let (connecting, chains) = pilot.thin(bound);
    let (chains_per_round, walks_per_round) =
        if ratio >= 1.0 { (ratio.round() as u64, 1) } else { (1, (1.0 / ratio).round() as u64) };
    let (b, w) = (chains_per_round as f64, walks_per_round as f64);
    let walks = walks(context, set, &anchors, bound).0;
    LocalPlan {
        connecting,
        chains_per_round,
        walks_per_round,
        rays_per_round: b * chains.rays + w * walks.rays,
        variance_per_round: chains.variance / b + walks.variance / w,
        mean_lx: mean,
        quasi: true,
        anchors,
    }
}

/// Chains a walk, by the rays of one each, and the bound that balances them.
fn ratio_and_bound(context: &Context, walk_rays: f64, chain_rays: f64) -> [f64; 2] {
    let ratio = walk_rays / (WALKS_PER_CHAIN * chain_rays);
    let ratio = ratio.clamp(1.0 / MOST_PER_ROUND, MOST_PER_ROUND);
    let ratio = if ratio >= 1.0 { ratio.round() } else { 1.0 / (1.0 / ratio).round() };
    [ratio, IN_FAVOUR_OF_CHAINS * PI * ratio / context.stage.emitters.luminous_flux_lm()]
}

impl Pilot<'_> {
    fn new<'a>(context: &'a Context<'a>, set: usize, anchors: &'a Anchors) -> Pilot<'a> {
        let count = (SCORES / anchors.len().max(1) as u64).clamp(FEWEST_CHAINS, CHAINS);
        let mut stream = Stream::new(context.seed, Purpose::Pilot, set as u32 + 1, 3);
        let mut path_rays = 0;
        let chains: Vec<Vec<ChainVertex>> = (0..count)
            .map(|chain| {
                stream.seek(chain);
                let choice = (chain as f64 + stream.fine_unit()) / count as f64;
                let mut vertices = Vec::new();
                path_rays += trace(anchors, context.stage, choice, &mut stream, &mut vertices);
                vertices
            })
            .collect();
        Pilot { context, set, anchors, chains, path_rays: path_rays as f64 / count as f64 }
    }

    /// The thinning that makes variance times rays least, under a bound.
    fn thin(&self, bound: f64) -> (Connecting, Part) {
        let mut best = Connecting { bound, threshold: 0.0 };
        let unthinned = self.chains(&best);
        let mut chains = unthinned;
        let cost = |part: &Part| {
            let variance = part.variance - (1.0 - 1.0 / QUASI_GAIN) * unthinned.variance;
            variance * part.rays
        };
        let largest = self.largest_score(bound);
        for step in 0..THRESHOLDS {
            let tried = Connecting { bound, threshold: largest * STEP.powi(-(step as i32)) };
            let part = self.chains(&tried);
            if cost(&part) < cost(&chains) {
                (best, chains) = (tried, part);
            }
        }
        (best, chains)
    }

    fn largest_score(&self, bound: f64) -> f64 {
        let mut scores = Vec::new();
        let mut largest = 0.0f64;
        for vertex in self.chains.iter().flatten() {
            self.anchors.scores(self.context.stage, vertex, bound, &mut scores);
            let levels = (0..scores.len()).map(|anchor| self.anchors.own_level_lx(anchor));
            largest = scores.iter().zip(levels).fold(largest, |most, (score, level)| most.max(score / level));
        }
        largest
    }

    /// One chain, as if nothing stood between.
    fn chains(&self, connecting: &Connecting) -> Part {
        let points = &self.context.scene.receivers[self.set].points;
        let mut scores = Vec::new();
        let mut of_chain = vec![0.0; points.len()];
        let (mut sums, mut squares) = (vec![0.0; points.len()], 0.0);
        let (mut thinning, mut rays) = (0.0, 0.0);
        for vertices in &self.chains {
            of_chain.fill(0.0);
            for vertex in vertices {
                self.anchors.scores(self.context.stage, vertex, connecting.bound, &mut scores);
                rays += RAYS_PER_SCORE * scores.len() as f64;
                for (anchor, score) in scores.iter().enumerate().filter(|(_, score)| **score > 0.0) {
                    let entry = self.anchors.entry(anchor);
                    of_chain[entry] += score;
                    let threshold = connecting.threshold * self.anchors.own_level_lx(anchor);
                    if *score < threshold {
                        thinning += points[entry].weight * score * (threshold - score);
                        rays += score / threshold;
                    } else {
                        rays += 1.0;
                    }
                }
            }
            for (entry, sum) in of_chain.iter().enumerate().filter(|(_, sum)| **sum > 0.0) {
                sums[entry] += sum;
                squares += points[entry].weight * sum * sum;
            }
        }
        let count = self.chains.len() as f64;
        let mean_squares: f64 = sums.iter().zip(points).map(|(sum, point)| point.weight * (sum / count).powi(2)).sum();
        let flux_lm = self.context.stage.emitters.luminous_flux_lm();
        let variance = ((squares + thinning) / count - mean_squares).max(0.0) * flux_lm * flux_lm;
        Part { variance, rays: self.path_rays + rays / count }
    }
}

/// One walk from every entry, judged by some of them, and the mean value of a walk.
fn walks(context: &Context, set: usize, anchors: &Anchors, bound: f64) -> (Part, f64) {
    let receivers = &context.scene.receivers[set];
    let mut stream = Stream::new(context.seed, Purpose::Pilot, set as u32 + 1, 4);
    let mut cut = Cut::default();
    let stride = receivers.points.len().div_ceil(SITES).max(1);
    let (mut part, mut total, mut sites) = (Part::default(), 0.0, 0.0);
    for (entry, point) in receivers.points.iter().enumerate().step_by(stride).filter(|(_, point)| !point.inside) {
        let (mut sum, mut squares) = (0.0, 0.0);
        for walk in 0..WALKS {
            stream.seek(entry as u64 * WALKS + walk);
            let (value, rays) = anchors.sample_rest(context.stage, receivers, entry, bound, &mut cut, &mut stream);
            sum += value;
            squares += value * value;
            part.rays += rays as f64;
        }
        let count = WALKS as f64;
        part.variance += point.weight * ((squares - sum * sum / count) / (count - 1.0)).max(0.0);
        total += sum;
        sites += 1.0;
    }
    if sites == 0.0 {
        return (Part::default(), 0.0);
    }
    let scale = receivers.points.len() as f64 / sites;
    let walks = WALKS as f64;
    (Part { variance: part.variance * scale, rays: part.rays / walks * scale }, total / (walks * sites))
}
