//! Builds a mesh: exactly coincident vertices become one, and triangles are added part by part.

use std::collections::HashMap;
use std::path::Path;

use glam::DVec3;

use super::error::SceneError;
use super::shapes::{GeometryShape, ShapePart};

/// Name of the part for triangles without a material, in a file with materials.
pub(super) const UNNAMED_PART: &str = "unnamed";

/// Makes a refusal of a mesh file that is not text.
pub(super) fn refusal(path: &Path, what: impl Into<String>, got: impl Into<String>, expected: &str) -> SceneError {
    let remedy = "export the model again; if that changes nothing, export it as OBJ";
    SceneError::of_file(path, what.into(), got.into(), expected, remedy)
}

/// A shape that grows as its file is read.
#[derive(Default)]
pub(super) struct MeshBuilder {
    numbers: HashMap<[u64; 3], u32>,
    shape: GeometryShape,
    /// Index of each part in the shape, by its name.
    places: HashMap<Option<String>, usize>,
    /// Number of triangles of all parts.
    triangles: usize,
}

impl MeshBuilder {
    /// Returns the number of the vertex at a point and adds the vertex if it is new.
    pub fn vertex(&mut self, point: DVec3) -> u32 {
        // Adding +0 makes −0 and +0 equal.
        let key = (point + DVec3::ZERO).to_array().map(f64::to_bits);
        let vertices = &mut self.shape.vertices;
        *self.numbers.entry(key).or_insert_with(|| {
            vertices.push(point);
            (vertices.len() - 1) as u32
        })
    }

    /// Position of a vertex.
    pub fn place(&self, vertex: u32) -> DVec3 {
        self.shape.vertices[vertex as usize]
    }

    /// Adds triangles to the part with a name. A new name begins a new part.
    pub fn add(&mut self, part: Option<&str>, triangles: impl IntoIterator<Item = [u32; 3]>) {
        let parts = &mut self.shape.parts;
        let place = *self.places.entry(part.map(str::to_owned)).or_insert_with(|| {
            parts.push(ShapePart { name: part.map(str::to_owned), triangles: Vec::new() });
            parts.len() - 1
        });
        let before = parts[place].triangles.len();
        parts[place].triangles.extend(triangles);
        self.triangles += parts[place].triangles.len() - before;
    }

    /// Number of triangles, or of vertices if that is greater.
    pub fn size(&self) -> usize {
        self.triangles.max(self.shape.vertices.len())
    }

    /// Returns the finished shape.
    pub fn finish(self) -> GeometryShape {
        self.shape
    }
}
