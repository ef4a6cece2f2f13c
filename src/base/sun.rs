//! The sun's disk: its luminance in a direction and the illuminance that it gives planes.

use std::f64::consts::{PI, TAU};

use glam::DVec3;

use super::ball::ball_illuminance_factor;

/// Half of the disk's angular diameter in degrees: 0.53° across on average over the year.
pub const HALF_ANGLE_DEG: f64 = 0.265;

/// A uniformly bright disk of the sky. The z axis points up.
#[derive(Clone, Copy, Debug)]
pub struct Sun {
    towards: DVec3,
    /// π times the luminance.
    exitance_lm_m2: f64,
    sine: f64,
    one_minus_cosine: f64,
}

impl Sun {
    /// Makes a sun in a unit direction from the illuminance in lx that its whole disk gives a plane across its rays.
    ///
    /// ```
    /// use glam::DVec3;
    /// use luxmc::base::sun::Sun;
    ///
    /// let sun = Sun::of_normal(DVec3::new(0.0, -0.6, 0.8), 100_000.0);
    /// assert!((sun.illuminance_lx(DVec3::Z) - 80_000.0).abs() < 1e-6);
    /// ```
    pub fn of_normal(towards: DVec3, normal_lx: f64) -> Sun {
        let (sine, cosine) = HALF_ANGLE_DEG.to_radians().sin_cos();
        let one_minus_cosine = sine * sine / (1.0 + cosine);
        Sun { towards, exitance_lm_m2: normal_lx / (sine * sine), sine, one_minus_cosine }
    }

    /// Makes a sun from the illuminance in lx that it gives an open horizontal plane; `None` where it stands below the horizon.
    pub fn of_horizontal(towards: DVec3, horizontal_lx: f64) -> Option<Sun> {
        let unit_lx = Sun::of_normal(towards, 1.0).illuminance_lx(DVec3::Z);
        (unit_lx > 0.0).then(|| Sun::of_normal(towards, horizontal_lx / unit_lx))
    }

    /// Returns the unit direction of its centre.
    pub fn towards(&self) -> DVec3 {
        self.towards
    }

    /// Returns the sine of half its angular diameter.
    pub fn sine(&self) -> f64 {
        self.sine
    }

    /// Returns 1 − cos of half its angular diameter.
    pub fn one_minus_cosine(&self) -> f64 {
        self.one_minus_cosine
    }

    /// Whether any of it stands above the horizon.
    pub fn is_up(&self) -> bool {
        self.towards.z > -self.sine
    }

    /// Returns the luminance in cd/m² in a unit direction: 0 outside the disk and below the horizon.
    pub fn luminance_cd_m2(&self, towards: DVec3) -> f64 {
        // 1 − cos from the chord, which is accurate for small angles.
        let is_in_disk = 0.5 * self.towards.distance_squared(towards) <= self.one_minus_cosine;
        if is_in_disk && towards.z > 0.0 { self.exitance_lm_m2 / PI } else { 0.0 }
    }

    /// Returns the illuminance in lx that the whole disk gives a plane with a unit normal where nothing hides it. The part behind the plane
    /// gives nothing.
    ///
    /// Accuracy: a closed form.
    pub fn illuminance_lx(&self, normal: DVec3) -> f64 {
        self.exitance_lm_m2 * ball_illuminance_factor(normal.dot(self.towards), self.sine.recip())
    }

    /// Returns the illuminance in lx on a plane across its rays.
    pub fn normal_lx(&self) -> f64 {
        self.exitance_lm_m2 * self.sine * self.sine
    }

    /// Returns ∫ L dω over the disk, in cd·sr/m².
    pub fn total_cd_sr_m2(&self) -> f64 {
        self.exitance_lm_m2 / PI * TAU * self.one_minus_cosine
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// High above the horizon the cosine law holds. Half the disk on the horizon is worked out by hand (2 sin α/(3π) of the normal
    /// illuminance to first order). Below the horizon there is nothing.
    #[test]
    fn a_disk_brings_what_is_above_the_horizon() {
        let at = |elevation_deg: f64| {
            let (height, flat) = elevation_deg.to_radians().sin_cos();
            Sun::of_normal(DVec3::new(flat, 0.0, height), 90_000.0)
        };
        assert!((at(30.0).illuminance_lx(DVec3::Z) / 45_000.0 - 1.0).abs() < 1e-12);
        assert!((at(90.0).normal_lx() - 90_000.0).abs() < 1e-6);
        // ∫ of the height over half a disk of radius α is 2α³/3; divided by the disk's πα².
        let half = 90_000.0 * 2.0 * HALF_ANGLE_DEG.to_radians() / (3.0 * PI);
        assert!((at(0.0).illuminance_lx(DVec3::Z) / half - 1.0).abs() < 1e-4);
        assert!((at(0.1).illuminance_lx(DVec3::Z) / half - 1.0).abs() > 0.1, "the planted fault passed");
        assert_eq!(at(-0.3).illuminance_lx(DVec3::Z), 0.0);
        assert!(!at(-0.3).is_up() && at(-0.2).is_up());
        assert!(Sun::of_horizontal(at(-0.3).towards(), 1.0).is_none());
        let low = Sun::of_horizontal(at(0.2).towards(), 300.0).expect("above the horizon");
        assert!((low.illuminance_lx(DVec3::Z) - 300.0).abs() < 1e-9);
        // L ω equals the normal illuminance except for the cosines within the disk.
        assert!((at(50.0).total_cd_sr_m2() / 90_000.0 - 1.0).abs() < 1e-5);
        let edge = |deg: f64| DVec3::new(0.0, deg.to_radians().sin(), deg.to_radians().cos());
        assert!(at(90.0).luminance_cd_m2(edge(0.26)) > 1e9 && at(90.0).luminance_cd_m2(edge(0.27)) == 0.0);
    }
}
