//! Pictures of a proof: true against stated error, and costs compared with other methods.

use plotters::prelude::*;

use super::campaign::{Proof, RoomProof};
use super::summary::Group;
use crate::validation::plots::{
    Drawn, EXACT, FAINT, ForecastChart, MEASURED, OTHER, PlotArea, Sign, TEXT, legend, svg, tick,
};

/// Height of the bars of one room, in SVG units.
const ROW: u32 = 22;
/// Smallest error shown, as a share of the target. Smaller errors are drawn at this value.
const LEAST_SHOWN: f64 = 0.02;
/// Layout of the chart of forecasts.
const FORECASTS: ForecastChart =
    ForecastChart { x_desc: "share of the rays that was done, %", first_share: 0.005, reach: 5.0 };

/// Picture of true error against stated error, one dot per map of a run.
pub fn error_picture(proof: &Proof) -> String {
    let maps = || {
        proof.rooms.iter().flat_map(|room| {
            let runs = room.runs.iter().flat_map(|run| run.maps.iter().map(move |map| (run.target_error, map)));
            runs.filter(|(_, map)| map.said_met).map(move |(target, map)| (room, target, map))
        })
    };
    let targets = || proof.rooms.iter().flat_map(|room| &room.runs).map(|run| run.target_error);
    let most = maps().map(|(_, _, map)| map.judgement.true_error).chain(targets()).fold(1e-6, f64::max);
    let least = LEAST_SHOWN * targets().fold(f64::INFINITY, f64::min).min(most);
    svg(520, |area| {
        let (top, plot) = area.split_vertically(28);
        let signs = [
            (Sign::Dot(MEASURED), "rooms that methods are tuned on".to_owned()),
            (Sign::Dot(OTHER), "rooms to judge only".to_owned()),
            (Sign::Line(EXACT), "true = stated".to_owned()),
        ];
        legend(&top, &signs)?;
        let range = 100.0 * least..130.0 * most;
        let mut chart = ChartBuilder::on(&plot)
            .margin(8)
            .margin_right(18)
            .x_label_area_size(46)
            .y_label_area_size(72)
            .build_cartesian_2d(range.clone().log_scale(), range.clone().log_scale())?;
        chart
            .configure_mesh()
            .light_line_style(TRANSPARENT)
            .bold_line_style(FAINT)
            .x_desc("stated error, %")
            .y_desc("true error, %")
            .label_style(TEXT)
            .x_label_formatter(&|value| tick(*value))
            .y_label_formatter(&|value| tick(*value))
            .draw()?;
        let ends = [(range.start, range.start), (range.end, range.end)];
        chart.draw_series(LineSeries::new(ends, EXACT.stroke_width(2)))?;
        chart.draw_series(maps().map(|(room, _, map)| {
            let colour = if room.is_for_tuning() { MEASURED } else { OTHER };
            let place = [map.stated_error, map.judgement.true_error].map(|error| 100.0 * error.max(least));
            Circle::new((place[0], place[1]), 2, colour.mix(0.4).filled())
        }))?;
        Ok(())
    })
}

/// Picture of forecasts over the actual result, against the share of the rays that was done; one line per run.
pub fn forecast_picture(proof: &Proof) -> String {
    svg(420, |area| {
        let (top, plot) = area.split_vertically(28);
        let signs = [
            (Sign::Line(MEASURED), "rooms that methods are tuned on".to_owned()),
            (Sign::Line(OTHER), "rooms to judge only".to_owned()),
            (Sign::Line(EXACT), "actual value".to_owned()),
        ];
        legend(&top, &signs)?;
        FORECASTS.draw(&plot, |chart| {
            for (group, colour) in [(Group::Tuned, MEASURED), (Group::Untuned, OTHER)] {
                for forecasts in proof.forecasts(group) {
                    let shown = forecasts.iter().filter(|forecast| forecast.share >= FORECASTS.first_share);
                    let line = shown.map(|forecast| FORECASTS.place(forecast.share, forecast.ratio));
                    chart.draw_series(LineSeries::new(line, colour.mix(0.5)))?;
                }
            }
            Ok(())
        })
    })
}

/// Picture of the processor seconds of walks and of the rival over those of `auto`, at one target; bars for every room.
pub fn cost_picture(proof: &Proof, target: usize, target_error: f64) -> String {
    let ratios: Vec<(&RoomProof, [Option<f64>; 2])> = proof
        .rooms
        .iter()
        .map(|room| (room, room.ratios(target, target_error)))
        .filter(|(_, ratios)| ratios.iter().any(Option::is_some))
        .collect();
    let height = 100 + ROW * ratios.len() as u32;
    svg(height, |area| cost_bars(area, &ratios))
}

fn cost_bars(area: &PlotArea, ratios: &[(&RoomProof, [Option<f64>; 2])]) -> Drawn {
    let all = || ratios.iter().flat_map(|(_, ratios)| ratios.iter().flatten().copied());
    if all().next().is_none() {
        return Err("nothing to compare".into());
    }
    let (low, high) = all().fold((0.5, 2.0), |(low, high): (f64, f64), ratio| (low.min(ratio), high.max(ratio)));
    let (low, high) = (low / 1.3, high * 1.3);
    let (top, plot) = area.split_vertically(28);
    let signs = [
        (Sign::Bar(MEASURED.mix(0.7)), "walks".to_owned()),
        (Sign::Bar(OTHER.mix(0.7)), "rival".to_owned()),
        (Sign::Line(EXACT), "auto".to_owned()),
    ];
    legend(&top, &signs)?;
    let rows = ratios.len() as f64;
    let mut chart = ChartBuilder::on(&plot)
        .margin(8)
        .margin_right(18)
        .x_label_area_size(46)
        .y_label_area_size(150)
        .build_cartesian_2d((low..high).log_scale(), -0.5..rows - 0.5)?;
    let row_name = |row: &f64| {
        let index = (rows - 1.0 - row).round();
        let whole = (row - row.round()).abs() < 1e-6 && index >= 0.0;
        ratios.get(index as usize).filter(|_| whole).map(|(room, _)| room.name()).unwrap_or_default()
    };
    chart
        .configure_mesh()
        .disable_y_mesh()
        .light_line_style(TRANSPARENT)
        .bold_line_style(FAINT)
        .y_labels(2 * ratios.len() + 2)
        .x_desc("processor seconds to the same true error, divided by those of auto")
        .label_style((TEXT.0, 11))
        .x_label_formatter(&|value| tick(*value))
        .y_label_formatter(&row_name)
        .draw()?;
    for (index, (_, ratios)) in ratios.iter().enumerate() {
        let middle = rows - 1.0 - index as f64;
        let bars = [(ratios[0], MEASURED, 0.0), (ratios[1], OTHER, -0.36)];
        chart.draw_series(bars.into_iter().filter_map(|(ratio, colour, from)| {
            let ends = [(1.0, middle + from), (ratio?, middle + from + 0.34)];
            Some(Rectangle::new(ends, colour.mix(0.7).filled()))
        }))?;
    }
    chart.draw_series(LineSeries::new([(1.0, -0.5), (1.0, rows - 0.5)], EXACT.stroke_width(2)))?;
    Ok(())
}
