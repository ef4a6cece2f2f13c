//! `luxmc convert`: turns another program's model into a scene for editing.

use std::path::{Component, Path, PathBuf};

use clap::Args;
use serde_json::Value;

use super::exit::{Exit, Failure};
use super::number_text::plain;
use super::text_table::text_table;
use super::{Outcome, console};
use crate::check::{BURIED, scene_from_json};
use crate::output::{ResultFile, write_files};
use crate::scene::{ProposedMaterial, STAND_IN, allow_large_files, is_radiance, propose_radiance_scene, propose_scene};

/// Long help text of the command.
pub const ABOUT: &str = "\
Makes a scene file from a model (OBJ, glTF, GLB, STL, PLY, or Radiance's .rad), to be edited. Meshes stay in their file, to which the scene
refers; Radiance's surfaces, materials and lights become keys of the scene, and sensor grids (.pts) its receivers. The list of materials on
standard output shows where each reflectance comes from and what is not known about it; warnings name what was not read.";

const EXAMPLES: &str = "\
Examples:
  luxmc convert office.glb --out office.json
  luxmc convert scene/*.mat scene/*.rad grid/*.pts --out room.json     files of Radiance, as honeybee writes them, are one scene
  luxmc inspect office.json                       then edit materials and luminaires, and check";

/// Arguments of `luxmc convert`.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct ConvertArguments {
    /// Model to read: one file, or several Radiance files (.mat, .rad) that form one scene; sensor grids (.pts) become receivers
    #[arg(value_name = "MODEL", required = true)]
    models: Vec<PathBuf>,
    /// Scene file to write
    #[arg(long, value_name = "SCENE")]
    out: PathBuf,
    /// Overwrite an existing scene file
    #[arg(long)]
    overwrite: bool,
    /// Read files of any size; without this option, files above 512 MiB are refused as probable mistakes
    #[arg(long)]
    allow_large: bool,
}

/// Writes the scene and prints its materials.
pub fn run(arguments: &ConvertArguments) -> Outcome {
    if arguments.allow_large {
        allow_large_files();
    }
    let out = &arguments.out;
    let name = out.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
    if out.exists() && !arguments.overwrite {
        return Err(Failure::Usage {
            what: "the scene file exists already".to_owned(),
            got: format!("--out {}", out.display()),
            expected: "a name that is not in use".to_owned(),
            remedy: "name another file, or add --overwrite".to_owned(),
        });
    }
    let folder = out.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let (sensors, models): (Vec<&Path>, Vec<&Path>) =
        arguments.models.iter().map(PathBuf::as_path).partition(|file| has_ending(file, "pts"));
    let mut proposal = match models.as_slice() {
        [model] => propose_scene(model, &name_from(folder, model))?,
        models if !models.is_empty() && models.iter().all(|model| is_radiance(model)) => {
            propose_radiance_scene(models)?
        }
        _ => return Err(not_one_model(&models)),
    };
    proposal.receive_at(sensors.iter().map(|file| name_from(folder, file)));
    let named = models.iter().find(|model| !has_ending(model, "mat")).unwrap_or(&models[0]);
    let title = named.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default();
    let mut text = format!("{:#}\n", proposal.scene_file(&title));

    // Faults of the scene are reported at once. The file is written in any case, since the user will edit it.
    let mut checked = scene_from_json(&text, Some(out), folder);
    if let Ok(scene) = &mut checked {
        let is_reported = |warning: &String| warning.starts_with(&format!("{STAND_IN}: {BURIED}"));
        if let Some(place) = scene.warnings.iter().position(is_reported) {
            scene.warnings.remove(place);
            proposal.put_the_stand_in_beside();
            text = format!("{:#}\n", proposal.scene_file(&title));
        }
    }
    write_files(folder, &[ResultFile { name, bytes: text.into_bytes() }])?;

    console::result(&table(&proposal.materials))?;
    for warning in &proposal.warnings {
        console::message(&format!("warning: {warning}"));
    }
    match checked {
        Ok(scene) => scene.warnings.iter().for_each(|warning| console::message(&format!("warning: {warning}"))),
        Err(error) => {
            proposal.reader_warnings.iter().for_each(|warning| console::message(&format!("warning: {warning}")));
            console::message(&format!(
                "warning: the scene was written, but must be corrected before it can be solved: {error}"
            ));
        }
    }
    console::message(&format!("made {}\nnext:\n  luxmc inspect {}", out.display(), out.display()));
    Ok(Exit::Done)
}

fn has_ending(file: &Path, ending: &str) -> bool {
    file.extension().is_some_and(|own| own.eq_ignore_ascii_case(ending))
}

fn not_one_model(models: &[&Path]) -> Failure {
    let names: Vec<String> = models.iter().map(|model| model.display().to_string()).collect();
    Failure::Usage {
        what: "several files that do not form one scene".to_owned(),
        got: if names.is_empty() { "only sensor grids".to_owned() } else { names.join(" ") },
        expected: "one model, or only files of Radiance (.mat, .rad); with sensor grids (.pts) if wished".to_owned(),
        remedy: "convert each model by itself, and combine the geometries of the scene files".to_owned(),
    }
}

/// The model's name as a scene in a folder refers to it: relative to that folder, so that both can be moved together.
fn name_from(folder: &Path, model: &Path) -> String {
    let whole = |path: &Path| path.canonicalize().unwrap_or_else(|_| path.to_path_buf());
    let (folder, model) = (whole(folder), whole(model));
    let shared = folder.components().zip(model.components()).take_while(|(one, other)| one == other).count();
    // Without a shared folder (another drive), no relative path leads to the model.
    if shared <= 1 {
        return model.to_string_lossy().into_owned();
    }
    let up = folder.components().skip(shared).map(|_| Component::ParentDir);
    up.chain(model.components().skip(shared)).collect::<PathBuf>().to_string_lossy().into_owned()
}

fn table(materials: &[ProposedMaterial]) -> String {
    let rows = materials.iter().map(|material| {
        vec![material.name.clone(), material.surfaces.to_string(), words(&material.bsdf), material.known.clone()]
    });
    text_table(&["material", "faces", "in the scene", "known"], &[0, 2, 3], rows)
}

/// Describes a material's keys in one line.
fn words(bsdf: &Value) -> String {
    let Some(keys) = bsdf.as_object() else { return String::new() };
    let word = |(key, value): (&String, &Value)| match value {
        Value::String(text) => text.clone(),
        other => {
            format!("{} {}", key.replace('_', " "), other.as_f64().map_or(String::new(), |number| plain(number, 3)))
        }
    };
    keys.iter().map(word).collect::<Vec<String>>().join(", ")
}
