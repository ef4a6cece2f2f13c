//! The plot of daylight factors on a grid.

use super::flat::FlatMap;
use super::map_plot::{GAP, Layout, ROOM, draw_map, foot, head, plus_minus};
use super::numbers::{lux, lux_with_error, percent};
use super::picture::{Picture, Words};
use super::texts::say;
use crate::maps::{DaylightFactors, Estimate};

/// Daylight factors in % along which lines run.
pub(super) const LEVELS_PERCENT: [f64; 6] = [0.5, 1.0, 2.0, 3.0, 5.0, 10.0];

/// False colours with lines of equal daylight factor, and what EN 17037 asks for.
pub(super) fn daylight_picture(map: &FlatMap, factors: &DaylightFactors, note: &str) -> Picture {
    let mut shown = map.clone();
    let in_percent = |lx: f64| 100.0 * lx / factors.outside_lx;
    shown.cells.iter_mut().for_each(|cell| cell.illuminance_lx = cell.illuminance_lx.map(in_percent));
    shown.field.values.iter_mut().for_each(|value| *value = in_percent(*value));
    let (layout, mut picture) = Layout::of(&shown);
    let above = percent(factors.shares_above[0].value);
    let remark = say!("; {} of the area above {} %", above, lux(factors.targets_percent[0]));
    head(&mut picture, &shown, say!("Daylight factor"), &remark);
    let told = |name: &str, estimate: Estimate| format!("{name} = {} %{GAP}", lux_with_error(estimate, plus_minus));
    let numbers = told("Dmean", factors.average_percent)
        + &told("Dmin", factors.minimum_percent)
        + &told("Dmedian", factors.median_percent);
    picture.words(Words::new(numbers.trim_end().to_owned(), [ROOM.left, 65.0], 13.0));
    let range = shown.field.range().unwrap_or_default();
    let levels = LEVELS_PERCENT.into_iter().filter(|level| (range[0]..range[1]).contains(level)).collect();
    let remark = draw_map(&mut picture, &shown, &layout, (levels, say!("lines")), "%");
    foot(&mut picture, &shown, &format!("{remark}{note}"));
    picture
}
