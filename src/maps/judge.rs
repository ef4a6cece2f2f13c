//! Estimates the error of a map from its replicas.

use serde::{Deserialize, Serialize};

use super::REPLICAS;
use super::replicas::ReplicaMap;

/// Error of a map as estimated from its replicas. All errors are fractions of the map's mean.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Judgement {
    /// Weighted mean of the map, in the unit of its quantity.
    pub mean: f64,
    /// Random error from the even and the odd half: ½ √(Σ A (E_odd − E_even)² / Σ A) / mean, docs/methods.md (7).
    pub halves_error: f64,
    /// Expected random error from the spread of all replicas. It estimates the same quantity, with 15 degrees of freedom per entry instead
    /// of one. For gathered maps it is the spread within the halves, plus the random error of their cells.
    pub expected_error: f64,
    /// Estimated bias that the even and the odd half share, from the cells. It is 0 for an unbiased estimator.
    pub bias: f64,
    /// Estimated discretisation error: variation of the illuminance within elements that these cannot show. It is 0 for points and for
    /// elements that stand for their means only.
    pub discretisation: f64,
    /// Effective degrees of freedom k = (tr C)²/tr C² of the map's error.
    pub degrees_of_freedom: f64,
    /// Weighted mean of the map in each replica, in the same unit.
    pub means: [f64; REPLICAS],
    /// Whether every entry is 0.
    pub dark: bool,
    /// Whether light could bounce but no chain or walk has scored yet. The spread of the replicas then gives no information about it.
    pub unseen: bool,
}

/// Number of pairs of one even and one odd replica.
const PAIRS: f64 = (REPLICAS / 2) as f64;

impl Judgement {
    /// Returns the stated error: the random error of the halves and the error that both share, in quadrature.
    pub fn stated_error(&self) -> f64 {
        self.halves_error.hypot(self.shared_error())
    }

    /// Returns the error to state for a part of a map. With few entries the halves' error has few degrees of freedom. The larger of it and
    /// the error of all replicas is used, in quadrature with the error that the halves share. The result is never below the error of the
    /// part's mean.
    pub fn error_of_part(&self) -> f64 {
        self.halves_error.max(self.expected_error).hypot(self.shared_error())
    }

    /// Returns the error that even and odd replicas share: bias and discretisation, in quadrature.
    pub fn shared_error(&self) -> f64 {
        self.bias.hypot(self.discretisation)
    }
}

/// Products of the deviations of every two replicas from their mean, summed over a map.
///
/// Let y_ab be the difference of replicas a and b, weighted by √A. Differences of pairs that share no replica are independent, with
/// covariance 2C. Products of different pairs then give tr C², and no outlier in one replica can inflate it alone. All 5,460 pairs of pairs
/// of 16 replicas estimate it far better than the pairs of one division.
#[derive(Clone, Copy, Debug, Default)]
struct ReplicaProducts([[f64; REPLICAS]; REPLICAS]);

impl ReplicaProducts {
    /// Adds an entry with its weight, from the deviations of its replicas.
    fn add(&mut self, weight: f64, deviations: &[f64; REPLICAS]) {
        for (row, one) in self.0.iter_mut().zip(deviations) {
            let weighted = weight * one;
            row.iter_mut().zip(deviations).for_each(|(sum, other)| *sum += weighted * other);
        }
    }

    /// Returns the degrees of freedom of the mean square over the map, (tr C)²/tr C², at least 1 (docs/methods.md (8)). Where halves share
    /// cells (`within_halves`), both replicas of a pair are from one half.
    fn degrees_of_freedom(&self, within_halves: bool) -> f64 {
        let product =
            |[a, b]: [usize; 2], [c, d]: [usize; 2]| (self.0[a][c] - self.0[a][d]) - (self.0[b][c] - self.0[b][d]);
        let pairs: Vec<[usize; 2]> = (0..REPLICAS)
            .flat_map(|a| (0..a).map(move |b| [a, b]))
            .filter(|[a, b]| !within_halves || a % 2 == b % 2)
            .collect();
        let (mut of_traces, mut of_squares) = (0.0, 0.0);
        for (place, one) in pairs.iter().enumerate() {
            let trace = product(*one, *one);
            for other in pairs[..place].iter().filter(|other| !other.iter().any(|replica| one.contains(replica))) {
                of_traces += trace * product(*other, *other);
                of_squares += product(*one, *other).powi(2);
            }
        }
        if of_squares > 0.0 { (of_traces / of_squares).max(1.0) } else { 1.0 }
    }
}

/// Estimates the error of the given entries of a map with their weights (areas; 0 leaves an entry out). Replicas 2j are even, 2j + 1 odd.
pub fn judge(map: &ReplicaMap, entries: impl Iterator<Item = (usize, f64)>) -> Judgement {
    let mut weight_sum = 0.0;
    let mut value_sum = 0.0;
    let mut halves_sum = 0.0;
    let mut spread_sum = 0.0;
    let mut products = ReplicaProducts::default();
    let mut means = [0.0f64; REPLICAS];
    let mut dark = true;
    let mut unseen = map.indirect_samples.complete > 0;
    let shares_cells = map.cells_error.is_some();
    let remaining = map.cells_error.as_ref().map(|error| error.remaining).unwrap_or_default();
    for (entry, weight) in entries.filter(|(_, weight)| *weight > 0.0) {
        let replicas: [f64; REPLICAS] = std::array::from_fn(|replica| map.value(replica, entry));
        let mean = replicas.iter().sum::<f64>() / REPLICAS as f64;
        dark &= replicas.iter().all(|value| *value == 0.0);
        unseen &= map.indirect_sum(entry) == 0.0;
        let halves = (0..REPLICAS).step_by(2).map(|even| replicas[even + 1] - replicas[even]).sum::<f64>() / PAIRS;
        // Coefficients of slopes contribute to the error, not to the mean.
        if entry < map.len() {
            weight_sum += weight;
            value_sum += weight * mean;
            means.iter_mut().zip(&replicas).for_each(|(sum, value)| *sum += weight * value);
        }
        halves_sum += weight * halves * halves;
        spread_sum += weight * map.squared_error(|replica| replicas[replica]);
        products.add(weight, &replicas.map(|value| value - mean));
    }
    if weight_sum <= 0.0 || value_sum <= 0.0 {
        return Judgement { dark, unseen, degrees_of_freedom: 1.0, ..Judgement::default() };
    }
    let mean = value_sum / weight_sum;
    Judgement {
        mean,
        halves_error: 0.5 * (halves_sum / weight_sum).sqrt() / mean,
        expected_error: (spread_sum / weight_sum + remaining.chance).sqrt() / mean,
        bias: remaining.common.sqrt() / mean,
        // Set by the map's job, which has the discretisation error of its elements.
        discretisation: 0.0,
        means: means.map(|sum| sum / weight_sum),
        degrees_of_freedom: products.degrees_of_freedom(shares_cells),
        dark,
        unseen,
    }
}

