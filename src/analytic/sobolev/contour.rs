//! Integration paths of Sobolev's integral: panels of nodes along three pieces of path, with the spectral function at the nodes.
//!
//! The poles of G in the right half-plane begin at Im k = 3.7 and lie left of Re k = ½ ln(π|k|/2). The turned path goes up the
//! imaginary axis to [`TURN`] and then along a ray at [`RAY_ANGLE_RAD`]. It encloses no pole together with the real axis, for any
//! reflectances. Both paths therefore give the same integral, without residues. As ρ₁ρ₂ → 1 one more pole approaches k = 0 just
//! left of the imaginary axis. Panels are halved until G is smooth on each.

use num_complex::Complex;

use super::Spectrum;
use crate::base::quadrature::GaussLegendre;

/// Height at which the turned path leaves the imaginary axis, well below the first pole's 3.7.
pub(super) const TURN: f64 = 2.0;

/// Angle between the ray and the real axis, in radians. The ray passes right of the poles at a distance of 0.8 or more.
pub(super) const RAY_ANGLE_RAD: f64 = 0.6;

/// Nodes of a panel's Gauss–Legendre rule.
pub(super) const NODES: usize = 16;

/// A panel is halved while its last Legendre coefficients exceed this part of its largest value. The error of the rule is
/// proportional to the square of this.
const SMOOTH: f64 = 1e-9;

/// Maximum number of halvings. No pole in double precision needs more.
const MOST_HALVINGS: u32 = 60;

/// Exponent beyond which e^−x is negligible beside 1, with a margin for the powers multiplied with it.
pub(super) const NOTHING_LEFT: f64 = 42.0;

/// One panel: an interval of the path's parameter, with the spectral function times every factor except the wave.
#[derive(Clone, Debug)]
pub(super) struct Panel<T> {
    /// Interval of the parameter, rising.
    pub from: f64,
    pub to: f64,
    /// Positions of the nodes, in the form that the wave needs.
    pub places: [T; NODES],
    /// Values of the integrand without the wave.
    pub values: [T; NODES],
}

/// The rule of a panel with the two projections that estimate its error.
#[derive(Clone, Debug)]
pub(super) struct PanelRule {
    rule: GaussLegendre,
    /// Weights that give the Legendre coefficients of the two highest degrees that the nodes resolve, one row for each degree.
    projections: [[f64; NODES]; 2],
}

/// The integral over a panel, and its error estimated from the coefficients.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct PanelSum {
    pub value: f64,
    /// Integral of the absolute value.
    pub absolute: f64,
    pub truncation: f64,
}

impl PanelRule {
    pub fn new() -> PanelRule {
        let rule = GaussLegendre::new(NODES);
        let mut projections = [[0.0; NODES]; 2];
        for (i, (x, w)) in rule.nodes().iter().zip(rule.weights()).enumerate() {
            let (mut before, mut here) = (1.0, *x);
            for n in 1..NODES {
                if n + 2 >= NODES {
                    projections[n + 2 - NODES][i] = w * here * (n as f64 + 0.5);
                }
                let n = n as f64;
                (before, here) = (here, ((2.0 * n + 1.0) * x * here - n * before) / (n + 1.0));
            }
        }
        PanelRule { rule, projections }
    }

    /// Integral over a panel of half-width `half` from its values at the nodes.
    ///
    /// If the highest resolved coefficients are c times the function's size, the integral's relative error is about c². The reason
    /// is that the rule is exact to twice the degree.
    pub fn sum(&self, half: f64, values: &[f64; NODES]) -> PanelSum {
        let mut out = PanelSum::default();
        let mut coefficients = [0.0f64; 2];
        let mut largest = 0.0f64;
        for (i, (value, weight)) in values.iter().zip(self.rule.weights()).enumerate() {
            out.value += weight * value;
            out.absolute += weight * value.abs();
            largest = largest.max(value.abs());
            coefficients[0] += self.projections[0][i] * value;
            coefficients[1] += self.projections[1][i] * value;
        }
        if largest > 0.0 {
            let tail = coefficients[0].powi(2) + coefficients[1].powi(2);
            out.truncation = 2.0 * half * tail / largest;
        }
        out.value *= half;
        out.absolute *= half;
        out
    }

    fn is_smooth(&self, values: &[Complex<f64>; NODES]) -> bool {
        let largest = values.iter().map(|v| v.norm()).fold(0.0, f64::max);
        self.projections.iter().all(|projection| {
            let coefficient: Complex<f64> = projection.iter().zip(values).map(|(p, v)| v * *p).sum();
            coefficient.norm() <= SMOOTH * largest
        })
    }

