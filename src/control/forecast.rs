//! Forecasts of a number at the end of a run, with the interval that contains it in 90 % of runs.

use serde::{Deserialize, Serialize};

use super::checks::{ENOUGH_SCORES, LONGEST_WAIT};
use super::schedule::GROWTH_AFTER_REFUSAL;
use crate::maps::REPLICAS;

/// Quantile of the normal distribution that one value in twenty exceeds: nine in ten lie within this many standard deviations.
pub const ONE_IN_TWENTY: f64 = 1.645;

/// Shares of a run's rays at which its forecasts are shown, and compared with what they forecast.
pub const FORECAST_SHARES: [f64; 4] = [0.02, 0.05, 0.2, 0.5];

/// Forecast of a number, with the interval that contains the number in 90 % of runs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Forecast {
    /// The expected number, approximately its median: as likely too high as too low.
    pub expected: f64,
    /// The number is below this in 5 % of runs.
    pub low: f64,
    /// The number is above this in 5 % of runs.
    pub high: f64,
}

impl Forecast {
    /// Forecast of a number that is known exactly.
    pub fn known(number: f64) -> Forecast {
        Forecast { expected: number, low: number, high: number }
    }

    /// Forecast of a positive number from the standard deviation of its logarithm.
    pub fn spread(expected: f64, deviation_ln: f64) -> Forecast {
        let factor = (ONE_IN_TWENTY * deviation_ln).exp();
        Forecast { expected, low: expected / factor, high: expected * factor }
    }

    /// Combines two estimates of one positive number. Each has the standard deviation of its logarithm and is weighted by the inverse
    /// square of it.
    pub fn pooled(sayings: [(f64, f64); 2]) -> Forecast {
        let weights = sayings.map(|(_, deviation_ln)| deviation_ln.max(LEAST_DEVIATION).powi(-2));
        let sum: f64 = weights.iter().sum();
        let ln = sayings.iter().zip(weights).map(|((number, _), weight)| weight * number.ln()).sum::<f64>() / sum;
        Forecast::spread(ln.exp(), sum.sqrt().recip())
    }

    /// Forecast of the sum of two numbers whose deviations are independent.
    pub fn plus(self, other: Forecast) -> Forecast {
        let expected = self.expected + other.expected;
        let below = (self.expected - self.low).hypot(other.expected - other.low);
        let above = (self.high - self.expected).hypot(other.high - other.expected);
        Forecast { expected, low: expected - below, high: expected + above }
    }

    /// Forecast of the sum of two numbers whose deviations agree: if one is too high, the other is likely to be too high too.
    pub fn plus_alike(self, other: Forecast) -> Forecast {
        Forecast { expected: self.expected + other.expected, low: self.low + other.low, high: self.high + other.high }
    }

    /// Forecast of the rest, after `done` of the number is done. No bound falls below 0.
    pub fn less(self, done: f64) -> Forecast {
        let left = |number: f64| (number - done).max(0.0);
        Forecast { expected: left(self.expected), low: left(self.low), high: left(self.high) }
    }

    /// Forecast of the number times an uncertain factor. The standard deviation of the logarithm of the factor is `deviation_ln`.
    pub fn times(self, factor: f64, deviation_ln: f64) -> Forecast {
        let part = |number: f64| (number / self.expected).ln() / ONE_IN_TWENTY;
        if self.expected <= 0.0 {
            return Forecast { expected: 0.0, low: 0.0, high: self.high * factor };
        }
        let [below, above] =
            [part(self.low).max(-MOST_DEVIATION), part(self.high)].map(|part| part.hypot(deviation_ln));
        let expected = self.expected * factor;
        Forecast {
            expected,
            low: expected * (-ONE_IN_TWENTY * below).exp(),
            high: expected * (ONE_IN_TWENTY * above).exp(),
        }
    }

    /// Whether the interval contains a number.
    pub fn holds(self, number: f64) -> bool {
        self.low <= number && number <= self.high
    }

    /// Forecast of the lesser of this number and a known one.
    pub fn at_most(self, most: f64) -> Forecast {
        Forecast { expected: self.expected.min(most), low: self.low.min(most), high: self.high.min(most) }
    }
}

/// Least standard deviation (of the logarithm) of an estimate.
const LEAST_DEVIATION: f64 = 1e-3;
/// Greatest deviation of the logarithm that an interval has. With this much, the number may as well be 0.
const MOST_DEVIATION: f64 = 8.0;

