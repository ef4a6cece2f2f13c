//! Caches of light: they are learned, frozen and then looked up.

mod cells;
mod enclosures;
mod larger;
mod light;
mod system;

pub use cells::{CellGrid, CellKey, Lookup};
pub use enclosures::NO_ENCLOSURE;
pub use light::CellLight;
pub use system::{CellSample, NO_CELL};
