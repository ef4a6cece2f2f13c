//! Sobolev's problem: a point source between two infinite parallel diffuse planes.
//!
//! κ(k) = k K₁(k) is the Hankel transform of the planes' kernel 1/(π(1+r²)²), and G(k) = ρ₂κ(ρ₁κe^{−h₁k} + e^{−h₂k})/(1 − ρ₁ρ₂κ²).
//! The reflected illuminance on plane 1 is ∫₀^∞ k G(k) J₀(kr) dk. Near the source it is integrated along the real axis. Farther
//! away the waves cancel there. The path is then turned towards the imaginary axis, where nothing cancels and the integral is
//! −(2/π) ∫ t K₀(tr) Im G(it) dt.
//!
//! Source: V. V. Sobolev, "On the illumination of two parallel planes", 1944.

mod contour;
#[cfg(test)]
mod tests;

use std::f64::consts::PI;

use num_complex::Complex;

use self::contour::{NODES, NOTHING_LEFT, Panel, PanelRule, PanelSum, TURN};
use super::error::{AnalyticError, require, require_reflectance};
use crate::base::special::{EULER_GAMMA, bessel_j0, bessel_k0, complex_bessel_k0_scaled, z_bessel_k1_and_deficit};

/// Two infinite parallel diffuse planes 1 m apart, with an isotropic point source of 1 cd between them.
///
/// For planes at distance h and a source of I cd, give h₁/h and r/h and multiply the illuminances by I/h².
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SobolevProblem {
    /// Height of the source above plane 1, between 0 and 1 (both excluded), m.
    pub h1: f64,
    /// Reflectance of plane 1, 0 to 1.
    pub rho1: f64,
    /// Reflectance of plane 2, 0 to 1; not both 1.
    pub rho2: f64,
}

/// The plane whose illuminance is computed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SobolevPlane {
    /// The plane at distance h₁ from the source.
    One,
    /// The plane at distance 1 − h₁ from the source.
    Two,
}

/// Illuminance on one of the planes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SobolevValue {
    /// Direct illuminance from the source, lx; accurate to rounding.
    pub direct_lx: f64,
    /// Illuminance after one or more reflections, lx.
    pub reflected_lx: f64,
    /// Sum of direct and reflected illuminance, lx.
    pub total_lx: f64,
    /// Estimated error of the reflected part, lx; an upper estimate.
    pub estimated_error_lx: f64,
}

/// Illuminance on one plane at distance `r` from the foot of the source.
///
/// Units: lx, for 1 cd and planes 1 m apart, r in m. Range: every finite r ≥ 0. Accuracy: the reflected part has a relative error
/// of 1e-12 for r ≤ 1e4, 1e-3 ≤ h₁ ≤ 1 − 1e-3 and reflectances up to 0.9999 (or 1 on one plane). The estimated error covers the
/// true error.
///
/// # Errors
/// h₁ outside (0, 1), a reflectance outside [0, 1], a negative or non-finite r, or reflectance 1 on both planes. In the last case
/// nothing absorbs and the illuminance is infinite.
///
/// ```
/// use luxmc::analytic::sobolev::{SobolevPlane, SobolevProblem, sobolev};
///
/// // 10,000 lm at 2 m above a floor under a 3 m ceiling, both reflecting half.
/// let problem = SobolevProblem { h1: 2.0 / 3.0, rho1: 0.5, rho2: 0.5 };
/// let below = sobolev(&problem, SobolevPlane::One, 0.0)?;
/// let scale = 10_000.0 / (4.0 * std::f64::consts::PI) / (3.0 * 3.0);
/// assert!((below.direct_lx * scale - 198.943679).abs() < 1e-6);
/// assert!((below.reflected_lx * scale - 56.536444).abs() < 1e-6);
/// # Ok::<(), luxmc::analytic::AnalyticError>(())
/// ```
pub fn sobolev(problem: &SobolevProblem, plane: SobolevPlane, r: f64) -> Result<SobolevValue, AnalyticError> {
    Ok(sobolev_at_radii(problem, plane, &[r])?[0])
}

