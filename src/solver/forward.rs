//! The forward stage of gathering: chains leave the light of their bounces in patches, where gathering rays look it up.
//!
//! A patch holds the mean of its indirect illuminance and, where chains meet it often enough, the slopes: the projection
//! of the deposits on linear functions, every coefficient of which is unbiased. Each replica has its own memory; the
//! rays of a half's eight replicas all look up the eight memories of that half, so that the halves stay independent.

use std::ops::Range;

use glam::DVec3;
use rayon::prelude::*;

use super::job::{Context, Ends};
use crate::estimators::direct::Receiver;
use crate::estimators::walk::{Memory, Recall, gather_indirect_lx};
use crate::geometry::{Meeting, Origin, SurfaceHit};
use crate::maps::{HALF, HalfChecks, HalfScores, REPLICAS};
use crate::sampling::emitter_tree::Cut;
use crate::sampling::random::{Purpose, Stream};
use crate::sampling::warp::{cosine_hemisphere, uniform_triangle};
use crate::scene::Side;
use crate::scene::patches::{PatchPlace, Patches};

/// Number of the forward stage among the maps, for its streams.
const FORWARD: u32 = u32::MAX;
/// Expected deposits of a replica on a patch from which on slopes are worth their noise.
const DEPOSITS_FOR_SLOPES: f64 = 4.0;
/// Rays of the patches' own gathering over those of the chains.
const REFINING_SHARE: f64 = 1.0;
/// Rays of one sample of that, about.
const RAYS_PER_SAMPLE: f64 = 2.0;
/// Points of a patch that tell how much of it shows, and rays from each that must all meet backs where it does not.
const EXPOSURE_POINTS: u64 = 16;
const HIDING_RAYS: u32 = 3;
/// A ray that meets a surface nearer than this share of the edge of patches goes on instead of looking the patch up: in corners a
/// patch says little of what lies next to it.
const NEAR: f64 = 0.07;
/// Below so many samples a patch the deposits stay as they are.
const FEWEST_SAMPLES: u64 = 4;

/// Light that chains brought, patch by patch, in sixteen replicas.
pub struct Forward {
    fine: Layer,
    /// Patches with twice the edges: what they would have said tells the bias of the finer ones.
    coarse: Layer,
    /// Nearer than this, in m, patches are not looked up.
    near_m: f64,
    /// Chains of each replica so far.
    pub chains: u64,
    /// Rays so far, all replicas: those of the chains and those of the patches' own gathering.
    pub rays: u64,
    /// Rays of stages before this one, which it replaced.
    pub earlier_rays: u64,
    chain_rays: u64,
    /// Chains that the patches' light was last worked out from.
    settled_chains: u64,
    /// How the packets ended.
    pub ends: [Ends; REPLICAS],
}

/// Patches of one size and what was left in them.
struct Layer {
    patches: Patches,
    /// Share of each patch that is not hidden inside of a solid that stands on it: all that rays can meet.
    exposed: Vec<f64>,
    /// Deposits of each replica on each patch: their number and the sums of their offsets.
    sums: Vec<Vec<[f64; 3]>>,
    /// Illuminance in lx at the middle of each patch, and its slopes, replica by replica.
    values_lx: Vec<Vec<[f64; 3]>>,
    /// The same as the even and the odd half look it up.
    tables: [Vec<Remembered>; 2],
}

/// Mean of what the eight memories of a half say.
#[inline]
fn mean_of(memories_lx: &[f64; HALF]) -> f64 {
    memories_lx.iter().sum::<f64>() / HALF as f64
}

/// What the eight replicas of a half remember of a patch: illuminance in lx at its middle, and its slopes along the two
/// offsets.
type Remembered = [[f64; HALF]; 3];

impl Layer {
    fn new(context: &Context, patches: Patches) -> Layer {
        let exposed = (0..patches.len() as u32).into_par_iter().map(|patch| exposed_share(context, &patches, patch));
        let exposed = exposed.collect();
        let sums = vec![vec![[0.0; 3]; patches.len()]; REPLICAS];
        let table = vec![[[0.0; HALF]; 3]; patches.len()];
        Layer { patches, exposed, values_lx: sums.clone(), sums, tables: [table.clone(), table] }
    }

