//! The sun: direct light calculated by hand, sharp and soft shadows, and reflected light, by every method.

use std::f64::consts::PI;
use std::path::Path;

use glam::DVec3;
use luxmc::base::polygon::polygon_illuminance_factor;
use luxmc::check::scene_from_json;
use luxmc::maps::MapResult;
use luxmc::scene::{Elements, Scene};
use luxmc::solver::{MapSelection, Method, Solution};
use serde_json::{Value, json};

use crate::common;

/// Illuminance of a plane perpendicular to the rays in lx.
const NORMAL_LX: f64 = 80_000.0;
/// Half the angle of the disk in radians.
const HALF_ANGLE: f64 = 0.265 * PI / 180.0;

fn read(scene: &Value) -> Scene {
    common::scene_of(&scene.to_string())
}

fn solved(scene: &Value, method: Method, maps: MapSelection, target_error: f64) -> Solution {
    common::to_target_by(&read(scene), method, 11, maps, target_error)
}

fn map<'a>(solution: &'a Solution, name: &str) -> &'a MapResult {
    solution.maps.iter().find(|map| map.name == name).expect(name)
}

fn mean_lx(solution: &Solution, name: &str) -> f64 {
    let values = &map(solution, name).values.value;
    values.iter().sum::<f64>() / values.len() as f64
}

fn sun(elevation_deg: f64, azimuth_deg: f64) -> Value {
    json!({ "name": "sun", "type": "sun", "sun_elevation_deg": elevation_deg, "sun_azimuth_deg": azimuth_deg,
            "normal_illuminance_lx": NORMAL_LX })
}

fn rectangle(name: &str, origin: [f64; 3], u: [f64; 3], v: [f64; 3], material: &str) -> Value {
    json!({ "name": name, "type": "rectangle", "origin": origin, "u": u, "v": v, "material": material, "max_element_edge": 2.5 })
}

/// A room of 4 m × 4 m × 3 m with a free rooflight of 1 m × 1 m in the middle of its ceiling.
fn room(floor: &str, rest: &str) -> Vec<Value> {
    vec![
        rectangle("floor", [0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0], floor),
        rectangle("back", [0.0, 4.0, 0.0], [4.0, 0.0, 0.0], [0.0, 0.0, 3.0], rest),
        rectangle("front", [0.0, 0.0, 0.0], [0.0, 0.0, 3.0], [4.0, 0.0, 0.0], rest),
        rectangle("left", [0.0, 0.0, 0.0], [0.0, 4.0, 0.0], [0.0, 0.0, 3.0], rest),
        rectangle("right", [4.0, 0.0, 0.0], [0.0, 0.0, 3.0], [0.0, 4.0, 0.0], rest),
        rectangle("ceiling 1", [0.0, 0.0, 3.0], [0.0, 4.0, 0.0], [1.5, 0.0, 0.0], rest),
        rectangle("ceiling 2", [2.5, 0.0, 3.0], [0.0, 4.0, 0.0], [1.5, 0.0, 0.0], rest),
        rectangle("ceiling 3", [1.5, 0.0, 3.0], [0.0, 1.5, 0.0], [1.0, 0.0, 0.0], rest),
        rectangle("ceiling 4", [1.5, 2.5, 3.0], [0.0, 1.5, 0.0], [1.0, 0.0, 0.0], rest),
    ]
}

fn scene(geometry: Vec<Value>, luminaires: Vec<Value>, receivers: Value) -> Value {
    json!({ "version": 1,
        "materials": { "paint": { "type": "diffuse", "reflectance": 0.5 }, "black": { "type": "diffuse", "reflectance": 0 },
                       "mirror": { "type": "mirror", "reflectance": 0.8 },
                       "pane": { "type": "glass", "refractive_index": 1.5, "internal_transmittance": 1 } },
        "geometry": geometry, "luminaires": luminaires, "receivers": receivers })
}

fn at(name: &str, place: [f64; 3], u: [f64; 3], v: [f64; 3]) -> Value {
    json!({ "name": name, "type": "grid", "origin": place, "u": u, "v": v, "columns": 2, "rows": 2 })
}

/// Flux in lm that the elements of a surface receive.
fn surface_lm(value: &Value, solution: &Solution, name: &str) -> f64 {
    let scene = read(value);
    let elements = Elements::of(&scene);
    let entries = map(solution, "elements").values.value.iter().enumerate();
    let of_elements = entries.map(|(entry, lx)| (elements.element(entry as u32), lx));
    let own = of_elements.filter(|(element, _)| scene.surface_of(element.triangle).name == name);
    own.map(|(element, lx)| lx * elements.area_m2(&scene, element)).sum()
}

