//! The pilot of local estimation: the number of walks per chain, the bound that follows from it, and the number of connections.
//! Walks get about half the rays of chains, which is never far from the best. Let a round have B chains and W walks from every receiver. A
//! point of illuminance E is met by chains B E/Φ times per area, and by walks W K/π times. The bound c = π B E/(Φ W) gives each of the two
//! what it meets more often (Veach and Guibas 1995).

use std::f64::consts::PI;

use rayon::prelude::*;

use super::{Kernel, LocalPlan, trace};
use crate::base::scattered::scattered;
use crate::control::margin;
use crate::estimators::local::{Anchors, ChainVertex, Connecting};
use crate::maps::MapKind;
use crate::sampling::emitter_tree::Cut;
use crate::sampling::random::{Purpose, Stream};
use crate::solver::context::Context;
use crate::solver::pilot::{ENOUGH_RAYS, FEWEST_SITES};
use crate::transport::Traced;

/// Fewest and most chains of the pilot, and work by the cheapest other method per chain that it traces.
const FEWEST_CHAINS: usize = 256;
const MOST_CHAINS: usize = 2048;
const WORK_A_CHAIN: f64 = 2e4;
/// Fewest and most entries at which the pilot's chains score, and the most pairs of vertices and entries that it stores: in nearly white
/// rooms chains have thousands of vertices.
const FEWEST_ENTRIES: usize = 4;
const MOST_ENTRIES: usize = 256;
const MOST_PAIRS: usize = 2_000_000;
/// Lower limit for the allowed number of pairs, and pairs per ray of work at stake. A pair is evaluated at some thirty bounds and
/// thresholds, in half the time of a ray.
const FEWEST_PAIRS: usize = 250_000;
const PAIRS_AT_STAKE: f64 = 0.1;
/// Approximate number of vertices that it stores, some 150 bytes each: in nearly white rooms single chains have hundreds of thousands.
const MOST_VERTICES: usize = 400_000;
/// For a pilot that traces its connections: most entries, and the share of the work at stake that its connections may take.
const MOST_TRACED_ENTRIES: usize = 32;
const SHARE_OF_TRACING: f64 = 0.02;
/// Entries from which the pilot walks, and walks from each.
const SITES: usize = 64;
const WALKS: u64 = 8;
/// Number of thresholds that are tried, each half of the one before, and halvings of the largest score to the first one.
const THRESHOLDS: usize = 10;
const FIRST_THRESHOLD: usize = 3;
/// Batches of the pilot's chains, each with its own quasi-random points, and the replica number of the first one's stream.
const BATCHES: usize = 8;
const FIRST_BATCH: u32 = 16;
/// Ratio of the variance of independent chains to that of a run's quasi-random ones: the ratio that the pilot's batches show, to this
/// power, times this factor. The larger it is with few points, the faster it grows with their number. Measured in 18 maps of eleven made-up
/// rooms: work within a factor of 1.3 in two of three maps, where a gain of 4 for all is off by 1.6.
const QUASI_POWER: f64 = 1.6;
const QUASI_FACTOR: f64 = 1.6;
/// Chains from quasi-random points may vary less than the pilot's by this factor. The variance that thinning adds must stay small compared
/// with that.
const QUASI_GAIN: f64 = 4.0;
/// Ratio of the degrees of freedom of a run to those of the pilot's chains: quasi-random points remove the error that all points share
/// most.
const QUASI_DEGREES: f64 = 2.0;
/// Computing a score takes the time of this many rays.
const RAYS_PER_SCORE: f64 = 0.004;
/// Factor by which bounds are above their balance. Chains of many vertices and from quasi-random points vary less than single hits, and
/// walks that continue vary more. Measured on Sobolev's planes and on edges: 4 does better than 1 and than 16.
const IN_FAVOUR_OF_CHAINS: f64 = 4.0;
/// Rays of the walks relative to those of the chains.
const WALKS_PER_CHAIN: f64 = 0.5;
/// Most chains of a round per walk, and most walks of a round per chain.
const MOST_PER_ROUND: f64 = 64.0;

/// Weighted variance and rays of one sample of a part, summed over the set.
#[derive(Clone, Copy, Debug, Default)]
struct PartVariance {
    variance: f64,
    rays: f64,
}

/// Size of a pilot.
struct Extent {
    chains: usize,
    entries: usize,
    pairs: usize,
    /// Whether it traces its connections. Otherwise all count as unobstructed.
    traced: bool,
}

