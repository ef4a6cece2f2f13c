//! Luminaires that stand close to a surface: the spot that they light is so small and bright that walks hardly ever meet it.
//!
//! A walk meets a place in proportion to how much of its view that fills, K = cos θ cos θ′/(π d²) an area; a packet of a near luminaire
//! in proportion to the illuminance there over the flux, E/Φ. Where E/Φ is far above K, looks from where walks arrive have a
//! heavy tail, or seem to have none since nobody has met the spot. So walks also draw a packet and look back from where it
//! arrives; both ways count with the shares of their densities (Veach and Guibas, 1995, "Optimally combining sampling
//! techniques for Monte Carlo rendering"), and no path counts twice.

use std::f64::consts::PI;

use glam::DVec3;

use super::Stage;
use crate::geometry::{Meeting, Origin, SurfaceHit};
use crate::sampling::random::{Purpose, Stream};
use crate::sampling::reflection::{Bsdf, LobeKind};

/// Packets that show what luminaires light, and chains that show how far surfaces are apart.
const PACKETS: u64 = 1024;
const CHAINS: u64 = 256;
/// Distances that tell their median well enough, the fewest chains that they must come from, and distances that tell it however
/// few these are: a chain of so many has been everywhere.
const ENOUGH_DISTANCES: usize = 100_000;
const MOST_DISTANCES: usize = 400_000;
const FEWEST_CHAINS: u64 = 16;
/// E/Φ over K, K that of places that face each other at the median distance of surfaces, from which on a luminaire lights a place
/// from near: a point nearer than a third of that distance, about. Where the lights of a room are no nearer than that, the means below
/// are far from their limit, so that this only says how much of a spot counts; with 6, a lamp that lights a far corner by way of its
/// spot on the ceiling alone was not one.
const NEAR: f64 = 2.0;
/// The mean of that ratio over all packets, those that arrive from farther away left out, from which on packets are worth their
/// rays: the variance of looks grows with it.
const LEAST_MEAN: f64 = 1.0;
/// The ratio from which on slopes of elements cannot show a spot: a thirtieth of that distance.
const TOUCHING: f64 = 225.0;
/// What this finds out enters no result but by way of densities: it is the same for all seeds.
const SEED: u64 = 0x4E_4541;

/// The emitters that stand close to surfaces.
#[derive(Clone, Debug)]
pub struct NearLights {
    /// Whether an emitter is one.
    is_near: Vec<bool>,
    /// Those that are, and their flux up to and including each, in lm.
    emitters: Vec<u32>,
    cumulative_flux_lm: Vec<f64>,
    /// Whether one of them nearly touches a surface.
    touch: bool,
    rays: u64,
}

/// Where a walk looks back from: a place in m and its unit normal.
pub type LookedBack = (DVec3, DVec3);

/// What looking back found.
#[derive(Clone, Copy, Debug)]
pub struct LookBack {
    /// What the place receives, in lx.
    pub lx: f64,
    /// Rays that it took.
    pub rays: u64,
    /// Density in 1/m² of walks from the place there where the packet arrived.
    pub met_per_m2: f64,
    /// Density in 1/m² of packets there.
    pub lit_per_m2: f64,
}

/// What a surface sends on of the light that a packet brings.
enum Leaving {
    /// One side reflects it, by its reflectance.
    Reflected(f64),
    /// A sheet spreads it to either side.
    EitherSide { reflected: f64, passed: f64 },
}

/// Where a packet of a near luminaire has arrived.
pub struct LitSpot {
    /// The emitter.
    pub emitter: u32,
    /// Where.
    pub hit: SurfaceHit,
    /// Unit normal of the lit side.
    pub normal: DVec3,
    leaving: Leaving,
}

impl LitSpot {
    /// Reflectance of a surface that spreads light to the lit side alone; `None` of a sheet.
    pub fn reflectance(&self) -> Option<f64> {
        match self.leaving {
            Leaving::Reflected(reflectance) => Some(reflectance),
            Leaving::EitherSide { .. } => None,
        }
    }
}

impl LookBack {
    fn nothing(rays: u64) -> LookBack {
        LookBack { lx: 0.0, rays, met_per_m2: 0.0, lit_per_m2: 0.0 }
    }
}

