//! Illuminance on small bodies, which light reaches from all sides: the response to light from a direction, and the planes whose
//! illuminances add up to it.
//!
//! Cylindrical illuminance is the mean of the illuminances on all upright planes, E_z = 1/2π ∫ E_v(φ) dφ. So a plane turned at random gives
//! an unbiased sample of it. Semi-cylindrical illuminance weights the same planes, E_sc = 1/2π ∫ (1 + 4/π cos φ) E_v(φ) dφ, with φ from the
//! direction that the body faces. The half cosine of a receiving plane has the harmonics 1/π and ½. So light from azimuth α at ε from the
//! vertical counts (1 + cos α) sin ε/π.

use std::f64::consts::PI;

use glam::DVec3;
use serde::{Deserialize, Serialize};

use crate::scene::Quantity;

/// A small body whose illuminance is calculated.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum SmallBody {
    /// The lateral surface of an upright cylinder.
    Cylinder,
    /// The curved face of a half cylinder, which faces a horizontal unit vector.
    HalfCylinder(DVec3),
}

impl SmallBody {
    /// The body of a quantity. `None` for planes and for quantities other than illuminance.
    pub fn of(quantity: Quantity) -> Option<SmallBody> {
        match quantity {
            Quantity::Cylindrical => Some(SmallBody::Cylinder),
            Quantity::SemiCylindrical { direction } => Some(SmallBody::HalfCylinder(direction)),
            _ => None,
        }
    }

    /// Illuminance of the body by light from a unit direction, over that of a plane perpendicular to it.
    pub fn response(self, towards: DVec3) -> f64 {
        let sine = (towards.x * towards.x + towards.y * towards.y).sqrt();
        match self {
            SmallBody::Cylinder => sine / PI,
            SmallBody::HalfCylinder(front) => (sine + towards.dot(front)) / PI,
        }
    }

    /// The normal of a plane turned by an angle, and its weight. The mean over all turns of weight times illuminance is the body's
    /// illuminance.
    pub fn turned_plane(self, turn: f64) -> (DVec3, f64) {
        let (sine, cosine) = turn.sin_cos();
        let plane = |front: DVec3| cosine * front + sine * DVec3::Z.cross(front);
        match self {
            SmallBody::Cylinder => (plane(DVec3::X), 1.0),
            SmallBody::HalfCylinder(front) => (plane(front), 1.0 + 4.0 / PI * cosine),
        }
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;

    /// Light from azimuth α at ε from the vertical gives 1/π sin ε on a cylinder and (1 + cos α)/π sin ε on a half cylinder. Planes and
    /// response both give these values. The value of the other body is rejected for each.
    #[test]
    fn the_weighted_planes_make_up_the_response_of_every_body() {
        const STEPS: u32 = 20_000;
        let (azimuth, from_vertical) = (0.7f64, 1.1f64);
        let front = DVec3::new(0.6, 0.8, 0.0);
        let towards = from_vertical.sin() * (azimuth.cos() * front + azimuth.sin() * DVec3::Z.cross(front))
            + from_vertical.cos() * DVec3::Z;
        let by_planes = |body: SmallBody| {
            let sample = |step: u32| {
                let (normal, weight) = body.turned_plane(TAU * f64::from(step) / f64::from(STEPS));
                weight * normal.dot(towards).max(0.0)
            };
            (0..STEPS).map(sample).sum::<f64>() / f64::from(STEPS)
        };
        let whole = from_vertical.sin() / PI;
        let half = whole * (1.0 + azimuth.cos());
        for (body, exact, other) in [(SmallBody::Cylinder, whole, half), (SmallBody::HalfCylinder(front), half, whole)]
        {
            for found in [by_planes(body), body.response(towards)] {
                assert!((found - exact).abs() < 1e-7 && (found - other).abs() > 1e-2, "{body:?}: {found}");
            }
        }
    }
}
