//! First directions of rays, drawn more often where light comes from.
//!
//! A direction of a hemisphere corresponds to two variates in a square. The square has equal bins. A density over the bins, learned from
//! samples, warps the variates so that bins with large scores are drawn more often. Each sample is weighted by one over its density. A
//! share of all samples stays uniform, so no weight exceeds one over that share, whatever was learned.

use serde::{Deserialize, Serialize};

/// Number of bins along each side of the square.
const ACROSS: usize = 8;
/// Number of bins.
pub const BINS: usize = ACROSS * ACROSS;
/// Share of samples that stay uniform.
const EVEN: f64 = 0.25;

/// A density over the bins of the unit square.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Density {
    /// Cumulative probability of the columns.
    columns: [f64; ACROSS],
    /// Cumulative probability of the bins of each column.
    rows: [[f64; ACROSS]; ACROSS],
}

impl Density {
    /// Makes the density in proportion to the worth of each bin, plus the uniform share. `None` if no bin is worth anything.
    pub fn of(worth: &[f64; BINS]) -> Option<Density> {
        let total: f64 = worth.iter().sum();
        if !(total.is_finite() && total > 0.0) {
            return None;
        }
        let share = |bin: usize| EVEN / BINS as f64 + (1.0 - EVEN) * worth[bin] / total;
        let column = |index: usize| (0..ACROSS).map(|row| share(index * ACROSS + row)).sum::<f64>();
        let columns = cumulative(std::array::from_fn(column));
        let rows = std::array::from_fn(|index| cumulative(std::array::from_fn(|row| share(index * ACROSS + row))));
        Some(Density { columns, rows })
    }

    /// Warps two variates in [0, 1) to the density, and returns them with the weight of the sample.
    #[inline]
    pub fn warp(&self, [u, v]: [f64; 2]) -> ([f64; 2], f64) {
        let (column, across, u) = place(&self.columns, u);
        let (_, along, v) = place(&self.rows[column], v);
        ([u, v], 1.0 / (BINS as f64 * across * along))
    }

    /// Returns the weight of samples in a bin.
    #[inline]
    pub fn weight(&self, bin: usize) -> f64 {
        let (column, row) = (bin / ACROSS, bin % ACROSS);
        1.0 / (BINS as f64 * length(&self.columns, column) * length(&self.rows[column], row))
    }

    /// Returns the second moment of the weighted scores, as a ratio to that of uniform samples, from the second moments in the bins.
    pub fn second_moment(&self, squares: &[f64; BINS]) -> f64 {
        (0..BINS).map(|bin| squares[bin] * self.weight(bin)).sum::<f64>() / BINS as f64
    }
}

/// Returns the bin of a point of the square.
#[inline]
pub fn bin_of([u, v]: [f64; 2]) -> usize {
    let step = |at: f64| ((at * ACROSS as f64) as usize).min(ACROSS - 1);
    step(u) * ACROSS + step(v)
}

fn cumulative(shares: [f64; ACROSS]) -> [f64; ACROSS] {
    let total: f64 = shares.iter().sum();
    let mut sum = 0.0;
    let mut sums = shares.map(|share| {
        sum += share;
        sum / total
    });
    sums[ACROSS - 1] = 1.0;
    sums
}

#[inline]
fn length(cumulative: &[f64; ACROSS], index: usize) -> f64 {
    cumulative[index] - if index == 0 { 0.0 } else { cumulative[index - 1] }
}

/// Returns the part that contains a variate, its probability, and the variate's position after the warp.
#[inline]
fn place(cumulative: &[f64; ACROSS], at: f64) -> (usize, f64, f64) {
    let index = cumulative.iter().take(ACROSS - 1).filter(|sum| **sum <= at).count();
    let length = length(cumulative, index);
    let within = ((at - (cumulative[index] - length)) / length).clamp(0.0, 1.0 - f64::EPSILON);
    (index, length, (index as f64 + within) / ACROSS as f64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::quadrature::GOLDEN;

    /// A skewed distribution: one bin has ten times as much as all others together.
    fn skewed() -> [f64; BINS] {
        std::array::from_fn(|bin| if bin == 19 { 10.0 } else { 1.0 / 63.0 })
    }

    #[test]
    fn warped_samples_fill_the_square_in_proportion_and_weigh_it_evenly() {
        // 2¹⁸ points of a golden lattice. The weights in every bin sum to 1/64 of all, and the bin of high worth gets its share of the
        // samples.
        let density = Density::of(&skewed()).expect("worth something");
        const STEPS: usize = 512;
        let (mut weights, mut counts) = ([0.0; BINS], [0usize; BINS]);
        for step in 0..STEPS * STEPS {
            let at = [(step as f64 + 0.5) / (STEPS * STEPS) as f64, (step as f64 * GOLDEN).fract()];
            let (to, weight) = density.warp(at);
            assert!(to.iter().all(|at| (0.0..1.0).contains(at)));
            weights[bin_of(to)] += weight / (STEPS * STEPS) as f64;
            counts[bin_of(to)] += 1;
        }
        for (bin, weight) in weights.iter().enumerate() {
            assert!((weight * BINS as f64 - 1.0).abs() < 0.03, "{bin}: {weight}");
        }
        let share = counts[19] as f64 / (STEPS * STEPS) as f64;
        let expected = EVEN / BINS as f64 + (1.0 - EVEN) * 10.0 / 11.0;
        assert!((share - expected).abs() < 0.005, "{share} {expected}");
    }

    #[test]
    fn weights_stay_below_one_over_the_even_share_and_moments_are_those_of_samples() {
        let density = Density::of(&skewed()).expect("worth something");
        let squares: [f64; BINS] = std::array::from_fn(|bin| skewed()[bin].powi(2));
        let mut sum = 0.0;
        const STEPS: usize = 1024;
        for step in 0..STEPS * STEPS {
            let at = [step % STEPS, step / STEPS].map(|at| (at as f64 + 0.5) / STEPS as f64);
            let (to, weight) = density.warp(at);
            assert!(weight <= 1.0 / EVEN * (1.0 + 1e-12));
            sum += squares[bin_of(to)] * weight * weight / (STEPS * STEPS) as f64;
        }
        assert!((sum / density.second_moment(&squares) - 1.0).abs() < 0.02, "{sum}");
        let even = squares.iter().sum::<f64>() / BINS as f64;
        assert!(density.second_moment(&squares) < 0.1 * even);
        assert_eq!(Density::of(&[0.0; BINS]), None);
    }
}