impl Extent {
    /// The size that the work at stake allows.
    fn of(at_stake: f64, traced: bool) -> Extent {
        if traced {
            let pairs = (SHARE_OF_TRACING * at_stake) as usize;
            return Extent { chains: MOST_PAIRS, entries: MOST_TRACED_ENTRIES, pairs: pairs.min(MOST_PAIRS), traced };
        }
        let chains = ((at_stake / WORK_A_CHAIN) as usize).clamp(FEWEST_CHAINS, MOST_CHAINS);
        let pairs = ((PAIRS_AT_STAKE * at_stake) as usize).clamp(FEWEST_PAIRS, MOST_PAIRS);
        Extent { chains, entries: MOST_ENTRIES, pairs, traced }
    }
}

pub(super) fn plan(
    context: &Context,
    set: usize,
    kernel: Kernel,
    mut anchors: Anchors,
    at_stake: f64,
    traced: bool,
) -> LocalPlan {
    let mut pilot_rays = 0;
    let mut walks = |anchors: &Anchors, bound: f64| {
        let (part, mean) = walks(context, set, anchors, bound);
        pilot_rays += mean.rays;
        (part, mean.value)
    };
    let (whole, mean) = walks(&anchors, 0.0);
    let mean_level_lx = mean / anchors.mean_scale().max(f64::MIN_POSITIVE);
    anchors.set_levels(context.world, mean_level_lx);
    let mut pilot = Pilot::new(context, set, &anchors, &Extent::of(at_stake, traced));
    if kernel == Kernel::Naive {
        let connecting = Connecting { bound: f64::INFINITY, threshold: 0.0 };
        let scores = pilot.scores(f64::INFINITY);
        let chains = pilot.unthinned(&scores);
        return LocalPlan {
            connecting,
            chains_per_round: 1,
            walks_per_round: 0,
            rays_per_round: chains.rays,
            variance_per_round: chains.variance,
            quasi_gain: 1.0,
            mean,
            quasi: false,
            margin: margin(QUASI_DEGREES * pilot.degrees(&scores)),
            pilot_chains: pilot.chains.len(),
            found: 1.0,
            pilot_rays: pilot_rays + pilot.all_rays(),
            anchors,
        };
    }
    anchors.set_walk_rates();
    pilot.set_bounds(&anchors);
    // The bound follows from the ratio, the thinning from the bound, and the ratio from the rays that remain after thinning.
    let [_, bound] = ratio_and_bound(context, whole.rays, pilot.unthinned(&pilot.scores(1.0)).rays);
    let (_, thinned) = pilot.thin(bound);
    let (whole, _) = walks(&anchors, 0.0);
    let [ratio, bound] = ratio_and_bound(context, whole.rays, thinned.rays);
    let (threshold, chains) = pilot.thin(bound);
    let connecting = Connecting { bound, threshold };
    let (b, w) = (ratio.max(1.0), (1.0 / ratio).max(1.0));
    let (walks, rest) = walks(&anchors, bound);
    let scores = pilot.scores(bound);
    let found = scores.mean * pilot.flux_lm / (mean - rest).max(f64::MIN_POSITIVE);
    LocalPlan {
        connecting,
        chains_per_round: b as u64,
        walks_per_round: w as u64,
        rays_per_round: b * chains.rays + w * walks.rays,
        variance_per_round: chains.variance / b + walks.variance / w,
        quasi_gain: pilot.quasi_gain(&scores),
        mean,
        quasi: true,
        margin: margin(QUASI_DEGREES * pilot.degrees(&scores)),
        pilot_chains: pilot.chains.len(),
        found,
        pilot_rays: pilot_rays + pilot.all_rays(),
        anchors,
    }
}

/// Chains per walk, from the rays of one each, and the bound that balances them. The ratio is a power of 2, to fit quasi-random points.
fn ratio_and_bound(context: &Context, walk_rays: f64, chain_rays: f64) -> [f64; 2] {
    let ratio = walk_rays / (WALKS_PER_CHAIN * chain_rays);
    let ratio = ratio.clamp(1.0 / MOST_PER_ROUND, MOST_PER_ROUND).log2().round().exp2();
    [ratio, IN_FAVOUR_OF_CHAINS * PI * ratio / context.world.emitters.luminous_flux_lm()]
}

