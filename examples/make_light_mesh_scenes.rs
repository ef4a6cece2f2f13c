//! Writes the two open-air scenes of the light-mesh studies: `scenes/gazebo.json` and `scenes/playground.json`.
//!
//! `cargo run --release --example make_light_mesh_scenes` (from the project's root)

use luxmc::validation::studies::open_air::{Lamps, gazebo, playground, scene_text};

/// Receivers along each edge of the lawn.
const EDGE: usize = 1024;

fn main() -> std::io::Result<()> {
    for (name, title, things, depth) in [
        ("gazebo", "A garden house on a lawn, 400 units wide, for the study of light meshes", gazebo(), 400.0),
        ("playground", "A playground, 400 units wide, for the study of light meshes", playground(), 350.0),
    ] {
        std::fs::write(format!("scenes/{name}.obj"), &things.text)?;
        std::fs::write(
            format!("scenes/{name}.json"),
            scene_text(title, &format!("{name}.obj"), depth, EDGE, Lamps::Points),
        )?;
        println!("scenes/{name}.json: {} triangles in {} solids", things.triangles, things.parts);
    }
    Ok(())
}
