//! Luminaires that stand close to a surface. The spot that they light is so small and bright that walks hardly ever meet it.
//!
//! A walk meets a surface point in proportion to its view factor per area, K = cos θ cos θ′/(π d²). A packet of a near luminaire meets it
//! in proportion to the illuminance there over the flux, E/Φ. Where E/Φ is far above K, light samples from walk vertices have a heavy tail.
//! The tail may even seem absent, because no walk has met the spot yet. So walks also draw a packet and connect to the point where it
//! arrives. Both paths are weighted by the shares of their densities (multiple importance sampling: Veach and Guibas,
//! 1995, "Optimally combining sampling techniques for Monte Carlo rendering"). No path counts twice.

use std::f64::consts::PI;

use glam::DVec3;

use super::World;
use crate::geometry::{Meeting, Origin, SurfaceHit};
use crate::sampling::random::{Purpose, Stream};
use crate::sampling::reflection::{Bsdf, LobeKind};

/// Number of packets that show what luminaires light, and of chains that show how far surfaces are apart.
const PACKETS: u64 = 1024;
const CHAINS: u64 = 256;
/// Three limits on the sampled distances: enough distances for their median, the upper limit for any number of chains, and the fewest
/// chains for `ENOUGH_DISTANCES`. A chain with more distances than the upper limit has been everywhere.
const ENOUGH_DISTANCES: usize = 100_000;
const MOST_DISTANCES: usize = 400_000;
const FEWEST_CHAINS: u64 = 16;
/// Ratio of E/Φ to K from which on a luminaire lights a point from nearby. K is the one of two points that face each other at the median
/// distance of surfaces. The limit corresponds to a point source nearer than about a third of that distance. If the lights of a room are no
/// nearer than that, the means below are far from their limit, so this constant only decides how much of a spot counts. With a limit of 6,
/// a lamp that lights a far corner only through its spot on the ceiling was not counted as near.
const NEAR: f64 = 2.0;
/// Mean of that ratio over all packets from which on packets are worth their rays. Packets that arrive from farther away add nothing to the
/// mean. The variance of light samples grows with it.
const LEAST_MEAN: f64 = 1.0;
/// Ratio from which on slopes of elements cannot show a spot. It corresponds to a thirtieth of that distance.
const TOUCHING: f64 = 225.0;
/// The result of this search affects only probability densities, so it is the same for all seeds.
const SEED: u64 = 0x4E_4541;

/// The emitters that stand close to surfaces.
#[derive(Clone, Debug)]
pub struct NearLuminaires {
    /// Whether each emitter is near.
    is_near: Vec<bool>,
    /// Numbers of the near emitters, and their cumulative flux up to and including each, in lm.
    emitters: Vec<u32>,
    cumulative_flux_lm: Vec<f64>,
    /// Whether one of them nearly touches a surface.
    touch: bool,
    rays: u64,
}

/// A surface or receiver point in m and its unit normal.
pub type PointAndNormal = (DVec3, DVec3);

/// Result of a light-path connection to the spot where a packet of a near luminaire has arrived.
#[derive(Clone, Copy, Debug)]
pub struct PacketConnection {
    /// Illuminance of the start point, in lx.
    pub lx: f64,
    /// Rays traced.
    pub rays: u64,
    /// Density in 1/m², at the arrival of the packet, of walks from the start point.
    pub met_per_m2: f64,
    /// Density in 1/m² of packets at the same point.
    pub lit_per_m2: f64,
}

/// Share of a packet's light that a surface sends on.
enum Leaving {
    /// One side reflects the light, by its reflectance.
    Reflected(f64),
    /// A sheet scatters the light to both sides.
    EitherSide { reflected: f64, passed: f64 },
}

/// Surface point where a packet of a near luminaire has arrived.
pub struct LitSpot {
    /// The emitter.
    pub emitter: u32,
    /// The surface point.
    pub hit: SurfaceHit,
    /// Unit normal of the lit side.
    pub normal: DVec3,
    leaving: Leaving,
}

impl LitSpot {
    /// Reflectance of a surface that scatters light only to the lit side. `None` for a sheet.
    pub fn reflectance(&self) -> Option<f64> {
        match self.leaving {
            Leaving::Reflected(reflectance) => Some(reflectance),
            Leaving::EitherSide { .. } => None,
        }
    }
}

impl PacketConnection {
    fn nothing(rays: u64) -> PacketConnection {
        PacketConnection { lx: 0.0, rays, met_per_m2: 0.0, lit_per_m2: 0.0 }
    }
}

