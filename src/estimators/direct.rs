//! Direct light: exact where nothing is in between, sampled in visibility where something may be (docs/methods.md (2)).

use glam::DVec3;

use super::control_variate::{ControlVariate, SHARE_FOR_A_LIGHT_SAMPLE};
use super::element::Element;
use super::expected_light::{EmitterPair, ExpectedLight};
use super::receiver::Receiver;
use crate::sampling::emitter::{Emitter, LightSample};
use crate::sampling::emitter_tree::Cut;
use crate::sampling::opening::OpeningPoint;
use crate::sampling::random::{Purpose, Stream};
use crate::sampling::triangle::SeenTriangle;
use crate::scene::Side;
use crate::transport::{HIDDEN, LightInSight, Traced, TriangleSide, World};

/// Up to this number, each emitter gets a light sample in every pass, at a receiver and at a glossy sub-point that an eye sees. If there
/// are more emitters, a stratified choice represents all.
pub const MOST_EACH: usize = 24;
/// Share of the bound of an emitter's illuminance that is added to its unshadowed illuminance.
const SHARE_OF_BOUND: f64 = 0.05;
/// Share of all light samples of a pass at a receiver that goes to any emitter, bright or dim. The bright ones may be hidden.
const SHARE_FOR_ANY: f64 = 0.01;
/// Maximum number of light samples that find the luminaires visible from a point, before the others get less weight.
const MOST_SURVEY_SAMPLES: u64 = 256;
/// Number of a point's stream for its control variate. Number 0 finds the visible luminaires.
const CONTROL_VARIATE: u32 = 1;
/// Light samples of one pass at an element if emitters are chosen. It is small since there are many elements.
const SAMPLES_OVER_ELEMENT: usize = 6;

/// Scratch space for one pass over the emitters, so that a pass allocates nothing.
#[derive(Clone, Debug, Default)]
pub struct DirectPass {
    importance: Vec<f64>,
    total: f64,
    /// Emitters that a light sample found hidden beforehand.
    hidden: Vec<u32>,
    cut: Cut,
}

/// Direct light at a random point of an element, sampled twice.
#[derive(Clone, Copy, Debug)]
pub struct SamplePair {
    /// The point: the weights of the element's second and third corner.
    pub at: [f64; 2],
    /// Two samples of the direct illuminance there in lx. They are independent except for the point.
    pub samples_lx: [f64; 2],
    /// Rays of both samples.
    pub rays: u64,
}

impl DirectPass {
    /// One unbiased sample of the direct illuminance at a point in lx, and the number of rays.
    ///
    /// Every emitter gives its exact unshadowed illuminance times the visibility of one of its points. The point is drawn in proportion to
    /// its illuminance.
    pub fn at_point(&mut self, world: &World, receiver: &Receiver, stream: &mut Stream) -> Traced {
        let mut sum_lx = 0.0;
        let rays = self.parts_at_point(world, receiver, stream, |lx, _| sum_lx += lx);
        Traced { value: sum_lx, rays }
    }

    /// The same part by part. Each part comes with its light sample. Returns the number of rays.
    pub fn parts_at_point(
        &mut self,
        world: &World,
        receiver: &Receiver,
        stream: &mut Stream,
        mut found: impl FnMut(f64, &LightSample),
    ) -> u64 {
        if world.emitters.list().len() > MOST_EACH {
            let survey_rays = self.weigh_at(world, receiver);
            return survey_rays + self.sample_most(world, receiver, stream, found);
        }
        let mut rays = 0;
        for (number, emitter) in world.emitters.list().iter().enumerate() {
            stream.turn_to(number as u64);
            if let Some(sample) = emitter.light_sample(receiver.point_m, receiver.normal, stream) {
                found(sample.unshadowed_lx * world.seen_share(&sample, receiver.origin), &sample);
                rays += 1;
            }
        }
        rays
    }

    /// The control variate of a point, for any number of samples there (docs/methods.md, section 2). An emitter that gives all of the light
    /// there gets `survey_samples` light samples, the others get their shares of that.
    pub fn control_variate(&mut self, world: &World, receiver: &Receiver, survey_samples: f64) -> ControlVariate {
        let rays = self.weigh_at(world, receiver);
        let mut stream = stream_of_place(receiver, CONTROL_VARIATE);
        let mut control_variate = ControlVariate::of(world, receiver, &self.importance, survey_samples, &mut stream);
        control_variate.rays += rays;
        control_variate
    }

