//! Plots the error during a run against rays and seconds of computing, with the forecasts and their outcome.

use super::axes::{ChartFrame, Scale, TYPE};
use super::color::{BLACK, BLUE, FAINT, GREEN, Ink, PURPLE, SKY, SOFT, VERMILION};
use super::numbers::{count, count_tick, duration, percent, tick};
use super::picture::{PagePoint, Pen, Picture, TextAnchor, Words};
use super::texts::{decimal, said, say, words};
use crate::control::{FORECAST_SHARES, Forecast};
use crate::solver::{ConvergenceRow, ErrorParts, Solution};

const WIDTH: f64 = 940.0;
const HEIGHT: f64 = 572.0;
/// Top and height of each panel: the errors, and the forecasts below them on the same axis.
const ERRORS: [f64; 2] = [96.0, 270.0];
const FORECASTS: [f64; 2] = [384.0, 104.0];
/// Height for the numbers and label of the axis of the upper panels, if there are no forecasts below.
const BELOW_AXIS: f64 = 36.0;
/// Left edges of the columns, and the width of a column.
const LEFTS: [f64; 2] = [92.0, 552.0];
const COLUMN: f64 = 360.0;
/// Parts of the error are drawn down to this multiple of the least error or target.
const LEAST_PART: f64 = 0.2;

/// One quantity that a run spends.
struct SpentQuantity {
    name: &'static str,
    spent: fn(&ConvergenceRow, f64) -> f64,
    forecast: fn(&ConvergenceRow, f64) -> Forecast,
    show: fn(f64) -> String,
}

const SPENDINGS: [SpentQuantity; 2] = [
    SpentQuantity {
        name: words!("rays"),
        spent: |row, _| row.rays as f64,
        forecast: |row, _| row.forecast_rays,
        show: count_tick,
    },
    SpentQuantity {
        name: words!("computing time / s"),
        spent: |row, begun_s| row.wall_s - begun_s,
        forecast: |row, begun_s| {
            let since = |wall_s: f64| wall_s - begun_s;
            let wall_s = row.forecast_wall_s;
            Forecast { expected: since(wall_s.expected), low: since(wall_s.low), high: since(wall_s.high) }
        },
        show: tick,
    },
];

/// A part of the error, with the ink of its line.
struct ErrorPart {
    name: &'static str,
    of: fn(&ErrorParts) -> f64,
    ink: Ink,
}

const ERROR_PARTS: [ErrorPart; 3] = [
    ErrorPart { name: words!("random"), of: |error| error.random, ink: SKY },
    ErrorPart { name: words!("bias"), of: |error| error.bias, ink: PURPLE },
    ErrorPart { name: words!("discretisation"), of: |error| error.discretisation, ink: GREEN },
];

/// A forecast as it was when a share of the run was done.
struct Stood<'a> {
    label: String,
    row: &'a ConvergenceRow,
}

/// Draws the stated error of the worst bound map over rays and over seconds of computing (above). Below, it draws the forecasts of
/// the whole run at several times, beside the run's actual total.
///
/// The style follows figure 1 of Volobuev et al. on the accuracy of Monte Carlo illuminance: independent chains give straight lines
/// of slope −1/2.
pub fn convergence_picture(solution: &Solution) -> Picture {
    let mut picture = Picture::new(WIDTH, HEIGHT, say!("Error against rays and time, with forecasts"));
    picture.words(Words::new(say!("How the error fell, and what was forecast"), [62.0, 26.0], 17.0).bold());
    let begun_s = solution.begun_wall_s;
    let is_drawable =
        |row: &&ConvergenceRow| row.error.estimated > 0.0 && row.error.estimated.is_finite() && row.wall_s > begun_s;
    let rows: Vec<ConvergenceRow> = solution.convergence.iter().filter(is_drawable).copied().collect();
    let Some(last) = rows.last() else {
        let why = say!("There is no curve to draw: no error check found an error above 0.");
        picture.words(Words::new(why, [62.0, 52.0], 13.0).ink(SOFT));
        return picture;
    };
    let target = solution.target_error.filter(|target| *target > 0.0);
    let aim = target.map_or(String::new(), |target| say!(", target {}", percent(target)));
    let rays = if last.rays == 0 { String::new() } else { say!("{} rays in ", count(last.rays as f64)) };
    let line = say!(
        "Stated error {}{}, after {}{} of computing; starting, reading and building took {} before that",
        percent(solution.estimated_error),
        aim,
        rays,
        duration(last.wall_s - begun_s),
        duration(begun_s)
    );
    picture.words(Words::new(line, [62.0, 46.0], 13.0).ink(SOFT));
    let parts: Vec<&ErrorPart> = shown_parts(&rows);
    let stood = as_they_stood(&rows);
    let spendings = SPENDINGS.iter().filter(|spending| rows.iter().all(|row| (spending.spent)(row, begun_s) > 0.0));
    for (spending, left) in spendings.zip(LEFTS) {
        let numbers = |row: &ConvergenceRow| (spending.spent)(row, begun_s);
        let reach = |stood: &Stood| {
            let forecast = (spending.forecast)(stood.row, begun_s);
            [forecast.low, forecast.expected, forecast.high]
        };
        let x = around(rows.iter().map(numbers).chain(stood.iter().flat_map(reach)), 1.15);
        let panel = SpendingPanel { spending, begun_s, rows: &rows, stood: &stood, target };
        panel.draw_errors(&mut picture, left, x, &parts);
        if !stood.is_empty() {
            panel.draw_forecasts(&mut picture, left, x);
        }
    }
    draw_key(&mut picture, &parts, target.is_some(), rows.iter().any(|row| !row.judged));
    if stood.is_empty() {
        // A run with a single error check has no forecast.
        picture.height = FORECASTS[0] + BELOW_AXIS;
    } else {
        draw_key_of_forecasts(&mut picture, target.is_some());
    }
    picture
}

