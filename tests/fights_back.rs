//! Input that fights back: whatever stands in a file, it is read or refused, quickly and in little memory.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use luxmc::scene::photometry::{parse_eulumdat, parse_ies};
use luxmc::scene::{inspect, mesh_from_obj, receiver_points_from_csv, scene_from_json};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

fn corpus(reader: &str) -> Vec<Vec<u8>> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("fuzz/corpus").join(reader);
    let entries = std::fs::read_dir(&folder).unwrap_or_else(|error| panic!("{}: {error}", folder.display()));
    let mut paths: Vec<PathBuf> = entries.map(|entry| entry.expect("readable").path()).collect();
    paths.sort();
    assert!(paths.len() >= 2, "no corpus in {}", folder.display());
    paths.iter().map(|path| std::fs::read(path).expect("readable")).collect()
}

/// Gives bytes to a reader; its answer does not matter, but that there is one.
fn read_as(reader: &str, bytes: &[u8]) {
    let text = String::from_utf8_lossy(bytes);
    let said = match reader {
        "scene" => scene_from_json(&text, None, Path::new("/nowhere"))
            .map(|scene| inspect(&scene).warnings.len())
            .err()
            .map(|e| e.to_string()),
        "obj" => mesh_from_obj(&text, Path::new("mesh.obj")).err().map(|error| error.to_string()),
        "ies" => parse_ies(bytes, None).err().map(|error| error.to_string()),
        "ldt" => parse_eulumdat(bytes).err().map(|error| error.to_string()),
        "points" => receiver_points_from_csv(&text, Path::new("p.csv")).err().map(|error| error.to_string()),
        other => panic!("no reader {other}"),
    };
    assert!(said.is_none_or(|message| !message.is_empty()));
}

const READERS: [&str; 5] = ["scene", "obj", "ies", "ldt", "points"];
const PATCHES: [&str; 20] = [
    "",
    "-",
    "1e9",
    "1e308",
    "-1e308",
    "1e-320",
    "4294967296",
    "NaN",
    "inf",
    "\u{0}",
    "\u{1a}",
    "é",
    "\"",
    "{",
    "]",
    ",",
    "/",
    "\\\n",
    "\r",
    "f -1 -2 -3\n",
];

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, rng_seed: RngSeed::Fixed(9), failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn any_bytes_are_read_or_refused(bytes in prop::collection::vec(any::<u8>(), 0..600)) {
        READERS.iter().for_each(|reader| read_as(reader, &bytes));
    }

    #[test]
    fn good_files_with_faults_are_read_or_refused(
        which in any::<prop::sample::Index>(), at in any::<prop::sample::Index>(), length in 0usize..9,
        patch in prop::sample::select(PATCHES.to_vec()), again in any::<prop::sample::Index>(), flip in any::<u8>(),
    ) {
        for reader in READERS {
            let files = corpus(reader);
            let mut bytes = files[which.index(files.len())].clone();
            let from = at.index(bytes.len());
            bytes.splice(from..(from + length).min(bytes.len()), patch.bytes());
            if !bytes.is_empty() {
                let place = again.index(bytes.len());
                bytes[place] ^= flip;
            }
            read_as(reader, &bytes);
            bytes.truncate(from);
            read_as(reader, &bytes);
        }
    }
}

/// A scene with these geometries, luminaires and receivers beside a plain room and lamp.
fn scene_text(geometry: &str, luminaires: &str, receivers: &str) -> String {
    format!(
        r#"{{ "version": 1, "materials": {{ "m": {{ "type": "diffuse", "reflectance": 0.5 }} }},
        "geometry": [ {{ "name": "room", "type": "box", "min": [0,0,0], "max": [4,3,2], "facing": "inward", "material": "m" }} {geometry} ],
        "luminaires": [ {{ "name": "lamp", "type": "point", "position": [2,1,1], "intensity_cd": 1 }} {luminaires} ],
        "receivers": [ {receivers} ] }}"#
    )
}

/// Refused within two seconds: nothing of the size that is asked for is made first.
fn refused(text: &str, says: &str) {
    let start = Instant::now();
    let error =
        scene_from_json(text, None, Path::new(".")).err().unwrap_or_else(|| panic!("read, not refused: {says}"));
    assert!(error.to_string().contains(says), "{error}");
    assert!(start.elapsed() < Duration::from_secs(2), "{:?}", start.elapsed());
}

