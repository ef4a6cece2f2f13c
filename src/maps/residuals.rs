//! Residual walks of gathered maps. They measure the error of the cells, correct it at three scales, and give the remaining error.
//!
//! The replicas of a half share cells, but have walks of their own. Walks of two replicas of one half give an entry's error with
//! independent random errors. The mean of their product is thus the squared error of the half's cells. For replicas of different halves,
//! this mean is the part of it that both halves share: a bias. The rest is random error of the cells, which the difference of the halves
//! shows.
//!
//! Means over the map, over regions of neighbours and over single entries are estimated separately. A mean over many entries has a small
//! uncertainty, a single entry a large one. Each scale is corrected by the share λ = b²/(b² + σ²), which leaves the least error. Here b² is
//! the squared error of the scale, and σ² the variance of a half's walks there. The shares for one half come from the other half, so that
//! no estimate weights itself.

use serde::{Deserialize, Serialize};

use super::residual_state::{OfScales, RemainingError, ResidualState, SURE};
use super::{HALF, REPLICAS};

/// Smallest squared error of an entry's cells that is assumed, as a share of the mean squared error.
const LEAST_UNSURE: f64 = 0.1;

/// Residual walks of a map.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Residuals {
    /// Number of walks of each entry with walks, in every replica.
    pub walks: u64,
    /// For every element or point: whether it has walks.
    pub walkers: Vec<bool>,
    /// One slab per replica: sums over the walks of an entry, in the unit of the map's quantity. Where elements have slopes, the sums times the linear polynomials
    /// follow those of the elements.
    pub sums: Vec<Vec<f64>>,
    /// The same for the first steps of the walks alone.
    pub first_steps: Vec<Vec<f64>>,
    /// Region of every element or point.
    regions: Vec<u32>,
    region_count: usize,
    /// For every region: whether any entry in it has walks.
    region_walks: Vec<bool>,
    /// For every replica, after [`Residuals::settle`]: mean over the map and over every region, for a profile of 1. Last, the region's
    /// mean of first steps.
    means: Vec<f64>,
    region_means: Vec<Vec<f64>>,
    region_means_of_first_steps: Vec<Vec<f64>>,
    /// Uncertainty of the cells that each entry looks up, divided by its root mean square over the map.
    profile: Vec<f64>,
    /// Shares of the measured error that are corrected. First index: half (even, odd). Second index: scale.
    shares: [OfScales; 2],
    state: ResidualState,
}

/// Error of a map's cells that remains after the correction by walks.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct CellsError {
    /// Remaining error of the map.
    pub remaining: RemainingError,
    /// Error that walks have measured, with the shares of it that were corrected.
    pub measured: Measured,
    /// Remaining error at every element or point, in the unit of the map's quantity, for the error bars of entries.
    pub by_site: Vec<f64>,
}

/// What walks measure of a map's cells, and the shares of this error that are corrected in the even and the odd half.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Measured {
    state: ResidualState,
    shares: [OfScales; 2],
}

impl Measured {
    /// Returns the remaining error of the cells over all scales, in lx²: the squared bias that both halves share and the squared random
    /// error. `sure` standard errors are added to the measured values.
    fn remaining(&self, sure: f64) -> RemainingError {
        let [one, other] = self.shares.map(|shares| self.state.remaining_by(shares, sure));
        RemainingError { common: 0.5 * (one.common + other.common), chance: 0.5 * (one.chance + other.chance) }
    }
}

/// A map, or a part of its points, with cells and walks of its own. It is one of several whose mean is computed.
#[derive(Clone, Copy, Debug)]
pub struct MeasuredPart {
    /// Weight of the map in the mean.
    pub weight: f64,
    /// Share of these points in the map's weight; 1 for all points.
    pub area_share: f64,
    /// What its walks have measured, if it gathers.
    pub measured: Option<Measured>,
}

impl CellsError {
    /// Computes the remaining error of a map from what its walks have measured. `profile` is the relative uncertainty of the cells at each
    /// entry: see [`CellsError::profile`].
    ///
    /// The map's stated error includes the uncertainty of the measurement. Bars of single entries must contain the true value as often as
    /// they state, so they use the expected error.
    pub fn of(measured: Measured, profile: &[f64]) -> CellsError {
        CellsError::remaining_at([SURE, 0.0].map(|sure| measured.remaining(sure)), profile, measured)
    }

