//! A diffuse part and Phong's lobe about the mirror direction, made reciprocal and free of loss (docs/methods.md (13)).
//!
//! The lobe (n + 1)/(2π) cosⁿα / max(cos θ_i, cos θ_o) is reciprocal; what it loses comes back by [`Lossless`]. The reflectance is
//! then ρ_d + ρ_s at every angle.

use std::f64::consts::TAU;

use glam::DVec3;

use super::lossless::{GlossyBase, Lossless, draw_power_of_cosine, power_of_cosine_angle};
use super::{Pair, Reflection, Scattered, mirrored};
use crate::sampling::random::Stream;

/// The law with its table.
#[derive(Clone, Debug)]
pub struct Phong {
    exponent: f64,
    gloss: GlossyBase,
}

impl Phong {
    /// Tabulates the lobe's reflectance for an exponent of 0 or more.
    pub fn new(diffuse_reflectance: f64, specular_reflectance: f64, exponent: f64) -> Phong {
        let width = 1.0 / (exponent + 2.0).sqrt();
        let table = Lossless::new(width, |y| power_of_cosine_angle(exponent, y));
        Phong { exponent, gloss: GlossyBase { diffuse_reflectance, specular_reflectance, table } }
    }

    /// A direction of the lobe of light that arrives along another, not thinned yet.
    fn draw_lobe(&self, direction: DVec3, normal: DVec3, stream: &mut Stream) -> DVec3 {
        draw_power_of_cosine(self.exponent, mirrored(direction, normal), stream.pair())
    }
}

impl Reflection for Phong {
    /// The lobe is drawn about the mirror direction.
    fn sample(&self, direction: DVec3, normal: DVec3, stream: &mut Stream) -> Option<Scattered> {
        self.gloss.sample(direction, normal, stream, |stream| self.draw_lobe(direction, normal, stream))
    }

    fn diffuse_part(&self) -> f64 {
        self.gloss.diffuse_reflectance
    }

    fn sample_gloss(&self, direction: DVec3, normal: DVec3, stream: &mut Stream) -> Option<Scattered> {
        Some(self.gloss.sample_gloss(direction, normal, stream, |stream| self.draw_lobe(direction, normal, stream)))
    }

    fn pdf_per_sr(&self, pair: &Pair) -> f64 {
        self.eval_per_sr(pair) * pair.cos_out().max(0.0) / self.total(1.0)
    }

    #[inline]
    fn total(&self, _: f64) -> f64 {
        self.gloss.total()
    }

    fn lobe_per_sr(&self, pair: &Pair) -> f64 {
        let (cos_in, cos_out, cos_alpha) = (pair.cos_in(), pair.cos_out(), pair.cos_alpha());
        if cos_in <= 0.0 || cos_out <= 0.0 || cos_alpha <= 0.0 {
            return 0.0;
        }
        self.gloss.specular_reflectance * (self.exponent + 1.0) / TAU * cos_alpha.powf(self.exponent)
            / cos_in.max(cos_out)
    }

    fn spread_per_sr(&self, pair: &Pair) -> f64 {
        self.gloss.spread_per_sr(pair)
    }
}
