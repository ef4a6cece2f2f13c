//! All triangles that a ray crosses, for parities; and occlusion without the tree, to measure what the tree saves.

use glam::DVec3;

use super::origin::Origin;
use super::tracer::Tracer;
use super::triangle::Ray;
use crate::scene::Side;

/// A triangle that a ray crosses.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Crossed {
    /// Number of the triangle in the scene.
    pub triangle: u32,
    /// The side that the ray comes from.
    pub side: Side,
    /// Distance from the ray's origin in m, 0 or more.
    pub distance_m: f64,
}

impl Tracer {
    /// Returns all triangles that a ray with this unit direction crosses, nearest first. Where it goes through an edge, both triangles are
    /// listed.
    pub fn crossings(&self, origin: &Origin, direction: DVec3) -> Vec<Crossed> {
        let mut found = self.tree.crossings(&Ray::new(origin.point, direction.as_vec3a()), origin);
        found.retain(|one| self.tree.luminaire(one.primitive).is_none());
        found.sort_by(|one, other| {
            one.crossing.t.total_cmp(&other.crossing.t).then(one.primitive.cmp(&other.primitive))
        });
        let crossed = |one: &super::tree::Found| Crossed {
            triangle: one.primitive,
            side: if one.crossing.sum > 0.0 { Side::Front } else { Side::Back },
            distance_m: self.metres(f64::from(one.crossing.t.max(0.0))),
        };
        found.iter().map(crossed).collect()
    }

    /// Gives the same answer as [`Tracer::is_occluded`] by testing every triangle, to measure the time that the tree saves.
    pub fn is_occluded_one_by_one(&self, from: &Origin, to: &Origin) -> bool {
        let difference = to.point - from.point;
        if difference == glam::Vec3A::ZERO {
            return false;
        }
        from.has_below(difference)
            || to.has_below(-difference)
            || self.tree.blocks_one_by_one(&Ray::new(from.point, difference), from, to)
    }
}
