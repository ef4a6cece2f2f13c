//! Reports on a run in progress.

use crate::control::Forecast;
use crate::solver::job::Hindrance;

/// The state of a run.
#[derive(Clone, Debug)]
pub struct Progress {
    /// Worst stated error of the bound maps that have been judged, once there is one.
    pub estimated_error: Option<f64>,
    /// Target, if one is set.
    pub target_error: Option<f64>,
    /// Chains so far, all maps.
    pub chains: u64,
    /// Rays so far.
    pub rays: u64,
    /// Forecast of the rays at the end, if there is one.
    pub forecast_rays: Option<Forecast>,
    /// Forecast of the remaining seconds, if there is one.
    pub remaining_s: Option<Forecast>,
    /// The map that takes most of the remaining time, once there is a forecast.
    pub slowest_map: Option<SlowestMap>,
    /// Share of the work done, 0 to 1.
    pub fraction: f64,
    /// Seconds since the process started.
    pub wall_s: f64,
}

/// The map that takes most of the remaining time of a run.
#[derive(Clone, Debug, PartialEq)]
pub struct SlowestMap {
    /// `elements`, or the receiver set's name.
    pub name: String,
    /// Its stated error by its latest look, once it has had one.
    pub error: Option<f64>,
    /// What keeps it from its target, apart from random error; `None` if nothing else is known.
    pub hindrance: Option<Hindrance>,
}
