//! Where a ray meets a smooth body, in f64 and without a mesh.
//!
//! A line and the body's centre span a plane. In it the body is r = R(ψ), with ψ the angle from the line's foot, and the line is r = p /
//! cos ψ. They cross where H(ψ) = R(ψ) cos ψ − p is 0, docs/methods.md (34). The bounds of the series give a constant that H″ never
//! exceeds. A parabola therefore bounds H from here on, and a step to its root passes no crossing, docs/methods.md (35). Near a crossing
//! this is Newton's step. Inside and outside are states of a ray, not results of rounded comparisons: a ray that starts outside a body
//! stays outside until it crosses.

use std::sync::Arc;

use glam::DVec3;

use super::ball::Ball;
use super::frame::Frame;
use super::origin::{Anchor, Origin, RESOLUTION};
use super::triangle::{Crossing, Ray};
use crate::scene::{Body, Side};

/// Distance at which an origin on a body is placed off it, over the body's size: far above the rounding of the series.
const OFF: f64 = 1e-10;
/// Values of H below this, over the body's size, count as 0.
const ZERO: f64 = 1e-13;
/// A line that passes the centre nearer than this, over the body's size, is treated as passing at this distance.
const NEAREST: f64 = 1e-13;
/// Longest step along a ray in rad, so that a step does not turn past the end of a line.
const LONGEST_STEP_RAD: f64 = 1.0;
/// Largest number of steps along a ray. A ray that only touches a body takes about a hundred.
const MOST_STEPS: usize = 1000;

/// A body for rays in the tracer's coordinates.
pub(super) struct LocalBody {
    pub body: Arc<Body>,
    pub frame: Frame,
}

impl AsRef<Body> for LocalBody {
    fn as_ref(&self) -> &Body {
        &self.body
    }
}

/// A point near a body, in m along the body's own axes, and whether it counts as outside.
struct Beside {
    point_m: DVec3,
    outside: bool,
}

impl LocalBody {
    /// Returns a ball around the body.
    pub fn ball(&self) -> Ball {
        let center = self.frame.to_local(self.body.center_m);
        Ball { center, radius: self.frame.length(self.body.bounds.high), luminaire: u32::MAX }
    }

    /// Returns the position of an origin. An origin on the body is placed exactly beside it, on the side that it belongs to.
    fn beside(&self, origin: &Origin) -> Beside {
        let body = &*self.body;
        let turned = body.turn.transpose();
        let point_m = turned * (self.frame.to_metres(origin.point.as_dvec3()) - body.center_m);
        let distance_m = point_m.length();
        if distance_m > body.bounds.high + self.frame.metres(4.0 * RESOLUTION) {
            return Beside { point_m, outside: true };
        }
        let direction = if distance_m > 0.0 { point_m / distance_m } else { DVec3::Z };
        let (radius_m, slope_m) = body.series.value_and_slope(direction);
        let outside = match origin.anchor {
            Anchor::Triangle { triangle, side, .. } if body.triangles.contains(&triangle) => {
                (side == Side::Front) != body.inward
            }
            Anchor::Side if (distance_m - radius_m).abs() < self.frame.metres(4.0 * RESOLUTION) => {
                (turned * origin.normal.as_dvec3()).dot(radius_m * direction - slope_m) > 0.0
            }
            _ => return Beside { point_m, outside: distance_m >= radius_m },
        };
        let off_m = if outside { OFF * body.bounds.high } else { -OFF * body.bounds.high };
        Beside { point_m: (radius_m + off_m) * direction, outside }
    }

    /// Returns the first crossing of a ray from an origin with the body. The distance is in units of the ray's direction. The weights hold
    /// the direction from the body's centre. Their sum is 1 for the front and −1 for the back.
    pub fn meet(&self, ray: &Ray, origin: &Origin) -> Option<Crossing> {
        let along = self.body.turn.transpose() * ray.direction.as_dvec3();
        let length = along.length();
        let beside = self.beside(origin);
        let (distance_m, direction) = self.body.cross(beside.point_m, along / length, beside.outside, f64::INFINITY)?;
        Some(Crossing {
            t: (self.frame.length(distance_m) / length) as f32,
            weights: direction.as_vec3(),
            sum: if beside.outside == self.body.inward { -1.0 } else { 1.0 },
        })
    }

    /// Whether the body stands between two origins.
    pub fn parts(&self, from: &Origin, to: &Origin) -> bool {
        let (from, to) = (self.beside(from), self.beside(to));
        let along = to.point_m - from.point_m;
        let distance_m = along.length();
        distance_m > 0.0 && self.body.cross(from.point_m, along / distance_m, from.outside, distance_m).is_some()
    }
}

