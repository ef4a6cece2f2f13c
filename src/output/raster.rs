//! Pictures as pixels.

use tiny_skia::{FillRule, LineJoin, Paint, Path, PathBuilder, Pixmap, StrokeDash, Transform};

use super::color::{Ink, WHITE};
use super::font::{self, Stroke};
use super::picture::{Item, PagePoint, Picture, TextAnchor, Words};

/// Pixels for each unit of a picture: sharp in print at the width of a column.
const PIXELS_PER_UNIT: f32 = 2.0;

/// A picture as a PNG file.
pub fn png(picture: &Picture) -> Vec<u8> {
    let pixels = |length: f64| ((length * f64::from(PIXELS_PER_UNIT)).ceil() as u32).max(1);
    let Some(mut map) = Pixmap::new(pixels(picture.width), pixels(picture.height)) else {
        return Vec::new();
    };
    map.fill(color(WHITE, 1.0));
    for item in &picture.items {
        draw(&mut map, item);
    }
    map.encode_png().unwrap_or_default()
}

fn draw(map: &mut Pixmap, item: &Item) {
    let scale = Transform::from_scale(PIXELS_PER_UNIT, PIXELS_PER_UNIT);
    match item {
        Item::Area { rings, ink, opacity, crisp } => {
            let mut builder = PathBuilder::new();
            rings.iter().for_each(|ring| trace(&mut builder, ring, true));
            if let Some(path) = builder.finish() {
                let mut paint = paint(*ink, *opacity);
                paint.anti_alias = !crisp;
                map.fill_path(&path, &paint, FillRule::Winding, scale, None);
            }
        }
        Item::Line { spots, closed, pen } => {
            let mut builder = PathBuilder::new();
            trace(&mut builder, spots, *closed);
            let stroke = tiny_skia::Stroke {
                width: pen.width as f32,
                line_join: LineJoin::Round,
                dash: pen.dash.and_then(|dash| StrokeDash::new(dash.map(|length| length as f32).to_vec(), 0.0)),
                ..Default::default()
            };
            if let Some(path) = builder.finish() {
                map.stroke_path(&path, &paint(pen.ink, pen.opacity), &stroke, scale, None);
            }
        }
        Item::Words(words) => draw_words(map, words, scale),
    }
}

fn draw_words(map: &mut Pixmap, words: &Words, scale: Transform) {
    let Some(path) = word_path(words) else {
        return;
    };
    if words.rim > 0.0 {
        let stroke =
            tiny_skia::Stroke { width: 2.0 * words.rim as f32, line_join: LineJoin::Round, ..Default::default() };
        map.stroke_path(&path, &paint(WHITE, 1.0), &stroke, scale, None);
    }
    map.fill_path(&path, &paint(words.ink, 1.0), FillRule::Winding, scale, None);
}

/// Outlines of words in the picture's units, rotated and at their position.
fn word_path(words: &Words) -> Option<Path> {
    let width = font::text_width(&words.text, words.size, words.bold);
    let start = match words.anchor {
        TextAnchor::Start => 0.0,
        TextAnchor::Middle => -0.5 * width,
        TextAnchor::End => -width,
    };
    let (sine, cosine) = words.turn_deg.to_radians().sin_cos();
    let place = |[x, y]: PagePoint| {
        let [along, down] = [start + x, -y];
        let [x, y] = [words.spot[0] + along * cosine - down * sine, words.spot[1] + along * sine + down * cosine];
        (x as f32, y as f32)
    };
    let mut builder = PathBuilder::new();
    font::outline(&words.text, words.size, words.bold, &mut |stroke| match stroke {
        Stroke::Move(to) => builder.move_to(place(to).0, place(to).1),
        Stroke::Line(to) => builder.line_to(place(to).0, place(to).1),
        Stroke::Quadratic(control, to) => {
            let (control, to) = (place(control), place(to));
            builder.quad_to(control.0, control.1, to.0, to.1);
        }
        Stroke::Cubic(first, second, to) => {
            let (first, second, to) = (place(first), place(second), place(to));
            builder.cubic_to(first.0, first.1, second.0, second.1, to.0, to.1);
        }
        Stroke::Close => builder.close(),
    });
    builder.finish()
}

fn trace(builder: &mut PathBuilder, spots: &[PagePoint], closed: bool) {
    for (index, [x, y]) in spots.iter().enumerate() {
        if index == 0 {
            builder.move_to(*x as f32, *y as f32);
        } else {
            builder.line_to(*x as f32, *y as f32);
        }
    }
    if closed && !spots.is_empty() {
        builder.close();
    }
}

fn paint(ink: Ink, opacity: f64) -> Paint<'static> {
    let mut paint = Paint::default();
    paint.set_color(color(ink, opacity));
    paint.anti_alias = true;
    paint
}

fn color([red, green, blue]: Ink, opacity: f64) -> tiny_skia::Color {
    tiny_skia::Color::from_rgba8(red, green, blue, (255.0 * opacity.clamp(0.0, 1.0)).round() as u8)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::output::color::BLACK;

    #[test]
    fn pixels_show_areas_and_words_where_they_were_drawn() {
        let mut picture = Picture::new(40.0, 20.0, "");
        picture.cells(vec![vec![[0.0, 0.0], [10.0, 0.0], [10.0, 20.0], [0.0, 20.0]]], [255, 0, 0]);
        picture.words(Words::new("I", [30.0, 18.0], 20.0).anchored(TextAnchor::Middle));
        let map = Pixmap::decode_png(&png(&picture)).expect("a sound PNG");
        assert_eq!((map.width(), map.height()), (80, 40));
        let at = |x: u32, y: u32| {
            let pixel = map.pixel(x, y).expect("inside");
            [pixel.red(), pixel.green(), pixel.blue()]
        };
        assert_eq!((at(10, 10), at(79, 0)), ([255, 0, 0], WHITE));
        assert_eq!(at(60, 25), BLACK);
    }
}
