//! A picture under construction: areas, lines and words at points of a page, written as SVG or as pixels.
//!
//! y points down; one unit is a CSS pixel.

use std::fmt::Write as _;

use super::color::{BLACK, Ink, WHITE};
use super::font::FAMILIES;

/// A point of the page.
pub type PagePoint = [f64; 2];

/// How a line is drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pen {
    /// Its ink.
    pub ink: Ink,
    /// Its width.
    pub width: f64,
    /// Opacity from 0 to 1; 1 covers what lies below.
    pub opacity: f64,
    /// Lengths of dashes and gaps; `None` for a solid line.
    pub dash: Option<[f64; 2]>,
}

impl Pen {
    /// A solid, opaque pen.
    pub fn new(ink: Ink, width: f64) -> Pen {
        Pen { ink, width, opacity: 1.0, dash: None }
    }

    /// The same, dashed.
    pub fn dashed(self, dash: f64, gap: f64) -> Pen {
        Pen { dash: Some([dash, gap]), ..self }
    }

    /// The same, partly transparent.
    pub fn faint(self, opacity: f64) -> Pen {
        Pen { opacity, ..self }
    }
}

/// How a line of words is aligned with its point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TextAnchor {
    /// It begins there.
    Start,
    /// It is centred there.
    Middle,
    /// It ends there.
    End,
}

/// A line of words; its point lies on the baseline.
#[derive(Clone, Debug, PartialEq)]
pub struct Words {
    /// The text.
    pub text: String,
    /// Position.
    pub spot: PagePoint,
    /// Size of the type.
    pub size: f64,
    /// Bold type.
    pub bold: bool,
    /// Alignment with its point.
    pub anchor: TextAnchor,
    /// Rotation about the point in degrees, clockwise as seen.
    pub turn_deg: f64,
    /// Its ink.
    pub ink: Ink,
    /// Width of a white rim that separates the words from what lies below.
    pub rim: f64,
}

impl Words {
    /// Black words that begin at a point.
    pub fn new(text: impl Into<String>, spot: PagePoint, size: f64) -> Words {
        let text = text.into();
        Words { text, spot, size, bold: false, anchor: TextAnchor::Start, turn_deg: 0.0, ink: BLACK, rim: 0.0 }
    }

    /// In bold type.
    pub fn bold(self) -> Words {
        Words { bold: true, ..self }
    }

    /// With another alignment.
    pub fn anchored(self, anchor: TextAnchor) -> Words {
        Words { anchor, ..self }
    }

    /// In another ink.
    pub fn ink(self, ink: Ink) -> Words {
        Words { ink, ..self }
    }

    /// Rotated by an angle in degrees.
    pub fn turned(self, turn_deg: f64) -> Words {
        Words { turn_deg, ..self }
    }

    /// With a white rim.
    pub fn rimmed(self, rim: f64) -> Words {
        Words { rim, ..self }
    }
}

/// One item of a picture.
#[derive(Clone, Debug)]
pub(super) enum Item {
    /// Filled rings. If `crisp`, no seams appear between neighbours.
    Area { rings: Vec<Vec<PagePoint>>, ink: Ink, opacity: f64, crisp: bool },
    /// A line through points.
    Line { spots: Vec<PagePoint>, closed: bool, pen: Pen },
    /// Words.
    Words(Words),
}

/// A picture: items drawn one over the other on white paper.
#[derive(Clone, Debug)]
pub struct Picture {
    /// Width of the page.
    pub width: f64,
    /// Height of the page.
    pub height: f64,
    /// Text alternative for a reader who cannot see the picture.
    pub description: String,
    pub(super) items: Vec<Item>,
}

impl Picture {
    /// An empty page.
    pub fn new(width: f64, height: f64, description: impl Into<String>) -> Picture {
        Picture { width, height, description: description.into(), items: Vec::new() }
    }

    /// Fills rings of one ink that may touch each other.
    pub fn cells(&mut self, rings: Vec<Vec<PagePoint>>, ink: Ink) {
        self.items.push(Item::Area { rings, ink, opacity: 1.0, crisp: true });
    }

