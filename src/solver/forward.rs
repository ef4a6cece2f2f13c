//! The forward stage of gathering: chains leave the light of their bounces in patches, where gathering rays look it up.
//!
//! A patch holds the mean of its indirect illuminance and, where chains meet it often enough, the slopes: the projection
//! of the deposits on linear functions, every coefficient of which is unbiased. Each replica has its own memory; the
//! rays of a half's eight replicas all look up the eight memories of that half, so that the halves stay independent.
//! Where it is worth its rays, patches hold direct light too, found by looks from points spread over them.

mod layer;
mod memory;

use std::ops::Range;

use glam::DVec3;
use rayon::prelude::*;

use self::layer::{EXPOSURE_POINTS, Layer, LinearLx, projected};
use self::memory::Deposits;
pub use self::memory::Recollection;
use super::job::{Context, Ends};
use crate::estimators::cover::is_covered;
use crate::estimators::direct::{Care, Receiver, one_look};
use crate::estimators::walk::gather_indirect_lx;
use crate::geometry::Origin;
use crate::maps::{HALF, REPLICAS};
use crate::sampling::emitter_tree::Cut;
use crate::sampling::random::{Purpose, Stream};
use crate::sampling::reflection::Law;
use crate::sampling::warp::uniform_triangle;
use crate::scene::Side;
use crate::scene::patches::{PatchPlace, Patches};

/// Number of the forward stage among the maps, for its streams.
const FORWARD: u32 = u32::MAX;
/// Rays of the patches' own gathering over those of the chains.
const REFINING_SHARE: f64 = 1.0;
/// Rays of one sample of that, about.
const RAYS_PER_SAMPLE: f64 = 2.0;
/// A ray that meets a surface nearer than this share of the edge of patches goes on instead of looking the patch up: in corners a
/// patch says little of what lies next to it. Patches that gather look for luminaires there.
const NEAR: f64 = 0.25;
/// Below so many samples a patch the deposits stay as they are.
const FEWEST_SAMPLES: u64 = 4;
/// Looks of a replica from a patch for its direct light, at least, and those beyond that over the rays of the chains.
const FEWEST_LOOKS: u64 = 4;
const LOOKS_SHARE: f64 = 0.5;
/// A patch tells direct light if what coarser ones say of it is not surely off by more than so many roots of the error asked for,
/// over all light there: a tenth for 1%.
const MOST_MISFIT: f64 = 1.0;
const MISFIT_POINTS: u64 = 8;
/// Squares of standard errors by which chance may make them differ.
const SURE: f64 = 4.0;

