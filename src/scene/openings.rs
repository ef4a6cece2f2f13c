//! Openings through which the sky's light enters: panes, and holes in the surfaces around a room.
//!
//! An opening is a triangle whose front faces the room. Light from the sky belongs to the last front that it passed on its way in, or to
//! none. So every line to the sky counts once, for any position and orientation of the openings. The openings only direct the sampling of
//! the sky. `check/sky_openings.rs` finds them.

use std::f64::consts::PI;

use glam::DVec3;

/// Largest distance of a flat hole's corners from its plane, as a fraction of the scene's size. A step off a surface has the same length.
pub(crate) const FLAT: f64 = 1e-6;

/// The openings through which the inside of a scene sees the sky.
#[derive(Clone, Debug, Default)]
pub struct Openings {
    /// Corners in m, counter-clockwise as seen from the room.
    pub fronts_m: Vec<[DVec3; 3]>,
    /// Whether the sky's light reaches the surfaces and receivers of the room only through these openings.
    pub are_all: bool,
    /// Centre in m of a ball that contains the scene.
    pub center_m: DVec3,
    /// Radius in m of that ball.
    pub radius_m: f64,
}

impl Openings {
    /// Returns the openings if the sky's light enters only through them, otherwise `None`.
    pub fn if_all(&self) -> Option<&Openings> {
        self.are_all.then_some(self)
    }

    /// Flux in lm through each front. `illuminance_lx` gives the illuminance in lx on a plane with a unit normal.
    pub fn fluxes_lm(&self, illuminance_lx: impl Fn(DVec3) -> f64) -> impl Iterator<Item = f64> {
        self.fronts_m.iter().map(move |corners_m| area_m2(corners_m) * illuminance_lx(-normal(corners_m)))
    }

    /// Flux in lm that may enter past all fronts: that through the ball about the scene, or 0 if light enters only through the fronts.
    /// `total_cd_sr_m2` is ∫ L dω in cd·sr/m².
    pub fn open_flux_lm(&self, total_cd_sr_m2: f64) -> f64 {
        if self.are_all { 0.0 } else { PI * self.radius_m * self.radius_m * total_cd_sr_m2 }
    }

    /// A point outside the scene.
    pub fn outside_m(&self) -> DVec3 {
        self.center_m + 2.0 * self.radius_m * DVec3::Z
    }

    /// Whether light from the sky that reaches a point belongs to the opening `own` (`None`: to none). That is so if the line from the
    /// point back to the sky leaves through no other front before. `distance_m` is the distance of the opening.
    pub fn belongs_to(&self, own: Option<u32>, place_m: DVec3, towards: DVec3, distance_m: f64) -> bool {
        let rounding_m = FLAT * self.radius_m;
        !(0u32..).zip(&self.fronts_m).any(|(number, corners_m)| {
            Some(number) != own
                && crossed_at_m(corners_m, place_m, towards).is_some_and(|at_m| {
                    at_m > -rounding_m
                        && (at_m < distance_m - rounding_m
                            || at_m <= distance_m + rounding_m && own.is_none_or(|own| number < own))
                })
        })
    }

    /// Whether a line from a point leaves through any front within a distance in m.
    pub fn are_left_within(&self, place_m: DVec3, towards: DVec3, distance_m: f64) -> bool {
        let rounding_m = FLAT * self.radius_m;
        let within = -rounding_m..distance_m - rounding_m;
        let mut left = self.fronts_m.iter().filter_map(|corners_m| crossed_at_m(corners_m, place_m, towards));
        left.any(|at_m| within.contains(&at_m))
    }

    /// Distance in m from a packet's start to the next opening that it enters. `own` is the opening through which it entered (`None`:
    /// past all). Infinite if there is no next one.
    pub fn reach_m(&self, own: Option<u32>, place_m: DVec3, direction: DVec3) -> f64 {
        let rounding_m = FLAT * self.radius_m;
        let entered = (0u32..).zip(&self.fronts_m).filter_map(|(number, corners_m)| {
            let at_m = -crossed_at_m(corners_m, place_m, -direction)?;
            let is_later = at_m > rounding_m || at_m >= -rounding_m && own.is_some_and(|own| number < own);
            (Some(number) != own && is_later).then_some(at_m)
        });
        entered.fold(f64::INFINITY, f64::min)
    }
}

/// Distance in m along a line at which it leaves through a front; negative behind its start. `None` if it does not leave there.
pub(crate) fn crossed_at_m([a, b, c]: &[DVec3; 3], place_m: DVec3, towards: DVec3) -> Option<f64> {
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

/// Unit normal on the front of an opening.
pub(crate) fn normal([a, b, c]: &[DVec3; 3]) -> DVec3 {
    (b - a).cross(c - a).normalize_or_zero()
}

/// Area of an opening in m².
pub(crate) fn area_m2([a, b, c]: &[DVec3; 3]) -> f64 {
    0.5 * (b - a).cross(c - a).length()
}