/// Illuminances at many distances. Work that does not depend on the distance is shared: about 30 µs per distance.
///
/// Units, range, accuracy, errors: those of [`sobolev`]. The values are in the order of `radii`.
pub fn sobolev_at_radii(
    problem: &SobolevProblem,
    plane: SobolevPlane,
    radii: &[f64],
) -> Result<Vec<SobolevValue>, AnalyticError> {
    let spectrum = Spectrum::new(problem, plane)?;
    for r in radii {
        let holds = *r >= 0.0 && r.is_finite();
        require(holds, "the distance r", *r, "a finite distance of at least 0", "measure r from the source's foot")?;
    }
    let near = radii.iter().any(|r| *r < REAL_AXIS_BELOW).then(|| RealAxisForm::new(&spectrum));
    let r_max = radii.iter().copied().fold(REAL_AXIS_BELOW, f64::max);
    let far = (r_max >= REAL_AXIS_BELOW).then(|| TurnedForm::new(&spectrum, REAL_AXIS_BELOW, r_max));
    let values = radii.iter().map(|r| {
        let form = if *r < REAL_AXIS_BELOW { near.as_ref().map(|f| f.at(*r)) } else { far.as_ref().map(|f| f.at(*r)) };
        let reflected = form.unwrap_or_default();
        let direct_lx = spectrum.h1 / (spectrum.h1 * spectrum.h1 + r * r).powf(1.5);
        SobolevValue {
            direct_lx,
            reflected_lx: reflected.value,
            total_lx: direct_lx + reflected.value,
            estimated_error_lx: reflected.estimated_error,
        }
    });
    Ok(values.collect())
}

/// For r below this the real axis is used, from it on the turned path. At this limit the real axis loses two digits at most.
const REAL_AXIS_BELOW: f64 = 3.0;

/// Rounding error of a sum, as a fraction of the sum of its terms' absolute values. The errors of κ and of the wave are about 2e-15
/// at worst, mostly of either sign. The value has a margin for cases other than the 1,040 tested ones.
const ROUNDING_OF_A_SUM: f64 = 6e-15;

/// Safety factor on the truncation estimate, for integrands whose coefficients do not fall evenly.
const TRUNCATION_SAFETY: f64 = 10.0;

/// The spectral function G for one plane.
#[derive(Clone, Copy, Debug)]
struct Spectrum {
    h1: f64,
    h2: f64,
    rho1: f64,
    rho2: f64,
    /// 1 − ρ₁ρ₂ computed without cancellation.
    absorbed: f64,
}

impl Spectrum {
    fn new(problem: &SobolevProblem, plane: SobolevPlane) -> Result<Spectrum, AnalyticError> {
        let SobolevProblem { h1, rho1, rho2 } = *problem;
        let between = h1 > 0.0 && h1 < 1.0;
        require(between, "the source height h1", h1, "a height between 0 and 1", "put the source between the planes")?;
        require_reflectance("the reflectance rho1", rho1)?;
        require_reflectance("the reflectance rho2", rho2)?;
        require(
            rho1 < 1.0 || rho2 < 1.0,
            "the reflectance of both planes",
            1.0,
            "less than 1 on one plane at least",
            "let a plane absorb: between two perfect reflectors light piles up without bound",
        )?;
        let absorbed = (1.0 - rho1) + rho1 * (1.0 - rho2);
        let one = Spectrum { h1, h2: 1.0 - h1, rho1, rho2, absorbed };
        Ok(match plane {
            SobolevPlane::One => one,
            SobolevPlane::Two => Spectrum { h1: one.h2, h2: one.h1, rho1: rho2, rho2: rho1, absorbed },
        })
    }

