//! Skies: light through openings by every method, against exact numbers.

use std::f64::consts::PI;
use std::path::Path;

use luxmc::check::scene_from_json;
use luxmc::maps::MapResult;
use luxmc::output::{PartOfRun, RunRecord, summary_file};
use luxmc::scene::{Emission, Openings, Scene};
use luxmc::solver::{MapSelection, Method, Solution};
use serde_json::{Value, json};

use crate::common;

/// Zenith luminance in cd/m².
const LUMINANCE_CD_M2: f64 = 1000.0;

fn read(scene: &Value) -> Scene {
    common::scene_of(&scene.to_string())
}

fn solved(scene: &Value, method: Method, maps: MapSelection, target_error: f64) -> Solution {
    common::to_target_by(&read(scene), method, 5, maps, target_error)
}

fn rectangle(name: &str, origin: [f64; 3], u: [f64; 3], v: [f64; 3], material: &str, two_sided: bool) -> Value {
    json!({ "name": name, "type": "rectangle", "origin": origin, "u": u, "v": v, "material": material,
            "two_sided": two_sided, "max_element_edge": 2.5 })
}

/// Walls of a room of 4 m × 4 m × 3 m with a window of 3 m × 2 m in the wall y = 0 and a rooflight of 1 m × 1 m.
fn walls(two_sided: bool) -> Vec<Value> {
    let wall = |name: &str, origin, u, v| rectangle(name, origin, u, v, "paint", two_sided);
    vec![
        wall("floor", [0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]),
        wall("back", [0.0, 4.0, 0.0], [4.0, 0.0, 0.0], [0.0, 0.0, 3.0]),
        wall("left", [0.0, 0.0, 0.0], [0.0, 4.0, 0.0], [0.0, 0.0, 3.0]),
        wall("right", [4.0, 0.0, 0.0], [0.0, 0.0, 3.0], [0.0, 4.0, 0.0]),
        wall("front 1", [0.0, 0.0, 0.0], [0.0, 0.0, 3.0], [0.5, 0.0, 0.0]),
        wall("front 2", [3.5, 0.0, 0.0], [0.0, 0.0, 3.0], [0.5, 0.0, 0.0]),
        wall("front 3", [0.5, 0.0, 0.0], [0.0, 0.0, 0.5], [3.0, 0.0, 0.0]),
        wall("front 4", [0.5, 0.0, 2.5], [0.0, 0.0, 0.5], [3.0, 0.0, 0.0]),
        wall("ceiling 1", [0.0, 0.0, 3.0], [0.0, 4.0, 0.0], [1.5, 0.0, 0.0]),
        wall("ceiling 2", [2.5, 0.0, 3.0], [0.0, 4.0, 0.0], [1.5, 0.0, 0.0]),
        wall("ceiling 3", [1.5, 0.0, 3.0], [0.0, 1.5, 0.0], [1.0, 0.0, 0.0]),
        wall("ceiling 4", [1.5, 2.5, 3.0], [0.0, 1.5, 0.0], [1.0, 0.0, 0.0]),
    ]
}

fn sky(distribution: &str, more: Value) -> Value {
    let mut sky = json!({ "name": "sky", "type": "sky", "luminance_distribution": distribution,
                          "zenith_luminance_cd_m2": LUMINANCE_CD_M2 });
    sky.as_object_mut().expect("an object").extend(more.as_object().expect("an object").clone());
    sky
}

fn scene(geometry: Vec<Value>, luminaires: Vec<Value>, receivers: Value) -> Value {
    json!({ "version": 1,
        "materials": { "paint": { "type": "diffuse", "reflectance": 0.7 }, "black": { "type": "diffuse", "reflectance": 0 },
                       "mirror": { "type": "mirror", "reflectance": 1 },
                       "pane": { "type": "glass", "refractive_index": 1.52, "internal_transmittance": 1 } },
        "geometry": geometry, "luminaires": luminaires, "receivers": receivers })
}

