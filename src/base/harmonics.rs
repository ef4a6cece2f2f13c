//! Series of real spherical harmonics: the radius of a closed smooth body by direction, its slopes, and bounds of both.

use std::f64::consts::{PI, SQRT_2};

use glam::DVec3;

/// Largest degree of a series: 32 degrees, l = 0 … 31, of 2l + 1 harmonics each.
pub const LARGEST_DEGREE: usize = 31;

/// Steps between the directions at which a radius is bounded, times the degree: the bound is then no wider than the range of the
/// radius by more than 9%.
const STEP_BY_DEGREE: f64 = 0.4;

/// Bounds are as much wider than what is found, over the largest value: far above the rounding of sums.
const ROUNDING: f64 = 1e-9;

/// One harmonic pair of order m and what leads to the next degree.
#[derive(Clone, Copy, Debug, PartialEq)]
struct HarmonicTerm {
    cosine: f64,
    sine: f64,
    /// (2l + 1)/(l + 1 − m) and (l + m)/(l + 1 − m).
    up: f64,
    down: f64,
}

/// r(d) = Σ c_lm Y_lm(d) over unit vectors d, with orthonormal real harmonics.
///
/// Y_l0 = N_l0 P_l(cos θ), Y_lm = √2 N_lm P_l^m(cos θ) cos mφ, Y_l,−m = √2 N_lm P_l^m(cos θ) sin mφ for m > 0, N_lm² =
/// (2l+1)/4π (l−m)!/(l+m)!, without the sign (−1)^m. Written in x, y and z, so that poles are places like others.
///
/// Source: docs/methods.md (31).
#[derive(Clone, Debug, PartialEq)]
pub struct HarmonicSeries {
    degree: usize,
    coefficients: Vec<f64>,
    terms: Vec<HarmonicTerm>,
}

/// Bounds of a series over the sphere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RadialBounds {
    /// No value is smaller.
    pub low: f64,
    /// No value is larger.
    pub high: f64,
    /// Along great circles the first and the second derivative by the angle stay within ± these.
    pub derivatives: [f64; 2],
}

/// Place of a coefficient in the list: l² + l + m.
pub fn place_of(degree: usize, order: i64) -> usize {
    ((degree * degree + degree) as i64 + order) as usize
}

/// √2 N_lm (N_l0 for m = 0) times (2m − 1)!!, with which the polynomials of order m begin at 1.
fn norm(degree: usize, order: usize) -> f64 {
    let factorials: f64 = (degree - order + 1..=degree + order).map(|factor| factor as f64).product();
    let double_factorial: f64 = (1..=order).map(|factor| (2 * factor - 1) as f64).product();
    let pair = if order == 0 { 1.0 } else { SQRT_2 };
    pair * ((2 * degree + 1) as f64 / (4.0 * PI) / factorials).sqrt() * double_factorial
}

impl HarmonicSeries {
    /// A series with the coefficients c_lm at l² + l + m.
    ///
    /// # Panics
    ///
    /// If their number is no (L + 1)², or L is above [`LARGEST_DEGREE`].
    pub fn new(coefficients: Vec<f64>) -> HarmonicSeries {
        let degree = (coefficients.len() as f64).sqrt().round() as usize - 1;
        assert!((degree + 1).pow(2) == coefficients.len() && degree <= LARGEST_DEGREE);
        let mut terms = Vec::with_capacity((degree + 1) * (degree + 2) / 2);
        for m in 0..=degree {
            for l in m..=degree {
                let norm = norm(l, m);
                let sine = if m == 0 { 0.0 } else { norm * coefficients[place_of(l, -(m as i64))] };
                let steps = (l + 1 - m) as f64;
                terms.push(HarmonicTerm {
                    cosine: norm * coefficients[place_of(l, m as i64)],
                    sine,
                    up: (2 * l + 1) as f64 / steps,
                    down: (l + m) as f64 / steps,
                });
            }
        }
        HarmonicSeries { degree, coefficients, terms }
    }

    /// Largest degree L.
    pub fn degree(&self) -> usize {
        self.degree
    }

