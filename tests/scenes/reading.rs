//! The scene that a good scene file gives.

use std::f64::consts::PI;
use std::path::{Path, PathBuf};

use glam::DVec3;
use luxmc::check::{inspect, read_scene, scene_from_json};
use luxmc::scene::{Emission, ReceiverLayout, Scene};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/scenes")
}

fn office() -> Scene {
    read_scene(&folder().join("office.json")).unwrap_or_else(|error| panic!("{error}"))
}

fn scene(text: &str) -> Scene {
    scene_from_json(text, None, &folder()).unwrap_or_else(|error| panic!("{error}"))
}

/// A white box of one cubic metre that faces outward, a lamp of 1 cd above it, and the given further objects.
fn with(unit: &str, geometry: &str, luminaires: &str, receivers: &str) -> Scene {
    scene(&format!(
        r#"{{ "version": 1, "length_unit": "{unit}", "materials": {{ "m": {{ "type": "diffuse", "reflectance": 0.5 }} }},
        "geometry": [{geometry}], "luminaires": [{luminaires}], "receivers": [{receivers}] }}"#
    ))
}

const CUBE: &str = r#"{ "name": "cube", "type": "box", "min": [0,0,0], "max": [1,1,1], "material": "m" }"#;
const ROOM: &str =
    r#"{ "name": "room", "type": "box", "min": [-4,-4,-4], "max": [4,4,4], "facing": "inward", "material": "m" }"#;
const LAMP: &str = r#"{ "name": "lamp", "type": "point", "position": [0.5,0.5,2], "intensity_cd": 1 }"#;

#[test]
fn the_office_has_its_parts_areas_and_materials() {
    let scene = office();
    let facts = inspect(&scene);
    let surfaces: Vec<(&str, &str, f64)> = facts
        .surfaces
        .iter()
        .map(|surface| (surface.name.as_str(), surface.material.as_str(), (surface.area_m2 * 1e9).round() / 1e9))
        .collect();
    assert_eq!(
        surfaces[..9],
        [
            ("room/floor", "carpet", 48.0),
            ("room/ceiling", "plaster", 48.0),
            ("room/x_min", "plaster", 18.0),
            ("room/x_max", "plaster", 18.0),
            ("room/y_min", "plaster", 24.0),
            ("room/y_max", "plaster", 24.0),
            ("desks/Wood", "lacquer", 2.0 * 1.6 * 0.8 + 2.0 * (1.6 + 0.8) * 0.03),
            ("desks/Steel", "Steel", 2.0 * 0.4 * 0.6 + 2.0 * (0.4 + 0.6) * 0.7),
            ("panel", "plaster", 0.72),
        ]
        .map(|(name, material, area)| (name, material, (area * 1e9f64).round() / 1e9))
    );
    let ball = &facts.surfaces[9];
    let exact_m2 = 4.0 * PI * 0.3 * 0.3;
    assert!(ball.area_m2 < exact_m2 && ball.area_m2 > 0.995 * exact_m2);
    assert!(facts.closed);
    assert_eq!((facts.bounds_min_m, facts.bounds_max_m), ([0.0; 3], [8.0, 6.0, 3.0]));
    // 8 m × 6 m: triangles with a longest edge of 10 m, divided into 40 per side.
    assert_eq!(facts.surfaces[0].elements, 2 * 40 * 40);
    assert!(scene.warnings.iter().any(|warning| warning.contains("ball") && warning.contains("% too small")));
    serde_json::to_string(&facts).expect("facts become JSON");
}

#[test]
fn a_turned_mesh_lies_where_the_turn_puts_it() {
    let scene = office();
    let desks = inspect(&scene);
    let shell = desks.shells.iter().find(|shell| shell.surfaces == ["desks/Wood"]).expect("the desk top");
    assert!(shell.closed && shell.facing == Some("outward"));
    assert!((shell.volume_m3.expect("closed") - 1.6 * 0.8 * 0.03).abs() < 1e-12);
    // A quarter turn about z takes (1.6, 0.8) to (−0.8, 1.6).
    let surface = scene.surfaces.iter().find(|surface| surface.name == "desks/Wood").expect("the desk top");
    let corners: Vec<DVec3> = surface.triangles.clone().flat_map(|triangle| scene.corners_m(triangle)).collect();
    let low = corners.iter().copied().fold(DVec3::INFINITY, DVec3::min);
    let high = corners.iter().copied().fold(DVec3::NEG_INFINITY, DVec3::max);
    assert!(low.distance(DVec3::new(0.2, 2.0, 0.72)) < 1e-15 && high.distance(DVec3::new(1.0, 3.6, 0.75)) < 1e-15);
}

