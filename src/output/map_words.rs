//! The texts of a map: title and numbers above it, notes below.

use super::axes::TYPE;
use super::color::SOFT;
use super::flat::FlatMap;
use super::font::text_width;
use super::numbers::{UNKNOWN, lux_with_error, percent, uniformity_with_error};
use super::picture::{Picture, Words};
use super::texts::say;
use crate::maps::{Estimate, TableRow};

/// Space for titles above, axis below, numbers at the left and the legend at the right.
pub(super) const ROOM: LineSpace = LineSpace { top: 90.0, bottom: 84.0, left: 62.0, right: 104.0 };
/// Smallest type size of a line that is reduced to fit its page, unless it has no other place.
const LEAST_TYPE: f64 = 10.5;
/// Size of the type of a title.
const TITLE: f64 = 17.0;
/// Type size of the line of numbers, and the free margin beside a line.
const NUMBERS: f64 = 13.0;
const MARGIN: f64 = 8.0;
/// Size of the type of labels in the drawing.
pub(super) const SMALL: f64 = 11.0;
/// Height of the first line of notes above the end of the page.
const FOOT: f64 = 26.0;
/// Distance between two lines of small type.
const LINE: f64 = 15.0;
/// Gap between numbers in a line; plain spaces would collapse.
pub(super) const GAP: &str = "\u{a0}\u{a0}\u{a0} ";

/// Free space around a drawing.
pub(super) struct LineSpace {
    pub top: f64,
    pub bottom: f64,
    pub left: f64,
    pub right: f64,
}

pub(super) fn plus_minus(number: &str, error: &str) -> String {
    format!("{number} ± {error}")
}

/// Writes the title, and a line with view, count and remark. Returns the remark as a sentence if a narrow page has no space for it.
pub(super) fn head(picture: &mut Picture, map: &FlatMap, quantity: &str, remark: &str) -> String {
    let row = map.row;
    let side = if row.side == "back" { say!(", back") } else { "" };
    let title = format!("{quantity}: {}{side}", row.name);
    let size = size_within(picture, &title, TITLE, true);
    picture.words(Words::new(title, [ROOM.left, 24.0], size).bold());
    let view = capital(&format!("{}; {}", map.plane.view, map.count));
    let is_whole = size_within(picture, &format!("{view}{remark}"), TYPE, false) >= LEAST_TYPE;
    let (view, rest) = if is_whole { (format!("{view}{remark}"), "") } else { (view, remark.trim_start_matches("; ")) };
    let size = size_within(picture, &view, TYPE, false);
    picture.words(Words::new(view, [ROOM.left, 43.0], size).ink(SOFT));
    if rest.is_empty() { String::new() } else { format!("{}. ", capital(rest)) }
}

/// Writes averages and uniformities below the title.
pub(super) fn numbers_of(picture: &mut Picture, row: &TableRow) {
    let unknown = || format!("= {UNKNOWN}");
    let lux = |estimate: Estimate| {
        let is = if estimate.is_known() { "= " } else { "" };
        format!("{is}{} lx", lux_with_error(estimate, plus_minus))
    };
    let numbers = format!(
        "Ē {}{GAP}Emin {}{GAP}Emax {}{GAP}U0 = {}{GAP}Ud = {}",
        lux(row.average),
        row.least().map_or_else(unknown, lux),
        row.greatest().map_or_else(unknown, lux),
        uniformity_with_error(row.u0(), plus_minus),
        uniformity_with_error(row.ud(), plus_minus),
    );
    line_of_numbers(picture, &numbers);
}

/// Writes the line below the title.
pub(super) fn line_of_numbers(picture: &mut Picture, numbers: &str) {
    let size = size_within(picture, numbers, NUMBERS, false);
    picture.words(Words::new(numbers, [ROOM.left, 65.0], size));
}

/// Type size of a line above a map. A long line on a narrow page is set smaller, so that none of it is cut off.
fn size_within(picture: &Picture, text: &str, size: f64, bold: bool) -> f64 {
    let room = picture.width - ROOM.left - MARGIN;
    size * (room / text_width(text, size, bold)).min(1.0)
}

pub(super) fn foot(picture: &mut Picture, map: &FlatMap, note: &str) {
    let error = say!(
        "Stated error of this map {} (relative RMS of its values); ± is one standard error.",
        percent(map.estimated_error)
    );
    picture.words(Words::new(error, [ROOM.left, picture.height - FOOT], SMALL).ink(SOFT));
    draw_notes(picture, note, 1);
}

/// Writes notes at the foot, beginning at line number `first`. A narrow page grows downward if they need several lines.
pub(super) fn draw_notes(picture: &mut Picture, note: &str, first: usize) {
    let y = picture.height - FOOT;
    let lines = lines_within(note, SMALL, picture.width - ROOM.left - MARGIN);
    picture.height += LINE * (first + lines.len()).saturating_sub(2) as f64;
    for (number, line) in lines.into_iter().enumerate() {
        picture.words(Words::new(line, [ROOM.left, y + LINE * (first + number) as f64], SMALL).ink(SOFT));
    }
}

/// Breaks text into lines no wider than a width, except single words that are wider.
fn lines_within(text: &str, size: f64, width: f64) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in text.split_whitespace() {
        match lines.last_mut() {
            Some(line) if text_width(&format!("{line} {word}"), size, false) <= width => *line += &format!(" {word}"),
            _ => lines.push(word.to_owned()),
        }
    }
    lines
}

fn capital(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or(String::new(), |first| first.to_uppercase().chain(letters).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A long note is broken into lines that fit the page, and no word is lost.
    #[test]
    fn a_long_note_takes_several_lines() {
        let note = "No isolux lines: the values differ by little more than their error. The target does not apply to this map.";
        let lines = lines_within(note, SMALL, 300.0);
        assert!(lines.len() > 1 && lines.iter().all(|line| text_width(line, SMALL, false) <= 300.0), "{lines:?}");
        assert_eq!(lines.join(" "), note);
        assert_eq!(lines_within(note, SMALL, 3000.0), [note]);
        assert!(lines_within("", SMALL, 300.0).is_empty());
    }

    /// A long title on a narrow page is set smaller; a short one is not.
    #[test]
    fn a_long_line_fits_its_page() {
        let picture = Picture::new(620.0, 400.0, "map");
        let long = "On small upright half cylinders that look towards +x, z = 1.6 m; seen from above; 3 × 7 points; minimum and maximum framed";
        let size = size_within(&picture, long, TYPE, false);
        assert!(size < TYPE && ROOM.left + text_width(long, size, false) <= picture.width, "{size}");
        assert_eq!(size_within(&picture, "Upright, x = 0 m", TYPE, false), TYPE);
    }
}
