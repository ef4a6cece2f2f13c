//! The files of a year: measures of sets and points, the hours, and the summary.

use std::fs::File;
use std::io::{BufReader, BufWriter, Read, Seek, SeekFrom, Write};

use serde_json::{Map, Value, json};

use super::daylight::COMPONENT_COLUMNS;
use super::sheet::{Sheet, SheetCell};
use super::streamed::unwritable;
use super::{OutputError, ResultFile, StreamedFile, file_name_part};
use crate::maps::{Estimate, certainty};
use crate::scene::{Scene, Weather};
use crate::year::{
    MEASURES, SetSunlight, SetYear, YearHour, YearHours, YearMeasure, YearSettings, YearSky, YearSolution, sum_of_hours,
};

/// Shares of the area with daylight autonomy that IES LM-83 requires: accepted, and preferred.
pub const AUTONOMY_WANTED: [f64; 2] = [0.55, 0.75];

/// Each of [`MEASURES`] with its error, without the components of the daylight factor at their end.
const MEASURE_COLUMNS: [&str; 2 * MEASURES.len() - COMPONENT_COLUMNS.len()] = [
    "daylight_autonomy",
    "daylight_autonomy_standard_error",
    "useful_below_100_lx",
    "useful_below_100_lx_standard_error",
    "useful_100_to_300_lx",
    "useful_100_to_300_lx_standard_error",
    "useful_300_to_3000_lx",
    "useful_300_to_3000_lx_standard_error",
    "useful_above_3000_lx",
    "useful_above_3000_lx_standard_error",
    "sunlit_hours",
    "sunlit_hours_standard_error",
    "light_exposure_lx_h",
    "light_exposure_standard_error_lx_h",
];
/// Columns before and after these, in the tables of sets and of points.
const SET_COLUMNS: [&[&str]; 2] = [
    &[
        "receiver",
        "points",
        "spatial_daylight_autonomy",
        "spatial_daylight_autonomy_standard_error",
        "certainty_of_55_percent",
        "certainty_of_75_percent",
        "annual_sunlight_exposure",
        "annual_sunlight_exposure_standard_error",
    ],
    &["hours_with_closed_blinds", "hourly_error", "worst_hourly_error"],
];
const POINT_COLUMNS: [&[&str]; 2] =
    [&["receiver", "point", "x_m", "y_m", "z_m", "inside_solid"], &["hourly_error", "walks"]];

const HOUR_COLUMNS: &[&str] = &[
    "receiver",
    "month",
    "day",
    "hour",
    "occupied",
    "sun_elevation_deg",
    "sun_azimuth_deg",
    "outside_sky_lx",
    "outside_sun_lx",
    "average_lx",
    "average_standard_error_lx",
    "share_300_to_3000_lx",
    "blinds_closed",
];