/// The parts of the error, if there is more than one.
fn shown_parts(rows: &[ConvergenceRow]) -> Vec<&'static ErrorPart> {
    let judged = || rows.iter().filter(|row| row.judged);
    let shown: Vec<&ErrorPart> =
        ERROR_PARTS.iter().filter(|part| judged().any(|row| (part.of)(&row.error) > 0.0)).collect();
    if shown.len() > 1 { shown } else { Vec::new() }
}

/// For each share, the latest forecast before that share of the run was done. If the first forecast came later, it is shown under
/// its own share.
fn as_they_stood(rows: &[ConvergenceRow]) -> Vec<Stood<'_>> {
    // Forecasts that repeat the present values know nothing of the end: those of a resumed run before it got its present target.
    let known = |row: &&ConvergenceRow| {
        row.forecast_rays.expected > row.rays as f64 || row.forecast_wall_s.expected > row.wall_s
    };
    let (Some(first), Some(last)) = (rows.iter().find(known), rows.last()) else {
        return Vec::new();
    };
    // The progress of a method without rays is measured by time.
    let done = |row: &ConvergenceRow| if last.rays > 0 { row.rays as f64 } else { row.wall_s };
    let first_share = done(first) / done(last);
    let label = |share: f64| say!("at {} %", decimal(format!("{:.0}", (100.0 * share).max(1.0))));
    let mut stood = Vec::new();
    let later_shares = || FORECAST_SHARES.into_iter().filter(|share| *share > first_share);
    // The first row stands for itself, unless it stands for the next share under the same label.
    let is_apart = later_shares().all(|share| label(share) != label(first_share));
    if FORECAST_SHARES[0] < first_share && first_share < 1.0 && is_apart {
        stood.push(Stood { label: label(first_share), row: first });
    }
    for share in later_shares() {
        if let Some(row) = rows.iter().filter(known).rfind(|row| done(row) <= share * done(last)) {
            stood.push(Stood { label: label(share), row });
        }
    }
    stood
}

/// A logarithmic scale around the positive numbers, widened by the factor `room` at either end.
fn around(numbers: impl Iterator<Item = f64>, room: f64) -> Scale {
    let (low, high) = numbers
        .filter(|number| number.is_finite() && *number > 0.0)
        .fold((f64::INFINITY, 0.0f64), |(low, high), number| (low.min(number), high.max(number)));
    if high == 0.0 {
        return Scale::logarithmic(0.1, 10.0);
    }
    Scale::logarithmic(low / room, high * room)
}

/// Errors and forecasts over one spent quantity.
struct SpendingPanel<'a> {
    spending: &'a SpentQuantity,
    begun_s: f64,
    rows: &'a [ConvergenceRow],
    stood: &'a [Stood<'a>],
    target: Option<f64>,
}

