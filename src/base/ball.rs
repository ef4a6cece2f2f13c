//! A uniformly bright ball seen from a point: its share of the illuminance that a full hemisphere gives.

use std::f64::consts::PI;

/// Returns the illuminance that a uniformly bright ball gives at a point, divided by the ball's exitance.
///
/// `cos_theta` is the cosine between the receiver's normal and the direction to the ball's centre. `distance_per_radius` is the distance of
/// the centre divided by the radius (above 1). A ball wholly above the horizon gives cos θ/H². For a ball that the horizon cuts, the value
/// is the closed form of the cut disc of directions. A ball below the horizon gives 0.
///
/// Range: 0 to 1. Accuracy: about 1e-15 absolute.
pub fn ball_illuminance_factor(cos_theta: f64, distance_per_radius: f64) -> f64 {
    let h = distance_per_radius.max(1.0);
    let c = cos_theta;
    if c * h >= 1.0 {
        return c / (h * h);
    }
    if c * h <= -1.0 {
        return 0.0;
    }
    let tangent_squared = h * h - 1.0;
    let tangent = tangent_squared.sqrt();
    let above = (1.0 - h * h * c * c).max(0.0).sqrt();
    let sin_theta = (1.0 - c * c).max(0.0).sqrt();
    let arc = if sin_theta == 0.0 { 0.0 } else { (-c * tangent / sin_theta).clamp(-1.0, 1.0).acos() };
    let rim = if tangent == 0.0 { PI / 2.0 } else { (above / tangent).atan() };
    ((c * arc - above * tangent) / (PI * h * h) + rim / PI).max(0.0)
}

#[cfg(test)]
mod tests {
    use super::ball_illuminance_factor;

    #[test]
    fn a_ball_cut_by_the_horizon_agrees_with_quadrature() {
        // Independent midpoint quadrature over the cone of directions.
        for (cos_theta, h) in [(0.1, 5.0), (0.0, 5.0), (-0.1, 5.0), (0.3, 1.5), (-0.4, 1.5)] {
            let sin_theta: f64 = (1.0f64 - cos_theta * cos_theta).sqrt();
            let cos_max: f64 = (1.0f64 - 1.0 / (h * h)).sqrt();
            let (n_mu, n_phi) = (1200, 1200);
            let mut sum = 0.0;
            for i in 0..n_mu {
                let mu = cos_max + (1.0 - cos_max) * (i as f64 + 0.5) / n_mu as f64;
                for j in 0..n_phi {
                    let phi = std::f64::consts::TAU * (j as f64 + 0.5) / n_phi as f64;
                    sum += (mu * cos_theta + (1.0 - mu * mu).sqrt() * sin_theta * phi.cos()).max(0.0);
                }
            }
            let quadrature = sum * 2.0 * (1.0 - cos_max) / f64::from(n_mu * n_phi);
            let formula = ball_illuminance_factor(cos_theta, h);
            assert!((formula - quadrature).abs() < 2e-6, "{cos_theta} {h}: {formula} {quadrature}");
        }
    }

    #[test]
    fn a_ball_above_the_horizon_follows_the_inverse_square() {
        assert!((ball_illuminance_factor(0.5, 10.0) - 0.005).abs() < 1e-16);
        assert_eq!(ball_illuminance_factor(-0.5, 10.0), 0.0);
    }
}
