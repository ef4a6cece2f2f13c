//! Finds how much walks leave to chance in a scene. A pilot takes walks from the receivers, or from the elements if there are no receivers.
//!
//! A walk of variance V and C rays reaches an error with work V C. Suppose it continues from a vertex with weight w and probability p. This
//! costs p c of C and adds w² M/p to V. Here M is the second moment of what the rest of a walk finds, and c is its number of rays. So p = w
//! √(M C/(V c)) is best, or 1 if that is greater (Bolin and Meyer, 1997, "An error metric for Monte Carlo ray tracing"; docs/methods.md
//! (48)). The probability of a light-path connection to near luminaires follows from what each candidate would cost
//! (docs/methods.md (49)).

use glam::DVec3;

use crate::base::scattered::scattered;
use crate::estimators::cache::{Cache, CacheAnswer, Met, WalkEvent};
use crate::estimators::element::Element;
use crate::estimators::receiver::Receiver;
use crate::estimators::walk::walk_parts_lx;
use crate::sampling::emitter_tree::Cut;
use crate::sampling::random::{Purpose, Stream};
use crate::scene::Scene;
use crate::transport::{PacketConnection, Roulette, Traced, World};

/// Maximum number of points from which walks of the pilot start; walks of all points together, and the fewest at each point.
const MOST_PLACES: usize = 256;
const WALKS: usize = 1024;
const LEAST_WALKS: usize = 4;
/// Rays after which the pilot ends, if it has taken the fewest walks: in nearly white rooms each walk takes thousands.
const ENOUGH_RAYS: u64 = 50_000;
const FEWEST_WALKS: usize = 64;
/// Maximum number of surfaces that a walk meets. In a white space it would continue for long.
const MOST_SURFACES: u32 = 1000;
/// Candidate probabilities of a light-path connection. With smaller ones, scores get rare and large. (One probability at the
/// start of walks and another at later vertices took as much work in the mean of twelve rooms, and in two of them 1.4 times as much.)
const CHANCES: [f64; 3] = [1.0, 0.5, 0.25];
/// Approximate ratio of the pilot's variance to the variance of a run's walks, which are quasi-random. (Measured by the cost of other
/// probabilities of a connection in ten rooms of the proving ground: 0.3 to 5, 2.2 in the middle. If it is too low, rare scores get large.)
const QUASI_RANDOM_GAIN: f64 = 2.5;
/// Least safe weight. Variances from few walks may be far off.
const LEAST_SAFE_WEIGHT: f64 = 0.05;
/// The pilot affects results only through probabilities, so its random numbers are the same for all seeds.
const SEED: u64 = 0x52_4F55;

/// Prepares a scene for walks: [`World::new`], and what walks leave to chance there.
pub fn world_for_walks(scene: &Scene) -> World {
    let mut world = World::new(scene);
    if world.reflects() {
        world.roulette = pilot(&world, &places_of(scene, &world)).roulette();
    }
    world
}

/// Start points of the walks that matter: points of receivers spread over all sets, or the middle of elements; in m, with their normals.
fn places_of(scene: &Scene, world: &World) -> Vec<(DVec3, DVec3)> {
    let sets = scene.receivers.iter().filter(|set| set.intensity_table().is_none());
    let points = sets.flat_map(|set| set.points.iter()).filter(|point| !point.inside);
    let stride = |count: usize| count.div_ceil(MOST_PLACES).max(1);
    let count = points.clone().count();
    if count > 0 {
        return points.step_by(stride(count)).map(|point| (point.position_m, point.normal)).collect();
    }
    let middle = |index: usize| {
        let element = Element::of(world, scene, &world.elements, index as u32);
        let at = [1.0 / 3.0; 2];
        (element.point_m(world, at), element.normal_at(world, at))
    };
    (0..world.elements.len()).step_by(stride(world.elements.len())).map(middle).collect()
}

