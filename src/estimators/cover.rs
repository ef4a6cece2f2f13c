//! Points that are covered: something lies on them, a partition on the floor say, or they lie inside of a solid.
//!
//! Along its normal such a point meets a surface at once, or all that it sees is the backs of one-sided surfaces. Its
//! illuminance is 0, and nobody sees it.

use glam::DVec3;

use crate::chain::Stage;
use crate::geometry::{Meeting, Origin};
use crate::sampling::random::Stream;
use crate::sampling::warp::cosine_hemisphere;

/// Rays of which all must meet backs: a point that sees them beside other things is not covered.
const RAYS: u64 = 12;
/// What lies on a point is at most so many times as far from it as positions are accurate.
const CLOSE: f64 = 10.0;
/// A ray that goes so many times as far has not met what lies on a point, but for one in ten thousand.
const FAR: f64 = 100.0;

/// Whether a point with a unit normal is covered, and the rays that it took to tell.
pub fn is_covered(stage: &Stage, origin: &Origin, normal: DVec3, stream: &mut Stream) -> (bool, u64) {
    let close_m = CLOSE * stage.tracer.position_accuracy_m();
    let first_hit = |stream: &mut Stream| stage.tracer.first_hit(origin, cosine_hemisphere(normal, stream.pair()));
    let meets_back = |met: &Meeting| matches!(met, Meeting::Surface(hit) if !stage.receives(hit.triangle, hit.side));
    let met = first_hit(stream);
    let is_near = matches!(met, Meeting::Surface(hit) if hit.distance_m < FAR * close_m);
    if !is_near && !meets_back(&met) {
        return (false, 1);
    }
    if matches!(stage.tracer.first_hit(origin, normal), Meeting::Surface(hit) if hit.distance_m < close_m) {
        return (true, 2);
    }
    if !meets_back(&met) {
        return (false, 2);
    }
    for ray in 2..=RAYS {
        if !meets_back(&first_hit(stream)) {
            return (false, 1 + ray);
        }
    }
    (true, 1 + RAYS)
}
