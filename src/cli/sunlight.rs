//! `luxmc sunlight`: how long receivers see the sun, day by day.

use std::path::PathBuf;

use clap::Args;

use super::exit::Exit;
use super::run::thread_pool;
use super::text_table::text_table;
use super::{Outcome, console, values};
use crate::base::solar_position::DAYS_OF_MONTHS;
use crate::check::read_scene;
use crate::output::{sunlight_file, write_files};
use crate::scene::Scene;
use crate::year::{EXPOSURE_HOURS, SetSunlight, SunSite, sum_of_hours, sunlight};

/// Long help text of the command.
pub const ABOUT: &str = "\
Exposure to sunlight after EN 17037: for how many hours of a day the centre of the sun is visible from each receiver, in front of its
plane, through panes and past all geometry. The standard requires 1.5, 3 or 4 hours on a day between 1 February and 21
March, at the middle of an opening's inner side. Times are accurate to a second where the sun is visible or hidden for a minute
or longer. +y is north.

Standard output shows the day with most hours of each receiver set; --out writes all points and days to sunlight.csv.";

const EXAMPLES: &str = "\
Examples:
  luxmc sunlight office.json --latitude 52 --longitude 13 --time-zone 1
  luxmc sunlight office.json --latitude 52 --longitude 13 --time-zone 1 --days 03-21 --least-elevation 11 --out out/sun";

/// Arguments of `luxmc sunlight`.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct SunlightArguments {
    /// Scene file
    #[arg(value_name = "SCENE")]
    scene: PathBuf,
    /// Latitude in degrees, south below 0
    #[arg(long, value_name = "DEG", value_parser = clap::value_parser!(f64), allow_negative_numbers = true)]
    latitude: f64,
    /// Longitude in degrees, west of Greenwich below 0
    #[arg(long, value_name = "DEG", allow_negative_numbers = true)]
    longitude: f64,
    /// Hours by which the times are ahead of universal time
    #[arg(long, value_name = "HOURS", default_value_t = 0.0, allow_negative_numbers = true)]
    time_zone: f64,
    /// Day or range of days, as MM-DD or MM-DD:MM-DD
    #[arg(long, value_name = "DAYS", default_value = "02-01:03-21", value_parser = days)]
    days: Days,
    /// Lowest elevation of the sun in degrees at which it counts; national annexes give a value
    #[arg(long, value_name = "DEG", default_value_t = 0.0)]
    least_elevation: f64,
    /// Write sunlight.csv into this directory
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Worker threads; results do not depend on them [default: all processors]
    #[arg(long, value_name = "T", value_parser = values::threads, allow_hyphen_values = true)]
    threads: Option<usize>,
}

/// Days of a year as pairs of month and day.
#[derive(Clone, Debug, PartialEq)]
struct Days(Vec<(u32, u32)>);

fn days(text: &str) -> Result<Days, String> {
    const REMEDY: &str = "write a day as 03-21, or from and to as 02-01:03-21";
    let day = |text: &str| -> Option<(u32, u32)> {
        let (month, day) = text.trim().split_once('-')?;
        let (month, day): (u32, u32) = (month.parse().ok()?, day.parse().ok()?);
        let length = *DAYS_OF_MONTHS.get((month as usize).checked_sub(1)?)?;
        (1..=length).contains(&day).then_some((month, day))
    };
    let (from, to) = text.split_once(':').unwrap_or((text, text));
    let (Some(from), Some(to)) = (day(from), day(to)) else { return Err(REMEDY.to_owned()) };
    let all = (1..=12u32).flat_map(|month| (1..=DAYS_OF_MONTHS[month as usize - 1]).map(move |day| (month, day)));
    let found: Vec<(u32, u32)> = all.filter(|day| (from..=to).contains(day)).collect();
    if found.is_empty() { Err(REMEDY.to_owned()) } else { Ok(Days(found)) }
}

/// Finds the hours of sun, prints a table with each set's days, and writes all of them.
pub fn run(arguments: &SunlightArguments) -> Outcome {
    let scene = read_scene(&arguments.scene)?;
    let site = SunSite {
        latitude_deg: arguments.latitude,
        longitude_deg: arguments.longitude,
        time_zone_hours: arguments.time_zone,
        least_elevation_deg: arguments.least_elevation,
    };
    for (what, number, limit) in [
        ("latitude", site.latitude_deg, 90.0),
        ("longitude", site.longitude_deg, 180.0),
        ("time zone", site.time_zone_hours, 14.0),
    ] {
        if !(-limit..=limit).contains(&number) {
            return Err(super::Failure::Usage {
                what: format!("the {what} is out of range"),
                got: number.to_string(),
                expected: format!("-{limit} to {limit}"),
                remedy: "check the number".to_owned(),
            });
        }
    }
    let Days(days) = &arguments.days;
    let found = thread_pool(arguments.threads)?.install(|| sunlight(&scene, &site, days));
    if let Some(out) = &arguments.out {
        write_files(out, &[sunlight_file(&scene, days, &found)?])?;
    }
    console::result(&table(&scene, days, &found))?;
    Ok(Exit::Done)
}

fn table(scene: &Scene, days: &[(u32, u32)], found: &[SetSunlight]) -> String {
    let rows = found.iter().map(|set| {
        let receivers = &scene.receivers[set.set];
        let counted =
            || receivers.points.iter().zip(&set.points).filter(|(point, _)| !point.inside).map(|(_, days)| days);
        let most = |day: usize| counted().map(|days| sum_of_hours(&days[day])).fold(0.0, f64::max);
        let least = |day: usize| counted().map(|days| sum_of_hours(&days[day])).fold(f64::INFINITY, f64::min);
        let best = (0..days.len()).max_by(|one, other| most(*one).total_cmp(&most(*other)).then(other.cmp(one)));
        let best = best.unwrap_or(0);
        let points = counted().count().max(1) as f64;
        let share = |hours: f64| {
            let enough = |days: &&Vec<_>| days.iter().any(|sunlit| sum_of_hours(sunlit) >= hours);
            format!("{:.0} %", 100.0 * counted().filter(enough).count() as f64 / points)
        };
        let mut cells = vec![receivers.name.clone(), receivers.points.len().to_string()];
        cells.push(format!("{:02}-{:02}", days[best].0, days[best].1));
        cells.extend(
            [most(best), least(best)].map(|hours| if hours.is_finite() { format!("{hours:.2}") } else { "-".into() }),
        );
        cells.extend(EXPOSURE_HOURS.map(share));
        cells
    });
    let header = ["receivers", "points", "best day", "most/h", "least/h", "1.5 h on a day", "3 h", "4 h"];
    text_table(&header, &[0], rows)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn days_are_read_one_or_from_and_to() {
        assert_eq!(days("03-21"), Ok(Days(vec![(3, 21)])));
        let many = days("02-01:03-21").expect("days").0;
        assert_eq!((many.len(), many[0], many[48]), (49, (2, 1), (3, 21)));
        for wrong in ["", "3", "02-29", "13-01", "03-21:02-01", "00-01", "é-é"] {
            assert!(days(wrong).is_err(), "{wrong}");
        }
    }
}
