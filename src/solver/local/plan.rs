//! The pilot of local estimation: which bound, how many walks, how many connections.
//!
//! With variances v and costs c a sample, chains and walks are best shared out so that the product of variance and cost
//! is (√(v₁c₁) + √(v₂c₂))². The bound that makes it least wins: a high one leaves the chains a wild kernel, a low one
//! leaves the walks most of the light.

use super::near::nearest_m;
use super::{Kernel, LocalPlan, has_other_paths, trace};
use crate::estimators::local::{Anchors, ChainVertex, Connecting};
use crate::sampling::emitter_tree::Cut;
use crate::sampling::random::{Purpose, Stream};
use crate::solver::job::Context;

/// Chains of the pilot, fewer where they meet very many receivers.
const CHAINS: u64 = 256;
const FEWEST_CHAINS: u64 = 32;
/// Scores that the pilot works out for every bound, about.
const SCORES: u64 = 1 << 18;
/// Entries from which the pilot walks, and walks from each.
const SITES: usize = 64;
const WALKS: u64 = 4;
/// Bounds that are tried, each four times the one before, from the kernel that half of the light comes below.
const BOUNDS: u32 = 7;
const STEP: f64 = 4.0;
/// Thresholds that are tried, each a quarter of the one before.
const THRESHOLDS: u32 = 8;
/// Working out a score takes this many rays' time.
const RAYS_PER_SCORE: f64 = 0.02;
/// Chains or walks that a round holds at most for each of the other.
const MOST_PER_ROUND: f64 = 64.0;
/// Kernels that are sorted to find the middle one.
const SORTED: usize = 1 << 14;

/// Variance and rays of one sample of a part.
#[derive(Clone, Copy, Debug, Default)]
struct Part {
    variance: f64,
    rays: f64,
}

impl Part {
    fn product(self) -> f64 {
        (self.variance * self.rays).sqrt()
    }
}

struct Pilot<'a> {
    context: &'a Context<'a>,
    set: usize,
    anchors: &'a Anchors,
    /// Vertices, chain by chain.
    chains: Vec<Vec<ChainVertex>>,
    path_rays: f64,
}

