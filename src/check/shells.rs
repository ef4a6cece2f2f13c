//! Connected pieces of surface: which are closed, which way they face, and what lies inside of them.

use std::collections::HashMap;
use std::f64::consts::PI;

use glam::DVec3;

use super::box_tree::{Box3, Budget};
use super::by_number::sorted_by_number;
use super::winding::WindingTree;
use crate::base::linked_sets::LinkedSets;
use crate::scene::Scene;

/// A connected piece of surface.
#[derive(Clone, Debug)]
pub struct Shell {
    /// Its triangles.
    pub triangles: Vec<u32>,
    /// Whether every edge is used equally often in both directions, so that there is no boundary.
    pub closed: bool,
    /// Signed volume in m³ of a closed shell: positive where the fronts face outward.
    pub volume_m3: f64,
    low_m: DVec3,
    high_m: DVec3,
    /// Present only for a closed shell.
    tree: Option<WindingTree>,
}

impl Shell {
    /// Returns how many times, and in which direction, the shell lies around a point: +1 inside of a shell that faces outward, −1 inside of
    /// one that faces inward, 0 outside. The value has a meaning only for a closed shell and off its surface.
    ///
    /// A shell with a boundary gives 0.
    pub fn winding(&self, point_m: DVec3) -> f64 {
        self.winding_within(point_m, &mut Budget::of_steps(u64::MAX))
    }

    /// Returns the same, as far as the budget suffices.
    pub(super) fn winding_within(&self, point_m: DVec3, budget: &mut Budget) -> f64 {
        if point_m.cmplt(self.low_m).any() || point_m.cmpgt(self.high_m).any() {
            return 0.0;
        }
        self.tree.as_ref().map_or(0.0, |tree| tree.solid_angle_sr(point_m, budget) / (4.0 * PI))
    }

    /// Whether a point lies inside, and farther from the surface than a tolerance.
    pub(super) fn encloses(&self, point_m: DVec3, tolerance_m: f64, budget: &mut Budget) -> bool {
        if self.winding_within(point_m, budget).abs() <= 0.5 {
            return false;
        }
        let distance_m = |triangle| distance_to_triangle(point_m, triangle);
        !self.tree.as_ref().is_some_and(|tree| tree.any_near(point_m, tolerance_m, budget, distance_m))
    }

    /// Whether the surface may cut a box or come within `tolerance_m` of it. If not, all points of the box lie on one side of the shell.
    pub(super) fn may_cut(&self, box_m: Box3, tolerance_m: f64, budget: &mut Budget) -> bool {
        self.tree.as_ref().is_some_and(|tree| tree.may_cut(box_m, tolerance_m, budget))
    }

    /// Returns a distance in m such that no part of the shell is nearer to the point.
    pub(super) fn clear_m(&self, point_m: DVec3, budget: &mut Budget) -> f64 {
        let box_m = point_m.distance(point_m.clamp(self.low_m, self.high_m));
        if box_m > 0.0 { box_m } else { self.tree.as_ref().map_or(0.0, |tree| tree.clear_m(point_m, budget)) }
    }

    /// Lowest and highest coordinates in m.
    pub(super) fn bounds_m(&self) -> Box3 {
        [self.low_m, self.high_m]
    }
}

/// Returns the shells that some triangles form. Triangles with a common vertex belong to one shell. `with_trees` prepares closed shells for
/// tests of what lies inside.
fn shells(
    scene: &Scene,
    triangles: std::ops::Range<u32>,
    vertex_of: impl Fn(u32) -> u32,
    with_trees: bool,
) -> Vec<Shell> {
    let corners = |triangle: u32| scene.triangles[triangle as usize].map(&vertex_of);

    // Joins the vertices of every triangle, in a list that starts at the lowest number.
    let numbers = || triangles.clone().flat_map(corners);
    let (Some(lowest), Some(highest)) = (numbers().min(), numbers().max()) else {
        return Vec::new();
    };
    let mut linked = LinkedSets::new((highest - lowest) as usize + 1);
    for triangle in triangles.clone() {
        let [a, b, c] = corners(triangle).map(|vertex| vertex - lowest);
        linked.link(a, b);
        linked.link(a, c);
    }
    let mut places: HashMap<u32, usize> = HashMap::new();
    let mut shells: Vec<Shell> = Vec::new();
    let mut last: Option<(u32, usize)> = None;
    for triangle in triangles {
        let root = linked.root(corners(triangle)[0] - lowest);
        let place = match last {
            Some((last_root, place)) if last_root == root => place,
            _ => *places.entry(root).or_insert_with(|| {
                shells.push(Shell {
                    triangles: Vec::new(),
                    closed: false,
                    volume_m3: 0.0,
                    low_m: DVec3::INFINITY,
                    high_m: DVec3::NEG_INFINITY,
                    tree: None,
                });
                shells.len() - 1
            }),
        };
        last = Some((root, place));
        shells[place].triangles.push(triangle);
    }
    for shell in &mut shells {
        shell.measure(scene, corners, with_trees);
    }
    shells
}

