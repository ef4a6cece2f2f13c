//! Formats numbers for reports.

pub use crate::output::date::utc_date as date;
pub use crate::output::numbers::significant;
use crate::output::numbers::{grouped_from, superscript};
pub use crate::output::picture::escaped;

/// Below this percentage a report only states that it is rounding.
const NOTHING_PERCENT: f64 = 1e-7;

/// A fraction in per cent with three significant digits.
pub fn percent(fraction: f64) -> String {
    let percent = 100.0 * fraction;
    if percent == 0.0 {
        return format!("0{NARROW}%");
    }
    if percent.abs() < NOTHING_PERCENT {
        return format!("< 10⁻⁷{NARROW}%");
    }
    let number = if percent.abs() < 1e-3 { scientific(percent) } else { significant(percent, 3).replace('-', "−") };
    format!("{number}{NARROW}%")
}

/// A narrow no-break space.
const NARROW: char = '\u{202f}';

/// A signed fraction in per cent.
pub fn signed_percent(fraction: f64) -> String {
    let text = percent(fraction);
    if fraction > 0.0 && !text.starts_with('<') { format!("+{text}") } else { text }
}

/// A fraction in whole per cent.
pub fn whole_percent(fraction: f64) -> String {
    format!("{:.0} %", 100.0 * fraction).replace('-', "−")
}

/// A number of standard errors.
pub fn sigmas(z: f64) -> String {
    format!("{z:.2}{NARROW}σ").replace('-', "−")
}

/// A number as mantissa and power of ten.
pub fn scientific(number: f64) -> String {
    let text = format!("{number:.1e}");
    let Some((mantissa, exponent)) = text.split_once('e') else {
        return text;
    };
    format!("{}·10{}", mantissa.replace('-', "−"), superscript(exponent))
}

/// A count with separated thousands.
pub fn grouped(count: u64) -> String {
    grouped_from(4, &count.to_string(), NARROW)
}

/// A rounded count of rays or chains: `12.3 million`.
pub fn rounded_count(count: u64) -> String {
    match count {
        0..100_000 => grouped(count),
        100_000..1_000_000_000 => format!("{} million", significant(count as f64 / 1e6, 3)),
        _ => format!("{} billion", significant(count as f64 / 1e9, 3)),
    }
}

/// Seconds, or minutes and seconds.
pub fn duration(seconds: f64) -> String {
    if seconds < 0.01 {
        return format!("< 0.01{NARROW}s");
    }
    if seconds < 60.0 {
        return format!("{}{NARROW}s", significant(seconds, 2));
    }
    let whole = seconds.round() as u64;
    format!("{}{NARROW}min {:02}{NARROW}s", whole / 60, whole % 60)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_read_well() {
        assert_eq!(percent(0.00123456), "0.123\u{202f}%");
        assert_eq!(percent(0.0), "0\u{202f}%");
        assert_eq!(percent(2.3e-8), "2.3·10⁻⁶\u{202f}%");
        assert_eq!(percent(1e-15), "< 10⁻⁷\u{202f}%");
        assert_eq!(signed_percent(-0.01), "−1.00\u{202f}%");
        assert_eq!(signed_percent(0.01), "+1.00\u{202f}%");
        assert_eq!(significant(1234.5, 3), "1234");
        assert_eq!(grouped(1_234_567), "1\u{202f}234\u{202f}567");
        assert_eq!(duration(75.2), "1\u{202f}min 15\u{202f}s");
        assert_eq!(date(951_782_400), "2000-02-29");
        assert_eq!(date(1_795_219_200), "2026-11-21");
        assert_eq!(escaped("a<b & \"c\""), "a&lt;b &amp; &quot;c&quot;");
    }
}
