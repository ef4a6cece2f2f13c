//! Flat mirrors and the images of luminaires in them: of points, which no ray can meet, and of balls and areas, which few rays meet.

use std::sync::Arc;

use super::TriangleOptics;
use crate::sampling::beam::{Facet, MOST_FACETS};
use crate::sampling::emitter::{Emitters, PointEmitters};
use crate::sampling::reflection::Bsdf;
use crate::scene::{Scene, Side, body_of};

/// Maximum number of areas and balls whose images are searched. A search weighs all of them at every step.
const MOST_AREAS: usize = 256;

/// The facets in which images are searched, and the emitters that have images.
pub struct Mirrors {
    /// Sides of triangles that reflect as mirrors do.
    pub facets: Vec<Facet>,
    /// Number of the emitter that is the sun. Its images are searched like those of points.
    pub sun: Option<u32>,
    /// Emitters that are points, or draw a point, if there are any.
    pub points: Option<Arc<PointEmitters>>,
    /// Numbers of the emitters that rays can meet and whose images are searched.
    pub areas: Vec<u32>,
    /// Whether these are all mirror facets of the scene.
    pub are_all: bool,
    /// Facet number of every triangle's front and back.
    number: Vec<[u16; 2]>,
}

/// Facet number of a triangle side that is no facet.
const NO_FACET: u16 = u16::MAX;

impl Mirrors {
    /// Whether walks search for areas in the mirrors.
    #[inline]
    pub fn walks_sample_areas(&self) -> bool {
        !self.areas.is_empty()
    }

    /// Facet number of a side of a triangle.
    #[inline]
    pub fn number(&self, triangle: u32, side: Side) -> Option<u16> {
        Some(self.number[triangle as usize][side as usize]).filter(|number| *number != NO_FACET)
    }
}

/// The mirrors that walks search, and the names of the surfaces that exceed the limit on facets.
pub(super) fn mirrors_of(
    scene: &Scene,
    triangles: &[TriangleOptics],
    bsdfs: &[Bsdf],
    emitters: &Emitters,
) -> (Option<Mirrors>, Vec<String>) {
    let bsdf = |triangle: u32| &bsdfs[triangles[triangle as usize].bsdf as usize];
    let mut surfaces: Vec<(usize, usize)> = scene
        .surfaces
        .iter()
        .enumerate()
        .filter(|(_, surface)| bsdf(surface.triangles.start).is_mirror())
        .map(|(id, surface)| (surface.triangles.len() * Side::of_surface(surface.two_sided).len(), id))
        .collect();
    if surfaces.is_empty() {
        return (None, Vec::new());
    }
    let points = emitters.points().map(Arc::new);
    let sun = emitters.list().iter().position(|emitter| emitter.is_sun()).map(|number| number as u32);
    let list = emitters.list().iter().zip(0u32..);
    let mut areas: Vec<u32> =
        list.filter(|(emitter, _)| emitter.exitance_lm_m2().is_some()).map(|(_, number)| number).collect();
    if areas.len() > MOST_AREAS {
        areas.clear();
    }
    if points.is_none() && areas.is_empty() && sun.is_none() {
        return (None, Vec::new());
    }

    // Flat mirrors have few facets, so they come first. Curved mirrors are left out if there are too many facets.
    surfaces.sort_unstable();
    let mut facets = Vec::new();
    let mut number = vec![[NO_FACET; 2]; triangles.len()];
    let mut left_out = Vec::new();
    for (count, id) in surfaces {
        let surface = &scene.surfaces[id];
        let is_smooth = body_of(&scene.bodies, surface.triangles.start).is_some();
        if is_smooth || facets.len() + count > MOST_FACETS {
            left_out.push(format!("{} ({count} facets)", surface.name));
            continue;
        }
        for side in Side::of_surface(surface.two_sided) {
            for facet in Facet::all_of(scene, surface.triangles.clone(), *side) {
                facet.triangles().for_each(|triangle| number[triangle as usize][*side as usize] = facets.len() as u16);
                facets.push(facet);
            }
        }
    }
    let are_all = left_out.is_empty();
    if points.is_none() && sun.is_none() {
        // Rays meet areas in the mirrors that are left out.
        left_out.clear();
    }
    let mirrors = (!facets.is_empty()).then_some(Mirrors { facets, sun, points, areas, are_all, number });
    (mirrors, left_out)
}

/// Describes in words the class of paths that walks cannot find.
pub(super) fn not_found(left_out: &[String]) -> Vec<String> {
    if left_out.is_empty() {
        return Vec::new();
    }
    vec![format!(
        "light of the sun and of point-like luminaires reflected by mirrors with more than {MOST_FACETS} flat facets in total, at receivers: {}",
        left_out.join(", ")
    )]
}
