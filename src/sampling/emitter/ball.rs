//! Luminous balls: the point that a receiver sees.

use glam::DVec3;

use super::Place;
use crate::sampling::random::Stream;
use crate::sampling::warp::uniform_cone;

/// Draws that thinning by the cosine may take; see [`crate::sampling::triangle`] for the reasoning.
const MOST_DRAWS: u32 = 2000;

/// Draws the point of a ball that a receiver looks at, in proportion to projected solid angle; `None` where the point is
/// within the ball or next to nothing of it is above the horizon.
pub(super) fn draw_ball(
    luminaire: u32,
    center_m: DVec3,
    radius_m: f64,
    point_m: DVec3,
    normal: DVec3,
    stream: &mut Stream,
) -> Option<Place> {
    let offset = center_m - point_m;
    let distance = offset.length();
    let direction = draw_in_cone(offset / distance, radius_m / distance, normal, stream)?;
    let along = direction.dot(offset);
    let miss_squared = (offset - along * direction).length_squared();
    let reach = along - (radius_m * radius_m - miss_squared).max(0.0).sqrt();
    Some(Place::Ball { luminaire, position_m: point_m + direction * reach })
}

/// Draws a direction of a cone about a unit axis by the sine of half its angle, in proportion to its cosine with a unit normal; `None`
/// where the cone is no cone or next to nothing of it is above the horizon.
pub(super) fn draw_in_cone(axis: DVec3, sin_max: f64, normal: DVec3, stream: &mut Stream) -> Option<DVec3> {
    if sin_max >= 1.0 {
        return None;
    }
    // 1 − cos without the cancellation that a far ball would bring.
    let one_minus_cos = sin_max * sin_max / (1.0 + (1.0 - sin_max * sin_max).sqrt());
    let largest = (axis.dot(normal).clamp(-1.0, 1.0).acos() - sin_max.asin()).max(0.0).cos();
    for _ in 0..MOST_DRAWS {
        let direction = uniform_cone(axis, one_minus_cos, stream.pair());
        if stream.unit() * largest < direction.dot(normal) {
            return Some(direction);
        }
    }
    None
}
