//! The bundled font: widths for text layout, and outlines for pixel pictures.
//!
//! Arimo has the widths of Helvetica, Arial and Liberation Sans. Text laid out with it also fits if an SVG viewer uses one of these
//! instead.

use std::sync::OnceLock;

use ttf_parser::{Face, GlyphId, OutlineBuilder};

const REGULAR: &[u8] = include_bytes!("font/Arimo-Regular.ttf");
const BOLD: &[u8] = include_bytes!("font/Arimo-Bold.ttf");

/// Font families for an SVG viewer, best first.
pub const FAMILIES: &str = "Helvetica, Arial, 'Liberation Sans', Arimo, sans-serif";

/// Height of capitals as a share of the type size.
pub const CAPITALS: f64 = 0.72;

/// The bytes of the font's file.
pub fn font_file(bold: bool) -> &'static [u8] {
    if bold { BOLD } else { REGULAR }
}

/// Number of a letter's glyph in the font file.
pub fn glyph_number(face: &Face, letter: char) -> u16 {
    glyph(face, letter).0
}

/// The parsed font; it is parsed once.
pub fn face(bold: bool) -> &'static Face<'static> {
    static FACES: OnceLock<[Face<'static>; 2]> = OnceLock::new();
    let parsed = |bold: bool| Face::parse(font_file(bold), 0).expect("the font that comes with the program is sound");
    &FACES.get_or_init(|| [false, true].map(parsed))[usize::from(bold)]
}

fn glyph(face: &Face, letter: char) -> GlyphId {
    face.glyph_index(letter).or_else(|| face.glyph_index('?')).unwrap_or(GlyphId(0))
}

/// Width of a line of text, in the unit of `size`.
pub fn text_width(text: &str, size: f64, bold: bool) -> f64 {
    let face = face(bold);
    let units: u32 = text.chars().map(|letter| u32::from(advance(face, letter))).sum();
    f64::from(units) * size / f64::from(face.units_per_em())
}

fn advance(face: &Face, letter: char) -> u16 {
    face.glyph_hor_advance(glyph(face, letter)).unwrap_or(0)
}

/// Draws the outlines of a line of text that starts at 0 on its baseline; y grows upwards.
pub fn outline(text: &str, size: f64, bold: bool, pen: &mut impl FnMut(Stroke)) {
    let face = face(bold);
    let scale = size / f64::from(face.units_per_em());
    let mut at = 0.0;
    for letter in text.chars() {
        face.outline_glyph(glyph(face, letter), &mut Tracing { at, scale, pen });
        at += f64::from(advance(face, letter)) * scale;
    }
}

/// A segment of an outline; points are `[x, y]`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Stroke {
    /// Starts a contour.
    Move([f64; 2]),
    /// A straight segment.
    Line([f64; 2]),
    /// A quadratic segment: control point, end.
    Quadratic([f64; 2], [f64; 2]),
    /// A cubic segment: control points, end.
    Cubic([f64; 2], [f64; 2], [f64; 2]),
    /// Ends a contour.
    Close,
}

struct Tracing<'a, P> {
    at: f64,
    scale: f64,
    pen: &'a mut P,
}

impl<P> Tracing<'_, P> {
    fn point(&self, x: f32, y: f32) -> [f64; 2] {
        [self.at + f64::from(x) * self.scale, f64::from(y) * self.scale]
    }
}

impl<P: FnMut(Stroke)> OutlineBuilder for Tracing<'_, P> {
    fn move_to(&mut self, x: f32, y: f32) {
        let to = self.point(x, y);
        (self.pen)(Stroke::Move(to));
    }

    fn line_to(&mut self, x: f32, y: f32) {
        let to = self.point(x, y);
        (self.pen)(Stroke::Line(to));
    }

    fn quad_to(&mut self, x1: f32, y1: f32, x: f32, y: f32) {
        let (control, to) = (self.point(x1, y1), self.point(x, y));
        (self.pen)(Stroke::Quadratic(control, to));
    }

    fn curve_to(&mut self, x1: f32, y1: f32, x2: f32, y2: f32, x: f32, y: f32) {
        let (first, second, to) = (self.point(x1, y1), self.point(x2, y2), self.point(x, y));
        (self.pen)(Stroke::Cubic(first, second, to));
    }

    fn close(&mut self) {
        (self.pen)(Stroke::Close);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Helvetica's published widths: 556 of 1000 for a digit, 278 for a space, 722 for D.
    #[test]
    fn widths_are_those_of_helvetica() {
        for (letter, width) in [("0", 0.556), (" ", 0.278), ("D", 0.722)] {
            assert!((text_width(letter, 1.0, false) - width).abs() < 1e-3, "{letter}");
        }
        assert!(text_width("Ēmin ± 0.5 · 10⁻³ m² − °", 10.0, true) > 100.0);
    }

    #[test]
    fn every_letter_that_plots_use_has_its_own_outline() {
        let face = face(false);
        for letter in "Ē±·²³°−–—“”’…×≥≤⁰¹⁴⁵⁶⁷⁸⁹⁻äöüßéñ\u{2009}\u{a0}".chars()
        {
            assert!(face.glyph_index(letter).is_some(), "{letter}");
        }
    }
}