/// A room in surroundings of one luminance. Its walls emit what they do not reflect, and the sky is above a ground that reflects
/// everything. By Kirchhoff's law every point receives π L, whatever is near it: a mirror, panes, or a wall outside in front of the window.
fn isothermal(two_sided: bool, sky_cd_m2: f64) -> Value {
    let mut geometry = walls(two_sided);
    geometry.push(rectangle("rooflight", [1.5, 1.5, 3.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0], "pane", true));
    if two_sided {
        geometry.push(rectangle("outside", [0.0, -2.0, 0.0], [0.0, 0.0, 2.0], [4.0, 0.0, 0.0], "paint", true));
        geometry.push(rectangle("mirror", [0.01, 1.0, 1.0], [0.0, 2.0, 0.0], [0.0, 0.0, 1.0], "mirror", true));
    }
    let exitance = 0.3 * PI * LUMINANCE_CD_M2;
    let shines = |part: &&Value| part["material"] == "paint";
    let mut luminaires: Vec<Value> = (geometry.iter().filter(shines))
        .map(|part| {
            let side = if two_sided { "both" } else { "front" };
            json!({ "name": part["name"], "type": "area", "surface": part["name"], "side": side, "exitance_lm_m2": exitance })
        })
        .collect();
    luminaires.push(sky("uniform", json!({ "ground_reflectance": 1, "zenith_luminance_cd_m2": sky_cd_m2 })));
    let receivers = json!([
        { "name": "plane", "type": "grid", "origin": [0.5, 0.5, 0.8], "u": [3, 0, 0], "v": [0, 3, 0], "columns": 4, "rows": 4 },
        { "name": "window", "type": "grid", "origin": [1, 0.3, 1], "u": [2, 0, 0], "v": [0, 0, 1], "columns": 2, "rows": 2 }
    ]);
    scene(geometry, luminaires, receivers)
}

/// Largest deviation of a map's entries from a value in their own standard errors, and the mean relative deviation.
fn deviation(map: &MapResult, exact: f64) -> (f64, f64) {
    let entries: Vec<(f64, f64)> =
        map.values.value.iter().zip(&map.values.standard_error).map(|(value, error)| (*value, *error)).collect();
    let worst = entries.iter().map(|(value, error)| (value - exact).abs() / (error + 1e-6 * exact)).fold(0.0, f64::max);
    let mean = entries.iter().map(|(value, _)| value / exact - 1.0).sum::<f64>() / entries.len() as f64;
    (worst, mean)
}

/// Seed 5, stated errors of 1 %. By every method all values at receivers are within 7 standard errors of π L (α some 1e-5 for all with 15
/// degrees of freedom), and the mean of each set is within 1 %. With a sky 10 % too dark, the planted fault, the mean near the window is
/// not.
#[test]
#[ignore = "takes long: .ci/run runs it"]
fn in_a_world_of_one_luminance_every_place_receives_alike() {
    for two_sided in [false, true] {
        for method in [Method::Auto, Method::Gather, Method::Collision, Method::Local] {
            let solution = solved(&isothermal(two_sided, LUMINANCE_CD_M2), method, MapSelection::Receivers, 0.01);
            for map in solution.maps.iter().filter(|map| ["plane", "window"].contains(&map.name.as_str())) {
                let (worst, mean) = deviation(map, PI * LUMINANCE_CD_M2);
                let what = format!("{method:?}, two-sided {two_sided}, {}: {worst:.2} σ, {mean:.5}", map.name);
                assert!(worst < 7.0 && mean.abs() < 0.01, "{what}");
            }
        }
    }
    let faulty = solved(&isothermal(true, 0.9 * LUMINANCE_CD_M2), Method::Auto, MapSelection::Receivers, 0.01);
    let window = faulty.maps.iter().find(|map| map.name == "window").expect("the set");
    assert!(deviation(window, PI * LUMINANCE_CD_M2).1.abs() > 0.01, "the planted fault passed");
}

