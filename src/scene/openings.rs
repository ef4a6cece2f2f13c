//! Openings through which the sky's light enters: panes, and holes in the surfaces around a room.
//!
//! An opening is a triangle whose front faces the room. Light from the sky belongs to the last front that it passed on its way in, or to
//! none. So every line to the sky counts once, for any position and orientation of the openings. The openings only direct the sampling of
//! the sky. `check/sky_openings.rs` finds them, and `sampling/sky_openings.rs` tells which of them light entered through.

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
}

/// Unit normal on the front of an opening.
pub(crate) fn normal([a, b, c]: &[DVec3; 3]) -> DVec3 {
    (b - a).cross(c - a).normalize_or_zero()
}

/// Area of an opening in m².
pub(crate) fn area_m2([a, b, c]: &[DVec3; 3]) -> f64 {
    0.5 * (b - a).cross(c - a).length()
}
