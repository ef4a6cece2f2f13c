//! The watertight ray–triangle test (Woop, Benthin and Wald 2013, "Watertight Ray/Triangle Intersection").
//!
//! The ray's frame puts its origin at zero and its direction along z: vertices are translated and sheared one by one,
//! and the triangle is hit if zero lies inside its projection. Translating and shearing round, but the same vertex
//! always rounds the same, so that a closed mesh stays closed. The edge functions are two products and a difference,
//! each rounded once and never fused: rounding is monotone, so the sign of the difference is never wrong, only zero.
//! Zero counts as inside for both triangles at an edge, hence nothing slips between them.

use glam::{DVec3, Vec3, Vec3A, Vec4, Vec4Swizzles};

/// Smallest component of a direction that the slab test divides by: a ray turned by so little moves by less than
/// 2⁻⁵⁸ on its way through the scene, while infinities (and 0 · ∞) never arise.
const SMALLEST_COMPONENT: f32 = 1.0 / (1u64 << 60) as f32;

/// The corners of all triangles in the order of the leaves: x, y and z of the three corners, 36 bytes each. Memory
/// is what a walk through a large scene waits for, hence no padding and no numbers that a test does not need.
pub(super) struct Slots {
    numbers: Vec<f32>,
}

/// A triangle in [`Slots`].
#[derive(Clone, Copy)]
pub(super) struct Slot<'a> {
    /// Its nine numbers, and one more that belongs to the next.
    numbers: &'a [f32; 10],
}

impl Slots {
    /// Triangles with these corners. One whose corners coincide stands for something else: every ray through the
    /// scene meets it at a distance that is not a number, and thereby takes a closer look.
    pub fn new(corners: impl ExactSizeIterator<Item = [Vec3; 3]>) -> Slots {
        let mut numbers = Vec::with_capacity(corners.len() * 9 + 1);
        for [a, b, c] in corners {
            numbers.extend([a.x, b.x, c.x, a.y, b.y, c.y, a.z, b.z, c.z]);
        }
        numbers.push(0.0);
        Slots { numbers }
    }

    /// Where a slot lies in memory.
    #[inline(always)]
    pub fn address(&self, slot: u32) -> *const i8 {
        self.numbers.as_ptr().wrapping_add(slot as usize * 9).cast()
    }

    /// The triangle in a slot.
    #[inline(always)]
    pub fn slot(&self, slot: usize) -> Slot<'_> {
        let start = slot * 9;
        assert!(start + 10 <= self.numbers.len());
        // SAFETY: the ten numbers lie within the list.
        Slot { numbers: unsafe { &*self.numbers.as_ptr().add(start).cast() } }
    }
}

impl Slot<'_> {
    /// The three corners' coordinates along an axis, 0 to 2; the fourth lane is some finite number.
    #[inline(always)]
    fn row(self, axis: usize) -> Vec4 {
        debug_assert!(axis < 3);
        // SAFETY: the axis is 0, 1 or 2, so that at most the tenth number is read.
        Vec4::from_array(unsafe { *self.numbers.as_ptr().add(axis * 3).cast() })
    }

    /// The rounded corners.
    #[inline]
    pub fn corners_f32(self) -> [Vec3A; 3] {
        [0, 1, 2].map(|corner| Vec3A::new(self.numbers[corner], self.numbers[corner + 3], self.numbers[corner + 6]))
    }

    /// The rounded corners, exact in f64.
    pub fn corners(self) -> [DVec3; 3] {
        self.corners_f32().map(|corner| corner.as_dvec3())
    }
}

/// A ray in the tracer's coordinates with what the tests derive from it once.
pub(super) struct Ray {
    pub origin: Vec3A,
    pub direction: Vec3A,
    /// Reciprocal of the direction, finite.
    pub inverse: Vec3A,
    /// Axes of the ray's frame: the direction's largest component comes last.
    axes: [usize; 3],
    /// The origin's components in that order.
    translation: [Vec4; 3],
    shear: [Vec4; 2],
    /// Reciprocal of the direction's largest component.
    scale: f32,
    /// Bytes from `child_min_…` to the near plane of each axis in a node: 0, or 8 where the ray runs down.
    pub near: [usize; 3],
    /// Walking order of children in obvhs' encoding.
    pub oct_inv4: u32,
}

/// Where a ray runs through a triangle. The weights of the corners share one sign: positive if it comes from the front.
#[derive(Clone, Copy)]
pub(super) struct Crossing {
    /// Distance in units of the ray's direction; not a number for edge-on triangles and for those that are none.
    pub t: f32,
    /// Undivided weights of the corners; the fourth is 0.
    pub weights: Vec4,
    /// Sum of the weights.
    pub sum: f32,
}