/// Returns the edges of triangles: the ends with the lower number first, whether the triangle runs that way, and the triangle. Equal edges
/// are adjacent.
pub(super) fn sorted_edges(triangles: &[u32], corners: impl Fn(u32) -> [u32; 3]) -> Vec<([u32; 2], bool, u32)> {
    let edges_of = |triangle: &u32| {
        let [a, b, c] = corners(*triangle);
        [(a, b), (b, c), (c, a)].map(|(from, to)| ([from.min(to), from.max(to)], from < to, *triangle))
    };
    sorted_by_number(|| triangles.iter().flat_map(edges_of), |edge| edge.0[0])
}

impl Shell {
    fn measure(&mut self, scene: &Scene, corners: impl Fn(u32) -> [u32; 3], with_tree: bool) {
        for corner_m in self.triangles.iter().flat_map(|triangle| scene.corners_m(*triangle)) {
            self.low_m = self.low_m.min(corner_m);
            self.high_m = self.high_m.max(corner_m);
        }
        let turns = |edge: &([u32; 2], bool, u32)| if edge.1 { 1 } else { -1 };
        self.closed = sorted_edges(&self.triangles, &corners)
            .chunk_by(|one, other| one.0 == other.0)
            .all(|same| same.iter().map(turns).sum::<i32>() == 0);
        if self.closed && with_tree {
            let triangles = self.triangles.iter().map(|triangle| corners(*triangle)).collect();
            self.tree = Some(WindingTree::of(triangles, |vertex| scene.vertices_m[vertex as usize]));
        }

        // Relative to a corner of its own, so that a small shell far from the origin keeps its digits.
        self.volume_m3 = self
            .triangles
            .iter()
            .map(|triangle| {
                let [a, b, c] = scene.corners_m(*triangle).map(|corner| corner - self.low_m);
                a.dot(b.cross(c)) / 6.0
            })
            .sum();
    }
}

/// Returns the closed shells of every geometry by itself.
pub fn closed_shells_of_geometries(scene: &Scene) -> Vec<Shell> {
    let geometries = scene.surfaces.chunk_by(|one, other| one.geometry == other.geometry);
    geometries
        .flat_map(|parts| {
            let triangles = parts[0].triangles.start..parts[parts.len() - 1].triangles.end;
            shells(scene, triangles, |vertex| vertex, true)
        })
        .filter(|shell| shell.closed)
        .collect()
}

/// Returns the shells of the scene as a whole. Exactly coinciding vertices of different geometries count as one, so that a room made of
/// rectangles is closed.
pub fn shells_of_scene(scene: &Scene) -> Vec<Shell> {
    shells_over(scene, &one_vertex_a_place(scene))
}

/// Returns for each vertex the first vertex at its position.
pub(super) fn one_vertex_a_place(scene: &Scene) -> Vec<u32> {
    let mut first: HashMap<[u64; 3], u32> = HashMap::new();
    (0u32..)
        .zip(&scene.vertices_m)
        .map(|(number, vertex)| *first.entry((*vertex + DVec3::ZERO).to_array().map(f64::to_bits)).or_insert(number))
        .collect()
}

/// Returns the same as [`shells_of_scene`], from the result of [`one_vertex_a_place`].
pub(super) fn shells_over(scene: &Scene, vertex_of: &[u32]) -> Vec<Shell> {
    shells(scene, 0..scene.triangles.len() as u32, |vertex| vertex_of[vertex as usize], true)
}

/// Returns the same without the trees for inside tests: only which triangles are connected, and whether the shells are closed.
pub(super) fn plain_shells_over(scene: &Scene, vertex_of: &[u32]) -> Vec<Shell> {
    shells(scene, 0..scene.triangles.len() as u32, |vertex| vertex_of[vertex as usize], false)
}

/// Whether every triangle of a shell reflects on both sides.
pub(super) fn reflects_on_both_sides(scene: &Scene, shell: &Shell) -> bool {
    shell.triangles.iter().all(|triangle| scene.surface_of(*triangle).two_sided)
}

/// Returns the diagonal of the geometry's bounding box in m.
pub(super) fn size_m(scene: &Scene) -> f64 {
    let [low_m, high_m] = scene.bounds_m();
    low_m.distance(high_m)
}

/// Returns the distance of a point to a triangle.
fn distance_to_triangle(point: DVec3, [a, b, c]: [DVec3; 3]) -> f64 {
    let normal = (b - a).cross(c - a).normalize();
    let edges = [(a, b), (b, c), (c, a)];
    let above = edges.iter().all(|(from, to)| (*to - *from).cross(point - *from).dot(normal) >= 0.0);
    if above {
        return (point - a).dot(normal).abs();
    }
    edges
        .iter()
        .map(|(from, to)| {
            let along = ((point - *from).dot(*to - *from) / (*to - *from).length_squared()).clamp(0.0, 1.0);
            point.distance(*from + along * (*to - *from))
        })
        .fold(f64::INFINITY, f64::min)
}