    /// Fills a ring.
    pub fn area(&mut self, ring: Vec<PagePoint>, ink: Ink, opacity: f64) {
        self.items.push(Item::Area { rings: vec![ring], ink, opacity, crisp: false });
    }

    /// Fills a disk.
    pub fn disk(&mut self, [x, y]: PagePoint, radius: f64, ink: Ink) {
        self.area(circle([x, y], radius), ink, 1.0);
    }

    /// Draws an open line.
    pub fn line(&mut self, spots: Vec<PagePoint>, pen: Pen) {
        self.items.push(Item::Line { spots, closed: false, pen });
    }

    /// Draws a closed line.
    pub fn ring(&mut self, spots: Vec<PagePoint>, pen: Pen) {
        self.items.push(Item::Line { spots, closed: true, pen });
    }

    /// Draws a circle.
    pub fn circle(&mut self, spot: PagePoint, radius: f64, pen: Pen) {
        self.ring(circle(spot, radius), pen);
    }

    /// Sets words.
    pub fn words(&mut self, words: Words) {
        self.items.push(Item::Words(words));
    }

    /// The picture as a separate SVG file.
    pub fn svg(&self) -> String {
        let (width, height) = (short(self.width), short(self.height));
        let size = format!(" width=\"{width}\" height=\"{height}\"");
        format!("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n{}", self.svg_element(&size))
    }

    /// The picture as an `svg` element, for a page that sets its width.
    pub fn inline_svg(&self) -> String {
        self.svg_element("")
    }

    fn svg_element(&self, size: &str) -> String {
        let (width, height) = (short(self.width), short(self.height));
        let mut svg = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\"{size} viewBox=\"0 0 {width} {height}\" role=\"img\" font-family=\"{FAMILIES}\">\n\
             <title>{}</title>\n<rect width=\"{width}\" height=\"{height}\" fill=\"{}\"/>\n",
            escaped(&self.description),
            hex(WHITE)
        );
        for item in &self.items {
            write_item(&mut svg, item);
        }
        svg.push_str("</svg>\n");
        svg
    }
}

/// Corners of a polygon that looks like a circle.
fn circle([x, y]: PagePoint, radius: f64) -> Vec<PagePoint> {
    let corners = (8.0 + 2.0 * radius).min(180.0) as u32;
    let turn = |i: u32| std::f64::consts::TAU * f64::from(i) / f64::from(corners);
    (0..corners).map(|i| [x + radius * turn(i).cos(), y + radius * turn(i).sin()]).collect()
}

fn write_item(svg: &mut String, item: &Item) {
    match item {
        Item::Area { rings, ink, opacity, crisp } => {
            svg.push_str("<path d=\"");
            for ring in rings {
                path(svg, ring, true);
            }
            *svg += &format!("\" fill=\"{}\"", hex(*ink));
            attribute(svg, "fill-opacity", *opacity, 1.0);
            if *crisp {
                // A hairline of the same ink closes the seams that viewers leave between neighbours.
                *svg += &format!(" stroke=\"{}\" stroke-width=\"0.5\" stroke-linejoin=\"round\"", hex(*ink));
            }
            svg.push_str("/>\n");
        }
        Item::Line { spots, closed, pen } => {
            svg.push_str("<path d=\"");
            path(svg, spots, *closed);
            *svg += &format!(
                "\" fill=\"none\" stroke=\"{}\" stroke-width=\"{}\" stroke-linejoin=\"round\"",
                hex(pen.ink),
                short(pen.width)
            );
            attribute(svg, "stroke-opacity", pen.opacity, 1.0);
            if let Some([dash, gap]) = pen.dash {
                *svg += &format!(" stroke-dasharray=\"{} {}\"", short(dash), short(gap));
            }
            svg.push_str("/>\n");
        }
        Item::Words(words) => write_words(svg, words),
    }
}

