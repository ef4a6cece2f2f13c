//! Readers of the files that a scene names, from their text alone.

use std::path::Path;

use glam::DVec3;

use super::error::SceneError;
use super::model::ReceiverPoint;
use super::reader::Source;
use super::units::LengthUnit;
use super::{obj, points_file};

/// Content of an OBJ file. Lengths are in the file's unit.
#[derive(Clone, Debug, PartialEq)]
pub struct Mesh {
    /// Distinct vertices, in the order of the file.
    pub vertices: Vec<DVec3>,
    /// Vertex numbers of all triangles, part by part. Polygons are cut into triangles.
    pub triangles: Vec<[u32; 3]>,
    /// Names of the parts by `usemtl`; `None` for faces before the first.
    pub parts: Vec<Option<String>>,
    /// Ignored parts of the file that matter.
    pub warnings: Vec<String>,
}

/// Reads the text of an OBJ file; `path` names it in messages.
///
/// # Errors
///
/// Malformed vertices and faces, corners that do not exist, and texts without a face. The errors give their positions.
pub fn mesh_from_obj(text: &str, path: &Path) -> Result<Mesh, SceneError> {
    let mut warnings = Vec::new();
    let shape = obj::read(&Source { text, path }, &mut warnings)?;
    Ok(Mesh {
        vertices: shape.vertices,
        triangles: shape.parts.iter().flat_map(|part| part.triangles.iter().copied()).collect(),
        parts: shape.parts.into_iter().map(|part| part.name).collect(),
        warnings,
    })
}

/// Reads the text of a points file in metres; `path` names it in messages.
///
/// # Errors
///
/// As for points files that a scene names: a wrong header, a malformed row, no point at all. The errors give their positions.
pub fn receiver_points_from_csv(text: &str, path: &Path) -> Result<Vec<ReceiverPoint>, SceneError> {
    points_file::read(text, path, LengthUnit::of(0))
}
