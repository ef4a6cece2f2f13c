//! Any text as a scene file: read, and inspected if it is valid.
#![no_main]

use std::path::Path;

use libfuzzer_sys::fuzz_target;
use luxmc::check::{inspect, scene_from_json};

fuzz_target!(|text: &str| {
    // Files that the scene names do not exist, so that only the scene itself is tested.
    match scene_from_json(text, None, Path::new("/nowhere")) {
        Ok(scene) => {
            std::hint::black_box(inspect(&scene));
        }
        Err(error) => {
            std::hint::black_box(error.to_string());
        }
    }
});