    /// Coefficients c_lm at l² + l + m.
    pub fn coefficients(&self) -> &[f64] {
        &self.coefficients
    }

    /// The value in a unit direction, and its gradient on the unit sphere, a vector across the direction.
    ///
    /// Accuracy: some 1e-14 of the largest values.
    pub fn value_and_slope(&self, direction: DVec3) -> (f64, DVec3) {
        let DVec3 { x, y, z } = direction;
        let (mut value, mut slope) = (0.0, DVec3::ZERO);
        // Real and imaginary part of (x + iy)^m, and of the power before.
        let (mut power, mut before) = ([1.0, 0.0], [0.0, 0.0]);
        let mut terms = self.terms.iter();
        for m in 0..=self.degree {
            let (mut cosines, mut sines) = ([0.0; 2], [0.0; 2]);
            // Legendre polynomials of this order over their sin^m θ, and their derivatives by z.
            let (mut legendre, mut last) = ([1.0, 0.0], [0.0, 0.0]);
            for _ in m..=self.degree {
                let Some(term) = terms.next() else { break };
                for k in 0..2 {
                    cosines[k] += term.cosine * legendre[k];
                    sines[k] += term.sine * legendre[k];
                }
                let next = [
                    term.up * z * legendre[0] - term.down * last[0],
                    term.up * (legendre[0] + z * legendre[1]) - term.down * last[1],
                ];
                (last, legendre) = (legendre, next);
            }
            value += cosines[0] * power[0] + sines[0] * power[1];
            slope.x += m as f64 * (cosines[0] * before[0] + sines[0] * before[1]);
            slope.y += m as f64 * (sines[0] * before[0] - cosines[0] * before[1]);
            slope.z += cosines[1] * power[0] + sines[1] * power[1];
            before = power;
            power = [x * power[0] - y * power[1], x * power[1] + y * power[0]];
        }
        (value, slope - slope.dot(direction) * direction)
    }

    /// Bounds of value and derivatives that hold everywhere.
    ///
    /// On a great circle the series is a trigonometric polynomial of its degree, of which Bernstein's inequality bounds the
    /// derivatives by the range; with it, values on a fine grid bound those between.
    pub fn bounds(&self) -> RadialBounds {
        let degree = self.degree.max(1) as f64;
        let rows = (PI * degree / STEP_BY_DEGREE).ceil() as usize + 1;
        let step = PI / rows as f64;
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for row in 0..rows {
            let theta = (row as f64 + 0.5) * step;
            for column in 0..2 * rows {
                let value = self.value_and_slope(direction(theta.cos(), column as f64 * step)).0;
                (low, high) = (low.min(value), high.max(value));
            }
        }
        // No direction is farther from the grid than half its cells' diagonal.
        let reach = step / SQRT_2;
        let half_range = 0.5 * (high - low) / (1.0 - 0.5 * (degree * reach).powi(2));
        let beyond = 0.5 * (degree * reach).powi(2) * half_range;
        let by_degrees = |power: i32| -> f64 {
            (1..=self.degree)
                .map(|l| {
                    let of_degree = &self.coefficients[l * l..(l + 1) * (l + 1)];
                    let norm = of_degree.iter().map(|c| c * c).sum::<f64>().sqrt();
                    (l as f64).powi(power) * norm * ((2 * l + 1) as f64 / (4.0 * PI)).sqrt()
                })
                .sum()
        };
        let degree = self.degree as f64;
        let derivatives = [(degree * half_range).min(by_degrees(1)), (degree * degree * half_range).min(by_degrees(2))];
        // What is summed is rounded.
        let beyond = beyond + ROUNDING * high.abs();
        RadialBounds { low: low - beyond, high: high + beyond, derivatives }
    }
}

/// The unit vector with this z and azimuth in rad.
pub fn direction(z: f64, azimuth: f64) -> DVec3 {
    let across = (1.0 - z * z).max(0.0).sqrt();
    DVec3::new(across * azimuth.cos(), across * azimuth.sin(), z)
}

