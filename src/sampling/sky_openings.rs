//! Tests of lines of light against the openings through which the sky's light enters a scene.

use glam::DVec3;

use crate::scene::Openings;
use crate::scene::openings::FLAT;

/// Whether light from the sky that reaches a point belongs to the opening `own` (`None`: to none). That is so if the line from the
/// point back to the sky leaves through no other front before. `distance_m` is the distance of the opening.
pub fn belongs_to(openings: &Openings, own: Option<u32>, place_m: DVec3, towards: DVec3, distance_m: f64) -> bool {
    let rounding_m = FLAT * openings.radius_m;
    !(0u32..).zip(&openings.fronts_m).any(|(number, corners_m)| {
        Some(number) != own
            && crossed_at_m(corners_m, place_m, towards).is_some_and(|at_m| {
                at_m > -rounding_m
                    && (at_m < distance_m - rounding_m
                        || at_m <= distance_m + rounding_m && own.is_none_or(|own| number < own))
            })
    })
}

/// Whether a line from a point leaves through any front within a distance in m.
pub fn are_left_within(openings: &Openings, place_m: DVec3, towards: DVec3, distance_m: f64) -> bool {
    let rounding_m = FLAT * openings.radius_m;
    let within = -rounding_m..distance_m - rounding_m;
    let mut left = openings.fronts_m.iter().filter_map(|corners_m| crossed_at_m(corners_m, place_m, towards));
    left.any(|at_m| within.contains(&at_m))
}

/// Distance in m from a packet's start to the next opening that it enters. `own` is the opening through which it entered (`None`:
/// past all). Infinite if there is no next one.
pub fn reach_m(openings: &Openings, own: Option<u32>, place_m: DVec3, direction: DVec3) -> f64 {
    let rounding_m = FLAT * openings.radius_m;
    let entered = (0u32..).zip(&openings.fronts_m).filter_map(|(number, corners_m)| {
        let at_m = -crossed_at_m(corners_m, place_m, -direction)?;
        let is_later = at_m > rounding_m || at_m >= -rounding_m && own.is_some_and(|own| number < own);
        (Some(number) != own && is_later).then_some(at_m)
    });
    entered.fold(f64::INFINITY, f64::min)
}

/// Distance in m along a line at which it leaves through a front; negative behind its start. `None` if it does not leave there.
pub fn crossed_at_m([a, b, c]: &[DVec3; 3], place_m: DVec3, towards: DVec3) -> Option<f64> {
    let twice_area = (b - a).cross(c - a);
    let slope = twice_area.dot(towards);
    if slope >= 0.0 {
        return None;
    }
    let at_m = twice_area.dot(a - place_m) / slope;
    let met_m = place_m + at_m * towards;
    let is_left = |from: &DVec3, to: &DVec3| (to - from).cross(met_m - from).dot(twice_area) >= 0.0;
    (at_m.is_finite() && is_left(a, b) && is_left(b, c) && is_left(c, a)).then_some(at_m)
}
