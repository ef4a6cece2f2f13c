//! `luxmc validate`: runs cases against known true values and writes the report.

use std::path::PathBuf;
use std::time::{Instant, SystemTime, UNIX_EPOCH};

use clap::Args;

use super::exit::Exit;
use super::mesh::MeshArguments;
use super::proving_ground::{self, CommonArguments, PROVING_GROUND, ProvingGroundArguments};
use super::values;
use super::{Failure, Outcome, console};
use crate::output::{ResultDirectory, ResultFile};
use crate::validation::{
    CampaignSettings, Case, RunMethod, Validation, calibrate, calibration_csv, calibration_html, calibration_md,
    calibration_pictures, calibration_table, case_csv, find_cases, method_names, report_html, report_md, run_case,
    run_case_by,
};

const EXAMPLES: &str = "\
Examples:
  luxmc validate --out report                     all cases, some minutes
  luxmc validate quick --out report               under a minute
  luxmc validate sobolev cie171-5.8 --out report  two cases
  luxmc validate cie171-5.6 --method light-mesh --out report   by another method than its own
  luxmc validate hard --out report                hard cases: rooms that break naive methods
  luxmc validate calibration --out report         60 runs a map: error bars, stop rule and forecast; some minutes
  luxmc validate calibration --seeds 300 --target-error 2% --out report   the full campaign
  luxmc validate proving-ground --quick --out report   made-up rooms, a coarse check; under a minute
  luxmc validate proving-ground --rooms 4 --seeds 20 --rival peer --out report   a campaign of hours
  luxmc validate my/case --out report             a case of your own: a folder with a case.json

Exit code 1: a case failed; standard error and the report name it.";

/// Arguments of `luxmc validate`.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct ValidateArguments {
    /// Cases, groups (all, quick, hard, calibration, proving-ground) or case folders [default: all]
    #[arg(value_name = "CASE")]
    names: Vec<String>,
    /// Directory for the report; created if missing, other files in it stay
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Folder that contains the folders of the cases [default: ./validation, or one beside or above the program]
    #[arg(long, value_name = "DIR")]
    cases: Option<PathBuf>,
    /// Run every case by this method instead of its own: any method of luxmc compare; cases that it cannot compute are left out
    #[arg(long, value_name = "NAME")]
    method: Option<String>,
    #[command(flatten)]
    mesh: MeshArguments,
    /// Runs of every map, for the group calibration [default: 60]; of every room and target, for proving-ground [default: 8]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(2..=100_000))]
    seeds: Option<u64>,
    /// Target of every run, for the group calibration [default: 3%]
    #[arg(long, value_name = "ERROR", value_parser = values::target_error, allow_hyphen_values = true)]
    target_error: Option<f64>,
    /// Leave out the maps by --method auto, for the group calibration
    #[arg(long)]
    collision_only: bool,
    #[command(flatten)]
    proving_ground: ProvingGroundArguments,
    /// No progress on standard error; failures stay
    #[arg(long)]
    quiet: bool,
}

/// Runs the validation.
pub fn run(arguments: &ValidateArguments, started: Instant) -> Outcome {
    let method = method_of(arguments)?;
    if arguments.names.iter().any(|name| name == PROVING_GROUND) {
        let common = CommonArguments {
            is_alone: arguments.names.len() == 1
                && arguments.cases.is_none()
                && arguments.method.is_none()
                && arguments.target_error.is_none()
                && !arguments.collision_only,
            out: &arguments.out,
            seeds: arguments.seeds,
            quiet: arguments.quiet,
        };
        return proving_ground::run(&arguments.proving_ground, &common);
    }
    if let Some(option) = arguments.proving_ground.named() {
        return Err(proving_ground::refuse(option));
    }
    let calibrates = arguments.names.iter().any(|name| name == CALIBRATION);
    if (calibrates && arguments.names.len() > 1)
        || (!calibrates && (arguments.seeds.is_some() || arguments.target_error.is_some() || arguments.collision_only))
    {
        return Err(Failure::Usage {
            what: "calibration must be the only name given".to_owned(),
            got: arguments.names.join(" "),
            expected: "luxmc validate calibration [--seeds N] [--target-error ERROR] --out DIR".to_owned(),
            remedy: "run cases and calibration one after the other".to_owned(),
        });
    }
    let found = find_cases(&arguments.names, arguments.cases.as_deref())?;
    if calibrates {
        return run_calibration(arguments, &found.cases);
    }
    let mut directory = ResultDirectory::open(&arguments.out)?;
    let tell = |line: &str| {
        if !arguments.quiet {
            console::message(line)
        }
    };
    for group in &found.empty_groups {
        tell(&format!("the group \"{group}\" has no cases yet"));
    }
    let mut validation = Validation {
        cases: Vec::new(),
        empty_groups: found.empty_groups,
        unix_s: SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |since| since.as_secs()),
        wall_s: 0.0,
        threads: rayon::current_num_threads(),
    };
    let all = found.cases.len();
    for (index, case) in found.cases.iter().enumerate() {
        let mut tell_run = |run: &str| tell(&format!("{}/{all} {}: {run}", index + 1, case.name));
        let outcome = match &method {
            None => Some(run_case(case, &mut tell_run)?),
            Some(method) => run_case_by(case, method, &mut tell_run)?,
        };
        let Some(outcome) = outcome else { continue };
        let verdict = if outcome.passes() { "pass" } else { "FAIL" };
        tell(&format!("{}/{all} {}: {verdict}, {}", index + 1, case.name, super::number_text::time(outcome.seconds())));
        validation.cases.push(outcome);
    }
    validation.wall_s = started.elapsed().as_secs_f64();

    // The report comes last: if it exists, all files that it names exist too.
    for case in &validation.cases {
        directory.stage(&file(&format!("{}.csv", case.name), case_csv(case)))?;
    }
    directory.stage(&file("report.md", report_md(&validation)))?;
    directory.stage(&file("report.html", report_html(&validation)))?;
    directory.commit()?;

    console::result(&summary(&validation))?;
    tell(&format!("report in {}", arguments.out.join("report.html").display()));
    let failures = validation.failures();
    if failures.is_empty() {
        return Ok(Exit::Done);
    }
    console::message(&format!("failed: {}", failures.join(", ")));
    Ok(Exit::CaseFailed)
}

