//! The sample scenes with real materials and photometric files: their content and the expected numbers.

use std::path::Path;

use luxmc::check::{inspect, read_scene};
use luxmc::solver::{MapSelection, Settings, solve};

use crate::common::Silent;

/// Averages in lx of receiver sets and surfaces, from runs of 30 million rays and more with standard errors of 0.3 % or less.
const EXPECTED: &[(&str, &[(&str, f64)])] = &[
    (
        "corridor",
        &[("floor", 138.0), ("floor behind the door", 14.94), ("corridor/floor", 94.0), ("corridor/y_max", 139.6)],
    ),
    (
        "gallery",
        &[("picture wall", 101.1), ("floor", 28.69), ("room/y_max", 37.21), ("bust", 103.9), ("screen", 68.19)],
    ),
];

/// Chains of a run, as `MOST_ALLOWED` requires.
const CHAINS: u64 = 90_000;
/// Standard errors of a run (15 degrees of freedom): α = 0.002 for nine values, seed 0.
const BARS: f64 = 5.0;
/// Three standard errors of the long runs.
const LONG_RUN: f64 = 0.009;
/// Limit of both together, as a share of the expected value.
const MOST_ALLOWED: f64 = 0.09;

fn gives_its_expected_averages(name: &str) {
    let (_, averages) = EXPECTED.iter().find(|(known, _)| *known == name).expect("a scene");
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes").join(format!("{name}.json"));
    let scene = read_scene(&path).unwrap_or_else(|error| panic!("{error}"));
    assert!(inspect(&scene).closed, "{name} is closed");
    let settings = Settings {
        method: luxmc::solver::Method::Collision,
        elements: luxmc::solver::ElementChoice::Given,
        seed: 0,
        target_error: None,
        chains: Some(CHAINS),
        time_limit_s: None,
        maps: MapSelection::All,
        threads: None,
    };
    let solution = solve(&scene, &settings, &Silent);
    for (row_name, expected) in *averages {
        let rows = solution.maps.iter().flat_map(|map| &map.tables);
        let row = rows.clone().find(|row| row.name == *row_name && row.side == "front").expect("a row");
        let (value, error) = (row.average.value, row.average.standard_error);
        let allowed = BARS * error + LONG_RUN * expected;
        assert!(allowed < MOST_ALLOWED * expected, "{name}, {row_name}: {value} ± {error}");
        // The planted fault: three twentieths of all light are lost.
        let of_less = |share: f64| (share * value - expected).abs() < BARS * share * error + LONG_RUN * expected;
        assert!(of_less(1.0), "{name}, {row_name}: {value} ± {error}, expected {expected}");
        assert!(!of_less(0.85), "{name}, {row_name}: {value} ± {error} passes for {expected} when light is lost");
    }
    let balance = solution.flux_balance.expect("chains were traced");
    let sum = balance.absorbed_lm + balance.escaped_lm + balance.back_face_lm + balance.truncated_lm;
    assert!((sum / balance.emitted_lm - 1.0).abs() < 1e-12, "{name}: {balance:?}");
    assert!(solution.map_check.is_ok_and(|check| check.z_score.abs() < 4.5), "{name}");
    assert!(solution.paths_not_found.is_empty(), "{name}");
}

#[test]
fn the_corridor_gives_its_expected_averages() {
    gives_its_expected_averages("corridor");
}

#[test]
fn the_gallery_gives_its_expected_averages() {
    gives_its_expected_averages("gallery");
}