/// A back counts as this much farther than it is, in units of the direction, so that of two skins in one plane,
/// rounded differently, a ray meets the front.
const SKIN: f32 = 1.0 / (1u32 << 20) as f32;

impl Crossing {
    /// No crossing.
    pub const NONE: Crossing = Crossing { t: f32::INFINITY, weights: Vec4::ZERO, sum: 0.0 };

    /// Distance by which crossings are ordered.
    #[inline(always)]
    pub fn rank(&self) -> f32 {
        self.t + if self.sum < 0.0 { SKIN } else { 0.0 }
    }
}

impl Ray {
    /// The direction need not have unit length, but some length.
    #[inline]
    pub fn new(origin: Vec3A, direction: Vec3A) -> Ray {
        let magnitude = direction.abs();
        let last = if magnitude.x > magnitude.y && magnitude.x > magnitude.z {
            0
        } else if magnitude.y > magnitude.z {
            1
        } else {
            2
        };
        let along = direction.to_array();
        let first = if last == 2 { 0 } else { last + 1 };
        let second = if first == 2 { 0 } else { first + 1 };
        // A ray that runs up its axis swaps the other two, so that it always sees fronts counter-clockwise.
        let axes = if along[last] > 0.0 { [second, first, last] } else { [first, second, last] };
        let from = origin.to_array();
        let inverse = 1.0
            / Vec3A::select(
                magnitude.cmplt(Vec3A::splat(SMALLEST_COMPONENT)),
                Vec3A::splat(SMALLEST_COMPONENT).copysign(direction),
                direction,
            );
        let down = inverse.is_negative_bitmask() as usize;
        Ray {
            origin,
            direction,
            inverse,
            axes,
            translation: axes.map(|axis| Vec4::splat(from[axis])),
            shear: [Vec4::splat(along[axes[0]] / along[last]), Vec4::splat(along[axes[1]] / along[last])],
            scale: 1.0 / along[last],
            near: [(down & 1) * 8, (down >> 1 & 1) * 8, (down >> 2 & 1) * 8],
            oct_inv4: (if down & 1 == 0 { 0x0404_0404 } else { 0 })
                | (if down & 2 == 0 { 0x0202_0202 } else { 0 })
                | (if down & 4 == 0 { 0x0101_0101 } else { 0 }),
        }
    }

    /// The corners in the ray's frame: x, y and z of all three.
    #[inline(always)]
    fn project(&self, slot: Slot) -> [Vec4; 3] {
        let z = slot.row(self.axes[2]) - self.translation[2];
        let x = slot.row(self.axes[0]) - self.translation[0] - self.shear[0] * z;
        let y = slot.row(self.axes[1]) - self.translation[1] - self.shear[1] * z;
        [x, y, z]
    }

    /// Where the line of the ray runs through a triangle, behind the origin too, or `None` if it passes it by.
    #[inline(always)]
    pub fn cross(&self, slot: Slot) -> Option<Crossing> {
        let [x, y, z] = self.project(slot);
        // The weight of a corner is the edge function of the edge across. The fourth lane cancels to 0 exactly.
        let weights = x.yzxw() * y.zxyw() - y.yzxw() * x.zxyw();
        let negative = weights.cmplt(Vec4::ZERO).bitmask();
        let positive = weights.cmpgt(Vec4::ZERO).bitmask();
        if negative != 0 && positive != 0 {
            return None;
        }
        let sum = weights.x + weights.y + weights.z;
        let t = weights.dot(z) * self.scale / sum;
        Some(Crossing { t, weights, sum })
    }

    /// The same for a triangle that is seen so nearly edge-on that all its edge functions rounded to zero: f64
    /// subtracts products of f32 without losing a sign. A triangle that is edge-on exactly is passed by, as its
    /// neighbours cover its line.
    #[cold]
    pub fn cross_edge_on(&self, slot: Slot) -> Option<Crossing> {
        let [x, y, z] = self.project(slot).map(|row| row.as_dvec4());
        let edge = |i: usize, j: usize| x[i] * y[j] - y[i] * x[j];
        let weights = [edge(1, 2), edge(2, 0), edge(0, 1)];
        if weights.iter().any(|weight| *weight < 0.0) && weights.iter().any(|weight| *weight > 0.0) {
            return None;
        }
        let sum: f64 = weights.iter().sum();
        if sum == 0.0 || sum.is_nan() {
            return None;
        }
        let shares = DVec3::from(weights) / sum.abs();
        let t = shares.dot(z.truncate()) * f64::from(self.scale) * sum.signum();
        Some(Crossing { t: t as f32, weights: shares.as_vec3().extend(0.0), sum: sum.signum() as f32 })
    }
}
