//! Samples of the direct light of one element by the pilot of a map whose elements adapt.

use nalgebra::{Matrix3, Vector3};

use crate::estimators::basis::{Linear, slopes_at};
use crate::estimators::direct::{DirectPass, MOST_EACH};
use crate::estimators::element::Element;
use crate::estimators::expected_light::{EmitterPair, ExpectedLight, FoundOfEmitter};
use crate::sampling::random::{Purpose, Stream};
use crate::solver::context::Context;

/// Among so many points one asks every emitter. The others ask those that brought no even light to the parent.
const POINTS_TO_ASK_ALL: usize = 4;

/// Findings of the pilot on an element's direct light.
#[derive(Clone, Copy, Debug, Default)]
pub struct DirectSamples {
    /// Points that were sampled, 0 at first.
    pub points: usize,
    /// Share of the points that is not hidden by contact.
    pub contact_free: f64,
    /// Mean of the samples, in lx.
    pub mean_lx: f64,
    /// The linear function closest to them, in lx.
    pub fitted_lx: Linear,
    /// Mean square of what that function leaves out, in lx². It may be below 0 by random error.
    pub left_lx2: f64,
    /// Variance of a point's mean of both samples about that function, in lx².
    pub scatter_lx2: f64,
}

impl DirectSamples {
    /// The reference for samples. If points are left out it is constant, since a slope would not have its mean over the remaining points.
    pub fn reference_lx(&self) -> Linear {
        if self.contact_free < 1.0 { Linear::even(self.mean_lx) } else { self.fitted_lx }
    }

    pub fn slope_lx2(&self) -> f64 {
        let Linear([_, first_lx, second_lx]) = self.fitted_lx;
        first_lx * first_lx + second_lx * second_lx
    }

    pub fn lost_lx2(&self, sloped: bool) -> f64 {
        self.left_lx2 + if sloped { 0.0 } else { self.slope_lx2() }
    }
}

/// An element that the pilot samples.
pub struct PilotedElement<'a> {
    pub context: &'a Context<'a>,
    pub element: Element,
    /// Its number among the elements of this round.
    pub index: u64,
    /// Round of the pilot.
    pub round: u32,
}

/// What the points of an element showed.
#[derive(Default)]
struct SeenPoints {
    /// Points that are not hidden by contact: the weights of the second and third corner.
    points: Vec<[f64; 2]>,
    /// Two samples of each of them, in lx.
    samples_lx: Vec<[f64; 2]>,
    /// The parts of every emitter, point by point, if each was asked by itself.
    of_emitters: Vec<EmitterPair>,
    rays: u64,
}

