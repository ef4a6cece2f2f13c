//! Bounds on the plan of a map that gathers. They follow from the uncertainty of the measured numbers that the plan uses.

use super::GatheringParts;
use super::forecast::ONE_IN_TWENTY;
use crate::maps::REPLICAS;

/// Uncertainty assumed for the cells' squared error, in its standard errors. The walks that the plan itself adds make this error better
/// known, so the factor is smaller than the one that 1 run in 20 exceeds. Measured in six kinds of rooms.
const OF_BIAS: f64 = 0.8;
/// A variance is assumed to be at least this share of the measured one.
const LEAST_VARIANCE: f64 = 0.25;

impl GatheringParts {
    /// Bounds on the rays, beyond those so far, with which the plan reaches a target. Each bound takes all measured numbers as low,
    /// or as high, as they are in one run of twenty.
    ///
    /// The plan itself always lies within the bounds. It can lie outside the two computed values: walks that find less bias subtract less
    /// of it, and the bias that they do not know may then need more walks. A variance is known to 2/(15 k) of its square, k being the
    /// degrees of freedom. The cells' squared error is known to its own standard error.
    pub fn bounds(&self, target_lx: f64) -> [f64; 2] {
        let of_variance = (2.0 / ((REPLICAS - 1) as f64 * self.degrees_of_freedom.max(1.0))).sqrt();
        let planned = self.rays_of_growth(target_lx);
        let bounds = [-1.0, 1.0].map(|sign| {
            let mut parts = *self;
            let factor = (1.0 + sign * ONE_IN_TWENTY * of_variance).max(LEAST_VARIANCE);
            parts.squared_lx2.iter_mut().for_each(|squared| *squared *= factor);
            for (common, error) in parts.residuals.common.iter_mut().zip(self.residuals.standard_error) {
                *common += sign * OF_BIAS * error;
            }
            parts.rays_of_growth(target_lx)
        });
        [bounds[0].min(bounds[1]).min(planned), bounds[0].max(bounds[1]).max(planned)]
    }

    /// Rays of the plan. For a plan that does not reach the target: the rays of the largest growth tried, at most [`BEYOND`] times the rays
    /// so far.
    fn rays_of_growth(&self, target_lx: f64) -> f64 {
        let growth = self.growth(target_lx);
        if growth.reaches { growth.rays } else { growth.rays.min(BEYOND * self.rays.iter().sum::<f64>()) }
    }
}

/// Upper bound of the rays of a plan that does not reach the target, as a multiple of the rays so far.
const BEYOND: f64 = 30.0;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::control::KINDS;
    use crate::maps::ResidualState;

    /// The bounds contain the plan. They lie farther apart if walks know less of the cells' error.
    #[test]
    fn bounds_hold_the_plan_and_part_with_ignorance() {
        let parts = |standard_error: f64| GatheringParts {
            squared_lx2: [0.01, 4.0, 0.01],
            rays: [1e5; KINDS],
            residuals: ResidualState {
                common: [0.0, 0.5, 0.0],
                standard_error: [0.0, standard_error, 0.0],
                variance: [0.0, 1.0, 0.0],
                ..ResidualState::default()
            },
            degrees_of_freedom: 100.0,
        };
        let spread = |standard_error: f64| {
            let [low, high] = parts(standard_error).bounds(1.0);
            let planned = parts(standard_error).growth(1.0).rays;
            assert!(low <= planned && planned <= high, "{low} {planned} {high}");
            high / low
        };
        assert!(spread(1.0) > spread(0.01), "{} {}", spread(1.0), spread(0.01));
    }
}
