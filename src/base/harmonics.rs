//! Series of real spherical harmonics: the radius of a closed smooth body as a function of direction, its slopes, and bounds of both.

use std::f64::consts::{PI, SQRT_2};

use glam::DVec3;

/// Largest degree of a series: the 32 degrees l = 0 … 31, with 2l + 1 harmonics each.
pub const LARGEST_DEGREE: usize = 31;

/// Angular step between the directions at which a radius is bounded, times the degree. With this step the bounds exceed the true range of
/// the radius by at most 9%.
const STEP_BY_DEGREE: f64 = 0.4;

/// Bounds are widened by this share of the largest value, far above the rounding of the sums.
const WIDENED_BY: f64 = 1e-9;

/// Number of orders that are summed side by side.
const LANES: usize = 4;

/// The harmonics of degree m + k of [`LANES`] neighbouring orders m. Harmonics that the series lacks have the coefficient 0.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct HarmonicTerms {
    /// Factors of the recurrence for the next polynomial: q_{k+1} = z q_k − down q_{k−1}.
    down: [f64; LANES],
    /// Factors of q_k in the sums that multiply cos mφ and sin mφ, and in the derivatives of these sums by z.
    sums: [[f64; LANES]; 4],
}

/// A series r(d) = Σ c_lm Y_lm(d) over unit vectors d, with orthonormal real harmonics.
///
/// Y_l0 = N_l0 P_l(cos θ), Y_lm = √2 N_lm P_l^m(cos θ) cos mφ, Y_l,−m = √2 N_lm P_l^m(cos θ) sin mφ for m > 0, N_lm² = (2l+1)/4π
/// (l−m)!/(l+m)!, without the sign (−1)^m. The series is evaluated in x, y and z, so the poles need no special case.
///
/// Source: docs/methods.md (31).
#[derive(Clone, Debug, PartialEq)]
pub struct HarmonicSeries {
    degree: usize,
    coefficients: Vec<f64>,
    terms: Vec<HarmonicTerms>,
}

/// Bounds of a series over the sphere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RadialBounds {
    /// Lower bound of all values.
    pub low: f64,
    /// Upper bound of all values.
    pub high: f64,
    /// Along every great circle the absolute first and second derivatives by the angle stay below these two.
    pub derivatives: [f64; 2],
    /// Upper bounds of (second derivative − value) and of (value − second derivative), in this order.
    pub bends: [f64; 2],
}

/// Returns the index of a coefficient in the list: l² + l + m.
pub fn place_of(degree: usize, order: i64) -> usize {
    ((degree * degree + degree) as i64 + order) as usize
}

/// Returns √2 N_lm (N_l0 for m = 0) times (2m − 1)!!. This factor lets the polynomials of order m start at 1.
fn norm(degree: usize, order: usize) -> f64 {
    let factorials: f64 = (degree - order + 1..=degree + order).map(|factor| factor as f64).product();
    let double_factorial: f64 = (1..=order).map(|factor| (2 * factor - 1) as f64).product();
    let pair = if order == 0 { 1.0 } else { SQRT_2 };
    pair * ((2 * degree + 1) as f64 / (4.0 * PI) / factorials).sqrt() * double_factorial
}

impl HarmonicSeries {
    /// Makes a series with the coefficients c_lm at l² + l + m.
    ///
    /// # Panics
    ///
    /// If the number of coefficients is not (L + 1)², or if L is above [`LARGEST_DEGREE`].
    pub fn new(coefficients: Vec<f64>) -> HarmonicSeries {
        let degree = (coefficients.len() as f64).sqrt().round() as usize - 1;
        assert!((degree + 1).pow(2) == coefficients.len() && degree <= LARGEST_DEGREE);
        let mut terms = Vec::new();
        for first in (0..=degree).step_by(LANES) {
            let mut of_orders = vec![HarmonicTerms::default(); degree - first + 1];
            for (lane, m) in (first..=degree.min(first + LANES - 1)).enumerate() {
                let mut scale = 1.0;
                for (k, terms) in of_orders.iter_mut().enumerate().take(degree - m + 1) {
                    let l = m + k;
                    let [even, odd] = [m as i64, -(m as i64)].map(|order| coefficients[place_of(l, order)]);
                    let factor = scale * norm(l, m);
                    terms.sums[0][lane] = factor * even;
                    terms.sums[1][lane] = if m == 0 { 0.0 } else { factor * odd };
                    // The derivative of Gegenbauer's polynomial of order m + ½ is the sum of 2(j + m + ½) times the polynomials of j = k −
                    // 1, k − 3, …
                    for above in (k + 1..=degree - m).step_by(2) {
                        let norm = scale * (2 * l + 1) as f64 * norm(m + above, m);
                        let [even, odd] = [m as i64, -(m as i64)].map(|order| coefficients[place_of(m + above, order)]);
                        terms.sums[2][lane] += norm * even;
                        terms.sums[3][lane] += if m == 0 { 0.0 } else { norm * odd };
                    }
                    let [l, m] = [l, m].map(|number| number as f64);
                    terms.down[lane] = (l + m) * (l - m) / ((2.0 * l + 1.0) * (2.0 * l - 1.0)).max(1.0);
                    scale *= (2.0 * l + 1.0) / (l + 1.0 - m);
                }
            }
            terms.extend(of_orders);
        }
        HarmonicSeries { degree, coefficients, terms }
    }

