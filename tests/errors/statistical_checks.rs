//! Statistical checks on real runs: sound runs pass, the naive kernel in a corner fails.

use luxmc::scene::Scene;
use luxmc::solver::{MapSelection, Method, Settings, Solution, solve};

use crate::common::{Silent, cube, scene_of, slow, to_target};

fn failed(solution: &Solution, map: usize) -> Vec<&'static str> {
    solution.maps[map].checks.iter().filter(|check| !check.passed).map(|check| check.name).collect()
}

/// A box of 2 m whose walls emit what their reflectance leaves, and 8 receivers 1 mm from a wall.
fn corner() -> Scene {
    let wall = |name: &str, origin: [i32; 3], u: [i32; 3], v: [i32; 3]| {
        format!(
            r#"{{ "name": "{name}", "type": "rectangle", "origin": {origin:?}, "u": {u:?}, "v": {v:?}, "material": "paint" }}"#
        )
    };
    let walls = [
        wall("floor", [0, 0, 0], [2, 0, 0], [0, 2, 0]),
        wall("ceiling", [0, 0, 2], [0, 2, 0], [2, 0, 0]),
        wall("west", [0, 0, 0], [0, 2, 0], [0, 0, 2]),
        wall("east", [2, 0, 0], [0, 0, 2], [0, 2, 0]),
        wall("south", [0, 0, 0], [0, 0, 2], [2, 0, 0]),
        wall("north", [0, 2, 0], [2, 0, 0], [0, 0, 2]),
    ];
    let glow = |name: &str| {
        format!(r#"{{ "name": "glow {name}", "type": "area", "surface": "{name}", "exitance_lm_m2": 500 }}"#)
    };
    let glows = ["floor", "ceiling", "west", "east", "south", "north"].map(glow);
    scene_of(&format!(
        r#"{{ "version": 1, "materials": {{ "paint": {{ "type": "diffuse", "reflectance": 0.5 }} }},
            "geometry": [ {} ], "luminaires": [ {} ],
            "receivers": [ {{ "name": "by the wall", "type": "grid", "origin": [0.001,0.3,0], "u": [0,1.4,0], "v": [-1e-9,0,0],
                              "columns": 8, "rows": 1 }} ] }}"#,
        walls.join(","),
        glows.join(",")
    ))
}

/// At 1 mm from a wall the variance of the naive kernel is finite only formally. Of some runs of 16,384 chains (seeds from 0 on), all but
/// `most_passed` must fail a check. With the bounded kernel at most 1 may fail.
fn naive_kernels_are_caught(seeds: u64, most_passed: u64) {
    let scene = corner();
    let run = |method: Method, seed: u64| {
        let settings =
            Settings { method, seed, chains: Some(16_384), maps: MapSelection::Receivers, ..Settings::default() };
        solve(&scene, &settings, &Silent)
    };
    let mut caught = [0, 0];
    for seed in 0..seeds {
        for (count, method) in caught.iter_mut().zip([Method::LocalNaive, Method::Local]) {
            let solution = run(method, seed);
            assert_eq!(solution.maps[0].checks.len(), 5);
            *count += u64::from(!failed(&solution, 0).is_empty());
        }
    }
    eprintln!("naive kernel caught in {} of {seeds} runs, bounded one in {}", caught[0], caught[1]);
    assert!(caught[0] + most_passed >= seeds && caught[1] <= 1, "{caught:?}");
}

#[test]
fn the_naive_kernel_in_a_corner_is_caught_and_the_bounded_one_is_not() {
    naive_kernels_are_caught(12, 0);
}

#[test]
#[ignore = "takes long: .ci/run runs it"]
fn forty_runs_of_the_naive_kernel_in_a_corner_are_caught() {
    naive_kernels_are_caught(40, 2);
}

#[test]
fn sound_runs_are_not_held_up() {
    // A cube to 3 %, elements and points, seeds 0 to 39 (299 in the slow run): at most 1 (2) of 80 (600) maps may be refused.
    let scene = cube(0.5, 1.0);
    let seeds = if slow() { 300 } else { 40 };
    let mut refused = 0;
    for seed in 0..seeds {
        let solution = to_target(&scene, seed, MapSelection::All, 0.03);
        assert_eq!(solution.target_met, Some(true));
        refused += solution.maps.iter().map(|map| u32::from(map.refusals > 0)).sum::<u32>();
    }
    eprintln!("{refused} of {} maps held up", 2 * seeds);
    assert!(refused <= if slow() { 2 } else { 1 }, "{refused}");
}
