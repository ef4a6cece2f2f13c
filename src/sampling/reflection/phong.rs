//! A diffuse part and Phong's lobe about the mirror direction, made reciprocal and free of loss (docs/methods.md (13)).
//!
//! The lobe (n + 1)/(2π) cosⁿα / max(cos θ_i, cos θ_o) is reciprocal; what it loses comes back by [`Lossless`]. The reflectance is
//! then ρ_d + ρ_s at every angle.

use std::f64::consts::{FRAC_1_PI, TAU};

use glam::DVec3;

use super::lossless::{Lossless, draw_power_of_cosine, power_of_cosine_angle};
use super::{Pair, Reflection, Scattered, Way, mirrored};
use crate::sampling::random::Stream;
use crate::sampling::warp::cosine_hemisphere;

/// The law with its table.
#[derive(Clone, Debug)]
pub struct Phong {
    diffuse_reflectance: f64,
    specular_reflectance: f64,
    exponent: f64,
    table: Lossless,
}

impl Phong {
    /// Tabulates the lobe's reflectance for an exponent of 0 or more.
    pub fn new(diffuse_reflectance: f64, specular_reflectance: f64, exponent: f64) -> Phong {
        let width = 1.0 / (exponent + 2.0).sqrt();
        let table = Lossless::new(width, |y| power_of_cosine_angle(exponent, y));
        Phong { diffuse_reflectance, specular_reflectance, exponent, table }
    }
}

impl Reflection for Phong {
    /// The lobe is drawn about the mirror direction, all of it, and thinned by cos θ_o/max(cos θ_i, cos θ_o): the
    /// share that remains is R(θ_i) exactly. What falls out goes to the second term.
    fn sample(&self, direction: DVec3, normal: DVec3, stream: &mut Stream) -> Option<Scattered> {
        let choice = stream.unit();
        if choice < self.diffuse_reflectance {
            return Some(Scattered { direction: cosine_hemisphere(normal, stream.pair()), way: Way::Spread });
        }
        if choice >= self.total(1.0) {
            return None;
        }
        let leaving = draw_power_of_cosine(self.exponent, mirrored(direction, normal), stream.pair());
        let (cos_in, cos_out) = (-direction.dot(normal), leaving.dot(normal));
        if cos_out > 0.0 && stream.unit() * cos_in < cos_out {
            return Some(Scattered { direction: leaving, way: Way::Lobe });
        }
        Some(Scattered { direction: self.table.draw_rest(normal, stream), way: Way::Spread })
    }

    fn pdf_per_sr(&self, pair: &Pair) -> f64 {
        self.eval_per_sr(pair) * pair.cos_out().max(0.0) / self.total(1.0)
    }

    #[inline]
    fn total(&self, _: f64) -> f64 {
        self.diffuse_reflectance + self.specular_reflectance
    }

    fn lobe_per_sr(&self, pair: &Pair) -> f64 {
        let (cos_in, cos_out, cos_alpha) = (pair.cos_in(), pair.cos_out(), pair.cos_alpha());
        if cos_in <= 0.0 || cos_out <= 0.0 || cos_alpha <= 0.0 {
            return 0.0;
        }
        self.specular_reflectance * (self.exponent + 1.0) / TAU * cos_alpha.powf(self.exponent) / cos_in.max(cos_out)
    }

    /// The diffuse part, and what makes up for the light that the lobe loses.
    fn spread_per_sr(&self, pair: &Pair) -> f64 {
        let (cos_in, cos_out) = (pair.cos_in(), pair.cos_out());
        if cos_in <= 0.0 || cos_out <= 0.0 {
            return 0.0;
        }
        FRAC_1_PI * (self.diffuse_reflectance + self.specular_reflectance * self.table.rest(cos_in, cos_out))
    }
}
