//! obvhs, wrapped: its eight-wide tree, walked with our own node test and triangle test.
//!
//! The stock node test clamps the entry into a box to 1e-4 in units of the ray's length, so that a ray from just
//! above a floor misses it. Ours starts a little before the origin ([`super::origin::BEFORE`]). It divides nothing by rounding
//! twice: the boxes under the tree are padded (`build`), which exceeds all the rounding of the test. Both
//! versions of the test, AVX2 and portable, do the same operations in the same order and give the same bits.

use glam::{UVec2, Vec3, Vec3A};
use obvhs::cwbvh::CwBvh;
use obvhs::cwbvh::node::CwBvhNode;

use super::ball::{Ball, ball_parts, meet_ball};
use super::body::LocalBody;
use super::build::build;
use super::origin::{BEFORE, Origin};
use super::triangle::{Crossing, Ray, Slots};
use crate::scene::body_of;

/// Distance from either end, in scaled coordinates, within which the sides of a triangle are weighed before it counts.
const NEAR: f32 = 1.0 / (1u32 << 12) as f32;

/// Triangles and balls under an eight-wide tree.
pub(super) struct Tree {
    pub(super) tree: CwBvh,
    /// Triangles in the order of the leaves; a triangle whose box was split stands there several times.
    pub slots: Slots,
    pub balls: Vec<Ball>,
    pub bodies: Vec<LocalBody>,
    /// Number of the scene's triangles; what has a higher number in `primitive_indices` is a ball, then a body.
    triangles: u32,
    /// Whether this processor has AVX2 and its kin.
    pub has_avx2: bool,
}

/// What a ray met first.
#[derive(Clone, Copy)]
pub(super) struct Found {
    /// Number of the triangle, or of the ball after all triangles.
    pub primitive: u32,
    /// Where the line crosses it.
    pub crossing: Crossing,
}

impl Tree {
    /// Builds the tree over so many triangles with these rounded corners, leaves of bodies apart, and balls and bodies.
    pub fn new(triangles: u32, corners: impl Fn(u32) -> [Vec3; 3], balls: Vec<Ball>, bodies: Vec<LocalBody>) -> Tree {
        let flat: Vec<u32> = (0..triangles).filter(|triangle| body_of(&bodies, *triangle).is_none()).collect();
        let around = |of: &LocalBody| Ball {
            center: of.frame.to_local(of.body.center_m),
            radius: of.frame.length(of.body.bounds.high),
            luminaire: u32::MAX,
        };
        let round: Vec<Ball> = balls.iter().copied().chain(bodies.iter().map(around)).collect();
        let mut tree = build(flat.iter().map(|triangle| corners(*triangle)), &round);
        for primitive in &mut tree.primitive_indices {
            *primitive = match primitive.checked_sub(flat.len() as u32) {
                Some(after) => triangles + after,
                None => flat[*primitive as usize],
            };
        }
        let of_primitive = |primitive: &u32| match primitive.checked_sub(triangles) {
            Some(after) => [round[after as usize].center.as_vec3(); 3],
            None => corners(*primitive),
        };
        let slots = Slots::new(tree.primitive_indices.iter().map(of_primitive));
        Tree { tree, slots, balls, bodies, triangles, has_avx2: has_avx2() }
    }

    /// Number of a triangle in the scene for each slot; balls follow after the last triangle.
    pub fn primitives(&self) -> &[u32] {
        &self.tree.primitive_indices
    }

    /// The luminaire of a ball, or `None` if the primitive is none.
    #[inline]
    pub fn luminaire(&self, primitive: u32) -> Option<u32> {
        self.balls.get(primitive.checked_sub(self.triangles)? as usize).map(|ball| ball.luminaire)
    }

    /// The smooth body that a primitive is, if it is one.
    #[inline]
    pub fn body(&self, primitive: u32) -> Option<&LocalBody> {
        let after = primitive.checked_sub(self.triangles)?;
        self.bodies.get((after as usize).checked_sub(self.balls.len())?)
    }

    /// What the ray meets first.
    #[inline]
    pub fn closest(&self, ray: &Ray, origin: &Origin) -> Option<Found> {
        #[cfg(target_arch = "x86_64")]
        if self.has_avx2 {
            // SAFETY: the processor has AVX2 and FMA.
            return unsafe { self.closest_avx2(ray, origin) };
        }
        self.closest_portable(ray, origin)
    }

    /// Whether anything lies between two origins; the ray runs from the first, and its direction is the difference.
    #[inline]
    pub fn blocks(&self, ray: &Ray, from: &Origin, to: &Origin) -> bool {
        #[cfg(target_arch = "x86_64")]
        if self.has_avx2 {
            // SAFETY: the processor has AVX2 and FMA.
            return unsafe { self.blocks_avx2(ray, from, to) };
        }
        self.blocks_portable(ray, from, to)
    }