/// An open plane receives light by the cosine law, horizontal and vertical, at every height of the sun. With the sun on the horizon a
/// vertical plane gets half of the disk. At night everything is dark. By light samples, and on the pit's floor by counted packets.
#[test]
fn open_planes_receive_by_the_cosine_law() {
    let floor = || vec![rectangle("pit", [0.0, 0.0, 0.0], [3.0, 0.0, 0.0], [0.0, 3.0, 0.0], "black")];
    // Vertical ones face −y, where the sun stands.
    let grids = json!([
        at("flat", [1.0, 1.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]),
        at("upright", [1.0, 1.0, 1.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0])
    ]);
    for elevation_deg in [90.0, 89.0, 40.0, 3.0, 0.0, -0.3, -50.0f64] {
        let solution = solved(
            &scene(floor(), vec![sun(elevation_deg, 180.0)], grids.clone()),
            Method::Collision,
            MapSelection::All,
            0.01,
        );
        let (sine, cosine) = elevation_deg.to_radians().sin_cos();
        let is_up = elevation_deg > 1.0;
        let flat = if is_up {
            NORMAL_LX * sine
        } else if elevation_deg == 0.0 {
            NORMAL_LX * 2.0 * HALF_ANGLE / (3.0 * PI)
        } else {
            0.0
        };
        let upright = if elevation_deg == 90.0 {
            NORMAL_LX * 2.0 * HALF_ANGLE / (3.0 * PI)
        } else if is_up {
            NORMAL_LX * cosine
        } else if elevation_deg == 0.0 {
            0.5 * NORMAL_LX
        } else {
            0.0
        };
        for (name, exact) in [("flat", flat), ("upright", upright)] {
            let lx = mean_lx(&solution, name);
            assert!((lx - exact).abs() <= 0.02 * exact, "{elevation_deg}°, {name}: {lx}, {exact}");
            assert!(exact == 0.0 || (1.05 * lx - exact).abs() > 0.02 * exact, "the planted fault passed");
        }
        let pit = mean_lx(&solution, "elements");
        assert!((pit - flat).abs() <= 0.03 * flat, "{elevation_deg}°: {pit}, {flat}");
    }
}

/// Through a free rooflight 3 m above a floor: E sin γ in the light and nothing in the shade. In between it is the visible part of the
/// disk, by the segment of a circle. In the planted fault the disk is a tenth wider. Panes transmit by Fresnel's formulas.
#[test]
fn a_rooflight_throws_a_spot_with_soft_edges() {
    let radius_m = 3.0 * HALF_ANGLE.tan();
    // Part of a disk on one side of a line at h radii from its centre.
    let part = |h: f64| 1.0 - (h.acos() - h * (1.0 - h * h).sqrt()) / PI;
    let point = |name: &str, x: f64| json!({ "name": name, "type": "points", "points": [[x, 2.0, 0.0, 0, 0, 1]] });
    let receivers = json!([
        point("light", 2.0),
        point("shade", 1.4),
        point("edge", 1.5),
        point("half in", 1.5 + 0.5 * radius_m),
        point("half out", 1.5 - 0.5 * radius_m)
    ]);
    for method in [Method::Auto, Method::Gather, Method::Local] {
        let solution = solved(
            &scene(room("black", "black"), vec![sun(90.0, 0.0)], receivers.clone()),
            method,
            MapSelection::Receivers,
            0.002,
        );
        for (name, share) in
            [("light", 1.0), ("shade", 0.0), ("edge", 0.5), ("half in", part(0.5)), ("half out", 1.0 - part(0.5))]
        {
            let lx = mean_lx(&solution, name);
            assert!((lx / NORMAL_LX - share).abs() < 0.01, "{method:?}, {name}: {lx}");
        }
        let wider = part(0.5 / 1.1);
        assert!((mean_lx(&solution, "half in") / NORMAL_LX - wider).abs() > 0.01, "the planted fault passed");
    }
    // 60° high: the centre of the rooflight's spot lies along the ray.
    let mut glazed = room("black", "black");
    glazed.push(rectangle("rooflight", [1.5, 1.5, 3.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0], "pane"));
    let height_m = 1.0;
    let shifted = [2.0, 2.0 + (3.0 - height_m) * 30f64.to_radians().tan(), height_m];
    let grid =
        json!([{ "name": "light", "type": "points", "points": [[shifted[0], shifted[1], shifted[2], 0, 0, 1]] }]);
    let solution = solved(&scene(glazed, vec![sun(60.0, 180.0)], grid), Method::Auto, MapSelection::Receivers, 0.002);
    let (cos_in, n) = (60f64.to_radians().sin(), 1.5f64);
    let cos_out = (1.0 - (1.0 - cos_in * cos_in) / (n * n)).sqrt();
    let passed = |amplitude: f64| {
        let r = amplitude * amplitude;
        (1.0 - r) / (1.0 + r)
    };
    let through = 0.5
        * (passed((cos_in - n * cos_out) / (cos_in + n * cos_out))
            + passed((n * cos_in - cos_out) / (n * cos_in + cos_out)));
    let exact = through * NORMAL_LX * cos_in;
    let lx = mean_lx(&solution, "light");
    assert!((lx / exact - 1.0).abs() < 0.005, "{lx}, {exact}");
}

