//! From the scene file to a valid [`Scene`] in SI units.

mod arrays;
mod bodies;
mod daylight;
mod digest;
pub mod elements;
mod emission;
mod energy;
mod error;
mod evaluation_grid;
mod file;
mod given;
mod gltf;
mod gltf_buffers;
mod gltf_extensions;
mod grid_frame;
mod intensity;
mod intensity_table;
mod leaves;
mod limits;
mod luminaire_keys;
mod luminaire_reading;
mod luminaires;
mod materials;
mod mesh_builder;
mod mesh_file;
mod model;
mod names;
mod not_read;
mod obj;
mod observers;
pub(crate) mod openings;
mod parse;
mod photometric_luminaire;
pub mod photometry;
mod placing;
mod plain_file;
mod ply;
mod points_file;
mod polygon;
mod project;
mod proposal;
mod proposed;
mod quantity;
mod radiance;
mod radiance_scene;
mod reader;
mod receivers;
mod receivers_part;
mod reported;
mod requirements;
mod room_receivers;
mod schema;
mod series;
mod shapes;
mod shared_receivers;
mod sky;
mod standard;
mod standard_entries;
mod stl;
mod sun;
mod surface_grid;
mod surfaces;
mod surroundings;
mod texts;
pub(crate) mod under_way;
mod unique_names;
mod units;
mod vectors;
mod weather;
mod weld;

pub use bodies::{Body, body_of};
pub use elements::{ElementSide, Elements, Side, positions_m};
pub use emission::Emission;
pub use energy::Energy;
pub use error::{Refusal, SceneError, TextPlace};
pub use evaluation_grid::{ElementSizes, EvaluationGrid, GridPart, evaluation_grid};
pub(crate) use file::{WrittenGeometry, from_json_with, read_with};
pub use intensity_table::IntensityTable;
pub use materials::{BsdfParameters, Material};
pub use model::*;
pub(crate) use names::{joined, listed, place_words};
pub use openings::Openings;
pub use photometric_luminaire::Product;
pub use plain_file::allow_large_files;
pub(crate) use polygon::triangulate;
pub use project::Project;
pub use proposal::{is_radiance, propose_radiance_scene, propose_scene};
pub use proposed::{Proposal, ProposedMaterial, STAND_IN};
pub use quantity::{Background, Quantity};
pub(crate) use reader::Node;
pub use receivers_part::ReceiversPart;
pub use schema::scene_schema;
pub use series::series_file;
#[cfg(test)]
pub(crate) use shapes::icosphere;
pub use sky::DaylightTargets;
pub use standard::{Area, Measure, Requirement, SpaceLimits, StandardEntry};
pub use texts::{Mesh, mesh_from_obj, receiver_points_from_csv};
pub(crate) use units::{LengthUnit, UNIT_NAMES};
pub use weather::{Weather, WeatherHour, WeatherLight, read_weather, weather_from_text};

/// Names of the types of materials and of luminaires, each with its key in a scene.
#[cfg(test)]
pub(crate) fn type_names() -> [(&'static str, &'static [&'static str]); 2] {
    [("materials", &materials::TYPES), ("luminaires", &emission::TYPES)]
}
