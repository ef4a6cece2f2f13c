//! The light of a place from what the points of its set say.

use glam::{DMat3, DVec3};

use super::walks::HALVES;

/// What the points of a set would bring to a place's plane, and the linear function of their offsets that fits it best:
/// its value at the place has no error of first order, neither from the height that the set lies at nor from a set that
/// lies to one side.
pub struct Fit {
    /// How many members it has.
    pub members: f64,
    /// Σ o and Σ o oᵀ of the offsets over the radius.
    sum: DVec3,
    square: DMat3,
    /// Σ E and Σ E o of each half.
    lx: [f64; HALVES],
    moment: [DVec3; HALVES],
}

/// Least determinant of the offsets' covariance, over the radius to the sixth: a whole half ball's is 0.0024, a flat set's 0.
const LEAST_SPREAD: f64 = 2e-4;

/// Added to the offsets' sums of squares, which are in units of the radius: as much as one more member a radius away along
/// every axis. The slopes of small sets bring more chance than they take error; this draws them towards 0.
const RIDGE: f64 = 0.1;

impl Fit {
    /// No member yet, but the ridge.
    pub fn empty() -> Fit {
        Fit {
            members: 0.0,
            sum: DVec3::ZERO,
            square: DMat3::IDENTITY * RIDGE,
            lx: [0.0; HALVES],
            moment: [DVec3::ZERO; HALVES],
        }
    }

    /// Adds a member by its offset over the radius, and what it would bring in lx by each half.
    pub fn add(&mut self, offset: DVec3, lx: [f64; HALVES]) {
        self.members += 1.0;
        self.sum += offset;
        self.square += DMat3::from_cols(offset * offset.x, offset * offset.y, offset * offset.z);
        for ((sum_lx, moment), lx) in self.lx.iter_mut().zip(&mut self.moment).zip(lx) {
            *sum_lx += lx;
            *moment += lx * offset;
        }
    }

    /// The members' mean.
    pub fn mean(&self) -> [f64; HALVES] {
        self.lx.map(|lx| (lx / self.members).max(0.0))
    }

    /// The fit's value at the place; the mean where the set is too flat for a slope.
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

    /// A linear field is met by any set with a slope, as nearly as its members outnumber the ridge, and by the mean only
    /// where the set lies around the place.
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