    /// All crossings that count along the ray, in no order.
    #[cold]
    pub fn crossings(&self, ray: &Ray, origin: &Origin) -> Vec<Found> {
        let mut all = Vec::new();
        let mut state = self.tree.new_traversal(ray.direction);
        let mut node;
        obvhs::traverse!(self.tree, node, state, node_test_portable(node, ray, state.oct_inv4, BEFORE, f32::MAX), {
            let slot = state.primitive_id as usize;
            let primitive = self.tree.primitive_indices[slot];
            if let Some(mut crossing) = ray.cross(self.slots.slot(slot))
                && self.weigh(ray, origin, slot, &mut crossing)
            {
                all.push(Found { primitive, crossing });
            }
        });
        all
    }

    /// The same as [`Tree::blocks`] by asking every triangle and ball in turn.
    #[cold]
    pub fn blocks_one_by_one(&self, ray: &Ray, from: &Origin, to: &Origin) -> bool {
        let near = NEAR / ray.direction.length().max(f32::MIN_POSITIVE);
        let (first, last) = (BEFORE * near / NEAR, 1.0 - BEFORE * near / NEAR);
        (0..self.tree.primitive_indices.len()).any(|slot| {
            ray.cross(self.slots.slot(slot)).is_some_and(|crossing| {
                let plain = crossing.t > near && crossing.t < 1.0 - near;
                !(crossing.t > last || crossing.t < first) && (plain || self.parts(ray, from, to, slot, &crossing))
            })
        })
    }

    /// Fetches the triangles that the walk tests next.
    #[inline(always)]
    fn announce(&self, node: &CwBvhNode, hits: u32) -> u32 {
        #[cfg(target_arch = "x86_64")]
        {
            let triangles = hits & 0x00ff_ffff;
            if triangles != 0 {
                let first = self.slots.address(node.primitive_base_idx + (31 - triangles.leading_zeros()));
                // SAFETY: a prefetch reads nothing.
                unsafe {
                    use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
                    _mm_prefetch::<_MM_HINT_T0>(first);
                    _mm_prefetch::<_MM_HINT_T0>(first.wrapping_sub(64));
                    _mm_prefetch::<_MM_HINT_T0>(
                        self.slots.address(node.primitive_base_idx + triangles.trailing_zeros()),
                    );
                }
            }
        }
        hits
    }

    /// Whether of two crossings at the same distance the first goes first, whatever the order of the walk.
    #[cold]
    fn is_before(&self, slot: usize, other: usize) -> bool {
        self.tree.primitive_indices[slot] < self.tree.primitive_indices.get(other).copied().unwrap_or(u32::MAX)
    }

    /// The front that is pressed onto the origin's surface just where the origin is, if there is one.
    #[cold]
    pub fn pressed(&self, ray: &Ray, origin: &Origin) -> Option<Found> {
        let mut pressed = None;
        let mut state = self.tree.new_traversal(ray.direction);
        let mut node;
        obvhs::traverse!(self.tree, node, state, node_test_portable(node, ray, state.oct_inv4, BEFORE, -BEFORE), {
            let slot = state.primitive_id as usize;
            let primitive = self.tree.primitive_indices[slot];
            if let Some(crossing) = ray.cross(self.slots.slot(slot))
                && crossing.sum > 0.0
                && primitive != origin.own_triangle()
                && origin.is_pressed_by(self.slots.slot(slot))
            {
                pressed = Some(Found { primitive, crossing });
            }
        });
        pressed
    }

    /// Whether a crossing counts: a front seen from in front, a back from behind, or a ball; completes crossings
    /// whose distance is not a number.
    #[inline]
    fn weigh(&self, ray: &Ray, origin: &Origin, slot: usize, crossing: &mut Crossing) -> bool {
        let primitive = self.tree.primitive_indices[slot];
        if primitive == origin.own_triangle() {
            return false;
        }
        if crossing.t.is_nan() {
            let completed = match (primitive.checked_sub(self.triangles), self.body(primitive)) {
                (_, Some(body)) => body.meet(ray, origin),
                (Some(ball), None) => {
                    meet_ball(ray, origin, &self.balls[ball as usize]).map(|t| Crossing { t, ..*crossing })
                }
                (None, None) => ray.cross_edge_on(self.slots.slot(slot)),
            };
            match completed {
                Some(completed) => *crossing = completed,
                None => return false,
            }
            if primitive >= self.triangles {
                return true;
            }
        }
        crossing.t >= BEFORE
            && !origin.has_under(ray.direction, crossing.t)
            && origin.is_in_front(self.slots.slot(slot)) == (crossing.sum > 0.0)
    }

