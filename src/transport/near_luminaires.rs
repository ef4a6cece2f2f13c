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
use super::sides_by_area::{SidesByArea, TriangleSide};
use crate::geometry::{Meeting, Origin, SurfaceHit};
use crate::sampling::random::{Purpose, Stream};
use crate::sampling::reflection::{Bsdf, LobeKind};
use crate::sampling::warp::{cosine_hemisphere, uniform_triangle};
use crate::scene::{Scene, Side};

/// Number of packets that show what luminaires light, and of chains and rays that show how far surfaces are apart.
const PACKETS: u64 = 1024;
const CHAINS: u64 = 256;
const RAYS: u64 = 1024;
/// Three limits on the distances sampled by chains: enough distances for their median, the upper limit for any number of chains, and the
/// fewest chains for `ENOUGH_DISTANCES`. A chain with more distances than the upper limit has been everywhere.
const ENOUGH_DISTANCES: usize = 100_000;
const MOST_DISTANCES: usize = 400_000;
const FEWEST_CHAINS: u64 = 16;
/// Ratio of E/Φ to K from which on a luminaire lights a point from nearby. K is the one of two points that face each other at the typical
/// distance of surfaces. The limit corresponds to a point source nearer than about a third of that distance. If the lights of a room are no
/// nearer than that, the means below are far from their limit, so this constant only decides how much of a spot counts. With a limit of 6,
/// a lamp that lights a far corner only through its spot on the ceiling was not counted as near.
const NEAR: f64 = 2.0;
/// Mean of that ratio over all packets from which on packets are worth their rays. Packets that arrive from farther away add nothing to the
/// mean. The variance of light samples grows with it.
const LEAST_MEAN: f64 = 1.0;
/// Share of packets that are drawn by flux alone, not by the distance of the emitter; and most emitters that are weighed by distance.
const BY_FLUX: f64 = 0.25;
const MOST_WEIGHED: usize = 32;
/// Ratio from which on slopes of elements cannot show a spot. It corresponds to a thirtieth of that distance.
const TOUCHING: f64 = 225.0;
/// The result of this search affects only probability densities, so it is the same for all seeds.
const SEED: u64 = 0x4E_4541;

/// The emitters that stand close to surfaces.
#[derive(Clone, Debug)]
pub struct NearLuminaires {
    /// Place of each emitter of the scene among the near ones.
    places: Vec<Option<u32>>,
    /// The near emitters, and their cumulative flux up to and including each, in lm.
    emitters: Vec<NearEmitter>,
    cumulative_flux_lm: Vec<f64>,
    /// Whether one of them nearly touches a surface.
    touch: bool,
    rays: u64,
}

/// An emitter that stands close to surfaces.
#[derive(Clone, Copy, Debug)]
struct NearEmitter {
    /// Its number in the scene.
    number: u32,
    center_m: DVec3,
    luminous_flux_lm: f64,
    /// Mean square of the distance in m² from its centre to the surfaces that its packets light.
    spots_m2: f64,
}

impl NearEmitter {
    /// What its spots bring to a point, approximately, up to a common factor: docs/methods.md (54).
    #[inline]
    fn weight_at(&self, from_m: DVec3) -> f64 {
        self.luminous_flux_lm / (from_m.distance_squared(self.center_m) + self.spots_m2)
    }
}

/// Arrival of a packet of the search.
struct Arrived {
    emitter: u32,
    /// Illuminance there per lumen of the emitter, in 1/m².
    per_m2: f64,
    point_m: DVec3,
}

/// A surface or receiver point in m and its unit normal.
pub type PointAndNormal = (DVec3, DVec3);

/// A point from which a light-path connection to a packet has been made.
#[derive(Clone, Copy, Debug)]
pub struct ConnectedFrom {
    /// The point in m and its unit normal.
    pub place: PointAndNormal,
    /// The point in m for which the packet's emitter was drawn.
    pub drawn_for_m: DVec3,
}

