//! Discomfort glare: the unified glare rating.

/// Ratings below this are reported as `< 10`, because the scale of CIE 117 begins here.
pub const LEAST_RATING: f64 = 10.0;

/// Returns the unified glare rating from the background luminance and the luminaires' Σ L²ω/p² (cd²·sr/m⁴).
///
/// UGR = 8 log₁₀(0.25/L_b · Σ L²ω/p²). `None` without glare or without background luminance, where UGR has no value.
///
/// Source: CIE 117-1995; docs/methods.md (25).
pub fn unified_glare_rating(background_cd_m2: f64, glare_sum: f64) -> Option<f64> {
    (background_cd_m2 > 0.0 && glare_sum > 0.0).then(|| 8.0 * (0.25 / background_cd_m2 * glare_sum).log10())
}

/// Returns a rating as text: `19.3`, or `< 10` below the scale and where nothing causes glare.
pub fn rating_text(ugr: Option<f64>) -> String {
    match ugr {
        Some(ugr) if ugr >= LEAST_RATING => format!("{ugr:.1}"),
        _ => format!("< {LEAST_RATING}"),
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::base::position_index::position_index;

    /// Three downward luminaires of 0.6 m × 0.6 m send 500 cd towards an eye at (0, 0, 1.2) that looks along +x. The background is 20
    /// cd/m². Every step was worked out by hand. The indices lie at T/R, H/R = 0, 0.5333; 0.5, 0.5333 and 0, 0.32.
    #[test]
    fn the_worked_case_comes_out() {
        let eye = DVec3::new(0.0, 0.0, 1.2);
        let cases = [
            (DVec3::new(3.0, 0.0, 2.8), 2.86 + 0.64 / 3.0, 13515.1, 17.822),
            (DVec3::new(3.0, 1.5, 2.8), 2.91 + 0.49 / 3.0, 12365.2, 17.513),
            (DVec3::new(5.0, 0.0, 2.8), 1.90 + 0.45 * 0.2, 20877.2, 19.333),
        ];
        let mut sum = 0.0;
        for (position, index, term, rating) in cases {
            let offset = position - eye;
            let towards = offset.normalize();
            let p = position_index(DVec3::X, towards).expect("ahead");
            assert!((p - index).abs() < 1e-9, "{p} {index}");
            let area = 0.36 * towards.z;
            let glare = 500.0 * 500.0 / (area * offset.length_squared()) / (p * p);
            assert!((glare - term).abs() < 0.5, "{glare} {term}");
            let alone = unified_glare_rating(20.0, glare).expect("glare");
            assert!((alone - rating).abs() < 1e-3, "{alone} {rating}");
            sum += glare;
        }
        let together = unified_glare_rating(20.0, sum).expect("glare");
        assert!((together - 22.134).abs() < 1e-3, "{together}");
        // A background 2% off (the planted fault) shows.
        assert!((unified_glare_rating(20.4, sum).expect("glare") - 22.134).abs() > 0.01);
        assert_eq!(unified_glare_rating(0.0, 1.0), None);
    }
}
