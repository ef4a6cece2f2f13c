//! The light sources of a room, and their direct light.

use std::f64::consts::PI;

use glam::DVec3;

use super::faces::{RoomFace, triangle_rule};
use crate::base::form_factors::exchange_m2;
use crate::base::polygon::polygon_illuminance_lx;
use crate::base::solid_angle::triangle_solid_angle_sr;

/// A source in the room.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum RoomSource {
    /// An isotropic point.
    Point {
        /// Position within the room, m.
        position: DVec3,
        /// Intensity in every direction, cd (flux over 4π).
        intensity_cd: f64,
    },
    /// A Lambertian rectangle flush with a face. It keeps the face's reflectance.
    Panel {
        /// The face that it lies on.
        face: RoomFace,
        /// Low corner along the other two axes, m.
        low: [f64; 2],
        /// High corner, m.
        high: [f64; 2],
        /// Exitance emitted, lm/m².
        exitance_lm_m2: f64,
    },
}

impl RoomSource {
    /// Emitted flux, lm.
    pub fn luminous_flux_lm(&self) -> f64 {
        match *self {
            RoomSource::Point { intensity_cd, .. } => 4.0 * PI * intensity_cd,
            RoomSource::Panel { low, high, exitance_lm_m2, .. } => {
                exitance_lm_m2 * (high[0] - low[0]) * (high[1] - low[1])
            }
        }
    }

    /// Illuminance in lx at a point with a unit normal.
    pub fn at_point_lx(&self, size_m: [f64; 3], point: DVec3, normal: DVec3) -> f64 {
        match *self {
            RoomSource::Point { position, intensity_cd } => {
                let to = position - point;
                intensity_cd * normal.dot(to).max(0.0) / to.length().powi(3)
            }
            RoomSource::Panel { face, low, high, exitance_lm_m2 } => {
                let corners = face.corners(size_m, [[low[0], high[0]], [low[1], high[1]]]);
                polygon_illuminance_lx(point, normal, &corners, exitance_lm_m2)
            }
        }
    }

    /// Mean illuminance in lx over a triangle of a face: exact for a point, by quadrature for a panel.
    pub fn triangle_mean_lx(&self, size_m: [f64; 3], face: RoomFace, corners: [DVec3; 3], area_m2: f64) -> f64 {
        match *self {
            RoomSource::Point { position, intensity_cd } => {
                let [a, b, c] = corners.map(|corner| corner - position);
                intensity_cd * triangle_solid_angle_sr(a, b, c) / area_m2
            }
            RoomSource::Panel { face: own, .. } if own == face => 0.0,
            RoomSource::Panel { .. } => {
                let at = |[along, across]: [f64; 2]| {
                    let across_edge = corners[1] + (corners[2] - corners[1]) * across;
                    self.at_point_lx(size_m, corners[0] + (across_edge - corners[0]) * along, face.normal())
                };
                triangle_rule().iter().map(|(place, weight)| weight * at(*place)).sum()
            }
        }
    }

    /// Mean illuminance in lx over a rectangle of a face; exact.
    pub fn rectangle_mean_lx(&self, size_m: [f64; 3], face: RoomFace, stretches: [[f64; 2]; 2]) -> f64 {
        let rectangle = face.rectangle(size_m, stretches);
        match *self {
            RoomSource::Point { .. } => {
                let [[u0, u1], [v0, v1]] = stretches;
                let at = |u: f64, v: f64| face.position(size_m, [u, v]);
                let half = 0.5 * rectangle.area_m2();
                let first = self.triangle_mean_lx(size_m, face, [at(u0, v0), at(u1, v0), at(u1, v1)], half);
                let second = self.triangle_mean_lx(size_m, face, [at(u0, v0), at(u1, v1), at(u0, v1)], half);
                0.5 * (first + second)
            }
            RoomSource::Panel { face: own, .. } if own == face => 0.0,
            RoomSource::Panel { face: own, low, high, exitance_lm_m2 } => {
                let panel = own.rectangle(size_m, [[low[0], high[0]], [low[1], high[1]]]);
                exitance_lm_m2 * exchange_m2(&panel, &rectangle) / rectangle.area_m2()
            }
        }
    }
}
