//! What a map that asks cells needs next: rays, fuller cells, walks or passes over direct light.
//!
//! Four variances and four costs are measured at every look. The next step is the growth of the four that is predicted to reach
//! the target with the fewest rays.

use super::margin;
use crate::maps::ResidualState;

/// Kinds of work: passes over direct light, gathering rays, filling of cells, residual walks.
pub const KINDS: usize = 4;

/// What a look at a map that asks cells has shown.
#[derive(Clone, Copy, Debug, Default)]
pub struct CellParts {
    /// Squared errors in lx² of the mean over all replicas: of direct light, rays, cells and walks.
    pub squared_lx2: [f64; KINDS],
    /// Rays so far of each.
    pub rays: [f64; KINDS],
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
    /// Whether all entries are to walk, so many times as often as some do.
    pub all_walk: bool,
    /// Rays that it takes, beyond those so far.
    pub rays: f64,
    /// Whether the target is predicted to be met then.
    pub reaches: bool,
}

/// Step and number of the growths of walks that are tried.
const STEP: f64 = 1.15;
const STEPS: i32 = 40;
/// Share of the squared target that the prediction may fill: it is a prediction.
const FILLED: f64 = 0.95;

impl CellParts {
    /// Rays that such growth takes.
    fn rays_for(&self, factors: [f64; KINDS]) -> f64 {
        self.rays.iter().zip(factors).map(|(done, factor)| done * (factor - 1.0)).sum()
    }

    /// The cheapest growth to a target in lx.
    ///
    /// Walks act on what is left of the bias too, so that some growths of theirs are tried. The rest is a sum of variances vᵢ that
    /// fall as 1/fᵢ at cost cᵢ fᵢ: it is cheapest where every f is max(1, μ √(v/c)), with one μ for all.
    pub fn growth(&self, target_lx: f64) -> CellGrowth {
        let margin = margin(self.degrees_of_freedom);
        let goal_lx2 = FILLED * target_lx * target_lx;
        let most = STEP.powi(STEPS - 1);
        let silent = self.residuals.silent_share;
        let mut best =
            CellGrowth { factors: [most; KINDS], all_walk: silent > 0.0, rays: f64::INFINITY, reaches: false };
        let growths = (0..STEPS).map(|step| (STEP.powi(step), false));
        // Where some entries walk, all may, each as often as those did or more.
        let over_all = growths.clone().map(|(walks, _)| (walks, true)).filter(|_| silent > 0.0);
        for (walks, all_walk) in growths.chain(over_all) {
            let residuals = if all_walk { self.residuals.over_all() } else { self.residuals };
            let left_lx2 = goal_lx2 - residuals.left_lx2(walks);
            let squared_lx2 = self.squared_lx2[WALKS] / walks;
            let may_have_lx2 = left_lx2 / (margin * margin) - squared_lx2;
            if left_lx2 <= 0.0 || may_have_lx2 <= 0.0 {
                continue;
            }
            let factors = self.cheapest(may_have_lx2, walks);
            let of_others = if all_walk { self.rays[WALKS] * walks * silent / (1.0 - silent) } else { 0.0 };
            let rays = self.rays_for(factors) + of_others;
            if factors.iter().all(|factor| *factor <= most) && rays < best.rays {
                best = CellGrowth { factors, all_walk, rays, reaches: true };
            }
        }
        if !best.reaches {
            best.rays = self.rays_for(best.factors);
        }
        best
    }

    /// The cheapest growths of all but walks to a sum of variances in lx².
    fn cheapest(&self, may_have_lx2: f64, walks: f64) -> [f64; KINDS] {
        let kinds = 0..WALKS;
        let merit = |kind: usize| (self.squared_lx2[kind].max(0.0) / self.rays[kind]).sqrt();
        // What does not grow keeps its variance; the more it is, the faster the others have to grow, and the fewer stay.
        let mut grows = [true; WALKS];
        loop {
            let kept: f64 = kinds.clone().filter(|kind| !grows[*kind]).map(|kind| self.squared_lx2[kind]).sum();
            let growing = kinds.clone().filter(|kind| grows[*kind] && self.squared_lx2[*kind] > 0.0);
            let sum: f64 = growing.map(|kind| self.squared_lx2[kind] / merit(kind)).sum();
            let scale = if may_have_lx2 > kept { sum / (may_have_lx2 - kept) } else { f64::INFINITY };
            let too_slow = kinds.clone().find(|kind| grows[*kind] && !(scale * merit(*kind) > 1.0));
            match too_slow {
                Some(kind) => grows[kind] = false,
                None => {
                    let factor = |kind: usize| match (kind == WALKS, kind < WALKS && grows[kind]) {
                        (true, _) => walks,
                        (_, true) => scale * merit(kind),
                        _ => 1.0,
                    };
                    return std::array::from_fn(factor);
                }
            }
        }
    }
}

/// The kind of work that walks are.
const WALKS: usize = KINDS - 1;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_leads_grows_and_what_is_right_stays() {
        let parts = CellParts {
            squared_lx2: [0.01, 4.0, 0.01, 0.01],
            rays: [1e5; KINDS],
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
        let parts = CellParts { squared_lx2: [0.01; KINDS], rays: [1e5; KINDS], residuals, degrees_of_freedom: 1000.0 };
        let growth = parts.growth(1.0);
        assert!(growth.reaches && growth.factors[3] > 2.0 && growth.factors[1] == 1.0, "{growth:?}");
    }
}
