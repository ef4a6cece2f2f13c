//! Builds a case from a scene and a stored long run of it: `luxmc compare SCENE --truth DIR`.

use std::path::Path;

use serde_json::{Value, json};

use super::case::Case;
use super::comparison::ELEMENT_MAP;
use super::error::CaseError;
use super::fields::read_text;

/// Builds a case that compares every map of a stored run. The seeds of its runs follow the stored run's seed.
///
/// # Errors
///
/// A refused scene, a directory without results, or results of another scene.
pub fn case_of_stored_run(scene: &Path, run: &Path) -> Result<Case, CaseError> {
    let path = run.join("summary.json");
    let text = read_text(&path, "the stored run cannot be read: name the directory of a luxmc solve")?;
    let summary: Value = serde_json::from_str(&text).map_err(|error| {
        let remedy = "compute the run again: luxmc solve SCENE --out DIR";
        CaseError::new(&path, "the stored run's summary is not valid JSON", error.to_string(), "a summary", remedy)
    })?;
    let maps = summary["maps"].as_array().map(Vec::as_slice).unwrap_or_default();
    let compare: Vec<Value> = maps
        .iter()
        .filter_map(|map| map["name"].as_str())
        .map(|name| {
            json!({
                "name": name,
                "what": if name == ELEMENT_MAP { "elements" } else { "points" },
                "map": name,
                "truth": { "function": "run", "folder": run },
                "criterion": { "coverage_alpha": 1e-4 }
            })
        })
        .collect();
    let title = summary["title"].as_str().filter(|title| !title.trim().is_empty());
    let case = json!({
        "title": title.unwrap_or("A scene and a long run of it"),
        "physics": "A scene whose exact illuminance is unknown, compared with a long run of the same program.",
        "groups": [],
        "scene_file": scene,
        "runs": [{ "name": "as stored", "chains": 1, "seed": summary["seed"].as_u64().unwrap_or(0) + 1 }],
        "compare": compare
    });
    let name = scene.file_stem().map_or_else(|| "scene".to_owned(), |stem| stem.to_string_lossy().into_owned());
    Case::of_value(name, Path::new(""), &path, case)
}
