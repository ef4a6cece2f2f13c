//! Every bad scene file is refused with the place of the fault, the error, the expected content and a remedy.

use std::path::{Path, PathBuf};

use luxmc::check::{read_scene, scene_from_json};
use luxmc::scene::SceneError;

use crate::refusal_cases::{CASES, Case, GOOD};

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/scenes")
}

fn read(text: &str) -> Result<luxmc::scene::Scene, SceneError> {
    scene_from_json(text, Some(Path::new("bad.json")), &folder())
}

#[test]
fn the_good_file_is_read() {
    if let Err(error) = read(GOOD) {
        panic!("{error}");
    }
}

#[test]
fn every_bad_file_is_refused_at_its_fault() {
    let mut failures = Vec::new();
    for Case { old, new, at, json_path, says } in CASES {
        assert_eq!(GOOD.matches(old).count(), 1, "{old:?} must stand once in the good file");
        let text = GOOD.replace(old, new);
        let Err(error) = read(&text) else {
            failures.push(format!("{new:?} was read"));
            continue;
        };
        let from = GOOD.find(old).expect("it stands there");
        let object_start = text[..from].rfind("\n    {").map_or(0, |newline| newline + 1);
        let fault = text[from..]
            .find(at)
            .map(|offset| from + offset)
            .or_else(|| text[object_start..].find(at).map(|offset| object_start + offset));
        let fault = fault.or_else(|| text.find(at)).unwrap_or_else(|| panic!("{at:?} stands nowhere"));
        let line = text[..fault].matches('\n').count() + 1;
        let column = text[..fault].chars().rev().take_while(|character| *character != '\n').count() + 1;
        let message = error.to_string();
        let place = error.place.clone().unwrap_or_else(|| panic!("no place: {message}"));
        if (place.line, place.column) != (line, column) || place.json_path != *json_path {
            failures.push(format!("{new:?}: expected line {line}, column {column}, {json_path}, got\n{message}"));
        }
        if !message.contains(says) {
            failures.push(format!("{new:?}: {says:?} is not in\n{message}"));
        }
        for (part, text) in [("got", &error.got), ("expected", &error.expected), ("remedy", &error.remedy)] {
            if text.trim().is_empty() {
                failures.push(format!("{new:?}: no {part}"));
            }
        }
        if error.path != Path::new("bad.json") || !message.contains("bad.json") {
            failures.push(format!("{new:?}: the file is not named in\n{message}"));
        }
    }
    assert!(failures.is_empty(), "{}", failures.join("\n\n"));
}

#[test]
fn scenes_without_light_or_surface_are_refused() {
    for (key, says) in [("geometry", "geometry"), ("luminaires", "luminaire"), ("materials", "materials")] {
        let value: serde_json::Value = serde_json::from_str(GOOD).expect("good");
        let mut without = value.clone();
        without.as_object_mut().expect("an object").remove(key);
        let error = read(&without.to_string()).expect_err(key);
        assert!(error.to_string().contains(says) && error.place.is_some(), "{error}");
        if key != "materials" {
            let mut empty = value.clone();
            empty[key] = serde_json::json!([]);
            let error = read(&empty.to_string()).expect_err(key);
            assert!(error.to_string().contains(says), "{error}");
            assert_eq!(error.place.as_ref().expect("a place").json_path, key);
        }
    }
    for text in ["", "  \n", "[]", "7", "null"] {
        let error = read(text).expect_err(text);
        assert!(error.place.is_some(), "{error}");
    }
}

