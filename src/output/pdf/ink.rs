//! Pages of a PDF and the drawing on them: text in the bundled fonts, lines and areas.

use std::collections::{BTreeMap, BTreeSet};

use pdf_writer::types::{CidFontType, FontFlags, LineJoinStyle, SystemInfo, TextRenderingMode, UnicodeCmap};
use pdf_writer::{Content, Date, Filter, Finish, Name, Pdf, Rect, Ref, Str, TextStr};
use subsetter::{GlyphRemapper, subset};

use crate::output::color::{Ink, WHITE};
use crate::output::font::{face, font_file, glyph_number};
use crate::output::zlib::zlib;
use flate2::Compression;

/// Width and height of A4 in points.
pub const A4: [f64; 2] = [595.28, 841.89];
const NAMES: [&str; 2] = ["Regular", "Bold"];
const POSTSCRIPT: [&str; 2] = ["LUXMCR+Arimo-Regular", "LUXMCB+Arimo-Bold"];

/// How a line is drawn.
#[derive(Clone, Copy, Debug)]
pub struct PaperStroke {
    /// Ink.
    pub ink: Ink,
    /// Width in points.
    pub width: f64,
    /// Opacity from 0 to 1; 1 covers what lies below.
    pub opacity: f64,
    /// Dash and gap in points.
    pub dash: Option<[f64; 2]>,
}

/// How text is set.
#[derive(Clone, Copy, Debug)]
pub struct Type {
    /// Size in points.
    pub size: f64,
    /// Bold type.
    pub bold: bool,
    /// Its ink.
    pub ink: Ink,
    /// Rotation about its beginning in degrees, clockwise as seen.
    pub turn_deg: f64,
    /// Width of a white rim in points.
    pub rim: f64,
}

/// Letters of a font that a document uses.
struct Letters {
    glyphs: GlyphRemapper,
    /// Letter and width in thousandths of an em for each glyph of the subset.
    used: BTreeMap<u16, (char, f64)>,
}

/// A PDF under construction. Lengths are points from the upper left corner of an A4 page.
pub struct Paper {
    pages: Vec<Content>,
    letters: [Letters; 2],
    opacities: BTreeSet<u8>,
}

fn number(length: f64) -> f32 {
    ((length * 100.0).round() / 100.0) as f32
}

impl Paper {
    /// A document without pages.
    pub fn new() -> Paper {
        let letters = || Letters { glyphs: GlyphRemapper::new(), used: BTreeMap::new() };
        Paper { pages: Vec::new(), letters: [letters(), letters()], opacities: BTreeSet::new() }
    }

    /// Begins a new page.
    pub fn turn_page(&mut self) {
        self.pages.push(Content::new());
    }

    /// Number of pages so far.
    pub fn pages(&self) -> usize {
        self.pages.len()
    }

    fn page(&mut self, page: usize) -> &mut Content {
        &mut self.pages[page]
    }

    /// Draws rings or open lines on a page, filled or stroked or both.
    pub fn draw(
        &mut self,
        page: usize,
        lines: &[(Vec<[f64; 2]>, bool)],
        fill: Option<(Ink, f64)>,
        stroke: Option<PaperStroke>,
    ) {
        let opacity = fill.map(|(_, opacity)| opacity).or(stroke.map(|stroke| stroke.opacity)).unwrap_or(1.0);
        let percent = (100.0 * opacity).round().clamp(0.0, 100.0) as u8;
        if percent < 100 {
            self.opacities.insert(percent);
        }
        let content = self.page(page);
        content.save_state();
        if percent < 100 {
            content.set_parameters(Name(format!("O{percent}").as_bytes()));
        }
        if let Some((ink, _)) = fill {
            let [r, g, b] = shares(ink);
            content.set_fill_rgb(r, g, b);
        }
        if let Some(stroke) = stroke {
            let [r, g, b] = shares(stroke.ink);
            content
                .set_stroke_rgb(r, g, b)
                .set_line_width(number(stroke.width))
                .set_line_join(LineJoinStyle::RoundJoin);
            if let Some(dash) = stroke.dash {
                content.set_dash_pattern(dash.map(number), 0.0);
            }
        }
        for (line, closed) in lines {
            for (index, [x, y]) in line.iter().enumerate() {
                let (x, y) = (number(*x), number(A4[1] - y));
                if index == 0 {
                    content.move_to(x, y);
                } else {
                    content.line_to(x, y);
                }
            }
            if *closed {
                content.close_path();
            }
        }
        match (fill.is_some(), stroke.is_some()) {
            (true, true) => content.fill_nonzero_and_stroke(),
            (true, false) => content.fill_nonzero(),
            (false, _) => content.stroke(),
        };
        content.restore_state();
    }

