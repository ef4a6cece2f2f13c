//! The smaller commands: `sobolev`, `inspect`, `schema`, help.

use std::io::Read;
use std::process::Stdio;

use crate::cli_support::*;

const SOBOLEV: [&str; 7] = ["sobolev", "--h1", "0.5", "--rho1", "0.5", "--rho2", "0.5"];

fn sobolev(more: &[&str]) -> Vec<Vec<f64>> {
    let output = run(&[&SOBOLEV[..], more].concat());
    assert_eq!(code(&output), 0, "{}", errors(&output));
    let text = results(&output);
    let mut lines = text.lines();
    assert_eq!(lines.next(), Some("r,direct,reflected,total,estimated_error"));
    lines.map(|line| line.split(',').map(|cell| cell.parse().expect("a number")).collect()).collect()
}

#[test]
fn sobolev_keeps_the_order_asked_and_the_direct_part_is_the_closed_formula() {
    let rows = sobolev(&["--r", "1,0,0.5"]);
    for (row, r) in rows.iter().zip([1.0, 0.0, 0.5f64]) {
        assert_eq!(row[0], r);
        let direct = 0.5 / (0.25 + r * r).powf(1.5);
        assert!((row[1] - direct).abs() < 1e-14 * direct, "{} {direct}", row[1]);
        assert!((row[3] - row[1] - row[2]).abs() < 1e-14 * row[3]);
        assert!(row[4] >= 0.0 && row[4] < 1e-9);
    }
    let spaced = sobolev(&["--r", "0:3:31", "--plane", "2"]);
    assert_eq!((spaced.len(), spaced[3][0], spaced[30][0]), (31, 0.3, 3.0));

    // A source half way between equal planes lights both planes alike.
    assert_eq!(sobolev(&["--r", "0.3"])[0], sobolev(&["--r", "0.3", "--plane", "2"])[0]);
}

#[test]
fn sobolev_refuses_what_has_no_answer() {
    for more in [
        &["sobolev", "--h1", "1.5", "--rho1", "0.5", "--rho2", "0.5", "--r", "0"][..],
        &["sobolev", "--h1", "0.5", "--rho1", "1", "--rho2", "1", "--r", "0"],
        &["sobolev", "--h1", "0.5", "--rho1", "-0.1", "--rho2", "1", "--r", "0"],
        &["sobolev", "--h1", "nan", "--rho1", "0.5", "--rho2", "0.5", "--r", "0"],
        &["sobolev", "--h1", "0.5", "--rho1", "0.5", "--rho2", "0.5", "--r", "-1,0"],
        &["sobolev", "--h1", "0.5", "--rho1", "0.5", "--rho2", "0.5", "--r", "0:1:0"],
        &["sobolev", "--h1", "0.5", "--rho1", "0.5", "--rho2", "0.5", "--r", "0", "--plane", "3"],
        &["sobolev", "--h1", "0.5"],
    ] {
        let output = run(more);
        assert_eq!(code(&output), 2, "{more:?}: {}", errors(&output));
        assert!(output.stdout.is_empty() && !output.stderr.is_empty());
    }
}

#[test]
fn inspect_shows_surfaces_luminaires_and_receivers() {
    let scene = scene("room.json");
    let tables = run(&["inspect", text(&scene)]);
    assert_eq!(code(&tables), 0, "{}", errors(&tables));
    for told in ["room/floor", "panel, upper", "front, back", "glow", "work plane", "3 x 2", "closed"] {
        assert!(results(&tables).contains(told), "{told} is missing in\n{}", results(&tables));
    }
    let json = run(&["inspect", text(&scene), "--json"]);
    let read: serde_json::Value = serde_json::from_str(&results(&json)).expect("JSON");
    let area_m2 = read["totals"]["area_m2"].as_f64().expect("a number");
    assert!((area_m2 - 25.0).abs() < 1e-12, "{area_m2}");
    let flux_lm = read["luminaires"][0]["luminous_flux_lm"].as_f64().expect("a number");
    assert!((flux_lm - 400.0).abs() < 1e-9, "{flux_lm}");
    assert_eq!(code(&run(&["inspect", "no-such-scene.json"])), 2);
}

#[test]
fn inspect_shows_photometric_files() {
    for (name, flux_lm) in [("troffer.ies", 3600.0), ("downlight.ldt", 1100.0)] {
        let file = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/luminaires").join(name);
        let read = run(&["inspect", text(&file)]);
        assert_eq!(code(&read), 0, "{}", errors(&read));
        assert!(results(&read).contains("light output ratio") && results(&read).contains("beam"));
        let json = run(&["inspect", text(&file), "--json"]);
        let read: serde_json::Value = serde_json::from_str(&results(&json)).expect("JSON");
        let told_lm = read["luminous_flux_lm"].as_f64().expect("a number");
        assert!((told_lm - flux_lm).abs() < 2e-3 * flux_lm, "{told_lm}");
    }
    assert_eq!(code(&run(&["inspect", "no-such-file.ies"])), 2);
}

#[test]
fn the_schema_is_json_and_names_the_scene_file_s_keys() {
    let schema: serde_json::Value = serde_json::from_str(&results(&run(&["schema"]))).expect("JSON");
    for key in ["version", "materials", "geometry", "luminaires", "receivers"] {
        assert!(schema["properties"].get(key).is_some(), "{key}");
    }
}

#[test]
fn a_reader_that_goes_away_is_no_error() {
    let mut child = luxmc(&[&SOBOLEV[..], &["--r", "0:3:20001"]].concat())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the program starts");
    let mut first = [0; 1];
    let mut output = child.stdout.take().expect("a pipe");
    output.read_exact(&mut first).expect("one byte");
    drop(output);
    let ended = child.wait_with_output().expect("it ended");
    assert_eq!(code(&ended), 0, "{}", errors(&ended));
    assert!(ended.stderr.is_empty(), "{}", errors(&ended));
}

#[test]
fn every_command_explains_itself() {
    for command in ["solve", "sobolev", "inspect", "schema"] {
        let help = run(&[command, "--help"]);
        assert_eq!(code(&help), 0);
        assert!(results(&help).contains("Usage: luxmc"), "{command}");
    }
    for option in [
        "--target-error",
        "--time-limit",
        "--chains",
        "--seed",
        "--threads",
        "--maps",
        "--method",
        "--plots",
        "--quiet",
    ] {
        assert!(results(&run(&["solve", "--help"])).contains(option), "{option}");
    }
    assert_eq!(code(&run(&["--version"])), 0);
}
