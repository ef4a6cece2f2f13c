//! Plots of measured against exact values, as SVG. Everyone can distinguish blue and vermilion; shapes distinguish them in print.

use std::ops::Range;

use plotters::coord::Shift;
use plotters::coord::combinators::LogCoord;
use plotters::prelude::*;

use super::comparison::Criterion;
use super::outcome::ComparisonOutcome;
use super::statistics::ComparedEntry;
use crate::output::color;
use crate::output::numbers;

/// Colour of measured values: the blue of the project's pages.
pub(super) const MEASURED: RGBColor = rgb(color::BLUE);
/// Colour of exact values.
pub(super) const EXACT: RGBColor = rgb(color::VERMILION);
/// Colour of published values.
const BESIDE: RGBColor = rgb(color::SOFT);
/// Colour of grids and bands.
pub(super) const FAINT: RGBColor = rgb(color::FAINT);
/// Colour of the band that the criterion allows: green-blue (Okabe and Ito 2008).
const ALLOWED: RGBColor = rgb(color::GREEN);
/// Colour of the method `auto`, of rooms not used for tuning, and of the rival.
pub(super) const OTHER: RGBColor = rgb(color::GREEN);
/// Font of axes and legends: the typeface of the pages, size in SVG units.
pub(super) const TEXT: (&str, u32) = ("Helvetica, Arial, sans-serif", 13);

/// Converts a colour of the project's pages for the plotter.
const fn rgb([red, green, blue]: color::Ink) -> RGBColor {
    RGBColor(red, green, blue)
}

/// Width of a plot in SVG units.
const WIDTH: u32 = 760;
/// With more entries than this the plot is a histogram of their z-scores.
const MOST_ENTRIES: usize = 70;
/// Up to this many entries in order have their names on the axis.
const MOST_NAMES: usize = 24;
/// Values that span more than this factor have a logarithmic axis.
const LOGARITHMIC_FROM: f64 = 30.0;

/// A picture, or a part of one, to draw in.
pub(super) type PlotArea<'a> = DrawingArea<SVGBackend<'a>, Shift>;

/// Result of drawing. The only error is a wrong range; the picture is then replaced by a message.
pub(super) type Drawn = Result<(), Box<dyn std::error::Error>>;

/// A chart of forecasts over actual results, against the share of a run that was done.
pub(super) struct ForecastChart {
    /// Label of the axis of shares.
    pub x_desc: &'static str,
    /// Smallest share shown.
    pub first_share: f64,
    /// Ratios further from 1 than this factor are drawn at this factor.
    pub reach: f64,
}

/// The coordinate plane of forecasts.
type ForecastPlane<'a, 'b> = ChartContext<'a, SVGBackend<'b>, Cartesian2d<LogCoord<f64>, LogCoord<f64>>>;

impl ForecastChart {
    /// Position of a forecast in the chart: share in percent, and ratio.
    pub fn place(&self, share: f64, ratio: f64) -> (f64, f64) {
        (100.0 * share, ratio.clamp(1.0 / self.reach, self.reach))
    }

    /// Draws the axes, the forecasts, and the line of the actual result.
    pub fn draw(&self, area: &PlotArea, forecasts: impl FnOnce(&mut ForecastPlane) -> Drawn) -> Drawn {
        let first = 100.0 * self.first_share;
        let mut chart =
            ChartBuilder::on(area)
                .margin(8)
                .margin_right(18)
                .x_label_area_size(46)
                .y_label_area_size(72)
                .build_cartesian_2d((first..100.0f64).log_scale(), (1.0 / self.reach..self.reach).log_scale())?;
        chart
            .configure_mesh()
            .light_line_style(TRANSPARENT)
            .bold_line_style(FAINT)
            .x_desc(self.x_desc)
            .y_desc("forecast over actual value")
            .label_style(TEXT)
            .x_label_formatter(&|value| tick(*value))
            .y_label_formatter(&|value| tick(*value))
            .draw()?;
        forecasts(&mut chart)?;
        chart.draw_series(LineSeries::new([(first, 1.0), (100.0, 1.0)], EXACT.stroke_width(2)))?;
        Ok(())
    }
}

/// Returns whether the picture shows each entry, not a histogram of all.
pub(super) fn shows_entries(outcome: &ComparisonOutcome) -> bool {
    outcome.set.entries.len() <= MOST_ENTRIES
}

