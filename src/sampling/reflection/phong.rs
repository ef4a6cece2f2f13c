//! Phong's lobe around the mirror direction, made reciprocal and lossless (docs/methods.md (13)).
//!
//! The lobe (n + 1)/(2π) cosⁿα / max(cos θ_i, cos θ_o) is reciprocal. [`super::glossy::Glossy`] gives its losses back.

use std::f64::consts::TAU;

use glam::DVec3;

use super::glossy::Lobe;
use super::lossless::{draw_power_of_cosine, power_of_cosine_angle};
use super::{Pair, mirrored};
use crate::sampling::random::Stream;

/// The lobe with an exponent of 0 or more.
#[derive(Clone, Debug)]
pub struct Phong {
    pub exponent: f64,
}

impl Lobe for Phong {
    fn width_rad(&self) -> f64 {
        1.0 / (self.exponent + 2.0).sqrt()
    }

    fn angle_at(&self, y: f64) -> [f64; 2] {
        power_of_cosine_angle(self.exponent, y)
    }

    fn draw(&self, direction: DVec3, normal: DVec3, stream: &mut Stream) -> DVec3 {
        draw_power_of_cosine(self.exponent, mirrored(direction, normal), stream.pair())
    }

    fn per_sr(&self, pair: &Pair) -> f64 {
        let (cos_alpha, cos) = (pair.cos_alpha(), pair.cos_in().max(pair.cos_out()));
        if cos_alpha <= 0.0 { 0.0 } else { (self.exponent + 1.0) / TAU * cos_alpha.powf(self.exponent) / cos }
    }
}
