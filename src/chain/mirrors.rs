//! Flat mirrors and what they show of point-like luminaires, which no ray can meet.

use super::TriangleOptics;
use crate::sampling::beam::Facet;
use crate::sampling::emitter::{Emitters, PointEmitters};
use crate::sampling::reflection::Law;
use crate::scene::{Scene, Side};

/// Flat facets that images are looked for in, at most: a look asks all of them.
const MOST_FACETS: usize = 128;

/// The facets that images are looked for in, and the emitters that have images.
pub struct Mirrors {
    /// Sides of triangles that reflect as mirrors do.
    pub facets: Vec<Facet>,
    /// Emitters that are points, or draw one.
    pub points: PointEmitters,
}

/// Mirrors that walks look into, and the names of the surfaces beyond their number of facets.
pub(super) fn mirrors_of(
    scene: &Scene,
    triangles: &[TriangleOptics],
    laws: &[Law],
    emitters: &Emitters,
) -> (Option<Mirrors>, Vec<String>) {
    let law = |triangle: u32| &laws[triangles[triangle as usize].law as usize];
    let mut surfaces: Vec<(usize, usize)> = scene
        .surfaces
        .iter()
        .enumerate()
        .filter(|(_, surface)| law(surface.triangles.start).is_mirror())
        .map(|(id, surface)| (surface.triangles.len() * if surface.two_sided { 2 } else { 1 }, id))
        .collect();
    if surfaces.is_empty() {
        return (None, Vec::new());
    }
    let Some(points) = emitters.points() else {
        return (None, Vec::new());
    };

    // Flat mirrors have few facets: they come first, and curved ones are left out where there are too many.
    surfaces.sort_unstable();
    let mut facets = Vec::new();
    let mut left_out = Vec::new();
    for (count, id) in surfaces {
        let surface = &scene.surfaces[id];
        if facets.len() + count > MOST_FACETS {
            left_out.push(format!("{} ({count} facets)", surface.name));
            continue;
        }
        for triangle in surface.triangles.clone() {
            facets.push(Facet::new(scene, triangle, Side::Front));
            if surface.two_sided {
                facets.push(Facet::new(scene, triangle, Side::Back));
            }
        }
    }
    let mirrors = (!facets.is_empty()).then_some(Mirrors { facets, points });
    (mirrors, left_out)
}

/// The class of paths that walks cannot find, in words.
pub(super) fn not_found(left_out: &[String]) -> Vec<String> {
    if left_out.is_empty() {
        return Vec::new();
    }
    vec![format!(
        "light of point-like luminaires by way of mirrors with more than {MOST_FACETS} flat facets in all, at receivers: {}",
        left_out.join(", ")
    )]
}
