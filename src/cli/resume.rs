//! `luxmc resume`: resumes a run from its checkpoint.

use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::Args;

use super::method::{self, Plots};
use super::solve::run_from;
use super::solve_arguments::{Resumption, SolveArguments};
use super::{Outcome, values};
use crate::output::{CheckpointFile, SealedError, read_checkpoint};

const EXAMPLES: &str = "\
Examples:
  luxmc solve office.json --out out --checkpoint office.ckpt --checkpoint-every 60s
  luxmc resume office.ckpt                        continues where that run was interrupted, and writes into out
  luxmc resume office.ckpt --target-error 0.3%    continues to a smaller error, once the first one is met
  luxmc resume office.ckpt --time-limit 1h        at most an hour; the next resume continues from there

A run that is interrupted and resumed gives the same bytes as one that is not. It keeps its checkpoint in the same file.";

/// Arguments of `luxmc resume`.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct ResumeArguments {
    /// Checkpoint, written by luxmc solve --checkpoint
    #[arg(value_name = "FILE")]
    checkpoint: PathBuf,
    /// Directory for the results [default: that of the run]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Stop at this stated relative error of every bound map: 1% or 0.01 [default: that of the run]
    #[arg(long, value_name = "ERROR", value_parser = values::target_error, allow_hyphen_values = true)]
    target_error: Option<f64>,
    /// Stop this long after the start of this process: 60s, 500ms, 5m, 1h [default: what is left of the run's own limit, if it has one]
    #[arg(long, value_name = "TIME", value_parser = values::time_s, allow_hyphen_values = true)]
    time_limit: Option<f64>,
    /// Time between two checkpoints [default: that of the run]
    #[arg(long, value_name = "TIME", value_parser = values::time_s, allow_hyphen_values = true)]
    checkpoint_every: Option<f64>,
    /// Scene file, if it is no longer where the run found it
    #[arg(long, value_name = "SCENE")]
    scene: Option<PathBuf>,
    /// Worker threads; results do not depend on them [default: those of the run]
    #[arg(long, value_name = "T", value_parser = values::threads, allow_hyphen_values = true)]
    threads: Option<usize>,
    /// Plots: svg, png, both separated by a comma, or none [default: those of the run]
    #[arg(long, value_name = "FORMATS", value_parser = method::plots)]
    plots: Option<Plots>,
    /// Memory that the run may use: 2GB, 512MiB [default: what the machine has left]
    #[arg(long, value_name = "MEMORY", value_parser = values::bytes, allow_hyphen_values = true)]
    memory_limit: Option<u64>,
    /// Read files of any size; without this option, files above 512 MiB (photometric files above 64 MiB) are refused as probable mistakes
    #[arg(long)]
    allow_large: bool,
    /// No progress on standard error; warnings and errors stay
    #[arg(long)]
    quiet: bool,
}

/// Resumes a run.
pub fn run(arguments: &ResumeArguments, started: Instant) -> Outcome {
    let file = read_checkpoint(&arguments.checkpoint)?;
    check_version(&file)?;
    let mut solve: SolveArguments = serde_json::from_value(file.header.arguments.clone()).map_err(|error| {
        unfit(
            &file,
            "this luxmc does not know the arguments of the run in the checkpoint",
            error.to_string(),
            "arguments that this luxmc knows",
        )
    })?;
    solve.out = Some(arguments.out.clone().unwrap_or_else(|| file.header.out.clone()));
    solve.target_error = arguments.target_error.or(solve.target_error);
    solve.checkpoint = Some(arguments.checkpoint.clone());
    solve.checkpoint_every = arguments.checkpoint_every.or(solve.checkpoint_every);
    solve.threads = arguments.threads.or(solve.threads);
    solve.plots = arguments.plots.or(solve.plots);
    solve.memory_limit = arguments.memory_limit.or(solve.memory_limit);
    solve.allow_large |= arguments.allow_large;
    solve.quiet = arguments.quiet;
    let scene = arguments.scene.clone().unwrap_or_else(|| scene_of(&file));
    run_from(&solve, Some(Resumption { file, scene, time_limit_s: arguments.time_limit }), started)
}

/// The scene's path as the run named it, if that still leads to the same file; else its absolute path.
fn scene_of(file: &CheckpointFile) -> PathBuf {
    let named = Path::new(&file.header.scene);
    match std::path::absolute(named) {
        Ok(path) if path == file.header.scene_path => named.to_path_buf(),
        _ => file.header.scene_path.clone(),
    }
}

fn check_version(file: &CheckpointFile) -> Result<(), SealedError> {
    let (got, own) = (&file.header.luxmc, env!("CARGO_PKG_VERSION"));
    if got == own {
        return Ok(());
    }
    Err(unfit(file, "the checkpoint was written by another version of luxmc", got.clone(), own))
}

fn unfit(file: &CheckpointFile, what: &str, got: String, expected: &str) -> SealedError {
    SealedError {
        path: file.path.clone(),
        what: what.to_owned(),
        got,
        expected: expected.to_owned(),
        remedy: "resume with the luxmc that wrote it, or start a new run".to_owned(),
    }
}
