//! A glossy BSDF for any lobe: a diffuse part, a lobe over max(cos θ_i, cos θ_o), and the lobe's losses, given back by [`Lossless`]. The
//! reflectance is ρ_d + ρ_s at every angle.

use std::f64::consts::FRAC_1_PI;

use glam::DVec3;

use super::lossless::Lossless;
use super::{LobeKind, Pair, Reflection, Scattered};
use crate::sampling::random::Stream;
use crate::sampling::warp::cosine_hemisphere;

/// A lobe that reflects all light that arrives along the normal, except for what falls below the horizon. It is the only difference between
/// glossy BSDFs.
pub trait Lobe {
    /// Returns its width in rad about its axis, which must be as steep as the mirror direction: about its standard deviation across and
    /// along.
    fn width_rad(&self) -> f64;

    /// Returns cosine and sine of the angle from the mirror direction beyond which the share exp(−y²) of its flux goes.
    fn angle_at(&self, y: f64) -> [f64; 2];

    /// Draws a direction of the lobe for light that arrives along `direction`, without the rejection by cos θ_o/max(cos θ_i, cos θ_o).
    fn draw(&self, direction: DVec3, normal: DVec3, stream: &mut Stream) -> DVec3;

    /// Returns its BRDF per sr, with max(cos θ_i, cos θ_o) in the denominator. Both directions are above the surface.
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
    /// Makes the BSDF and tabulates the lobe's losses.
    pub fn new(diffuse_reflectance: f64, specular_reflectance: f64, lobe: L) -> Glossy<L> {
        let table = Lossless::new(lobe.width_rad(), |y| lobe.angle_at(y));
        Glossy { diffuse_reflectance, specular_reflectance, lobe, table }
    }

    /// Draws how light leaves by the lobe. The lobe is drawn as a whole and rejected by cos θ_o/max(cos θ_i, cos θ_o). The share that
    /// remains is exactly R(θ_i). Rejected draws go to the second term.
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

    fn lobe_width_rad(&self) -> Option<f64> {
        Some(self.lobe.width_rad())
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

    /// The diffuse part plus the term that compensates the lobe's losses.
    fn spread_per_sr(&self, pair: &Pair) -> f64 {
        let (cos_in, cos_out) = (pair.cos_in(), pair.cos_out());
        if cos_in <= 0.0 || cos_out <= 0.0 {
            return 0.0;
        }
        FRAC_1_PI * (self.diffuse_reflectance + self.specular_reflectance * self.table.rest(cos_in, cos_out))
    }
}
