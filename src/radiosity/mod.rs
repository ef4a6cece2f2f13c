//! Radiosity on rectangular rooms: the finite-element rival of the methods that trace chains.
//!
//! Every face is cut into rectangles, finer towards its edges and towards breaks of material. The exchange between
//! rectangles and the direct light's mean over each are exact (of measured distributions: integrated), so that only the
//! exitance's variation within a rectangle is lost, an error that falls with the square of their size. Three meshes,
//! each twice as fine as the one before, let it be extrapolated away and judged.
//!
//! [`Radiosity`] computes the maps of a scene; [`mesh::RoomMesh`] solves one mesh.

mod direct;
mod error;
pub mod faces;
mod field;
pub mod mesh;
mod room;
mod solve;
pub mod sources;

pub use error::NotARoom;
pub use solve::{AbsorbedFlux, Radiosity};
