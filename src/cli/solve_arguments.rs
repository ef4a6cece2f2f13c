//! The arguments of `luxmc solve`, their conversion to options of a run, and the command that repeats it.

use std::path::{Path, PathBuf};

use clap::Args;
use serde::{Deserialize, Serialize};

use super::exit::Failure;
use super::mesh::MeshArguments;
use super::method::{self, MethodChoice, Plots, method};
use super::results::quoted;
use super::run::RunOptions;
use super::verdict_target::{Target, target};
use super::{share, values};
use crate::check::MeshCheck;
use crate::output::{CheckpointFile, Language};
use crate::scene::ReceiversPart;
use crate::solver::{ElementChoice, Portion, Share, Solution};

const EXAMPLES: &str = "\
Examples:
  luxmc solve office.json --out out                       to a stated error of 1% (the default)
  luxmc solve office.json --out out --target-error 0.5%   finer
  luxmc solve office.json --out out --target verdicts     until it is certain whether every requirement is met
  luxmc solve office.json --out out --time-limit 60s      as good as a minute allows
  luxmc solve office.json --out out --chains 1e6          the same bytes in every run
  luxmc solve office.json --out out/3 --share 3/8 --chains 1e7   one of eight shares, for luxmc merge
  luxmc solve campus.json --out out/3 --receivers-part 3/8       every eighth receiver, for luxmc merge
  luxmc solve office.json --out out --checkpoint office.ckpt     kept every minute; luxmc resume office.ckpt continues
  luxmc solve office.json --dry-run                       what targets would take: rays, seconds, memory
  luxmc solve office.json --out out --maps \"work plane\"   one receiver set only

The first stop rule met ends the run. Standard output carries the result table alone.
Ctrl-C ends the run and writes what it has; another one a second later ends the process at once.
Exit code 3: a limit came before the target.";

/// Arguments of `luxmc solve`.
#[derive(Debug, Args, Serialize, Deserialize)]
#[command(after_help = EXAMPLES)]
pub struct SolveArguments {
    /// Scene file (JSON)
    pub(super) scene: PathBuf,
    /// Directory for the results; made where missing, other files in it stay
    #[arg(long, value_name = "DIR", required_unless_present = "dry_run")]
    pub out: Option<PathBuf>,
    /// Run the pilots only, and print what a run would take (rays, seconds, memory) by every method that applies, or by --method, to
    /// errors of 3, 1, 0.3 and 0.1%, and to --target-error
    #[arg(long)]
    pub(super) dry_run: bool,
    /// Stop at this stated relative error of every bound map: 1% or 0.01 [default: 1%, where no stop rule is given]
    #[arg(long, value_name = "ERROR", value_parser = values::target_error, allow_hyphen_values = true)]
    pub target_error: Option<f64>,
    /// Run until it is certain for every requirement of the scene whether it is met: verdicts. Computes the receiver sets, unless --maps
    /// names others; --target-error is then the smallest error to go to [default: 0.1%]
    #[arg(long, value_name = "WHAT", value_parser = target)]
    pub(super) target: Option<Target>,
    /// Stop this long after process start: 60s, 500ms, 5m, 1h; a plain number counts seconds
    #[arg(long, value_name = "TIME", value_parser = values::time_s, allow_hyphen_values = true)]
    pub(super) time_limit: Option<f64>,
    /// Chains for every map, rounded up to fill the replicas: 1000000, 1_000_000 or 1e6
    #[arg(long, value_name = "N", value_parser = values::chains, allow_hyphen_values = true)]
    pub(super) chains: Option<u64>,
    /// Seed of all random numbers
    #[arg(long, value_name = "SEED", default_value = "0", value_parser = values::seed, allow_hyphen_values = true)]
    pub(super) seed: u64,
    /// Worker threads; results do not depend on them [default: all processors]
    #[arg(long, value_name = "T", value_parser = values::threads, allow_hyphen_values = true)]
    pub threads: Option<usize>,
    /// Maps to compute, write and bind to the target: all, elements, receivers, or names of receiver sets, separated by commas [default:
    /// all are computed; the target binds the receiver sets, if any]
    #[arg(long, value_name = "MAPS")]
    pub(super) maps: Option<String>,
    /// Method: auto, gather, collision or local (every scene), local-naive, radiosity (closed diffuse rooms of rectangles along the axes), or
    /// light-mesh (planes and luminance; pays with many luminaires and many receivers)
    #[arg(long, value_name = "NAME", default_value = "auto", value_parser = method)]
    pub(super) method: MethodChoice,
    /// Elements of the element map where the target binds it: adaptive (the scene's elements, subdivided and with slopes as far as the
    /// target requires, with their discretisation error) or given (the scene's elements, as means)
    #[arg(long, value_name = "NAME", default_value = "adaptive", value_parser = method::elements)]
    pub(super) elements: ElementChoice,
    /// Compute one of many independent shares of a run, such as 3/8; luxmc merge combines them into one result. --chains or --time-limit
    /// set the work of a share; the merged result is checked against --target-error
    #[arg(long, value_name = "K/N", value_parser = values::share, allow_hyphen_values = true, conflicts_with = "dry_run")]
    pub(super) share: Option<Share>,
    /// Compute one of several parts of the receivers, such as 3/8: every eighth point of each set from the third on. luxmc merge combines
    /// all parts into one result, and checks the target
    #[arg(long, value_name = "K/N", value_parser = values::receivers_part, allow_hyphen_values = true, conflicts_with = "dry_run")]
    pub(super) receivers_part: Option<ReceiversPart>,
    /// Keep the state of the run in this file, from which luxmc resume continues
    #[arg(long, value_name = "FILE", conflicts_with = "dry_run")]
    #[serde(skip)]
    pub checkpoint: Option<PathBuf>,
    /// Time between two checkpoints: 60s, 5m; longer where writing takes more than 2 % of it [default: 60s]
    #[arg(long, value_name = "TIME", value_parser = values::time_s, allow_hyphen_values = true, requires = "checkpoint")]
    pub checkpoint_every: Option<f64>,
    #[command(flatten)]
    #[serde(skip)]
    pub(super) mesh: MeshArguments,
    /// Plots: svg, png, both separated by a comma, or none [default: svg]
    #[arg(long, value_name = "FORMATS", value_parser = method::plots)]
    pub plots: Option<Plots>,
    /// Language of report, plots and the table on the terminal: en or de
    #[arg(long, value_name = "CODE", default_value = "en", value_parser = Language::of_code)]
    #[serde(default)]
    pub language: Language,
    /// Memory that the run may use: 2GB, 512MiB [default: what the machine has left]
    #[arg(long, value_name = "MEMORY", value_parser = values::bytes, allow_hyphen_values = true)]
    pub memory_limit: Option<u64>,
    /// Read files of any size; without this option, files above 512 MiB (photometric files above 64 MiB) are refused as probable mistakes
    #[arg(long)]
    pub allow_large: bool,
    /// Checks of meshes to skip, separated by commas: faults, overlaps, advice, insides (then points inside of solids count). The
    /// warnings of the run list the skipped checks
    #[arg(long, value_name = "CHECKS", value_delimiter = ',', value_parser = values::mesh_check)]
    #[serde(default)]
    pub skip_check: Vec<MeshCheck>,
    /// No progress on standard error; warnings and errors stay
    #[arg(long)]
    pub quiet: bool,
}

