//! Pictures of a calibration.

use plotters::prelude::*;

use super::campaign::{Campaign, LEVELS};
use crate::validation::plots::{Drawn, EXACT, FAINT, ForecastChart, MEASURED, OTHER, PlotArea, TEXT, svg, tick};

/// Height of a row with the runs of one campaign, in SVG units.
const ROW: u32 = 30;
/// Layout of the chart of forecasts.
const FORECASTS: ForecastChart =
    ForecastChart { x_desc: "share of the run that was done, %", first_share: 1e-3, reach: 10.0 };
/// Errors beyond this multiple of the target are drawn at the border.
const ERROR_REACH: f64 = 3.0;
/// Maximum number of forecasts drawn for a campaign, evenly chosen.
const MOST_DOTS: usize = 400;

fn colour(campaign: &Campaign) -> RGBColor {
    if campaign.method == "auto" { OTHER } else { MEASURED }
}

fn name(campaign: &Campaign) -> String {
    format!("{}: {}, {}", campaign.case, campaign.comparison, campaign.method)
}

/// Draws the legend of the two methods above a picture.
fn methods(area: &PlotArea) -> Drawn {
    use crate::validation::plots::{Sign, legend};
    let signs = [(Sign::Dot(MEASURED), "collision".to_owned()), (Sign::Dot(OTHER), "auto".to_owned())];
    legend(area, &signs)
}

/// Picture of the coverage minus its nominal level, one line per campaign.
pub(super) fn coverage_picture(campaigns: &[Campaign]) -> String {
    svg(400, |area| {
        let (top, plot) = area.split_vertically(28);
        methods(&top)?;
        let excess = |campaign: &Campaign, level: usize| 100.0 * (campaign.coverage(level) - LEVELS[level]);
        let all = || campaigns.iter().flat_map(|campaign| (0..LEVELS.len()).map(move |level| excess(campaign, level)));
        let reach = 1.15 * all().fold(2.0, |most: f64, value| most.max(value.abs()));
        let mut chart = ChartBuilder::on(&plot)
            .margin(8)
            .margin_right(18)
            .x_label_area_size(46)
            .y_label_area_size(72)
            .build_cartesian_2d(0.0..100.0, -reach..reach)?;
        chart
            .configure_mesh()
            .light_line_style(TRANSPARENT)
            .bold_line_style(FAINT)
            .x_desc("nominal level of the error bars, %")
            .y_desc("held share minus nominal, points")
            .label_style(TEXT)
            .x_label_formatter(&|value| tick(*value))
            .y_label_formatter(&|value| tick(*value))
            .draw()?;
        chart.draw_series(LineSeries::new([(0.0, 0.0), (100.0, 0.0)], EXACT.stroke_width(2)))?;
        for campaign in campaigns {
            let points: Vec<(f64, f64)> =
                (0..LEVELS.len()).map(|level| (100.0 * LEVELS[level], excess(campaign, level))).collect();
            chart.draw_series(LineSeries::new(points.iter().copied(), colour(campaign).mix(0.5).stroke_width(1)))?;
            chart.draw_series(points.iter().map(|point| Circle::new(*point, 3, colour(campaign).mix(0.7).filled())))?;
        }
        Ok(())
    })
}

/// Picture of the true error over the target, one row per campaign and one dot per run.
pub(super) fn error_picture(campaigns: &[Campaign]) -> String {
    let height = 90 + ROW * campaigns.len() as u32;
    svg(height, |area| {
        let ratios = |campaign: &Campaign| -> Vec<f64> {
            campaign.runs.iter().map(|run| (run.true_error / campaign.target_error).min(ERROR_REACH)).collect()
        };
        let most = campaigns.iter().flat_map(ratios).fold(1.3, f64::max);
        let rows = campaigns.len() as f64;
        let mut chart = ChartBuilder::on(area)
            .margin(8)
            .margin_right(18)
            .x_label_area_size(46)
            .y_label_area_size(230)
            .build_cartesian_2d(0.0..1.05 * most, -0.5..rows - 0.5)?;
        let row_name = |row: &f64| {
            let index = (rows - 1.0 - row).round();
            let whole = (row - row.round()).abs() < 1e-6 && index >= 0.0;
            campaigns.get(index as usize).filter(|_| whole).map(name).unwrap_or_default()
        };
        chart
            .configure_mesh()
            .disable_y_mesh()
            .light_line_style(TRANSPARENT)
            .bold_line_style(FAINT)
            .y_labels(2 * campaigns.len() + 2)
            .x_desc("true error over target (at 3: and more)")
            .label_style((TEXT.0, 11))
            .x_label_formatter(&|value| tick(*value))
            .y_label_formatter(&row_name)
            .draw()?;
        chart.draw_series(LineSeries::new([(1.0, -0.5), (1.0, rows - 0.5)], EXACT.stroke_width(2)))?;
        for (index, campaign) in campaigns.iter().enumerate() {
            let middle = rows - 1.0 - index as f64;
            let dots = ratios(campaign).into_iter().enumerate().map(|(run, ratio)| {
                // Dots are spread over the row's height by the golden section, so that they overlap less.
                let shift = 0.6 * ((run as f64 * 0.618_033_988_75).fract() - 0.5);
                Circle::new((ratio, middle + shift), 2, colour(campaign).mix(0.5).filled())
            });
            chart.draw_series(dots)?;
        }
        Ok(())
    })
}

/// Picture of the forecasts over the actual result, against the share of the work.
pub(super) fn forecast_picture(campaigns: &[Campaign]) -> String {
    svg(420, |area| {
        let (top, plot) = area.split_vertically(28);
        methods(&top)?;
        FORECASTS.draw(&plot, |chart| {
            for campaign in campaigns {
                let forecasts = || {
                    let all = campaign.runs.iter().flat_map(|run| &run.forecasts);
                    all.filter(|forecast| (FORECASTS.first_share..1.0).contains(&forecast.share))
                };
                let step = forecasts().count().div_ceil(MOST_DOTS).max(1);
                let dots = forecasts().step_by(step).map(|forecast| {
                    let place = FORECASTS.place(forecast.share, forecast.ratio);
                    Circle::new(place, 2, colour(campaign).mix(0.25).filled())
                });
                chart.draw_series(dots)?;
            }
            Ok(())
        })
    })
}
