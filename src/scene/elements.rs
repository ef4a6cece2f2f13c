//! The elements of a scene: every triangle is cut into `n²` congruent parts, numbered in one sequence.
//!
//! Rays meet the triangle as given. The element follows from the point in the triangle that a ray hits. Cutting therefore opens no crack
//! and changes no path.

use glam::DVec3;
use serde::{Deserialize, Serialize};

use super::bodies::body_of;
pub use super::leaves::MOST_CUTS;
use super::leaves::{Leaves, UNCUT, corners_of, cuts_of};
use super::{Scene, SurfaceId};

/// A side of a surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum Side {
    /// The side that the normal points to.
    Front,
    /// The other side.
    Back,
}

impl Side {
    /// The sides of a surface that reflect and are reported.
    pub fn of_surface(two_sided: bool) -> &'static [Side] {
        if two_sided { &[Side::Front, Side::Back] } else { &[Side::Front] }
    }

    /// Returns the opposite side.
    #[inline]
    pub fn other(self) -> Side {
        match self {
            Side::Front => Side::Back,
            Side::Back => Side::Front,
        }
    }

    /// Name as in tables.
    pub fn name(self) -> &'static str {
        match self {
            Side::Front => "front",
            Side::Back => "back",
        }
    }
}

/// Numbers every element side of a scene, triangle by triangle: first the front, then the back if the surface is two-sided. The parts of
/// triangles may be cut further into leaves. The leaves are then the elements.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Elements {
    /// Number of the first uncut element side of every triangle, then the total number of them.
    #[serde(skip)]
    first_of_triangle: Vec<u32>,
    #[serde(skip)]
    divisions: Vec<u32>,
    #[serde(skip)]
    two_sided: Vec<bool>,
    leaves: Option<Leaves>,
}

/// One element side: its position and what it belongs to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ElementSide {
    /// Triangle of the scene.
    pub triangle: u32,
    /// Number of the part of the triangle, 0 to n² − 1.
    pub part: u32,
    /// Front or back.
    pub side: Side,
    /// Path of the leaf within the part, if the part is cut into leaves.
    path: u32,
}

impl ElementSide {
    /// How often the part was cut to get this leaf.
    pub fn cuts(&self) -> u32 {
        cuts_of(self.path)
    }
}

impl Elements {
    /// Numbers the elements of a scene.
    pub fn of(scene: &Scene) -> Elements {
        let two_sided: Vec<bool> =
            (0..scene.triangles.len()).map(|triangle| scene.surface_of(triangle as u32).two_sided).collect();
        let mut first_of_triangle = Vec::with_capacity(scene.triangles.len() + 1);
        let mut next = 0u32;
        for (divisions, two_sided) in scene.divisions.iter().zip(&two_sided) {
            first_of_triangle.push(next);
            next += divisions * divisions * if *two_sided { 2 } else { 1 };
        }
        first_of_triangle.push(next);
        Elements { first_of_triangle, divisions: scene.divisions.clone(), two_sided, leaves: None }
    }

    /// Copies the numbering of the scene from `of_scene`. Stored elements contain only the leaves.
    pub fn take_numbering(&mut self, of_scene: &Elements) {
        self.first_of_triangle.clone_from(&of_scene.first_of_triangle);
        self.divisions.clone_from(&of_scene.divisions);
        self.two_sided.clone_from(&of_scene.two_sided);
    }

    /// Returns these elements with each one cut as often as `cuts` says. Both sides of a surface get the same cuts.
    pub fn cut(&self, cuts: impl Fn(u32) -> u32) -> Elements {
        let parts = self.uncut_len();
        let mirrored = |part: u32| {
            let (triangle, local) = self.uncut(part);
            let count = self.divisions[triangle] * self.divisions[triangle];
            if !self.two_sided[triangle] {
                part
            } else if local < count {
                part + count
            } else {
                part - count
            }
        };
        let wanted = |part: u32, path: u32| {
            // A piece is cut if it was cut before, or if the leaf that holds it has cuts left.
            match &self.leaves {
                Some(leaves) if leaves.is_cut(part, path) => true,
                Some(leaves) => {
                    let (leaf, above) = leaves.holder(part, path);
                    cuts_of(path) - above < cuts(leaf)
                }
                None => cuts_of(path) < cuts(part),
            }
        };
        let leaves = Leaves::of(parts, |part, path| wanted(part, path) || wanted(mirrored(part), path));
        Elements { leaves: Some(leaves), ..self.clone() }
    }

