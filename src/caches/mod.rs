//! What is learned of the light, frozen, and then asked.

mod cells;
mod light;

pub use cells::{CellGrid, Lookup};
pub use light::{CellLight, CellRef, CellSample};