/// Light that chains brought, patch by patch, in sixteen replicas.
pub struct Forward {
    fine: Layer<HALF>,
    /// Patches with twice the edges: what they would have said tells the bias of the finer ones.
    coarse: Layer<1>,
    /// Nearer than this, in m, gathering rays look no patch up, and patches that gather no direct light.
    near_m: f64,
    /// Where patches shall tell direct light: the error that decides which of them do.
    direct_for: Option<f64>,
    /// Whether each of them does; empty before they know it.
    tells_direct: Vec<bool>,
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
        let patches = |edge_m: f64| {
            let patches = Patches::of(context.scene, edge_m);
            let share = |patch| exposed_share(context, &patches, patch);
            let exposed = (0..patches.len() as u32).into_par_iter().map(share).collect();
            (patches, exposed)
        };
        let (fine, coarse) = rayon::join(|| patches(edge_m), || patches(2.0 * edge_m));
        Forward {
            fine: Layer::new(fine.0, fine.1),
            coarse: Layer::new(coarse.0, coarse.1),
            near_m: NEAR * edge_m,
            direct_for: None,
            tells_direct: Vec::new(),
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

    /// Rays that it takes at least to know the direct light of all patches.
    pub fn rays_to_know_direct(&self) -> f64 {
        (FEWEST_LOOKS * REPLICAS as u64) as f64 * self.fine.patches.len() as f64
    }

    /// Whether patches shall tell direct light too.
    pub fn shall_tell_direct(&self) -> bool {
        self.direct_for.is_some()
    }

    /// Lets patches tell direct light too, from when chains are settled on, as exactly as a relative error asks for.
    pub fn tell_direct(&mut self, error: f64) {
        self.direct_for = Some(error);
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
        let flux_per_chain_lm = context.stage.emitters.luminous_flux_lm() / self.chains as f64;
        self.fine.value(flux_per_chain_lm);
        self.coarse.value(flux_per_chain_lm);
        let rays_per_sample = RAYS_PER_SAMPLE * self.fine.patches.len() as f64;
        let wanted_rays = REFINING_SHARE * self.rays_per_chain() * self.chains as f64;
        let earlier_rays = self.rays;
        // Where looks would take more than there is, patches tell no direct light, and rays look themselves.
        self.tells_direct.clear();
        if let Some(error) = self.direct_for
            && self.rays_to_know_direct() <= most_rays
        {
            self.look_at_direct(context, error, most_rays);
        }
        let most_rays = most_rays - (self.rays - earlier_rays) as f64;
        let samples = (wanted_rays.min(most_rays / REPLICAS as f64) / rays_per_sample) as u64;
        if samples >= FEWEST_SAMPLES {
            self.refine(context, samples);
        }
        self.fine.tabulate();
        self.coarse.tabulate();
    }

    /// Direct light by looks from points of every patch, more from large ones, by `most_rays` in all.
    fn look_at_direct(&mut self, context: &Context, error: f64, most_rays: f64) {
        let stage = context.stage;
        let patches = &self.fine.patches;
        let area_m2 = patches.all_area_m2();
        let more_looks =
            (LOOKS_SHARE * self.chain_rays as f64).min(most_rays - self.rays_to_know_direct()) / REPLICAS as f64;
        let looks_of = |patch: u32| FEWEST_LOOKS.max((more_looks * patches.area_m2(patch) / area_m2) as u64);
        let look = |_: usize, spot: (u32, Side), receiver: &Receiver, cut: &mut Cut, stream: &mut Stream| {
            if !matches!(stage.law(spot.0), Law::Diffuse(law) if law.reflectance > 0.0) {
                return (0.0, 0);
            }
            let sight = one_look(stage, spot, receiver, Care::Glance, cut, stream);
            sight.map_or((0.0, 0), |sight| (sight.direct_lx(), 1))
        };
        let found = self.sampled(context, Purpose::Direct, looks_of, look);
        self.fine.direct_lx.clear();
        self.coarse.direct_lx.clear();
        for Sampled { fine_lx, coarse_lx, rays } in found {
            self.fine.direct_lx.push(fine_lx);
            self.coarse.direct_lx.push(coarse_lx);
            self.rays += rays;
        }
        let tells = |patch: u32| {
            let most_lx = MOST_MISFIT * error.sqrt() * self.fine.mean_lx(patch);
            !self.fine.patches.is_joined(patch) && self.misfit_lx2(context, patch) <= most_lx * most_lx
        };
        self.tells_direct = (0..self.fine.patches.len() as u32).into_par_iter().map(tells).collect();
    }

    /// Mean square over a patch, in lx², of what coarser patches say of its direct light beyond it, what chance may have of
    /// that taken off: near luminaires and at the edges of shadows a linear function does not show it.
    fn misfit_lx2(&self, context: &Context, patch: u32) -> f64 {
        let mut stream = Stream::new(context.seed, Purpose::Pilot, FORWARD, REPLICAS as u32 + 1);
        let (mut squares, mut chance_lx2) = (0.0, 0.0);
        for number in 0..MISFIT_POINTS {
            stream.seek_quasi((u64::from(patch) << 32) | number, u64::from(patch), number);
            let (point, ..) = point_of_patch(context, &self.fine.patches, patch, &mut stream);
            let fine = self.fine.patches.place(point.0, point.1, point.2);
            let coarse = self.coarse.patches.place(point.0, point.1, point.2);
            if let (Some(fine), Some(coarse)) = (fine, coarse) {
                let (fine_lx, fine_lx2) = self.fine.mean_direct_lx(&fine);
                let (coarse_lx, coarse_lx2) = self.coarse.mean_direct_lx(&coarse);
                squares += (coarse_lx - fine_lx).powi(2);
                chance_lx2 += SURE * (fine_lx2 + coarse_lx2);
            }
        }
        (squares - chance_lx2) / MISFIT_POINTS as f64
    }

    /// Indirect light by gathering from points of every patch.
    fn refine(&mut self, context: &Context, samples: u64) {
        let gather = |replica: usize, _: (u32, Side), receiver: &Receiver, cut: &mut Cut, stream: &mut Stream| {
            let mut memory = Deposits { forward: self, replica };
            gather_indirect_lx(context.stage, receiver, &mut memory, cut, stream)
        };
        let found = self.sampled(context, Purpose::Gathering, |_| samples, gather);
        for (replica, Sampled { fine_lx, coarse_lx, rays }) in found.into_iter().enumerate() {
            self.fine.indirect_lx[replica] = fine_lx;
            self.coarse.indirect_lx[replica] = coarse_lx;
            self.rays += rays;
        }
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
                let exposed = self.fine.exposed[patch as usize];
                let count = count_of(patch);
                let weight = patches[0].area_m2(patch) / count as f64;
                for number in 0..count {
                    stream.seek_quasi((u64::from(patch) << 32) | number, u64::from(patch), number);
                    let (point, origin, normal) = point_of_patch(context, patches[0], patch, &mut stream);
                    if exposed < 1.0 && is_covered(context.stage, &origin, normal, &mut stream).0 {
                        continue;
                    }
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
            let values = |means: &[PatchMean], exposed: &[f64]| -> Vec<LinearLx> {
                means.iter().zip(exposed).map(|(mean, exposed)| mean.value(*exposed == 1.0)).collect()
            };
            let [fine, coarse] = &means;
            let (fine_lx, coarse_lx) = (values(fine, &self.fine.exposed), values(coarse, &self.coarse.exposed));
            Sampled { fine_lx, coarse_lx, rays }
        };
        (0..REPLICAS).into_par_iter().with_max_len(1).map(of_replica).collect()
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

/// What a replica found in the patches of both sizes, and the rays it took.
struct Sampled {
    fine_lx: Vec<LinearLx>,
    coarse_lx: Vec<LinearLx>,
    rays: u64,
}

/// Weighted samples of a patch: their weight, their sum and that of samples times offsets.
#[derive(Clone, Copy, Debug, Default)]
struct PatchMean {
    weight: f64,
    sums: [f64; 3],
}

impl PatchMean {
    fn add(&mut self, weight: f64, lx: f64, offset: [f64; 2]) {
        self.weight += weight;
        self.sums[0] += weight * lx;
        self.sums[1] += weight * lx * offset[0];
        self.sums[2] += weight * lx * offset[1];
    }

    fn value(&self, slopes: bool) -> LinearLx {
        if self.weight > 0.0 { projected(self.sums, 1.0 / self.weight, slopes) } else { [0.0; 3] }
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

/// Share of a patch that is not covered: nobody sees what is, and what is seen of the patch must not suffer from it.
fn exposed_share(context: &Context, patches: &Patches, patch: u32) -> f64 {
    let mut stream = Stream::new(context.seed, Purpose::Pilot, FORWARD, REPLICAS as u32);
    let exposed = (0..EXPOSURE_POINTS).filter(|number| {
        stream.seek_quasi((u64::from(patch) << 32) | number, u64::from(patch), *number);
        let (_, origin, normal) = point_of_patch(context, patches, patch, &mut stream);
        !is_covered(context.stage, &origin, normal, &mut stream).0
    });
    exposed.count() as f64 / EXPOSURE_POINTS as f64
}
