//! `luxmc solve` as its users see it: bytes, exit codes, files.

use std::path::Path;
#[cfg(unix)]
use std::time::Duration;

use crate::cli_support::*;

const TABLES: [&str; 3] = ["elements.csv", "receivers.csv", "tables.csv"];

fn directory() -> tempfile::TempDir {
    tempfile::tempdir().expect("a temporary directory")
}

#[test]
fn any_number_of_threads_and_any_run_give_the_same_bytes() {
    let home = directory();
    let bytes = |name: &str, threads: &str, seed: &str| {
        let out = home.path().join(name);
        let output = solve("room.json", &out, &["--chains", "20000", "--threads", threads, "--seed", seed, "--quiet"]);
        assert_eq!(code(&output), 0, "{}", errors(&output));
        TABLES.map(|table| std::fs::read(out.join(table)).expect("written"))
    };
    let one = bytes("one", "1", "5");
    assert!(one == bytes("two", "2", "5"), "2 threads");
    assert!(one == bytes("seven", "7", "5"), "7 threads");
    assert!(one == bytes("again", "1", "5"), "a second run");
    assert!(one != bytes("other", "1", "6"), "the planted fault, another seed, was not seen");
}

#[test]
fn tables_have_their_columns_and_no_empty_cell() {
    let home = directory();
    let output = solve("room.json", home.path(), &["--chains", "2000"]);
    assert_eq!(code(&output), 0, "{}", errors(&output));
    assert!(results(&output).contains("work plane") && !results(&output).contains("target"));
    let headers = [
        (
            "elements.csv",
            "surface,element,side,x,y,z,nx,ny,nz,area_m2,illuminance_lx,standard_error_lx,direct_lx,indirect_lx,exitance_lm_m2,luminance_cd_m2,even_lx,odd_lx,diffuse_luminance_cd_m2,emitted_luminance_cd_m2,material_type",
        ),
        (
            "receivers.csv",
            "receiver,index,x,y,z,nx,ny,nz,illuminance_lx,standard_error_lx,direct_lx,indirect_lx,inside,even_lx,odd_lx",
        ),
        (
            "tables.csv",
            "name,kind,side,average_lx,average_standard_error_lx,minimum_lx,minimum_standard_error_lx,maximum_lx,uniformity_u0,uniformity_u0_standard_error,uniformity_ud,area_m2,estimated_error,maximum_standard_error_lx,uniformity_ud_standard_error,evaluation_points,covered_area_m2",
        ),
        (
            "convergence.csv",
            "wall_s,rays,chains,estimated_error,random_error,bias,forecast_rays,forecast_rays_low,forecast_rays_high,forecast_wall_s,forecast_wall_low_s,forecast_wall_high_s",
        ),
    ];
    const TEXTS: [&str; 7] = ["surface", "side", "receiver", "name", "kind", "inside", "material_type"];
    for (name, expected) in headers {
        let (header, rows) = table(&home.path().join(name));
        assert_eq!(header.join(","), expected, "{name}");
        assert!(!rows.is_empty(), "{name}");
        for (column, cell) in rows.iter().flat_map(|row| header.iter().zip(row)) {
            assert!(!cell.is_empty(), "{name}: an empty cell in {column}");
            if !TEXTS.contains(&column.as_str()) {
                let number: f64 = cell.parse().unwrap_or(f64::NAN);
                assert!(number.is_finite(), "{name}: {cell} in {column}");
            }
        }
    }
}

/// A dry run prints what every method needs for four errors and for the target. It requires no directory and writes nothing.
#[test]
fn a_dry_run_tells_what_targets_take() {
    let scene = scene("room.json");
    let output = run(&["solve", text(&scene), "--dry-run", "--target-error", "2%"]);
    assert_eq!(code(&output), 0, "{}", errors(&output));
    let results = results(&output);
    let lines = |method: &str| results.lines().filter(|line| line.starts_with(method)).count();
    assert_eq!(["auto", "gather", "collision", "local"].map(lines), [5; 4], "{results}");
    let refused = run(&["solve", text(&scene), "--dry-run", "--method", "radiosity"]);
    assert!(code(&refused) == 2 && results_are_empty(&refused), "{}", errors(&refused));
    let without = run(&["solve", text(&scene), "--target-error", "2%"]);
    assert!(code(&without) == 2 && errors(&without).contains("--out"), "{}", errors(&without));
}

