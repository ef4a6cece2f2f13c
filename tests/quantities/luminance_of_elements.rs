//! Luminance of the elements of a surface towards an eye, against images by hand, the plain line of sight, and Kirchhoff's law.

use std::path::Path;

use glam::DVec3;
use luxmc::check::scene_from_json;
use luxmc::maps::MapValues;
use luxmc::scene::Scene;
use luxmc::solver::MapSelection;

use crate::common::with_chains;

const SEED: u64 = 9;

fn read(materials: &str, geometry: &str, luminaires: &str, receivers: &str) -> Result<Scene, String> {
    let text = format!(
        r#"{{ "version": 1, "materials": {{ "black": {{ "type": "diffuse", "reflectance": 0 }}, {materials} }}, "geometry": [ {geometry} ],
        "luminaires": [ {luminaires} ], "receivers": [ {receivers} ] }}"#
    );
    scene_from_json(&text, None, Path::new(".")).map_err(|error| error.to_string())
}

fn scene_of(materials: &str, geometry: &str, luminaires: &str, receivers: &str) -> Scene {
    read(materials, geometry, luminaires, receivers).unwrap_or_else(|error| panic!("{error}"))
}

fn values(scene: &Scene, chains: u64) -> Vec<MapValues> {
    with_chains(scene, SEED, MapSelection::Receivers, chains).maps.into_iter().map(|map| map.values).collect()
}

/// A mirror shows a bright panel only in those elements whose mirrored line of sight meets it, and is black in the others. In the diffuse
/// column of the element map all of it would be black.
#[test]
fn elements_of_a_mirror_show_what_it_mirrors() {
    let geometry = r#"{ "name": "floor", "type": "rectangle", "origin": [-2,0,0], "u": [4,0,0], "v": [0,1,0], "material": "silver", "max_element_edge": 0.3 },
        { "name": "panel", "type": "rectangle", "origin": [1,-1,2], "u": [0,3,0], "v": [1,0,0], "material": "black" }"#;
    let light = r#"{ "name": "panel", "type": "area", "surface": "panel", "exitance_lm_m2": 314.1592653589793 }"#;
    let silver = r#""silver": { "type": "mirror", "reflectance": 0.8 }"#;
    let eye = r#"{ "name": "seen", "type": "luminance", "position": [-1.5,0.5,2], "surface": "floor" }"#;
    let scene = scene_of(silver, geometry, light, eye);
    let (points, values) = (&scene.receivers[0].points, &values(&scene, 64)[0]);
    let area_m2: f64 = points.iter().map(|point| point.weight).sum();
    assert!((area_m2 - 4.0).abs() < 1e-9, "all of the floor turns to the eye: {area_m2}");
    let mut bright = 0;
    for (point, value) in points.iter().zip(&values.value) {
        let place_m = point.position_m + point.normal * (point.position_m.z / -point.normal.z);
        // The eye is as high as the panel. The mirrored line therefore reaches that height again after the same distance.
        let meets_m = 2.0 * place_m.x + 1.5;
        if (meets_m - 1.0).abs() > 1e-3 && (meets_m - 2.0).abs() > 1e-3 {
            let exact = if (1.0..2.0).contains(&meets_m) { 80.0 } else { 0.0 };
            assert!((value - exact).abs() < 1e-6, "{place_m}: {value}, exact {exact}");
            bright += usize::from(exact > 0.0);
        }
    }
    assert!(bright > 10, "{bright}");
}