/// Chains that enter no result, with the connections between their vertices and the anchors of some entries.
struct Pilot {
    chains: Vec<Vec<ChainVertex>>,
    path_rays: f64,
    flux_lm: f64,
    anchors: Vec<PilotAnchor>,
    /// Weights of the sampled entries.
    weights: Vec<f64>,
    /// Ratio of the entries of the set to the sampled entries.
    share_inverse: f64,
    /// For each vertex and anchor: the kernel in 1/m², and the share that the vertex scatters towards the anchor, in 1/sr.
    pairs: Vec<[f64; 2]>,
    /// In the same order, the transmittance between them; empty if all connections count as unobstructed.
    seen: Vec<f64>,
    /// Rays of connections.
    connecting_rays: u64,
}

struct PilotAnchor {
    number: usize,
    /// Index of its entry among the sampled entries.
    entry: usize,
    scale: f64,
    own_level: f64,
    bound_factor: f64,
}

/// Scores of the pilot's chains under a bound.
struct PilotScores {
    /// For 1 lm, for each vertex and anchor.
    each: Vec<f64>,
    /// Weighted variance of a chain that is not thinned.
    variance: f64,
    /// Weighted mean.
    mean: f64,
}

/// Sums over scores within the same number of halvings of the largest one.
#[derive(Clone, Copy, Debug, Default)]
struct HalvedScores {
    count: f64,
    /// Scores relative to their anchors' own levels.
    relative: f64,
    /// Weighted squares of the visible scores.
    squared: f64,
    /// Weighted products of the visible scores and the levels of their anchors.
    times_level: f64,
}

impl PilotAnchor {
    /// The anchors of some entries of the set.
    fn of_entries(anchors: &Anchors, entries: &[usize]) -> Vec<PilotAnchor> {
        let anchor = |entry: usize, number: usize| PilotAnchor {
            number,
            entry,
            scale: anchors.scale(number),
            own_level: anchors.own_level(number),
            bound_factor: 1.0,
        };
        let of_entry = |(index, entry): (usize, &usize)| {
            anchors.of_entry(*entry).map(|number| anchor(index, number)).collect::<Vec<_>>()
        };
        entries.iter().enumerate().flat_map(of_entry).collect()
    }
}

/// Traces the pilot's chains. Returns their vertices, and the rays traced.
fn trace_chains(context: &Context, set: usize, anchors: &Anchors, extent: &Extent) -> (Vec<Vec<ChainVertex>>, u64) {
    let number = MapKind::Receivers(set).number();
    let stream = |batch: usize| Stream::new(context.seed, Purpose::Pilot, number, FIRST_BATCH + batch as u32);
    let mut streams: [Stream; BATCHES] = std::array::from_fn(stream);
    let most = extent.chains;
    let enough_rays = ENOUGH_RAYS * (most / FEWEST_CHAINS) as u64;
    let points = context.scene.receivers[set].points.len();
    let enough_vertices = if extent.traced { extent.pairs / points.clamp(1, extent.entries) } else { usize::MAX };
    let is_done = |chains: usize, rays: u64, vertices: usize| {
        chains == most
            || chains >= FEWEST_SITES && (rays >= enough_rays || vertices >= enough_vertices)
            || chains >= 2 && (vertices >= MOST_VERTICES || context.is_over())
    };
    let (mut chains, mut rays, mut vertex_count) = (Vec::new(), 0, 0);
    while !is_done(chains.len(), rays, vertex_count) {
        let mut vertices = Vec::new();
        let (chain, batch) = (chains.len() / BATCHES, chains.len() % BATCHES);
        rays += trace(anchors, context.world, chain as u64, &mut streams[batch], &mut vertices);
        vertex_count += vertices.len();
        chains.push(vertices);
    }
    (chains, rays)
}

/// Transmittance between every vertex and every anchor, in the order of `pairs`; 0 where a connection brings nothing.
fn transmittances(
    context: &Context,
    anchors: &Anchors,
    sampled: &[PilotAnchor],
    vertices: &[&ChainVertex],
    pairs: &[[f64; 2]],
) -> Vec<f64> {
    let count = sampled.len().max(1);
    let mut seen = vec![0.0; vertices.len() * count];
    seen.par_chunks_mut(count).zip(pairs.par_chunks(count)).zip(vertices).for_each(|((seen, pairs), vertex)| {
        for ((seen, [kernel, spread]), anchor) in seen.iter_mut().zip(pairs).zip(sampled) {
            if kernel * spread > 0.0 {
                *seen = anchors.transmittance(context.world, anchor.number, vertex);
            }
        }
    });
    seen
}

