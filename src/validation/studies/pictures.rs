//! Plots of studies.

use plotters::prelude::*;

use crate::output::numbers::count_tick;
use crate::validation::plots::{Drawn, EXACT, FAINT, MEASURED, Sign, TEXT, legend, legend_height, svg, tick};

/// Colours that everyone can distinguish (Okabe and Ito 2008).
const COLOURS: [RGBColor; 8] = [
    EXACT,
    MEASURED,
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(86, 180, 233),
    RGBColor(0, 0, 0),
    RGBColor(230, 159, 0),
    RGBColor(130, 130, 130),
];
/// With this many powers of ten an axis needs no numbers between them.
const ENOUGH_POWERS: usize = 3;
/// Numbers below this are written in full on axes.
const WRITTEN_OUT: f64 = 1000.0;

/// A line of a plot.
pub struct PlotLine {
    /// Name of the line.
    pub name: String,
    /// Points of the line.
    pub places: Vec<(f64, f64)>,
}

impl PlotLine {
    /// Creates a line without points.
    pub fn new(name: impl Into<String>) -> PlotLine {
        PlotLine { name: name.into(), places: Vec::new() }
    }
}

/// Plot of lines with dots on logarithmic axes.
pub fn log_log(axes: [&str; 2], lines: &[PlotLine]) -> String {
    let all = || lines.iter().flat_map(|line| &line.places).filter(|place| place.1 > 0.0);
    if all().next().is_none() {
        return "<p>There is nothing to plot: every value is 0.</p>".to_owned();
    }
    let span = |of: fn(&(f64, f64)) -> f64| {
        all().fold((f64::INFINITY, 0.0f64), |(low, high), place| (low.min(of(place)), high.max(of(place))))
    };
    let (x, y) = (span(|place| place.0), span(|place| place.1));
    svg(400, |area| -> Drawn {
        let signs = signs(lines);
        let (top, below) = area.split_vertically(legend_height(&signs));
        legend(&top, &signs)?;
        let mut chart = ChartBuilder::on(&below)
            .margin(8)
            .margin_right(18)
            .x_label_area_size(46)
            .y_label_area_size(72)
            .build_cartesian_2d(
                (x.0 / 1.3..x.1 * 1.3).log_scale().with_key_points(log_ticks(x.0 / 1.3, x.1 * 1.3)),
                (y.0 / 1.6..y.1 * 1.6).log_scale().with_key_points(log_ticks(y.0 / 1.6, y.1 * 1.6)),
            )?;
        let words = |value: &f64| if *value < WRITTEN_OUT { tick(*value) } else { count_tick(*value) };
        chart
            .configure_mesh()
            .light_line_style(TRANSPARENT)
            .bold_line_style(FAINT)
            .x_labels(8)
            .y_labels(8)
            .x_desc(axes[0])
            .y_desc(axes[1])
            .label_style(TEXT)
            .x_label_formatter(&words)
            .y_label_formatter(&words)
            .draw()?;
        for (index, line) in lines.iter().enumerate() {
            let colour = COLOURS[index % COLOURS.len()];
            let shown: Vec<(f64, f64)> = line.places.iter().copied().filter(|place| place.1 > 0.0).collect();
            chart.draw_series(LineSeries::new(shown.clone(), colour.stroke_width(2)))?;
            match index % 3 {
                0 => chart.draw_series(shown.iter().map(|at| Circle::new(*at, 4, colour.filled())))?,
                1 => chart.draw_series(shown.iter().map(|at| TriangleMarker::new(*at, 6, colour.filled())))?,
                _ => chart.draw_series(shown.iter().map(|at| Cross::new(*at, 4, colour.stroke_width(2))))?,
            };
        }
        Ok(())
    })
}

/// Numbers on a logarithmic axis: powers of ten, with twice and five times these if there are few.
fn log_ticks(low: f64, high: f64) -> Vec<f64> {
    let powers = low.log10().floor() as i32..=high.log10().ceil() as i32;
    let ticks = |factors: &[f64]| -> Vec<f64> {
        let all = powers.clone().flat_map(|power| factors.iter().map(move |factor| factor * 10f64.powi(power)));
        all.filter(|tick| (low..=high).contains(tick)).collect()
    };
    let tens = ticks(&[1.0]);
    if tens.len() >= ENOUGH_POWERS { tens } else { ticks(&[1.0, 2.0, 5.0]) }
}

/// Plot of lines on linear axes, over the range `x` and upwards from 0.
pub fn profiles(axes: [&str; 2], x: [f64; 2], lines: &[PlotLine]) -> String {
    let most = lines.iter().flat_map(|line| &line.places).map(|place| place.1).fold(0.0, f64::max);
    svg(380, |area| -> Drawn {
        let signs: Vec<(Sign, String)> = lines
            .iter()
            .enumerate()
            .map(|(index, line)| (Sign::Line(COLOURS[index % COLOURS.len()]), line.name.clone()))
            .collect();
        let (top, below) = area.split_vertically(legend_height(&signs));
        legend(&top, &signs)?;
        let mut chart = ChartBuilder::on(&below)
            .margin(8)
            .margin_right(18)
            .x_label_area_size(46)
            .y_label_area_size(72)
            .build_cartesian_2d(x[0]..x[1], 0.0..1.08 * most.max(f64::MIN_POSITIVE))?;
        chart
            .configure_mesh()
            .light_line_style(TRANSPARENT)
            .bold_line_style(FAINT)
            .x_desc(axes[0])
            .y_desc(axes[1])
            .label_style(TEXT)
            .x_label_formatter(&|value| tick(if value.abs() < 1e-9 { 0.0 } else { *value }))
            .y_label_formatter(&|value| tick(*value))
            .draw()?;
        for (index, line) in lines.iter().enumerate() {
            let colour = COLOURS[index % COLOURS.len()];
            let shown = line.places.iter().copied().filter(|place| (x[0]..=x[1]).contains(&place.0));
            chart.draw_series(LineSeries::new(shown, colour.stroke_width(2)))?;
        }
        Ok(())
    })
}

fn signs(lines: &[PlotLine]) -> Vec<(Sign, String)> {
    let sign = |index: usize| {
        let colour = COLOURS[index % COLOURS.len()];
        match index % 3 {
            0 => Sign::Dot(colour),
            1 => Sign::Triangle(colour),
            _ => Sign::Cross(colour),
        }
    };
    lines.iter().enumerate().map(|(index, line)| (sign(index), line.name.clone())).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn short_axes_have_numbers_between_powers_of_ten() {
        assert_eq!(log_ticks(4.0, 25.0), [5.0, 10.0, 20.0]);
        assert_eq!(log_ticks(0.5, 2000.0), [1.0, 10.0, 100.0, 1000.0]);
    }
}
