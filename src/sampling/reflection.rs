//! Reflection laws: how a packet that arrives at a surface leaves it.

use glam::DVec3;

use super::random::Stream;
use super::warp::{cosine_hemisphere, cosine_hemisphere_pdf_per_sr};
use crate::scene::ReflectionLaw;

/// Draws whether a packet survives, and if so its new direction about the unit normal of the side it met.
///
/// Survival is analogue: its probability is the reflectance, so that a survivor carries all of its flux on.
#[inline]
pub fn sample(law: &ReflectionLaw, normal: DVec3, stream: &mut Stream) -> Option<DVec3> {
    match law {
        ReflectionLaw::Diffuse { reflectance } => {
            (stream.unit() < *reflectance).then(|| cosine_hemisphere(normal, stream.pair()))
        }
    }
}

/// Density of the directions that [`sample`] gives to survivors, per sr.
pub fn pdf_per_sr(law: &ReflectionLaw, cos_leaving: f64) -> f64 {
    match law {
        ReflectionLaw::Diffuse { .. } => cosine_hemisphere_pdf_per_sr(cos_leaving),
    }
}

/// Luminance that leaves for each lx that arrives, in cd/m² per lx (the BRDF, per sr).
pub fn eval_per_sr(law: &ReflectionLaw) -> f64 {
    match law {
        ReflectionLaw::Diffuse { reflectance } => reflectance / std::f64::consts::PI,
    }
}

/// Hemispherical reflectance, 0 to 1.
#[inline]
pub fn total(law: &ReflectionLaw) -> f64 {
    match law {
        ReflectionLaw::Diffuse { reflectance } => *reflectance,
    }
}
