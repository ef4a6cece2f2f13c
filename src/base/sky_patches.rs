//! The sky divided into patches: Reinhart's subdivision of Tregenza's 145 patches.
//!
//! Source: P. R. Tregenza, Subdivision of the sky hemisphere for luminance measurements, Lighting Research and Technology 19 (1987) 13–14;
//! C. F. Reinhart, Daylight availability and manual lighting control in office buildings (2001).

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use glam::DVec3;

/// Number of patches in each of Tregenza's rows below the zenith.
const TREGENZA: [u32; 7] = [30, 30, 24, 24, 18, 12, 6];

/// Rows of equal height around a cap in the zenith. Patches are numbered from the horizon upwards. Each row runs from north (+y) towards
/// east (+x), and its first patch is centred on north.
#[derive(Clone, Debug)]
pub struct SkyPatches {
    /// Number of the first patch of each row, where the cap counts as a row. The last entry is the number of all patches.
    firsts: Vec<u32>,
    /// Height of a row in radians.
    height_rad: f64,
}

impl SkyPatches {
    /// Makes Tregenza's patches with each side cut into `subdivision` parts.
    ///
    /// ```
    /// use luxmc::base::sky_patches::SkyPatches;
    ///
    /// assert_eq!([1, 2, 4].map(|subdivision| SkyPatches::new(subdivision).count()), [145, 577, 2305]);
    /// ```
    pub fn new(subdivision: u32) -> SkyPatches {
        let mut firsts = vec![0];
        for across in TREGENZA {
            for _ in 0..subdivision {
                firsts.push(firsts[firsts.len() - 1] + subdivision * across);
            }
        }
        firsts.push(firsts[firsts.len() - 1] + 1);
        SkyPatches { height_rad: FRAC_PI_2 / (f64::from(TREGENZA.len() as u32 * subdivision) + 0.5), firsts }
    }

    /// Returns the number of patches.
    pub fn count(&self) -> usize {
        self.firsts[self.firsts.len() - 1] as usize
    }

    /// Returns the patch that holds a unit direction; `None` below the horizon.
    pub fn patch_of(&self, towards: DVec3) -> Option<usize> {
        if towards.z <= 0.0 {
            return None;
        }
        let elevation = towards.z.atan2(towards.x.hypot(towards.y));
        let cap = self.firsts.len() - 2;
        let row = ((elevation / self.height_rad) as usize).min(cap);
        let across = self.firsts[row + 1] - self.firsts[row];
        let turn = towards.x.atan2(towards.y) / TAU;
        let place = ((turn * f64::from(across) + 0.5).rem_euclid(f64::from(across)) as u32).min(across - 1);
        Some((self.firsts[row] + place) as usize)
    }

    /// Returns the limits of a patch: the sines of its elevations, and its azimuths (radians, from north towards east).
    fn bounds(&self, patch: usize) -> [[f64; 2]; 2] {
        let row = self.firsts.partition_point(|first| *first as usize <= patch) - 1;
        let across = f64::from(self.firsts[row + 1] - self.firsts[row]);
        let place = (patch - self.firsts[row] as usize) as f64;
        let is_cap = row + 2 == self.firsts.len();
        let sine = |step: f64| (step * self.height_rad).sin();
        let upper = if is_cap { 1.0 } else { sine(row as f64 + 1.0) };
        [[sine(row as f64), upper], [-0.5, 0.5].map(|side| TAU * (place + side) / across)]
    }

    /// Returns the solid angle of a patch in sr.
    pub fn solid_angle_sr(&self, patch: usize) -> f64 {
        let [[low, high], [from, to]] = self.bounds(patch);
        (high - low) * (to - from)
    }

    /// Returns ∫ sin γ dω over a patch in sr: the illuminance of an open horizontal plane over the patch's luminance.
    pub fn horizontal_sr(&self, patch: usize) -> f64 {
        let [[low, high], [from, to]] = self.bounds(patch);
        0.5 * (high * high - low * low) * (to - from)
    }

    /// Returns `parts`² directions, each the middle of an equal part of a patch's solid angle.
    pub fn directions(&self, patch: usize, parts: u32) -> impl Iterator<Item = DVec3> {
        let [[low, high], [from, to]] = self.bounds(patch);
        let share = move |part: u32| (f64::from(part) + 0.5) / f64::from(parts);
        (0..parts * parts).map(move |part| {
            let sine = low + share(part / parts) * (high - low);
            let (east, north) = (from + share(part % parts) * (to - from)).sin_cos();
            let cosine = (1.0 - sine * sine).max(0.0).sqrt();
            DVec3::new(cosine * east, cosine * north, sine)
        })
    }
}

/// ∫ sin γ dω over the whole sky, to check sums against.
pub const HORIZONTAL_SR: f64 = PI;

#[cfg(test)]
mod tests {
    use super::*;

    /// The directions of every patch lie in it. All solid angles add up to that of the sky. Every direction has a patch, and the cap is as
    /// wide as a row is high. Rows 4% too high, the planted fault, are detected by the directions and by the cap.
    #[test]
    fn patches_part_the_sky() {
        for subdivision in 1..=4 {
            let patches = SkyPatches::new(subdivision);
            let faulty = SkyPatches { height_rad: 1.04 * patches.height_rad, ..patches.clone() };
            let holds = |patch: usize, of: &SkyPatches| {
                of.directions(patch, 3).all(|towards| patches.patch_of(towards) == Some(patch))
            };
            assert!((0..patches.count()).all(|patch| holds(patch, &patches)), "{subdivision}");
            assert!(!(0..patches.count()).all(|patch| holds(patch, &faulty)), "the planted fault passed");
            let sum = |of: &dyn Fn(usize) -> f64| (0..patches.count()).map(of).sum::<f64>();
            assert!((sum(&|patch| patches.solid_angle_sr(patch)) - TAU).abs() < 1e-9);
            assert!((sum(&|patch| patches.horizontal_sr(patch)) - HORIZONTAL_SR).abs() < 1e-9);
            let off = |of: &SkyPatches| of.solid_angle_sr(of.count() - 1) - TAU * (1.0 - (0.5 * of.height_rad).cos());
            assert!(off(&patches).abs() < 1e-12 && off(&faulty).abs() > 1e-6, "the planted fault passed");
        }
    }

    /// The first patch is centred on north and the next one lies towards east. The zenith belongs to the cap. There is no patch below the
    /// horizon.
    #[test]
    fn patches_are_numbered_from_north_towards_east() {
        let patches = SkyPatches::new(1);
        let at = |azimuth_deg: f64, elevation_deg: f64| {
            patches.patch_of(super::super::solar_position::direction_of(elevation_deg, azimuth_deg))
        };
        assert_eq!([at(0.0, 6.0), at(5.9, 6.0), at(6.1, 6.0), at(354.1, 6.0)], [0, 0, 1, 0].map(Some));
        assert_eq!([at(353.9, 6.0), at(0.0, 18.0), at(0.0, 85.0)], [29, 30, 144].map(Some));
        assert_eq!((at(40.0, 90.0), at(40.0, -1.0)), (Some(144), None));
    }
}
