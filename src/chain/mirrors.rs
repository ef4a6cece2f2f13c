//! Flat mirrors and what they show of luminaires: of points, which no ray can meet, and of balls and areas, which few do.

use super::TriangleOptics;
use crate::sampling::beam::Facet;
use crate::sampling::emitter::{Emitters, PointEmitters};
use crate::sampling::reflection::Bsdf;
use crate::scene::{Scene, Side, body_of};

/// Flat facets that images are looked for in, at most: a look asks all of them.
const MOST_FACETS: usize = 128;
/// Areas and balls whose images are looked for, at most: a look weighs all of them at every step.
const MOST_AREAS: usize = 256;

/// The facets that images are looked for in, and the emitters that have images.
pub struct Mirrors {
    /// Sides of triangles that reflect as mirrors do.
    pub facets: Vec<Facet>,
    /// Number of the emitter that is the sun, whose images are looked for as those of points are.
    pub sun: Option<u32>,
    /// Emitters that are points, or draw one, if there are any.
    pub points: Option<PointEmitters>,
    /// Numbers of the emitters that rays can meet and whose images are looked for.
    pub areas: Vec<u32>,
    /// Whether the facets are all there are in the scene.
    pub are_all: bool,
    /// Of every triangle's front and back, the number of the facet that it is.
    number: Vec<[u16; 2]>,
}

/// The number of what is no facet.
const NO_FACET: u16 = u16::MAX;

impl Mirrors {
    /// Whether walks look for areas in them.
    #[inline]
    pub fn walks_look(&self) -> bool {
        !self.areas.is_empty()
    }

    /// The number of the facet that a side of a triangle is.
    #[inline]
    pub fn number(&self, triangle: u32, side: Side) -> Option<u16> {
        Some(self.number[triangle as usize][side as usize]).filter(|number| *number != NO_FACET)
    }
}

/// Mirrors that walks look into, and the names of the surfaces beyond their number of facets.
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
    let points = emitters.points();
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

    // Flat mirrors have few facets: they come first, and curved ones are left out where there are too many.
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
            let mut open: Option<Facet> = None;
            for triangle in surface.triangles.clone() {
                // The two halves of a rectangle are one.
                let joined = open.and_then(|open| open.joined(scene, triangle));
                if joined.is_some() {
                    facets.pop();
                }
                number[triangle as usize][*side as usize] = facets.len() as u16;
                facets.push(joined.unwrap_or_else(|| Facet::new(scene, triangle, *side)));
                open = if joined.is_some() { None } else { facets.last().copied() };
            }
        }
    }
    let are_all = left_out.is_empty();
    if points.is_none() && sun.is_none() {
        // Rays meet areas in what is left out.
        left_out.clear();
    }
    let mirrors = (!facets.is_empty()).then_some(Mirrors { facets, sun, points, areas, are_all, number });
    (mirrors, left_out)
}

/// The class of paths that walks cannot find, in words.
pub(super) fn not_found(left_out: &[String]) -> Vec<String> {
    if left_out.is_empty() {
        return Vec::new();
    }
    vec![format!(
        "light of the sun and of point-like luminaires by way of mirrors with more than {MOST_FACETS} flat facets in all, at receivers: {}",
        left_out.join(", ")
    )]
}
