//! The tree over all that rays can meet, and the two walks through it: one finds the first hit, the other finds anything in between.
//!
//! obvhs builds a binary tree. Here it becomes nodes of eight boxes over blocks of eight triangles, so that boxes and triangles are tested
//! side by side. The test of boxes starts a little before the origin ([`super::origin::BEFORE`]), so that a ray from just above a floor
//! does not miss it. The boxes are padded (`build`) by more than all the rounding of the test. Both versions of the walks, AVX2 and
//! portable, do the same operations in the same order and give the same bits.

use std::mem::MaybeUninit;

use glam::{DVec3, Vec3};

use super::ball::{Ball, ball_parts, meet_ball};
use super::body::LocalBody;
use super::build::{DEEPEST, build};
use super::nodes::{Below, Child, Nodes, WideNode};
use super::origin::{BEFORE, Origin};
use super::region::Region;
use super::triangle::{Crossing, LANES, Lanes, Ray, Slot};
use crate::scene::body_of;

/// Largest number of children that wait on a walk's stack: all but one of every level, and the last level's.
const STACK: usize = (LANES - 1) * DEEPEST + 1;

/// Distance from either end, in scaled coordinates, within which the sides of a triangle are checked before its crossing counts.
const NEAR_END: f32 = 1.0 / (1u32 << 12) as f32;

/// Triangles and balls under an eight-wide tree.
pub(super) struct Tree {
    nodes: Nodes,
    pub balls: Vec<Ball>,
    pub bodies: Vec<LocalBody>,
    /// Number of the scene's triangles. Higher numbers belong to balls, and after them to bodies.
    triangles: u32,
    /// Whether this processor has AVX2 and FMA.
    #[cfg(target_arch = "x86_64")]
    pub has_avx2: bool,
}

/// The first hit of a ray.
#[derive(Clone, Copy)]
pub(super) struct Found {
    /// Number of the triangle; balls and bodies are numbered after all triangles.
    pub primitive: u32,
    /// Where the line of the ray crosses it.
    pub crossing: Crossing,
}

impl Tree {
    /// Builds the tree over triangles with these rounded corners, except the leaves of bodies, and over balls and bodies.
    pub fn new(triangles: u32, corners: impl Fn(u32) -> [Vec3; 3], balls: Vec<Ball>, bodies: Vec<LocalBody>) -> Tree {
        let flat: Vec<u32> = (0..triangles).filter(|triangle| body_of(&bodies, *triangle).is_none()).collect();
        let round: Vec<Ball> = balls.iter().copied().chain(bodies.iter().map(LocalBody::ball)).collect();
        let mut nodes = build(flat.len() as u32, |triangle| corners(flat[triangle as usize]), &round);
        nodes.renumber(|primitive| match primitive.checked_sub(flat.len() as u32) {
            Some(after) => triangles + after,
            None => flat[primitive as usize],
        });
        Tree {
            nodes,
            balls,
            bodies,
            triangles,
            #[cfg(target_arch = "x86_64")]
            has_avx2: has_avx2(),
        }
    }

    /// Returns the numbers of the slots that hold a triangle with its number in the scene. Balls follow after the last triangle.
    pub fn slots(&self) -> impl Iterator<Item = (usize, u32)> {
        self.nodes.filled()
    }