impl PilotedElement<'_> {
    /// Samples `points` random points. Returns the findings, what was found of each emitter, and the rays. `before` is what was found of
    /// the emitters in the parent.
    pub fn sampled(&self, points: usize, before: &[FoundOfEmitter]) -> (DirectSamples, Vec<FoundOfEmitter>, u64) {
        let world = self.context.world;
        let asks_each = world.emitters.list().len() <= MOST_EACH && !world.is_unlit(self.element.spot());
        let seen = if asks_each { self.of_each(points, before) } else { self.of_all(points) };
        let contact_free = seen.points.len() as f64 / points as f64;
        let mut samples = DirectSamples { points, contact_free, ..DirectSamples::default() };
        let Some(fit) = PointFit::at(seen.points.iter().copied()) else {
            return (samples, Vec::new(), seen.rays);
        };
        let fitted = fit.of(seen.samples_lx.iter().copied());
        samples.mean_lx = seen.samples_lx.iter().flatten().sum::<f64>() / (2 * seen.points.len()) as f64;
        (samples.fitted_lx, samples.left_lx2) = (fitted.linear_lx, fitted.product_lx2);
        let found = fit.of_emitters(&seen.of_emitters, contact_free == 1.0);
        let of_a_sample_lx2 = if found.is_empty() { fitted.square_lx2 } else { ExpectedLight::of(&found, points).1 };
        samples.scatter_lx2 = 0.5 * (of_a_sample_lx2 + fitted.product_lx2).max(0.0);
        (samples, found, seen.rays)
    }

    fn stream(&self) -> Stream {
        Stream::new(self.context.seed, Purpose::Pilot, u32::MAX - self.round, 0)
    }

    fn seek(&self, point: usize, stream: &mut Stream) {
        stream.seek_quasi((self.index << 32) | point as u64, self.index, point as u64);
    }

    /// Samples all emitters together.
    fn of_all(&self, points: usize) -> SeenPoints {
        let (world, mut stream) = (self.context.world, self.stream());
        let (mut seen, mut pass) = (SeenPoints::default(), DirectPass::default());
        for point in 0..points {
            self.seek(point, &mut stream);
            let at = self.element.draw(world, &mut stream);
            let pair = pass.sample_twice_at(world, &self.element, at, &mut stream);
            seen.rays += pair.rays;
            if self.is_free(pair.samples_lx, at, &mut stream, &mut seen.rays) {
                seen.points.push(at);
                seen.samples_lx.push(pair.samples_lx);
            }
        }
        seen
    }

    /// Samples emitters one by one. Those whose light was even in the parent are asked at few points, unless they bring something else there.
    fn of_each(&self, points: usize, before: &[FoundOfEmitter]) -> SeenPoints {
        let (world, mut stream) = (self.context.world, self.stream());
        let emitters = world.emitters.list().len();
        let mut is_asked: Vec<bool> =
            (0..emitters).map(|emitter| before.get(emitter).is_none_or(|found| !found.is_even())).collect();
        let mut seen = SeenPoints::default();
        let mut origins = Vec::new();
        let mut missing: Vec<(usize, usize, usize)> = Vec::new();
        for point in 0..points {
            self.seek(point, &mut stream);
            let at = self.element.draw(world, &mut stream);
            let origin = self.element.origin(world, at);
            let receiver = self.element.receiver(world, at, &origin);
            let asks_all = point % POINTS_TO_ASK_ALL == 0;
            let mut ask = |emitter| EmitterPair::sampled(world, emitter, &receiver, &mut stream, &mut seen.rays);
            let mut pairs: Vec<Option<EmitterPair>> =
                (0..emitters).map(|emitter| (asks_all || is_asked[emitter]).then(|| ask(emitter))).collect();
            // Expected light says nothing of contact.
            if !pairs.iter().flatten().any(EmitterPair::is_lit) {
                pairs.iter_mut().enumerate().for_each(|(emitter, pair)| *pair = pair.or_else(|| Some(ask(emitter))));
            }
            let sums_lx = sums_lx(pairs.iter().flatten());
            if !self.is_free(sums_lx, at, &mut stream, &mut seen.rays) {
                continue;
            }
            for (emitter, pair) in pairs.into_iter().enumerate() {
                let pair = match pair {
                    Some(pair) => {
                        let is_other = |found: &FoundOfEmitter| found.differs_from(&pair, at);
                        is_asked[emitter] |= before.get(emitter).is_some_and(is_other);
                        pair
                    }
                    None => {
                        missing.push((emitter, seen.of_emitters.len(), point));
                        before[emitter].expected_pair(at)
                    }
                };
                seen.of_emitters.push(pair);
            }
            seen.points.push(at);
            origins.push(origin);
        }
        for (emitter, place, point) in missing {
            if is_asked[emitter] {
                let number = place / emitters;
                let receiver = self.element.receiver(world, seen.points[number], &origins[number]);
                self.seek(point, &mut stream);
                seen.of_emitters[place] = EmitterPair::sampled(world, emitter, &receiver, &mut stream, &mut seen.rays);
            }
        }
        let of_points = seen.of_emitters.chunks(emitters.max(1));
        seen.samples_lx = of_points.map(|pairs| sums_lx(pairs.iter())).collect();
        seen
    }

    /// Whether a point is not hidden by contact. A point that receives light is not.
    fn is_free(&self, samples_lx: [f64; 2], at: [f64; 2], stream: &mut Stream, rays: &mut u64) -> bool {
        if samples_lx.iter().any(|lx| *lx > 0.0) {
            return true;
        }
        let (in_contact, tested_rays) = self.element.is_in_contact(self.context.world, at, stream);
        *rays += tested_rays;
        !in_contact
    }
}

/// Fits linear functions to pairs of samples at random points by least squares.
/// The two samples of a point are fitted separately. So the product of their residuals contains no random error of either sample, and
/// is 0 on average where the light is linear.
struct PointFit {
    rows: Vec<Vector3<f64>>,
    inverse: Matrix3<f64>,
}

