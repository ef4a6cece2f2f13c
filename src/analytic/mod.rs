//! Exact solutions, each with a stated accuracy, to validate simulations.

pub mod box_room;
pub mod cylinder;
pub mod direct;
pub mod error;
pub mod sobolev;
pub mod sphere;
pub mod ugr_table;

pub use error::AnalyticError;
