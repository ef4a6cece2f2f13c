//! A glossy BSDF but for its lobe: a diffuse part, a lobe over max(cos θ_i, cos θ_o), and what that loses, given back by [`Lossless`].
//! The reflectance is ρ_d + ρ_s at every angle.

use std::f64::consts::FRAC_1_PI;

use glam::DVec3;

use super::lossless::Lossless;
use super::{LobeKind, Pair, Reflection, Scattered};
use crate::sampling::random::Stream;
use crate::sampling::warp::cosine_hemisphere;

/// A lobe that reflects all light which arrives along the normal, but for what falls below the horizon: all that makes one glossy BSDF differ
/// from another.
pub trait Lobe {
    /// Its width, about its standard deviation across and along in rad.
    fn width(&self) -> f64;

    /// Cosine and sine of the angle from the mirror direction beyond which exp(−y²) of its flux goes.
    fn angle_at(&self, y: f64) -> [f64; 2];

    /// A direction of it, of light that arrives along another, not thinned by cos θ_o/max(cos θ_i, cos θ_o) yet.
    fn draw(&self, direction: DVec3, normal: DVec3, stream: &mut Stream) -> DVec3;

    /// Its BRDF per sr, with max(cos θ_i, cos θ_o) in the denominator; both directions are above the surface.
    fn per_sr(&self, pair: &Pair) -> f64;
}

/// A glossy BSDF with its table.
#[derive(Clone, Debug)]
pub struct Glossy<L> {
    diffuse_reflectance: f64,
    specular_reflectance: f64,
    lobe: L,
    table: Lossless,
}

impl<L: Lobe> Glossy<L> {
    /// Tabulates what the lobe loses.
    pub fn new(diffuse_reflectance: f64, specular_reflectance: f64, lobe: L) -> Glossy<L> {
        let table = Lossless::new(lobe.width(), |y| lobe.angle_at(y));
        Glossy { diffuse_reflectance, specular_reflectance, lobe, table }
    }

    /// Draws how light leaves by the lobe. It is drawn whole and thinned by cos θ_o/max(cos θ_i, cos θ_o): the share that remains is R(θ_i)
    /// exactly. What falls out goes to the second term.
    fn draw_gloss(&self, direction: DVec3, normal: DVec3, stream: &mut Stream) -> Scattered {
        let leaving = self.lobe.draw(direction, normal, stream);
        let (cos_in, cos_out) = (-direction.dot(normal), leaving.dot(normal));
        if cos_out > 0.0 && stream.unit() * cos_in < cos_out {
            return Scattered { direction: leaving, lobe: LobeKind::Glossy };
        }
        Scattered { direction: self.table.draw_rest(normal, stream), lobe: LobeKind::Spread }
    }
}

impl<L: Lobe> Reflection for Glossy<L> {
    fn sample(&self, direction: DVec3, normal: DVec3, stream: &mut Stream) -> Option<Scattered> {
        let choice = stream.unit();
        if choice < self.diffuse_reflectance {
            return Some(Scattered { direction: cosine_hemisphere(normal, stream.pair()), lobe: LobeKind::Spread });
        }
        (choice < self.total(1.0)).then(|| self.draw_gloss(direction, normal, stream))
    }

    fn diffuse_part(&self) -> f64 {
        self.diffuse_reflectance
    }

    fn sample_gloss(&self, direction: DVec3, normal: DVec3, stream: &mut Stream) -> Option<Scattered> {
        Some(self.draw_gloss(direction, normal, stream))
    }

    fn pdf_per_sr(&self, pair: &Pair) -> f64 {
        self.eval_per_sr(pair) * pair.cos_out().max(0.0) / self.total(1.0)
    }

    #[inline]
    fn total(&self, _: f64) -> f64 {
        self.diffuse_reflectance + self.specular_reflectance
    }

    fn lobe_per_sr(&self, pair: &Pair) -> f64 {
        let is_above = pair.cos_in() > 0.0 && pair.cos_out() > 0.0;
        if is_above { self.specular_reflectance * self.lobe.per_sr(pair) } else { 0.0 }
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
