//! Direct light in closed form: from a disk, a sphere, a line, and from points between mirrors.

use std::f64::consts::PI;

use glam::DVec3;

use super::error::{AnalyticError, require, require_length, require_light, require_reflectance};
use crate::base::ball::ball_illuminance_factor;
use crate::base::sum::CompensatedSum;

/// Illuminance from a luminous disk on a plane parallel to it, at distance `height_m` and `offset_m` off its axis.
///
/// Units: m, cd/m², lx. Accuracy: the configuration factor is exact to rounding, 1e-16 absolutely.
///
/// # Errors
/// Lengths that are not positive (a negative offset), negative luminance.
pub fn disk_illuminance_lx(
    radius_m: f64,
    height_m: f64,
    offset_m: f64,
    luminance_cd_m2: f64,
) -> Result<f64, AnalyticError> {
    require_length("the disk's radius", radius_m)?;
    require_length("the distance from the disk's plane", height_m)?;
    let valid = offset_m >= 0.0 && offset_m.is_finite();
    require(valid, "the distance off the axis", offset_m, "a finite distance of at least 0", "give it in metres")?;
    require_light("the luminance", luminance_cd_m2)?;
    let (h2, r2, a2) = (height_m * height_m, offset_m * offset_m, radius_m * radius_m);
    // (1 − x/√(x² + 4h²a²))/2 with x = h² + r² − a², in a form without cancellation where x is large.
    let x = h2 + r2 - a2;
    let root = (x * x + 4.0 * h2 * a2).sqrt();
    let factor = if x > 0.0 { 2.0 * h2 * a2 / (root * (root + x)) } else { 0.5 * (1.0 - x / root) };
    Ok(PI * luminance_cd_m2 * factor)
}

/// Illuminance from a luminous sphere on a small patch at distance `distance_m` from its centre. `cosine` is that of the angle
/// between the patch's normal and the direction to the centre. The part of the sphere below the patch's horizon is cut off.
///
/// Units: m, cd/m², lx. Accuracy: 1e-15 of the illuminance without the cut.
/// Source: E. M. Sparrow, R. D. Cess, "Radiation Heat Transfer", 1978.
///
/// # Errors
/// A radius that is not positive, a point inside the sphere, a cosine outside [−1, 1], negative luminance.
pub fn sphere_illuminance_lx(
    radius_m: f64,
    distance_m: f64,
    cosine: f64,
    luminance_cd_m2: f64,
) -> Result<f64, AnalyticError> {
    require_length("the sphere's radius", radius_m)?;
    require_light("the luminance", luminance_cd_m2)?;
    let outside = distance_m > radius_m && distance_m.is_finite();
    require(outside, "the distance from the centre", distance_m, "more than the radius", "stay outside the sphere")?;
    require((-1.0..=1.0).contains(&cosine), "the cosine", cosine, "−1 to 1", "give the cosine of an angle")?;
    Ok(PI * luminance_cd_m2 * ball_illuminance_factor(cosine, distance_m / radius_m))
}

/// Illuminance from a straight line source on a plane parallel to the line, which faces it at distance `distance_m`. The line's
/// intensity falls with the cosine of the angle to its normal.
///
/// `angles_rad` are the angles of the line's two ends to the perpendicular, rising, within ±π/2. Units: cd/m (intensity of a metre
/// of line along its normal), m, lx. Accuracy: to rounding.
///
/// # Errors
/// A distance that is not positive, angles that do not rise or exceed ±π/2, negative intensity.
pub fn line_illuminance_lx(
    intensity_per_length_cd_m: f64,
    distance_m: f64,
    angles_rad: [f64; 2],
) -> Result<f64, AnalyticError> {
    require_light("the line's intensity per length", intensity_per_length_cd_m)?;
    require_length("the distance from the line", distance_m)?;
    let [low, high] = angles_rad;
    let quarter = PI / 2.0;
    require(
        low >= -quarter && low <= high,
        "the angle of the line's first end",
        low,
        "−π/2 to the second's",
        "order them",
    )?;
    require(high <= quarter, "the angle of the line's second end", high, "at most π/2", "give angles off the normal")?;
    let part = |angle: f64| angle + angle.sin() * angle.cos();
    Ok(intensity_per_length_cd_m / (2.0 * distance_m) * (part(high) - part(low)))
}

/// Two parallel mirrors, at x = 0 and at x = `gap_m`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TwoMirrors {
    /// Distance between the mirrors, m.
    pub gap_m: f64,
    /// Specular reflectance of both mirrors, 0 to below 1.
    pub reflectance: f64,
}

