//! Flat glossy surfaces in which walks look for the highlights of point-like luminaires.

use std::sync::Arc;

use super::World;
use crate::sampling::beam::Facet;
use crate::sampling::emitter::PointEmitters;
use crate::scene::{Scene, Side, body_of};

/// Maximum number of facets in which highlights are searched: the largest by area times the reflectance of the lobe. (Measured: squared
/// error times rays in three rooms with glossy floors and furniture: 5 facets 1.06, 11 facets 1.00, 1 facet 1.18.)
const MOST_GLOSSY: usize = 8;
/// Lobes wider than this, in rad, are found well by light samples. (Measured: squared error times rays with searches over that without, in
/// one room: 0.84 at a width of 0.21, 0.96 at 0.29, 1.07 at 0.41; by time 0.85, 1.04, 1.03.)
const WIDEST_RAD: f64 = 0.25;

/// The facets in which highlights are searched, and the emitters that have highlights.
pub struct GlossyFacets {
    /// Sides of triangles with a lobe.
    pub facets: Vec<Facet>,
    /// Width of the lobe of every facet, in rad.
    pub widths_rad: Vec<f64>,
    /// Emitters that no ray meets.
    pub points: Arc<PointEmitters>,
}

impl GlossyFacets {
    /// Facets of a world whose unlit sides are known; `None` if there are none, or no point-like emitters.
    pub(super) fn of(scene: &Scene, world: &World) -> Option<GlossyFacets> {
        let mut found = Vec::new();
        for surface in &scene.surfaces {
            let bsdf = world.bsdf(surface.triangles.start);
            let is_smooth = body_of(&scene.bodies, surface.triangles.start).is_some();
            let Some(width_rad) = bsdf.lobe_width_rad().filter(|width_rad| *width_rad < WIDEST_RAD && !is_smooth)
            else {
                continue;
            };
            let reflectance = bsdf.total(1.0) - bsdf.diffuse_part();
            for side in Side::of_surface(surface.two_sided) {
                let facets = Facet::all_of(scene, surface.triangles.clone(), *side);
                let lit = facets.into_iter().filter(|facet| !world.is_unlit((facet.triangle(), *side)));
                found.extend(lit.map(|facet| (facet.area_m2() * reflectance, facet, width_rad)));
            }
        }
        if found.is_empty() {
            return None;
        }
        let points = match &world.mirrors {
            Some(mirrors) => mirrors.points.clone(),
            None => world.emitters.points().map(Arc::new),
        }?;
        found.sort_by(|(one, ..), (other, ..)| other.total_cmp(one));
        found.truncate(MOST_GLOSSY);
        let (facets, widths_rad) = found.into_iter().map(|(_, facet, width_rad)| (facet, width_rad)).unzip();
        Some(GlossyFacets { facets, widths_rad, points })
    }

    /// Number of the facet on a side of a triangle.
    #[inline]
    pub fn number(&self, triangle: u32, side: Side) -> Option<usize> {
        self.facets.iter().position(|facet| facet.side == side && facet.triangles().any(|own| own == triangle))
    }
}
