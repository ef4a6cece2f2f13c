//! Triangles that lie in one plane and cover each other in part: which of them a ray meets there is chance.

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::model::Scene;
use super::shells::size_m;

/// Planes nearer to each other than this fraction of the scene's size are one.
const SAME_PLANE: f64 = 1e-6;
/// Steps of a unit normal's coordinates that are told apart.
const NORMAL_STEPS: f64 = 1e4;
/// An overlap of less than this share of the smaller triangle is rounding.
const LEAST_SHARE: f64 = 1e-4;

/// Cells of the grid over a plane's triangles are so many times as wide as these in the mean.
const CELL: f64 = 1.5;
/// Triangles wider than so many cells are not entered into the grid.
const LARGE: f64 = 8.0;

/// A triangle in the frame of its plane.
struct Flat {
    triangle: u32,
    corners_m: [DVec2; 3],
    low_m: DVec2,
    high_m: DVec2,
}

/// Pairs of triangles that overlap in one plane and face the same way (or both either way), each with a place in m in both;
/// triangles with the same three corners are left to others. The flag says whether all pairs were looked at, no more than
/// `most_pairs` of them.
pub(super) fn coplanar_overlaps(scene: &Scene, vertex_of: &[u32], most_pairs: usize) -> (Vec<([u32; 2], DVec3)>, bool) {
    let step_m = SAME_PLANE * size_m(scene);
    let mut planes: Vec<([i64; 4], u32)> = (0..scene.triangles.len() as u32)
        .into_par_iter()
        .map(|triangle| (plane_of(scene, triangle, step_m), triangle))
        .collect();
    planes.par_sort_unstable();

    let mut found = Vec::new();
    let mut pairs = 0;
    for same in planes.chunk_by(|one, other| one.0 == other.0).filter(|same| same.len() > 1) {
        let normal = scene.triangle_normal(same[0].1);
        let flats: Vec<Flat> = same.iter().map(|(_, triangle)| flat(scene, *triangle, normal)).collect();
        let all_seen = near_pairs(&flats, |one, other| {
            pairs += 1;
            if both_are_met(scene, one.triangle, other.triangle)
                && !same_corners(scene, vertex_of, one.triangle, other.triangle)
                && let Some(place) = common_place(one, other)
            {
                let place_m = lifted(scene, one.triangle, normal, place);
                found.push(([one.triangle.min(other.triangle), one.triangle.max(other.triangle)], place_m));
            }
            pairs < most_pairs
        });
        if !all_seen {
            return (found, false);
        }
    }
    found.sort_unstable_by_key(|(pair, _)| *pair);
    (found, true)
}

/// Shows every pair of triangles whose boxes overlap once, until `show` wants no more; whether it saw all.
///
/// Triangles are entered into the cells of a grid that their boxes reach into; the few that reach into many meet all others.
fn near_pairs(flats: &[Flat], mut show: impl FnMut(&Flat, &Flat) -> bool) -> bool {
    let overlap = |one: &Flat, other: &Flat| one.low_m.cmplt(other.high_m).all() && other.low_m.cmplt(one.high_m).all();
    let extent = |flat: &Flat| (flat.high_m - flat.low_m).max_element();
    let cell_m = CELL * flats.iter().map(extent).sum::<f64>() / flats.len() as f64;
    let low_m = flats.iter().fold(DVec2::INFINITY, |low, flat| low.min(flat.low_m));
    let cell_of = |point_m: DVec2| ((point_m - low_m) / cell_m).floor().as_i64vec2();
    let (large, small): (Vec<usize>, Vec<usize>) =
        (0..flats.len()).partition(|number| extent(&flats[*number]) > LARGE * cell_m);
    for (rank, number) in large.iter().enumerate() {
        for other in large[rank + 1..].iter().chain(&small) {
            if overlap(&flats[*number], &flats[*other]) && !show(&flats[*number], &flats[*other]) {
                return false;
            }
        }
    }
    let mut entered: Vec<(i64, i64, usize)> = Vec::with_capacity(2 * small.len());
    for number in small {
        let (from, to) = (cell_of(flats[number].low_m), cell_of(flats[number].high_m));
        entered.extend((from.x..=to.x).flat_map(|x| (from.y..=to.y).map(move |y| (x, y, number))));
    }
    entered.sort_unstable();
    for cell in entered.chunk_by(|one, other| (one.0, one.1) == (other.0, other.1)) {
        for (rank, (x, y, number)) in cell.iter().enumerate() {
            let one = &flats[*number];
            for (_, _, other) in &cell[rank + 1..] {
                let other = &flats[*other];
                // A pair counts in the cell where what the boxes have in common begins.
                let begins = cell_of(one.low_m.max(other.low_m));
                if overlap(one, other) && (begins.x, begins.y) == (*x, *y) && !show(one, other) {
                    return false;
                }
            }
        }
    }
    true
}

/// Numbers that triangles of one plane share, whichever side they face.
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

/// The two axes that a plane is seen along best.
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
    let sorted = |triangle: u32| {
        let mut corners = scene.triangles[triangle as usize].map(|vertex| vertex_of[vertex as usize]);
        corners.sort_unstable();
        corners
    };
    sorted(one) == sorted(other)
}

/// Twice the area of a polygon, above 0 where it turns to the left.
fn twice_area(polygon: &[DVec2]) -> f64 {
    (0..polygon.len()).map(|i| polygon[i].perp_dot(polygon[(i + 1) % polygon.len()])).sum()
}

/// The middle of what two triangles have in common, if that is more than rounding.
fn common_place(one: &Flat, other: &Flat) -> Option<DVec2> {
    // Coordinates about a corner keep their digits far from the origin.
    let origin = one.corners_m[0];
    let clip = one.corners_m.map(|corner| corner - origin);
    let mut polygon: Vec<DVec2> = other.corners_m.iter().map(|corner| *corner - origin).collect();
    let least = LEAST_SHARE * twice_area(&clip).min(twice_area(&polygon));
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

/// A place in a triangle's plane in m, from its two coordinates.
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