/// The same on the elements by counted packets. Packets enter through the openings and past them, and none is counted twice. Means by area
/// of the receiving surfaces, without the rooflight and the mirror, are within 1 % of π L. With a sky 10 % too dark, the planted fault,
/// they are not.
#[test]
fn counted_packets_of_a_sky_are_those_that_enter() {
    let mean = |sky_cd_m2: f64, two_sided: bool| {
        let value = isothermal(two_sided, sky_cd_m2);
        let solution = solved(&value, Method::Collision, MapSelection::Elements, 0.02);
        let map = solution.maps.iter().find(|map| map.name == "elements").expect("the elements");
        let scene = read(&value);
        let elements = luxmc::scene::Elements::of(&scene);
        let (mut lm, mut m2) = (0.0, 0.0);
        for (entry, lx) in map.values.value.iter().enumerate() {
            let element = elements.element(entry as u32);
            let name = &scene.surface_of(element.triangle).name;
            if name != "rooflight" && name != "mirror" {
                let area_m2 = elements.area_m2(&scene, element);
                lm += lx * area_m2;
                m2 += area_m2;
            }
        }
        lm / m2 / (PI * LUMINANCE_CD_M2)
    };
    for two_sided in [false, true] {
        let share = mean(LUMINANCE_CD_M2, two_sided);
        assert!((share - 1.0).abs() < 0.01, "two-sided {two_sided}: {share}");
    }
    let faulty = mean(0.9 * LUMINANCE_CD_M2, true);
    assert!((faulty - 1.0).abs() > 0.01, "the planted fault passed: {faulty}");
}

fn openings(scene: &Scene) -> &Openings {
    scene
        .luminaires
        .iter()
        .find_map(|luminaire| match &luminaire.emission {
            Emission::Sky { openings, .. } => Some(&**openings),
            _ => None,
        })
        .expect("a sky")
}

/// A window and a rooflight, both free: two triangles each, which together close the room. A free-standing sheet changes nothing. Walls
/// that also reflect on the outside are lit past the openings, and so is a point outside.
#[test]
fn openings_are_found_and_told_from_open_air() {
    let point = |place: [f64; 3]| json!([{ "name": "p", "type": "grid", "origin": place, "u": [0.1, 0, 0], "v": [0, 0.1, 0], "columns": 2, "rows": 2 }]);
    let mut sheet = walls(false);
    sheet.push(rectangle("table", [1.0, 1.0, 0.7], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], "paint", true));
    // A cupboard on the floor against the back wall, whose sides there face out of the room, also changes nothing.
    sheet.push(json!({ "name": "cupboard", "type": "box", "min": [1, 3.5, 0], "max": [2, 4, 1], "material": "paint" }));
    let inside = [2.0, 2.0, 0.8];
    for (geometry, place, shut) in [
        (walls(false), inside, true),
        (sheet, inside, true),
        (walls(true), inside, false),
        (walls(false), [2.0, -1.0, 0.8], false),
    ] {
        let scene = read(&scene(geometry, vec![sky("overcast", json!({}))], point(place)));
        let found = openings(&scene);
        assert_eq!((found.fronts_m.len(), found.are_all), (4, shut), "{place:?}");
        let area: f64 = found.fronts_m.iter().map(|[a, b, c]| 0.5 * (*b - *a).cross(*c - *a).length()).sum();
        assert!((area - 7.0).abs() < 1e-9, "{area} m²");
        // Fronts face the inside.
        let looks_in =
            |[a, b, c]: &[glam::DVec3; 3]| (*b - *a).cross(*c - *a).dot(glam::DVec3::new(2.0, 2.0, 1.5) - *a) > 0.0;
        assert!(found.fronts_m.iter().all(looks_in));
    }
}

