//! Luminaires that stand close to a surface. The spot that they light is so small and bright that walks hardly ever meet it.
//!
//! A walk meets a surface point in proportion to its view factor per area, K = cos θ cos θ′/(π d²). A packet of a near luminaire meets it
//! in proportion to the illuminance there over the flux, E/Φ. Where E/Φ is far above K, light samples from walk vertices have a heavy tail.
//! The tail may even seem absent, because no walk has met the spot yet. So walks also draw a packet and connect to the point where it
//! lands: see [`super::packets`]. Where surfaces near the luminaire face each other, they also connect to where it lands after that.

use std::f64::consts::PI;

use glam::DVec3;

use super::World;
use super::near_emitters::{NearEmitter, NearEmitters};
use super::packets::{
    ConnectedFrom, ConnectingPoint, LaterLandings, LitSpot, MetFrom, PacketConnection, PointAndNormal, SampledPlace,
};
use super::sight_lines::see_from_surfaces;
use super::traced::Traced;
use crate::geometry::Meeting;
use crate::sampling::emitter_tree::BeaconMask;
use crate::sampling::random::{Purpose, Stream};
use crate::sampling::reflection::{Bsdf, LobeKind};
use crate::scene::Scene;

/// Number of packets that show what luminaires light, and of chains and rays that show how far surfaces are apart.
const PACKETS: u64 = 1024;
const CHAINS: u64 = 256;
const RAYS: u64 = 1024;
/// Number of packets that show what they light after a reflection. Few of them land close by.
const REFLECTED_PACKETS: u64 = 4096;
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
/// The same for packets that the lit surface sends on, where they land next: mean, times the share that this surface sends on, of the ratio
/// of the harmonic sum of both densities to K. (Of 21 made-up rooms with near lamps, 19 from 0.013 to 0.75 took 0.43 to 1.05 of the work
/// with second landings. Two below 0.005 took 1.0 and 1.2 of the rays.)
const LEAST_MEAN_OF_SECOND: f64 = 0.0075;
/// Ratio from which on slopes of elements cannot show a spot. It corresponds to a thirtieth of that distance.
const TOUCHING: f64 = 225.0;
/// The result of this search affects only probability densities, so it is the same for all seeds.
const SEED: u64 = 0x4E_4541;

/// The emitters that stand close to surfaces, and what packets of them are worth.
#[derive(Clone, Debug)]
pub struct NearLuminaires {
    emitters: NearEmitters,
    /// The near emitters among all that choices weigh; `None` if these are too many.
    beacons: Option<BeaconMask>,
    /// Whether one of them nearly touches a surface.
    touch: bool,
    /// Whether packets that surfaces send on are worth their rays.
    lands_again: bool,
    rays: u64,
}