fn write_words(svg: &mut String, words: &Words) {
    // The rim is a separate text below: not every program draws a stroke behind its fill.
    if words.rim > 0.0 {
        let width = short(2.0 * words.rim);
        let white = hex(WHITE);
        let stroke = format!(" stroke=\"{white}\" stroke-width=\"{width}\" stroke-linejoin=\"round\"");
        write_text(svg, words, &white, &stroke);
    }
    write_text(svg, words, &hex(words.ink), "");
}

fn write_text(svg: &mut String, words: &Words, fill: &str, stroke: &str) {
    let [x, y] = words.spot.map(short);
    *svg += &format!("<text x=\"{x}\" y=\"{y}\" font-size=\"{}\" fill=\"{fill}\"", short(words.size));
    svg.push_str(match words.anchor {
        TextAnchor::Start => "",
        TextAnchor::Middle => " text-anchor=\"middle\"",
        TextAnchor::End => " text-anchor=\"end\"",
    });
    if words.bold {
        svg.push_str(" font-weight=\"bold\"");
    }
    if words.turn_deg != 0.0 {
        *svg += &format!(" transform=\"rotate({} {x} {y})\"", short(words.turn_deg));
    }
    *svg += &format!("{stroke}>{}</text>\n", escaped(&words.text));
}

/// Writes a path through points, to a tenth of a pixel.
fn path(svg: &mut String, spots: &[PagePoint], closed: bool) {
    let tenth = |x: f64| {
        let text = format!("{:.1}", x + 0.0);
        let text = text.strip_suffix(".0").unwrap_or(&text);
        if text == "-0" { "0".to_owned() } else { text.to_owned() }
    };
    for (index, [x, y]) in spots.iter().enumerate() {
        svg.push(if index == 0 { 'M' } else { 'L' });
        svg.push_str(&tenth(*x));
        svg.push(' ');
        svg.push_str(&tenth(*y));
    }
    if closed {
        svg.push('Z');
    }
}

fn attribute(svg: &mut String, name: &str, value: f64, default: f64) {
    if value != default {
        write!(svg, " {name}=\"{}\"", short(value)).ok();
    }
}

/// Formats a coordinate to a hundredth of a pixel.
fn short(number: f64) -> String {
    let text = format!("{:.2}", number + 0.0);
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".to_owned() } else { text.to_owned() }
}

fn hex([red, green, blue]: Ink) -> String {
    format!("#{red:02x}{green:02x}{blue:02x}")
}

/// Escapes text for XML and HTML.
pub fn escaped(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for letter in text.chars() {
        match letter {
            '&' => escaped.push_str("&amp;"),
            '<' => escaped.push_str("&lt;"),
            '>' => escaped.push_str("&gt;"),
            '"' => escaped.push_str("&quot;"),
            // XML does not permit control characters.
            letter if letter.is_control() && letter != '\n' && letter != '\t' => escaped.push('\u{fffd}'),
            letter => escaped.push(letter),
        }
    }
    escaped
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_svg_holds_what_was_drawn_and_no_loose_markup() {
        let mut picture = Picture::new(100.0, 50.0, "a < b");
        picture.cells(vec![vec![[0.0, 0.0], [10.0, 0.0], [10.0, 1.0 / 3.0]]], [255, 0, 16]);
        picture.line(vec![[0.0, 0.0], [5.0, -0.001]], Pen::new(BLACK, 1.5).dashed(4.0, 2.0));
        picture.words(Words::new("Ē < 5 & \"x\"", [1.0, 2.0], 12.0).bold().turned(-90.0).rimmed(1.5));
        let svg = picture.svg();
        assert!(svg.contains("<title>a &lt; b</title>"));
        assert!(svg.contains("d=\"M0 0L10 0L10 0.3Z\" fill=\"#ff0010\" stroke=\"#ff0010\""));
        assert!(svg.contains("d=\"M0 0L5 0\"") && svg.contains("stroke-dasharray=\"4 2\""));
        assert!(svg.contains("rotate(-90 1 2)") && svg.contains(">Ē &lt; 5 &amp; &quot;x&quot;</text>"));
        assert!(
            svg.contains("width=\"100\" height=\"50\"")
                && !picture.inline_svg().contains("width=\"100\" height=\"50\" viewBox")
        );
    }
}
