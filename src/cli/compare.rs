//! `luxmc compare`: speed against error of every method that applies to a case.

use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};

use super::exit::Exit;
use super::{Failure, Outcome, console, values};
use crate::output::{ResultDirectory, ResultFile};
use crate::validation::studies::{self, DirectForm, Findings, Interpolation, Only, STUDIES, Study, studies_named};
use crate::validation::{METHODS, case_of_stored_run, climb, find_cases, ladder_csv, ladder_html, ladder_md};

const EXAMPLES: &str = "\
Examples:
  luxmc compare cube --out speed                 every method on a diffuse cube
  luxmc compare sobolev cube --out speed --budget 60s
  luxmc compare light-mesh-luminaires --out speed   what a light mesh saves with many luminaires
  luxmc compare scaling choice --out speed        how cost grows with a scene, and how well auto chooses
  luxmc compare scenes/office.json --truth out/long --out speed   a scene, compared with a long run of it

Every map of points or elements that the case compares is computed with more and more chains until the budget is
used up, and compared with the exact map each time. A scene without an exact solution is compared with a long run of it, such as
luxmc solve scenes/office.json --method collision --seed 1000 --target-error 0.1% --out out/long";

/// The examples and the list of studies, shown at the end of the help text.
fn after_help() -> String {
    let list: Vec<String> = STUDIES.iter().map(|study| format!("  {:<23}{}", study.name, study.title)).collect();
    format!(
        "{EXAMPLES}\n\nStudies, which are given like cases (all studies of light meshes: {}):\n{}",
        studies::GROUP,
        list.join("\n")
    )
}

/// Arguments of `luxmc compare`.
#[derive(Debug, Args)]
#[command(after_help = after_help())]
pub struct CompareArguments {
    /// Cases, groups, case folders or studies; with --truth a scene file
    #[arg(value_name = "CASE", required = true)]
    names: Vec<String>,
    /// Directory for the report; created if missing, other files in it stay
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Time for every method on every map: 20s, 5m
    #[arg(long, value_name = "TIME", default_value = "20s", value_parser = values::time_s)]
    budget: f64,
    /// Results of a long run of the scene, made by luxmc solve: the reference, whose standard errors are taken into account
    #[arg(long, value_name = "DIR", conflicts_with = "cases")]
    truth: Option<PathBuf>,
    /// Folder that contains the folders of the cases [default: ./validation, or one beside or above the program]
    #[arg(long, value_name = "DIR")]
    cases: Option<PathBuf>,
    /// Small versions of the studies, to test that they work: seconds instead of minutes
    #[arg(long)]
    quick: bool,
    /// What mesh points store of direct light in the study light-mesh-forms [default: both]
    #[arg(long, value_name = "FORM", value_enum)]
    mesh_direct: Option<DirectWord>,
    /// How places get it from the mesh points, in that study and in light-mesh-indirect [default: all]
    #[arg(long, value_name = "WAY", value_enum)]
    mesh_interpolation: Option<InterpolationWord>,
    /// No progress on standard error
    #[arg(long)]
    quiet: bool,
}

/// What a mesh point keeps of direct light.
#[derive(Clone, Copy, Debug, ValueEnum)]
enum DirectWord {
    /// Which luminaires are visible
    Visibility,
    /// One number for all luminaires together
    Scalar,
}

/// How a place takes it.
#[derive(Clone, Copy, Debug, ValueEnum)]
enum InterpolationWord {
    /// The nearest corner of its cell
    Nearest,
    /// All corners of its cell
    Trilinear,
    /// All points within the radius, with both weights
    Sphere,
}

impl CompareArguments {
    fn only(&self) -> Only {
        let direct = self.mesh_direct.map(|word| match word {
            DirectWord::Visibility => DirectForm::Visibility,
            DirectWord::Scalar => DirectForm::Scalar,
        });
        let interpolation = self.mesh_interpolation.map(|word| match word {
            InterpolationWord::Nearest => Interpolation::Nearest,
            InterpolationWord::Trilinear => Interpolation::Trilinear,
            InterpolationWord::Sphere => Interpolation::Sphere,
        });
        Only { direct, interpolation }
    }
}

/// Runs the comparison.
pub fn run(arguments: &CompareArguments) -> Outcome {
    let (study_names, names): (Vec<String>, Vec<String>) = match arguments.truth {
        None => arguments.names.iter().cloned().partition(|name| !studies_named(name).is_empty()),
        Some(_) => (Vec::new(), arguments.names.clone()),
    };
    let cases = match &arguments.truth {
        None if names.is_empty() => Vec::new(),
        None => find_cases(&names, arguments.cases.as_deref())?.cases,
        Some(truth) => {
            names.iter().map(|scene| case_of_stored_run(Path::new(scene), truth)).collect::<Result<Vec<_>, _>>()?
        }
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
    let found = run_studies(&study_names, arguments)?;
    if ladders.is_empty() && found.is_empty() {
        return Err(Failure::Usage {
            what: "nothing can be compared".to_owned(),
            got: arguments.names.join(", "),
            expected: "a case that compares a map of points or elements".to_owned(),
            remedy: "name another case, such as cube or sobolev".to_owned(),
        });
    }
    let sections: String = found.iter().map(studies::study_section).collect();
    let text: String = found.iter().map(studies::study_md).collect();
    let mut files = vec![
        ("compare.md".to_owned(), ladder_md(&ladders, &text)),
        ("compare.html".to_owned(), ladder_html(&ladders, &sections)),
    ];
    if !ladders.is_empty() {
        files.push(("compare.csv".to_owned(), ladder_csv(&ladders)));
    }
    files.extend(found.iter().map(|findings| (format!("{}.csv", findings.name), studies::study_csv(findings))));
    for (name, text) in files {
        directory.stage(&ResultFile { name, bytes: text.into_bytes() })?;
    }
    directory.commit()?;
    console::result(&ladder_md(&ladders, &text))?;
    Ok(Exit::Done)
}

/// Runs the studies that the names select, each once.
fn run_studies(names: &[String], arguments: &CompareArguments) -> Result<Vec<Findings>, Failure> {
    let is_requested =
        |study: &&Study| names.iter().any(|name| studies_named(name).iter().any(|other| other.name == study.name));
    let run = |study: &Study| {
        let mut tell = |line: &str| {
            if !arguments.quiet {
                console::message(&format!("{}: {line}", study.name));
            }
        };
        let mut wishes = studies::StudyWishes { quick: arguments.quick, only: arguments.only(), tell: &mut tell };
        (study.run)(&mut wishes)
            .map(|found| found.marked(arguments.quick))
            .map_err(|why| Failure::Study { name: study.name, why })
    };
    STUDIES.iter().filter(is_requested).map(run).collect()
}
