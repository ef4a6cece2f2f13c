//! Warns of luminous openings that a surface cuts: the part behind the surface shines where nobody sees it.

use glam::DVec3;
use rayon::prelude::*;

use super::fitted_openings::SLIGHT_M;
use super::straight::ON_SURFACE_M;
use super::warnings::names;
use crate::scene::listed;
use crate::scene::photometry::Opening;
use crate::scene::{Emission, Luminaire, Scene};

/// Adds a warning for the luminaires with an opening that a surface cuts, with the surfaces' names.
pub(super) fn advise_on_openings(scene: &Scene, advice: &mut Vec<String>) {
    let cuts: Vec<Vec<(u32, f64)>> = scene.luminaires.par_iter().map(|luminaire| cuts_of(scene, luminaire)).collect();
    let cut: Vec<&Luminaire> = scene
        .luminaires
        .iter()
        .zip(&cuts)
        .filter(|(_, cuts)| !cuts.is_empty())
        .map(|(luminaire, _)| luminaire)
        .collect();
    if cut.is_empty() {
        return;
    }
    let mut surfaces: Vec<&str> = Vec::new();
    let mut deepest_m = 0.0f64;
    for (triangle, depth_m) in cuts.iter().flatten() {
        deepest_m = deepest_m.max(*depth_m);
        let surface = scene.surface_of(*triangle).name.as_str();
        if !surfaces.contains(&surface) {
            surfaces.push(surface);
        }
    }
    let its = if cut.len() == 1 { "its luminous opening" } else { "their luminous openings" };
    advice.push(format!(
        "{}: part of {its} lies behind {}, up to {:.0} mm deep, and its light is lost there; move the luminaire's \"position\" off the surface by this distance, or turn its \"aim\"",
        names(cut.iter().copied()),
        listed(surfaces),
        1000.0 * deepest_m
    ));
}

/// Returns the names of the luminaires whose opening lies partly behind a surface, as a message lists them; `None` if there are none.
pub(crate) fn luminaires_behind_surfaces(scene: &Scene) -> Option<String> {
    let cut: Vec<&Luminaire> =
        scene.luminaires.par_iter().filter(|luminaire| !cuts_of(scene, luminaire).is_empty()).collect();
    (!cut.is_empty()).then(|| names(cut))
}

/// Returns the triangles that cut a luminaire's opening, with the depth in m to which it extends through each.
fn cuts_of(scene: &Scene, luminaire: &Luminaire) -> Vec<(u32, f64)> {
    let Emission::Photometric { position_m, frame, opening, .. } = &luminaire.emission else { return Vec::new() };
    let rim_m = rim_m(opening, frame);
    let reach_m = rim_m.iter().map(|offset_m| offset_m.length()).fold(0.0, f64::max);
    if reach_m <= SLIGHT_M {
        return Vec::new();
    }
    let (low_m, high_m) = (*position_m - reach_m, *position_m + reach_m);
    let cut = |triangle: u32| {
        let corners_m @ [a, b, c] = scene.corners_m(triangle);
        if a.min(b).min(c).cmpgt(high_m).any() || a.max(b).max(c).cmplt(low_m).any() {
            return None;
        }
        let depth_m = depth_behind_m(corners_m, *position_m, frame[2], &rim_m, reach_m);
        (depth_m > SLIGHT_M).then_some((triangle, depth_m))
    };
    (0..scene.triangles.len() as u32).filter_map(cut).collect()
}

/// Returns the outermost points of an opening as offsets from its centre in m. `frame` holds the unit vectors of C0, C90 and γ = 0.
fn rim_m(opening: &Opening, frame: &[DVec3; 3]) -> Vec<DVec3> {
    let extents_m = opening.extents_m();
    let half = [0, 1, 2].map(|axis| 0.5 * extents_m[axis] * frame[axis]);
    if matches!(opening, Opening::Rectangle { .. } | Opening::Box { .. }) {
        let end = |corner: u32, axis: u32| if corner & (1 << axis) == 0 { -1.0 } else { 1.0 };
        (0..8).map(|corner| end(corner, 0) * half[0] + end(corner, 1) * half[1] + end(corner, 2) * half[2]).collect()
    } else {
        half.iter().flat_map(|half| [-*half, *half]).collect()
    }
}

