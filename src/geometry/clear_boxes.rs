//! Boxes with nothing inside, as the space above the desks of an office. Two points in the same box see each other, so no ray is traced.
//!
//! Sight lines show where light passes. From the middle of some of them boxes grow until something stops them, one axis after the other, in
//! all six orders. A few of these boxes are kept, those that hold both ends of the most sight lines.

use arrayvec::ArrayVec;
use glam::{DVec3, Vec3A};

use super::origin::{LIFT, Origin, RESOLUTION};
use super::region::Region;
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
/// Distance by which an origin is moved along its normal before it is compared with a box.
const ALONG_NORMAL: f32 = 2.0 * LIFT as f32;
/// Margin that it must then keep to the faces. A point that was lifted off a face keeps it. A point does not if it faces the face, or if
/// its surface lies behind the face by more than rounding.
const MARGIN: f64 = 3.0 * LIFT - RESOLUTION;
/// The orders in which boxes grow along the axes.
const ORDERS: [[usize; 3]; 6] = [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]];

/// The boxes of a scene.
#[derive(Default)]
pub(super) struct ClearBoxes {
    boxes: ArrayVec<ClearBox, MOST_BOXES>,
}

/// The corners between which origins must lie.
#[derive(Clone, Copy)]
struct ClearBox {
    low: Vec3A,
    high: Vec3A,
}

impl ClearBoxes {
    /// Finds the boxes of a scene. `left` holds the ends of sight lines; the first few of them visit all parts of the scene.
    pub fn of(tree: &Tree, mut left: Vec<[Origin; 2]>) -> ClearBoxes {
        if tree.balls.len() + tree.bodies.len() > MOST_ROUND {
            return ClearBoxes::default();
        }
        let middles = left.iter().take(SEEDS).map(|[from, to]| 0.5 * (from.point + to.point).as_dvec3());
        let grown: Vec<ClearBox> = middles.flat_map(|middle| boxes_around(tree, middle)).collect();
        let least = (LEAST_GAIN * left.len() as f64).max(1.0);
        let mut boxes = ArrayVec::new();
        while !boxes.is_full() {
            let gain = |one: &ClearBox| left.iter().filter(|[from, to]| one.holds(from) && one.holds(to)).count();
            let best = grown.iter().map(|one| (gain(one), one)).max_by_key(|(gain, _)| *gain);
            let Some((_, best)) = best.filter(|(gain, _)| *gain as f64 >= least) else {
                break;
            };
            left.retain(|[from, to]| !(best.holds(from) && best.holds(to)));
            boxes.push(*best);
        }
        ClearBoxes { boxes }
    }

    /// Whether both origins certainly lie in the same box.
    #[inline]
    pub fn hold(&self, from: &Origin, to: &Origin) -> bool {
        self.boxes.iter().any(|one| one.holds(from) && one.holds(to))
    }
}

impl ClearBox {
    fn of(region: Region) -> ClearBox {
        let inset = region.inset(MARGIN);
        ClearBox { low: inset.low.as_vec3a(), high: inset.high.as_vec3a() }
    }

    #[inline]
    fn holds(&self, origin: &Origin) -> bool {
        let off = origin.point + ALONG_NORMAL * Vec3A::from(origin.normal);
        (off.cmpge(self.low) & off.cmple(self.high)).all()
    }
}

/// Returns the boxes that grow from a place, one for each order of the axes.
fn boxes_around(tree: &Tree, middle: DVec3) -> ArrayVec<ClearBox, 6> {
    let first = Region { low: middle - FIRST, high: middle + FIRST };
    if first_met(tree, first, 0, true).is_some() {
        return ArrayVec::new();
    }
    ORDERS.iter().map(|order| ClearBox::of(grown(tree, first, order))).collect()
}

/// Returns the region after it has grown along the axes in this order, until surfaces or the end of the scene stop it.
fn grown(tree: &Tree, mut region: Region, order: &[usize; 3]) -> Region {
    for axis in *order {
        // Corners are rounded, so surfaces beside the region may reach into its rim.
        let beside = region.inset(RESOLUTION);
        let mut below = beside;
        (below.low[axis], below.high[axis]) = (-1.0, region.low[axis]);
        region.low[axis] = first_met(tree, below, axis, false).unwrap_or(-1.0);
        let mut above = beside;
        (above.low[axis], above.high[axis]) = (region.high[axis], 1.0);
        region.high[axis] = first_met(tree, above, axis, true).unwrap_or(1.0);
    }
    region
}

/// Returns the coordinate at which a plane that moves through a region along an axis, up or down, first meets something.
fn first_met(tree: &Tree, mut region: Region, axis: usize, up: bool) -> Option<f64> {
    let mut first = None;
    // What was met ends the region, so nothing behind it is visited.
    let mut meet = |region: &mut Region, met: Region| {
        if up {
            region.high[axis] = met.low[axis].max(region.low[axis]);
        } else {
            region.low[axis] = met.high[axis].min(region.high[axis]);
        }
        first = Some(if up { region.high[axis] } else { region.low[axis] });
    };
    for around in tree.round_boxes() {
        if around.overlaps(&region) {
            meet(&mut region, around);
        }
    }
    tree.for_each_within(region, |region, slot| {
        if let Some(met) = Region::around(&region.part_of(slot.corners())) {
            meet(region, met);
        }
    });
    first
}
