//! The regular mesh: positions of its points, and the cell of a position.

use glam::DVec3;

/// Limit for the points along the longest side of a mesh: each index fits in 20 bits.
const MOST_POINTS: f64 = (1u32 << 20) as f64;

/// A regular mesh of points over a box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lattice {
    /// The point (0, 0, 0) in m.
    pub origin_m: DVec3,
    /// Distance between neighbouring points in m.
    pub step_m: f64,
    /// Number of points along each axis.
    pub counts: [u32; 3],
}

/// Index of a point along the three axes.
pub type Index = [i32; 3];

impl Lattice {
    /// Creates a mesh that includes every point within `reach_m` of a box. The low faces of the box lie midway between two layers, so that
    /// walls at round coordinates do not run through points.
    ///
    /// `None` if one side would need more than a million points.
    pub fn over([low_m, high_m]: [DVec3; 2], step_m: f64, reach_m: f64) -> Option<Lattice> {
        let margin = (reach_m / step_m).ceil() + 1.0;
        let origin_m = low_m + (0.5 - margin) * step_m;
        let counts = ((high_m - low_m) / step_m).ceil() + 2.0 * margin + 1.0;
        (counts.max_element() < MOST_POINTS).then(|| Lattice {
            origin_m,
            step_m,
            counts: counts.to_array().map(|count| count as u32),
        })
    }

    /// Returns the number of points of the whole mesh, used or not.
    pub fn points(&self) -> f64 {
        self.counts.iter().map(|count| f64::from(*count)).product()
    }

    /// Returns the position of a point in m.
    #[inline]
    pub fn position_m(&self, index: Index) -> DVec3 {
        self.origin_m + self.step_m * DVec3::new(f64::from(index[0]), f64::from(index[1]), f64::from(index[2]))
    }

    /// Returns the cell of a position, as the index of its lowest point, and the position within the cell in steps, 0 to 1.
    #[inline]
    pub fn cell_of(&self, place_m: DVec3) -> (Index, DVec3) {
        let steps = (place_m - self.origin_m) / self.step_m;
        let floor = steps.floor();
        ([floor.x as i32, floor.y as i32, floor.z as i32], steps - floor)
    }

    /// Whether the mesh includes this point.
    #[inline]
    pub fn contains(&self, index: Index) -> bool {
        (0..3).all(|axis| (index[axis] as u32) < self.counts[axis])
    }

    /// Returns a unique number for every point.
    #[inline]
    pub fn key(&self, [i, j, k]: Index) -> u64 {
        (u64::from(k as u32) << 40) | (u64::from(j as u32) << 20) | u64::from(i as u32)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_place_lies_in_its_cell_and_all_within_reach_are_points_of_the_mesh() {
        let lattice =
            Lattice::over([DVec3::new(-1.0, 0.0, 2.0), DVec3::new(3.0, 5.0, 2.0)], 0.25, 0.8).expect("a small mesh");
        for place_m in [DVec3::new(-1.0, 0.0, 2.0), DVec3::new(3.0, 5.0, 2.0), DVec3::new(0.3, 4.1, 2.0)] {
            let (cell, rest) = lattice.cell_of(place_m);
            assert!((lattice.position_m(cell) + 0.25 * rest).distance(place_m) < 1e-12);
            let reach = (0.8f64 / 0.25).ceil() as i32;
            assert!(lattice.contains(cell.map(|i| i - reach)) && lattice.contains(cell.map(|i| i + 1 + reach)));
        }
        assert!(Lattice::over([DVec3::ZERO, DVec3::ONE], 1e-9, 1e-9).is_none());
    }
}