impl ConnectedFrom {
    /// From a point whose packets are drawn for itself.
    pub fn itself(place: PointAndNormal) -> ConnectedFrom {
        ConnectedFrom { place, drawn_for_m: place.0 }
    }
}

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
    emitter: u32,
    /// Probability that the emitter was drawn, over its flux in lm.
    drawn_per_lm: f64,
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

    /// Density in 1/m² of such packets at a point of the spot's surface in m, and the emitter's illuminance there in lx.
    pub fn lit(&self, world: &World, point_m: DVec3) -> (f64, f64) {
        let lx = world.emitters.list()[self.emitter as usize].unshadowed_lx(point_m, self.normal);
        (lx * self.drawn_per_lm, lx)
    }

    /// Illuminance of a point from the spot, weighted against walks from the point that meet the spot. Its rays are those that test
    /// visibility.
    pub fn seen_from(&self, world: &World, to: PointAndNormal, to_origin: &Origin) -> PacketConnection {
        let LitSpot { hit, normal, .. } = self;
        let (leaving, lobe) = match self.leaving {
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
        let (lit_per_m2, lit_lx) = self.lit(world, point_m);
        if met_per_m2 <= 0.0 || lit_per_m2 <= 0.0 {
            return PacketConnection::nothing(0);
        }
        let both_per_m2 = met_per_m2 + world.roulette.connection_chance * lit_per_m2;
        let passed = world.transmittance(to_origin, &place_origin);
        let lx = lit_lx * leaving * met_per_m2 * passed / both_per_m2;
        PacketConnection { lx, rays: 1, met_per_m2, lit_per_m2 }
    }
}

impl PacketConnection {
    fn nothing(rays: u64) -> PacketConnection {
        PacketConnection { lx: 0.0, rays, met_per_m2: 0.0, lit_per_m2: 0.0 }
    }
}

