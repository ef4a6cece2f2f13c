//! Content of model files that no reader uses. `luxmc convert` lists it.

use std::collections::{BTreeMap, BTreeSet};

use gltf::{Document, Semantic};
use ply_rs_bw::parser::{Parser, Reader};
use ply_rs_bw::ply::DefaultElement;

use super::{gltf_extensions, obj, ply, stl};

/// Lists cameras, textures, attributes of vertices besides positions, and extensions that describe appearance or are notes.
pub(super) fn of_gltf(document: &Document) -> Vec<String> {
    let mut attributes = BTreeSet::new();
    for primitive in document.meshes().flat_map(|mesh| mesh.primitives()) {
        let beside = primitive.attributes().map(|(semantic, _)| semantic).filter(|kind| *kind != Semantic::Positions);
        attributes.extend(beside.map(|semantic| semantic.to_string()));
    }
    let counted = [("cameras", document.cameras().len()), ("textures", document.textures().len())];
    let counted = counted.into_iter().filter(|(_, count)| *count > 0).map(|(what, count)| format!("{count} {what}"));
    let extensions = gltf_extensions::not_needed(document).map(str::to_owned);
    counted.chain(attributes.into_iter().map(|name| format!("{name} of vertices"))).chain(extensions).collect()
}

/// Lists the statements of an OBJ file about appearance and names, and its files of materials.
pub(super) fn of_obj(text: &str) -> Vec<String> {
    let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
    let mut files = BTreeSet::new();
    for line in text.lines() {
        let (word, rest) = line.trim_start().split_once(char::is_whitespace).unwrap_or((line.trim(), ""));
        if word == obj::MATERIALS_FILE {
            files.insert(rest.trim());
        } else if obj::PASSED_OVER.contains(&word) {
            *counts.entry(word).or_default() += 1;
        }
    }
    let files = files.into_iter().map(|file| format!("the materials of {file:?}"));
    files.chain(counts.into_iter().map(|(word, count)| format!("{count} statements {word:?}"))).collect()
}

/// Lists the properties of vertices and faces of a PLY file besides positions and corners.
pub(super) fn of_ply(bytes: &[u8]) -> Vec<String> {
    let Ok(header) = Parser::<DefaultElement>::new().read_header(&mut Reader::new(bytes)) else { return Vec::new() };
    let beside = |element: &str, read: &[&str], of: &str| {
        let properties = header.elements.get(element).into_iter().flat_map(|element| element.properties.keys());
        let names: Vec<&str> = properties.map(String::as_str).filter(|name| !read.contains(name)).collect();
        (!names.is_empty()).then(|| format!("{} of {of}", names.join(", ")))
    };
    [beside("vertex", &ply::PLACES, "vertices"), beside("face", &ply::CORNERS, "faces")].into_iter().flatten().collect()
}

/// Reports the two bytes after each triangle of a binary STL file, if they are not all 0. Some programs write colours there.
pub(super) fn of_stl(bytes: &[u8]) -> Vec<String> {
    let has_colors = stl::bytes_behind_triangles(bytes).any(|pair| pair != [0, 0]);
    if has_colors { vec!["the two bytes behind each triangle, perhaps colours".to_owned()] } else { Vec::new() }
}
