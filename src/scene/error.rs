//! The message for a refused scene file: where, what, got, expected, and a remedy.

use std::fmt;
use std::ops::Deref;
use std::path::{Path, PathBuf};

/// A scene file, or a file that it names, that cannot be read. Nothing of it is used.
///
/// Its fields are those of [`Refusal`]. `Display` writes them over several lines, with the line of the file and a caret below the error.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneError(Box<Refusal>);

/// All fields of a refusal.
#[derive(Clone, Debug, PartialEq)]
pub struct Refusal {
    /// The file that contains the error: the scene file, or the mesh, points or photometric file that it names.
    pub path: PathBuf,
    /// Position in that file; `None` if the file as a whole is wrong (missing, unreadable).
    pub place: Option<TextPlace>,
    /// The entry of the scene file that names this file, if the error is in another file than the scene file.
    pub named_by: Option<String>,
    /// What is wrong, in one sentence.
    pub what: String,
    /// What the file contains.
    pub got: String,
    /// What the file could contain.
    pub expected: String,
    /// What to do about it.
    pub remedy: String,
}

/// A position in a text file.
#[derive(Clone, Debug, PartialEq)]
pub struct TextPlace {
    /// Line, counted from 1.
    pub line: usize,
    /// Column in characters, counted from 1.
    pub column: usize,
    /// Path to the value inside the JSON, such as `geometry[0].min[1]`; empty at the top and in files that are not JSON.
    pub json_path: String,
    /// The text of the line, or the part of it around the position.
    pub excerpt: String,
    /// Number of characters of the excerpt before the position.
    pub indent: usize,
    /// Length of the marked text in characters, at least 1.
    pub length: usize,
}

/// Longest excerpt of a line in a message, in characters.
const EXCERPT_CHARACTERS: usize = 110;
/// Number of characters of a long line that a message shows before the position.
const EXCERPT_BEFORE: usize = 50;

impl SceneError {
    pub(super) fn new(refusal: Refusal) -> SceneError {
        SceneError(Box::new(refusal))
    }

    /// Makes a refusal of a file as a whole.
    pub(super) fn of_file(path: &Path, what: String, got: String, expected: &str, remedy: &str) -> SceneError {
        SceneError::new(Refusal {
            path: path.to_path_buf(),
            place: None,
            named_by: None,
            what,
            got,
            expected: expected.into(),
            remedy: remedy.into(),
        })
    }

    pub(super) fn named_by(mut self, named_by: String) -> SceneError {
        self.0.named_by = Some(named_by);
        self
    }
}

impl Deref for SceneError {
    type Target = Refusal;

    fn deref(&self) -> &Refusal {
        &self.0
    }
}

impl TextPlace {
    /// Returns the position of a byte range of a text. A range past the end moves to the end. A bound within a character moves to its
    /// start.
    pub(super) fn of(text: &str, start: usize, end: usize, json_path: &str) -> TextPlace {
        let floor = |mut byte: usize| {
            byte = byte.min(text.len());
            while !text.is_char_boundary(byte) {
                byte -= 1;
            }
            byte
        };
        let start = floor(start);
        let end = floor(end).max(start);
        let line_start = text[..start].rfind('\n').map_or(0, |newline| newline + 1);
        let line_end = text[start..].find('\n').map_or(text.len(), |newline| start + newline);
        let before = text[line_start..start].chars().count();
        let length = text[start..end.min(line_end)].chars().count().max(1);

        // A minified file is one endless line, so the excerpt shows only the text around the position.
        let skipped = before.saturating_sub(EXCERPT_BEFORE);
        let excerpt: String = text[line_start..line_end]
            .chars()
            .skip(skipped)
            .take(EXCERPT_CHARACTERS)
            .map(|character| if character.is_control() { ' ' } else { character })
            .collect();
        let indent = before - skipped;
        TextPlace {
            line: text[..start].matches('\n').count() + 1,
            column: before + 1,
            json_path: json_path.to_string(),
            excerpt: excerpt.trim_end().to_string(),
            indent,
            length: length.min(EXCERPT_CHARACTERS - indent),
        }
    }
}

impl fmt::Display for SceneError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}", self.what)?;
        match &self.place {
            None => writeln!(f, "  in {}", self.path.display())?,
            Some(place) => {
                write!(f, "  in {}, line {}, column {}", self.path.display(), place.line, place.column)?;
                if !place.json_path.is_empty() {
                    write!(f, ", at {}", place.json_path)?;
                }
                let number = place.line.to_string();
                let margin = " ".repeat(number.len());
                writeln!(f, "\n  {margin} |\n  {number} | {}", place.excerpt)?;
                writeln!(f, "  {margin} | {}{}", " ".repeat(place.indent), "^".repeat(place.length))?;
            }
        }
        if let Some(named_by) = &self.named_by {
            writeln!(f, "  named by {named_by}")?;
        }
        writeln!(f, "  got:      {}", self.got)?;
        writeln!(f, "  expected: {}", self.expected)?;
        write!(f, "  remedy:   {}", self.remedy)
    }
}

impl std::error::Error for SceneError {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_place_counts_lines_and_characters_from_one() {
        let text = "{\n  \"ä\": 1\n}";
        let start = text.find('1').expect("the text has a 1");
        let place = TextPlace::of(text, start, start + 1, "ä");
        assert_eq!((place.line, place.column, place.length), (2, 8, 1));
        assert_eq!(place.excerpt, "  \"ä\": 1");
    }

    #[test]
    fn a_long_line_is_cut_around_the_place() {
        let text = format!("{}X{}", "a".repeat(5000), "b".repeat(5000));
        let place = TextPlace::of(&text, 5000, 5001, "");
        assert_eq!(place.column, 5001);
        assert_eq!(place.excerpt.chars().nth(place.indent), Some('X'));
        assert!(place.excerpt.chars().count() <= EXCERPT_CHARACTERS);
    }

    #[test]
    fn a_range_off_the_text_has_a_place_all_the_same() {
        for (start, end) in [(1, 1), (3, 900), (900, 901)] {
            let place = TextPlace::of("ä\n", start, end, "");
            assert!(place.length >= 1);
        }
    }
}