/// Takes pilot walks from these points.
fn pilot(world: &World, places: &[(DVec3, DVec3)]) -> Moments {
    let walks = (WALKS / places.len().max(1)).max(LEAST_WALKS);
    let mut stream = Stream::new(SEED, Purpose::Pilot, 0, 0);
    let mut cut = Cut::default();
    let mut seen = Moments::default();
    for place in scattered(places.len()) {
        let (point_m, normal) = &places[place];
        let origin = world.tracer.side_origin(*point_m, *normal);
        let receiver = Receiver { point_m: *point_m, normal: *normal, origin: &origin };
        let (mut sum_lx, mut squares) = (0.0, 0.0);
        for walk in 0..walks {
            stream.seek((place * walks + walk) as u64);
            let mut watch = Watch::default();
            let variates = stream.pair();
            let ([sampled_lx, arriving_lx], rays) =
                walk_parts_lx(world, &receiver, variates, &mut watch, &mut cut, &mut stream);
            let lx = sampled_lx + arriving_lx;
            sum_lx += lx;
            squares += lx * lx;
            seen.add(&watch, arriving_lx, rays);
        }
        let count = walks as f64;
        seen.variance_lx2 += (squares - sum_lx * sum_lx / count).max(0.0) * count / (count - 1.0);
        if seen.rays > ENOUGH_RAYS && seen.walks >= FEWEST_WALKS {
            break;
        }
    }
    seen
}

/// Sums over the walks of the pilot.
#[derive(Default)]
struct Moments {
    walks: usize,
    rays: u64,
    /// Variance of a walk about the mean of its point, in lx², summed over the walks.
    variance_lx2: f64,
    /// Square, in lx², and rays of the rest of each walk after the first surface from which it continued, scaled to a weight of 1 there.
    rest_lx2: f64,
    rest_rays: u64,
    /// Surfaces that walks met, and sum of the weights with which they continued. Each includes 1 for the first surface.
    goes_on: [f64; 2],
    /// Whether one of the walks was cut off, so that the squares give no information.
    is_cut: bool,
    /// Rays of the light-path connections.
    back_rays: u64,
    /// Variance that each candidate probability of a connection adds.
    added: [f64; CHANCES.len()],
}

impl Moments {
    fn add(&mut self, watch: &Watch, arriving_lx: f64, rays: u64) {
        self.walks += 1;
        self.rays += rays;
        self.goes_on.iter_mut().zip(watch.goes_on).for_each(|(sum, goes_on)| *sum += 1.0 + goes_on);
        self.is_cut |= watch.surfaces >= MOST_SURFACES;
        self.back_rays += watch.back_rays;
        self.added.iter_mut().zip(watch.added).for_each(|(sum, added)| *sum += added);
        if let Some((weight, before)) = watch.first {
            self.rest_lx2 += ((arriving_lx - before.value) / weight).powi(2);
            self.rest_rays += rays - before.rays - watch.rays_at_receiver.unwrap_or(0);
        }
    }

    /// Variance of the walks that a run will take, in lx², summed over the walks.
    fn run_variance_lx2(&self) -> f64 {
        self.variance_lx2 / QUASI_RANDOM_GAIN
    }

    /// The best settings for the walks of a run.
    fn roulette(&self) -> Roulette {
        Roulette {
            safe_weight: self.safe_weight(),
            connection_chance: self.connection_chance(),
            longer: (self.goes_on[0] / self.goes_on[1]).max(1.0),
            pilot_rays: self.rays,
        }
    }

    /// The weight √(V c/(M C)) from which on walks always continue.
    fn safe_weight(&self) -> f64 {
        let [of_walk, of_rest] = [self.run_variance_lx2() / self.rays as f64, self.rest_lx2 / self.rest_rays as f64];
        let best = (of_walk / of_rest).sqrt();
        if best.is_finite() && !self.is_cut {
            best.clamp(LEAST_SAFE_WEIGHT, 1.0)
        } else {
            Roulette::default().safe_weight
        }
    }

    /// The probability of a connection with the least work.
    fn connection_chance(&self) -> f64 {
        let work = |number: usize| {
            let saved_rays = (1.0 - CHANCES[number]) * self.back_rays as f64;
            (self.run_variance_lx2() + self.added[number]) * (self.rays as f64 - saved_rays)
        };
        let best = (0..CHANCES.len()).min_by(|a, b| work(*a).total_cmp(&work(*b)));
        best.map_or(1.0, |number| CHANCES[number])
    }
}

