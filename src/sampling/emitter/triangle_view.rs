//! An emitting triangle as seen from one point.

use super::{LightSample, Place};
use crate::sampling::random::Stream;
use crate::sampling::triangle::RisenTriangle;
use crate::scene::Side;

/// A side of a triangle as seen from one point, prepared for any number of light samples.
#[derive(Clone, Copy, Debug)]
pub(super) struct TriangleView {
    /// Triangle of the scene.
    pub triangle: u32,
    /// Emitting side.
    pub side: Side,
    /// Illuminance in lx if nothing stands between.
    pub unshadowed_lx: f64,
    /// The part of it above the horizon.
    pub risen: Option<RisenTriangle>,
}

impl TriangleView {
    /// See [`super::Emitter::light_sample`].
    pub fn light_sample(&self, stream: &mut Stream) -> Option<LightSample> {
        if self.unshadowed_lx <= 0.0 {
            return None;
        }
        let drawn = self.risen.as_ref().and_then(|risen| risen.draw(stream));
        let place = drawn.map(|(_, barycentric)| place_on(self.triangle, self.side, barycentric));
        Some(LightSample { unshadowed_lx: self.unshadowed_lx, place })
    }
}

/// Returns a `Place` on a side of a triangle. The barycentric coordinates refer to the corners in the order in which that side sees them.
pub(super) fn place_on(triangle: u32, side: Side, [u, v]: [f64; 2]) -> Place {
    let barycentric = if side == Side::Front { [u, v] } else { [v, u] };
    Place::Surface { triangle, barycentric, side }
}