impl NearLuminaires {
    /// Finds the emitters that light surfaces from nearby. `None` if connections to them bring no gain.
    pub fn of(scene: &Scene, world: &World) -> Option<NearLuminaires> {
        if !world.reflects() {
            return None;
        }
        let emitters = world.emitters.list();
        let mut stream = Stream::new(SEED, Purpose::Pilot, 0, 0);
        let mut rays = 0;
        let mut found: Vec<Arrived> = Vec::new();
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
                let per_m2 = lx / emitters[index as usize].luminous_flux_lm;
                found.push(Arrived { emitter: index, per_m2, point_m });
            }
        }
        let near = |distance_m: f64| {
            let ratio = move |at: &Arrived| (at.emitter, at.per_m2 * PI * distance_m * distance_m);
            let ratios = found.iter().map(ratio);
            ratios.filter(|(_, ratio)| *ratio > NEAR)
        };
        let matter =
            |distance_m: f64| near(distance_m).map(|(_, ratio)| ratio).sum::<f64>() > LEAST_MEAN * PACKETS as f64;
        if !matter(world.tracer.longest_m()) {
            return None;
        }
        let (distance_m, distance_rays) = typical_distance_m(scene, world);
        if !matter(distance_m) {
            return None;
        }
        let mut is_near = vec![false; emitters.len()];
        near(distance_m).for_each(|(index, _)| is_near[index as usize] = true);
        let touch = near(distance_m).any(|(_, ratio)| ratio > TOUCHING);
        let near_emitter = |number: u32| {
            let emitter = &emitters[number as usize];
            let center_m = emitter.center_m();
            let of_it =
                || found.iter().filter(|at| at.emitter == number).map(|at| at.point_m.distance_squared(center_m));
            let spots_m2 = of_it().sum::<f64>() / of_it().count().max(1) as f64;
            NearEmitter { number, center_m, luminous_flux_lm: emitter.luminous_flux_lm, spots_m2 }
        };
        let numbers = (0..emitters.len() as u32).filter(|number| is_near[*number as usize]);
        let near_emitters: Vec<NearEmitter> = numbers.map(near_emitter).collect();
        let mut places = vec![None; emitters.len()];
        near_emitters.iter().zip(0..).for_each(|(emitter, place)| places[emitter.number as usize] = Some(place));
        let cumulative_flux_lm = near_emitters.iter().scan(0.0, |sum_lm, emitter| {
            *sum_lm += emitter.luminous_flux_lm;
            Some(*sum_lm)
        });
        let cumulative_flux_lm = cumulative_flux_lm.collect();
        Some(NearLuminaires { places, emitters: near_emitters, cumulative_flux_lm, touch, rays: rays + distance_rays })
    }

    /// Numbers of the luminaires to which the near emitters belong.
    pub fn luminaires(&self, world: &World) -> impl Iterator<Item = usize> {
        let mut luminaires: Vec<usize> =
            self.emitters.iter().map(|near| world.emitters.list()[near.number as usize].luminaire as usize).collect();
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
    fn luminous_flux_lm(&self) -> f64 {
        self.cumulative_flux_lm.last().copied().unwrap_or(0.0)
    }

    /// Probability that a packet drawn for a point in m comes from an emitter, over the emitter's flux in lm.
    #[inline]
    fn drawn_per_lm(&self, emitter: &NearEmitter, from_m: DVec3) -> f64 {
        self.probability(emitter, from_m, self.weights_at(from_m)) / emitter.luminous_flux_lm
    }

    /// Draws a near emitter for a point in m by a variate in [0, 1), and returns it with its probability.
    #[inline]
    fn choose(&self, from_m: DVec3, variate: f64) -> (&NearEmitter, f64) {
        let weights = self.weights_at(from_m);
        let last = self.emitters.len() - 1;
        let place = if weights.is_some() {
            let mut left = variate;
            let is_it = |emitter: &NearEmitter| {
                left -= self.probability(emitter, from_m, weights);
                left < 0.0
            };
            self.emitters.iter().position(is_it).unwrap_or(last)
        } else {
            let aim_lm = variate * self.luminous_flux_lm();
            self.cumulative_flux_lm.partition_point(|sum_lm| *sum_lm <= aim_lm).min(last)
        };
        let emitter = &self.emitters[place];
        (emitter, self.probability(emitter, from_m, weights))
    }

    /// Sum of the emitters' weights at a point in m; `None` if they are drawn by flux alone: if there is only one, or so many that weighing
    /// them takes longer than it saves.
    #[inline]
    fn weights_at(&self, from_m: DVec3) -> Option<f64> {
        let sum = || self.emitters.iter().map(|emitter| emitter.weight_at(from_m)).sum();
        (2..=MOST_WEIGHED).contains(&self.emitters.len()).then(sum)
    }

    /// Probability of an emitter, given the sum of all weights.
    #[inline]
    fn probability(&self, emitter: &NearEmitter, from_m: DVec3, weights: Option<f64>) -> f64 {
        let by_flux = emitter.luminous_flux_lm / self.luminous_flux_lm();
        weights.map_or(by_flux, |sum| BY_FLUX * by_flux + (1.0 - BY_FLUX) * emitter.weight_at(from_m) / sum)
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
        from: ConnectedFrom,
    ) -> f64 {
        if !self.is_near(emitter) {
            return 1.0;
        }
        let met_per_m2 = seen_per_m2((place.0, seen), from.place);
        if met_per_m2 <= 0.0 {
            // The walk met the point by rounding alone: a connection does not see it.
            return 1.0;
        }
        met_per_m2
            / (met_per_m2 + world.roulette.connection_chance * self.lit_per_m2(world, emitter, place, from.drawn_for_m))
    }

    /// Whether an emitter is near.
    #[inline]
    pub fn is_near(&self, emitter: u32) -> bool {
        self.places[emitter as usize].is_some()
    }

    /// Density in 1/m² of packets of an emitter at a point, if they are drawn for another point in m: docs/methods.md (42). 0 if the emitter
    /// is not near.
    pub fn lit_per_m2(
        &self,
        world: &World,
        emitter: u32,
        (point_m, normal): PointAndNormal,
        drawn_for_m: DVec3,
    ) -> f64 {
        let drawn_per_lm = |place: u32| self.drawn_per_lm(&self.emitters[place as usize], drawn_for_m);
        let lx = world.emitters.list()[emitter as usize].unshadowed_lx(point_m, normal);
        lx * self.places[emitter as usize].map_or(0.0, drawn_per_lm)
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
        let (spot, rays) = self.packet(world, to.0, stream);
        spot.map_or(PacketConnection::nothing(rays), |spot| {
            let found = spot.seen_from(world, to, to_origin);
            PacketConnection { rays: rays + found.rays, ..found }
        })
    }

    /// The spot that a packet of a near luminaire lights, drawn for a point in m, and the number of rays traced. `None` if the packet
    /// lights no scattering surface, or if the chance of [`Roulette`] draws no packet.
    pub fn packet(&self, world: &World, from_m: DVec3, stream: &mut Stream) -> (Option<LitSpot>, u64) {
        let chance = world.roulette.connection_chance;
        if chance < 1.0 && !stream.happens(chance) {
            return (None, 0);
        }
        let (near, probability) = self.choose(from_m, stream.fine_unit());
        let (emitter, drawn_per_lm) = (near.number, probability / near.luminous_flux_lm);
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
            return (Some(LitSpot { emitter, drawn_per_lm, hit, normal, leaving }), rays);
        }
    }
}

