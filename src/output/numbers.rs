//! Numbers for readers: of reports, plots and the validation's pages, with as many digits as are useful. The terminal's numbers are the same
//! with plain signs: `cli/number_text.rs`. CSV and JSON files do not use them: their numbers are for programs and have all digits.

use super::texts::{decimal, say};
use crate::maps::Estimate;

/// An illuminance for reading: no decimals from 10 lx on, below that two digits.
pub fn lux(illuminance_lx: f64) -> String {
    decimal(in_groups(&rounded(illuminance_lx, 2)))
}

/// An amount such as a flux, an area or a power: three digits, all digits before the point.
pub fn amount(number: f64) -> String {
    decimal(in_groups(&rounded(number, 3)))
}

/// A standard error: one digit, or two if the first is 1.
pub fn uncertainty(number: f64) -> String {
    let two = rounded(number, 2);
    let leading = two.chars().find(|letter| ('1'..='9').contains(letter));
    decimal(in_groups(&if leading == Some('1') { two } else { rounded(number, 1) }))
}

/// Space between a number and its unit: no line ends there.
pub const SPACE: char = '\u{a0}';

/// Sign for an unknown number.
pub const UNKNOWN: &str = "–";

/// An illuminance with its standard error: `349 ± 2`. A value below its own error is shown as an upper bound.
pub fn lux_with_error(estimate: Estimate, join: impl Fn(&str, &str) -> String) -> String {
    match estimate.is_known() {
        true => join(&lux(estimate.value), &uncertainty(estimate.standard_error)),
        false => decimal(format!("< {}", rounded(estimate.upper_bound(), 2))),
    }
}

/// An illuminance without its error: `349`, or an upper bound if it is below its own error: `< 0.27`.
pub fn lux_alone(estimate: Estimate) -> String {
    lux_with_error(estimate, |number, _| number.to_owned())
}

/// A percentage with its standard error. Both have the decimals of the error's first digit, two at most: `88.31 ± 0.01`, `45.5 ±
/// 0`. A percentage below its own error is shown as an upper bound of two digits, as illuminances are: `< 0.50`.
pub fn percents_with_error(percents: Estimate, join: impl Fn(&str, &str) -> String) -> String {
    let error = percents.standard_error;
    if error <= 0.0 {
        return join(&decimal(format!("{:.1}", percents.value)), "0");
    }
    if !percents.is_known() {
        return lux_with_error(percents, join);
    }
    let decimals = usize::try_from(-power_of_ten(error, 1)).unwrap_or(0).min(2);
    let least = 0.1f64.powi(decimals as i32);
    join(&decimal(format!("{:.decimals$}", percents.value)), &decimal(format!("{:.decimals$}", error.max(least))))
}

/// A uniformity with its standard error; [`UNKNOWN`] if there is none.
pub fn uniformity_with_error(uniformity: Option<Estimate>, join: impl Fn(&str, &str) -> String) -> String {
    uniformity.map_or(UNKNOWN.to_owned(), |uniformity| {
        let [number, error] = uniformity_digits(uniformity);
        join(&number, &error)
    })
}

/// A uniformity and its standard error: two decimals. Below 0.1 it has two significant digits, as limits such as 1:40 require.
pub fn uniformity_digits(Estimate { value, standard_error }: Estimate) -> [String; 2] {
    let error = if is_small_ratio(value) { uncertainty(standard_error) } else { ratio_uncertainty(standard_error) };
    [uniformity(value), error]
}

/// A uniformity for reading: two decimals; below 0.1 two significant digits.
pub fn uniformity(value: f64) -> String {
    if is_small_ratio(value) { decimal(significant(value, 2)) } else { ratio(value) }
}

/// Whether two decimals would leave a ratio one significant digit or none.
fn is_small_ratio(value: f64) -> bool {
    value > 0.0 && value < 0.0995
}

/// The standard error of a ratio: two decimals.
fn ratio_uncertainty(number: f64) -> String {
    if number > 0.0 && number < 0.005 { decimal("0.01") } else { ratio(number) }
}

/// A count of rays, chains, …: all digits below 10 000, else three digits in thousands, millions, …: `1.23 M`.
pub fn count(number: f64) -> String {
    match in_thousands(number) {
        (number, None) => format!("{number:.0}"),
        (number, Some(letter)) => decimal(format!("{}{SPACE}{letter}", significant(number, 3))),
    }
}

/// A count on an axis: `150 k`, `2 M`.
pub fn count_tick(number: f64) -> String {
    match in_thousands(number) {
        (number, None) => tick(number),
        (number, Some(letter)) => format!("{}{SPACE}{letter}", tick(number)),
    }
}

/// A count in thousands, millions, …, with the letter for them; unchanged below 10 000.
fn in_thousands(number: f64) -> (f64, Option<char>) {
    match number {
        n if n < 1e4 => (n, None),
        n if n < 1e6 => (n / 1e3, Some('k')),
        n if n < 1e9 => (n / 1e6, Some('M')),
        n => (n / 1e9, Some('G')),
    }
}

