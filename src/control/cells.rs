//! What a map that asks cells needs next: rays, samples of cells, walks or passes over direct light.
//!
//! Four variances and four costs are measured at every look. The next step is the growth of the four that is predicted to reach
//! the target with the fewest rays.

use super::margin;
use crate::maps::ResidualState;

/// Kinds of work: passes over direct light, gathering rays, samples of cells, residual walks.
pub const KINDS: usize = 4;

/// What a look at a map that asks cells has shown.
#[derive(Clone, Copy, Debug, Default)]
pub struct CellParts {
    /// Squared errors in lx² of the mean over all replicas: of direct light, rays, cells and walks.
    pub squared_lx2: [f64; KINDS],
    /// Rays so far of each.
    pub rays: [f64; KINDS],
    /// Share of the samples that lie in cells which want no more.
    pub full_share: f64,
    /// What walks say of the bias.
    pub residuals: ResidualState,
    /// Effective degrees of freedom of the map's error.
    pub degrees_of_freedom: f64,
}

/// Factors by which each kind of work is to grow.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CellGrowth {
    /// Of each kind: 1 or more.
    pub factors: [f64; KINDS],
    /// Rays that it takes, beyond those so far.
    pub rays: f64,
    /// Whether the target is predicted to be met then.
    pub reaches: bool,
}

/// Step and number of the factors that are tried.
const STEP: f64 = 1.4;
const STEPS: i32 = 17;
/// Share of the squared target that the prediction may fill: it is a prediction.
const FILLED: f64 = 0.9;

impl CellParts {
    /// Squared error in lx² that would be judged after such growth.
    fn judged_lx2(&self, factors: [f64; KINDS], margin: f64) -> f64 {
        let [direct, rays, cells, walks] = factors;
        // Rays are quasi-random; samples of cells that are not full grow with the rays that ask.
        let samples = (1.0 - self.full_share) * rays + self.full_share * cells;
        let by = [direct, rays.powf(RAY_POWER), samples, walks];
        let random: f64 = self.squared_lx2.iter().zip(by).map(|(squared, factor)| squared / factor).sum();
        margin * margin * random + self.residuals.left_lx2(walks)
    }

    /// Rays that such growth takes.
    fn rays_for(&self, [direct, rays, cells, walks]: [f64; KINDS]) -> f64 {
        let samples = (1.0 - self.full_share) * rays + self.full_share * cells.min(rays);
        let more = [direct - 1.0, rays - 1.0, samples - 1.0, walks - 1.0];
        self.rays.iter().zip(more).map(|(done, more)| done * more).sum()
    }

    /// The cheapest growth to a target in lx.
    pub fn growth(&self, target_lx: f64) -> CellGrowth {
        let margin = margin(self.degrees_of_freedom);
        let goal_lx2 = FILLED * target_lx * target_lx;
        let factors: Vec<f64> = (0..STEPS).map(|step| STEP.powi(step)).collect();
        let mut best = CellGrowth { factors: [factors[factors.len() - 1]; KINDS], rays: f64::INFINITY, reaches: false };
        for walks in &factors {
            if self.residuals.left_lx2(*walks) > goal_lx2 {
                continue;
            }
            for rays in &factors {
                for cells in &factors {
                    // Cells take samples where rays ask: they cannot grow faster.
                    if cells > rays && self.full_share > 0.0 {
                        break;
                    }
                    for direct in &factors {
                        let tried = [*direct, *rays, *cells, *walks];
                        if self.judged_lx2(tried, margin) > goal_lx2 {
                            continue;
                        }
                        let cost = self.rays_for(tried);
                        if cost < best.rays {
                            best = CellGrowth { factors: tried, rays: cost, reaches: true };
                        }
                        break;
                    }
                }
            }
        }
        if !best.reaches {
            best.rays = self.rays_for(best.factors);
        }
        best
    }
}

/// Power of the number of rays with which the variance of quasi-random rays falls, about.
const RAY_POWER: f64 = 1.2;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_leads_grows_and_what_is_right_stays() {
        let parts = CellParts {
            squared_lx2: [0.01, 4.0, 0.01, 0.01],
            rays: [1e5; KINDS],
            full_share: 1.0,
            degrees_of_freedom: 1000.0,
            ..CellParts::default()
        };
        let growth = parts.growth(1.0);
        assert!(growth.reaches && growth.factors[1] > 3.0, "{growth:?}");
        assert!([0, 2, 3].iter().all(|kind| growth.factors[*kind] < 1.5), "{growth:?}");
    }

    #[test]
    fn ignorance_of_the_bias_asks_for_walks() {
        let residuals = ResidualState { standard_error: [0.0, 4.0], variance: [0.0, 1.0], ..ResidualState::default() };
        let parts = CellParts {
            squared_lx2: [0.01; KINDS],
            rays: [1e5; KINDS],
            full_share: 1.0,
            residuals,
            degrees_of_freedom: 1000.0,
        };
        let growth = parts.growth(1.0);
        assert!(growth.reaches && growth.factors[3] > 2.0 && growth.factors[1] == 1.0, "{growth:?}");
    }
}
