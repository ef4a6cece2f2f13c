//! Methods that use no chains: light meshes and radiosity, each from scene and settings to a solution.

mod light_mesh;
mod light_mesh_words;
mod radiosity;

pub use light_mesh::{MeshChoice, check_requests as check_light_mesh, solve_by_light_mesh};
pub use radiosity::solve_by_radiosity;
