//! Sobolev's two infinite planes as truth for finite rectangles.

use std::f64::consts::PI;

use serde::Deserialize;

use super::exact::{Exact, LightPart, TruthSite};
use crate::analytic::sobolev::{SobolevPlane, SobolevProblem, sobolev};

/// Sobolev's planes at z = 0 (plane 1) and z = distance (plane 2). The source is above the origin.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SobolevTruth {
    /// Height of the source above plane 1 divided by the planes' distance.
    pub h1: f64,
    /// Reflectance of plane 1.
    pub rho1: f64,
    /// Reflectance of plane 2.
    pub rho2: f64,
    /// Number of the compared plane: 1 or 2.
    pub plane: u8,
    /// Distance between the planes in m.
    #[serde(default = "one")]
    pub distance_m: f64,
    /// Intensity of the source in cd.
    #[serde(default = "one")]
    pub intensity_cd: f64,
    /// Half the width of the rectangles that approximate the infinite planes, in m.
    pub half_width_m: f64,
}

fn one() -> f64 {
    1.0
}

impl SobolevTruth {
    /// Source of the numbers, in words for a reader.
    pub fn in_words(&self) -> String {
        format!(
            "Sobolev's exact solution for infinite planes (relative error below 1e-12); the model's planes extend to {} times their distance in every direction",
            self.half_width_m / self.distance_m
        )
    }
}

pub(super) fn sobolev_truth(truth: &SobolevTruth, site: &TruthSite, light: LightPart) -> Result<Exact, String> {
    let TruthSite::Point { position_m, .. } = site else {
        return Err("Sobolev's solution can be compared only at points".to_owned());
    };
    let (plane, other) = match truth.plane {
        1 => (SobolevPlane::One, SobolevPlane::Two),
        2 => (SobolevPlane::Two, SobolevPlane::One),
        plane => return Err(format!("there is no plane {plane}: 1 or 2")),
    };
    let problem = SobolevProblem { h1: truth.h1, rho1: truth.rho1, rho2: truth.rho2 };
    let r = position_m.truncate().length() / truth.distance_m;
    let scale = truth.intensity_cd / (truth.distance_m * truth.distance_m);
    let at = |plane, r| sobolev(&problem, plane, r).map_err(|error| error.to_string());
    let value = at(plane, r)?;

    // Beyond the rim E falls like r⁻³ or faster. The opposite plane lacks there at most ρ E(W) ∫ K over distances from D = W − r
    // on, with K = 1/(π(1+d²)²) < 1/(π d⁴). Reflections between the planes add up to at most 1/(1 − ρ₁ρ₂) times that.
    let half_width = truth.half_width_m / truth.distance_m;
    let distance = half_width - r;
    if distance <= 0.0 {
        return Err("a point lies outside of the model's planes".to_owned());
    }
    let rho_other = if truth.plane == 1 { truth.rho2 } else { truth.rho1 };
    let rim = at(other, half_width)?.total_lx;
    let kernel = 1.0 / (distance * distance) + 2.0 * r / (3.0 * distance.powi(3));
    let truncation = rho_other * rim * kernel / (1.0 - truth.rho1 * truth.rho2);
    let (value_lx, truncation, uncertainty) = match light {
        LightPart::Direct => (value.direct_lx, 0.0, 0.0),
        LightPart::Indirect => (value.reflected_lx, truncation, value.estimated_error_lx),
        LightPart::Total => (value.total_lx, truncation, value.estimated_error_lx),
    };
    Ok(Exact {
        value: value_lx * scale,
        uncertainty: uncertainty * scale,
        truncation: truncation * scale,
        ..Exact::default()
    })
}

/// Luminance in cd/m² that an observer between the planes sees: ρE/π at the point of the compared plane in the line of sight, for
/// any angle.
pub(super) fn sobolev_luminance(truth: &SobolevTruth, site: &TruthSite, light: LightPart) -> Result<Exact, String> {
    let TruthSite::Point { position_m, normal, index } = *site else {
        return Err("luminances can be compared only at points".to_owned());
    };
    if light != LightPart::Total {
        return Err("the luminance of Sobolev's planes is known only for the total".to_owned());
    }
    let (height_m, rho) = if truth.plane == 1 { (0.0, truth.rho1) } else { (truth.distance_m, truth.rho2) };
    let reach_m = (height_m - position_m.z) / normal.z;
    if !(reach_m > 0.0 && reach_m.is_finite()) {
        return Err(format!("direction {index} does not look at plane {}", truth.plane));
    }
    let site = TruthSite::Point { position_m: position_m + reach_m * normal, normal, index };
    let exact = sobolev_truth(truth, &site, light)?;
    let share = rho / PI;
    Ok(Exact {
        value: share * exact.value,
        uncertainty: share * exact.uncertainty,
        truncation: share * exact.truncation,
        ..Exact::default()
    })
}
