//! Radiosity against exact solutions, flux balance and chains.

use std::f64::consts::PI;
use std::path::Path;

use glam::DVec3;
use luxmc::analytic::box_room::{BoxRoom, RoomSource};
use luxmc::methods::solve_by_radiosity;
use luxmc::radiosity::Radiosity;
use luxmc::scene::{Elements, Scene};
use luxmc::solver::{MapSelection, Settings, Solution, StopReason};

use crate::cli_support;
use crate::common;

fn to_target(scene: &Scene, maps: MapSelection, target_error: f64) -> Solution {
    let target_error = Some(target_error);
    let settings = Settings {
        method: luxmc::solver::Method::Collision,
        elements: luxmc::solver::ElementChoice::Given,
        seed: 0,
        target_error,
        chains: None,
        time_limit_s: None,
        maps,
        threads: None,
    };
    solve_by_radiosity(scene, &settings, &common::Silent).unwrap_or_else(|error| panic!("{error}"))
}

/// A room of 6 m × 4 m × 3 m made of rectangles, with two for the floor. It has a luminous ceiling field, a downlight on the ceiling, and
/// points inside the room whose normals are parallel to no axis.
fn tiled_room() -> Scene {
    let rectangle = |name: &str, origin: [f64; 3], u: [f64; 3], v: [f64; 3], material: &str| {
        format!(
            r#"{{"name": "{name}", "type": "rectangle", "origin": {origin:?}, "u": {u:?}, "v": {v:?},
                "material": "{material}", "max_element_edge": 0.8}}"#
        )
    };
    let (x, y, z) = ([6.0, 0.0, 0.0], [0.0, 4.0, 0.0], [0.0, 0.0, 3.0]);
    let geometry = [
        rectangle("floor a", [0.0; 3], [2.0, 0.0, 0.0], y, "dark"),
        rectangle("floor b", [2.0, 0.0, 0.0], [4.0, 0.0, 0.0], y, "bright"),
        rectangle("field", [0.0, 0.0, 3.0], y, [2.0, 0.0, 0.0], "bright"),
        rectangle("ceiling", [2.0, 0.0, 3.0], y, [4.0, 0.0, 0.0], "bright"),
        rectangle("west", [0.0; 3], y, z, "dark"),
        rectangle("east", [6.0, 0.0, 0.0], z, y, "dark"),
        rectangle("south", [0.0; 3], z, x, "bright"),
        rectangle("north", [0.0, 4.0, 0.0], x, z, "bright"),
    ];
    common::scene_of(&format!(
        r#"{{"version": 1,
            "materials": {{"dark": {{"type": "diffuse", "reflectance": 0.2}},
                           "bright": {{"type": "diffuse", "reflectance": 0.7}}}},
            "geometry": [{}],
            "luminaires": [
                {{"name": "glow", "type": "area", "surface": "field", "luminous_flux_lm": 3000}},
                {{"name": "down", "type": "point", "distribution": "lambertian", "position": [4,2,2.5],
                  "aim": [0.2,0.3,-1], "luminous_flux_lm": 2000}}],
            "receivers": [
                {{"name": "plane", "type": "grid", "origin": [0.5,0.5,0.8], "u": [5,0,0], "v": [0,3,0.5],
                  "columns": 3, "rows": 3}}]}}"#,
        geometry.join(",")
    ))
}

#[test]
fn the_cube_of_cie_171_case_5_8_is_met_at_points_and_on_average() {
    let scene = common::cube(0.5, 1.0);
    let solution = to_target(&scene, MapSelection::All, 0.001);
    assert_eq!(solution.stop_reason, StopReason::TargetMet, "{:?}", solution.convergence);
    let elements = &solution.maps[0];
    for row in &elements.tables {
        assert!((row.average.value - 208.3333).abs() < 0.01, "{row:?}");
    }
    let check = solution.map_check.clone().expect("a closed room");
    assert!((check.absorbed_by_map_lm / 10_000.0 - 1.0).abs() < 1e-4, "{check:?}");
    assert!(check.z_score.abs() < 3.0, "{check:?}");
    assert!(solution.flux_balance.is_err());
    println!("cube: {} {:?}", elements.error.bias, check);
}

#[test]
fn the_middle_of_a_face_has_the_known_indirect_illuminance() {
    let mut scene = common::cube(0.5, 4.0);
    scene.receivers[0].points.truncate(1);
    scene.receivers[0].points[0].position_m = DVec3::new(2.0, 2.0, 0.0);
    let solution = to_target(&scene, MapSelection::Receivers, 1e-5);
    let (values, direct_lx) = (&solution.maps[0].values, 10_000.0 / (4.0 * PI) / 4.0);
    println!("centre {values:?}");
    assert!((values.indirect[0] - 112.038).abs() < 0.003, "{values:?}");
    assert!((values.direct[0] - direct_lx).abs() < 1e-9, "{values:?}");
}

