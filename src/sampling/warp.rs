//! Warps that turn uniform variates into directions and points.

use std::f64::consts::{PI, TAU};

use glam::DVec3;

/// Returns two unit vectors that form a right-handed frame with a unit normal (after Duff et al., 2017, "Building an orthonormal basis,
/// revisited": no branch, no loss of digits near −z).
#[inline]
pub fn tangents(normal: DVec3) -> [DVec3; 2] {
    let sign = 1.0f64.copysign(normal.z);
    let a = -1.0 / (sign + normal.z);
    let b = normal.x * normal.y * a;
    [
        DVec3::new(1.0 + sign * normal.x * normal.x * a, sign * b, -sign * normal.x),
        DVec3::new(b, sign + normal.y * normal.y * a, -normal.y),
    ]
}

/// Coefficients of the series of sin x / x in x²: 1, −1/3!, 1/5!, …
const SINE: [f64; 8] = [
    1.0,
    -1.0 / 6.0,
    1.0 / 120.0,
    -1.0 / 5_040.0,
    1.0 / 362_880.0,
    -1.0 / 39_916_800.0,
    1.0 / 6_227_020_800.0,
    -1.0 / 1_307_674_368_000.0,
];
/// Coefficients of the series of (cos x − 1) / x² in x²: −1/2!, 1/4!, …
const COSINE: [f64; 8] = [
    -1.0 / 2.0,
    1.0 / 24.0,
    -1.0 / 720.0,
    1.0 / 40_320.0,
    -1.0 / 3_628_800.0,
    1.0 / 479_001_600.0,
    -1.0 / 87_178_291_200.0,
    1.0 / 20_922_789_888_000.0,
];

/// Floating-point numbers near this one, 1.5 · 2⁵², are integers. Adding it therefore rounds.
const TO_WHOLE: f64 = 6_755_399_441_055_744.0;

/// Evaluates a polynomial of degree 7 by pairs of coefficients (Estrin's scheme), with three dependent steps instead of seven.
#[inline(always)]
fn polynomial(c: &[f64; 8], x: f64) -> f64 {
    let squared = x * x;
    let low = (c[0] + c[1] * x) + (c[2] + c[3] * x) * squared;
    let high = (c[4] + c[5] * x) + (c[6] + c[7] * x) * squared;
    low + high * (squared * squared)
}

/// Returns sine and cosine of `turns` full turns, 0 to 1, to about 1e-15. With the mathematical library, which must reduce any angle, a
/// chain spends an eighth of its time here.
#[inline]
pub fn sin_cos_of_turns(turns: f64) -> (f64, f64) {
    // Finds the nearest quarter turn, which rounding leaves in the last bits, and the rest between −1/8 and 1/8 of a turn as an angle.
    let rounded = 4.0 * turns + TO_WHOLE;
    let (quarter, angle) = (rounded.to_bits(), (turns - 0.25 * (rounded - TO_WHOLE)) * TAU);
    let a = angle * angle;
    // Taylor's series with products by constants, because divisions would take most of the time.
    let sin = (angle * polynomial(&SINE, a)).to_bits();
    let cos = (1.0 + a * polynomial(&COSINE, a)).to_bits();
    // Quarter turns exchange sine and cosine and change their signs. This is done by bits, because a branch would be mispredicted.
    let exchanged = (sin ^ cos) & (quarter & 1).wrapping_neg();
    let turned = |bits: u64, quarters: u64| f64::from_bits((bits ^ exchanged) ^ (quarters & 2) << 62);
    (turned(sin, quarter), turned(cos, quarter + 1))
}

/// Draws a direction about a normal with density cos θ / π per sr.
#[inline]
pub fn cosine_hemisphere(normal: DVec3, [u, v]: [f64; 2]) -> DVec3 {
    let radius = u.sqrt();
    let (sin, cos) = sin_cos_of_turns(v);
    let [t, b] = tangents(normal);
    // 1 − u never reaches 0, because u stays below 1. The direction therefore always leaves the surface.
    t * (radius * cos) + b * (radius * sin) + normal * (1.0 - u).sqrt()
}

/// Draws a direction with density 1 / 4π per sr.
#[inline]
pub fn uniform_sphere([u, v]: [f64; 2]) -> DVec3 {
    let z = 1.0 - 2.0 * u;
    let radius = (1.0 - z * z).max(0.0).sqrt();
    let (sin, cos) = sin_cos_of_turns(v);
    DVec3::new(radius * cos, radius * sin, z)
}