    /// Sets a line of text that begins at a point on its baseline.
    pub fn set(&mut self, page: usize, text: &str, [x, y]: [f64; 2], how: &Type) {
        let bytes = self.letters[usize::from(how.bold)].take(text, how.bold);
        let (sine, cosine) = (-how.turn_deg).to_radians().sin_cos();
        let matrix = [cosine, sine, -sine, cosine].map(|turn| turn as f32);
        let matrix = [matrix[0], matrix[1], matrix[2], matrix[3], number(x), number(A4[1] - y)];
        let content = self.page(page);
        let rims = (how.rim > 0.0).then_some((WHITE, true)).into_iter().chain([(how.ink, false)]);
        for (ink, is_rim) in rims {
            let [r, g, b] = shares(ink);
            content.save_state().begin_text().set_fill_rgb(r, g, b);
            if is_rim {
                content.set_stroke_rgb(r, g, b).set_line_width(number(2.0 * how.rim));
                content.set_line_join(LineJoinStyle::RoundJoin).set_text_rendering_mode(TextRenderingMode::FillStroke);
            }
            content.set_font(Name(NAMES[usize::from(how.bold)].as_bytes()), number(how.size));
            content.set_text_matrix(matrix).show(Str(&bytes)).end_text().restore_state();
        }
    }

    /// Returns the file. `unix_time_s` is the time at which it was made.
    pub fn finish(self, title: &str, author: &str, language: &str, unix_time_s: u64) -> Vec<u8> {
        let mut pdf = Pdf::new();
        let [catalog, tree, info] = [1, 2, 3].map(Ref::new);
        let mut next = Ref::new(4);
        let fonts: Vec<[Ref; 5]> = (0..2).map(|_| [(); 5].map(|()| next.bump())).collect();
        let pages: Vec<[Ref; 2]> = self.pages.iter().map(|_| [(); 2].map(|()| next.bump())).collect();
        pdf.catalog(catalog).pages(tree).lang(TextStr(language));
        let mut about = pdf.document_info(info);
        about.title(TextStr(title)).creator(TextStr(concat!("luxmc ", env!("CARGO_PKG_VERSION"))));
        if !author.is_empty() {
            about.author(TextStr(author));
        }
        if let Some(date) = date_of(unix_time_s) {
            about.creation_date(date);
        }
        about.finish();
        pdf.pages(tree).kids(pages.iter().map(|[page, _]| *page)).count(pages.len() as i32);
        for ([page, content], drawn) in pages.into_iter().zip(self.pages) {
            let mut sheet = pdf.page(page);
            sheet.parent(tree).media_box(Rect::new(0.0, 0.0, A4[0] as f32, A4[1] as f32)).contents(content);
            let mut resources = sheet.resources();
            let mut named = resources.fonts();
            for (name, font) in NAMES.iter().zip(&fonts) {
                named.pair(Name(name.as_bytes()), font[0]);
            }
            named.finish();
            let mut states = resources.ext_g_states();
            for percent in &self.opacities {
                let share = f64::from(*percent) as f32 / 100.0;
                let name = format!("O{percent}");
                let mut state = states.insert(Name(name.as_bytes())).start::<pdf_writer::writers::ExtGraphicsState>();
                state.non_stroking_alpha(share).stroking_alpha(share);
            }
            states.finish();
            resources.finish();
            sheet.finish();
            let bytes = zlib(&drawn.finish(), Compression::default());
            pdf.stream(content, &bytes).filter(Filter::FlateDecode);
        }
        for (bold, (letters, refs)) in self.letters.iter().zip(fonts).enumerate() {
            letters.write(&mut pdf, refs, bold == 1);
        }
        pdf.finish()
    }
}

