//! Remaining error of the cells in averages over many elements or points.
//!
//! Neighbours look up the same cells. The errors of these cells do not average out as random errors do, and halves that share a cell error
//! agree on it. Walks measure it, as they do for a map (`residuals.rs`).

use super::residual_state::SURE;
use super::residuals::within_halves;
use super::{CellsError, HALF, REPLICAS, Residuals};

/// What walks measure of an average after corrections, in the unit of the map's values and its square.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RemainingInAverage {
    /// Weight of all elements or points of the average, and of those with walks.
    weight: f64,
    walked_weight: f64,
    /// Squared mean of the error that walks still find, minus the variance of this mean (docs/methods.md (39)). It can be negative by
    /// chance.
    squared: f64,
    /// Variance of that mean, from the spread within the halves.
    chance: f64,
    /// Mean uncertainty of the cells (relative to the map), and mean of the remaining error at each element or point.
    unsure: f64,
    by_site: f64,
    /// Squared error from elements or points without walks, which those with walks have to represent.
    unseen: f64,
}

impl RemainingInAverage {
    /// Measures the average over elements or points with these weights: docs/methods.md (39).
    pub fn of(
        residuals: &Residuals,
        error: &CellsError,
        sites: impl Iterator<Item = (usize, f64)>,
    ) -> RemainingInAverage {
        let mut remaining = RemainingInAverage::default();
        let (mut sums, mut walkers, mut by_site_squared) = ([0.0; REPLICAS], 0.0, 0.0);
        for (site, weight) in sites.filter(|(_, weight)| *weight > 0.0) {
            remaining.weight += weight;
            remaining.unsure += weight * residuals.unsure(site);
            remaining.by_site += weight * error.by_site[site];
            by_site_squared += weight * error.by_site[site].powi(2);
            if residuals.has_walked(site) {
                remaining.walked_weight += weight;
                walkers += 1.0;
                for (replica, sum) in sums.iter_mut().enumerate() {
                    *sum += weight * residuals.remaining_in(replica, site);
                }
            }
        }
        let whole = remaining.weight.max(f64::MIN_POSITIVE);
        (remaining.unsure, remaining.by_site) = (remaining.unsure / whole, remaining.by_site / whole);
        if remaining.walked_weight > 0.0 {
            let means = sums.map(|sum| sum / remaining.walked_weight);
            let mean = means.iter().sum::<f64>() / REPLICAS as f64;
            remaining.chance = within_halves(|replica| means[replica]);
            remaining.squared = mean * mean - remaining.chance;
            remaining.unseen = (1.0 - remaining.walked_weight / whole).max(0.0) * by_site_squared / whole / walkers;
        }
        remaining
    }

    /// Returns the variance of `squared`.
    fn variance(&self) -> f64 {
        let of_spread = HALF as f64 / (HALF - 1) as f64;
        2.0 * of_spread * self.chance * self.chance + 4.0 * self.squared.max(0.0) * self.chance
    }
}

/// Returns the remaining error of the cells in each average of a map, in the unit of its values.
///
/// All averages together give the remaining error for cells of the usual uncertainty. Half a standard error is added, as for the map's own
/// error. If an average's own walks show more, beyond their standard error, that larger value counts. The error of an average without walks
/// can be as large as the mean error of its own elements or points.
pub fn remaining_by_average(averages: &[RemainingInAverage]) -> Vec<f64> {
    let walked = || averages.iter().filter(|average| average.walked_weight > 0.0);
    let sum = |of: &dyn Fn(&RemainingInAverage) -> f64| walked().map(of).sum::<f64>();
    let units = sum(&|average| average.weight * average.unsure * average.unsure).max(f64::MIN_POSITIVE);
    let common = sum(&|average| average.weight * average.squared) / units;
    let sure = SURE * sum(&|average| average.weight * average.weight * average.variance()).sqrt() / units;
    let common = (common + sure).max(0.0);
    let remaining = |average: &RemainingInAverage| {
        let usual = common * average.unsure * average.unsure;
        if average.walked_weight <= 0.0 {
            return usual.sqrt().max(average.by_site);
        }
        let own = average.squared - average.variance().sqrt();
        (usual.max(own) + average.unseen).sqrt()
    };
    averages.iter().map(remaining).collect()
}

#[cfg(test)]
mod tests {
    use super::super::ReplicaMap;
    use super::super::replicas::Unit;
    use super::*;
    use crate::sampling::random::{Purpose, Stream};

    const ROWS: usize = 6;
    const SITES: usize = 48;

