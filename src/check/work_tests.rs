//! Meshes that are made to be difficult. The work of the checks on them is counted in tests of boxes and triangles.

use std::f64::consts::TAU;
use std::fmt::Write;
use std::path::Path;

use glam::DVec3;

use super::box_tree::Budget;
use super::insides::{ON_SURFACE, SolidLookup};
use super::overlaps::{overlaps, overlaps_budget};
use super::shells::{self, Shell};
use super::{Inspection, closed_shells_of_geometries, inspect, scene_from_json};
use crate::scene::Scene;

/// Limits of the number of tests of each search on any mesh, and of the additional tests per triangle, solid or point.
const MOST_STEPS: u64 = 250_000_000;
const MOST_STEPS_EACH: u64 = 400;

/// Makes a scene of one mesh with a lamp above it.
fn scene_of(obj: &str) -> Scene {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("mesh.obj"), obj).expect("written");
    let text = r#"{ "version": 1, "materials": { "m": { "type": "diffuse", "reflectance": 0.5 } },
        "geometry": [ { "name": "mesh", "type": "mesh", "file": "mesh.obj", "material": "m" } ],
        "luminaires": [ { "name": "a", "type": "point", "position": [0,0,9], "intensity_cd": 1 } ] }"#;
    scene_from_json(text, None, folder.path()).expect("a valid scene")
}

/// Makes triangles around one vertex, in one plane or on a wavy cone.
fn fan(count: u32, height: f64) -> String {
    let mut obj = String::from("v 0 0 0\n");
    for number in 0..count {
        let angle = TAU * f64::from(number) / f64::from(count);
        writeln!(obj, "v {} {} {}", angle.cos(), angle.sin(), height * (20.0 * angle).sin()).expect("written");
    }
    for number in 0..count {
        writeln!(obj, "f 1 {} {}", number + 2, (number + 1) % count + 2).expect("written");
    }
    obj
}

/// Makes one triangle many times over, each with its own vertices or all with the same.
fn copies(count: u32, own_vertices: bool) -> String {
    let corners = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
    if !own_vertices {
        return corners.to_owned() + &"f 1 2 3\n".repeat(count as usize);
    }
    format!("{corners}f -3 -2 -1\n").repeat(count as usize)
}

/// Makes nested tetrahedra.
fn shells_about_each_other(count: u32) -> String {
    shells_facing(count, |_| true)
}

/// Makes nested tetrahedra of which some face outward and the others inward.
fn shells_facing(count: u32, outward: impl Fn(u32) -> bool) -> String {
    (0..count)
        .map(|number| {
            let r = 1.0 + 1e-4 * f64::from(number);
            let vertices = format!("v {r} {r} {r}\nv {r} -{r} -{r}\nv -{r} {r} -{r}\nv -{r} -{r} {r}\n");
            vertices
                + if outward(number) {
                    "f -4 -3 -2\nf -4 -1 -3\nf -4 -2 -1\nf -3 -1 -2\n"
                } else {
                    "f -2 -3 -4\nf -3 -1 -4\nf -1 -2 -4\nf -2 -1 -3\n"
                }
        })
        .collect()
}

/// Makes rectangles that lie on each other, each shifted a little further.
fn layers(count: u32) -> String {
    (0..count)
        .map(|number| {
            let (from, to) = (1e-4 * f64::from(number), 1.0 + 1e-4 * f64::from(number));
            format!("v {from} 0 0\nv {to} 0 0\nv {to} 1 0\nv {from} 1 0\nf -4 -3 -2 -1\n")
        })
        .collect()
}

fn assert_bounded(found: &Inspection, triangles: usize) {
    let most = MOST_STEPS + MOST_STEPS_EACH * triangles as u64;
    assert!(found.mesh.steps <= most, "{} steps for {triangles} triangles", found.mesh.steps);
    for faults in [&found.mesh.overlapping_triangles, &found.mesh.duplicate_triangles, &found.mesh.t_junctions] {
        assert!(faults.places_m.len() <= 8 && faults.surfaces.len() <= 8);
    }
    assert!(found.mesh.holes.len() <= 1000);
}