impl NearLuminaires {
    /// Finds the emitters that light surfaces from nearby. `None` if connections to them bring no gain.
    pub fn of(world: &World) -> Option<NearLuminaires> {
        if !world.reflects() {
            return None;
        }
        let emitters = world.emitters.list();
        let mut stream = Stream::new(SEED, Purpose::Pilot, 0, 0);
        let mut rays = 0;
        // Illuminance per lumen of the emitter, in 1/m², at the arrival of each packet.
        let mut found: Vec<(u32, f64)> = Vec::new();
        for packet in 0..PACKETS {
            stream.seek_quasi(packet, 0, packet);
            let choice = (packet as f64 + 0.5) / PACKETS as f64;
            let index = world.emitters.index_at(choice);
            // Sky and sun are far away.
            if emitters[index as usize].is_far() {
                continue;
            }
            let emitted = emitters[index as usize].emit(&mut stream);
            rays += 1;
            let Meeting::Surface(hit) = world.tracer.first_hit(&world.origin(&emitted.place), emitted.direction) else {
                continue;
            };
            let bsdf = world.bsdf(hit.triangle);
            if world.receives(hit.triangle, hit.side) && matches!(bsdf, Bsdf::Diffuse(_) | Bsdf::Translucent(_)) {
                let point_m = world.tracer.position_m(&world.leave(&hit, LobeKind::Spread));
                let lx = emitters[index as usize].unshadowed_lx(point_m, world.normal_at(&hit));
                found.push((index, lx / emitters[index as usize].luminous_flux_lm));
            }
        }
        let near = |distance_m: f64| {
            let ratios = found.iter().map(move |(index, per_m2)| (*index, per_m2 * PI * distance_m * distance_m));
            ratios.filter(|(_, ratio)| *ratio > NEAR)
        };
        let matter =
            |distance_m: f64| near(distance_m).map(|(_, ratio)| ratio).sum::<f64>() > LEAST_MEAN * PACKETS as f64;
        if !matter(world.tracer.longest_m()) {
            return None;
        }
        let (distance_m, chain_rays) = median_distance_m(world);
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
        Some(NearLuminaires { is_near, emitters: indices, cumulative_flux_lm, touch, rays: rays + chain_rays })
    }

    /// Numbers of the luminaires to which the near emitters belong.
    pub fn luminaires(&self, world: &World) -> impl Iterator<Item = usize> {
        let mut luminaires: Vec<usize> =
            self.emitters.iter().map(|index| world.emitters.list()[*index as usize].luminaire as usize).collect();
        luminaires.dedup();
        luminaires.into_iter()
    }

    /// Whether one of them nearly touches a surface.
    pub fn touch(&self) -> bool {
        self.touch
    }

    /// Rays spent on finding them.
    pub fn rays(&self) -> u64 {
        self.rays
    }

    /// Flux of all near emitters in lm.
    pub fn luminous_flux_lm(&self) -> f64 {
        self.cumulative_flux_lm.last().copied().unwrap_or(0.0)
    }

    /// Weight of a light sample of an emitter at a diffuse point, beside the light-path connection: docs/methods.md (42). A walk met the
    /// point on the side with the normal `seen`. `place` has the normal of its lit side. The walk came from `from`, where it made the
    /// connection.
    #[inline]
    pub fn share_of_light_sample(
        &self,
        world: &World,
        emitter: u32,
        place: PointAndNormal,
        seen: DVec3,
        from: PointAndNormal,
    ) -> f64 {
        if !self.is_near(emitter) {
            return 1.0;
        }
        let met_per_m2 = seen_per_m2((place.0, seen), from);
        if met_per_m2 <= 0.0 {
            // The walk met the point by rounding alone: a connection does not see it.
            return 1.0;
        }
        met_per_m2 / (met_per_m2 + world.roulette.connection_chance * self.lit_per_m2(world, emitter, place))
    }

    /// Whether an emitter is near.
    #[inline]
    pub fn is_near(&self, emitter: u32) -> bool {
        self.is_near[emitter as usize]
    }

    /// Density in 1/m² of packets of an emitter at a point.
    pub fn lit_per_m2(&self, world: &World, emitter: u32, (point_m, normal): PointAndNormal) -> f64 {
        world.emitters.list()[emitter as usize].unshadowed_lx(point_m, normal) / self.luminous_flux_lm()
    }

    /// One weighted sample of the illuminance of a point in lx, by way of the diffuse surfaces that near luminaires light. It is taken with
    /// the chance of [`Roulette`].
    pub fn connect_to_packet(
        &self,
        world: &World,
        to: PointAndNormal,
        to_origin: &Origin,
        stream: &mut Stream,
    ) -> PacketConnection {
        let (spot, rays) = self.packet(world, stream);
        spot.map_or(PacketConnection::nothing(rays), |spot| {
            let found = self.seen_from(world, &spot, to, to_origin);
            PacketConnection { rays: rays + found.rays, ..found }
        })
    }