    /// Returns coarser elements: a piece stays cut only if its edge √(2 A) is longer than `most_edge_m`. No element gets finer.
    pub fn joined(&self, scene: &Scene, most_edge_m: f64) -> Elements {
        let edge_m = |part: u32| {
            let (triangle, _) = self.uncut(part);
            (2.0 * scene.triangle_area_m2(triangle as u32)).sqrt() / f64::from(self.divisions[triangle])
        };
        let is_cut = |part: u32, path: u32| {
            self.is_cut(part, path) && edge_m(part) > most_edge_m * f64::from(1u32 << cuts_of(path))
        };
        Elements { leaves: Some(Leaves::of(self.uncut_len(), is_cut)), ..self.clone() }
    }

    /// Returns these elements with the cuts of `other` added, for elements of the same scene.
    pub fn cut_like(&self, other: &Elements) -> Elements {
        let is_cut = |part: u32, path: u32| self.is_cut(part, path) || other.is_cut(part, path);
        Elements { leaves: Some(Leaves::of(self.uncut_len(), is_cut)), ..self.clone() }
    }

    fn is_cut(&self, part: u32, path: u32) -> bool {
        self.leaves.as_ref().is_some_and(|leaves| leaves.is_cut(part, path))
    }

    /// Number of element sides.
    pub fn len(&self) -> usize {
        self.leaves.as_ref().map_or(self.uncut_len(), Leaves::len)
    }

    fn uncut_len(&self) -> usize {
        self.first_of_triangle.last().map_or(0, |count| *count as usize)
    }

    /// First element of an uncut one.
    fn first_of(&self, uncut: u32) -> u32 {
        self.leaves.as_ref().map_or(uncut, |leaves| leaves.first_of(uncut))
    }

    /// Returns the triangle of an uncut element, and the element's number within that triangle.
    fn uncut(&self, uncut: u32) -> (usize, u32) {
        let triangle = self.first_of_triangle.partition_point(|first| *first <= uncut) - 1;
        (triangle, uncut - self.first_of_triangle[triangle])
    }

    /// Whether there is no element at all.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Returns the element side that a hit belongs to, or `None` for the back of a one-sided surface. `at` holds the barycentric
    /// coordinates `(u, v)` in the triangle: the weights of its second and third corner.
    #[inline]
    pub fn element_at(&self, triangle: u32, at: [f64; 2], side: Side) -> Option<u32> {
        let uncut = self.first_uncut(triangle, side)? + part_at(self.divisions[triangle as usize], at[0], at[1]);
        match &self.leaves {
            None => Some(uncut),
            Some(leaves) => Some(leaves.at(uncut, inner_at(self.divisions[triangle as usize], at)).0),
        }
    }

    /// As `element_at`, with the position in the element: the weights of its second and third corner.
    #[inline]
    pub fn place_at(&self, triangle: u32, at: [f64; 2], side: Side) -> Option<(u32, [f64; 2])> {
        let divisions = self.divisions[triangle as usize];
        let uncut = self.first_uncut(triangle, side)? + part_at(divisions, at[0], at[1]);
        let inner = inner_at(divisions, at);
        Some(self.leaves.as_ref().map_or((uncut, inner), |leaves| leaves.at(uncut, inner)))
    }

