//! The error of a map, judged from its replicas.

use serde::{Deserialize, Serialize};

use super::REPLICAS;
use super::replicas::ReplicaMap;

/// What the replicas tell of a map's error; all errors are fractions of the map's mean.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Judgement {
    /// Weighted mean of the map in lx.
    pub mean_lx: f64,
    /// Random error from the even and the odd half: ½ √(Σ A (E_odd − E_even)² / Σ A) / mean, docs/methods.md (7).
    pub halves_error: f64,
    /// Expected random error from the spread of all replicas: the same quantity, with 15 degrees of freedom an entry instead of one.
    pub expected_error: f64,
    /// Estimated bias that the even and the odd half share, that of cells; 0 for an unbiased estimator.
    pub bias: f64,
    /// Estimated discretisation error: what elements cannot show of the illuminance within them; 0 for points and for
    /// elements that stand for nothing but their means.
    pub discretisation: f64,
    /// Effective degrees of freedom k = (tr C)²/tr C² of the map's error.
    pub degrees_of_freedom: f64,
    /// Weighted mean of the map in each replica, in lx.
    pub means_lx: [f64; REPLICAS],
    /// Whether every entry is 0.
    pub dark: bool,
    /// Whether light could bounce but no chain or walk has scored yet: the spread then says nothing of it.
    pub unseen: bool,
}

impl Judgement {
    /// The stated error: the random error of the halves and what they share, in quadrature.
    pub fn stated_error(&self) -> f64 {
        self.halves_error.hypot(self.shared_error())
    }

    /// What even and odd share: bias and discretisation, in quadrature.
    pub fn shared_error(&self) -> f64 {
        self.bias.hypot(self.discretisation)
    }
}

/// Pairs of replicas.
const PAIRS: usize = REPLICAS / 2;

/// Products of the differences of pairs of replicas, summed over a map.
///
/// With y_j the difference of pair j, weighted by √A, the y_j are independent with covariance 2C: tr C² follows from products
/// of different pairs, which no outlier in one pair can inflate alone.
#[derive(Clone, Copy, Debug, Default)]
struct PairProducts([[f64; PAIRS]; PAIRS]);

impl PairProducts {
    /// Adds an entry with its weight.
    fn add(&mut self, weight: f64, pairs: &[f64; PAIRS]) {
        for i in 0..PAIRS {
            for j in 0..=i {
                self.0[i][j] += weight * pairs[i] * pairs[j];
            }
        }
    }

    /// Degrees of freedom of the mean square over the map, (tr C)²/tr C²: 1 at least (docs/methods.md (8)).
    fn degrees_of_freedom(&self) -> f64 {
        let different = || (0..PAIRS).flat_map(|i| (0..i).map(move |j| (i, j)));
        let of_traces: f64 = different().map(|(i, j)| self.0[i][i] * self.0[j][j]).sum();
        let of_squares: f64 = different().map(|(i, j)| self.0[i][j] * self.0[i][j]).sum();
        if of_squares > 0.0 { (of_traces / of_squares).max(1.0) } else { 1.0 }
    }
}

