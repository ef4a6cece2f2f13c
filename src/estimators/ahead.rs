//! What a receiver expects of every emitter before it samples direct light.
//!
//! A few looks ahead tell about which emitters a receiver sees, and which it sees in part. What they found is expected
//! from then on, and samples look for what differs from that: L = Σ cⱼ + Σ (lᵢ − cⱼ)/nⱼ, cⱼ what emitter j is expected to bring,
//! lᵢ what a look at it brought and nⱼ how many looks it gets on average. Whatever cⱼ, the mean is right; looks go where
//! doubt is left, and what stands in full light or full shade needs few. The expectation is shared by all samples of all
//! replicas: their looks are independent of it and of each other.

use super::direct::Receiver;
use crate::chain::Stage;
use crate::sampling::emitter::Emitter;
use crate::sampling::random::Stream;

/// An emitter that brings at least this share of all is looked at ahead.
const SHARE_FOR_A_LOOK: f64 = 1.0 / 400.0;
/// Looks ahead at an emitter that brought everything, and at any one at most.
const LOOKS_AHEAD: f64 = 64.0;
const MOST_LOOKS_AHEAD: f64 = 16.0;
/// Looks that both answers, in sight and hidden, count for before the first: emitters are mostly seen in full or not at all.
const PRIOR: f64 = 0.4;
/// Looks of a sample over the number of emitters among which the doubt is spread.
const LOOKS_PER_DOUBT: f64 = 0.5;
/// Doubts that are kept for all points of a receiver set together: some 50 MB.
const MOST_DOUBTS: usize = 2_000_000;

/// What a receiver expects of its emitters.
#[derive(Clone, Debug, Default)]
pub struct Expectation {
    /// All that is expected, in lx.
    sum_lx: f64,
    /// Emitters that may bring something else.
    doubts: Vec<Doubt>,
    /// Looks of a sample.
    looks: usize,
    /// Rays that it took to find all this out.
    pub rays: u64,
}

/// An emitter of which it is not certain what it brings.
#[derive(Clone, Copy, Debug)]
struct Doubt {
    emitter: u32,
    /// What is expected of it, in lx.
    expected_lx: f64,
    /// Doubt of the emitters up to and including this one, in lx.
    cumulative_lx: f64,
}

/// Expectations at the points of a receiver set, kept from pass to pass as far as there is room.
#[derive(Clone, Debug, Default)]
pub struct Expectations {
    of_points: Vec<Option<Expectation>>,
    doubts: usize,
}

impl Expectations {
    /// That of a point, if it is kept.
    pub fn of(&self, point: usize) -> Option<&Expectation> {
        self.of_points.get(point).and_then(Option::as_ref)
    }

    /// Keeps that of a point, if there is room. It is the same when it is made again.
    pub fn keep(&mut self, point: usize, expectation: Expectation) {
        if self.doubts + expectation.doubts.len() > MOST_DOUBTS {
            return;
        }
        self.doubts += expectation.doubts.len();
        self.of_points.resize(self.of_points.len().max(point + 1), None);
        self.of_points[point] = Some(expectation);
    }
}

impl Expectation {
    /// Looks ahead from a receiver, at emitters weighed by what they may bring there; the stream is one that no sample
    /// draws from.
    pub fn of(stage: &Stage, receiver: &Receiver, importance: &[f64], stream: &mut Stream) -> Expectation {
        let total: f64 = importance.iter().sum();
        let mut expectation = Expectation::default();
        let (mut doubt_lx, mut squares_lx2) = (0.0, 0.0);
        for (number, (emitter, importance)) in stage.emitters.list().iter().zip(importance).enumerate() {
            if *importance <= 0.0 {
                continue;
            }
            let share = importance / total;
            let (expected_lx, own_doubt_lx) = if share >= SHARE_FOR_A_LOOK {
                let count = (LOOKS_AHEAD * share).ceil().min(MOST_LOOKS_AHEAD) as u64;
                expectation.ask(stage, receiver, emitter, *importance, number as u64, count, stream)
            } else {
                (0.0, *importance)
            };
            expectation.sum_lx += expected_lx;
            if own_doubt_lx > 0.0 {
                doubt_lx += own_doubt_lx;
                squares_lx2 += own_doubt_lx * own_doubt_lx;
                expectation.doubts.push(Doubt { emitter: number as u32, expected_lx, cumulative_lx: doubt_lx });
            }
        }
        if doubt_lx > 0.0 {
            expectation.looks = (LOOKS_PER_DOUBT * doubt_lx * doubt_lx / squares_lx2).ceil().max(1.0) as usize;
        }
        expectation
    }

