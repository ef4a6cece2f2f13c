//! What is learned of the light, frozen, and then asked.

mod cells;
mod directions;
mod light;

pub use cells::{CellGrid, CellKey, Lookup};
pub use directions::{DirectionControl, DirectionSums, bin_of};
pub use light::{CellLight, CellRef, CellSample};
