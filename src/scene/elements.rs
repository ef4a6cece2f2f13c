//! The elements of a scene: every triangle cut into `n²` congruent parts, numbered in one line.
//!
//! Rays meet the triangle as given; the element follows from where in the triangle they hit, so that no splitting
//! opens a crack or changes a path.

use glam::DVec3;

use super::{Scene, SurfaceId};

/// A side of a surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Side {
    /// The side that the normal points to.
    Front,
    /// The other side.
    Back,
}

impl Side {
    /// The other one.
    #[inline]
    pub fn other(self) -> Side {
        match self {
            Side::Front => Side::Back,
            Side::Back => Side::Front,
        }
    }

    /// Name as tables write it.
    pub fn name(self) -> &'static str {
        match self {
            Side::Front => "front",
            Side::Back => "back",
        }
    }
}

/// Numbers every element side ("cell") of a scene: triangle by triangle, front cells first, then the back cells of
/// two-sided surfaces.
#[derive(Clone, Debug)]
pub struct Elements {
    first_cell: Vec<u32>,
    divisions: Vec<u32>,
    two_sided: Vec<bool>,
}

/// One element side: where it is and what it belongs to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cell {
    /// Triangle of the scene.
    pub triangle: u32,
    /// Number within the triangle, 0 to n² − 1.
    pub part: u32,
    /// Front or back.
    pub side: Side,
}

impl Elements {
    /// Numbers the elements of a scene.
    pub fn of(scene: &Scene) -> Elements {
        let two_sided: Vec<bool> =
            (0..scene.triangles.len()).map(|triangle| scene.surface_of(triangle as u32).two_sided).collect();
        let mut first_cell = Vec::with_capacity(scene.triangles.len() + 1);
        let mut next = 0u32;
        for (divisions, two_sided) in scene.divisions.iter().zip(&two_sided) {
            first_cell.push(next);
            next += divisions * divisions * if *two_sided { 2 } else { 1 };
        }
        first_cell.push(next);
        Elements { first_cell, divisions: scene.divisions.clone(), two_sided }
    }

    /// Number of cells (element sides).
    pub fn len(&self) -> usize {
        self.first_cell[self.first_cell.len() - 1] as usize
    }

    /// Whether there is no cell at all.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The cell in which a triangle was hit at barycentric coordinates `(u, v)` (weights of its second and third
    /// corner), or `None` for the back of a one-sided surface.
    #[inline]
    pub fn cell_at(&self, triangle: u32, [u, v]: [f64; 2], side: Side) -> Option<u32> {
        let index = triangle as usize;
        let divisions = self.divisions[index];
        let skip = match side {
            Side::Front => 0,
            Side::Back if self.two_sided[index] => divisions * divisions,
            Side::Back => return None,
        };
        Some(self.first_cell[index] + skip + part_at(divisions, u, v))
    }

    /// What a cell number stands for.
    pub fn cell(&self, cell: u32) -> Cell {
        let triangle = self.first_cell.partition_point(|first| *first <= cell) - 1;
        let parts = self.divisions[triangle] * self.divisions[triangle];
        let local = cell - self.first_cell[triangle];
        Cell {
            triangle: triangle as u32,
            part: local % parts,
            side: if local < parts { Side::Front } else { Side::Back },
        }
    }

    /// The same part of the triangle on its other side; `None` where that is not reported.
    pub fn opposite(&self, cell: u32) -> Option<u32> {
        let Cell { triangle, side, .. } = self.cell(cell);
        let parts = self.divisions[triangle as usize] * self.divisions[triangle as usize];
        match side {
            Side::Front => self.two_sided[triangle as usize].then_some(cell + parts),
            Side::Back => Some(cell - parts),
        }
    }

    /// The cells of a triangle, both sides.
    pub fn cells_of_triangle(&self, triangle: u32) -> std::ops::Range<u32> {
        self.first_cell[triangle as usize]..self.first_cell[triangle as usize + 1]
    }

    /// Cells of a surface, both sides.
    pub fn cells_of_surface(&self, scene: &Scene, surface: SurfaceId) -> std::ops::Range<u32> {
        let triangles = &scene.surfaces[surface as usize].triangles;
        self.first_cell[triangles.start as usize]..self.first_cell[triangles.end as usize]
    }

    /// Barycentric coordinates `(u, v)` of the three corners of a part of a triangle.
    pub fn part_corners(&self, triangle: u32, part: u32) -> [[f64; 2]; 3] {
        part_corners(self.divisions[triangle as usize], part)
    }

    /// Corners of a cell in m, turned like its triangle's front.
    pub fn corners_m(&self, scene: &Scene, cell: Cell) -> [DVec3; 3] {
        let [a, b, c] = scene.corners_m(cell.triangle);
        self.part_corners(cell.triangle, cell.part).map(|[u, v]| a + u * (b - a) + v * (c - a))
    }

    /// Area of a cell in m².
    pub fn area_m2(&self, scene: &Scene, cell: Cell) -> f64 {
        let divisions = f64::from(self.divisions[cell.triangle as usize]);
        scene.triangle_area_m2(cell.triangle) / (divisions * divisions)
    }
}

/// Parts are numbered in rows of constant v: row `j` has `2(n − j) − 1` parts, upright and upside-down in turn.
#[inline]
pub(super) fn part_at(divisions: u32, u: f64, v: f64) -> u32 {
    if divisions == 1 {
        return 0;
    }
    let n = f64::from(divisions);
    let row = ((v * n) as u32).min(divisions - 1);
    let column = ((u * n) as u32).min(divisions - 1 - row);
    let upside_down = column < divisions - 1 - row && (u * n - f64::from(column)) + (v * n - f64::from(row)) > 1.0;
    row * (2 * divisions - row) + 2 * column + u32::from(upside_down)
}

pub(super) fn part_corners(divisions: u32, part: u32) -> [[f64; 2]; 3] {
    let mut row = 0;
    let mut first = 0;
    while first + 2 * (divisions - row) - 1 <= part {
        first += 2 * (divisions - row) - 1;
        row += 1;
    }
    let column = (part - first) / 2;
    let at = |i: u32, j: u32| [f64::from(i) / f64::from(divisions), f64::from(j) / f64::from(divisions)];
    if (part - first).is_multiple_of(2) {
        [at(column, row), at(column + 1, row), at(column, row + 1)]
    } else {
        [at(column + 1, row + 1), at(column, row + 1), at(column + 1, row)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_part_holds_its_own_centroid_and_has_the_same_area_and_turn() {
        for divisions in [1, 2, 3, 7, 40] {
            for part in 0..divisions * divisions {
                let [a, b, c] = part_corners(divisions, part);
                let centroid = [(a[0] + b[0] + c[0]) / 3.0, (a[1] + b[1] + c[1]) / 3.0];
                assert_eq!(part_at(divisions, centroid[0], centroid[1]), part, "{divisions} divisions");
                let twice_area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
                let expected = 1.0 / f64::from(divisions * divisions);
                assert!((twice_area - expected).abs() < 1e-12 * expected.max(1e-3), "{twice_area} {expected}");
            }
        }
    }

    #[test]
    fn the_rim_of_a_triangle_belongs_to_its_parts() {
        for (u, v) in [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (0.5, 0.5), (0.999_999_999, 1e-10)] {
            assert!(part_at(5, u, v) < 25);
        }
    }
}