/// Observes a walk of the pilot.
#[derive(Default)]
struct Watch {
    /// Weight with which the walk continued from its first diffuse surface, and the light in lx that it had found before.
    first: Option<(f64, Traced)>,
    /// Rays of the light-path connection from the receiver itself.
    rays_at_receiver: Option<u64>,
    back_rays: u64,
    added: [f64; CHANCES.len()],
    /// How often the walk continued from a diffuse surface, and the sum of its weights there.
    goes_on: [f64; 2],
    /// Diffuse surfaces that the walk has met.
    surfaces: u32,
}

impl Watch {
    /// Adds, for one connection, what each probability of a connection adds to the second moment, docs/methods.md (49). Here f is lx (K +
    /// D) and its density is D.
    fn weigh(&mut self, weight: f64, found: &PacketConnection) {
        self.rays_at_receiver.get_or_insert(found.rays);
        self.back_rays += found.rays;
        let &PacketConnection { lx, met_per_m2, lit_per_m2, .. } = found;
        if lx <= 0.0 {
            return;
        }
        let both_per_m2 = met_per_m2 + lit_per_m2;
        let squares = (weight * lx * both_per_m2).powi(2) / lit_per_m2;
        for (chance, added) in CHANCES.iter().zip(&mut self.added) {
            *added += squares * (1.0 / (met_per_m2 + chance * lit_per_m2) - 1.0 / both_per_m2);
        }
    }
}

impl Cache for Watch {
    fn look_up(&mut self, _: &Met, _: &mut Cut, _: &mut Stream) -> (CacheAnswer, u64) {
        self.surfaces += 1;
        (if self.surfaces < MOST_SURFACES { CacheAnswer::Nothing } else { CacheAnswer::Stop }, 0)
    }

    fn observe(&mut self, event: &WalkEvent) {
        match *event {
            WalkEvent::GoesOn { weight, before } => {
                self.first.get_or_insert((weight, before));
                self.goes_on[0] += 1.0;
                self.goes_on[1] += weight;
            }
            WalkEvent::Connected { weight, found } => self.weigh(weight, found),
            WalkEvent::FoundNear { .. } => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::check::scene_from_json;
    use crate::estimators::walk::sample_indirect_lx;
    use crate::estimators::walks_in_a_box::EmptyBox;
    use crate::scene::Scene;

    const ROOM: EmptyBox = EmptyBox([4.0, 3.0, 2.0]);
    const LM: f64 = 1000.0;

    /// A room of one reflectance with a lamp `below_m` below its ceiling.
    fn room(reflectance: f64, below_m: f64) -> Scene {
        room_of_lamps(reflectance, &[(below_m, LM)])
    }

    /// A room of one reflectance with lamps in a row, each with its distance below the ceiling in m and its flux in lm.
    fn room_of_lamps(reflectance: f64, lamps: &[(f64, f64)]) -> Scene {
        let lamp = |(number, (below_m, lm)): (usize, &(f64, f64))| {
            let (x_m, height_m) = (1.7 + 1.6 * number as f64, ROOM.0[2] - below_m);
            format!(
                r#"{{ "name": "{number}", "type": "point", "position": [{x_m},1.3,{height_m}], "luminous_flux_lm": {lm} }}"#
            )
        };
        let lamps: Vec<String> = lamps.iter().enumerate().map(lamp).collect();
        let lamps = lamps.join(", ");
        let text = format!(
            r#"{{ "version": 1, "materials": {{ "m": {{ "type": "diffuse", "reflectance": {reflectance} }} }},
            "geometry": [ {{ "name": "r", "type": "box", "min": [0,0,0], "max": [4,3,2], "facing": "inward", "material": "m" }} ],
            "luminaires": [ {lamps} ] }}"#
        );
        scene_from_json(&text, None, Path::new(".")).expect("a valid scene")
    }

    /// Mean, variance and rays of `count` walks that start anywhere.
    fn walks(world: &World, count: u64, seed: u64) -> [f64; 3] {
        let walk =
            |receiver: &Receiver, cut: &mut Cut, stream: &mut Stream| sample_indirect_lx(world, receiver, cut, stream);
        ROOM.walks(world, (count, seed), walk)
    }

