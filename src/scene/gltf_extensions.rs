//! Extensions of glTF: which ones are ignored because they do not affect shapes, which are read, and which make a file unreadable.

use std::path::Path;

use gltf::json::Root;
use gltf::json::extensions::ENABLED_EXTENSIONS;

use super::error::SceneError;

/// Positions as whole numbers.
const QUANTIZATION: &str = "KHR_mesh_quantization";
/// Extensions that are read. For each of them the reader takes all that concerns light.
const READ: [&str; 3] = [QUANTIZATION, "KHR_materials_pbrSpecularGlossiness", "KHR_materials_transmission"];
/// Prefixes of extensions for the appearance of surfaces: shaders, materials, textures and how these are stored.
const APPEARANCE: [&str; 8] = [
    "KHR_materials_",
    "KHR_texture_",
    "KHR_techniques_",
    "EXT_materials_",
    "EXT_texture_",
    "MSFT_texture_",
    "ADOBE_materials_",
    "MSFT_packing_",
];
/// Notes on a model and its parts, and image-based lights.
const NOTES: [&str; 8] = [
    "KHR_xmp",
    "KHR_xmp_json_ld",
    "KHR_animation_pointer",
    "EXT_mesh_features",
    "EXT_instance_features",
    "EXT_structural_metadata",
    "EXT_lights_image_based",
    "KHR_audio_emitter",
];
/// Lamps. A file that requires them still has its shapes, and a warning says that the lamps were ignored.
const LAMPS: &str = "KHR_lights_punctual";
/// Compressed numbers of meshes.
const PACKED: [&str; 3] = ["KHR_draco_mesh_compression", "EXT_meshopt_compression", "KHR_meshopt_compression"];
/// Extensions that place or light something. A file may use them without listing them as required.
const OF_CONSEQUENCE: [&str; 5] =
    ["EXT_mesh_gpu_instancing", LAMPS, "KHR_node_visibility", "EXT_lights_ies", "EXT_lights_image_based"];

fn may_be_passed_over(name: &str) -> bool {
    let is_known = [QUANTIZATION, LAMPS].contains(&name) || NOTES.contains(&name);
    is_known || APPEARANCE.iter().any(|beginning| name.starts_with(beginning)) || ENABLED_EXTENSIONS.contains(&name)
}

/// Removes the ignorable extensions from the list of extensions that a file requires.
///
/// # Errors
///
/// Files that require other extensions.
pub(super) fn refuse_unread(path: &Path, root: &mut Root) -> Result<(), SceneError> {
    root.extensions_required.retain(|name| !may_be_passed_over(name));
    match root.extensions_required.first() {
        Some(name) if PACKED.contains(&name.as_str()) => Err(packed(path, name)),
        Some(name) => {
            let what = "the glTF file needs an extension that is not supported".to_owned();
            let remedy = "export the model again without this extension";
            Err(SceneError::of_file(path, what, format!("{name:?}"), "plain glTF 2.0", remedy))
        }
        None => Ok(()),
    }
}

/// Returns the refusal of a file with compressed numbers, if it is one. A file may use the compression without requiring it. Its
/// accessors then have no data.
pub(super) fn is_packed(path: &Path, root: &Root) -> Option<SceneError> {
    let name = root.extensions_used.iter().find(|name| PACKED.contains(&name.as_str()))?;
    let lacks_numbers = |accessor: &gltf::json::Accessor| accessor.buffer_view.is_none() && accessor.sparse.is_none();
    root.accessors.iter().any(lacks_numbers).then(|| packed(path, name))
}

fn packed(path: &Path, name: &str) -> SceneError {
    let remedy = "export the model again without compression of meshes, or unpack it with a tool for glTF files";
    let what = "the meshes of the glTF file are compressed in a way that is not supported".to_owned();
    SceneError::of_file(path, what, format!("{name:?}"), "plain glTF 2.0, or KHR_mesh_quantization", remedy)
}

/// Extensions in use that affect the scene and are ignored: those known to affect it, and all unknown ones.
pub(super) fn passed_over(document: &gltf::Document) -> impl Iterator<Item = &str> {
    document.extensions_used().filter(|name| has_a_part(name))
}

/// The other extensions in use that are not read, or not completely: they describe appearance, or are notes.
pub(super) fn not_needed(document: &gltf::Document) -> impl Iterator<Item = &str> {
    document.extensions_used().filter(|name| !has_a_part(name) && !READ.contains(name))
}

fn has_a_part(name: &str) -> bool {
    OF_CONSEQUENCE.contains(&name) || !may_be_passed_over(name)
}
