//! What all work of a run needs to know of it.

use super::Method;
use super::pace::{Pace, TimeLeft};
use crate::chain::Stage;
use crate::scene::Scene;

/// Everything that a job needs to know of its run.
pub struct Context<'a> {
    /// The scene as read.
    pub scene: &'a Scene,
    /// The scene made ready for packets.
    pub stage: &'a Stage,
    /// Seed of the run.
    pub seed: u64,
    /// How maps are estimated.
    pub method: Method,
    /// Error that the run is planned for.
    pub target_error: f64,
    /// Whether it goes to that error, and not to a number of chains.
    pub to_target: bool,
    /// Error that elements adapt to, if they do.
    pub adapt_to: Option<f64>,
    /// What time it has left.
    pub time_left: &'a (dyn Fn() -> TimeLeft + Sync),
    /// How much work it does between two looks at the clock.
    pub pace: Pace,
}

impl Context<'_> {
    /// Whether a limit or the user has ended the run: what a pilot has seen must do.
    pub fn is_over(&self) -> bool {
        (self.time_left)() <= TimeLeft::None
    }
}

#[cfg(test)]
impl<'a> Context<'a> {
    /// Of a test that is in no hurry: by counts, to 1 %.
    pub fn of_a_test(scene: &'a Scene, stage: &'a Stage, seed: u64) -> Context<'a> {
        let (method, target_error, time_left) = (Method::Collision, 0.01, &|| TimeLeft::Enough);
        Context {
            scene,
            stage,
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
