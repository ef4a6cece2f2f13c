//! Walks compared with chains for light through flat mirrors, curved mirrors and sheets close to a lamp. Walks use light samples of images
//! and light-path connections from the surfaces that lamps light. Chains use neither.

use std::path::Path;

use luxmc::base::polygon::polygon_illuminance_lx;
use luxmc::check::scene_from_json;
use luxmc::scene::{Elements, Scene};
use luxmc::solver::{MapSelection, Method, Settings, solve};

use crate::common::Silent;

const SEEDS: u64 = 8;
/// Student's t of 14 degrees of freedom at α = 1e-5 on each side.
const T: f64 = 6.2;

fn scene(geometry: &str, luminaires: &str, receivers: &str) -> Scene {
    let text = format!(
        r#"{{ "version": 1,
            "materials": {{ "grey": {{ "type": "diffuse", "reflectance": 0.5 }}, "black": {{ "type": "diffuse", "reflectance": 0 }},
                "mirror": {{ "type": "mirror", "reflectance": 0.9 }},
                "gloss": {{ "type": "phong", "diffuse_reflectance": 0.2, "specular_reflectance": 0.3, "exponent": 12 }},
                "shade": {{ "type": "translucent", "diffuse_reflectance": 0.4, "diffuse_transmittance": 0.3 }} }},
            "geometry": [ {geometry} ], "luminaires": [ {luminaires} ], "receivers": [ {receivers} ] }}"#
    );
    scene_from_json(&text, None, Path::new(".")).expect("a valid scene")
}

/// Mean over seeds and its standard error.
fn over_seeds(of_seed: impl Fn(u64) -> f64) -> (f64, f64) {
    let found: Vec<f64> = (0..SEEDS).map(of_seed).collect();
    let mean = found.iter().sum::<f64>() / SEEDS as f64;
    let squares: f64 = found.iter().map(|value| (value - mean).powi(2)).sum();
    (mean, (squares / (SEEDS * (SEEDS - 1)) as f64).sqrt())
}

/// Mean indirect illuminance of the receivers by walks, in lx.
fn by_walks(scene: &Scene, method: Method, walks: u64) -> (f64, f64) {
    over_seeds(|seed| {
        let chains = Some(walks * scene.receivers[0].points.len() as u64);
        let settings = Settings { method, seed, chains, maps: MapSelection::Receivers, ..Settings::default() };
        let solution = solve(scene, &settings, &Silent);
        let values = &solution.maps[0].values.indirect;
        values.iter().sum::<f64>() / values.len() as f64
    })
}

/// Mean indirect illuminance of the floor by chains, in lx.
fn by_chains(scene: &Scene, chains: u64) -> (f64, f64) {
    let elements = Elements::of(scene);
    let is_floor = |index: usize| {
        let element = elements.element(index as u32);
        scene.corners_m(element.triangle).iter().all(|corner_m| corner_m.z.abs() < 1e-9)
    };
    over_seeds(|seed| {
        let settings = Settings {
            method: Method::Collision,
            seed,
            chains: Some(chains),
            maps: MapSelection::Elements,
            ..Settings::default()
        };
        let solution = solve(scene, &settings, &Silent);
        let values = solution.maps[0].values.indirect.iter().enumerate();
        let on_floor: Vec<f64> = values.filter(|(index, _)| is_floor(*index)).map(|(_, lx)| *lx).collect();
        on_floor.iter().sum::<f64>() / on_floor.len() as f64
    })
}

fn agree(what: &str, (one, one_error): (f64, f64), (other, other_error): (f64, f64), fault: f64) {
    let error = one_error.hypot(other_error);
    assert!((one - other).abs() < T * error, "{what}: {one} ± {one_error}, {other} ± {other_error}");
    assert!((fault * one - other).abs() > T * error, "{what}: the fault of {fault} passed, ± {error}");
}

const FLOOR: &str = r#"{ "name": "floor", "type": "grid", "origin": [0.125,0.125,0], "u": [3.75,0,0], "v": [0,2.75,0], "columns": 16, "rows": 12 }"#;
const ROOM: &str =
    r#"{ "name": "room", "type": "box", "min": [0,0,0], "max": [4,3,2.5], "facing": "inward", "material": "grey" }"#;