impl Pilot {
    fn new(context: &Context, set: usize, anchors: &Anchors, extent: &Extent) -> Pilot {
        let world = context.world;
        let points = &context.scene.receivers[set].points;
        let (chains, path_rays) = trace_chains(context, set, anchors, extent);
        let vertices: Vec<&ChainVertex> = chains.iter().flatten().collect();
        let most_entries = (extent.pairs / vertices.len().max(1)).clamp(FEWEST_ENTRIES, extent.entries);
        let stride = points.len().div_ceil(most_entries).max(1);
        let entries: Vec<usize> = (0..points.len()).step_by(stride).collect();
        let sampled = PilotAnchor::of_entries(anchors, &entries);
        let kernels =
            |vertex| sampled.iter().map(move |anchor| anchors.kernel_and_spread(world, anchor.number, vertex));
        let pairs: Vec<[f64; 2]> = vertices.par_iter().flat_map_iter(|vertex| kernels(*vertex)).collect();
        let seen =
            if extent.traced { transmittances(context, anchors, &sampled, &vertices, &pairs) } else { Vec::new() };
        let connected = pairs.iter().take(seen.len()).filter(|[kernel, spread]| kernel * spread > 0.0);
        let connecting_rays = connected.count() as u64;
        Pilot {
            path_rays: path_rays as f64 / chains.len() as f64,
            chains,
            flux_lm: world.emitters.luminous_flux_lm(),
            anchors: sampled,
            weights: entries.iter().map(|entry| points[*entry].weight).collect(),
            share_inverse: points.len() as f64 / entries.len().max(1) as f64,
            pairs,
            seen,
            connecting_rays,
        }
    }

    /// Takes over bounds that have changed.
    fn set_bounds(&mut self, anchors: &Anchors) {
        self.anchors.iter_mut().for_each(|anchor| anchor.bound_factor = anchors.bound_factor(anchor.number));
    }

    /// Unobstructed contribution of every vertex to every anchor for 1 lm, without the anchors' scales.
    fn brought(&self, bound: f64) -> impl Iterator<Item = impl Iterator<Item = (&PilotAnchor, f64)>> {
        let count = self.anchors.len().max(1);
        self.chains.iter().flatten().zip(self.pairs.chunks(count)).map(move |(vertex, pairs)| {
            let bound_per_m2 = bound * vertex.level_lx;
            self.anchors.iter().zip(pairs).map(move |(anchor, [kernel, spread])| {
                (anchor, spread * kernel.min(bound_per_m2 * anchor.bound_factor))
            })
        })
    }

    fn scores(&self, bound: f64) -> PilotScores {
        let mut each = Vec::with_capacity(self.pairs.len());
        for of_vertex in self.brought(bound) {
            each.extend(of_vertex.map(|(anchor, brought)| anchor.scale * brought));
        }
        let (mut sums, mut squares) = (vec![0.0; self.weights.len()], 0.0);
        self.for_each_chain(&each, usize::MAX, |_, of_chain| {
            for ((sum, weight), of_chain) in sums.iter_mut().zip(&self.weights).zip(of_chain) {
                *sum += of_chain;
                squares += weight * of_chain * of_chain;
            }
        });
        let count = self.chains.len() as f64;
        let of_means: f64 = sums.iter().zip(&self.weights).map(|(sum, weight)| weight * (sum / count).powi(2)).sum();
        let sum: f64 = sums.iter().zip(&self.weights).map(|(sum, weight)| weight * sum / count).sum();
        let mean = sum / self.weights.iter().sum::<f64>().max(f64::MIN_POSITIVE);
        PilotScores { each, variance: (squares / count - of_means).max(0.0), mean }
    }

    /// Calls `visit` with the contribution of each of the first `most` chains to every sampled entry, summed over its vertices.
    fn for_each_chain(&self, each: &[f64], most: usize, mut visit: impl FnMut(usize, &[f64])) {
        let mut of_chain = vec![0.0; self.weights.len()];
        let mut places = 0..;
        for (chain, vertices) in self.chains.iter().take(most).enumerate() {
            of_chain.fill(0.0);
            for (anchor, place) in vertices.iter().flat_map(|_| &self.anchors).zip(&mut places) {
                of_chain[anchor.entry] += self.seen(place) * each[place];
            }
            visit(chain, &of_chain);
        }
    }

