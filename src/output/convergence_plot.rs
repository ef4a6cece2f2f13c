//! The error during a run against time and chains, and the forecasts as they stood and as they came true.

use super::axes::{Frame, Scale, TYPE};
use super::color::{BLUE, SOFT, VERMILION};
use super::numbers::{count_tick, duration, percent, tick};
use super::picture::{Anchor, Pen, Picture, Spot, Words};
use crate::solver::{ConvergenceRow, Solution};

const WIDTH: f64 = 900.0;
const HEIGHT: f64 = 752.0;

/// One quantity of the judgements that spending grows.
struct Spending {
    name: &'static str,
    spent: fn(&ConvergenceRow) -> f64,
    forecast: fn(&ConvergenceRow) -> f64,
    forecast_name: &'static str,
    show: fn(f64) -> String,
}

const SPENDINGS: [Spending; 2] = [
    Spending {
        name: "time since start / s",
        spent: |row| row.wall_s,
        forecast: |row| row.forecast_wall_s,
        forecast_name: "forecast of the time needed / s",
        show: tick,
    },
    Spending {
        name: "chains",
        spent: |row| row.chains as f64,
        forecast: |row| row.forecast_chains,
        forecast_name: "forecast of the chains needed",
        show: count_tick,
    },
];

/// The stated error of the worst bound map over time and over chains (above), and what was forecast of the whole run
/// at every judgement beside what it came to (below).
///
/// In the spirit of figure 1 of Volobuev et al. on the accuracy of Monte Carlo illuminance: straight lines of slope
/// −1/2 are what independent chains give.
pub fn convergence_picture(solution: &Solution) -> Picture {
    let mut picture = Picture::new(WIDTH, HEIGHT, "Error against time and chains, with forecasts");
    picture.words(Words::new("How the error fell, and what was forecast", [62.0, 26.0], 17.0).bold());
    let rows: Vec<ConvergenceRow> = solution.convergence.iter().copied().filter(is_drawable).collect();
    let Some(last) = rows.last() else {
        let why = "The error was not judged while it was above 0: there is no curve to draw.";
        picture.words(Words::new(why, [62.0, 52.0], 13.0).ink(SOFT));
        return picture;
    };
    let target = solution.target_error.filter(|target| *target > 0.0);
    let aim = target.map_or(String::new(), |target| format!(", target {}", percent(target)));
    let line = format!(
        "Stated error {}{aim}, after {} chains in {}",
        percent(solution.estimated_error),
        super::numbers::amount(solution.chains as f64),
        duration(last.wall_s)
    );
    picture.words(Words::new(line, [62.0, 46.0], 13.0).ink(SOFT));
    for (index, spending) in SPENDINGS.iter().enumerate() {
        let left = 76.0 + 440.0 * index as f64;
        draw_error(&mut picture, [left, 74.0], &rows, target, spending);
        draw_forecast(&mut picture, [left, 404.0], &rows, target, spending);
    }
    draw_key(&mut picture, [76.0, HEIGHT - 20.0], target.is_some());
    picture
}

fn is_drawable(row: &ConvergenceRow) -> bool {
    row.estimated_error > 0.0 && row.estimated_error.is_finite() && row.wall_s > 0.0 && row.chains > 0
}

/// A logarithmic scale around numbers above 0.
fn around(numbers: impl Iterator<Item = f64>, room: f64) -> Scale {
    let (low, high) = numbers
        .filter(|number| number.is_finite() && *number > 0.0)
        .fold((f64::INFINITY, 0.0f64), |(low, high), number| (low.min(number), high.max(number)));
    if high == 0.0 {
        return Scale::logarithmic(0.1, 10.0);
    }
    Scale::logarithmic(low / room, high * room)
}

fn frame([left, top]: Spot, x: Scale, y: Scale) -> Frame {
    Frame { left, top, width: 365.0, height: 250.0, x, y }
}

fn draw_error(picture: &mut Picture, corner: Spot, rows: &[ConvergenceRow], target: Option<f64>, spending: &Spending) {
    let spent = || rows.iter().map(|row| (spending.spent)(row));
    let forecasts = || rows.iter().map(|row| (spending.forecast)(row)).filter(|forecast| *forecast > 0.0);
    let x = around(spent().chain(forecasts()), 1.25);
    let y = around(rows.iter().map(|row| row.estimated_error).chain(target), 1.3);
    let frame = frame(corner, x, y);
    let as_percent = |fraction: f64| format!("{} %", tick(((100.0 * fraction) * 1e9).round() / 1e9));
    frame.draw(picture, [spending.name, "stated error"], [&spending.show, &as_percent]);

    // Each forecast leads from where it was made to where it saw the target met.
    if let Some(target) = target {
        for row in with_forecast(rows, Some(target), spending) {
            let from = frame.spot((spending.spent)(row), row.estimated_error);
            let to = frame.spot((spending.forecast)(row), target);
            if frame.holds(to) {
                picture.line(vec![from, to], Pen::new(SOFT, 0.8).dashed(2.0, 3.0).faint(0.7));
                picture.ring(diamond(to), Pen::new(SOFT, 1.2));
            }
        }
        let ends = [frame.x.low, frame.x.high].map(|x| frame.spot(x, target));
        picture.line(ends.to_vec(), Pen::new(VERMILION, 1.6).dashed(7.0, 4.0));
    }
    let spots: Vec<Spot> = rows.iter().map(|row| frame.spot((spending.spent)(row), row.estimated_error)).collect();
    picture.line(spots.clone(), Pen::new(BLUE, 1.8));
    for spot in spots {
        picture.disk(spot, 3.2, BLUE);
    }
}

