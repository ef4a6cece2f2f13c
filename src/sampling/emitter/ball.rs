//! Luminous balls.

use std::f64::consts::{PI, TAU};
use std::sync::Arc;

use glam::DVec3;

use super::light::{Light, SeenPart};
use super::{Emitted, LightSample, Place};
use crate::base::ball::ball_illuminance_factor;
use crate::sampling::importance::{Beacon, Profile};
use crate::sampling::random::Stream;
use crate::sampling::triangle::MOST_DRAWS;
use crate::sampling::warp::{cosine_hemisphere, uniform_cone, uniform_sphere};

/// A uniformly bright ball that is black and opaque.
#[derive(Clone, Debug)]
pub(super) struct BallLight {
    /// Its luminaire.
    pub luminaire: u32,
    pub center_m: DVec3,
    pub radius_m: f64,
    pub exitance_lm_m2: f64,
}

impl BallLight {
    fn place(&self, position_m: DVec3) -> Place {
        Place::Ball { luminaire: self.luminaire, position_m }
    }

    /// Draws the point for a light sample in proportion to projected solid angle. `None` where the receiver is inside the ball or almost
    /// nothing of the ball is above the horizon.
    fn draw_seen(&self, point_m: DVec3, normal: DVec3, stream: &mut Stream) -> Option<Place> {
        let offset = self.center_m - point_m;
        let distance = offset.length();
        let direction = draw_in_cone(offset / distance, self.radius_m / distance, normal, stream)?;
        Some(self.place(point_m + direction * self.met_at_m(point_m, direction)))
    }

    /// Returns the distance at which a line meets the ball. The line must meet it.
    fn met_at_m(&self, from_m: DVec3, direction: DVec3) -> f64 {
        let offset_m = self.center_m - from_m;
        let along_m = direction.dot(offset_m);
        let miss_squared = (offset_m - along_m * direction).length_squared();
        along_m - (self.radius_m * self.radius_m - miss_squared).max(0.0).sqrt()
    }
}

impl Light for BallLight {
    fn beacon(&self) -> Beacon {
        Beacon {
            center_m: self.center_m,
            radius_m: self.radius_m,
            axis: DVec3::Z,
            intensity_cd: self.exitance_lm_m2 * self.radius_m * self.radius_m,
            profile: Profile::Uniform,
            parts: Arc::default(),
        }
    }

    fn emit(&self, stream: &mut Stream) -> Emitted {
        let outward = uniform_sphere(stream.pair());
        let place = self.place(self.center_m + outward * self.radius_m);
        Emitted::new(place, cosine_hemisphere(outward, stream.pair()))
    }

    fn unshadowed_lx(&self, point_m: DVec3, normal: DVec3) -> f64 {
        let offset = self.center_m - point_m;
        let distance = offset.length();
        self.exitance_lm_m2 * ball_illuminance_factor(offset.dot(normal) / distance, distance / self.radius_m)
    }

    fn light_sample(&self, point_m: DVec3, normal: DVec3, stream: &mut Stream) -> Option<LightSample> {
        let unshadowed_lx = self.unshadowed_lx(point_m, normal);
        if unshadowed_lx <= 0.0 {
            return None;
        }
        Some(LightSample { unshadowed_lx, place: self.draw_seen(point_m, normal, stream) })
    }

    fn seen_from_afar(&self, direction: DVec3, stream: &mut Stream) -> Option<(f64, Place)> {
        // Points of a hemisphere drawn by the cosine are uniform on the disk that is seen from afar.
        let outward = cosine_hemisphere(direction, stream.pair());
        let place = self.place(self.center_m + outward * self.radius_m);
        Some((self.exitance_lm_m2 * self.radius_m * self.radius_m, place))
    }

    fn point_seen_from(&self, place_m: DVec3, variates: [f64; 2]) -> Option<Place> {
        let offset_m = self.center_m - place_m;
        let sine = self.radius_m / offset_m.length();
        if sine >= 1.0 {
            return None;
        }
        let direction = uniform_cone(offset_m.normalize(), one_minus_cos(sine), variates);
        Some(self.place(place_m + direction * self.met_at_m(place_m, direction)))
    }

    fn show_parts(&self, eye_m: DVec3, stream: &mut Stream, show: &mut dyn FnMut(SeenPart)) {
        let offset_m = self.center_m - eye_m;
        let distance_m = offset_m.length();
        if distance_m <= self.radius_m {
            return;
        }
        let one_minus_cos = one_minus_cos(self.radius_m / distance_m);
        let towards = offset_m / distance_m;
        let direction = uniform_cone(towards, one_minus_cos, stream.pair());
        let luminance = self.exitance_lm_m2 / PI;
        show(SeenPart {
            towards,
            squared_luminance_sr: luminance * luminance * TAU * one_minus_cos,
            place: self.place(eye_m + direction * self.met_at_m(eye_m, direction)),
        });
    }

    fn exitance_lm_m2(&self) -> Option<f64> {
        Some(self.exitance_lm_m2)
    }

    fn ball_at_m(&self, eye_m: DVec3, direction: DVec3) -> Option<f64> {
        Some(self.met_at_m(eye_m, direction))
    }
}

/// Returns 1 − cos of an angle from its sine, without the cancellation for a far ball.
fn one_minus_cos(sine: f64) -> f64 {
    sine * sine / (1.0 + (1.0 - sine * sine).sqrt())
}

/// Draws a direction in a cone, in proportion to its cosine with a unit normal. The cone has a unit axis and the sine of its half angle.
/// `None` where the sine is 1 or more, or where almost nothing of the cone is above the horizon.
pub(super) fn draw_in_cone(axis: DVec3, sin_max: f64, normal: DVec3, stream: &mut Stream) -> Option<DVec3> {
    if sin_max >= 1.0 {
        return None;
    }
    let one_minus_cos = one_minus_cos(sin_max);
    let largest = (axis.dot(normal).clamp(-1.0, 1.0).acos() - sin_max.asin()).max(0.0).cos();
    for _ in 0..MOST_DRAWS {
        let direction = uniform_cone(axis, one_minus_cos, stream.pair());
        if stream.unit() * largest < direction.dot(normal) {
            return Some(direction);
        }
    }
    None
}
