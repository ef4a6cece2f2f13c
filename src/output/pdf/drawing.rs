//! Draws the `svg` element of a picture, as `Picture` writes it, on a page.

use roxmltree::Node;

use super::ink::{Paper, PaperStroke, Type, drawable};
use crate::output::color::{BLACK, Ink};
use crate::output::font::text_width;

/// Width and height of a picture in its own units.
pub fn size(svg: Node) -> [f64; 2] {
    let mut numbers = svg.attribute("viewBox").unwrap_or_default().split(' ').skip(2).map(number);
    [numbers.next().unwrap_or(1.0), numbers.next().unwrap_or(1.0)]
}

/// Draws the picture with its upper left corner at a point. `scale` is the number of points for each of its units.
pub fn draw(paper: &mut Paper, page: usize, svg: Node, corner: [f64; 2], scale: f64) {
    let place = |[x, y]: [f64; 2]| [corner[0] + scale * x, corner[1] + scale * y];
    for item in svg.children().filter(Node::is_element) {
        let of = |name: &str, default: f64| item.attribute(name).map_or(default, number);
        match item.tag_name().name() {
            "path" => {
                let lines: Vec<_> = lines(item.attribute("d").unwrap_or_default())
                    .into_iter()
                    .map(|(line, closed)| (line.into_iter().map(place).collect(), closed))
                    .collect();
                let fill = item.attribute("fill").and_then(ink).map(|ink| (ink, of("fill-opacity", 1.0)));
                let stroke = item.attribute("stroke").and_then(ink).map(|ink| PaperStroke {
                    ink,
                    width: scale * of("stroke-width", 1.0),
                    opacity: of("stroke-opacity", 1.0),
                    dash: dash(item.attribute("stroke-dasharray")).map(|dash| dash.map(|length| scale * length)),
                });
                paper.draw(page, &lines, fill, stroke);
            }
            // The rim of a text is a separate text below it.
            "text" => {
                let words = drawable(item.text().unwrap_or_default());
                let (size, bold) = (of("font-size", 12.0), item.attribute("font-weight") == Some("bold"));
                let width = text_width(&words, size, bold);
                let before = match item.attribute("text-anchor") {
                    Some("middle") => 0.5 * width,
                    Some("end") => width,
                    _ => 0.0,
                };
                let turn_deg = item
                    .attribute("transform")
                    .and_then(|turn| turn.strip_prefix("rotate("))
                    .and_then(|turn| turn.split(' ').next())
                    .map_or(0.0, number);
                let (sine, cosine) = turn_deg.to_radians().sin_cos();
                let begin = [of("x", 0.0) - before * cosine, of("y", 0.0) - before * sine];
                let rim = item.attribute("stroke").map_or(0.0, |_| 0.5 * scale * of("stroke-width", 0.0));
                let ink = item.attribute("fill").and_then(ink).unwrap_or(BLACK);
                let how = Type { size: scale * size, bold, ink, turn_deg, rim };
                paper.set(page, &words, place(begin), &how);
            }
            _ => {}
        }
    }
}

fn number(text: &str) -> f64 {
    text.trim().parse().unwrap_or(0.0)
}

/// Parses a colour: `#rrggbb`.
fn ink(text: &str) -> Option<Ink> {
    let digits = text.strip_prefix('#')?;
    let part = |from: usize| u8::from_str_radix(digits.get(from..from + 2)?, 16).ok();
    Some([part(0)?, part(2)?, part(4)?])
}

fn dash(text: Option<&str>) -> Option<[f64; 2]> {
    let (dash, gap) = text?.split_once(' ')?;
    Some([number(dash), number(gap)])
}

/// Parses a path of `M`, `L` and `Z` into lines; the flag is true for closed lines.
fn lines(path: &str) -> Vec<(Vec<[f64; 2]>, bool)> {
    path.split('M')
        .filter(|line| !line.is_empty())
        .map(|line| {
            let spots = line.trim_end_matches('Z').split('L').filter_map(|spot| {
                let (x, y) = spot.split_once(' ')?;
                Some([number(x), number(y)])
            });
            (spots.collect(), line.ends_with('Z'))
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_are_read_as_pictures_write_them() {
        assert_eq!(
            lines("M0 0L10 0L10 0.3ZM1 2L3 4"),
            [(vec![[0.0, 0.0], [10.0, 0.0], [10.0, 0.3]], true), (vec![[1.0, 2.0], [3.0, 4.0]], false)]
        );
        assert_eq!((ink("#ff0010"), ink("none"), dash(Some("6 3"))), (Some([255, 0, 16]), None, Some([6.0, 3.0])));
    }
}
