//! Turns a model of another program into a scene for editing: its geometry, and materials with what is known and unknown about them.

use std::collections::HashMap;
use std::path::Path;

use glam::DVec3;
use serde_json::{Map, Value, json};

use super::error::SceneError;
use super::gltf::{self, Appearance};
use super::mesh_builder::UNNAMED_PART;
use super::mesh_file::{MeshContent, MeshFile};
use super::proposed::{Proposal, ProposedMaterial, UNKNOWN_REFLECTANCE};
use super::reader::Source;
use super::units::LengthUnit;
use super::{not_read, parse, radiance_scene};

/// Largest reflectance taken from a colour. Even the whitest paints reflect no more.
const WHITEST: f64 = 0.9;

/// Ending of Radiance's scenes, and ending of files with materials alone. The latter are read first.
const RADIANCE: [&str; 2] = ["rad", "mat"];

/// Whether a file is a Radiance file. Several of them may make one scene.
pub fn is_radiance(model: &Path) -> bool {
    RADIANCE.contains(&ending_of(model).as_str())
}

fn ending_of(model: &Path) -> String {
    model.extension().map(|ending| ending.to_string_lossy().to_lowercase()).unwrap_or_default()
}

/// Proposes a scene for a model: OBJ, glTF, STL, PLY or Radiance. `named` is the model's name in the scene file.
///
/// # Errors
///
/// Files that cannot be read or are damaged, and those without a surface.
pub fn propose_scene(model: &Path, named: &str) -> Result<Proposal, SceneError> {
    if is_radiance(model) {
        return propose_radiance_scene(&[model]);
    }
    let mut proposal = of_mesh(model, named, &ending_of(model))?;
    proposal.let_a_lamp_stand_in();
    Ok(proposal)
}

/// Proposes a scene for several Radiance files, which are read as one. Files with materials come first, the others in the given order.
///
/// # Errors
///
/// As [`propose_scene`].
pub fn propose_radiance_scene(models: &[&Path]) -> Result<Proposal, SceneError> {
    let mut models = models.to_vec();
    models.sort_by_key(|model| ending_of(model) != RADIANCE[1]);
    let read = |model: &&Path| parse::read_text(model, "the Radiance file");
    let texts: Vec<String> = models.iter().map(read).collect::<Result<_, _>>()?;
    let sources: Vec<Source> = models.iter().zip(&texts).map(|(path, text)| Source { text, path }).collect();
    let mut proposal = radiance_scene::propose(&sources)?;
    proposal.bounds_m = bounds(proposal.geometry.iter().flat_map(places_of));
    if proposal.luminaires.is_empty() {
        proposal.let_a_lamp_stand_in();
    }
    Ok(proposal)
}

fn of_mesh(model: &Path, named: &str, ending: &str) -> Result<Proposal, SceneError> {
    let (mut warnings, mut reader_warnings) = (Vec::new(), Vec::new());
    let mut file = MeshFile::open(model)?;
    let shape = file.shape(LengthUnit::of(0), &mut reader_warnings)?;
    let (appearances, not_read) = match &file.content {
        MeshContent::Gltf(bytes) => {
            let document = gltf::description(model, bytes)?;
            (gltf::appearances(&document), not_read::of_gltf(&document))
        }
        MeshContent::Stl(bytes) => (HashMap::new(), not_read::of_stl(bytes)),
        MeshContent::Ply(bytes) => (HashMap::new(), not_read::of_ply(bytes)),
        MeshContent::Obj(text) => (HashMap::new(), not_read::of_obj(text)),
    };
    if !not_read.is_empty() {
        warnings.push(format!("not read: {}", not_read.join(", ")));
    }
    if !matches!(file.content, MeshContent::Gltf(_)) {
        warnings.push("the file does not state the unit of its lengths: metres are assumed (length_unit)".to_owned());
    }
    let is_one = shape.parts.len() == 1 && shape.parts[0].name.is_none();
    let (mut bsdfs, mut materials, mut by_part) = (Map::new(), Vec::new(), Map::new());
    for part in &shape.parts {
        let name = match &part.name {
            Some(name) => name.clone(),
            None if is_one => "surface".to_owned(),
            None => UNNAMED_PART.to_owned(),
        };
        let (bsdf, known) = proposed(appearances.get(&name), ending);
        bsdfs.insert(name.clone(), bsdf.clone());
        by_part.insert(name.clone(), json!(name));
        materials.push(ProposedMaterial { name, surfaces: part.triangles.len(), bsdf, known });
    }
    let stem = model.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default();
    let name = if stem.trim().is_empty() { "model".to_owned() } else { stem };
    let mut geometry = json!({ "name": name, "type": "mesh", "file": named });
    if is_one {
        geometry["material"] = json!("surface");
    } else {
        geometry["materials"] = Value::Object(by_part);
    }
    let bounds_m = bounds(shape.vertices.iter().copied());
    let geometry = vec![geometry];
    Ok(Proposal { materials, bsdfs, geometry, warnings, reader_warnings, bounds_m, ..Proposal::default() })
}

/// Estimates the reflection of a material from its appearance. Returns the material for the scene file, and what is known about it.
fn proposed(appearance: Option<&Appearance>, ending: &str) -> (Value, String) {
    let diffuse = |reflectance: f64| json!({ "type": "diffuse", "reflectance": reflectance });
    let Some(appearance) = appearance else {
        let why = match ending {
            "gltf" | "glb" => "the model does not describe it",
            "stl" | "ply" => "this file format does not describe materials",
            _ => "material files (mtllib) are not read",
        };
        return (diffuse(UNKNOWN_REFLECTANCE), format!("not known: {why}"));
    };
    // Weights of Rec. 709, whose colours glTF uses.
    let [red, green, blue] = appearance.base_color;
    let luminance = 0.2126 * red + 0.7152 * green + 0.0722 * blue;
    let expected = if appearance.has_texture { UNKNOWN_REFLECTANCE * luminance } else { luminance };
    let reflectance = (1e3 * expected.clamp(0.0, WHITEST)).round() / 1e3;
    let mut known = vec![match appearance.has_texture {
        true => format!(
            "not known: its texture is not read; {UNKNOWN_REFLECTANCE} is assumed for it (base colour: {luminance:.3})"
        ),
        false => format!("from the base colour, which is made for display: {luminance:.3}"),
    }];
    let mut note = |is_so: bool, what: &str| {
        if is_so {
            known.push(what.to_owned());
        }
    };
    note(expected > WHITEST, "whiter than any paint, so a lower value is used");
    note(appearance.is_metal, "a metal: perhaps phong or mirror");
    note(appearance.is_transparent, "transparent: perhaps glass or translucent");
    note(appearance.is_emissive, "emits light in the model: make it an area luminaire");
    (diffuse(reflectance), known.join("; "))
}

fn bounds(places: impl Iterator<Item = DVec3> + Clone) -> [DVec3; 2] {
    [DVec3::min as fn(DVec3, DVec3) -> DVec3, DVec3::max].map(|pick| places.clone().reduce(pick).unwrap_or(DVec3::ZERO))
}

/// Vertices of a mesh in the scene file, or the centre of a sphere.
fn places_of(geometry: &Value) -> impl Iterator<Item = DVec3> + Clone {
    let point = |value: &Value| {
        let number = |axis: usize| value[axis].as_f64().unwrap_or(0.0);
        DVec3::new(number(0), number(1), number(2))
    };
    let vertices = geometry["vertices"].as_array().map(Vec::as_slice).unwrap_or_default().iter().map(point);
    vertices.chain(geometry.get("center").map(point))
}
