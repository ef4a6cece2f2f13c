//! Compares the two independent halves of a computation: where they differ, and the distribution of the differences.

use super::axes::TYPE;
use super::color::{BLACK, Ink, SOFT, WHITE, mixed};
use super::flat::FlatMap;
use super::map_plot::{LEAST_LEGEND, MapLayout, draw_axes, draw_cells};
use super::numbers::percent;
use super::picture::{Pen, Picture, TextAnchor, Words};
use super::texts::say;
use crate::maps::MapResult;

/// Largest difference of the scale, in standard errors. Larger ones have the last colour and lie in the last bars.
const WIDEST: f64 = 3.0;
/// Colour steps on either side of 0.
const SHADES: i32 = 12;
const BLUE: Ink = [33, 102, 172];
const RED: Ink = [178, 24, 43];
/// Bars of the histogram, over [−`WIDEST`, `WIDEST`].
const BARS: usize = 24;
/// Fewer points show no distribution.
const FEWEST: usize = 50;

/// Differences of the halves (odd minus even) over their standard errors. `None` if a point has no error; empty if a method has no
/// halves.
///
/// The mean of both halves has the standard error s. Each half alone has √2 s, and their difference 2 s.
pub fn deviations(map: &MapResult) -> Vec<Option<f64>> {
    let values = &map.values;
    let halves = values.halves.iter().zip(&values.standard_error);
    halves.map(|([even, odd], error_lx)| (*error_lx > 0.0).then(|| (odd - even) / (2.0 * error_lx))).collect()
}

/// Draws the differences of a grid, in units of their standard errors, on a diverging scale.
pub fn difference_picture(mut map: FlatMap, deviations: &[Option<f64>], note: &str) -> Picture {
    let (layout, mut picture) = MapLayout::of(&map);
    // Cells are in the order of the points. Cells without an error are blank, as inside a solid.
    for (cell, deviation) in map.cells.iter_mut().zip(deviations) {
        cell.value = cell.value.and(*deviation);
    }
    let title = say!("Odd minus even half: {}", map.row.name);
    picture.words(Words::new(title, [62.0, 24.0], 17.0).bold());
    let words = say!("Difference of two independent halves of the computation, in standard errors of the difference");
    picture.words(Words::new(words, [62.0, 43.0], TYPE).ink(SOFT));
    let beyond = deviations.iter().flatten().filter(|z| z.abs() > 2.0).count() as f64;
    let all = deviations.iter().flatten().count().max(1) as f64;
    let words = say!(
        "{} of the points differ by more than two (4.6 % if the stated error is chance alone)",
        percent(beyond / all)
    );
    picture.words(Words::new(words, [62.0, 65.0], 13.0));
    // The sum of n independent deviations, divided by √n, has a standard deviation of one.
    draw_cells(&mut picture, &map, &layout, |sum, count| sum / count.sqrt(), &ink);
    draw_axes(&mut picture, &map, &layout);
    draw_legend(&mut picture, &layout);
    let y = picture.height - 10.0;
    picture.words(Words::new(note, [62.0, y], 11.0).ink(SOFT));
    picture
}

/// Draws a histogram of the differences beside the normal curve; `None` for few points.
pub fn histogram_picture(name: &str, deviations: &[Option<f64>]) -> Option<Picture> {
    let known: Vec<f64> = deviations.iter().flatten().copied().collect();
    if known.len() < FEWEST {
        return None;
    }
    let width = 2.0 * WIDEST / BARS as f64;
    let mut counts = [0usize; BARS];
    for z in &known {
        let bar = ((z + WIDEST) / width).floor().clamp(0.0, (BARS - 1) as f64);
        counts[bar as usize] += 1;
    }
    let share = |count: usize| count as f64 / known.len() as f64 / width;
    let density = |z: f64| (-0.5 * z * z).exp() / (2.0 * std::f64::consts::PI).sqrt();
    let most = counts.iter().map(|count| share(*count)).fold(density(0.0), f64::max) * 1.08;
    let (left, right, top, bottom) = (62.0, 640.0, 64.0, 330.0);
    let x = |z: f64| left + (z + WIDEST) / (2.0 * WIDEST) * (right - left);
    let y = |height: f64| bottom - height / most * (bottom - top);
    let mut picture = Picture::new(680.0, 400.0, say!("Differences of the halves of {}", name));
    picture.words(Words::new(say!("Differences of the halves: {}", name), [left, 24.0], 17.0).bold());
    let words = say!("{} points; bars: frequency, line: normal distribution of mean 0 and variance 1", known.len());
    picture.words(Words::new(words, [left, 43.0], TYPE).ink(SOFT));
    for (bar, count) in counts.iter().enumerate() {
        let [low, high] = [bar, bar + 1].map(|edge| x(edge as f64 * width - WIDEST));
        let at = y(share(*count));
        picture.area(vec![[low, at], [high, at], [high, bottom], [low, bottom]], mixed(BLUE, WHITE, 0.45), 1.0);
        picture.ring(vec![[low, at], [high, at], [high, bottom], [low, bottom]], Pen::new(WHITE, 0.8));
    }
    let steps = 120;
    let curve = (0..=steps).map(|step| 2.0 * WIDEST * f64::from(step) / f64::from(steps) - WIDEST);
    picture.line(curve.map(|z| [x(z), y(density(z))]).collect(), Pen::new(BLACK, 1.6));
    picture.line(vec![[left, bottom], [right, bottom]], Pen::new(BLACK, 1.0));
    for z in -3..=3 {
        let at = x(f64::from(z));
        picture.line(vec![[at, bottom], [at, bottom + 4.0]], Pen::new(BLACK, 0.8));
        picture.words(Words::new(signed(z), [at, bottom + 18.0], TYPE).anchored(TextAnchor::Middle));
    }
    let label = say!("odd minus even, in standard errors of the difference (outermost bars: and beyond)");
    let below = Words::new(label, [0.5 * (left + right), bottom + 40.0], TYPE);
    picture.words(below.anchored(TextAnchor::Middle).ink(SOFT));
    Some(picture)
}