fn with_measures([before, after]: [&[&'static str]; 2]) -> Vec<&'static str> {
    [before, &MEASURE_COLUMNS, &COMPONENT_COLUMNS, after].concat()
}

fn pairs<'a>(estimates: &[Estimate]) -> Vec<SheetCell<'a>> {
    estimates.iter().flat_map(|estimate| [estimate.value, estimate.standard_error].map(SheetCell::Number)).collect()
}

/// Makes `year.csv`, `year-points.csv` and `year-hours.csv`.
///
/// # Errors
///
/// A number that is not finite; no table may hold one.
pub fn year_tables(solution: &YearSolution) -> Result<Vec<ResultFile>, OutputError> {
    let mut sets = Sheet::new("year.csv", &with_measures(SET_COLUMNS));
    let mut points = Sheet::new("year-points.csv", &with_measures(POINT_COLUMNS));
    let mut hours = Sheet::new("year-hours.csv", HOUR_COLUMNS);
    for set in &solution.sets {
        let mut fields = vec![SheetCell::Text(&set.name), SheetCell::Count(set.points.len() as u64)];
        fields.extend(pairs(&[set.autonomy]));
        fields.extend(AUTONOMY_WANTED.map(|share| SheetCell::Number(certainty(set.autonomy, share))));
        fields.extend(pairs(&[set.sunlit]));
        fields.extend(pairs(&set.averages));
        fields.push(SheetCell::Count(set.closed.iter().filter(|closed| **closed).count() as u64));
        fields.extend([set.error, set.worst_error].map(SheetCell::Number));
        sets.row(&fields)?;
        for (number, (point, year)) in solution.scene.receivers[set.set].points.iter().zip(&set.points).enumerate() {
            let mut fields = vec![SheetCell::Text(&set.name), SheetCell::Count(number as u64 + 1)];
            fields.extend(point.position_m.to_array().map(SheetCell::Number));
            fields.push(SheetCell::Flag(point.inside));
            fields.extend(pairs(&year.measures));
            fields.extend([SheetCell::Number(year.error), SheetCell::Count(year.walks)]);
            points.row(&fields)?;
        }
        for (number, hour) in solution.sky.hours.iter().enumerate() {
            hours.row(&hour_row(set, number, hour))?;
        }
    }
    Ok(vec![sets.finish(), points.finish(), hours.finish()])
}

fn hour_row<'a>(set: &'a SetYear, number: usize, hour: &YearHour) -> Vec<SheetCell<'a>> {
    let sun = hour.towards_sun;
    let azimuth_deg = sun.x.atan2(sun.y).to_degrees().rem_euclid(360.0);
    vec![
        SheetCell::Text(&set.name),
        SheetCell::Count(u64::from(hour.month)),
        SheetCell::Count(u64::from(hour.day)),
        SheetCell::Number(hour.middle_hours),
        SheetCell::Flag(hour.is_occupied),
        SheetCell::Number(sun.z.asin().to_degrees()),
        SheetCell::Number(azimuth_deg),
        SheetCell::Number(hour.outside_lx[0]),
        SheetCell::Number(hour.outside_lx[1]),
        SheetCell::Number(set.hourly_lx[number]),
        SheetCell::Number(set.hourly_standard_error_lx[number]),
        SheetCell::Number(set.hourly_useful[number]),
        SheetCell::Flag(set.closed.get(number).is_some_and(|closed| *closed)),
    ]
}

/// Makes `summary.json` of a year, with the names of the other files.
pub fn year_summary(
    path: &str,
    weather: (&str, &Weather),
    settings: &YearSettings,
    solution: &YearSolution,
    wall_s: f64,
    files: &[String],
) -> ResultFile {
    let scene = &solution.scene;
    let estimate = |estimate: Estimate| json!({ "value": estimate.value, "standard_error": estimate.standard_error });
    let set = |set: &SetYear| {
        let names = MEASURE_COLUMNS.iter().chain(&COMPONENT_COLUMNS).step_by(2).map(|name| (*name).to_owned());
        let means: Map<String, Value> = names.zip(set.averages.map(estimate)).collect();
        let mut entry = json!({
            "receiver": set.name,
            "points": set.points.len(),
            "spatial_daylight_autonomy": estimate(set.autonomy),
            "annual_sunlight_exposure": estimate(set.sunlit),
            "hours_with_closed_blinds": set.closed.iter().filter(|closed| **closed).count(),
            "hourly_error": set.error,
            "worst_hourly_error": set.worst_error,
        });
        if let Some(entries) = entry.as_object_mut() {
            entries.extend(means);
        }
        entry
    };
    let summary = json!({
        "luxmc": env!("CARGO_PKG_VERSION"),
        "command": "year",
        "scene": path,
        "title": scene.title,
        "weather": {
            "file": weather.0,
            "place": weather.1.place,
            "latitude_deg": weather.1.latitude_deg,
            "longitude_deg": weather.1.longitude_deg,
            "time_zone_hours": weather.1.time_zone_hours,
            "hours": weather.1.hours.len(),
        },
        "subdivision": settings.subdivision,
        "sky_patches": solution.sky.patches.count(),
        "patch_error": solution.patch_error,
        "suns": solution.sky.suns.towards.len(),
        "hours_with_light": solution.sky.hours.len(),
        "occupied_hours": solution.sky.occupied,
        "occupied_from_to_hours": settings.occupied_hours,
        "blinds_transmittance": settings.blinds.map(|blinds| blinds.transmittance),
        "seed": settings.seed,
        "target_error": solution.target_error,
        "target_met": solution.target_met(),
        "rays": solution.rays,
        "walks_given_up": solution.walks_given_up,
        "wall_s": wall_s,
        "left_out": solution.left_out,
        "sets": solution.sets.iter().map(set).collect::<Vec<_>>(),
        "warnings": scene.warnings.iter().chain(&solution.warnings).collect::<Vec<_>>(),
        "files": files,
    });
    let mut bytes = serde_json::to_vec_pretty(&summary).unwrap_or_default();
    bytes.push(b'\n');
    ResultFile { name: "summary.json".to_owned(), bytes }
}

/// Writes the hours of all points to files: one row for each point, one column for each hour with light.
pub struct HourlyFiles {
    /// Name, illuminances and standard errors of each set.
    sets: Vec<(String, [BufWriter<File>; 2])>,
}

/// Beginnings of the names of a set's two files.
const HOURLY: [&str; 2] = ["hourly-", "hourly-error-"];

impl HourlyFiles {
    /// Files without any set.
    pub const NONE: HourlyFiles = HourlyFiles { sets: Vec::new() };

    /// Adds the hours of a point.
    ///
    /// # Errors
    ///
    /// An error of the disk.
    pub fn add(&mut self, sky: &YearSky, hours: &YearHours) -> Result<(), OutputError> {
        let receivers = hours.receivers;
        let refused = |error: &std::io::Error| unwritable("hourly illuminances", error);
        if self.sets.last().is_none_or(|(name, _)| *name != receivers.name) {
            let mut begun = Vec::with_capacity(2);
            for _ in HOURLY {
                let file = tempfile::tempfile().map_err(|error| refused(&error))?;
                let mut writer = BufWriter::new(file);
                write_header(&mut writer, sky).map_err(|error| refused(&error))?;
                begun.push(writer);
            }
            let both = begun.try_into().unwrap_or_else(|_| unreachable!("two files were begun"));
            self.sets.push((receivers.name.clone(), both));
        }
        let Some((_, writers)) = self.sets.last_mut() else { return Ok(()) };
        let place_m = receivers.points[hours.point].position_m;
        for (writer, values) in writers.iter_mut().zip([hours.lx, hours.standard_error_lx]) {
            write_row(writer, hours.point, place_m.to_array(), values).map_err(|error| refused(&error))?;
        }
        Ok(())
    }

    /// Returns the complete files.
    ///
    /// # Errors
    ///
    /// An error of the disk.
    pub fn finish(self) -> Result<Vec<StreamedFile<'static>>, OutputError> {
        let refused = |error: std::io::Error| unwritable("hourly illuminances", &error);
        let mut files = Vec::new();
        for (name, writers) in self.sets {
            for (writer, prefix) in writers.into_iter().zip(HOURLY) {
                let file = writer.into_inner().map_err(|error| refused(error.into_error()))?;
                let name = format!("{prefix}{}.csv", file_name_part(&name));
                let path_name = name.clone();
                files.push(StreamedFile::new(name, move |out| {
                    copy(&file, out).map_err(|error| unwritable(&path_name, &error))
                }));
            }
        }
        Ok(files)
    }
}

