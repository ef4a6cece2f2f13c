//! Where rays start, and on which side of a triangle the start is.
//!
//! In f32 a point on a surface is known only to about 2⁻²⁴. Its height above the planes of nearby triangles may therefore have the wrong
//! sign. Two measures replace the usual smallest distance along the ray:
//!
//! - The origin is *lifted* off its surface by [`LIFT`], and *pulled* off the edges of its triangle by [`PULL`], so
//!   that neighbours at edges and corners are clearly on one side.
//! - Where this is not enough, a triangle's *side* is decided in f64 by the height of the unlifted point above its plane.
//!   A point in the plane within [`RESOLUTION`] belongs to the side that its own surface faces.

use glam::{DVec3, Vec3, Vec3A};
use serde::{Deserialize, Serialize};

use super::triangle::Slot;
use crate::scene::Side;

/// Distance before its origin at which a ray may still meet a front that the origin counts as in front of, in units of the direction. It is
/// a few times [`LIFT`], for rays that leave a surface at a flat angle.
pub(super) const BEFORE: f32 = -1.0 / (1u32 << 18) as f32;
/// Distance by which a point on a surface is lifted along its normal, in scaled coordinates. It is eight times the coarsest rounding of a
/// point (2⁻²⁴), so that the ray's own plane is certainly behind it.
pub(super) const LIFT: f64 = 1.0 / (1u64 << 21) as f64;

/// Distance by which a point is pulled off the edges of its triangle, in scaled coordinates. At an edge where two surfaces meet at 10°, the
/// point is then 2⁻¹⁹·⁵ off the other surface, three times its lift.
pub(super) const PULL: f64 = 1.0 / (1u64 << 17) as f64;

/// Heights above a plane below this, in scaled coordinates, are rounding. The corners of the triangle and of the origin's own (2⁻²⁴·² each,
/// three roundings of 2⁻²⁵) and the origin itself (2⁻²⁴·²) add up to 2⁻²²·⁶.
pub(super) const RESOLUTION: f64 = 1.0 / (1u64 << 22) as f64;

/// Cosine between normals below which two coplanar surfaces lie back to back: the two skins of a sheet, or a wall between two rooms.
/// Rounded corners turn the normal of a triangle as small as 2⁻¹⁷ by less than this.
const BACK_TO_BACK: f64 = -0.9999;

/// Cosine below which a receiver in a triangle's plane faces away from it. A receiver that is perpendicular to the plane belongs to the
/// front.
const FACING_AWAY: f64 = -1e-3;

/// Square of the height, in scaled coordinates, above which f32 is accurate enough to decide the side of a plane.
const CLEARLY_OFF: f32 = 1.0 / (1u64 << 28) as f32;

/// The object that a ray starts from.
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

/// Where a ray starts, in the tracer's own centred and scaled coordinates.
///
/// A [`crate::geometry::Tracer`] makes it, and it is valid only for that tracer. It records the surface that it lies on, so that this
/// surface never shadows it.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct Origin {
    /// The lifted point.
    pub(super) point: Vec3A,
    /// Unit normal of the side that the point belongs to; zero for a free point.
    pub(super) normal: Vec3,
    pub(super) anchor: Anchor,
}

/// Moves the weights of a triangle's corners towards the middle until none is below its least weight.
#[inline]
pub(super) fn pull_in([second, third]: [f64; 2], least: Vec3) -> [f64; 2] {
    let least = least.as_dvec3();
    let free = 1.0 - (least.x + least.y + least.z);
    let first = (1.0 - second - third).max(0.0);
    if first >= least.x && second >= least.y && third >= least.z {
        return [second, third];
    }
    // Clamping and distributing the rest keeps the point's position along the edge.
    let over = [(first - least.x).max(0.0), (second - least.y).max(0.0), (third - least.z).max(0.0)];
    let share = free / (over[0] + over[1] + over[2]).max(f64::MIN_POSITIVE);
    [least.y + over[1] * share, least.z + over[2] * share]
}

impl Origin {
    /// Makes an origin from a point and the normal along which it is lifted.
    #[inline]
    pub(super) fn lifted(point: DVec3, normal: DVec3, anchor: Anchor) -> Origin {
        Origin { point: (point + LIFT * normal).as_vec3().into(), normal: normal.as_vec3(), anchor }
    }

    /// Whether it is a point in free space.
    #[inline]
    pub fn is_free(&self) -> bool {
        matches!(self.anchor, Anchor::Free)
    }

    /// Whether a direction goes straight into the triangle that the origin lies on.
    #[inline]
    pub(super) fn has_below(&self, direction: Vec3A) -> bool {
        matches!(self.anchor, Anchor::Triangle { .. }) && Vec3A::from(self.normal).dot(direction) < 0.0
    }

    /// Whether a crossing a little before the origin lies below the surface that the origin was lifted off.
    #[inline]
    pub(super) fn has_under(&self, direction: Vec3A, t: f32) -> bool {
        t < 0.0 && t * Vec3A::from(self.normal).dot(direction) < (RESOLUTION - LIFT) as f32
    }

    /// Returns the triangle that the origin lies on, which its rays do not meet; otherwise a number that no triangle has.
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
        // The rounding of this product is below 2⁻²¹ of the product of the edges' lengths.
        if height * height > CLEARLY_OFF * along.length_squared() * across.length_squared() {
            return height > 0.0;
        }
        self.is_just_in_front(slot)
    }

    /// Returns the cosine between the origin's normal and a triangle's, and the height of the unlifted point above the triangle.
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

    /// Gives the answer of [`Origin::is_in_front`] in f64.
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
