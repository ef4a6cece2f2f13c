//! `luxmc validate proving-ground`: many made-up rooms, stated against true errors, seconds against those of others.

use std::path::{Path, PathBuf};
use std::time::{SystemTime, UNIX_EPOCH};

use clap::Args;

use super::exit::Exit;
use super::text_table::text_table;
use super::{Failure, Outcome, console, values};
use crate::output::{ResultDirectory, ResultFile};
use crate::validation::proving_ground::rooms::{KINDS, Kind, kind_of};
use crate::validation::proving_ground::{
    ProofSettings, ReferenceSettings, Rival, failures, proof_csv, proof_html, proof_md, proof_pictures, proof_table,
    prove,
};

/// The group that is made by rule.
pub const PROVING_GROUND: &str = "proving-ground";

/// Where nothing else is asked for: rooms of each kind, runs of each room and target, targets.
const ROOMS: u64 = 2;
const SEEDS: u64 = 8;
const TARGETS: [f64; 3] = [0.03, 0.01, 0.003];
/// The same for a coarse look.
const QUICK_ROOMS: u64 = 1;
const QUICK_SEEDS: u64 = 4;
const QUICK_TARGETS: [f64; 1] = [0.03];
const QUICK_KINDS: [&str; 4] = ["furnished", "dark", "corridor", "curved"];
/// Error of a reference over the smallest target.
const REFERENCE_SHARE: f64 = 1.0 / 3.0;
/// Processor seconds that a reference, and a run, may take.
const REFERENCE_S: f64 = 1800.0;
const PATIENCE_S: f64 = 900.0;
const QUICK_REFERENCE_S: f64 = 20.0;
/// Paths that a rival traces from each receiver.
const RIVAL_PATHS: u32 = 256;

/// Arguments of `luxmc validate proving-ground` beside those of every validation.
#[derive(Debug, Args)]
#[command(next_help_heading = "For proving-ground")]
pub struct ProvingGroundArguments {
    /// Kinds of rooms, with commas between [default: all; luxmc new room --kind list]
    #[arg(long, value_name = "KINDS", value_delimiter = ',')]
    kinds: Vec<String>,
    /// Rooms of each kind: even ones to tune on, odd ones to judge by [default: 2]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=10_000))]
    rooms: Option<u64>,
    /// Targets of the runs, with commas between [default: 3%,1%,0.3%]
    #[arg(long, value_name = "ERRORS", value_delimiter = ',', value_parser = values::target_error)]
    targets: Vec<f64>,
    /// Error of the references [default: a third of the smallest target]
    #[arg(long, value_name = "ERROR", value_parser = values::target_error)]
    reference_error: Option<f64>,
    /// Processor time that a reference may take [default: 30m]
    #[arg(long, value_name = "TIME", value_parser = values::time_s)]
    reference_time: Option<f64>,
    /// Folder where references are kept and found again [default: references in the folder of the report]
    #[arg(long, value_name = "DIR")]
    references: Option<PathBuf>,
    /// Program to run beside luxmc in diffuse rooms; docs/validation.md says what it must read and write
    #[arg(long, value_name = "PROGRAM")]
    rival: Option<PathBuf>,
    /// Paths that it traces from each receiver [default: 256]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..), requires = "rival")]
    rival_paths: Option<u32>,
    /// Processor time after which a run is given up [default: 15m]
    #[arg(long, value_name = "TIME", value_parser = values::time_s)]
    patience: Option<f64>,
    /// A coarse look in under a minute: four kinds, one room each, 3%, four seeds
    #[arg(long)]
    quick: bool,
}

/// What every validation knows.
pub struct CommonArguments<'a> {
    /// Whether neither cases nor options of theirs are asked for beside.
    pub is_alone: bool,
    /// Directory for the report.
    pub out: &'a Path,
    /// Runs.
    pub seeds: Option<u64>,
    /// No progress.
    pub quiet: bool,
}

