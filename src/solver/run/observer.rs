//! The interface to whoever watches a run, and what it reports.

use super::kept::{GoingOn, Keeper};
use super::progress::Progress;
use crate::control::Forecast;
use crate::solver::Settings;

/// Watches a run: progress goes out, interruptions and the clock come in.
pub trait Observer: Sync {
    /// Called once the scene is ready for rays. From then on the clock is used.
    fn ready(&self) {}
    /// Called after every slice of work.
    fn progress(&self, _progress: &Progress) {}
    /// Called once before the work if a time limit is expected to end the run, before its target if it has one. It gives the stated error
    /// that the run is expected to reach.
    fn expects(&self, _error: Forecast, _target: Option<f64>) {}
    /// Whether the user wants to stop.
    fn is_interrupted(&self) -> bool {
        false
    }
    /// What stores the run's state, if it is to be stored.
    fn keeper(&self) -> Option<&dyn Keeper> {
        None
    }
    /// Seconds since the process started. With a clock that stands still, no time limit ends a run.
    fn wall_s(&self) -> f64 {
        0.0
    }
}

/// Watches nothing, never interrupts, and has a clock that stands still.
#[derive(Clone, Copy, Debug, Default)]
pub struct Silent;

impl Observer for Silent {}

/// An observer whose clock continues from the time of a stored run.
pub struct LaterObserver<'a> {
    observer: &'a dyn Observer,
    /// Seconds by which its clock is ahead.
    ahead_s: f64,
}

impl<'a> LaterObserver<'a> {
    /// Creates the observer of a run that resumes or begins.
    pub fn of(observer: &'a dyn Observer, going_on: Option<&GoingOn>) -> LaterObserver<'a> {
        let ahead_s = going_on.map_or(0.0, |going_on| going_on.kept.wall_s - observer.wall_s());
        LaterObserver { observer, ahead_s }
    }

    /// The time limit in seconds on the clock of the whole run.
    pub fn time_limit_s(&self, settings: &Settings, going_on: Option<&GoingOn>) -> Option<f64> {
        let of_part_s = going_on.and_then(|going_on| going_on.time_limit_s);
        of_part_s.map(|limit_s| limit_s + self.ahead_s).or(settings.time_limit_s)
    }
}

impl Observer for LaterObserver<'_> {
    fn ready(&self) {
        self.observer.ready();
    }

    fn progress(&self, progress: &Progress) {
        self.observer.progress(progress);
    }

    fn expects(&self, error: Forecast, target: Option<f64>) {
        self.observer.expects(error, target);
    }

    fn is_interrupted(&self) -> bool {
        self.observer.is_interrupted()
    }

    fn wall_s(&self) -> f64 {
        self.ahead_s + self.observer.wall_s()
    }

    fn keeper(&self) -> Option<&dyn Keeper> {
        self.observer.keeper()
    }
}
