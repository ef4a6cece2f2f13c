//! Faults of meshes as other programs write them: holes, T-junctions, doubled and reversed triangles, each with its position.

use std::collections::HashMap;

use glam::DVec3;

use super::box_tree::Budget;
use super::by_number::sorted_by_number;
use super::coplanar::coplanar_overlaps;
use super::faults::{Hole, MeshFaults, RimEdge};
use super::shells::{Shell, one_vertex_a_place, plain_shells_over, size_m, sorted_edges};
use super::t_junctions::closed_at_t_junctions;
use crate::scene::{Scene, joined, place_words};

/// A piece of surface is flat if no corner deviates from its plane by more than this fraction of its size.
const MOST_OFF_PLANE: f64 = 1e-6;
/// Largest number of listed corners of a hole.
const MOST_CORNERS_LISTED: usize = 32;
/// Largest number of listed holes.
const MOST_HOLES: usize = 1000;
/// Largest number of tests of boxes and triangles in each search: a few seconds' work on request, a fraction of a second when a scene is
/// read.
const MOST_TESTS: u64 = 100_000_000;
const MOST_TESTS_WHEN_READ: u64 = 20_000_000;
/// Additional tests per triangle. Sound meshes take some tens.
const TESTS_A_TRIANGLE: u64 = 200;

/// Examines all triangles of a scene. `vertex_of` gives vertices at one position one number; `shells` are the scene's shells.
pub(super) fn mesh_faults(scene: &Scene, shells: &[Shell], vertex_of: &[u32]) -> MeshFaults {
    faults_within(scene, shells, vertex_of, MOST_TESTS)
}

fn faults_within(scene: &Scene, shells: &[Shell], vertex_of: &[u32], most_tests: u64) -> MeshFaults {
    let budget = || Budget::of_steps(most_tests + TESTS_A_TRIANGLE * scene.triangles.len() as u64);
    let mut faults = MeshFaults { t_junctions_searched: true, ..MeshFaults::default() };
    let place_m = |vertex: u32| scene.vertices_m[vertex as usize];
    let name = |triangle: u32| scene.surface_of(triangle).name.as_str();
    let corners = |triangle: u32| scene.triangles[triangle as usize].map(|vertex| vertex_of[vertex as usize]);

    // Rotated so that the lowest number comes first. This keeps the direction, because two rooms back to back share a wall.
    let turned = |triangle: u32| {
        let [a, b, c] = corners(triangle);
        if a < b && a < c {
            [a, b, c]
        } else if b < c {
            [b, c, a]
        } else {
            [c, a, b]
        }
    };
    let all = 0..scene.triangles.len() as u32;
    let by_corners = sorted_by_number(
        || all.clone().map(|triangle| (turned(triangle), triangle)),
        |(corners, _): &([u32; 3], u32)| corners[0],
    );
    let mut doubled: Vec<u32> = Vec::new();
    for same in by_corners.chunk_by(|one, other| one.0 == other.0) {
        doubled.extend(same[1..].iter().map(|(_, triangle)| *triangle));
    }
    doubled.sort_unstable();
    for triangle in &doubled {
        let [a, b, c] = corners(*triangle);
        faults.duplicate_triangles.add((place_m(a) + place_m(b) + place_m(c)) / 3.0, name(*triangle));
    }
    drop(by_corners);
    let mut overlaps_budget = budget();
    let overlaps = coplanar_overlaps(scene, vertex_of, &mut overlaps_budget);
    faults.steps = overlaps_budget.taken();
    faults.overlaps_searched = overlaps.all_examined;
    for ([one, other], place) in overlaps.first {
        faults.overlapping_triangles.add(place, name(one));
        faults.overlapping_triangles.name(name(other));
    }
    faults.overlapping_triangles.count = overlaps.count;
    let single: Vec<u32> =
        (0..scene.triangles.len() as u32).filter(|triangle| doubled.binary_search(triangle).is_err()).collect();
    let edges = sorted_edges(&single, corners);
    let mut rim: Vec<RimEdge> = Vec::new();
    for same in edges.chunk_by(|one, other| one.0 == other.0) {
        let ([from, to], _, triangle) = same[0];
        let forward = same.iter().filter(|edge| edge.1).count();
        let middle_m = 0.5 * (place_m(from) + place_m(to));
        if same.len() % 2 == 1 {
            rim.push(RimEdge { ends: [from, to], triangle });
            if same.len() > 1 {
                faults.odd_edges.add(middle_m, name(triangle));
            }
        } else if 2 * forward != same.len() {
            faults.turned_edges.add(middle_m, name(triangle));
        }
    }

    let mut is_flat = vec![false; scene.triangles.len()];
    for shell in shells.iter().filter(|shell| !shell.closed && lies_in_a_plane(scene, shell)) {
        shell.triangles.iter().for_each(|triangle| is_flat[*triangle as usize] = true);
    }
    let rim = closed_at_t_junctions(scene, rim, &mut budget(), &mut faults);
    list_holes(scene, &rim.open, |triangle| is_flat[triangle as usize], &mut faults);
    faults
}