    /// Returns the largest degree L.
    pub fn degree(&self) -> usize {
        self.degree
    }

    /// Returns the coefficients c_lm, at l² + l + m.
    pub fn coefficients(&self) -> &[f64] {
        &self.coefficients
    }

    /// Returns the value in a unit direction and its gradient on the unit sphere, a vector perpendicular to the direction.
    ///
    /// Accuracy: about 1e-14 of the largest values.
    pub fn value_and_slope(&self, direction: DVec3) -> (f64, DVec3) {
        let DVec3 { x, y, z } = direction;
        let times = |[a, b]: [f64; 2], [c, d]: [f64; 2]| [a * c - b * d, a * d + b * c];
        // Powers of x + iy, real and imaginary parts in separate lists. `last_power` is the last power of the preceding group of orders.
        let second = times([x, y], [x, y]);
        let third = times(second, [x, y]);
        let fourth = times(second, second);
        let mut powers = [[1.0, x, second[0], third[0]], [0.0, y, second[1], third[1]]];
        let mut last_power = [0.0; 2];
        let (mut value, mut slope) = ([0.0; LANES], [[0.0; LANES]; 3]);
        let mut terms = &self.terms[..];
        for first in (0..=self.degree).step_by(LANES) {
            let (of_orders, rest) = terms.split_at(self.degree - first + 1);
            terms = rest;
            let mut sums = [[0.0; LANES]; 4];
            let (mut polynomial, mut last) = ([1.0; LANES], [0.0; LANES]);
            for term in of_orders {
                for lane in 0..LANES {
                    let here = polynomial[lane];
                    for (sum, factor) in sums.iter_mut().zip(&term.sums) {
                        sum[lane] += factor[lane] * here;
                    }
                    polynomial[lane] = z * here - term.down[lane] * last[lane];
                    last[lane] = here;
                }
            }
            let [reals, imaginaries] = powers;
            let before = [0, 1].map(|k| [last_power[k], powers[k][0], powers[k][1], powers[k][2]]);
            for lane in 0..LANES {
                let order = (first + lane) as f64;
                let [cosine, sine] = [sums[0][lane], sums[1][lane]];
                value[lane] += cosine * reals[lane] + sine * imaginaries[lane];
                slope[0][lane] += order * (cosine * before[0][lane] + sine * before[1][lane]);
                slope[1][lane] += order * (sine * before[0][lane] - cosine * before[1][lane]);
                slope[2][lane] += sums[2][lane] * reals[lane] + sums[3][lane] * imaginaries[lane];
                [powers[0][lane], powers[1][lane]] = times([reals[lane], imaginaries[lane]], fourth);
            }
            last_power = [reals[LANES - 1], imaginaries[LANES - 1]];
        }
        let sum = |lanes: [f64; LANES]| (lanes[0] + lanes[1]) + (lanes[2] + lanes[3]);
        let slope = DVec3::from(slope.map(sum));
        (sum(value), slope - slope.dot(direction) * direction)
    }

    /// Returns the series of the Laplacian on the unit sphere.
    fn laplacian(&self) -> HarmonicSeries {
        let of_degree = |(place, c): (usize, &f64)| {
            let l = (place as f64).sqrt().floor();
            -l * (l + 1.0) * c
        };
        HarmonicSeries::new(self.coefficients.iter().enumerate().map(of_degree).collect())
    }

    /// Returns the series of the derivative by the azimuth.
    fn by_azimuth(&self) -> HarmonicSeries {
        let mut coefficients = vec![0.0; self.coefficients.len()];
        for l in 0..=self.degree {
            for m in 1..=l as i64 {
                coefficients[place_of(l, -m)] = -m as f64 * self.coefficients[place_of(l, m)];
                coefficients[place_of(l, m)] = m as f64 * self.coefficients[place_of(l, -m)];
            }
        }
        HarmonicSeries::new(coefficients)
    }

