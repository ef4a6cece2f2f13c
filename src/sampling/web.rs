//! Directions drawn from a measured intensity distribution, exactly in proportion to its bilinear interpolant.

use glam::DVec3;

use crate::scene::photometry::IntensityWeb;
use crate::scene::photometry::zones::{invert_linear, invert_zone, sine_moments};

/// Draws directions with the density I/Φ per steradian.
///
/// The first variate chooses the angle C: its marginal density, a plane's flux per radian, is linear between the planes of the
/// table. The second chooses γ by the cumulated flux of the plane at that C, which is the mean of its two
/// neighbours', weighted as the intensities are. Both maps are monotone and
/// nothing is rejected, so that well spread variates give well spread directions.
#[derive(Clone, Debug)]
pub struct WebSampler {
    web: IntensityWeb,
    c_rad: Vec<f64>,
    gamma_rad: Vec<f64>,
    /// Flux in lm/rad of each plane up to each γ: `plane * gamma_rad.len() + i`.
    cumulated_lm_rad: Vec<f64>,
    /// Flux in lm up to each C.
    cumulated_lm: Vec<f64>,
}

impl WebSampler {
    /// Prepares the cumulated fluxes of a distribution.
    pub fn new(web: &IntensityWeb) -> Self {
        let c_rad: Vec<f64> = web.c_deg.iter().map(|angle| angle.to_radians()).collect();
        let gamma_rad: Vec<f64> = web.gamma_deg.iter().map(|angle| angle.to_radians()).collect();
        let row = gamma_rad.len();
        let mut cumulated_lm_rad = vec![0.0; c_rad.len() * row];
        for (cumulated, cd) in cumulated_lm_rad.chunks_exact_mut(row).zip(web.intensity_cd.chunks_exact(row)) {
            for i in 1..row {
                let moments = sine_moments(gamma_rad[i - 1], gamma_rad[i] - gamma_rad[i - 1]);
                cumulated[i] = cumulated[i - 1] + cd[i - 1] * moments.whole + (cd[i] - cd[i - 1]) * moments.ramp;
            }
        }
        let mut cumulated_lm = vec![0.0; c_rad.len()];
        for j in 1..c_rad.len() {
            let (before, here) = (cumulated_lm_rad[j * row - 1], cumulated_lm_rad[(j + 1) * row - 1]);
            cumulated_lm[j] = cumulated_lm[j - 1] + (c_rad[j] - c_rad[j - 1]) * 0.5 * (before + here);
        }
        WebSampler { web: web.clone(), c_rad, gamma_rad, cumulated_lm_rad, cumulated_lm }
    }

    /// A unit vector along C0, C90 and γ = 0 for two variates in [0, 1).
    ///
    /// A distribution without flux gives the axis, where its density is 0.
    pub fn sample(&self, variates: [f64; 2]) -> DVec3 {
        if self.total() <= 0.0 {
            return DVec3::Z;
        }
        let row = self.gamma_rad.len();

        // The column between two planes that holds the first variate's share of the flux, and where in it.
        let target_lm = variates[0] * self.total();
        let column = interval(self.cumulated_lm.len(), target_lm, |j| self.cumulated_lm[j]);
        let (near, far) = (column * row, (column + 1) * row);
        let column_lm = self.cumulated_lm[column + 1] - self.cumulated_lm[column];
        let share = ((target_lm - self.cumulated_lm[column]) / column_lm).clamp(0.0, 1.0);
        let t = invert_linear(self.cumulated_lm_rad[near + row - 1], self.cumulated_lm_rad[far + row - 1], share);
        let c_rad = self.c_rad[column] + t * (self.c_rad[column + 1] - self.c_rad[column]);

        // In the plane at that C, the zone that holds the second variate's share, and where in it.
        let between = |table: &[f64], i: usize| (1.0 - t) * table[near + i] + t * table[far + i];
        let cumulated = |i: usize| between(&self.cumulated_lm_rad, i);
        let target_lm_rad = variates[1] * cumulated(row - 1);
        let zone = interval(row, target_lm_rad, cumulated);
        let (from, to) = (self.gamma_rad[zone], self.gamma_rad[zone + 1]);
        let (from_cd, to_cd) = (between(&self.web.intensity_cd, zone), between(&self.web.intensity_cd, zone + 1));
        let offset = invert_zone(from, to - from, from_cd, to_cd, target_lm_rad - cumulated(zone));
        self.web.direction_at(c_rad, from + offset)
    }

    /// Density per steradian of a unit direction along C0, C90 and γ = 0: I/Φ.
    pub fn pdf_per_sr(&self, direction: DVec3) -> f64 {
        if self.total() > 0.0 { self.eval(direction) / self.total() } else { 0.0 }
    }

    /// Intensity in cd of a direction along C0, C90 and γ = 0.
    pub fn eval(&self, direction: DVec3) -> f64 {
        self.web.intensity_along_cd(direction)
    }

    /// Luminous flux Φ in lm: the integral of `eval` over the sphere.
    pub fn total(&self) -> f64 {
        self.cumulated_lm[self.cumulated_lm.len() - 1]
    }
}

/// The interval `i` with `cumulated(i) <= target < cumulated(i + 1)`; never an empty one, if any is not.
fn interval(count: usize, target: f64, cumulated: impl Fn(usize) -> f64) -> usize {
    let (mut low, mut high) = (0, count - 1);
    while high - low > 1 {
        let middle = usize::midpoint(low, high);
        if cumulated(middle) <= target {
            low = middle;
        } else {
            high = middle;
        }
    }
    // Rounding may put the target on the very end, behind intervals without flux.
    while low > 0 && cumulated(low + 1) <= cumulated(low) {
        low -= 1;
    }
    low
}
