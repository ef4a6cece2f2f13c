//! What a number of a run will have come to at its end, with the interval that holds it in 90 % of runs.

use serde::{Deserialize, Serialize};

use super::checks::{ENOUGH_SCORES, LONGEST_WAIT};
use super::schedule::GROWTH_AFTER_REFUSAL;
use crate::maps::REPLICAS;

/// Standard deviations of the normal distribution beyond which 5 % lie on either side.
pub const NINE_OF_TEN: f64 = 1.645;

/// A number to come and the interval that holds it in 90 % of runs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Forecast {
    /// The number, about: as likely too high as too low.
    pub expected: f64,
    /// It is below this in 5 % of runs.
    pub low: f64,
    /// It is above this in 5 % of runs.
    pub high: f64,
}

impl Forecast {
    /// A number that is known.
    pub fn known(number: f64) -> Forecast {
        Forecast { expected: number, low: number, high: number }
    }

    /// A number above 0 of whose logarithm the standard deviation is known.
    pub fn spread(expected: f64, deviation_ln: f64) -> Forecast {
        let factor = (NINE_OF_TEN * deviation_ln).exp();
        Forecast { expected, low: expected / factor, high: expected * factor }
    }

    /// What two sayings of one number above 0 tell together, each with the standard deviation of its logarithm: they weigh by its
    /// inverse square.
    pub fn pooled(sayings: [(f64, f64); 2]) -> Forecast {
        let weights = sayings.map(|(_, deviation_ln)| deviation_ln.max(LEAST_DEVIATION).powi(-2));
        let sum: f64 = weights.iter().sum();
        let ln = sayings.iter().zip(weights).map(|((number, _), weight)| weight * number.ln()).sum::<f64>() / sum;
        Forecast::spread(ln.exp(), sum.sqrt().recip())
    }

    /// The sum of two numbers whose deviations know nothing of each other.
    pub fn plus(self, other: Forecast) -> Forecast {
        let expected = self.expected + other.expected;
        let below = (self.expected - self.low).hypot(other.expected - other.low);
        let above = (self.high - self.expected).hypot(other.high - other.expected);
        Forecast { expected, low: expected - below, high: expected + above }
    }

    /// The sum of two numbers that are off alike: where one is too high the other is likely to be.
    pub fn plus_alike(self, other: Forecast) -> Forecast {
        Forecast { expected: self.expected + other.expected, low: self.low + other.low, high: self.high + other.high }
    }

    /// What is left of it once so much of it is done.
    pub fn less(self, done: f64) -> Forecast {
        let left = |number: f64| (number - done).max(0.0);
        Forecast { expected: left(self.expected), low: left(self.low), high: left(self.high) }
    }

    /// So many times the number, by a factor of whose logarithm the standard deviation is known.
    pub fn times(self, factor: f64, deviation_ln: f64) -> Forecast {
        let part = |number: f64| (number / self.expected).ln() / NINE_OF_TEN;
        if self.expected <= 0.0 {
            return Forecast { expected: 0.0, low: 0.0, high: self.high * factor };
        }
        let [below, above] =
            [part(self.low).max(-MOST_DEVIATION), part(self.high)].map(|part| part.hypot(deviation_ln));
        let expected = self.expected * factor;
        Forecast {
            expected,
            low: expected * (-NINE_OF_TEN * below).exp(),
            high: expected * (NINE_OF_TEN * above).exp(),
        }
    }

    /// Whether the interval holds a number.
    pub fn holds(self, number: f64) -> bool {
        self.low <= number && number <= self.high
    }

    /// The lesser of it and a number that is known.
    pub fn at_most(self, most: f64) -> Forecast {
        Forecast { expected: self.expected.min(most), low: self.low.min(most), high: self.high.min(most) }
    }
}

/// No saying is surer than this.
const LEAST_DEVIATION: f64 = 1e-3;
/// A deviation that no interval exceeds: a number that may as well be 0.
const MOST_DEVIATION: f64 = 8.0;

/// Standard deviation of the logarithm of the work that a map will have taken, by a look at its error after a share of it.
///
/// The squared error at a look and the one at the end are each known to 2/(15 k) of their squares, from the spread of 16 replicas with k
/// effective degrees of freedom; sums that hold the same samples vary together, by the share that they have in common. Where n scores
/// carry the squared error, effectively, it is unsure by 1/√n of itself, and is taken to be by twice that: few scores tell too little of
/// how much they scatter, too.
pub fn deviation_of_work(degrees_of_freedom: f64, scores: f64, share: f64, exponent: f64) -> f64 {
    let of_spread = 4.0 / ((REPLICAS - 1) as f64 * degrees_of_freedom.max(1.0));
    ((of_spread + 4.0 / scores.max(1.0)) * (1.0 - share).clamp(0.0, 1.0)).sqrt() / (2.0 * exponent)
}

