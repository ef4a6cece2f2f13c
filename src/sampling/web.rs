//! Directions drawn from a measured intensity distribution, exactly in proportion to its bilinear interpolant.

use glam::DVec3;

use crate::scene::photometry::IntensityWeb;
use crate::scene::photometry::zones::{Zone, invert_linear, sine_moments};

/// Draws directions with the density I/Φ per steradian.
///
/// The first variate chooses the angle C. The marginal density of C, a plane's flux per radian, is linear between the planes of the table.
/// The second variate chooses γ from the cumulated flux of the plane at that C. That cumulated flux is the mean of the two neighbouring
/// planes, weighted as the intensities are. Both maps are monotone and nothing is rejected, so evenly spread variates give evenly spread
/// directions.
#[derive(Clone, Debug)]
pub struct WebSampler {
    web: IntensityWeb,
    c_rad: Vec<f64>,
    gamma_rad: Vec<f64>,
    gamma_sines: Vec<f64>,
    /// Cumulated flux in lm/rad of each plane up to each γ, at the index `plane * gamma_rad.len() + i`.
    cumulated_lm_rad: Vec<f64>,
    /// Cumulated flux in lm up to each C.
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
        let gamma_sines = gamma_rad.iter().map(|gamma| gamma.sin()).collect();
        WebSampler { web: web.clone(), c_rad, gamma_rad, gamma_sines, cumulated_lm_rad, cumulated_lm }
    }

    /// Returns a unit vector along C0, C90 and γ = 0 for two variates in [0, 1).
    ///
    /// A distribution without flux returns the axis, where its density is 0.
    pub fn sample(&self, variates: [f64; 2]) -> DVec3 {
        if self.flux_lm() <= 0.0 {
            return DVec3::Z;
        }
        let row = self.gamma_rad.len();

        // Finds the column between two planes that holds the first variate's share of the flux, and the position within it.
        let target_lm = variates[0] * self.flux_lm();
        let column = interval(self.cumulated_lm.len(), target_lm, |j| self.cumulated_lm[j]);
        let (near, far) = (column * row, (column + 1) * row);
        let column_lm = self.cumulated_lm[column + 1] - self.cumulated_lm[column];
        let share = ((target_lm - self.cumulated_lm[column]) / column_lm).clamp(0.0, 1.0);
        let t = invert_linear(self.cumulated_lm_rad[near + row - 1], self.cumulated_lm_rad[far + row - 1], share);
        let c_rad = self.c_rad[column] + t * (self.c_rad[column + 1] - self.c_rad[column]);

        // Finds the zone in the plane at that C that holds the second variate's share, and the position within it.
        let between = |table: &[f64], i: usize| (1.0 - t) * table[near + i] + t * table[far + i];
        let cumulated = |i: usize| between(&self.cumulated_lm_rad, i);
        let target_lm_rad = variates[1] * cumulated(row - 1);
        let index = interval(row, target_lm_rad, cumulated);
        let zone = Zone {
            from_rad: self.gamma_rad[index],
            width_rad: self.gamma_rad[index + 1] - self.gamma_rad[index],
            sines: [self.gamma_sines[index], self.gamma_sines[index + 1]],
            intensities_cd: [index, index + 1].map(|i| between(&self.web.intensity_cd, i)),
        };
        let before_lm_rad = cumulated(index);
        let offset = zone.offset_rad_holding(target_lm_rad - before_lm_rad, cumulated(index + 1) - before_lm_rad);
        self.web.direction_at(c_rad, zone.from_rad + offset)
    }

    /// Returns the density I/Φ per steradian of a unit direction along C0, C90 and γ = 0.
    pub fn pdf_per_sr(&self, direction: DVec3) -> f64 {
        if self.flux_lm() > 0.0 { self.intensity_cd(direction) / self.flux_lm() } else { 0.0 }
    }

    /// Returns the intensity in cd in a direction along C0, C90 and γ = 0.
    pub fn intensity_cd(&self, direction: DVec3) -> f64 {
        self.web.intensity_along_cd(direction)
    }

    /// Returns the luminous flux Φ in lm: the integral of `intensity_cd` over the sphere.
    pub fn flux_lm(&self) -> f64 {
        self.cumulated_lm[self.cumulated_lm.len() - 1]
    }
}