/// Density in 1/m² with which cosine-distributed rays from one point meet another, without occlusion.
fn seen_per_m2((point_m, normal): PointAndNormal, (from_m, from_normal): PointAndNormal) -> f64 {
    let offset_m = point_m - from_m;
    let square_m2 = offset_m.length_squared();
    let cosines = offset_m.dot(from_normal).max(0.0) * (-offset_m.dot(normal)).max(0.0);
    if cosines > 0.0 { cosines / (PI * square_m2 * square_m2) } else { 0.0 }
}

/// Typical distance in m from one surface to the next, and the number of rays traced to find it: the larger of two medians. Where a luminaire
/// has a housing, most packets travel inside it; where a room is cluttered, most surfaces face others close by.
fn typical_distance_m(scene: &Scene, world: &World) -> (f64, u64) {
    let (of_packets, packet_rays) = distances_of_packets_m(world);
    let of_surfaces = distances_of_surfaces_m(scene, world);
    let median_m = |mut distances_m: Vec<f64>| {
        let middle = distances_m.len() / 2;
        match distances_m.is_empty() {
            true => f64::INFINITY,
            false => *distances_m.select_nth_unstable_by(middle, f64::total_cmp).1,
        }
    };
    (median_m(of_packets).max(median_m(of_surfaces)), packet_rays + RAYS)
}

/// Distances in m from one surface to the next that packets meet, and the number of rays traced for them.
fn distances_of_packets_m(world: &World) -> (Vec<f64>, u64) {
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
    (distances_m, rays)
}