#[test]
fn a_fan_about_one_vertex_takes_few_tests_a_triangle_or_is_given_up() {
    // Out of one plane every search ends. In one plane the boxes of most slivers overlap, and the incomplete search is reported.
    let found = inspect(&scene_of(&fan(100_000, 0.3)));
    assert!(found.mesh.overlaps_searched && found.mesh.t_junctions_searched);
    assert!(found.mesh.steps < 1000 * 100_000, "{} steps", found.mesh.steps);
    let scene = scene_of(&fan(100_000, 0.0));
    let found = inspect(&scene);
    assert!(!found.mesh.overlaps_searched && found.mesh.overlapping_triangles.count == 0);
    assert!(scene.warnings.iter().any(|warning| warning.contains("too many triangles in one plane")));
    assert_bounded(&found, 100_000);
}

#[test]
fn copies_of_a_triangle_are_counted_without_a_test_of_their_pairs() {
    for own_vertices in [true, false] {
        let found = inspect(&scene_of(&copies(20_000, own_vertices)));
        assert_eq!(found.mesh.duplicate_triangles.count, 19_999);
        assert!(found.mesh.overlaps_searched);
        assert!(found.mesh.steps < 1000, "{} steps", found.mesh.steps);
    }
}

#[test]
fn layers_in_one_plane_are_counted_as_far_as_a_budget_goes() {
    let scene = scene_of(&layers(5000));
    let found = inspect(&scene);
    assert!(!found.mesh.overlaps_searched && found.mesh.overlapping_triangles.count > 10_000);
    assert!(scene.warnings.iter().any(|warning| warning.contains("at least") && warning.contains("cover each other")));
    assert_bounded(&found, 10_000);
    // Few layers are counted completely. Of the four pairs of two layers' triangles, the diagonals separate one.
    let found = inspect(&scene_of(&layers(50)));
    assert!(found.mesh.overlaps_searched);
    assert_eq!(found.mesh.overlapping_triangles.count, 3 * 50 * 49 / 2);
}

#[test]
fn shells_about_each_other_are_examined_as_far_as_a_budget_goes() {
    let scene = scene_of(&shells_about_each_other(20_000));
    assert!(scene.warnings.iter().any(|warning| warning.contains("at least") && warning.contains("solids intersect")));
    let shells = closed_shells_of_geometries(&scene);
    assert_eq!(shells.len(), 20_000);
    let size_m = shells::size_m(&scene);
    let mut budget = overlaps_budget(shells.len());
    let found = overlaps(&scene, &shells, size_m, &mut budget);
    assert!(!found.all_examined && found.count > 1000);
    assert!(budget.taken() <= MOST_STEPS + MOST_STEPS_EACH * 20_000, "{} steps", budget.taken());

    // The smallest shell decides for a point in all of them. Points in all boxes but in no shell take longer.
    let solids = SolidLookup::of(&shells, size_m);
    let (inside, steps) = solids.holding(&[DVec3::ZERO]);
    assert!(inside == [true] && steps < 300_000, "{inside:?}, {steps} steps");
    let beside: Vec<DVec3> = (0..4000).map(|number| DVec3::splat(-1.0 - 1e-4 * f64::from(number))).collect();
    let (inside, steps) = solids.holding(&beside);
    assert!(inside == vec![false; 4000] && steps < 5_000 * 4000, "{steps} steps");
}

#[test]
fn a_great_many_points_among_many_shells_take_few_tests_each() {
    // Every second shell may face inward. A row of points crosses each of them twice; a block of points lies beside most of them.
    for facing in [1, 2] {
        let scene = scene_of(&shells_facing(300, |number| number % facing == 0));
        let shells = closed_shells_of_geometries(&scene);
        assert_eq!(shells.len(), 300);
        let size_m = shells::size_m(&scene);
        let solids = SolidLookup::of(&shells, size_m);
        let row = (0..300_000).map(|number| DVec3::new(-1.2 + 8e-6 * f64::from(number), 0.11, 0.07));
        let block = (0..27_000).map(|number| {
            let [x, y, z] = [number % 30, number / 30 % 30, number / 900].map(|place| -1.1 + 0.07 * f64::from(place));
            DVec3::new(x, y, z)
        });
        let points_m: Vec<DVec3> = row.chain(block).collect();
        let (inside, steps) = solids.holding(&points_m);
        assert_eq!(inside.len(), points_m.len());
        // Testing every shell for every point would take about 2,000.
        assert!(steps < 100 * points_m.len() as u64, "{steps} steps for {} points", points_m.len());

        // The smallest shell around a point, found without the search, gives the expected answer.
        let mut by_size: Vec<&Shell> = shells.iter().collect();
        by_size.sort_by(|one, other| one.volume_m3.abs().total_cmp(&other.volume_m3.abs()));
        let encloses = |shell: &Shell, point_m: DVec3| {
            shell.encloses(point_m, ON_SURFACE * size_m, &mut Budget::of_steps(u64::MAX))
        };
        let smallest = |point_m: &DVec3| by_size.iter().find(|shell| encloses(shell, *point_m));
        let mut found = [0; 2];
        for (point_m, inside) in points_m.iter().zip(&inside).step_by(97) {
            let expected = smallest(point_m).is_some_and(|shell| shell.volume_m3 > 0.0);
            assert_eq!(*inside, expected, "{point_m}");
            found[usize::from(smallest(point_m).is_some_and(|shell| shell.volume_m3 < 0.0))] += 1;
        }
        assert!(found[0] > 100 && (facing == 1) == (found[1] == 0), "{found:?}");
    }
}