/// Returns how far the opening extends through a triangle, in m; 0 where the triangle does not cut it.
///
/// A luminaire in the triangle's plane belongs to the side that it aims at.
fn depth_behind_m([a, b, c]: [DVec3; 3], center_m: DVec3, aim: DVec3, rim_m: &[DVec3], reach_m: f64) -> f64 {
    let twice_area = (b - a).cross(c - a);
    let Some(normal) = twice_area.try_normalize() else { return 0.0 };
    let above_m = normal.dot(center_m - a);
    if above_m.abs() >= reach_m {
        return 0.0;
    }
    let side = if above_m.abs() <= ON_SURFACE_M { normal.dot(aim).signum() } else { above_m.signum() };
    let mut deepest_m = 0.0f64;
    for offset_m in rim_m {
        let depth_m = -side * (above_m + normal.dot(*offset_m));
        if depth_m <= deepest_m {
            continue;
        }
        // The point where the line from the centre to the rim crosses the plane.
        let share = (side * above_m).max(0.0) / (side * above_m + depth_m);
        let hit_m = center_m + share * *offset_m;
        let is_left = |from: DVec3, to: DVec3| (to - from).cross(hit_m - from).dot(twice_area) >= 0.0;
        if is_left(a, b) && is_left(b, c) && is_left(c, a) {
            deepest_m = depth_m;
        }
    }
    deepest_m
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use crate::check::scene_from_json;

    /// Returns the warnings of openings behind surfaces, in a room 4 m × 4 m × 3 m with a troffer of 0.6 m × 0.6 m.
    fn warnings(luminaire: &str) -> Vec<String> {
        let text = format!(
            r#"{{ "version": 1, "materials": {{ "white": {{ "type": "diffuse", "reflectance": 0.5 }} }},
            "geometry": [ {{ "name": "room", "type": "box", "min": [0,0,0], "max": [4,4,3], "facing": "inward", "material": "white" }} ],
            "luminaires": [ {{ "name": "troffer", "type": "photometric", "file": "luminaires/troffer.ies",
                "maintenance_factor": 0.8, {luminaire} }} ] }}"#
        );
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes");
        let scene = scene_from_json(&text, None, &folder).expect("a valid scene");
        scene.warnings.into_iter().filter(|warning| warning.contains("lies behind")).collect()
    }

    #[test]
    fn openings_that_a_surface_cuts_are_reported_with_the_surface_and_the_depth() {
        // Turned by 30° about y in the plane of the ceiling, half of it extends up to 0.3 m · sin 30° behind the ceiling.
        let warned = warnings(r#""position": [2,2,3], "aim": [0.5,0,-0.8660254037844386]"#);
        assert_eq!(warned.len(), 1);
        assert!(warned[0].contains("troffer: ") && warned[0].contains("\"room/ceiling\", up to 150 mm"), "{warned:?}");
        let warned = warnings(r#""position": [0.1,2,2.5]"#);
        assert!(warned.len() == 1 && warned[0].contains("\"room/x_min\", up to 200 mm"), "{warned:?}");
    }

    #[test]
    fn openings_in_and_off_surfaces_are_not() {
        for sound in [
            r#""position": [2,2,3]"#,
            r#""position": [2,2,2.99]"#,
            r#""position": [0.3,2,3]"#,
            r#""position": [2,2,2.8], "aim": [0.5,0,-0.8660254037844386]"#,
            r#""position": [0,2,1.5], "aim": [1,0,0]"#,
        ] {
            assert!(warnings(sound).is_empty(), "{sound}: {:?}", warnings(sound));
        }
    }
}
