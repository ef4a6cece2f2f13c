//! `luxmc new`: a starting project that runs as it is.

use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};

use super::exit::{Exit, Failure};
use super::new_hall::hall_obj;
use super::{Outcome, console};
use crate::output::{ResultFile, write_files};

const EXAMPLES: &str = "\
Examples:
  luxmc new office --out my-office
  luxmc solve my-office/office.json --out my-office/results

Files that are there already are never overwritten.";

/// Arguments of `luxmc new`.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct NewArguments {
    /// What to start from
    #[arg(value_enum)]
    kind: Kind,
    /// Directory for the project; made where missing
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
}

/// The projects that there are.
#[derive(Clone, Copy, Debug, ValueEnum)]
enum Kind {
    /// An open-plan office with desks, a partition, six troffers and two downlights
    Office,
    /// A corridor with a glass door, a polished floor and four wall washers
    Corridor,
    /// A storage hall with racks and 120 luminaires
    Hall,
}

/// A file of a project: its path in the project's directory and its text.
type Template = (&'static str, &'static str);

const OFFICE: &[Template] = &[
    ("office.json", include_str!("../../scenes/office.json")),
    ("desks.obj", include_str!("../../scenes/desks.obj")),
    ("luminaires/downlight.ldt", include_str!("../../scenes/luminaires/downlight.ldt")),
    ("README.txt", include_str!("projects/office.txt")),
];
const CORRIDOR: &[Template] = &[
    ("corridor.json", include_str!("../../scenes/corridor.json")),
    ("luminaires/wall_washer.ldt", include_str!("../../scenes/luminaires/wall_washer.ldt")),
    ("README.txt", include_str!("projects/corridor.txt")),
];
const HALL: &[Template] = &[
    ("hall.json", include_str!("../../scenes/hall.json")),
    ("luminaires/troffer.ies", include_str!("../../scenes/luminaires/troffer.ies")),
    ("README.txt", include_str!("projects/hall.txt")),
];
/// What every project's README ends with.
const KEYS: &str = include_str!("projects/keys.txt");

/// Writes a project.
pub fn run(arguments: &NewArguments) -> Outcome {
    let templates = match arguments.kind {
        Kind::Office => OFFICE,
        Kind::Corridor => CORRIDOR,
        Kind::Hall => HALL,
    };
    let mut files: Vec<(&str, Vec<u8>)> = templates
        .iter()
        .map(|(path, text)| {
            let text = if *path == "README.txt" { format!("{text}\n{KEYS}") } else { (*text).to_owned() };
            (*path, text.into_bytes())
        })
        .collect();
    if matches!(arguments.kind, Kind::Hall) {
        files.push(("hall.obj", hall_obj().into_bytes()));
    }
    for (path, _) in &files {
        let target = arguments.out.join(path);
        if target.exists() {
            return Err(Failure::Usage {
                what: "a file of the project is there already".to_owned(),
                got: target.display().to_string(),
                expected: "a directory without files of these names".to_owned(),
                remedy: "name another directory with --out".to_owned(),
            });
        }
    }
    for (path, bytes) in files {
        let path = Path::new(path);
        let folder = path.parent().map_or_else(|| arguments.out.clone(), |parent| arguments.out.join(parent));
        let name = path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
        write_files(&folder, &[ResultFile { name, bytes }])?;
    }
    let scene = arguments.out.join(templates[0].0);
    console::message(&format!(
        "made {}\nnext:\n  luxmc inspect {}\n  luxmc solve {} --out {}",
        arguments.out.display(),
        scene.display(),
        scene.display(),
        arguments.out.join("results").display()
    ));
    Ok(Exit::Done)
}
