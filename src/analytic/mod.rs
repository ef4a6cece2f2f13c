//! Exact solutions, each with a stated accuracy: numbers to hold simulations against.

pub mod error;
pub mod sobolev;

pub use error::AnalyticError;
