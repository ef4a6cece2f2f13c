//! The stop rule, and the work at which it will accept a map.

use statrs::distribution::{Continuous, ContinuousCDF, FisherSnedecor};

use crate::maps::{Judgement, REPLICAS};

/// At least this share of the runs that report "target met" have a true error at or below the target.
pub const CONFIDENCE: f64 = 0.95;

/// Exponent α of error ∝ work^(−α) for independent samples.
pub const EXPONENT_OF_INDEPENDENT_SAMPLES: f64 = 0.5;

/// Above this many degrees of freedom the margin is within 0.2% of 1 and no longer changes.
const MOST_DEGREES: f64 = 1e6;

/// Step of the logarithm of a quantile below which it is known, and most steps; halving the bounds alone would take no more.
const LEAST_STEP: f64 = 1e-13;
const MOST_STEPS: u32 = 60;

/// Factor by which the expected error must lie below the target, so that the true error is below the target with [`CONFIDENCE`].
///
/// The true squared error of a run is its expectation times χ²_k/k. The expectation is estimated from the spread of the replicas with 15 k
/// degrees of freedom. The two are independent, so their ratio follows Fisher's F(k, 15 k). The margin is the root of its 95% quantile:
/// docs/methods.md (10).
pub fn margin(degrees_of_freedom: f64) -> f64 {
    let k = degrees_of_freedom.clamp(1.0, MOST_DEGREES);
    fisher_quantile([k, (REPLICAS - 1) as f64 * k], CONFIDENCE).sqrt()
}

/// Quantile of F with these degrees of freedom, by Newton's method for its logarithm within bounds that close in. Valid for probabilities of
/// at least one half and for quantiles up to e¹².
pub(super) fn fisher_quantile([numerator, denominator]: [f64; 2], probability: f64) -> f64 {
    let Ok(f) = FisherSnedecor::new(numerator, denominator) else {
        return f64::INFINITY;
    };
    let (mut low, mut high, mut ln) = (-1.0f64, 12.0f64, 0.0f64);
    for _ in 0..MOST_STEPS {
        let quantile = ln.exp();
        let excess = f.cdf(quantile) - probability;
        if excess < 0.0 {
            low = ln
        } else {
            high = ln
        }
        let newton = ln - excess / (f.pdf(quantile) * quantile);
        let next = if (low..=high).contains(&newton) { newton } else { 0.5 * (low + high) };
        if (next - ln).abs() < LEAST_STEP {
            return next.exp();
        }
        ln = next;
    }
    ln.exp()
}

/// Whether the error of a map is small enough for the target (a fraction of the mean). Two errors must be at or below the target: the
/// expected random error times the margin, and the random error of the halves. Each is combined in quadrature with the error that the
/// halves share (bias and discretisation): docs/methods.md, section 6.
///
/// Three kinds of maps are always refused: a dark map, a map in which nothing has bounced yet, and a map whose mean is not above 0. In the
/// last, corrections may outweigh the little light that they correct.
pub fn accepts(target_error: f64, judgement: &Judgement) -> bool {
    if judgement.dark || judgement.unseen || !judgement.expected_error.is_finite() || judgement.mean <= 0.0 {
        return false;
    }
    let safe_error = judgement.expected_error * margin(judgement.degrees_of_freedom);
    safe_error.hypot(judgement.shared_error()) <= target_error && judgement.stated_error() <= target_error
}

/// Work at which the rule accepts a map, as a multiple of the present work. Assumes random error ∝ work^(−α). Infinite if the shared error
/// (bias and discretisation) alone reaches the target, and for a map that is always refused.
pub fn needed_work(target_error: f64, judgement: &Judgement, exponent: f64) -> f64 {
    if judgement.dark || judgement.unseen || judgement.mean <= 0.0 || judgement.shared_error() >= target_error {
        return f64::INFINITY;
    }
    let safe_error = judgement.expected_error * margin(judgement.degrees_of_freedom);
    let squared = safe_error.powi(2) / (target_error * target_error - judgement.shared_error().powi(2));
    squared.powf(0.5 / exponent)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn judged(expected_error: f64, halves_error: f64, degrees_of_freedom: f64) -> Judgement {
        Judgement { mean: 100.0, halves_error, expected_error, degrees_of_freedom, ..Judgement::default() }
    }

    #[test]
    fn the_margin_is_the_root_of_fishers_quantile() {
        // Tabulated F quantiles at 95%: F(1,15) = 4.543, F(2,30) = 3.316, F(4,60) = 2.525, F(8,120) = 2.016.
        for (k, f) in [(1.0, 4.543), (2.0, 3.316), (4.0, 2.525), (8.0, 2.016)] {
            assert!((margin(k).powi(2) - f).abs() < 2e-3, "{k}: {}", margin(k).powi(2));
        }
        assert!(margin(2400.0) < 1.03 && margin(2400.0) > 1.0);
    }

    /// The distribution function at the quantile is the probability, from few to very many degrees of freedom.
    #[test]
    fn a_quantile_has_its_probability() {
        for (degrees, probability) in
            [([1.0, 15.0], 0.95), ([1e6, 1.5e7], 0.95), ([7.0, 7.0], 0.9999), ([3.7, 55.0], 0.5), ([1e6, 1e6], 0.999)]
        {
            let f = FisherSnedecor::new(degrees[0], degrees[1]).expect("degrees of freedom above 0");
            let found = f.cdf(fisher_quantile(degrees, probability));
            assert!((found - probability).abs() < 1e-9, "{degrees:?} {probability}: {found}");
        }
    }

    #[test]
    fn the_rule_does_not_fire_at_a_noisy_dip() {
        assert!(accepts(0.01, &judged(0.0095, 0.0095, 2400.0)));
        assert!(
            !accepts(0.01, &judged(0.0095, 0.0095, 3.0)),
            "three degrees of freedom prove nothing at 5% under the target"
        );
        assert!(!accepts(0.01, &judged(0.02, 0.001, 2400.0)), "a lucky pair of halves must not stop the run");
        assert!(!accepts(0.01, &judged(f64::NAN, 0.0, 10.0)));
        assert!(!accepts(0.01, &Judgement { dark: true, ..judged(0.0, 0.0, 1.0) }));
        assert!(!accepts(0.01, &Judgement { unseen: true, ..judged(0.0, 0.0, 1.0) }));
        assert!(!accepts(0.01, &Judgement { mean: -1.0, ..judged(0.0, 0.0, 1.0) }), "an error of no mean is none");
    }

    #[test]
    fn work_grows_with_the_square_of_the_error_or_as_the_exponent_says() {
        let twice = needed_work(0.01, &judged(0.02, 0.02, 1e6), 0.5);
        assert!((twice - 4.0).abs() < 0.05, "{twice}");
        let twice = needed_work(0.01, &judged(0.02, 0.02, 1e6), 1.0);
        assert!((twice - 2.0).abs() < 0.05, "{twice}");
    }
}
