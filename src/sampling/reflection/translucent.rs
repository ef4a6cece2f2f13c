//! A sheet that scatters to both sides: M_front = ρE_front + τE_back, and the reverse.

use std::f64::consts::PI;

use super::{Pair, Scattered, Way};
use crate::sampling::random::Stream;
use crate::sampling::warp::{cosine_hemisphere, cosine_hemisphere_pdf_per_sr};
use glam::DVec3;

/// Diffuse reflection and diffuse transmission.
#[derive(Clone, Copy, Debug)]
pub struct Translucent {
    /// Share that is reflected, 0 to 1.
    pub reflectance: f64,
    /// Share that is let through, 0 to 1.
    pub transmittance: f64,
}

impl Translucent {
    /// See [`super::Law::sample`].
    pub fn sample(&self, normal: DVec3, stream: &mut Stream) -> Option<Scattered> {
        let choice = stream.unit();
        if choice < self.reflectance {
            return Some(Scattered { direction: cosine_hemisphere(normal, stream.pair()), way: Way::Spread });
        }
        (choice < self.total())
            .then(|| Scattered { direction: cosine_hemisphere(-normal, stream.pair()), way: Way::SpreadThrough })
    }

    /// See [`super::Law::pdf_per_sr`].
    pub fn pdf_per_sr(&self, pair: &Pair) -> f64 {
        self.share_of_side(pair) / self.total() * cosine_hemisphere_pdf_per_sr(pair.cos_out().abs())
    }

    /// See [`super::Law::eval_per_sr`].
    pub fn eval_per_sr(&self, pair: &Pair) -> f64 {
        self.share_of_side(pair) / PI
    }

    /// See [`super::Law::total`].
    #[inline]
    pub fn total(&self) -> f64 {
        self.reflectance + self.transmittance
    }

    fn share_of_side(&self, pair: &Pair) -> f64 {
        if pair.cos_out() > 0.0 { self.reflectance } else { self.transmittance }
    }
}