fn signed(number: i32) -> String {
    if number < 0 { format!("−{}", -number) } else { number.to_string() }
}

/// White at 0, red above, blue below.
fn ink(deviation: f64) -> Ink {
    let step = (deviation / WIDEST * f64::from(SHADES)).round().clamp(-f64::from(SHADES), f64::from(SHADES));
    mixed(WHITE, if step < 0.0 { BLUE } else { RED }, step.abs() / f64::from(SHADES))
}

fn draw_legend(picture: &mut Picture, layout: &MapLayout) {
    let (left, width) = (layout.left + layout.width + 22.0, 16.0);
    let height = layout.height.max(LEAST_LEGEND);
    let (top, bottom) = (layout.top, layout.top + height);
    let y = |deviation: f64| bottom - (deviation + WIDEST) / (2.0 * WIDEST) * height;
    for shade in -SHADES..=SHADES {
        let edge =
            |by: f64| (f64::from(shade) + by).clamp(-f64::from(SHADES), f64::from(SHADES)) * WIDEST / f64::from(SHADES);
        let (low, high) = (y(edge(-0.5)), y(edge(0.5)));
        let ring = vec![[left, high], [left + width, high], [left + width, low], [left, low]];
        picture.cells(vec![ring], ink(f64::from(shade) * WIDEST / f64::from(SHADES)));
    }
    picture.ring(vec![[left, top], [left + width, top], [left + width, bottom], [left, bottom]], Pen::new(BLACK, 0.8));
    for z in -3..=3 {
        let at = y(f64::from(z));
        picture.line(vec![[left + width, at], [left + width + 4.0, at]], Pen::new(BLACK, 0.8));
        picture.words(Words::new(signed(z), [left + width + 8.0, at + 4.0], TYPE));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::maps::{MapError, MapKind, MapValues};
    use crate::scene::Quantity;

    fn map(halves: Vec<[f64; 2]>, standard_error: Vec<f64>) -> MapResult {
        let value = halves.iter().map(|[even, odd]| 0.5 * (even + odd)).collect();
        MapResult {
            name: "plane".to_owned(),
            kind: MapKind::Receivers(0),
            quantity: Quantity::Perpendicular,
            method: String::new(),
            method_reason: String::new(),
            chains: 0,
            values: MapValues { value, standard_error, halves, ..MapValues::default() },
            error: MapError::default(),
            bound: true,
            refusals: 0,
            checks: Vec::new(),
            target_met: None,
            tables: Vec::new(),
        }
    }

    #[test]
    fn differences_are_reported_in_their_standard_errors() {
        // Halves of 10 and 14 lx: if their mean has a standard error of 1 lx, their difference has one of 2 lx.
        let map = map(vec![[10.0, 14.0], [5.0, 5.0], [3.0, 3.0]], vec![1.0, 0.5, 0.0]);
        assert_eq!(deviations(&map), [Some(2.0), Some(0.0), None]);
        assert_eq!(ink(0.0), WHITE);
        assert_eq!((ink(9.0), ink(-9.0)), (RED, BLUE));
        assert!(histogram_picture("plane", &deviations(&map)).is_none(), "three points show no distribution");
        assert!(histogram_picture("plane", &[Some(0.3); 60]).is_some());
    }
}