    /// Returns the content of a slot.
    #[inline]
    pub fn slot(&self, slot: usize) -> Slot<'_> {
        self.nodes.blocks[slot / LANES].slot(slot % LANES)
    }

    /// Returns the luminaire of a ball; `None` if the primitive is not a ball.
    #[inline]
    pub fn luminaire(&self, primitive: u32) -> Option<u32> {
        self.balls.get(primitive.checked_sub(self.triangles)? as usize).map(|ball| ball.luminaire)
    }

    /// Returns the smooth body of a primitive, if it is one.
    #[inline]
    pub fn body(&self, primitive: u32) -> Option<&LocalBody> {
        let after = primitive.checked_sub(self.triangles)?;
        self.bodies.get((after as usize).checked_sub(self.balls.len())?)
    }

    /// Returns the first hit of the ray.
    #[inline]
    pub fn closest(&self, ray: &Ray, origin: &Origin) -> Option<Found> {
        #[cfg(target_arch = "x86_64")]
        if self.has_avx2 {
            // SAFETY: the processor has AVX2 and FMA.
            return unsafe { self.closest_avx2(ray, origin) };
        }
        self.closest_portable(ray, origin)
    }

    /// Whether anything lies between two origins. The ray starts at the first, and its direction is the difference.
    #[inline]
    pub fn blocks(&self, ray: &Ray, from: &Origin, to: &Origin) -> bool {
        #[cfg(target_arch = "x86_64")]
        if self.has_avx2 {
            // SAFETY: the processor has AVX2 and FMA.
            return unsafe { self.blocks_avx2(ray, from, to) };
        }
        self.blocks_portable(ray, from, to)
    }

    /// Returns all crossings that count along the ray, in no order.
    #[cold]
    pub fn crossings(&self, ray: &Ray, origin: &Origin) -> Vec<Found> {
        let mut all = Vec::new();
        self.for_each_crossing(ray, f32::INFINITY, |slot, mut crossing| {
            if self.weigh(ray, origin, slot, &mut crossing) {
                all.push(Found { primitive: self.nodes.primitives[slot], crossing });
            }
        });
        all
    }

    /// Passes to `each` all slots that the line of a ray crosses, with the crossings. It searches the boxes that the line enters before
    /// `last`.
    fn for_each_crossing(&self, ray: &Ray, last: f32, mut each: impl FnMut(usize, Crossing)) {
        let mut open = if self.nodes.nodes.is_empty() { vec![] } else { vec![Child::ROOT] };
        while let Some(child) = open.pop() {
            match child.what() {
                Below::Node(node) => {
                    let node = &self.nodes.nodes[node];
                    let (entered, _) = enter(node, ray, BEFORE, last, signs_portable);
                    open.extend(entered.map(|lane| node.children[lane]));
                }
                Below::Block(block) => {
                    let crossings = ray.cross(&self.nodes.blocks[block], signs_portable);
                    for lane in crossings.lanes {
                        each(block * LANES + lane, crossings.lane(lane));
                    }
                }
            }
        }
    }

    /// Returns boxes around the balls and the smooth bodies.
    pub fn round_boxes(&self) -> impl Iterator<Item = Region> {
        let balls = self.balls.iter().copied().chain(self.bodies.iter().map(LocalBody::ball));
        balls.map(|ball| Region { low: ball.center - ball.radius, high: ball.center + ball.radius })
    }

    /// Passes to `each` the triangles whose boxes overlap a region. `each` may shrink the region.
    pub fn for_each_within(&self, mut region: Region, mut each: impl FnMut(&mut Region, Slot)) {
        let mut open = if self.nodes.nodes.is_empty() { vec![] } else { vec![Child::ROOT] };
        while let Some(child) = open.pop() {
            match child.what() {
                Below::Node(node) => {
                    let node = &self.nodes.nodes[node];
                    let corner = |lane: usize, end: usize| {
                        DVec3::from([0, 1, 2].map(|axis| f64::from(node.planes[2 * axis + end][lane])))
                    };
                    let overlaps =
                        |lane: &usize| region.overlaps(&Region { low: corner(*lane, 0), high: corner(*lane, 1) });
                    open.extend((0..LANES).filter(overlaps).map(|lane| node.children[lane]));
                }
                Below::Block(block) => {
                    let slots = block * LANES..(block + 1) * LANES;
                    let triangles = slots.filter(|slot| self.nodes.primitives[*slot] < self.triangles);
                    triangles.for_each(|slot| each(&mut region, self.slot(slot)));
                }
            }
        }
    }

    /// Gives the answer of [`Tree::blocks`] by testing every triangle and ball in turn.
    #[cold]
    pub fn blocks_one_by_one(&self, ray: &Ray, from: &Origin, to: &Origin) -> bool {
        let near = NEAR_END / ray.direction.length().max(f32::MIN_POSITIVE);
        let (first, last) = (BEFORE * near / NEAR_END, 1.0 - BEFORE * near / NEAR_END);
        self.nodes.blocks.iter().enumerate().any(|(number, block)| {
            let crossings = ray.cross(block, signs_portable);
            let mut lanes = crossings.lanes;
            lanes.any(|lane| {
                let crossing = crossings.lane(lane);
                let plain = crossing.t > near && crossing.t < 1.0 - near;
                !(crossing.t > last || crossing.t < first)
                    && (plain || self.parts(ray, from, to, number * LANES + lane, &crossing))
            })
        })
    }

    /// Whether the first of two crossings at the same distance takes precedence, independent of the order of the walk.
    #[cold]
    fn is_before(&self, slot: usize, other: usize) -> bool {
        self.nodes.primitives[slot] < self.nodes.primitives.get(other).copied().unwrap_or(u32::MAX)
    }

    /// Returns the front that touches the origin's surface at the origin's position, if there is one.
    #[cold]
    pub fn pressed(&self, ray: &Ray, origin: &Origin) -> Option<Found> {
        let mut pressed = None;
        self.for_each_crossing(ray, -BEFORE, |slot, crossing| {
            let primitive = self.nodes.primitives[slot];
            if crossing.sum > 0.0 && primitive != origin.own_triangle() && origin.is_pressed_by(self.slot(slot)) {
                pressed = Some(Found { primitive, crossing });
            }
        });
        pressed
    }

    /// Whether a crossing counts: a front seen from in front, a back seen from behind, or a ball. It completes crossings whose distance is
    /// NaN.
    #[inline]
    fn weigh(&self, ray: &Ray, origin: &Origin, slot: usize, crossing: &mut Crossing) -> bool {
        let primitive = self.nodes.primitives[slot];
        if primitive == origin.own_triangle() {
            return false;
        }
        if crossing.t.is_nan() {
            let completed = match (primitive.checked_sub(self.triangles), self.body(primitive)) {
                (_, Some(body)) => body.meet(ray, origin),
                (Some(ball), None) => {
                    meet_ball(ray, origin, &self.balls[ball as usize]).map(|t| Crossing { t, ..*crossing })
                }
                (None, None) => ray.cross_edge_on(self.slot(slot)),
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
            && origin.is_in_front(self.slot(slot)) == (crossing.sum > 0.0)
    }

    /// Whether a crossing near an end of a segment, or one with a NaN distance, blocks the segment. The ends must lie on different sides.
    #[inline]
    fn parts(&self, ray: &Ray, from: &Origin, to: &Origin, slot: usize, crossing: &Crossing) -> bool {
        let primitive = self.nodes.primitives[slot];
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
            let Some(careful) = ray.cross_edge_on(self.slot(slot)) else {
                return false;
            };
            crossing = careful;
        }
        if from.has_under(ray.direction, crossing.t) || to.has_under(-ray.direction, 1.0 - crossing.t) {
            return false;
        }
        let is_front = crossing.sum > 0.0;
        from.is_in_front(self.slot(slot)) == is_front && to.is_in_front(self.slot(slot)) != is_front
    }
}