    /// Simulates maps of six rows. Returns the share of averages within their intervals of ±2.13 standard errors, in two versions. The
    /// first uses what walks measure of the averages. The second, the planted fault, uses the spread of the replicas alone.
    ///
    /// The cells have a common error of `common_lx` (RMS over rows) in both halves. Each half has a separate error of the same size. In
    /// addition, single entries are off by 3 lx, rays of a replica by 4 lx, and a walk from an entry by `walk_lx`.
    fn held(maps: u64, common_lx: f64, walk_lx: f64) -> [f64; 2] {
        let mut stream = Stream::new(6, Purpose::Pilot, 0, 0);
        let (mut held, weights) = ([0.0; 2], vec![1.0; ROWS * SITES]);
        for number in 0..maps {
            stream.seek(number);
            let mut normal = || (0..12).map(|_| stream.unit()).sum::<f64>() - 6.0;
            let regions = (0..ROWS * SITES).map(|site| (site / 24) as u32).collect();
            let mut map = ReplicaMap::new(ROWS * SITES, Unit::Scores);
            map.indirect_samples.complete = 1;
            let mut residuals = Residuals::new(regions, ROWS * SITES);
            residuals.walks = 1;
            for row in 0..ROWS {
                let common = common_lx * normal();
                let of_halves = [common + common_lx * normal(), common + common_lx * normal()];
                for site in row * SITES..(row + 1) * SITES {
                    let own = 3.0 * normal();
                    for replica in 0..REPLICAS {
                        let off_lx = of_halves[replica % 2] + own;
                        map.indirect[replica][site] = 100.0 - off_lx + 4.0 * normal();
                        residuals.sums[replica][site] = off_lx + walk_lx * normal();
                        residuals.first_steps[replica][site] = residuals.sums[replica][site];
                    }
                }
            }
            map.residuals = Some(residuals);
            map.take_residuals(&weights);
            let (residuals, error) = (map.residuals.as_ref().expect("given"), map.cells_error.as_ref().expect("taken"));
            let sites = |row: usize| (row * SITES..(row + 1) * SITES).map(|site| (site, 1.0));
            let averages: Vec<RemainingInAverage> =
                (0..ROWS).map(|row| RemainingInAverage::of(residuals, error, sites(row))).collect();
            for (row, remaining_lx) in remaining_by_average(&averages).into_iter().enumerate() {
                let average_lx =
                    |replica: usize| sites(row).map(|(site, _)| map.value(replica, site)).sum::<f64>() / SITES as f64;
                let off_lx = (0..REPLICAS).map(average_lx).sum::<f64>() / REPLICAS as f64 - 100.0;
                let spread_lx = within_halves(average_lx).sqrt();
                for (held, remaining_lx) in held.iter_mut().zip([remaining_lx, 0.0]) {
                    *held += f64::from(u8::from(off_lx.abs() <= 2.13 * spread_lx.hypot(remaining_lx)));
                }
            }
        }
        held.map(|count| count / (maps as usize * ROWS) as f64)
    }

    /// At α = 10⁻⁴ a true share of at least 0.93 gives a measured share of at least 0.89. There are 1,200 averages, in 200 maps of six;
    /// those of a map are taken to be as dependent as if only two of three were independent.
    #[test]
    fn intervals_of_averages_hold_what_cells_share() {
        for (common_lx, walk_lx) in [(0.0, 30.0), (0.5, 30.0), (2.0, 30.0), (2.0, 10.0)] {
            let [known, by_spread] = held(200, common_lx, walk_lx);
            assert!(known > 0.89, "{known} by {common_lx} lx, walks {walk_lx} lx");
            // With many walks the remaining error is small.
            let is_much = common_lx > 1.0 && walk_lx > 20.0;
            assert!(!is_much || by_spread < 0.8, "the planted fault passed: {by_spread} by {common_lx} lx");
        }
    }

    /// A row whose own walks show a far larger error than other rows gets that error. A row without walks gets the error of its own points.
    #[test]
    fn an_average_is_reported_by_its_own_walks_where_these_say_more() {
        let usual = RemainingInAverage {
            weight: 1.0,
            walked_weight: 1.0,
            squared: 1.0,
            chance: 0.1,
            unsure: 1.0,
            by_site: 3.0,
            unseen: 0.0,
        };
        let far = RemainingInAverage { weight: 1e-3, squared: 400.0, ..usual };
        let silent = RemainingInAverage { walked_weight: 0.0, squared: 0.0, chance: 0.0, ..usual };
        let [one, other, without] = remaining_by_average(&[usual, far, silent])[..] else { unreachable!("three") };
        assert!(
            (1.0..1.5).contains(&one) && (18.0..20.0).contains(&other) && without == 3.0,
            "{one} {other} {without}"
        );
    }
}