impl NearLights {
    /// Finds the emitters that light surfaces from near; `None` where that is not worth anything.
    pub fn of(stage: &Stage) -> Option<NearLights> {
        if !stage.reflects() {
            return None;
        }
        let emitters = stage.emitters.list();
        let mut stream = Stream::new(SEED, Purpose::Pilot, 0, 0);
        let mut rays = 0;
        // Illuminance for a lumen of the emitter, in 1/m², where each packet arrives.
        let mut found: Vec<(u32, f64)> = Vec::new();
        for packet in 0..PACKETS {
            stream.seek_quasi(packet, 0, packet);
            let choice = (packet as f64 + 0.5) / PACKETS as f64;
            let index = stage.emitters.index_at(choice);
            // Sky and sun are far.
            if emitters[index as usize].is_far() {
                continue;
            }
            let emitted = emitters[index as usize].emit(&mut stream);
            rays += 1;
            let Meeting::Surface(hit) = stage.tracer.first_hit(&stage.origin(&emitted.place), emitted.direction) else {
                continue;
            };
            let bsdf = stage.bsdf(hit.triangle);
            if stage.receives(hit.triangle, hit.side) && matches!(bsdf, Bsdf::Diffuse(_) | Bsdf::Translucent(_)) {
                let point_m = stage.tracer.position_m(&stage.leave(&hit, LobeKind::Spread));
                let lx = emitters[index as usize].unshadowed_lx(point_m, stage.normal_at(&hit));
                found.push((index, lx / emitters[index as usize].luminous_flux_lm));
            }
        }
        let near = |distance_m: f64| {
            let ratios = found.iter().map(move |(index, per_m2)| (*index, per_m2 * PI * distance_m * distance_m));
            ratios.filter(|(_, ratio)| *ratio > NEAR)
        };
        let matter =
            |distance_m: f64| near(distance_m).map(|(_, ratio)| ratio).sum::<f64>() > LEAST_MEAN * PACKETS as f64;
        if !matter(stage.tracer.longest_m()) {
            return None;
        }
        let (distance_m, chain_rays) = median_distance_m(stage);
        if !matter(distance_m) {
            return None;
        }
        let mut is_near = vec![false; emitters.len()];
        near(distance_m).for_each(|(index, _)| is_near[index as usize] = true);
        let touch = near(distance_m).any(|(_, ratio)| ratio > TOUCHING);
        let indices: Vec<u32> = (0..emitters.len() as u32).filter(|index| is_near[*index as usize]).collect();
        let fluxes_lm = indices.iter().map(|index| emitters[*index as usize].luminous_flux_lm);
        let cumulative_flux_lm = fluxes_lm.scan(0.0, |sum_lm, lm| {
            *sum_lm += lm;
            Some(*sum_lm)
        });
        let cumulative_flux_lm = cumulative_flux_lm.collect();
        Some(NearLights { is_near, emitters: indices, cumulative_flux_lm, touch, rays: rays + chain_rays })
    }

    /// Numbers of the luminaires that they belong to.
    pub fn luminaires(&self, stage: &Stage) -> impl Iterator<Item = usize> {
        let mut luminaires: Vec<usize> =
            self.emitters.iter().map(|index| stage.emitters.list()[*index as usize].luminaire as usize).collect();
        luminaires.dedup();
        luminaires.into_iter()
    }

    /// Whether one of them nearly touches a surface.
    pub fn touch(&self) -> bool {
        self.touch
    }

    /// Rays that it took to find them.
    pub fn rays(&self) -> u64 {
        self.rays
    }

    /// Flux of all of them in lm.
    pub fn luminous_flux_lm(&self) -> f64 {
        self.cumulative_flux_lm.last().copied().unwrap_or(0.0)
    }

    /// The share with which a look at an emitter counts from a diffuse place with the normal of its lit side, that a walk met on the
    /// side with the normal `seen`, coming from where it looked back from: docs/methods.md (42).
    #[inline]
    pub fn share_of_look(&self, stage: &Stage, emitter: u32, place: LookedBack, seen: DVec3, from: LookedBack) -> f64 {
        if !self.is_near(emitter) {
            return 1.0;
        }
        let met_per_m2 = seen_per_m2((place.0, seen), from);
        if met_per_m2 <= 0.0 {
            // Met all the same, by rounding: looking back does not see it.
            return 1.0;
        }
        met_per_m2 / (met_per_m2 + stage.roulette.look_back_chance * self.lit_per_m2(stage, emitter, place))
    }

    /// Whether an emitter is one of them.
    #[inline]
    pub fn is_near(&self, emitter: u32) -> bool {
        self.is_near[emitter as usize]
    }

    /// Density in 1/m² of packets of an emitter at a place.
    pub fn lit_per_m2(&self, stage: &Stage, emitter: u32, (point_m, normal): LookedBack) -> f64 {
        stage.emitters.list()[emitter as usize].unshadowed_lx(point_m, normal) / self.luminous_flux_lm()
    }

    /// One sample, with its share, of what a place receives by way of the diffuse surfaces that near luminaires light, in lx; it is
    /// taken by the chance of [`Roulette`].
    pub fn look_back(&self, stage: &Stage, to: LookedBack, to_origin: &Origin, stream: &mut Stream) -> LookBack {
        let (spot, rays) = self.packet(stage, stream);
        spot.map_or(LookBack::nothing(rays), |spot| {
            let found = self.seen_from(stage, &spot, to, to_origin);
            LookBack { rays: rays + found.rays, ..found }
        })
    }

