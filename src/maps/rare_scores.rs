//! Error bars of entries whose light comes from few scores.
//!
//! Where few walks or packets bring most of the light, the mean and its spread rise and fall together. Means that are too low then have
//! bars that are too short. Where no score has come at all, there is no spread.
//!
//! By Edgeworth's expansion (Hall, P., 1992, "The Bootstrap and Edgeworth Expansion", section 2.6), a t interval of ±z standard errors
//! loses coverage. The loss is about 2 φ(z) z (z⁴ + 2z² − 3)/18 · g², where g is the skewness of the mean. Bars that are longer by a share
//! of (z⁴ + 2z² − 3)/18 · g² restore it.

use super::residuals::within_halves;
use super::{HALF, REPLICAS};

/// (z⁴ + 2z² − 3)/18 − 1.3 (z² − 3)/12 at z = 2.17, Student's quantile of 95.4% for 15 degrees of freedom. The second term is the
/// correction for the kurtosis of compound Poisson scores, which is about 1.3 times the square of their skewness.
const PER_SQUARED_SKEWNESS: f64 = 1.4;
/// Largest skewness of the mean for which the expansion is used; beyond it the expansion is not valid.
const MOST_SKEWNESS: f64 = 1.5;
/// Number of possibly missing scores, added to the variance of those that came. An interval of ±2.13 standard errors about 0 then reaches
/// three scores. A Poisson variable of mean three is 0 once in twenty times.
const MISSING_SCORES: f64 = 2.0;

/// Moments of one entry's replicas, in the unit of the map's values and its powers.
pub(super) struct Spread {
    /// Indirect part of the entry.
    scale: f64,
    /// Third central moment of a replica times the indirect part, unbiased.
    third: f64,
    /// Squared variance of a replica, unbiased.
    fourth: f64,
    /// Variance of the mean of the indirect part.
    variance: f64,
}

impl Spread {
    /// Computes the moments from an entry's value and indirect part in every replica. Products of even and odd replicas are unbiased,
    /// since these replicas are independent.
    pub fn of(value: impl Fn(usize) -> f64, indirect: impl Fn(usize) -> f64) -> Spread {
        let halves = [0, 1].map(|parity| {
            let replicas = || (parity..REPLICAS).step_by(2);
            let mean = |of: &dyn Fn(usize) -> f64| replicas().map(of).sum::<f64>() / HALF as f64;
            let center = mean(&value);
            let power = |power: i32| mean(&|replica| (value(replica) - center).powi(power));
            let n = HALF as f64;
            (mean(&indirect), power(2) * n / (n - 1.0), power(3) * n * n / ((n - 1.0) * (n - 2.0)))
        });
        let [(even, even_variance, even_third), (odd, odd_variance, odd_third)] = halves;
        Spread {
            scale: 0.5 * (even + odd),
            third: 0.5 * (even_third * odd + odd_third * even),
            fourth: even_variance * odd_variance,
            variance: within_halves(indirect),
        }
    }

    /// Returns the contribution of one score to the mean. Scores of one size have a variance of that size times their mean. An entry
    /// of less than one score is taken as one score.
    fn score(&self) -> f64 {
        let error = self.variance.sqrt();
        if self.scale > error { self.variance / self.scale } else { error }
    }
}

/// Statistics of rare scores of a map.
///
/// Sixteen replicas cannot give the skewness of one entry. But scores of one kind have a skewness in proportion to their relative spread,
/// as counts have: g = c · s/E, where E is the indirect part. The map has one c, computed from the third moments of all entries. The
/// replicas also cannot give the size of a score where none has come. The size of scores elsewhere in the map is used there.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RareScores {
    /// Skewness of a mean divided by its relative standard error.
    skewness: f64,
    /// Contribution of one score to a mean, in the unit of the map's values: for entries with scores, and for entries without.
    score: f64,
    unseen_score: f64,
}

impl RareScores {
    /// Computes the skewness of a map with these entries.
    pub(super) fn of(spreads: &[Spread]) -> RareScores {
        let (mut thirds, mut fourths) = (0.0, 0.0);
        for spread in spreads.iter().filter(|spread| spread.scale > 0.0) {
            thirds += spread.third / spread.scale.powi(3);
            fourths += spread.fourth / spread.scale.powi(3);
        }
        let skewness = if fourths > 0.0 { (thirds / fourths).max(0.0) } else { 0.0 };
        RareScores { skewness, ..RareScores::default() }
    }

    /// Returns the same statistics with the size of missing scores, for a map whose scores are in the unit of its values.
    /// `unseen`: an entry without scores is not certain to be dark.
    pub(super) fn with_missing(self, spreads: &[Spread], unseen: bool) -> RareScores {
        let lit = || spreads.iter().filter(|spread| spread.variance > 0.0);
        let score = lit().map(Spread::score).sum::<f64>() / lit().count().max(1) as f64;
        RareScores { score, unseen_score: if unseen { score } else { 0.0 }, ..self }
    }