    /// What some looks at an emitter let expect of it, and the standard deviation of another look, both in lx.
    #[allow(clippy::too_many_arguments)]
    fn ask(
        &mut self,
        stage: &Stage,
        receiver: &Receiver,
        emitter: &Emitter,
        importance: f64,
        number: u64,
        count: u64,
        stream: &mut Stream,
    ) -> (f64, f64) {
        let is_certain = emitter.is_single_point();
        let count = if is_certain { 1 } else { count };
        let (mut sum_lx, mut squares_lx2, mut seen) = (0.0, 0.0, 0.0);
        for look in 0..count {
            stream.seek_quasi(number, number, look);
            if let Some(look) = emitter.look(receiver.point_m, receiver.normal, stream) {
                self.rays += 1;
                let share = stage.seen_share(&look, receiver.origin);
                let lx = look.unshadowed_lx * share;
                sum_lx += lx;
                squares_lx2 += lx * lx;
                seen += f64::from(u8::from(share > 0.0));
            }
        }
        let count = count as f64;
        let mean_lx = sum_lx / count;
        if is_certain {
            return (mean_lx, 0.0);
        }
        let scatter_lx2 = (squares_lx2 / count - mean_lx * mean_lx).max(0.0);
        let seen_share = (seen + PRIOR) / (count + 2.0 * PRIOR);
        (mean_lx, (importance * importance * seen_share * (1.0 - seen_share)).max(scatter_lx2).sqrt())
    }

    /// One unbiased sample of the direct illuminance in lx, and the rays it took.
    pub fn sample(&self, stage: &Stage, receiver: &Receiver, stream: &mut Stream) -> (f64, u64) {
        let (mut sum_lx, mut rays) = (self.sum_lx, 0);
        let Some(last) = self.doubts.last() else {
            return (sum_lx, rays);
        };
        let step_lx = last.cumulative_lx / self.looks as f64;
        let first = stream.fine_unit();
        let (mut place, mut before_lx, mut again) = (0, 0.0, 0);
        for look in 0..self.looks {
            let aim_lx = (first + look as f64) * step_lx;
            while self.doubts[place].cumulative_lx <= aim_lx && place + 1 < self.doubts.len() {
                before_lx = self.doubts[place].cumulative_lx;
                place += 1;
                again = 0;
            }
            let doubt = &self.doubts[place];
            stream.turn_to((again << 32) | u64::from(doubt.emitter));
            again += 1;
            let look = stage.emitters.list()[doubt.emitter as usize].look(receiver.point_m, receiver.normal, stream);
            let found_lx = look.map_or(0.0, |look| {
                rays += 1;
                look.unshadowed_lx * stage.seen_share(&look, receiver.origin)
            });
            sum_lx += (found_lx - doubt.expected_lx) * step_lx / (doubt.cumulative_lx - before_lx);
        }
        (sum_lx, rays)
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use glam::DVec3;

    use super::*;
    use crate::estimators::direct::DirectPass;
    use crate::sampling::random::Purpose;
    use crate::scene::scene_from_json;

    /// A wall hides parts of shining panels from the points behind it; a small lamp hangs in the open.
    const SCENE: &str = r#"{ "version": 1, "materials": { "grey": { "type": "diffuse", "reflectance": 0.5 } },
      "geometry": [ { "name": "wall", "type": "box", "min": [2,0,0], "max": [2.1,4,2], "facing": "outward", "material": "grey" },
        { "name": "one", "type": "rectangle", "origin": [0.2,0.5,3], "u": [0,1,0], "v": [1,0,0], "material": "grey" },
        { "name": "two", "type": "rectangle", "origin": [1.7,2,3], "u": [0,1,0], "v": [1.2,0,0], "material": "grey" },
        { "name": "three", "type": "rectangle", "origin": [3.5,1,3], "u": [0,1,0], "v": [0.3,0,0], "material": "grey" } ],
      "luminaires": [ { "name": "a", "type": "area", "surface": "one", "luminous_flux_lm": 1000 },
        { "name": "b", "type": "area", "surface": "two", "luminous_flux_lm": 700 },
        { "name": "c", "type": "area", "surface": "three", "luminous_flux_lm": 3000 },
        { "name": "d", "type": "point", "position": [1, 1, 2.5], "luminous_flux_lm": 200 } ] }"#;