    /// G(k). On the imaginary axis the imaginary part keeps its digits, because all its terms have one sign.
    fn at(&self, k: Complex<f64>) -> Complex<f64> {
        let (kappa, deficit) = z_bessel_k1_and_deficit(k);
        let first = kappa * (k * -self.h1).exp() * self.rho1 + (k * -self.h2).exp();
        // 1 − ρ₁ρ₂κ² = (1 − ρ₁ρ₂) + ρ₁ρ₂ (1 − κ)(1 + κ).
        let rest = deficit * (kappa + 1.0) * (self.rho1 * self.rho2) + self.absorbed;
        kappa * first * self.rho2 / rest
    }
}

/// A reflected illuminance with its estimated error.
#[derive(Clone, Copy, Debug, Default)]
struct ReflectedEstimate {
    value: f64,
    estimated_error: f64,
}

/// Adds up the sums of panels.
#[derive(Default)]
struct PanelTally(PanelSum);

impl PanelTally {
    fn add(&mut self, panel: PanelSum) {
        self.0.value += panel.value;
        self.0.absolute += panel.absolute;
        self.0.truncation += panel.truncation;
    }

    fn estimate(&self) -> ReflectedEstimate {
        let estimated_error = ROUNDING_OF_A_SUM * self.0.absolute + TRUNCATION_SAFETY * self.0.truncation;
        ReflectedEstimate { value: self.0.value, estimated_error }
    }
}

/// ∫₀^∞ k G(k) J₀(kr) dk along the real axis. It is accurate where the waves hardly cancel.
struct RealAxisForm {
    rule: PanelRule,
    panels: Vec<Panel<f64>>,
    /// Sums over the panels before each panel: of k G(k), and of k G(k) times k² and k⁴.
    moments: Vec<[f64; 3]>,
}

/// A last panel with less than this part of the whole is left out. For r < 3 the integral is at least 0.02 of the whole.
const NOTHING_ON_AXIS: f64 = 1e-17;

/// Up to this kr the wave is 1 − (kr)²/4 + (kr)⁴/64. The next term is (kr)⁶/2304.
const FLAT_PHASE: f64 = 0.01;

impl RealAxisForm {
    fn new(spectrum: &Spectrum) -> RealAxisForm {
        let rule = PanelRule::new();
        let mut panels = contour::real_axis(&rule, spectrum);
        // Because of the falling exponentials the last panels are negligible.
        let size = |panel: &Panel<f64>| rule.sum(0.5 * (panel.to - panel.from), &panel.values).absolute;
        let nothing = NOTHING_ON_AXIS * panels.iter().map(size).sum::<f64>();
        while panels.last().is_some_and(|panel| size(panel) < nothing) {
            panels.pop();
        }
        let mut moments = vec![[0.0; 3]];
        for panel in &panels {
            let half = 0.5 * (panel.to - panel.from);
            let before = moments[moments.len() - 1];
            let moment = |power: i32| {
                let values: [f64; NODES] = std::array::from_fn(|i| panel.values[i] * panel.places[i].powi(power));
                rule.sum(half, &values).value
            };
            moments.push([before[0] + moment(0), before[1] + moment(2), before[2] + moment(4)]);
        }
        RealAxisForm { rule, panels, moments }
    }

    fn at(&self, r: f64) -> ReflectedEstimate {
        let mut tally = PanelTally::default();
        let flat = self.panels.partition_point(|panel| panel.to * r <= FLAT_PHASE);
        let [zeroth, second, fourth] = self.moments[flat];
        let value = zeroth - 0.25 * r * r * second + r.powi(4) / 64.0 * fourth;
        tally.add(PanelSum { value, absolute: zeroth, truncation: 0.0 });
        for panel in &self.panels[flat..] {
            let values = std::array::from_fn(|i| panel.values[i] * bessel_j0(panel.places[i] * r));
            tally.add(self.rule.sum(0.5 * (panel.to - panel.from), &values));
        }
        tally.estimate()
    }
}

/// The integral along the turned path: up the imaginary axis, then along a ray.
struct TurnedForm {
    rule: PanelRule,
    axis: Vec<Panel<f64>>,
    /// Sums over the axis' panels before each panel, with v = −(2/π) t Im G(it): of v tⁿ and of v tⁿ ln t, for n = 0, 2, 4.
    moments: Vec<[[f64; 2]; 3]>,
    ray: Vec<Panel<Complex<f64>>>,
}

