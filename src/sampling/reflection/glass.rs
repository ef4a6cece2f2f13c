//! A thin pane: light is reflected as by a mirror, or passes straight through.

use super::{LobeKind, Reflection, Scattered, mirrored};
use crate::base::pane::glazed_shares;
use crate::sampling::random::Stream;
use glam::DVec3;

/// One sheet for both faces of a pane, by Fresnel's formulas with all inner reflections.
#[derive(Clone, Copy, Debug)]
pub struct Glass {
    /// Refractive index relative to air, 1 or more.
    pub refractive_index: f64,
    /// Transmittance of the glass itself at normal incidence, 0 to 1.
    pub internal_transmittance: f64,
    /// Share of the area that is glass, 0 to 1. The rest, the frame, is black.
    pub glazed_share: f64,
}

impl Glass {
    /// Returns reflectance and transmittance at an angle with this cosine.
    pub fn shares(&self, cos_in: f64) -> [f64; 2] {
        glazed_shares(self.glazed_share, self.refractive_index, self.internal_transmittance, cos_in.abs())
    }
}

impl Reflection for Glass {
    fn sample(&self, direction: DVec3, normal: DVec3, stream: &mut Stream) -> Option<Scattered> {
        let [reflectance, transmittance] = self.shares(direction.dot(normal));
        let choice = stream.unit();
        if choice < reflectance {
            return Some(Scattered { direction: mirrored(direction, normal), lobe: LobeKind::Mirrored });
        }
        (choice < reflectance + transmittance).then_some(Scattered { direction, lobe: LobeKind::Passed })
    }

    fn total(&self, cos_in: f64) -> f64 {
        let [reflectance, transmittance] = self.shares(cos_in);
        reflectance + transmittance
    }

    fn is_specular(&self) -> bool {
        true
    }

    fn mirror_share(&self, cos_in: f64) -> f64 {
        self.shares(cos_in)[0]
    }

    fn is_mirror(&self) -> bool {
        self.refractive_index > 1.0 && self.glazed_share > 0.0
    }
}