#[test]
fn every_element_of_the_bright_cube_is_exact_to_its_stated_error() {
    let scene = common::scene("cube.json");
    let intensity_cd = 10_000.0 / (4.0 * PI);
    let sources = vec![RoomSource::Point { position: DVec3::splat(2.0), intensity_cd }];
    let truth = BoxRoom { size_m: [4.0; 3], reflectances: [0.8; 6], sources }.solve().expect("a room");
    let solution = to_target(&scene, MapSelection::All, 0.01);
    let values = &solution.maps[0].values;
    let elements = Elements::of(&scene);
    let (mut squares, mut beyond, mut worst) = (0.0, 0, 0.0f64);
    // The room is symmetric, so that an eighth of one face represents all of it.
    let numbers: Vec<u32> = elements.of_triangle(0).step_by(5).collect();
    for index in &numbers {
        let exact = truth.triangle_mean(elements.corners_m(&scene, elements.element(*index))).expect("on a face");
        let off_lx = values.value[*index as usize] - exact.total_lx();
        let stated_lx = values.standard_error[*index as usize] + exact.estimated_error_lx;
        squares += (off_lx / exact.total_lx()).powi(2);
        beyond += usize::from(off_lx.abs() > stated_lx);
        worst = worst.max(off_lx.abs() / stated_lx);
        assert!((values.direct[*index as usize] / exact.direct_lx - 1.0).abs() < 1e-9);
    }
    let rms = (squares / numbers.len() as f64).sqrt();
    println!(
        "cube.json: true {rms:e}, stated {:e}, {beyond} of {} beyond, worst {worst}",
        solution.estimated_error,
        numbers.len()
    );
    assert!(rms < solution.estimated_error.max(1e-5) && beyond * 20 <= numbers.len(), "{rms} {beyond}");
}

/// α some 0.003 (3.5 standard errors of the chains with 15 degrees of freedom, plus the stated error of radiosity) for each of some 9 + 8
/// numbers, N = 400,000 chains, seed 1.
#[test]
fn a_room_of_tiles_agrees_with_chains() {
    let scene = tiled_room();
    let solution = to_target(&scene, MapSelection::All, 0.003);
    let check = solution.map_check.clone().expect("a closed room");
    println!("tiles: {:?} {:?}", check, solution.convergence);
    assert!((check.absorbed_by_map_lm / 5000.0 - 1.0).abs() < 2e-3 && check.z_score.abs() < 3.0, "{check:?}");
    let chains = common::with_chains(&scene, 1, MapSelection::All, 400_000);
    let mut compared = Vec::new();
    for (one, other) in solution.maps[0].tables.iter().zip(&chains.maps[0].tables) {
        compared.push((one.name.clone(), one.average, other.average));
    }
    let (one, other) = (&solution.maps[1].values, &chains.maps[1].values);
    for i in 0..9 {
        let estimate = |values: &luxmc::maps::MapValues| luxmc::maps::Estimate {
            value: values.value[i],
            standard_error: values.standard_error[i],
        };
        compared.push((format!("point {i}"), estimate(one), estimate(other)));
    }
    for (name, one, other) in compared {
        let allowed = one.standard_error + 3.5 * other.standard_error;
        println!("{name}: {one:?} {other:?}");
        assert!((one.value - other.value).abs() < allowed, "{name}: {one:?} {other:?}");
        // A twentieth more light would be detected.
        assert!(allowed < 0.05 * one.value, "{name}: {one:?} {other:?}");
    }
}

#[test]
fn what_is_no_room_is_refused_with_the_method_that_can() {
    for (name, reason) in [("office.json", "office"), ("sphere.json", "sphere")] {
        let error = Radiosity::check(&common::scene(name)).expect_err(reason).to_string();
        assert!(error.contains("--method collision"), "{error}");
    }
    let out = std::env::temp_dir().join(format!("luxmc-radiosity-{}", std::process::id()));
    let office = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/office.json");
    let arguments = ["solve", cli_support::text(&office), "--out", cli_support::text(&out), "--method", "radiosity"];
    let output = cli_support::run(&arguments);
    assert_eq!(cli_support::code(&output), 2);
    assert!(cli_support::errors(&output).contains("collision"), "{}", cli_support::errors(&output));
    assert!(!out.exists(), "something was written");
}
