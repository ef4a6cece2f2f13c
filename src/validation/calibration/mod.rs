//! Calibration: many runs of cases whose truth is known tell whether error bars, stop rule and forecast keep what they
//! promise.
//!
//! A case of the group `calibration` lends its scene and its truths; chains and targets of its own runs do not count.

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
/// A campaign of so many seeds is judged by the plain share that the method promises, too.
const FULL: usize = 300;
/// Share of the runs of a full campaign that must truly meet their target.
const FULL_SHARE: f64 = 0.925;
/// A map of so many degrees of freedom is asked to stop within this factor of an oracle's work.
const MANY_DEGREES: f64 = 200.0;
const FACTOR_OF_MANY: f64 = 1.3;
/// The same over χ²(k, 95%)/k for maps of fewer.
const FACTOR_OF_FEW: f64 = 1.2;
/// Coverage may deviate from its nominal value by this much, and by three of its own standard errors.
const COVERAGE_ALLOWANCE: f64 = 0.02;
/// What error bars of two standard errors are held to: 95.4%.
pub(super) const NOMINAL: f64 = 0.954;

/// |t| that Student's t stays within with this probability.
pub(super) fn student_within(probability: f64, degrees_of_freedom: f64) -> f64 {
    StudentsT::new(0.0, 1.0, degrees_of_freedom.max(1.0))
        .map_or(f64::INFINITY, |t| t.inverse_cdf(0.5 + 0.5 * probability))
}

/// Fewest of so many runs that may truly meet their target, if each does with the promised probability.
pub fn fewest_met(runs: usize) -> usize {
    let Ok(count) = Binomial::new(CONFIDENCE, runs as u64) else {
        return runs;
    };
    let by_chance = (0..=runs as u64).find(|met| count.cdf(*met) > ALPHA).unwrap_or(0) as usize;
    if runs >= FULL { by_chance.max((FULL_SHARE * runs as f64).ceil() as usize) } else { by_chance }
}

/// How many times an oracle's work a map of so many degrees of freedom may take.
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