    /// Turns deposits into illuminances; slopes only where deposits are dense enough.
    fn value(&mut self, flux_per_chain_lm: f64) {
        let deposits: f64 = self.sums.iter().flatten().map(|sum| sum[0]).sum();
        let area_m2: f64 = (0..self.patches.len() as u32).map(|patch| self.patches.area_m2(patch)).sum();
        let density_m2 = deposits / REPLICAS as f64 / area_m2;
        let (patches, exposed) = (&self.patches, &self.exposed);
        self.values_lx.par_iter_mut().with_max_len(1).zip(&self.sums).for_each(|(values_lx, sums)| {
            for (patch, (value_lx, sum)) in values_lx.iter_mut().zip(sums).enumerate() {
                // A patch of which nothing is known to show still takes what reaches it.
                let area_m2 = patches.area_m2(patch as u32) * exposed[patch].max(1.0 / EXPOSURE_POINTS as f64);
                let slopes = exposed[patch] == 1.0 && density_m2 * area_m2 >= DEPOSITS_FOR_SLOPES;
                *value_lx = projected(*sum, flux_per_chain_lm / area_m2, slopes);
            }
        });
    }

    fn tabulate(&mut self) {
        let values_lx = &self.values_lx;
        for (parity, table) in self.tables.iter_mut().enumerate() {
            table.par_iter_mut().enumerate().for_each(|(patch, remembered)| {
                for (coefficient, memories) in remembered.iter_mut().enumerate() {
                    *memories = std::array::from_fn(|memory| values_lx[2 * memory + parity][patch][coefficient]);
                }
            });
        }
    }

    /// What a single replica remembers of a place, in lx.
    #[inline]
    fn recall_of(&self, replica: usize, hit: &SurfaceHit) -> Option<f64> {
        let PatchPlace { patch, offset } = self.patches.place(hit.triangle, hit.barycentric, hit.side)?;
        let [middle, along_a, along_b] = self.values_lx[replica][patch as usize];
        Some(middle + along_a * offset[0] + along_b * offset[1])
    }

    #[inline]
    fn recall(&self, parity: usize, hit: &SurfaceHit) -> Option<[f64; HALF]> {
        let PatchPlace { patch, offset } = self.patches.place(hit.triangle, hit.barycentric, hit.side)?;
        let [middle, along_a, along_b] = &self.tables[parity][patch as usize];
        Some(std::array::from_fn(|memory| middle[memory] + along_a[memory] * offset[0] + along_b[memory] * offset[1]))
    }
}

/// Mean and slopes of a linear function from the sums of samples and of samples times offsets: the inverse of the
/// offsets' covariances, 1/18 each and −1/36 between them.
fn projected([sum, a, b]: [f64; 3], unit: f64, slopes: bool) -> [f64; 3] {
    let slope_unit = if slopes { unit } else { 0.0 };
    [sum * unit, (24.0 * a + 12.0 * b) * slope_unit, (12.0 * a + 24.0 * b) * slope_unit]
}

impl Forward {
    /// A stage without chains on patches with edges of about `edge_m`.
    pub fn new(context: &Context, edge_m: f64) -> Forward {
        let layer = |edge_m: f64| Layer::new(context, Patches::of(context.scene, edge_m));
        Forward {
            fine: layer(edge_m),
            coarse: layer(2.0 * edge_m),
            near_m: NEAR * edge_m,
            chains: 0,
            rays: 0,
            earlier_rays: 0,
            chain_rays: 0,
            settled_chains: 0,
            ends: [Ends::default(); REPLICAS],
        }
    }

    /// All rays so far, those of stages that it replaced too.
    pub fn all_rays(&self) -> u64 {
        self.rays + self.earlier_rays
    }

    /// Number of patches.
    pub fn patch_count(&self) -> usize {
        self.fine.patches.len()
    }

    /// Patches over which the deposits are spread: (Σ n)²/Σ n², n those of a patch.
    pub fn lit_patches(&self) -> f64 {
        let deposits = |patch: usize| self.fine.sums.iter().map(|sums| sums[patch][0]).sum::<f64>();
        let counts = (0..self.patch_count()).map(deposits);
        let (sum, squares) = counts.fold((0.0, 0.0), |(sum, squares), count| (sum + count, squares + count * count));
        sum * sum / squares.max(f64::MIN_POSITIVE)
    }

    /// Chains of a replica, of so many rays each, from which on the patches gather themselves.
    pub fn chains_to_refine(&self, rays_per_chain: f64) -> f64 {
        let rays = FEWEST_SAMPLES as f64 * RAYS_PER_SAMPLE * self.fine.patches.len() as f64;
        (rays / (REFINING_SHARE * rays_per_chain)).ceil()
    }

