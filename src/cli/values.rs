//! Parses values of options as users write them: `1%`, `60s`, `1_000_000`, `0:3:31`.
//!
//! The errors are texts for clap, which puts the option and its value before them.

use crate::check::MeshCheck;
use crate::scene::ReceiversPart;
use crate::solver::Share;

/// Largest number of worker threads.
const MOST_THREADS: usize = 1024;
/// Largest number of chains of a map: the limit of the counters of samples.
const MOST_CHAINS: u64 = 1 << 36;
/// Largest number of values of `from:to:count`.
const MOST_VALUES: usize = 1_000_000;
/// Longest time limit in s: a century.
const LONGEST_S: f64 = 3.2e9;

/// A relative error: `1%` or `0.01`, above 0 and below 1.
pub fn target_error(text: &str) -> Result<f64, String> {
    const REMEDY: &str = "write a relative error above 0 and below 1, such as 1% or 0.01";
    let error = number_or_percent(text).ok_or_else(|| format!("not a number; {REMEDY}"))?;
    if error > 0.0 && error < 1.0 {
        return Ok(error);
    }
    Err(format!("{}; {REMEDY}", if error >= 1.0 { "100% or more is no target" } else { "no run can reach it" }))
}

/// A part of a whole: `0.2` or `20%`.
pub fn part(text: &str) -> Result<f64, String> {
    const REMEDY: &str = "write a share from 0 to 1, such as 20% or 0.2";
    number_or_percent(text).filter(|part| (0.0..=1.0).contains(part)).ok_or_else(|| REMEDY.to_owned())
}

fn number_or_percent(text: &str) -> Option<f64> {
    let text = text.trim();
    let (digits, unit) = text.strip_suffix('%').map_or((text, 1.0), |digits| (digits.trim_end(), 100.0));
    Some(digits.parse::<f64>().ok()? / unit)
}

/// Parses the name of a check of meshes.
pub fn mesh_check(text: &str) -> Result<MeshCheck, String> {
    let names = MeshCheck::ALL.map(MeshCheck::name).join(", ");
    let found = MeshCheck::ALL.into_iter().find(|check| check.name() == text.trim());
    found.ok_or_else(|| format!("no such check of meshes; name some of {names}, separated by commas"))
}

/// A share of a run: `3/8`, counted from 1.
pub fn share(text: &str) -> Result<Share, String> {
    let (number, of) = one_of(text, "share")?;
    Ok(Share { number, of })
}

/// A part of the receivers: `3/8`, counted from 1.
pub fn receivers_part(text: &str) -> Result<ReceiversPart, String> {
    let (number, of) = one_of(text, "part")?;
    Ok(ReceiversPart { number, of })
}

/// One of several: `3/8`, counted from 1.
fn one_of(text: &str, what: &str) -> Result<(u32, u32), String> {
    let remedy = format!("write the number of the {what} and the total, such as 3/8, counted from 1");
    let (number, of) = text.split_once('/').ok_or_else(|| format!("no {what}; {remedy}"))?;
    let count = |part: &str| part.trim().parse::<u32>().map_err(|_| format!("\"{part}\" is no number; {remedy}"));
    let (number, of) = (count(number)?, count(of)?);
    if (1..=of).contains(&number) { Ok((number, of)) } else { Err(format!("there is no such {what}; {remedy}")) }
}

/// Sets of reflectances of ceiling, walls and reference plane, as fractions.
#[derive(Clone, Debug, PartialEq)]
pub struct Reflectances(pub Vec<[f64; 3]>);

/// Sets of reflectances in percent: `70/50/20,50/30/20`, each from 0 to below 100.
pub fn reflectances(text: &str) -> Result<Reflectances, String> {
    const REMEDY: &str = "write ceiling, walls and reference plane in percent, such as 70/50/20 or 70/50/20,50/30/20";
    let set = |text: &str| {
        let numbers: Vec<f64> = text
            .split('/')
            .map(|part| part.trim().parse().map_err(|_| format!("\"{part}\" is not a number; {REMEDY}")))
            .collect::<Result<_, String>>()?;
        if let Some(wrong) = numbers.iter().find(|percent| !(0.0..100.0).contains(*percent)) {
            return Err(format!("{wrong} is not from 0 to below 100; {REMEDY}"));
        }
        let percents: [f64; 3] = numbers
            .try_into()
            .map_err(|numbers: Vec<f64>| format!("{} numbers instead of 3; {REMEDY}", numbers.len()))?;
        Ok(percents.map(|percent| percent / 100.0))
    };
    Ok(Reflectances(text.split(',').map(set).collect::<Result<_, String>>()?))
}

