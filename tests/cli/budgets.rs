//! The program keeps its limits of memory, file size and time. Long after a time limit it also leaves out points of a set.

use std::path::Path;

use crate::cli_support::{code, errors, luxmc, run, solve_file, summary, text};

fn office() -> std::path::PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/office.json")
}

/// Cells that would exceed their share of the memory are replaced by walks and counts. The tables are the same with one thread and with
/// two. With enough memory the same run uses gathering to its end.
#[test]
fn cells_give_way_where_they_would_take_more_than_their_share() {
    let home = tempfile::tempdir().expect("a temporary directory");
    let solved = |name: &str, memory: &str, threads: &str| {
        let out = home.path().join(name);
        let options = ["--method", "gather", "--chains", "50000", "--plots", "none", "--memory-limit", memory];
        let output = solve_file(&office(), &out, &[&options[..], &["--threads", threads]].concat());
        assert_eq!(code(&output), 0, "{}", errors(&output));
        let summary = summary(&out);
        let gathers = summary["maps"].as_array().expect("maps").iter().all(|map| map["method"] == "gather");
        let reasons = summary["maps"].to_string();
        let tables =
            ["elements.csv", "receivers.csv", "tables.csv"].map(|file| std::fs::read(out.join(file)).expect("written"));
        (gathers, reasons, tables)
    };
    let (gathers, reasons, one) = solved("one", "64MB", "1");
    assert!(!gathers && reasons.contains("used up their 7 MB of memory"), "{reasons}");
    assert!(solved("two", "64MB", "2").2 == one, "tables differ with the number of threads");
    assert!(solved("wide", "4GB", "2").0);
}

/// A scene file in a temporary folder. The folder is deleted with the first value.
fn scene_in_a_folder(text: &str) -> (tempfile::TempDir, std::path::PathBuf) {
    let home = tempfile::tempdir().expect("a temporary directory");
    let scene = home.path().join("scene.json");
    std::fs::write(&scene, text).expect("written");
    (home, scene)
}

/// A run that exceeds its memory ends with a message and leaves no files.
#[test]
fn memory_that_is_used_up_ends_the_run_in_words() {
    let (home, scene) = scene_in_a_folder(
        r#"{ "version": 1, "materials": { "m": { "type": "diffuse", "reflectance": 0.5 } },
        "geometry": [ { "name": "r", "type": "box", "min": [0,0,0], "max": [4,3,2.5], "facing": "inward", "material": "m" } ],
        "luminaires": [ { "name": "l", "type": "point", "position": [1,1,2], "luminous_flux_lm": 1, "columns": 1000, "rows": 1000,
                          "u": [2,0,0], "v": [0,1,0] } ] }"#,
    );
    let out = home.path().join("out");
    let output = solve_file(&scene, &out, &["--memory-limit", "64MB", "--chains", "1"]);
    assert_eq!(code(&output), 4, "{}", errors(&output));
    assert!(errors(&output).contains("out of memory") && !out.exists(), "{}", errors(&output));
    let output = solve_file(&scene, &out, &["--memory-limit", "1 horse"]);
    assert!(code(&output) == 2 && errors(&output).contains("no unit of memory"), "{}", errors(&output));
}

/// A mesh above the stated size is read only with an option. A pipe is never read.
#[test]
fn large_meshes_ask_for_a_word_and_pipes_are_refused() {
    let (home, scene) = scene_in_a_folder(
        r#"{ "version": 1, "materials": { "m": { "type": "diffuse", "reflectance": 0.5 } },
        "geometry": [ { "name": "r", "type": "mesh", "file": "mesh.obj", "material": "m" } ],
        "luminaires": [ { "name": "l", "type": "point", "position": [1,1,2], "luminous_flux_lm": 1 } ] }"#,
    );
    let mesh = home.path().join("mesh.obj");
    // A sparse file of 513 MiB, which takes no space on the disk.
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

/// 15,000 luminaires and a limit of 50 ms: a warning before anything is read states that reading, preparing and writing take longer. A room
/// with one lamp gets no warning.
#[test]
fn what_takes_longer_than_the_limit_whatever_is_computed_is_reported_before_it_is_read() {
    let text = |columns: u32| {
        format!(
            r#"{{ "version": 1, "materials": {{ "m": {{ "type": "diffuse", "reflectance": 0.5 }} }},
            "geometry": [ {{ "name": "r", "type": "box", "min": [0,0,0], "max": [4,4,3], "facing": "inward", "material": "m" }} ],
            "luminaires": [ {{ "name": "l", "type": "point", "position": [1,1,2], "luminous_flux_lm": 10,
                "columns": {columns}, "rows": 1, "u": [2,0,0] }} ] }}"#
        )
    };
    for (columns, limit, is_reported) in [(15_000, "0.05s", true), (1, "0.05s", false), (15_000, "1h", false)] {
        let (home, scene) = scene_in_a_folder(&text(columns));
        let options = ["--time-limit", limit, "--chains", "16", "--plots", "none"];
        let output = solve_file(&scene, &home.path().join("out"), &options);
        let told = errors(&output);
        let (warning, opening) = (told.find("warning: reading this scene takes about"), told.find("luxmc 0"));
        assert_eq!(warning.is_some(), is_reported, "{columns}, {limit}: {told}");
        assert!(opening.is_some() && (warning.is_none() || warning < opening), "{told}");
    }
}

