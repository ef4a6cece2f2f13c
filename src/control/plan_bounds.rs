//! How far the plan of a map that gathers may be off, by what is known of the numbers that it goes by.

use super::GatheringParts;
use super::forecast::NINE_OF_TEN;
use crate::maps::REPLICAS;

/// Standard errors by which the cells' squared error is taken to be off: it is known the better the more walks the plan itself adds, so
/// that fewer do than those beyond which one run of twenty lies. Measured in six kinds of rooms.
const OF_BIAS: f64 = 0.8;
/// A variance is taken to be this share of what was measured at least.
const LEAST_SHARE: f64 = 0.25;

impl GatheringParts {
    /// Rays beyond those so far by which the plan reaches a target in lx, where all that was measured is as low, and as high, as it is
    /// in one run of twenty.
    ///
    /// The plan itself lies within: where walks find less bias they take less of it off, and what they do not know of it may then take
    /// more walks. Variances are known to 2/(15 k) of their squares, the cells' squared error by its own standard error.
    pub fn bounds(&self, target_lx: f64) -> [f64; 2] {
        let of_variance = (2.0 / ((REPLICAS - 1) as f64 * self.degrees_of_freedom.max(1.0))).sqrt();
        let planned = self.rays_of_growth(target_lx);
        let bounds = [-1.0, 1.0].map(|sign| {
            let mut parts = *self;
            let factor = (1.0 + sign * NINE_OF_TEN * of_variance).max(LEAST_SHARE);
            parts.squared_lx2.iter_mut().for_each(|squared| *squared *= factor);
            for (common, error) in parts.residuals.common.iter_mut().zip(self.residuals.standard_error) {
                *common += sign * OF_BIAS * error;
            }
            parts.rays_of_growth(target_lx)
        });
        [bounds[0].min(bounds[1]).min(planned), bounds[0].max(bounds[1]).max(planned)]
    }

    /// Rays of the plan; beyond what can be planned lies the most that was tried.
    fn rays_of_growth(&self, target_lx: f64) -> f64 {
        let growth = self.growth(target_lx);
        if growth.reaches { growth.rays } else { growth.rays.min(BEYOND * self.rays.iter().sum::<f64>()) }
    }
}

/// A plan that does not reach is taken to take so many times the rays so far.
const BEYOND: f64 = 30.0;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::control::KINDS;
    use crate::maps::ResidualState;

    /// The bounds hold the plan, and lie the farther apart the less walks know of the cells.
    #[test]
    fn bounds_hold_the_plan_and_part_with_ignorance() {
        let parts = |standard_error: f64| GatheringParts {
            squared_lx2: [0.01, 4.0, 0.01],
            rays: [1e5; KINDS],
            residuals: ResidualState {
                common: [0.0, 0.5],
                standard_error: [0.0, standard_error],
                variance: [0.0, 1.0],
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
