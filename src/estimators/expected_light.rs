//! The light that a pilot expects of every emitter in an element, beside which samples are taken (docs/methods.md (57)).
//!
//! In most elements most emitters are seen from everywhere or from nowhere, and what they bring hardly bends. The sum of what is expected
//! of all emitters at a point then needs few corrections. A sample corrects one emitter, E(x) = Σ eₖ(x) + (lₖ(x) − eₖ(x))/pₖ. Emitter k is
//! chosen with the probability pₖ, in proportion to how far its light samples were from the expected eₖ. No probability is 0, so the mean
//! is right whatever is expected.

use serde::{Deserialize, Serialize};

use super::basis::Linear;
use super::receiver::Receiver;
use crate::sampling::random::Stream;
use crate::transport::{Traced, World};

/// Share of an emitter's unshadowed illuminance, squared, that counts as one more square of a difference: an edge of a shadow may lie
/// between the points of the pilot.
const UNSEEN_EDGE: f64 = 0.1;
/// Largest difference of light samples from even light, as a share of the unshadowed illuminance: their root mean square, and half of that of
/// a single one.
const EVEN: f64 = 0.05;
/// Least uncertainty of any emitter, as a share of the mean unshadowed illuminance of all.
const LEAST_UNCERTAINTY: f64 = 0.02;

/// Direct light of one emitter at a point of an element, sampled twice.
#[derive(Clone, Copy, Debug)]
pub struct EmitterPair {
    /// Number of the emitter.
    pub emitter: u32,
    /// Two samples of its illuminance in lx. They are independent, except for a single point, which has no randomness.
    pub samples_lx: [f64; 2],
    /// Illuminance in lx if nothing stands between.
    pub unshadowed_lx: f64,
}

impl EmitterPair {
    /// Samples an emitter twice at a point. The light of a single point has no randomness and is sampled once.
    pub fn sampled(
        world: &World,
        emitter: usize,
        receiver: &Receiver,
        stream: &mut Stream,
        rays: &mut u64,
    ) -> EmitterPair {
        let emitters = world.emitters.list();
        let view = emitters[emitter].view(receiver.point_m, receiver.normal);
        let mut unshadowed_lx = 0.0;
        let mut sample_lx = |sequence: usize| {
            stream.turn_to(sequence as u64);
            let sample = view.light_sample(stream);
            unshadowed_lx = sample.map_or(unshadowed_lx, |sample| sample.unshadowed_lx);
            let found = world.light_found(sample, receiver.origin);
            *rays += found.rays;
            found.value
        };
        let first_lx = sample_lx(emitter);
        let is_point = emitters[emitter].is_single_point();
        let second_lx = if is_point { first_lx } else { sample_lx(emitters.len() + emitter) };
        EmitterPair { emitter: emitter as u32, samples_lx: [first_lx, second_lx], unshadowed_lx }
    }

    /// Whether any light was found.
    pub fn is_lit(&self) -> bool {
        self.samples_lx.iter().any(|lx| *lx > 0.0)
    }
}

/// What a pilot found of one emitter in an element.
#[derive(Clone, Copy, Debug)]
pub struct FoundOfEmitter {
    /// Number of the emitter.
    pub emitter: u32,
    /// The linear function closest to its light samples, in lx.
    pub expected_lx: Linear,
    /// Mean square difference of a light sample from it, in lx².
    pub difference_lx2: f64,
    /// Mean of its unshadowed illuminance, in lx.
    pub unshadowed_lx: f64,
}

impl FoundOfEmitter {
    /// Whether its light samples differ little from the expected light. Such an emitter is seen from the whole element or from nowhere in it.
    pub fn is_even(&self) -> bool {
        self.difference_lx2 <= (EVEN * self.unshadowed_lx).powi(2)
    }

    /// Whether light samples at a point differ more from the expected light.
    pub fn differs_from(&self, pair: &EmitterPair, at: [f64; 2]) -> bool {
        let expected_lx = self.expected_lx.at(at);
        let most_lx = EVEN * self.unshadowed_lx.max(pair.unshadowed_lx);
        pair.samples_lx.iter().any(|lx| (lx - expected_lx).abs() > 2.0 * most_lx)
    }

    /// The light expected at a point, in place of light samples.
    pub fn expected_pair(&self, at: [f64; 2]) -> EmitterPair {
        let FoundOfEmitter { emitter, unshadowed_lx, .. } = *self;
        EmitterPair { emitter, samples_lx: [self.expected_lx.at(at); 2], unshadowed_lx }
    }

