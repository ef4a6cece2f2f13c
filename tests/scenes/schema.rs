//! The schema and the reader, which both follow the tables of keys: what the reader accepts, the schema accepts.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use luxmc::check::scene_from_json;
use luxmc::scene::scene_schema;
use luxmc::validation::proving_ground::rooms::KINDS;
use serde_json::{Value, json};

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/scenes")
}

/// Pointers to all parts of a schema that a value meets. The error names the first part that it does not meet.
fn met(schema: &Value, at: &str, value: &Value) -> Result<Vec<String>, String> {
    part_met(schema, schema.pointer(at).ok_or(at)?, at, value)
}

/// As [`met`], for a part of the schema and the pointer to it.
fn part_met(schema: &Value, part: &Value, at: &str, value: &Value) -> Result<Vec<String>, String> {
    let refused = |key: &str| Err(format!("{at}/{key}"));
    let mut pointers = vec![at.to_owned()];
    for (key, limit) in part.as_object().ok_or(at)? {
        let number = |meets: fn(f64, f64) -> bool| {
            value.as_f64().zip(limit.as_f64()).is_none_or(|(value, limit)| meets(value, limit))
        };
        let length = |meets: fn(usize, usize) -> bool| {
            value.as_array().zip(limit.as_u64()).is_none_or(|(items, limit)| meets(items.len(), limit as usize))
        };
        let part_met = |key: &str, part: &Value, value: &Value| part_met(schema, part, &format!("{at}/{key}"), value);
        // Of the kinds of an object, the one that it names decides.
        let is_named = |choice: &Value| {
            choice
                .pointer("/properties/type/const")
                .is_none_or(|kind| value.get("type").is_some_and(|name| name == kind))
        };
        let choices = limit.as_array().into_iter().flatten().enumerate().filter(|(_, choice)| is_named(choice));
        let mut met_choices =
            choices.filter_map(|(number, choice)| part_met(&format!("{key}/{number}"), choice, value).ok());
        let is_met = match key.as_str() {
            "type" => match limit.as_str() {
                Some("object") => value.is_object(),
                Some("array") => value.is_array(),
                Some("string") => value.is_string(),
                Some("boolean") => value.is_boolean(),
                Some("integer") => value.as_f64().is_some_and(|number| number.fract() == 0.0),
                _ => value.is_number(),
            },
            "const" => value == limit,
            "enum" => limit.as_array().is_some_and(|names| names.contains(value)),
            "minimum" => number(|value, limit| value >= limit),
            "exclusiveMinimum" => number(|value, limit| value > limit),
            "maximum" => number(|value, limit| value <= limit),
            "minItems" => length(|items, limit| items >= limit),
            "maxItems" => length(|items, limit| items <= limit),
            "required" => limit.as_array().into_iter().flatten().all(|key| value.get(key.as_str().unwrap()).is_some()),
            "oneOf" | "anyOf" => {
                let first = met_choices.next();
                let is_met = first.is_some() && (key == "anyOf" || met_choices.next().is_none());
                pointers.extend(first.unwrap_or_default());
                is_met
            }
            "$ref" => {
                pointers.extend(met(schema, limit.as_str().ok_or(at)?.trim_start_matches('#'), value)?);
                true
            }
            "items" | "prefixItems" => {
                for (place, item) in value.as_array().into_iter().flatten().enumerate() {
                    pointers.extend(match limit.get(place) {
                        Some(limit) => part_met(&format!("{key}/{place}"), limit, item)?,
                        None => part_met(key, limit, item)?,
                    });
                }
                true
            }
            "properties" | "additionalProperties" => {
                for (name, item) in value.as_object().into_iter().flatten() {
                    match (key.as_str(), part["properties"].get(name)) {
                        ("properties", Some(part)) => {
                            pointers.extend(part_met(&format!("properties/{name}"), part, item)?);
                        }
                        ("additionalProperties", None) if limit == false => return refused(name),
                        ("additionalProperties", None) => pointers.extend(part_met(key, limit, item)?),
                        _ => {}
                    }
                }
                true
            }
            "$schema" | "$defs" | "title" | "description" | "format" => true,
            _ => return Err(format!("{at}/{key} is not known here")),
        };
        if !is_met {
            return refused(key);
        }
    }
    Ok(pointers)
}

/// Pointers to a value and to all within it. Of a list of numbers, one counts.
fn places(value: &Value, at: &str) -> Vec<String> {
    let parts: Vec<(String, &Value)> = match value {
        Value::Object(parts) => parts.iter().map(|(key, part)| (key.clone(), part)).collect(),
        Value::Array(parts) if parts.first().is_some_and(Value::is_number) => vec![("0".to_owned(), &parts[0])],
        Value::Array(parts) => parts.iter().enumerate().map(|(n, part)| (n.to_string(), part)).collect(),
        _ => Vec::new(),
    };
    let below = parts.into_iter().flat_map(|(name, part)| places(part, &format!("{at}/{name}")));
    below.chain([at.to_owned()]).collect()
}

