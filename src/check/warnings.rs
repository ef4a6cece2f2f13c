//! Arranges warnings for the reader: one warning for many equal ones, and the most serious first.

use std::collections::{HashMap, HashSet};

use crate::scene::{Luminaire, Scene};

/// Largest number of names in a warning. For more luminaires it gives their number.
const MOST_NAMES: usize = 4;

/// Words of grave warnings: unless the cause is corrected, the results are not those of the intended room.
const GRAVE: [&str; 10] = [
    "gives no light",
    "is dark",
    "are outside of",
    "is outside of",
    "inside of a closed solid",
    "large for what is lit",
    "length_unit",
    "solids intersect",
    "normals may be flipped",
    "left out, because",
];
/// Words of remarks on how a file was read, and on things that may well be intended.
const SLIGHT: [&str; 10] = [
    "maintenance",
    "is taken",
    "was taken",
    "were ignored",
    "read as",
    "header",
    "gamma runs from",
    "cannot be chosen by --maps",
    "can only stand alone in --maps",
    "parallelogram",
];

/// Merges equal warnings of several things into one, and puts grave warnings first. Otherwise it keeps their order.
pub(super) fn arrange(scene: &mut Scene) {
    let scene_names = scene.surfaces.iter().map(|surface| surface.name.as_str());
    let scene_names = scene_names.chain(scene.luminaires.iter().map(|luminaire| luminaire.name.as_str()));
    let names: HashSet<&str> = scene_names.chain(scene.receivers.iter().map(|set| set.name.as_str())).collect();
    let mut warnings = grouped(&scene.warnings, |name| names.contains(name));
    warnings.sort_by_key(|warning| rank(warning));
    scene.warnings = warnings;
}

/// Returns the names of luminaires, or their number and the first name.
pub(super) fn names<'a>(luminaires: impl IntoIterator<Item = &'a Luminaire>) -> String {
    let names: Vec<&str> = luminaires.into_iter().map(|luminaire| luminaire.name.as_str()).collect();
    match names.len() {
        0..=MOST_NAMES => names.join(", "),
        count => format!("{count} luminaires ({}, …)", names[0]),
    }
}

fn rank(warning: &str) -> u32 {
    let has = |words: &[&str]| words.iter().any(|words| warning.contains(words));
    match warning {
        _ if has(&GRAVE) => 0,
        _ if has(&SLIGHT) => 2,
        _ => 1,
    }
}

/// Merges warnings that differ only in the name before the colon, at the position of the first of them.
fn grouped(warnings: &[String], is_name: impl Fn(&str) -> bool) -> Vec<String> {
    let parts = |warning: &str| {
        // Names may contain colons.
        let ends = warning.match_indices(": ").map(|(end, _)| end);
        let end = ends.into_iter().find(|end| is_name(&warning[..*end]))?;
        Some((warning[..end].to_owned(), warning[end + 2..].to_owned()))
    };
    let mut groups: Vec<(Vec<String>, String)> = Vec::new();
    let mut known: HashMap<String, usize> = HashMap::new();
    for warning in warnings {
        let Some((name, words)) = parts(warning) else {
            groups.push((Vec::new(), warning.clone()));
            continue;
        };
        let place = *known.entry(words.clone()).or_insert_with(|| {
            groups.push((Vec::new(), words));
            groups.len() - 1
        });
        groups[place].0.push(name);
    }
    let text = |(names, words): (Vec<String>, String)| match &names[..] {
        [] => words,
        [name] => format!("{name}: {words}"),
        [first, .., last] => format!("{first} … {last} ({} alike): {words}", names.len()),
    };
    groups.into_iter().map(text).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_warnings_of_many_things_are_one() {
        let mut warnings: Vec<String> =
            (1..=512).map(|number| format!("lamp: {number}: this luminaire gives no light")).collect();
        warnings.push("lamp: 7: aim has no effect".to_owned());
        warnings.push("mesh: a hole".to_owned());
        let is_name = |name: &str| name.starts_with("lamp: ") && !name.ends_with("light");
        assert_eq!(
            grouped(&warnings, is_name),
            [
                "lamp: 1 … lamp: 512 (512 alike): this luminaire gives no light",
                "lamp: 7: aim has no effect",
                "mesh: a hole"
            ]
        );
    }

    #[test]
    fn what_spoils_results_comes_first() {
        let ranks = [
            "work plane: 3 of 9 points lie inside of a closed solid",
            "wall: its normal looks away",
            "no luminaire has a maintenance_factor: results are those of a new installation",
        ]
        .map(rank);
        assert_eq!(ranks, [0, 1, 2]);
    }
}
