//! Verdicts on requirements: how often they are right, and where they are shown.

use luxmc::control::Ruling;
use luxmc::scene::Scene;
use luxmc::solver::{MapSelection, Method, Settings, VerdictLadder, solve, solve_to_verdicts, verdicts};

use crate::cli_support::{code, errors, results, run, summary, text};
use crate::common::{Silent, scene_of, with_chains};

/// Illuminance in lx of the room whose walls all emit: M/(1 − ρ) everywhere.
const TRUTH_LX: f64 = 200.0;

/// A box whose walls of reflectance 0.5 all emit 100 lm/m², and a grid in it.
fn shining_room(requirements: &str, points: &str) -> Scene {
    scene_of(&format!(
        r#"{{ "version": 1, "materials": {{ "grey": {{ "type": "diffuse", "reflectance": 0.5 }} }},
          "geometry": [ {{ "name": "room", "type": "box", "min": [0,0,0], "max": [4,3,2.5], "facing": "inward", "material": "grey" }} ],
          "luminaires": [ {{ "name": "glow", "type": "area", "surface": "room", "exitance_lm_m2": 100 }} ],
          "receivers": [ {{ "name": "plane", "type": "grid", "origin": [1,1,0.8], "u": [2,0,0], "v": [0,1,0], {points},
            "requirements": {requirements} }} ] }}"#
    ))
}