fn copy(mut file: &File, out: &mut dyn Write) -> std::io::Result<()> {
    file.seek(SeekFrom::Start(0))?;
    let mut reader = BufReader::new(file);
    let mut block = vec![0; 1 << 20];
    loop {
        let count = reader.read(&mut block)?;
        if count == 0 {
            return Ok(());
        }
        out.write_all(&block[..count])?;
    }
}

fn write_header(writer: &mut impl Write, sky: &YearSky) -> std::io::Result<()> {
    write!(writer, "point,x_m,y_m,z_m")?;
    for hour in &sky.hours {
        let minutes = (60.0 * hour.middle_hours).round() as u32;
        write!(writer, ",{:02}-{:02} {:02}:{:02}", hour.month, hour.day, minutes / 60, minutes % 60)?;
    }
    writeln!(writer)
}

/// Values have one decimal: 0.1 lx is less than any target error of a year.
fn write_row(writer: &mut impl Write, point: usize, [x, y, z]: [f64; 3], values: &[f64]) -> std::io::Result<()> {
    write!(writer, "{},{x},{y},{z}", point + 1)?;
    for lx in values {
        write!(writer, ",{lx:.1}")?;
    }
    writeln!(writer)
}

/// The rows of the terminal's table: sDA, ASE, autonomy, useful share, and exposure in klx h.
pub fn year_rows(solution: &YearSolution) -> Vec<[Estimate; 5]> {
    let row = |set: &SetYear| {
        let measure = |measure: YearMeasure| set.averages[MEASURES.iter().position(|one| *one == measure).unwrap_or(0)];
        let exposure = measure(YearMeasure::Exposure);
        let in_klx = Estimate { value: 1e-3 * exposure.value, standard_error: 1e-3 * exposure.standard_error };
        [set.autonomy, set.sunlit, measure(YearMeasure::Autonomy), measure(YearMeasure::Useful), in_klx]
    };
    solution.sets.iter().map(row).collect()
}

const SUNLIGHT_COLUMNS: &[&str] =
    &["receiver", "point", "x_m", "y_m", "z_m", "month", "day", "sunlight_hours", "from_hour", "to_hour", "parts"];

/// Makes `sunlight.csv`: how long each point sees the sun on each day, from when to when, and in how many parts.
///
/// # Errors
///
/// A number that is not finite; no table may hold one.
pub fn sunlight_file(scene: &Scene, days: &[(u32, u32)], found: &[SetSunlight]) -> Result<ResultFile, OutputError> {
    let mut sheet = Sheet::new("sunlight.csv", SUNLIGHT_COLUMNS);
    for set in found {
        let receivers = &scene.receivers[set.set];
        for (number, (point, of_days)) in receivers.points.iter().zip(&set.points).enumerate() {
            for ((month, day), sunlit) in days.iter().zip(of_days) {
                let ends = [sunlit.first().map_or(0.0, |part| part[0]), sunlit.last().map_or(0.0, |part| part[1])];
                let mut fields = vec![SheetCell::Text(&receivers.name), SheetCell::Count(number as u64 + 1)];
                fields.extend(point.position_m.to_array().map(SheetCell::Number));
                fields.extend([SheetCell::Count(u64::from(*month)), SheetCell::Count(u64::from(*day))]);
                fields.push(SheetCell::Number(sum_of_hours(sunlit)));
                fields.extend(ends.map(SheetCell::Number));
                fields.push(SheetCell::Count(sunlit.len() as u64));
                sheet.row(&fields)?;
            }
        }
    }
    Ok(sheet.finish())
}
