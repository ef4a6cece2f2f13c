//! luxmc computes illuminance and luminance of a lit scene, with an error it can vouch for.
//!
//! The rooms stand on floors; a room uses only rooms on floors above it in this list
//! (`docs/architecture.md` draws the house).

pub mod base;

pub mod scene;

pub mod geometry;
pub mod sampling;

pub mod chain;

pub mod caches;

pub mod estimators;

pub mod maps;

pub mod control;

pub mod light_mesh;
pub mod radiosity;
pub mod solver;

pub mod analytic;
pub mod output;

pub mod cli;
pub mod validation;
