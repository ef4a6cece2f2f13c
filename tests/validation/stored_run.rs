//! A stored run as the truth: errors count on both sides, a fault of two percent is detected, another scene is refused.

use std::ffi::OsString;
use std::fs;
use std::path::Path;
use std::process::{Command, Output};
use std::sync::LazyLock;

use luxmc::validation::{Case, run_case};
use serde_json::{Value, json};
use tempfile::TempDir;

fn luxmc(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_luxmc")).args(arguments).output().unwrap()
}

fn scene() -> Value {
    json!({
        "version": 1,
        "materials": { "paint": { "type": "diffuse", "reflectance": 0.5 } },
        "geometry": [{ "name": "room", "type": "box", "min": [0, 0, 0], "max": [4, 3, 2.5], "facing": "inward",
                       "material": "paint", "max_element_edge": 1 }],
        "luminaires": [{ "name": "lamp", "type": "point", "position": [2, 1.5, 2], "luminous_flux_lm": 1000 }],
        "receivers": [{ "name": "desk", "type": "grid", "origin": [0.5, 0.5, 0.8], "u": [3, 0, 0], "v": [0, 2, 0],
                        "columns": 6, "rows": 5 }]
    })
}

/// The files of a long run (seed 1000, 8 times the chains of the judged run), with their names.
static LONG_RUN: LazyLock<Vec<(OsString, Vec<u8>)>> = LazyLock::new(|| {
    let home = TempDir::new().unwrap();
    let (file, out) = (home.path().join("room.json"), home.path().join("long"));
    fs::write(&file, scene().to_string()).unwrap();
    let arguments = ["--chains", "1600000", "--seed", "1000", "--plots", "none", "--quiet", "--out"];
    let mut all = vec!["solve", file.to_str().unwrap()];
    all.extend(arguments);
    all.push(out.to_str().unwrap());
    assert!(luxmc(&all).status.success());
    let files = fs::read_dir(out).unwrap().map(Result::unwrap);
    files.map(|file| (file.file_name(), fs::read(file.path()).unwrap())).collect()
});

/// Scene, long run and a case in a new folder.
fn home() -> TempDir {
    let home = TempDir::new().unwrap();
    let at = |name: &str| home.path().join(name);
    fs::write(at("room.json"), scene().to_string()).unwrap();
    fs::create_dir(at("long")).unwrap();
    for (name, bytes) in LONG_RUN.iter() {
        fs::write(at("long").join(name), bytes).unwrap();
    }
    let truth = json!({ "function": "run", "folder": "long" });
    let criterion = json!({ "coverage_alpha": 1e-4 });
    let case = json!({
        "title": "A room", "physics": "Judged by a long run of itself.", "groups": [], "scene_file": "room.json",
        "runs": [{ "name": "short", "chains": 200_000, "seed": 3 }],
        "compare": [
            { "name": "desk", "what": "points", "map": "desk", "truth": truth, "criterion": criterion },
            { "name": "elements", "what": "elements", "truth": truth, "criterion": criterion },
            { "name": "floor", "what": "average", "surface": "room/floor", "truth": truth, "criterion": { "worst": "5%" } },
            { "name": "mean", "what": "average", "map": "desk", "truth": truth, "criterion": { "worst": "5%" } }
        ]
    });
    fs::write(at("case.json"), case.to_string()).unwrap();
    home
}

fn passes(folder: &Path) -> bool {
    let case = Case::read(folder).unwrap_or_else(|error| panic!("{error}"));
    run_case(&case, &mut |_| {}).unwrap_or_else(|error| panic!("{error}")).passes()
}

/// Multiplies columns of a CSV file by a factor.
fn scale(path: &Path, columns: &[&str], factor: f64) {
    let mut reader = csv::Reader::from_path(path).unwrap();
    let header = reader.headers().unwrap().clone();
    let rows: Vec<csv::StringRecord> = reader.records().map(Result::unwrap).collect();
    let mut writer = csv::Writer::from_path(path).unwrap();
    writer.write_record(&header).unwrap();
    for row in rows {
        let cells = row.iter().zip(&header).map(|(cell, name)| match columns.contains(&name) {
            true => (factor * cell.parse::<f64>().unwrap()).to_string(),
            false => cell.to_owned(),
        });
        writer.write_record(cells.collect::<Vec<_>>()).unwrap();
    }
    writer.flush().unwrap();
}

#[test]
fn a_short_run_agrees_with_a_long_one_and_a_fault_of_two_percent_is_seen() {
    let home = home();
    assert!(passes(home.path()));
    let long = home.path().join("long");
    let receivers = fs::read(long.join("receivers.csv")).unwrap();
    scale(&long.join("receivers.csv"), &["illuminance_lx"], 1.02);
    assert!(!passes(home.path()), "the planted fault passed at the points");
    fs::write(long.join("receivers.csv"), receivers).unwrap();
    assert!(passes(home.path()));
    scale(&long.join("elements.csv"), &["illuminance_lx"], 1.02);
    assert!(!passes(home.path()), "the planted fault passed in the elements");
}

#[test]
fn another_scene_and_shared_random_numbers_are_refused() {
    let home = home();
    let case_file = home.path().join("case.json");
    let text = fs::read_to_string(&case_file).unwrap();
    fs::write(&case_file, text.replace("\"seed\":3", "\"seed\":1000")).unwrap();
    let told = Case::read(home.path()).unwrap_err().to_string();
    assert!(told.contains("shares its random numbers"), "{told}");
    fs::write(&case_file, text).unwrap();

    let scene_file = home.path().join("room.json");
    let text = fs::read_to_string(&scene_file).unwrap();
    fs::write(&scene_file, text.replace("1000", "1010")).unwrap();
    let told = Case::read(home.path()).unwrap_err().to_string();
    assert!(told.contains("computed another scene") && told.contains("luminous_flux_lm"), "{told}");
    fs::write(&scene_file, text.replace("[0.5,0.5,0.8]", "[0.5,0.5,0.9]")).unwrap();
    let told = run_case(&Case::read(home.path()).unwrap(), &mut |_| {}).unwrap_err().to_string();
    assert!(told.contains("row 0"), "{told}");
}

#[test]
fn a_scene_is_compared_with_its_long_run() {
    let home = home();
    let [scene, long, speed] = ["room.json", "long", "speed"].map(|name| home.path().join(name));
    let [scene, long, speed] = [&scene, &long, &speed].map(|path| path.to_str().unwrap());
    let output = luxmc(&["compare", scene, "--truth", long, "--out", speed, "--budget", "1s", "--quiet"]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let table = fs::read_to_string(home.path().join("speed/compare.csv")).unwrap();
    assert!(table.contains("desk") && table.contains("elements"), "{table}");

    let output = luxmc(&["compare", scene, "--truth", home.path().to_str().unwrap(), "--out", speed]);
    assert_eq!(output.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&output.stderr).contains("luxmc solve"));
}
