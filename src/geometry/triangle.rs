//! The watertight ray–triangle test (Woop, Benthin and Wald 2013, "Watertight Ray/Triangle Intersection").
//!
//! In the ray's frame its origin is zero and its direction is z. Vertices are translated and sheared one by one. The triangle is hit if
//! zero lies inside its projection. Translating and shearing round, but the same vertex always rounds the same way, so a closed mesh stays
//! closed. Each edge function is the difference of two products, rounded separately and never fused. Rounding is monotone, so the sign of
//! the difference is never wrong; it can only become zero. Zero counts as inside for both triangles at an edge, so no ray slips between
//! them.

use glam::{DVec3, Vec3, Vec3A};

/// Smallest component of a direction that the slab test divides by. A ray that is turned by this moves by less than 2⁻⁵⁸ on its way through
/// the scene. Infinities (and 0 · ∞) never arise.
const SMALLEST_COMPONENT: f32 = 1.0 / (1u64 << 60) as f32;

/// Axis with the largest component, indexed by whether x is above y (1), x above z (2) and y above z (4).
const LARGEST: [usize; 8] = [2, 2, 2, 0, 1, 2, 1, 0];
/// Axes of a ray's frame, indexed by the last axis and by whether the ray goes up along it. In that case the other two axes are exchanged,
/// so that fronts always appear counter-clockwise.
const FRAMES: [[[usize; 3]; 2]; 3] = [[[1, 2, 0], [2, 1, 0]], [[2, 0, 1], [0, 2, 1]], [[0, 1, 2], [1, 0, 2]]];

/// Number of triangles side by side.
pub(super) const LANES: usize = 8;

/// Up to eight triangles side by side: for each axis and each corner, the coordinate of each triangle. Empty places hold NaN, and no ray
/// meets them.
#[derive(Clone)]
#[repr(C, align(32))]
pub(super) struct Block {
    corners: [[[f32; LANES]; 3]; 3],
}

/// A triangle in a [`Block`].
#[derive(Clone, Copy)]
pub(super) struct Slot<'a> {
    block: &'a Block,
    lane: usize,
}

impl Block {
    pub const EMPTY: Block = Block { corners: [[[f32::NAN; LANES]; 3]; 3] };

    /// Puts a triangle into a place. A triangle whose corners coincide represents another object. Every ray meets it at a NaN distance,
    /// which triggers an exact test.
    pub fn set(&mut self, lane: usize, corners: [Vec3; 3]) {
        for (corner, place) in corners.into_iter().enumerate() {
            for axis in 0..3 {
                self.corners[axis][corner][lane] = place[axis];
            }
        }
    }

    /// Returns the triangle in a place, 0 to 7.
    #[inline]
    pub fn slot(&self, lane: usize) -> Slot<'_> {
        Slot { block: self, lane }
    }
}

impl Slot<'_> {
    /// Returns the rounded corners.
    #[inline]
    pub fn corners_f32(self) -> [Vec3A; 3] {
        let [x, y, z] = &self.block.corners;
        [0, 1, 2].map(|corner| Vec3A::new(x[corner][self.lane], y[corner][self.lane], z[corner][self.lane]))
    }

    /// Returns the rounded corners, exactly converted to f64.
    #[inline]
    pub fn corners(self) -> [DVec3; 3] {
        self.corners_f32().map(|corner| corner.as_dvec3())
    }
}

/// A ray in the tracer's coordinates, with values that the tests derive from it once.
pub(super) struct Ray {
    pub origin: Vec3A,
    pub direction: Vec3A,
    /// Reciprocal of the direction, finite.
    pub inverse: Vec3A,
    /// Axes of the ray's frame. The axis of the direction's largest component is last.
    axes: [usize; 3],
    /// The origin's components in that order.
    translation: [f32; 3],
    shear: [f32; 2],
    /// Reciprocal of the direction's largest component.
    scale: f32,
    /// For each axis, which of a node's two planes is the near one: the low one, 0, or the high one, 1, where the ray goes down.
    pub near: [usize; 3],
}

/// Where a ray goes through a triangle. The weights of the corners have one sign, positive if the ray comes from the front.
#[derive(Clone, Copy)]
pub(super) struct Crossing {
    /// Distance in units of the ray's direction. NaN for edge-on triangles and for entries that represent other objects.
    pub t: f32,
    /// Weights of the corners, not divided by their sum.
    pub weights: Vec3,
    /// Sum of the weights.
    pub sum: f32,
}

/// A subset of the lanes, one bit each, the first lane in the lowest bit. As an iterator it returns their numbers in turn.
#[derive(Clone, Copy)]
pub(super) struct Lanes(pub u32);

impl Iterator for Lanes {
    type Item = usize;

    #[inline(always)]
    fn next(&mut self) -> Option<usize> {
        let lane = (self.0 != 0).then_some(self.0.trailing_zeros() as usize);
        self.0 &= self.0.wrapping_sub(1);
        lane
    }
}

/// Where a ray goes through triangles side by side.
pub(super) struct Crossings {
    /// The crossed triangles.
    pub lanes: Lanes,
    pub t: [f32; LANES],
    weights: [[f32; LANES]; 3],
    sum: [f32; LANES],
}

