//! The program at its limits: scenes without light, with far too large dimensions or almost no absorption, and full disks.

use std::path::{Path, PathBuf};

use serde_json::{Value, json};

use crate::cli_support::{self, code, errors, listing, luxmc, run, solve_file, summary, text};

/// A room of 4 m × 3 m × 2.5 m with a lamp of 1200 lm and a grid.
fn room() -> Value {
    json!({
        "version": 1,
        "materials": { "m": { "type": "diffuse", "reflectance": 0.5 } },
        "geometry": [ { "name": "room", "type": "box", "min": [0, 0, 0], "max": [4, 3, 2.5], "facing": "inward", "material": "m" } ],
        "luminaires": [ { "name": "lamp", "type": "point", "position": [2, 1.5, 2.2], "luminous_flux_lm": 1200 } ],
        "receivers": [ { "name": "g", "type": "grid", "origin": [0.5, 0.5, 0.8], "u": [3, 0, 0], "v": [0, 2, 0], "columns": 3, "rows": 2 } ]
    })
}

fn written(home: &Path, scene: &Value) -> PathBuf {
    let path = home.join("scene.json");
    std::fs::write(&path, scene.to_string()).expect("written");
    path
}

#[test]
fn a_scene_with_everything_switched_off_is_dark_by_every_method() {
    let home = tempfile::tempdir().expect("a temporary directory");
    let out = home.path().join("out");
    for (key, value) in [("dimming", 0), ("luminous_flux_lm", 0)] {
        let mut scene = room();
        scene["luminaires"][0][key] = json!(value);
        let path = written(home.path(), &scene);
        for method in ["auto", "gather", "collision", "local", "local-naive", "light-mesh", "radiosity"] {
            for maps in ["all", "receivers", "elements"] {
                let output = solve_file(&path, &out, &["--method", method, "--maps", maps, "--plots", "none"]);
                let said = errors(&output);
                assert_eq!(code(&output), 0, "{method}: {said}");
                assert!(said.contains("no luminaire gives light"), "{method}: {said}");
                let summary = summary(&out);
                assert_eq!(
                    (&summary["target_met"], &summary["stop_reason"]),
                    (&json!(true), &json!("exact")),
                    "{method}"
                );
            }
        }
    }
}

/// Packets cannot prove that no light reaches an outdoor map. Therefore the target is not met.
#[test]
fn a_map_that_no_light_was_found_in_misses_the_target() {
    let home = tempfile::tempdir().expect("a temporary directory");
    let out = home.path().join("out");
    let mut scene = room();
    scene["receivers"][0]["origin"] = json!([10.5, 0.5, 0.8]);
    let path = written(home.path(), &scene);
    let output = solve_file(&path, &out, &["--maps", "receivers", "--method", "collision"]);
    assert_eq!(code(&output), 3, "{}", errors(&output));
    assert!(errors(&output).contains("no light was found"), "{}", errors(&output));
    assert_eq!(summary(&out)["target_met"], json!(false));
}

/// One triangle of wide ground outside makes positions coarse. Results in the room are 0.2 % off at 10 km, 1.4 % at 50 km and 6 % at 100
/// km, independent of the stated error.
#[test]
fn a_room_that_is_lost_in_a_far_larger_scene_is_refused() {
    let home = tempfile::tempdir().expect("a temporary directory");
    let out = home.path().join("out");
    for (legs_m, exit, word) in
        [(1e3, 0, ""), (1e4, 0, "large for what is lit"), (5e4, 2, "too large for"), (1e8, 2, "too large for")]
    {
        let mesh = format!("v 0 0 -1\nv {legs_m} 0 -1\nv 0 {legs_m} -1\nf 1 2 3\n");
        std::fs::write(home.path().join("ground.obj"), mesh).expect("written");
        let mut scene = room();
        let ground = json!({ "name": "ground", "type": "mesh", "file": "ground.obj", "material": "m" });
        scene["geometry"].as_array_mut().expect("a list").push(ground);
        let path = written(home.path(), &scene);
        let output = solve_file(&path, &out, &["--maps", "receivers", "--target-error", "5%"]);
        assert_eq!(code(&output), exit, "{legs_m}: {}", errors(&output));
        assert_eq!(errors(&output).contains("for what is lit"), !word.is_empty(), "{}", errors(&output));
        assert!(errors(&output).contains(word), "{}", errors(&output));
        let inspected = run(&["inspect", text(&path)]);
        assert!(code(&inspected) == 0 && cli_support::results(&inspected).contains(word));
    }
    // A position far from the origin is no error.
    let mut scene = room();
    let shifted = |place: &mut Value| place[0] = json!(place[0].as_f64().expect("a number") + 1e6);
    for (list, keys) in
        [("geometry", vec!["min", "max"]), ("luminaires", vec!["position"]), ("receivers", vec!["origin"])]
    {
        keys.into_iter().for_each(|key| shifted(&mut scene[list][0][key]));
    }
    let inspected = run(&["inspect", text(&written(home.path(), &scene))]);
    assert!(!cli_support::results(&inspected).contains("for what is lit"), "{}", cli_support::results(&inspected));
}