    fn remaining_at([remaining, expected]: [RemainingError; 2], profile: &[f64], measured: Measured) -> CellsError {
        let root = (expected.common + expected.chance).sqrt();
        CellsError { remaining, measured, by_site: profile.iter().map(|unsure| root * unsure).collect() }
    }

    /// Returns the uncertainty of the cells at each entry, divided by its root mean square.
    pub fn profile(&self) -> Vec<f64> {
        let expected = self.measured.remaining(0.0);
        let root = (expected.common + expected.chance).sqrt();
        let unsure = |error: &f64| if root > 0.0 { error / root } else { 1.0 };
        self.by_site.iter().map(unsure).collect()
    }

    /// Computes the remaining error of the mean of several maps, or of several parts of its points. Each has cells and walks of its own.
    ///
    /// The walks' measurements are pooled, which makes them more certain than those of one map. The bias that both halves of a map share is
    /// taken to be the same in all maps and does not fall. The random error falls. Parts of one map's points stand beside each other: there
    /// neither falls (docs/methods.md (47)).
    pub fn of_mean(maps: &[MeasuredPart], profile: &[f64]) -> CellsError {
        let gathered = || maps.iter().filter_map(|part| Some((part.weight * part.area_share, part, part.measured?)));
        let all_weights = maps.iter().map(|part| part.weight * part.area_share).sum::<f64>().max(f64::MIN_POSITIVE);
        let weight_sum = gathered().map(|(weight, ..)| weight).sum::<f64>().max(f64::MIN_POSITIVE);
        let mean = |of: &dyn Fn(&ResidualState) -> f64| {
            gathered().map(|(weight, _, measured)| weight * of(&measured.state)).sum::<f64>() / weight_sum
        };
        let scales = |of: &dyn Fn(&ResidualState, usize) -> f64| {
            std::array::from_fn(|scale| mean(&|state: &ResidualState| of(state, scale)))
        };
        let pooled = ResidualState {
            common: scales(&|state, scale| state.common[scale]),
            chance: scales(&|state, scale| state.chance[scale]),
            standard_error: std::array::from_fn(|scale| {
                let squares =
                    gathered().map(|(weight, _, measured)| (weight * measured.state.standard_error[scale]).powi(2));
                squares.sum::<f64>().sqrt() / weight_sum
            }),
            ..ResidualState::default()
        };
        let remaining = [SURE, 0.0].map(|sure| {
            let mut remaining = RemainingError::default();
            for (_, part, measured) in gathered() {
                // Each map was corrected by its own shares, and had its own entries without walks.
                let state = ResidualState { silent_share: measured.state.silent_share, ..pooled };
                let share = part.weight / all_weights;
                let of_map = Measured { state, ..measured }.remaining(sure);
                remaining.common += part.area_share * share * of_map.common;
                remaining.chance += part.area_share * share * share * of_map.chance;
            }
            remaining
        });
        CellsError::remaining_at(remaining, profile, Measured { state: pooled, shares: [[0.0; 3]; 2] })
    }
}

impl Residuals {
    /// Returns residuals without walks, for elements or points in these regions and `entries` entries.
    pub fn new(regions: Vec<u32>, entries: usize) -> Residuals {
        let region_count = regions.iter().max().map_or(0, |last| *last as usize + 1);
        Residuals {
            walks: 0,
            walkers: vec![true; regions.len()],
            profile: vec![1.0; regions.len()],
            sums: vec![vec![0.0; entries]; REPLICAS],
            first_steps: vec![vec![0.0; entries]; REPLICAS],
            regions,
            region_count,
            region_walks: Vec::new(),
            means: vec![0.0; REPLICAS],
            region_means: vec![Vec::new(); REPLICAS],
            region_means_of_first_steps: vec![Vec::new(); REPLICAS],
            shares: [[0.0; 3]; 2],
            state: ResidualState::default(),
        }
    }

    /// Returns the region of every element or point.
    pub fn regions(&self) -> &[u32] {
        &self.regions
    }