impl TwoMirrors {
    /// Illuminance at a point between the mirrors with a unit `normal`, from an isotropic point source and all its images.
    ///
    /// Returns the source's own contribution and that of the images. Units: m, cd, lx. Accuracy: 1e-13 of the total (the sum over
    /// the images stops when the rest is below this).
    ///
    /// # Errors
    /// A gap that is not positive, a reflectance outside [0, 1), a source or point not between the mirrors, or both at the same
    /// position.
    pub fn point_illuminance_lx(
        &self,
        source: DVec3,
        intensity_cd: f64,
        point: DVec3,
        normal: DVec3,
    ) -> Result<(f64, f64), AnalyticError> {
        let TwoMirrors { gap_m, reflectance } = *self;
        require_length("the gap between the mirrors", gap_m)?;
        require_reflectance("the mirrors' reflectance", reflectance)?;
        require(reflectance < 1.0, "the mirrors' reflectance", reflectance, "less than 1", "let the mirrors absorb")?;
        require_light("the source's intensity", intensity_cd)?;
        let remedy = "put source and point between the mirrors";
        for (what, x) in [("the source's x", source.x), ("the point's x", point.x)] {
            require((0.0..=gap_m).contains(&x), what, x, &format!("0 to {gap_m} m"), remedy)?;
        }
        let apart = (source - point).length();
        require(apart > 0.0, "the distance from source to point", apart, "more than 0", "move the point")?;

        let from = |x: f64| {
            let to = DVec3::new(x, source.y, source.z) - point;
            intensity_cd * normal.dot(to).max(0.0) / to.length().powi(3)
        };
        let mut images = CompensatedSum::new();
        let mut weight = 1.0;
        for order in 1.. {
            weight *= reflectance;
            // An even number of reflections shifts the source by that many gaps. An odd number also mirrors it.
            let shift = order as f64 * gap_m;
            let pair = match order % 2 {
                0 => from(source.x + shift) + from(source.x - shift),
                _ => from(shift + gap_m - source.x) + from(-(shift - gap_m) - source.x),
            };
            images.add(weight * pair);
            // The rest is at most two images per order at the next distance, each order weaker by the reflectance.
            let nearest = (shift - gap_m).max(gap_m * f64::EPSILON);
            let left = 2.0 * intensity_cd * weight * reflectance / (1.0 - reflectance) / (nearest * nearest);
            if left <= 1e-14 * (from(source.x) + images.value()) || weight == 0.0 {
                break;
            }
        }
        Ok((from(source.x), images.value()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_published_disk_is_met() {
        for (offset, exact) in [(0.0, 184.799568), (0.5, 165.833381), (1.0, 123.094865), (2.0, 49.829863)] {
            let value = disk_illuminance_lx(0.5, 2.0, offset, 1000.0).expect("valid");
            assert!((value - exact).abs() < 6e-7, "{value} {exact}");
        }
        // Far away the inverse square law holds: πa² L h²/d⁴.
        let far = disk_illuminance_lx(1e-6, 3.0, 4.0, 1.0).expect("valid");
        assert!((far / (PI * 1e-12 * 9.0 / 625.0) - 1.0).abs() < 1e-11);
    }

    #[test]
    fn the_published_sphere_is_met_across_the_horizon() {
        for (cosine, exact) in [(0.1, 0.00433087), (0.0, 0.00171847), (-0.1, 0.00033087)] {
            let value = sphere_illuminance_lx(1.0, 5.0, cosine, 1.0 / PI).expect("valid");
            assert!((value - exact).abs() < 6e-9, "{value} {exact}");
        }
        assert_eq!(sphere_illuminance_lx(1.0, 5.0, -0.2, 1.0), Ok(0.0));
        let whole = sphere_illuminance_lx(1.0, 5.0, 0.5, 1000.0).expect("valid");
        assert!((whole / (PI * 1000.0 / 25.0 * 0.5) - 1.0).abs() < 1e-15);
        // Both forms agree where the sphere touches the horizon.
        let [cut, uncut] = [0.2 - 1e-9, 0.2].map(|c| sphere_illuminance_lx(1.0, 5.0, c, 1.0).expect("valid"));
        assert!((cut - uncut).abs() < 1e-9);
    }

    #[test]
    fn the_published_line_is_met() {
        // The table gives the line's ends in metres, at a distance of 2 m.
        for (half_m, exact) in [(1.0, 43.182380), (0.6, 28.334308), (f64::INFINITY, 78.539816)] {
            let half = (half_m / 2.0f64).atan();
            let value = line_illuminance_lx(100.0, 2.0, [-half, half]).expect("valid");
            assert!((value - exact).abs() < 6e-7, "{value} {exact}");
        }
    }

    #[test]
    fn the_published_mirrors_are_met() {
        let table = [
            (0.0, [181.65056, 198.94368, 142.35251, 70.33721, 48.49917]),
            (0.5, [236.90587, 239.00067, 166.26065, 90.36980, 69.91754]),
            (0.9, [285.28556, 275.07542, 189.47475, 111.06718, 92.28252]),
            (0.99, [297.24080, 284.23182, 195.73286, 116.83432, 98.50101]),
        ];
        let source = DVec3::new(1.0, 0.0, 2.0);
        for (reflectance, values) in table {
            let mirrors = TwoMirrors { gap_m: 4.0, reflectance };
            for (x, exact) in [0.5, 1.0, 2.0, 3.0, 3.5].iter().zip(values) {
                let point = DVec3::new(*x, 0.0, 0.0);
                let (direct, images) =
                    mirrors.point_illuminance_lx(source, 10_000.0 / (4.0 * PI), point, DVec3::Z).expect("valid");
                assert!((direct + images - exact).abs() < 6e-6, "{reflectance} {x}: {direct} {images} {exact}");
            }
        }
    }

    #[test]
    fn what_has_no_answer_is_refused() {
        assert!(disk_illuminance_lx(0.5, 0.0, 0.0, 1.0).is_err());
        assert!(sphere_illuminance_lx(1.0, 0.9, 0.0, 1.0).is_err());
        assert!(line_illuminance_lx(1.0, 1.0, [0.5, 0.4]).is_err());
        let at = DVec3::new(1.0, 0.0, 0.0);
        assert!(
            TwoMirrors { gap_m: 2.0, reflectance: 1.0 }.point_illuminance_lx(at, 1.0, at + DVec3::Y, DVec3::Z).is_err()
        );
        assert!(TwoMirrors { gap_m: 2.0, reflectance: 0.5 }.point_illuminance_lx(at, 1.0, at, DVec3::Z).is_err());
    }
}
