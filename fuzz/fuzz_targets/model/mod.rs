//! Any bytes as a model of another program: converted to a scene, which is read and inspected if it is valid.

use std::hint::black_box;
use std::path::Path;

use luxmc::check::{inspect, scene_from_json};
use luxmc::scene::propose_scene;

/// `ending` is the extension of the file name, by which the reader is chosen.
pub fn read(bytes: &[u8], ending: &str) {
    let folder = Path::new("/dev/shm");
    let name = format!("luxmc-fuzz-{}.{ending}", std::process::id());
    let path = folder.join(&name);
    std::fs::write(&path, bytes).expect("memory takes the file");
    match propose_scene(&path, &name) {
        Ok(proposal) => match scene_from_json(&proposal.scene_file("model").to_string(), None, folder) {
            Ok(scene) => {
                black_box(inspect(&scene));
            }
            Err(error) => {
                black_box(error.to_string());
            }
        },
        Err(error) => {
            black_box(error.to_string());
        }
    }
}