pub(super) fn plan(context: &Context, set: usize, kernel: Kernel, anchors: Anchors) -> LocalPlan {
    let stage = context.stage;
    let receivers = &context.scene.receivers[set];
    let pilot = Pilot::new(context, set, &anchors);
    let other_paths = has_other_paths(stage, context.scene.triangles.len(), &anchors) && kernel == Kernel::Bounded;
    let nearest_m = match kernel {
        Kernel::Bounded => nearest_m(context.scene, stage, receivers.quantity, &anchors),
        Kernel::Naive => vec![f64::INFINITY; anchors.len()],
    };
    let walkers = |bound_per_m2: f64| -> Vec<u32> {
        let mut entries: Vec<u32> = (0..anchors.len())
            .filter(|anchor| other_paths || nearest_m[*anchor].powi(2) * bound_per_m2 < 1.0)
            .map(|anchor| anchors.entry(anchor) as u32)
            .collect();
        entries.dedup();
        entries
    };
    let mut bounds = vec![f64::INFINITY];
    if kernel == Kernel::Bounded {
        let middle = pilot.middle_kernel_per_m2();
        bounds = (0..BOUNDS).map(|step| middle * STEP.powi(step as i32)).filter(|bound| *bound > 0.0).collect();
        // Where nothing is near, the kernel bounds itself.
        let nearest = nearest_m.iter().fold(f64::INFINITY, |least: f64, distance| least.min(*distance));
        bounds.push(if nearest > 0.0 { nearest.powi(-2) } else { f64::MAX.sqrt() });
    }
    let mut best: Option<(f64, f64, Part, Vec<u32>)> = None;
    for bound in bounds {
        let chains = pilot.chains(bound, 0.0);
        let walkers = walkers(bound);
        let walks = pilot.walks(bound, &walkers);
        let product = chains.product() + walks.product();
        if best.as_ref().is_none_or(|(least, ..)| product < *least) {
            best = Some((product, bound, walks, walkers));
        }
    }
    let (_, bound_per_m2, walks, walkers) = best.unwrap_or((0.0, f64::INFINITY, Part::default(), Vec::new()));

    let mut threshold = 0.0;
    let mut chains = pilot.chains(bound_per_m2, threshold);
    if kernel == Kernel::Bounded {
        let largest = pilot.largest_score(bound_per_m2);
        for step in 0..THRESHOLDS {
            let tried = largest * STEP.powi(-(step as i32));
            let part = pilot.chains(bound_per_m2, tried);
            if part.product() < chains.product() {
                (threshold, chains) = (tried, part);
            }
        }
    }
    // B chains a walk: √(v₁c₂ / v₂c₁).
    let ratio = (chains.variance * walks.rays / (walks.variance * chains.rays)).sqrt();
    let ratio = if ratio.is_nan() { 1.0 } else { ratio.clamp(1.0 / MOST_PER_ROUND, MOST_PER_ROUND) };
    let (chains_per_round, walks_per_round) = match ratio {
        _ if walkers.is_empty() => (1, 1),
        ratio if ratio >= 1.0 => (ratio.round() as u64, 1),
        ratio => (1, (1.0 / ratio).round() as u64),
    };
    let (b, w) = (chains_per_round as f64, walks_per_round as f64);
    LocalPlan {
        connecting: Connecting { bound_per_m2, threshold },
        chains_per_round,
        walks_per_round,
        rays_per_round: b * chains.rays + w * walks.rays,
        variance_per_round: chains.variance / b + walks.variance / w,
        walkers,
        quasi: kernel == Kernel::Bounded,
        anchors,
    }
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
                path_rays += trace(context.stage, choice, &mut stream, &mut vertices);
                vertices
            })
            .collect();
        Pilot { context, set, anchors, chains, path_rays: path_rays as f64 / count as f64 }
    }

    fn weight(&self, entry: usize) -> f64 {
        self.context.scene.receivers[self.set].points[entry].weight
    }

    /// The kernel (with the vertex' own share) below which half of the light comes, in 1/m².
    fn middle_kernel_per_m2(&self) -> f64 {
        let mut scores = Vec::new();
        let mut kernels: Vec<f64> = Vec::new();
        let all = self.chains.iter().map(Vec::len).sum::<usize>() * self.anchors.len();
        let stride = all.div_ceil(SORTED).max(1);
        for vertex in self.chains.iter().flatten() {
            self.anchors.scores(self.context.stage, vertex, f64::INFINITY, &mut scores);
            // A score under a bound of 1/m² is what a kernel of 1/m² is worth: their ratio is the kernel.
            let mut units = Vec::new();
            self.anchors.scores(self.context.stage, vertex, f64::MIN_POSITIVE, &mut units);
            let offset = kernels.len() % stride;
            let pairs = scores.iter().zip(&units).skip(offset).step_by(stride);
            kernels.extend(pairs.filter(|(_, unit)| **unit > 0.0).map(|(score, unit)| {
                score / (unit / f64::MIN_POSITIVE)
            }));
        }
        kernels.sort_by(f64::total_cmp);
        let half = 0.5 * kernels.iter().sum::<f64>();
        let mut sum = 0.0;
        kernels
            .iter()
            .find(|kernel| {
                sum += **kernel;
                sum >= half
            })
            .copied()
            .unwrap_or(0.0)
    }

    fn largest_score(&self, bound_per_m2: f64) -> f64 {
        let mut scores = Vec::new();
        let mut largest = 0.0f64;
        for vertex in self.chains.iter().flatten() {
            self.anchors.scores(self.context.stage, vertex, bound_per_m2, &mut scores);
            largest = scores.iter().fold(largest, |most, score| most.max(*score));
        }
        largest
    }

    /// Weighted variance and rays of one chain, as if nothing stood between.
    fn chains(&self, bound_per_m2: f64, threshold: f64) -> Part {
        let entries = self.context.scene.receivers[self.set].points.len();
        let mut scores = Vec::new();
        let mut of_chain = vec![0.0; entries];
        let (mut sums, mut squares) = (vec![0.0; entries], 0.0);
        let (mut thinning, mut rays) = (0.0, 0.0);
        for vertices in &self.chains {
            of_chain.fill(0.0);
            for vertex in vertices {
                self.anchors.scores(self.context.stage, vertex, bound_per_m2, &mut scores);
                rays += RAYS_PER_SCORE * scores.len() as f64;
                for (anchor, score) in scores.iter().enumerate().filter(|(_, score)| **score > 0.0) {
                    let entry = self.anchors.entry(anchor);
                    of_chain[entry] += score;
                    if *score < threshold {
                        thinning += self.weight(entry) * score * (threshold - score);
                        rays += score / threshold;
                    } else {
                        rays += 1.0;
                    }
                }
            }
            for (entry, sum) in of_chain.iter().enumerate().filter(|(_, sum)| **sum > 0.0) {
                sums[entry] += sum;
                squares += self.weight(entry) * sum * sum;
            }
        }
        let count = self.chains.len() as f64;
        let mean_squares: f64 =
            sums.iter().enumerate().map(|(entry, sum)| self.weight(entry) * (sum / count).powi(2)).sum();
        let flux_lm = self.context.stage.emitters.luminous_flux_lm();
        let variance = ((squares + thinning) / count - mean_squares).max(0.0) * flux_lm * flux_lm;
        Part { variance, rays: self.path_rays + rays / count }
    }

    /// Weighted variance and rays of one walk from every walker.
    fn walks(&self, bound_per_m2: f64, walkers: &[u32]) -> Part {
        let receivers = &self.context.scene.receivers[self.set];
        let mut stream = Stream::new(self.context.seed, Purpose::Pilot, self.set as u32 + 1, 4);
        let mut cut = Cut::default();
        let stride = walkers.len().div_ceil(SITES).max(1);
        let (mut variance, mut rays, mut sites) = (0.0, 0.0, 0.0);
        for entry in walkers.iter().step_by(stride).map(|entry| *entry as usize) {
            let (mut sum, mut squares) = (0.0, 0.0);
            for walk in 0..WALKS {
                stream.seek(entry as u64 * WALKS + walk);
                let (value, walk_rays) = self.anchors.sample_rest(
                    self.context.stage,
                    receivers,
                    entry,
                    bound_per_m2,
                    &mut cut,
                    &mut stream,
                );
                sum += value;
                squares += value * value;
                rays += walk_rays as f64;
            }
            let count = WALKS as f64;
            variance += self.weight(entry) * ((squares - sum * sum / count) / (count - 1.0)).max(0.0);
            sites += 1.0;
        }
        if sites == 0.0 {
            return Part::default();
        }
        let scale = walkers.len() as f64 / sites;
        Part { variance: variance * scale, rays: rays / WALKS as f64 * scale }
    }
}
