//! What walks say of gathered maps: how far the cells are off, taken off at three scales, and what is left of it.
//!
//! Replicas have cells and walks of their own. What walks of two replicas say of an entry has errors that know nothing of
//! each other, so that the mean of their product is the squared bias that all replicas share. Means over the map, over regions of
//! neighbours and over single entries are told apart: a mean over many entries is known well, a single entry's poorly. Each scale is
//! taken off by the share λ = b²/(b² + σ²) that leaves the least, b² its squared bias and σ² the variance of a replica's
//! walks there. The shares for one half come from the other, so that nothing weighs itself.

use super::HALF;
use super::replicas::REPLICAS;

/// Standard errors of the squared bias that are added to it where it is stated.
const SURE: f64 = 0.5;

/// Residual walks of a map.
#[derive(Clone, Debug)]
pub struct Residuals {
    /// Walks of every entry that has walks, in every replica.
    pub walks: u64,
    /// Which entries have walks.
    pub walkers: Vec<bool>,
    /// One slab a replica: sums over the walks of an entry in lx.
    pub sums_lx: Vec<Vec<f64>>,
    /// Region of every entry.
    regions: Vec<u32>,
    region_count: usize,
    /// Whether any entry of a region has walks.
    region_walks: Vec<bool>,
    /// Of every replica, once settled: mean over the map and over every region, in lx.
    means_lx: Vec<f64>,
    region_means_lx: Vec<Vec<f64>>,
    /// Shares of regions and of entries that the even and the odd half take off.
    shares: [[f64; 2]; 2],
    state: ResidualState,
}

/// What walks say of a map's bias; all in lx².
#[derive(Clone, Copy, Debug, Default)]
pub struct ResidualState {
    /// Of regions and of entries: squared bias, mean over the map; may be below 0 by chance.
    pub squared_bias: [f64; 2],
    /// Standard error of that.
    pub standard_error: [f64; 2],
    /// Variance of what one replica's walks say.
    pub variance: [f64; 2],
    /// Variance of a replica's correction, mean over the entries.
    pub correction_variance: f64,
    /// Share of the entries, by weight, without walks.
    pub silent_share: f64,
}

impl ResidualState {
    /// Share of a scale that is taken off, where walks are so many times as many.
    pub fn share(&self, scale: usize, walks: f64) -> f64 {
        let squared = self.squared_bias[scale].max(0.0);
        let all = squared + self.variance[scale] / (walks * REPLICAS as f64);
        if all > 0.0 { squared / all } else { 0.0 }
    }

    /// Squared bias in lx² that is left and stated, where walks are so many times as many.
    pub fn left_lx2(&self, walks: f64) -> f64 {
        let shares = [0, 1].map(|scale| self.share(scale, walks));
        self.left_by_shares_lx2(shares, walks)
    }

    fn left_by_shares_lx2(&self, shares: [f64; 2], walks: f64) -> f64 {
        let left = |scale: usize, silent: f64| {
            let sure = self.squared_bias[scale].max(0.0) + SURE * self.standard_error[scale] / walks;
            ((1.0 - silent) * (1.0 - shares[scale]).powi(2) + silent) * sure
        };
        left(0, 0.0) + left(1, self.silent_share)
    }

    /// The same if all entries had walks, each as many.
    pub fn over_all(self) -> ResidualState {
        let had = 1.0 - self.silent_share;
        ResidualState {
            standard_error: self.standard_error.map(|error| error * had.sqrt()),
            variance: [self.variance[0] * had, self.variance[1]],
            silent_share: 0.0,
            ..self
        }
    }
}

impl Residuals {
    /// No walks yet, for entries in so many regions.
    pub fn new(regions: Vec<u32>) -> Residuals {
        let region_count = regions.iter().max().map_or(0, |last| *last as usize + 1);
        Residuals {
            walks: 0,
            walkers: vec![true; regions.len()],
            sums_lx: vec![vec![0.0; regions.len()]; REPLICAS],
            regions,
            region_count,
            region_walks: Vec::new(),
            means_lx: vec![0.0; REPLICAS],
            region_means_lx: vec![Vec::new(); REPLICAS],
            shares: [[0.0; 2]; 2],
            state: ResidualState::default(),
        }
    }

