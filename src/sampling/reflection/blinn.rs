//! Blinn's lobe around the half vector, made reciprocal and lossless (docs/methods.md (45)).
//!
//! The half vector h bisects both directions. θ_h is the angle between h and the normal, θ_ih the angle between h and either direction. The
//! lobe is (n + 1)/(8π) cosⁿθ_h / (cos θ_ih max(cos θ_i, cos θ_o)). It is reciprocal; its denominator is that of Ashikhmin and Shirley,
//! 2000, "An Anisotropic Phong BRDF Model". [`super::glossy::Glossy`] gives its losses back. At grazing incidence the lobe is narrower
//! across the plane of incidence than Phong's, as on real gloss.

use std::f64::consts::TAU;

use glam::DVec3;

use super::glossy::Lobe;
use super::lossless::{draw_power_of_cosine, power_of_cosine_angle};
use super::{Pair, mirrored};
use crate::sampling::random::Stream;

/// The lobe with an exponent of 0 or more.
#[derive(Clone, Debug)]
pub struct Blinn {
    pub exponent: f64,
}

impl Lobe for Blinn {
    fn width_rad(&self) -> f64 {
        2.0 / (self.exponent + 4.0).sqrt()
    }

    /// For the share of light above the surface, the light may be taken to leave at 2 θ_h from the mirror direction, uniformly around it.
    /// cos θ_o then has the same distribution.
    fn angle_at(&self, y: f64) -> [f64; 2] {
        let [cos_half, sin_half] = power_of_cosine_angle(self.exponent, y);
        [1.0 - 2.0 * sin_half * sin_half, 2.0 * sin_half * cos_half]
    }

    /// The half vector is drawn around the normal.
    fn draw(&self, direction: DVec3, normal: DVec3, stream: &mut Stream) -> DVec3 {
        mirrored(direction, draw_power_of_cosine(self.exponent, normal, stream.pair()))
    }

    fn per_sr(&self, pair: &Pair) -> f64 {
        let (cos_in, cos_out) = (pair.cos_in(), pair.cos_out());
        // |ω_i + ω_o| is twice the cosine between half vector and either direction.
        let twice_cos = (pair.towards + pair.leaving).length();
        let cos_half = (cos_in + cos_out) / twice_cos;
        (self.exponent + 1.0) / (2.0 * TAU) * cos_half.min(1.0).powf(self.exponent) / (twice_cos * cos_in.max(cos_out))
    }
}
