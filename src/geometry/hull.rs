//! Convex scenes, in which nothing stands between two points: no triangle has any part of the scene behind its plane, as in an empty room
//! without niches.

use glam::Vec3A;

use super::origin::{Anchor, LIFT, Origin, RESOLUTION};
use super::tree::Tree;
use crate::scene::Side;

/// Largest number of planes of a convex scene. With more planes, testing them takes as long as the tree.
const MOST_PLANES: usize = 24;
/// Planes whose normals and offsets differ by less than this, in scaled coordinates, count as one.
const ALIKE: f32 = RESOLUTION as f32;
/// A point at least this high above a plane is certainly in front of it.
const CLEARLY: f32 = 4.0 * RESOLUTION as f32;
/// Least height of a point that was lifted off a plane, and least cosine between its normal and the plane's.
const LIFTED: f32 = 0.5 * LIFT as f32;
const FACING_ALIKE: f32 = 0.9999;

/// The planes of a convex scene.
pub(super) struct Hull {
    planes: Vec<HullPlane>,
}

/// A plane in the tracer's coordinates: its unit normal points into the scene.
#[derive(Clone, Copy)]
struct HullPlane {
    normal: Vec3A,
    offset: f32,
}

impl HullPlane {
    #[inline]
    fn height(&self, point: Vec3A) -> f32 {
        self.normal.dot(point) - self.offset
    }
}

impl Hull {
    /// Returns the planes of a tree's triangles, if they are few and nothing lies behind any of them. `None` for a scene with balls or
    /// bodies.
    pub fn of(tree: &Tree) -> Option<Hull> {
        if !(tree.balls.is_empty() && tree.bodies.is_empty()) {
            return None;
        }
        let slots = || tree.slots().map(|(slot, _)| tree.slot(slot));
        let mut planes: Vec<HullPlane> = Vec::new();
        for slot in slots() {
            let [a, b, c] = slot.corners();
            let normal = (b - a).cross(c - a).try_normalize()?;
            let plane = HullPlane { normal: normal.as_vec3a(), offset: normal.dot(a) as f32 };
            let is_alike = |other: &HullPlane| {
                (other.normal - plane.normal).abs().max_element() < ALIKE && (other.offset - plane.offset).abs() < ALIKE
            };
            if planes.iter().any(is_alike) {
                continue;
            }
            if planes.len() == MOST_PLANES {
                return None;
            }
            planes.push(plane);
        }
        let hull = Hull { planes };
        let is_within = |corner: &Vec3A| hull.planes.iter().all(|plane| plane.height(*corner) > -ALIKE);
        slots().all(|slot| slot.corners_f32().iter().all(is_within)).then_some(hull)
    }

    /// Whether an origin is certainly inside. Any two origins that are inside see each other.
    #[inline]
    pub fn holds(&self, origin: &Origin) -> bool {
        match origin.anchor {
            Anchor::Triangle { side, .. } => side == Side::Front,
            Anchor::Ball { .. } => false,
            // A free point has a zero normal, so it never counts as facing like a plane.
            Anchor::Free | Anchor::Side => self.planes.iter().all(|plane| {
                let height = plane.height(origin.point);
                height > CLEARLY || height > LIFTED && plane.normal.dot(origin.normal.into()) > FACING_ALIKE
            }),
        }
    }
}
