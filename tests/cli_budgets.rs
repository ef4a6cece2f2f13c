//! The program keeps to what it is given: memory, sizes of files, and places of a set once a time limit is long over.

mod cli_support;

use std::path::Path;

use cli_support::{code, errors, luxmc, run, solve_file, summary, text};

fn office() -> std::path::PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/office.json")
}

/// Cells that would take more than their share of the memory give way to walks and counts, at the same ray for any number of
/// threads; with enough memory the same run gathers to its end.
#[test]
fn cells_give_way_where_they_would_take_more_than_their_share() {
    let home = tempfile::tempdir().expect("a temporary directory");
    let solved = |name: &str, memory: &str, threads: &str| {
        let out = home.path().join(name);
        let options = ["--method", "gather", "--chains", "800000", "--plots", "none", "--memory-limit", memory];
        let output = solve_file(&office(), &out, &[&options[..], &["--threads", threads]].concat());
        assert_eq!(code(&output), 0, "{}", errors(&output));
        let summary = summary(&out);
        let gathers = summary["maps"].as_array().expect("maps").iter().all(|map| map["method"] == "gather");
        let reasons = summary["maps"].to_string();
        let tables =
            ["elements.csv", "receivers.csv", "tables.csv"].map(|file| std::fs::read(out.join(file)).expect("written"));
        (gathers, reasons, tables)
    };
    let (gathers, reasons, one) = solved("one", "100MB", "1");
    assert!(!gathers && reasons.contains("took all of their 11 MB of memory"), "{reasons}");
    assert!(solved("two", "100MB", "2").2 == one, "tables differ with the number of threads");
    assert!(solved("wide", "4GB", "2").0);
}

/// What cannot do without memory ends in words, and nothing is left.
#[test]
fn memory_that_is_used_up_ends_the_run_in_words() {
    let home = tempfile::tempdir().expect("a temporary directory");
    let scene = home.path().join("scene.json");
    let text_of = r#"{ "version": 1, "materials": { "m": { "type": "diffuse", "reflectance": 0.5 } },
        "geometry": [ { "name": "r", "type": "box", "min": [0,0,0], "max": [4,3,2.5], "facing": "inward", "material": "m" } ],
        "luminaires": [ { "name": "l", "type": "point", "position": [1,1,2], "luminous_flux_lm": 1, "columns": 1000, "rows": 1000,
                          "u": [2,0,0], "v": [0,1,0] } ] }"#;
    std::fs::write(&scene, text_of).expect("written");
    let out = home.path().join("out");
    let output = solve_file(&scene, &out, &["--memory-limit", "64MB", "--chains", "1"]);
    assert_eq!(code(&output), 4, "{}", errors(&output));
    assert!(errors(&output).contains("the memory is used up") && !out.exists(), "{}", errors(&output));
    let output = solve_file(&scene, &out, &["--memory-limit", "1 horse"]);
    assert!(code(&output) == 2 && errors(&output).contains("no unit of memory"), "{}", errors(&output));
}

/// A mesh beyond the stated size is read only by request; a pipe never.
#[test]
fn large_meshes_ask_for_a_word_and_pipes_are_refused() {
    let home = tempfile::tempdir().expect("a temporary directory");
    let scene = home.path().join("scene.json");
    let text_of = r#"{ "version": 1, "materials": { "m": { "type": "diffuse", "reflectance": 0.5 } },
        "geometry": [ { "name": "r", "type": "mesh", "file": "mesh.obj", "material": "m" } ],
        "luminaires": [ { "name": "l", "type": "point", "position": [1,1,2], "luminous_flux_lm": 1 } ] }"#;
    std::fs::write(&scene, text_of).expect("written");
    let mesh = home.path().join("mesh.obj");
    // A hole of 513 MiB, which takes no room on the disk.
    std::fs::File::create(&mesh).and_then(|file| file.set_len(513 << 20)).expect("a hole");
    let output = run(&["inspect", text(&scene)]);
    assert_eq!(code(&output), 2);
    assert!(errors(&output).contains("--allow-large"), "{}", errors(&output));

    std::fs::remove_file(&mesh).expect("removed");
    if std::process::Command::new("mkfifo").arg(&mesh).status().is_ok_and(|status| status.success()) {
        let output = luxmc(&["inspect", text(&scene), "--allow-large"]).output().expect("the program starts");
        assert_eq!(code(&output), 2);
        assert!(errors(&output).contains("a device or a pipe"), "{}", errors(&output));
    }
}

/// A walk in this room meets ten thousand surfaces, and nobody has time for one from each of 40,000 points: the set is left out
/// and named, instead of a wait of minutes.
#[test]
fn what_there_is_no_time_for_is_left_out_and_named() {
    let home = tempfile::tempdir().expect("a temporary directory");
    let scene = home.path().join("scene.json");
    let text_of = r#"{ "version": 1, "materials": { "m": { "type": "diffuse", "reflectance": 0.9998 } },
        "geometry": [ { "name": "r", "type": "box", "min": [0,0,0], "max": [4,3,2.5], "facing": "inward", "material": "m" } ],
        "luminaires": [ { "name": "l", "type": "point", "position": [1,1,2], "luminous_flux_lm": 1000 } ],
        "receivers": [ { "name": "g", "type": "grid", "origin": [0.5,0.5,0.8], "u": [3,0,0], "v": [0,2,0], "columns": 200, "rows": 200 } ] }"#;
    std::fs::write(&scene, text_of).expect("written");
    let out = home.path().join("out");
    let options = ["--method", "collision", "--time-limit", "100ms", "--target-error", "1%", "--plots", "none"];
    let output = solve_file(&scene, &out, &options);
    assert_eq!(code(&output), 3, "{}", errors(&output));
    assert!(errors(&output).contains("\"g\" is left out"), "{}", errors(&output));
    let summary = summary(&out);
    assert_eq!(summary["target_met"], false);
    // Some millions of rays of the six billion that a walk in every replica from every point would take.
    assert!(summary["rays"].as_u64().expect("a number") < 100_000_000, "{}", summary["rays"]);
}
