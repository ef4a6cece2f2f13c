//! Numbers for the validation's pages: those of [`crate::output::numbers`], and some that only a comparison with a truth needs.

pub use crate::output::date::utc_date as date;
use crate::output::numbers::{SPACE, percent_to};
pub use crate::output::numbers::{count, duration, grouped, significant, whole_percent};
pub use crate::output::picture::escaped;

/// Below this percentage a report only states that it is rounding.
const NOTHING_PERCENT: f64 = 1e-7;

/// A fraction in per cent with three significant digits.
pub fn percent(fraction: f64) -> String {
    let is_rounding = fraction != 0.0 && 100.0 * fraction.abs() < NOTHING_PERCENT;
    if is_rounding { format!("< 10⁻⁷{SPACE}%") } else { percent_to(fraction, 3) }
}

/// A signed fraction in per cent.
pub fn signed_percent(fraction: f64) -> String {
    let text = percent(fraction);
    if fraction > 0.0 && !text.starts_with('<') { format!("+{text}") } else { text }
}

/// A number of standard errors.
pub fn sigmas(z: f64) -> String {
    format!("{z:.2}{SPACE}σ").replace('-', "−")
}

/// A number with two significant digits and a power of ten.
pub fn scientific(number: f64) -> String {
    crate::output::numbers::scientific(number, 2)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_read_well() {
        assert_eq!(percent(0.00123456), "0.123\u{a0}%");
        assert_eq!(percent(0.0), "0\u{a0}%");
        assert_eq!(percent(2.3e-8), "2.30·10⁻⁶\u{a0}%");
        assert_eq!(percent(1e-15), "< 10⁻⁷\u{a0}%");
        assert_eq!(signed_percent(-0.01), "−1.00\u{a0}%");
        assert_eq!(signed_percent(0.01), "+1.00\u{a0}%");
        assert_eq!(significant(1234.5, 3), "1234");
        assert_eq!(grouped(1_234_567), "1\u{2009}234\u{2009}567");
        assert_eq!(duration(75.2), "75\u{a0}s");
        assert_eq!(date(951_782_400), "2000-02-29");
        assert_eq!(date(1_795_219_200), "2026-11-21");
        assert_eq!(escaped("a<b & \"c\""), "a&lt;b &amp; &quot;c&quot;");
    }
}
