//! The plot of daylight factors on a grid.

use super::flat::FlatMap;
use super::map_plot::{MapLayout, draw_map};
use super::map_words::{GAP, draw_notes, foot, head, line_of_numbers, plus_minus};
use super::numbers::{lux, percent, percents_with_error, tick};
use super::picture::Picture;
use super::texts::say;
use crate::maps::{DaylightFactors, Estimate, MapResult, MapValues, NO_SKY_PERCENT};

/// Levels of the lines of equal daylight factor, in %.
pub(super) const LEVELS_PERCENT: [f64; 9] = [0.5, 1.0, 2.0, 3.0, 5.0, 10.0, 20.0, 30.0, 50.0];

/// Levels of the lines of equal sky component, in %.
const SKY_LEVELS_PERCENT: [f64; 8] = [NO_SKY_PERCENT, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0];

/// Draws false colours with lines of equal daylight factor, and the values that EN 17037 requires.
pub(super) fn daylight_picture(map: &FlatMap, factors: &DaylightFactors, note: &str) -> Picture {
    let mut shown = map.clone();
    let in_percent = |lx: f64| 100.0 * lx / factors.outside_lx;
    shown.cells.iter_mut().for_each(|cell| cell.value = cell.value.map(in_percent));
    shown.field.values.iter_mut().for_each(|value| *value = in_percent(*value));
    let (layout, mut picture) = MapLayout::of(&shown);
    let above = percent(factors.shares_above[0].value);
    let remark = say!("; {} of the area above {} %", above, lux(factors.targets_percent[0]));
    let rest = head(&mut picture, &shown, say!("Daylight factor"), &remark);
    let numbers_of =
        |name: &str, estimate: Estimate| format!("{name} = {} %{GAP}", percents_with_error(estimate, plus_minus));
    let numbers = numbers_of("Dmean", factors.average_percent)
        + &numbers_of("Dmin", factors.minimum_percent)
        + &numbers_of("Dmedian", factors.median_percent);
    line_of_numbers(&mut picture, numbers.trim_end());
    let range = shown.field.range().unwrap_or_default();
    let levels = LEVELS_PERCENT.into_iter().filter(|level| (range[0]..range[1]).contains(level)).collect();
    let remark = draw_map(&mut picture, &shown, &layout, (levels, say!("lines")), "%");
    foot(&mut picture, &shown, &format!("{rest}{remark}{note}"));
    picture
}

/// The texts and line levels of a plot of percentages on a grid.
pub(super) struct PercentWords<'a> {
    pub title: &'a str,
    pub remark: &'a str,
    /// Means and similar values, with their errors.
    pub numbers: String,
    /// Levels of lines, of which those within the grid's range are drawn.
    pub levels: &'a [f64],
    pub note: &'a str,
}

/// Draws percentages at the points of a grid in false colours.
pub(super) fn percent_picture(flat: &FlatMap, words: &PercentWords) -> Picture {
    let (layout, mut picture) = MapLayout::of(flat);
    let rest = head(&mut picture, flat, words.title, words.remark);
    line_of_numbers(&mut picture, &words.numbers);
    let range = flat.field.range().unwrap_or_default();
    let levels = words.levels.iter().copied().filter(|level| (range[0]..range[1]).contains(level)).collect();
    let remark = draw_map(&mut picture, flat, &layout, (levels, say!("lines")), "%");
    let numbers_of = format!("{rest}{remark}{} {}", say!("± is one standard error."), words.note);
    draw_notes(&mut picture, &numbers_of, 0);
    picture
}

/// The same for sky components. The first line is the no-sky line, beyond which hardly any sky is visible.
pub(super) fn sky_component_picture(flat: &FlatMap, means: &[(&str, Estimate)], note: &str) -> Picture {
    let numbers_of = |(name, mean): &(&str, Estimate)| format!("{name} = {} %", percents_with_error(*mean, plus_minus));
    percent_picture(
        flat,
        &PercentWords {
            title: say!("Sky component of the daylight factor"),
            remark: &say!("; the no-sky line at {} %", tick(NO_SKY_PERCENT)),
            numbers: means.iter().map(numbers_of).collect::<Vec<_>>().join(GAP),
            levels: &SKY_LEVELS_PERCENT,
            note,
        },
    )
}

/// The sky components of a map as a map for drawing, with values in %; `None` if they are unknown.
pub(super) fn sky_component_map(map: &MapResult, outside_lx: f64) -> Option<MapResult> {
    let components = &map.values.sky_components_lx;
    if components.is_empty() {
        return None;
    }
    let percent = |lx: f64| 100.0 * lx / outside_lx;
    let values = MapValues {
        value: components.iter().map(|[sky, ..]| percent(sky.value)).collect(),
        standard_error: components.iter().map(|[sky, ..]| percent(sky.standard_error)).collect(),
        ..MapValues::default()
    };
    Some(MapResult { values, ..map.clone() })
}