/// The values of all harmonics up to a degree in a unit direction, at l² + l + m.
pub fn harmonics_at(degree: usize, direction: DVec3) -> Vec<f64> {
    let mut values = vec![0.0; (degree + 1).pow(2)];
    let mut power = [1.0, 0.0];
    for m in 0..=degree {
        let (mut legendre, mut last) = (1.0, 0.0);
        for l in m..=degree {
            let value = norm(l, m) * legendre;
            values[place_of(l, m as i64)] = value * power[0];
            if m > 0 {
                values[place_of(l, -(m as i64))] = value * power[1];
            }
            let next = ((2 * l + 1) as f64 * direction.z * legendre - (l + m) as f64 * last) / (l + 1 - m) as f64;
            (last, legendre) = (legendre, next);
        }
        power = [direction.x * power[0] - direction.y * power[1], direction.x * power[1] + direction.y * power[0]];
    }
    values
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::quadrature::GaussLegendre;

    #[test]
    fn harmonics_are_orthonormal_and_the_series_sums_them() {
        let degree = 6;
        let count = (degree + 1) * (degree + 1);
        let mut products = vec![0.0; count * count];
        let rule = GaussLegendre::new(degree + 2);
        let columns = 2 * degree + 2;
        for (z, weight) in rule.on(-1.0, 1.0) {
            for column in 0..columns {
                let d = direction(z, 2.0 * PI * column as f64 / columns as f64);
                let values = harmonics_at(degree, d);
                for (i, one) in values.iter().enumerate() {
                    for (j, other) in values.iter().enumerate() {
                        products[i * count + j] += weight * 2.0 * PI / columns as f64 * one * other;
                    }
                }
            }
        }
        for (index, product) in products.iter().enumerate() {
            let expected = if index / count == index % count { 1.0 } else { 0.0 };
            assert!((product - expected).abs() < 1e-12, "{index}: {product}");
        }
    }

    #[test]
    fn slopes_are_those_of_the_values_and_bounds_hold() {
        let coefficients: Vec<f64> =
            (0..64).map(|k| if k == 0 { 4.0 } else { 0.2 * f64::sin(7.3 * k as f64) / f64::from(k).sqrt() }).collect();
        let series = HarmonicSeries::new(coefficients.clone());
        let bounds = series.bounds();
        for k in 0..2000 {
            let d = direction(1.0 - (k as f64 + 0.5) / 1000.0, 2.4 * k as f64);
            let (value, slope) = series.value_and_slope(d);
            let by_sum: f64 = harmonics_at(7, d).iter().zip(&coefficients).map(|(y, c)| y * c).sum();
            assert!((value - by_sum).abs() < 1e-13);
            assert!(bounds.low <= value && value <= bounds.high && slope.length() <= bounds.derivatives[0]);
            let (first, second) = d.any_orthonormal_pair();
            for across in [first, second] {
                let at = |angle: f64| series.value_and_slope(d * angle.cos() + across * angle.sin());
                let difference = (at(1e-5).0 - at(-1e-5).0) / 2e-5;
                assert!((difference - slope.dot(across)).abs() < 1e-8, "{difference} {}", slope.dot(across));
                let bend = (at(1e-3).0 - 2.0 * value + at(-1e-3).0) / 1e-6;
                assert!(bend.abs() <= bounds.derivatives[1]);
            }
        }
        // The pole is a place like any other.
        let (pole, near) = (series.value_and_slope(DVec3::Z), series.value_and_slope(direction(1.0 - 1e-14, 1.0)));
        assert!((pole.0 - near.0).abs() < 1e-5 && pole.1.distance(near.1) < 1e-5);
    }

    #[test]
    fn degree_31_is_as_accurate() {
        let mut coefficients = vec![0.0; 1024];
        coefficients[place_of(31, -17)] = 1.0;
        let d = DVec3::new(0.6, -0.48, 0.64);
        let value = HarmonicSeries::new(coefficients).value_and_slope(d).0;
        assert!((value - harmonics_at(31, d)[place_of(31, -17)]).abs() < 1e-13 && value.abs() < 3.0);
    }
}
