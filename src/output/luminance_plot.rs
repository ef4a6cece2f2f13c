//! The luminances that an eye sees: a picture in false colours on a logarithmic scale, or luminance over the angle of a fan.

use std::collections::BTreeMap;

use super::axes::{ChartFrame, Scale, TYPE};
use super::color::{BLACK, BLUE, Ink, SHADES, SOFT, perceptual};
use super::numbers::{lux, percent, tick};
use super::picture::{Pen, Picture, TextAnchor, Words};
use super::texts::say;
use crate::maps::MapResult;
use crate::scene::{ReceiverLayout, ReceiverSet};

/// Largest width and height of a picture.
const LARGEST_PICTURE: [f64; 2] = [760.0, 620.0];
/// Left and upper edge of the picture on the page.
const LEFT: f64 = 40.0;
const TOP: f64 = 70.0;
/// Space for the legend at the right, and for a note below.
const RIGHT: f64 = 110.0;
const BELOW: f64 = 52.0;
/// Lowest end of the scale, as a share of the brightest value: four decades.
const WIDEST_SPAN: f64 = 1e-4;
/// Highest lower end of the scale, as a share of the brightest value. The span is at least a factor of two, so that an even field
/// does not show noise only.
const NARROWEST_SPAN: f64 = 0.5;
/// Share of the darkest cells that do not stretch the scale.
const DARKEST: f64 = 0.01;

/// The plot of a luminance set; `None` if its layout has no plot.
pub(super) fn luminance_picture(set: &ReceiverSet, map: &MapResult, note: &str) -> Option<Picture> {
    match set.layout {
        ReceiverLayout::View { columns, rows, field_deg } => {
            Some(view_picture(set, map, [columns, rows], field_deg, note))
        }
        ReceiverLayout::Fan { from_deg, to_deg } if set.points.len() > 1 && from_deg != to_deg => {
            Some(fan_picture(set, map, [from_deg, to_deg], note))
        }
        _ => None,
    }
}

fn head(picture: &mut Picture, set: &ReceiverSet, map: &MapResult, what: &str) {
    picture.words(Words::new(say!("Luminance: {}", set.name), [LEFT, 24.0], 17.0).bold());
    let values = &map.values.value;
    let brightest = values.iter().fold(0.0, |most: f64, value| most.max(*value));
    let mean = map.tables.first().map_or(0.0, |row| row.average.value);
    let line = say!(
        "{}; mean {} cd/m², brightest {} cd/m²; stated error {}",
        what,
        lux(mean),
        lux(brightest),
        percent(map.error.estimated)
    );
    picture.words(Words::new(line, [LEFT, 44.0], TYPE).ink(SOFT));
}

fn view_picture(
    set: &ReceiverSet,
    map: &MapResult,
    [columns, rows]: [u32; 2],
    field_deg: [f64; 2],
    note: &str,
) -> Picture {
    // The cells of the flat screen have the proportions of its field and need not be square.
    let size = field_deg.map(|angle_deg| (0.5 * angle_deg).to_radians().tan());
    let scale = (LARGEST_PICTURE[0] / size[0]).min(LARGEST_PICTURE[1] / size[1]);
    let (width, height) = (size[0] * scale, size[1] * scale);
    let page_width = (LEFT + width + RIGHT).max(560.0);
    let page_height = TOP + height.max(120.0) + BELOW;
    let mut picture = Picture::new(page_width, page_height, say!("Luminance picture {}", set.name));
    let what = say!("{} × {} directions, {}° × {}°", columns, rows, tick(field_deg[0]), tick(field_deg[1]));
    head(&mut picture, set, map, &what);
    let scale = log_scale(&map.values.value);
    let mut by_ink: BTreeMap<usize, Vec<Vec<[f64; 2]>>> = BTreeMap::new();
    let (cell_width, cell_height) = (width / f64::from(columns), height / f64::from(rows));
    for (index, value) in map.values.value.iter().enumerate() {
        let (column, row) = (index as u32 % columns, index as u32 / columns);
        let (x, y) = (LEFT + f64::from(column) * cell_width, TOP + f64::from(row) * cell_height);
        let ring = vec![[x, y], [x + cell_width, y], [x + cell_width, y + cell_height], [x, y + cell_height]];
        by_ink.entry(shade(&scale, *value)).or_default().push(ring);
    }
    for (shade, rings) in by_ink {
        picture.cells(rings, ink(shade));
    }
    let ring = vec![[LEFT, TOP], [LEFT + width, TOP], [LEFT + width, TOP + height], [LEFT, TOP + height]];
    picture.ring(ring, Pen::new(BLACK, 1.0));
    draw_legend(&mut picture, [LEFT + width + 22.0, TOP], height.max(120.0), &scale);
    picture.words(Words::new(note, [LEFT, page_height - 16.0], TYPE).ink(SOFT));
    picture
}

