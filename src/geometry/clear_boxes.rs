//! Boxes with nothing inside, as the space above the desks of an office. Two points in the same box see each other, so no ray is traced.
//!
//! Sight lines show where light passes. From the middle of some of them boxes grow until something stops them, one axis after the other, in
//! all six orders. A few of these boxes are kept, those that hold both ends of the most sight lines.

use arrayvec::ArrayVec;
use glam::{DVec3, Vec3A};

use super::origin::{LIFT, Origin, RESOLUTION};
use super::tree::Tree;

/// Number of sight lines from whose middles boxes grow.
const SEEDS: usize = 16;
/// Largest number of boxes, and the share of the sight lines that each must add.
const MOST_BOXES: usize = 8;
const LEAST_GAIN: f64 = 0.08;
/// Half of the edge of the cube that a box grows from, in scaled coordinates.
const FIRST: f64 = 1.0 / (1u32 << 9) as f64;
/// Largest number of balls and smooth bodies. Each of them is compared with every box that grows.
const MOST_ROUND: usize = 64;
/// Distance by which an origin is moved along its normal, and margin of a box that it must then keep. A point that was lifted off the side
/// of a box keeps it, a point that faces the side does not.
const MARGIN: f32 = 2.0 * LIFT as f32;
/// Cosine above which a surface counts as parallel to a face of a box.
const PARALLEL: f64 = 0.999;
/// The orders in which boxes grow along the axes.
const ORDERS: [[usize; 3]; 6] = [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]];
/// The boxes of a scene.
#[derive(Default)]
pub(super) struct ClearBoxes {
    boxes: ArrayVec<[Vec3A; 2], MOST_BOXES>,
}

/// A box in f64.
#[derive(Clone, Copy)]
struct Region {
    low: DVec3,
    high: DVec3,
}

impl ClearBoxes {
    /// Finds the boxes of a scene. `left` holds the ends of sight lines, in an order that visits all parts of the scene again and again.
    pub fn of(tree: &Tree, mut left: Vec<[Origin; 2]>) -> ClearBoxes {
        if tree.balls.len() + tree.bodies.len() > MOST_ROUND {
            return ClearBoxes::default();
        }
        let middles = left.iter().take(SEEDS).map(|[from, to]| 0.5 * (from.point + to.point).as_dvec3());
        let mut grown: Vec<Region> = middles.flat_map(|middle| boxes_around(tree, middle)).collect();
        let least = (LEAST_GAIN * left.len() as f64).max(1.0);
        let mut boxes = ArrayVec::new();
        while !boxes.is_full() {
            let gain = |one: &Region| left.iter().filter(|line| hold_both(&one.with_margin(), line)).count();
            let best = grown.iter().map(gain).enumerate().max_by_key(|(_, gain)| *gain);
            let Some((best, _)) = best.filter(|(_, gain)| *gain as f64 >= least) else {
                break;
            };
            let one = grown.swap_remove(best).off_covered_faces(tree).with_margin();
            left.retain(|line| !hold_both(&one, line));
            boxes.push(one);
        }
        ClearBoxes { boxes }
    }

    /// Whether both origins certainly lie in the same box.
    #[inline]
    pub fn hold(&self, from: &Origin, to: &Origin) -> bool {
        self.boxes.iter().any(|one| holds(one, from) && holds(one, to))
    }
}

fn hold_both(one: &[Vec3A; 2], [from, to]: &[Origin; 2]) -> bool {
    holds(one, from) && holds(one, to)
}

#[inline]
fn holds(one: &[Vec3A; 2], origin: &Origin) -> bool {
    let off = origin.point + MARGIN * Vec3A::from(origin.normal);
    (off.cmpge(one[0]) & off.cmple(one[1])).all()
}

/// Returns the boxes that grow from a place.
fn boxes_around(tree: &Tree, middle: DVec3) -> ArrayVec<Region, 6> {
    let first = Region { low: middle - FIRST, high: middle + FIRST };
    if first.first_met(tree, 0, true).is_some() {
        return ArrayVec::new();
    }
    ORDERS.iter().map(|order| first.grown(tree, order)).collect()
}

impl Region {
    /// Returns the box after it has grown along the axes in this order.
    fn grown(mut self, tree: &Tree, order: &[usize; 3]) -> Region {
        for axis in *order {
            for up in [false, true] {
                let mut ahead = self.inset(RESOLUTION);
                if up {
                    (ahead.low[axis], ahead.high[axis]) = (self.high[axis], 1.0);
                    self.high[axis] = ahead.first_met(tree, axis, true).unwrap_or(1.0);
                } else {
                    (ahead.low[axis], ahead.high[axis]) = (-1.0, self.low[axis]);
                    self.low[axis] = ahead.first_met(tree, axis, false).unwrap_or(-1.0);
                }
            }
        }
        self
    }

