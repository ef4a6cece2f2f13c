//! Lambertian reflection.

use std::f64::consts::PI;

use super::{LobeKind, Pair, Reflection, Scattered};
use crate::sampling::random::Stream;
use crate::sampling::warp::{cosine_hemisphere, cosine_hemisphere_pdf_per_sr};
use glam::DVec3;

/// The same luminance ρE/π in every direction.
#[derive(Clone, Copy, Debug)]
pub struct Diffuse {
    /// Hemispherical reflectance, 0 to 1.
    pub reflectance: f64,
}

impl Diffuse {
    /// Draws how a surviving packet leaves the side with this normal.
    #[inline]
    pub fn spread(normal: DVec3, stream: &mut Stream) -> Scattered {
        Scattered { direction: cosine_hemisphere(normal, stream.pair()), lobe: LobeKind::Spread }
    }
}

impl Reflection for Diffuse {
    #[inline]
    fn sample(&self, _: DVec3, normal: DVec3, stream: &mut Stream) -> Option<Scattered> {
        stream.happens(self.reflectance).then(|| Diffuse::spread(normal, stream))
    }

    fn pdf_per_sr(&self, pair: &Pair) -> f64 {
        cosine_hemisphere_pdf_per_sr(pair.cos_out())
    }

    #[inline]
    fn spread_per_sr(&self, pair: &Pair) -> f64 {
        if pair.cos_out() > 0.0 { self.reflectance / PI } else { 0.0 }
    }

    #[inline]
    fn total(&self, _: f64) -> f64 {
        self.reflectance
    }
}