/// At night a sky of zero luminance is dark by every method, with a warning. So is a room behind a window that transmits nothing.
#[test]
fn night_and_a_black_window_are_dark() {
    let grid = json!([{ "name": "p", "type": "grid", "origin": [1, 1, 0.8], "u": [1, 0, 0], "v": [0, 1, 0], "columns": 2, "rows": 2 }]);
    let night = scene(walls(false), vec![sky("overcast", json!({ "zenith_luminance_cd_m2": 0 }))], grid.clone());
    let mut shuttered = walls(false);
    shuttered.push(rectangle("shutter", [0.5, 0.0, 0.5], [0.0, 0.0, 2.0], [3.0, 0.0, 0.0], "black", false));
    shuttered.push(rectangle("lid", [1.5, 1.5, 3.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0], "black", false));
    let black = scene(shuttered, vec![sky("overcast", json!({}))], grid);
    for method in [Method::Auto, Method::Gather, Method::Collision] {
        for dark in [&night, &black] {
            let solution = solved(dark, method, MapSelection::All, 0.01);
            let map = solution.maps.iter().find(|map| map.name == "p").expect("the set");
            assert!(map.values.value.iter().all(|lx| *lx == 0.0), "{method:?}: {:?}", map.values.value);
        }
    }
    assert!(read(&night).warnings.iter().any(|warning| warning.contains("gives no light")));
}

/// The sky lights a horizontal plane outside as its closed form states, and a vertical one too.
#[test]
fn open_planes_receive_the_closed_form() {
    let receivers = json!([
        { "name": "up", "type": "grid", "origin": [1, 1, 1], "u": [1, 0, 0], "v": [0, 1, 0], "columns": 2, "rows": 2 },
        { "name": "upright", "type": "grid", "origin": [1, 1, 1], "u": [1, 0, 0], "v": [0, 0, 1], "columns": 2, "rows": 2 } ]);
    let floor = vec![rectangle("pit", [0.0, 0.0, -5.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], "black", false)];
    let value = scene(floor, vec![sky("overcast", json!({ "ground_reflectance": 0.2 }))], receivers);
    let solution = solved(&value, Method::Auto, MapSelection::Receivers, 0.002);
    let up = 7.0 / 9.0 * PI * LUMINANCE_CD_M2;
    let upright = (PI / 6.0 + 4.0 / 9.0) * LUMINANCE_CD_M2;
    for (name, exact) in [("up", up), ("upright", upright)] {
        let map = solution.maps.iter().find(|map| map.name == name).expect("the set");
        // The pit's floor hides some of the ground. It is black and not visible from above the horizon.
        let mean = map.values.value.iter().sum::<f64>() / map.values.value.len() as f64;
        let with_ground = if name == "upright" { exact + 0.1 * up } else { exact };
        assert!((mean / with_ground - 1.0).abs() < 0.01, "{name}: {mean}, {with_ground}");
        assert!((mean / (1.03 * with_ground) - 1.0).abs() > 0.01, "the planted fault passed");
    }
}

/// Points that face down on a floor outdoors get the sky only by one reflection: ρ E_h times Lambert's factor of the floor, by every method
/// within 1 %. With 3 % more, the planted fault, they do not agree.
#[test]
fn a_sky_that_is_seen_by_one_bounce_alone_brings_its_exact_share() {
    let floor = vec![rectangle("floor", [-5.0, -5.0, 0.0], [10.0, 0.0, 0.0], [0.0, 10.0, 0.0], "paint", false)];
    let receivers = json!([{ "name": "down", "type": "grid", "origin": [-0.01, -0.01, 1], "u": [0, 0.02, 0], "v": [0.02, 0, 0], "columns": 2, "rows": 2 }]);
    let value = scene(floor, vec![sky("overcast", json!({}))], receivers);
    let corners = [[-5.0, -5.0], [5.0, -5.0], [5.0, 5.0], [-5.0, 5.0]].map(|[x, y]| glam::DVec3::new(x, y, 0.0));
    let factor = luxmc::base::polygon::polygon_illuminance_factor(glam::DVec3::Z, glam::DVec3::NEG_Z, &corners).abs();
    let exact = 0.7 * 7.0 / 9.0 * PI * LUMINANCE_CD_M2 * factor;
    for method in [Method::Auto, Method::Gather, Method::Collision, Method::Local] {
        let solution = solved(&value, method, MapSelection::Receivers, 0.004);
        let values = &solution.maps[0].values;
        let mean = values.value.iter().sum::<f64>() / values.value.len() as f64;
        assert!((mean / exact - 1.0).abs() < 0.01, "{method:?}: {mean}, {exact}");
        assert!((mean / (1.03 * exact) - 1.0).abs() > 0.01, "the planted fault passed");
        assert!(values.direct.iter().all(|lx| *lx == 0.0));
    }
}

