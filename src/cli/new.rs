//! `luxmc new`: writes a starting project that runs as it is.

use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};

use super::exit::{Exit, Failure};
use super::new_hall::hall_obj;
use super::new_harmonics::{USUAL_DEGREE, fitted_body};
use super::text_table::text_table;
use super::{Outcome, console, values};
use crate::output::{ResultFile, write_files};
use crate::scene::type_names;
use crate::validation::proving_ground::rooms::{KINDS, SCENE_FILE, kind_of};

const EXAMPLES: &str = "\
Examples:
  luxmc new office --out my-office
  luxmc solve my-office/office.json --out my-office/results
  luxmc new harmonics head.obj --degree 7 --out head   a smooth body fitted to a mesh
  luxmc new room --kind list                       kinds of made-up rooms
  luxmc new room --kind attic --seed 3 --out attic one of them, to try things on

Existing files are never overwritten.";

/// Arguments of `luxmc new`.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct NewArguments {
    /// What to start from
    #[arg(value_enum)]
    project: NewProject,
    /// The mesh, for harmonics: a closed OBJ, glTF, STL or PLY in m
    #[arg(value_name = "MESH")]
    mesh: Option<PathBuf>,
    /// Degree of the series, for harmonics [default: 7]
    #[arg(long, value_name = "L")]
    degree: Option<usize>,
    /// Directory for the project; created if missing [default for rooms: KIND-SEED]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Kind of room, for rooms; "list" shows all kinds
    #[arg(long, value_name = "KIND")]
    kind: Option<String>,
    /// Seed of the room, for rooms: another seed is another room of its kind [default: 0]
    #[arg(long, value_name = "N", value_parser = values::seed)]
    seed: Option<u64>,
}

/// The projects that there are.
#[derive(Clone, Copy, Debug, ValueEnum)]
enum NewProject {
    /// An open-plan office with desks, a partition, twelve troffers and the requirements of the standard
    Office,
    /// A corridor with a glass door, a polished floor, four wall washers and the requirements of the standard
    Corridor,
    /// A classroom with a board, desks and the requirements of the standard
    Classroom,
    /// A school's gymnasium with 24 luminaires and its requirements
    Gym,
    /// A storage hall with racks and 120 luminaires
    Hall,
    /// A made-up room of the proving ground, by kind and seed
    Room,
    /// A smooth body of spherical harmonics, fitted to a star-shaped mesh
    Harmonics,
}

/// A file of a project: its path in the project's directory and its text.
type Template = (&'static str, &'static str);

const OFFICE: &[Template] = &[
    ("office.json", include_str!("projects/office.json")),
    ("desks.obj", include_str!("../../scenes/desks.obj")),
    ("luminaires/troffer.ies", include_str!("../../scenes/luminaires/troffer.ies")),
    ("README.txt", include_str!("projects/office.txt")),
];
const CORRIDOR: &[Template] = &[
    ("corridor.json", include_str!("projects/corridor.json")),
    ("luminaires/wall_washer.ldt", include_str!("../../scenes/luminaires/wall_washer.ldt")),
    ("README.txt", include_str!("projects/corridor.txt")),
];
const CLASSROOM: &[Template] = &[
    ("classroom.json", include_str!("projects/classroom.json")),
    ("classroom_desks.obj", include_str!("../../scenes/classroom_desks.obj")),
    ("luminaires/troffer.ies", include_str!("../../scenes/luminaires/troffer.ies")),
    ("luminaires/wall_washer.ldt", include_str!("../../scenes/luminaires/wall_washer.ldt")),
    ("README.txt", include_str!("projects/classroom.txt")),
];
const GYM: &[Template] = &[
    ("gym.json", include_str!("../../scenes/gym.json")),
    ("luminaires/high_bay.ies", include_str!("../../scenes/luminaires/high_bay.ies")),
    ("README.txt", include_str!("projects/gym.txt")),
];
const HALL: &[Template] = &[
    ("hall.json", include_str!("../../scenes/hall.json")),
    ("luminaires/troffer.ies", include_str!("../../scenes/luminaires/troffer.ies")),
    ("README.txt", include_str!("projects/hall.txt")),
];
/// The text at the end of every project's README. It names types by {key}.
const KEYS: &str = include_str!("projects/keys.txt");

/// A file to be written: its path in the project's directory and its content.
type FileToWrite = (String, Vec<u8>);