    /// Rays of one chain, on average.
    pub fn rays_per_chain(&self) -> f64 {
        self.chain_rays as f64 / (self.chains.max(1) as f64 * REPLICAS as f64)
    }

    /// Deposits of one chain, on average.
    pub fn deposits_per_chain(&self) -> f64 {
        let deposits: f64 = self.fine.sums.iter().flatten().map(|sum| sum[0]).sum();
        deposits / (self.chains.max(1) as f64 * REPLICAS as f64)
    }

    /// Variance in lx² of what a half remembers of a place, by the chance of its deposits.
    fn variance(&self, parity: usize, hit: &SurfaceHit) -> f64 {
        let place = self.fine.patches.place(hit.triangle, hit.barycentric, hit.side);
        place.map_or(0.0, |place| {
            let patch = place.patch as usize;
            let count: f64 = (0..HALF).map(|memory| self.fine.sums[2 * memory + parity][patch][0]).sum();
            let mean_lx = mean_of(&self.fine.tables[parity][patch][0]);
            if count > 0.0 { mean_lx * mean_lx / count } else { 0.0 }
        })
    }

    /// Turns the deposits into what gathering rays look up: smooths them by a gathering of the patches themselves, where
    /// that is worth its rays.
    ///
    /// Deposits scatter from patch to patch; what a patch gathers is the mean over all that it sees. Each replica gathers
    /// with its own rays from its own deposits, so that replicas stay independent. All together take at most `most_rays`.
    pub fn settle(&mut self, context: &Context, most_rays: f64) {
        if self.settled_chains == self.chains {
            return;
        }
        self.settled_chains = self.chains;
        let flux_per_chain_lm = context.stage.emitters.luminous_flux_lm() / self.chains as f64;
        self.fine.value(flux_per_chain_lm);
        self.coarse.value(flux_per_chain_lm);
        let rays_per_sample = RAYS_PER_SAMPLE * self.fine.patches.len() as f64;
        let wanted_rays = REFINING_SHARE * self.rays_per_chain() * self.chains as f64;
        let samples = (wanted_rays.min(most_rays / REPLICAS as f64) / rays_per_sample) as u64;
        if samples >= FEWEST_SAMPLES {
            self.refine(context, samples);
        }
        self.fine.tabulate();
        self.coarse.tabulate();
    }

    fn refine(&mut self, context: &Context, samples: u64) {
        let refined = (0..REPLICAS).into_par_iter().with_max_len(1).map(|replica| {
            let mut stream = Stream::new(context.seed, Purpose::Gathering, FORWARD, replica as u32);
            let mut memory = Deposits { layer: &self.fine, replica };
            let mut cut = Cut::default();
            let mut rays = 0;
            let mut sums = [&self.fine, &self.coarse].map(|layer| vec![PatchMean::default(); layer.patches.len()]);
            for patch in 0..self.fine.patches.len() as u32 {
                let exposed = self.fine.exposed[patch as usize];
                for number in 0..samples {
                    stream.seek_quasi((u64::from(patch) << 32) | number, u64::from(patch), number);
                    let (point, origin, normal) = point_of_patch(context, &self.fine.patches, patch, &mut stream);
                    if exposed < 1.0 && is_hidden(context, &origin, normal, &mut stream) {
                        continue;
                    }
                    let point_m = context.stage.tracer.position_m(&origin);
                    let receiver = Receiver { point_m, normal, origin: &origin };
                    let (lx, sample_rays) =
                        gather_indirect_lx(context.stage, &receiver, &mut memory, &mut cut, &mut stream);
                    rays += sample_rays;
                    for (layer, sums) in [&self.fine, &self.coarse].into_iter().zip(&mut sums) {
                        if let Some(place) = layer.patches.place(point.0, point.1, point.2) {
                            sums[place.patch as usize].add(lx, place.offset);
                        }
                    }
                }
            }
            let [fine, coarse] = &sums;
            let values = |layer: &Layer, sums: &[PatchMean]| -> Vec<[f64; 3]> {
                sums.iter().zip(&layer.exposed).map(|(sum, exposed)| sum.value(*exposed == 1.0)).collect()
            };
            (values(&self.fine, fine), values(&self.coarse, coarse), rays)
        });
        let refined: Vec<_> = refined.collect();
        for (replica, (fine, coarse, rays)) in refined.into_iter().enumerate() {
            self.fine.values_lx[replica] = fine;
            self.coarse.values_lx[replica] = coarse;
            self.rays += rays;
        }
    }