    /// Ratio of the variance of independent chains to that of a run's quasi-random ones, from the spread of the batches' means.
    fn quasi_gain(&self, scores: &PilotScores) -> f64 {
        let of_batch = self.chains.len() as f64 / BATCHES as f64;
        let mut means = vec![[0.0; BATCHES]; self.weights.len()];
        self.for_each_chain(&scores.each, usize::MAX, |chain, of_chain| {
            means.iter_mut().zip(of_chain).for_each(|(means, value)| means[chain % BATCHES] += value / of_batch);
        });
        let spread = |means: &[f64; BATCHES]| {
            let mean = means.iter().sum::<f64>() / BATCHES as f64;
            means.iter().map(|of_batch| (of_batch - mean).powi(2)).sum::<f64>() / (BATCHES - 1) as f64
        };
        let between: f64 = means.iter().zip(&self.weights).map(|(means, weight)| weight * spread(means)).sum();
        let shown = if between > 0.0 { scores.variance / of_batch / between } else { 1.0 };
        QUASI_FACTOR * shown.max(1.0).powf(QUASI_POWER)
    }

    /// Transmittance between a vertex and an anchor.
    fn seen(&self, place: usize) -> f64 {
        self.seen.get(place).copied().unwrap_or(1.0)
    }

    /// Rays of all its chains and connections.
    fn all_rays(&self) -> u64 {
        (self.path_rays * self.chains.len() as f64).round() as u64 + self.connecting_rays
    }

    /// Degrees of freedom of a map from the random error of its chains: (tr C)²/tr C² of its entries' weighted covariances. They are few,
    /// since all entries share the chains. They are computed from the products of what every two chains bring to all sampled entries.
    fn degrees(&self, scores: &PilotScores) -> f64 {
        let entries = self.weights.len();
        let roots: Vec<f64> = self.weights.iter().map(|weight| weight.sqrt()).collect();
        // Every two chains are compared, so the number of chains is limited to a few hundred.
        let mut of_chains = Vec::with_capacity(entries * self.chains.len().min(FEWEST_CHAINS));
        self.for_each_chain(&scores.each, FEWEST_CHAINS, |_, of_chain| {
            of_chains.extend(roots.iter().zip(of_chain).map(|(root, value)| root * value));
        });
        let mut of_chains: Vec<&mut [f64]> = of_chains.chunks_mut(entries.max(1)).collect();
        let count = of_chains.len() as f64;
        let mut means = vec![0.0; entries];
        for of_chain in &of_chains {
            means.iter_mut().zip(of_chain.iter()).for_each(|(mean, value)| *mean += value / count);
        }
        for of_chain in of_chains.iter_mut() {
            of_chain.iter_mut().zip(&means).for_each(|(value, mean)| *value -= mean);
        }
        let product = |one: &[f64], other: &[f64]| one.iter().zip(other).map(|(a, b)| a * b).sum::<f64>();
        let trace = of_chains.iter().map(|of_chain| product(of_chain, of_chain)).sum::<f64>() / count;
        let mut of_squares = 0.0;
        for (place, one) in of_chains.iter().enumerate() {
            of_squares += of_chains[..place].iter().map(|other| product(one, other).powi(2)).sum::<f64>();
        }
        let of_squares = of_squares / (0.5 * count * (count - 1.0));
        if of_squares > 0.0 { (trace * trace / of_squares).max(1.0) } else { 1.0 }
    }

    /// Variance and rays of one chain, all of whose scores count in full.
    fn unthinned(&self, scores: &PilotScores) -> PartVariance {
        let positive = scores.each.iter().filter(|score| **score > 0.0).count();
        self.with_thinning(scores, 0.0, positive as f64)
    }

    /// The same with the variance that thinning adds in all, and the rays of all connections.
    fn with_thinning(&self, scores: &PilotScores, thinning: f64, connecting_rays: f64) -> PartVariance {
        let count = self.chains.len() as f64;
        let rays = connecting_rays + RAYS_PER_SCORE * scores.each.len() as f64;
        PartVariance {
            variance: (scores.variance + thinning / count) * self.flux_lm * self.flux_lm * self.share_inverse,
            rays: self.path_rays + self.share_inverse * rays / count,
        }
    }