    /// Returns the number of regions.
    pub fn region_count(&self) -> usize {
        self.region_count
    }

    /// Returns what walks have measured of the cells' error.
    pub fn state(&self) -> ResidualState {
        self.state
    }

    /// Returns the element or point of an entry.
    fn site_of(&self, entry: usize) -> usize {
        entry % self.regions.len()
    }

    /// Returns the correction that is added to an entry of a replica, in lx.
    #[inline]
    pub fn correction_lx(&self, replica: usize, entry: usize) -> f64 {
        if self.walks == 0 {
            return 0.0;
        }
        let [of_region, of_first, of_later] = self.shares[replica % 2];
        let site = self.site_of(entry);
        let [first_lx, later_lx] = self.own_lx(replica, entry, 1.0 / self.walks as f64);
        if entry > site {
            // Neighbours have no common slopes.
            return if self.walkers[site] { of_first * first_lx + of_later * later_lx } else { 0.0 };
        }
        let (mean, region, unsure) = (self.means[replica], self.regions[site] as usize, self.profile[site]);
        if !self.region_walks[region] {
            return unsure * mean;
        }
        let region_mean = self.region_means[replica][region];
        let corrected_lx = unsure * (mean + of_region * (region_mean - mean));
        if !self.walkers[site] {
            return corrected_lx;
        }
        let [first_of_region, later_of_region] = self.steps_of_region(replica, region);
        corrected_lx
            + of_first * (first_lx - unsure * first_of_region)
            + of_later * (later_lx - unsure * later_of_region)
    }

    /// Mean over the walks of an entry, of their first and of their later steps, in lx.
    #[inline]
    fn own_lx(&self, replica: usize, entry: usize, inverse: f64) -> [f64; 2] {
        let first_lx = self.first_steps[replica][entry];
        [inverse * first_lx, inverse * (self.sums[replica][entry] - first_lx)]
    }

    /// The same for the mean of a region, for a profile of 1.
    #[inline]
    fn steps_of_region(&self, replica: usize, region: usize) -> [f64; 2] {
        let first = self.region_means_of_first_steps[replica][region];
        [first, self.region_means[replica][region] - first]
    }

    /// Returns the uncertainty of the cells that an element or point looks up, divided by its root mean square over the map.
    pub fn unsure(&self, site: usize) -> f64 {
        self.profile[site]
    }

    /// Whether walks have started from an element or point.
    pub fn has_walked(&self, site: usize) -> bool {
        self.walks > 0 && self.walkers[site]
    }

    /// Returns the error that the walks of an element or point still find in a replica after correction, in the unit of the map's values.
    pub fn remaining_in(&self, replica: usize, site: usize) -> f64 {
        self.sums[replica][site] / self.walks as f64 - self.correction_lx(replica, site)
    }

