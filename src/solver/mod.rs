//! The batch loop: work in replicas over threads, merged in order, until a stop rule ends it.

mod solution;

pub use solution::*;