    /// Traces chains up to a number in each replica.
    pub fn trace_to(&mut self, context: &Context, until: u64) {
        self.trace(context, Purpose::Chains, until);
    }

    /// The same with chains of a pilot, which no run traces again: fewer, where they would take more than enough rays.
    pub fn trace_pilot(&mut self, context: &Context, most_chains: u64, enough_rays: u64) {
        let mut until = 1;
        loop {
            self.trace(context, Purpose::Pilot, until);
            if until == most_chains || 2 * self.chain_rays > enough_rays {
                return;
            }
            until = (2 * until).min(most_chains);
        }
    }

    fn trace(&mut self, context: &Context, purpose: Purpose, until: u64) {
        let chains = self.chains..until;
        let patches = [&self.fine.patches, &self.coarse.patches];
        let sums = self.fine.sums.par_iter_mut().with_max_len(1).zip(self.coarse.sums.par_iter_mut()).enumerate();
        let traced = sums.map(|(replica, (fine, coarse))| {
            let stream = Stream::new(context.seed, purpose, FORWARD, replica as u32);
            trace_chains(context, patches, stream, chains.clone(), [fine, coarse])
        });
        for (replica, (rays, ends)) in traced.collect::<Vec<_>>().into_iter().enumerate() {
            self.rays += rays;
            self.chain_rays += rays;
            self.ends[replica] += ends;
        }
        self.chains = until;
    }
}

fn trace_chains(
    context: &Context,
    patches: [&Patches; 2],
    mut stream: Stream,
    chains: Range<u64>,
    mut sums: [&mut [[f64; 3]]; 2],
) -> (u64, Ends) {
    let mut rays = 0;
    let mut ends = Ends::default();
    for chain in chains {
        stream.seek_quasi(chain, 0, chain);
        let choice = stream.fine_unit();
        let (end, chain_rays) = context.stage.trace_chain(choice, &mut stream, |arrival| {
            if arrival.bounces == 0 {
                return;
            }
            let hit = &arrival.hit;
            for (patches, sums) in patches.iter().zip(&mut sums) {
                if let Some(place) = patches.place(hit.triangle, hit.barycentric, hit.side) {
                    let [count, a, b] = &mut sums[place.patch as usize];
                    *count += 1.0;
                    *a += place.offset[0];
                    *b += place.offset[1];
                }
            }
        });
        ends.count(end);
        rays += chain_rays;
    }
    (rays, ends)
}

/// Samples of a patch: their number, their sum and that of samples times offsets.
#[derive(Clone, Copy, Debug, Default)]
struct PatchMean {
    count: u64,
    sums: [f64; 3],
}

impl PatchMean {
    fn add(&mut self, lx: f64, offset: [f64; 2]) {
        self.count += 1;
        self.sums[0] += lx;
        self.sums[1] += lx * offset[0];
        self.sums[2] += lx * offset[1];
    }

    fn value(&self, slopes: bool) -> [f64; 3] {
        projected(self.sums, 1.0 / self.count.max(1) as f64, slopes)
    }
}

/// A random point of a patch: triangle, barycentric coordinates and side; where rays leave it, and its normal.
fn point_of_patch(
    context: &Context,
    patches: &Patches,
    patch: u32,
    stream: &mut Stream,
) -> ((u32, [f64; 2], Side), Origin, DVec3) {
    let choice = stream.fine_unit();
    let point = patches.point(patch, uniform_triangle(stream.pair()), choice);
    let (triangle, barycentric, side) = point;
    let origin = context.stage.tracer.surface_origin(triangle, barycentric, side);
    (point, origin, context.stage.normal(triangle, side))
}

/// Whether a point lies inside of a solid that stands on its surface: all it sees is the backs of one-sided surfaces.
/// Its illuminance is 0, nobody sees it, and what is seen of its patch must not suffer from it.
fn is_hidden(context: &Context, origin: &Origin, normal: DVec3, stream: &mut Stream) -> bool {
    let stage = context.stage;
    (0..HIDING_RAYS).all(|_| {
        let direction = cosine_hemisphere(normal, stream.pair());
        matches!(stage.tracer.first_hit(origin, direction), Meeting::Surface(hit) if !stage.receives(hit.triangle, hit.side))
    })
}

fn exposed_share(context: &Context, patches: &Patches, patch: u32) -> f64 {
    let mut stream = Stream::new(context.seed, Purpose::Pilot, FORWARD, REPLICAS as u32);
    let exposed = (0..EXPOSURE_POINTS).filter(|number| {
        stream.seek_quasi((u64::from(patch) << 32) | number, u64::from(patch), *number);
        let (_, origin, normal) = point_of_patch(context, patches, patch, &mut stream);
        !is_hidden(context, &origin, normal, &mut stream)
    });
    exposed.count() as f64 / EXPOSURE_POINTS as f64
}

