//! Directions from a point to the highlight of a luminaire on a flat glossy surface (docs/methods.md (56)).

use std::f64::consts::TAU;

use glam::DVec3;

use super::beam::Facet;
use super::reflection::draw_power_of_cosine;

/// Directions are drawn up to the angle beyond which the share exp(−6) of a whole lobe would go. (Measured: squared error times rays in
/// three rooms: exp(−4.2) 0.997, exp(−7.8) 0.998.)
const OUTERMOST: f64 = 6.0;
/// Least variance of the directions in rad², for points close to a surface that is nearly a mirror.
const LEAST_VARIANCE: f64 = 1e-8;

/// A density of directions about the one in which a mirror would show the luminaire: cosᵐθ, cut off where little of it is left.
#[derive(Clone, Copy, Debug)]
pub struct Highlight {
    axis: DVec3,
    exponent: f64,
}

impl Highlight {
    /// The highlight on a facet with a lobe of a given width, as a point sees it. The luminaire is given as a ball, by its centre and
    /// radius in m. `None` if the facet does not face both.
    pub fn new(facet: &Facet, width_rad: f64, point_m: DVec3, (center_m, radius_m): (DVec3, f64)) -> Option<Highlight> {
        let (own_m, other_m) = (facet.height_m(point_m), facet.height_m(center_m));
        if own_m <= 0.0 || other_m <= 0.0 {
            return None;
        }
        let offset_m = facet.image_m(center_m) - point_m;
        let distance_m = offset_m.length();
        let blur_rad = width_rad * other_m / (own_m + other_m);
        let half_extent_rad = 0.5 * radius_m / distance_m;
        let variance = (blur_rad * blur_rad + half_extent_rad * half_extent_rad).max(LEAST_VARIANCE);
        Some(Highlight { axis: offset_m / distance_m, exponent: (1.0 / variance - 2.0).max(0.0) })
    }

    /// Draws a unit direction by two variates in [0, 1).
    pub fn draw(&self, [u, v]: [f64; 2]) -> DVec3 {
        draw_power_of_cosine(self.exponent, self.axis, [-(-OUTERMOST).exp_m1() * u, v])
    }

    /// Density per sr with which a unit direction is drawn.
    pub fn per_sr(&self, direction: DVec3) -> f64 {
        let log_cos = self.axis.dot(direction).max(0.0).ln();
        if (self.exponent + 1.0) * log_cos < -OUTERMOST {
            return 0.0;
        }
        (self.exponent + 1.0) / (TAU * -(-OUTERMOST).exp_m1()) * (self.exponent * log_cos).exp()
    }
}
