//! `luxmc compare`: speed against error of every method that applies to a case.

use std::path::{Path, PathBuf};

use clap::Args;

use super::exit::Exit;
use super::{Failure, Outcome, console, values};
use crate::output::{ResultDirectory, ResultFile};
use crate::validation::{METHODS, case_of_stored_run, climb, find_cases, ladder_csv, ladder_html, ladder_md};

const EXAMPLES: &str = "\
Examples:
  luxmc compare cube --out speed                 every method on a diffuse cube
  luxmc compare sobolev cube --out speed --budget 60s
  luxmc compare scenes/office.json --truth out/long --out speed   a scene, judged by a long run of it

Every map of points or elements that the case compares is computed with more and more chains until the budget is
used up, and judged against the exact map each time. A scene without an exact solution is judged by a long run of it, such as
luxmc solve scenes/office.json --method collision --seed 1000 --target-error 0.1% --out out/long";

/// Arguments of `luxmc compare`.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct CompareArguments {
    /// Cases, groups or case folders; with --truth a scene file
    #[arg(value_name = "CASE", required = true)]
    names: Vec<String>,
    /// Directory for the report; made where missing, other files in it stay
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Time for every method on every map: 20s, 5m
    #[arg(long, value_name = "TIME", default_value = "20s", value_parser = values::time_s)]
    budget: f64,
    /// Results of a long run of the scene, made by luxmc solve: the truth, whose standard errors are allowed for
    #[arg(long, value_name = "DIR", conflicts_with = "cases")]
    truth: Option<PathBuf>,
    /// Folder whose folders are the cases [default: ./validation, or one beside or above the program]
    #[arg(long, value_name = "DIR")]
    cases: Option<PathBuf>,
    /// No progress on standard error
    #[arg(long)]
    quiet: bool,
}

/// Compares.
pub fn run(arguments: &CompareArguments) -> Outcome {
    let cases = match &arguments.truth {
        None => find_cases(&arguments.names, arguments.cases.as_deref())?.cases,
        Some(truth) => arguments
            .names
            .iter()
            .map(|scene| case_of_stored_run(Path::new(scene), truth))
            .collect::<Result<Vec<_>, _>>()?,
    };
    let mut directory = ResultDirectory::open(&arguments.out)?;
    let mut ladders = Vec::new();
    for case in &cases {
        for method in METHODS {
            let mut tell = |line: &str| {
                if !arguments.quiet {
                    console::message(&format!("{}: {line}", case.name));
                }
            };
            ladders.extend(climb(case, method, arguments.budget, &mut tell)?);
        }
    }
    if ladders.is_empty() {
        return Err(Failure::Usage {
            what: "nothing can be compared".to_owned(),
            got: arguments.names.join(", "),
            expected: "a case that compares a map of points or elements".to_owned(),
            remedy: "name another case, such as cube or sobolev".to_owned(),
        });
    }
    let files = [
        ("compare.csv", ladder_csv(&ladders)),
        ("compare.md", ladder_md(&ladders)),
        ("compare.html", ladder_html(&ladders)),
    ];
    for (name, text) in files {
        directory.stage(&ResultFile { name: name.to_owned(), bytes: text.into_bytes() })?;
    }
    directory.commit()?;
    console::result(&ladder_md(&ladders))?;
    Ok(Exit::Done)
}