/// Draws a direction uniformly in the cone of half-angle arccos `cos_max` about an axis, with density 1 / (2π(1 − cos_max)).
///
/// The argument is 1 − cos_max instead of cos_max, so that narrow cones keep their digits.
#[inline]
pub fn uniform_cone(axis: DVec3, one_minus_cos_max: f64, [u, v]: [f64; 2]) -> DVec3 {
    let drop = u * one_minus_cos_max;
    let radius = (drop * (2.0 - drop)).max(0.0).sqrt();
    let (sin, cos) = sin_cos_of_turns(v);
    let [t, b] = tangents(axis);
    t * (radius * cos) + b * (radius * sin) + axis * (1.0 - drop)
}

/// Draws a point uniformly in a triangle and returns its barycentric coordinates (weights of the second and third corner).
#[inline]
pub fn uniform_triangle([u, v]: [f64; 2]) -> [f64; 2] {
    let root = u.sqrt();
    [root * (1.0 - v), root * v]
}

/// Returns the density of [`cosine_hemisphere`] per sr.
#[inline]
pub fn cosine_hemisphere_pdf_per_sr(cos_theta: f64) -> f64 {
    cos_theta.max(0.0) / PI
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::random::{Purpose, Stream};

    #[test]
    fn sine_and_cosine_of_turns_are_those_of_the_library() {
        for i in 0..=100_000 {
            let turns = f64::from(i) / 100_000.0;
            let (sin, cos) = sin_cos_of_turns(turns);
            let angle = TAU * turns;
            assert!((sin - angle.sin()).abs() < 2e-15 && (cos - angle.cos()).abs() < 2e-15, "{turns}");
        }
        let (sin, cos) = sin_cos_of_turns(1.0 - 2f64.powi(-53));
        assert!(sin.abs() < 1e-15 && (cos - 1.0).abs() < 1e-15);
    }

    /// Returns mean and standard error over N = 200,000 draws (seed 1). Each mean must lie within 4.9 standard errors of the exact value (α
    /// = 1e-6). The mean of a density skewed 1% towards the normal must not.
    fn moments(draw: impl Fn(&mut Stream) -> f64) -> (f64, f64) {
        let mut stream = Stream::new(1, Purpose::Pilot, 0, 0);
        let (mut sum, mut squares) = (0.0, 0.0);
        const N: u32 = 200_000;
        for index in 0..N {
            stream.seek(u64::from(index));
            let value = draw(&mut stream);
            sum += value;
            squares += value * value;
        }
        let mean = sum / f64::from(N);
        (mean, ((squares / f64::from(N) - mean * mean) / f64::from(N)).sqrt())
    }

    #[test]
    fn the_cosine_hemisphere_has_its_moments_about_any_normal() {
        for normal in [DVec3::Z, -DVec3::Z, DVec3::X, DVec3::new(1.0, -2.0, 0.5).normalize()] {
            // E[cos θ] = 2/3, E[cos² θ] = 1/2; E[x²] = 1/4 along either tangent.
            let [t, _] = tangents(normal);
            let (mean, error) = moments(|stream| cosine_hemisphere(normal, stream.pair()).dot(normal));
            assert!((mean - 2.0 / 3.0).abs() < 4.9 * error, "{mean} ± {error}");
            assert!((mean * 1.01 - 2.0 / 3.0).abs() > 4.9 * error, "the planted fault passed");
            let (mean, error) = moments(|stream| cosine_hemisphere(normal, stream.pair()).dot(t).powi(2));
            assert!((mean - 0.25).abs() < 4.9 * error, "{mean} ± {error}");
        }
    }

    #[test]
    fn edge_variates_give_unit_vectors_that_leave_the_surface() {
        let last = 1.0 - 2f64.powi(-32);
        for pair in [[0.0, 0.0], [last, last], [0.0, last], [last, 0.0], [last, 0.25]] {
            for normal in [DVec3::Z, -DVec3::Z, DVec3::Y] {
                let direction = cosine_hemisphere(normal, pair);
                assert!((direction.length() - 1.0).abs() < 1e-12 && direction.dot(normal) > 0.0);
            }
            assert!((uniform_sphere(pair).length() - 1.0).abs() < 1e-12);
            let [u, v] = uniform_triangle(pair);
            assert!(u >= 0.0 && v >= 0.0 && u + v <= 1.0);
            assert!((uniform_cone(DVec3::X, 1e-9, pair).length() - 1.0).abs() < 1e-12);
        }
    }
}
