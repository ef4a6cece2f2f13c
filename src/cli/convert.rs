//! `luxmc convert`: a model of another program as a scene to be edited.

use std::path::{Path, PathBuf};

use clap::Args;
use serde_json::Value;

use super::exit::{Exit, Failure};
use super::number_text::plain;
use super::text_table::text_table;
use super::{Outcome, console};
use crate::check::scene_from_json;
use crate::output::{ResultFile, write_files};
use crate::scene::{ProposedMaterial, allow_large_files, propose_scene};

/// What the command does, at length.
pub const ABOUT: &str = "\
Makes a scene file of a model (OBJ, glTF, GLB, STL, PLY, or Radiance's .rad), to be edited. Meshes stay in their file, which the scene
names; Radiance's surfaces, materials and lights become keys of the scene. The list of materials on the standard output tells where each
reflectance comes from, and what is not known of it; warnings name what was not read.";

const EXAMPLES: &str = "\
Examples:
  luxmc convert office.glb --out office.json
  luxmc convert room.rad --out room.json          (cat materials.rad room.rad > all.rad where there are several)
  luxmc inspect office.json                       then edit materials and luminaires, and look";

/// Arguments of `luxmc convert`.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct ConvertArguments {
    /// Model to read
    model: PathBuf,
    /// Scene file to write
    #[arg(long, value_name = "SCENE")]
    out: PathBuf,
    /// Write over a scene file that is there already
    #[arg(long)]
    overwrite: bool,
    /// Read files of any size: above 512 MiB they are taken for a slip
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
            what: "the scene file is there already".to_owned(),
            got: format!("--out {}", out.display()),
            expected: "a name that is free".to_owned(),
            remedy: "name another file, or add --overwrite".to_owned(),
        });
    }
    let folder = out.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let proposal = propose_scene(&arguments.model, &name_from(folder, &arguments.model))?;
    let title = arguments.model.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default();
    let text = format!("{:#}\n", proposal.scene_file(&title));
    write_files(folder, &[ResultFile { name, bytes: text.clone().into_bytes() }])?;

    console::result(&table(&proposal.materials))?;
    for warning in &proposal.warnings {
        console::message(&format!("warning: {warning}"));
    }
    // What the scene lacks is told at once; it is there to be edited in any case.
    match scene_from_json(&text, Some(out), folder) {
        Ok(scene) => scene.warnings.iter().for_each(|warning| console::message(&format!("warning: {warning}"))),
        Err(error) => console::message(&format!(
            "warning: the scene was written, and is to be mended before it is solved: {error}"
        )),
    }
    Ok(Exit::Done)
}

/// The model's name as a scene in a folder has it: relative where it lies in or below it.
fn name_from(folder: &Path, model: &Path) -> String {
    let whole = |path: &Path| path.canonicalize().unwrap_or_else(|_| path.to_path_buf());
    let model = whole(model);
    model.strip_prefix(whole(folder)).unwrap_or(&model).to_string_lossy().into_owned()
}

fn table(materials: &[ProposedMaterial]) -> String {
    let rows = materials.iter().map(|material| {
        vec![material.name.clone(), material.surfaces.to_string(), words(&material.law), material.known.clone()]
    });
    text_table(&["material", "surfaces", "in the scene", "known"], &[0, 2, 3], rows)
}

/// A material's keys in a line.
fn words(law: &Value) -> String {
    let Some(keys) = law.as_object() else { return String::new() };
    let word = |(key, value): (&String, &Value)| match value {
        Value::String(text) => text.clone(),
        other => {
            format!("{} {}", key.replace('_', " "), other.as_f64().map_or(String::new(), |number| plain(number, 3)))
        }
    };
    keys.iter().map(word).collect::<Vec<String>>().join(", ")
}
