//! Requirements by EN 1838 and EN 12193: direct light alone against the inverse square law, and refusals.

use std::path::Path;

use luxmc::control::Ruling;
use luxmc::scene::{Measure, Scene};
use luxmc::scene_from_json;
use luxmc::solver::{Finding, MapSelection, Settings, solve, verdicts};

use crate::common::{Silent, scene_of};

/// Height of the lamps in m and their intensity in cd.
const HEIGHT_M: f64 = 2.5;
const INTENSITY_CD: f64 = 40.0;

/// A white corridor of 20 m whose centre line is an escape route under two bare lamps.
fn corridor(requirements: &str) -> String {
    format!(
        r#"{{ "version": 1, "materials": {{ "white": {{ "type": "diffuse", "reflectance": 0.8 }} }},
          "geometry": [ {{ "name": "corridor", "type": "box", "min": [0,0,0], "max": [20,2,3], "facing": "inward", "material": "white" }} ],
          "luminaires": [ {{ "name": "lamp", "type": "point", "position": [5,1,{HEIGHT_M}], "intensity_cd": {INTENSITY_CD}, "columns": 2, "u": [10,0,0] }} ],
          "receivers": [ {{ "name": "route", "type": "grid", "origin": [0.5,1,0], "u": [19,0,0], "v": [0,0.001,0], "columns": 39, "rows": 1,
            "requirements": {requirements} }} ] }}"#
    )
}

/// Direct illuminance along the centre line by the inverse square law, in lx.
fn along_the_route_lx() -> Vec<f64> {
    let of_lamp = |x_m: f64, lamp_m: f64| {
        let distance_m2 = (x_m - lamp_m).powi(2) + HEIGHT_M.powi(2);
        INTENSITY_CD * HEIGHT_M / distance_m2.powf(1.5)
    };
    (0..39).map(|place| 0.5 + 0.5 * f64::from(place)).map(|x_m| of_lamp(x_m, 5.0) + of_lamp(x_m, 15.0)).collect()
}

fn found(scene: &Scene) -> Vec<(Measure, f64, f64, Ruling)> {
    let settings = Settings { target_error: Some(0.05), maps: MapSelection::Receivers, ..Settings::default() };
    let solution = solve(scene, &settings, &Silent);
    let told = verdicts(scene, &solution).into_iter().map(|verdict| match &verdict.finding {
        Finding::Value { estimate, .. } => {
            (verdict.requirement.measure, estimate.value, estimate.standard_error, verdict.ruling())
        }
        Finding::BelowScale | Finding::Nothing(_) => panic!("no value"),
    });
    told.collect()
}

/// Walls that reflect 80 % give the route ten times as much light. Only direct light counts, on batteries at 80 %. The planted fault that
/// must be rejected: all light counts.
#[test]
fn an_escape_route_is_judged_by_direct_light_alone_and_exactly() {
    let truth_lx = along_the_route_lx();
    let least_lx = truth_lx.iter().copied().fold(f64::INFINITY, f64::min);
    let greatest_lx = truth_lx.iter().copied().fold(0.0, f64::max);
    let of_route = found(&scene_of(&corridor(r#"{ "en_1838": "escape route", "flux_factor": 0.8 }"#)));
    let [
        (Measure::DirectMinimumLx, least, least_error, too_dark),
        (Measure::DirectUniformityUd, ratio, ratio_error, even),
    ] = of_route[..]
    else {
        panic!("{of_route:?}")
    };
    assert!((least / (0.8 * least_lx) - 1.0).abs() < 1e-6 && least_error == 0.0, "{least} {least_lx}");
    assert!((ratio / (least_lx / greatest_lx) - 1.0).abs() < 1e-6 && ratio_error == 0.0, "{ratio}");
    assert_eq!([too_dark, even], [Ruling::NotMet, Ruling::Met], "0.61 lx of 1 lx, 1:8.5 of 1:40");

    let all_light = found(&scene_of(&corridor(r#"{ "minimum_lx": 1 }"#)));
    assert!(all_light[0].1 > 5.0 * least_lx && all_light[0].3 == Ruling::Met, "the planted fault: {all_light:?}");
    let area = found(&scene_of(&corridor(r#"{ "en_1838": "open area" }"#)));
    assert_eq!(area[0].3, Ruling::Met, "0.76 lx of 0.5 lx");
}

#[test]
fn classes_of_sports_have_their_numbers() {
    let scene = scene_of(&corridor(r#"{ "en_12193": "II", "uniformity_ud": 0.5 }"#));
    let asked: Vec<(Measure, f64)> =
        scene.receivers[0].requirements.iter().map(|requirement| (requirement.measure, requirement.limit)).collect();
    assert_eq!(asked, [(Measure::AverageLx, 500.0), (Measure::UniformityU0, 0.7), (Measure::UniformityUd, 0.5)]);
}

#[test]
fn what_cannot_be_meant_is_refused() {
    for (requirements, says) in [
        (r#"{ "en_1838": "escape route", "en_12193": "I" }"#, "second standard"),
        (r#"{ "average_lx": 300, "flux_factor": 0.5 }"#, "direct light only"),
        (r#"{ "en_1838": "escape rout" }"#, "escape route"),
        (r#"{ "en_12193": "IV" }"#, "class of EN 12193"),
        (r#"{ "direct_minimum_lx": 1, "flux_factor": 1.5 }"#, "flux"),
    ] {
        let error = scene_from_json(&corridor(requirements), None, Path::new(".")).expect_err(requirements).to_string();
        assert!(error.contains(says) && error.contains("remedy"), "{error}");
    }
    let energy = corridor(r#"{ "minimum_lx": 1 }"#)
        .replace("\"version\": 1,", "\"version\": 1, \"energy\": { \"day_hours\": 9000 },");
    let error = scene_from_json(&energy, None, Path::new(".")).expect_err("a long year").to_string();
    assert!(error.contains("8784") && error.contains("remedy"), "{error}");
}