#[test]
fn points_on_the_faces_of_a_great_many_shells_are_examined_as_far_as_a_budget_goes() {
    // Every shell has a face in one plane, and all points lie in all of these faces, so no box separates them.
    let shell = |number: u32| {
        let r = 2.0 + 1e-4 * f64::from(number);
        format!("v {r} 0 0\nv -{r} {r} 0\nv -{r} -{r} 0\nv 0 0 -{r}\nf -4 -3 -2\nf -4 -1 -3\nf -4 -2 -1\nf -3 -1 -2\n")
    };
    let scene = scene_of(&(0..20_000).map(shell).collect::<String>());
    let shells = closed_shells_of_geometries(&scene);
    assert_eq!(shells.len(), 20_000);
    let solids = SolidLookup::of(&shells, shells::size_m(&scene));
    let points_m: Vec<DVec3> = (0..4000).map(|number| DVec3::new(1e-4 * f64::from(number), 0.1, 0.0)).collect();
    let (inside, steps) = solids.holding(&points_m);
    assert!((64..2000).contains(&inside.len()) && !inside.contains(&true), "{} of 4000", inside.len());
    assert!(steps <= 100_000_000 + 20 * 4000, "{steps} steps");
}

#[test]
fn a_mesh_that_twice_as_many_triangles_make_takes_hardly_more_than_twice_the_tests() {
    // Separate rectangles: a wall of tiles with only open edges.
    let tiles = |across: u32| -> String {
        let tile = |number: u32| {
            let (x, y) = (1.5 * f64::from(number % across), 1.5 * f64::from(number / across));
            format!(
                "v {x} {y} 0\nv {} {y} 0\nv {} {} 0\nv {x} {} 0\nf -4 -3 -2 -1\n",
                x + 1.0,
                x + 1.0,
                y + 1.0,
                y + 1.0
            )
        };
        (0..across * across).map(tile).collect()
    };
    let steps = [60, 120].map(|across| inspect(&scene_of(&tiles(across))).mesh.steps as f64);
    assert!(steps[1] < 5.5 * steps[0], "{steps:?} for four times as many tiles");
}

#[test]
fn geometry_finds_its_names_at_once_however_many_there_are() {
    // Duplicate and unknown names are reported as before. Of two thousand surfaces each lamp finds its own.
    let rectangle = |number: u32| {
        format!(
            r#"{{ "name": "r{number}", "type": "rectangle", "origin": [{number},0,0], "u": [0.5,0,0], "v": [0,1,0], "material": "m{}" }}"#,
            number % 100
        )
    };
    let lamp = |number: u32| {
        format!(r#"{{ "name": "l{number}", "type": "area", "surface": "r{number}", "exitance_lm_m2": 1 }}"#)
    };
    let material = |number: u32| format!(r#""m{number}": {{ "type": "diffuse", "reflectance": 0.5 }}"#);
    let list = |count: u32, one: &dyn Fn(u32) -> String| (0..count).map(one).collect::<Vec<String>>().join(",");
    let text = format!(
        r#"{{ "version": 1, "materials": {{ {} }}, "geometry": [ {} ], "luminaires": [ {} ] }}"#,
        list(100, &material),
        list(2000, &rectangle),
        list(2000, &lamp)
    );
    let scene = scene_from_json(&text, None, Path::new(".")).expect("a valid scene");
    let found = inspect(&scene);
    assert!((0..2000).all(|number| found.luminaires[number].surfaces == [format!("r{number}")]));
    assert!((0..2000).all(|number| found.surfaces[number].material == format!("m{}", number % 100)));
}