pub(super) fn lies_in_a_plane(scene: &Scene, shell: &Shell) -> bool {
    let [a, b, c] = scene.corners_m(shell.triangles[0]);
    let normal = (b - a).cross(c - a).normalize();
    let offsets = || shell.triangles.iter().flat_map(|triangle| scene.corners_m(*triangle)).map(|corner| corner - a);
    let reach_m = offsets().map(DVec3::length).fold(0.0, f64::max);
    offsets().all(|offset_m| offset_m.dot(normal).abs() <= MOST_OFF_PLANE * reach_m)
}

/// Returns the area in m² that a rim encloses, each of its lines taken as flat.
pub(super) fn rim_area_m2(scene: &Scene, rim: &[RimEdge]) -> f64 {
    let mut faults = MeshFaults::default();
    list_holes(scene, rim, |_| false, &mut faults);
    faults.hole_area_m2
}

/// Splits a rim into connected lines. Each line has its vertices and the indices of its edges; a closed line ends where it begins.
pub(super) fn lines_of(rim: &[RimEdge]) -> Vec<(Vec<u32>, Vec<usize>)> {
    let mut at_vertex: HashMap<u32, Vec<usize>> = HashMap::new();
    for (index, edge) in rim.iter().enumerate() {
        edge.ends.iter().for_each(|end| at_vertex.entry(*end).or_default().push(index));
    }
    let mut used = vec![false; rim.len()];
    let mut lines = Vec::new();
    for start in 0..rim.len() {
        if used[start] {
            continue;
        }
        // Follows the line from the first end of its first edge, as long as an edge continues it.
        let mut vertices = vec![rim[start].ends[0]];
        let mut line: Vec<usize> = Vec::new();
        let mut next = Some(start);
        while let Some(index) = next {
            used[index] = true;
            line.push(index);
            let last = vertices[vertices.len() - 1];
            let end = if rim[index].ends[0] == last { rim[index].ends[1] } else { rim[index].ends[0] };
            vertices.push(end);
            next = at_vertex.get_mut(&end).and_then(|around| {
                while around.last().is_some_and(|index| used[*index]) {
                    around.pop();
                }
                around.last().copied()
            });
        }
        lines.push((vertices, line));
    }
    lines
}

/// Adds holes for the lines of a rim. Lines that belong only to flat pieces are not holes.
fn list_holes(scene: &Scene, rim: &[RimEdge], is_flat: impl Fn(u32) -> bool, faults: &mut MeshFaults) {
    let place_m = |vertex: u32| scene.vertices_m[vertex as usize];
    let mut found: Vec<Hole> = Vec::new();
    for (vertices, line) in lines_of(rim) {
        if line.iter().all(|index| is_flat(rim[*index].triangle)) {
            continue;
        }
        let mut surfaces: Vec<String> =
            line.iter().map(|index| scene.surface_of(rim[*index].triangle).name.clone()).collect();
        surfaces.sort_unstable();
        surfaces.dedup();
        let places = || vertices.iter().map(|vertex| place_m(*vertex));
        let distinct = if vertices.first() == vertices.last() { vertices.len() - 1 } else { vertices.len() };
        found.push(Hole {
            length_m: line
                .iter()
                .map(|index| place_m(rim[*index].ends[0]).distance(place_m(rim[*index].ends[1])))
                .sum(),
            area_m2: ring_area_m2(places()),
            edges: line.len(),
            min_m: places().fold(DVec3::INFINITY, DVec3::min).to_array(),
            max_m: places().fold(DVec3::NEG_INFINITY, DVec3::max).to_array(),
            corners_m: places().take(distinct.min(MOST_CORNERS_LISTED)).map(|place| place.to_array()).collect(),
            surfaces,
        });
    }
    let small_m2 = SMALL_HOLE * size_m(scene).powi(2);
    faults.hole_count = found.len();
    faults.hole_area_m2 = found.iter().map(|hole| hole.area_m2).sum();
    faults.small_hole_count = found.iter().filter(|hole| hole.area_m2 < small_m2).count();
    found.sort_by(|one, other| other.length_m.total_cmp(&one.length_m));
    faults.longest_small_hole = found.iter().find(|hole| hole.area_m2 < small_m2).cloned();
    found.truncate(MOST_HOLES);
    faults.holes = found;
}

