//! A diffuse part and Blinn's lobe about the half vector, made reciprocal and free of loss (docs/methods.md, section 9).
//!
//! The half vector h bisects both directions. The lobe (n + 1)/(8π) cosⁿθ_h / (cos θ_ih max(cos θ_i, cos θ_o)), θ_h the angle
//! between h and the normal and θ_ih that between h and either direction, is reciprocal (its denominator is that of Ashikhmin and
//! Shirley, 2000, "An Anisotropic Phong BRDF Model"); what it loses comes back by [`Lossless`]. The reflectance is then ρ_d + ρ_s
//! at every angle. At grazing incidence the lobe is narrower across the plane of incidence than Phong's, as on real gloss.

use std::f64::consts::{FRAC_1_PI, TAU};

use glam::DVec3;

use super::lossless::{Lossless, draw_power_of_cosine, power_of_cosine_angle};
use super::{Pair, Reflection, Scattered, Way, mirrored};
use crate::sampling::random::Stream;
use crate::sampling::warp::cosine_hemisphere;

/// The law with its table.
#[derive(Clone, Debug)]
pub struct Blinn {
    diffuse_reflectance: f64,
    specular_reflectance: f64,
    exponent: f64,
    table: Lossless,
}

impl Blinn {
    /// Tabulates the lobe's reflectance for an exponent of 0 or more.
    pub fn new(diffuse_reflectance: f64, specular_reflectance: f64, exponent: f64) -> Blinn {
        let width = 2.0 / (exponent + 4.0).sqrt();
        // Light leaves at 2 θ_h from the mirror direction, evenly about it: as in Phong's lobe, with another angle.
        let table = Lossless::new(width, |y| {
            let [cos_half, sin_half] = power_of_cosine_angle(exponent, y);
            [1.0 - 2.0 * sin_half * sin_half, 2.0 * sin_half * cos_half]
        });
        Blinn { diffuse_reflectance, specular_reflectance, exponent, table }
    }
}

impl Reflection for Blinn {
    /// The half vector is drawn about the normal, and what it mirrors thinned by cos θ_o/max(cos θ_i, cos θ_o): the share that
    /// remains is R(θ_i) exactly. What falls out goes to the second term.
    fn sample(&self, direction: DVec3, normal: DVec3, stream: &mut Stream) -> Option<Scattered> {
        let choice = stream.unit();
        if choice < self.diffuse_reflectance {
            return Some(Scattered { direction: cosine_hemisphere(normal, stream.pair()), way: Way::Spread });
        }
        if choice >= self.total(1.0) {
            return None;
        }
        let half = draw_power_of_cosine(self.exponent, normal, stream.pair());
        let leaving = mirrored(direction, half);
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
        let (cos_in, cos_out) = (pair.cos_in(), pair.cos_out());
        if cos_in <= 0.0 || cos_out <= 0.0 {
            return 0.0;
        }
        // |ω_i + ω_o| is twice the cosine between half vector and either direction.
        let twice_cos = (pair.towards + pair.leaving).length();
        let cos_half = (cos_in + cos_out) / twice_cos;
        self.specular_reflectance * (self.exponent + 1.0) / (2.0 * TAU) * cos_half.min(1.0).powf(self.exponent)
            / (twice_cos * cos_in.max(cos_out))
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
