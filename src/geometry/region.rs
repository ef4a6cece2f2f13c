//! A box along the axes, in f64, and the parts of triangles in it.

use arrayvec::ArrayVec;
use glam::DVec3;

/// Largest number of corners of a triangle's part in a box: each of six faces may add one.
const MOST_CORNERS: usize = 9;

/// The box between two corners.
#[derive(Clone, Copy)]
pub(super) struct Region {
    pub low: DVec3,
    pub high: DVec3,
}

impl Region {
    /// Returns the box that contains the points, if there are any.
    pub fn around(points: &[DVec3]) -> Option<Region> {
        let low = points.iter().copied().reduce(DVec3::min)?;
        let high = points.iter().copied().reduce(DVec3::max)?;
        Some(Region { low, high })
    }

    /// Whether two boxes have a point in common.
    pub fn overlaps(&self, other: &Region) -> bool {
        self.low.cmple(other.high).all() && self.high.cmpge(other.low).all()
    }

    /// Returns the box without a strip along its faces.
    pub fn inset(self, strip: f64) -> Region {
        Region { low: self.low + strip, high: self.high - strip }
    }

    /// Returns the corners of the part of a triangle that lies in the box.
    pub fn part_of(&self, corners: [DVec3; 3]) -> ArrayVec<DVec3, MOST_CORNERS> {
        if !Region::around(&corners).is_some_and(|around| self.overlaps(&around)) {
            return ArrayVec::new();
        }
        let mut part = ArrayVec::from_iter(corners);
        for axis in 0..3 {
            part = clipped(&part, |corner| corner[axis] - self.low[axis]);
            part = clipped(&part, |corner| self.high[axis] - corner[axis]);
        }
        part
    }
}

/// Returns the corners of the part of a convex polygon whose points have no negative height (Sutherland and Hodgman 1974).
fn clipped(polygon: &[DVec3], height: impl Fn(DVec3) -> f64) -> ArrayVec<DVec3, MOST_CORNERS> {
    let mut part = ArrayVec::new();
    for (place, corner) in polygon.iter().enumerate() {
        let before = polygon[(place + polygon.len() - 1) % polygon.len()];
        let (one, other) = (height(before), height(*corner));
        if (one < 0.0) != (other < 0.0) {
            part.push(before + one / (one - other) * (*corner - before));
        }
        if other >= 0.0 {
            part.push(*corner);
        }
    }
    part
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_part_of_a_triangle_has_the_area_that_lies_in_the_box() {
        // The triangle x + y ≤ 1.5 at half height: a corner of the unit square, an eighth of its area, is missing.
        let region = Region { low: DVec3::ZERO, high: DVec3::ONE };
        let triangle = |height: f64| [[0.0, 0.0], [1.5, 0.0], [0.0, 1.5]].map(|[x, y]| DVec3::new(x, y, height));
        let part = region.part_of(triangle(0.5));
        let doubled: DVec3 = (1..part.len() - 1).map(|k| (part[k] - part[0]).cross(part[k + 1] - part[0])).sum();
        assert!((0.5 * doubled.z - 0.875).abs() < 1e-15, "{part:?}");
        assert!(region.part_of(triangle(1.5)).is_empty() && region.part_of(triangle(1.0)).len() > 2);
    }
}
