//! Triangles that lie in one plane and partly cover each other: which of them a ray meets there is random.

use std::collections::BinaryHeap;

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::box_tree::{BoxTree, Budget};
use super::shells::size_m;
use crate::scene::Scene;

/// Planes nearer to each other than this fraction of the scene's size count as one.
const SAME_PLANE: f64 = 1e-6;
/// Number of distinguished steps per unit of a unit normal's coordinates.
const NORMAL_STEPS: f64 = 1e4;
/// An overlap below this share of the smaller triangle is rounding.
const LEAST_OVERLAP: f64 = 1e-4;
/// Steps for a pair of triangles with overlapping boxes, and additional steps if no edge separates them.
const STEPS_A_PAIR: u64 = 8;
const STEPS_A_CUT: u64 = 64;
/// Hash places for planes, per triangle. One in eight triangles without coplanar others shares its place by chance.
const PLACES_A_TRIANGLE: u64 = 8;
/// An odd number without a pattern in its bits (2⁶⁴ over the golden ratio), for hashing.
const MIXER: u64 = 0x9E37_79B9_7F4A_7C15;
/// Pairs that are kept with their positions; the others are only counted.
const MOST_KEPT: usize = 256;

/// A triangle in the coordinates of its plane.
struct Flat {
    triangle: u32,
    corners_m: [DVec2; 3],
    low_m: DVec2,
    high_m: DVec2,
}

/// Pairs of triangles that overlap in one plane.
#[derive(Debug, Default)]
pub(super) struct CoplanarOverlaps {
    /// Number of pairs found.
    pub count: usize,
    /// The pairs with the lowest numbers, in order, each with a point in m that lies in both triangles.
    pub first: Vec<([u32; 2], DVec3)>,
    /// Whether all pairs were tested.
    pub all_examined: bool,
}

/// Returns the pairs of triangles that overlap in one plane and face the same way (or are both met from both sides).
///
/// Triangles with the same three corners are reported elsewhere, and one of them represents all here. Planes with few triangles come first,
/// so that a plane with very many does not use up the budget of the others.
pub(super) fn coplanar_overlaps(scene: &Scene, vertex_of: &[u32], budget: &mut Budget) -> CoplanarOverlaps {
    let step_m = SAME_PLANE * size_m(scene);
    let mut planes: Vec<([i64; 4], u32)> = triangles_of_shared_planes(scene, step_m)
        .into_par_iter()
        .map(|triangle| (plane_of(scene, triangle, step_m), triangle))
        .collect();
    planes.par_sort_unstable();
    let mut planes: Vec<Vec<u32>> = planes
        .chunk_by(|one, other| one.0 == other.0)
        .filter(|same| same.len() > 1)
        .map(|same| one_of_each(scene, vertex_of, same.iter().map(|(_, triangle)| *triangle)))
        .collect();
    planes.sort_by_key(Vec::len);

    let mut found = CoplanarOverlaps::default();
    let mut first: BinaryHeap<([u32; 2], [u64; 3])> = BinaryHeap::new();
    for same in &planes {
        let normal = scene.triangle_normal(same[0]);
        let flats: Vec<Flat> = same.iter().map(|triangle| flat(scene, *triangle, normal)).collect();
        let tree = BoxTree::of(flats.iter().map(|flat| [flat.low_m.extend(0.0), flat.high_m.extend(f64::MAX)]));
        tree.pairs(0.0, budget, |one, other, budget| {
            let (one, other) = (&flats[one as usize], &flats[other as usize]);
            budget.take(STEPS_A_PAIR);
            if are_apart(one, other) || !budget.take(STEPS_A_CUT) {
                return;
            }
            if both_are_met(scene, one.triangle, other.triangle)
                && !same_corners(scene, vertex_of, one.triangle, other.triangle)
                && let Some(place) = common_place(one, other)
            {
                found.count += 1;
                let pair = [one.triangle.min(other.triangle), one.triangle.max(other.triangle)];
                if first.len() == MOST_KEPT && first.peek().is_some_and(|last| last.0 < pair) {
                    return;
                }
                let place_m = lifted(scene, one.triangle, normal, place);
                first.push((pair, place_m.to_array().map(f64::to_bits)));
                if first.len() > MOST_KEPT {
                    first.pop();
                }
            }
        });
    }
    found.all_examined = !budget.is_spent();
    let first = first.into_sorted_vec().into_iter();
    found.first = first.map(|(pair, place)| (pair, DVec3::from_array(place.map(f64::from_bits)))).collect();
    found
}

/// Returns all triangles that are coplanar with others, and a few more. Planes are distinguished only by a hash, which removes most
/// triangles of a mesh that is nowhere flat.
fn triangles_of_shared_planes(scene: &Scene, step_m: f64) -> Vec<u32> {
    let count = scene.triangles.len() as u32;
    let places = (PLACES_A_TRIANGLE * u64::from(count)).next_power_of_two();
    let place_of = |triangle: u32| {
        let mixed = plane_of(scene, triangle, step_m)
            .iter()
            .fold(0u64, |mixed, part| (mixed.rotate_left(5) ^ *part as u64).wrapping_mul(MIXER));
        ((mixed >> 32) & (places - 1)) as u32
    };
    let place_of_each: Vec<u32> = (0..count).into_par_iter().map(place_of).collect();
    let mut taken = vec![0u8; places as usize];
    place_of_each.iter().for_each(|place| taken[*place as usize] = taken[*place as usize].saturating_add(1));
    (0..count)
        .zip(place_of_each)
        .filter(|(_, place)| taken[*place as usize] > 1)
        .map(|(triangle, _)| triangle)
        .collect()
}