    /// Panels over the given edges, halved until `integrand` (position and value from the parameter) is smooth on each.
    fn panels(
        &self,
        edges: &[f64],
        integrand: impl Fn(f64) -> (Complex<f64>, Complex<f64>),
    ) -> Vec<Panel<Complex<f64>>> {
        let mut panels = Vec::new();
        let mut open: Vec<(f64, f64, u32)> = edges.windows(2).rev().map(|e| (e[0], e[1], 0)).collect();
        while let Some((from, to, halvings)) = open.pop() {
            let mut places = [Complex::new(0.0, 0.0); NODES];
            let mut values = places;
            for (i, (s, _)) in self.rule.on(from, to).enumerate() {
                (places[i], values[i]) = integrand(s);
            }
            if halvings < MOST_HALVINGS && !self.is_smooth(&values) {
                let middle = 0.5 * (from + to);
                open.push((middle, to, halvings + 1));
                open.push((from, middle, halvings + 1));
                continue;
            }
            panels.push(Panel { from, to, places, values });
        }
        panels
    }
}

/// Panels along the real axis: k and k G(k).
pub(super) fn real_axis(rule: &PanelRule, spectrum: &Spectrum) -> Vec<Panel<f64>> {
    // Below the lowest edge k G(k) is at most k/(1 − ρ₁ρ₂), with a negligible integral.
    let lowest = 1e-9 * spectrum.absorbed.sqrt();
    let mut edges = rising_powers(lowest, 2.0);
    // Beyond 2 the wave determines the width: a panel of 2 spans eight radians either way at r = 8.
    while edges[edges.len() - 1] * (1.0 + spectrum.h1.min(spectrum.h2)) < NOTHING_LEFT {
        edges.push(edges[edges.len() - 1] + 2.0);
    }
    let on_axis = |k: f64| {
        let place = Complex::new(k, 0.0);
        (place, place * spectrum.at(place))
    };
    split(rule.panels(&edges, on_axis), |k| k.re, |f| f.re)
}

/// Panels up the imaginary axis to [`TURN`]: t and t Im G(it), for radii up to `r_max`.
pub(super) fn imaginary_axis(rule: &PanelRule, spectrum: &Spectrum, r_max: f64) -> Vec<Panel<f64>> {
    let edges = rising_powers(NEGLIGIBLE_PHASE / r_max, TURN);
    let on_axis = |t: f64| {
        let place = Complex::new(0.0, t);
        (place, spectrum.at(place) * t)
    };
    split(rule.panels(&edges, on_axis), |k| k.im, |f| f.im)
}

/// The lowest panel of the turned integral ends at this t r. It contributes the part (t r)³ ln(t r), so its singularity is
/// negligible.
const NEGLIGIBLE_PHASE: f64 = 4e-6;

/// Panels along the ray: k and k G(k) e^{iφ}. The parameter is the distance from the beginning of the ray.
pub(super) fn ray(rule: &PanelRule, spectrum: &Spectrum, r_min: f64) -> Vec<Panel<Complex<f64>>> {
    let direction = Complex::from_polar(1.0, RAY_ANGLE_RAD);
    let mut edges = vec![0.0, 0.5, 1.0];
    while edges[edges.len() - 1] * (r_min * direction.im + direction.re) < NOTHING_LEFT {
        edges.push(edges[edges.len() - 1] + 1.0);
    }
    rule.panels(&edges, |s| {
        let place = Complex::new(0.0, TURN) + direction * s;
        (place, place * spectrum.at(place) * direction)
    })
}

/// Returns 0, then `to` times powers of two from just below `lowest` up to `to`.
fn rising_powers(lowest: f64, to: f64) -> Vec<f64> {
    let mut edges = vec![to];
    while edges[edges.len() - 1] > lowest {
        edges.push(0.5 * edges[edges.len() - 1]);
    }
    edges.push(0.0);
    edges.reverse();
    edges
}

/// The same panels with one real number per node.
fn split(
    panels: Vec<Panel<Complex<f64>>>,
    place: impl Fn(Complex<f64>) -> f64,
    value: impl Fn(Complex<f64>) -> f64,
) -> Vec<Panel<f64>> {
    panels
        .into_iter()
        .map(|p| Panel { from: p.from, to: p.to, places: p.places.map(&place), values: p.values.map(&value) })
        .collect()
}
