//! Sides of triangles, to be drawn in proportion to their areas.

use crate::scene::{Scene, Side};

/// Side of a triangle.
pub type TriangleSide = (u32, Side);

/// Some sides of triangles and their areas.
pub struct SidesByArea<'a> {
    sides: &'a [TriangleSide],
    /// Sum of the areas in m² up to and including each side.
    cumulative_m2: Vec<f64>,
}

impl SidesByArea<'_> {
    /// Sums up the areas of some sides, at least one.
    pub fn of<'a>(scene: &Scene, sides: &'a [TriangleSide]) -> SidesByArea<'a> {
        let sums_m2 = sides.iter().scan(0.0, |sum_m2, (triangle, _)| {
            *sum_m2 += scene.triangle_area_m2(*triangle);
            Some(*sum_m2)
        });
        SidesByArea { sides, cumulative_m2: sums_m2.collect() }
    }

    /// The side at a share in [0, 1) of the whole area.
    pub fn at(&self, share: f64) -> TriangleSide {
        let last = self.sides.len() - 1;
        let aim_m2 = share * self.cumulative_m2[last];
        self.sides[self.cumulative_m2.partition_point(|sum_m2| *sum_m2 <= aim_m2).min(last)]
    }
}