/// Standard deviation of the logarithm of the work that a map will have taken. The estimate comes from a look (error check) at `share` of
/// that work.
///
/// The squared error at the look and at the end are each known to 2/(15 k) of their squares, from the spread of 16 replicas with k
/// effective degrees of freedom. Sums that contain the same samples vary together, by the share that they have in common. If effectively n
/// scores carry the squared error, its relative uncertainty is 1/√n. Twice that is used here, since few scores also show too little of
/// their own scatter.
pub fn deviation_of_work(degrees_of_freedom: f64, scores: f64, share: f64, exponent: f64) -> f64 {
    let of_spread = 4.0 / ((REPLICAS - 1) as f64 * degrees_of_freedom.max(1.0));
    ((of_spread + 4.0 / scores.max(1.0)) * (1.0 - share).clamp(0.0, 1.0)).sqrt() / (2.0 * exponent)
}

/// Work at which the statistical checks let a map end, as a multiple of the present work. The error of the map needs `needed` times the
/// present work. Effectively `scores` scores carry its squared error now.
///
/// After f times the work, f·n scores carry it. The map then tolerates f/needed times its squared error, so the required number of scores
/// falls by the square of that. The map is judged when its error is small enough, and again after every refusal. A map that has waited long
/// enough passes. A heavy tail delays it by [`work_for_tail`].
pub fn work_to_pass(needed: f64, scores: f64, tail_spare: f64) -> f64 {
    let enough = (ENOUGH_SCORES * needed * needed / scores.max(f64::MIN_POSITIVE)).cbrt();
    let for_scores = GROWTH_AFTER_REFUSAL.powf(refusals(enough / needed)).min(LONGEST_WAIT as f64);
    needed * for_scores.max(work_for_tail(tail_spare))
}

/// Factor on the work of a map with a heavy tail, for which it must tolerate `tail_spare` times its squared error. It is the geometric mean
/// of two cases: no delay, if more scores show that the tail has an end, and the full delay.
pub fn work_for_tail(tail_spare: f64) -> f64 {
    GROWTH_AFTER_REFUSAL.powf(0.5 * refusals(tail_spare))
}

/// Number of refusals after which the work has grown at least `growth` times.
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
        assert!((slower.high / 20.0 - (0.1 * ONE_IN_TWENTY).exp()).abs() < 1e-12, "{slower:?}");
    }

    /// Enough scores require no more work. Too few require one refusal, or as many as the longest wait takes.
    #[test]
    fn too_few_scores_take_more_work_and_never_more_than_the_longest_wait() {
        assert_eq!(work_to_pass(3.0, 1e3, 1.0), 3.0);
        // 7 scores now become 21 when the error is small enough: that is enough.
        assert_eq!(work_to_pass(3.0, 7.0, 1.0), 3.0);
        // 5 become 15. After half of the work again they are 22, and the smaller error requires 9.
        assert_eq!(work_to_pass(3.0, 5.0, 1.0), 4.5);
        assert_eq!(work_to_pass(3.0, 0.01, 1.0), 3.0 * LONGEST_WAIT as f64);
        // Four refusals for five times the squared error. Half of them are expected.
        assert_eq!(work_to_pass(3.0, 1e3, 5.0), 3.0 * 1.5 * 1.5);
        // An estimate from few scores is uncertain.
        assert!(deviation_of_work(100.0, 4.0, 0.2, 0.5) > 3.0 * deviation_of_work(100.0, f64::INFINITY, 0.2, 0.5));
    }

    /// 2,000 runs of 16 replicas of independent entries. The error is judged at a fifth of the work and at the end. The work forecast at
    /// the look differs from the work known at the end by the stated deviation, within 4 standard errors of a deviation from 2,000 runs
    /// (1.6 % of it each). With twice the degrees of freedom (the planted fault) the test fails.
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
        // Shared sums contribute their share of the squared spread once more: their correlation is the share itself.
        let stated = |degrees: f64| deviation_of_work(degrees, f64::INFINITY, share, 0.5);
        assert!((measured - stated(entries as f64)).abs() < tolerance, "{measured} {} ± {tolerance}", stated(24.0));
        assert!((measured - stated(2.0 * entries as f64)).abs() > tolerance, "the planted fault passed: {measured}");
    }
}
