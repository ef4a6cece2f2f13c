//! The forward stage of gathering: chains leave the light of their bounces in patches, where gathering rays look it up.
//!
//! A patch holds the mean of its indirect illuminance and, where chains meet it often enough, the slopes: the projection
//! of the deposits on linear functions, every coefficient of which is unbiased. Each replica has its own memory; the
//! rays of a half's eight replicas all look up the eight memories of that half, so that the halves stay independent.
//! Where it is worth its rays, patches hold direct light too, found by looks from points spread over them.

mod direct;
mod layer;
mod memory;

use std::ops::Range;

use glam::DVec3;
use rayon::prelude::*;

use self::layer::{EXPOSURE_POINTS, Layer, LinearLx, PatchMean};
use self::memory::Deposits;
pub use self::memory::Recollection;
use super::job::{Context, Ends};
use super::survey::Sharing;
use crate::estimators::cover::is_covered;
use crate::estimators::direct::Receiver;
use crate::estimators::walk::gather_indirect_lx;
use crate::geometry::{Origin, SurfaceHit};
use crate::maps::{HALF, REPLICAS};
use crate::sampling::emitter_tree::Cut;
use crate::sampling::random::{Purpose, Stream};
use crate::sampling::warp::uniform_triangle;
use crate::scene::Side;
use crate::scene::patches::{PatchPlace, Patches, Spot};

/// Number of the forward stage among the maps, for its streams.
const FORWARD: u32 = u32::MAX;
/// Rays of the patches' own gathering over those of the chains.
const REFINING_SHARE: f64 = 1.0;
/// Rays of one sample of that, about.
const RAYS_PER_SAMPLE: f64 = 2.0;
/// A ray that meets a surface nearer than this share of the edge of patches goes on instead of looking the patch up: in corners a
/// patch says little of what lies next to it. Patches that gather look for luminaires there.
const NEAR: f64 = 0.25;
/// Samples of a replica from which on a patch tells slopes by them.
pub const FEWEST_SAMPLES: u64 = 4;
/// Rays of one that is shared: a look beside it.
const RAYS_PER_SHARED: f64 = 3.0;
/// Share of what shows of a coarse patch for which samples of fine ones must stand, for it to be known by them: all about, since its
/// slopes, and its mean, are those of even samples. One of joined triangles tells of where it is asked.
const ENOUGH_OF_COARSE: [f64; 2] = [0.95, 0.75];
/// Samples of a patch between two looks whether time is over.
const SAMPLES_AT_ONCE: u64 = 1024;
/// Points of a patch that are tried until one is not covered.
const TRIES: usize = 16;

/// Light that chains brought, patch by patch, in sixteen replicas.
pub struct Forward {
    fine: Layer<HALF>,
    /// Patches with twice the edges: what they would have said tells the bias of the finer ones.
    coarse: Layer<1>,
    /// Nearer than this, in m, gathering rays look no patch up, and patches that gather no direct light.
    near_m: f64,
    /// Rays of the samples that patches took last.
    patch_rays: u64,
    /// Samples that patches take for all rays, and the error that decides which of them tell direct light, where any shall.
    sharing: Option<(Sharing, Option<f64>)>,
    /// Distance in m from which on each of them does; empty before they know it.
    tells_direct_from_m: Vec<f64>,
    /// Whether each of the coarse ones knows the direct light of enough of them.
    coarse_knows_direct: Vec<bool>,
    /// Chains of each replica so far.
    pub chains: u64,
    /// Rays so far, all replicas: those of the chains, of looks for the patches' direct light and of their own gathering.
    pub rays: u64,
    /// Rays of stages before this one, which it replaced.
    pub earlier_rays: u64,
    chain_rays: u64,
    /// Chains that the patches' light was last worked out from.
    settled_chains: u64,
    /// How the packets ended.
    pub ends: [Ends; REPLICAS],
}

