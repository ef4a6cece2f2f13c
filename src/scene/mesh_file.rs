//! Mesh files by their endings: OBJ, glTF, STL and PLY.

use std::path::Path;

use super::error::SceneError;
use super::reader::Source;
use super::shapes::GeometryShape;
use super::units::LengthUnit;
use super::{gltf, obj, parse, ply, stl, under_way};

/// Reads a mesh; lengths come in the scene's unit. A file whose ending says nothing is an OBJ file. Warnings say what
/// was passed over and matters.
///
/// # Errors
///
/// Files that cannot be read, that are damaged or cut short, ask for too much, or hold no triangle.
pub(super) fn read(path: &Path, unit: LengthUnit, warnings: &mut Vec<String>) -> Result<GeometryShape, SceneError> {
    under_way::begin(path.file_name().unwrap_or_default().to_string_lossy(), 0);
    let ending = path.extension().map(|ending| ending.to_string_lossy().to_lowercase()).unwrap_or_default();
    match ending.as_str() {
        "gltf" | "glb" => gltf::read(path, &parse::read_bytes(path, "the glTF file")?, unit, warnings),
        "stl" => stl::read(path, parse::read_bytes(path, "the STL file")?, warnings),
        "ply" => ply::read(path, &parse::read_bytes(path, "the PLY file")?, warnings),
        _ => obj::read(&Source { text: &parse::read_text(path, "the OBJ file")?, path }, warnings),
    }
}