    /// Computes the corrections, for entries with these weights.
    pub fn settle(&mut self, weights: &[f64]) {
        if self.walks == 0 {
            return;
        }
        let inverse = 1.0 / self.walks as f64;
        let (all_weights, sites) = (weights, self.regions.len());
        let walks_at = |entry: usize| self.walkers[self.site_of(entry)];
        let walked = weights.iter().enumerate();
        let weights: Vec<f64> = walked.map(|(entry, weight)| if walks_at(entry) { *weight } else { 0.0 }).collect();
        let weight_sum: f64 = weights[..sites].iter().sum();
        // The common error of a region, or of the map, is in units of the cells' uncertainty. A mean is weighted so that its mean over the
        // entries equals that of the walks.
        let (mut of_regions, mut squares_of_regions) = (vec![0.0; self.region_count], vec![0.0; self.region_count]);
        for ((region, weight), unsure) in self.regions.iter().zip(&weights).zip(&self.profile) {
            of_regions[*region as usize] += weight * unsure;
            squares_of_regions[*region as usize] += weight * unsure * unsure;
        }
        let of_all: f64 = of_regions.iter().sum();
        self.region_walks = of_regions.iter().map(|weight| *weight > 0.0).collect();
        for replica in 0..REPLICAS {
            let sums_of_regions = |sums_lx: &[f64]| {
                let mut sums = vec![0.0; self.region_count];
                for ((region, weight), lx) in self.regions.iter().zip(&weights).zip(sums_lx) {
                    sums[*region as usize] += weight * lx * inverse;
                }
                sums
            };
            let per_weight = |mut sums: Vec<f64>| {
                sums.iter_mut().zip(&of_regions).for_each(|(sum, weight)| *sum /= weight.max(f64::MIN_POSITIVE));
                sums
            };
            let sums = sums_of_regions(&self.sums[replica]);
            self.means[replica] = sums.iter().sum::<f64>() / of_all.max(f64::MIN_POSITIVE);
            self.region_means[replica] = per_weight(sums);
            self.region_means_of_first_steps[replica] = per_weight(sums_of_regions(&self.first_steps[replica]));
        }
        let regions = ScaleErrors::of(&squares_of_regions, self.region_count, |replica, region| {
            self.region_means[replica][region] - self.means[replica]
        });
        let [first_steps, later_steps] = [0, 1].map(|step| {
            ScaleErrors::of(&weights, sites, |replica, entry| {
                let site = self.site_of(entry);
                let of_region =
                    if entry == site { self.steps_of_region(replica, self.regions[site] as usize)[step] } else { 0.0 };
                self.own_lx(replica, entry, inverse)[step] - self.profile[site] * of_region
            })
        });
        let scales = [&regions, &first_steps, &later_steps];
        self.shares = [1, 0].map(|other: usize| scales.map(|scale| scale.share_by(other)));
        let corrections = ScaleErrors::of(all_weights, sites, |replica, entry| self.correction_lx(replica, entry));
        self.state = ResidualState {
            common: scales.map(|scale| scale.across),
            chance: scales.map(|scale| 0.5 * (scale.within() - scale.across)),
            standard_error: scales.map(|scale| scale.standard_error),
            variance: scales.map(|scale| scale.variance),
            correction_variance: corrections.variance,
            silent_share: 1.0 - weight_sum / all_weights[..sites].iter().sum::<f64>().max(f64::MIN_POSITIVE),
        };
    }

    /// Distributes the cells' error among the entries in proportion to the uncertainty of the cells that each looks up. The walks measure
    /// its size.
    pub fn share_out(&mut self, unsure_lx2: &[f64], weights: &[f64]) {
        let (mut sum, mut weight_sum) = (0.0, 0.0);
        for (unsure, weight) in unsure_lx2.iter().zip(weights) {
            sum += weight * unsure;
            weight_sum += weight;
        }
        let mean = sum / f64::max(weight_sum, f64::MIN_POSITIVE);
        if mean > 0.0 {
            self.profile = unsure_lx2.iter().map(|unsure| (unsure / mean).max(LEAST_UNSURE).sqrt()).collect();
        }
    }

    /// Returns the remaining error of the cells after correction.
    pub fn cells_error(&self) -> CellsError {
        let measured = Measured { state: self.state, shares: self.shares };
        CellsError::of(if self.walks == 0 { Measured::default() } else { measured }, &self.profile)
    }
}

/// Returns the sums of squared deviations of the even and of the odd replicas, each from the mean of its half.
pub fn half_squares(value: impl Fn(usize) -> f64) -> [f64; 2] {
    [0, 1].map(|parity| {
        let half = || (parity..REPLICAS).step_by(2);
        let mean = half().map(&value).sum::<f64>() / HALF as f64;
        half().map(|replica| (value(replica) - mean).powi(2)).sum()
    })
}

/// Returns the squared standard error of the mean over all replicas, from their spread within the halves. The replicas of a half share
/// cells.
pub fn within_halves(value: impl Fn(usize) -> f64) -> f64 {
    let [even, odd] = half_squares(value);
    (even + odd) / (4 * HALF * (HALF - 1)) as f64
}

/// Error of one scale from the replicas' walks, in lx².
struct ScaleErrors {
    /// Mean product of two replicas of the even half, and of two replicas of the odd half.
    of_halves: [f64; 2],
    /// Mean product of one replica of each half.
    across: f64,
    /// Standard error of the mean of `within` and `across`.
    standard_error: f64,
    /// Variance of a replica.
    variance: f64,
}

