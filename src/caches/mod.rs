//! What is learned of the light, frozen, and then asked.

mod cells;
mod light;

pub use cells::{CellGrid, CellKey, Lookup};
pub use light::{CellLight, CellSample, NO_CELL};