/// A screen hides a panel from the points, and a mirror shows it. The points get 0.9 times the illuminance of the image, with uniform rays
/// and with guided ones. N = 8 seeds of 256 walks from 35 points; 4 % (the planted fault) is detected.
#[test]
fn a_panel_that_a_mirror_alone_shows_has_its_exact_illuminance() {
    let geometry = r#"
        { "name": "mirror", "type": "rectangle", "origin": [0,-10,0], "u": [0,20,0], "v": [0,0,20], "material": "mirror" },
        { "name": "screen", "type": "rectangle", "origin": [2,-9,0.4], "u": [0,18,0], "v": [0,0,9], "material": "black", "two_sided": true },
        { "name": "panel", "type": "rectangle", "origin": [1.8,-0.2,1], "u": [0,0,0.4], "v": [0,0.4,0], "material": "black" }"#;
    let light = r#"{ "name": "light", "type": "area", "surface": "panel", "exitance_lm_m2": 20000 }"#;
    let points = r#"{ "name": "points", "type": "grid", "origin": [0.2,-2,0.1], "u": [1.4,0,0], "v": [0,4,0], "columns": 5, "rows": 7 }"#;
    let scene = scene(geometry, light, points);
    // The image's front faces +x.
    let image_m =
        [[-1.8, -0.2, 1.0], [-1.8, 0.2, 1.0], [-1.8, 0.2, 1.4], [-1.8, -0.2, 1.4]].map(glam::DVec3::from_array);
    let points = &scene.receivers[0].points;
    let of_point = |point: &luxmc::scene::ReceiverPoint| {
        0.9 * polygon_illuminance_lx(point.position_m, point.normal, &image_m, 20_000.0)
    };
    let exact = points.iter().map(of_point).sum::<f64>() / points.len() as f64;
    for (name, method) in [("auto", Method::Auto), ("walks", Method::Collision)] {
        agree(name, by_walks(&scene, method, 256), (exact, 0.0), 1.04);
    }
}

/// A panel in a room with a flat mirror, a mirrored ball and a glossy cupboard. Light samples of images must contain exactly what rays no
/// longer count. N = 8 seeds; 5 % more (the planted fault) is detected.
#[test]
#[ignore = "takes long: .ci/run runs it"]
fn walks_that_sample_images_in_flat_mirrors_find_what_chains_find() {
    let geometry = format!(
        r#"{ROOM}, {{ "name": "mirror", "type": "rectangle", "origin": [0.02,0.4,0.3], "u": [0,2,0], "v": [0,0,1.8], "material": "mirror" }},
        {{ "name": "ball", "type": "sphere", "center": [3.2,2.2,0.8], "radius": 0.35, "material": "mirror" }},
        {{ "name": "cupboard", "type": "box", "min": [2,2.3,0.9], "max": [2.6,2.9,1.9], "material": "gloss" }},
        {{ "name": "panel", "type": "rectangle", "origin": [2,1,2.3], "u": [0,0.5,0], "v": [0.5,0,0], "material": "grey" }}"#
    );
    let light = r#"{ "name": "light", "type": "area", "surface": "panel", "exitance_lm_m2": 8000 }"#;
    let scene = scene(&geometry, light, FLOOR);
    let chains = by_chains(&scene, 1_000_000);
    agree("walks", by_walks(&scene, Method::Collision, 512), chains, 1.05);
    agree("auto", by_walks(&scene, Method::Auto, 512), chains, 1.05);
}

/// A lamp between four translucent sheets. Light-path connections start from both sides of the sheets. N = 8 seeds; 6 % more (the planted
/// fault) is detected.
#[test]
#[ignore = "takes long: .ci/run runs it"]
fn walks_that_connect_to_packets_from_a_shade_find_what_chains_find() {
    let side = |name: &str, origin: &str, u: &str| {
        format!(
            r#"{{ "name": "{name}", "type": "rectangle", "origin": {origin}, "u": {u}, "v": [0,0,0.3], "material": "shade", "two_sided": true }}"#
        )
    };
    let shade = [
        side("south", "[1.8,1.3,1.6]", "[0.4,0,0]"),
        side("north", "[1.8,1.7,1.6]", "[0.4,0,0]"),
        side("west", "[1.8,1.3,1.6]", "[0,0.4,0]"),
        side("east", "[2.2,1.3,1.6]", "[0,0.4,0]"),
    ];
    let lamp = r#"{ "name": "lamp", "type": "point", "position": [2.03,1.46,1.75], "luminous_flux_lm": 1000 }"#;
    let scene = scene(&format!("{ROOM}, {}", shade.join(", ")), lamp, FLOOR);
    let chains = by_chains(&scene, 1_000_000);
    agree("walks", by_walks(&scene, Method::Collision, 1024), chains, 1.06);
    agree("auto", by_walks(&scene, Method::Auto, 1024), chains, 1.06);
}
