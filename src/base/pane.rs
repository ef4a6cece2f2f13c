//! A thin plane pane of clear or tinted glass in air.

/// Smaller cosines are raised to this value, because at 90° both formulas below are 0/0.
const LEAST_COSINE: f64 = 1e-9;

/// Returns reflectance and transmittance of a pane for unpolarised light, with all inner reflections.
///
/// `refractive_index` is relative to air (1 or more). `internal_transmittance` is that of the glass alone along the normal. `cos_theta` is
/// the cosine of the angle in air. Let R be the reflectance of one face (Fresnel) and a the transmittance along the path inside (Snell).
/// Then for each polarisation the geometric series of inner reflections gives T = (1 − R)² a / (1 − R² a²) and R (1 + a T). The result is
/// the mean of the two polarisations.
///
/// Accuracy: rounding only, about 1e-15. Source: docs/methods.md (14).
pub fn pane_shares(refractive_index: f64, internal_transmittance: f64, cos_theta: f64) -> [f64; 2] {
    let cos = cos_theta.clamp(LEAST_COSINE, 1.0);
    // Snell's law, without the cancellation of 1 − sin².
    let cos_inside = ((refractive_index - 1.0) * (refractive_index + 1.0) + cos * cos).sqrt() / refractive_index;
    let inside = internal_transmittance.powf(1.0 / cos_inside);
    let across = (cos - refractive_index * cos_inside) / (cos + refractive_index * cos_inside);
    let along = (refractive_index * cos - cos_inside) / (refractive_index * cos + cos_inside);
    let mut shares = [0.0; 2];
    for amplitude in [across, along] {
        let face = amplitude * amplitude;
        let passed = (1.0 - face) * (1.0 - face) * inside / (1.0 - (face * inside) * (face * inside));
        shares[0] += 0.5 * face * (1.0 + inside * passed);
        shares[1] += 0.5 * passed;
    }
    shares
}

/// Returns the shares of [`pane_shares`] for a pane of which only `glazed_share` is glass. The rest, the frame, is black.
pub fn glazed_shares(
    glazed_share: f64,
    refractive_index: f64,
    internal_transmittance: f64,
    cos_theta: f64,
) -> [f64; 2] {
    pane_shares(refractive_index, internal_transmittance, cos_theta).map(|share| glazed_share * share)
}

/// Returns the internal transmittance of the glass along the normal, from the visible transmittance of a whole pane with all inner
/// reflections.
///
/// Range: the result is above 1 if no glass of this index can transmit the given share. Source: docs/methods.md (14), solved for a.
pub fn internal_transmittance_of(refractive_index: f64, visible_transmittance: f64) -> f64 {
    let face = ((refractive_index - 1.0) / (refractive_index + 1.0)).powi(2);
    let through_faces = (1.0 - face) * (1.0 - face);
    2.0 * visible_transmittance / (through_faces + through_faces.hypot(2.0 * face * visible_transmittance))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_clear_pane_transmits_what_the_tables_say() {
        // n = 1.52 without absorption, 0° to 80°, computed independently with (1 − R)/(1 + R) for each polarisation.
        let table = [0.9183, 0.9183, 0.9179, 0.9160, 0.9095, 0.8912, 0.8435, 0.7247, 0.4560];
        for (step, expected) in table.into_iter().enumerate() {
            let [reflected, passed] = pane_shares(1.52, 1.0, (10.0 * step as f64).to_radians().cos());
            assert!((passed - expected).abs() < 5.1e-5, "{passed} at {} degrees", 10 * step);
            assert!((reflected + passed - 1.0).abs() < 1e-14);
        }
    }

    #[test]
    fn a_tinted_pane_absorbs_along_its_oblique_path() {
        // The expected values are summed bounce by bounce, an independent method.
        for degrees in [0.0, 35.0, 60.0, 85.0f64] {
            let (n, tau) = (1.6, 0.8f64);
            let (sin, cos) = degrees.to_radians().sin_cos();
            let inside = (1.0 - (sin / n).powi(2)).sqrt();
            let a = tau.powf(1.0 / inside);
            let faces = [(cos - n * inside) / (cos + n * inside), (n * cos - inside) / (n * cos + inside)];
            let mut expected = [0.0; 2];
            for face in faces.map(|r| r * r) {
                expected[0] += 0.5 * face;
                let mut within = (1.0 - face) * a;
                for bounce in 0..60 {
                    expected[usize::from(bounce % 2 == 0)] += 0.5 * within * (1.0 - face);
                    within *= face * a;
                }
            }
            let shares = pane_shares(n, tau, cos);
            for (share, expected) in shares.iter().zip(expected) {
                assert!((share - expected).abs() < 1e-14, "{shares:?} {expected}");
            }
            assert!(shares[0] + shares[1] < 1.0);
        }
    }

    #[test]
    fn a_pane_lets_pass_the_transmittance_that_it_was_found_from() {
        for (index, visible) in [(1.52, 0.78), (1.52, 0.05), (1.0, 0.5), (2.4, 0.6), (1.52, 0.0)] {
            let inside = internal_transmittance_of(index, visible);
            assert!((pane_shares(index, inside, 1.0)[1] - visible).abs() < 1e-14, "{index} {visible}: {inside}");
        }
        // (1 − R)/(1 + R) at n = 1.52 is the largest possible transmittance of a pane.
        let face = (0.52f64 / 2.52).powi(2);
        assert!((internal_transmittance_of(1.52, (1.0 - face) / (1.0 + face)) - 1.0).abs() < 1e-14);
        assert!(internal_transmittance_of(1.52, 0.93) > 1.0);
    }

    #[test]
    fn edges_stay_between_nothing_and_all() {
        for cos in [0.0, 1e-12, 1e-3, 1.0] {
            for (n, tau) in [(1.0, 1.0), (1.0, 0.0), (1.52, 0.0), (3.0, 1.0), (1.52, 1e-300)] {
                let [reflected, passed] = pane_shares(n, tau, cos);
                assert!((0.0..=1.0).contains(&reflected) && (0.0..=1.0).contains(&passed), "{n} {tau} {cos}");
                assert!(reflected + passed <= 1.0 + 1e-14);
            }
        }
        assert_eq!(pane_shares(1.0, 0.7, 1.0), [0.0, 0.7]);
    }
}
