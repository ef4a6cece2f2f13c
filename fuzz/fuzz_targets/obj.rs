//! Any text as an OBJ file: read, and inspected as a part of a scene if it is valid.
#![no_main]

use std::path::Path;

use libfuzzer_sys::fuzz_target;
use luxmc::check::{inspect, scene_from_json};
use luxmc::scene::mesh_from_obj;

fuzz_target!(|text: &str| {
    match mesh_from_obj(text, Path::new("mesh.obj")) {
        Ok(_) => in_a_scene(text),
        Err(error) => {
            std::hint::black_box(error.to_string());
        }
    }
});

fn in_a_scene(text: &str) {
    let folder = Path::new("/dev/shm");
    let name = format!("luxmc-fuzz-{}.obj", std::process::id());
    std::fs::write(folder.join(&name), text).expect("memory takes the file");
    let scene = format!(
        r#"{{ "version": 1, "materials": {{ "m": {{ "type": "diffuse", "reflectance": 0.5 }} }},
        "geometry": [ {{ "name": "mesh", "type": "mesh", "file": "{name}", "material": "m", "max_element_edge": 0.5 }} ],
        "luminaires": [ {{ "name": "a", "type": "point", "position": [0.2,0.3,0.4], "intensity_cd": 1 }} ],
        "receivers": [ {{ "name": "g", "type": "grid", "origin": [0,0,0.1], "u": [1,0,0], "v": [0,1,0], "columns": 3, "rows": 3 }} ] }}"#
    );
    match scene_from_json(&scene, None, folder) {
        Ok(scene) => {
            std::hint::black_box(inspect(&scene));
        }
        Err(error) => {
            std::hint::black_box(error.to_string());
        }
    }
}