/// Returns one triangle of each set with the same corners that face the same way and are equally one-sided or two-sided: the first.
fn one_of_each(scene: &Scene, vertex_of: &[u32], triangles: impl Iterator<Item = u32>) -> Vec<u32> {
    let alike = |triangle: u32| {
        let faces = scene.triangle_normal(triangle).to_array().map(|part| part > 0.0);
        (sorted_corners(scene, vertex_of, triangle), faces, scene.surface_of(triangle).two_sided)
    };
    let mut keyed: Vec<_> = triangles.map(|triangle| (alike(triangle), triangle)).collect();
    keyed.sort_unstable();
    keyed.dedup_by(|one, other| one.0 == other.0);
    let mut kept: Vec<u32> = keyed.into_iter().map(|(_, triangle)| triangle).collect();
    kept.sort_unstable();
    kept
}

/// Returns numbers that are equal for triangles of one plane, on whichever side they face.
fn plane_of(scene: &Scene, triangle: u32, step_m: f64) -> [i64; 4] {
    let [a, b, c] = scene.corners_m(triangle);
    let mut normal = scene.triangle_normal(triangle);
    if normal[normal.abs().max_position()] < 0.0 {
        normal = -normal;
    }
    let rounded = |number: f64| number.round() as i64;
    let offset_m = normal.dot((a + b + c) / 3.0);
    let [x, y, z] = (normal * NORMAL_STEPS).to_array().map(rounded);
    [x, y, z, rounded(offset_m / step_m)]
}

/// Returns the two axes along which a plane has the largest projection.
fn axes(normal: DVec3) -> [usize; 2] {
    let dropped = normal.abs().max_position();
    [(dropped + 1) % 3, (dropped + 2) % 3]
}

fn flat(scene: &Scene, triangle: u32, normal: DVec3) -> Flat {
    let [u, v] = axes(normal);
    let mut corners_m = scene.corners_m(triangle).map(|corner| DVec2::new(corner[u], corner[v]));
    if twice_area(&corners_m) < 0.0 {
        corners_m.swap(1, 2);
    }
    let low_m = corners_m.iter().fold(DVec2::INFINITY, |low, corner| low.min(*corner));
    let high_m = corners_m.iter().fold(DVec2::NEG_INFINITY, |high, corner| high.max(*corner));
    Flat { triangle, corners_m, low_m, high_m }
}

fn both_are_met(scene: &Scene, one: u32, other: u32) -> bool {
    let alike = scene.triangle_normal(one).dot(scene.triangle_normal(other)) > 0.0;
    alike || (scene.surface_of(one).two_sided && scene.surface_of(other).two_sided)
}

fn same_corners(scene: &Scene, vertex_of: &[u32], one: u32, other: u32) -> bool {
    sorted_corners(scene, vertex_of, one) == sorted_corners(scene, vertex_of, other)
}

fn sorted_corners(scene: &Scene, vertex_of: &[u32], triangle: u32) -> [u32; 3] {
    let mut corners = scene.triangles[triangle as usize].map(|vertex| vertex_of[vertex as usize]);
    corners.sort_unstable();
    corners
}

/// Returns twice the area of a polygon, positive if it runs counter-clockwise.
fn twice_area(polygon: &[DVec2]) -> f64 {
    (0..polygon.len()).map(|i| polygon[i].perp_dot(polygon[(i + 1) % polygon.len()])).sum()
}

/// Whether an edge of the first triangle separates it from the second.
fn are_apart(one: &Flat, other: &Flat) -> bool {
    let parts = |edge: usize| {
        let (from, to) = (one.corners_m[edge], one.corners_m[(edge + 1) % 3]);
        other.corners_m.iter().all(|corner| (to - from).perp_dot(*corner - from) <= 0.0)
    };
    (0..3).any(parts)
}

/// Returns the middle of the common part of two triangles, if that part is more than rounding.
fn common_place(one: &Flat, other: &Flat) -> Option<DVec2> {
    // Coordinates relative to a corner keep their digits far from the origin.
    let origin = one.corners_m[0];
    let clip = one.corners_m.map(|corner| corner - origin);
    let mut polygon: Vec<DVec2> = other.corners_m.iter().map(|corner| *corner - origin).collect();
    let least = LEAST_OVERLAP * twice_area(&clip).min(twice_area(&polygon));
    for edge in 0..3 {
        let (from, to) = (clip[edge], clip[(edge + 1) % 3]);
        let side = |point: DVec2| (to - from).perp_dot(point - from);
        let mut kept = Vec::with_capacity(polygon.len() + 1);
        for (i, point) in polygon.iter().enumerate() {
            let next = polygon[(i + 1) % polygon.len()];
            let (here, there) = (side(*point), side(next));
            if here >= 0.0 {
                kept.push(*point);
            }
            if (here > 0.0 && there < 0.0) || (here < 0.0 && there > 0.0) {
                kept.push(*point + (next - *point) * (here / (here - there)));
            }
        }
        polygon = kept;
        if polygon.len() < 3 {
            return None;
        }
    }
    (twice_area(&polygon) > least).then(|| origin + polygon.iter().sum::<DVec2>() / polygon.len() as f64)
}

/// Returns the point in m of a triangle's plane that has these two coordinates.
fn lifted(scene: &Scene, triangle: u32, normal: DVec3, place: DVec2) -> DVec3 {
    let [u, v] = axes(normal);
    let dropped = 3 - u - v;
    let corner = scene.corners_m(triangle)[0];
    let mut lifted = DVec3::ZERO;
    (lifted[u], lifted[v]) = (place.x, place.y);
    lifted[dropped] =
        corner[dropped] - (normal[u] * (place.x - corner[u]) + normal[v] * (place.y - corner[v])) / normal[dropped];
    lifted
}
