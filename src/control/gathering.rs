//! Decides what a map that gathers needs next: rays, fuller cells, walks or passes over direct light.
//!
//! Every look (error check) measures the variances and costs of these four kinds of work. The next step is the combination of growths that
//! is predicted to reach the target with the fewest rays.

use serde::{Deserialize, Serialize};

use super::margin;
use crate::maps::{REPLICAS, ResidualState};

/// Kinds of work: passes over direct light, gathering rays, filling of cells, residual walks.
pub const KINDS: usize = 4;
const WALKS: usize = 3;
/// Kinds of work whose variance falls with their own work and affects nothing else: direct light and rays.
const PLAIN: usize = 2;

/// Measurements of one look (error check) at a map that gathers.
#[derive(Clone, Copy, Debug, Default)]
pub struct GatheringParts {
    /// Squared errors in lx² of the mean over all replicas, of three parts: direct light, rays, and the correction by walks.
    pub squared_lx2: [f64; 3],
    /// Rays so far, for each kind of work.
    pub rays: [f64; KINDS],
    /// Estimates of the cells' error by residual walks.
    pub residuals: ResidualState,
    /// Effective degrees of freedom of the map's error.
    pub degrees_of_freedom: f64,
}

/// Factors by which each kind of work is to grow.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct GatheringGrowth {
    /// Factor of each kind, 1 or more.
    pub factors: [f64; KINDS],
    /// Whether all entries are to walk, each `factors[WALKS]` times as often as the entries that already walk. Otherwise only those entries
    /// walk.
    pub all_walk: bool,
    /// Rays that the growth takes, beyond those so far.
    pub rays: f64,
    /// Whether this growth is predicted to meet the target.
    pub reaches: bool,
}

/// Ratio of one step, and numbers of steps, of the growths of walks and of filling that are tried.
const STEP: f64 = 1.15;
const WALK_STEPS: i32 = 40;
const FILL_STEPS: i32 = 24;
/// Variances of direct light and of gathering rays fall with this power β of the rays, since their points are quasi-random. In 24 steps from
/// one look to the next, mostly by four times the rays, it was 1.04 to 1.58 for gathering rays of six made-up rooms, 1.27 in the median. For
/// direct light it scatters more (0.3 to 2.3 in 9 steps).
const POWER: f64 = 1.25;
/// Share of the squared target that the predicted squared error may take. It is below 1 because it is a prediction.
const FILLED: f64 = 0.95;

impl GatheringParts {
    /// Returns the cheapest growth that reaches a target in lx.
    ///
    /// Walks and filling act together on the remaining error of the cells, so a grid of their growths is tried. The rest is a sum of
    /// variances vᵢ that fall as 1/fᵢ^β at cost cᵢ fᵢ. It is cheapest if every f is max(1, μ (v/c)^(1/(1 + β))), with one μ for all.
    pub fn growth(&self, target_lx: f64) -> GatheringGrowth {
        let margin = margin(self.degrees_of_freedom);
        let goal_lx2 = FILLED * target_lx * target_lx;
        let most = STEP.powi(WALK_STEPS - 1);
        let silent = self.residuals.silent_share;
        // The variance of the correction is measured as a whole. What cells do not explain of it is that of the map's mean, which is corrected
        // in full, whatever the cells' error is.
        let [measured_lx2, expected_lx2] = [self.squared_lx2[PLAIN], self.residuals.correction_lx2() / REPLICAS as f64];
        let of_scales = (measured_lx2 / expected_lx2).min(1.0) / REPLICAS as f64;
        let of_mean_lx2 = (measured_lx2 - expected_lx2).max(0.0);
        let merits =
            std::array::from_fn(|kind| (self.squared_lx2[kind].max(0.0) / self.rays[kind]).powf(1.0 / (1.0 + POWER)));
        let mut best =
            GatheringGrowth { factors: [most; KINDS], all_walk: silent > 0.0, rays: f64::INFINITY, reaches: false };
        let steps = |count: i32| (0..count).map(|step| STEP.powi(step));
        // If only some entries walk, all may. Each then walks at least as often as those did.
        for all_walk in [false, true].into_iter().take(if silent > 0.0 { 2 } else { 1 }) {
            let residuals = if all_walk { self.residuals.over_all() } else { self.residuals };
            let walkers = if all_walk { 1.0 / (1.0 - silent) } else { 1.0 };
            for (walks, fills) in steps(WALK_STEPS).flat_map(|walks| steps(FILL_STEPS).map(move |fills| (walks, fills)))
            {
                let expected = residuals.expected(walks, fills);
                let left = expected.remaining_lx2();
                let of_chance_lx2 = (goal_lx2 - left.common) / (margin * margin);
                let correction_lx2 = of_mean_lx2 / walks + of_scales * expected.correction_lx2();
                let may_have_lx2 = of_chance_lx2 - left.chance - correction_lx2;
                if may_have_lx2 <= 0.0 {
                    continue;
                }
                let [direct, rays] = self.cheapest(merits, may_have_lx2);
                let factors = [direct, rays, fills, walks];
                let more = |kind: usize| {
                    let wider = if kind == WALKS { walkers } else { 1.0 };
                    self.rays[kind] * (wider * factors[kind] - 1.0)
                };
                let more_rays = (0..KINDS).map(more).sum();
                if more_rays < best.rays {
                    best = GatheringGrowth { factors, all_walk, rays: more_rays, reaches: true };
                }
            }
        }
        if !best.reaches {
            best.rays = (0..KINDS).map(|kind| self.rays[kind] * (most - 1.0)).sum();
        }
        best
    }

