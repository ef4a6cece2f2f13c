//! Readers of the files that a scene names, by their text alone.

use std::path::Path;

use glam::DVec3;

use super::error::SceneError;
use super::model::ReceiverPoint;
use super::reader::Source;
use super::units::LengthUnit;
use super::{obj, points_file};

/// What an OBJ file holds: lengths as they stand in the file.
#[derive(Clone, Debug, PartialEq)]
pub struct Mesh {
    /// Vertices that differ, in the order of the file.
    pub vertices: Vec<DVec3>,
    /// Vertex numbers of all triangles, part by part; polygons are cut up.
    pub triangles: Vec<[u32; 3]>,
    /// Names of the parts by `usemtl`; `None` for faces before the first.
    pub parts: Vec<Option<String>>,
    /// What was passed over and matters.
    pub warnings: Vec<String>,
}

/// Reads the text of an OBJ file; `path` names it in messages.
///
/// # Errors
///
/// Malformed vertices and faces, corners that do not exist, and texts without a face, with their places.
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
/// As for points files that a scene names: a wrong header, a malformed row, no point at all, with their places.
pub fn receiver_points_from_csv(text: &str, path: &Path) -> Result<Vec<ReceiverPoint>, SceneError> {
    points_file::read(text, path, LengthUnit::of(0))
}
