//! Plots of a year: maps over day and hour, and maps of daylight autonomy and useful daylight on grids.

use std::collections::BTreeMap;

use super::axes::{ChartFrame, Scale, TYPE};
use super::color::{BLACK, Ink, SOFT, perceptual};
use super::daylight_plot::{PercentWords, percent_picture, sky_component_picture};
use super::flat::{FlatMap, grid_map};
use super::map_words::{GAP, ROOM, plus_minus};
use super::numbers::{percents_with_error, tick};
use super::picture::{PagePoint, Pen, Picture, TextAnchor, Words};
use super::raster::png;
use super::texts::say;
use super::{ResultFile, file_name_part};
use crate::maps::{Estimate, MapError, MapKind, MapResult, MapValues, TableKind, TableRow};
use crate::scene::{Quantity, Scene, Weather};
use crate::year::{MEASURES, SetYear, YearMeasure, YearPoint, YearSolution};

/// Space for the legend at the right.
const LEGEND: f64 = 104.0;
/// Number of colours of a scale.
const SHADES: usize = 64;
/// Range of the colours of the map over the year in lx, and round values at the legend.
const RANGE_LX: [f64; 2] = [30.0, 10_000.0];
const TICKS_LX: [f64; 6] = [30.0, 100.0, 300.0, 1000.0, 3000.0, 10_000.0];
/// Days before each month of a common year.
const BEFORE_MONTHS: [u32; 12] = [0, 31, 59, 90, 120, 151, 181, 212, 243, 273, 304, 334];
/// Levels of lines, in %.
const LEVELS_PERCENT: [f64; 3] = [25.0, 50.0, 75.0];

/// The plots of a year, as SVG, and also as PNG if `also_png`.
pub fn year_plots(weather: &Weather, solution: &YearSolution, also_png: bool) -> Vec<ResultFile> {
    let mut files = Vec::new();
    let mut add = |stem: String, picture: Picture| {
        files.push(ResultFile { name: format!("{stem}.svg"), bytes: picture.svg().into_bytes() });
        if also_png {
            files.push(ResultFile { name: format!("{stem}.png"), bytes: png(&picture) });
        }
    };
    for set in &solution.sets {
        let name = file_name_part(&set.name);
        add(format!("year-{name}"), temporal_picture(set, weather, solution));
        let measures = [
            (YearMeasure::Autonomy, "autonomy"),
            (YearMeasure::Useful, "useful"),
            (YearMeasure::SkyComponent, "sky-component"),
        ];
        for (measure, stem) in measures {
            if let Some(picture) = measure_picture(&solution.scene, (set, solution.sky.occupied), measure) {
                add(format!("year-{name}-{stem}"), picture);
            }
        }
    }
    files
}

/// Draws mean illuminance, and the share of the area with useful daylight, over the days and hours of the year.
fn temporal_picture(set: &SetYear, weather: &Weather, solution: &YearSolution) -> Picture {
    let title = say!("Daylight over the year: {}", set.name);
    let mut picture = Picture::new(900.0, 660.0, title.clone());
    picture.words(Words::new(title, [ROOM.left, 24.0], 17.0).bold());
    let place = if weather.place.is_empty() { "–" } else { &weather.place };
    let site = format!("{place}, {}°, {}°", tick(weather.latitude_deg), tick(weather.longitude_deg));
    let hours = say!("{} hours with light; standard time", solution.sky.hours.len());
    picture.words(Words::new(format!("{site}; {hours}"), [ROOM.left, 43.0], TYPE).ink(SOFT));
    let logarithmic = Scale::logarithmic(RANGE_LX[0], RANGE_LX[1]);
    let mean = say!("Mean illuminance / lx");
    let panel = |top: f64| ChartFrame {
        left: ROOM.left,
        top,
        width: 900.0 - ROOM.left - LEGEND,
        height: 230.0,
        x: Scale::linear(0.0, 365.0),
        y: Scale::linear(0.0, 24.0),
    };
    draw_panel(&mut picture, &panel(82.0), (mean, &TICKS_LX), logarithmic, solution, &set.hourly_lx);
    let share = say!("Share of the area with 300 to 3000 lx / %");
    let percents: Vec<f64> = set.hourly_useful.iter().map(|share| 100.0 * share).collect();
    let scale = Scale::linear(0.0, 100.0);
    draw_panel(&mut picture, &panel(376.0), (share, &[0.0, 25.0, 50.0, 75.0, 100.0]), scale, solution, &percents);
    picture
}

