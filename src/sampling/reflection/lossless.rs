//! Gives back a lobe's losses: the light that it would send below the horizon, and the light that the maximum in its denominator removes.
//!
//! A reciprocal lobe g / max(cos θ_i, cos θ_o) has a directional reflectance R(θ) that falls towards grazing incidence. A second, smooth
//! term (1 − R(θ_i))(1 − R(θ_o))/(π(1 − R̄)) gives back exactly the missing 1 − R(θ_i). It is reciprocal too (after Kelemen and
//! Szirmay-Kalos, 2001, "A Microfacet Based Coupled Specular-Matte BRDF Model with Importance Sampling").

use std::f64::consts::{FRAC_1_PI, PI};

use glam::DVec3;

use crate::base::quadrature::GaussLegendre;
use crate::sampling::random::Stream;
use crate::sampling::warp::{sin_cos_of_turns, tangents};

/// Intervals of the table of 1 − R over the cosine.
const INTERVALS: usize = 256;
/// Panels of the quadrature over the lobe, 8 points each.
const PANELS: usize = 64;
/// End of the quadrature in y. Only exp(−6.5²) = 4e-19 of the lobe's flux lies beyond.
const LOBE_END: f64 = 6.5;
/// Cosine that stands for grazing incidence in the table.
const GRAZING: f64 = 1e-9;
/// Largest number of draws of the rejection loop. Within an interval of the table 1 − R varies by far less than a factor 2, so 200 failures
/// in a row have a probability below 1e-60.
const MOST_DRAWS: u32 = 200;

/// The table of a lobe's losses.
#[derive(Clone, Debug)]
pub(super) struct Lossless {
    /// Width of the lobe in rad, about its standard deviation across and along. The table resolves cosines down to it.
    width_rad: f64,
    /// 1/ln(1 + 1/width_rad), which makes the table's abscissa run from 0 to 1.
    log_scale: f64,
    /// 1 − R at the nodes.
    missing: Vec<f64>,
    /// ∫ 2μ(1 − R) dμ up to each node; the last is 1 − R̄.
    cumulated: Vec<f64>,
}

impl Lossless {
    /// Tabulates the losses of a lobe around the mirror direction. At grazing incidence the nodes are as close as its width (rad).
    /// `alpha_at` returns cosine and sine of the angle from the mirror direction beyond which the share exp(−y²) of the lobe's flux goes.
    pub fn new(width_rad: f64, alpha_at: impl Fn(f64) -> [f64; 2]) -> Lossless {
        let log_scale = 1.0 / (1.0 / width_rad).ln_1p();
        let mut table = Lossless { width_rad, log_scale, missing: Vec::new(), cumulated: vec![0.0] };
        let rule = GaussLegendre::new(8);
        table.missing =
            (0..=INTERVALS).map(|node| missing_share(&alpha_at, table.cosine(node as f64), &rule)).collect();
        for interval in 0..INTERVALS {
            let (from, to) = (table.cosine(interval as f64), table.cosine(interval as f64 + 1.0));
            let mass = rule.integrate(from, to, |cos| 2.0 * cos * table.missing_at(cos));
            table.cumulated.push(table.cumulated[interval] + mass);
        }
        table
    }

    /// Returns π times the second term for the cosines of both directions.
    pub fn rest(&self, cos_in: f64, cos_out: f64) -> f64 {
        self.missing_at(cos_in) * self.missing_at(cos_out) / self.cumulated[INTERVALS]
    }

    /// Draws a direction around the normal with density (1 − R(θ)) cos θ / (π(1 − R̄)).
    pub fn draw_rest(&self, normal: DVec3, stream: &mut Stream) -> DVec3 {
        let aim = stream.fine_unit() * self.cumulated[INTERVALS];
        let interval = self.cumulated.partition_point(|sum| *sum <= aim).clamp(1, INTERVALS) - 1;
        let squares = [interval, interval + 1].map(|node| self.cosine(node as f64).powi(2));
        let largest = self.missing[interval].max(self.missing[interval + 1]);
        let mut square = squares[1];
        for _ in 0..MOST_DRAWS {
            square = squares[0] + stream.unit() * (squares[1] - squares[0]);
            if stream.unit() * largest < self.missing_at(square.sqrt()) {
                break;
            }
        }
        let (sin, cos) = sin_cos_of_turns(stream.unit());
        let radius = (1.0 - square).max(0.0).sqrt();
        let [t, b] = tangents(normal);
        t * (radius * cos) + b * (radius * sin) + normal * square.sqrt().max(GRAZING)
    }

