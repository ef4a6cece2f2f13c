//! Spheres: the kernel between any two points of a sphere is constant, so every solution has a closed form.

use std::f64::consts::PI;

use super::error::{AnalyticError, require, require_length, require_light, require_reflectance};

/// Indirect illuminance in a closed diffuse sphere of uniform reflectance. It is the same everywhere, for any position and
/// distribution of the source.
///
/// Units: m, lm, lx. Accuracy: to rounding.
///
/// # Errors
/// A radius that is not positive, negative flux, a reflectance outside [0, 1) (at 1 the light accumulates without bound).
///
/// ```
/// use luxmc::analytic::sphere::sphere_indirect_lx;
///
/// assert!((sphere_indirect_lx(1.0, 10_000.0, 0.8)? - 3183.0989).abs() < 1e-4);
/// # Ok::<(), luxmc::analytic::AnalyticError>(())
/// ```
pub fn sphere_indirect_lx(radius_m: f64, luminous_flux_lm: f64, reflectance: f64) -> Result<f64, AnalyticError> {
    require_length("the sphere's radius", radius_m)?;
    require_light("the flux", luminous_flux_lm)?;
    let area_m2 = 4.0 * PI * radius_m * radius_m;
    rank_one_indirect_lx(reflectance * luminous_flux_lm / area_m2, reflectance)
}

/// Indirect illuminance in a closed diffuse sphere with any reflectance map: ⟨ρE₀⟩/(1 − ⟨ρ⟩), the same everywhere.
///
/// ⟨ρE₀⟩ is the area mean of reflectance times direct illuminance, ⟨ρ⟩ that of the reflectance. Units: lx. Accuracy: to rounding.
///
/// # Errors
/// A mean reflectance outside [0, 1), a negative or infinite mean.
pub fn rank_one_indirect_lx(mean_reflected_direct_lx: f64, mean_reflectance: f64) -> Result<f64, AnalyticError> {
    require_light("the mean of reflectance times direct illuminance", mean_reflected_direct_lx)?;
    require_reflectance("the sphere's mean reflectance", mean_reflectance)?;
    let remedy = "let some of the sphere absorb: nothing leaves it otherwise";
    require(mean_reflectance < 1.0, "the sphere's mean reflectance", mean_reflectance, "less than 1", remedy)?;
    Ok(mean_reflected_direct_lx / (1.0 - mean_reflectance))
}

/// Indirect illuminance in a sphere whose two hemispheres have different reflectances. An isotropic point source lies on their
/// common axis, `height_m` above the centre.
///
/// Units: m, lm, lx. Accuracy: to rounding.
///
/// # Errors
/// As [`sphere_indirect_lx`], and a source outside the sphere.
pub fn two_hemispheres_indirect_lx(
    radius_m: f64,
    height_m: f64,
    luminous_flux_lm: f64,
    upper_reflectance: f64,
    lower_reflectance: f64,
) -> Result<f64, AnalyticError> {
    require_length("the sphere's radius", radius_m)?;
    require_light("the flux", luminous_flux_lm)?;
    require_reflectance("the upper hemisphere's reflectance", upper_reflectance)?;
    require_reflectance("the lower hemisphere's reflectance", lower_reflectance)?;
    let inside = height_m.abs() < radius_m;
    require(inside, "the source's height", height_m, "less than the radius", "put the source into the sphere")?;
    let lower_share = 0.5 * (1.0 - height_m / radius_m.hypot(height_m));
    let area_m2 = 4.0 * PI * radius_m * radius_m;
    let reflected = upper_reflectance * (1.0 - lower_share) + lower_reflectance * lower_share;
    rank_one_indirect_lx(reflected * luminous_flux_lm / area_m2, 0.5 * (upper_reflectance + lower_reflectance))
}

/// Illuminances on two concentric spheres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ConcentricSpheres {
    /// Illuminance on the outside of the inner sphere, lx.
    pub inner_lx: f64,
    /// Illuminance on the inside of the outer sphere, direct and indirect, lx.
    pub outer_lx: f64,
}