/// The picture of a comparison.
pub fn comparison_plot(outcome: &ComparisonOutcome) -> String {
    if !shows_entries(outcome) {
        return svg(350, |area| {
            let (top, plot) = area.split_vertically(LEGEND_HEIGHT);
            let expected = "expected for correct error bars (Student's t)".to_owned();
            let bars = Sign::Bar(MEASURED.mix(0.55));
            legend(&top, &[(bars, "luxmc".to_owned()), (Sign::Line(EXACT), expected)])?;
            histogram(&plot, outcome)
        });
    }
    svg(480, |area| {
        let (top, plots) = area.split_vertically(LEGEND_HEIGHT);
        let mut signs = vec![
            (Sign::Dot(MEASURED), "luxmc, with two standard errors".to_owned()),
            (Sign::Line(EXACT), "exact".to_owned()),
        ];
        if let Some(beside) = &outcome.comparison.beside
            && outcome.set.entries.iter().any(|entry| entry.beside.is_some())
        {
            signs.push((Sign::Cross(BESIDE), beside.name.clone()));
        }
        legend(&top, &signs)?;
        let (upper, lower) = plots.split_vertically(250);
        values(&upper, outcome)?;
        deviations(&lower, outcome)
    })
}

/// Draws into an SVG text of the plots' width.
pub(super) fn svg(height: u32, draw: impl FnOnce(&PlotArea) -> Drawn) -> String {
    let mut text = String::new();
    {
        let area = SVGBackend::with_string(&mut text, (WIDTH, height)).into_drawing_area();
        let drawn = area.fill(&WHITE).map_err(Into::into).and_then(|()| draw(&area));
        if let Err(error) = drawn.and_then(|()| area.present().map_err(Into::into)) {
            return format!("<p>no plot: {}</p>", super::words::escaped(&error.to_string()));
        }
    }

    // The page scales the picture to its width.
    text.replacen(&format!("width=\"{WIDTH}\" height=\"{height}\" "), "", 1)
}

/// Horizontal positions of the entries, their range and the label of the axis.
struct EntryPlaces {
    at: Vec<f64>,
    range: Range<f64>,
    names: Option<Vec<String>>,
    label: String,
}

fn places(outcome: &ComparisonOutcome) -> EntryPlaces {
    let entries = &outcome.set.entries;
    if let Some(axis) = &outcome.comparison.axis
        && entries.iter().all(|entry| entry.along_m.is_some())
    {
        let at: Vec<f64> = entries.iter().filter_map(|entry| entry.along_m).collect();
        let (low, high) = span(at.iter().copied());
        let room = 0.04 * (high - low).max(1e-9);
        return EntryPlaces { at, range: low - room..high + room, names: None, label: axis.label.clone() };
    }
    let at = (0..entries.len()).map(|index| index as f64).collect();
    let names = (entries.len() <= MOST_NAMES).then(|| entries.iter().map(|entry| entry.label.clone()).collect());
    EntryPlaces { at, range: -0.6..entries.len() as f64 - 0.4, names, label: String::new() }
}

fn span(numbers: impl Iterator<Item = f64>) -> (f64, f64) {
    numbers.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), number| (low.min(number), high.max(number)))
}

fn values(area: &PlotArea, outcome: &ComparisonOutcome) -> Drawn {
    let places = places(outcome);
    let entries = &outcome.set.entries;
    let (low, high) = span(entries.iter().flat_map(|entry| [entry.measured, entry.exact.value]));
    let positive = span(entries.iter().map(|entry| entry.exact.value).filter(|value| *value > 0.0)).0;
    let logarithmic = low > 0.0 && high / positive > LOGARITHMIC_FROM;
    let mut builder = ChartBuilder::on(area);
    builder.margin(8).margin_right(18).x_label_area_size(8).y_label_area_size(72);
    if logarithmic {
        let mut chart = builder.build_cartesian_2d(places.range.clone(), (low / 1.5..high * 1.5).log_scale())?;
        chart
            .configure_mesh()
            .disable_x_mesh()
            .light_line_style(TRANSPARENT)
            .bold_line_style(FAINT)
            .x_labels(0)
            .y_desc("illuminance, lx")
            .label_style(TEXT)
            .y_label_formatter(&|value| tick(*value))
            .draw()?;
        draw_values(&mut chart, &places, entries, outcome)
    } else {
        let room = 0.12 * (high - low).max(0.02 * high.abs()).max(1e-12);
        let bottom = if low >= 0.0 && low < 0.5 * high { -0.02 * high } else { low - room };
        let mut chart = builder.build_cartesian_2d(places.range.clone(), bottom..high + room)?;
        chart
            .configure_mesh()
            .disable_x_mesh()
            .light_line_style(TRANSPARENT)
            .bold_line_style(FAINT)
            .x_labels(0)
            .y_labels(6)
            .y_desc("illuminance, lx")
            .label_style(TEXT)
            .y_label_formatter(&|value| tick(*value))
            .draw()?;
        draw_values(&mut chart, &places, entries, outcome)
    }
}