    /// Returns the error bar of a mean, from the standard error that its replicas' spread gives and from its indirect part.
    ///
    /// Source: docs/methods.md (9).
    pub(super) fn bar(self, spread: f64, indirect: f64) -> f64 {
        if indirect <= 0.0 {
            return spread.hypot(MISSING_SCORES.sqrt() * self.unseen_score);
        }
        let skewness = (self.skewness * spread / indirect).min(MOST_SKEWNESS);
        let widened = spread * (1.0 + PER_SQUARED_SKEWNESS * skewness * skewness);
        widened.hypot(MISSING_SCORES.sqrt() * self.score)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::maps::standard_error;
    use crate::sampling::random::{Purpose, Stream};

    /// Quantile of 95.4% of Student's t with 15 degrees of freedom.
    const T: f64 = 2.174;

    /// Returns the share of 40,000 entries (1,000 maps of 40; seed 1) whose bar contains the true value, plain and widened. Scores come
    /// `mean_count` times per replica on average. Their size is a power of an exponential variable.
    fn coverage(mean_count: f64, power: i32) -> [f64; 2] {
        let mut stream = Stream::new(1, Purpose::Pilot, 0, 0);
        let exponential = |stream: &mut Stream| -(1.0 - stream.unit()).ln();
        let truth = mean_count * (1..=power).map(f64::from).product::<f64>();
        let mut held = [0.0; 2];
        for map in 0..1000 {
            stream.seek(map);
            let entries: Vec<[f64; REPLICAS]> = (0..40)
                .map(|_| {
                    std::array::from_fn(|_| {
                        let (mut time, mut sum) = (exponential(&mut stream), 0.0);
                        while time < mean_count {
                            sum += exponential(&mut stream).powi(power);
                            time += exponential(&mut stream);
                        }
                        sum
                    })
                })
                .collect();
            let spreads: Vec<Spread> = entries
                .iter()
                .map(|values| {
                    let value = |replica: usize| values[replica];
                    Spread::of(value, value)
                })
                .collect();
            let skewed = RareScores::of(&spreads);
            for (spread, values) in spreads.iter().zip(&entries) {
                let deviation = (spread.scale - truth).abs();
                let error = standard_error(|replica| values[replica]);
                held[0] += f64::from(u8::from(deviation <= T * error));
                held[1] += f64::from(u8::from(deviation <= T * skewed.bar(error, spread.scale)));
            }
        }
        held.map(|count| count / 40_000.0)
    }

    /// The plain bars are the planted fault: they must fail where the widened ones pass.
    #[test]
    fn widened_bars_hold_what_plain_ones_lose() {
        for (mean_count, power) in [(2.0, 1), (3.0, 2)] {
            let [plain, widened] = coverage(mean_count, power);
            assert!(plain < 0.934, "{mean_count} {power}: {plain}");
            assert!((0.934..0.974).contains(&widened), "{mean_count} {power}: {plain} {widened}");
        }
    }

    #[test]
    fn bars_of_many_scores_stay() {
        let [plain, widened] = coverage(200.0, 0);
        assert!((plain - 0.954).abs() < 0.006 && (widened - plain).abs() < 0.004, "{plain} {widened}");
    }

    /// Returns the share of dark entries whose bar contains their mean (seed 2; 400 maps of 60 entries, a third of them dark). All scores
    /// have one size. The bright entries have 200 scores per replica on average, the dark ones `mean_count` over all replicas. The first
    /// result uses bars with missing scores; the second, the planted fault, uses bars without.
    fn coverage_in_the_dark(mean_count: f64) -> [f64; 2] {
        let mut stream = Stream::new(2, Purpose::Pilot, 0, 0);
        let mut held = [0.0; 2];
        for map in 0..400 {
            stream.seek(map);
            let count_of = |stream: &mut Stream, mean: f64| {
                let (mut time, mut count) = (-(1.0 - stream.unit()).ln(), 0.0);
                while time < mean {
                    (count, time) = (count + 1.0, time - (1.0 - stream.unit()).ln());
                }
                count
            };
            let entry = |number: usize, stream: &mut Stream| {
                let mean = if number.is_multiple_of(3) { mean_count / REPLICAS as f64 } else { 200.0 };
                let values: [f64; REPLICAS] = std::array::from_fn(|_| 5.0 * count_of(stream, mean));
                (
                    Spread::of(|replica| values[replica], |replica| values[replica]),
                    standard_error(|replica| values[replica]),
                )
            };
            let (spreads, errors): (Vec<Spread>, Vec<f64>) = (0..60).map(|number| entry(number, &mut stream)).unzip();
            let skewed = RareScores::of(&spreads);
            for (held, rare) in held.iter_mut().zip([skewed.with_missing(&spreads, true), skewed]) {
                for number in (0..60).step_by(3) {
                    let deviation = (spreads[number].scale - 5.0 * mean_count / REPLICAS as f64).abs();
                    *held += f64::from(u8::from(deviation <= T * rare.bar(errors[number], spreads[number].scale)));
                }
            }
        }
        held.map(|count| count / 8000.0)
    }

    /// At α = 10⁻⁴ a true share of at least 0.93 gives a measured share of at least 0.915.
    #[test]
    fn bars_hold_where_scores_are_missing() {
        for mean_count in [0.5, 1.0, 2.0, 4.0] {
            let [with, without] = coverage_in_the_dark(mean_count);
            assert!(with > 0.915, "{mean_count}: {with}");
            assert!(without < 0.915 || mean_count > 2.0, "the planted fault passed: {mean_count}: {without}");
        }
    }

    /// Where every entry has many scores, the effect of missing scores is negligible.
    #[test]
    fn a_missing_score_of_many_is_next_to_nothing() {
        let value = |replica: usize| 1000.0 + (replica % 4) as f64;
        let spreads = [Spread::of(value, value)];
        let rare = RareScores::of(&spreads).with_missing(&spreads, true);
        assert!((rare.bar(0.28, 1001.5) / 0.28 - 1.0).abs() < 1e-3, "{rare:?}");
        assert!(rare.bar(0.0, 0.0) > 0.0, "{rare:?}");
        assert_eq!(RareScores::of(&spreads).with_missing(&spreads, false).bar(0.0, 0.0), 0.0);
    }
}