/// Returns the interval `i` with `cumulated(i) <= target < cumulated(i + 1)`. It returns an empty interval only if all are empty.
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
    // Rounding may put the target at the very end, after intervals without flux.
    while low > 0 && cumulated(low + 1) <= cumulated(low) {
        low -= 1;
    }
    low
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{PI, TAU};

    use super::*;
    use crate::sampling::chi_square::chi_square_p;
    use crate::sampling::random::{Purpose, Stream};
    use crate::scene::photometry::PhotometricType;

    /// Probability that the test rejects a correct sampler.
    const ALPHA: f64 = 1e-3;
    /// Draws of a χ² test. A fault of 1% in half of all directions is then about ten standard deviations off.
    const DRAWS: usize = 2_000_000;
    const SEED: u64 = 20_240_917;
    /// Bins of the χ² test along the azimuth and the cosine.
    const BINS: [usize; 2] = [8, 6];
    /// Midpoints along each side of a bin, for its expected count.
    const MIDPOINTS: usize = 128;

    fn stream() -> Stream {
        Stream::new(SEED, Purpose::Pilot, 0, 0)
    }

    /// A skewed distribution: uneven steps, dark zones, a dark plane and an asymmetric lobe.
    fn skewed() -> IntensityWeb {
        let c = vec![0.0, 30.0, 100.0, 180.0, 250.0, 360.0];
        let gamma = vec![0.0, 10.0, 45.0, 90.0, 120.0, 180.0];
        let rows = [
            [5.0, 8.0, 3.0, 1.0, 0.0, 0.0],
            [5.0, 20.0, 9.0, 2.0, 0.0, 0.0],
            [5.0, 6.0, 30.0, 2.0, 4.0, 0.0],
            [0.0; 6],
            [5.0, 2.0, 0.0, 0.0, 7.0, 2.0],
            [5.0, 8.0, 3.0, 1.0, 0.0, 0.0],
        ];
        IntensityWeb::new(c, gamma, rows.concat()).unwrap()
    }

    /// A floodlight's table, dark in most directions.
    fn floodlight() -> IntensityWeb {
        let (planes, angles) = (vec![150.0, 180.0, 220.0], vec![50.0, 90.0, 110.0]);
        let cd = vec![1.0, 4.0, 2.0, 5.0, 9.0, 3.0, 2.0, 6.0, 1.0];
        IntensityWeb::on_goniometer(PhotometricType::B, planes, angles, cd).unwrap()
    }

    /// The same distribution, brighter by `excess` in the planes up to C100.
    fn with_fault(web: &IntensityWeb, excess: f64) -> IntensityWeb {
        let mut faulty = web.clone();
        let row = web.gamma_deg.len();
        for (index, cd) in faulty.intensity_cd.iter_mut().enumerate() {
            if web.c_deg[index / row] <= 100.0 {
                *cd *= 1.0 + excess;
            }
        }
        faulty
    }

    /// Returns the p-value of draws from `drawn` against the intensities of `truth`.
    fn p_of_draws(drawn: &WebSampler, truth: &IntensityWeb) -> f64 {
        let mut counts = vec![0.0; BINS[0] * BINS[1]];
        let mut stream = stream();
        for _ in 0..DRAWS {
            let direction = drawn.sample([stream.fine_unit(), stream.fine_unit()]);
            let turn = (direction.y.atan2(direction.x) / TAU).rem_euclid(1.0);
            let [i, j] = [turn, 0.5 * (1.0 - direction.z)];
            let [i, j] = [(i * BINS[0] as f64) as usize, (j * BINS[1] as f64) as usize];
            counts[i.min(BINS[0] - 1) * BINS[1] + j.min(BINS[1] - 1)] += 1.0;
        }

        let masses: Vec<f64> = (0..counts.len()).map(|bin| bin_mass(truth, bin / BINS[1], bin % BINS[1])).collect();
        let total: f64 = masses.iter().sum();
        let expected: Vec<f64> = masses.iter().map(|mass| mass / total * DRAWS as f64).collect();
        chi_square_p(&counts, &expected)
    }

    /// Returns ∫ I dω over a bin, by midpoints in azimuth and cosine.
    fn bin_mass(web: &IntensityWeb, i: usize, j: usize) -> f64 {
        let at = |k: usize, bin: usize, bins: usize| (bin as f64 + (k as f64 + 0.5) / MIDPOINTS as f64) / bins as f64;
        let mut sum = 0.0;
        for k in 0..MIDPOINTS * MIDPOINTS {
            let azimuth = TAU * at(k / MIDPOINTS, i, BINS[0]);
            let z = 1.0 - 2.0 * at(k % MIDPOINTS, j, BINS[1]);
            let radius = (1.0 - z * z).sqrt();
            sum += web.intensity_along_cd(DVec3::new(radius * azimuth.cos(), radius * azimuth.sin(), z));
        }
        sum * 4.0 * PI / (BINS[0] * BINS[1] * MIDPOINTS * MIDPOINTS) as f64
    }

    #[test]
    fn draws_follow_the_distribution_and_a_fault_of_two_percent_is_rejected() {
        let web = skewed();
        let right = p_of_draws(&WebSampler::new(&web), &web);
        assert!(right > ALPHA, "p = {right}");
        let wrong = p_of_draws(&WebSampler::new(&with_fault(&web, 0.02)), &web);
        assert!(wrong < ALPHA, "a planted fault went unseen: p = {wrong}");
    }

    #[test]
    fn density_integrates_to_one_and_total_is_the_flux() {
        for web in [skewed(), floodlight()] {
            let sampler = WebSampler::new(&web);
            assert!((sampler.flux_lm() / web.luminous_flux_lm() - 1.0).abs() < 1e-14);
            let bins = (0..BINS[0] * BINS[1]).map(|bin| bin_mass(&web, bin / BINS[1], bin % BINS[1]));
            let integral = bins.sum::<f64>() / sampler.flux_lm();
            // The table ends in steps, so the accuracy of this integral is limited by where its midpoints lie.
            assert!((integral - 1.0).abs() < 2e-3, "{integral}");
        }
        let smooth =
            IntensityWeb::new(vec![0.0, 360.0], vec![0.0, 90.0, 180.0], vec![1.0, 3.0, 2.0, 1.0, 3.0, 2.0]).unwrap();
        let sampler = WebSampler::new(&smooth);
        let integral = (0..BINS[1]).map(|j| bin_mass(&smooth, 0, j)).sum::<f64>() * BINS[0] as f64 / sampler.flux_lm();
        assert!((integral - 1.0).abs() < 1e-5, "{integral}");
    }

    /// The variates are cumulated shares of flux: the flux within the angles of a sample equals its variates.
    #[test]
    fn samples_stand_where_their_share_of_the_flux_ends() {
        // I = 1 below the horizontal: γ follows from 1 − cos γ = u, C from u alone.
        let hemisphere = IntensityWeb::new(vec![0.0, 360.0], vec![0.0, 90.0], vec![1.0; 4]).unwrap();
        let sampler = WebSampler::new(&hemisphere);
        for (u, v) in [(0.1, 0.3), (0.5, 0.999), (0.9, 1e-9), (0.25, 1e-17)] {
            let direction = sampler.sample([u, v]);
            assert!((direction.z - (1.0 - v)).abs() < 1e-14, "{direction} for {v}");
            let radius = (v * (2.0 - v)).sqrt();
            assert!((direction.x - radius * (TAU * u).cos()).abs() < 1e-13);
            assert!((direction.y - radius * (TAU * u).sin()).abs() < 1e-13);
        }
    }

    #[test]
    fn edge_variates_give_unit_directions_within_the_table() {
        let last = 1.0 - (-53_f64).exp2();
        for web in [skewed(), floodlight()] {
            let sampler = WebSampler::new(&web);
            for u in [0.0, 1e-300, 0.5, last] {
                for v in [0.0, 1e-300, 0.5, last] {
                    let direction = sampler.sample([u, v]);
                    assert!((direction.length() - 1.0).abs() < 1e-14, "{direction} for {u}, {v}");
                    assert!(sampler.pdf_per_sr(direction) >= 0.0);
                }
            }
        }
        // A table without zeros gives a density above 0 even on its edges.
        let sampler = WebSampler::new(&floodlight());
        for variates in [[0.0, 0.0], [last, last], [0.0, last], [last, 0.0]] {
            assert!(sampler.pdf_per_sr(sampler.sample(variates)) > 0.0, "{variates:?}");
        }
        let dark = WebSampler::new(&IntensityWeb::new(vec![0.0, 360.0], vec![0.0, 90.0], vec![0.0; 4]).unwrap());
        assert_eq!((dark.flux_lm(), dark.pdf_per_sr(dark.sample([0.3, 0.4]))), (0.0, 0.0));
    }

    #[test]
    fn a_floodlight_draws_by_its_own_angles() {
        let web = floodlight();
        let sampler = WebSampler::new(&web);
        let mut stream = stream();
        // The mean of 1/I over draws ∝ I is the solid angle of the table divided by its flux.
        let mean =
            (0..200_000).map(|_| 1.0 / sampler.intensity_cd(sampler.sample([stream.fine_unit(), stream.fine_unit()])));
        let mean = mean.sum::<f64>() / 200_000.0;
        let zone = 50_f64.to_radians().cos() - 110_f64.to_radians().cos();
        let exact = 70_f64.to_radians() * zone / sampler.flux_lm();
        // The tolerance is five standard errors; one is about 0.15% of the mean.
        assert!((mean / exact - 1.0).abs() < 0.0075, "{mean} {exact}");
    }
}