/// A ratio such as U0: two decimals.
pub fn ratio(number: f64) -> String {
    decimal(format!("{number:.2}"))
}

/// A fraction as percent with two digits: `1.9 %`.
pub fn percent(fraction: f64) -> String {
    percent_to(fraction, 2)
}

/// A fraction as percent with this many digits.
pub fn percent_to(fraction: f64, digits: usize) -> String {
    if !fraction.is_finite() {
        return say!("unknown").to_owned();
    }
    decimal(format!("{}{SPACE}%", rounded(100.0 * fraction, digits)))
}

/// A fraction in whole percent.
pub fn whole_percent(fraction: f64) -> String {
    format!("{:.0}{SPACE}%", 100.0 * fraction).replace('-', "−")
}

/// A time for reading: `0.52 s`, `48 s`, `3 min 20 s`, `2 h 5 min`.
pub fn duration(seconds: f64) -> String {
    match seconds.max(0.0) {
        s if s < 99.5 => decimal(format!("{}{SPACE}s", rounded(s, 2))),
        s if s < 3600.0 => format!("{}{SPACE}min {}{SPACE}s", (s / 60.0).floor(), (s % 60.0).floor()),
        s => format!("{}{SPACE}h {}{SPACE}min", (s / 3600.0).floor(), (s % 3600.0 / 60.0).floor()),
    }
}

/// A number on an axis: plain decimals without trailing zeros; powers of ten if it is very small or large.
pub fn tick(number: f64) -> String {
    if number == 0.0 {
        return "0".to_owned();
    }
    let text = if (1e-4..1e6).contains(&number.abs()) {
        trimmed(&format!("{number:.6}"))
    } else {
        let text = with_power(&format!("{number:e}"));
        text.strip_prefix("1·").map_or(text.clone(), str::to_owned)
    };
    decimal(text.replace('-', "−"))
}

/// A number with this many significant digits as a plain decimal. It always has all digits before the point.
pub fn significant(number: f64, digits: usize) -> String {
    if number == 0.0 || !number.is_finite() {
        // Adding 0 removes the sign of −0.
        return format!("{}", number + 0.0);
    }
    let decimals = (digits as i32 - 1 - power_of_ten(number, digits)).max(0) as usize;
    format!("{number:.decimals$}")
}

/// Power of ten of a number after rounding to this many significant digits: that of 9.996 is 1 for three digits, 0 for four.
pub fn power_of_ten(number: f64, digits: usize) -> i32 {
    let scientific = format!("{number:.*e}", digits - 1);
    scientific.rsplit('e').next().and_then(|power| power.parse().ok()).unwrap_or(0)
}

/// The same as [`significant`] with a proper minus sign, and with a power of ten below 0.0001.
fn rounded(number: f64, digits: usize) -> String {
    if !number.is_finite() {
        return "0".to_owned();
    }
    let is_small = number != 0.0 && power_of_ten(number, digits) < LEAST_POWER;
    if is_small { scientific(number, digits) } else { significant(number, digits).replace('-', "−") }
}

/// A number with this many significant digits and a proper minus sign: as a plain decimal if that is short, else with a power of ten.
pub fn short(number: f64, digits: usize) -> String {
    let is_long = number.is_finite() && power_of_ten(number, digits) > GREATEST_POWER;
    if is_long || !number.is_finite() { scientific(number, digits) } else { rounded(number, digits) }
}

/// Least and greatest power of ten of a short plain decimal.
const LEAST_POWER: i32 = -4;
const GREATEST_POWER: i32 = 8;

/// A number with this many significant digits and a power of ten: `1.5·10⁻⁹`.
pub fn scientific(number: f64, digits: usize) -> String {
    with_power(&format!("{number:.*e}", digits - 1)).replace('-', "−")
}

/// The power of ten of `1.5e-9` as readers write it: `1.5·10⁻⁹`.
fn with_power(text: &str) -> String {
    text.split_once('e').map_or(text.to_owned(), |(digits, power)| format!("{digits}·10{}", superscript(power)))
}

fn trimmed(text: &str) -> String {
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text.to_owned() }
}

/// A power of ten's exponent in raised digits.
fn superscript(power: &str) -> String {
    const RAISED: [char; 10] = ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'];
    let raised = |letter: char| letter.to_digit(10).map_or('⁻', |digit| RAISED[digit as usize]);
    power.chars().map(raised).collect()
}

/// A count with all its digits, and with separated thousands from 10 000 on.
pub fn grouped(count: u64) -> String {
    in_groups(&count.to_string())
}

/// Separates thousands in numbers from 10 000.
fn in_groups(text: &str) -> String {
    let whole = text.split('.').next().unwrap_or(text).len();
    if whole < 5 || text.contains('·') {
        return text.to_owned();
    }
    let mut grouped = String::with_capacity(text.len() + 4);
    for (index, letter) in text.chars().enumerate() {
        if index > 0 && index < whole && (whole - index).is_multiple_of(3) {
            grouped.push('\u{2009}');
        }
        grouped.push(letter);
    }
    grouped
}