    /// Returns the cosine at a position of the table, from 0 to [`INTERVALS`].
    fn cosine(&self, place: f64) -> f64 {
        let share = place / INTERVALS as f64;
        (self.width_rad * (share / self.log_scale).exp_m1()).min(1.0)
    }

    /// Returns 1 − R at a cosine, interpolated between the nodes of the table.
    fn missing_at(&self, cos: f64) -> f64 {
        let place = (cos / self.width_rad).ln_1p() * self.log_scale * INTERVALS as f64;
        let node = (place as usize).min(INTERVALS - 1);
        let t = (place - node as f64).clamp(0.0, 1.0);
        self.missing[node] + t * (self.missing[node + 1] - self.missing[node])
    }
}

/// Draws a direction around an axis with density (n + 1)/(2π) cosⁿα.
pub(in crate::sampling) fn draw_power_of_cosine(exponent: f64, axis: DVec3, [u, v]: [f64; 2]) -> DVec3 {
    // Computes ln cos α, then 1 − cos²α without the cancellation of narrow lobes.
    let log_cos = (-u).ln_1p() / (exponent + 1.0);
    let sin_alpha = (-(2.0 * log_cos).exp_m1()).max(0.0).sqrt();
    let (sin, cos) = sin_cos_of_turns(v);
    let [t, b] = tangents(axis);
    t * (sin_alpha * cos) + b * (sin_alpha * sin) + axis * log_cos.exp()
}

/// Returns cosine and sine of the angle from the axis beyond which the share exp(−y²) of a flux with density (n + 1)/(2π) cosⁿα goes. The
/// flux is uniform in u = cosⁿ⁺¹α = exp(−y²).
pub(super) fn power_of_cosine_angle(exponent: f64, y: f64) -> [f64; 2] {
    let log_cos = -y * y / (exponent + 1.0);
    [log_cos.exp(), (-(2.0 * log_cos).exp_m1()).max(0.0).sqrt()]
}

/// Returns 1 − R at a cosine. The azimuth around the mirror direction is integrated in closed form, α by quadrature.
///
/// At an angle α the cosine along the circle is a + b cos φ with a = cos α cos θ and b = sin α sin θ. Of the light that the lobe sends
/// there, min(1, cos θ_o/cos θ_i)⁺ remains.
fn missing_share(alpha_at: &impl Fn(f64) -> [f64; 2], cos: f64, rule: &GaussLegendre) -> f64 {
    let cos = cos.max(GRAZING);
    let sin = (1.0 - cos * cos).max(0.0).sqrt();
    let lost_at = |y: f64| {
        let [cos_alpha, sin_alpha] = alpha_at(y);
        let (a, b) = (cos_alpha * cos, sin_alpha * sin);
        if b <= 0.0 {
            return 2.0 * y * (-y * y).exp() * (1.0 - a.max(0.0) / cos);
        }
        let full = ((cos - a) / b).clamp(-1.0, 1.0).acos();
        let horizon = (-a / b).clamp(-1.0, 1.0).acos();
        let kept = full + (a * (horizon - full) + b * (horizon.sin() - full.sin())) / cos;
        2.0 * y * (-y * y).exp() * (PI - kept) * FRAC_1_PI
    };
    let step = LOBE_END / PANELS as f64;
    let sum: f64 =
        (0..PANELS).map(|panel| rule.integrate(panel as f64 * step, (panel + 1) as f64 * step, lost_at)).sum();
    sum.clamp(0.0, 1.0)
}
