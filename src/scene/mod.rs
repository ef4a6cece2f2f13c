//! From the scene file as written to one always-valid [`Scene`] in SI units.

mod advice;
mod advice_openings;
mod arrays;
mod box_tree;
mod coplanar;
pub mod elements;
mod error;
mod evaluation_grid;
mod file;
mod fitted_openings;
mod gltf;
mod gltf_buffers;
mod insides;
mod inspect;
mod leaves;
mod limits;
mod luminaires;
mod materials;
mod mesh_builder;
mod mesh_faults;
mod mesh_file;
mod model;
mod names;
mod obj;
mod observers;
mod open_rooms;
mod openings;
mod overlaps;
mod parse;
pub mod photometry;
mod placing;
mod plain_file;
mod ply;
mod points_file;
mod polygon;
mod reader;
mod receivers;
mod requirements;
mod rooms_outward;
mod schema;
mod shapes;
mod shells;
mod sky;
mod stl;
mod surface_grid;
mod surfaces;
mod t_junctions;
mod texts;
mod units;
mod vectors;
mod walls;
mod warnings;
mod weld;
mod whiteness;
mod winding;
#[cfg(test)]
mod work_tests;

pub(crate) use advice::first_met;
pub(crate) use advice_openings::luminaires_behind_surfaces;
pub use elements::{Cell, Elements, Side};
pub use error::{Refusal, SceneError, TextPlace};
pub use evaluation_grid::{EvaluationGrid, GridPart, evaluation_grid};
pub use file::{read_scene, scene_from_json};
pub use insides::all_luminaires_are_shut_in;
pub use inspect::{
    InspectedLuminaire, InspectedReceivers, InspectedShell, InspectedSurface, InspectedTotals, InspectedUnits,
    Inspection, inspect,
};
pub use mesh_faults::{Faults, Hole, MeshFaults};
pub use model::*;
pub use openings::Openings;
pub use plain_file::allow_large_files;
pub use requirements::{Measure, Requirement, StandardEntry};
pub use schema::scene_schema;
pub use shells::{Shell, closed_shells_of_geometries, shells_of_scene};
pub use texts::{Mesh, mesh_from_obj, receiver_points_from_csv};
