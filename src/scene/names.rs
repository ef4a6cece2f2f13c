//! Names in messages: lists of allowed names and the nearest name to a mistyped one.

use glam::DVec3;

/// Returns the allowed name that a mistyped one most likely means.
pub(super) fn nearest<'a>(typed: &str, allowed: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    /// Longest typed name in bytes. Longer ones are no typing errors. The time per pair grows with the square of the length.
    const LONGEST: usize = 200;
    /// Only this many names of a list are compared.
    const MOST_COMPARED: usize = 10_000;
    if typed.len() > LONGEST {
        return None;
    }
    let lower = typed.to_lowercase();
    allowed
        .into_iter()
        .take(MOST_COMPARED)
        .filter(|name| name.len() <= LONGEST)
        .map(|name| (edits(&lower, &name.to_lowercase()), name))
        .filter(|(edits, name)| *edits <= 1 + name.chars().count() / 3)
        .min_by_key(|(edits, _)| *edits)
        .map(|(_, name)| name)
}

/// Joins names as `"a", "b" or "c"`. Long lists are cut.
pub(crate) fn listed<'a>(names: impl IntoIterator<Item = &'a str>) -> String {
    /// Most names in a message.
    const MOST_QUOTED: usize = 16;
    let names: Vec<&str> = names.into_iter().collect();
    let quoted: Vec<String> = names.iter().take(MOST_QUOTED).map(|name| format!("\"{name}\"")).collect();
    if names.len() > MOST_QUOTED {
        return format!("{}, … ({} in all)", quoted.join(", "), names.len());
    }
    match quoted.as_slice() {
        [] => "none".into(),
        [only] => only.clone(),
        [first @ .., last] => format!("{} or {last}", first.join(", ")),
    }
}

/// Joins names as `a, b, c`. Long lists show the first few names and the number of the others.
pub(crate) fn joined(names: &[String]) -> String {
    /// Most names in a sentence.
    const MOST_JOINED: usize = 8;
    let more =
        if names.len() > MOST_JOINED { format!(" and {} more", names.len() - MOST_JOINED) } else { String::new() };
    format!("{}{more}", names[..names.len().min(MOST_JOINED)].join(", "))
}

/// Levenshtein's distance: the number of insertions, deletions and replacements of characters.
fn edits(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.chars().collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, a) in a.chars().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, b) in b.iter().enumerate() {
            let replaced = diagonal + usize::from(a != *b);
            diagonal = row[j + 1];
            row[j + 1] = replaced.min(row[j] + 1).min(diagonal + 1);
        }
    }
    row[b.len()]
}

/// Writes a point for messages: `(1.2, 0, 2.801) m`. It is rounded to 0.1 mm, or to five digits of its largest coordinate if that is
/// finer.
pub(crate) fn place_words(place_m: DVec3) -> String {
    let power = place_m.abs().max_element().log10().floor().clamp(-300.0, 300.0) as i32;
    let scale = 10f64.powi((4 - power).clamp(4, 300));
    // Adding 0 turns −0 into 0.
    let rounded_m = |m: f64| Some((m * scale).round() / scale + 0.0).filter(|m| m.is_finite()).unwrap_or(m);
    let [x, y, z] = place_m.to_array().map(rounded_m);
    format!("({x}, {y}, {z}) m")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_name_is_the_one_with_the_fewest_edits() {
        let keys = ["reflectance", "type", "material"];
        assert_eq!(nearest("reflectence", keys), Some("reflectance"));
        assert_eq!(nearest("Type", keys), Some("type"));
        assert_eq!(nearest("colour", keys), None);
        assert_eq!(edits("kitten", "sitting"), 3);
    }

    #[test]
    fn places_are_reported_as_far_as_anybody_measures() {
        for (place_m, words) in [
            (DVec3::new(1.2, -0.0, 2.8009999999999997), "(1.2, 0, 2.801) m"),
            (DVec3::new(-0.00001, 12345.67891, 0.30000000000000004), "(0, 12345.6789, 0.3) m"),
            (DVec3::new(1.5e-7, 0.1 + 0.2 - 0.3, 3.0e-9), "(0.00000015, 0, 0.000000003) m"),
            (DVec3::ZERO, "(0, 0, 0) m"),
        ] {
            assert_eq!(place_words(place_m), words);
        }
        assert!(place_words(DVec3::new(f64::NAN, f64::INFINITY, 1e308)).starts_with("(NaN, inf, 1"));
    }
}