/// A logarithmic scale over the values, of four decades at most.
fn log_scale(values: &[f64]) -> Scale {
    let mut sorted: Vec<f64> = values.iter().copied().filter(|value| *value > 0.0).collect();
    sorted.sort_by(f64::total_cmp);
    let Some(high) = sorted.last().copied() else {
        return Scale::logarithmic(0.1, 1.0);
    };
    let dark = sorted[((sorted.len() - 1) as f64 * DARKEST) as usize];
    Scale::logarithmic(dark.clamp(WIDEST_SPAN * high, NARROWEST_SPAN * high), high)
}

fn shade(scale: &Scale, value: f64) -> usize {
    (scale.share(value).clamp(0.0, 1.0) * (SHADES - 1) as f64).round() as usize
}

fn ink(shade: usize) -> Ink {
    perceptual(shade as f64 / (SHADES - 1) as f64)
}

fn draw_legend(picture: &mut Picture, [left, top]: [f64; 2], height: f64, scale: &Scale) {
    const WIDTH: f64 = 16.0;
    let y = |share: f64| top + (1.0 - share) * height;
    for shade in 0..SHADES {
        let (low, high) = (y(shade as f64 / SHADES as f64), y((shade + 1) as f64 / SHADES as f64));
        picture.cells(vec![vec![[left, high], [left + WIDTH, high], [left + WIDTH, low], [left, low]]], ink(shade));
    }
    picture.ring(
        vec![[left, top], [left + WIDTH, top], [left + WIDTH, top + height], [left, top + height]],
        Pen::new(BLACK, 0.8),
    );
    for number in scale.ticks(((height / 34.0) as usize).clamp(2, 10)) {
        let at = y(scale.share(number));
        picture.line(vec![[left + WIDTH, at], [left + WIDTH + 4.0, at]], Pen::new(BLACK, 0.8));
        picture.words(Words::new(tick(number), [left + WIDTH + 8.0, at + 4.0], TYPE));
    }
    picture.words(Words::new("cd/m²", [left, top - 8.0], TYPE).ink(SOFT));
}

fn fan_picture(set: &ReceiverSet, map: &MapResult, [from_deg, to_deg]: [f64; 2], note: &str) -> Picture {
    const WIDTH: f64 = 720.0;
    const HEIGHT: f64 = 380.0;
    let mut picture = Picture::new(LEFT + 50.0 + WIDTH + 30.0, TOP + HEIGHT + 84.0, say!("Luminance fan {}", set.name));
    head(&mut picture, set, map, &say!("{} directions", set.points.len()));
    let (values, errors) = (&map.values.value, &map.values.standard_error);
    let (low, high) = values
        .iter()
        .filter(|value| **value > 0.0)
        .fold((f64::INFINITY, 0.0f64), |(low, high), value| (low.min(*value), high.max(*value)));
    let y = if high > 0.0 && low < high / 30.0 {
        Scale::logarithmic(low.max(WIDEST_SPAN * high) / 1.3, 1.3 * high)
    } else {
        Scale::linear(0.0, if high > 0.0 { 1.1 * high } else { 1.0 })
    };
    let frame = ChartFrame {
        left: LEFT + 50.0,
        top: TOP,
        width: WIDTH,
        height: HEIGHT,
        x: Scale::linear(from_deg.min(to_deg), from_deg.max(to_deg)),
        y,
    };
    frame.draw_plain(&mut picture, [say!("angle / °"), say!("luminance / cd/m²")]);
    let angle = |index: usize| from_deg + (to_deg - from_deg) * index as f64 / (values.len() - 1) as f64;
    let bottom = |value: f64| value.max(frame.y.low);
    for (index, (value, error)) in values.iter().zip(errors).enumerate() {
        let ends = [value - error, value + error].map(|end| frame.spot(angle(index), bottom(end).min(frame.y.high)));
        picture.line(ends.to_vec(), Pen::new(BLUE, 1.0));
    }
    let line = values.iter().enumerate().map(|(index, value)| frame.spot(angle(index), bottom(*value))).collect();
    picture.line(line, Pen::new(BLUE, 1.6));
    let note_spot = [LEFT, TOP + HEIGHT + 68.0];
    picture.words(
        Words::new(say!("Bars: one standard error. {}", note), note_spot, TYPE).ink(SOFT).anchored(TextAnchor::Start),
    );
    picture
}
