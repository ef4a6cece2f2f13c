//! Light meshes against exact values.

#[path = "../common/mod.rs"]
mod common;

mod errors;
mod exact;
mod gloss;
mod limits;
mod luminance;
mod mirrors;
mod shadow_rivals;
mod studies;