    /// The same on a piece of the element with these corners.
    pub fn on_piece(&self, corners: [[f64; 2]; 3]) -> FoundOfEmitter {
        FoundOfEmitter { expected_lx: self.expected_lx.on_piece(corners), ..*self }
    }
}

/// The light expected of all emitters in an element. Empty if no pilot has asked them one by one.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ExpectedLight {
    /// The sum over the emitters, in lx.
    sum_lx: Linear,
    emitters: Vec<ExpectedEmitter>,
}

#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct ExpectedEmitter {
    emitter: u32,
    expected_lx: Linear,
    /// Cumulative uncertainty of the emitters up to and including this one, in lx.
    cumulative_lx: f64,
}

impl ExpectedLight {
    /// The light expected after a pilot of `points` points (none if all is known from a larger element), and the mean square in lx² by which a
    /// sample beside it differs from it.
    pub fn of(found: &[FoundOfEmitter], points: usize) -> (ExpectedLight, f64) {
        let mut light = ExpectedLight { emitters: Vec::with_capacity(found.len()), ..ExpectedLight::default() };
        let unshadowed_lx: f64 = found.iter().map(|found| found.unshadowed_lx).sum();
        if unshadowed_lx <= 0.0 {
            return (ExpectedLight::default(), 0.0);
        }
        let least_lx = LEAST_UNCERTAINTY * unshadowed_lx / found.len() as f64;
        let (mut cumulative_lx, mut squares_lx) = (0.0, 0.0);
        for found in found {
            let unseen_lx2 = UNSEEN_EDGE * found.unshadowed_lx * found.unshadowed_lx / points.max(1) as f64;
            let uncertainty_lx = (found.difference_lx2 + unseen_lx2 + least_lx * least_lx).sqrt();
            squares_lx += found.difference_lx2 / uncertainty_lx;
            cumulative_lx += uncertainty_lx;
            let FoundOfEmitter { emitter, expected_lx, .. } = *found;
            light.sum_lx = light.sum_lx.plus(&expected_lx);
            light.emitters.push(ExpectedEmitter { emitter, expected_lx, cumulative_lx });
        }
        (light, squares_lx * cumulative_lx)
    }

    /// Whether nothing is expected, because no pilot has asked.
    pub fn is_empty(&self) -> bool {
        self.emitters.is_empty()
    }

    /// The same light on a piece of the element with these corners.
    pub fn on_piece(&self, corners: [[f64; 2]; 3]) -> ExpectedLight {
        let piece = |emitter: &ExpectedEmitter| ExpectedEmitter {
            expected_lx: emitter.expected_lx.on_piece(corners),
            ..*emitter
        };
        ExpectedLight { sum_lx: self.sum_lx.on_piece(corners), emitters: self.emitters.iter().map(piece).collect() }
    }

    /// One unbiased sample of the direct illuminance in lx at a point of the element, given by its weights of the second and third corner.
    /// Something must be expected.
    pub fn sample(&self, world: &World, receiver: &Receiver, at: [f64; 2], stream: &mut Stream) -> Traced {
        let all_lx = self.emitters.last().map_or(0.0, |last| last.cumulative_lx);
        let aim_lx = stream.fine_unit() * all_lx;
        let place = self.emitters.partition_point(|emitter| emitter.cumulative_lx <= aim_lx);
        let place = place.min(self.emitters.len() - 1);
        let chosen = &self.emitters[place];
        let before_lx = if place > 0 { self.emitters[place - 1].cumulative_lx } else { 0.0 };
        let emitter = &world.emitters.list()[chosen.emitter as usize];
        let light_sample = emitter.light_sample(receiver.point_m, receiver.normal, stream);
        let found = world.light_found(light_sample, receiver.origin);
        let beyond_lx = found.value - chosen.expected_lx.at(at);
        let value = self.sum_lx.at(at) + beyond_lx * all_lx / (chosen.cumulative_lx - before_lx);
        Traced { value, ..found }
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use glam::DVec3;

    use super::*;
    use crate::check::scene_from_json;
    use crate::estimators::direct::DirectPass;
    use crate::sampling::random::Purpose;

    /// A wall hides parts of two panels from the points behind it. A small lamp hangs in the open.
    const SCENE: &str = r#"{ "version": 1, "materials": { "grey": { "type": "diffuse", "reflectance": 0.5 } },
      "geometry": [ { "name": "wall", "type": "box", "min": [2,0,0], "max": [2.1,4,2], "facing": "outward", "material": "grey" },
        { "name": "one", "type": "rectangle", "origin": [0.2,0.5,3], "u": [0,1,0], "v": [1,0,0], "material": "grey" },
        { "name": "two", "type": "rectangle", "origin": [3.5,1,3], "u": [0,1,0], "v": [0.3,0,0], "material": "grey" } ],
      "luminaires": [ { "name": "a", "type": "area", "surface": "one", "luminous_flux_lm": 1000 },
        { "name": "b", "type": "area", "surface": "two", "luminous_flux_lm": 3000 },
        { "name": "c", "type": "point", "position": [1, 1, 2.5], "luminous_flux_lm": 200 } ] }"#;

