//! Calibration: many runs of cases with known truth test whether error bars, stop rule and forecast are reliable.
//!
//! A case of the group `calibration` provides its scene and its truths. The chains and targets of its own runs are not used.

mod bias;
mod campaign;
mod pictures;
mod report;

pub use campaign::{Campaign, CampaignSettings, SeedRun, calibrate};
pub use report::{calibration_csv, calibration_html, calibration_md, calibration_pictures, calibration_table};

use statrs::distribution::{Binomial, ChiSquared, ContinuousCDF, DiscreteCDF, StudentsT};

use crate::control::CONFIDENCE;

/// Probability with which an honest campaign fails one of its bounds.
const ALPHA: f64 = 0.01;
/// A campaign with this many seeds must also reach the plain share `FULL_SHARE`.
const FULL: usize = 300;
/// Minimum share of the runs of a full campaign that must truly meet their target.
const FULL_SHARE: f64 = 0.925;
/// From this many degrees of freedom on, a map must stop within `FACTOR_OF_MANY` times an oracle's work.
const MANY_DEGREES: f64 = 200.0;
const FACTOR_OF_MANY: f64 = 1.3;
/// The factor on χ²(k, 95%)/k for maps of fewer degrees of freedom k.
const FACTOR_OF_FEW: f64 = 1.2;
/// Maximum deviation of the coverage from its nominal value, in addition to three of its own standard errors.
const COVERAGE_ALLOWANCE: f64 = 0.02;
/// Nominal probability of error bars of two standard errors: 95.4%.
pub(super) const NOMINAL: f64 = 0.954;

/// |t| that Student's t stays within with this probability.
pub(super) fn student_within(probability: f64, degrees_of_freedom: f64) -> f64 {
    StudentsT::new(0.0, 1.0, degrees_of_freedom.max(1.0))
        .map_or(f64::INFINITY, |t| t.inverse_cdf(0.5 + 0.5 * probability))
}

/// Smallest number of `runs` that must truly meet their target, if each does so with the promised probability.
pub fn fewest_met(runs: usize) -> usize {
    let Ok(count) = Binomial::new(CONFIDENCE, runs as u64) else {
        return runs;
    };
    let by_chance = (0..=runs as u64).find(|met| count.cdf(*met) > ALPHA).unwrap_or(0) as usize;
    if runs >= FULL { by_chance.max((FULL_SHARE * runs as f64).ceil() as usize) } else { by_chance }
}

/// Maximum work relative to an oracle's work for a map of this many degrees of freedom.
pub fn most_cost(degrees_of_freedom: f64) -> f64 {
    if degrees_of_freedom >= MANY_DEGREES {
        return FACTOR_OF_MANY;
    }
    let k = degrees_of_freedom.max(1.0);
    ChiSquared::new(k).map_or(f64::INFINITY, |chi| FACTOR_OF_FEW * chi.inverse_cdf(CONFIDENCE) / k)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bounds_are_those_of_the_binomial_and_of_chi_square() {
        // P(X ≤ 52) = 1.0% and P(X ≤ 51) = 0.3% for 60 runs at 95%, from the binomial's terms.
        assert_eq!(fewest_met(60), 53);
        assert_eq!(fewest_met(300), 278);
        assert_eq!(most_cost(2400.0), 1.3);
        // χ²(3, 95%) = 7.815.
        assert!((most_cost(3.0) - 1.2 * 7.815 / 3.0).abs() < 1e-3);
        assert!((student_within(NOMINAL, 15.0) - 2.174).abs() < 3e-3);
    }
}