/// Landing of a packet of the search.
struct Landed {
    emitter: u32,
    /// Illuminance there per lumen of the emitter, in 1/m².
    per_m2: f64,
    point_m: DVec3,
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
        let mut found: Vec<Landed> = Vec::new();
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
                found.push(Landed { emitter: index, per_m2, point_m });
            }
        }
        let near = |distance_m: f64| {
            let ratio = move |at: &Landed| (at.emitter, at.per_m2 * PI * distance_m * distance_m);
            let ratios = found.iter().map(ratio);
            ratios.filter(|(_, ratio)| *ratio > NEAR)
        };
        let matter =
            |distance_m: f64| near(distance_m).map(|(_, ratio)| ratio).sum::<f64>() > LEAST_MEAN * PACKETS as f64;
        if !matter(world.tracer.longest_m()) {
            return None;
        }
        let Traced { value: distance_m, rays: distance_rays } = typical_distance_m(scene, world);
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
        let near_emitters = NearEmitters::new(numbers.map(near_emitter).collect(), emitters.len());
        let (lands_again, later_rays) = are_later_landings_worth_it(world, &near_emitters, distance_m);
        let rays = rays + distance_rays + later_rays;
        let beacons = world.emitters.mask(|number| near_emitters.contains(number));
        Some(NearLuminaires { emitters: near_emitters, beacons, touch, lands_again, rays })
    }

    /// Numbers of the luminaires to which the near emitters belong.
    pub fn luminaires(&self, world: &World) -> impl Iterator<Item = usize> {
        let mut luminaires: Vec<usize> =
            self.emitters.numbers().map(|number| world.emitters.list()[number as usize].luminaire as usize).collect();
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

    /// Whether an emitter is near.
    #[inline]
    pub fn is_near(&self, emitter: u32) -> bool {
        self.emitters.contains(emitter)
    }

    /// The near emitters among all that choices weigh; `None` if these are too many.
    #[inline]
    pub fn beacons(&self) -> Option<&BeaconMask> {
        self.beacons.as_ref()
    }

    /// Density of packets at a place that a walk met from `from`, over that of such walks and for an illuminance of 1 lx there. Packets are
    /// taken to be drawn by flux.
    #[inline]
    pub fn packets_per_lx(&self, world: &World, place: &SampledPlace, from: &ConnectedFrom) -> f64 {
        place.packets_per_lx(world, &self.emitters, from)
    }

    /// Landings to which points along a walk also connect, after surfaces have sent packets on: docs/methods.md (55).
    #[inline]
    pub fn later_landings(&self) -> LaterLandings {
        if self.lands_again { LaterLandings::All } else { LaterLandings::None }
    }

    /// The same for receivers: sheets alone. Neighbours share the light from points that scatter it only to one side.
    #[inline]
    pub fn later_landings_of_receivers(&self, world: &World) -> LaterLandings {
        if self.lands_again && world.has_sheets() { LaterLandings::OnSheets } else { LaterLandings::None }
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
        let lx = world.emitters.list()[emitter as usize].unshadowed_lx(point_m, normal);
        lx * self.emitters.drawn_per_lm(emitter, drawn_for_m)
    }

    /// Weight of a light sample of an emitter at a diffuse point that a walk met from `from`: docs/methods.md (42) and (55).
    #[inline]
    pub fn share_of_light_sample(
        &self,
        world: &World,
        emitter: u32,
        place: &SampledPlace,
        from: &ConnectedFrom,
    ) -> f64 {
        if self.is_near(emitter) { place.share(world, &self.emitters, emitter, from) } else { 1.0 }
    }

    /// One weighted sample of the illuminance of a point in lx, by way of the diffuse surfaces that near luminaires light. It is taken with
    /// the chance of [`Roulette`].
    pub fn connect_to_packet(&self, world: &World, to: &ConnectingPoint, stream: &mut Stream) -> PacketConnection {
        let (spot, rays) = self.packet(world, to.front.place.0, stream);
        let Some(spot) = spot else {
            return PacketConnection::nothing(rays);
        };
        let found = self.connect_to_spot(world, &spot, to);
        let later = self.connect_to_later_landings(world, &spot, to, stream);
        PacketConnection { rays: rays + found.rays + later.rays, later_lx: later.value, ..found }
    }

    /// One weighted sample of the illuminance of a point in lx by way of where a packet lands after its spot has sent it on, and the number
    /// of rays.
    pub fn connect_to_later_landings(
        &self,
        world: &World,
        spot: &LitSpot,
        to: &ConnectingPoint,
        stream: &mut Stream,
    ) -> Traced {
        if to.later == LaterLandings::None {
            return Traced::default();
        }
        let (mut landed, rays) = spot.land_again(world, &self.emitters, stream);
        let mut sum = Traced { value: 0.0, rays };
        while let Some(packet) = landed {
            sum += packet.seen_from(world, &self.emitters, to);
            let (next, next_rays) = packet.land_again(world, &self.emitters, stream);
            landed = next;
            sum.rays += next_rays;
        }
        sum
    }

    /// How a walk from a point where it made a connection meets a place. `None` if later landings there are not connected to from the point.
    #[inline]
    pub fn meets(
        &self,
        from: &ConnectedFrom,
        is_sheet: bool,
        place: impl FnOnce() -> PointAndNormal,
    ) -> Option<MetFrom> {
        from.meets(&self.emitters, is_sheet, place)
    }

    /// One weighted sample of the illuminance of a point in lx from the spot of a packet that was drawn for it or for its neighbours.
    pub fn connect_to_spot(&self, world: &World, spot: &LitSpot, to: &ConnectingPoint) -> PacketConnection {
        spot.seen_from(world, to)
    }

    /// The spot that a packet of a near luminaire lights, drawn for a point in m, and the number of rays traced. `None` if the packet
    /// lights no scattering surface, or if the chance of [`Roulette`] draws no packet.
    pub fn packet(&self, world: &World, from_m: DVec3, stream: &mut Stream) -> (Option<LitSpot>, u64) {
        let chance = world.roulette.connection_chance;
        if chance < 1.0 && !stream.happens(chance) {
            return (None, 0);
        }
        LitSpot::land(world, self.emitters.draw(from_m, stream.fine_unit()), stream)
    }
}

