//! The subcommands of the program, with the arguments of each.

use clap::{Parser, Subcommand};

use super::compare::CompareArguments;
use super::completions::CompletionsArguments;
use super::convert::{self, ConvertArguments};
use super::inspect::InspectArguments;
use super::man::ManArguments;
use super::merge::MergeArguments;
use super::new::NewArguments;
use super::resume::ResumeArguments;
use super::sobolev::{self, SobolevArguments};
use super::solve_arguments::SolveArguments;
use super::sunlight::{self, SunlightArguments};
use super::ugr_table::{self, UgrTableArguments};
use super::validate::ValidateArguments;
use super::version::long_version;
use super::year::{self, YearArguments};

const EXAMPLES: &str = "\
Examples:
  luxmc new office --out my-office
  luxmc inspect my-office/office.json
  luxmc convert model.glb --out scene.json
  luxmc solve my-office/office.json --out my-office/results --target-error 1%
  luxmc year scenes/daylight-office.json --weather city.epw --out out/year
  luxmc ugr-table downlight.ldt --out out/downlight
  luxmc sobolev --h1 0.5 --rho1 0.5 --rho2 0.5 --r 0:3:31
  luxmc validate --out report
  luxmc compare cube --out report
  luxmc schema > scene.schema.json

Exit codes:
  0    done (target met where one was set)
  1    a validation case failed
  2    bad usage or bad input; nothing written
  3    a limit ended the run before the set target was met; results written
  4    results could not be written
  130  interrupted; results written";

/// Photometric lighting simulator: illuminance and luminance of a lit scene, with an error it can vouch for.
#[derive(Debug, Parser)]
#[command(name = "luxmc", version, long_version = long_version(), after_help = EXAMPLES, arg_required_else_help = true)]
pub struct Arguments {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
}

/// What to do.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Start a project from a template that runs as it is
    New(NewArguments),
    /// Compute every map and receiver set of a scene and write the results into a directory
    Solve(SolveArguments),
    /// Resume a run from its checkpoint (solve --checkpoint FILE), to the same results or to a smaller error
    Resume(ResumeArguments),
    /// Merge the shares of a run (solve --share k/n) into one result, and check its target
    Merge(MergeArguments),
    /// Exact illuminance between two parallel diffuse planes lit by a point source
    #[command(long_about = sobolev::ABOUT)]
    Sobolev(SobolevArguments),
    /// Run validation cases against their exact solutions and write a report
    Validate(ValidateArguments),
    /// Compare speed and error of every method that applies to a validation case
    Compare(CompareArguments),
    /// Show what was read from a scene or a photometric file
    Inspect(InspectArguments),
    /// A year of daylight by a weather file: hourly illuminances, sDA, UDI and ASE with their errors
    #[command(long_about = year::ABOUT)]
    Year(YearArguments),
    /// How long receivers see the sun on the days of EN 17037
    #[command(long_about = sunlight::ABOUT)]
    Sunlight(SunlightArguments),
    /// UGR table of a luminaire after CIE 190
    #[command(long_about = ugr_table::ABOUT)]
    UgrTable(UgrTableArguments),
    /// Print the JSON Schema of the scene file
    Schema,
    /// Make a scene from a model: OBJ, glTF, STL, PLY, Radiance
    #[command(long_about = convert::ABOUT)]
    Convert(ConvertArguments),
    /// Print a script that lets a shell complete commands and options
    Completions(CompletionsArguments),
    /// Print a page of the manual, or write all of them
    Man(ManArguments),
}