    fn first_uncut(&self, triangle: u32, side: Side) -> Option<u32> {
        let index = triangle as usize;
        match side {
            Side::Front => Some(self.first_of_triangle[index]),
            Side::Back if self.two_sided[index] => {
                Some(self.first_of_triangle[index] + self.divisions[index] * self.divisions[index])
            }
            Side::Back => None,
        }
    }

    /// Returns the element side of a number.
    #[inline]
    pub fn element(&self, index: u32) -> ElementSide {
        let (uncut, path) = self.leaves.as_ref().map_or((index, UNCUT), |leaves| leaves.part_and_path(index));
        let (triangle, local) = self.uncut(uncut);
        let parts = self.divisions[triangle] * self.divisions[triangle];
        ElementSide {
            triangle: triangle as u32,
            part: local % parts,
            side: if local < parts { Side::Front } else { Side::Back },
            path,
        }
    }

    /// Returns the same part of the triangle on the other side, or `None` if that side has no elements.
    pub fn opposite(&self, index: u32) -> Option<u32> {
        let ElementSide { triangle, part, side, .. } = self.element(index);
        let here = self.first_of(self.first_uncut(triangle, side)? + part);
        let there = self.first_of(self.first_uncut(triangle, side.other())? + part);
        Some(index - here + there)
    }

    /// The element numbers of a triangle, both sides.
    pub fn of_triangle(&self, triangle: u32) -> std::ops::Range<u32> {
        self.first_of(self.first_of_triangle[triangle as usize])
            ..self.first_of(self.first_of_triangle[triangle as usize + 1])
    }

    /// The element numbers of a surface, both sides.
    pub fn of_surface(&self, scene: &Scene, surface: SurfaceId) -> std::ops::Range<u32> {
        let triangles = &scene.surfaces[surface as usize].triangles;
        self.first_of(self.first_of_triangle[triangles.start as usize])
            ..self.first_of(self.first_of_triangle[triangles.end as usize])
    }

    /// Barycentric coordinates `(u, v)` of the three corners of an element in its triangle.
    #[inline]
    pub fn corners(&self, element: &ElementSide) -> [[f64; 2]; 3] {
        corners_of(part_corners(self.divisions[element.triangle as usize], element.part), element.path)
    }

    /// Corners of an element in m, in the same sense of rotation as the front of its triangle.
    pub fn corners_m(&self, scene: &Scene, element: ElementSide) -> [DVec3; 3] {
        positions_m(scene, element.triangle, self.corners(&element))
    }

    /// Middle of an element in m, and the unit normal of its side there.
    pub fn middle(&self, scene: &Scene, element: ElementSide) -> (DVec3, DVec3) {
        let (middle_m, front) = match body_of(&scene.bodies, element.triangle) {
            Some(body) => {
                let [a, b, c] = self.corners(&element);
                body.place(element.triangle, [0, 1].map(|k| (a[k] + b[k] + c[k]) / 3.0))
            }
            None => {
                let [a, b, c] = self.corners_m(scene, element);
                ((a + b + c) / 3.0, scene.triangle_normal(element.triangle))
            }
        };
        (middle_m, if element.side == Side::Front { front } else { -front })
    }

    /// Area of an element in m².
    pub fn area_m2(&self, scene: &Scene, element: ElementSide) -> f64 {
        let divisions = f64::from(self.divisions[element.triangle as usize] << element.cuts());
        if divisions > 1.0
            && let Some(body) = body_of(&scene.bodies, element.triangle)
        {
            return body.part_area_m2(element.triangle, self.corners(&element));
        }
        scene.triangle_area_m2(element.triangle) / (divisions * divisions)
    }
}

/// Positions in m of three points of a triangle, from their barycentric coordinates `(u, v)`.
#[inline]
pub fn positions_m(scene: &Scene, triangle: u32, [first, second, third]: [[f64; 2]; 3]) -> [DVec3; 3] {
    if let Some(body) = body_of(&scene.bodies, triangle) {
        let place_m = |at: [f64; 2]| body.place(triangle, at).0;
        return [place_m(first), place_m(second), place_m(third)];
    }
    let [a, b, c] = scene.corners_m(triangle);
    let place_m = |[u, v]: [f64; 2]| a + u * (b - a) + v * (c - a);
    [place_m(first), place_m(second), place_m(third)]
}