    /// Whatever is left to chance, the mean over all sides of a closed room of one reflectance is Φ ρ/(A (1 − ρ)). Three rooms,
    /// four roulettes, 40,000 walks each, α = 1e-5 each (4.4 σ), seed 7. Means that are 3% off are rejected. In the last room packets come from
    /// either of two lamps, more often from the nearer one.
    #[test]
    fn no_mean_moves() {
        let rooms: [(f64, &[(f64, f64)]); 3] =
            [(0.5, &[(0.1, LM)]), (0.8, &[(0.3, LM)]), (0.6, &[(0.1, 0.7 * LM), (0.2, 0.3 * LM)])];
        for (reflectance, lamps) in rooms {
            let scene = room_of_lamps(reflectance, lamps);
            let mut world = world_for_walks(&scene);
            assert!(lamps.len() == 1 || world.is_near(0) && world.is_near(1));
            let exact_lx = LM * reflectance / (ROOM.area_m2() * (1.0 - reflectance));
            let found = world.roulette;
            for (safe_weight, connection_chance) in
                [(1.0, 1.0), (0.1, 0.25), (0.5, 0.125), (found.safe_weight, found.connection_chance)]
            {
                world.roulette = Roulette { safe_weight, connection_chance, ..found };
                let [mean_lx, variance, _] = walks(&world, 40_000, 7);
                let sigma_lx = (variance / 40_000.0).sqrt();
                let off = |lx: f64| ((lx - exact_lx) / sigma_lx).abs();
                assert!(off(mean_lx) < 4.4, "{mean_lx} for {exact_lx} lx by {:?}", world.roulette);
                assert!(off(1.03 * mean_lx).max(off(0.97 * mean_lx)) > 4.4, "3% are not seen: {sigma_lx} lx");
            }
        }
    }

    /// The pilot predicts, from walks that always connect to packets, the variance that a lower probability of connecting adds, to 30%: 200,000
    /// walks, seed 3.
    #[test]
    fn the_pilot_predicts_what_fewer_connections_cost() {
        let scene = room(0.6, 0.15);
        let mut world = World::new(&scene);
        assert!(world.near_luminaires.is_some());
        world.roulette = Roulette { safe_weight: 1.0, ..Roulette::default() };
        let mut stream = Stream::new(3, Purpose::Pilot, 1, 0);
        let places: Vec<(DVec3, DVec3)> = (0..20_000).map(|_| ROOM.anywhere(&mut stream)).collect();
        let seen = {
            let mut sum = Moments::default();
            for some in places.chunks(MOST_PLACES) {
                let seen = pilot(&world, some);
                sum.walks += seen.walks;
                sum.added.iter_mut().zip(seen.added).for_each(|(sum, added)| *sum += added);
            }
            sum
        };
        let always = walks(&world, 200_000, 3)[1];
        for (number, chance) in CHANCES.iter().enumerate().skip(1) {
            world.roulette.connection_chance = *chance;
            let added = walks(&world, 200_000, 3)[1] - always;
            let predicted = seen.added[number] / seen.walks as f64;
            assert!((predicted / added).ln().abs() < 1.3_f64.ln(), "{predicted} predicted, {added} found, by {chance}");
        }
    }

    /// Work V C of walks with the pilot's settings, compared with walks that end at every surface by its reflectance and always connect to packets:
    /// 40,000 walks, seed 5.
    #[test]
    fn walks_take_less_work() {
        for (reflectance, below_m, share) in [(0.9, 0.4, 0.6), (0.5, 1.0, 0.9)] {
            let scene = room(reflectance, below_m);
            let mut world = world_for_walks(&scene);
            let work = |world: &World| {
                let [_, variance, rays] = walks(world, 40_000, 5);
                variance * rays
            };
            let found = work(&world);
            world.roulette = Roulette { safe_weight: 1.0, ..Roulette::default() };
            let analogue = work(&world);
            assert!(found < share * analogue, "{} of the work in a room of {reflectance}", found / analogue);
        }
    }
}