impl Letters {
    /// Adds a text's glyphs to the subset, and returns their numbers in it, two bytes each.
    fn take(&mut self, text: &str, bold: bool) -> Vec<u8> {
        let face = face(bold);
        let per_em = f64::from(face.units_per_em());
        let mut bytes = Vec::with_capacity(2 * text.len());
        for letter in text.chars() {
            let glyph = glyph_number(face, letter);
            let advance = face.glyph_hor_advance(ttf_parser::GlyphId(glyph)).unwrap_or(0);
            let number = self.glyphs.remap(glyph);
            self.used.entry(number).or_insert((letter, 1000.0 * f64::from(advance) / per_em));
            bytes.extend(number.to_be_bytes());
        }
        bytes
    }

    /// Writes the subset of the font and its description.
    fn write(&self, pdf: &mut Pdf, [font, cid, descriptor, unicode, file]: [Ref; 5], bold: bool) {
        let name = Name(POSTSCRIPT[usize::from(bold)].as_bytes());
        let face = face(bold);
        let scale = 1000.0 / f64::from(face.units_per_em());
        let em = |units: i16| (f64::from(units) * scale) as f32;
        let system = SystemInfo { registry: Str(b"Adobe"), ordering: Str(b"Identity"), supplement: 0 };
        pdf.type0_font(font)
            .base_font(name)
            .encoding_predefined(Name(b"Identity-H"))
            .descendant_font(cid)
            .to_unicode(unicode);
        let mut described = pdf.cid_font(cid);
        described.subtype(CidFontType::Type2).base_font(name).system_info(system).font_descriptor(descriptor);
        described.default_width(0.0).cid_to_gid_map_predefined(Name(b"Identity"));
        let mut widths = described.widths();
        for (glyph, (_, width)) in &self.used {
            widths.consecutive(*glyph, [*width as f32]);
        }
        widths.finish();
        described.finish();
        let bounds = face.global_bounding_box();
        pdf.font_descriptor(descriptor)
            .name(name)
            .flags(FontFlags::NON_SYMBOLIC)
            .bbox(Rect::new(em(bounds.x_min), em(bounds.y_min), em(bounds.x_max), em(bounds.y_max)))
            .italic_angle(0.0)
            .ascent(em(face.ascender()))
            .descent(em(face.descender()))
            .cap_height(em(face.capital_height().unwrap_or(1409)))
            .stem_v(if bold { 140.0 } else { 80.0 })
            .font_file2(file);
        let mut cmap = UnicodeCmap::new(Name(b"Letters"), system);
        for (glyph, (letter, _)) in &self.used {
            cmap.pair(*glyph, *letter);
        }
        pdf.cmap(unicode, &cmap.finish());
        let bytes = subset(font_file(bold), 0, &self.glyphs).expect("the bundled font has these letters");
        let length = bytes.len() as i32;
        let bytes = zlib(&bytes, Compression::default());
        pdf.stream(file, &bytes).filter(Filter::FlateDecode).pair(Name(b"Length1"), length);
    }
}

/// Replaces letters without a glyph in the font.
pub fn drawable(text: &str) -> String {
    let regular = face(false);
    let unknown = glyph_number(regular, '\u{10ffff}');
    let drawn = |letter: char| match letter {
        '✓' => '√',
        '✗' => '×',
        letter if letter != '?' && glyph_number(regular, letter) == unknown => '?',
        letter => letter,
    };
    text.chars().map(drawn).collect()
}

fn shares(ink: Ink) -> [f32; 3] {
    ink.map(|part| f32::from(part) / 255.0)
}

/// The day of a time, for the document's metadata.
fn date_of(unix_time_s: u64) -> Option<Date> {
    let text = crate::output::date::utc_date(unix_time_s);
    let mut parts = text.split('-').map(|part| part.trim().parse::<u16>().ok());
    let (year, month, day) = (parts.next()??, parts.next()??, parts.next()??);
    Some(Date::new(year).month(month as u8).day(day as u8))
}
