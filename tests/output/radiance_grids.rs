//! Sensor grids of Radiance: the content of `.pts` and `.res`, and that they can be read back.

use std::path::Path;

use luxmc::output::{ResultFile, result_files};
use luxmc::scene::receiver_points_from_csv;
use luxmc::{Scene, Settings, Silent, Solution, scene_from_json, solve};
use serde_json::Value;

/// Two sets whose names give the same file name, and one for luminance, which is no grid of illuminances.
const SCENE: &str = r#"{ "version": 1, "title": "a room", "materials": { "paint": { "type": "diffuse", "reflectance": 0.5 } },
  "geometry": [ { "name": "room", "type": "box", "min": [0, 0, 0], "max": [4, 3, 2.5], "facing": "inward", "material": "paint" } ],
  "luminaires": [ { "name": "lamp", "type": "point", "position": [2, 1.5, 2], "intensity_cd": 100 } ],
  "receivers": [ { "name": "work plane", "type": "grid", "origin": [0.3, 0.3, 0.8], "u": [3.4, 0, 0], "v": [0, 2.4, 0], "columns": 7, "rows": 5 },
                 { "name": "work-plane", "type": "points", "points": [[1, 1, 1, 0, 0.6, 0.8], [2, 1, 0.1, 0, 0, 1]] },
                 { "name": "view", "type": "luminance", "position": [1, 1, 1.2], "directions": [[1, 0, 0]] } ] }"#;

fn solved() -> (Scene, Solution) {
    let scene = scene_from_json(SCENE, None, Path::new(".")).expect("valid");
    let solution = solve(&scene, &Settings { chains: Some(64), ..Settings::default() }, &Silent);
    (scene, solution)
}

fn text<'a>(files: &'a [ResultFile], name: &str) -> &'a str {
    let file = files.iter().find(|file| file.name == name).unwrap_or_else(|| panic!("{name} is not written"));
    std::str::from_utf8(&file.bytes).expect("text")
}

#[test]
fn grids_hold_the_points_and_their_illuminances_and_come_back() {
    let (scene, solution) = solved();
    let files = result_files(&scene, &solution).expect("finite");
    let list: Value = serde_json::from_str(text(&files, "grids_info.json")).expect("JSON");
    let receivers = text(&files, "receivers.csv");
    let rows: Vec<csv::StringRecord> =
        csv::Reader::from_reader(receivers.as_bytes()).records().map(|row| row.expect("a row")).collect();
    let grids = list.as_array().expect("a list");
    assert_eq!(grids.len(), 2, "luminances are no grid");
    let mut row = rows.iter();
    for (grid, set) in grids.iter().zip(&scene.receivers) {
        assert_eq!((grid["name"].as_str(), &grid["identifier"]), (Some(set.name.as_str()), &grid["full_id"]));
        assert_eq!(grid["count"], set.points.len());
        let stem = grid["identifier"].as_str().expect("a name");
        let name = format!("{stem}.pts");
        // The written values are read back to the last bit.
        let back = receiver_points_from_csv(text(&files, &name), Path::new(&name)).expect("the reader takes it");
        assert_eq!(back.len(), set.points.len());
        for (found, wanted) in back.iter().zip(&set.points) {
            assert_eq!(found.position_m, wanted.position_m);
            assert!(found.normal.distance(wanted.normal) < 1e-15);
        }
        let values: Vec<&str> = text(&files, &format!("{stem}.res")).lines().collect();
        let wanted: Vec<&str> = row.by_ref().take(set.points.len()).map(|row| &row[8]).collect();
        assert_eq!(values, wanted, "{stem}: the illuminances of receivers.csv, in its order");
    }
    assert_eq!(
        [0, 1].map(|grid| grids[grid]["identifier"].as_str()),
        [Some("grid-work-plane"), Some("grid-work-plane-2")]
    );
}