/// On any machine, a million luminaires take longer to read than a limit of a millisecond and one second more. The run ends with a message
/// that states how far reading came and which limit would be enough. Nothing is written, not even a directory. Without a limit, or with a
/// long one, the run is not ended.
#[test]
fn reading_that_goes_on_long_after_the_limit_ends_in_words() {
    let text = |columns: u32| {
        format!(
            r#"{{ "version": 1, "materials": {{ "m": {{ "type": "diffuse", "reflectance": 0.5 }} }},
            "geometry": [ {{ "name": "r", "type": "box", "min": [0,0,0], "max": [4,4,3], "facing": "inward", "material": "m" }} ],
            "luminaires": [ {{ "name": "l", "type": "point", "position": [1,1,2], "luminous_flux_lm": 10,
                "columns": {columns}, "rows": 1000, "u": [2,0,0], "v": [0,2,0] }} ] }}"#
        )
    };
    let (home, scene) = scene_in_a_folder(&text(1000));
    let out = home.path().join("out");
    let output = solve_file(&scene, &out, &["--time-limit", "1ms", "--plots", "none"]);
    let told = errors(&output);
    assert_eq!(code(&output), 2, "{told}");
    let (before, ends) =
        (told.find("ends the run during reading"), told.find("the time limit ends the run before its scene was read"));
    assert!(before.is_some() && before < ends && told.contains("reading had reached"), "{told}");
    assert!(told.contains("raise --time-limit") && !out.exists(), "{told}");

    let (home, scene) = scene_in_a_folder(&text(2));
    let output =
        solve_file(&scene, &home.path().join("out"), &["--time-limit", "1h", "--chains", "16", "--plots", "none"]);
    assert_eq!(code(&output), 0, "{}", errors(&output));
}

/// A walk in this room meets ten thousand surfaces. One walk from each of 40,000 points would take minutes. The set is left out and named
/// instead.
#[test]
fn what_there_is_no_time_for_is_left_out_and_named() {
    let (home, scene) = scene_in_a_folder(
        r#"{ "version": 1, "materials": { "m": { "type": "diffuse", "reflectance": 0.9998 } },
        "geometry": [ { "name": "r", "type": "box", "min": [0,0,0], "max": [4,3,2.5], "facing": "inward", "material": "m" } ],
        "luminaires": [ { "name": "l", "type": "point", "position": [1,1,2], "luminous_flux_lm": 1000 } ],
        "receivers": [ { "name": "g", "type": "grid", "origin": [0.5,0.5,0.8], "u": [3,0,0], "v": [0,2,0], "columns": 200, "rows": 200 } ] }"#,
    );
    let out = home.path().join("out");
    let options = ["--method", "collision", "--time-limit", "100ms", "--target-error", "1%", "--plots", "none"];
    let output = solve_file(&scene, &out, &options);
    assert_eq!(code(&output), 3, "{}", errors(&output));
    assert!(errors(&output).contains("\"g\" is left out"), "{}", errors(&output));
    let summary = summary(&out);
    assert_eq!(summary["target_met"], false);
    // A walk in every replica from every point would take six billion rays. The run takes some millions.
    assert!(summary["rays"].as_u64().expect("a number") < 100_000_000, "{}", summary["rays"]);
}

/// 12,000 luminaires from one entry. The summary has them all in one entry, and the plan draws symbols where there is room for them.
/// Reading alone takes longer than the limit, which is reported before the run.
#[test]
fn very_many_luminaires_are_written_once_and_drawn_where_there_is_room() {
    let (home, scene) = scene_in_a_folder(
        r#"{ "version": 1, "materials": { "m": { "type": "diffuse", "reflectance": 0.5 } },
        "geometry": [ { "name": "r", "type": "box", "min": [0,0,0], "max": [20,20,3], "facing": "inward", "material": "m" } ],
        "luminaires": [ { "name": "l", "type": "point", "position": [1,1,2], "luminous_flux_lm": 10,
            "columns": 120, "rows": 100, "u": [18,0,0], "v": [0,18,0] } ] }"#,
    );
    let out = home.path().join("out");
    let output = solve_file(&scene, &out, &["--method", "collision", "--time-limit", "0.1ms", "--plots", "none"]);
    assert_eq!(code(&output), 0, "{}", errors(&output));
    let said = errors(&output);
    let told = said.find("reading and checking the scene took").expect("told");
    assert!(told < said.find("time limit reached").expect("an end"), "{said}");
    let luminaires = summary(&out)["luminaires"].as_array().expect("luminaires").clone();
    // All are equal, so one entry represents them.
    assert_eq!(luminaires.len(), 1);
    assert_eq!((&luminaires[0]["count"], &luminaires[0]["luminous_flux_lm"]), (&12_000.into(), &10.0.into()));
    assert_eq!((&luminaires[0]["name"], &luminaires[0]["last_name"]), (&"l 1".into(), &"l 12000".into()));
    let report = std::fs::read_to_string(out.join("report.html")).expect("a report");
    assert!(report.len() < 3_000_000, "{} bytes", report.len());
}