/// Defines the two walks for one method of gathering signs.
macro_rules! walks {
    ($(#[$attribute:meta])* $signs:ident, $closest:ident, $blocks:ident) => {
        impl Tree {
            $(#[$attribute])*
            pub(super) fn $closest(&self, ray: &Ray, origin: &Origin) -> Option<Found> {
                let mut found = Crossing::NONE;
                let mut found_slot = usize::MAX;
                let mut rank = f32::INFINITY;
                // Children that wait, with the distances at which the ray enters their boxes.
                let mut stack = Stack::<(Child, f32)>::new();
                let mut next = (!self.nodes.nodes.is_empty()).then_some(Child::ROOT);
                while let Some(child) = next {
                    match child.what() {
                        Below::Node(node) => {
                            let node = &self.nodes.nodes[node];
                            let (mut entered, distances) = enter(node, ray, BEFORE, rank, |words| $signs(words));
                            if let Some(lane) = entered.next() {
                                let (mut nearest, mut distance) = (node.children[lane], distances[lane]);
                                let nearer_wait_after = stack.count;
                                for lane in entered {
                                    let mut other = (node.children[lane], distances[lane]);
                                    if other.1 < distance {
                                        std::mem::swap(&mut nearest, &mut other.0);
                                        std::mem::swap(&mut distance, &mut other.1);
                                    }
                                    stack.push_sorted(nearer_wait_after, other);
                                }
                                next = Some(nearest);
                                continue;
                            }
                        }
                        Below::Block(block) => {
                            let crossings = ray.cross(&self.nodes.blocks[block], |words| $signs(words));
                            for lane in crossings.lanes {
                                let t = crossings.t[lane];
                                if t > rank || t < BEFORE {
                                    continue;
                                }
                                let slot = block * LANES + lane;
                                let mut crossing = crossings.lane(lane);
                                if t > NEAR_END || self.weigh(ray, origin, slot, &mut crossing) {
                                    let own_rank = crossing.rank();
                                    if own_rank < rank || (own_rank == rank && self.is_before(slot, found_slot)) {
                                        (rank, found_slot, found) = (own_rank, slot, crossing);
                                    }
                                }
                            }
                        }
                    }
                    next = loop {
                        match stack.pop() {
                            Some((_, distance)) if distance > rank => {}
                            waiting => break waiting.map(|(child, _)| child),
                        }
                    };
                }
                let primitive = self.nodes.primitives.get(found_slot)?;
                Some(Found { primitive: *primitive, crossing: found })
            }

            $(#[$attribute])*
            pub(super) fn $blocks(&self, ray: &Ray, from: &Origin, to: &Origin) -> bool {
                let near = NEAR_END / ray.direction.length().max(f32::MIN_POSITIVE);
                let (first, last) = (BEFORE * near / NEAR_END, 1.0 - BEFORE * near / NEAR_END);
                let mut stack = Stack::<Child>::new();
                let mut next = (!self.nodes.nodes.is_empty()).then_some(Child::ROOT);
                while let Some(child) = next {
                    match child.what() {
                        Below::Node(node) => {
                            let node = &self.nodes.nodes[node];
                            let (entered, _) = enter(node, ray, first, last, |words| $signs(words));
                            for lane in entered {
                                stack.push(node.children[lane]);
                            }
                        }
                        Below::Block(block) => {
                            let crossings = ray.cross(&self.nodes.blocks[block], |words| $signs(words));
                            for lane in crossings.lanes {
                                let t = crossings.t[lane];
                                if t > last || t < first {
                                    continue;
                                }
                                let plain = t > near && t < 1.0 - near;
                                if plain || self.parts(ray, from, to, block * LANES + lane, &crossings.lane(lane)) {
                                    return true;
                                }
                            }
                        }
                    }
                    next = stack.pop();
                }
                false
            }
        }
    };
}

walks!(signs_portable, closest_portable, blocks_portable);
#[cfg(target_arch = "x86_64")]
walks!(
    #[target_feature(enable = "avx2,fma,popcnt,lzcnt,bmi1,bmi2")]
    signs_avx2,
    closest_avx2,
    blocks_avx2
);

#[cfg(target_arch = "x86_64")]
fn has_avx2() -> bool {
    is_x86_feature_detected!("avx2")
        && is_x86_feature_detected!("fma")
        && is_x86_feature_detected!("popcnt")
        && is_x86_feature_detected!("lzcnt")
        && is_x86_feature_detected!("bmi1")
        && is_x86_feature_detected!("bmi2")
}

/// The waiting entries of a walk.
struct Stack<T> {
    waiting: [MaybeUninit<T>; STACK],
    count: usize,
}

impl<T: Copy> Stack<T> {
    #[inline(always)]
    fn new() -> Stack<T> {
        Stack { waiting: [const { MaybeUninit::uninit() }; STACK], count: 0 }
    }

    #[inline(always)]
    fn push(&mut self, one: T) {
        self.waiting[self.count].write(one);
        self.count += 1;
    }

    #[inline(always)]
    fn pop(&mut self) -> Option<T> {
        self.count = self.count.checked_sub(1)?;
        Some(self.at(self.count))
    }

    #[inline(always)]
    fn at(&self, place: usize) -> T {
        // SAFETY: all entries below the count have been written, and this is one of them or was written just now.
        unsafe { self.waiting[place].assume_init() }
    }
}

impl Stack<(Child, f32)> {
    /// Pushes a child below the nearer ones. It does not move below position `after`.
    #[inline(always)]
    fn push_sorted(&mut self, after: usize, one: (Child, f32)) {
        let mut place = self.count;
        while place > after && self.at(place - 1).1 < one.1 {
            self.waiting[place] = self.waiting[place - 1];
            place -= 1;
        }
        self.waiting[place].write(one);
        self.count += 1;
    }
}

/// Returns which boxes of a node the ray enters between two distances, and at which distances. `signs` gathers the top bits of eight words.
#[inline(always)]
fn enter(
    node: &WideNode,
    ray: &Ray,
    first: f32,
    last: f32,
    signs: impl Fn(&[u32; LANES]) -> u32,
) -> (Lanes, [f32; LANES]) {
    let (mut enters, mut leaves) = ([first; LANES], [last; LANES]);
    for axis in 0..3 {
        let (near, far) = (&node.planes[2 * axis + ray.near[axis]], &node.planes[2 * axis + 1 - ray.near[axis]]);
        let (origin, inverse) = (ray.origin[axis], ray.inverse[axis]);
        for lane in 0..LANES {
            let (near, far) = ((near[lane] - origin) * inverse, (far[lane] - origin) * inverse);
            enters[lane] = if near > enters[lane] { near } else { enters[lane] };
            leaves[lane] = if far < leaves[lane] { far } else { leaves[lane] };
        }
    }
    let mut entered = [0; LANES];
    for lane in 0..LANES {
        entered[lane] = if enters[lane] <= leaves[lane] { u32::MAX } else { 0 };
    }
    (Lanes(signs(&entered)), enters)
}

/// Returns the top bits of eight words; that of the first word is the lowest bit.
#[inline(always)]
fn signs_portable(words: &[u32; LANES]) -> u32 {
    words.iter().rev().fold(0, |signs, word| signs << 1 | word >> 31)
}

/// Does the same with one vector instruction.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
#[inline]
fn signs_avx2(words: &[u32; LANES]) -> u32 {
    use std::arch::x86_64::{_mm256_castsi256_ps, _mm256_loadu_si256, _mm256_movemask_ps};
    // SAFETY: the pointer is valid for eight words of four bytes.
    let words = unsafe { _mm256_loadu_si256(words.as_ptr().cast()) };
    _mm256_movemask_ps(_mm256_castsi256_ps(words)) as u32
}
