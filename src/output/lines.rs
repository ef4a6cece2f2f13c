//! Translates lines from other rooms, such as warnings and notes, into the current language.
//!
//! The lines come as English text with names and numbers in it. [`LINES`] holds the wording of the most common ones. A line that
//! matches one is translated, whatever stands between its words. Other lines stay English, and pages mark them so.

use super::picture::escaped;
use super::texts::{Language, decimal, language, said_with};

/// Wordings of lines, with `{}` for the variable parts. The first match counts, so a long wording comes before its own beginning.
const LINES: [&str; 35] = [
    "{}: luminaires in sight that have no position index in CIE 117 do not count: {}",
    "{} beside or behind the observer ({})",
    "{} below the line of sight ({})",
    "{} too far aside (T/R above 3) ({})",
    "{} too steeply above the eye (H/R beyond the table, at most 1.9) ({})",
    "a run to stated errors of {} tried to decide the verdicts",
    "{} runs to stated errors of {} tried to decide the verdicts",
    "no luminaire has a maintenance_factor: results are those of a new installation",
    "no luminaire gives light, so that everything is dark: all have a flux, a dimming or a factor of 0",
    "{}: this luminaire gives no light",
    "{}: this luminaire is outside of the scene's bounding box ({} m; the box goes from {} to {} m)",
    "{}: these luminaires are outside of the scene's bounding box (the first at {} m; the box goes from {} to {} m)",
    "{}: {} of {} points lies inside of a closed solid and is left out of tables and errors",
    "{}: {} of {} points lie inside of a closed solid; they are left out of tables and errors",
    "{}: the sphere is approximated by {} inscribed triangles; their area is {} % too small",
    "{}: its sides are not at right angles; it is taken as a parallelogram",
    "{}: a receiver of this name cannot be chosen by --maps",
    "{}: a name with a comma can only stand alone in --maps",
    "the luminaire is not symmetric about both its planes: tables of CIE 190 are not made for it; here its C0 (crosswise) or C90 (endwise) side faces the observer",
    "the luminous opening has {} m², below the {} m² from which on UGR is defined (CIE 117): tables overrate small sources",
    "the file contains {} sets of lamps; the first, {}, is taken",
    "{} values after the last intensity were ignored",
    "planes given twice differ by up to {} % of the maximum; the first was taken",
    "gamma runs from {} to {} degrees; outside of it the intensity is 0",
    "vertical angles run from {} to {} degrees; outside of them the intensity is 0",
    "all intensities or the lamps' flux are 0: the luminaire is dark",
    "all intensities are 0: the luminaire is dark",
    "the intensities add up to {} lm, {} % of the lamps' {} lm, where the file states {} %; the flux from the intensities is used",
    "the intensities add up to {} lm, more than the {} lm that the file states for {} lamp; the flux from the intensities is used",
    "the intensities add up to {} lm, more than the {} lm that the file states for {} lamps; the flux from the intensities is used",
    "{} % of the flux goes downward, where the header states {} %",
    "numbers are written with decimal commas; they were read as such",
    "the edition `{}` is unknown; read as LM-63-2002",
    "no plane lies within the last {} degrees of the full turn; intensities there are interpolated",
    "{} lumens per lamp: read as -1, absolute photometry",
];

/// An item of a list on a page: the translated line, or the English one, marked as English.
pub(super) fn line_item(english: &str) -> String {
    match translated(english) {
        Some(line) => format!("<li>{}</li>\n", escaped(&line)),
        None => format!("<li lang=\"en\">{}</li>\n", escaped(english)),
    }
}

/// A line in the current language; `None` if its wording is unknown, and in English.
fn translated(english: &str) -> Option<String> {
    if language() == Language::ENGLISH {
        return None;
    }
    for line in LINES {
        if let Some(parts) = parts_of(english, line) {
            let parts: Vec<String> = parts.into_iter().map(translated_part).collect();
            let values: Vec<&dyn std::fmt::Display> = parts.iter().map(|part| part as &dyn std::fmt::Display).collect();
            return Some(said_with(line, &values));
        }
    }
    // Warnings on a file follow the name of the object that uses the file.
    let (name, rest) = english.split_once(": ")?;
    Some(format!("{name}: {}", translated(rest)?))
}

/// Translates a variable part: a list of lines, a number, or a name.
fn translated_part(part: &str) -> String {
    let is_number = part.chars().all(|letter| letter.is_ascii_digit() || ".,-% e".contains(letter));
    if is_number {
        return part.split(", ").map(decimal).collect::<Vec<_>>().join("; ");
    }
    part.split("; ").map(|piece| translated(piece).unwrap_or_else(|| piece.to_owned())).collect::<Vec<_>>().join("; ")
}

/// The variable parts of a text by a wording; `None` if the text does not match it.
fn parts_of<'a>(text: &'a str, line: &str) -> Option<Vec<&'a str>> {
    let mut words = line.split("{}");
    let mut rest = text.strip_prefix(words.next()?)?;
    let mut parts = Vec::new();
    let mut words = words.peekable();
    while let Some(word) = words.next() {
        let at = match (word.is_empty(), words.peek()) {
            // The last variable part takes the rest.
            (true, None) => rest.len(),
            (_, None) => {
                rest.len().checked_sub(word.len()).filter(|at| rest.is_char_boundary(*at) && rest[*at..] == *word)?
            }
            _ => rest.find(word)?,
        };
        parts.push(&rest[..at]);
        rest = &rest[at + word.len()..];
    }
    rest.is_empty().then_some(parts)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::output::in_language;
    use crate::output::texts::said;

    #[test]
    fn what_differs_is_found_between_the_words() {
        assert_eq!(parts_of("3 of 7 lie", "{} of {} lie"), Some(vec!["3", "7"]));
        assert_eq!(parts_of("a: b: c", "{}: {}"), Some(vec!["a", "b: c"]));
        assert_eq!(parts_of("nothing differs", "nothing differs"), Some(vec![]));
        assert_eq!(parts_of("nothing differs here", "nothing differs"), None);
        assert_eq!(parts_of("3 of 7 lay", "{} of {} lie"), None);
    }

    #[test]
    fn lines_are_said_in_german_with_their_numbers_and_lists() {
        let german = Language::of_code("de").expect("there is German");
        let item = |line: &str| in_language(german, || line_item(line));
        let glare = "seats: luminaires in sight that have no position index in CIE 117 do not count: \
                     1 too far aside (T/R above 3) (lamp 2); 2 below the line of sight (lamp 3, lamp 4)";
        let text = item(glare);
        assert!(
            text.starts_with("<li>seats: ")
                && text.contains("1 zu weit seitlich")
                && text.contains("2 unter der Blickrichtung"),
            "{text}"
        );
        let text = item("2 runs to stated errors of 3.00 %, 1.36 % tried to decide the verdicts");
        assert!(text.contains("3,00 %; 1,36 %") && text.starts_with("<li>2 "), "{text}");
        // The line follows the name of the object that uses the file. Unknown words stay as they are.
        assert!(item("spot: 12 values after the last intensity were ignored").starts_with("<li>spot: 12 Werte"));
        assert_eq!(item("spot: who knows"), "<li lang=\"en\">spot: who knows</li>\n");
        assert_eq!(line_item("spot: who knows"), "<li lang=\"en\">spot: who knows</li>\n");
    }

    #[test]
    fn every_line_has_words() {
        let german = Language::of_code("de").expect("there is German");
        in_language(german, || {
            for line in LINES {
                assert_ne!(said(line), line);
            }
        });
    }
}
