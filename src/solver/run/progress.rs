//! What is told of a run while it goes on.

use crate::control::Forecast;
use crate::solver::job::Hindrance;

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

/// The map that the rest of a run goes to most.
#[derive(Clone, Debug, PartialEq)]
pub struct SlowestMap {
    /// `elements`, or the receiver set's name.
    pub name: String,
    /// Its stated error by its latest look, once it has had one.
    pub error: Option<f64>,
    /// What keeps it from its target but chance; `None` where nothing else is known to.
    pub hindrance: Option<Hindrance>,
}