/// A time in s: a number with `ms`, `s`, `m`, `h`, or without a unit (seconds).
pub fn time_s(text: &str) -> Result<f64, String> {
    const REMEDY: &str = "write a time above 0, such as 60s, 500ms, 5m or 1.5h; a plain number counts seconds";
    let text = text.trim();
    let start_of_unit = text.find(|letter: char| letter.is_ascii_alphabetic() && letter != 'e').unwrap_or(text.len());
    let (digits, unit) = text.split_at(start_of_unit);
    let unit_s = match unit {
        "" | "s" => 1.0,
        "ms" => 1e-3,
        "m" | "min" => 60.0,
        "h" => 3600.0,
        _ => return Err(format!("\"{unit}\" is no unit of time; {REMEDY}")),
    };
    let time_s = digits.trim_end().parse::<f64>().map_err(|_| format!("not a number; {REMEDY}"))? * unit_s;
    if time_s > 0.0 && time_s <= LONGEST_S {
        return Ok(time_s);
    }
    Err(format!("out of range; {REMEDY}"))
}

/// Memory in bytes: a number with `MB`, `GB`, `MiB`, `GiB` or a similar unit, or without a unit (bytes).
pub fn bytes(text: &str) -> Result<u64, String> {
    const REMEDY: &str = "write an amount of at least 64 MB, such as 2GB, 512MiB or 2e9";
    const LEAST: f64 = 64e6;
    let text = text.trim();
    let start_of_unit = text.find(|letter: char| letter.is_ascii_alphabetic() && letter != 'e').unwrap_or(text.len());
    let (digits, unit) = text.split_at(start_of_unit);
    let unit_bytes = match unit.to_ascii_lowercase().as_str() {
        "" | "b" => 1.0,
        "kb" | "k" => 1e3,
        "mb" | "m" => 1e6,
        "gb" | "g" => 1e9,
        "tb" | "t" => 1e12,
        "kib" => 1024.0,
        "mib" => 1024.0 * 1024.0,
        "gib" => 1024.0 * 1024.0 * 1024.0,
        "tib" => 1024.0 * 1024.0 * 1024.0 * 1024.0,
        _ => return Err(format!("\"{unit}\" is no unit of memory; {REMEDY}")),
    };
    let bytes = digits.trim_end().parse::<f64>().map_err(|_| format!("not a number; {REMEDY}"))? * unit_bytes;
    if (LEAST..=1e18).contains(&bytes) { Ok(bytes as u64) } else { Err(format!("out of range; {REMEDY}")) }
}

/// A number of chains: a whole number above 0, `1_000_000` and `1e6` included.
pub fn chains(text: &str) -> Result<u64, String> {
    let remedy = format!("write a whole number from 1 to {MOST_CHAINS}, such as 1000000, 1_000_000 or 1e6");
    let is_too_large = text.parse().is_ok_and(|number: f64| number > MOST_CHAINS as f64);
    let fault = if is_too_large { "out of range" } else { "not a whole number" };
    let chains = whole_number(text).ok_or_else(|| format!("{fault}; {remedy}"))?;
    if (1..=MOST_CHAINS).contains(&chains) { Ok(chains) } else { Err(format!("out of range; {remedy}")) }
}

/// A seed: any whole number that 64 bits hold.
pub fn seed(text: &str) -> Result<u64, String> {
    text.replace('_', "").parse().map_err(|_| format!("write a whole number from 0 to {}", u64::MAX))
}

/// Worker threads.
pub fn threads(text: &str) -> Result<usize, String> {
    let threads = text.parse().ok().filter(|threads| (1..=MOST_THREADS).contains(threads));
    threads.ok_or_else(|| format!("write a whole number from 1 to {MOST_THREADS}"))
}

fn whole_number(text: &str) -> Option<u64> {
    let plain = text.trim().replace('_', "");
    if let Ok(number) = plain.parse() {
        return Some(number);
    }
    let number: f64 = plain.parse().ok()?;

    // Up to this number, every whole f64 is exact.
    const EXACT: f64 = 9_007_199_254_740_992.0;
    (number.fract() == 0.0 && (0.0..=EXACT).contains(&number)).then_some(number as u64)
}