    /// Region of every entry.
    pub fn regions(&self) -> &[u32] {
        &self.regions
    }

    /// Region of an entry.
    #[inline]
    pub fn region_of(&self, site: usize) -> u32 {
        self.regions[site]
    }

    /// Number of regions.
    pub fn region_count(&self) -> usize {
        self.region_count
    }

    /// What walks say of the map's bias.
    pub fn state(&self) -> ResidualState {
        self.state
    }

    /// What is added to an entry of a replica, in lx.
    #[inline]
    pub fn correction_lx(&self, replica: usize, site: usize) -> f64 {
        if self.walks == 0 {
            return 0.0;
        }
        let [of_region, of_entry] = self.shares[replica % 2];
        let (mean, region) = (self.means_lx[replica], self.regions[site] as usize);
        if !self.region_walks[region] {
            return mean;
        }
        let region_mean = self.region_means_lx[replica][region];
        let corrected = mean + of_region * (region_mean - mean);
        if !self.walkers[site] {
            return corrected;
        }
        corrected + of_entry * (self.sums_lx[replica][site] / self.walks as f64 - region_mean)
    }

    /// Makes ready what is taken off, for entries that count with these weights.
    pub fn settle(&mut self, weights: &[f64]) {
        if self.walks == 0 {
            return;
        }
        let inverse = 1.0 / self.walks as f64;
        let all_weights = weights;
        let weights: Vec<f64> =
            weights.iter().zip(&self.walkers).map(|(weight, walks)| if *walks { *weight } else { 0.0 }).collect();
        let weight_sum: f64 = weights.iter().sum();
        let mut of_regions = vec![0.0; self.region_count];
        for (region, weight) in self.regions.iter().zip(&weights) {
            of_regions[*region as usize] += weight;
        }
        self.region_walks = of_regions.iter().map(|weight| *weight > 0.0).collect();
        for replica in 0..REPLICAS {
            let mut means = vec![0.0; self.region_count];
            let mut sum = 0.0;
            for ((region, weight), lx) in self.regions.iter().zip(&weights).zip(&self.sums_lx[replica]) {
                means[*region as usize] += weight * lx * inverse;
                sum += weight * lx * inverse;
            }
            means.iter_mut().zip(&of_regions).for_each(|(mean, weight)| *mean /= weight.max(f64::MIN_POSITIVE));
            self.means_lx[replica] = sum / weight_sum.max(f64::MIN_POSITIVE);
            self.region_means_lx[replica] = means;
        }
        let state_of = |replicas: &[usize]| {
            let regions = Scale::of(&of_regions, replicas, |replica, region| {
                self.region_means_lx[replica][region] - self.means_lx[replica]
            });
            let entries = Scale::of(&weights, replicas, |replica, site| {
                self.sums_lx[replica][site] * inverse - self.region_means_lx[replica][self.regions[site] as usize]
            });
            ResidualState {
                squared_bias: [regions.squared_bias, entries.squared_bias],
                standard_error: [regions.standard_error, entries.standard_error],
                variance: [regions.variance, entries.variance],
                correction_variance: 0.0,
                silent_share: 1.0 - weight_sum / all_weights.iter().sum::<f64>().max(f64::MIN_POSITIVE),
            }
        };
        let halves: [ResidualState; 2] =
            [0, 1].map(|parity| state_of(&(0..HALF).map(|row| 2 * row + parity).collect::<Vec<_>>()));
        self.shares = [1, 0].map(|other: usize| [0, 1].map(|scale| halves[other].share(scale, 1.0)));
        let mut state = state_of(&(0..REPLICAS).collect::<Vec<_>>());
        // The shares that are used are those of the halves; what is left is stated by the same.
        let corrections = Scale::of(all_weights, &(0..REPLICAS).collect::<Vec<_>>(), |replica, site| {
            self.correction_lx(replica, site)
        });
        state.correction_variance = corrections.variance;
        self.state = state;
    }