    fn mean_and_error(samples: &[f64]) -> (f64, f64) {
        let count = samples.len() as f64;
        let mean = samples.iter().sum::<f64>() / count;
        let squares = samples.iter().map(|sample| (sample - mean).powi(2)).sum::<f64>();
        (mean, (squares / (count - 1.0) / count).sqrt())
    }

    /// Seven points from full light through penumbra to shade: 20,000 samples by expectation and 20,000 passes over every
    /// lamp agree within 4.5 standard errors of their difference (α = 7e-6 each; seeds 5 and 6). An expectation that counts
    /// 3% too much (the planted fault) does not, where it is in doubt. In the mean over the points samples scatter less than passes that
    /// take as many rays.
    #[test]
    fn samples_by_expectation_have_the_mean_of_looks_at_every_lamp() {
        const N: u64 = 20_000;
        let scene = scene_from_json(SCENE, None, Path::new(".")).expect("a scene");
        let stage = Stage::new(&scene);
        let mut pass = DirectPass::default();
        let (mut by_expectation, mut by_passes) = (0.0, 0.0);
        for x in [0.4, 1.0, 1.5, 1.8, 2.3, 2.7, 3.4] {
            let (point_m, normal) = (DVec3::new(x, 1.3, 0.3), DVec3::Z);
            let origin = stage.tracer.side_origin(point_m, normal);
            let receiver = Receiver { point_m, normal, origin: &origin };
            let expectation = pass.expect(&stage, &receiver);
            let sampled = |seed: u64, sample: &mut dyn FnMut(&mut Stream) -> (f64, u64)| {
                let mut stream = Stream::new(seed, Purpose::Direct, 0, 0);
                let mut rays = 0;
                let samples: Vec<f64> = (0..N)
                    .map(|index| {
                        stream.seek(index);
                        let (lx, sample_rays) = sample(&mut stream);
                        rays += sample_rays;
                        lx
                    })
                    .collect();
                (mean_and_error(&samples), rays as f64 / N as f64)
            };
            let ((mean, error), rays) = sampled(5, &mut |stream| expectation.sample(&stage, &receiver, stream));
            let ((truth, truth_error), pass_rays) = sampled(6, &mut |stream| pass.at_point(&stage, &receiver, stream));
            let bound = 4.5 * error.hypot(truth_error) + 1e-9 * truth;
            assert!((mean - truth).abs() < bound, "at {x}: {mean} {truth} ± {error} {truth_error}");
            assert!((mean + 0.03 * expectation.sum_lx - truth).abs() > bound, "at {x}: the planted fault passed");
            by_expectation += error * error * rays;
            by_passes += truth_error * truth_error * pass_rays;
        }
        assert!(by_expectation < by_passes, "{by_expectation} {by_passes}");
    }

    /// A point lamp leaves no doubt: samples take no rays and say what a look says.
    #[test]
    fn what_points_bring_is_known_from_one_look() {
        let text = r#"{ "version": 1, "materials": { "grey": { "type": "diffuse", "reflectance": 0.5 } },
          "geometry": [ { "name": "floor", "type": "rectangle", "origin": [0,0,0], "u": [4,0,0], "v": [0,4,0], "material": "grey" } ],
          "luminaires": [ { "name": "a", "type": "point", "position": [1, 1, 2], "luminous_flux_lm": 1256.6370614359173 } ] }"#;
        let scene = scene_from_json(text, None, Path::new(".")).expect("a scene");
        let stage = Stage::new(&scene);
        let (point_m, normal) = (DVec3::new(1.0, 1.0, 1.0), DVec3::Z);
        let origin = stage.tracer.side_origin(point_m, normal);
        let receiver = Receiver { point_m, normal, origin: &origin };
        let expectation = DirectPass::default().expect(&stage, &receiver);
        let (lx, rays) = expectation.sample(&stage, &receiver, &mut Stream::new(0, Purpose::Direct, 0, 0));
        assert!((lx - 100.0).abs() < 1e-9 && rays == 0, "{lx} lx by {rays} rays");
    }
}