fn results_are_empty(output: &std::process::Output) -> bool {
    output.stdout.is_empty()
}

/// Checks the halves in the tables. The mean of both halves is the illuminance. They differ by 2 of its standard errors in the root mean
/// square of many.
#[test]
fn the_halves_of_every_value_are_reported() {
    let home = directory();
    assert_eq!(code(&solve("room.json", home.path(), &["--target-error", "5%", "--maps", "all"])), 0);
    for name in ["elements.csv", "receivers.csv"] {
        let (header, rows) = table(&home.path().join(name));
        let place = |wanted: &str| header.iter().position(|column| column == wanted).expect("a column");
        let [whole, error, even, odd] = ["illuminance_lx", "standard_error_lx", "even_lx", "odd_lx"].map(place);
        let (mut differences, mut expected) = (0.0, 0.0);
        for row in &rows {
            let number = |column: usize| row[column].parse::<f64>().expect("a number");
            let mean_lx = 0.5 * (number(even) + number(odd));
            assert!((mean_lx - number(whole)).abs() <= 1e-9 * number(whole).abs().max(1.0), "{name}: {row:?}");
            differences += (number(odd) - number(even)).powi(2);
            expected += (2.0 * number(error)).powi(2);
        }
        let ratio = (differences / expected).sqrt();
        assert!((0.4..1.6).contains(&ratio), "{name}: {ratio} of what the errors say");
    }
}

#[test]
fn exitance_is_what_a_side_reflects_and_emits() {
    let home = directory();
    assert_eq!(
        code(&solve("room.json", home.path(), &["--chains", "2000", "--maps", "elements", "--elements", "given"])),
        0
    );
    let (header, rows) = table(&home.path().join("elements.csv"));
    let column = |name: &str| header.iter().position(|column| column == name).expect("a column");
    let number = |row: &[String], name: &str| row[column(name)].parse::<f64>().expect("a number");
    let mut emitting_sides = 0;
    for row in &rows {
        let is_panel = row[0] == "panel, upper";
        let emits = is_panel && row[2] == "back";
        emitting_sides += usize::from(emits);
        let reflectance = if is_panel { 0.25 } else { 0.5 };
        let own_lm_m2 = if emits { 0.8 * 500.0 } else { 0.0 };
        let exitance_lm_m2 = reflectance * number(row, "illuminance_lx") + own_lm_m2;
        assert!((number(row, "exitance_lm_m2") - exitance_lm_m2).abs() < 1e-9 * exitance_lm_m2.max(1.0));
        let luminance_cd_m2 = exitance_lm_m2 / std::f64::consts::PI;
        assert!((number(row, "luminance_cd_m2") - luminance_cd_m2).abs() < 1e-9 * luminance_cd_m2.max(1.0));
        let sum_lx = number(row, "direct_lx") + number(row, "indirect_lx");
        assert!((number(row, "illuminance_lx") - sum_lx).abs() < 1e-9 * sum_lx.max(1.0));
        if is_panel {
            assert_eq!(number(row, "nz"), if row[2] == "front" { 1.0 } else { -1.0 });
        }
    }
    assert_eq!(emitting_sides, 2, "two triangles");
}

