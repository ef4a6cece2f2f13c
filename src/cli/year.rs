//! `luxmc year`: hourly illuminances of a year, and the measures that standards derive from them.

use std::path::PathBuf;
use std::time::Instant;

use clap::Args;

use super::exit::{Exit, Failure};
use super::number_text::{count, percent, significant, time};
use super::run::thread_pool;
use super::text_table::text_table;
use super::{Outcome, console, values};
use crate::check::read_scene;
use crate::maps::Estimate;
use crate::output::numbers::percents_with_error;
use crate::output::{
    HourlyFiles, Language, ResultDirectory, in_language, year_plots, year_rows, year_summary, year_tables,
};
use crate::scene::read_weather;
use crate::year::{Blinds, YearSettings, YearSolution, solve_year};

/// Long help text of the command.
pub const ABOUT: &str = "\
A year of daylight. The scene's sky takes its light from the weather hour by hour: Perez's all-weather sky in patches of
Reinhart's, the ground below it, and the sun at its position in each hour. The light that each patch and each hour's sun
brings to a receiver is gathered once and used for all hours, which therefore share its errors.

For each receiver set on planes: spatial daylight autonomy (300 lx in half of the occupied hours) and annual sunlight
exposure (1000 lx of the sun alone in more than 250 occupied hours) after IES LM-83, useful daylight illuminance (below
100, to 300, to 3000, above 3000 lx), light exposure, each with its standard error. year.csv has the sets, year-points.csv
the points, year-hours.csv the hours; plots show them over the year and on grids.

Weather: an EPW file, or CSV (docs/formats.md). Electric light is left out.";

const EXAMPLES: &str = "\
Examples:
  luxmc year scenes/daylight-office.json --weather city.epw --out out/year
  luxmc year office.json --weather city.epw --out out/year --blinds 20% --hourly
  luxmc year office.json --weather city.epw --out out/year --occupied 7-19 --sky-subdivision 4 --target-error 2%";

/// Largest subdivision of patches.
const MOST_SUBDIVISION: u32 = 4;

/// Arguments of `luxmc year`.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct YearArguments {
    /// Scene file with a luminaire of type "sky"
    #[arg(value_name = "SCENE")]
    scene: PathBuf,
    /// Weather of the year: EPW, or CSV
    #[arg(long, value_name = "FILE")]
    weather: PathBuf,
    /// Directory for the results
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Target for the relative standard error of each point's hourly illuminances: root mean square over occupied hours (in hours darker
    /// than a hundredth of the mean, relative to that hundredth)
    #[arg(long, value_name = "ERROR", default_value = "3%", value_parser = values::target_error)]
    target_error: f64,
    /// Occupied hours of every day, in standard time
    #[arg(long, value_name = "FROM-TO", default_value = "8-18", value_parser = occupied)]
    occupied: Occupied,
    /// Number of parts into which each side of the 145 patches of the sky is divided: 145, 577, 1297 or 2305 patches
    #[arg(long, value_name = "N", default_value_t = 2, value_parser = clap::value_parser!(u32).range(1..=i64::from(MOST_SUBDIVISION)))]
    sky_subdivision: u32,
    /// Blinds close while the sun alone brings 1000 lx to more than 2 % of a set's points; closed blinds let through this share of all
    /// other light
    #[arg(long, value_name = "SHARE", value_parser = values::part)]
    blinds: Option<f64>,
    /// Write the illuminances of all hours at all points, and their standard errors
    #[arg(long)]
    hourly: bool,
    /// Write plots as PNG too
    #[arg(long)]
    png: bool,
    /// Language of plots: en or de
    #[arg(long, value_name = "LANGUAGE", default_value = "en", value_parser = Language::of_code)]
    language: Language,
    /// Seed of all random numbers
    #[arg(long, value_name = "SEED", default_value_t = 0, value_parser = values::seed, allow_hyphen_values = true)]
    seed: u64,
    /// Worker threads; results do not depend on them [default: all processors]
    #[arg(long, value_name = "T", value_parser = values::threads, allow_hyphen_values = true)]
    threads: Option<usize>,
    /// Show only warnings and results
    #[arg(long, short)]
    quiet: bool,
}

/// Occupied hours of a day: from, to.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Occupied([f64; 2]);