#[test]
fn a_closed_room_that_is_next_to_white_is_refused() {
    let home = tempfile::tempdir().expect("a temporary directory");
    let mut scene = room();
    for (reflectance, exit) in [(0.9999999, 2), (1.0 - 1e-16, 2), (0.9999, 0)] {
        scene["materials"]["m"]["reflectance"] = json!(reflectance);
        assert_eq!(code(&run(&["inspect", text(&written(home.path(), &scene))])), exit, "{reflectance}");
    }
}

#[test]
fn luminous_openings_larger_than_any_luminaire_are_refused() {
    let home = tempfile::tempdir().expect("a temporary directory");
    let samples = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/luminaires");
    let ies = std::fs::read_to_string(samples.join("spotlight.ies")).expect("a sample");
    for (size, exit) in [("-0.08", 0), ("-99", 0), ("-101", 2), ("1e300", 2)] {
        let path = home.path().join("opening.ies");
        std::fs::write(&path, ies.replacen("-0.08 -0.08 0", &format!("{size} {size} 0"), 1)).expect("written");
        assert_eq!(code(&run(&["inspect", text(&path)])), exit, "{size}");
    }
    let ldt = std::fs::read_to_string(samples.join("downlight.ldt")).expect("a sample");
    for (length_mm, exit) in [("120", 0), ("1e30", 2)] {
        let mut lines: Vec<&str> = ldt.lines().collect();
        lines[15] = length_mm;
        let path = home.path().join("opening.ldt");
        std::fs::write(&path, lines.join("\n")).expect("written");
        assert_eq!(code(&run(&["inspect", text(&path)])), exit, "{length_mm}");
    }
}

#[test]
fn a_mesh_step_too_fine_for_a_mesh_is_warned_of_and_one_as_wide_as_a_room_is_taken() {
    let home = tempfile::tempdir().expect("a temporary directory");
    let out = home.path().join("out");
    let mut scene = room();
    let panel = json!({ "name": "panel", "type": "rectangle", "origin": [1, 1, 2.4], "u": [0, 1, 0], "v": [1, 0, 0], "material": "m" });
    scene["geometry"].as_array_mut().expect("a list").push(panel);
    let shelf =
        json!({ "name": "shelf", "type": "box", "min": [1.4, 0.2, 1], "max": [1.6, 2.8, 1.8], "material": "m" });
    scene["geometry"].as_array_mut().expect("a list").push(shelf);
    let area = json!({ "name": "area", "type": "area", "surface": "panel", "luminous_flux_lm": 1000 });
    scene["luminaires"].as_array_mut().expect("a list").push(area);
    scene["materials"]["m"]["reflectance"] = json!(0);
    let path = written(home.path(), &scene);
    for (step, warned) in [("50", false), ("1e-9", true)] {
        let more = ["--method", "light-mesh", "--mesh-step", step, "--maps", "receivers"];
        let output = solve_file(&path, &out, &more);
        assert_eq!(code(&output), 0, "{step}: {}", errors(&output));
        assert_eq!(errors(&output).contains("warning: \"g\" has no mesh"), warned, "{step}: {}", errors(&output));
    }
}

#[cfg(unix)]
#[test]
fn a_limit_on_the_size_of_files_is_reported_and_nothing_half_written_stays() {
    let home = tempfile::tempdir().expect("a temporary directory");
    let path = written(home.path(), &room());
    let out = home.path().join("out");
    let program = luxmc(&[]).get_program().to_owned();
    let command = format!(
        "ulimit -f 8; exec {} solve {} --out {} --chains 100",
        program.to_str().expect("UTF-8"),
        text(&path),
        text(&out)
    );
    let output = std::process::Command::new("sh").args(["-c", &command]).output().expect("a shell");
    assert_eq!(output.status.code(), Some(4), "{}", errors(&output));
    assert!(errors(&output).contains("cannot be written"), "{}", errors(&output));
    assert!(listing(&out).is_empty(), "{:?}", listing(&out));
}

/// Checks that were left out are named in the summary. Nothing else changes.
#[test]
fn checks_of_meshes_that_are_left_out_are_reported() {
    let home = tempfile::tempdir().expect("a temporary directory");
    let warnings = |name: &str, more: &[&str]| -> String {
        let out = home.path().join(name);
        let room = cli_support::scene("room.json");
        let output = solve_file(&room, &out, &[&["--chains", "500", "--plots", "none", "--quiet"][..], more].concat());
        assert_eq!(code(&output), 0, "{}", errors(&output));
        summary(&out)["warnings"].to_string()
    };
    assert!(!warnings("all", &[]).contains("skip-check"));
    let some = warnings("some", &["--skip-check", "faults,overlaps"]);
    assert!(some.contains("--skip-check left out faults, overlaps") && !some.contains("insides"), "{some}");
    let more = warnings("more", &["--skip-check", "advice", "--skip-check", "insides"]);
    assert!(more.contains("left out advice, insides; tables and errors include points"), "{more}");
    let read = |name: &str| std::fs::read(home.path().join(name).join("receivers.csv")).expect("written");
    assert!(read("all") == read("some"));
    let output = run(&["inspect", text(&cli_support::scene("room.json")), "--skip-check", "everything"]);
    assert!(code(&output) == 2 && errors(&output).contains("faults, overlaps, advice, insides"), "{}", errors(&output));
}