/// The spot on a reflecting floor lights a black room like a luminous square of the same exitance, by Lambert's formula for polygons; by
/// every method. With 12 % more, the planted fault, it does not. The counted floor receives the light that comes through the opening.
#[test]
fn what_the_spot_reflects_is_that_of_a_luminous_square() {
    let place = [2.0, 1.0, 2.9];
    let receivers = json!([{ "name": "down", "type": "points", "points": [[place[0], place[1], place[2], 0, 0, -1]] }]);
    let value = scene(room("paint", "black"), vec![sun(90.0, 0.0)], receivers);
    let corners = [[1.5, 1.5], [2.5, 1.5], [2.5, 2.5], [1.5, 2.5]].map(|[x, y]| DVec3::new(x, y, 0.0));
    let exact = 0.5 * NORMAL_LX * polygon_illuminance_factor(DVec3::from_array(place), -DVec3::Z, &corners).abs();
    for method in [Method::Auto, Method::Gather, Method::Collision, Method::Local] {
        let solution = solved(&value, method, MapSelection::All, 0.02);
        let lx = mean_lx(&solution, "down");
        assert!((lx / exact - 1.0).abs() < 0.05, "{method:?}: {lx}, {exact}");
        assert!((1.12 * lx / exact - 1.0).abs() > 0.05, "the planted fault passed");
        let floor_lm = surface_lm(&value, &solution, "floor");
        assert!((floor_lm / NORMAL_LX - 1.0).abs() < 0.05, "{method:?}: {floor_lm} lm");
    }
}

/// In a reflecting room, the sun's spot and a panel with the spot's exitance light all other points equally within 5 %. With 12 % more, the
/// planted fault, they do not. Sky and sun together give the sum of the sky alone and the sun alone.
#[test]
#[ignore = "takes long: .ci/run runs it"]
fn interreflections_are_those_of_a_panel_in_place_of_the_spot() {
    let receivers = json!([
        at("ceiling", [0.5, 0.5, 2.9], [0.0, 0.5, 0.0], [0.5, 0.0, 0.0]),
        at("floor", [0.3, 0.3, 0.1], [0.8, 0.0, 0.0], [0.0, 0.8, 0.0]),
        at("wall", [0.1, 1.0, 1.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0])
    ]);
    let lit = |geometry: Vec<Value>, luminaires: Vec<Value>, method: Method| {
        solved(&scene(geometry, luminaires, receivers.clone()), method, MapSelection::Receivers, 0.02)
    };
    let mut with_panel = room("paint", "paint");
    with_panel.push(rectangle("panel", [1.5, 1.5, 0.001], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], "paint"));
    let panel = json!({ "name": "panel", "type": "area", "surface": "panel", "exitance_lm_m2": 0.5 * NORMAL_LX });
    let expected = lit(with_panel, vec![panel], Method::Auto);
    let names = ["ceiling", "floor", "wall"];
    for method in [Method::Auto, Method::Gather, Method::Collision, Method::Local] {
        let solution = lit(room("paint", "paint"), vec![sun(90.0, 0.0)], method);
        for name in names {
            let (lx, exact) = (mean_lx(&solution, name), mean_lx(&expected, name));
            assert!((lx / exact - 1.0).abs() < 0.05, "{method:?}, {name}: {lx}, {exact}");
            assert!((1.12 * lx / exact - 1.0).abs() > 0.05, "the planted fault passed");
        }
    }
    let sky = json!({ "name": "sky", "type": "sky", "luminance_distribution": "overcast", "horizontal_illuminance_lx": 40_000 });
    let [sky_alone, sun_alone, both] = [vec![sky.clone()], vec![sun(55.0, 160.0)], vec![sky, sun(55.0, 160.0)]]
        .map(|luminaires| lit(room("paint", "paint"), luminaires, Method::Auto));
    for name in names {
        let sum = mean_lx(&sky_alone, name) + mean_lx(&sun_alone, name);
        assert!((mean_lx(&both, name) / sum - 1.0).abs() < 0.05, "{name}: {}, {sum}", mean_lx(&both, name));
    }
}