    /// Weights the emitters for a point by their unshadowed illuminance. Returns the number of rays.
    ///
    /// An opening counts as its centre, which may lie below the horizon while parts of it do not. A share of the bound keeps these parts
    /// possible.
    fn weigh_at(&mut self, world: &World, receiver: &Receiver) -> u64 {
        let (point_m, normal) = (receiver.point_m, receiver.normal);
        self.weigh(world, |emitter| {
            let bound = emitter.importance_lx(point_m, normal);
            if bound > 0.0 { emitter.unshadowed_lx(point_m, normal) + SHARE_OF_BOUND * bound } else { 0.0 }
        });
        let rays = self.weigh_hidden_less(world, receiver);
        let total: f64 = self.importance.iter().sum();
        let any = SHARE_FOR_ANY * total / self.importance.len() as f64;
        self.importance.iter_mut().filter(|importance| **importance > 0.0).for_each(|importance| *importance += any);
        self.total = self.importance.iter().sum();
        rays
    }

    /// Searches for visible luminaires, strong ones first, until the rest is small beside them. If nearly all unshadowed light is hidden,
    /// the hidden luminaires together get no more weight than all others. Returns the number of rays.
    fn weigh_hidden_less(&mut self, world: &World, receiver: &Receiver) -> u64 {
        let mut stream = stream_of_place(receiver, 0);
        self.hidden.clear();
        let place = [receiver.point_m, receiver.normal];
        let enough = |found: &LightInSight| {
            let is_seen =
                if found.is_mostly_hidden() { found.has_little_rest() } else { found.rest_lx <= found.seen_lx };
            found.rays >= MOST_SURVEY_SAMPLES || is_seen
        };
        let mut note_hidden = |index: u32, lx: f64| {
            if lx <= 0.0 {
                self.hidden.push(index);
            }
        };
        let found = world.light_samples_around(receiver.origin, place, &mut stream, &mut note_hidden, &enough);
        let weight_of = |indices: &[u32]| indices.iter().map(|index| self.importance[*index as usize]).sum::<f64>();
        let (weight_hidden, weight) = (weight_of(&self.hidden), self.total);
        let others = weight - weight_hidden;
        if others > 0.0 && weight_hidden > HIDDEN * weight {
            let scale = others / weight_hidden;
            self.hidden.iter().for_each(|index| self.importance[*index as usize] *= scale);
        }
        found.rays
    }

    /// One unbiased sample of the direct illuminance in lx at a point on a side of a triangle, from `count` light samples. They are equal
    /// steps through the probabilities that walks use for their choice.
    pub fn chosen_samples(
        &mut self,
        world: &World,
        spot: TriangleSide,
        receiver: &Receiver,
        count: usize,
        stream: &mut Stream,
    ) -> Traced {
        let first = stream.fine_unit();
        let (point_m, normal) = (receiver.point_m, receiver.normal);
        let choices = world.choices(spot, point_m, normal, &mut self.cut);
        let mut sum = Traced::default();
        for step in 0..count {
            let variate = (first + step as f64) / count as f64;
            let Some((index, probability)) = choices.choose(variate) else {
                continue;
            };
            stream.turn_to((u64::from(index) << 32) | step as u64);
            if let Some(sample) = world.emitters.list()[index as usize].light_sample(point_m, normal, stream) {
                sum.value += sample.unshadowed_lx / probability * world.seen_share(&sample, receiver.origin);
                sum.rays += 1;
            }
        }
        sum / count as f64
    }

    fn weigh(&mut self, world: &World, weight: impl Fn(&Emitter) -> f64) {
        self.importance.clear();
        self.importance.extend(world.emitters.list().iter().map(weight));
        self.total = self.importance.iter().sum();
    }

    /// Takes one light sample of every emitter with a sufficient share of the importance. The others are sampled by equal steps through
    /// their cumulative importance, so none is ever left out. A point with all important emitters fully visible or fully hidden has no
    /// randomness.
    fn sample_most(
        &self,
        world: &World,
        receiver: &Receiver,
        stream: &mut Stream,
        mut found: impl FnMut(f64, &LightSample),
    ) -> u64 {
        let step = self.total * SHARE_FOR_A_LIGHT_SAMPLE;
        let mut next = stream.fine_unit() * step;
        let mut before = 0.0;
        let mut rays = 0;
        for (number, (emitter, importance)) in world.emitters.list().iter().zip(&self.importance).enumerate() {
            let weight = if *importance >= step {
                1.0
            } else {
                before += importance;
                if next >= before {
                    continue;
                }
                next += step;
                step / importance
            };
            stream.turn_to(number as u64);
            if let Some(sample) = emitter.light_sample(receiver.point_m, receiver.normal, stream) {
                found(sample.unshadowed_lx * weight * world.seen_share(&sample, receiver.origin), &sample);
                rays += 1;
            }
        }
        rays
    }