/// Luminances of elements are named for what they are. A mirror differs from a black surface in the table: both have no diffuse luminance.
#[test]
fn luminances_of_elements_say_what_they_are_and_mirrors_are_not_black() {
    let home = directory();
    let scene = home.path().join("scene.json");
    let text = r#"{ "version": 1,
        "materials": { "black": { "type": "diffuse", "reflectance": 0 }, "silver": { "type": "mirror", "reflectance": 0.9 },
                       "lacquer": { "type": "phong", "diffuse_reflectance": 0.4, "specular_reflectance": 0.3, "exponent": 60 } },
        "geometry": [ { "name": "room", "type": "box", "min": [0,0,0], "max": [3,3,3], "facing": "inward", "material": "black",
                        "materials": { "floor": "lacquer", "x_min": "silver" } },
                      { "name": "panel", "type": "rectangle", "origin": [1,1,2.9], "u": [0,1,0], "v": [1,0,0], "material": "lacquer" } ],
        "luminaires": [ { "name": "light", "type": "area", "surface": "panel", "exitance_lm_m2": 400 } ] }"#;
    std::fs::write(&scene, text).expect("a scene");
    let out = home.path().join("out");
    let solved = solve_file(&scene, &out, &["--chains", "4000", "--elements", "given"]);
    assert_eq!(code(&solved), 0, "{}", errors(&solved));
    let (header, rows) = table(&out.join("elements.csv"));
    let column = |name: &str| header.iter().position(|column| column == name).expect("a column");
    let mut types = std::collections::BTreeMap::new();
    for row in &rows {
        let number = |name: &str| row[column(name)].parse::<f64>().expect("a number");
        let diffuse_cd_m2 = number("diffuse_luminance_cd_m2");
        // For the lacquer, only the diffuse part counts: 0.4 of the light, not 0.7.
        let reflectance = if row[0] == "room/floor" || row[0] == "panel" { 0.4 } else { 0.0 };
        let expected_cd_m2 = reflectance * number("illuminance_lx") / std::f64::consts::PI;
        assert!((diffuse_cd_m2 - expected_cd_m2).abs() < 1e-9 * expected_cd_m2.max(1.0), "{row:?}");
        let emitted_cd_m2 = if row[0] == "panel" { 400.0 / std::f64::consts::PI } else { 0.0 };
        assert!((number("emitted_luminance_cd_m2") - emitted_cd_m2).abs() < 1e-9 * emitted_cd_m2.max(1.0), "{row:?}");
        assert!((number("luminance_cd_m2") - diffuse_cd_m2 - emitted_cd_m2).abs() < 1e-9 * emitted_cd_m2.max(1.0));
        types.insert(row[0].clone(), row[column("material_type")].clone());
    }
    let of = |surface: &str| types[surface].as_str();
    assert_eq!([of("room/x_min"), of("room/x_max"), of("room/floor")], ["mirror", "diffuse", "phong"]);
}

#[test]
fn the_summary_has_its_keys_and_tells_the_truth() {
    let home = directory();
    let output = solve("room.json", home.path(), &["--target-error", "20%", "--seed", "3"]);
    assert_eq!(code(&output), 0, "{}", errors(&output));
    let summary = summary(home.path());
    for key in [
        "scene",
        "seed",
        "method",
        "chains",
        "rays",
        "read_s",
        "build_s",
        "compute_s",
        "write_s",
        "wall_s",
        "target_error",
        "estimated_error",
        "target_met",
        "stop_reason",
        "maps",
        "flux_balance",
        "luminaires",
        "warnings",
        "versions",
    ] {
        assert!(summary.get(key).is_some(), "{key} is missing");
    }
    assert_eq!((&summary["seed"], &summary["target_met"]), (&3.into(), &true.into()));
    assert_eq!(summary["stop_reason"], "target_met");
    assert!(summary["estimated_error"].as_f64().expect("a number") <= 0.2);
    let names: Vec<&str> =
        summary["maps"].as_array().expect("maps").iter().map(|map| map["name"].as_str().expect("a name")).collect();
    assert_eq!(names, ["elements", "work plane", "probes"]);
    let lamp = &summary["luminaires"][1];
    let expected_lm = 0.5 * 0.8 * 4.0 * std::f64::consts::PI * 100.0;
    assert!((lamp["luminous_flux_lm"].as_f64().expect("a number") - expected_lm).abs() < 1e-9 * expected_lm);
    assert_eq!((&lamp["dimming"], &lamp["maintenance_factor"]), (&0.5.into(), &0.8.into()));
    let balance = &summary["flux_balance"];
    let lm = |key: &str| balance[key].as_f64().expect("a number");
    let ends_lm = lm("absorbed_lm") + lm("escaped_lm") + lm("back_face_lm") + lm("truncated_lm");
    assert!((lm("emitted_lm") - ends_lm).abs() < 1e-9 * ends_lm);
}