impl Forward {
    /// A stage without chains on patches with edges of about `edge_m`.
    pub fn new(context: &Context, edge_m: f64) -> Forward {
        let (fine, coarse) =
            rayon::join(|| Patches::of(context.scene, edge_m), || Patches::of(context.scene, 2.0 * edge_m));
        let [fine_exposed, coarse_exposed] = exposed_shares(context, &fine, &coarse);
        Forward {
            fine: Layer::new(fine, fine_exposed, [0.0; 2]),
            coarse: Layer::new(coarse, coarse_exposed, ENOUGH_OF_COARSE),
            near_m: NEAR * edge_m,
            patch_rays: 0,
            sharing: None,
            tells_direct_from_m: Vec::new(),
            coarse_knows_direct: Vec::new(),
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

    /// Number of those that are made of joined triangles.
    pub fn joined_count(&self) -> usize {
        (0..self.patch_count() as u32).filter(|patch| self.fine.patches.is_joined(*patch)).count()
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

    /// The patch that a ray asks which met a surface there, and whether it is made of joined triangles.
    pub fn asked(&self, hit: &SurfaceHit) -> Option<(u32, bool)> {
        let place = self.fine.place(hit)?;
        (hit.distance_m >= self.near_m).then_some((place.patch, self.fine.patches.is_joined(place.patch)))
    }

    /// Makes patches of joined triangles tell of where rays asked them; before chains are traced.
    pub fn tell_of<'a>(&mut self, context: &Context, places: impl Iterator<Item = &'a Spot> + Clone) {
        self.fine.patches.tell_of(places.clone().copied());
        self.coarse.patches.tell_of(places.copied());
        [self.fine.exposed, self.coarse.exposed] = exposed_shares(context, &self.fine.patches, &self.coarse.patches);
    }

    /// Lets patches take samples for all rays, from when chains are settled on: of indirect light, and of direct light too
    /// where they shall tell it as exactly as a relative error asks for.
    pub fn share(&mut self, sharing: Option<(Sharing, Option<f64>)>) {
        self.sharing = sharing;
    }

    /// Rays, about, of the samples that patches take for all rays.
    pub fn rays_to_share(&self) -> Option<f64> {
        self.sharing.as_ref().map(|(sharing, _)| RAYS_PER_SHARED * sharing.sum())
    }

    /// Share of the rays' asking for direct light that patches shall answer.
    pub fn told_share(&self) -> f64 {
        self.sharing.as_ref().map_or(0.0, |(sharing, tells_for)| tells_for.map_or(0.0, |_| sharing.told_share))
    }

    /// Variance in lx² of what a half remembers of a place, by the chance of its deposits.
    fn variance(&self, parity: usize, place: &PatchPlace) -> f64 {
        let patch = place.patch as usize;
        let replicas = (0..HALF).map(|memory| 2 * memory + parity);
        let count: f64 = replicas.clone().map(|replica| self.fine.sums[replica][patch][0]).sum();
        let mean_lx = replicas.map(|replica| self.fine.indirect_lx[replica][patch][0]).sum::<f64>() / HALF as f64;
        if count > 0.0 { mean_lx * mean_lx / count } else { 0.0 }
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
        let earlier_rays = self.rays;
        let flux_per_chain_lm = context.stage.emitters.luminous_flux_lm() / self.chains as f64;
        self.fine.value(flux_per_chain_lm);
        self.coarse.value(flux_per_chain_lm);
        let rays_per_sample = RAYS_PER_SAMPLE * self.fine.patches.len() as f64;
        let wanted_rays = REFINING_SHARE * self.rays_per_chain() * self.chains as f64;
        self.tells_direct_from_m.clear();
        // So few rays as a run in haste gives them are worth it; else whoever has no time left has to do with deposits.
        let is_over = || most_rays.is_infinite() && context.is_over();
        if let Some((sharing, tells_for)) = self.sharing.take() {
            let samples_of = |patch| if is_over() { 0 } else { sharing.of_patch(patch) };
            // Where there is too little left for it, rays look themselves, and deposits have to do.
            if RAYS_PER_SHARED * sharing.sum() <= most_rays {
                if let Some(error) = tells_for {
                    self.look_at_direct(context, samples_of, error);
                }
                self.refine(context, samples_of);
            }
            self.sharing = Some((sharing, tells_for));
        } else {
            let samples = (wanted_rays.min(most_rays / REPLICAS as f64) / rays_per_sample) as u64;
            if samples >= FEWEST_SAMPLES {
                self.refine(context, |_| if is_over() { 0 } else { samples });
            }
        }
        self.patch_rays = self.rays - earlier_rays;
        self.fine.tabulate();
        self.coarse.tabulate();
    }

    /// Rays of the chains so far, all replicas.
    pub fn chain_rays(&self) -> u64 {
        self.chain_rays
    }

    /// Rays of the samples that patches took when chains were settled on last, all replicas.
    pub fn patch_rays(&self) -> u64 {
        self.patch_rays
    }

    /// Indirect light by gathering from points of every patch.
    fn refine(&mut self, context: &Context, samples_of: impl Fn(u32) -> u64 + Sync) {
        let gather = |replica: usize, _: (u32, Side), receiver: &Receiver, cut: &mut Cut, stream: &mut Stream| {
            let mut memory = Deposits { forward: self, replica };
            gather_indirect_lx(context.stage, receiver, &mut memory, cut, stream)
        };
        let found = self.sampled(context, Purpose::Gathering, samples_of, gather);
        // Where too little was gathered, deposits stay.
        let of_fine = |(found, deposits_lx): (&Sampled, &Vec<LinearLx>)| {
            self.fine.means_lx(&found.means[0], FEWEST_SAMPLES, deposits_lx)
        };
        let of_coarse = |(found, deposits_lx): (&Sampled, &Vec<LinearLx>)| {
            self.coarse.means_lx(&found.means[1], FEWEST_SAMPLES, deposits_lx)
        };
        let mut fine_lx: Vec<Vec<LinearLx>> = found.iter().zip(&self.fine.indirect_lx).map(of_fine).collect();
        let mut coarse_lx: Vec<Vec<LinearLx>> = found.iter().zip(&self.coarse.indirect_lx).map(of_coarse).collect();
        let flux_per_deposit_lm = context.stage.emitters.luminous_flux_lm() / self.chains as f64;
        let ratios = self.fine.flux_ratios(&fine_lx, flux_per_deposit_lm);
        self.fine.keep_flux(&mut fine_lx, &ratios);
        self.coarse.keep_flux(&mut coarse_lx, &ratios);
        (self.fine.indirect_lx, self.coarse.indirect_lx) = (fine_lx, coarse_lx);
        self.rays += found.iter().map(|found| found.rays).sum::<u64>();
    }

    /// Projections of what every replica finds at points of every patch, so many of each; `sample` tells it in lx, with the
    /// rays it took.
    fn sampled(
        &self,
        context: &Context,
        purpose: Purpose,
        count_of: impl Fn(u32) -> u64 + Sync,
        sample: impl Fn(usize, (u32, Side), &Receiver, &mut Cut, &mut Stream) -> (f64, u64) + Sync,
    ) -> Vec<Sampled> {
        let patches = [&self.fine.patches, &self.coarse.patches];
        let of_replica = |replica: usize| {
            let mut stream = Stream::new(context.seed, purpose, FORWARD, replica as u32);
            let mut cut = Cut::default();
            let mut rays = 0;
            let mut means = patches.map(|patches| vec![PatchMean::default(); patches.len()]);
            for patch in 0..patches[0].len() as u32 {
                let count = count_of(patch);
                let exposed = self.fine.exposed[patch as usize];
                let weight = exposed * patches[0].area_m2(patch) / count as f64;
                for number in 0..count {
                    // None is wanted any more where the end came.
                    if number > 0 && number % SAMPLES_AT_ONCE == 0 && count_of(patch) == 0 {
                        break;
                    }
                    stream.seek_quasi((u64::from(patch) << 32) | number, u64::from(patch), number);
                    let (point, cover_rays) = self.exposed_point(context, patch, &mut stream);
                    rays += cover_rays;
                    let Some((point, origin, normal)) = point else {
                        continue;
                    };
                    let point_m = context.stage.tracer.position_m(&origin);
                    let receiver = Receiver { point_m, normal, origin: &origin };
                    let (lx, sample_rays) = sample(replica, (point.0, point.2), &receiver, &mut cut, &mut stream);
                    rays += sample_rays;
                    for (patches, means) in patches.iter().zip(&mut means) {
                        if let Some(place) = patches.place(point.0, point.1, point.2) {
                            means[place.patch as usize].add(weight, lx, place.offset);
                        }
                    }
                }
            }
            Sampled { means, rays }
        };
        (0..REPLICAS).into_par_iter().with_max_len(1).map(of_replica).collect()
    }

    /// A random point of a patch that is not covered, and the rays that it took to find one; `None` where that fails.
    fn exposed_point(&self, context: &Context, patch: u32, stream: &mut Stream) -> (Option<PatchPoint>, u64) {
        let mut rays = 0;
        for _ in 0..TRIES {
            let point = point_of_patch(context, &self.fine.patches, patch, stream);
            if self.fine.exposed[patch as usize] == 1.0 {
                return (Some(point), rays);
            }
            let (is_covered, cover_rays) = is_covered(context.stage, &point.1, point.2, stream);
            rays += cover_rays;
            if !is_covered {
                return (Some(point), rays);
            }
        }
        (None, rays)
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
                    *count += patches.weight(hit.triangle, hit.side);
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

/// What a replica found in the patches of both sizes, and the rays it took.
struct Sampled {
    means: [Vec<PatchMean>; 2],
    rays: u64,
}

/// A point of a patch, where rays leave it, and its normal.
type PatchPoint = (Spot, Origin, DVec3);

/// A random point of a patch.
fn point_of_patch(context: &Context, patches: &Patches, patch: u32, stream: &mut Stream) -> PatchPoint {
    let choice = stream.fine_unit();
    let point = patches.point(patch, uniform_triangle(stream.pair()), choice);
    let (triangle, barycentric, side) = point;
    let origin = context.stage.tracer.surface_origin(triangle, barycentric, side);
    (point, origin, context.stage.normal(triangle, side))
}

/// Share of every patch that is not covered, and of every coarser one: nobody sees what is, and what is seen of the patch must
/// not suffer from it.
fn exposed_shares(context: &Context, fine: &Patches, coarse: &Patches) -> [Vec<f64>; 2] {
    let point_number = |patch: u32, number: u64, stream: &mut Stream| {
        stream.seek_quasi((u64::from(patch) << 32) | number, u64::from(patch), number);
        point_of_patch(context, fine, patch, stream)
    };
    let new_stream = || Stream::new(context.seed, Purpose::Pilot, FORWARD, REPLICAS as u32);
    let covered_points = |stream: &mut Stream, patch: u32| -> Vec<u64> {
        if context.is_over() {
            return Vec::new();
        }
        let is_covered = |number: &u64| {
            let (_, origin, normal) = point_number(patch, *number, stream);
            is_covered(context.stage, &origin, normal, stream).0
        };
        (0..EXPOSURE_POINTS).filter(is_covered).collect()
    };
    let covered: Vec<Vec<u64>> = (0..fine.len() as u32)
        .into_par_iter()
        .map_init(new_stream, |stream, patch| covered_points(stream, patch))
        .collect();
    let mut coarse_covered_m2 = vec![0.0; coarse.len()];
    let mut stream = new_stream();
    for (patch, numbers) in covered.iter().enumerate() {
        for number in numbers {
            let ((triangle, barycentric, side), ..) = point_number(patch as u32, *number, &mut stream);
            if let Some(place) = coarse.place(triangle, barycentric, side) {
                coarse_covered_m2[place.patch as usize] += fine.area_m2(patch as u32) / EXPOSURE_POINTS as f64;
            }
        }
    }
    let shown = |(patch, covered_m2): (usize, &f64)| (1.0 - covered_m2 / coarse.area_m2(patch as u32)).max(0.0);
    [
        covered.iter().map(|numbers| 1.0 - numbers.len() as f64 / EXPOSURE_POINTS as f64).collect(),
        coarse_covered_m2.iter().enumerate().map(shown).collect(),
    ]
}