/// Daylight factors of points without randomness: a window under the uniform sky, whose sky component is Lambert's factor (CIE 171, 5.11).
/// Also the shares of the points above two values.
#[test]
fn daylight_factors_are_those_of_the_window() {
    let mut geometry = walls(false);
    geometry.iter_mut().for_each(|wall| wall["material"] = json!("black"));
    geometry.retain(|wall| !wall["name"].as_str().expect("a name").starts_with("ceiling"));
    geometry.push(rectangle("ceiling", [0.0, 0.0, 3.0], [0.0, 4.0, 0.0], [4.0, 0.0, 0.0], "black", false));
    let grid = json!([{ "name": "floor", "type": "grid", "origin": [2, 0.5, 0], "u": [0.1, 0, 0], "v": [0, 3, 0], "columns": 2, "rows": 4 }]);
    let value = scene(geometry, vec![sky("uniform", json!({ "median_diffuse_illuminance_lx": 2000 }))], grid);
    let solution = solved(&value, Method::Auto, MapSelection::Receivers, 0.01);
    let factors = luxmc::output::daylight_factors(&read(&value), &solution);
    let [set] = factors.as_slice() else { panic!("one set: {factors:?}") };
    assert!((set.outside_lx - PI * LUMINANCE_CD_M2).abs() < 1e-9 && set.targets_percent == [15.0, 5.0]);
    let corners = [[0.5, 0.0, 0.5], [0.5, 0.0, 2.5], [3.5, 0.0, 2.5], [3.5, 0.0, 0.5]].map(glam::DVec3::from_array);
    let factor = |x: f64, y: f64| {
        100.0
            * luxmc::base::polygon::polygon_illuminance_factor(glam::DVec3::new(x, y, 0.0), glam::DVec3::Z, &corners)
                .abs()
    };
    let exact: Vec<f64> = [0.5, 1.5, 2.5, 3.5].into_iter().flat_map(|y| [factor(2.0, y), factor(2.1, y)]).collect();
    let mean = exact.iter().sum::<f64>() / 8.0;
    assert!((set.average_percent.value - mean).abs() < 1e-6, "{set:?}, {exact:?}");
    assert!((set.average_percent.value - 1.01 * mean).abs() > 1e-6, "the planted fault passed");
    // The same in tables.csv and summary.json, with components: here only the sky component.
    let record = RunRecord {
        scene: String::new(),
        read_s: 0.0,
        write_s: 0.0,
        wall_s: 0.0,
        threads: 1,
        peak_memory_bytes: 0,
        position_accuracy_m: 0.0,
        files: Vec::new(),
        part: PartOfRun::Whole,
    };
    let summary: Value = serde_json::from_slice(&summary_file(&read(&value), &solution, &record).bytes).expect("JSON");
    let told = &summary["daylight_factors"][0];
    assert_eq!((told["receiver"].as_str(), told["target_percent"].as_f64()), (Some("floor"), Some(15.0)));
    for (key, expected) in
        [("average_percent", mean), ("sky_component_percent", mean), ("internally_reflected_percent", 0.0)]
    {
        assert!((told[key].as_f64().expect(key) - expected).abs() < 1e-6, "{key}: {told}");
    }
    let files = luxmc::output::result_files(&read(&value), &solution).expect("files");
    let table = files.iter().find(|file| file.name == "tables.csv").expect("tables.csv");
    let mut rows =
        std::str::from_utf8(&table.bytes).expect("text").lines().map(|row| row.split(',').collect::<Vec<_>>());
    let header = rows.next().expect("a header");
    let row = rows.find(|row| row[0] == "floor" && row[1] == "grid").expect("the set");
    let cell = |name: &str| row[header.iter().position(|column| *column == name).expect(name)].parse::<f64>();
    assert!((cell("daylight_factor_percent").expect("a number") - mean).abs() < 1e-6, "{row:?}");
    assert!((cell("sky_component_percent").expect("a number") - mean).abs() < 1e-6, "{row:?}");
    assert_eq!(cell("externally_reflected_percent").expect("a number"), 0.0);
    let above = |limit: f64| exact.iter().filter(|factor| **factor > limit).count() as f64 / 8.0;
    for (share, limit) in set.shares_above.iter().zip([15.0, 5.0]) {
        assert!((share.value - above(limit)).abs() < 1e-9, "above {limit} %: {share:?}, {exact:?}");
    }
}