    /// Returns the cheapest growth that brings indirect light alone to an error in lx.
    pub fn growth_of_indirect(&self, error_lx: f64) -> GatheringGrowth {
        let [_, of_rays, of_walks] = self.squared_lx2;
        let parts =
            GatheringParts { squared_lx2: [0.0, of_rays, of_walks], degrees_of_freedom: f64::INFINITY, ..*self };
        parts.growth(error_lx)
    }

    /// The cheapest growths of direct light and rays that bring the sum of their variances to `may_have_lx2`. `merits` are their
    /// (v/c)^(1/(1 + β)), so v over the merit to the power β is the merit times c.
    fn cheapest(&self, merits: [f64; PLAIN], may_have_lx2: f64) -> [f64; PLAIN] {
        // A kind that does not grow keeps its variance. The more variance is kept, the faster the other kind has to grow.
        let mut grows = [true; PLAIN];
        loop {
            let kept: f64 = (0..PLAIN).filter(|kind| !grows[*kind]).map(|kind| self.squared_lx2[kind]).sum();
            let sum: f64 = (0..PLAIN).filter(|kind| grows[*kind]).map(|kind| self.rays[kind] * merits[kind]).sum();
            let scale =
                if may_have_lx2 > kept { (sum / (may_have_lx2 - kept)).powf(POWER.recip()) } else { f64::INFINITY };
            match (0..PLAIN).find(|kind| grows[*kind] && (scale * merits[*kind]).total_cmp(&1.0).is_le()) {
                Some(kind) => grows[kind] = false,
                None => return std::array::from_fn(|kind| if grows[kind] { scale * merits[kind] } else { 1.0 }),
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_leads_grows_and_what_is_right_stays() {
        let parts = GatheringParts {
            squared_lx2: [0.01, 4.0, 0.01],
            rays: [1e5; KINDS],
            degrees_of_freedom: 1000.0,
            ..GatheringParts::default()
        };
        let growth = parts.growth(1.0);
        assert!(growth.reaches && growth.factors[1] > 3.0, "{growth:?}");
        assert!([0, 2, 3].iter().all(|kind| growth.factors[*kind] < 1.5), "{growth:?}");
    }

    #[test]
    fn ignorance_of_the_bias_asks_for_walks_and_chance_of_cells_for_samples() {
        let growth = |residuals: ResidualState| {
            let parts =
                GatheringParts { squared_lx2: [0.01; 3], rays: [1e5; KINDS], residuals, degrees_of_freedom: 1000.0 };
            parts.growth(1.0)
        };
        let ignorant =
            ResidualState { standard_error: [0.0, 4.0, 0.0], variance: [0.0, 1.0, 0.0], ..ResidualState::default() };
        let walking = growth(ignorant);
        assert!(walking.reaches && walking.factors[WALKS] > 2.0 && walking.factors[2] == 1.0, "{walking:?}");
        let unsure = ResidualState { chance: [0.0, 2.0, 0.0], variance: [0.0, 1e4, 0.0], ..ResidualState::default() };
        let filling = growth(unsure);
        assert!(filling.reaches && filling.factors[2] > 2.0 && filling.factors[WALKS] < 1.5, "{filling:?}");
    }

    /// The cells of a look are wrong at single entries, and what walks take off has most of the variance. Fuller cells need less correction.
    /// A plan in which only more walks lessen that variance (the planted fault) would take 1.5 million rays.
    #[test]
    fn fuller_cells_need_less_correction() {
        let residuals = ResidualState {
            common: [0.0, 0.0, 0.0],
            chance: [2.3, 45.0, 0.0],
            standard_error: [1.5, 4.6, 0.0],
            variance: [25.0, 230.0, 0.0],
            correction_variance: 147.0,
            silent_share: 0.0,
        };
        let parts = GatheringParts {
            squared_lx2: [0.003, 0.64, 9.2],
            rays: [5e3, 3.7e5, 1.1e5, 2.3e6],
            residuals,
            degrees_of_freedom: 144.0,
        };
        let growth = parts.growth(3.2);
        assert!(growth.reaches && growth.factors[2] > 4.0 && growth.rays < 8e5, "{growth:?}");
    }
}