impl ScaleErrors {
    /// Computes weighted means over `places` elements or points: of the product of two replicas' values, and of their variance. Later
    /// weights belong to slopes, whose squares are added.
    fn of(weights: &[f64], places: usize, value: impl Fn(usize, usize) -> f64) -> ScaleErrors {
        let n = HALF as f64;
        let mut scale = ScaleErrors { of_halves: [0.0; 2], across: 0.0, standard_error: 0.0, variance: 0.0 };
        let (mut weight_sum, mut noise) = (0.0, 0.0);
        for (place, weight) in weights.iter().enumerate().filter(|(_, weight)| **weight > 0.0) {
            let halves = [0, 1].map(|parity| {
                let (mut sum, mut squares) = (0.0, 0.0);
                for replica in (parity..REPLICAS).step_by(2) {
                    let value = value(replica, place);
                    sum += value;
                    squares += value * value;
                }
                (sum / n, (sum * sum - squares) / (n * (n - 1.0)), (squares - sum * sum / n).max(0.0) / (n - 1.0))
            });
            let across = halves[0].0 * halves[1].0;
            if place < places {
                weight_sum += weight;
            }
            scale.across += weight * across;
            let of_within = halves.map(|(_, product, variance)| {
                2.0 * variance * variance / (n * (n - 1.0)) + 4.0 * product.max(0.0) * variance / n
            });
            let variances = halves.map(|half| half.2);
            let of_across = variances[0] * variances[1] / (n * n) + across.max(0.0) * (variances[0] + variances[1]) / n;
            // Variance of ½ (½ (even + odd) + across).
            noise += weight * weight * 0.25 * (0.25 * (of_within[0] + of_within[1]) + of_across);
            scale.variance += weight * 0.5 * (variances[0] + variances[1]);
            for (sum, half) in scale.of_halves.iter_mut().zip(halves) {
                *sum += weight * half.1;
            }
        }
        let inverse = 1.0 / f64::max(weight_sum, f64::MIN_POSITIVE);
        ScaleErrors {
            of_halves: scale.of_halves.map(|sum| sum * inverse),
            across: scale.across * inverse,
            standard_error: noise.sqrt() * inverse,
            variance: scale.variance * inverse,
        }
    }

    /// Returns the squared error of a half's cells.
    fn within(&self) -> f64 {
        0.5 * (self.of_halves[0] + self.of_halves[1])
    }

