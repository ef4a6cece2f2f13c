//! What lights a room, and its direct light.

use std::f64::consts::PI;

use glam::DVec3;

use super::faces::{RoomFace, triangle_rule};
use crate::analytic::error::{AnalyticError, require, require_light};
use crate::base::form_factors::{AxisRectangle, exchange_m2};
use crate::base::polygon::polygon_illuminance_lx;
use crate::base::solid_angle::triangle_solid_angle_sr;

/// A source in the room.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum RoomSource {
    /// An isotropic point.
    Point {
        /// Where it is, within the room, m.
        position: DVec3,
        /// Intensity in every direction, cd (flux over 4π).
        intensity_cd: f64,
    },
    /// A Lambertian rectangle flush with a face, whose reflectance it keeps.
    Panel {
        /// The face it lies on.
        face: RoomFace,
        /// Low corner along the other two axes, m.
        low: [f64; 2],
        /// High corner, m.
        high: [f64; 2],
        /// What it emits, lm/m².
        exitance_lm_m2: f64,
    },
}

impl RoomSource {
    /// Flux emitted, lm.
    pub fn luminous_flux_lm(&self) -> f64 {
        match *self {
            RoomSource::Point { intensity_cd, .. } => 4.0 * PI * intensity_cd,
            RoomSource::Panel { low, high, exitance_lm_m2, .. } => {
                exitance_lm_m2 * (high[0] - low[0]) * (high[1] - low[1])
            }
        }
    }

    pub(super) fn check(&self, size_m: [f64; 3]) -> Result<(), AnalyticError> {
        let remedy = "put the source into the room";
        match *self {
            RoomSource::Point { position, intensity_cd } => {
                require_light("the source's intensity", intensity_cd)?;
                for (axis, length) in size_m.into_iter().enumerate() {
                    let within = position[axis] > 0.0 && position[axis] < length;
                    require(within, "a coordinate of the source", position[axis], &format!("0 to {length} m"), remedy)?;
                }
            }
            RoomSource::Panel { face, low, high, exitance_lm_m2 } => {
                require_light("the panel's exitance", exitance_lm_m2)?;
                for (i, axis) in face.other_axes().into_iter().enumerate() {
                    let length = size_m[axis];
                    let expected = format!("0 to {length} m, rising");
                    require(low[i] >= 0.0 && low[i] < high[i], "the panel's low edge", low[i], &expected, remedy)?;
                    require(high[i] <= length, "the panel's high edge", high[i], &expected, remedy)?;
                }
            }
        }
        Ok(())
    }

    /// Illuminance at a point with a unit normal.
    pub(super) fn at_point_lx(&self, size_m: [f64; 3], point: DVec3, normal: DVec3) -> f64 {
        match *self {
            RoomSource::Point { position, intensity_cd } => {
                let to = position - point;
                intensity_cd * normal.dot(to).max(0.0) / to.length().powi(3)
            }
            RoomSource::Panel { face, low, high, exitance_lm_m2 } => {
                let corner = |u: f64, v: f64| face.position(size_m, [u, v]);
                let mut corners = [
                    corner(low[0], low[1]),
                    corner(high[0], low[1]),
                    corner(high[0], high[1]),
                    corner(low[0], high[1]),
                ];
                let turn = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
                if turn.dot(face.normal()) < 0.0 {
                    corners.reverse();
                }
                polygon_illuminance_lx(point, normal, &corners, exitance_lm_m2)
            }
        }
    }

    /// Mean over a triangle of a face: exact for a point, by quadrature for a panel.
    pub(super) fn triangle_mean_lx(&self, size_m: [f64; 3], face: RoomFace, corners: [DVec3; 3], area_m2: f64) -> f64 {
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

    /// Mean over a rectangle of a face; exact.
    pub(super) fn rectangle_mean_lx(&self, size_m: [f64; 3], face: RoomFace, stretches: [[f64; 2]; 2]) -> f64 {
        let rectangle = on_face(size_m, face, stretches);
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
                let panel = on_face(size_m, own, [[low[0], high[0]], [low[1], high[1]]]);
                exitance_lm_m2 * exchange_m2(&panel, &rectangle) / rectangle.area_m2()
            }
        }
    }
}

/// A rectangle of a face, seen from within.
fn on_face(size_m: [f64; 3], face: RoomFace, stretches: [[f64; 2]; 2]) -> AxisRectangle {
    AxisRectangle { axis: face.axis(), at: face.at(size_m), faces_up: !face.is_high(), stretches }
}