/// Whether near luminaires light surfaces that are close to each other, so that walks hardly ever find what is reflected there twice; and
/// the number of rays traced.
fn are_later_landings_worth_it(world: &World, near: &NearEmitters, distance_m: f64) -> (bool, u64) {
    let facing_per_m2 = 1.0 / (PI * distance_m * distance_m);
    let mut stream = Stream::new(SEED, Purpose::Pilot, 3, 0);
    let (mut sum, mut rays) = (0.0, 0);
    for packet in 0..REFLECTED_PACKETS {
        stream.seek_quasi(packet, 3, packet);
        let (spot, spot_rays) = LitSpot::land(world, near.draw_by_flux(stream.fine_unit()), &mut stream);
        rays += spot_rays;
        let Some(spot) = spot else { continue };
        let (landing, landing_rays) = spot.land_again(world, near, &mut stream);
        rays += landing_rays;
        let Some(landing) = landing else { continue };
        let ratio = landing.ratio_to(world, facing_per_m2);
        sum += if ratio > NEAR { landing.leaving() * ratio } else { 0.0 };
    }
    (sum > LEAST_MEAN_OF_SECOND * REFLECTED_PACKETS as f64, rays)
}

/// Typical distance in m from one surface to the next, and the number of rays traced to find it: the larger of two medians. Where a luminaire
/// has a housing, most packets travel inside it; where a room is cluttered, most surfaces face others close by.
fn typical_distance_m(scene: &Scene, world: &World) -> Traced {
    let (of_packets, packet_rays) = distances_of_packets_m(world);
    let of_surfaces = distances_of_surfaces_m(scene, world);
    let median_m = |mut distances_m: Vec<f64>| {
        let middle = distances_m.len() / 2;
        match distances_m.is_empty() {
            true => f64::INFINITY,
            false => *distances_m.select_nth_unstable_by(middle, f64::total_cmp).1,
        }
    };
    Traced { value: median_m(of_packets).max(median_m(of_surfaces)), rays: packet_rays + RAYS }
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
    let mut stream = Stream::new(SEED, Purpose::Pilot, 2, 0);
    let mut distances_m = Vec::new();
    see_from_surfaces(scene, world, RAYS, &mut stream, |_, hit| distances_m.push(hit.distance_m));
    distances_m
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::check::scene_from_json;
    use crate::sampling::emitter_tree::Cut;

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

    /// The spot of a lamp 10 cm from a wall, met by a walk from 4 m away, under a second lamp. What packets have found of the near lamp counts
    /// little in a light sample there, so the second lamp is chosen often, and the second moment of samples is less than an eighth of that of
    /// choices by illuminance alone. The mean of 100,000 choices at equal steps is what both lamps bring, to a thousandth.
    #[test]
    fn what_packets_find_is_chosen_less_often() {
        let world = world("", &[lamp("near", "[0.1,2,1.5]", 1000.0), lamp("far", "[3,3,2.5]", 1000.0)].join(","));
        let lights = world.near_luminaires.as_ref().expect("a near lamp");
        let (lit, seen_from) = ((DVec3::new(0.0, 2.0, 1.5), DVec3::X), (DVec3::new(4.0, 2.0, 1.4), DVec3::NEG_X));
        let place = SampledPlace { lit, seen: lit.1, leaving: 0.5 };
        let from = ConnectedFrom {
            place: seen_from,
            drawn_for_m: seen_from.0,
            met: None,
            sends: 1.0,
            later: LaterLandings::None,
        };
        let wall = world.tracer.first_hit(&world.tracer.side_origin(seen_from.0, seen_from.1), DVec3::NEG_X);
        let Meeting::Surface(hit) = wall else { panic!("a wall") };
        let lamps_lx: [f64; 2] = [0, 1].map(|emitter: u32| {
            let share = lights.share_of_light_sample(&world, emitter, &place, &from);
            share * world.emitters.list()[emitter as usize].unshadowed_lx(lit.0, lit.1)
        });
        const N: u32 = 100_000;
        let second_moment = |packets_per_lx: f64| {
            let (spot, at, mut cut) = ((hit.triangle, hit.side), [lit.0, lit.1], Cut::default());
            let choices = world.choices_beside_packets(spot, at, || packets_per_lx, &mut cut);
            let probabilities = [0, 1].map(|emitter| choices.probability(emitter));
            let all: f64 = probabilities.iter().sum();
            assert!((all - 1.0).abs() < 1e-6, "{probabilities:?}");
            let sample_lx = |number: u32| {
                let variate = (f64::from(number) + 0.5) / f64::from(N);
                choices.choose(variate).map_or(0.0, |(emitter, probability)| lamps_lx[emitter as usize] / probability)
            };
            let mean_lx = (0..N).map(sample_lx).sum::<f64>() / f64::from(N);
            assert!((mean_lx / lamps_lx.iter().sum::<f64>() - 1.0).abs() < 1e-3, "{mean_lx} {lamps_lx:?}");
            lamps_lx.iter().zip(probabilities).map(|(lx, probability)| lx * lx / probability).sum::<f64>()
        };
        let [beside, alone] = [lights.packets_per_lx(&world, &place, &from), 0.0].map(second_moment);
        assert!(beside < 0.125 * alone, "{beside:?} {alone:?}");
    }
}