/// Every element of a lacquered sheet under a lamp has the luminance that a line of sight from the eye to its centre gives. A board between
/// eye and sheet changes nothing. Another eye gives other values (the planted fault).
#[test]
fn elements_shine_towards_the_eye_whatever_stands_between() {
    let lacquer =
        r#""lacquer": { "type": "phong", "diffuse_reflectance": 0.2, "specular_reflectance": 0.5, "exponent": 50 }"#;
    let sheet = r#"{ "name": "sheet", "type": "rectangle", "origin": [-1,-1,0], "u": [2,0,0], "v": [0,2,0], "material": "lacquer", "max_element_edge": 0.6 }"#;
    let board = r#"{ "name": "board", "type": "rectangle", "origin": [0.9,-3,0.8], "u": [0,6,0], "v": [0.3,0,0.3], "material": "black", "two_sided": true }"#;
    let lamp = r#"{ "name": "lamp", "type": "point", "position": [-1,0,1.5], "intensity_cd": 100 }"#;
    let towards =
        |eye: &str| format!(r#"{{ "name": "seen", "type": "luminance", "position": {eye}, "surface": "sheet" }}"#);
    let bare = scene_of(lacquer, sheet, lamp, &towards("[1.4,0.2,1.6]"));
    let eye_m = DVec3::new(1.4, 0.2, 1.6);
    let directions: Vec<String> = bare.receivers[0]
        .points
        .iter()
        .map(|point| format!("[{},{},{}]", point.normal.x, point.normal.y, point.normal.z))
        .collect();
    let plain = format!(
        r#"{{ "name": "plain", "type": "luminance", "position": [{},{},{}], "directions": [{}] }}"#,
        eye_m.x,
        eye_m.y,
        eye_m.z,
        directions.join(",")
    );
    let by_sight = &values(&scene_of(lacquer, sheet, lamp, &plain), 4000)[0];
    let own = &values(&bare, 4000)[0];
    let behind = &values(&scene_of(lacquer, &format!("{sheet}, {board}"), lamp, &towards("[1.4,0.2,1.6]")), 4000)[0];
    let other = &values(&scene_of(lacquer, sheet, lamp, &towards("[-1.4,0.2,1.6]")), 4000)[0];
    let differences = |a: &MapValues, b: &MapValues| {
        let pairs = a.direct.iter().zip(&b.direct);
        pairs.map(|(a, b)| (a - b).abs() / b.max(1.0)).fold(0.0, f64::max)
    };
    assert!(own.direct.iter().copied().fold(0.0, f64::max) > 4.0 * 0.2 * 30.0 / std::f64::consts::PI, "a highlight");
    assert!(differences(own, by_sight) < 2e-3, "{}", differences(own, by_sight));
    assert!(differences(behind, own) < 2e-3, "{}", differences(behind, own));
    assert!(differences(other, own) > 0.1, "the planted fault passed");
}

/// In an isothermal room everything has the luminance L₀ towards every eye, for every material: within 5 standard errors for each element
/// (t with 15 degrees of freedom, 2e-4 each) and 4.5 for the mean. 3 % more, the planted fault, is detected.
#[test]
fn in_an_isothermal_room_all_elements_have_its_luminance() {
    let materials = r#""grey": { "type": "diffuse", "reflectance": 0.5 }, "lacquer": { "type": "phong", "diffuse_reflectance": 0.2, "specular_reflectance": 0.4, "exponent": 20 }"#;
    let room = r#"{ "name": "room", "type": "box", "min": [0,0,0], "max": [2,2,2], "facing": "inward", "material": "grey", "materials": { "floor": "lacquer" },
        "max_element_edge": 0.75 }"#;
    let glow = |part: &str, absorbed: f64| {
        let exitance = 100.0 * std::f64::consts::PI * absorbed;
        format!(r#"{{ "name": "{part}", "type": "area", "surface": "room/{part}", "exitance_lm_m2": {exitance} }}"#)
    };
    let parts = ["ceiling", "x_min", "x_max", "y_min", "y_max"].map(|part| glow(part, 0.5));
    let lights = format!("{}, {}", parts.join(", "), glow("floor", 0.4));
    let eye = r#"{ "name": "seen", "type": "luminance", "position": [0.4,0.7,1.2], "surface": "room" }"#;
    let scene = scene_of(materials, room, &lights, eye);
    let solution = with_chains(&scene, SEED, MapSelection::Receivers, 300_000);
    let values = &solution.maps[0].values;
    assert!(values.value.len() > 100);
    for (value, error) in values.value.iter().zip(&values.standard_error) {
        assert!((value - 100.0).abs() < 5.0 * error + 1e-6, "{value} ± {error}");
    }
    let mean = solution.maps[0].tables[0].average;
    assert!((mean.value - 100.0).abs() < 4.5 * mean.standard_error, "{mean:?}");
    assert!((1.03 * mean.value - 100.0).abs() > 4.5 * mean.standard_error, "the planted fault passed: {mean:?}");
}

#[test]
fn a_surface_that_turns_away_from_the_eye_is_refused() {
    let sheet = r#"{ "name": "sheet", "type": "rectangle", "origin": [0,0,0], "u": [1,0,0], "v": [0,1,0], "material": "black" }"#;
    let lamp = r#"{ "name": "lamp", "type": "point", "position": [0,0,1], "intensity_cd": 1 }"#;
    let towards = |eye: &str, more: &str| {
        let receiver =
            format!(r#"{{ "name": "seen", "type": "luminance", "position": {eye}, "surface": "sheet" {more} }}"#);
        read(r#""grey": { "type": "diffuse", "reflectance": 0.5 }"#, sheet, lamp, &receiver).map(|_| ())
    };
    assert_eq!(towards("[0.2,0.3,1]", ""), Ok(()));
    for (eye, more, said) in [
        ("[0.2,0.3,-1]", "", "no reflecting side of this surface"),
        ("[0.2,0.3,1]", r#", "directions": [[1,0,0]]"#, "one set of directions"),
    ] {
        let told = towards(eye, more).expect_err(eye);
        assert!(told.contains(said), "{told}");
    }
}
