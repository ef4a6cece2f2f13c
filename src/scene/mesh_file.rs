//! Mesh files by their endings: OBJ, glTF, STL and PLY.

use std::path::Path;

use super::error::SceneError;
use super::reader::Source;
use super::shapes::GeometryShape;
use super::units::LengthUnit;
use super::{gltf, obj, parse, ply, stl, under_way};

/// A mesh file as read from the disk.
pub(super) struct MeshFile<'a> {
    pub path: &'a Path,
    pub content: MeshContent,
}

/// Content of a mesh file, by its ending.
pub(super) enum MeshContent {
    Gltf(Vec<u8>),
    Stl(Vec<u8>),
    Ply(Vec<u8>),
    Obj(String),
}

impl MeshFile<'_> {
    /// Reads a file. A file with an unknown ending is read as OBJ.
    ///
    /// # Errors
    ///
    /// Files that cannot be read.
    pub fn open(path: &Path) -> Result<MeshFile<'_>, SceneError> {
        under_way::begin(path.file_name().unwrap_or_default().to_string_lossy(), 0);
        let ending = path.extension().map(|ending| ending.to_string_lossy().to_lowercase()).unwrap_or_default();
        let content = match ending.as_str() {
            "gltf" | "glb" => MeshContent::Gltf(parse::read_bytes(path, "the glTF file")?),
            "stl" => MeshContent::Stl(parse::read_bytes(path, "the STL file")?),
            "ply" => MeshContent::Ply(parse::read_bytes(path, "the PLY file")?),
            _ => MeshContent::Obj(parse::read_text(path, "the OBJ file")?),
        };
        Ok(MeshFile { path, content })
    }

    /// Returns the mesh, with lengths in the scene's unit. Warnings name the ignored parts of the file that matter.
    ///
    /// # Errors
    ///
    /// Files that are damaged or cut short, request too much, or contain no triangle.
    pub fn shape(&mut self, unit: LengthUnit, warnings: &mut Vec<String>) -> Result<GeometryShape, SceneError> {
        match &mut self.content {
            MeshContent::Gltf(bytes) => gltf::read(self.path, bytes, unit, warnings),
            MeshContent::Stl(bytes) => stl::read(self.path, bytes, warnings),
            MeshContent::Ply(bytes) => ply::read(self.path, bytes, warnings),
            MeshContent::Obj(text) => obj::read(&Source { text: text.as_str(), path: self.path }, warnings),
        }
    }
}
