//! Polynomials on a triangle that are orthonormal over its area. They separate what an element map shows from what it leaves out.
//!
//! With coefficients c_k of these polynomials, the mean square of a function over the triangle is Σ c_k² (Parseval). c₀ is the mean.
//! Source: Koornwinder, "Two-variable analogues of the classical orthogonal polynomials", 1975.

use std::sync::LazyLock;

use serde::{Deserialize, Serialize};

use crate::scene::elements::{part_at, part_corners};

/// Number of linear polynomials ("slopes") beside the constant.
pub const SLOPES: usize = 2;
/// Number of linear and quadratic ones together ("bends").
pub const BENDS: usize = 5;
/// Number of parts of a triangle, each with a fourth of its edge lengths. Means over the parts show what the polynomials leave out.
pub const PARTS: usize = (DIVISIONS * DIVISIONS) as usize;
const DIVISIONS: u32 = 4;

/// Returns the two linear polynomials at `(a, b)`, the weights of the second and third corner.
#[inline]
pub fn slopes_at([a, b]: [f64; 2]) -> [f64; SLOPES] {
    [std::f64::consts::SQRT_2 * (3.0 * a - 1.0), 6f64.sqrt() * (2.0 * b + a - 1.0)]
}

/// Returns the two linear and the three quadratic polynomials at `(a, b)`, the weights of the second and third corner.
#[inline]
pub fn bends_at([a, b]: [f64; 2]) -> [f64; BENDS] {
    let [first, second] = slopes_at([a, b]);
    let across = 2.0 * b + a - 1.0;
    [
        first,
        second,
        3f64.sqrt() * (10.0 * a * a - 8.0 * a + 1.0),
        3.0 * (5.0 * a - 1.0) * across,
        15f64.sqrt() * 0.5 * (3.0 * across * across - (1.0 - a) * (1.0 - a)),
    ]
}

/// Returns the part of a triangle that contains `(a, b)`.
#[inline]
pub fn part_of([a, b]: [f64; 2]) -> usize {
    part_at(DIVISIONS, a, b) as usize
}

/// Means of the polynomials over each part.
pub static MEANS_OVER_PARTS: LazyLock<[[f64; BENDS]; PARTS]> = LazyLock::new(|| {
    std::array::from_fn(|part| {
        let [a, b, c] = part_corners(DIVISIONS, part as u32);
        // The mean over the midpoints of the edges is exact for quadratic functions.
        let middles = [(a, b), (b, c), (c, a)].map(|(p, q)| bends_at([0, 1].map(|k| 0.5 * (p[k] + q[k]))));
        std::array::from_fn(|k| middles.iter().map(|bends| bends[k]).sum::<f64>() / 3.0)
    })
});

/// A linear function on a triangle, given by its coefficients: its mean and those of the two linear polynomials.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Linear(pub [f64; 1 + SLOPES]);

impl Linear {
    /// Returns the function with this value everywhere.
    pub fn even(value: f64) -> Linear {
        Linear([value, 0.0, 0.0])
    }

    /// Returns the sum of two functions.
    pub fn plus(&self, other: &Linear) -> Linear {
        Linear(std::array::from_fn(|k| self.0[k] + other.0[k]))
    }

    /// Returns the value at a point, given by the weights of the second and third corner.
    #[inline]
    pub fn at(&self, at: [f64; 2]) -> f64 {
        let [mean, first, second] = self.0;
        let [p, q] = slopes_at(at);
        mean + first * p + second * q
    }

    /// Returns the function with these values at the corners.
    pub fn through([a, b, c]: [f64; 3]) -> Linear {
        let mean = (a + b + c) / 3.0;
        Linear([mean, (b - mean) / 8f64.sqrt(), (c - a) / 24f64.sqrt()])
    }

    /// Returns the same function on a piece of the triangle with these corners.
    pub fn on_piece(&self, corners: [[f64; 2]; 3]) -> Linear {
        Linear::through(corners.map(|corner| self.at(corner)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_linear_function_is_known_by_its_corners_and_on_its_pieces() {
        let function = Linear::through([1.0, 4.0, -2.0]);
        let exact = |[a, b]: [f64; 2]| 1.0 + 3.0 * a - 3.0 * b;
        let corners = [[0.5, 0.5], [0.0, 0.5], [0.5, 0.0]];
        let piece = function.on_piece(corners);
        for at in [[0.0, 0.0], [1.0, 0.0], [0.2, 0.7]] {
            assert!((function.at(at) - exact(at)).abs() < 1e-12);
            let outer = [0, 1].map(|k| {
                corners[0][k] + at[0] * (corners[1][k] - corners[0][k]) + at[1] * (corners[2][k] - corners[0][k])
            });
            assert!((piece.at(at) - exact(outer)).abs() < 1e-12);
        }
    }

    #[test]
    fn parts_hold_the_means_of_the_polynomials() {
        let means = &*MEANS_OVER_PARTS;
        for k in 0..BENDS {
            assert!(means.iter().map(|part| part[k]).sum::<f64>().abs() < 1e-12);
        }
        // The centre of a part lies in it, and a linear polynomial has its mean over the part there.
        for (part, mean) in means.iter().enumerate() {
            let [a, b, c] = part_corners(DIVISIONS, part as u32);
            let middle = [0, 1].map(|k| (a[k] + b[k] + c[k]) / 3.0);
            let slopes = slopes_at(middle);
            assert_eq!(part_of(middle), part);
            assert!((slopes[0] - mean[0]).abs() < 1e-12 && (slopes[1] - mean[1]).abs() < 1e-12);
        }
    }

    #[test]
    fn the_polynomials_are_orthonormal() {
        // Means over the triangle by the midpoints of a fine lattice. Their error falls with the square of the step.
        const STEPS: usize = 600;
        let mut products = [[0.0; BENDS + 1]; BENDS + 1];
        let mut count = 0.0;
        for (i, j) in (0..STEPS).flat_map(|i| (0..STEPS - i).map(move |j| (i, j))) {
            let thirds: &[f64] = if i + j + 1 < STEPS { &[1.0 / 3.0, 2.0 / 3.0] } else { &[1.0 / 3.0] };
            for third in thirds {
                let at = [i, j].map(|step| (step as f64 + third) / STEPS as f64);
                let [p, q, r, s, t] = bends_at(at);
                let all = [1.0, p, q, r, s, t];
                for (row, x) in products.iter_mut().zip(all) {
                    row.iter_mut().zip(all).for_each(|(sum, y)| *sum += x * y);
                }
                count += 1.0;
            }
        }
        for (i, row) in products.iter().enumerate() {
            for (j, product) in row.iter().enumerate() {
                let expected = f64::from(u8::from(i == j));
                assert!((product / count - expected).abs() < 1e-4, "{i} {j}: {}", product / count);
            }
        }
    }
}