impl SolveArguments {
    /// The portion of the run that is requested, if not all of it.
    pub(super) fn portion(&self) -> Option<Portion> {
        let (share, part) = (self.share, self.receivers_part);
        (share.is_some() || part.is_some()).then_some(Portion { share, part })
    }
}

/// A run that is resumed.
pub struct Resumption {
    /// Its checkpoint.
    pub file: CheckpointFile,
    /// Path of its scene.
    pub scene: PathBuf,
    /// Seconds from the start of the process at which this part of the run ends, if limited.
    pub time_limit_s: Option<f64>,
}

/// The command that reproduces the run.
pub fn command_again(arguments: &SolveArguments, solution: &Solution) -> String {
    let portion = arguments.portion().map_or(String::new(), share::options_of);
    format!("{} --out out{portion}", command_without_output(arguments, solution))
}

/// The same without directory and portion.
pub fn command_without_output(arguments: &SolveArguments, solution: &Solution) -> String {
    let mut command = format!("luxmc solve {} --seed {}", quoted(&arguments.scene), arguments.seed);
    if arguments.target.is_some() {
        command += " --target verdicts";
    }
    match (arguments.chains, arguments.target_error) {
        (None, None) if arguments.target.is_some() => {}
        (Some(chains), _) => command += &format!(" --chains {chains}"),
        (None, Some(target)) => command += &format!(" --target-error {target}"),
        (None, None) => {
            command += &solution.target_error.map_or(String::new(), |target| format!(" --target-error {target}"));
        }
    }
    if arguments.method != MethodChoice::AUTO {
        command += &format!(" --method {}", solution.method);
    }
    command += &arguments.mesh.again();
    if let Some(limit_s) = arguments.time_limit {
        command += &format!(" --time-limit {limit_s}s");
    }
    if let Some(maps) = &arguments.maps {
        command += &format!(" --maps {}", quoted(Path::new(maps)));
    }
    command
}

/// Converts the arguments to the options of a run.
pub fn options(arguments: &SolveArguments) -> Result<RunOptions, Failure> {
    Ok(RunOptions {
        method: arguments.method,
        elements: arguments.elements,
        mesh: arguments.mesh.choice(arguments.method == MethodChoice::LightMesh)?,
        seed: arguments.seed,
        target_error: arguments.target_error,
        target: arguments.target,
        chains: arguments.chains,
        time_limit_s: arguments.time_limit,
        maps: arguments.maps.clone(),
        threads: arguments.threads,
        receivers_part: arguments.receivers_part,
    })
}
