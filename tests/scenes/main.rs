//! Scene files: what good ones become, how bad ones are refused, and the sample scenes.

#[path = "../common/mod.rs"]
mod common;

mod given_meshes;
mod reading;
mod refusal_cases;
mod refusals;
mod sample_scenes;
mod showrooms;
mod surroundings;
