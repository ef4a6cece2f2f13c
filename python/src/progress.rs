//! Watches a run from a separate thread. The solver stores its progress here. Python's thread reads it and passes interruptions on.

use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use luxmc::Observer;
use luxmc::solver::Progress;

/// Both sides of a watched run.
pub struct Watched {
    started: Instant,
    is_interrupted: AtomicBool,
    latest: Mutex<Option<Progress>>,
}

impl Watched {
    /// A run that starts now.
    pub fn new() -> Watched {
        Watched { started: Instant::now(), is_interrupted: AtomicBool::new(false), latest: Mutex::new(None) }
    }

    /// The last progress that the solver reported and nobody has read yet.
    pub fn news(&self) -> Option<Progress> {
        self.latest.lock().ok()?.take()
    }

    /// Ends the run with what it has so far.
    pub fn interrupt(&self) {
        self.is_interrupted.store(true, Ordering::Relaxed);
    }

    /// Seconds since the run started.
    pub fn elapsed_s(&self) -> f64 {
        self.started.elapsed().as_secs_f64()
    }
}

impl Observer for Watched {
    fn progress(&self, progress: &Progress) {
        if let Ok(mut latest) = self.latest.lock() {
            *latest = Some(progress.clone());
        }
    }

    fn is_interrupted(&self) -> bool {
        self.is_interrupted.load(Ordering::Relaxed)
    }

    fn wall_s(&self) -> f64 {
        self.elapsed_s()
    }
}