/// Returns the area of a closed ring of points, from the sum of the triangles that its edges make with its first point.
fn ring_area_m2(places: impl Iterator<Item = DVec3>) -> f64 {
    let places: Vec<DVec3> = places.collect();
    let Some(first) = places.first() else {
        return 0.0;
    };
    let spokes = places.windows(2).map(|pair| (pair[0] - *first).cross(pair[1] - *first));
    0.5 * spokes.sum::<DVec3>().length()
}

/// Holes below this share of the square of the scene's size are small and probably unintended.
const SMALL_HOLE: f64 = 0.01;

/// Searches a scene for mesh faults when it is read, within a short time, and warns of them.
pub(super) fn warn_of_faults(scene: &mut Scene) {
    let vertex_of = one_vertex_a_place(scene);
    let found = faults_within(scene, &plain_shells_over(scene, &vertex_of), &vertex_of, MOST_TESTS_WHEN_READ);
    scene.warnings.extend(warnings_of(&found));
}

/// Returns warnings for mesh faults: each kind once, with its number and first position.
pub(super) fn warnings_of(found: &MeshFaults) -> Vec<String> {
    let mut warnings = Vec::new();
    if !found.t_junctions_searched {
        warnings.push(format!("{MESH}too many open edges to check for T-junctions here; luxmc inspect checks longer"));
    }
    if !found.overlaps_searched {
        warnings.push(format!(
            "{MESH}too many triangles in one plane to check for all overlaps here; luxmc inspect checks longer"
        ));
    }
    for kind in found.kinds().into_iter().filter(|kind| kind.faults.count > 0) {
        let first = kind.faults.places_m.first();
        let place = first
            .map_or(String::new(), |place_m| format!("; the first at {}", place_words(DVec3::from_array(*place_m))));
        let (words, surfaces) = (kind.words(), joined(&kind.faults.surfaces));
        warnings.push(format!("{MESH}{words}{} ({surfaces}{place})", kind.remedy));
    }
    if let Some(hole) = &found.longest_small_hole {
        let holes = match found.small_hole_count {
            1 => "a small hole, ".to_owned(),
            count => format!("{count} small holes, the longest "),
        };
        warnings.push(format!(
            "{MESH}{holes}{:.3} m around at {}, along {}; light escapes there (luxmc inspect lists them)",
            hole.length_m,
            place_words(DVec3::from_array(hole.min_m)),
            joined(&hole.surfaces)
        ));
    }
    warnings
}