impl Body {
    /// Returns where a ray first crosses the body within a distance, from outside or from inside: the distance in m and the unit direction
    /// from the centre. All values are in the body's own axes.
    fn cross(&self, start_m: DVec3, along: DVec3, outside: bool, far_m: f64) -> Option<(f64, DVec3)> {
        let size_m = self.bounds.high;
        let before_foot_m = -start_m.dot(along);
        let foot_m = start_m + before_foot_m * along;
        let nearest_m = foot_m.length();
        if outside && (nearest_m >= size_m || before_foot_m < 0.0 && start_m.length_squared() >= size_m * size_m) {
            return None;
        }
        let (nearest_m, across) = if nearest_m > NEAREST * size_m {
            (nearest_m, foot_m / nearest_m)
        } else {
            (NEAREST * size_m, along.any_orthonormal_vector())
        };
        // Nothing beyond the sphere around the body needs to be examined.
        let half_chord_m = (size_m * size_m - nearest_m * nearest_m).max(0.0).sqrt();
        let last_m = (far_m - before_foot_m).min(half_chord_m);
        let (mut cosine, mut sine) = if outside && before_foot_m > half_chord_m {
            (nearest_m / size_m, -half_chord_m / size_m)
        } else {
            let distance_m = nearest_m.hypot(before_foot_m);
            (nearest_m / distance_m, -before_foot_m / distance_m)
        };
        let sign = if outside { 1.0 } else { -1.0 };
        let bend_m = self.bounds.bends[usize::from(!outside)].max(0.0);
        let most_bent_m = bend_m.hypot(2.0 * self.bounds.derivatives[0]);
        for _ in 0..MOST_STEPS {
            let direction = across * cosine + along * sine;
            let (radius_m, gradient_m) = self.series.value_and_slope(direction);
            let turning_m = gradient_m.dot(along * cosine - across * sine);
            let height_m = sign * (radius_m * cosine - nearest_m);
            let rise_m = sign * (turning_m * cosine - radius_m * sine);
            if height_m >= -ZERO * size_m && rise_m > 0.0 {
                return Some(((radius_m * sine + before_foot_m).clamp(0.0, far_m), direction));
            }
            let depth_m = (-height_m).max(0.0);
            let root_m = (rise_m * rise_m + 2.0 * most_bent_m * depth_m).sqrt();
            let step = if rise_m > 0.0 { 2.0 * depth_m / (rise_m + root_m) } else { (root_m - rise_m) / most_bent_m };
            // Twice the angle whose tangent is half a step is not longer than the step, and needs no trigonometric functions.
            let half = (0.5 * step).min(0.5 * LONGEST_STEP_RAD);
            let scale = 1.0 / (1.0 + half * half);
            let [by_cosine, by_sine] = [(1.0 - half * half) * scale, 2.0 * half * scale];
            (cosine, sine) = (cosine * by_cosine - sine * by_sine, sine * by_cosine + cosine * by_sine);
            if cosine <= 0.0 || sine * nearest_m > last_m * cosine || half == 0.0 {
                return None;
            }
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use glam::DMat3;

    use super::*;
    use crate::base::harmonics::{HarmonicSeries, direction};

    fn body(coefficients: Vec<f64>) -> Body {
        Body::new(HarmonicSeries::new(coefficients), DVec3::ZERO, DMat3::IDENTITY, false, 0..768)
    }

    #[test]
    fn a_ball_is_met_where_the_formula_says_from_both_sides() {
        let ball = body(vec![2.0 * (4.0 * PI).sqrt()]);
        for k in 0..5000 {
            let along = direction(1.0 - (f64::from(k) + 0.5) / 2500.0, 2.4 * f64::from(k));
            let start = DVec3::new(0.3, -0.7, if k % 2 == 0 { 3.0 } else { 1.0 });
            let (b, outside) = (start.dot(along), start.length() > 2.0);
            let square = b * b - start.length_squared() + 4.0;
            let expected = (square >= 0.0).then(|| -b + if outside { -square.sqrt() } else { square.sqrt() });
            let found = ball.cross(start, along, outside, f64::INFINITY);
            match expected.filter(|t| *t >= 0.0) {
                Some(t) => {
                    let (found, direction) = found.expect("the ray meets it");
                    assert!((found - t).abs() < 1e-6 && (start + t * along - 2.0 * direction).length() < 1e-6);
                }
                None => assert!(found.is_none()),
            }
        }
    }

    #[test]
    fn no_crossing_of_a_lumpy_body_is_passed() {
        let lumpy = |k: i32| if k == 0 { 4.0 } else { 0.5 * f64::sin(7.3 * f64::from(k)) / f64::from(k).sqrt() };
        let body = body((0..64).map(lumpy).collect());
        assert!(body.bounds.low > 0.0);
        let height = |p: DVec3| p.length() - body.series.value_and_slope(p.normalize()).0;
        let (mut met, mut steps) = (0, 0);
        for k in 0..600 {
            let start = 3.0 * direction(1.0 - (f64::from(k) + 0.5) / 300.0, 2.4 * f64::from(k));
            let aim = 1.6 * direction(f64::from(k) * 0.618 % 1.0 * 2.0 - 1.0, 1.7 * f64::from(k));
            let along = (aim - start).normalize();
            // Finds all crossings one after the other, and compares them with a walk in small steps.
            let (mut t, mut outside, mut found) = (0.0, true, Vec::new());
            while let Some((more, direction)) = body.cross(start + t * along, along, outside, f64::INFINITY) {
                t += more;
                let place = start + t * along;
                assert!(height(place).abs() < 1e-9 && place.normalize().distance(direction) < 1e-9);
                found.push(t);
                (t, outside) = (t + 1e-7, !outside);
                steps += 1;
                assert!(steps < 10_000);
            }
            let mut walked = Vec::new();
            for step in 0..6000 {
                let [a, b] = [0, 1].map(|more| height(start + f64::from(step + more) * 1e-3 * along));
                if a.signum() != b.signum() {
                    walked.push(f64::from(step) * 1e-3);
                }
            }
            assert!(found.len() >= walked.len() && found.len() % 2 == 0, "{found:?} {walked:?}");
            for walked in &walked {
                assert!(found.iter().any(|t| (t - walked - 5e-4).abs() < 6e-4), "{found:?} {walked}");
            }
            met += usize::from(!found.is_empty());
        }
        assert!(met > 200 && met < 600, "{met}");
    }
}