/// Distances in m to the next surface from points evenly spread over all surfaces, in directions in which they reflect.
fn distances_of_surfaces_m(scene: &Scene, world: &World) -> Vec<f64> {
    let fronts: Vec<TriangleSide> = (0..scene.triangles.len() as u32).map(|triangle| (triangle, Side::Front)).collect();
    let sides = SidesByArea::of(scene, &fronts);
    let mut stream = Stream::new(SEED, Purpose::Pilot, 2, 0);
    let mut distances_m = Vec::new();
    for ray in 0..RAYS {
        stream.seek_quasi(ray, 2, ray);
        let (triangle, front) = sides.at(stream.unit());
        let is_back = stream.unit() < 0.5 && world.receives(triangle, Side::Back);
        let side = if is_back { Side::Back } else { front };
        let barycentric = uniform_triangle(stream.pair());
        let direction = cosine_hemisphere(world.normal_on(triangle, barycentric, side), stream.pair());
        let origin = world.tracer.surface_origin(triangle, barycentric, side);
        if let Meeting::Surface(hit) = world.tracer.first_hit(&origin, direction) {
            distances_m.push(hit.distance_m);
        }
    }
    distances_m
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::check::scene_from_json;

    /// A room of 5 × 4 × 3 m with further bodies and the given luminaires.
    fn world(bodies: &str, luminaires: &str) -> World {
        let text = format!(
            r#"{{ "version": 1, "materials": {{ "m": {{ "type": "diffuse", "reflectance": 0.5 }},
                "black": {{ "type": "diffuse", "reflectance": 0.04 }} }},
            "geometry": [ {{ "name": "r", "type": "box", "min": [0,0,0], "max": [5,4,3], "facing": "inward", "material": "m" }} {bodies} ],
            "luminaires": [ {luminaires} ] }}"#
        );
        World::new(&scene_from_json(&text, None, Path::new(".")).expect("a valid scene"))
    }

    fn lamp(name: &str, position: &str, luminous_flux_lm: f64) -> String {
        format!(
            r#"{{ "name": "{name}", "type": "point", "position": {position}, "luminous_flux_lm": {luminous_flux_lm} }}"#
        )
    }

    /// A lamp 5 cm from the walls of a dark housing that is open below lights these walls from nearby, however many of its packets stay in
    /// the housing. A lamp alone in the middle of the room is near to nothing.
    #[test]
    fn a_lamp_in_its_housing_is_near() {
        let side = |name: &str, origin: &str, u: &str, v: &str| {
            format!(
                r#", {{ "name": "{name}", "type": "rectangle", "origin": {origin}, "u": {u}, "v": {v}, "material": "black", "two_sided": true }}"#
            )
        };
        let housing = [
            side("a", "[2,1.95,2.4]", "[0.1,0,0]", "[0,0,0.4]"),
            side("b", "[2,2.05,2.4]", "[0.1,0,0]", "[0,0,0.4]"),
            side("c", "[2,1.95,2.4]", "[0,0.1,0]", "[0,0,0.4]"),
            side("d", "[2.1,1.95,2.4]", "[0,0.1,0]", "[0,0,0.4]"),
            side("e", "[2,1.95,2.8]", "[0.1,0,0]", "[0,0.1,0]"),
        ];
        assert!(world(&housing.concat(), &lamp("l", "[2.05,2,2.7]", 1000.0)).is_near(0));
        assert!(world("", &lamp("l", "[2.5,2,1.5]", 1000.0)).near_luminaires.is_none());
    }

    /// Packets are drawn from each of three lamps as often as their probability says, which is greatest for the nearest. 100,000 packets,
    /// seed 2: each share is within 4.5 σ (α = 7e-6 each), and shares of flux alone are rejected.
    #[test]
    fn emitters_are_drawn_with_their_probability() {
        let lamps =
            [lamp("a", "[0.5,2,2.9]", 2000.0), lamp("b", "[2.5,2,2.9]", 1000.0), lamp("c", "[4.5,2,2.9]", 1000.0)];
        let world = world("", &lamps.join(", "));
        let lights = world.near_luminaires.as_ref().expect("near luminaires");
        let from_m = DVec3::new(4.2, 2.0, 2.0);
        let mut stream = Stream::new(2, Purpose::Pilot, 0, 0);
        const DRAWN: usize = 100_000;
        let mut counts = [0.0; 3];
        (0..DRAWN)
            .for_each(|_| counts[lights.choose(from_m, stream.fine_unit()).0.number as usize] += 1.0 / DRAWN as f64);
        let probabilities =
            [0, 1, 2].map(|place| lights.probability(&lights.emitters[place], from_m, lights.weights_at(from_m)));
        assert!((probabilities.iter().sum::<f64>() - 1.0).abs() < 1e-12);
        assert!(probabilities[2] > probabilities[0] && probabilities[0] > 0.5 * BY_FLUX);
        let off = |expected: [f64; 3]| {
            let sigma = |p: f64| (p * (1.0 - p) / DRAWN as f64).sqrt();
            counts.iter().zip(expected).map(|(share, p)| (share - p).abs() / sigma(p)).fold(0.0, f64::max)
        };
        assert!(off(probabilities) < 4.5, "{counts:?} {probabilities:?}");
        assert!(off([0.5, 0.25, 0.25]) > 4.5);
    }
}