/// The sun of a clear sky in the zenith and on the horizon. An open plane receives the given illuminance of the sky within 1 %, by light
/// samples and by counted packets (on the pit's floor, which is open too). With 3 % more, the planted fault, it does not agree.
#[test]
fn clear_skies_hold_with_the_sun_in_the_zenith_and_on_the_horizon() {
    const GIVEN_LX: f64 = 20_000.0;
    for (kind, elevation_deg) in [("CIE 12", 90), ("CIE 12", 0), ("CIE 15", 90), ("CIE 13", 5)] {
        let mut clear = sky(kind, json!({ "sun_elevation_deg": elevation_deg, "horizontal_illuminance_lx": GIVEN_LX }));
        clear.as_object_mut().expect("an object").remove("zenith_luminance_cd_m2");
        let receivers = json!([{ "name": "up", "type": "grid", "origin": [1, 1, 1], "u": [1, 0, 0], "v": [0, 1, 0], "columns": 2, "rows": 2 }]);
        let floor = vec![rectangle("pit", [0.0, 0.0, 0.0], [3.0, 0.0, 0.0], [0.0, 3.0, 0.0], "paint", false)];
        let solution = solved(&scene(floor, vec![clear], receivers), Method::Collision, MapSelection::All, 0.005);
        for map in &solution.maps {
            let mean = map.values.value.iter().sum::<f64>() / map.values.value.len() as f64;
            assert!((mean / GIVEN_LX - 1.0).abs() < 0.01, "{kind}, {elevation_deg}°, {}: {mean}", map.name);
            assert!((1.03 * mean / GIVEN_LX - 1.0).abs() > 0.01, "the planted fault passed");
        }
    }
}

/// Each refusal states what is to be done: two skies, glare ratings under a sky, a sun where there is none or below the horizon.
#[test]
fn what_a_sky_cannot_be_is_refused() {
    let refusal = |luminaires: Vec<Value>, receivers: Value| {
        let value = scene(walls(false), luminaires, receivers).to_string();
        scene_from_json(&value, None, Path::new(".")).expect_err("a refusal").to_string()
    };
    let mut second = sky("uniform", json!({}));
    second["name"] = json!("another");
    let two = refusal(vec![sky("overcast", json!({})), second], json!([]));
    assert!(two.contains("more than one sky"), "{two}");
    let observer = json!([{ "name": "eye", "type": "ugr", "position": [2, 2, 1.2], "view_direction": [0, -1, 0] }]);
    let rated = refusal(vec![sky("overcast", json!({}))], observer);
    assert!(rated.contains("for electric light"), "{rated}");
    let sunny = refusal(vec![sky("overcast", json!({ "sun_elevation_deg": 30 }))], json!([]));
    assert!(sunny.contains("does not depend on the sun"), "{sunny}");
    let night = refusal(vec![sky("CIE 12", json!({ "sun_elevation_deg": -5 }))], json!([]));
    assert!(night.contains("above the horizon"), "{night}");
}