/// A linear function fitted to pairs of samples.
struct FittedPairs {
    linear_lx: Linear,
    /// Mean product of what it leaves of both samples, in lx². It may be below 0 by random error.
    product_lx2: f64,
    /// Mean square of what it leaves of a sample, in lx².
    square_lx2: f64,
}

/// Sums of both samples over emitters, in lx.
fn sums_lx<'a>(pairs: impl Iterator<Item = &'a EmitterPair>) -> [f64; 2] {
    pairs.fold([0.0; 2], |sums, pair| [0, 1].map(|k| sums[k] + pair.samples_lx[k]))
}

impl FittedPairs {
    /// The constant closest to pairs of samples.
    fn even(pairs_lx: impl Iterator<Item = [f64; 2]> + Clone) -> FittedPairs {
        let points = pairs_lx.clone().count() as f64;
        let means_lx = [0, 1].map(|k| pairs_lx.clone().map(|pair_lx| pair_lx[k]).sum::<f64>() / points);
        let left_lx = pairs_lx.map(|pair_lx| [0, 1].map(|k| pair_lx[k] - means_lx[k]));
        FittedPairs::leaving(left_lx, points - 1.0, Linear::even(0.5 * (means_lx[0] + means_lx[1])))
    }

    /// A function that leaves so much of each pair. `free` is the number of points less that of the fitted coefficients.
    fn leaving(left_lx: impl Iterator<Item = [f64; 2]>, free: f64, linear_lx: Linear) -> FittedPairs {
        let (mut product_lx2, mut square_lx2) = (0.0, 0.0);
        for [one, other] in left_lx {
            product_lx2 += one * other;
            square_lx2 += 0.5 * (one * one + other * other);
        }
        let free = free.max(1.0);
        FittedPairs { linear_lx, product_lx2: product_lx2 / free, square_lx2: square_lx2 / free }
    }
}

impl PointFit {
    /// `None` if the points do not determine a linear function.
    fn at(points: impl Iterator<Item = [f64; 2]>) -> Option<PointFit> {
        let row = |at: [f64; 2]| {
            let [p, q] = slopes_at(at);
            Vector3::new(1.0, p, q)
        };
        let rows: Vec<Vector3<f64>> = points.map(row).collect();
        let normal: Matrix3<f64> = rows.iter().map(|row| row * row.transpose()).sum();
        let inverse = normal.try_inverse()?;
        Some(PointFit { rows, inverse })
    }

    /// The function closest to the pairs of samples at these points.
    fn of(&self, pairs_lx: impl Iterator<Item = [f64; 2]> + Clone) -> FittedPairs {
        let both = || self.rows.iter().zip(pairs_lx.clone());
        let fits = [0, 1].map(|number| -> Vector3<f64> {
            let sums: Vector3<f64> = both().map(|(row, pair_lx)| row * pair_lx[number]).sum();
            self.inverse * sums
        });
        let left_lx = both().map(|(row, pair_lx)| [0, 1].map(|number| pair_lx[number] - row.dot(&fits[number])));
        let linear_lx = Linear((0.5 * (fits[0] + fits[1])).into());
        FittedPairs::leaving(left_lx, self.rows.len() as f64 - 3.0, linear_lx)
    }