    /// Whether a crossing near an end of a segment, or one that is not a number, blocks it: its ends must lie on
    /// different sides.
    #[inline]
    fn parts(&self, ray: &Ray, from: &Origin, to: &Origin, slot: usize, crossing: &Crossing) -> bool {
        let primitive = self.tree.primitive_indices[slot];
        if primitive == from.own_triangle() || primitive == to.own_triangle() {
            return false;
        }
        let mut crossing = *crossing;
        if crossing.t.is_nan() {
            if let Some(body) = self.body(primitive) {
                return body.parts(from, to);
            }
            if primitive >= self.triangles {
                return ball_parts(ray, from, to, &self.balls[(primitive - self.triangles) as usize]);
            }
            let Some(careful) = ray.cross_edge_on(self.slots.slot(slot)) else {
                return false;
            };
            crossing = careful;
        }
        if from.has_under(ray.direction, crossing.t) || to.has_under(-ray.direction, 1.0 - crossing.t) {
            return false;
        }
        let is_front = crossing.sum > 0.0;
        from.is_in_front(self.slots.slot(slot)) == is_front && to.is_in_front(self.slots.slot(slot)) != is_front
    }
}

/// Defines the two walks with one node test.
macro_rules! walks {
    ($(#[$attribute:meta])* $node_test:ident, $closest:ident, $blocks:ident) => {
        impl Tree {
            $(#[$attribute])*
            pub(super) fn $closest(&self, ray: &Ray, origin: &Origin) -> Option<Found> {
                let mut found = Crossing::NONE;
                let mut found_slot = usize::MAX;
                let mut rank = f32::INFINITY;
                let mut state = self.tree.new_traversal(ray.direction);
                state.oct_inv4 = ray.oct_inv4;
                let mut node;
                obvhs::traverse!(
                    self.tree,
                    node,
                    state,
                    self.announce(node, $node_test(node, ray, state.oct_inv4, BEFORE, rank)),
                    {
                        let slot = state.primitive_id as usize;
                        if let Some(mut crossing) = ray.cross(self.slots.slot(slot))
                            && !(crossing.t > rank || crossing.t < BEFORE)
                            && (crossing.t > NEAR || self.weigh(ray, origin, slot, &mut crossing))
                        {
                            let own_rank = crossing.rank();
                            if own_rank < rank || (own_rank == rank && self.is_before(slot, found_slot)) {
                                (rank, found_slot, found) = (own_rank, slot, crossing);
                            }
                        }
                    }
                );
                let primitive = self.tree.primitive_indices.get(found_slot)?;
                Some(Found { primitive: *primitive, crossing: found })
            }

            $(#[$attribute])*
            pub(super) fn $blocks(&self, ray: &Ray, from: &Origin, to: &Origin) -> bool {
                let near = NEAR / ray.direction.length().max(f32::MIN_POSITIVE);
                let (first, last) = (BEFORE * near / NEAR, 1.0 - BEFORE * near / NEAR);
                let mut state = self.tree.new_traversal(ray.direction);
                state.oct_inv4 = ray.oct_inv4;
                let mut node;
                obvhs::traverse!(
                    self.tree,
                    node,
                    state,
                    self.announce(node, $node_test(node, ray, state.oct_inv4, first, last)),
                    {
                        let slot = state.primitive_id as usize;
                        if let Some(crossing) = ray.cross(self.slots.slot(slot))
                            && !(crossing.t > last || crossing.t < first)
                        {
                            let plain = crossing.t > near && crossing.t < 1.0 - near;
                            if plain || self.parts(ray, from, to, slot, &crossing) {
                                return true;
                            }
                        }
                    }
                );
                false
            }
        }
    };
}

walks!(node_test_portable, closest_portable, blocks_portable);
#[cfg(target_arch = "x86_64")]
walks!(
    #[target_feature(enable = "avx2,fma,popcnt,lzcnt,bmi1,bmi2")]
    node_test_avx2,
    closest_avx2,
    blocks_avx2
);

fn has_avx2() -> bool {
    #[cfg(target_arch = "x86_64")]
    {
        is_x86_feature_detected!("avx2")
            && is_x86_feature_detected!("fma")
            && is_x86_feature_detected!("popcnt")
            && is_x86_feature_detected!("lzcnt")
            && is_x86_feature_detected!("bmi1")
            && is_x86_feature_detected!("bmi2")
    }
    #[cfg(not(target_arch = "x86_64"))]
    false
}

/// Which children of a node the ray enters between two distances, as obvhs encodes them.
#[inline(always)]
fn node_test_portable(node: &CwBvhNode, ray: &Ray, oct_inv4: u32, first: f32, last: f32) -> u32 {
    let step = (node.compute_extent() * ray.inverse).to_array();
    let start = ((Vec3A::from(node.p) - ray.origin) * ray.inverse).to_array();
    let planes = [
        [&node.child_min_x, &node.child_max_x],
        [&node.child_min_y, &node.child_max_y],
        [&node.child_min_z, &node.child_max_z],
    ];
    let mut enter = [first; 8];
    let mut leave = [last; 8];
    for axis in 0..3 {
        let near = usize::from(ray.near[axis] != 0);
        for child in 0..8 {
            let t_near = f32::from(planes[axis][near][child]) * step[axis] + start[axis];
            let t_far = f32::from(planes[axis][1 - near][child]) * step[axis] + start[axis];
            enter[child] = if t_near > enter[child] { t_near } else { enter[child] };
            leave[child] = if t_far < leave[child] { t_far } else { leave[child] };
        }
    }
    let (child_bits, bit_index) = node.get_child_and_index_bits(oct_inv4);
    let (child_bits, bit_index) = (child_bits.to_le_bytes(), bit_index.to_le_bytes());
    (0..8)
        .filter(|child| enter[*child] <= leave[*child])
        .fold(0, |hits, child| hits | u32::from(child_bits[child]) << bit_index[child])
}

/// The same for all eight children at once.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma,popcnt,lzcnt,bmi1,bmi2")]
#[inline]
fn node_test_avx2(node: &CwBvhNode, ray: &Ray, oct_inv4: u32, first: f32, last: f32) -> u32 {
    use std::arch::x86_64::*;
    const FIRST_PLANES: usize = std::mem::offset_of!(CwBvhNode, child_min_x);
    const {
        assert!(std::mem::offset_of!(CwBvhNode, child_max_x) == FIRST_PLANES + 8);
        assert!(std::mem::offset_of!(CwBvhNode, child_min_y) == FIRST_PLANES + 16);
        assert!(std::mem::offset_of!(CwBvhNode, child_max_y) == FIRST_PLANES + 24);
        assert!(std::mem::offset_of!(CwBvhNode, child_min_z) == FIRST_PLANES + 32);
        assert!(std::mem::offset_of!(CwBvhNode, child_max_z) == FIRST_PLANES + 40);
    }
    let step = (node.compute_extent() * ray.inverse).to_array();
    let start = ((Vec3A::from(node.p) - ray.origin) * ray.inverse).to_array();
    let base = std::ptr::from_ref(node).cast::<u8>();
    let eight = |offset: usize| {
        // SAFETY: the offsets are those of the node's six arrays of eight bytes.
        let bytes = unsafe { _mm_loadl_epi64(base.add(FIRST_PLANES + offset).cast()) };
        _mm256_cvtepi32_ps(_mm256_cvtepu8_epi32(bytes))
    };
    let plane = |axis: usize, offset: usize| {
        let distance = _mm256_mul_ps(eight(axis * 16 + offset), _mm256_set1_ps(step[axis]));
        _mm256_add_ps(distance, _mm256_set1_ps(start[axis]))
    };
    let near = |axis: usize| plane(axis, ray.near[axis]);
    let far = |axis: usize| plane(axis, ray.near[axis] ^ 8);
    let enter = _mm256_max_ps(_mm256_max_ps(near(0), near(1)), _mm256_max_ps(near(2), _mm256_set1_ps(first)));
    let leave = _mm256_min_ps(_mm256_min_ps(far(0), far(1)), _mm256_min_ps(far(2), _mm256_set1_ps(last)));
    let entered = _mm256_castps_si256(_mm256_cmp_ps::<_CMP_LE_OQ>(enter, leave));

    // Each child that is entered sets its bits at its place in the walking order.
    let (child_bits, bit_index) = node.get_child_and_index_bits(oct_inv4);
    let child_bits = _mm256_cvtepu8_epi32(_mm_cvtsi64_si128(child_bits as i64));
    let bit_index = _mm256_cvtepu8_epi32(_mm_cvtsi64_si128(bit_index as i64));
    let hits = _mm256_and_si256(_mm256_sllv_epi32(child_bits, bit_index), entered);
    let hits = _mm_or_si128(_mm256_castsi256_si128(hits), _mm256_extracti128_si256::<1>(hits));
    let hits = _mm_or_si128(hits, _mm_shuffle_epi32::<0b01_00_11_10>(hits));
    let hits = _mm_or_si128(hits, _mm_shuffle_epi32::<0b10_11_00_01>(hits));
    _mm_cvtsi128_si32(hits) as u32
}
