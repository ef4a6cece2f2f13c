//! Vertical, cylindrical and semi-cylindrical illuminance against closed formulas.

use std::f64::consts::PI;
use std::path::Path;

use luxmc::check::scene_from_json;
use luxmc::maps::MapResult;
use luxmc::solver::{MapSelection, Settings, Silent, solve};

/// Limit in standard errors. A correct program fails each of the comparisons below with a probability of some 1e-4 (16 replicas, t with 15
/// degrees of freedom).
const WITHIN: f64 = 5.0;
const SEED: u64 = 5;

/// Solves a closed room of one material with these luminaires and receivers.
fn receivers(reflectance: f64, luminaires: &str, receivers: &str, chains: u64) -> Vec<MapResult> {
    let text = format!(
        r#"{{ "version": 1, "materials": {{ "wall": {{ "type": "diffuse", "reflectance": {reflectance} }} }},
        "geometry": [ {{ "name": "room", "type": "box", "min": [-3,-3,-3], "max": [3,3,3], "facing": "inward", "material": "wall" }} ],
        "luminaires": [ {luminaires} ], "receivers": [ {receivers} ] }}"#
    );
    let scene = scene_from_json(&text, None, Path::new(".")).unwrap_or_else(|error| panic!("{error}"));
    let settings = Settings {
        method: luxmc::solver::Method::Collision,
        elements: luxmc::solver::ElementChoice::Given,
        seed: SEED,
        target_error: None,
        chains: Some(chains),
        time_limit_s: None,
        maps: MapSelection::Receivers,
        threads: None,
    };
    solve(&scene, &settings, &Silent).maps
}

/// A grid of one point in the middle.
fn middle(name: &str, more: &str) -> String {
    format!(
        r#"{{ "name": "{name}", "type": "grid", "origin": [0,0,0], "u": [1e-9,0,0], "v": [0,1e-9,0], "columns": 1, "rows": 1, {more} }}"#
    )
}

const ALL: [(&str, &str); 4] = [
    ("horizontal", r#""quantity": "horizontal""#),
    ("vertical", r#""quantity": "vertical", "direction": [1,0,0]"#),
    ("cylindrical", r#""quantity": "cylindrical""#),
    ("semi-cylindrical", r#""quantity": "semi-cylindrical", "direction": [1,0,0]"#),
];

fn all_in_the_middle() -> String {
    ALL.map(|(name, more)| middle(name, more)).join(", ")
}

/// Asserts that the only value of a map agrees with the truth, and that it does not agree with a truth 5 % off.
fn assert_is(map: &MapResult, truth_lx: f64) {
    let (value, error) = (map.values.value[0], map.values.standard_error[0]);
    // Exact calculations are exact to rounding.
    let allowed = (WITHIN * error).max(1e-9 * truth_lx);
    assert!((value - truth_lx).abs() < allowed, "{}: {value} ± {error}, exact {truth_lx}", map.name);
    assert!((value - 1.05 * truth_lx).abs() > allowed, "{}: a fault of 5% would go unseen, ± {error}", map.name);
}

#[test]
fn one_lamp_in_a_black_room_follows_the_closed_formulas() {
    // The lamp is at azimuth 50° from +x, 60° from the vertical, at a distance of 2 m.
    let (azimuth, from_vertical, distance_m, intensity_cd) = (50f64.to_radians(), 60f64.to_radians(), 2.0, 700.0);
    let [x, y, z] = [from_vertical.sin() * azimuth.cos(), from_vertical.sin() * azimuth.sin(), from_vertical.cos()]
        .map(|share| share * distance_m);
    let lamp =
        format!(r#"{{ "name": "lamp", "type": "point", "position": [{x},{y},{z}], "intensity_cd": {intensity_cd} }}"#);
    let maps = receivers(0.0, &lamp, &all_in_the_middle(), 100_000);
    let normal_lx = intensity_cd / (distance_m * distance_m);
    assert_is(&maps[0], normal_lx * from_vertical.cos());
    assert_is(&maps[1], normal_lx * from_vertical.sin() * azimuth.cos());
    assert_is(&maps[2], normal_lx * from_vertical.sin() / PI);
    assert_is(&maps[3], normal_lx * from_vertical.sin() * (1.0 + azimuth.cos()) / PI);
}

#[test]
fn in_even_light_all_illuminances_are_the_same() {
    // Walls that all emit and reflect equally: L is M/(1 − ρ)/π everywhere, and every receiver gets πL.
    let walls = r#"{ "name": "walls", "type": "area", "surface": "room", "exitance_lm_m2": 100 }"#;
    let maps = receivers(0.6, walls, &all_in_the_middle(), 100_000);
    for map in &maps {
        assert_is(map, 100.0 / (1.0 - 0.6));
    }
}

#[test]
fn quantities_without_their_direction_are_refused() {
    for (quantity, more, words) in [
        ("vertical", "", "direction"),
        ("semi-cylindrical", r#", "direction": [1,0,1]"#, "[x, y, 0]"),
        ("cylindrical", r#", "direction": [1,0,0]"#, "no meaning"),
        ("spherical", "", "semi-cylindrical"),
    ] {
        let set = middle("set", &format!(r#""quantity": "{quantity}"{more}"#));
        let text = format!(
            r#"{{ "version": 1, "materials": {{ "wall": {{ "type": "diffuse", "reflectance": 0.5 }} }},
            "geometry": [ {{ "name": "room", "type": "box", "min": [-3,-3,-3], "max": [3,3,3], "facing": "inward", "material": "wall" }} ],
            "luminaires": [ {{ "name": "lamp", "type": "point", "position": [1,1,1], "intensity_cd": 1 }} ],
            "receivers": [ {set} ] }}"#
        );
        let refusal = scene_from_json(&text, None, Path::new(".")).expect_err(quantity).to_string();
        assert!(refusal.contains(words), "{refusal}");
    }
}
