//! Who watches a run of the proving ground: nobody but a clock that ends what takes too long.

use std::time::Instant;

use super::cpu::{ThreadClock, on_one_thread};
use crate::scene::Scene;
use crate::solver::{Observer, Settings, Solution, solve};

/// Ends a run after so many processor seconds. The run does not know of it and plans nothing for it, as it would for a time limit.
struct Patient {
    started: Instant,
    clock: ThreadClock,
    limit_s: f64,
}

impl Patient {
    /// Watches a run on the thread that asks, from now on.
    fn starting_now(limit_s: f64) -> Patient {
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

/// Solves a scene on one thread, for so many processor seconds at most; tells how many it took.
pub fn solve_watched(scene: &Scene, settings: &Settings, limit_s: f64) -> (Solution, f64) {
    on_one_thread(|| {
        let clock = ThreadClock::starting_now();
        let solution = solve(scene, settings, &Patient::starting_now(limit_s));
        (solution, clock.cpu_s())
    })
}
