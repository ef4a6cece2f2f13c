//! The command line: arguments, progress, exit codes. Nothing outside this room prints.

mod arguments;
mod beforehand;
mod checkpoint;
mod compare;
mod completions;
mod console;
mod convert;
mod dry_run;
mod exit;
mod inspect;
mod inspect_photometric;
mod kept_back;
mod man;
mod memory;
mod merge;
mod mesh;
mod method;
#[cfg(feature = "mpi")]
mod mpi;
mod new;
mod new_hall;
mod new_harmonics;
mod number_text;
mod patience;
mod progress;
mod proportions;
mod proving_ground;
mod result_table;
mod results;
mod resume;
mod run;
mod schema;
mod selection;
mod share;
mod sobolev;
mod solve;
mod solve_arguments;
mod sunlight;
mod text_table;
mod time_guard;
mod ugr_table;
mod validate;
mod values;
mod verdict_target;
mod version;
mod year;

use std::process::ExitCode;
use std::time::Instant;

use clap::{CommandFactory, Parser};

use arguments::{Arguments, Command};

/// Runs the program with the arguments of the process.
///
/// Returns the exit code: 0 done, 1 a validation case failed, 2 bad usage or input, 3 a limit came before the target. 4 means that
/// results could not be written, 130 interrupted.
pub fn run() -> ExitCode {
    let started = Instant::now();
    let arguments = Arguments::parse();
    survive_file_size_limits();
    let outcome = match &arguments.command {
        #[cfg(feature = "mpi")]
        Command::Solve(arguments) => mpi::run(arguments, started).unwrap_or_else(|| solve::run(arguments, started)),
        #[cfg(not(feature = "mpi"))]
        Command::Solve(arguments) => solve::run(arguments, started),
        Command::Resume(arguments) => resume::run(arguments, started),
        Command::Merge(arguments) => merge::run(arguments, started),
        Command::Sobolev(arguments) => sobolev::run(arguments),
        Command::Validate(arguments) => validate::run(arguments, started),
        Command::Compare(arguments) => compare::run(arguments),
        Command::Inspect(arguments) => inspect::run(arguments),
        Command::Sunlight(arguments) => sunlight::run(arguments),
        Command::Year(arguments) => year::run(arguments, started),
        Command::UgrTable(arguments) => ugr_table::run(arguments),
        Command::Schema => schema::run(),
        Command::New(arguments) => new::run(arguments),
        Command::Convert(arguments) => convert::run(arguments),
        Command::Completions(arguments) => completions::run(arguments, Arguments::command()),
        Command::Man(arguments) => man::run(arguments, Arguments::command()),
    };
    match outcome {
        Ok(exit) => exit.code(),
        Err(failure) => {
            console::message(&format!("luxmc: error: {failure}"));
            failure.exit().code()
        }
    }
}

/// Lets a write beyond the file size limit (`ulimit -f`) fail as any other write does. The failure is then reported and no
/// half-written file stays. By default the system would end the process without a message.
fn survive_file_size_limits() {
    #[cfg(unix)]
    {
        let beyond_limit = std::sync::Arc::new(std::sync::atomic::AtomicBool::new(false));
        // If the handler cannot be set, the process ends as it would by default: no reason not to run.
        signal_hook::flag::register(signal_hook::consts::SIGXFSZ, beyond_limit).ok();
    }
}

// For other front ends.
pub use exit::{Exit, Failure};
pub use inspect_photometric::photometric_json;
pub use memory::limit_memory;
pub use method::{MethodChoice, Plots, plots_named};
pub use result_table::result_table;
pub use results::{closing_lines, exit_of};
pub use run::{RunOptions, RunStory, SceneRun};
pub use verdict_target::Target;

/// The result of a command.
type Outcome = Result<Exit, Failure>;