fn draw_values<'a, Y>(
    chart: &mut ChartContext<'a, SVGBackend<'a>, Cartesian2d<plotters::coord::types::RangedCoordf64, Y>>,
    places: &EntryPlaces,
    entries: &[ComparedEntry],
    outcome: &ComparisonOutcome,
) -> Drawn
where
    Y: Ranged<ValueType = f64>,
{
    let at = |index: usize| places.at[index];
    let exact = || entries.iter().enumerate().map(|(index, entry)| (at(index), entry.exact.value));
    if outcome.comparison.axis.is_some() {
        let mut line: Vec<(f64, f64)> = exact().collect();
        line.sort_by(|a, b| a.0.total_cmp(&b.0));
        chart.draw_series(LineSeries::new(line, EXACT.stroke_width(2)))?;
    }
    chart.draw_series(
        exact().map(|place| EmptyElement::at(place) + Rectangle::new([(-9, -1), (9, 1)], EXACT.filled())),
    )?;
    if outcome.comparison.beside.is_some() {
        let published = entries.iter().enumerate().filter_map(|(index, entry)| Some((at(index), entry.beside?)));
        chart.draw_series(published.map(|place| Cross::new(place, 5, BESIDE.stroke_width(2))))?;
    }
    chart.draw_series(entries.iter().enumerate().map(|(index, entry)| {
        let (value, error) = (entry.measured, 2.0 * entry.standard_error);
        PathElement::new(vec![(at(index), value - error), (at(index), value + error)], MEASURED.stroke_width(2))
    }))?;
    chart.draw_series(
        entries.iter().enumerate().map(|(index, entry)| Circle::new((at(index), entry.measured), 4, MEASURED.filled())),
    )?;
    Ok(())
}

/// A sign in a legend.
pub(super) enum Sign {
    /// A short line.
    Line(RGBColor),
    /// A dot.
    Dot(RGBColor),
    /// A triangle.
    Triangle(RGBColor),
    /// A cross.
    Cross(RGBColor),
    /// A bar.
    Bar(RGBAColor),
}

/// Width of a sign in a legend, including the gap before its name.
const SIGN_WIDTH: i32 = 25;
/// Height of a row of a legend.
const LEGEND_HEIGHT: u32 = 26;

/// Height of a legend with these signs.
pub(super) fn legend_height(signs: &[(Sign, String)]) -> u32 {
    let rows = legend_places(signs).last().map_or(1, |(_, row)| row + 1);
    LEGEND_HEIGHT * rows
}

/// Left edge and row of each sign. After a full row a new row begins.
fn legend_places(signs: &[(Sign, String)]) -> Vec<(i32, u32)> {
    const FIRST_X: i32 = 82;
    const GAP: i32 = 22;
    const LETTER_WIDTH: f64 = 7.2;
    let (mut x, mut row) = (FIRST_X, 0);
    let place = |(_, name): &(Sign, String)| {
        let width = SIGN_WIDTH + (LETTER_WIDTH * name.chars().count() as f64) as i32;
        if x > FIRST_X && x + width > WIDTH as i32 {
            (x, row) = (FIRST_X, row + 1);
        }
        let left = x;
        x += width + GAP;
        (left, row)
    };
    signs.iter().map(place).collect()
}