#[test]
fn only_the_maps_asked_for_are_written() {
    let home = directory();
    let receivers_of = |maps: &str, out: &str| {
        let out = home.path().join(out);
        let output = solve("room.json", &out, &["--chains", "500", "--maps", maps, "--quiet"]);
        assert_eq!(code(&output), 0, "{}", errors(&output));
        let (_, rows) = table(&out.join("receivers.csv"));
        let mut names: Vec<String> = rows.into_iter().map(|row| row[0].clone()).collect();
        names.dedup();
        (names, out.join("elements.csv").exists())
    };
    assert_eq!(receivers_of("probes", "a"), (vec!["probes".to_owned()], false));
    assert_eq!(receivers_of("receivers", "b"), (vec!["work plane".to_owned(), "probes".to_owned()], false));
    assert_eq!(receivers_of("work plane,elements", "c"), (vec!["work plane".to_owned()], true));
    assert!(receivers_of("all", "d").1);

    // A later run without receivers removes the table of the earlier run. Files that it does not know are kept.
    let out = home.path().join("d");
    std::fs::write(out.join("notes.txt"), "foreign").expect("written");
    let elements_alone = ["--chains", "500", "--maps", "elements", "--plots", "none", "--quiet"];
    assert_eq!(code(&solve("room.json", &out, &elements_alone)), 0);
    let mut expected =
        ["convergence.csv", "elements.csv", "notes.txt", "report.html", "report.pdf", "scene.glb"].to_vec();
    expected.extend(["scene.vtp", "summary.json", "tables.csv"]);
    assert_eq!(listing(&out), expected);
}

#[test]
fn refusals_end_with_2_and_write_nothing() {
    let home = directory();
    let out = home.path().join("out");
    let scene = scene("room.json");
    let (scene, out_text) = (text(&scene), text(&out));
    let missing = home.path().join("missing.json");
    let broken = home.path().join("broken.json");
    std::fs::write(&broken, "{ \"version\": 1,\n  \"materials\": {").expect("written");
    let cases: &[(&[&str], &str)] = &[
        (&["solve", scene, "--out", out_text, "--target-error", "0"], "1% or 0.01"),
        (&["solve", scene, "--out", out_text, "--target-error", "-1%"], "1% or 0.01"),
        (&["solve", scene, "--out", out_text, "--target-error", "100%"], "1% or 0.01"),
        (&["solve", scene, "--out", out_text, "--target-error", "nan"], "1% or 0.01"),
        (&["solve", scene, "--out", out_text, "--time-limit", "0s"], "60s"),
        (&["solve", scene, "--out", out_text, "--chains", "0"], "1_000_000"),
        (&["solve", scene, "--out", out_text, "--chains", "-5"], "1_000_000"),
        (&["solve", scene, "--out", out_text, "--threads", "0"], "from 1"),
        (&["solve", scene, "--out", out_text, "--seed", "-1"], "from 0"),
        (&["solve", scene, "--out", out_text, "--method", "magic"], "collision"),
        (&["solve", scene, "--out", out_text, "--plots", "pdf"], "svg"),
        (&["solve", scene, "--out", out_text, "--maps", "desk"], "\"work plane\""),
        (&["solve", scene, "--out", out_text, "--unknown"], "--unknown"),
        (&["solve", scene], "--out"),
        (&["solve", text(&missing), "--out", out_text], "missing.json"),
        (&["solve", text(&broken), "--out", out_text], "line 2"),
        (&["conquer"], "conquer"),
        (&[], "Usage"),
    ];
    for (arguments, told) in cases {
        let output = run(arguments);
        assert_eq!(code(&output), 2, "{arguments:?}: {}", errors(&output));
        assert!(errors(&output).contains(told), "{arguments:?}: {}", errors(&output));
        assert!(output.stdout.is_empty(), "{arguments:?}");
        assert!(!out.exists(), "{arguments:?} made the directory");
    }
}

#[test]
fn a_directory_that_cannot_be_written_ends_with_4_before_the_run() {
    let home = directory();
    let file = home.path().join("file");
    std::fs::write(&file, "").expect("written");
    let taken = home.path().join("taken");
    std::fs::create_dir_all(taken.join("tables.csv")).expect("made");
    for out in [file.clone(), file.join("below"), taken.clone()] {
        // If the run began, it would take days.
        let scene = scene("room.json");
        let endless = ["solve", text(&scene), "--out", text(&out), "--target-error", "0.0000001%"];
        let output = run_or_hang(luxmc(&endless), |_| {});
        assert_eq!(code(&output), 4, "{}", errors(&output));
        assert!(errors(&output).contains("remedy"), "{}", errors(&output));
    }
    assert_eq!(listing(&taken), ["tables.csv"]);
}