impl Crossings {
    /// Returns the crossing of one crossed triangle.
    #[inline(always)]
    pub fn lane(&self, lane: usize) -> Crossing {
        let weights = Vec3::new(self.weights[0][lane], self.weights[1][lane], self.weights[2][lane]);
        Crossing { t: self.t[lane], weights, sum: self.sum[lane] }
    }
}

/// Extra distance of a back, in units of the direction. Of two coplanar skins that are rounded differently, a ray then meets the front.
const SKIN: f32 = 1.0 / (1u32 << 20) as f32;

impl Crossing {
    /// No crossing.
    pub const NONE: Crossing = Crossing { t: f32::INFINITY, weights: Vec3::ZERO, sum: 0.0 };

    /// Returns the distance by which crossings are ordered.
    #[inline(always)]
    pub fn rank(&self) -> f32 {
        self.t + if self.sum < 0.0 { SKIN } else { 0.0 }
    }
}

impl Ray {
    /// Makes a ray. The direction need not have unit length, but must not be zero.
    #[inline]
    pub fn new(origin: Vec3A, direction: Vec3A) -> Ray {
        let magnitude = direction.abs();
        let along = direction.to_array();
        let [x, y, z] = magnitude.to_array();
        let (x_y, x_z, y_z) = (x > y, x > z, y > z);
        // Uses tables, because a branch would be mispredicted.
        let last = LARGEST[usize::from(x_y) | usize::from(x_z) << 1 | usize::from(y_z) << 2];
        let axes = FRAMES[last][usize::from(along[last] > 0.0)];
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
            translation: [from[axes[0]], from[axes[1]], from[axes[2]]],
            shear: [along[axes[0]] / along[last], along[axes[1]] / along[last]],
            scale: 1.0 / along[last],
            near: [down & 1, down >> 1 & 1, down >> 2 & 1],
        }
    }

    /// Returns the corners of triangles side by side in the ray's frame: x, y and z of all three.
    #[inline(always)]
    fn project(&self, block: &Block) -> [[[f32; LANES]; 3]; 3] {
        let mut projected = [[[0.0; LANES]; 3]; 3];
        let [x, y, z] = &mut projected;
        let [xs, ys, zs] = [&block.corners[self.axes[0]], &block.corners[self.axes[1]], &block.corners[self.axes[2]]];
        for corner in 0..3 {
            for lane in 0..LANES {
                z[corner][lane] = zs[corner][lane] - self.translation[2];
                x[corner][lane] = xs[corner][lane] - self.translation[0] - self.shear[0] * z[corner][lane];
                y[corner][lane] = ys[corner][lane] - self.translation[1] - self.shear[1] * z[corner][lane];
            }
        }
        projected
    }

    /// Returns where the line of the ray goes through triangles side by side, behind the origin too. `signs` gathers the top bits of eight
    /// words, that of the first word in the lowest bit.
    #[inline(always)]
    pub fn cross(&self, block: &Block, signs: impl Fn(&[u32; LANES]) -> u32) -> Crossings {
        let [x, y, z] = self.project(block);
        // The weight of a corner is the edge function of the opposite edge.
        let mut weights = [[0.0; LANES]; 3];
        for (corner, weights) in weights.iter_mut().enumerate() {
            let (next, last) = ((corner + 1) % 3, (corner + 2) % 3);
            for lane in 0..LANES {
                weights[lane] = x[next][lane] * y[last][lane] - y[next][lane] * x[last][lane];
            }
        }
        let (mut sum, mut t, mut crossed) = ([0.0; LANES], [0.0; LANES], [0; LANES]);
        for lane in 0..LANES {
            let [a, b, c] = [weights[0][lane], weights[1][lane], weights[2][lane]];
            sum[lane] = a + b + c;
            t[lane] = (a * z[0][lane] + b * z[1][lane] + c * z[2][lane]) * self.scale / sum[lane];
            // All comparisons with NaN are false.
            let front = (a >= 0.0) & (b >= 0.0) & (c >= 0.0);
            let back = (a <= 0.0) & (b <= 0.0) & (c <= 0.0);
            crossed[lane] = if front | back { u32::MAX } else { 0 };
        }
        Crossings { lanes: Lanes(signs(&crossed)), t, weights, sum }
    }

    /// Returns the crossing of a triangle that is so nearly edge-on that all its edge functions rounded to zero. In f64, differences of
    /// products of f32 keep their sign. A triangle that is exactly edge-on is skipped, because its neighbours cover its line.
    #[cold]
    pub fn cross_edge_on(&self, slot: Slot) -> Option<Crossing> {
        let of_lane = |rows: [[f32; LANES]; 3]| rows.map(|row| f64::from(row[slot.lane]));
        let [x, y, z] = self.project(slot.block).map(of_lane);
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
        let t = shares.dot(DVec3::from(z)) * f64::from(self.scale) * sum.signum();
        Some(Crossing { t: t as f32, weights: shares.as_vec3(), sum: sum.signum() as f32 })
    }
}