    /// One unbiased sample of the mean direct illuminance of an element side in lx, and the number of rays.
    ///
    /// A point emitter uses the exact solid angle of a flat element, Ē = I Ω/A. For all other emitters, and on smooth bodies, a point is
    /// drawn uniformly in the element.
    pub fn over_element(&mut self, world: &World, element: &Element, stream: &mut Stream) -> Traced {
        if world.is_unlit(element.spot()) {
            return Traced::default();
        }
        if world.emitters.list().len() <= MOST_EACH {
            let mut sum = Traced::default();
            for emitter in world.emitters.list() {
                let point = if element.is_curved() { None } else { emitter.draw_point(stream) };
                let brought_lx = match point {
                    Some(point) => point_over_element(world, emitter, &point, element, stream),
                    None => {
                        let at = element.draw(world, stream);
                        let (point_m, normal) = (element.point_m(world, at), element.normal_at(world, at));
                        emitter.light_sample(point_m, normal, stream).map(|sample| {
                            let origin = element.origin(world, at);
                            let receiver = Receiver { point_m, normal, origin: &origin };
                            sample.unshadowed_lx * world.seen_share(&sample, receiver.origin)
                        })
                    }
                };
                sum.rays += u64::from(brought_lx.is_some());
                sum.value += brought_lx.unwrap_or(0.0);
            }
            return sum;
        }
        let at = element.draw(world, stream);
        let origin = element.origin(world, at);
        self.chosen_samples(world, element.spot(), &element.receiver(world, at, &origin), SAMPLES_OVER_ELEMENT, stream)
    }

    /// Two samples of the direct light at a random point of an element that is not hidden by contact, beside the light expected there.
    pub fn sample_twice(
        &mut self,
        world: &World,
        element: &Element,
        expected: &ExpectedLight,
        stream: &mut Stream,
    ) -> SamplePair {
        let (at, rays) = element.draw_contact_free(world, stream);
        let seen = if expected.is_empty() {
            self.sample_twice_at(world, element, at, stream)
        } else {
            let origin = element.origin(world, at);
            let receiver = element.receiver(world, at, &origin);
            let [one, other] = [0, 1].map(|sequence| {
                stream.turn_to(sequence);
                expected.sample(world, &receiver, at, stream)
            });
            SamplePair { at, samples_lx: [one.value, other.value], rays: one.rays + other.rays }
        };
        SamplePair { rays: seen.rays + rays, ..seen }
    }

    /// Two samples of the direct light at a point of an element.
    pub fn sample_twice_at(
        &mut self,
        world: &World,
        element: &Element,
        at: [f64; 2],
        stream: &mut Stream,
    ) -> SamplePair {
        let origin = element.origin(world, at);
        let (samples_lx, rays) = self.twice(world, element.spot(), &element.receiver(world, at, &origin), stream);
        SamplePair { at, samples_lx, rays }
    }

    /// Two unbiased samples of the direct illuminance in lx at a point on a side of a triangle, and the rays of both.
    ///
    /// The light of point emitters has no randomness and is sampled once.
    fn twice(
        &mut self,
        world: &World,
        spot: TriangleSide,
        receiver: &Receiver,
        stream: &mut Stream,
    ) -> ([f64; 2], u64) {
        if world.is_unlit(spot) {
            return ([0.0; 2], 0);
        }
        let emitters = world.emitters.list();
        if emitters.len() > MOST_EACH {
            let one = self.chosen_samples(world, spot, receiver, SAMPLES_OVER_ELEMENT, stream);
            let other = self.chosen_samples(world, spot, receiver, SAMPLES_OVER_ELEMENT, stream);
            return ([one.value, other.value], one.rays + other.rays);
        }
        let mut sums_lx = [0.0; 2];
        let mut rays = 0;
        for emitter in 0..emitters.len() {
            let pair = EmitterPair::sampled(world, emitter, receiver, stream, &mut rays);
            sums_lx.iter_mut().zip(pair.samples_lx).for_each(|(sum_lx, lx)| *sum_lx += lx);
        }
        (sums_lx, rays)
    }
}

/// A stream of the point's own. No sample of a run is drawn from it.
fn stream_of_place(receiver: &Receiver, what_for: u32) -> Stream {
    let bits = receiver.point_m.to_array().iter().fold(0u64, |bits, m| bits.rotate_left(21) ^ m.to_bits());
    let mut stream = Stream::new(bits, Purpose::Pilot, what_for, 0);
    stream.seek(bits);
    stream
}