#[test]
fn luminaires_are_maintained_and_follow_their_laws() {
    let scene = office();
    let flux =
        |name: &str| scene.luminaires.iter().find(|luminaire| luminaire.name == name).expect(name).luminous_flux_lm;
    assert!((flux("lamp") - 4.0 * PI * 800.0).abs() < 1e-9);
    assert!((flux("spot") - 600.0).abs() < 1e-12);
    assert!((flux("globe") - 1500.0).abs() < 1e-12);
    assert!((flux("troffer") - 4000.0 * 0.72 * 0.5 * 0.8).abs() < 1e-9);
    let Emission::Lambertian { intensity_cd, axis, .. } = scene.luminaires[1].emission else { panic!("lambertian") };
    assert!((intensity_cd - 600.0 / PI).abs() < 1e-12 && axis == -DVec3::Z);
    let Emission::Sphere { exitance_lm_m2, .. } = scene.luminaires[2].emission else { panic!("a sphere") };
    assert!((exitance_lm_m2 - 1500.0 / (4.0 * PI * 0.15 * 0.15)).abs() < 1e-9);
}

#[test]
fn an_area_luminaire_shares_its_flux_over_all_that_emits() {
    for (surface, side, area_m2) in [("cube", "both", 12.0), ("cube", "front", 6.0), ("cube/floor", "back", 1.0)] {
        let area = format!(
            r#"{{ "name": "l", "type": "area", "surface": "{surface}", "side": "{side}", "luminous_flux_lm": 60 }}"#
        );
        let scene = with("m", CUBE, &area, "");
        let Emission::Area { exitance_lm_m2, .. } = scene.luminaires[0].emission else { panic!("an area") };
        assert!((exitance_lm_m2 - 60.0 / area_m2).abs() < 1e-12, "{surface} {side}");
        assert_eq!(scene.luminaires[0].luminous_flux_lm, 60.0);
    }
}