/// The requested method, if any.
fn method_of(arguments: &ValidateArguments) -> Result<Option<RunMethod>, Failure> {
    let mesh = arguments.mesh.choice(arguments.method.as_deref() == Some("light-mesh"))?;
    let Some(name) = &arguments.method else { return Ok(None) };
    let method = RunMethod::named(name, mesh).ok_or_else(|| Failure::Usage {
        what: "no such method".to_owned(),
        got: format!("--method {name}"),
        expected: method_names(),
        remedy: "name one of those, or leave it out".to_owned(),
    })?;
    Ok(Some(method))
}

/// Name of the group that is run many times.
const CALIBRATION: &str = "calibration";
/// Default number of runs of every map.
const COARSE_SEEDS: u64 = 60;
/// Default target error of every run, as a fraction.
const CHEAP_TARGET: f64 = 0.03;

fn run_calibration(arguments: &ValidateArguments, cases: &[Case]) -> Outcome {
    let mut directory = ResultDirectory::open(&arguments.out)?;
    let tell = |line: &str| {
        if !arguments.quiet {
            console::message(line)
        }
    };
    let settings = CampaignSettings {
        seeds: arguments.seeds.unwrap_or(COARSE_SEEDS),
        target_error: arguments.target_error.unwrap_or(CHEAP_TARGET),
        with_auto: !arguments.collision_only,
        threads: rayon::current_num_threads(),
    };
    let unix_s = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |since| since.as_secs());
    let mut campaigns = Vec::new();
    for (index, case) in cases.iter().enumerate() {
        let mut tell_run = |run: &str| tell(&format!("{}/{} {}: {run}", index + 1, cases.len(), case.name));
        campaigns.extend(calibrate(case, &settings, &mut tell_run)?);
    }
    directory.stage(&file("calibration.csv", calibration_csv(&campaigns)))?;
    for (name, picture) in calibration_pictures(&campaigns) {
        directory.stage(&file(name, picture))?;
    }
    directory.stage(&file("calibration.md", calibration_md(&campaigns, &settings, unix_s)))?;
    directory.stage(&file("calibration.html", calibration_html(&campaigns, &settings, unix_s)))?;
    directory.commit()?;

    let table = calibration_table(&campaigns);
    console::result(&super::text_table::text_table(&table.header, &table.text_columns, table.rows))?;
    tell(&format!("report in {}", arguments.out.join("calibration.html").display()));
    let failures: Vec<String> = campaigns
        .iter()
        .filter(|campaign| !campaign.passes())
        .map(|campaign| format!("{}: {}, {}", campaign.case, campaign.comparison, campaign.method))
        .collect();
    if failures.is_empty() {
        return Ok(Exit::Done);
    }
    console::message(&format!("failed: {}", failures.join("; ")));
    Ok(Exit::CaseFailed)
}

fn file(name: &str, text: String) -> ResultFile {
    ResultFile { name: name.to_owned(), bytes: text.into_bytes() }
}

fn summary(validation: &Validation) -> String {
    let table = validation.overview();
    let keep = |cells: &[String]| -> Vec<String> {
        cells.iter().enumerate().filter(|(index, _)| *index != 1).map(|(_, cell)| cell.clone()).collect()
    };
    let header: Vec<String> = table.header.iter().map(|heading| (*heading).to_owned()).collect();
    let header = keep(&header);
    let header: Vec<&str> = header.iter().map(String::as_str).collect();
    super::text_table::text_table(&header, &[0], table.rows.iter().map(|row| keep(row)))
}