/// A light sample of one emitter from a vertex of a walk.
pub struct Sight<'a> {
    /// The emitter.
    pub emitter: &'a Emitter,
    /// Number of the emitter.
    pub index: u32,
    /// Probability with which the emitter was chosen.
    pub probability: f64,
    /// Illuminance in lx without occlusion.
    pub unshadowed_lx: f64,
    /// Share of that illuminance that arrives.
    pub transmittance: f64,
    /// Unit direction to the sampled point.
    pub towards: DVec3,
}

impl Sight<'_> {
    /// One unbiased sample of the direct illuminance in lx.
    #[inline]
    pub fn direct_lx(&self) -> f64 {
        self.unshadowed_lx / self.probability * self.transmittance
    }
}

/// How a point of a single emitter is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SampleCost {
    /// By any distribution that is cheap.
    Cheap,
    /// In proportion to its illuminance. Required if light samples are weighted by their density.
    Full,
}

/// A light sample of a single emitter from a point on a side of a triangle, chosen about in proportion to its illuminance. For the vertices
/// of walks. `None` if the choice contributes nothing; otherwise it took one ray.
#[inline]
pub fn one_light_sample<'a>(
    world: &'a World,
    spot: TriangleSide,
    receiver: &Receiver,
    cost: SampleCost,
    cut: &mut Cut,
    stream: &mut Stream,
) -> Option<Sight<'a>> {
    one_light_sample_beside_packets(world, spot, receiver, (cost, || 0.0), cut, stream)
}

/// The same where light of near luminaires is also found by packets: see [`World::choices_beside_packets`].
#[inline]
pub fn one_light_sample_beside_packets<'a>(
    world: &'a World,
    spot: TriangleSide,
    receiver: &Receiver,
    (cost, packets_per_lx): (SampleCost, impl FnOnce() -> f64),
    cut: &mut Cut,
    stream: &mut Stream,
) -> Option<Sight<'a>> {
    let place = [receiver.point_m, receiver.normal];
    let choices = world.choices_beside_packets(spot, place, packets_per_lx, cut);
    // If there is no choice, the better coordinates are left for the following draws.
    let variate = if choices.has_choice() { stream.fine_unit() } else { 0.0 };
    light_sample_of(world, choices.choose(variate)?, receiver, cost, stream)
}

/// The same of an emitter that was chosen with a known probability.
#[inline]
pub fn light_sample_of<'a>(
    world: &'a World,
    (index, probability): (u32, f64),
    receiver: &Receiver,
    cost: SampleCost,
    stream: &mut Stream,
) -> Option<Sight<'a>> {
    let emitter = &world.emitters.list()[index as usize];
    let sample = match cost {
        SampleCost::Cheap => emitter.cheap_light_sample(receiver.point_m, receiver.normal, stream)?,
        SampleCost::Full => emitter.light_sample(receiver.point_m, receiver.normal, stream)?,
    };
    let mut sight = Sight {
        emitter,
        index,
        probability,
        unshadowed_lx: sample.unshadowed_lx,
        transmittance: 0.0,
        towards: receiver.normal,
    };
    if let Some(place) = sample.place {
        let origin = world.origin(&place);
        sight.transmittance = world.transmittance(receiver.origin, &origin);
        sight.towards = (world.tracer.position_m(&origin) - receiver.point_m).normalize_or(receiver.normal);
    }
    Some(sight)
}

/// Mean illuminance that a point emitter gives an element: its intensity towards a point drawn by solid angle, times Ω/A, times visibility.
/// `None` if the element faces away.
fn point_over_element(
    world: &World,
    emitter: &Emitter,
    point: &OpeningPoint,
    element: &Element,
    stream: &mut Stream,
) -> Option<f64> {
    let [a, b, c] = element.corners_m;
    let [a, b, c] = [a - point.position_m, b - point.position_m, c - point.position_m];
    let facing = -(b - a).cross(c - a).dot(a);
    let side = element.id.side;
    if (side == Side::Front && facing <= 0.0) || (side == Side::Back && facing >= 0.0) {
        return None;
    }
    let seen = SeenTriangle::new([a, b, c]);
    let (direction, barycentric) = seen.draw(stream)?;
    let intensity_cd = emitter.intensity_from_cd(point, direction);
    if intensity_cd <= 0.0 {
        return None;
    }
    let source = world.origin(&emitter.place_of_point(point.position_m));
    let seen_share = world.transmittance(&element.origin(world, barycentric), &source);
    Some(intensity_cd * seen.solid_angle_sr() / element.area_m2 * seen_share)
}