/// Writes a project.
pub fn run(arguments: &NewArguments) -> Outcome {
    let templates = match arguments.project {
        NewProject::Office => OFFICE,
        NewProject::Corridor => CORRIDOR,
        NewProject::Classroom => CLASSROOM,
        NewProject::Gym => GYM,
        NewProject::Hall => HALL,
        NewProject::Room => return run_room(arguments),
        NewProject::Harmonics => return run_harmonics(arguments),
    };
    let of_a_fit = arguments.mesh.as_ref().map(|_| "MESH").or(arguments.degree.map(|_| "--degree"));
    if let Some(option) = of_a_fit {
        return Err(Failure::Usage {
            what: "a mesh and a degree apply to harmonics only".to_owned(),
            got: option.to_owned(),
            expected: "luxmc new harmonics MESH --degree L --out DIR".to_owned(),
            remedy: format!("leave out {option}, or fit a body"),
        });
    }
    if let Some(option) = arguments.kind.as_ref().map(|_| "--kind").or(arguments.seed.map(|_| "--seed")) {
        return Err(Failure::Usage {
            what: "a kind and a seed apply to rooms only".to_owned(),
            got: option.to_owned(),
            expected: "luxmc new room --kind KIND --seed N".to_owned(),
            remedy: format!("leave out {option}, or make a room"),
        });
    }
    let Some(out) = &arguments.out else {
        return Err(Failure::Usage {
            what: "a project needs a directory".to_owned(),
            got: "no --out".to_owned(),
            expected: "--out DIR".to_owned(),
            remedy: "name a directory with --out; it is created if missing".to_owned(),
        });
    };
    let mut files: Vec<FileToWrite> = templates
        .iter()
        .map(|(path, text)| {
            let text = if *path == "README.txt" { format!("{text}\n{}", notes_on_keys()) } else { (*text).to_owned() };
            ((*path).to_owned(), text.into_bytes())
        })
        .collect();
    if matches!(arguments.project, NewProject::Hall) {
        files.push(("hall.obj".to_owned(), hall_obj().into_bytes()));
    }
    write_project(out, files)
}

/// The notes on a scene's keys, with the names of all types.
fn notes_on_keys() -> String {
    type_names()
        .iter()
        .fold(KEYS.to_owned(), |notes, (key, names)| notes.replace(&format!("{{{key}}}"), &names.join(", ")))
}

/// The value of `--kind` that lists all kinds of rooms.
const LIST: &str = "list";

/// Writes a room of the proving ground, or lists its kinds.
fn run_room(arguments: &NewArguments) -> Outcome {
    let name = arguments.kind.as_deref().unwrap_or_default();
    if name == LIST {
        let rows = KINDS.iter().map(|kind| vec![kind.name.to_owned(), kind.what.to_owned()]);
        console::result(&text_table(&["kind", "what"], &[0, 1], rows))?;
        return Ok(Exit::Done);
    }
    let Some(kind) = kind_of(name) else {
        return Err(Failure::Usage {
            what: if name.is_empty() { "a room needs a kind" } else { "no such kind of room" }.to_owned(),
            got: if name.is_empty() { "no --kind".to_owned() } else { format!("--kind {name}") },
            expected: KINDS.iter().map(|kind| kind.name).collect::<Vec<_>>().join(", "),
            remedy: "name one of those; --kind list explains them".to_owned(),
        });
    };
    let room = kind.room(arguments.seed.unwrap_or(0));
    let out = arguments.out.clone().unwrap_or_else(|| PathBuf::from(room.name()));
    let mut files = vec![(SCENE_FILE.to_owned(), room.scene.into_bytes())];
    files.extend(room.files.into_iter().map(|file| (file.name, file.text.into_bytes())));
    write_project(&out, files)
}

/// Fits a body to a mesh, reports the quality of the fit, and writes the body with a scene around it.
fn run_harmonics(arguments: &NewArguments) -> Outcome {
    let (Some(mesh), Some(out)) = (&arguments.mesh, &arguments.out) else {
        return Err(Failure::Usage {
            what: "a body needs a mesh and a directory".to_owned(),
            got: if arguments.mesh.is_none() { "no MESH" } else { "no --out" }.to_owned(),
            expected: "luxmc new harmonics MESH --degree L --out DIR".to_owned(),
            remedy: "name both".to_owned(),
        });
    };
    let body = fitted_body(mesh, arguments.degree.unwrap_or(USUAL_DEGREE))?;
    let outcome = write_project(out, body.files)?;
    console::result(&body.description)?;
    Ok(outcome)
}

/// Writes the files of a project, the scene first, if none of them exists yet.
fn write_project(out: &Path, files: Vec<FileToWrite>) -> Outcome {
    for (path, _) in &files {
        let target = out.join(path);
        if target.exists() {
            return Err(Failure::Usage {
                what: "a file of the project exists already".to_owned(),
                got: target.display().to_string(),
                expected: "a directory without files of these names".to_owned(),
                remedy: "name another directory with --out".to_owned(),
            });
        }
    }
    let scene = out.join(&files[0].0);
    for (path, bytes) in files {
        let path = Path::new(&path);
        let folder = path.parent().map_or_else(|| out.to_path_buf(), |parent| out.join(parent));
        let name = path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
        write_files(&folder, &[ResultFile { name, bytes }])?;
    }
    console::message(&format!(
        "made {}\nnext:\n  luxmc inspect {}\n  luxmc solve {} --out {}",
        out.display(),
        scene.display(),
        scene.display(),
        out.join("results").display()
    ));
    Ok(Exit::Done)
}

#[cfg(test)]
mod tests {
    use super::{notes_on_keys, type_names};

    /// The notes on keys name the types of materials and luminaires, each in its line, and leave no name open.
    #[test]
    fn notes_of_a_project_name_all_types() {
        let notes = notes_on_keys();
        let line = |key: &str| notes.lines().find(|line| line.trim_start().starts_with(key)).unwrap_or_default();
        for (key, names) in type_names() {
            for name in names {
                assert!(line(key).contains(name), "{key}: {name}");
            }
        }
        assert!(line("materials").contains("of the types diffuse, phong, "), "{notes}");
        assert!(line("luminaires").contains("photometric") && !line("luminaires").contains("blinn"), "{notes}");
        assert!(!line("materials").contains("velvet"), "the line is read");
        assert!(!notes.contains(['{', '}']), "{notes}");
    }
}
