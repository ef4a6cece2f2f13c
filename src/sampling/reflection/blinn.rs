//! A diffuse part and Blinn's lobe about the half vector, made reciprocal and free of loss (docs/methods.md (45)).
//!
//! The half vector h bisects both directions. The lobe (n + 1)/(8π) cosⁿθ_h / (cos θ_ih max(cos θ_i, cos θ_o)), θ_h the angle
//! between h and the normal and θ_ih that between h and either direction, is reciprocal (its denominator is that of Ashikhmin and
//! Shirley, 2000, "An Anisotropic Phong BRDF Model"); what it loses comes back by [`Lossless`]. The reflectance is then ρ_d + ρ_s
//! at every angle. At grazing incidence the lobe is narrower across the plane of incidence than Phong's, as on real gloss.

use std::f64::consts::TAU;

use glam::DVec3;

use super::lossless::{GlossyBase, Lossless, draw_power_of_cosine, power_of_cosine_angle};
use super::{Pair, Reflection, Scattered, mirrored};
use crate::sampling::random::Stream;

/// The law with its table.
#[derive(Clone, Debug)]
pub struct Blinn {
    exponent: f64,
    gloss: GlossyBase,
}

impl Blinn {
    /// Tabulates the lobe's reflectance for an exponent of 0 or more.
    pub fn new(diffuse_reflectance: f64, specular_reflectance: f64, exponent: f64) -> Blinn {
        let width = 2.0 / (exponent + 4.0).sqrt();
        // As far as the share of light above the surface asks, light leaves at 2 θ_h from the mirror direction, evenly about it: cos θ_o has
        // the distribution that it would have then.
        let table = Lossless::new(width, |y| {
            let [cos_half, sin_half] = power_of_cosine_angle(exponent, y);
            [1.0 - 2.0 * sin_half * sin_half, 2.0 * sin_half * cos_half]
        });
        Blinn { exponent, gloss: GlossyBase { diffuse_reflectance, specular_reflectance, table } }
    }

    /// A direction of the lobe of light that arrives along another, not thinned yet.
    fn draw_lobe(&self, direction: DVec3, normal: DVec3, stream: &mut Stream) -> DVec3 {
        mirrored(direction, draw_power_of_cosine(self.exponent, normal, stream.pair()))
    }
}

impl Reflection for Blinn {
    /// The half vector is drawn about the normal.
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
        let (cos_in, cos_out) = (pair.cos_in(), pair.cos_out());
        if cos_in <= 0.0 || cos_out <= 0.0 {
            return 0.0;
        }
        // |ω_i + ω_o| is twice the cosine between half vector and either direction.
        let twice_cos = (pair.towards + pair.leaving).length();
        let cos_half = (cos_in + cos_out) / twice_cos;
        self.gloss.specular_reflectance * (self.exponent + 1.0) / (2.0 * TAU) * cos_half.min(1.0).powf(self.exponent)
            / (twice_cos * cos_in.max(cos_out))
    }

    fn spread_per_sr(&self, pair: &Pair) -> f64 {
        self.gloss.spread_per_sr(pair)
    }
}