/// Draws a legend at the top of a plot, where it covers nothing.
pub(super) fn legend(area: &PlotArea, signs: &[(Sign, String)]) -> Drawn {
    for ((sign, name), (x, row)) in signs.iter().zip(legend_places(signs)) {
        let y = 14 + (row * LEGEND_HEIGHT) as i32;
        match sign {
            Sign::Line(colour) => area.draw(&Rectangle::new([(x, y - 1), (x + 18, y + 1)], colour.filled()))?,
            Sign::Dot(colour) => area.draw(&Circle::new((x + 9, y), 4, colour.filled()))?,
            Sign::Triangle(colour) => area.draw(&TriangleMarker::new((x + 9, y), 6, colour.filled()))?,
            Sign::Cross(colour) => area.draw(&plotters::element::Cross::new((x + 9, y), 5, colour.stroke_width(2)))?,
            Sign::Bar(colour) => area.draw(&Rectangle::new([(x, y - 5), (x + 18, y + 5)], colour.filled()))?,
        }
        area.draw(&Text::new(name.clone(), (x + SIGN_WIDTH, y - 7), TEXT.into_font().color(&BLACK)))?;
    }
    Ok(())
}

fn deviations(area: &PlotArea, outcome: &ComparisonOutcome) -> Drawn {
    let places = places(outcome);
    let entries = &outcome.set.entries;
    let sizes: Vec<f64> = {
        let mean = entries.iter().map(|entry| entry.exact.value).sum::<f64>() / entries.len() as f64;
        entries.iter().map(|entry| if entry.exact.value > 0.0 { entry.exact.value } else { mean }).collect()
    };
    let percent = |index: usize, lx: f64| 100.0 * lx / sizes[index];
    let limit = allowed_percent(&outcome.comparison.criterion);
    let reach = entries
        .iter()
        .enumerate()
        .map(|(index, entry)| percent(index, entry.deviation().abs() + 2.0 * entry.standard_error))
        .chain(limit)
        .fold(0.0, f64::max);
    let reach = 1.15 * if reach > 0.0 { reach } else { 1e-6 };
    let mut chart = ChartBuilder::on(area)
        .margin(8)
        .margin_right(18)
        .x_label_area_size(46)
        .y_label_area_size(72)
        .build_cartesian_2d(places.range.clone(), -reach..reach)?;
    let named = |value: &f64| match &places.names {
        Some(names) => {
            let index = value.round();
            let whole = (value - index).abs() < 1e-6 && index >= 0.0;
            names.get(index as usize).filter(|_| whole).cloned().unwrap_or_default()
        }
        None => tick(*value),
    };
    chart
        .configure_mesh()
        .disable_x_mesh()
        .light_line_style(TRANSPARENT)
        .bold_line_style(FAINT)
        .x_labels(if places.names.is_some() { 0 } else { 10 })
        .y_labels(5)
        .x_desc(places.label.clone())
        .y_desc("deviation, %")
        .label_style(TEXT)
        .x_label_formatter(&named)
        .y_label_formatter(&|value| signed_tick(*value))
        .draw()?;
    if let Some(limit) = limit {
        let band =
            Rectangle::new([(places.range.start, -limit), (places.range.end, limit)], ALLOWED.mix(0.14).filled());
        chart.draw_series([band])?;
    }
    chart.draw_series([PathElement::new(
        vec![(places.range.start, 0.0), (places.range.end, 0.0)],
        EXACT.stroke_width(2),
    )])?;
    chart.draw_series(entries.iter().enumerate().map(|(index, entry)| {
        let (value, error) = (percent(index, entry.deviation()), percent(index, 2.0 * entry.standard_error));
        let ends = vec![(places.at[index], value - error), (places.at[index], value + error)];
        PathElement::new(ends, MEASURED.stroke_width(2))
    }))?;
    chart.draw_series(entries.iter().enumerate().map(|(index, entry)| {
        Circle::new((places.at[index], percent(index, entry.deviation())), 4, MEASURED.filled())
    }))?;
    if outcome.comparison.beside.is_some() {
        let published = entries.iter().enumerate().filter_map(|(index, entry)| {
            let deviation = percent(index, entry.beside? - entry.exact.value);
            (deviation.abs() <= reach).then_some((places.at[index], deviation))
        });
        chart.draw_series(published.map(|place| Cross::new(place, 5, BESIDE.stroke_width(2))))?;
    }
    if let Some(names) = &places.names {
        let style = TEXT.into_font().color(&BLACK);
        for (index, name) in names.iter().enumerate() {
            let (x, _) = chart.backend_coord(&(places.at[index], -reach));
            let (_, y) = chart.backend_coord(&(places.at[index], -reach));
            let width = 6 * name.chars().count() as i32;
            let crowded = names.iter().map(|name| name.chars().count()).sum::<usize>() > 90;
            let drop = if crowded && index % 2 == 1 { 22 } else { 6 };
            let root = area.get_pixel_range();
            let place = (x - root.0.start - width / 2, y - root.1.start + drop);
            area.draw(&Text::new(name.clone(), place, style.clone()))?;
        }
    }
    Ok(())
}