/// Scenes that together have every key. Balls take longest to read and are in one scene alone.
fn scenes_of_all_keys() -> Vec<Value> {
    let all: Value = serde_json::from_str(include_str!("../data/scenes/every_key.json")).expect("JSON");
    let (balls, others): (Vec<Value>, Vec<Value>) = (all["geometry"].as_array().expect("geometry").iter().cloned())
        .partition(|geometry| geometry["type"].as_str().is_some_and(|kind| kind.starts_with("sph")));
    let room = vec![others[0].clone()];
    let with = |geometry: &[Value], luminaires: Value| {
        let mut scene = all.clone();
        scene["geometry"] = json!(geometry);
        scene["luminaires"] = luminaires;
        scene["receivers"] = json!([]);
        scene
    };
    let mut indoors = all.clone();
    indoors["geometry"] = json!(others);
    let maintained = json!([
        { "name": "sky", "type": "sky", "luminance_distribution": "CIE 12", "sun_elevation_deg": 30, "sun_azimuth_deg": 170,
          "horizontal_illuminance_lx": 10000, "ground_reflectance": 0.2, "median_diffuse_illuminance_lx": 15000,
          "dimming": 1, "maintenance_factor": 0.9, "power_w": 0 },
        { "name": "sun", "type": "sun", "latitude_deg": 52, "longitude_deg": 13, "date_time": "2026-06-21T12:00:00Z",
          "normal_illuminance_lx": 80000, "dimming": 1, "maintenance_factor": 0.9, "power_w": 0 }
    ]);
    let all_weather = json!([
        { "name": "sky", "type": "sky", "luminance_distribution": "Perez", "latitude_deg": 52, "longitude_deg": 13,
          "date_time": "2026-06-21T12:00:00Z", "direct_normal_illuminance_lx": 60000, "diffuse_horizontal_illuminance_lx": 18000 },
        { "name": "sun", "type": "sun", "sun_elevation_deg": 60, "sun_azimuth_deg": 180, "horizontal_illuminance_lx": 50000 }
    ]);
    let overcast = json!([
        { "name": "sky", "type": "sky", "luminance_distribution": "overcast", "zenith_luminance_cd_m2": 5000 }
    ]);
    let lamp = json!([{ "name": "bulb", "type": "point", "position": [5, 3, 2.5], "luminous_flux_lm": 800 }]);
    let daylit = [maintained, all_weather, overcast].map(|luminaires| with(&room, luminaires));
    [vec![indoors, with(&[room.clone(), balls].concat(), lamp)], daylit.to_vec()].concat()
}

/// Other values in place of one: of another type, out of range, a name that is none, with a key too many or too few, longer and shorter.
fn others(value: &Value) -> Vec<Value> {
    match value {
        Value::Number(_) => vec![json!(-1), json!(0), json!(0.25), json!(1e5), json!("1")],
        Value::String(_) => vec![json!("no such name"), json!(1)],
        Value::Array(parts) => {
            let longer = parts.iter().chain(parts.last()).cloned().collect();
            vec![json!(1), json!([]), longer, parts.iter().skip(1).cloned().collect()]
        }
        Value::Object(parts) => {
            let without = |key: &String| parts.clone().into_iter().filter(|(other, _)| other != key).collect();
            let with_one_more = parts.clone().into_iter().chain([("colour".to_owned(), json!(1))]).collect();
            parts.keys().map(without).chain([json!(1), with_one_more]).collect()
        }
        _ => vec![json!(1)],
    }
}

#[test]
fn the_schema_accepts_all_scenes() {
    let schema = scene_schema();
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes");
    let samples = std::fs::read_dir(folder).expect("a folder").map(|entry| entry.expect("an entry").path());
    let mut texts: Vec<String> = samples
        .filter(|path| path.extension().is_some_and(|extension| extension == "json"))
        .map(|path| std::fs::read_to_string(path).expect("a text"))
        .collect();
    assert!(texts.len() > 10);
    texts.extend(KINDS.iter().map(|kind| kind.room(0).scene));
    for text in texts {
        let scene: Value = serde_json::from_str(&text).expect("JSON");
        if let Err(fault) = met(&schema, "", &scene) {
            panic!("{fault}: {text}");
        }
    }
}

#[test]
fn what_the_schema_refuses_the_reader_refuses() {
    let schema = scene_schema();
    let reads = |scene: &Value| scene_from_json(&scene.to_string(), Some(Path::new("scene.json")), &folder());
    let is_key = |place: &String| place.rsplit('/').nth(1) == Some("properties");
    let mut unmet: BTreeSet<String> = places(&schema, "").into_iter().filter(is_key).collect();
    for scene in scenes_of_all_keys() {
        if let Err(error) = reads(&scene) {
            panic!("{error}");
        }
        let pointers = met(&schema, "", &scene).unwrap_or_else(|fault| panic!("{fault}"));
        unmet.retain(|key| !pointers.contains(key));

        let mut refused = 0;
        for place in places(&scene, "") {
            for other in others(scene.pointer(&place).expect("a place")) {
                let mut faulty = scene.clone();
                *faulty.pointer_mut(&place).expect("a place") = other;
                let Err(fault) = met(&schema, "", &faulty) else { continue };
                refused += 1;
                assert!(reads(&faulty).is_err(), "{fault} is read: {faulty}");
            }
        }
        assert!(refused > 150, "{refused} faults");

        // The planted fault: a schema that lacks a key of the scene.
        let mut without = schema.clone();
        let materials = without["$defs"]["Material"]["oneOf"].as_array_mut().expect("kinds");
        materials[0]["properties"].as_object_mut().expect("keys").remove("reflectance");
        assert!(met(&without, "", &scene).is_err());
    }
    assert!(unmet.is_empty(), "no scene here has {unmet:?}");
}