/// The smallest step of the series 1, 2, 5, 10, … with which at most `most` steps fill the width.
pub fn round_step(width: f64, most: usize) -> f64 {
    let least = width.abs().max(f64::MIN_POSITIVE) / most.max(1) as f64;
    let power = 10f64.powf(least.log10().floor());
    let multiple = [1.0, 2.0, 5.0, 10.0].into_iter().find(|multiple| multiple * power >= least * (1.0 - 1e-9));
    multiple.unwrap_or(10.0) * power
}

/// Multiples of a round step within a range, at most `most + 1`.
pub fn round_ticks(low: f64, high: f64, most: usize) -> Vec<f64> {
    let step = round_step(high - low, most);
    // A tick at the end of the range belongs to it, despite rounding.
    let [first, last] = [(low / step - 1e-6).ceil(), (high / step + 1e-6).floor()];
    if !(last - first).is_finite() {
        return Vec::new();
    }
    (0..=(last - first).max(-1.0) as i64).map(|index| (first + index as f64) * step).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_the_digits_that_a_reader_needs() {
        assert_eq!([349.6, 12.34, 9.96, 1.234, 0.1234, 0.0].map(lux), ["350", "12", "10", "1.2", "0.12", "0"]);
        assert_eq!([0.23, 5.2, 0.148, 12.6, 0.0986, 0.0].map(uncertainty), ["0.2", "5", "0.15", "13", "0.1", "0"]);
        assert_eq!(amount(19_040.4), "19\u{2009}040");
        assert_eq!(amount(1_234_567.0), "1\u{2009}234\u{2009}567");
        assert_eq!([0.0194, 0.1, 2e-9].map(percent), ["1.9\u{a0}%", "10\u{a0}%", "2.0·10⁻⁷\u{a0}%"]);
        let counts = [7.0, 1234.0, 12_345.0, 5_170_903.0, 1.2e7].map(count);
        assert_eq!(counts, ["7", "1234", "12.3\u{a0}k", "5.17\u{a0}M", "12.0\u{a0}M"]);
        assert_eq!([1234, 1_234_567].map(grouped), ["1234", "1\u{2009}234\u{2009}567"]);
        assert_eq!([2e-10, 1.5e12].map(amount), ["2.00·10⁻¹⁰", "1\u{2009}500\u{2009}000\u{2009}000\u{2009}000"]);
        assert_eq!([-1.5e-9, 1.5e12, 0.0123].map(|number| short(number, 2)), ["−1.5·10⁻⁹", "1.5·10¹²", "0.012"]);
        assert_eq!(
            [0.523, 61.0, 200.0, 3723.0].map(duration),
            ["0.52\u{a0}s", "61\u{a0}s", "3\u{a0}min 20\u{a0}s", "1\u{a0}h 2\u{a0}min"]
        );
        assert_eq!([0.0, 0.1, -0.25, 2000.0, 1e-5, 3e7].map(tick), ["0", "0.1", "−0.25", "2000", "10⁻⁵", "3·10⁷"]);
    }

    #[test]
    fn percents_go_to_their_errors_first_digit() {
        let texts = |value: f64, standard_error: f64| {
            percents_with_error(Estimate { value, standard_error }, |number, error| format!("{number} ± {error}"))
        };
        assert_eq!(
            [texts(88.309, 0.008), texts(45.45, 0.0), texts(51.23, 0.05)],
            ["88.31 ± 0.01", "45.5 ± 0", "51.23 ± 0.05"]
        );
        assert_eq!([texts(91.2, 0.31), texts(47.0, 13.0), texts(0.1, 0.2)], ["91.2 ± 0.3", "47 ± 13", "< 0.50"]);
    }

    #[test]
    fn small_uniformities_keep_two_digits() {
        let texts = |value: f64, standard_error: f64| {
            uniformity_with_error(Some(Estimate { value, standard_error }), |number, error| {
                format!("{number} ± {error}")
            })
        };
        assert_eq!([texts(0.821, 0.0029), texts(0.0536, 0.021)], ["0.82 ± 0.01", "0.054 ± 0.02"]);
        assert_eq!(
            [texts(0.025, 0.0013), texts(0.0996, 0.02), texts(0.0, 0.0)],
            ["0.025 ± 0.0013", "0.10 ± 0.02", "0.00 ± 0.00"]
        );
    }

    #[test]
    fn significant_digits_are_those_of_the_rounded_number() {
        for (number, digits, text) in [
            (9.996, 3, "10.0"),
            (9.996, 4, "9.996"),
            (9.9996, 4, "10.00"),
            (0.099_96, 3, "0.100"),
            (999.6, 3, "1000"),
            (-0.0, 3, "0"),
            (1234.5, 3, "1234"),
        ] {
            assert_eq!(significant(number, digits), text);
        }
    }

    #[test]
    fn ticks_are_round_and_within() {
        assert_eq!(round_ticks(0.0, 8.0, 8), [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0]);
        assert_eq!(round_ticks(0.13, 0.49, 4), [0.2, 0.30000000000000004, 0.4]);
        assert_eq!(round_step(430.0, 8), 100.0);
        assert!(round_ticks(1.0, 1.0, 5).len() <= 1);
    }
}
