//! `luxmc validate`: runs cases against their truths and writes the report.

use std::path::PathBuf;
use std::time::{Instant, SystemTime, UNIX_EPOCH};

use clap::Args;

use super::exit::Exit;
use super::mesh::MeshArguments;
use super::{Failure, Outcome, console};
use crate::output::{ResultDirectory, ResultFile};
use crate::validation::{
    RunMethod, Validation, case_csv, find_cases, method_names, report_html, report_md, run_case, run_case_by,
};

const EXAMPLES: &str = "\
Examples:
  luxmc validate --out report                     all cases, some minutes
  luxmc validate quick --out report               under a minute
  luxmc validate sobolev cie171-5.8 --out report  two cases
  luxmc validate cie171-5.6 --method light-mesh --out report   by another method than its own
  luxmc validate my/case --out report             a case of your own: a folder with a case.json

Exit code 1: a case failed; its name stands on standard error and in the report.";

/// Arguments of `luxmc validate`.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct ValidateArguments {
    /// Cases, groups (all, quick, hard, calibration) or case folders [default: all]
    #[arg(value_name = "CASE")]
    names: Vec<String>,
    /// Directory for the report; made where missing, other files in it stay
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Folder whose folders are the cases [default: ./validation, or one beside or above the program]
    #[arg(long, value_name = "DIR")]
    cases: Option<PathBuf>,
    /// Run every case by this method instead of its own: any that luxmc compare knows; what it cannot is left out
    #[arg(long, value_name = "NAME")]
    method: Option<String>,
    #[command(flatten)]
    mesh: MeshArguments,
    /// No progress on standard error; failures stay
    #[arg(long)]
    quiet: bool,
}

/// Validates.
pub fn run(arguments: &ValidateArguments, started: Instant) -> Outcome {
    let method = method_of(arguments)?;
    let found = find_cases(&arguments.names, arguments.cases.as_deref())?;
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

    // The report comes last: where it stands, everything that it speaks of stands too.
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

/// The method that the user asks for, if one.
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