    /// Returns the coordinate at which a plane that moves through the region along an axis first meets something.
    fn first_met(mut self, tree: &Tree, axis: usize, up: bool) -> Option<f64> {
        let mut first = None;
        let mut meet = |region: &mut Region, low: f64, high: f64| {
            if up {
                region.high[axis] = low.max(region.low[axis]);
            } else {
                region.low[axis] = high.min(region.high[axis]);
            }
            first = Some(if up { region.high[axis] } else { region.low[axis] });
        };
        for around in tree.round_boxes() {
            if around[0].cmplt(self.high).all() && around[1].cmpgt(self.low).all() {
                meet(&mut self, around[0][axis], around[1][axis]);
            }
        }
        tree.for_each_within(self.low, self.high, |low, high, slot| {
            let mut region = Region { low: *low, high: *high };
            let piece = region.piece(slot.corners());
            let along = || piece.iter().map(|corner| corner[axis]);
            if !piece.is_empty() {
                meet(&mut region, along().fold(f64::INFINITY, f64::min), along().fold(f64::NEG_INFINITY, f64::max));
                (*low, *high) = (region.low, region.high);
            }
        });
        first
    }

    /// Returns the corners of the part of a triangle that lies in the region.
    fn piece(&self, corners: [DVec3; 3]) -> ArrayVec<DVec3, 9> {
        let [a, b, c] = corners;
        if a.max(b).max(c).cmplt(self.low).any() || a.min(b).min(c).cmpgt(self.high).any() {
            return ArrayVec::new();
        }
        let mut piece: ArrayVec<DVec3, 9> = ArrayVec::from_iter(corners);
        for axis in 0..3 {
            for (limit, sign) in [(self.low[axis], 1.0), (self.high[axis], -1.0)] {
                let height = |corner: DVec3| sign * (corner[axis] - limit);
                let whole = std::mem::take(&mut piece);
                for (place, corner) in whole.iter().enumerate() {
                    let before = whole[(place + whole.len() - 1) % whole.len()];
                    let (one, other) = (height(before), height(*corner));
                    if (one < 0.0) != (other < 0.0) {
                        piece.push(before + one / (one - other) * (*corner - before));
                    }
                    if other >= 0.0 {
                        piece.push(*corner);
                    }
                }
            }
        }
        piece
    }

    /// Returns the box with faces moved inwards where surfaces lie behind one another. Points that were lifted off the surface behind then
    /// are not in it.
    fn off_covered_faces(self, tree: &Tree) -> Region {
        let depth = 2.0 * f64::from(MARGIN);
        let mut off = self;
        for axis in 0..3 {
            let mut face = self.inset(f64::from(MARGIN));
            (face.low[axis], face.high[axis]) = (self.low[axis] - depth, self.low[axis] + RESOLUTION);
            if !face.is_one_surface(tree, axis) {
                off.low[axis] += depth;
            }
            (face.low[axis], face.high[axis]) = (self.high[axis] - RESOLUTION, self.high[axis] + depth);
            if !face.is_one_surface(tree, axis) {
                off.high[axis] -= depth;
            }
        }
        off
    }

    /// Returns the corners of the part of the box that origins must lie in.
    fn with_margin(self) -> [Vec3A; 2] {
        let inset = self.inset(f64::from(MARGIN));
        [inset.low.as_vec3a(), inset.high.as_vec3a()]
    }

    /// Whether all surfaces in a thin region across an axis that are parallel to it lie in one plane.
    fn is_one_surface(&self, tree: &Tree, axis: usize) -> bool {
        let mut one = None;
        let mut alike = true;
        tree.for_each_within(self.low, self.high, |low, high, slot| {
            let [a, b, c] = slot.corners();
            if (b - a).cross(c - a).normalize_or_zero()[axis].abs() < PARALLEL {
                return;
            }
            if let Some(corner) = (Region { low: *low, high: *high }).piece([a, b, c]).first() {
                alike &= (corner[axis] - *one.get_or_insert(corner[axis])).abs() <= RESOLUTION;
            }
        });
        alike
    }

    /// Returns the region without a strip along its faces.
    fn inset(self, strip: f64) -> Region {
        Region { low: self.low + strip, high: self.high - strip }
    }
}