#[test]
fn lengths_become_metres_and_photometric_quantities_stay() {
    let cube = CUBE.replace("[1,1,1]", "[2700,2700,2700]").replace('}', r#", "max_element_edge": 900 }"#);
    let lamp = LAMP.replace("[0.5,0.5,2]", "[100,200,2000]");
    let grid = r#"{ "name": "g", "type": "grid", "surface": "cube/ceiling", "height": 100, "margin": 350, "spacing": 500 },
                  { "name": "p", "type": "points", "file": "probes.csv" }"#;
    let scene = with("mm", &cube, &lamp, grid);
    assert_eq!(scene.vertices_m[7], DVec3::splat(2.7));
    assert_eq!(scene.divisions[0], 5); // 2.7 m · √2 / 0.9 m = 4.24
    let Emission::Isotropic { position_m, intensity_cd } = scene.luminaires[0].emission else { panic!("isotropic") };
    assert_eq!((position_m, intensity_cd), (DVec3::new(0.1, 0.2, 2.0), 1.0));
    let points = &scene.receivers[0].points;
    assert_eq!(points.len(), 16);
    assert!(points[0].position_m.distance(DVec3::new(0.6, 0.6, 2.8)) < 1e-15 && points[0].normal == DVec3::Z);
    assert!(points[1].position_m.distance(DVec3::new(1.1, 0.6, 2.8)) < 1e-15);
    assert!((points.iter().map(|point| point.weight).sum::<f64>() - 4.0).abs() < 1e-12);
    assert_eq!(scene.receivers[1].points[0].position_m, DVec3::new(0.001, 0.001, 0.0008));
}

#[test]
fn grids_have_their_points_where_the_contract_says() {
    let scene = office();
    let plane = &scene.receivers[0];
    assert_eq!(plane.points.len(), 32 * 24);
    assert_eq!(plane.points[0].position_m, DVec3::new(0.25, 0.25, 0.8));
    assert!(plane.points[32 * 24 - 1].position_m.distance(DVec3::new(7.75, 5.75, 0.8)) < 1e-12);
    assert!(plane.points[31].position_m.distance(DVec3::new(7.75, 0.25, 0.8)) < 1e-12);
    assert!(plane.points.iter().all(|point| point.normal == DVec3::Z));
    let ReceiverLayout::Grid { area_m2, .. } = plane.layout else { panic!("a grid") };
    assert!((area_m2 - 7.5 * 32.0 / 31.0 * 5.5 * 24.0 / 23.0).abs() < 1e-12);

    // EN 12464-1 on 7 m × 5 m: p = 0.2·5^(log₁₀ 7) = 0.779 m, which gives 9 × 6 points.
    let ReceiverLayout::Grid { columns, rows, origin_m, area_m2, .. } = scene.receivers[1].layout else {
        panic!("a grid")
    };
    assert_eq!((columns, rows), (9, 6));
    assert!((area_m2 - 35.0).abs() < 1e-12);
    assert!(origin_m.distance(DVec3::new(0.5 + 3.5 / 9.0, 0.5 + 2.5 / 6.0, 0.8)) < 1e-12);
}

#[test]
fn a_single_column_or_row_sits_in_the_middle() {
    let grid =
        r#"{ "name": "g", "type": "grid", "origin": [0,0,2], "u": [2,0,0], "v": [0,4,0], "columns": 1, "rows": 3 }"#;
    let scene = with("m", CUBE, LAMP, grid);
    let places: Vec<DVec3> = scene.receivers[0].points.iter().map(|point| point.position_m).collect();
    assert_eq!(places, [DVec3::new(1.0, 0.0, 2.0), DVec3::new(1.0, 2.0, 2.0), DVec3::new(1.0, 4.0, 2.0)]);
    let ReceiverLayout::Grid { area_m2, .. } = scene.receivers[0].layout else { panic!("a grid") };
    assert!((area_m2 - 2.0 * 4.0 * 3.0 / 2.0).abs() < 1e-12);
}

/// Which of six points is inside: in the cube, on its top, on its edge, above it, beside it in its box's corner, far away.
fn insides(geometry: &str) -> Vec<bool> {
    let grid = r#"{ "name": "p", "type": "points", "file": "inside.csv" }"#;
    with("m", geometry, LAMP, grid).receivers[0].points.iter().map(|point| point.inside).collect()
}

#[test]
fn points_inside_of_solids_are_marked_and_those_on_them_are_not() {
    let solid = [true, false, false, false, false, false];
    assert_eq!(insides(CUBE), solid);
    assert_eq!(insides(&format!("{CUBE}, {ROOM}")), solid);
    assert_eq!(insides(&CUBE.replace('}', r#", "facing": "inward" }"#)), [false; 6]);

    // A room in a larger solid is not an inside, and neither is a hollow in a solid.
    let hull = ROOM.replace("room", "hull").replace('4', "5").replace("inward", "outward");
    assert_eq!(insides(&format!("{hull}, {ROOM}, {CUBE}")), solid);
    assert_eq!(insides(&hull), [true, true, true, true, true, false]);
    let hollow = CUBE.replace('}', r#", "facing": "inward" }"#);
    assert_eq!(insides(&format!("{hollow}, {hull}")), [false, true, true, true, true, false]);
}

#[test]
fn a_sphere_is_a_solid_and_an_open_surface_is_none() {
    let sphere = r#"{ "name": "s", "type": "sphere", "center": [0.5,0.5,0.5], "radius": 0.6, "material": "m" }"#;
    assert!(insides(sphere)[0]);
    let plane =
        r#"{ "name": "s", "type": "rectangle", "origin": [0,0,0], "u": [1,0,0], "v": [0,1,0], "material": "m" }"#;
    assert_eq!(insides(plane), [false; 6]);
}

#[test]
fn a_room_made_of_rectangles_is_closed_and_one_with_a_gap_is_not() {
    let rectangle = |name: &str, origin: &str, u: &str, v: &str| {
        format!(
            r#"{{ "name": "{name}", "type": "rectangle", "origin": {origin}, "u": {u}, "v": {v}, "material": "m" }}"#
        )
    };
    let faces = [
        rectangle("floor", "[0,0,0]", "[1,0,0]", "[0,1,0]"),
        rectangle("ceiling", "[0,0,3]", "[0,1,0]", "[1,0,0]"),
        rectangle("south", "[0,0,0]", "[0,0,3]", "[1,0,0]"),
        rectangle("north", "[0,1,0]", "[1,0,0]", "[0,0,3]"),
        rectangle("west", "[0,0,0]", "[0,1,0]", "[0,0,3]"),
        rectangle("east", "[1,0,0]", "[0,0,3]", "[0,1,0]"),
    ];
    let closed = inspect(&with("m", &faces.join(","), LAMP, ""));
    assert!(closed.closed && closed.shells.len() == 1 && closed.shells[0].facing == Some("inward"));
    assert!((closed.shells[0].volume_m3.expect("closed") - 3.0).abs() < 1e-12);
    assert!(!inspect(&with("m", &faces[1..].join(","), LAMP, "")).closed);
    assert!(!inspect(&with("m", CUBE, LAMP, "")).closed);
}

#[test]
fn what_a_user_should_know_is_said() {
    let warned = |scene: &Scene, words: &str| scene.warnings.iter().any(|warning| warning.contains(words));
    let small = with("mm", CUBE, LAMP, "");
    assert!(warned(&small, "length_unit") && warned(&small, "outside of the scene's bounding box"));
    assert!(warned(&small, "maintenance_factor"));
    let tower = CUBE.replace("[1,1,1]", "[1,1,1001]").replace("\"type\"", "\"facing\": \"outward\", \"type\"");
    assert!(warned(&with("m", &tower, LAMP, ""), "length_unit"));
    assert!(!warned(&with("m", ROOM, LAMP, ""), "length_unit"));
    let maintained = with("m", ROOM, &LAMP.replace('}', r#", "maintenance_factor": 1 }"#), "");
    assert!(maintained.warnings.is_empty(), "{:?}", maintained.warnings);
    let mesh = r#"{ "name": "d", "type": "mesh", "file": "slivers.obj", "material": "m" }"#;
    assert!(warned(&with("m", mesh, LAMP, ""), "d: 2 triangles without an area were dropped"));
    let grid = r#"{ "name": "g", "type": "grid", "origin": [0.5,0.5,0.5], "u": [2,0,0], "v": [0,2,0], "columns": 2, "rows": 2 }"#;
    assert!(warned(&with("m", CUBE, LAMP, grid), "g: 1 of 4 points"));
}

#[test]
fn a_white_room_is_good_where_something_else_absorbs() {
    let room = ROOM.replace("\"m\"", "\"white\"");
    let text = |geometry: &str, luminaire: &str| {
        format!(
            r#"{{ "version": 1, "materials": {{ "white": {{ "type": "diffuse", "reflectance": 1 }}, "m": {{ "type": "diffuse", "reflectance": 0.5 }} }},
            "geometry": [{geometry}], "luminaires": [{luminaire}] }}"#
        )
    };
    let globe = r#"{ "name": "globe", "type": "sphere", "center": [2,2,2], "radius": 0.1, "luminous_flux_lm": 1 }"#;
    let panel = r#"{ "name": "panel", "type": "rectangle", "origin": [0,0,0], "u": [1,0,0], "v": [0,1,0], "material": "white" }"#;
    scene(&text(&format!("{room}, {CUBE}"), LAMP));
    scene(&text(&room, globe));
    scene(&text(&format!("{room}, {panel}"), LAMP));
    scene(&text(&room.replace("inward", "outward"), LAMP));
    for geometry in [room.clone(), format!("{room}, {}", CUBE.replace("\"m\"", "\"white\""))] {
        let error = scene_from_json(&text(&geometry, LAMP), None, &folder()).expect_err("nothing absorbs");
        assert!(error.what.contains("absorbs almost nothing"), "{error}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 300, rng_seed: RngSeed::Fixed(1), failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn a_mangled_file_is_read_or_refused_but_never_breaks(
        cut in 0usize..3000, from in 0usize..3000, length in 0usize..12,
        patch in prop::sample::select(vec!["", "-", "1e999", "null", "{", "]", "\"", ",", "0", "é", "\u{0}", "[[", "1e300", "-1e-320", "\"room\"", "\\u12"]),
    ) {
        let text = include_str!("../data/scenes/office.json");
        let floor = |mut byte: usize| { byte = byte.min(text.len()); while !text.is_char_boundary(byte) { byte -= 1; } byte };
        let mangled = format!("{}{}{}", &text[..floor(from)], patch, &text[floor(from + length)..]);
        for version in [&text[..floor(cut)], &mangled] {
            if let Err(error) = scene_from_json(version, None, &folder()) {
                prop_assert!(!error.to_string().is_empty());
                // A mangled file name refers to a file that does not exist. The place is then the object that names it.
                prop_assert!(error.place.is_some() || error.named_by.is_some(), "{error}");
            }
        }
    }
}