/// How many of 100 seeds decide on a requirement for the average and on one for the minimum.
fn decided(limit_lx: f64) -> [usize; 2] {
    let scene = shining_room(
        &format!(r#"{{ "average_lx": {limit_lx}, "minimum_lx": {limit_lx} }}"#),
        "\"columns\": 4, \"rows\": 3",
    );
    let mut counts = [0; 2];
    for seed in 0..100 {
        let solution = with_chains(&scene, seed, MapSelection::Receivers, 640);
        for (count, verdict) in counts.iter_mut().zip(verdicts(&scene, &solution)) {
            *count += usize::from(verdict.ruling() != Ruling::Undecided);
        }
    }
    counts
}

/// With the truth at the limit, a verdict is decided only by chance, in 5 % of the runs or less. At α = 10⁻⁴ at most 14 of 100 runs may
/// decide, both for the average and for the minimum, for which all twelve points are at the limit. A limit 5 % off is the planted fault.
#[test]
fn verdicts_at_the_limit_are_wrong_in_one_run_of_twenty_at_most() {
    let at_limit = decided(TRUTH_LX);
    assert!(at_limit.iter().all(|count| *count <= 14), "{at_limit:?}");
    let off = decided(1.05 * TRUTH_LX);
    assert!(off.iter().all(|count| *count > 14), "the planted fault passed: {off:?}");
}

/// How many of some seeds end with the average reported as met, when runs continue until the verdict is decided.
fn met_after_looks(seeds: u64, limit_lx: f64) -> usize {
    let scene = shining_room(&format!(r#"{{ "average_lx": {limit_lx} }}"#), "\"columns\": 2, \"rows\": 2");
    let ladder = VerdictLadder { first_error: 0.1, least_error: 0.01 };
    let met = |seed: &u64| {
        let settings =
            Settings { seed: *seed, method: Method::Collision, maps: MapSelection::Receivers, ..Settings::default() };
        let run = |settings: &Settings| Ok::<_, ()>(solve(&scene, settings, &Silent));
        let solution = solve_to_verdicts(&scene, &settings, ladder, run).expect("runs that do not fail");
        verdicts(&scene, &solution)[0].ruling() == Ruling::Met
    };
    (0..seeds).filter(met).count()
}

/// A limit slightly above the truth is reported as met in 5 % of the runs or less, however often a run checks it: at α = 10⁻⁴ in at most 7
/// of 25 (seeds 0 to 24). A limit 5 % below the truth, the planted fault, is met in all.
#[test]
fn runs_that_look_often_are_wrong_in_one_run_of_twenty_at_most() {
    let barely_missed = met_after_looks(25, 1.000_01 * TRUTH_LX);
    assert!(barely_missed <= 7, "{barely_missed}");
    let kept = met_after_looks(25, 0.95 * TRUTH_LX);
    assert!(kept == 25, "{kept}");
}

/// At most 14 of 100 (seeds 0 to 99, α = 10⁻⁴), and the planted fault in at least 98.
#[test]
#[ignore = "takes long: .ci/run runs it"]
fn a_hundred_runs_that_look_often_are_wrong_in_one_run_of_twenty_at_most() {
    let barely_missed = met_after_looks(100, 1.000_01 * TRUTH_LX);
    assert!(barely_missed <= 14, "{barely_missed}");
    let kept = met_after_looks(100, 0.95 * TRUTH_LX);
    assert!(kept >= 98, "{kept}");
}

/// Runs for verdicts end early where everything is clear, and name what stays undecided. They need requirements.
#[test]
fn a_run_for_verdicts_stops_where_all_is_decided() {
    let home = tempfile::tempdir().expect("a temporary directory");
    let scene = home.path().join("room.json");
    let room = |requirements: &str| {
        format!(
            r#"{{ "version": 1, "materials": {{ "grey": {{ "type": "diffuse", "reflectance": 0.5 }} }},
          "geometry": [ {{ "name": "room", "type": "box", "min": [0,0,0], "max": [4,3,2.5], "facing": "inward", "material": "grey" }} ],
          "luminaires": [ {{ "name": "ball", "type": "sphere", "center": [2,1.5,2.2], "radius": 0.1, "luminous_flux_lm": 4000 }} ],
          "receivers": [ {{ "name": "desk", "type": "grid", "origin": [1,1,0.8], "u": [2,0,0], "v": [0,1,0], "columns": 4, "rows": 3{requirements} }} ] }}"#
        )
    };
    std::fs::write(&scene, room(r#", "requirements": { "average_lx": 50 }"#)).expect("a file");
    let out = home.path().join("out");
    let solved = run(&["solve", text(&scene), "--out", text(&out), "--target", "verdicts"]);
    assert_eq!(code(&solved), 0, "{}", errors(&solved));
    assert!(errors(&solved).contains("verdicts decided"), "{}", errors(&solved));
    let told = summary(&out);
    assert_eq!((&told["target_error"], &told["target_met"]), (&0.03.into(), &true.into()), "one look was enough");
    assert_eq!(told["stop_reason"], "verdicts_decided");
    assert_eq!(told["maps"].as_array().map(Vec::len), Some(1), "nothing is required of the elements");
    assert!(told["notes"].to_string().contains("a run to stated errors of 3.00 % tried"), "{}", told["notes"]);

    std::fs::write(&scene, room("")).expect("a file");
    let refused = run(&["solve", text(&scene), "--out", text(&out), "--target", "verdicts"]);
    assert_eq!(code(&refused), 2);
    assert!(errors(&refused).contains("nothing to decide"), "{}", errors(&refused));

    // A limit at the value of a long run stays undecided and is reported as undecided. The summary has the work of all runs.
    std::fs::write(&scene, room(r#", "requirements": { "average_lx": 50 }"#)).expect("a file");
    let long =
        run(&["solve", text(&scene), "--out", text(&out), "--target-error", "0.1%", "--maps", "desk", "--seed", "7"]);
    assert_eq!(code(&long), 0, "{}", errors(&long));
    let value_lx = summary(&out)["verdicts"][0]["value"].as_f64().expect("a value");
    std::fs::write(&scene, room(&format!(r#", "requirements": {{ "average_lx": {value_lx} }}"#))).expect("a file");
    // One run in twenty decides by chance (4 of the seeds 0 to 59, and 0 is one of them).
    let to_the_end = ["--target", "verdicts", "--target-error", "1%", "--seed", "1"];
    let undecided = run(&[&["solve", text(&scene), "--out", text(&out)], &to_the_end[..]].concat());
    assert_eq!(code(&undecided), 3, "{}", errors(&undecided));
    assert!(errors(&undecided).contains("verdicts undecided"), "{}", errors(&undecided));
    let told = summary(&out);
    assert_eq!(
        (&told["stop_reason"], &told["target_met"], &told["target_error"]),
        (&"undecided".into(), &false.into(), &0.01.into())
    );
    let spent = told["spent"].as_object().expect("what rays were for");
    let rays: u64 = spent.values().filter_map(|of| of["rays"].as_u64()).sum();
    assert_eq!(Some(rays), told["rays"].as_u64());

    for beside in [["--chains", "1000"], ["--share", "1/2"], ["--checkpoint", "run.ckpt"], ["--maps", "elements"]] {
        let refused =
            run(&[&["solve", text(&scene), "--out", text(&out), "--target", "verdicts"], &beside[..]].concat());
        assert_eq!(code(&refused), 2, "{beside:?}");
        assert!(errors(&refused).contains("remedy"), "{}", errors(&refused));
    }
}

/// Terminal, file, summary and report of one run: met, not met, undecided because a map is missing, and an entry of the standard.
#[test]
fn verdicts_are_reported_where_people_look() {
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