#[cfg(test)]
mod tests {
    use super::super::replicas::Unit;
    use super::*;
    use crate::sampling::random::{Purpose, Stream};

    /// Builds a map of `len` entries of mean 1 and relative spread `sigma` in each replica. Each run of `alike` neighbours has equal
    /// values.
    fn noisy(seed: u64, len: usize, alike: usize, sigma: f64) -> ReplicaMap {
        let mut map = ReplicaMap::new(len, Unit::Scores);
        map.direct_samples.complete = 1;
        for replica in 0..REPLICAS {
            let mut stream = Stream::new(seed, Purpose::Pilot, 0, replica as u32);
            stream.seek(0);
            for block in 0..len / alike {
                // Twelve uniform variates minus six: nearly normal, with unit variance.
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
        // 40 seeds: the mean of the squared errors must be σ²/16 within 4 of its own standard errors. A map with 2% more noise (the planted
        // fault) must fall outside.
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

    /// 40 maps of two entries, as on a small surface: the stated error of a part is never below the error of its mean. The halves' error
    /// alone (the planted fault) is below it in at least a quarter of the maps.
    #[test]
    fn the_error_of_a_part_is_never_below_that_of_its_mean() {
        let below = |error: &dyn Fn(&Judgement) -> f64| {
            let runs = (0..40).map(|seed| judge(&noisy(500 + seed, 2, 1, 0.3), (0..2).map(|entry| (entry, 1.0))));
            runs.filter(|judgement| {
                let squares = judgement.means.iter().map(|mean| (mean - judgement.mean).powi(2)).sum::<f64>();
                let error_of_mean = (squares / (REPLICAS * (REPLICAS - 1)) as f64).sqrt();
                error(judgement) * judgement.mean < 0.999_999 * error_of_mean
            })
            .count()
        };
        assert_eq!(below(&Judgement::error_of_part), 0);
        assert!(below(&|judgement| judgement.halves_error) >= 10, "the planted fault passed");
    }

    /// Returns the degrees of freedom from eight pairs alone, with each replica in one of them.
    fn by_eight_pairs(map: &ReplicaMap, len: usize) -> f64 {
        let pair = |pair: usize| -> Vec<f64> {
            let of = |replica: usize| (0..len).map(move |entry| map.value(replica, entry));
            of(2 * pair).zip(of(2 * pair + 1)).map(|(a, b)| a - b).collect()
        };
        let pairs: Vec<Vec<f64>> = (0..REPLICAS / 2).map(pair).collect();
        let product = |i: usize, j: usize| pairs[i].iter().zip(&pairs[j]).map(|(a, b)| a * b).sum::<f64>();
        let different = || (0..pairs.len()).flat_map(|i| (0..i).map(move |j| (i, j)));
        let of_traces: f64 = different().map(|(i, j)| product(i, i) * product(j, j)).sum();
        of_traces / different().map(|(i, j)| product(i, j).powi(2)).sum::<f64>()
    }

    /// 200 maps of k = 16: the scatter of ln k is below 0.7 of the scatter from eight pairs alone, which are the planted fault. The
    /// expected ratio is 0.5, known to 7 %, so that a sound estimate fails with α < 1e-4. The mean of ln k is right within 4 standard
    /// errors.
    #[test]
    fn all_pairs_of_replicas_tell_the_degrees_of_freedom_better_than_eight() {
        let (len, alike) = (128, 8);
        let maps: Vec<ReplicaMap> = (0..200).map(|seed| noisy(1000 + seed, len, alike, 0.4)).collect();
        let moments = |degrees: &dyn Fn(&ReplicaMap) -> f64| {
            let logarithms: Vec<f64> = maps.iter().map(|map| degrees(map).ln()).collect();
            let mean = logarithms.iter().sum::<f64>() / logarithms.len() as f64;
            let squares = logarithms.iter().map(|ln| (ln - mean).powi(2)).sum::<f64>();
            (mean, (squares / (logarithms.len() - 1) as f64).sqrt())
        };
        let (mean, scatter) = moments(&|map| judge(map, (0..len).map(|i| (i, 1.0))).degrees_of_freedom);
        let (_, of_eight) = moments(&|map| by_eight_pairs(map, len));
        assert!(scatter < 0.7 * of_eight, "{scatter} {of_eight}");
        let truth = (len as f64 / alike as f64).ln();
        assert!(
            (mean - truth).abs() < 4.0 * scatter / (maps.len() as f64).sqrt() + 0.5 * scatter * scatter,
            "{mean} {truth}"
        );
    }
}
