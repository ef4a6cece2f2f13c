//! Helpers for the tests of whole runs.
#![allow(dead_code)]

use std::path::Path;

use luxmc::check::{read_scene, scene_from_json};
use luxmc::scene::Scene;
pub use luxmc::solver::Silent;
use luxmc::solver::{MapSelection, Method, Settings, Solution, solve};

/// Solves a scene to a target error.
pub fn to_target(scene: &Scene, seed: u64, maps: MapSelection, target_error: f64) -> Solution {
    solve(scene, &Settings { target_error: Some(target_error), ..settings(seed, maps) }, &Silent)
}

/// Solves a scene to a target error by one method.
pub fn to_target_by(scene: &Scene, method: Method, seed: u64, maps: MapSelection, target_error: f64) -> Solution {
    solve(scene, &Settings { method, target_error: Some(target_error), ..settings(seed, maps) }, &Silent)
}

/// Solves a scene with a number of chains.
pub fn with_chains(scene: &Scene, seed: u64, maps: MapSelection, chains: u64) -> Solution {
    solve(scene, &Settings { chains: Some(chains), ..settings(seed, maps) }, &Silent)
}

fn settings(seed: u64, maps: MapSelection) -> Settings {
    Settings {
        method: Method::Collision,
        elements: luxmc::solver::ElementChoice::Given,
        seed,
        target_error: None,
        chains: None,
        time_limit_s: None,
        maps,
        threads: None,
    }
}

/// Reads a scene of the project's `scenes` folder.
pub fn scene(name: &str) -> Scene {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes").join(name);
    read_scene(&path).unwrap_or_else(|error| panic!("{error}"))
}

/// Reads a scene from text.
pub fn scene_of(text: &str) -> Scene {
    scene_from_json(text, None, Path::new(".")).unwrap_or_else(|error| panic!("{error}"))
}

/// CIE 171:2006 case 5.8: a closed cube of 4 m, an isotropic source of 10,000 lm at its centre, and some points.
pub fn cube(reflectance: f64, max_element_edge: f64) -> Scene {
    scene_of(&format!(
        r#"{{"version": 1,
            "materials": {{"paint": {{"type": "diffuse", "reflectance": {reflectance}}}}},
            "geometry": [{{"name": "cube", "type": "box", "min": [0,0,0], "max": [4,4,4], "facing": "inward",
                           "material": "paint", "max_element_edge": {max_element_edge}}}],
            "luminaires": [{{"name": "source", "type": "point", "position": [2,2,2], "luminous_flux_lm": 10000}}],
            "receivers": [{{"name": "floor", "type": "grid", "origin": [0.25,0.25,0], "u": [3.5,0,0], "v": [0,3.5,0],
                            "columns": 8, "rows": 8}}]}}"#
    ))
}

/// Whether slow campaigns are requested.
pub fn slow() -> bool {
    std::env::var_os("LUXMC_SLOW_TESTS").is_some_and(|value| value == "1")
}

/// 95.4 % quantile of |t| with 15 degrees of freedom, the number that the 16 replicas leave. It corresponds to ±2σ of a normal
/// distribution.
pub const T15_QUANTILE_95_4: f64 = 2.174;