impl TurnedForm {
    /// For radii from `r_min` (about 1 or more) to `r_max`.
    fn new(spectrum: &Spectrum, r_min: f64, r_max: f64) -> TurnedForm {
        let rule = PanelRule::new();
        let axis = contour::imaginary_axis(&rule, spectrum, r_max);
        let ray = contour::ray(&rule, spectrum, r_min);
        let mut axis = axis;
        let mut moments = vec![[[0.0; 2]; 3]];
        for panel in &mut axis {
            panel.values = panel.values.map(|value| -2.0 / PI * value);
            let moment = |power: i32, log: i32| {
                let term = |i: usize| panel.values[i] * panel.places[i].powi(power) * panel.places[i].ln().powi(log);
                rule.sum(0.5 * (panel.to - panel.from), &std::array::from_fn(term)).value
            };
            let mut sums = moments[moments.len() - 1];
            for (n, sums) in sums.iter_mut().enumerate() {
                for (log, sum) in sums.iter_mut().enumerate() {
                    *sum += moment(2 * n as i32, log as i32);
                }
            }
            moments.push(sums);
        }
        TurnedForm { rule, axis, moments, ray }
    }

    fn at(&self, r: f64) -> ReflectedEstimate {
        let mut tally = PanelTally::default();
        let flat = self.axis.partition_point(|panel| panel.to * r <= SHALLOW_PHASE);
        let value = self.shallow(r, &self.moments[flat]);
        tally.add(PanelSum { value, absolute: value.abs(), truncation: 0.0 });
        for panel in self.axis[flat..].iter().take_while(|panel| panel.from * r < NOTHING_LEFT) {
            let values = std::array::from_fn(|i| panel.values[i] * bessel_k0(panel.places[i] * r));
            tally.add(self.rule.sum(0.5 * (panel.to - panel.from), &values));
        }
        // At the beginning of the ray the wave has already fallen by e^{−2r}.
        let fall = r * contour::RAY_ANGLE_RAD.sin() + contour::RAY_ANGLE_RAD.cos();
        let begins = TURN * r - 4.0 * r.ln_1p();
        for panel in self.ray.iter().take_while(|panel| begins + panel.from * fall < NOTHING_LEFT_OF_RAY) {
            let values = std::array::from_fn(|i| (panel.values[i] * hankel_wave(panel.places[i] * r)).re);
            tally.add(self.rule.sum(0.5 * (panel.to - panel.from), &values));
        }
        tally.estimate()
    }

    /// Contribution of the panels on which the first terms of K₀(tr) suffice: Σ (x/2)^{2n}/n!² (ψ(n+1) − ln(x/2)) to n = 2.
    fn shallow(&self, r: f64, moments: &[[f64; 2]; 3]) -> f64 {
        let log = (0.5 * r).ln();
        let q = 0.25 * r * r;
        let psi = [-EULER_GAMMA, 1.0 - EULER_GAMMA, 1.5 - EULER_GAMMA];
        let term = |n: usize| (psi[n] - log) * moments[n][0] - moments[n][1];
        term(0) + q * (term(1) + q * 0.25 * term(2))
    }
}

/// Up to this tr three terms of the wave K₀(tr) suffice. The next is (tr)⁶ ln(tr)/2304 = 1e-16.
const SHALLOW_PHASE: f64 = 0.006;

/// Exponent beyond which the ray is negligible beside a reflected illuminance that falls as r⁻³ or r⁻⁴.
const NOTHING_LEFT_OF_RAY: f64 = 38.0;

/// H₀⁽¹⁾(z) = (2/πi) K₀(−iz), for z in the first quadrant.
fn hankel_wave(z: Complex<f64>) -> Complex<f64> {
    let turned = Complex::new(z.im, -z.re);
    (-turned).exp() * complex_bessel_k0_scaled(turned) * Complex::new(0.0, -2.0 / PI)
}
