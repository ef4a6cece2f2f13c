//! Random streams, warps, and the four functions sample, pdf, eval and total of every luminaire and material.

pub mod abreast;
pub mod beam;
#[cfg(test)]
mod chi_square;
pub mod emitter;
pub mod emitter_tree;
mod few_beacons;
pub mod guide;
pub mod highlight;
mod importance;
pub mod opening;
pub mod random;
pub mod reflection;
pub mod sky_openings;
mod sobol;
pub mod triangle;
pub mod warp;
pub mod web;
