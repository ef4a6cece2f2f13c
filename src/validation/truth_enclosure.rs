//! Truths from flux balance: enclosures of uniform reflectance, and spheres.

use std::f64::consts::PI;

use super::exact::{Exact, LightPart, TruthSite};
use crate::analytic::sphere::{concentric_spheres, rank_one_indirect_lx};
use crate::scene::Scene;

/// Area in m² of a scene's triangles, or of those of a surface, geometry or part with this name.
pub(super) fn mesh_area_m2(scene: &Scene, name: Option<&str>) -> f64 {
    let counts = |triangle: &u32| {
        let surface = scene.surface_of(*triangle);
        let part = surface.name.rsplit('/').next();
        name.is_none_or(|name| surface.name == name || surface.geometry == name || part == Some(name))
    };
    (0..scene.triangles.len() as u32).filter(counts).map(|triangle| scene.triangle_area_m2(triangle)).sum()
}

/// X = Φ + ρX for the incident flux X. The mean total illuminance is Φ/(S(1−ρ)), the mean indirect illuminance ρ times that.
pub(super) fn uniform_enclosure(
    scene: &Scene,
    luminous_flux_lm: f64,
    reflectance: f64,
    ideal_area_m2: Option<f64>,
    light: LightPart,
) -> Result<Exact, String> {
    let incident_lm = luminous_flux_lm / (1.0 - reflectance);
    let share = match light {
        LightPart::Total => 1.0,
        LightPart::Indirect => reflectance,
        LightPart::Direct => 1.0 - reflectance,
    };
    let area_m2 = mesh_area_m2(scene, None);
    let value_lx = share * incident_lm / area_m2;
    let discretisation_lx = ideal_area_m2.map_or(0.0, |ideal| (share * incident_lm / ideal - value_lx).abs());
    Ok(Exact { value: value_lx, discretisation: discretisation_lx, ..Exact::default() })
}

/// In a sphere all parts exchange light equally: E_indirect = ⟨ρE⟩ = ⟨ρE_direct⟩/(1 − ⟨ρ⟩), with area means ⟨⟩. A plane through the
/// centre divides the source's flux exactly, on the ideal sphere and on its mesh.
pub(super) fn two_hemispheres(
    scene: &Scene,
    luminous_flux_lm: f64,
    radius_m: f64,
    source_height_m: f64,
    [upper, lower]: [f64; 2],
    light: LightPart,
) -> Result<Exact, String> {
    if light != LightPart::Indirect {
        return Err("the closed form of the two hemispheres gives only the indirect part".to_owned());
    }
    let to_lower = 0.5 * (1.0 - source_height_m / source_height_m.hypot(radius_m));
    let [upper_area, lower_area] = ["upper", "lower"].map(|name| mesh_area_m2(scene, Some(name)));
    if upper_area <= 0.0 || lower_area <= 0.0 {
        return Err("the scene needs surfaces \"upper\" and \"lower\"".to_owned());
    }
    let reflected_lm = luminous_flux_lm * (upper * (1.0 - to_lower) + lower * to_lower);
    let of_areas = |upper_area: f64, lower_area: f64| {
        let area_m2 = upper_area + lower_area;
        let mean_reflectance = (upper * upper_area + lower * lower_area) / area_m2;
        rank_one_indirect_lx(reflected_lm / area_m2, mean_reflectance).map_err(|error| error.to_string())
    };
    let value_lx = of_areas(upper_area, lower_area)?;
    let ideal_half = 2.0 * PI * radius_m * radius_m;
    let discretisation_lx = (of_areas(ideal_half, ideal_half)? - value_lx).abs();
    Ok(Exact { value: value_lx, discretisation: discretisation_lx, ..Exact::default() })
}

/// All flux of the inner sphere reaches the outer one. Of the light reflected by the outer one, the part A₁/A₂ reaches the inner
/// one. Only areas matter, so a mesh is equivalent to spheres with its areas.
pub(super) fn concentric(
    scene: &Scene,
    luminous_flux_lm: f64,
    radii_m: [f64; 2],
    [inner, outer]: [f64; 2],
    site: &TruthSite,
    light: LightPart,
) -> Result<Exact, String> {
    let surface = match site {
        TruthSite::Average { surface: Some(surface) } | TruthSite::Element { surface, .. } => *surface,
        _ => return Err("concentric spheres can be compared only on the surfaces \"inner\" and \"outer\"".to_owned()),
    };
    if light != LightPart::Total {
        return Err("the closed form of the concentric spheres gives only the total".to_owned());
    }
    let of_radii = |[inner_m, outer_m]: [f64; 2]| {
        let spheres = concentric_spheres(inner_m, outer_m, luminous_flux_lm, inner, outer);
        let spheres = spheres.map_err(|error| error.to_string())?;
        Ok::<f64, String>(if surface == "inner" { spheres.inner_lx } else { spheres.outer_lx })
    };
    let mesh_radii_m = ["inner", "outer"].map(|name| (mesh_area_m2(scene, Some(name)) / (4.0 * PI)).sqrt());
    let value_lx = of_radii(mesh_radii_m)?;
    let discretisation_lx = (of_radii(radii_m)? - value_lx).abs();
    Ok(Exact { value: value_lx, discretisation: discretisation_lx, ..Exact::default() })
}
