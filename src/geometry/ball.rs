//! Balls, which rays meet exactly, without a mesh.

use glam::DVec3;

use super::origin::{Anchor, BEFORE, Origin};
use super::triangle::Ray;

/// A ball in the tracer's coordinates.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ball {
    pub center: DVec3,
    pub radius: f64,
    pub luminaire: u32,
}

/// Returns the distance to a ball along a ray in units of the ray's direction, if the ray meets it; 0 from inside.
#[cold]
pub(super) fn meet_ball(ray: &Ray, origin: &Origin, ball: &Ball) -> Option<f32> {
    let along = ray.direction.as_dvec3();
    if let Anchor::Ball { luminaire } = origin.anchor
        && luminaire == ball.luminaire
    {
        return (along.dot(origin.normal.as_dvec3()) < 0.0).then_some(0.0);
    }
    let towards = ball.center - ray.origin.as_dvec3();
    let square = along.length_squared();
    let middle = towards.dot(along) / square;
    // The distance of the line from the centre, without the cancellation in b² − ac.
    let half_chord_squared = ball.radius * ball.radius - (towards - middle * along).length_squared();
    if half_chord_squared < 0.0 {
        return None;
    }
    let half_chord = (half_chord_squared / square).sqrt();
    (middle + half_chord >= 0.0).then(|| (middle - half_chord).max(0.0) as f32)
}

/// Whether a ball stands between two origins.
#[cold]
pub(super) fn ball_parts(ray: &Ray, from: &Origin, to: &Origin, ball: &Ball) -> bool {
    if let Anchor::Ball { luminaire } = to.anchor
        && luminaire == ball.luminaire
    {
        return ray.direction.as_dvec3().dot(to.normal.as_dvec3()) > 0.0;
    }
    meet_ball(ray, from, ball).is_some_and(|t| t < 1.0 + BEFORE)
}