/// How many times the present work a map will have taken when the statistical checks let it end, whose error takes `needed` times that
/// work and whose squared error so many scores carry now, effectively.
///
/// After f times the work f·n scores carry it, and of a map that then bears f/needed times its squared error that many fewer are asked.
/// It is looked at when its error is small enough, and after every refusal; a map that has waited long enough is let off. A tail holds it up
/// by [`work_for_tail`].
pub fn work_to_pass(needed: f64, scores: f64, tail_spare: f64) -> f64 {
    let enough = (ENOUGH_SCORES * needed * needed / scores.max(f64::MIN_POSITIVE)).cbrt();
    let for_scores = GROWTH_AFTER_REFUSAL.powf(refusals(enough / needed)).min(LONGEST_WAIT as f64);
    needed * for_scores.max(work_for_tail(tail_spare))
}

/// How many times the work a map will have taken for a tail for which it must bear `tail_spare` times its squared error: in the middle
/// between none, if more scores show that the tail has an end, and the square of this.
pub fn work_for_tail(tail_spare: f64) -> f64 {
    GROWTH_AFTER_REFUSAL.powf(0.5 * refusals(tail_spare))
}

/// Refusals after which the work is so many times as large at least.
fn refusals(growth: f64) -> f64 {
    (growth.ln() / GROWTH_AFTER_REFUSAL.ln()).ceil().max(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::random::{Purpose, Stream};

    #[test]
    fn deviations_add_in_squares_and_what_is_done_is_known() {
        let sum =
            Forecast { expected: 10.0, low: 7.0, high: 13.0 }.plus(Forecast { expected: 20.0, low: 16.0, high: 24.0 });
        assert_eq!(sum, Forecast { expected: 30.0, low: 25.0, high: 35.0 });
        assert_eq!(sum.less(27.0), Forecast { expected: 3.0, low: 0.0, high: 8.0 });
        let pooled = Forecast::pooled([(10.0, 0.1), (1000.0, 1.0)]);
        assert!((pooled.expected - 10.0 * 100f64.powf(1.0 / 101.0)).abs() < 1e-9, "{pooled:?}");
        let slower = Forecast::known(10.0).times(2.0, 0.1);
        assert!((slower.high / 20.0 - (0.1 * NINE_OF_TEN).exp()).abs() < 1e-12, "{slower:?}");
    }

    /// Scores that suffice ask for no more work; of too few, one refusal, or as many as the longest wait takes.
    #[test]
    fn too_few_scores_take_more_work_and_never_more_than_the_longest_wait() {
        assert_eq!(work_to_pass(3.0, 1e3, 1.0), 3.0);
        // 7 scores now are 21 when the error is small enough: these do.
        assert_eq!(work_to_pass(3.0, 7.0, 1.0), 3.0);
        // 5 are 15: after another half of the work 22, of which the smaller error asks 9.
        assert_eq!(work_to_pass(3.0, 5.0, 1.0), 4.5);
        assert_eq!(work_to_pass(3.0, 0.01, 1.0), 3.0 * LONGEST_WAIT as f64);
        // Four refusals for five times the squared error, of which half are expected.
        assert_eq!(work_to_pass(3.0, 1e3, 5.0), 3.0 * 1.5 * 1.5);
        // What few scores tell is unsure.
        assert!(deviation_of_work(100.0, 4.0, 0.2, 0.5) > 3.0 * deviation_of_work(100.0, f64::INFINITY, 0.2, 0.5));
    }

    /// 2,000 runs of 16 replicas of independent entries, whose error is judged at a fifth of the work and at the end: the work that the
    /// look forecasts and the one that the end tells differ by the deviation stated, within 4 standard errors of a deviation from so
    /// many (5 %·√¼ each). Twice the degrees of freedom (the planted fault) are refused.
    #[test]
    fn the_work_forecast_by_a_look_scatters_as_stated() {
        const RUNS: usize = 2000;
        let (entries, share) = (24, 0.2);
        let mut squares = 0.0;
        for run in 0..RUNS {
            let mut stream = Stream::new(run as u64, Purpose::Pilot, 0, 0);
            stream.seek(0);
            let mut normal = || (0..12).map(|_| stream.unit()).sum::<f64>() - 6.0;
            let (mut early, mut late) = (0.0, 0.0);
            for _ in 0..entries {
                let sums: Vec<[f64; 2]> = (0..REPLICAS)
                    .map(|_| {
                        let first = f64::sqrt(share) * normal();
                        [first, first + f64::sqrt(1.0 - share) * normal()]
                    })
                    .collect();
                let spread = |of: usize| {
                    let mean = sums.iter().map(|sum| sum[of]).sum::<f64>() / REPLICAS as f64;
                    sums.iter().map(|sum| (sum[of] - mean).powi(2)).sum::<f64>()
                };
                early += spread(0) / share;
                late += spread(1);
            }
            squares += (early / late).ln().powi(2);
        }
        let measured = (squares / RUNS as f64).sqrt();
        let tolerance = 4.0 * measured / (2.0 * RUNS as f64).sqrt();
        // Shared sums carry their share of the squared spread once more: their correlation is the share itself.
        let stated = |degrees: f64| deviation_of_work(degrees, f64::INFINITY, share, 0.5);
        assert!((measured - stated(entries as f64)).abs() < tolerance, "{measured} {} ± {tolerance}", stated(24.0));
        assert!((measured - stated(2.0 * entries as f64)).abs() > tolerance, "the planted fault passed: {measured}");
    }
}
