//! Daylight factors of a run.

use super::observers::maps_of;
use crate::maps::DaylightFactors;
use crate::scene::{Quantity, Scene};
use crate::solver::Solution;

/// Daylight factors of the receiver sets that are planes; none if there is other light than that of the sky.
pub fn daylight_factors(scene: &Scene, solution: &Solution) -> Vec<DaylightFactors> {
    let Some((outside_lx, targets)) = scene.daylight() else {
        return Vec::new();
    };
    let maps = maps_of(scene, solution, |quantity| quantity == Quantity::Perpendicular);
    let factors =
        maps.into_iter().map(|(map, set)| DaylightFactors::of(map, &scene.receivers[set].points, outside_lx, targets));
    factors.flatten().collect()
}
