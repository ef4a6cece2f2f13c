//! Formats numbers for readers, with as many digits as are significant.

use crate::output::numbers;

/// A number with this many significant digits: as a plain decimal if that is short, else with a power of ten.
pub fn significant(number: f64, digits: usize) -> String {
    let is_short = number == 0.0 || !number.is_finite() || (-4..9).contains(&numbers::power_of_ten(number, digits));
    if is_short { numbers::significant(number, digits) } else { format!("{number:.*e}", digits - 1) }
}

/// A number as a person would write it: up to this many significant digits, without trailing zeros.
pub fn plain(number: f64, digits: usize) -> String {
    let text = significant(number + 0.0, digits);
    if !text.contains('.') || text.contains('e') {
        return text;
    }
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

/// A fraction as percent: `1.23 %`.
pub fn percent(fraction: f64) -> String {
    if !fraction.is_finite() {
        return "unknown".to_owned();
    }
    format!("{} %", significant(100.0 * fraction, 3))
}

/// A count in thousands, millions, … : `1.23 M`.
pub fn count(number: f64) -> String {
    match numbers::in_thousands(number) {
        (number, "") => format!("{number:.0}"),
        (number, unit) => format!("{}{unit}", significant(number, 3)),
    }
}

/// A time: `0.52 s`, `3 min 20 s`, `2 h 5 min`.
pub fn time(seconds: f64) -> String {
    match seconds.max(0.0) {
        s if s < 9.95 => format!("{} s", significant(s, 2)),
        s if s < 99.5 => format!("{s:.0} s"),
        s if s < 3600.0 => format!("{:.0} min {:02.0} s", (s / 60.0).floor(), (s % 60.0).floor()),
        s => format!("{:.0} h {:02.0} min", (s / 3600.0).floor(), (s % 3600.0 / 60.0).floor()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_show_their_significant_digits() {
        for (number, text) in [
            (1234.56, "1235"),
            (123.456, "123.5"),
            (9.9996, "10.00"),
            (0.012_346, "0.01235"),
            (1.5e-9, "1.500e-9"),
            (0.0, "0"),
            (-0.0, "0"),
        ] {
            assert_eq!(significant(number, 4), text);
        }
        assert_eq!([1.0, 0.8, 20.0, 12.3456].map(|number| plain(number, 4)), ["1", "0.8", "20", "12.35"]);
        assert_eq!(percent(0.01), "1.00 %");
        assert_eq!(count(1_234_567.0), "1.23 M");
        assert_eq!((time(0.523), time(61.0), time(200.0)), ("0.52 s".into(), "61 s".into(), "3 min 20 s".into()));
    }
}