    /// Stated bias in lx: what is left of the squared bias at both scales, with its chance.
    pub fn bias_lx(&self) -> f64 {
        if self.walks == 0 {
            return 0.0;
        }
        let of_half = |shares: &[f64; 2]| self.state.left_by_shares_lx2(*shares, 1.0);
        self.shares.iter().map(of_half).sum::<f64>().max(0.0).sqrt() / 2f64.sqrt()
    }
}

/// What replicas say of one scale.
struct Scale {
    squared_bias: f64,
    standard_error: f64,
    variance: f64,
}

impl Scale {
    /// Weighted means over places of the product of two replicas' values, and of their variance.
    fn of(weights: &[f64], replicas: &[usize], value: impl Fn(usize, usize) -> f64) -> Scale {
        let n = replicas.len() as f64;
        let (mut weight_sum, mut products, mut variances, mut noise) = (0.0, 0.0, 0.0, 0.0);
        for (place, weight) in weights.iter().enumerate().filter(|(_, weight)| **weight > 0.0) {
            let (mut sum, mut squares) = (0.0, 0.0);
            for replica in replicas {
                let value = value(*replica, place);
                sum += value;
                squares += value * value;
            }
            let product = (sum * sum - squares) / (n * (n - 1.0));
            let variance = (squares - sum * sum / n).max(0.0) / (n - 1.0);
            weight_sum += weight;
            products += weight * product;
            variances += weight * variance;
            noise +=
                weight * weight * (2.0 * variance * variance / (n * (n - 1.0)) + 4.0 * product.max(0.0) * variance / n);
        }
        let scale = 1.0 / f64::max(weight_sum, f64::MIN_POSITIVE);
        Scale { squared_bias: products * scale, standard_error: noise.sqrt() * scale, variance: variances * scale }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::random::{Purpose, Stream};

    /// Entries in regions of 16, whose walks scatter by `sigma` about a bias of 3 lx that alternates from entry to entry.
    fn walked(seed: u64, bias_lx: f64, sigma: f64) -> Residuals {
        const SITES: usize = 512;
        let mut residuals = Residuals::new((0..SITES as u32).map(|site| site / 16).collect());
        residuals.walks = 1;
        for replica in 0..REPLICAS {
            let mut stream = Stream::new(seed, Purpose::Pilot, 7, replica as u32);
            stream.seek(0);
            for site in 0..SITES {
                let normal = (0..12).map(|_| stream.unit()).sum::<f64>() - 6.0;
                let sign = if site % 2 == 0 { 1.0 } else { -1.0 };
                residuals.sums_lx[replica][site] = sign * bias_lx + sigma * normal;
            }
        }
        residuals.settle(&[1.0; SITES]);
        residuals
    }

    #[test]
    fn the_squared_bias_is_the_one_put_in() {
        // 40 seeds: within 4 standard errors of the mean; a bias 5% larger (the planted fault) is told from it.
        let runs: Vec<ResidualState> = (0..40).map(|seed| walked(seed, 3.0, 10.0).state()).collect();
        let mean = runs.iter().map(|state| state.squared_bias[1]).sum::<f64>() / 40.0;
        let error = runs.iter().map(|state| state.standard_error[1]).sum::<f64>() / 40.0 / 40f64.sqrt();
        // Differences from the mean of a region of 16 have 15/16 of the variance, and no less of the alternating bias.
        assert!((mean - 9.0).abs() < 4.0 * error, "{mean} ± {error}");
        assert!((mean - 9.0 * 1.05f64.powi(2)).abs() > 4.0 * error, "the planted fault passed: {mean} ± {error}");
    }

    #[test]
    fn a_bias_that_walks_know_well_is_taken_off_and_chance_is_not() {
        let known = walked(3, 3.0, 1.0);
        let off = (known.correction_lx(0, 0) - 3.0).abs();
        assert!(off < 3.0 && known.shares[0][1] > 0.9, "{off} {:?}", known.shares);
        let chance = walked(3, 0.0, 10.0);
        assert!(chance.shares[0][1] < 0.2, "{:?}", chance.shares);
        assert!(known.bias_lx() < 1.0 && walked(3, 3.0, 100.0).bias_lx() > 2.0);
    }
}
