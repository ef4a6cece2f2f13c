//! Discomfort glare: Guth's position index and the unified glare rating.

use std::f64::consts::FRAC_PI_2;

use glam::DVec3;

/// The index is not defined beyond this in the model for sources below the line of sight.
const LARGEST_INDEX_BELOW: f64 = 16.0;

/// The variant of the position index, in words.
pub const POSITION_INDEX: &str = "Guth's formula above the line of sight (not the table of CIE 117, which differs by up to 10%), Iwata and Tokura below it";

/// Position index of a source: how much brighter than one on the line of sight it must be to disturb as much.
///
/// `view` is the line of sight and `towards` the direction of the source, both unit vectors; up is +z. With σ the angle
/// between them and τ the angle of their plane from the vertical, in degrees, above the line of sight
///
/// ln p = (35.2 − 0.31889 τ − 1.22 e^(−2τ/9)) 10⁻³ σ + (21 + 0.26667 τ − 0.002963 τ²) 10⁻⁵ σ².
///
/// Range: 1 or more. `None` for sources behind the observer.
///
/// Source: S. K. Guth 1963, as a formula by R. E. Levin 1975; below the line of sight T. Iwata and M. Tokura 1997.
pub fn position_index(view: DVec3, towards: DVec3) -> Option<f64> {
    let cosine = view.dot(towards);
    if cosine <= 0.0 {
        return None;
    }
    let aside = towards - cosine * view;
    let sigma_deg = aside.length().atan2(cosine).to_degrees();
    let upwards = (DVec3::Z - view.z * view).normalize_or_zero();
    let height = aside.dot(upwards);
    if height < 0.0 {
        // R = √(H² + Y²)/D, the tangent of σ.
        let tangent = aside.length() / cosine;
        let slope = if tangent < 0.6 { 0.8 } else { 1.2 };
        return Some((1.0 + slope * tangent).min(LARGEST_INDEX_BELOW));
    }
    let tau_deg = if aside.length() > 0.0 { (height / aside.length()).clamp(-1.0, 1.0).acos() } else { FRAC_PI_2 };
    let tau_deg = tau_deg.to_degrees();
    let linear = (35.2 - 0.31889 * tau_deg - 1.22 * (-2.0 * tau_deg / 9.0).exp()) * 1e-3;
    let square = (21.0 + 0.26667 * tau_deg - 0.002963 * tau_deg * tau_deg) * 1e-5;
    Some((linear * sigma_deg + square * sigma_deg * sigma_deg).exp())
}

/// Unified glare rating from the background luminance in cd/m² and Σ L²ω/p² of the luminaires in cd²·sr/m⁴.
///
/// UGR = 8 log₁₀(0.25/L_b · Σ L²ω/p²); `None` without glare or background, where it has no value.
///
/// Source: CIE 117-1995.
pub fn unified_glare_rating(background_cd_m2: f64, glare_sum: f64) -> Option<f64> {
    (background_cd_m2 > 0.0 && glare_sum > 0.0).then(|| 8.0 * (0.25 / background_cd_m2 * glare_sum).log10())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Three downward luminaires of 0.6 m × 0.6 m and 500 cd towards an eye at (0, 0, 1.2) that looks along +x, with a
    /// background of 20 cd/m²: every step worked out by hand from the two formulas.
    #[test]
    fn the_worked_case_comes_out() {
        let eye = DVec3::new(0.0, 0.0, 1.2);
        let cases = [
            (DVec3::new(3.0, 0.0, 2.8), 3.0630, 13606.4, 17.845),
            (DVec3::new(3.0, 1.5, 2.8), 3.0910, 12223.9, 17.473),
            (DVec3::new(5.0, 0.0, 2.8), 1.9525, 21687.8, 19.465),
        ];
        let mut sum = 0.0;
        for (position, index, term, rating) in cases {
            let offset = position - eye;
            let towards = offset.normalize();
            let p = position_index(DVec3::X, towards).expect("ahead");
            assert!((p - index).abs() < 1e-4, "{p} {index}");
            let area = 0.36 * towards.z;
            let glare = 500.0 * 500.0 / (area * offset.length_squared()) / (p * p);
            assert!((glare - term).abs() < 0.5, "{glare} {term}");
            let alone = unified_glare_rating(20.0, glare).expect("glare");
            assert!((alone - rating).abs() < 1e-3, "{alone} {rating}");
            sum += glare;
        }
        let together = unified_glare_rating(20.0, sum).expect("glare");
        assert!((together - 22.190).abs() < 1e-3, "{together}");
        // A background 2% off (the planted fault) shows.
        assert!((unified_glare_rating(20.4, sum).expect("glare") - 22.190).abs() > 0.01);
    }

    #[test]
    fn the_index_is_one_ahead_grows_aside_and_ends_behind() {
        let at = |y: f64, z: f64| position_index(DVec3::X, DVec3::new(1.0, y, z).normalize());
        assert!((at(0.0, 0.0).expect("ahead") - 1.0).abs() < 1e-12);
        assert!(at(0.0, 0.5) > at(0.0, 0.2) && at(0.5, 0.2) > at(0.0, 0.2));
        assert_eq!(at(0.7, 0.3), at(-0.7, 0.3));
        assert!((at(0.0, -0.5).expect("below") - 1.4).abs() < 1e-12);
        assert_eq!(position_index(DVec3::X, DVec3::NEG_X), None);
        assert_eq!(unified_glare_rating(0.0, 1.0), None);
    }
}