    /// Returns bounds of the value and its derivatives that hold in every direction.
    ///
    /// Along a great circle the series is a trigonometric polynomial of its degree. So are its derivatives along directions that turn with
    /// the circle. Bernstein's inequality bounds the second derivative of a trigonometric polynomial by its range. With this bound, values
    /// on a fine grid bound the values between grid points. Second derivatives on the grid are the eigenvalues of the Hessian in polar
    /// coordinates.
    pub fn bounds(&self) -> RadialBounds {
        let degree = self.degree.max(1) as f64;
        let rows = (PI * degree / STEP_BY_DEGREE).ceil() as usize + 1;
        let step = PI / rows as f64;
        let (by_azimuth, laplacian) = (self.by_azimuth(), self.laplacian());
        let (mut low, mut high, mut steepest) = (f64::INFINITY, f64::NEG_INFINITY, 0.0_f64);
        let (mut most_bent, mut bends) = (0.0_f64, [f64::NEG_INFINITY; 2]);
        for row in 0..rows {
            let (sine, cosine) = ((row as f64 + 0.5) * step).sin_cos();
            for column in 0..2 * rows {
                let towards = direction(cosine, column as f64 * step);
                let (sine_azimuth, cosine_azimuth) = (column as f64 * step).sin_cos();
                let down = DVec3::new(cosine * cosine_azimuth, cosine * sine_azimuth, -sine);
                let around = DVec3::new(-sine_azimuth, cosine_azimuth, 0.0);
                let (value, slope) = self.value_and_slope(towards);
                let (turned, turned_slope) = by_azimuth.value_and_slope(towards);
                let trace = laplacian.value_and_slope(towards).0;
                let bend_around = (turned_slope.dot(around) + cosine * slope.dot(down)) / sine;
                let twist = (turned_slope.dot(down) - cosine / sine * turned) / sine;
                let spread = (0.5 * trace - bend_around).hypot(twist);
                let [least, most] = [0.5 * trace - spread, 0.5 * trace + spread];
                (low, high, steepest) = (low.min(value), high.max(value), steepest.max(slope.length()));
                most_bent = most_bent.max(most.abs()).max(least.abs());
                bends = [bends[0].max(most - value), bends[1].max(value - least)];
            }
        }
        // No direction is farther from a grid point than half the diagonal of a grid cell.
        let reach = step / SQRT_2;
        let missed = 0.5 * (degree * reach).powi(2);
        let beyond = missed * 0.5 * (high - low) / (1.0 - missed);
        let derivatives = [steepest / (1.0 - missed), most_bent / (1.0 - missed)];
        // The sums carry rounding errors.
        let beyond = beyond + WIDENED_BY * high.abs();
        let (low, high) = (low - beyond, high + beyond);
        let bends = bends.map(|bend| bend + missed * (derivatives[1] + high.abs().max(low.abs())));
        RadialBounds { low, high, derivatives, bends }
    }
}

/// Returns the unit vector with this z and this azimuth in rad.
pub fn direction(z: f64, azimuth: f64) -> DVec3 {
    let across = (1.0 - z * z).max(0.0).sqrt();
    DVec3::new(across * azimuth.cos(), across * azimuth.sin(), z)
}

/// Returns the values of all harmonics up to a degree in a unit direction, at l² + l + m.
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
        let (mut steepest, mut bends) = (0.0_f64, [0.0_f64; 2]);
        for k in 0..2000 {
            let d = direction(1.0 - (k as f64 + 0.5) / 1000.0, 2.4 * k as f64);
            let (value, slope) = series.value_and_slope(d);
            let by_sum: f64 = harmonics_at(7, d).iter().zip(&coefficients).map(|(y, c)| y * c).sum();
            assert!((value - by_sum).abs() < 1e-13);
            assert!(bounds.low <= value && value <= bounds.high && slope.length() <= bounds.derivatives[0]);
            let (first, second) = d.any_orthonormal_pair();
            for across in
                (0..8).map(|part| 0.125 * PI * f64::from(part)).map(|turn| first * turn.cos() + second * turn.sin())
            {
                let at = |angle: f64| series.value_and_slope(d * angle.cos() + across * angle.sin());
                let difference = (at(1e-5).0 - at(-1e-5).0) / 2e-5;
                assert!((difference - slope.dot(across)).abs() < 1e-8, "{difference} {}", slope.dot(across));
                let bend = (at(1e-3).0 - 2.0 * value + at(-1e-3).0) / 1e-6;
                assert!(bend.abs() <= bounds.derivatives[1]);
                assert!(bend - value <= bounds.bends[0] && value - bend <= bounds.bends[1]);
                steepest = steepest.max(slope.length());
                bends = [bends[0].max(bend - value), bends[1].max(value - bend)];
            }
        }
        // The bounds are tight. Bounds from the series' range alone, the planted fault, are almost three times as far.
        let [bent, unbent] = [0, 1].map(|k| bounds.bends[k] / bends[k]);
        assert!(bounds.derivatives[0] < 1.1 * steepest && bent < 1.3 && unbent < 1.3, "{bent} {unbent}");
        assert!(49.0 * 0.5 * (bounds.high - bounds.low) > 2.0 * bounds.derivatives[1]);
        // The pole needs no special case.
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
