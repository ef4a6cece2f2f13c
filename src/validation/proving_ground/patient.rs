//! The observer of runs in the proving ground: a clock that ends runs that take too long.

use std::time::Instant;

use super::cpu::{ThreadClock, on_one_thread};
use crate::scene::Scene;
use crate::solver::{Observer, Settings, Solution, solve};

/// Ends a run after `limit_s` processor seconds. Unlike with a time limit, the run does not plan for this end.
struct Patient {
    started: Instant,
    clock: ThreadClock,
    limit_s: f64,
}

impl Patient {
    /// Starts to observe a run on the calling thread.
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

/// Solves a scene on one thread, for `limit_s` processor seconds at most. Returns the solution and the processor seconds used.
pub fn solve_watched(scene: &Scene, settings: &Settings, limit_s: f64) -> (Solution, f64) {
    on_one_thread(|| {
        let clock = ThreadClock::starting_now();
        let solution = solve(scene, settings, &Patient::starting_now(limit_s));
        (solution, clock.cpu_s())
    })
}
