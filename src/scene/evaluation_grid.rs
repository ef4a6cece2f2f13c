//! The grid on a surface that gives its least and greatest illuminance and its uniformities.
//!
//! EN 12464-1 gives the distance of the grid points. Each point stands for a cell about it. The illuminance there is the mean over the
//! part of the surface that lies in the cell. So these numbers do not depend on how finely a surface is cut.

use super::elements::{Elements, Side};
use super::model::{Scene, SurfaceId};
use super::surface_grid::{PointSpacing, Rectangle};

/// Most cells of a grid. A surface that needs more is as thin as a thread and has no grid.
const MOST_CELLS: f64 = 100_000.0;
/// Largest element as a share of a cell. Larger elements smooth out differences between cells.
const LARGEST_ELEMENT: f64 = 0.25;
/// Least share of a cell's area that must be visible surface for the cell to count.
const LEAST_FILLED: f64 = 0.5;
/// Least part of a cell, as a share of it. A smaller part is rounding.
const LEAST_PART: f64 = 1e-9;

/// The part of an element that lies in a cell of a grid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GridPart {
    /// Number of the element side.
    pub element: u32,
    /// Visible area in m².
    pub area_m2: f64,
    /// Factor from the mean illuminance of the element to that of its visible part.
    pub scale: f64,
    /// Centroid of the part in the element: the weights of the second and third corner.
    pub at: [f64; 2],
}

/// The cells of a grid that count, each as a list of element parts.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct EvaluationGrid {
    /// Parts of every cell.
    pub cells: Vec<Vec<GridPart>>,
    /// Area of a whole cell in m².
    pub cell_m2: f64,
    /// Whether an element in a cell that counts is larger than a quarter of a cell.
    pub is_finer_than_elements: bool,
}

impl EvaluationGrid {
    /// Removes the cells of which less than half is visible.
    pub fn leave_out_contact(&mut self) {
        let least_m2 = LEAST_FILLED * self.cell_m2;
        self.cells.retain(|parts| shown_m2(parts) >= least_m2);
    }
}

/// Visible area in m² of the parts of a cell.
fn shown_m2(parts: &[GridPart]) -> f64 {
    parts.iter().map(|part| part.area_m2).sum()
}

/// Limit of the size of elements in a grid.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ElementSizes {
    /// No limit. The grid reports whether elements are larger than a quarter of a cell.
    Any,
    /// Up to a quarter of a cell. The search stops at the first cell within a larger element. This saves the grids of, say, ten thousand
    /// panes of two elements each.
    Fine,
}

/// Makes the grid of EN 12464-1 on one side of a flat surface, its cells filled with the parts of the elements in them.
///
/// `contact_free` returns two numbers for an element side: its visible share, and the factor from its mean to that of its visible part.
/// Returns `None` if the surface is not flat, has fewer than two rows or columns of cells or more than `MOST_CELLS` cells, has no cell of
/// which half is visible, or has elements larger than `sizes` allows.
pub fn evaluation_grid(
    scene: &Scene,
    elements: &Elements,
    surface: SurfaceId,
    side: Side,
    contact_free: impl Fn(u32) -> (f64, f64),
    sizes: ElementSizes,
) -> Option<EvaluationGrid> {
    let triangles = &scene.triangles[scene.surfaces[surface as usize].triangles.start as usize
        ..scene.surfaces[surface as usize].triangles.end as usize];
    let (rectangle, _) = Rectangle::around(&scene.vertices_m, triangles).ok()?;
    let [columns, rows] = rectangle.counts(PointSpacing::En12464);
    if columns < 2.0 || rows < 2.0 || columns * rows > MOST_CELLS {
        return None;
    }
    let [long_m, short_m] = rectangle.sides_m();
    let cell_m2 = long_m * short_m / (columns * rows);
    let counts = [columns as usize, rows as usize];
    let mut cells = vec![Vec::new(); counts[0] * counts[1]];
    let mut large = vec![false; cells.len()];
    for number in elements.of_surface(scene, surface) {
        let element = elements.element(number);
        let area_m2 = elements.area_m2(scene, element);
        if element.side != side {
            continue;
        }
        let (contact_free_share, scale) = contact_free(number);
        if contact_free_share <= 0.0 {
            continue;
        }
        // In units of the grid's cells.
        let corners = elements.corners_m(scene, element).map(|corner_m| {
            let [x, y] = rectangle.place(corner_m);
            [x * columns, y * rows]
        });
        let range = |axis: usize| {
            let (low, high) = corners
                .iter()
                .fold((f64::MAX, f64::MIN), |(low, high), spot| (low.min(spot[axis]), high.max(spot[axis])));
            (low.max(0.0) as usize)..(high.ceil().max(0.0) as usize).min(counts[axis])
        };
        for row in range(1) {
            for column in range(0) {
                let Some((share, middle)) = overlap(corners, [column as f64, row as f64]) else { continue };
                let index = row * counts[0] + column;
                let part = GridPart {
                    element: number,
                    area_m2: share * cell_m2 * contact_free_share,
                    scale,
                    at: weights_of(corners, middle),
                };
                let is_large = area_m2 > LARGEST_ELEMENT * cell_m2 * (1.0 + 1e-6);
                if is_large && sizes == ElementSizes::Fine && part.area_m2 >= LEAST_FILLED * cell_m2 {
                    return None;
                }
                cells[index].push(part);
                large[index] |= is_large;
            }
        }
    }
    let kept: Vec<usize> =
        (0..cells.len()).filter(|index| shown_m2(&cells[*index]) >= LEAST_FILLED * cell_m2).collect();
    let is_finer_than_elements = kept.iter().any(|index| large[*index]);
    let cells: Vec<Vec<GridPart>> = kept.into_iter().map(|index| std::mem::take(&mut cells[index])).collect();
    let is_wanted = !cells.is_empty() && (sizes == ElementSizes::Any || !is_finer_than_elements);
    is_wanted.then_some(EvaluationGrid { cells, cell_m2, is_finer_than_elements })
}

