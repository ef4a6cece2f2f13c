//! The result of a year.

use super::count::MEASURES;
use super::hours::YearSky;
use crate::maps::Estimate;
use crate::scene::Scene;

/// The result of a year of daylight.
#[derive(Clone, Debug)]
pub struct YearSolution {
    /// The scene, with a uniform sky of 1 cd/m² as its only luminaire.
    pub scene: Scene,
    /// Its hours, skies and suns.
    pub sky: YearSky,
    /// Results of the receiver sets on planes.
    pub sets: Vec<SetYear>,
    /// Names of sets left out, since they request quantities other than illuminance on planes.
    pub left_out: Vec<String>,
    /// The target error; see [`YearPoint::error`].
    pub target_error: f64,
    /// Relative error of the sky's light due to patches of uniform luminance: root mean square over points, in the median hour of a
    /// survey, measured. No replica shows this error, so it adds to the errors of the hours.
    pub patch_error: f64,
    /// Rays traced.
    pub rays: u64,
    /// Walks that were given up.
    pub walks_given_up: u64,
    /// What the year leaves out, in words.
    pub warnings: Vec<String>,
}

impl YearSolution {
    /// Returns whether every point that counts meets the target error.
    pub fn target_met(&self) -> bool {
        self.sets.iter().all(|set| set.worst_error <= self.target_error)
    }
}

/// The year of a receiver set.
#[derive(Clone, Debug)]
pub struct SetYear {
    /// Index among the scene's receiver sets.
    pub set: usize,
    /// Its name.
    pub name: String,
    /// Its points, in the order of the scene.
    pub points: Vec<YearPoint>,
    /// Spatial daylight autonomy: share of the area with 300 lx in half of the occupied hours or more.
    pub autonomy: Estimate,
    /// Annual sunlight exposure: share of the area on which the sun alone gives 1000 lx in more than 250 occupied hours.
    pub sunlit: Estimate,
    /// Means over the area of the measures at points, in the order of [`MEASURES`].
    pub averages: [Estimate; MEASURES.len()],
    /// Mean illuminance of each hour with light, in lx.
    pub hourly_lx: Vec<f64>,
    /// Standard error of `hourly_lx` in lx.
    pub hourly_standard_error_lx: Vec<f64>,
    /// Share of the area from 300 to 3000 lx in each hour with light.
    pub hourly_useful: Vec<f64>,
    /// Whether blinds are closed in each hour; empty without blinds.
    pub closed: Vec<bool>,
    /// Largest error of a point that counts.
    pub worst_error: f64,
    /// Root mean square of the errors of the points that count.
    pub error: f64,
}

/// The year of a point.
#[derive(Clone, Debug, Default)]
pub struct YearPoint {
    /// The measures, in the order of [`MEASURES`].
    pub measures: [Estimate; MEASURES.len()],
    /// Relative standard error of the hours' illuminances: root mean square over the occupied hours with light. In hours darker
    /// than a hundredth of the mean illuminance, the error is relative to that hundredth.
    pub error: f64,
    /// Number of walks.
    pub walks: u64,
}