impl SpendingPanel<'_> {
    fn spent(&self, row: &ConvergenceRow) -> f64 {
        (self.spending.spent)(row, self.begun_s)
    }

    fn forecast(&self, stood: &Stood) -> Forecast {
        (self.spending.forecast)(stood.row, self.begun_s)
    }

    /// Total of the quantity that the run spent.
    fn end(&self) -> f64 {
        self.rows.last().map_or(0.0, |row| self.spent(row))
    }

    fn draw_errors(&self, picture: &mut Picture, left: f64, x: Scale, parts: &[&ErrorPart]) {
        let errors = || self.rows.iter().map(|row| row.error.estimated).chain(self.target);
        let least = LEAST_PART * errors().fold(f64::INFINITY, f64::min);
        let of_parts = self.rows.iter().flat_map(|row| parts.iter().map(|part| (part.of)(&row.error)));
        let y = around(errors().chain(of_parts.filter(|part| *part >= least)), 1.3);
        let [top, height] = ERRORS;
        let frame = ChartFrame { left, top, width: COLUMN, height, x, y };
        // Bands lie below the grid.
        if let Some(target) = self.target {
            for stood in self.stood {
                let forecast = self.forecast(stood);
                let from = frame.spot(self.spent(stood.row), stood.row.error.estimated);
                let [low, high] = [forecast.low, forecast.high].map(|end| frame.spot(end, target));
                picture.area(vec![from, low, high], FAINT, 0.45);
            }
        }
        let as_percent = |fraction: f64| format!("{} %", tick(((100.0 * fraction) * 1e9).round() / 1e9));
        if self.stood.is_empty() {
            frame.draw(picture, [said(self.spending.name), say!("stated error")], [&self.spending.show, &as_percent]);
        } else {
            frame.draw_upper(picture, say!("stated error"), &as_percent);
        }
        if let Some(target) = self.target {
            for stood in self.stood {
                let from = frame.spot(self.spent(stood.row), stood.row.error.estimated);
                let to = frame.spot(self.forecast(stood).expected, target);
                picture.line(vec![from, to], Pen::new(SOFT, 1.0).dashed(2.0, 3.0));
            }
            let ends = [x.low, x.high].map(|x| frame.spot(x, target));
            picture.line(ends.to_vec(), Pen::new(VERMILION, 1.6).dashed(7.0, 4.0));
        }
        let rim = [y.low, y.high].map(|y| frame.spot(self.end(), y));
        picture.line(rim.to_vec(), Pen::new(VERMILION, 1.6));
        for part in parts {
            let judged = self.rows.iter().filter(|row| row.judged && (part.of)(&row.error) >= least);
            let spots = judged.map(|row| frame.spot(self.spent(row), (part.of)(&row.error))).collect();
            picture.line(spots, Pen::new(part.ink, 1.4));
        }
        let spot = |row: &ConvergenceRow| frame.spot(self.spent(row), row.error.estimated);
        let spots: Vec<PagePoint> = self.rows.iter().map(spot).collect();
        picture.line(spots, Pen::new(BLUE, 1.8));
        for row in self.rows {
            match row.judged {
                true => picture.disk(spot(row), 2.6, BLUE),
                false => picture.circle(spot(row), 3.0, Pen::new(BLUE, 1.2)),
            }
        }
    }

    /// Draws a bar for each forecast, from the low to the high end of its interval.
    fn draw_forecasts(&self, picture: &mut Picture, left: f64, x: Scale) {
        let [top, height] = FORECASTS;
        let lines = self.stood.len().max(1);
        let frame = ChartFrame { left, top, width: COLUMN, height, x, y: Scale::linear(lines as f64, 0.0) };
        frame.draw_lower(picture, said(self.spending.name), &self.spending.show);
        let ends = [0.0, lines as f64].map(|y| frame.spot(self.end(), y));
        picture.line(ends.to_vec(), Pen::new(VERMILION, 1.6));
        for (line, stood) in self.stood.iter().enumerate() {
            let (forecast, y) = (self.forecast(stood), line as f64 + 0.5);
            let [low, middle, high] =
                [forecast.low, forecast.expected, forecast.high].map(|number| frame.spot(number, y));
            picture.line(vec![low, high], Pen::new(SOFT, 1.4));
            for [x, y] in [low, high] {
                picture.line(vec![[x, y - 4.0], [x, y + 4.0]], Pen::new(SOFT, 1.4));
            }
            picture.area(diamond(middle), BLACK, 1.0);
            let label = [left - 7.0, middle[1] + 4.0];
            picture.words(Words::new(&stood.label, label, TYPE).anchored(TextAnchor::End));
        }
    }
}

fn diamond([x, y]: PagePoint) -> Vec<PagePoint> {
    const R: f64 = 4.2;
    vec![[x, y - R], [x + R, y], [x, y + R], [x - R, y]]
}

/// Width of text in DejaVu, which systems without Helvetica and Arial show, relative to the width in Helvetica.
const OTHER_FONT: f64 = 1.15;

/// Key entries side by side, each after its symbol.
struct KeyLine {
    at: PagePoint,
}

impl KeyLine {
    fn at_height(y: f64) -> KeyLine {
        KeyLine { at: [92.0, y] }
    }

    fn entry(&mut self, picture: &mut Picture, words: &str, draw: &dyn Fn(&mut Picture, PagePoint)) {
        let [x, y] = self.at;
        draw(picture, [x, y - 4.0]);
        picture.words(Words::new(words, [x + 30.0, y], TYPE));
        self.at[0] += 30.0 + OTHER_FONT * super::font::text_width(words, TYPE, false) + 18.0;
    }
}

