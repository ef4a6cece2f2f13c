//! Computes the light of a receiver point from the values at the mesh points of its set.

use glam::{DMat3, DVec3};

use super::walks::HALVES;

/// Linear function of the offsets that fits the light of the set's points on the receiver's plane best. Its value at the receiver point has
/// no error of first order. This also holds for a set at some height or to one side.
pub struct Fit {
    /// Number of members.
    pub members: f64,
    /// Σ o and Σ o oᵀ of the offsets divided by the radius.
    sum: DVec3,
    square: DMat3,
    /// Σ E and Σ E o of each half.
    lx: [f64; HALVES],
    moment: [DVec3; HALVES],
}

/// Least determinant of the offsets' covariance, divided by the radius to the sixth power. It is 0.0024 for a whole half ball and 0 for a
/// flat set.
const LEAST_SPREAD: f64 = 2e-4;

/// Added to the offsets' sums of squares, which are in units of the radius. It has the effect of one more member a radius away along every
/// axis. The slopes of small sets add more random error than they remove bias; the ridge reduces these slopes.
const RIDGE: f64 = 0.1;

impl Fit {
    /// Returns a fit without members, with the ridge only.
    pub fn empty() -> Fit {
        Fit {
            members: 0.0,
            sum: DVec3::ZERO,
            square: DMat3::IDENTITY * RIDGE,
            lx: [0.0; HALVES],
            moment: [DVec3::ZERO; HALVES],
        }
    }

    /// Adds a member: its offset divided by the radius, and its light in lx from each half.
    pub fn add(&mut self, offset: DVec3, lx: [f64; HALVES]) {
        self.members += 1.0;
        self.sum += offset;
        self.square += DMat3::from_cols(offset * offset.x, offset * offset.y, offset * offset.z);
        for ((sum_lx, moment), lx) in self.lx.iter_mut().zip(&mut self.moment).zip(lx) {
            *sum_lx += lx;
            *moment += lx * offset;
        }
    }

    /// Returns the mean of the members.
    pub fn mean(&self) -> [f64; HALVES] {
        self.lx.map(|lx| (lx / self.members).max(0.0))
    }

    /// Returns the fit's value at the receiver point, or the mean if the set is too flat for a slope.
    pub fn at_place(&self) -> [f64; HALVES] {
        let center = self.sum / self.members;
        let outer = DMat3::from_cols(center * center.x, center * center.y, center * center.z);
        let spread = self.square * (1.0 / self.members) - outer;
        if spread.determinant() < LEAST_SPREAD {
            return self.mean();
        }
        let towards_place = spread.inverse() * -center;
        [0, 1].map(|half| {
            let mean = self.lx[half] / self.members;
            let slope = self.moment[half] / self.members - mean * center;
            (mean + slope.dot(towards_place)).max(0.0)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A fit with a slope reproduces a linear field for any set, as closely as its members outnumber the ridge. The mean does so only where
    /// the set lies around the receiver point.
    #[test]
    fn the_fit_knows_no_error_of_first_order() {
        let lx = |offset: DVec3| 5.0 + offset.dot(DVec3::new(1.0, -2.0, 3.0));
        let mut fit = Fit::empty();
        fit.square = DMat3::ZERO;
        for k in 0..2 {
            for j in -1..=1 {
                for i in -1..=1 {
                    let offset = 0.45 * DVec3::new(f64::from(i) + 0.3, f64::from(j) - 0.2, f64::from(k) + 0.5);
                    fit.add(offset, [lx(offset), 2.0 * lx(offset)]);
                }
            }
        }
        let [even, odd] = fit.at_place();
        assert!((even - 5.0).abs() < 1e-12 && (odd - 10.0).abs() < 1e-12, "{even} {odd}");
        assert!((fit.mean()[0] - 5.0).abs() > 1.0);
        fit.square += DMat3::IDENTITY * RIDGE;
        let off = (fit.at_place()[0] - 5.0).abs();
        assert!(off < 0.5 * (fit.mean()[0] - 5.0).abs(), "eighteen members outweigh the ridge: {off}");
        let mut flat = Fit::empty();
        (0..4).for_each(|i| flat.add(DVec3::new(f64::from(i % 2), f64::from(i / 2), 0.5), [1.0, 2.0]));
        assert_eq!(flat.at_place(), [1.0, 2.0]);
    }
}
