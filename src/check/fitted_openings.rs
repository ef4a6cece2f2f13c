//! Luminous boxes that are recessed into a surface: they shine only with the part in front of it.
//!
//! Photometric files give the luminous volume, and users put its middle at the height of the ceiling. The part behind the ceiling is
//! visible to nobody. The distribution is measured with the luminaire mounted, so the part in front emits all of it.

use glam::DVec3;
use rayon::prelude::*;

use super::straight::{MOST_LINE_TESTS, ON_SURFACE_M};
use super::warnings::names;
use crate::scene::listed;
use crate::scene::photometry::Opening;
use crate::scene::{Emission, Luminaire, Scene};

/// A part of an opening that lies less than this behind or in front of a surface, in m, comes from rounding and fitting.
pub(super) const SLIGHT_M: f64 = 1e-3;
/// The limit below which a part behind a surface is rounding alone and is not reported, in m.
const ROUNDING_M: f64 = 1e-9;
/// An axis of a box is parallel to a surface's normal if the cosine between them is above this.
const PARALLEL: f64 = 1.0 - 1e-6;

/// A box after it was fitted into a surface.
struct Fitted {
    position_m: DVec3,
    opening: Opening,
    /// How far the box extended behind the surface, in m, and the triangle.
    behind_m: f64,
    triangle: u32,
}

/// Cuts luminous boxes off where they extend behind a surface that is parallel to one of their sides, and reports that.
pub(super) fn fit_openings(scene: &mut Scene) {
    let boxes = scene.luminaires.iter().filter(|luminaire| has_box(luminaire)).count();
    if boxes.saturating_mul(scene.triangles.len()) > MOST_LINE_TESTS {
        scene
            .warnings
            .push(format!("too many luminous boxes ({boxes}) to check which of them are recessed into surfaces"));
        return;
    }
    let fitted: Vec<Option<Fitted>> = scene.luminaires.par_iter().map(|luminaire| fitted(scene, luminaire)).collect();
    let mut deepest_m = 0.0f64;
    let mut surfaces: Vec<String> = Vec::new();
    let mut trimmed: Vec<usize> = Vec::new();
    for (index, fitted) in fitted.into_iter().enumerate() {
        let Some(fitted) = fitted else { continue };
        if let Emission::Photometric { position_m, opening, .. } = &mut scene.luminaires[index].emission {
            (*position_m, *opening) = (fitted.position_m, fitted.opening);
        }
        if fitted.behind_m > SLIGHT_M {
            deepest_m = deepest_m.max(fitted.behind_m);
            let surface = scene.surface_of(fitted.triangle).name.clone();
            if !surfaces.contains(&surface) {
                surfaces.push(surface);
            }
            trimmed.push(index);
        }
    }
    if trimmed.is_empty() {
        return;
    }
    let its = if trimmed.len() == 1 { "its luminous box reaches" } else { "their luminous boxes reach" };
    let message = format!(
        "{}: {its} up to {:.0} mm behind {} and shine{} only with the part in front, which emits all of the flux",
        names(trimmed.iter().map(|index| &scene.luminaires[*index])),
        1000.0 * deepest_m,
        listed(surfaces.iter().map(String::as_str)),
        if trimmed.len() == 1 { "s" } else { "" }
    );
    scene.warnings.push(message);
}

fn has_box(luminaire: &Luminaire) -> bool {
    matches!(&luminaire.emission, Emission::Photometric { opening: Opening::Box { .. }, .. })
}

/// Returns a luminaire's box, fitted to the surfaces that it extends behind; `None` where there is nothing to fit.
fn fitted(scene: &Scene, luminaire: &Luminaire) -> Option<Fitted> {
    let Emission::Photometric { position_m, frame, opening, .. } = &luminaire.emission else { return None };
    let Opening::Box { .. } = opening else { return None };
    let (mut center_m, mut extents_m) = (*position_m, opening.extents_m());
    let reach_m = 0.5 * DVec3::from(extents_m).length() + SLIGHT_M;
    let (low_m, high_m) = (center_m - reach_m, center_m + reach_m);
    let mut found: Option<(f64, u32)> = None;
    for triangle in 0..scene.triangles.len() as u32 {
        let [a, b, c] = scene.corners_m(triangle);
        if a.min(b).min(c).cmpgt(high_m).any() || a.max(b).max(c).cmplt(low_m).any() {
            continue;
        }
        let normal = scene.triangle_normal(triangle);
        let Some(axis) = (0..3).find(|axis| normal.dot(frame[*axis]).abs() > PARALLEL) else { continue };
        let above_m = normal.dot(center_m - a);
        let foot_m = center_m - above_m * normal;
        let is_left = |from: DVec3, to: DVec3| (to - from).cross(foot_m - from).dot(normal) >= 0.0;
        if !(is_left(a, b) && is_left(b, c) && is_left(c, a)) {
            continue;
        }
        // No light reaches the backs of one-sided surfaces. For a two-sided surface the box's middle decides the side, or else its aim.
        let side = match scene.surface_of(triangle).two_sided {
            false => 1.0,
            true if above_m.abs() <= ON_SURFACE_M => normal.dot(frame[2]).signum(),
            true => above_m.signum(),
        };
        let (above_m, half_m) = (side * above_m, 0.5 * extents_m[axis]);
        let (lowest_m, highest_m) = (above_m - half_m, above_m + half_m);
        if lowest_m >= -ROUNDING_M || highest_m < -SLIGHT_M {
            continue;
        }
        let shown_m = if highest_m < SLIGHT_M { 0.0 } else { highest_m };
        center_m += side * normal * (0.5 * shown_m - above_m);
        extents_m[axis] = shown_m;
        if found.is_none_or(|(deepest_m, _)| -lowest_m > deepest_m) {
            found = Some((-lowest_m, triangle));
        }
    }
    let [c0_m, c90_m, height_m] = extents_m;
    let opening = match height_m {
        0.0 => Opening::Rectangle { c0_m, c90_m },
        _ => Opening::Box { c0_m, c90_m, height_m },
    };
    found.map(|(behind_m, triangle)| Fitted { position_m: center_m, opening, behind_m, triangle })
}
