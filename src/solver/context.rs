//! What all work of a run needs to know about the run.

use super::Method;
use super::pace::{Pace, TimeLeft};
use crate::scene::Scene;
use crate::transport::World;

/// Everything that a job needs to know about its run.
pub struct Context<'a> {
    /// The scene as read.
    pub scene: &'a Scene,
    /// The scene prepared for packets.
    pub world: &'a World,
    /// Seed of the run.
    pub seed: u64,
    /// How maps are estimated.
    pub method: Method,
    /// Target error for which the run is planned.
    pub target_error: f64,
    /// Whether the run goes to that error, and not to a number of chains.
    pub to_target: bool,
    /// Error to which elements adapt, if they do.
    pub adapt_to: Option<f64>,
    /// The time that it has left.
    pub time_left: &'a (dyn Fn() -> TimeLeft + Sync),
    /// How much work it does between two readings of the clock.
    pub pace: Pace,
}

impl Context<'_> {
    /// Whether a limit or the user has ended the run. A pilot must then do with what it has seen.
    pub fn is_over(&self) -> bool {
        (self.time_left)() <= TimeLeft::None
    }
}

#[cfg(test)]
impl<'a> Context<'a> {
    /// Context of a test without a time limit: by counts, to 1 %.
    pub fn of_a_test(scene: &'a Scene, world: &'a World, seed: u64) -> Context<'a> {
        let (method, target_error, time_left) = (Method::Collision, 0.01, &|| TimeLeft::Enough);
        Context {
            scene,
            world,
            seed,
            method,
            target_error,
            to_target: true,
            adapt_to: None,
            time_left,
            pace: Pace::steady(),
        }
    }
}