#[test]
fn a_few_bytes_that_ask_for_millions_are_refused_before_they_are_made() {
    let sphere = |name: &str, edge: &str| {
        format!(
            r#", {{ "name": "{name}", "type": "sphere", "center": [1,1,1], "radius": 0.5, "material": "m", "max_element_edge": {edge} }}"#
        )
    };
    refused(&scene_text(&sphere("s", "1e-9"), "", ""), "too many triangles");
    let many: String = (0..1000).map(|number| sphere(&format!("s{number}"), "0.01")).collect();
    let fine: String = (0..4).map(|number| sphere(&format!("s{number}"), "0.0012")).collect();
    assert!(scene_from_json(&scene_text(&many, "", ""), None, Path::new(".")).is_err());
    assert!(scene_from_json(&scene_text(&fine, "", ""), None, Path::new(".")).is_err());

    let panel = |edge: &str| {
        format!(
            r#", {{ "name": "p", "type": "rectangle", "origin": [1,1,1], "u": [1,0,0], "v": [0,1,0], "material": "m", "max_element_edge": {edge} }}"#
        )
    };
    for edge in ["1e-5", "1e-300", "1e-4"] {
        refused(&scene_text(&panel(edge), "", ""), "too many elements");
    }

    let grid = |name: &str, columns: &str, rows: &str| {
        format!(
            r#"{{ "name": "{name}", "type": "grid", "origin": [1,1,1], "u": [1,0,0], "v": [0,1,0], "columns": {columns}, "rows": {rows} }}"#
        )
    };
    refused(&scene_text("", "", &grid("g", "4294967295", "4294967295")), "too many points");
    refused(&scene_text("", "", &grid("g", "1000000000", "1")), "too many points");
    let grids: Vec<String> = (0..5).map(|number| grid(&format!("g{number}"), "1000", "1000")).collect();
    refused(&scene_text("", "", &grids.join(",")), "too many points");
    refused(
        &scene_text("", "", r#"{ "name": "g", "type": "grid", "surface": "room/floor", "spacing": 1e-9 }"#),
        "too many points",
    );

    let looks =
        |name: &str, how: &str| format!(r#"{{ "name": "{name}", "type": "luminance", "position": [2,1,1], {how} }}"#);
    // Each alone is allowed; the second of two is not, and is never made.
    let fan =
        |count: u32| format!(r#""fan": {{ "direction": [1,0,0], "from_deg": 0, "to_deg": 90, "count": {count} }}"#);
    let view = |columns: u32| {
        format!(r#""view": {{ "direction": [1,0,0], "field_deg": [90, 60], "columns": {columns}, "rows": 1000 }}"#)
    };
    refused(&scene_text("", "", &looks("v", &view(2_000_000))), "too many points");
    for (one, other) in [(fan(100_000), fan(3_950_000)), (fan(100_000), view(3_950)), (view(100), view(3_950))] {
        refused(&scene_text("", "", &format!("{}, {}", looks("one", &one), looks("other", &other))), "too many points");
    }

    let array = |name: &str, columns: &str| {
        format!(
            r#", {{ "name": "{name}", "type": "point", "position": [1,1,1], "intensity_cd": 1, "columns": {columns}, "rows": 1, "u": [1,0,0] }}"#
        )
    };
    refused(&scene_text("", &array("a", "1000000000"), ""), "too many luminaires");
    refused(&scene_text("", &format!("{}{}", array("a", "600000"), array("b", "600000")), ""), "too many luminaires");
}

#[test]
fn a_face_with_very_many_corners_is_refused_and_many_parts_are_read_quickly() {
    let corners = 5000;
    let mut text: String = (0..corners).map(|n| format!("v {n} {} 0\n", n % 2)).collect();
    text += "f";
    (1..=corners).for_each(|n| text += &format!(" {n}"));
    let error = mesh_from_obj(&text, Path::new("m.obj")).expect_err("too many corners");
    assert!(error.to_string().contains("at most 1024 corners"), "{error}");

    let start = Instant::now();
    let mut text = "v 0 0 0\nv 1 0 0\nv 0 1 0\n".to_string();
    (0..30_000).for_each(|part| text += &format!("usemtl part {part}\nf 1 2 3\n"));
    assert_eq!(mesh_from_obj(&text, Path::new("m.obj")).expect("valid").parts.len(), 30_000);
    assert!(start.elapsed() < Duration::from_secs(2), "{:?}", start.elapsed());
}

#[cfg(unix)]
#[test]
fn devices_and_folders_are_no_files() {
    for name in ["/dev/zero", "/dev", "/dev/stdin"] {
        let mesh = format!(r#", {{ "name": "d", "type": "mesh", "file": "{name}", "material": "m" }}"#);
        if !Path::new(name).metadata().is_ok_and(|metadata| metadata.is_file()) {
            refused(&scene_text(&mesh, "", ""), "cannot be read");
        }
    }
}

#[test]
fn luminaires_outside_are_told_in_one_warning() {
    let array = r#", { "name": "a", "type": "point", "position": [1,1,9], "intensity_cd": 1, "columns": 500, "rows": 20, "u": [1,0,0], "v": [0,1,0] }"#;
    let scene = scene_from_json(&scene_text("", array, ""), None, Path::new(".")).expect("valid");
    let told = scene.warnings.iter().filter(|warning| warning.contains("bounding box")).count();
    assert_eq!((scene.luminaires.len(), told), (10_001, 1));
}

#[test]
fn many_luminaires_in_fine_spheres_are_looked_at_once() {
    // 20,000 luminaires inside of a sphere of 350,000 triangles: read and inspected in 20 s, where a look over all triangles for
    // each of them took minutes.
    let sphere = r#", { "name": "s", "type": "sphere", "center": [0,0,0], "radius": 1000, "facing": "inward", "material": "m", "max_element_edge": 10 }"#;
    let array = r#", { "name": "a", "type": "point", "position": [1,1,9], "intensity_cd": 1, "columns": 200, "rows": 100, "u": [1,0,0], "v": [0,1,0] }"#;
    let start = Instant::now();
    let scene = scene_from_json(&scene_text(sphere, array, ""), None, Path::new(".")).expect("valid");
    assert!(inspect(&scene).closed);
    assert!(start.elapsed() < Duration::from_secs(20), "{:?}", start.elapsed());
}
