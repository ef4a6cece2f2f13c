//! A finished year.

use super::count::MEASURES;
use super::hours::YearSky;
use crate::maps::Estimate;
use crate::scene::Scene;

/// What a year comes to.
#[derive(Clone, Debug)]
pub struct YearSolution {
    /// The scene, its luminaires left out but a sky of 1 cd/m² all around.
    pub scene: Scene,
    /// Its hours, skies and suns.
    pub sky: YearSky,
    /// Receiver sets on planes.
    pub sets: Vec<SetYear>,
    /// Sets that were left out, since they ask for other than illuminance on planes.
    pub left_out: Vec<String>,
    /// The error that was asked for: see [`YearPoint::error`].
    pub target_error: f64,
    /// What patches of even luminance make of the sky's light, as a part of it: root mean square over points, in the median hour of a survey, measured. No
    /// replica shows it, so that it comes on top of what the errors of hours tell.
    pub patch_error: f64,
    /// Rays traced.
    pub rays: u64,
    /// Walks that were given up.
    pub walks_given_up: u64,
    /// What the year leaves out, in words.
    pub warnings: Vec<String>,
}

impl YearSolution {
    /// Whether every point that counts has the error that was asked for.
    pub fn target_met(&self) -> bool {
        self.sets.iter().all(|set| set.worst_error <= self.target_error)
    }
}

/// The year of a receiver set.
#[derive(Clone, Debug)]
pub struct SetYear {
    /// Place among the receivers of the scene.
    pub set: usize,
    /// Its name.
    pub name: String,
    /// Its points, in the order of the scene.
    pub points: Vec<YearPoint>,
    /// Spatial daylight autonomy: share of the area with 300 lx in half of the occupied hours or more.
    pub autonomy: Estimate,
    /// Annual sunlight exposure: share of the area on which the sun alone brings 1000 lx in more than 250 occupied hours.
    pub sunlit: Estimate,
    /// Means over the area of what is counted at points.
    pub averages: [Estimate; MEASURES.len()],
    /// Mean illuminance of each hour with light, in lx.
    pub hourly_lx: Vec<f64>,
    /// Its standard error in lx.
    pub hourly_standard_error_lx: Vec<f64>,
    /// Share of the area from 300 to 3000 lx in each hour with light.
    pub hourly_useful: Vec<f64>,
    /// Hours in which blinds are closed; none where there are none.
    pub closed: Vec<bool>,
    /// Greatest error of a point that counts.
    pub worst_error: f64,
    /// Root mean square of the errors of those points.
    pub error: f64,
}

/// The year of a point.
#[derive(Clone, Debug, Default)]
pub struct YearPoint {
    /// What is counted, in the order of [`MEASURES`].
    pub measures: [Estimate; MEASURES.len()],
    /// Relative standard error of the hours' illuminances, its root mean square over the occupied hours with light; of those darker than a hundredth of
    /// their mean, relative to that.
    pub error: f64,
    /// Walks that it took.
    pub walks: u64,
}