/// Distances: `0,0.5,1` in the order given, or `from:to:count` evenly spaced with both ends.
pub fn distances(text: &str) -> Result<Distances, String> {
    const REMEDY: &str = "write numbers of at least 0, as 0,0.5,1 or as from:to:count (0:3:31)";
    let number = |text: &str| {
        let number = text.trim().parse::<f64>().ok().filter(|number| number.is_finite() && *number >= 0.0);
        number.ok_or_else(|| format!("\"{}\" is no distance; {REMEDY}", text.trim()))
    };
    let parts: Vec<&str> = text.split(':').collect();
    match parts.as_slice() {
        [list] => list.split(',').map(number).collect::<Result<_, _>>().map(Distances),
        [from, to, count] => {
            let (from, to) = (number(from)?, number(to)?);
            let count = count.trim().parse::<usize>().ok().filter(|count| (1..=MOST_VALUES).contains(count));
            let count = count.ok_or_else(|| format!("the count must be from 1 to {MOST_VALUES}; {REMEDY}"))?;
            Ok(Distances(evenly_spaced(from, to, count)))
        }
        _ => Err(REMEDY.to_owned()),
    }
}

/// A list of distances.
#[derive(Clone, Debug, PartialEq)]
pub struct Distances(pub Vec<f64>);

/// Values from `from` to `to`, both exact. A count of 1 gives `from` alone.
fn evenly_spaced(from: f64, to: f64, count: usize) -> Vec<f64> {
    let last = count.saturating_sub(1).max(1) as f64;
    (0..count).map(|index| if index == 0 { from } else { from + (to - from) * index as f64 / last }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reflectances_are_percentages() {
        assert_eq!(reflectances("70/50/20, 0/0/0"), Ok(Reflectances(vec![[0.7, 0.5, 0.2], [0.0; 3]])));
        for refused in ["70/50", "70/50/20/10", "100/50/20", "-1/50/20", "a/b/c", "", "70/50/nan"] {
            assert!(reflectances(refused).is_err(), "{refused}");
        }
    }

    #[test]
    fn errors_read_as_fractions_or_percent_within_bounds() {
        assert_eq!(target_error("1%"), Ok(0.01));
        assert_eq!(target_error(" 2.5 %"), Ok(0.025));
        assert_eq!(target_error("0.01"), Ok(0.01));
        for refused in ["0", "-1%", "100%", "1", "nan", "inf", "", "%", "1%%", "1 lx"] {
            assert!(target_error(refused).is_err(), "{refused}");
        }
    }

    #[test]
    fn times_read_in_every_unit() {
        for (text, seconds) in [
            ("60", 60.0),
            ("60s", 60.0),
            ("500ms", 0.5),
            ("5m", 300.0),
            ("5 min", 300.0),
            ("1.5h", 5400.0),
            ("1e2s", 100.0),
        ] {
            let read = time_s(text).unwrap_or(f64::NAN);
            assert!((read - seconds).abs() < 1e-12 * seconds, "{text}: {read}");
        }
        for refused in ["0", "-1s", "1d", "s", "", "nan", "inf", "1e300h"] {
            assert!(time_s(refused).is_err(), "{refused}");
        }
    }

    #[test]
    fn counts_read_with_underscores_and_exponents() {
        assert_eq!(chains("20000"), Ok(20_000));
        assert_eq!(chains("1_000_000"), Ok(1_000_000));
        assert_eq!(chains("1e6"), Ok(1_000_000));
        for refused in ["0", "-1", "1.5", "1e99", "x", "", "nan"] {
            assert!(chains(refused).is_err(), "{refused}");
        }
        assert_eq!(seed("18446744073709551615"), Ok(u64::MAX));
        assert!(seed("18446744073709551616").is_err());
        assert!(threads("0").is_err() && threads("2") == Ok(2));
    }

    #[test]
    fn distances_keep_their_order_and_both_ends() {
        assert_eq!(distances("1, 0,0.5"), Ok(Distances(vec![1.0, 0.0, 0.5])));
        let Ok(Distances(spaced)) = distances("0:3:31") else { panic!("an even spacing was refused") };
        assert_eq!((spaced.len(), spaced[0], spaced[1], spaced[30]), (31, 0.0, 0.1, 3.0));
        assert_eq!(distances("2:3:1"), Ok(Distances(vec![2.0])));
        for refused in ["", "1,,2", "-1", "0:1", "0:1:0", "0:1:2:3", "nan", "0:inf:3"] {
            assert!(distances(refused).is_err(), "{refused}");
        }
    }
}
