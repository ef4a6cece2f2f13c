//! The batch loop: work in replicas over threads, merged in order, until a stop rule ends it.

mod finish;
mod glare;
mod job;
mod local;
mod pilot;
mod run;
mod solution;
mod sparse;
mod sweep;

pub use glare::GlareRating;
pub use run::{DEFAULT_TARGET_ERROR, Observer, Progress, map_requests, solve};
pub use solution::*;
