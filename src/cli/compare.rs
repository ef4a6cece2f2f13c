//! `luxmc compare`: speed against error of every method that applies to a case.

use std::path::PathBuf;

use clap::Args;

use super::exit::Exit;
use super::{Failure, Outcome, console, values};
use crate::output::{ResultDirectory, ResultFile};
use crate::validation::{METHODS, climb, find_cases, ladder_csv, ladder_html, ladder_md};

const EXAMPLES: &str = "\
Examples:
  luxmc compare cube --out speed                 every method on a diffuse cube
  luxmc compare sobolev cube --out speed --budget 60s

Every map of points or elements that the case compares is computed with more and more chains until the budget is
used up, and judged against the exact map each time.";

/// Arguments of `luxmc compare`.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct CompareArguments {
    /// Cases, groups or case folders
    #[arg(value_name = "CASE", required = true)]
    names: Vec<String>,
    /// Directory for the report; made where missing, other files in it stay
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Time for every method on every map: 20s, 5m
    #[arg(long, value_name = "TIME", default_value = "20s", value_parser = values::time_s)]
    budget: f64,
    /// Folder whose folders are the cases [default: ./validation, or one beside or above the program]
    #[arg(long, value_name = "DIR")]
    cases: Option<PathBuf>,
    /// No progress on standard error
    #[arg(long)]
    quiet: bool,
}

/// Compares.
pub fn run(arguments: &CompareArguments) -> Outcome {
    let found = find_cases(&arguments.names, arguments.cases.as_deref())?;
    let mut directory = ResultDirectory::open(&arguments.out)?;
    let mut ladders = Vec::new();
    for case in &found.cases {
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
