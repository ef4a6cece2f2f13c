//! Scene files: the result of good ones, the refusal of bad ones, and the sample scenes.

#[path = "../common/mod.rs"]
mod common;

mod given_meshes;
mod reading;
mod refusal_cases;
mod refusals;
mod sample_scenes;
mod schema;
mod showrooms;
mod surroundings;
