//! Where rays start, and on which side of a triangle that is.
//!
//! A point on a surface is known to f32 only within some 2⁻²⁴, so that its height above the planes of nearby
//! triangles may have the wrong sign. Two measures replace the usual smallest distance along the ray:
//!
//! - The origin is *lifted* off its surface by [`LIFT`], and *pulled* off the edges of its triangle by [`PULL`], so
//!   that neighbours at edges and corners are clearly on one side.
//! - Where it still matters, a triangle's *side* is judged by the height of the unlifted point above its plane in
//!   f64. A point in the plane within [`RESOLUTION`] belongs to the side that its own surface faces.

use glam::{DVec3, Vec3, Vec3A};
use serde::{Deserialize, Serialize};

use super::triangle::Slot;
use crate::scene::Side;

/// How far before its origin a ray may meet a front that the origin counts as in front of, in units of the
/// direction: a few times [`LIFT`], for rays that leave a surface at a slant.
pub(super) const BEFORE: f32 = -1.0 / (1u32 << 18) as f32;
/// How far a point on a surface is lifted along its normal, in scaled coordinates: eight times the coarsest rounding
/// of a point (2⁻²⁴), so that the ray's own plane is surely behind it.
pub(super) const LIFT: f64 = 1.0 / (1u64 << 21) as f64;

/// How far a point is pulled off the edges of its triangle, in scaled coordinates: at an edge where two surfaces
/// meet at 10°, the point then stands 2⁻¹⁹·⁵ off the other one, three times its lift.
pub(super) const PULL: f64 = 1.0 / (1u64 << 17) as f64;

/// Heights above a plane below this one, in scaled coordinates, are rounding: corners of the triangle and of the
/// origin's own (2⁻²⁴·² each, three roundings of 2⁻²⁵) and the origin itself (2⁻²⁴·²) add up to 2⁻²²·⁶.
pub(super) const RESOLUTION: f64 = 1.0 / (1u64 << 22) as f64;

/// Cosine between normals from which on two coplanar surfaces lie back to back: a sheet's two skins, or a wall that
/// two rooms share. Rounded corners turn the normal of a triangle as small as 2⁻¹⁷ by less than that.
const BACK_TO_BACK: f64 = -0.9999;

/// Cosine below which a receiver in a triangle's plane faces away from it; a receiver that stands on edge belongs to
/// the front.
const FACING_AWAY: f64 = -1e-3;

/// Square of the height, in scaled coordinates, above which f32 tells the side of a plane well enough.
const CLEARLY_OFF: f32 = 1.0 / (1u64 << 28) as f32;

/// What a ray starts from.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) enum Anchor {
    /// A point in free space.
    Free,
    /// A point that may lie on a surface, on the side its normal points to.
    Side,
    /// A point of a triangle, on one of its sides.
    Triangle { triangle: u32, side: Side, barycentric: [f32; 2] },
    /// A point of a ball's surface.
    Ball { luminaire: u32 },
}

/// Where a ray starts, in the tracer's own recentred and scaled coordinates.
///
/// Made by a [`crate::geometry::Tracer`] and valid for that one only. It remembers what it lies on, so that this
/// never shadows it.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct Origin {
    /// The lifted point.
    pub(super) point: Vec3A,
    /// Unit normal of the side that the point belongs to; zero for a free point.
    pub(super) normal: Vec3,
    pub(super) anchor: Anchor,
}

/// Weights of a triangle's corners, moved towards its middle until none is below its least weight.
#[inline]
pub(super) fn pull_in([second, third]: [f64; 2], least: Vec3) -> [f64; 2] {
    let least = least.as_dvec3();
    let free = 1.0 - (least.x + least.y + least.z);
    let first = (1.0 - second - third).max(0.0);
    if first >= least.x && second >= least.y && third >= least.z {
        return [second, third];
    }
    // Clamping and sharing out what remains keeps the point where it is along the edge.
    let over = [first - least.x, second - least.y, third - least.z].map(|weight| weight.max(0.0));
    let share = free / (over[0] + over[1] + over[2]).max(f64::MIN_POSITIVE);
    [least.y + over[1] * share, least.z + over[2] * share]
}

impl Origin {
    /// A point and the normal that it is lifted along.
    #[inline]
    pub(super) fn lifted(point: DVec3, normal: DVec3, anchor: Anchor) -> Origin {
        Origin { point: (point + LIFT * normal).as_vec3().into(), normal: normal.as_vec3(), anchor }
    }

    /// Whether it is a point in free space.
    #[inline]
    pub fn is_free(&self) -> bool {
        matches!(self.anchor, Anchor::Free)
    }

    /// Whether a direction leads straight into the surface that the origin surely lies on.
    #[inline]
    pub(super) fn has_below(&self, direction: Vec3A) -> bool {
        matches!(self.anchor, Anchor::Triangle { .. }) && Vec3A::from(self.normal).dot(direction) < 0.0
    }

    /// Whether a crossing a little before the origin lies under the surface that the origin was lifted off.
    #[inline]
    pub(super) fn has_under(&self, direction: Vec3A, t: f32) -> bool {
        t < 0.0 && t * Vec3A::from(self.normal).dot(direction) < (RESOLUTION - LIFT) as f32
    }

    /// The triangle that the origin lies on, which its rays do not meet; no triangle's number otherwise.
    #[inline]
    pub(super) fn own_triangle(&self) -> u32 {
        match self.anchor {
            Anchor::Triangle { triangle, .. } => triangle,
            _ => u32::MAX,
        }
    }

    /// Whether the origin counts as in front of a triangle with these corners.
    #[inline]
    pub(super) fn is_in_front(&self, slot: Slot) -> bool {
        let [a, b, c] = slot.corners_f32();
        let (along, across) = (b - a, c - a);
        let height = along.cross(across).dot(self.point - a);
        // The rounding of this product stays below 2⁻²¹ of the edges' lengths.
        if height * height > CLEARLY_OFF * along.length_squared() * across.length_squared() {
            return height > 0.0;
        }
        self.is_just_in_front(slot)
    }

    /// Cosine between the origin's normal and a triangle's, and the unlifted point's height above the triangle.
    fn stance(&self, slot: Slot) -> (f64, f64) {
        let [a, b, c] = slot.corners();
        let normal = (b - a).cross(c - a).normalize_or_zero();
        let facing = normal.dot(self.normal.as_dvec3());
        (facing, normal.dot(self.point.as_dvec3() - a) - LIFT * facing)
    }

    /// Whether a triangle faces the origin's surface and touches it.
    pub(super) fn is_pressed_by(&self, slot: Slot) -> bool {
        let (facing, height) = self.stance(slot);
        facing < BACK_TO_BACK && height.abs() <= RESOLUTION
    }

    /// The same as [`Origin::is_in_front`], carefully.
    #[cold]
    fn is_just_in_front(&self, slot: Slot) -> bool {
        let (facing, height) = self.stance(slot);
        if height.abs() > RESOLUTION {
            return height > 0.0;
        }
        match self.anchor {
            Anchor::Free => true,
            Anchor::Side | Anchor::Ball { .. } => facing > FACING_AWAY,
            Anchor::Triangle { .. } => facing > BACK_TO_BACK,
        }
    }
}