fn allowed_percent(criterion: &Criterion) -> Option<f64> {
    criterion.worst.map(|fraction| 100.0 * fraction.0)
}

/// Histogram of the z-scores with the expected Student's t distribution.
fn histogram(area: &PlotArea, outcome: &ComparisonOutcome) -> Drawn {
    const REACH: f64 = 5.0;
    const BINS: usize = 40;
    let width = 2.0 * REACH / BINS as f64;
    let scores: Vec<f64> = outcome.set.entries.iter().filter_map(ComparedEntry::z).collect();
    if scores.is_empty() {
        return Err("every value is exact".into());
    }
    let mut counts = [0usize; BINS];
    for z in &scores {
        let bin = ((z + REACH) / width).floor().clamp(0.0, (BINS - 1) as f64);
        counts[bin as usize] += 1;
    }
    let expected = |low: f64| {
        let cdf = |z: f64| {
            let within = super::statistics::probability_within(z.abs(), outcome.set.degrees_of_freedom);
            0.5 + 0.5 * z.signum() * within
        };
        (cdf(low + width) - cdf(low)) * scores.len() as f64
    };
    let highest =
        (0..BINS).map(|bin| expected(-REACH + bin as f64 * width).max(counts[bin] as f64)).fold(1.0, f64::max);
    let mut chart = ChartBuilder::on(area)
        .margin(8)
        .margin_right(18)
        .x_label_area_size(46)
        .y_label_area_size(72)
        .build_cartesian_2d(-REACH..REACH, 0.0..1.12 * highest)?;
    chart
        .configure_mesh()
        .disable_x_mesh()
        .light_line_style(TRANSPARENT)
        .bold_line_style(FAINT)
        .x_labels(11)
        .y_labels(5)
        .x_desc("deviation from the exact value, in standard errors (the outer bins hold all beyond)")
        .y_desc("elements")
        .label_style(TEXT)
        .x_label_formatter(&|value| signed_tick(*value))
        .y_label_formatter(&|value| tick(*value))
        .draw()?;
    chart.draw_series(counts.iter().enumerate().map(|(bin, count)| {
        let low = -REACH + bin as f64 * width;
        let mut bar = Rectangle::new([(low, 0.0), (low + width, *count as f64)], MEASURED.mix(0.55).filled());
        bar.set_margin(0, 0, 1, 1);
        bar
    }))?;
    let curve = (0..BINS).map(|bin| {
        let low = -REACH + bin as f64 * width;
        (low + 0.5 * width, expected(low))
    });
    chart.draw_series(LineSeries::new(curve, EXACT.stroke_width(2)))?;
    Ok(())
}

/// A number on an axis. Rounding to four digits removes rounding errors of the axis' steps.
pub(super) fn tick(value: f64) -> String {
    numbers::tick(format!("{value:.3e}").parse().unwrap_or(value))
}

fn signed_tick(value: f64) -> String {
    // A tick at 0 may have a rounding error.
    if value.abs() < 1e-12 {
        return "0".to_owned();
    }
    if value > 0.0 { format!("+{}", tick(value)) } else { tick(value) }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every name ends within the picture. Planted fault: in one row the last of seven names does not.
    #[test]
    fn long_legends_take_more_rows() {
        let names = ["auto (walk)", "collision (walk)", "gather", "local", "local-naive", "radiosity"];
        let last = "light-mesh (shadow-rays)";
        let signs: Vec<(Sign, String)> =
            names.iter().chain([&last]).map(|name| (Sign::Dot(MEASURED), (*name).to_owned())).collect();
        let right = |x: i32, name: &str| x + 25 + (7.2 * name.chars().count() as f64) as i32;
        let places = legend_places(&signs);
        for ((x, _), (_, name)) in places.iter().zip(&signs) {
            assert!(right(*x, name) <= WIDTH as i32, "{name} at {x}");
        }
        let in_one_row = names.iter().fold(82, |x, name| right(x, name) + 22);
        assert!(right(in_one_row, last) > WIDTH as i32);
        assert_eq!(legend_height(&signs), 2 * LEGEND_HEIGHT);
        assert_eq!(legend_height(&signs[..3]), LEGEND_HEIGHT);
    }
}