/// The image of the sun in a mirror on the ground lights points that face down, by the light samples of walks, which never meet the sun. It
/// lights a sheet by counted packets. A mirror that reflects a twentieth more, the planted fault, is detected.
#[test]
fn the_sun_is_found_in_mirrors() {
    let geometry = vec![
        rectangle("mirror", [-5.0, -5.0, 0.0], [10.0, 0.0, 0.0], [0.0, 10.0, 0.0], "mirror"),
        rectangle("sheet", [1.0, 0.0, 2.0], [0.0, 2.0, 0.0], [2.0, 0.0, 0.0], "black"),
    ];
    let receivers = json!([at("down", [0.5, 0.5, 1.0], [0.0, 0.1, 0.0], [0.1, 0.0, 0.0])]);
    let value = scene(geometry, vec![sun(40.0, 180.0)], receivers);
    let solution = solved(&value, Method::Collision, MapSelection::All, 0.01);
    let exact = 0.8 * NORMAL_LX * 40f64.to_radians().sin();
    let sheet = surface_lm(&value, &solution, "sheet") / 4.0;
    for lx in [mean_lx(&solution, "down"), sheet] {
        assert!((lx / exact - 1.0).abs() < 0.02, "{lx}, {exact}");
        assert!((lx / (1.05 * exact) - 1.0).abs() > 0.02, "the planted fault passed");
    }
}

/// Each refusal states what is to be done: two suns, a position given twice or by halves, times without a zone, glare, a sun below the
/// horizon given by its horizontal illuminance. At night there is a warning.
#[test]
fn what_a_sun_cannot_be_is_refused() {
    let refusal = |luminaires: Vec<Value>, receivers: Value| {
        scene_from_json(&scene(room("paint", "paint"), luminaires, receivers).to_string(), None, Path::new("."))
            .expect_err("a refusal")
            .to_string()
    };
    let with = |more: Value| {
        let mut sun = json!({ "name": "sun", "type": "sun", "normal_illuminance_lx": NORMAL_LX });
        sun.as_object_mut().expect("an object").extend(more.as_object().expect("an object").clone());
        sun
    };
    let mut second = sun(30.0, 100.0);
    second["name"] = json!("another");
    assert!(refusal(vec![sun(30.0, 180.0), second], json!([])).contains("more than one sun"));
    let place = json!({ "latitude_deg": 52.5, "longitude_deg": 13.4, "date_time": "2026-06-21T12:00:00+02:00" });
    let mut both = place.clone();
    both["sun_elevation_deg"] = json!(20);
    assert!(refusal(vec![with(both)], json!([])).contains("given twice"));
    let mut timeless = place.clone();
    timeless["date_time"] = json!("2026-06-21T12:00:00");
    assert!(refusal(vec![with(timeless)], json!([])).contains("cannot be read"));
    let mut placeless = place.clone();
    placeless.as_object_mut().expect("an object").remove("latitude_deg");
    assert!(refusal(vec![with(placeless)], json!([])).contains("latitude_deg"));
    let observer = json!([{ "name": "eye", "type": "ugr", "position": [2, 2, 1.2], "view_direction": [0, -1, 0] }]);
    assert!(refusal(vec![with(place.clone())], observer).contains("for electric light"));
    let mut low = sun(-3.0, 180.0);
    low.as_object_mut().expect("an object").remove("normal_illuminance_lx");
    low["horizontal_illuminance_lx"] = json!(100);
    assert!(refusal(vec![low], json!([])).contains("below the horizon"));
    let night = read(&scene(room("paint", "paint"), vec![sun(-10.0, 180.0)], json!([])));
    assert!(night.warnings.iter().any(|warning| warning.contains("gives no light")), "{:?}", night.warnings);
    let day = read(&scene(room("paint", "paint"), vec![with(place)], json!([])));
    assert!(day.luminous_flux_lm() > 0.8 * 0.8 * NORMAL_LX, "{}", day.luminous_flux_lm());
}