fn draw_forecast(
    picture: &mut Picture,
    corner: Spot,
    rows: &[ConvergenceRow],
    target: Option<f64>,
    spending: &Spending,
) {
    let end = end_of(rows, target);
    let drawn = with_forecast(rows, target, spending);
    let rows = &rows[..=end];
    let came_true = (spending.spent)(&rows[end]);
    let x = around(rows.iter().map(|row| (spending.spent)(row)), 1.25);
    let y = around(drawn.iter().map(|row| (spending.forecast)(row)).chain([came_true]), 1.6);
    let frame = frame(corner, x, y);
    let below = format!("when the forecast was made: {}", spending.name);
    frame.draw(picture, [&below, spending.forecast_name], [&spending.show, &spending.show]);
    let ends = [frame.x.low, frame.x.high].map(|x| frame.spot(x, came_true));
    picture.line(ends.to_vec(), Pen::new(VERMILION, 1.6));
    let spots: Vec<Spot> =
        drawn.iter().map(|row| frame.spot((spending.spent)(row), (spending.forecast)(row))).collect();
    picture.line(spots.clone(), Pen::new(SOFT, 0.8).dashed(2.0, 3.0));
    for spot in spots {
        picture.ring(diamond(spot), Pen::new(SOFT, 1.2));
    }
}

/// The judgement from which on the target was met, or else the last.
///
/// One map may meet it before another is judged at all. After it a run may still work on maps that the target does not
/// bind.
fn end_of(rows: &[ConvergenceRow], target: Option<f64>) -> usize {
    let is_met = |row: &ConvergenceRow| {
        target.is_some_and(|target| row.estimated_error <= target) && row.forecast_chains <= row.chains as f64
    };
    rows.iter().rposition(|row| !is_met(row)).map_or(0, |missed| (missed + 1).min(rows.len() - 1))
}

/// The judgements that forecast something, up to the end: while a map that the target binds is not judged yet, there is
/// nothing to forecast, and the rows repeat the present.
fn with_forecast<'a>(rows: &'a [ConvergenceRow], target: Option<f64>, spending: &Spending) -> Vec<&'a ConvergenceRow> {
    let end = end_of(rows, target);
    let is_ahead = |row: &ConvergenceRow| (spending.forecast)(row) > (spending.spent)(row);
    let kept = rows.iter().enumerate().filter(|(index, row)| *index == end || (*index < end && is_ahead(row)));
    kept.map(|(_, row)| row).collect()
}

fn diamond([x, y]: Spot) -> Vec<Spot> {
    const R: f64 = 4.2;
    vec![[x, y - R], [x + R, y], [x, y + R], [x - R, y]]
}

fn draw_key(picture: &mut Picture, [left, y]: Spot, has_target: bool) {
    let middle = y - 4.0;
    picture.line(vec![[left, middle], [left + 24.0, middle]], Pen::new(BLUE, 1.8));
    picture.disk([left + 12.0, middle], 3.2, BLUE);
    picture.words(Words::new("error as judged", [left + 32.0, y], TYPE));
    picture.ring(diamond([left + 170.0, middle]), Pen::new(SOFT, 1.2));
    picture.words(Words::new("forecast as it stood at each judgement", [left + 182.0, y], TYPE));
    picture.line(vec![[left + 440.0, middle], [left + 464.0, middle]], Pen::new(VERMILION, 1.6));
    picture.words(Words::new("what it came to", [left + 472.0, y], TYPE));
    if has_target {
        picture.line(vec![[left + 630.0, middle], [left + 654.0, middle]], Pen::new(VERMILION, 1.6).dashed(7.0, 4.0));
        picture.words(Words::new("target", [left + 662.0, y], TYPE).anchored(Anchor::Start));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(wall_s: f64, estimated_error: f64, forecast_wall_s: f64) -> ConvergenceRow {
        ConvergenceRow {
            wall_s,
            chains: 100,
            estimated_error,
            forecast_wall_s,
            forecast_chains: 100.0,
            rays: 500,
            forecast_rays: 500.0,
        }
    }

    /// A map that meets the target before the next one is judged does not end the run, and what it repeats of the
    /// present is no forecast.
    #[test]
    fn a_run_ends_with_its_last_map() {
        let rows = [row(0.1, 0.012, 0.1), row(0.2, 0.008, 0.2), row(0.3, 0.013, 0.5), row(0.4, 0.009, 0.4)];
        assert_eq!(end_of(&rows, Some(0.01)), 3);
        let forecasts: Vec<f64> =
            with_forecast(&rows, Some(0.01), &SPENDINGS[0]).iter().map(|row| row.forecast_wall_s).collect();
        assert_eq!(forecasts, [0.5, 0.4]);
        // Without a target, and where it was missed, the last judgement is the end; met from the first, the first.
        assert_eq!(end_of(&rows, None), 3);
        assert_eq!(end_of(&rows[..3], Some(0.01)), 2);
        assert_eq!(end_of(&rows, Some(0.02)), 0);
    }
}
