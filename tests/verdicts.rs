//! Verdicts on requirements: how often they are right, and where they are told.

mod cli_support;
mod common;

use cli_support::{code, errors, results, run, summary, text};
use common::{scene_of, with_chains};
use luxmc::control::Ruling;
use luxmc::scene::Scene;
use luxmc::solver::{MapSelection, verdicts};

/// Illuminance in lx of the room whose walls all shine, M/(1 − ρ), everywhere.
const TRUTH_LX: f64 = 200.0;

/// A box whose walls of reflectance 0.5 all shine with 100 lm/m², and a grid in it.
fn shining_room(requirements: &str) -> Scene {
    scene_of(&format!(
        r#"{{ "version": 1, "materials": {{ "grey": {{ "type": "diffuse", "reflectance": 0.5 }} }},
          "geometry": [ {{ "name": "room", "type": "box", "min": [0,0,0], "max": [4,3,2.5], "facing": "inward", "material": "grey" }} ],
          "luminaires": [ {{ "name": "glow", "type": "area", "surface": "room", "exitance_lm_m2": 100 }} ],
          "receivers": [ {{ "name": "plane", "type": "grid", "origin": [1,1,0.8], "u": [2,0,0], "v": [0,1,0], "columns": 4, "rows": 3,
            "requirements": {requirements} }} ] }}"#
    ))
}

/// How many of 100 seeds decide on a requirement of the average and on one of the minimum.
fn decided(limit_lx: f64) -> [usize; 2] {
    let scene = shining_room(&format!(r#"{{ "average_lx": {limit_lx}, "minimum_lx": {limit_lx} }}"#));
    let mut counts = [0; 2];
    for seed in 0..100 {
        let solution = with_chains(&scene, seed, MapSelection::Receivers, 640);
        for (count, verdict) in counts.iter_mut().zip(verdicts(&scene, &solution)) {
            *count += usize::from(verdict.ruling() != Ruling::Undecided);
        }
    }
    counts
}

/// Where the truth lies at the limit, whatever is decided is decided by chance: 5 % or less. At α = 10⁻⁴ no more than 14 of 100 runs do,
/// of the average and of the minimum alike, all twelve points of which are at the limit. A limit 5 % off is the planted fault.
#[test]
fn verdicts_at_the_limit_are_wrong_in_one_run_of_twenty_at_most() {
    let at_limit = decided(TRUTH_LX);
    assert!(at_limit.iter().all(|count| *count <= 14), "{at_limit:?}");
    let off = decided(1.05 * TRUTH_LX);
    assert!(off.iter().all(|count| *count > 14), "the planted fault passed: {off:?}");
}

/// Terminal, file, summary and report of one run: met, not met, undecided for want of a map, and an entry of the standard.
#[test]
fn verdicts_are_told_where_people_look() {
    let home = tempfile::tempdir().expect("a temporary directory");
    let scene = home.path().join("room.json");
    let room = r#"{ "version": 1, "materials": { "grey": { "type": "diffuse", "reflectance": 0.5 } },
      "geometry": [ { "name": "room", "type": "box", "min": [0,0,0], "max": [4,3,2.5], "facing": "inward", "material": "grey" } ],
      "luminaires": [ { "name": "ball", "type": "sphere", "center": [2,1.5,2.2], "radius": 0.1, "luminous_flux_lm": 4000,
        "maintenance_factor": 0.8, "power_w": 60 } ],
      "receivers": [
        { "name": "desk", "type": "grid", "origin": [1,1,0.8], "u": [2,0,0], "v": [0,1,0], "columns": 4, "rows": 3,
          "requirements": { "en_12464_1": "34.2", "uniformity": 0.05 } },
        { "name": "route", "type": "grid", "origin": [1,1,0], "u": [2,0,0], "v": [0,1,0], "columns": 4, "rows": 3,
          "requirements": { "minimum_lx": 1, "maximum_lx": 1e6, "uniformity_ud": 0.025 } },
        { "name": "seat", "type": "ugr", "position": [0.5,1.5,1.2], "view_direction": [1,0,0], "requirements": { "en_12464_1": "34.2" } } ] }"#;
    std::fs::write(&scene, room).expect("a file");
    let out = home.path().join("out");
    let solved = run(&["solve", text(&scene), "--out", text(&out), "--chains", "2000", "--maps", "desk,seat"]);
    assert_eq!(code(&solved), 0, "a verdict is no error: {}", errors(&solved));

    let file = std::fs::read_to_string(out.join("verdicts.csv")).expect("a file");
    let row = |start: &str| file.lines().find(|line| line.starts_with(start)).unwrap_or_else(|| panic!("{file}"));
    assert!(row("desk,average_lx,at least,500,\"EN 12464-1:2021, 34.2\"").ends_with(",not met"), "{file}");
    assert!(row("desk,uniformity,at least,0.05,scene").ends_with(",met"), "{file}");
    assert_eq!(row("route,uniformity_ud"), "route,uniformity_ud,at least,0.025,scene,,,,,,undecided");
    assert!(row("seat,ugr,at most,19,").ends_with("met"), "{file}");
    assert_eq!(file.lines().count(), 7);

    let told = summary(&out)["verdicts"].clone();
    assert_eq!(told.as_array().map(Vec::len), Some(6));
    assert_eq!((&told[0]["verdict"], &told[1]["verdict"]), (&"not met".into(), &"met".into()));
    assert_eq!(told[2]["doubt"], "not computed");
    let tables = std::fs::read_to_string(out.join("tables.csv")).expect("a file");
    let average =
        tables.lines().nth(1).and_then(|line| line.split(',').nth(3)).and_then(|cell| cell.parse::<f64>().ok());
    assert_eq!(told[0]["value"].as_f64(), average, "maintained as the tables are");

    let power = summary(&out)["electric_power"].clone();
    let lit_lx = average.expect("an average");
    assert_eq!((&power["installed_w"], &power["w_m2"]), (&60.0.into(), &5.0.into()), "60 W over 12 m²");
    let specific = power["per_100_lx"][0]["w_m2_per_100_lx"].as_f64().expect("a number");
    assert!((specific - 500.0 / lit_lx).abs() < 1e-9, "{specific}");

    let printed = results(&solved);
    assert!(
        printed.contains("Ē ≥ 500 lx") && printed.contains("not met") && printed.contains("not computed"),
        "{printed}"
    );
    let report = std::fs::read_to_string(out.join("report.html")).expect("a file");
    assert!(report.contains("✗ not met") && report.contains("✓ met") && report.contains("? undecided"));
    let met = file.lines().filter(|line| line.ends_with(",met")).count();
    assert!(report.contains(&format!("{met} of 6 requirements are met, ")), "{met}");
    assert!(report.contains("EN 12464-1:2021, 34.2: offices"));
}