    /// Returns the best share for the correction, from the walks of one half.
    fn share_by(&self, half: usize) -> f64 {
        let squared = self.of_halves[half].max(0.0);
        let all = squared + self.variance / HALF as f64;
        if all > 0.0 { squared / all } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::random::{Purpose, Stream};

    /// Builds entries in regions of 16. Their walks scatter by `sigma` about a bias of `bias_lx`, whose sign alternates from entry to
    /// entry. They have one step.
    fn walked(seed: u64, bias_lx: f64, sigma: f64) -> Residuals {
        walked_in_steps(seed, [bias_lx, 0.0], [sigma, 0.0])
    }

    /// The same with a bias and a scatter of the first step and of all later steps.
    fn walked_in_steps(seed: u64, bias_lx: [f64; 2], sigma: [f64; 2]) -> Residuals {
        const SITES: usize = 512;
        let mut residuals = Residuals::new((0..SITES as u32).map(|site| site / 16).collect(), SITES);
        residuals.walks = 1;
        for replica in 0..REPLICAS {
            let mut stream = Stream::new(seed, Purpose::Pilot, 7, replica as u32);
            stream.seek(0);
            for site in 0..SITES {
                let sign = if site % 2 == 0 { 1.0 } else { -1.0 };
                let mut step_lx = |step: usize| {
                    let normal = (0..12).map(|_| stream.unit()).sum::<f64>() - 6.0;
                    sign * bias_lx[step] + sigma[step] * normal
                };
                let first_lx = step_lx(0);
                residuals.first_steps[replica][site] = first_lx;
                residuals.sums[replica][site] = first_lx + step_lx(1);
            }
        }
        residuals.settle(&[1.0; SITES]);
        residuals
    }

    #[test]
    fn the_squared_bias_is_the_one_put_in() {
        // 40 seeds: the result is within 4 standard errors of the mean. A bias 5% larger (the planted fault) is distinguished from it.
        let runs: Vec<ResidualState> = (0..40).map(|seed| walked(seed, 3.0, 10.0).state()).collect();
        let mean = runs.iter().map(|state| state.common[1]).sum::<f64>() / 40.0;
        let error = runs.iter().map(|state| state.standard_error[1]).sum::<f64>() / 40.0 / 40f64.sqrt();
        // Differences from the mean of a region of 16 have 15/16 of the variance. The alternating bias does not fall.
        assert!((mean - 9.0).abs() < 4.0 * error, "{mean} ± {error}");
        assert!((mean - 9.0 * 1.05f64.powi(2)).abs() > 4.0 * error, "the planted fault passed: {mean} ± {error}");
    }

    /// 40 maps (seeds 0 to 39) whose later steps scatter six times as much as the first. The squared error of both is 9 lx² plus what later
    /// steps bring: 0, a tenth or a fourth of that. The mean over the maps is at most 40 % above that and nowhere below, though one map's
    /// later steps measure it to 48 lx² only. Planted faults: without later steps the last is missed, and by the walks alone one map's
    /// uncertainty is 6 times as large.
    #[test]
    fn later_steps_that_scatter_are_known_by_the_first() {
        for later_of_first in [0.0, 0.1, 0.25] {
            let bias_lx = [3.0, 3.0 * f64::sqrt(later_of_first)];
            let states: Vec<ResidualState> =
                (0..40).map(|seed| walked_in_steps(seed, bias_lx, [10.0, 60.0]).state()).collect();
            let mean = |of: &dyn Fn(&ResidualState) -> f64| states.iter().map(of).sum::<f64>() / 40.0;
            let stated = |state: &ResidualState, sure: f64| {
                let remaining = state.remaining_by([1.0, 0.0, 0.0], sure);
                remaining.common + remaining.chance
            };
            let (found, truth) = (mean(&|state| stated(state, 0.0)), 9.0 * (1.0 + later_of_first));
            assert!((1.0..1.4).contains(&(found / truth)), "{found} for {truth}");
            let first = mean(&|state| state.common[1] + state.chance[1]);
            assert!(later_of_first < 0.2 || first < 0.9 * truth, "the planted fault passed: {first} for {truth}");
            let unsure = mean(&|state| stated(state, 1.0) - stated(state, 0.0));
            let by_walks = mean(&|state| state.standard_error[2]);
            assert!(by_walks > 6.0 * unsure, "{unsure} and {by_walks} by the walks alone");
        }
    }

    /// 40 maps (seeds 0 to 39) whose later steps scatter little: they are measured, whatever the first step shows.
    #[test]
    fn later_steps_that_walks_know_are_measured() {
        let mean = (0..40).map(|seed| {
            let remaining = walked_in_steps(seed, [1.0, 3.0], [1.0, 1.0]).state().remaining_by([1.0, 1.0, 0.0], 0.0);
            remaining.common + remaining.chance
        });
        let mean = mean.sum::<f64>() / 40.0;
        assert!((mean - 9.0).abs() < 0.3, "{mean}");
    }

    /// 200 maps (seeds 0 to 199) whose walks scatter by 10 lx about a bias of 0 or of 3 lx: the error expected after four times the walks is the
    /// mean of what such walks measure (other seeds), within 15 %. Without a bias, the planted fault, which takes all that the first walks
    /// measure as real, is above that mean by more than a fifth.
    #[test]
    fn more_walks_are_expected_to_show_what_they_show() {
        let mean = |of: &dyn Fn(u64) -> f64| (0..200).map(of).sum::<f64>() / 200.0;
        for bias_lx in [0.0, 3.0] {
            let first = |seed: u64| walked(seed, bias_lx, 10.0).state();
            let expected = mean(&|seed| first(seed).expected(4.0, 1.0).remaining_lx2().common);
            let found = mean(&|seed| walked(200 + seed, bias_lx, 5.0).state().remaining_lx2().common);
            assert!((expected / found - 1.0).abs() < 0.15, "{expected} {found}");
            let taken_as_real = mean(&|seed| {
                let ResidualState { common, chance, .. } = first(seed);
                ResidualState { common, chance, ..first(seed).expected(4.0, 1.0) }.remaining_lx2().common
            });
            assert!(bias_lx > 0.0 || taken_as_real > 1.2 * found, "the planted fault passed: {taken_as_real} {found}");
        }
    }

    #[test]
    fn a_bias_that_walks_know_well_is_taken_off_and_chance_is_not() {
        let known = walked(3, 3.0, 1.0);
        let off = (known.correction_lx(0, 0) - 3.0).abs();
        assert!(off < 3.0 && known.shares[0][1] > 0.9, "{off} {:?}", known.shares);
        let chance = walked(3, 0.0, 10.0);
        assert!(chance.shares[0][1] < 0.2, "{:?}", chance.shares);
        let left = |residuals: &Residuals| residuals.cells_error().remaining.common;
        assert!(left(&known) < 1.0 && left(&walked(3, 3.0, 100.0)) > 4.0);
    }

    /// 40 maps (seeds 0 to 39) whose walks each give little information about a bias of 3 lx. Together they measure it within 4 of their
    /// standard errors, and distinguish it from 4 lx (the planted fault). Random error falls with their number, the bias does not. One map
    /// alone is unchanged.
    #[test]
    fn many_maps_know_what_one_does_not_and_their_bias_does_not_fall() {
        let of =
            |weight: f64, area_share: f64, measured: Option<Measured>| MeasuredPart { weight, area_share, measured };
        let measured: Vec<_> =
            (0..40).map(|seed| of(2.0, 1.0, Some(walked(seed, 3.0, 30.0).cells_error().measured))).collect();
        let profile = [1.0; 4];
        let all = CellsError::of_mean(&measured, &profile);
        let (found, error) = (all.measured.state.common[1], all.measured.state.standard_error[1]);
        assert!((found - 9.0).abs() < 4.0 * error && (found - 16.0).abs() > 4.0 * error, "{found} ± {error}");
        let [alone, twice] = [1, 2].map(|count| CellsError::of_mean(&vec![measured[7]; count], &profile));
        assert_eq!(alone.remaining.common, walked(7, 3.0, 30.0).cells_error().remaining.common);
        assert_eq!(2.0 * twice.remaining.chance, alone.remaining.chance);
        let expected = |error: &CellsError| error.by_site[0].powi(2) - error.remaining.chance;
        assert!((expected(&twice) - expected(&alone)).abs() < 1e-9, "{twice:?} {alone:?}");
        let without = CellsError::of_mean(&[measured[7], of(6.0, 1.0, None)], &profile);
        assert!(
            (4.0 * without.remaining.common / alone.remaining.common - 1.0).abs() < 1e-12,
            "a share that does not gather"
        );
        // Two halves of the points with the same error have this error together. Its uncertainty is smaller by the square root of two.
        let halves = CellsError::of_mean(&[of(2.0, 0.5, measured[7].measured); 2], &profile);
        let by_chance = |map: &&MeasuredPart| CellsError::of_mean(&[**map], &profile).remaining.chance > 0.0;
        let map = measured.iter().find(by_chance).expect("some cells are off by chance");
        let chance = |maps: &[MeasuredPart]| CellsError::of_mean(maps, &profile).remaining.chance;
        let of_halves = chance(&[of(2.0, 0.5, map.measured); 2]);
        assert!((of_halves / chance(&[*map]) - 1.0).abs() < 1e-12, "{of_halves} {map:?}");
        let sure = |error: &CellsError| error.measured.state.standard_error[1];
        assert!((sure(&halves) * 2f64.sqrt() / sure(&alone) - 1.0).abs() < 1e-12, "{halves:?} {alone:?}");
        let other = CellsError::of_mean(&[of(2.0, 0.25, measured[7].measured), of(2.0, 0.75, None)], &profile);
        assert!(
            (4.0 * other.remaining.common / alone.remaining.common - 1.0).abs() < 1e-12,
            "a part that does not gather"
        );
    }
}