fn line(pen: Pen) -> impl Fn(&mut Picture, PagePoint) {
    move |picture, [x, y]| picture.line(vec![[x, y], [x + 24.0, y]], pen)
}

fn draw_key(picture: &mut Picture, parts: &[&ErrorPart], has_target: bool, has_pilot: bool) {
    let mut key = KeyLine::at_height(70.0);
    key.entry(picture, say!("stated error"), &|picture, [x, y]| {
        line(Pen::new(BLUE, 1.8))(picture, [x, y]);
        picture.disk([x + 12.0, y], 2.6, BLUE);
    });
    if has_pilot {
        key.entry(picture, say!("expected by the pilot"), &|picture, [x, y]| {
            line(Pen::new(BLUE, 1.8))(picture, [x, y]);
            picture.circle([x + 12.0, y], 3.0, Pen::new(BLUE, 1.2));
        });
    }
    for part in parts {
        key.entry(picture, said(part.name), &line(Pen::new(part.ink, 1.4)));
    }
    if has_target {
        key.entry(picture, say!("target"), &line(Pen::new(VERMILION, 1.6).dashed(7.0, 4.0)));
    }
    key.entry(picture, say!("end of the run"), &|picture, [x, y]| {
        picture.line(vec![[x + 12.0, y - 7.0], [x + 12.0, y + 7.0]], Pen::new(VERMILION, 1.6));
    });
}

fn draw_key_of_forecasts(picture: &mut Picture, has_target: bool) {
    let mut key = KeyLine::at_height(HEIGHT - 18.0);
    key.entry(
        picture,
        say!("forecast of the whole run made at that time, with its 90 % interval"),
        &|picture, [x, y]| {
            line(Pen::new(SOFT, 1.4))(picture, [x, y]);
            picture.area(diamond([x + 12.0, y]), BLACK, 1.0);
        },
    );
    if has_target {
        key.entry(picture, say!("fit at that time"), &line(Pen::new(SOFT, 1.0).dashed(2.0, 3.0)));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(rays: u64, estimated: f64, forecast: f64) -> ConvergenceRow {
        ConvergenceRow {
            wall_s: rays as f64 * 1e-6,
            rays,
            chains: 0,
            error: ErrorParts::random(estimated),
            judged: true,
            forecast_rays: Forecast { expected: forecast, low: 0.9 * forecast, high: 1.1 * forecast },
            forecast_wall_s: Forecast::known(forecast * 1e-6),
        }
    }

    /// Forecasts are shown as they were at 2, 5, 20 and 50 % of the rays, by the last row before. If the first row is later, it is
    /// shown under its own share.
    #[test]
    fn forecasts_are_shown_as_they_stood() {
        let rows = [(10, 900.0), (40, 800.0), (190, 950.0), (450, 990.0), (1000, 1000.0)];
        let rows = rows.map(|(rays, forecast)| row(rays, 1.0 / rays as f64, forecast));
        let shown = |rows: &[ConvergenceRow]| -> Vec<(String, f64)> {
            let stood = as_they_stood(rows);
            stood.iter().map(|stood| (stood.label.clone(), stood.row.forecast_rays.expected)).collect()
        };
        let labelled = |shares: [&str; 4], forecasts: [f64; 4]| -> Vec<(String, f64)> {
            shares.into_iter().map(str::to_owned).zip(forecasts).collect()
        };
        let shares = ["at 2 %", "at 5 %", "at 20 %", "at 50 %"];
        assert_eq!(shown(&rows), labelled(shares, [900.0, 800.0, 950.0, 990.0]));
        assert_eq!(shown(&rows[2..])[0], ("at 19 %".to_owned(), 950.0));
        assert_eq!(shown(&rows[2..]).len(), 3);
        let just_before = rows.map(|each| row(each.rays + 10, 0.1, 2000.0));
        assert_eq!(
            shown(&just_before[1..]).iter().map(|(label, _)| label).collect::<Vec<_>>(),
            shares[1..].iter().collect::<Vec<_>>()
        );
        assert!(shown(&rows[4..]).is_empty());
        let mut resumed = rows;
        resumed[..2].iter_mut().for_each(|row| {
            (row.forecast_rays, row.forecast_wall_s) = (Forecast::known(row.rays as f64), Forecast::known(row.wall_s));
        });
        assert_eq!(shown(&resumed), shown(&rows[2..]));
    }

    /// If elements adapt, both errors are shown. An error with a single part is shown once.
    #[test]
    fn parts_of_the_error_are_shown_where_there_are_some() {
        let mut rows = [row(10, 0.1, 20.0)];
        assert!(shown_parts(&rows).is_empty());
        rows[0].error.discretisation = 0.05;
        let names: Vec<&str> = shown_parts(&rows).iter().map(|part| part.name).collect();
        assert_eq!(names, ["random", "discretisation"]);
    }
}