/// Judges the given entries of a map with their weights (areas; 0 leaves an entry out). Replicas 2j are even, 2j + 1 odd.
pub fn judge(map: &ReplicaMap, entries: impl Iterator<Item = (usize, f64)>) -> Judgement {
    let mut weight_sum = 0.0;
    let mut illuminance_sum = 0.0;
    let mut halves_sum = 0.0;
    let mut spread_sum = 0.0;
    let mut products = PairProducts::default();
    let mut means_lx = [0.0f64; REPLICAS];
    let mut dark = true;
    let mut unseen = map.indirect_samples.complete > 0;
    let shares_cells = map.cells_error.is_some();
    let remaining = map.cells_error.as_ref().map(|error| error.remaining).unwrap_or_default();
    for (entry, weight) in entries.filter(|(_, weight)| *weight > 0.0) {
        let replicas: [f64; REPLICAS] = std::array::from_fn(|replica| map.illuminance_lx(replica, entry));
        let mean = replicas.iter().sum::<f64>() / REPLICAS as f64;
        dark &= replicas.iter().all(|value| *value == 0.0);
        unseen &= map.indirect_sum(entry) == 0.0;
        let mut pairs: [f64; PAIRS] = std::array::from_fn(|pair| replicas[2 * pair + 1] - replicas[2 * pair]);
        let halves = pairs.iter().sum::<f64>() / PAIRS as f64;
        if shares_cells {
            // Replicas of a half share cells, whose error is in `remaining`: both of a pair (0 and 2, 1 and 3, 4 and 6, …) are of one
            // half, so that the pairs' differences are free of it.
            pairs = std::array::from_fn(|pair| {
                let first = 2 * pair - pair % 2;
                replicas[first + 2] - replicas[first]
            });
        }
        // Coefficients of slopes add to the error, not to the mean.
        if entry < map.len() {
            weight_sum += weight;
            illuminance_sum += weight * mean;
            means_lx.iter_mut().zip(&replicas).for_each(|(sum, value)| *sum += weight * value);
        }
        halves_sum += weight * halves * halves;
        spread_sum += weight * map.squared_error(|replica| replicas[replica]);
        products.add(weight, &pairs);
    }
    if weight_sum <= 0.0 || illuminance_sum <= 0.0 {
        return Judgement { dark, unseen, degrees_of_freedom: 1.0, ..Judgement::default() };
    }
    let mean_lx = illuminance_sum / weight_sum;
    Judgement {
        mean_lx,
        halves_error: 0.5 * (halves_sum / weight_sum).sqrt() / mean_lx,
        expected_error: (spread_sum / weight_sum + remaining.chance).sqrt() / mean_lx,
        bias: remaining.common.sqrt() / mean_lx,
        // Set by the map's job, which knows what its elements lose.
        discretisation: 0.0,
        means_lx: means_lx.map(|sum| sum / weight_sum),
        degrees_of_freedom: products.degrees_of_freedom(),
        dark,
        unseen,
    }
}

#[cfg(test)]
mod tests {
    use super::super::replicas::Unit;
    use super::*;
    use crate::sampling::random::{Purpose, Stream};

    /// A map of `len` entries of mean 1 and relative spread `sigma` in each replica, of which `alike` neighbours are equal.
    fn noisy(seed: u64, len: usize, alike: usize, sigma: f64) -> ReplicaMap {
        let mut map = ReplicaMap::new(len, Unit::Lux);
        map.direct_samples.complete = 1;
        for replica in 0..REPLICAS {
            let mut stream = Stream::new(seed, Purpose::Pilot, 0, replica as u32);
            stream.seek(0);
            for block in 0..len / alike {
                // Twelve uniform variates less six: normal enough, of unit variance.
                let normal = (0..12).map(|_| stream.unit()).sum::<f64>() - 6.0;
                for entry in block * alike..(block + 1) * alike {
                    map.direct[replica][entry] = 1.0 + sigma * normal;
                }
            }
        }
        map
    }

    #[test]
    fn error_and_degrees_of_freedom_are_those_put_in() {
        // 40 seeds: the mean of the squared errors must be σ²/16 within 4 of its own standard errors, and a map
        // with 2% more noise (the planted fault) must fall outside of it.
        for (len, alike) in [(2048, 1), (2048, 128)] {
            let k = (len / alike) as f64;
            let judged = |sigma: f64| {
                let runs: Vec<Judgement> =
                    (0..40).map(|seed| judge(&noisy(seed, len, alike, sigma), (0..len).map(|i| (i, 1.0)))).collect();
                let mean = |of: fn(&Judgement) -> f64| runs.iter().map(of).sum::<f64>() / runs.len() as f64;
                (mean(|j| j.expected_error.powi(2)), mean(|j| j.halves_error.powi(2)), mean(|j| j.degrees_of_freedom))
            };
            let (expected, halves, degrees) = judged(0.4);
            let truth = 0.16 / 16.0;
            let tolerance = 4.0 * truth * (2.0 / (40.0 * 15.0 * k)).sqrt();
            assert!((expected - truth).abs() < tolerance, "{expected} {truth} ± {tolerance}");
            assert!((halves - truth).abs() < 15f64.sqrt() * tolerance, "{halves} {truth}");
            assert!(degrees > 0.7 * k && degrees < 1.6 * k, "{degrees} {k}");
            if alike == 1 {
                let (faulty, _, _) = judged(0.4 * 1.02);
                assert!((faulty - truth).abs() > tolerance, "the planted fault passed: {faulty} {truth} ± {tolerance}");
            }
        }
    }
}