    /// The thinning with the least product of variance and rays, under a bound.
    fn thin(&self, bound: f64) -> (f64, PartVariance) {
        let scores = self.scores(bound);
        let unthinned = self.unthinned(&scores);
        let cost = |part: &PartVariance| (part.variance - (1.0 - 1.0 / QUASI_GAIN) * unthinned.variance) * part.rays;
        let (largest, halvings) = self.by_halvings(&scores);
        let mut best = (0.0, unthinned);
        for thinned_from in FIRST_THRESHOLD..FIRST_THRESHOLD + THRESHOLDS {
            let threshold = largest * 0.5f64.powi(thinned_from as i32);
            let (full, thinned) = halvings.split_at(thinned_from);
            let sum = |of: fn(&HalvedScores) -> f64| thinned.iter().map(of).sum::<f64>();
            let thinning = threshold * sum(|scores| scores.times_level) - sum(|scores| scores.squared);
            let chosen = sum(|scores| scores.relative) / threshold;
            let rays = chosen + full.iter().map(|scores| scores.count).sum::<f64>();
            let part = self.with_thinning(&scores, thinning.max(0.0), rays);
            if cost(&part) < cost(&best.1) {
                best = (threshold, part);
            }
        }
        best
    }

    /// The largest score relative to its anchor's own level, and sums over the scores that lie within the same number of halvings of it.
    fn by_halvings(&self, scores: &PilotScores) -> (f64, [HalvedScores; FIRST_THRESHOLD + THRESHOLDS]) {
        let inverses: Vec<f64> = self.anchors.iter().map(|anchor| anchor.own_level.recip()).collect();
        let of_vertices = || scores.each.chunks(self.anchors.len().max(1));
        let relative = of_vertices().flat_map(|each| each.iter().zip(&inverses)).filter(|(score, _)| **score > 0.0);
        let largest = relative.map(|(score, inverse)| score * inverse).fold(0.0, f64::max);
        let mut halvings = [HalvedScores::default(); FIRST_THRESHOLD + THRESHOLDS];
        for (number, each) in of_vertices().enumerate() {
            for (index, (score, anchor)) in
                each.iter().zip(&self.anchors).enumerate().filter(|(_, (score, _))| **score > 0.0)
            {
                let relative = score * inverses[index];
                let halved = whole_log2(largest / relative).min(halvings.len() - 1);
                let seen = self.seen(number * self.anchors.len() + index);
                let weight = seen * seen * self.weights[anchor.entry] * score;
                let sums = &mut halvings[halved];
                sums.count += 1.0;
                sums.relative += relative;
                sums.squared += weight * score;
                sums.times_level += weight * anchor.own_level;
            }
        }
        (largest, halvings)
    }
}

/// The whole part of the binary logarithm of a number of 1 or more: its exponent.
fn whole_log2(number: f64) -> usize {
    ((number.to_bits() >> (f64::MANTISSA_DIGITS - 1)) as usize).saturating_sub((f64::MAX_EXP - 1) as usize)
}

/// Returns one walk from every entry, estimated from some entries, and the mean value of a walk with the rays that the pilot took.
fn walks(context: &Context, set: usize, anchors: &Anchors, bound: f64) -> (PartVariance, Traced) {
    let receivers = &context.scene.receivers[set];
    let mut stream = Stream::new(context.seed, Purpose::Pilot, MapKind::Receivers(set).number(), 4);
    let mut cut = Cut::default();
    let stride = receivers.points.len().div_ceil(SITES).max(1);
    let (mut part, mut total, mut sites, mut traced) = (PartVariance::default(), 0.0, 0.0, 0);
    for site in scattered(receivers.points.len().div_ceil(stride)) {
        let (entry, point) = (site * stride, &receivers.points[site * stride]);
        if point.inside {
            continue;
        }
        if traced > ENOUGH_RAYS && sites >= FEWEST_SITES as f64 || sites >= 2.0 && context.is_over() {
            break;
        }
        let (mut sum, mut squares, mut rays_of_site, mut done) = (0.0, 0.0, 0, 0);
        let rate = anchors.walk_rate(entry);
        for walk in 0..WALKS {
            // A single walk in a nearly white room may take a good part of a second.
            if done >= 2 && context.is_over() {
                break;
            }
            done += 1;
            stream.seek(entry as u64 * WALKS + walk);
            let Traced { value, rays } =
                anchors.sample_rest(context.world, receivers, entry, bound, &mut cut, &mut stream);
            sum += value;
            squares += value * value;
            rays_of_site += rays;
        }
        traced += rays_of_site;
        let count = f64::from(done);
        part.rays += rate * rays_of_site as f64 / count;
        part.variance += point.weight / rate * ((squares - sum * sum / count) / (count - 1.0)).max(0.0);
        total += sum / count;
        sites += 1.0;
    }
    if sites == 0.0 {
        return (PartVariance::default(), Traced::default());
    }
    let scale = receivers.points.len() as f64 / sites;
    let all = PartVariance { variance: part.variance * scale, rays: part.rays * scale };
    (all, Traced { value: total / sites, rays: traced })
}