    /// The spot that a packet of a near luminaire lights, and the number of rays traced. `None` if the packet lights no scattering surface,
    /// or if the chance of [`Roulette`] draws no packet.
    pub fn packet(&self, world: &World, stream: &mut Stream) -> (Option<LitSpot>, u64) {
        let chance = world.roulette.connection_chance;
        if chance < 1.0 && !stream.happens(chance) {
            return (None, 0);
        }
        let aim_lm = stream.fine_unit() * self.luminous_flux_lm();
        let number = self.cumulative_flux_lm.partition_point(|sum_lm| *sum_lm <= aim_lm);
        let emitter = self.emitters[number.min(self.emitters.len() - 1)];
        let emitted = world.emitters.list()[emitter as usize].emit(stream);
        let (mut origin, mut rays) = (world.origin(&emitted.place), 0);
        loop {
            rays += 1;
            let Meeting::Surface(hit) = world.tracer.first_hit(&origin, emitted.direction) else {
                return (None, rays);
            };
            if !world.receives(hit.triangle, hit.side) || world.is_touched(&origin, &hit) {
                return (None, rays);
            }
            let normal = world.normal_at(&hit);
            let leaving = match world.bsdf(hit.triangle) {
                Bsdf::Diffuse(bsdf) => Leaving::Reflected(bsdf.reflectance),
                Bsdf::Translucent(bsdf) => {
                    Leaving::EitherSide { reflected: bsdf.reflectance, passed: bsdf.transmittance }
                }
                bsdf @ Bsdf::Glass(_) => match bsdf.sample(emitted.direction, normal, stream) {
                    Some(scattered) if scattered.lobe == LobeKind::Passed => {
                        origin = world.leave(&hit, scattered.lobe);
                        continue;
                    }
                    _ => return (None, rays),
                },
                _ => return (None, rays),
            };
            return (Some(LitSpot { emitter, hit, normal, leaving }), rays);
        }
    }

    /// Illuminance of a point from a spot, weighted against walks from the point that meet the spot. Its rays are those that test
    /// visibility.
    pub fn seen_from(&self, world: &World, spot: &LitSpot, to: PointAndNormal, to_origin: &Origin) -> PacketConnection {
        let LitSpot { emitter, hit, normal, .. } = spot;
        let (leaving, lobe) = match spot.leaving {
            Leaving::Reflected(reflected) => (reflected, LobeKind::Spread),
            Leaving::EitherSide { reflected, passed } => {
                let lit_m = world.tracer.position_m(&world.leave(hit, LobeKind::Spread));
                let is_behind = (to.0 - lit_m).dot(*normal) < 0.0;
                if is_behind { (passed, LobeKind::SpreadThrough) } else { (reflected, LobeKind::Spread) }
            }
        };
        if leaving <= 0.0 {
            return PacketConnection::nothing(0);
        }
        let place_origin = world.leave(hit, lobe);
        let point_m = world.tracer.position_m(&place_origin);
        let seen = if lobe == LobeKind::SpreadThrough { -normal } else { *normal };
        let met_per_m2 = seen_per_m2((point_m, seen), to);
        let lit_per_m2 = self.lit_per_m2(world, *emitter, (point_m, *normal));
        if met_per_m2 <= 0.0 || lit_per_m2 <= 0.0 {
            return PacketConnection::nothing(0);
        }
        let share = lit_per_m2 / (met_per_m2 + world.roulette.connection_chance * lit_per_m2);
        let passed = world.transmittance(to_origin, &place_origin);
        let lx = self.luminous_flux_lm() * leaving * met_per_m2 * share * passed;
        PacketConnection { lx, rays: 1, met_per_m2, lit_per_m2 }
    }
}

/// Density in 1/m² with which cosine-distributed rays from one point meet another, without occlusion.
fn seen_per_m2((point_m, normal): PointAndNormal, (from_m, from_normal): PointAndNormal) -> f64 {
    let offset_m = point_m - from_m;
    let square_m2 = offset_m.length_squared();
    let cosines = offset_m.dot(from_normal).max(0.0) * (-offset_m.dot(normal)).max(0.0);
    if cosines > 0.0 { cosines / (PI * square_m2 * square_m2) } else { 0.0 }
}

/// Median distance in m from one surface to the next that packets meet, and the number of rays traced for it.
pub fn median_distance_m(world: &World) -> (f64, u64) {
    let mut stream = Stream::new(SEED, Purpose::Pilot, 1, 0);
    let (mut distances_m, mut rays) = (Vec::new(), 0);
    for chain in 0..CHAINS {
        stream.seek_quasi(chain, 1, chain);
        let choice = stream.fine_unit();
        let (_, chain_rays) = world.trace_chain(choice, &mut stream, |arrival| {
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