/// Most corners of a triangle after four cuts along lines: 7, and some more for rounding.
const MOST_CORNERS: usize = 12;

/// A convex polygon with few corners.
#[derive(Clone, Copy, Default)]
struct ConvexCorners {
    corners: [[f64; 2]; MOST_CORNERS],
    len: usize,
}

impl ConvexCorners {
    fn add(&mut self, spot: [f64; 2]) {
        // Rounding can make a line cross a convex polygon more than twice, if it nearly runs along a side.
        if self.len < MOST_CORNERS {
            self.corners[self.len] = spot;
            self.len += 1;
        }
    }

    fn corners(&self) -> &[[f64; 2]] {
        &self.corners[..self.len]
    }
}

/// Returns the area of a triangle within the unit square at `low`, and the centroid of that part; `None` if they do not overlap.
///
/// The triangle is cut along the four sides of the square, one after the other (Sutherland and Hodgman 1974).
pub(super) fn overlap(corners: [[f64; 2]; 3], low: [f64; 2]) -> Option<(f64, [f64; 2])> {
    let mut ring = ConvexCorners::default();
    corners.iter().for_each(|[x, y]| ring.add([x - low[0], y - low[1]]));
    for (axis, sign, limit) in [(0, 1.0, 0.0), (0, -1.0, -1.0), (1, 1.0, 0.0), (1, -1.0, -1.0)] {
        let inside = |spot: &[f64; 2]| sign * spot[axis] - limit;
        let mut cut = ConvexCorners::default();
        for (index, here) in ring.corners().iter().enumerate() {
            let before = &ring.corners[(index + ring.len - 1) % ring.len];
            let (depth, depth_before) = (inside(here), inside(before));
            if (depth < 0.0) != (depth_before < 0.0) {
                let share = depth_before / (depth_before - depth);
                cut.add([0, 1].map(|k| before[k] + share * (here[k] - before[k])));
            }
            if depth >= 0.0 {
                cut.add(*here);
            }
        }
        ring = cut;
    }
    let [first, rest @ ..] = ring.corners() else { return None };
    let (mut area, mut moment) = (0.0, [0.0; 2]);
    for pair in rest.windows(2) {
        let [p, q] = [pair[0], pair[1]].map(|spot| [spot[0] - first[0], spot[1] - first[1]]);
        let part = 0.5 * (p[0] * q[1] - p[1] * q[0]).abs();
        area += part;
        (0..2).for_each(|k| moment[k] += part * (p[k] + q[k]) / 3.0);
    }
    (area > LEAST_PART).then(|| (area, [0, 1].map(|k| low[k] + first[k] + moment[k] / area)))
}