/// Returns the number of the part at a point. Parts are numbered in rows of constant v. Row `j` has `2(n − j) − 1` parts, upright and
/// upside-down in turn.
#[inline]
pub fn part_at(divisions: u32, u: f64, v: f64) -> u32 {
    if divisions == 1 {
        return 0;
    }
    let n = f64::from(divisions);
    let row = ((v * n) as u32).min(divisions - 1);
    let column = ((u * n) as u32).min(divisions - 1 - row);
    let upside_down = column < divisions - 1 - row && (u * n - f64::from(column)) + (v * n - f64::from(row)) > 1.0;
    row * (2 * divisions - row) + 2 * column + u32::from(upside_down)
}

/// Position of a triangle's point within its part: the weights of the part's second and third corner.
#[inline]
fn inner_at(divisions: u32, [u, v]: [f64; 2]) -> [f64; 2] {
    let n = f64::from(divisions);
    let row = ((v * n) as u32).min(divisions - 1);
    let column = ((u * n) as u32).min(divisions - 1 - row);
    let (a, b) = (u * n - f64::from(column), v * n - f64::from(row));
    // The same test as in `part_at`.
    if column < divisions - 1 - row && a + b > 1.0 { [1.0 - a, 1.0 - b] } else { [a, b] }
}

/// Barycentric coordinates of the corners of one of the `divisions²` parts of a triangle.
pub fn part_corners(divisions: u32, part: u32) -> [[f64; 2]; 3] {
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
    fn elements_that_are_cut_keep_their_places_and_areas_on_both_sides() {
        let text = r#"{ "version": 1, "materials": { "m": { "type": "diffuse", "reflectance": 0.5 } },
            "geometry": [ { "name": "table", "type": "rectangle", "origin": [0,0,0], "u": [3,0,0], "v": [0,2,0], "two_sided": true,
                            "max_element_edge": 1.3, "material": "m" } ],
            "luminaires": [ { "name": "lamp", "type": "point", "position": [2,1,0.9], "intensity_cd": 1 } ] }"#;
        let scene = crate::scene_from_json(text, None, std::path::Path::new(".")).expect("the table is valid");
        let given = Elements::of(&scene);
        // Cut twice: earlier cuts remain, and the back gets the cuts of the front.
        let once = given.cut(|element| u32::from(element == 1));
        let cut = once.cut(|element| if element == 3 { 2 } else { 0 });
        assert_eq!(once.len(), given.len() + 2 * 3);
        assert_eq!(cut.len(), once.len() + 2 * 15);
        let mut area_m2 = 0.0;
        for index in 0..cut.len() as u32 {
            let element = cut.element(index);
            area_m2 += cut.area_m2(&scene, element);
            let [a, b, c] = cut.corners(&element);
            let at = [0, 1].map(|k| a[k] + 0.4 * (b[k] - a[k]) + 0.3 * (c[k] - a[k]));
            let (found, inner) = cut.place_at(element.triangle, at, element.side).expect("both sides count");
            assert_eq!((found, cut.element_at(element.triangle, at, element.side)), (index, Some(index)));
            assert!((inner[0] - 0.4).abs() < 1e-9 && (inner[1] - 0.3).abs() < 1e-9, "{inner:?}");
            let other = cut.opposite(index).expect("the table has two sides");
            assert_eq!((cut.corners(&cut.element(other)), cut.opposite(other)), ([a, b, c], Some(index)));
        }
        assert!((area_m2 - 12.0).abs() < 1e-12);
    }

    #[test]
    fn the_rim_of_a_triangle_belongs_to_its_parts() {
        for (u, v) in [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (0.5, 0.5), (0.999_999_999, 1e-10)] {
            assert!(part_at(5, u, v) < 25);
        }
    }
}
