//! A sheet that scatters to both sides: M_front = ρE_front + τE_back, and the reverse.

use std::f64::consts::PI;

use super::{LobeKind, Pair, Reflection, Scattered};
use crate::sampling::random::Stream;
use crate::sampling::warp::{cosine_hemisphere, cosine_hemisphere_pdf_per_sr};
use glam::DVec3;

/// Diffuse reflection and diffuse transmission.
#[derive(Clone, Copy, Debug)]
pub struct Translucent {
    /// Share that is reflected, 0 to 1.
    pub reflectance: f64,
    /// Share that is transmitted, 0 to 1.
    pub transmittance: f64,
}

impl Reflection for Translucent {
    fn sample(&self, _: DVec3, normal: DVec3, stream: &mut Stream) -> Option<Scattered> {
        let choice = stream.unit();
        if choice < self.reflectance {
            return Some(Scattered { direction: cosine_hemisphere(normal, stream.pair()), lobe: LobeKind::Spread });
        }
        (choice < self.total(1.0))
            .then(|| Scattered { direction: cosine_hemisphere(-normal, stream.pair()), lobe: LobeKind::SpreadThrough })
    }

    fn pdf_per_sr(&self, pair: &Pair) -> f64 {
        self.share_of_side(pair) / self.total(1.0) * cosine_hemisphere_pdf_per_sr(pair.cos_out().abs())
    }

    fn spread_per_sr(&self, pair: &Pair) -> f64 {
        self.share_of_side(pair) / PI
    }

    #[inline]
    fn total(&self, _: f64) -> f64 {
        self.reflectance + self.transmittance
    }
}

impl Translucent {
    fn share_of_side(&self, pair: &Pair) -> f64 {
        if pair.cos_out() > 0.0 { self.reflectance } else { self.transmittance }
    }
}