fn occupied(text: &str) -> Result<Occupied, String> {
    const REMEDY: &str = "write from and to in hours of the day, such as 8-18";
    let (from, to) = text.split_once('-').ok_or(REMEDY)?;
    let hour = |text: &str| text.trim().parse::<f64>().ok().filter(|hour| (0.0..=24.0).contains(hour));
    match (hour(from), hour(to)) {
        (Some(from), Some(to)) if from < to => Ok(Occupied([from, to])),
        _ => Err(REMEDY.to_owned()),
    }
}

/// Solves the year and writes its files.
pub fn run(arguments: &YearArguments, started: Instant) -> Outcome {
    let weather = read_weather(&arguments.weather)?;
    let scene = read_scene(&arguments.scene)?;
    let mut directory = ResultDirectory::open(&arguments.out)?;
    for warning in &scene.warnings {
        console::message(&format!("warning: {warning}"));
    }
    let settings = YearSettings {
        subdivision: arguments.sky_subdivision,
        occupied_hours: arguments.occupied.0,
        target_error: arguments.target_error,
        seed: arguments.seed,
        blinds: arguments.blinds.map(|transmittance| Blinds { transmittance }),
    };
    let mut hourly = HourlyFiles::NONE;
    let pool = thread_pool(arguments.threads)?;
    let solved = pool.install(|| {
        solve_year(scene, &weather, &settings, |sky, hours| match arguments.hourly {
            true => hourly.add(sky, hours).map_err(Failure::from),
            false => Ok(()),
        })
    });
    let solution = match solved {
        Ok(solution) => solution,
        Err(failure) => {
            directory.withdraw();
            return Err(failure);
        }
    };
    for file in year_tables(&solution)? {
        directory.stage(&file)?;
    }
    for file in hourly.finish()? {
        directory.stage_streamed(&file)?;
    }
    for file in in_language(arguments.language, || year_plots(&weather, &solution, arguments.png)) {
        directory.stage(&file)?;
    }
    let names = directory.names();
    let paths = [&arguments.scene, &arguments.weather].map(|path| path.display().to_string());
    let wall_s = started.elapsed().as_secs_f64();
    let summary = year_summary(&paths[0], (&paths[1], &weather), &settings, &solution, wall_s, &names);
    directory.stage(&summary)?;
    directory.commit()?;
    for warning in &solution.warnings {
        console::message(&format!("warning: {warning}"));
    }
    if let [_, ..] = solution.left_out.as_slice() {
        let names = solution.left_out.join(", ");
        console::message(&format!(
            "warning: no year for receiver sets of quantities other than illuminance on planes: {names}"
        ));
    }
    console::result(&table(&solution))?;
    if !arguments.quiet {
        console::message(&closing_line(
            &solution,
            started.elapsed().as_secs_f64(),
            &arguments.out.display().to_string(),
        ));
    }
    Ok(if solution.target_met() { Exit::Done } else { Exit::TargetMissed })
}

fn table(solution: &YearSolution) -> String {
    let percents = |share: Estimate| {
        let percents = Estimate { value: 100.0 * share.value, standard_error: 100.0 * share.standard_error };
        format!("{} %", percents_with_error(percents, |value, error| format!("{value} ± {error}")))
    };
    let rows =
        solution.sets.iter().zip(year_rows(solution)).map(|(set, [autonomy, sunlit, mean, useful, exposure])| {
            vec![
                set.name.clone(),
                set.points.len().to_string(),
                percents(autonomy),
                percents(sunlit),
                percents(mean),
                percents(useful),
                format!("{} ± {}", significant(exposure.value, 4), significant(exposure.standard_error, 2)),
                percent(set.error),
            ]
        });
    let header = ["receivers", "points", "sDA", "ASE", "mean DA", "300-3000 lx", "exposure/klx h", "error of hours"];
    text_table(&header, &[0], rows)
}

fn closing_line(solution: &YearSolution, wall_s: f64, out: &str) -> String {
    let sky = &solution.sky;
    let worst = solution.sets.iter().map(|set| set.worst_error).fold(0.0, f64::max);
    let met = if solution.target_met() { "met" } else { "not met at all points" };
    format!(
        "{} hours with light, {} patches (deviating from the sky's own light by {}), {} suns; {} rays in {}; target \
         {} {met} (worst point {}); results in {out}",
        sky.hours.len(),
        sky.patches.count(),
        percent(solution.patch_error),
        sky.suns.towards.len(),
        count(solution.rays as f64),
        time(wall_s),
        percent(solution.target_error),
        percent(worst)
    )
}
