//! Who watches a run of the proving ground: nobody but a clock that ends what takes too long.

use std::time::Instant;

use super::cpu::ThreadClock;
use crate::solver::Observer;

/// Ends a run after so many processor seconds. The run does not know of it and plans nothing for it, as it would for a time limit.
pub struct Patient {
    started: Instant,
    clock: ThreadClock,
    limit_s: f64,
}

impl Patient {
    /// Watches a run on the thread that asks, from now on.
    pub fn starting_now(limit_s: f64) -> Patient {
        Patient { started: Instant::now(), clock: ThreadClock::starting_now(), limit_s }
    }
}

impl Observer for Patient {
    fn is_interrupted(&self) -> bool {
        self.clock.cpu_s() > self.limit_s
    }

    fn wall_s(&self) -> f64 {
        self.started.elapsed().as_secs_f64()
    }
}
