//! What an element map cannot show: how the illuminance varies within its elements.
//!
//! An element shows its mean, or its mean and two slopes. What is left out is measured without bias: products of the even
//! and the odd half's coefficients for linear and quadratic parts, and for direct light, whose edges no polynomial follows,
//! the product of two looks from the same point.

use super::basis::{BENDS, SLOPES};
use super::replicas::REPLICAS;

/// Sums over the samples of one replica in one element.
#[derive(Clone, Copy, Debug, Default)]
pub struct DirectDetail {
    /// Of (direct light − reference there) times the polynomials, in lx.
    pub bends_lx: [f64; BENDS],
    /// Of direct light − reference in lx.
    pub sum_lx: f64,
    /// Of the products of two looks − reference in lx².
    pub product_lx2: f64,
}

/// Sums that tell how light varies within elements.
#[derive(Clone, Debug)]
pub struct Detail {
    /// One slab a replica.
    pub direct: Vec<Vec<DirectDetail>>,
    /// One slab a replica: of (indirect scores − reference) times the polynomials, in the unit of the map's scores.
    pub indirect: Vec<Vec<[f64; BENDS]>>,
}

/// How the light varies within one element: mean squares over its area in lx².
#[derive(Clone, Copy, Debug, Default)]
pub struct Variation {
    /// Of direct light, its linear part left out.
    pub direct_lx2: f64,
    /// Variance of that estimate.
    pub direct_noise: f64,
    /// What indirect light adds to that: its quadratic part, and its product with that of direct light.
    pub indirect_lx2: f64,
    /// Variance of that estimate.
    pub indirect_noise: f64,
    /// Of the linear part, direct and indirect light together.
    pub slope_lx2: f64,
    /// Variance of that estimate.
    pub slope_noise: f64,
}

impl Detail {
    /// Nothing seen yet of so many elements.
    pub fn new(sites: usize) -> Detail {
        Detail {
            direct: vec![vec![DirectDetail::default(); sites]; REPLICAS],
            indirect: vec![vec![[0.0; BENDS]; sites]; REPLICAS],
        }
    }

    /// Forgets indirect light.
    pub fn restart_indirect(&mut self) {
        self.indirect.iter_mut().for_each(|slab| slab.fill([0.0; BENDS]));
    }

    /// How the light varies within an element, where a unit of its direct and of its indirect sums is worth so much
    /// ([`ReplicaMap::scales`](super::ReplicaMap::scales)), and where the references have these slopes.
    pub fn variation(
        &self,
        site: usize,
        (direct_scale, indirect_scale): (f64, f64),
        reference_slopes_lx: [f64; SLOPES],
    ) -> Variation {
        let direct: [[f64; BENDS]; REPLICAS] =
            std::array::from_fn(|replica| self.direct[replica][site].bends_lx.map(|sum_lx| sum_lx * direct_scale));
        let indirect: [[f64; BENDS]; REPLICAS] =
            std::array::from_fn(|replica| self.indirect[replica][site].map(|sum| sum * indirect_scale));
        let sums_lx: [f64; REPLICAS] = std::array::from_fn(|replica| self.direct[replica][site].sum_lx * direct_scale);
        let products_lx2: [f64; REPLICAS] =
            std::array::from_fn(|replica| self.direct[replica][site].product_lx2 * direct_scale);

        let mut found = Variation::default();
        // Direct light: all its variance, less what linear functions of the element follow.
        let followed = [0, 1].map(|k| Halves::of(|replica| direct[replica][k]));
        let mean = Halves::of(|replica| sums_lx[replica]);
        found.direct_lx2 = products_lx2.iter().sum::<f64>() / REPLICAS as f64
            - mean.product()
            - followed.iter().map(Halves::product).sum::<f64>();
        let influence = Halves::of(|replica| {
            products_lx2[replica]
                - 2.0 * mean.mean() * sums_lx[replica]
                - (0..SLOPES).map(|k| 2.0 * followed[k].mean() * direct[replica][k]).sum::<f64>()
        });
        found.direct_noise = influence.variance_of_mean();
        for k in 0..BENDS {
            let (d, i) = (Halves::of(|replica| direct[replica][k]), Halves::of(|replica| indirect[replica][k]));
            let both = Halves::of(|replica| direct[replica][k] + indirect[replica][k]);
            if k < SLOPES {
                let both = both.beyond(reference_slopes_lx[k]);
                found.slope_lx2 += both.product();
                found.slope_noise += both.variance_of_product();
            } else {
                found.indirect_lx2 += both.product() - d.product();
                found.indirect_noise += i.variance_of_product() + 4.0 * d.mean().powi(2) * i.variance_of_mean();
            }
        }
        found
    }
}

/// Means of the even and of the odd replicas, and the variances of these means.
struct Halves {
    means: [f64; 2],
    variances: [f64; 2],
}

impl Halves {
    fn of(value: impl Fn(usize) -> f64) -> Halves {
        const HALF: usize = REPLICAS / 2;
        let means = [0, 1].map(|parity| (0..HALF).map(|j| value(2 * j + parity)).sum::<f64>() / HALF as f64);
        let variances = [0, 1].map(|parity| {
            let squares: f64 = (0..HALF).map(|j| (value(2 * j + parity) - means[parity]).powi(2)).sum();
            squares / (HALF * (HALF - 1)) as f64
        });
        Halves { means, variances }
    }

    fn beyond(self, known: f64) -> Halves {
        Halves { means: self.means.map(|mean| known + mean), ..self }
    }

    fn mean(&self) -> f64 {
        0.5 * (self.means[0] + self.means[1])
    }

    /// The square of the expectation, without bias.
    fn product(&self) -> f64 {
        self.means[0] * self.means[1]
    }

    fn variance_of_mean(&self) -> f64 {
        0.25 * (self.variances[0] + self.variances[1])
    }

    fn variance_of_product(&self) -> f64 {
        self.variances[0] * self.variances[1] + 4.0 * self.product().max(0.0) * self.variance_of_mean()
    }
}