impl ProvingGroundArguments {
    /// An option that was given, if one was.
    pub fn named(&self) -> Option<&'static str> {
        let given = [
            (!self.kinds.is_empty(), "--kinds"),
            (self.rooms.is_some(), "--rooms"),
            (!self.targets.is_empty(), "--targets"),
            (self.reference_error.is_some(), "--reference-error"),
            (self.reference_time.is_some(), "--reference-time"),
            (self.references.is_some(), "--references"),
            (self.rival.is_some(), "--rival"),
            (self.rival_paths.is_some(), "--rival-paths"),
            (self.patience.is_some(), "--patience"),
            (self.quick, "--quick"),
        ];
        given.into_iter().find(|(is_given, _)| *is_given).map(|(_, name)| name)
    }

    fn settings(&self, common: &CommonArguments) -> Result<ProofSettings, Failure> {
        let names: Vec<&str> = match (self.kinds.is_empty(), self.quick) {
            (false, _) => self.kinds.iter().map(|name| name.trim()).collect(),
            (true, true) => QUICK_KINDS.to_vec(),
            (true, false) => KINDS.iter().map(|kind| kind.name).collect(),
        };
        let kinds = names.into_iter().map(kind_named).collect::<Result<Vec<_>, _>>()?;
        let targets = match (self.targets.is_empty(), self.quick) {
            (false, _) => self.targets.clone(),
            (true, true) => QUICK_TARGETS.to_vec(),
            (true, false) => TARGETS.to_vec(),
        };
        let smallest = targets.iter().copied().fold(f64::INFINITY, f64::min);
        let reference = ReferenceSettings {
            target_error: self.reference_error.unwrap_or(REFERENCE_SHARE * smallest),
            limit_s: self.reference_time.unwrap_or(if self.quick { QUICK_REFERENCE_S } else { REFERENCE_S }),
        };
        if let Some(program) = self.rival.as_ref().filter(|program| !program.is_file()) {
            return Err(Failure::Usage {
                what: "no such program".to_owned(),
                got: format!("--rival {}", program.display()),
                expected: "the path of a program that can be run".to_owned(),
                remedy: "correct the path, or leave --rival out".to_owned(),
            });
        }
        Ok(ProofSettings {
            kinds,
            rooms: self.rooms.unwrap_or(if self.quick { QUICK_ROOMS } else { ROOMS }),
            seeds: common.seeds.unwrap_or(if self.quick { QUICK_SEEDS } else { SEEDS }),
            targets,
            reference,
            references: self.references.clone().unwrap_or_else(|| common.out.join("references")),
            rival: self.rival.clone().map(|program| Rival { program, paths: self.rival_paths.unwrap_or(RIVAL_PATHS) }),
            patience_s: self.patience.unwrap_or(PATIENCE_S),
            threads: rayon::current_num_threads(),
        })
    }
}

fn kind_named(name: &str) -> Result<&'static Kind, Failure> {
    kind_of(name).ok_or_else(|| Failure::Usage {
        what: "no such kind of room".to_owned(),
        got: format!("--kinds {name}"),
        expected: KINDS.iter().map(|kind| kind.name).collect::<Vec<_>>().join(", "),
        remedy: "name some of those with commas between; luxmc new room --kind list tells what they are".to_owned(),
    })
}

/// Refuses an option where no proving ground is asked for.
pub fn refuse(option: &str) -> Failure {
    Failure::Usage {
        what: "an option of the proving ground".to_owned(),
        got: option.to_owned(),
        expected: format!("luxmc validate {PROVING_GROUND} {option} … --out DIR"),
        remedy: format!("leave out {option}, or name {PROVING_GROUND}"),
    }
}

/// Proves.
pub fn run(arguments: &ProvingGroundArguments, common: &CommonArguments) -> Outcome {
    if !common.is_alone {
        return Err(Failure::Usage {
            what: "the proving ground has rooms, methods and targets of its own".to_owned(),
            got: format!(
                "{PROVING_GROUND} beside cases, or with --cases, --method, --target-error or --collision-only"
            ),
            expected: format!("luxmc validate {PROVING_GROUND} [--kinds KINDS] [--targets ERRORS] --out DIR"),
            remedy: "leave those out; run cases and proving ground one after the other".to_owned(),
        });
    }
    let settings = arguments.settings(common)?;
    let mut directory = ResultDirectory::open(common.out)?;
    let tell = |line: &str| {
        if !common.quiet {
            console::message(line)
        }
    };
    let unix_s = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |since| since.as_secs());
    let proof = prove(&settings, &tell)?;

    let file = |name: &str, text: String| ResultFile { name: name.to_owned(), bytes: text.into_bytes() };
    directory.stage(&file("proving-ground.csv", proof_csv(&proof, &settings)))?;
    for (name, picture) in proof_pictures(&proof, &settings) {
        directory.stage(&file(name, picture))?;
    }
    directory.stage(&file("proving-ground.md", proof_md(&proof, &settings, unix_s)))?;
    directory.stage(&file("proving-ground.html", proof_html(&proof, &settings, unix_s)))?;
    directory.commit()?;

    let table = proof_table(&proof, &settings);
    console::result(&text_table(&table.header, &table.text_columns, table.rows))?;
    tell(&format!("report in {}", common.out.join("proving-ground.html").display()));
    let failures = failures(&proof);
    if failures.is_empty() {
        return Ok(Exit::Done);
    }
    console::message(&format!("failed: {}", failures.join("; ")));
    Ok(Exit::CaseFailed)
}