#[test]
fn faults_in_other_files_are_named_by_that_file_and_by_who_named_it() {
    let mesh = |file: &str| GOOD.replace("parts.obj", file);
    let points = |file: &str| GOOD.replace("probes.csv", file);
    for (text, file, place, named_at, says) in [
        (mesh("absent.obj"), "absent.obj", None, "geometry[3].file", "cannot be read"),
        (mesh("bad_corner.obj"), "bad_corner.obj", Some((5, 7)), "geometry[3].file", "vertex that does not exist"),
        (mesh("no_face.obj"), "no_face.obj", Some((1, 1)), "geometry[3].file", "without a face"),
        (mesh("office.json"), "office.json", Some((1, 1)), "geometry[3].file", "without a face"),
        (points("absent.csv"), "absent.csv", None, "receivers[2].file", "cannot be read"),
        (points("bad_row.csv"), "bad_row.csv", Some((3, 5)), "receivers[2].file", "z is not a finite number"),
        (points("bad_header.csv"), "bad_header.csv", Some((1, 1)), "receivers[2].file", "wrong header"),
        (points("parts.obj"), "parts.obj", Some((1, 1)), "receivers[2].file", "wrong header"),
    ] {
        let error = read(&text).expect_err(file);
        let message = error.to_string();
        assert_eq!(error.path, folder().join(file), "{message}");
        assert_eq!(error.place.as_ref().map(|place| (place.line, place.column)), place, "{message}");
        assert!(message.contains(says) && !error.remedy.is_empty(), "{message}");
        let named_by = error.named_by.clone().expect("who named it");
        assert!(named_by.contains(named_at) && named_by.contains("bad.json, line"), "{message}");
    }
}

#[test]
fn a_missing_photometric_file_is_named() {
    let luminaire = r#"{ "name": "lamp", "type": "photometric", "file": "absent.ies", "position": [2,1,2] }"#;
    let old = r#"{ "name": "lamp", "type": "point", "position": [2,1,2], "intensity_cd": 100 }"#;
    let error = read(&GOOD.replace(old, luminaire)).expect_err("a missing file");
    assert_eq!(error.path, folder().join("absent.ies"));
    assert!(error.named_by.as_ref().expect("who named it").contains("luminaires[0].file"), "{error}");
}

#[test]
fn a_grid_on_a_floor_that_is_no_rectangle_is_refused_with_a_way_out() {
    let text =
        GOOD.replace("parts.obj", "l_shape.obj").replace("\"surface\": \"room/floor\"", "\"surface\": \"parts\"");
    let error = read(&text).expect_err("an L");
    assert!(error.to_string().contains("does not fill"), "{error}");
    assert!(error.remedy.contains("several grids"), "{error}");
}

#[test]
fn a_file_that_is_missing_or_no_text_is_refused() {
    let error = read_scene(Path::new("no/such/scene.json")).expect_err("missing");
    assert!(error.place.is_none() && error.to_string().contains("no/such/scene.json"), "{error}");
    let error = read_scene(&folder()).expect_err("a folder");
    assert!(error.to_string().contains("cannot be read"), "{error}");

    let file = tempfile::NamedTempFile::new().expect("a temporary file");
    std::fs::write(file.path(), b"{\n  \"title\": \"\xff\" }").expect("written");
    let error = read_scene(file.path()).expect_err("no UTF-8");
    let place = error.place.as_ref().expect("a place");
    assert_eq!((place.line, place.column), (2, 13), "{error}");
}

#[test]
fn every_truncation_is_refused_with_a_place() {
    for end in (0..GOOD.trim_end().len()).filter(|end| GOOD.is_char_boundary(*end)) {
        let error = read(&GOOD[..end]).expect_err("cut short");
        let place = error.place.as_ref().unwrap_or_else(|| panic!("{error}"));
        assert!(place.line <= GOOD.lines().count() && place.column >= 1);
        assert!(error.what.contains("malformed") || error.what.contains("empty"), "{end}: {error}");
    }
}

#[test]
fn deep_nesting_ends_in_a_refusal() {
    for open in ["[", "{\"a\":"] {
        assert!(read(&open.repeat(100_000)).is_err());
    }
}

#[test]
fn a_message_shows_the_line_with_a_caret_below_the_fault() {
    let error = read(&GOOD.replace("\"reflectance\": 0.5", "\"reflectance\": 1.5")).expect_err("above 1");
    let expected = "\
reflectance is above 1
  in bad.json, line 7, column 50, at materials.grey.reflectance
    |
  7 |     \"grey\":  { \"type\": \"diffuse\", \"reflectance\": 1.5 }
    |                                                  ^^^
  got:      the number 1.5
  expected: a number from 0 to 1
  remedy:   give a number from 0 to 1";
    assert_eq!(error.to_string(), expected);
}