/// Weights of the second and third corner of a triangle at a point of its plane.
fn weights_of([a, b, c]: [[f64; 2]; 3], spot: [f64; 2]) -> [f64; 2] {
    let [p, q, r] = [b, c, spot].map(|to| [to[0] - a[0], to[1] - a[1]]);
    let twice_area = p[0] * q[1] - p[1] * q[0];
    [(r[0] * q[1] - r[1] * q[0]) / twice_area, (p[0] * r[1] - p[1] * r[0]) / twice_area]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grid(edge_m: &str, u: &str, v: &str) -> (Scene, Option<EvaluationGrid>) {
        let text = format!(
            r#"{{ "version": 1, "materials": {{ "m": {{ "type": "diffuse", "reflectance": 0.5 }} }},
            "geometry": [ {{ "name": "table", "type": "rectangle", "origin": [1,2,0], "u": {u}, "v": {v}, "material": "m"{edge_m} }} ],
            "luminaires": [ {{ "name": "lamp", "type": "point", "position": [2,1,0.9], "intensity_cd": 1 }} ] }}"#
        );
        let scene = crate::scene_from_json(&text, None, std::path::Path::new(".")).expect("the table is valid");
        let elements = Elements::of(&scene);
        let grid = evaluation_grid(&scene, &elements, 0, Side::Front, |_| (1.0, 1.0), ElementSizes::Any);
        (scene, grid)
    }

    /// Every cell is full, whatever the elements. The centroids of the parts are right: the mean over the parts of any linear function is
    /// that of the cell.
    #[test]
    fn cells_are_filled_by_the_parts_of_elements() {
        for edge_m in ["", r#", "max_element_edge": 0.31"#, r#", "max_element_edge": 0.07"#] {
            let (scene, grid) = grid(edge_m, "[3,0,0]", "[0,2,0]");
            let (grid, elements) = (grid.expect("a flat table"), Elements::of(&scene));
            assert_eq!(grid.is_finer_than_elements, edge_m.is_empty());
            // d = 3 m: 0.2·5^(log₁₀ 3) = 0.431 m.
            assert_eq!(grid.cells.len(), 7 * 5);
            for (index, parts) in grid.cells.iter().enumerate() {
                let area_m2: f64 = parts.iter().map(|part| part.area_m2).sum();
                assert!((area_m2 - 6.0 / 35.0).abs() < 1e-9, "{area_m2}");
                let mut middle_m = glam::DVec3::ZERO;
                for part in parts {
                    let [a, b, c] = elements.corners_m(&scene, elements.element(part.element));
                    middle_m += part.area_m2 / area_m2 * (a + part.at[0] * (b - a) + part.at[1] * (c - a));
                }
                let expected_m = glam::DVec3::new(
                    1.0 + 3.0 / 7.0 * ((index % 7) as f64 + 0.5),
                    2.0 + 0.4 * ((index / 7) as f64 + 0.5),
                    0.0,
                );
                assert!(middle_m.distance(expected_m) < 1e-9, "{middle_m} {expected_m}");
            }
        }
    }

    /// Too large elements are found at the first of them. Otherwise the grid is the same as without a limit.
    #[test]
    fn a_grid_finer_than_elements_is_given_up_at_once() {
        for (edge_m, is_fine) in [("", false), (r#", "max_element_edge": 0.31"#, true)] {
            let (scene, grid) = grid(edge_m, "[3,0,0]", "[0,2,0]");
            let elements = Elements::of(&scene);
            let asked = std::cell::Cell::new(0);
            let contact_free = |_| {
                asked.set(asked.get() + 1);
                (1.0, 1.0)
            };
            let fine = evaluation_grid(&scene, &elements, 0, Side::Front, contact_free, ElementSizes::Fine);
            assert_eq!(fine, grid.filter(|grid| !grid.is_finer_than_elements));
            assert_eq!((fine.is_some(), asked.get() > 1), (is_fine, is_fine));
        }
    }

    /// A tiny surface has no grid.
    #[test]
    fn a_surface_smaller_than_the_grid_has_none() {
        assert!(grid("", "[0.004,0,0]", "[0,0.004,0]").1.is_none());
        assert!(grid("", "[0.4,0,0]", "[0,0.4,0]").1.is_some());
    }

    /// Cells of which less than half is visible do not count: here half of the table, cut along its diagonal.
    #[test]
    fn covered_cells_do_not_count() {
        let (scene, _) = grid("", "[3,0,0]", "[0,2,0]");
        let elements = Elements::of(&scene);
        let one = |share: f64| {
            let contact_free = move |element: u32| (if element == 0 { 1.0 } else { share }, 1.0);
            evaluation_grid(&scene, &elements, 0, Side::Front, contact_free, ElementSizes::Any)
        };
        let full = one(1.0).map_or(0, |grid| grid.cells.len());
        let half = one(0.0).map_or(0, |grid| grid.cells.len());
        assert!(full == 35 && half > 15 && half < 22, "{full} {half}");
    }
}