fn draw_panel(
    picture: &mut Picture,
    frame: &ChartFrame,
    (title, ticks): (&str, &[f64]),
    scale: Scale,
    solution: &YearSolution,
    values: &[f64],
) {
    let ink = |share: f64| perceptual((share.clamp(0.0, 1.0) * (SHADES - 1) as f64).round() / (SHADES - 1) as f64);
    let mut by_ink: BTreeMap<Ink, Vec<Vec<PagePoint>>> = BTreeMap::new();
    for (hour, value) in solution.sky.hours.iter().zip(values) {
        let day = f64::from((BEFORE_MONTHS[hour.month as usize - 1] + hour.day - 1).min(364));
        let middle = hour.middle_hours;
        let corners = [[0.0, -0.5], [1.0, -0.5], [1.0, 0.5], [0.0, 0.5]];
        let ring = corners.map(|[x, y]| frame.spot(day + x, (middle + y).clamp(0.0, 24.0))).to_vec();
        by_ink.entry(ink(scale.share(*value))).or_default().push(ring);
    }
    for (ink, rings) in by_ink {
        picture.cells(rings, ink);
    }
    let (bottom, right) = (frame.top + frame.height, frame.left + frame.width);
    for (month, before) in BEFORE_MONTHS.iter().enumerate() {
        let [x, _] = frame.spot(f64::from(*before), 0.0);
        picture.line(vec![[x, bottom], [x, bottom + 4.0]], Pen::new(BLACK, 0.8));
        let [middle, _] = frame.spot(f64::from(*before) + 15.0, 0.0);
        let words = Words::new(format!("{}", month + 1), [middle, bottom + 16.0], TYPE);
        picture.words(words.anchored(TextAnchor::Middle));
    }
    for hour in (0..=24).step_by(6) {
        let [_, y] = frame.spot(0.0, f64::from(hour));
        picture.line(vec![[frame.left - 4.0, y], [frame.left, y]], Pen::new(BLACK, 0.8));
        picture.words(Words::new(format!("{hour}"), [frame.left - 7.0, y + 4.0], TYPE).anchored(TextAnchor::End));
    }
    let [left, top] = [frame.left, frame.top];
    picture.ring(vec![[left, top], [right, top], [right, bottom], [left, bottom]], Pen::new(BLACK, 1.0));
    picture.words(Words::new(title, [left, top - 8.0], 13.0));
    let below = Words::new(say!("month"), [0.5 * (left + right), bottom + 34.0], TYPE);
    picture.words(below.anchored(TextAnchor::Middle).ink(SOFT));
    let beside = Words::new(say!("hour"), [left - 36.0, top + 0.5 * frame.height], TYPE);
    picture.words(beside.anchored(TextAnchor::Middle).ink(SOFT).turned(-90.0));
    let (from, width) = (right + 22.0, 16.0);
    let at = |share: f64| bottom - share * frame.height;
    for shade in 0..SHADES {
        let [low, high] = [shade, shade + 1].map(|step| at(step as f64 / SHADES as f64));
        let ring = vec![[from, high], [from + width, high], [from + width, low], [from, low]];
        picture.cells(vec![ring], ink(shade as f64 / (SHADES - 1) as f64));
    }
    for number in ticks {
        let y = at(scale.share(*number));
        picture.line(vec![[from + width, y], [from + width + 4.0, y]], Pen::new(BLACK, 0.8));
        picture.words(Words::new(tick(*number), [from + width + 8.0, y + 4.0], TYPE));
    }
    picture.ring(vec![[from, top], [from + width, top], [from + width, bottom], [from, bottom]], Pen::new(BLACK, 0.8));
}

/// Draws a measure at the points of a grid in false colours; `None` for points that form no grid.
fn measure_picture(scene: &Scene, (set, occupied): (&SetYear, usize), measure: YearMeasure) -> Option<Picture> {
    let place = MEASURES.iter().position(|one| *one == measure)?;
    let times = if measure == YearMeasure::SkyComponent { 1.0 } else { 100.0 };
    let map = map_of(set, place, times);
    let flat: FlatMap = grid_map(scene, &map)?;
    let mean = set.averages[place];
    if measure == YearMeasure::SkyComponent {
        return Some(sky_component_picture(&flat, &[(say!("mean"), mean)], ""));
    }
    let text_of = |estimate: Estimate| {
        let estimate = Estimate { value: times * estimate.value, standard_error: times * estimate.standard_error };
        format!("{} %", percents_with_error(estimate, plus_minus))
    };
    let mean = format!("{} = {}", say!("mean"), text_of(mean));
    let (title, numbers) = match measure {
        YearMeasure::Autonomy => (
            say!("Daylight autonomy, 300 lx"),
            format!("sDA = {}{GAP}ASE = {}{GAP}{mean}", text_of(set.autonomy), text_of(set.sunlit)),
        ),
        _ => (say!("Useful daylight, 300 to 3000 lx"), mean),
    };
    let remark = say!("; share of {} occupied hours", occupied);
    let words = PercentWords { title, remark: &remark, numbers, levels: &LEVELS_PERCENT, note: "" };
    Some(percent_picture(&flat, &words))
}

/// A measure of a set's points as a map for drawing. All its numbers are in %.
fn map_of(set: &SetYear, place: usize, times: f64) -> MapResult {
    let of = |point: &YearPoint| point.measures[place];
    let percents = set.points.iter().map(|point| times * of(point).value).collect();
    let errors = set.points.iter().map(|point| times * of(point).standard_error).collect();
    let average = set.averages[place];
    let error = set.points.iter().map(|point| of(point).standard_error).sum::<f64>() / set.points.len().max(1) as f64;
    let relative = if average.value > 0.0 { error / average.value } else { 0.0 };
    let row = TableRow {
        name: set.name.clone(),
        kind: TableKind::Grid,
        side: "front",
        average,
        minimum: Estimate::default(),
        maximum: Estimate::default(),
        uniformity_u0: Estimate::default(),
        uniformity_ud: Estimate::default(),
        pulled: [0.0; 2],
        places: 0,
        area_m2: 0.0,
        covered_area_m2: 0.0,
        estimated_error: relative,
        replica_averages: Vec::new(),
    };
    MapResult {
        name: set.name.clone(),
        kind: MapKind::Receivers(set.set),
        quantity: Quantity::Perpendicular,
        method: String::new(),
        method_reason: String::new(),
        chains: 0,
        values: MapValues { value: percents, standard_error: errors, ..MapValues::default() },
        error: MapError { estimated: relative, ..MapError::default() },
        bound: false,
        target_met: None,
        refusals: 0,
        checks: Vec::new(),
        tables: vec![row],
    }
}
