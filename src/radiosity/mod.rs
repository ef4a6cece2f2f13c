//! Radiosity in rectangular rooms: the finite-element method to compare with the methods that trace chains.
//!
//! Every face is cut into rectangles, finer towards its edges and towards changes of material. The exchange between rectangles is
//! exact. The mean direct light over each rectangle is exact too (integrated for measured distributions). Only the variation of the
//! exitance within a rectangle is lost. This error falls with the square of the rectangles' size. Three meshes, each twice as fine
//! as the one before, allow to extrapolate the error away and to estimate what remains.
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
