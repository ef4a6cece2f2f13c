//! From the scene file as written to one always-valid [`Scene`] in SI units.

pub mod elements;
mod model;
pub mod photometry;

pub use elements::{Cell, Elements, Side};
pub use model::*;