/// What one replica's chains left, for its own patches to gather.
struct Deposits<'a> {
    layer: &'a Layer,
    replica: usize,
}

impl Memory for Deposits<'_> {
    #[inline]
    fn recall(&mut self, hit: &SurfaceHit, _: &Receiver, _: f64, _: &mut Cut, _: &mut Stream) -> (Recall, u64) {
        (self.layer.recall_of(self.replica, hit).map_or(Recall::Nothing, Recall::End), 0)
    }
}

/// The memory of a half, which now and then checks what it says by a walk.
pub struct Recollection<'a> {
    forward: &'a Forward,
    context: &'a Context<'a>,
    parity: usize,
    /// Share of the look-ups that are checked.
    checked_share: f64,
    /// Replica of the half whose rays ask.
    pub row: usize,
    /// Weight of the present sample.
    pub weight: f64,
    /// What the present entry's rays found; the rows are for the asker to fill.
    pub scores: HalfScores,
    /// What the checks found: (what walks brought − what was remembered) times what of it was reflected, each divided by the share.
    pub checks: HalfChecks,
    /// Sum of the variances of what was remembered, weighted as it was, in lx²; only a pilot asks for it.
    pub noise: f64,
    /// Whether the noise is summed up.
    pub is_pilot: bool,
    /// Number of checks, and their rays.
    pub check_count: [u64; 2],
}

impl<'a> Recollection<'a> {
    /// The memory of the even (0) or the odd half (1).
    pub fn new(context: &'a Context<'a>, forward: &'a Forward, parity: usize, checked_share: f64) -> Recollection<'a> {
        Recollection {
            forward,
            context,
            parity,
            checked_share,
            row: 0,
            weight: 1.0,
            scores: HalfScores::default(),
            checks: HalfChecks::default(),
            noise: 0.0,
            is_pilot: false,
            check_count: [0; 2],
        }
    }
}

impl Memory for Recollection<'_> {
    #[inline]
    fn recall(
        &mut self,
        hit: &SurfaceHit,
        vertex: &Receiver,
        reflectance: f64,
        cut: &mut Cut,
        stream: &mut Stream,
    ) -> (Recall, u64) {
        let forward = self.forward;
        let Some(known_lx) = forward.fine.recall(self.parity, hit) else {
            return (Recall::Nothing, 0);
        };
        let mean_lx = mean_of(&known_lx);
        if hit.distance_m < forward.near_m {
            return (Recall::Guide(mean_lx), 0);
        }
        let weight = self.weight * reflectance;
        self.scores.columns_lx.iter_mut().zip(&known_lx).for_each(|(sum, lx)| *sum += weight * lx);
        if let Some(coarse_lx) = forward.coarse.recall(self.parity, hit) {
            self.scores.coarser_lx += weight * (mean_of(&coarse_lx) - mean_lx);
        }
        if self.is_pilot {
            self.noise += weight * weight * forward.variance(self.parity, hit);
        }
        let mut rays = 0;
        if stream.happens(self.checked_share) {
            let mut guide = Guide { forward, parity: self.parity };
            let (walked_lx, walk_rays) = gather_indirect_lx(self.context.stage, vertex, &mut guide, cut, stream);
            let weight = weight / self.checked_share;
            self.checks.rows_lx[self.row] += weight * (walked_lx - mean_lx);
            let columns_lx = self.checks.columns_lx.iter_mut().zip(&known_lx);
            columns_lx.for_each(|(sum, lx)| *sum += weight * (walked_lx - lx));
            self.check_count[0] += 1;
            self.check_count[1] += walk_rays;
            rays = walk_rays;
        }
        (Recall::End(mean_lx), rays)
    }
}

/// A half's memory as the guide of a walk, which it cannot bias.
struct Guide<'a> {
    forward: &'a Forward,
    parity: usize,
}

impl Memory for Guide<'_> {
    #[inline]
    fn recall(&mut self, hit: &SurfaceHit, _: &Receiver, _: f64, _: &mut Cut, _: &mut Stream) -> (Recall, u64) {
        let known_lx = self.forward.fine.recall(self.parity, hit);
        (known_lx.map_or(Recall::Nothing, |lx| Recall::Guide(mean_of(&lx))), 0)
    }
}