#[test]
fn a_limit_before_the_target_ends_with_3_and_results() {
    let home = directory();
    let (timed, counted, free) = (home.path().join("a"), home.path().join("b"), home.path().join("c"));
    let output = solve("room.json", &timed, &["--time-limit", "300ms", "--target-error", "0.0001%"]);
    assert_eq!(code(&output), 3, "{}", errors(&output));
    assert_eq!(
        (&summary(&timed)["stop_reason"], &summary(&timed)["target_met"]),
        (&"time_limit".into(), &false.into())
    );
    assert!(errors(&output).contains("target not met"), "{}", errors(&output));
    let output = solve("room.json", &counted, &["--chains", "100", "--target-error", "0.0001%"]);
    assert_eq!(code(&output), 3, "{}", errors(&output));
    assert_eq!(summary(&counted)["stop_reason"], "chains");

    // Without a target there is none to miss.
    let output = solve("room.json", &free, &["--time-limit", "300ms"]);
    assert_eq!(code(&output), 0, "{}", errors(&output));
    assert!(summary(&free)["target_met"].is_null());
}

#[test]
fn a_scene_without_chance_is_exact() {
    let home = directory();
    let output = solve("black.json", home.path(), &["--target-error", "1%"]);
    assert_eq!(code(&output), 0, "{}", errors(&output));
    let (_, rows) = table(&home.path().join("receivers.csv"));
    // E = I cos γ / d² = 100 · 2 / (4 + r²)^(3/2) at r = 0 and 1.
    for (row, expected_lx) in rows.iter().zip([25.0, 200.0 / 5f64.powf(1.5)]) {
        assert!((row[8].parse::<f64>().expect("a number") - expected_lx).abs() < 1e-4, "{} {expected_lx}", row[8]);
        assert_eq!((row[9].as_str(), row[11].as_str(), row[12].as_str()), ("0", "0", "false"));
    }
    let summary = summary(home.path());
    assert!(summary["flux_balance"].is_null() && summary["flux_balance_note"].is_string());
}

/// Several interruptions at once count as one, whatever the signals are. This happens when a process and its group are signalled.
#[cfg(unix)]
#[test]
fn interruptions_end_with_130_and_results() {
    for signals in [&["-INT"][..], &["-TERM", "-TERM", "-INT"]] {
        ends_with_results_by(signals);
    }
}

#[cfg(unix)]
fn ends_with_results_by(signals: &[&str]) {
    let home = directory();
    let scene = scene("room.json");
    let endless = luxmc(&["solve", text(&scene), "--out", text(home.path()), "--target-error", "0.0000001%"]);
    let output = run_or_hang(endless, |id| {
        std::thread::sleep(Duration::from_millis(500));
        signals.iter().for_each(|name| signal(id, name));
    });
    assert_eq!(code(&output), 130, "{}", errors(&output));
    assert_eq!(summary(home.path())["stop_reason"], "interrupted");
    assert!(results(&output).contains("work plane"));
    for name in TABLES {
        assert!(home.path().join(name).exists(), "{name}");
    }
}

#[test]
fn quiet_runs_say_nothing_but_warnings() {
    let home = directory();
    let loud = solve("room.json", &home.path().join("a"), &["--chains", "100"]);
    let quiet = solve("room.json", &home.path().join("b"), &["--chains", "100", "--quiet"]);
    assert!(errors(&loud).contains("results in"));
    assert!(errors(&quiet).lines().all(|line| line.starts_with("warning:")), "{}", errors(&quiet));
    assert_eq!(results(&loud), results(&quiet));
}

#[test]
fn results_are_readable_by_others() {
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        let home = directory();
        assert_eq!(code(&solve("room.json", home.path(), &["--chains", "100", "--quiet"])), 0);
        let mode = |path: &Path| std::fs::metadata(path).expect("written").permissions().mode() & 0o777;
        let plain = home.path().join("plain");
        std::fs::write(&plain, "").expect("written");
        assert_eq!(mode(&home.path().join("tables.csv")), mode(&plain));
    }
}