    fn mean_and_error(mut sample: impl FnMut(u64) -> f64) -> (f64, f64) {
        const N: u64 = 200_000;
        let samples: Vec<f64> = (0..N).map(&mut sample).collect();
        let mean = samples.iter().sum::<f64>() / N as f64;
        let squares = samples.iter().map(|sample| (sample - mean).powi(2)).sum::<f64>();
        (mean, (squares / ((N - 1) * N) as f64).sqrt())
    }

    /// Four points from full light to shade, and expectations that are wrong at all of them. 200,000 samples beside the expected light and
    /// 200,000 passes over every lamp agree within 4.5 standard errors of their difference (α = 7e-6 each; seeds 5 and 6). Planted fault:
    /// an expected sum 3 % too high does not agree at any point.
    #[test]
    fn samples_beside_expected_light_have_the_mean_of_all_emitters() {
        let scene = scene_from_json(SCENE, None, Path::new(".")).expect("a scene");
        let world = World::new(&scene);
        let found_of = |emitter: u32| {
            let lx = 8.0 + 5.0 * f64::from(emitter);
            FoundOfEmitter {
                emitter,
                expected_lx: Linear([lx, 0.2 * lx, -0.1 * lx]),
                difference_lx2: if emitter == 1 { 200.0 } else { 4.0 },
                unshadowed_lx: 1.5 * lx,
            }
        };
        let found: Vec<FoundOfEmitter> = (0..world.emitters.list().len() as u32).map(found_of).collect();
        let (expected, _) = ExpectedLight::of(&found, 12);
        for (x, at) in [(0.4, [0.2, 0.3]), (1.8, [0.1, 0.1]), (2.3, [0.6, 0.2]), (3.4, [0.3, 0.6])] {
            let (point_m, normal) = (DVec3::new(x, 1.3, 0.3), DVec3::Z);
            let origin = world.tracer.side_origin(point_m, normal);
            let receiver = Receiver { point_m, normal, origin: &origin };
            let mut stream = Stream::new(5, Purpose::Direct, 0, 0);
            let (mean, error) = mean_and_error(|number| {
                stream.seek_quasi(number, 0, number);
                expected.sample(&world, &receiver, at, &mut stream).value
            });
            let mut stream = Stream::new(6, Purpose::Direct, 0, 0);
            let (truth, truth_error) = mean_and_error(|number| {
                stream.seek(number);
                DirectPass::default().at_point(&world, &receiver, &mut stream).value
            });
            let bound = 4.5 * error.hypot(truth_error);
            assert!((mean - truth).abs() < bound, "at {x}: {mean} {truth} ± {bound}");
            let faulty = mean + 0.03 * expected.sum_lx.at(at);
            assert!((faulty - truth).abs() > bound, "at {x}: the planted fault passed: {faulty} {truth} ± {bound}");
        }
    }

    /// Of three equal emitters two were as expected at all points of the pilot. The third, which was not, is asked four times as often as
    /// each of them. On a piece of the element it is the same.
    #[test]
    fn emitters_that_differ_from_what_is_expected_are_asked_most() {
        let found = [0, 1, 2].map(|emitter| FoundOfEmitter {
            emitter,
            expected_lx: Linear::even(10.0),
            difference_lx2: if emitter == 1 { 14.0 } else { 0.0 },
            unshadowed_lx: 10.0,
        });
        let (expected, beside_lx2) = ExpectedLight::of(&found, 12);
        for light in [expected.on_piece([[0.0, 0.0], [0.5, 0.0], [0.0, 0.5]]), expected] {
            let [first, second, third] = [0, 1, 2].map(|place| light.emitters[place].cumulative_lx);
            let shares = [first, second - first, third - second];
            assert!((shares[1] / shares[0] - 4.1).abs() < 0.1 && (shares[2] / shares[0] - 1.0).abs() < 1e-12);
            // It is asked once in about 1.5 samples, and a difference then counts 1.5 times.
            assert!((beside_lx2 / 14.0 - third / (second - first)).abs() < 0.05, "{beside_lx2}");
        }
        assert!(found[0].is_even() && !found[1].is_even());
        assert!(ExpectedLight::of(&found, 0).1.is_finite());
    }
}