/// The beginning of warnings about meshes.
pub const MESH: &str = "mesh: ";

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::check::{inspect, scene_from_json};

    /// Returns the faults of a room of rectangles 4 m × 3 m × 2 m without its ceiling, with more geometry.
    fn faults(more: &str) -> MeshFaults {
        let text = format!(
            r#"{{ "version": 1, "materials": {{ "m": {{ "type": "diffuse", "reflectance": 0.5 }} }},
            "geometry": [
              {{ "name": "floor", "type": "rectangle", "origin": [0,0,0], "u": [4,0,0], "v": [0,3,0], "material": "m" }},
              {{ "name": "south", "type": "rectangle", "origin": [0,0,0], "u": [0,0,2], "v": [4,0,0], "material": "m" }},
              {{ "name": "north", "type": "rectangle", "origin": [0,3,0], "u": [4,0,0], "v": [0,0,2], "material": "m" }},
              {{ "name": "west", "type": "rectangle", "origin": [0,0,0], "u": [0,3,0], "v": [0,0,2], "material": "m" }},
              {{ "name": "east", "type": "rectangle", "origin": [4,0,0], "u": [0,0,2], "v": [0,3,0], "material": "m" }}
              {more} ],
            "luminaires": [ {{ "name": "a", "type": "point", "position": [2,1,1], "intensity_cd": 1 }} ] }}"#
        );
        inspect(&scene_from_json(&text, None, Path::new(".")).expect("valid")).mesh
    }

    /// Returns a rectangle in the ceiling's plane that faces down.
    fn ceiling(name: &str, x: f64, width: f64) -> String {
        format!(
            r#", {{ "name": "{name}", "type": "rectangle", "origin": [{x},0,2], "u": [0,3,0], "v": [{width},0,0], "material": "m" }}"#
        )
    }

    #[test]
    fn a_missing_ceiling_is_a_hole_with_its_place_and_length() {
        let found = faults("");
        assert_eq!(found.holes.len(), 1, "{found:?}");
        let hole = &found.holes[0];
        assert_eq!((hole.length_m, hole.edges, hole.min_m, hole.max_m), (14.0, 4, [0.0, 0.0, 2.0], [4.0, 3.0, 2.0]));
        assert_eq!(hole.surfaces, ["east", "north", "south", "west"]);
        assert!(faults(&ceiling("c", 0.0, 4.0)).is_empty());
    }

    #[test]
    fn a_ceiling_in_two_parts_closes_with_t_junctions_and_one_with_a_slit_does_not() {
        let found = faults(&format!("{}{}", ceiling("c1", 0.0, 1.0), ceiling("c2", 1.0, 3.0)));
        assert!(found.holes.is_empty(), "{found:?}");
        assert_eq!(found.t_junctions.count, 2);
        assert!(found.t_junctions.places_m.contains(&[1.0, 3.0, 2.0]));

        let found = faults(&format!("{}{}", ceiling("c1", 0.0, 1.0), ceiling("c2", 1.01, 2.99)));
        assert_eq!(found.holes.len(), 1, "{found:?}");
        assert!((found.holes[0].length_m - 6.02).abs() < 1e-12);
    }

    #[test]
    fn doubled_and_turned_triangles_are_counted_and_placed() {
        let found = faults(&format!("{}{}", ceiling("c", 0.0, 4.0), ceiling("again", 0.0, 4.0)));
        assert_eq!((found.duplicate_triangles.count, found.holes.len()), (2, 0), "{found:?}");
        assert_eq!(found.duplicate_triangles.surfaces, ["again"]);

        let turned =
            r#", { "name": "c", "type": "rectangle", "origin": [0,0,2], "u": [4,0,0], "v": [0,3,0], "material": "m" }"#;
        let found = faults(turned);
        assert_eq!((found.turned_edges.count, found.holes.len()), (4, 0), "{found:?}");
        assert!(found.turned_edges.places_m.contains(&[2.0, 0.0, 2.0]));
    }

    #[test]
    fn triangles_that_cover_each_other_in_one_plane_are_counted_and_placed() {
        // Two rectangles 1 m wide share a strip of 0.2 m: the halves of one overlap the halves of the other.
        let sheet = |name: &str, x: f64, v: &str, two_sided: bool| {
            format!(
                r#", {{ "name": "{name}", "type": "rectangle", "origin": [{x},1,1], "u": [1,0.3,0.2], "v": {v}, "two_sided": {two_sided}, "material": "m" }}"#
            )
        };
        let all = ceiling("c", 0.0, 4.0);
        let [up, down] = ["[0,0.5,0.1]", "[0,-0.5,-0.1]"];
        let two = format!("{all}{}{}", sheet("p", 1.0, up, false), sheet("q", 1.8, up, false));
        // The second starts 0.8 along u. It is in the same plane only if it is moved along u itself.
        assert_eq!(faults(&two).overlapping_triangles.count, 0);
        let moved = sheet("q", 1.8, up, false).replace("[1.8,1,1]", "[1.8,1.24,1.16]");
        let found = faults(&format!("{all}{}{moved}", sheet("p", 1.0, up, false)));
        assert!(found.overlapping_triangles.count > 0 && found.overlaps_searched, "{found:?}");
        assert_eq!(found.overlapping_triangles.surfaces, ["p", "q"]);
        let [x, y, z] = found.overlapping_triangles.places_m[0];
        assert!((1.8..2.0).contains(&x) && (1.2..1.8).contains(&y), "{found:?}");
        let off = 0.3 * (x - 1.0) + 5.0 * (z - 1.0 - 0.2 * (x - 1.0)) - (y - 1.0);
        assert!(off.abs() < 1e-9, "{off}: {x} {y} {z}");

        // Sheets that face opposite ways hide each other's backs, unless both are two-sided.
        let turned = sheet("q", 1.8, down, false).replace("[1.8,1,1]", "[1.8,1.74,1.26]");
        assert_eq!(faults(&format!("{all}{}{turned}", sheet("p", 1.0, up, false))).overlapping_triangles.count, 0);
        let turned = turned.replace("false", "true");
        assert!(faults(&format!("{all}{}{turned}", sheet("p", 1.0, up, true))).overlapping_triangles.count > 0);
        // A box on the floor touches it from above.
        let box_on_floor = r#", { "name": "b", "type": "box", "min": [1,1,0], "max": [2,2,1], "material": "m" }"#;
        assert_eq!(faults(&format!("{all}{box_on_floor}")).overlapping_triangles.count, 0);
    }

    #[test]
    fn a_panel_in_a_closed_room_is_no_hole_and_a_fin_on_an_edge_is_reported() {
        let panel =
            r#", { "name": "p", "type": "rectangle", "origin": [1,1,1], "u": [1,0,0], "v": [0,1,0], "material": "m" }"#;
        assert!(faults(&format!("{}{panel}", ceiling("c", 0.0, 4.0))).is_empty());
        let fin = r#", { "name": "fin", "type": "rectangle", "origin": [0,0,0], "u": [4,0,0], "v": [0,0,-1], "material": "m" }"#;
        let found = faults(&format!("{}{fin}", ceiling("c", 0.0, 4.0)));
        assert_eq!(found.odd_edges.count, 1, "{found:?}");
    }
}
