//! Who watches a run, and what of it is told.

use super::{Keeper, SlowestMap};
use crate::control::Forecast;

/// How a run stands.
#[derive(Clone, Debug)]
pub struct Progress {
    /// Worst stated error of the bound maps, once all have been judged.
    pub estimated_error: Option<f64>,
    /// Target, if one is set.
    pub target_error: Option<f64>,
    /// Chains so far, all maps.
    pub chains: u64,
    /// Rays so far.
    pub rays: u64,
    /// Forecast of the rays at the end, where there is one.
    pub forecast_rays: Option<Forecast>,
    /// Forecast of the seconds that remain, where there is one.
    pub remaining_s: Option<Forecast>,
    /// The map that the rest of the time goes to most, once there is a forecast.
    pub slowest_map: Option<SlowestMap>,
    /// Share of the work done, 0 to 1.
    pub fraction: f64,
    /// Seconds since the process started.
    pub wall_s: f64,
}

/// Who watches a run: progress goes out, interruptions and the clock come in.
pub trait Observer: Sync {
    /// Called once the scene is ready for rays: all that follows asks the clock.
    fn ready(&self) {}
    /// Called after every slice of work.
    fn progress(&self, _progress: &Progress) {}
    /// Called once before the work where a time limit ends the run, before its target if it has one: the stated error that it may be
    /// expected to reach.
    fn expects(&self, _error: Forecast, _target: Option<f64>) {}
    /// Whether the user wants to stop.
    fn is_interrupted(&self) -> bool {
        false
    }
    /// What keeps the run's state, where it is to be kept.
    fn keeper(&self) -> Option<&dyn Keeper> {
        None
    }
    /// Seconds since the process started. A clock that stands lets no time limit end a run.
    fn wall_s(&self) -> f64 {
        0.0
    }
}

/// Watches nothing, never interrupts, and its clock stands.
#[derive(Clone, Copy, Debug, Default)]
pub struct Silent;

impl Observer for Silent {}
