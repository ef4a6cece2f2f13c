//! `scene.glb`: its content, and that it can be read back as a mesh.

use std::path::Path;

use glam::DVec3;
use gltf::Glb;
use luxmc::output::color::perceptual;
use luxmc::output::glb_file;
use luxmc::{MapSelection, Scene, Settings, Silent, Solution, read_scene, scene_from_json, solve};
use serde_json::{Value, json};

const SCENE: &str = r#"{ "version": 1, "title": "a room",
  "materials": { "paint": { "type": "diffuse", "reflectance": 0.5 }, "wood": { "type": "diffuse", "reflectance": 0.3 } },
  "geometry": [ { "name": "room", "type": "box", "min": [100, 200, 0], "max": [104, 203, 2.5], "facing": "inward", "material": "paint",
                  "materials": { "floor": "wood" }, "max_element_edge": 1 },
                { "name": "board", "type": "rectangle", "origin": [101, 201, 1], "u": [1, 0, 0], "v": [0, 1, 0], "material": "wood", "two_sided": true } ],
  "luminaires": [ { "name": "lamp", "type": "point", "position": [102, 201.5, 2], "intensity_cd": 100 } ] }"#;

fn solved() -> (Scene, Solution) {
    let scene = scene_from_json(SCENE, None, Path::new(".")).expect("valid");
    let settings = Settings { chains: Some(64), maps: MapSelection::Elements, ..Settings::default() };
    let solution = solve(&scene, &settings, &Silent);
    (scene, solution)
}

/// Converts a channel of sRGB to a linear one of two bytes. Source: IEC 61966-2-1.
fn linear(code: u8) -> u16 {
    let c = f64::from(code) / 255.0;
    let linear = if c <= 0.04045 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) };
    (linear * 65_535.0).round() as u16
}

/// The file read as a mesh of a scene: the same surfaces with the same materials at the same positions.
#[test]
fn the_file_comes_back_through_the_reader_of_meshes() {
    let (scene, solution) = solved();
    let file = glb_file(&scene, &solution).expect("an element map").made().expect("made");
    let home = tempfile::tempdir().expect("a temporary directory");
    std::fs::write(home.path().join(&file.name), &file.bytes).expect("written");
    let again = home.path().join("again.json");
    let text = r#"{ "version": 1, "materials": { "paint": { "type": "diffuse", "reflectance": 0.5 }, "wood": { "type": "diffuse", "reflectance": 0.3 } },
      "geometry": [ { "name": "all", "type": "mesh", "file": "scene.glb" } ],
      "luminaires": [ { "name": "lamp", "type": "point", "position": [102, 201.5, 2], "intensity_cd": 100 } ] }"#;
    std::fs::write(&again, text).expect("written");
    let back = read_scene(&again).expect("the reader takes it");
    assert_eq!(back.triangles.len(), solution.elements.len());
    let area_m2 = |scene: &Scene, material: &str| -> f64 {
        let of_material =
            |triangle: &u32| scene.materials[scene.surface_of(*triangle).material as usize].name == material;
        let sides = |triangle: u32| if scene.surface_of(triangle).two_sided { 2.0 } else { 1.0 };
        (0..scene.triangles.len() as u32)
            .filter(of_material)
            .map(|triangle| sides(triangle) * scene.triangle_area_m2(triangle))
            .sum()
    };
    for material in ["paint", "wood"] {
        let (wanted_m2, found_m2) = (area_m2(&scene, material), area_m2(&back, material));
        assert!((found_m2 - wanted_m2).abs() < 1e-5 * wanted_m2, "{material}: {found_m2} of {wanted_m2}");
    }
    let vector_area = |scene: &Scene| -> DVec3 {
        let of = |triangle: u32| scene.triangle_area_m2(triangle) * scene.triangle_normal(triangle);
        (0..scene.triangles.len() as u32).map(of).sum()
    };
    assert!(vector_area(&back).length() < 1e-4, "fronts of the room and both sides of the board cancel each other");
    let bounds = |scene: &Scene| {
        [DVec3::min, DVec3::max].map(|pick| scene.vertices_m.iter().copied().reduce(pick).unwrap_or_default())
    };
    for (found, wanted) in bounds(&back).into_iter().zip(bounds(&scene)) {
        assert!(found.distance(wanted) < 1e-6, "{found} for {wanted}");
    }
}

#[test]
fn corners_have_their_values_and_the_colours_of_the_legend() {
    let (scene, solution) = solved();
    let file = glb_file(&scene, &solution).expect("an element map").made().expect("made");
    let glb = Glb::from_slice(&file.bytes).expect("a GLB file");
    let json: Value = serde_json::from_slice(&glb.json).expect("JSON");
    let binary = glb.bin.expect("a binary part");
    let stops = json["asset"]["extras"]["stops"].as_array().expect("a legend");
    let end_lx = stops[stops.len() - 1]["illuminance_lx"].as_f64().expect("a number");
    assert_eq!((stops.len(), &stops[0]["srgb"]), (9, &json!([68, 1, 84])));
    let bytes_of = |accessor: &Value| {
        let accessor = &json["accessors"][accessor.as_u64().expect("a number") as usize];
        let view = &json["bufferViews"][accessor["bufferView"].as_u64().expect("a view") as usize];
        let number = |key: &str| view[key].as_u64().expect("a number") as usize;
        binary[number("byteOffset")..][..number("byteLength")].to_vec()
    };
    let mut seen = Vec::new();
    for mesh in json["meshes"].as_array().expect("meshes") {
        let attributes = &mesh["primitives"][0]["attributes"];
        let values = bytes_of(&attributes["_ILLUMINANCE_LX"]);
        let colors = bytes_of(&attributes["COLOR_0"]);
        assert_eq!(colors.len(), 2 * values.len());
        for (value, color) in values.chunks_exact(4).zip(colors.chunks_exact(8)) {
            let lx = f64::from(f32::from_le_bytes(value.try_into().expect("four bytes")));
            let wanted = perceptual(lx / end_lx).map(linear);
            let found: Vec<u16> = color.chunks(2).map(|two| u16::from_le_bytes([two[0], two[1]])).collect();
            // Rounding to single precision can move a colour to the next code of eight bits.
            let off = found.iter().zip(wanted).map(|(a, b)| a.abs_diff(b)).max().unwrap_or_default();
            assert!(off <= 600, "{found:?} for {wanted:?}");
            seen.push(lx);
        }
    }
    let map = &solution.maps[0].values;
    assert_eq!(seen.len(), 3 * map.value.len());
    let (mut found, mut wanted) = (seen, map.value.iter().flat_map(|lx| [*lx; 3]).collect::<Vec<f64>>());
    found.sort_by(f64::total_cmp);
    wanted.sort_by(f64::total_cmp);
    assert!(found.iter().zip(&wanted).all(|(found, wanted)| (found - wanted).abs() < 1e-6 * wanted));
    let below: f64 = wanted.iter().filter(|lx| **lx <= end_lx).count() as f64 / wanted.len() as f64;
    assert!(below >= 0.9, "{below} of the elements lie within the scale");
}