/// A white box of sheets with gaps between them. It is not a closed room and is therefore not refused. Packets in it would meet tens of
/// millions of surfaces. They are cut off and reported, and a time limit ends the run.
#[test]
fn packets_in_a_white_pocket_are_cut_off_and_told_of() {
    let home = tempfile::tempdir().expect("a temporary directory");
    let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("fuzz/cli/corpus/white-pocket/scene.json");
    let options = |method: &'static str| {
        ["--method", method, "--time-limit", "30ms", "--plots", "none", "--maps", "elements", "--elements", "given"]
    };
    for method in ["collision", "local", "gather"] {
        let out = home.path().join(method);
        let output = solve_file(&scene, &out, &options(method));
        assert_eq!(code(&output), 0, "{}", errors(&output));
        // 16 packets of 200,000 rays, and a pilot.
        let rays = summary(&out)["rays"].as_u64().expect("a number");
        assert!(rays < 20_000_000, "{rays}");
    }
    let out = home.path().join("one");
    let options =
        ["--method", "collision", "--chains", "1", "--plots", "none", "--maps", "elements", "--elements", "given"];
    let output = solve_file(&scene, &out, &options);
    assert_eq!(code(&output), 0, "{}", errors(&output));
    assert!(errors(&output).contains("of the flux was cut off"), "{}", errors(&output));
    let balance = &summary(&out)["flux_balance"];
    assert!(balance["truncated_lm"].as_f64().expect("a number") > 0.0, "{balance}");
}

/// In this scene, the pilot of local estimation keeps the vertices of a few chains instead of sixteen, because each chain has 200,000. The
/// run ends by its time limit and not by its memory limit (exit code 4).
#[test]
fn local_estimation_in_a_white_pocket_keeps_to_its_memory() {
    let home = tempfile::tempdir().expect("a temporary directory");
    let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("fuzz/cli/corpus/white-pocket-crossed/scene.json");
    let out = home.path().join("out");
    let options = ["--method", "local-naive", "--time-limit", "60ms", "--memory-limit", "256MB", "--plots", "none"];
    let output = solve_file(&scene, &out, &options);
    assert!(matches!(code(&output), 0 | 3), "{}", errors(&output));
    let peak = summary(&out)["peak_memory_bytes"].as_u64().expect("a number");
    assert!(peak > 1_000_000 && peak <= 256_000_000, "{peak}");
}

/// 400 luminaires with a measured distribution: radiosity has no result after 20 ms. It reports this and writes nothing.
#[test]
fn radiosity_without_time_for_its_coarsest_meshes_is_refused() {
    let home = tempfile::tempdir().expect("a temporary directory");
    let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("fuzz/cli/corpus/many-directed/scene.json");
    let out = home.path().join("out");
    let output = solve_file(&scene, &out, &["--method", "radiosity", "--time-limit", "20ms", "--plots", "none"]);
    assert_eq!(code(&output), 2, "{}", errors(&output));
    assert!(errors(&output).contains("allow more time"), "{}", errors(&output));
    assert!(!out.exists());
}

/// A target that takes days, with a time limit: a message before the work states that the limit comes first. A target that is met at once
/// gives no message.
#[test]
fn a_target_out_of_reach_is_reported_before_the_work() {
    let home = tempfile::tempdir().expect("a temporary directory");
    let cube = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/cube.json");
    let said = |name: &str, options: &[&str]| {
        let all = [options, &["--plots", "none", "--elements", "given", "--method", "collision"]].concat();
        errors(&solve_file(&cube, &home.path().join(name), &all))
    };
    let limited = said("limited", &["--target-error", "0.0001%", "--time-limit", "2s"]);
    let told = limited.find("the time limit comes before the target of 0.000100 %").expect("told");
    assert!(told < limited.find("target not met").expect("an end"), "{limited}");
    let met = said("met", &["--target-error", "20%", "--time-limit", "60s"]);
    assert!(!met.contains("comes before") && met.contains("target met"), "{met}");
}