    /// What was found of each emitter, from its pairs at every point, point by point. In an element that is partly hidden by contact few
    /// points may be left, and light is expected to be even.
    fn of_emitters(&self, pairs: &[EmitterPair], whole: bool) -> Vec<FoundOfEmitter> {
        let points = self.rows.len();
        let emitters = pairs.len() / points;
        let of_one = |emitter: usize| {
            let of_points = pairs[emitter..].iter().step_by(emitters);
            let pairs_lx = of_points.clone().map(|pair| pair.samples_lx);
            let fitted = if whole { self.of(pairs_lx) } else { FittedPairs::even(pairs_lx) };
            FoundOfEmitter {
                emitter: pairs[emitter].emitter,
                expected_lx: fitted.linear_lx,
                difference_lx2: fitted.square_lx2,
                unshadowed_lx: of_points.map(|pair| pair.unshadowed_lx).sum::<f64>() / points as f64,
            }
        };
        (0..emitters).map(of_one).collect()
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::check::scene_from_json;
    use crate::transport::World;

    /// A floor of two elements under four lamps. A board above one corner casts the shadow of the first lamp alone.
    const SCENE: &str = r#"{ "version": 1, "materials": { "grey": { "type": "diffuse", "reflectance": 0.5 } },
      "geometry": [ { "name": "floor", "type": "rectangle", "origin": [0,0,0], "u": [2,0,0], "v": [0,2,0], "material": "grey" },
        { "name": "board", "type": "rectangle", "origin": [0.2,0.2,0.3], "u": [0.5,0,0], "v": [0,0.5,0], "material": "grey", "two_sided": true } ],
      "luminaires": [ { "name": "a", "type": "point", "position": [0.6,0.3,3], "luminous_flux_lm": 4000 },
                      { "name": "b", "type": "point", "position": [30,1,3], "luminous_flux_lm": 90000 },
                      { "name": "c", "type": "point", "position": [1,30,3], "luminous_flux_lm": 90000 },
                      { "name": "d", "type": "point", "position": [30,30,3], "luminous_flux_lm": 90000 } ] }"#;

    /// Emitters whose light was even in the parent take a quarter of the rays, and the same light is found. An emitter that was thought
    /// even but casts a shadow here is found out and asked everywhere. Unasked, it would show no shadow.
    #[test]
    fn even_emitters_are_asked_at_few_points_and_shadows_are_found_all_the_same() {
        let scene = scene_from_json(SCENE, None, Path::new(".")).expect("a scene");
        let world = World::new(&scene);
        let context = Context::of_a_test(&scene, &world, 3);
        let lit = (0..world.elements.len() as u32)
            .map(|index| Element::of(&world, &scene, &world.elements, index))
            .find(|element| {
                element.point_m(&world, [0.0; 2]).length() < 1e-9 && element.normal_at(&world, [0.3; 2]).z > 0.0
            });
        let piloted = PilotedElement { context: &context, element: lit.expect("an element"), index: 0, round: 0 };
        let (all, found, rays_of_all) = piloted.sampled(24, &[]);
        assert!(!found[0].is_even() && found[1..].iter().all(|found| found.is_even()), "{found:?}");
        let (few, _, rays_of_few) = piloted.sampled(24, &found);
        assert!((rays_of_few as f64) < 0.5 * rays_of_all as f64, "{rays_of_few} of {rays_of_all}");
        let close = |one: f64, other: f64| (one / other - 1.0).abs() < 0.02;
        assert!(close(few.mean_lx, all.mean_lx) && close(few.left_lx2, all.left_lx2), "{few:?} {all:?}");
        let full_lx = Linear::even(found[0].unshadowed_lx);
        let thought_even = FoundOfEmitter { expected_lx: full_lx, difference_lx2: 0.0, ..found[0] };
        let (seen, again, _) = piloted.sampled(24, &[&[thought_even], &found[1..]].concat());
        assert!(!again[0].is_even() && close(seen.left_lx2, all.left_lx2), "{seen:?} {all:?}");
        let missed = thought_even.expected_pair([0.1; 2]).samples_lx;
        assert_eq!(missed, [found[0].unshadowed_lx; 2], "light that nobody asks for has no shadow");
    }

    /// Two points that are left in an element do not determine a linear function. Planted fault: a linear function through them would expect
    /// light far beyond what was found.
    #[test]
    fn few_points_beside_contact_expect_even_light() {
        let points = [[0.31, 0.22], [0.52, 0.37], [0.31, 0.22 + 1e-9]];
        let fit = PointFit::at(points.into_iter()).expect("rounding leaves an inverse");
        let pair = |lx: f64| EmitterPair { emitter: 0, samples_lx: [lx; 2], unshadowed_lx: 20.0 };
        let pairs = [pair(10.0), pair(16.0), pair(13.0)];
        let largest =
            |found: &[FoundOfEmitter]| found[0].expected_lx.0.iter().fold(0.0f64, |most, lx| most.max(lx.abs()));
        let even = fit.of_emitters(&pairs, false);
        assert!((largest(&even) - 13.0).abs() < 1e-12 && (even[0].difference_lx2 - 9.0).abs() < 1e-12, "{even:?}");
        assert!(largest(&fit.of_emitters(&pairs, true)) > 1e6, "the planted fault passed");
    }
}
