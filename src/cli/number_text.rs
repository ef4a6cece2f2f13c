//! Numbers for the terminal: those of [`crate::output::numbers`], with plain spaces and minus signs. Texts of a terminal are searched and
//! compared, and a no-break space or a true minus sign is not what a person types.

use crate::output::numbers::{self, SPACE};

/// With the signs of a keyboard.
fn typed(text: String) -> String {
    text.replace(SPACE, " ").replace('−', "-")
}

/// A number with this many significant digits: as a plain decimal if that is short, else with a power of ten.
pub fn significant(number: f64, digits: usize) -> String {
    typed(numbers::short(number, digits))
}

/// A number as a person would write it: up to this many significant digits, without trailing zeros.
pub fn plain(number: f64, digits: usize) -> String {
    let text = significant(number, digits);
    if !text.contains('.') || text.contains('·') {
        return text;
    }
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

/// A fraction as percent with three digits: `1.23 %`.
pub fn percent(fraction: f64) -> String {
    typed(numbers::percent_to(fraction, 3))
}

/// A count in thousands, millions, …: `1.23 M`.
pub fn count(number: f64) -> String {
    typed(numbers::count(number))
}

/// A time: `0.52 s`, `3 min 20 s`, `2 h 5 min`.
pub fn time(seconds: f64) -> String {
    typed(numbers::duration(seconds))
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
            (-1.5, "-1.500"),
            (1.5e-9, "1.500·10⁻⁹"),
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
