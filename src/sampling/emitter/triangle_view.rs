//! A shining triangle as one place sees it.

use super::{LightSample, Place};
use crate::sampling::random::Stream;
use crate::sampling::triangle::RisenTriangle;
use crate::scene::Side;

/// A side of a triangle as one place sees it, made ready for any number of looks.
#[derive(Clone, Copy, Debug)]
pub(super) struct TriangleView {
    /// Triangle of the scene.
    pub triangle: u32,
    /// Emitting side.
    pub side: Side,
    /// Illuminance in lx if nothing stands between.
    pub unshadowed_lx: f64,
    /// What of it stands above the horizon.
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

/// A place on a side of a triangle by barycentric coordinates among its corners in the order in which that side sees them.
pub(super) fn place_on(triangle: u32, side: Side, [u, v]: [f64; 2]) -> Place {
    let barycentric = if side == Side::Front { [u, v] } else { [v, u] };
    Place::Surface { triangle, barycentric, side }
}