    /// The spot that a packet of a near luminaire lights, and the rays it took; `None` where it lights none that spreads light, and where
    /// the chance of [`Roulette`] draws no packet.
    pub fn packet(&self, stage: &Stage, stream: &mut Stream) -> (Option<LitSpot>, u64) {
        let chance = stage.roulette.look_back_chance;
        if chance < 1.0 && !stream.happens(chance) {
            return (None, 0);
        }
        let aim_lm = stream.fine_unit() * self.luminous_flux_lm();
        let number = self.cumulative_flux_lm.partition_point(|sum_lm| *sum_lm <= aim_lm);
        let emitter = self.emitters[number.min(self.emitters.len() - 1)];
        let emitted = stage.emitters.list()[emitter as usize].emit(stream);
        let (mut origin, mut rays) = (stage.origin(&emitted.place), 0);
        loop {
            rays += 1;
            let Meeting::Surface(hit) = stage.tracer.first_hit(&origin, emitted.direction) else {
                return (None, rays);
            };
            if !stage.receives(hit.triangle, hit.side) || stage.is_touched(&origin, &hit) {
                return (None, rays);
            }
            let normal = stage.normal_at(&hit);
            let leaving = match stage.bsdf(hit.triangle) {
                Bsdf::Diffuse(bsdf) => Leaving::Reflected(bsdf.reflectance),
                Bsdf::Translucent(bsdf) => {
                    Leaving::EitherSide { reflected: bsdf.reflectance, passed: bsdf.transmittance }
                }
                bsdf @ Bsdf::Glass(_) => match bsdf.sample(emitted.direction, normal, stream) {
                    Some(scattered) if scattered.lobe == LobeKind::Passed => {
                        origin = stage.leave(&hit, scattered.lobe);
                        continue;
                    }
                    _ => return (None, rays),
                },
                _ => return (None, rays),
            };
            return (Some(LitSpot { emitter, hit, normal, leaving }), rays);
        }
    }

    /// What a place receives from a spot, with its share beside walks from the place that meet it; its rays are those of seeing it.
    pub fn seen_from(&self, stage: &Stage, spot: &LitSpot, to: LookedBack, to_origin: &Origin) -> LookBack {
        let LitSpot { emitter, hit, normal, .. } = spot;
        let (leaving, lobe) = match spot.leaving {
            Leaving::Reflected(reflected) => (reflected, LobeKind::Spread),
            Leaving::EitherSide { reflected, passed } => {
                let lit_m = stage.tracer.position_m(&stage.leave(hit, LobeKind::Spread));
                let is_behind = (to.0 - lit_m).dot(*normal) < 0.0;
                if is_behind { (passed, LobeKind::SpreadThrough) } else { (reflected, LobeKind::Spread) }
            }
        };
        if leaving <= 0.0 {
            return LookBack::nothing(0);
        }
        let place_origin = stage.leave(hit, lobe);
        let point_m = stage.tracer.position_m(&place_origin);
        let seen = if lobe == LobeKind::SpreadThrough { -normal } else { *normal };
        let met_per_m2 = seen_per_m2((point_m, seen), to);
        let lit_per_m2 = self.lit_per_m2(stage, *emitter, (point_m, *normal));
        if met_per_m2 <= 0.0 || lit_per_m2 <= 0.0 {
            return LookBack::nothing(0);
        }
        let share = lit_per_m2 / (met_per_m2 + stage.roulette.look_back_chance * lit_per_m2);
        let passed = stage.transmittance(to_origin, &place_origin);
        let lx = self.luminous_flux_lm() * leaving * met_per_m2 * share * passed;
        LookBack { lx, rays: 1, met_per_m2, lit_per_m2 }
    }
}

/// Density in 1/m² with which walks from a place by the cosine law meet another, if nothing is in the way.
fn seen_per_m2((point_m, normal): LookedBack, (from_m, from_normal): LookedBack) -> f64 {
    let offset_m = point_m - from_m;
    let square_m2 = offset_m.length_squared();
    let cosines = offset_m.dot(from_normal).max(0.0) * (-offset_m.dot(normal)).max(0.0);
    if cosines > 0.0 { cosines / (PI * square_m2 * square_m2) } else { 0.0 }
}

/// Median distance in m from one surface to the next that packets meet, and the rays that it took to find out.
pub fn median_distance_m(stage: &Stage) -> (f64, u64) {
    let mut stream = Stream::new(SEED, Purpose::Pilot, 1, 0);
    let (mut distances_m, mut rays) = (Vec::new(), 0);
    for chain in 0..CHAINS {
        stream.seek_quasi(chain, 1, chain);
        let choice = stream.fine_unit();
        let (_, chain_rays) = stage.trace_chain(choice, &mut stream, |arrival| {
            if arrival.bounces > 0 {
                distances_m.push(arrival.hit.distance_m);
            }
        });
        rays += chain_rays;
        // In nearly white rooms a chain meets thousands of surfaces.
        if distances_m.len() > MOST_DISTANCES || distances_m.len() > ENOUGH_DISTANCES && chain >= FEWEST_CHAINS {
            break;
        }
    }
    let middle = distances_m.len() / 2;
    if distances_m.is_empty() {
        return (f64::INFINITY, rays);
    }
    (*distances_m.select_nth_unstable_by(middle, f64::total_cmp).1, rays)
}