/// Illuminances between two concentric diffuse spheres. The inner sphere emits uniformly.
///
/// Units: m, lm, lx. Accuracy: to rounding.
///
/// # Errors
/// Radii that are not positive and rising, reflectances outside [0, 1] or both 1, negative flux.
pub fn concentric_spheres(
    inner_radius_m: f64,
    outer_radius_m: f64,
    luminous_flux_lm: f64,
    inner_reflectance: f64,
    outer_reflectance: f64,
) -> Result<ConcentricSpheres, AnalyticError> {
    require_length("the inner radius", inner_radius_m)?;
    require_length("the outer radius", outer_radius_m)?;
    require_light("the flux", luminous_flux_lm)?;
    require_reflectance("the inner reflectance", inner_reflectance)?;
    require_reflectance("the outer reflectance", outer_reflectance)?;
    let remedy = "make the outer sphere the larger";
    require(inner_radius_m < outer_radius_m, "the inner radius", inner_radius_m, "less than the outer", remedy)?;
    let absorbs = outer_reflectance < 1.0 || inner_reflectance < 1.0;
    require(absorbs, "the reflectance of both spheres", 1.0, "less than 1 on one sphere at least", "let one absorb")?;
    let exitance_lm_m2 = luminous_flux_lm / (4.0 * PI * inner_radius_m * inner_radius_m);
    let to_inner = (inner_radius_m / outer_radius_m).powi(2);
    let to_itself = 1.0 - to_inner;
    let outer_lx = to_inner * exitance_lm_m2 / (1.0 - outer_reflectance * (to_itself + inner_reflectance * to_inner));
    Ok(ConcentricSpheres { inner_lx: outer_reflectance * outer_lx, outer_lx })
}

/// Exitance that a surface of an isothermal enclosure must have. With these exitances the luminance is the same everywhere and in
/// every direction. The illuminance is π times the luminance at every point, for any geometry and reflection.
///
/// A surface of reflectance ρ emits (1 − ρ)πL₀ itself. Units: cd/m², lm/m². Accuracy: to rounding.
///
/// # Errors
/// A reflectance outside [0, 1], a negative luminance.
pub fn isothermal_exitance_lm_m2(reflectance: f64, luminance_cd_m2: f64) -> Result<f64, AnalyticError> {
    require_reflectance("the reflectance", reflectance)?;
    require_light("the luminance", luminance_cd_m2)?;
    Ok((1.0 - reflectance) * PI * luminance_cd_m2)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_hemispheres_meet_the_published_values() {
        let table = [
            (0.0, 0.8, 0.2, 795.7747),
            (0.5, 0.8, 0.2, 1009.3035),
            (0.5, 0.2, 0.8, 582.2460),
            (0.9, 0.8, 0.8, 3183.0989),
        ];
        for (height, upper, lower, exact) in table {
            let value = two_hemispheres_indirect_lx(1.0, height, 10_000.0, upper, lower).expect("valid");
            assert!((value - exact).abs() < 6e-5, "{value} {exact}");
        }
    }

    #[test]
    fn concentric_spheres_meet_the_published_values() {
        let table =
            [(0.5, 0.5, 1414.7106, 707.3553), (0.0, 0.8, 1989.4368, 1591.5494), (0.9, 0.9, 6496.1201, 5846.5081)];
        for (inner, outer, outer_lx, inner_lx) in table {
            let value = concentric_spheres(0.5, 1.0, 10_000.0, inner, outer).expect("valid");
            assert!((value.outer_lx - outer_lx).abs() < 6e-5 && (value.inner_lx - inner_lx).abs() < 6e-5, "{value:?}");
        }
    }

    #[test]
    fn what_has_no_answer_is_refused() {
        assert!(sphere_indirect_lx(1.0, 1.0, 1.0).is_err());
        assert!(sphere_indirect_lx(0.0, 1.0, 0.5).is_err());
        assert!(sphere_indirect_lx(1.0, f64::NAN, 0.5).is_err());
        assert!(two_hemispheres_indirect_lx(1.0, 1.0, 1.0, 0.5, 0.5).is_err());
        assert!(concentric_spheres(1.0, 0.5, 1.0, 0.5, 0.5).is_err());
        assert!(concentric_spheres(0.5, 1.0, 1.0, 1.0, 1.0).is_err());
        assert!(isothermal_exitance_lm_m2(1.1, 1.0).is_err());
        assert_eq!(isothermal_exitance_lm_m2(1.0, 5.0), Ok(0.0));
    }
}
