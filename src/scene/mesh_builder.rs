//! A mesh in the making: vertices that coincide exactly are one, triangles come part by part.

use std::collections::HashMap;
use std::path::Path;

use glam::DVec3;

use super::error::SceneError;
use super::shapes::{GeometryShape, ShapePart};

/// Name of the part of triangles without a material, in a file that has others.
pub(super) const UNNAMED_PART: &str = "unnamed";

/// A refusal of a mesh file that is no text.
pub(super) fn refusal(path: &Path, what: impl Into<String>, got: impl Into<String>, expected: &str) -> SceneError {
    let remedy = "export the model again; if that changes nothing, export it as OBJ";
    SceneError::of_file(path, what.into(), got.into(), expected, remedy)
}

/// A shape that grows as its file is read.
#[derive(Default)]
pub(super) struct MeshBuilder {
    numbers: HashMap<[u64; 3], u32>,
    shape: GeometryShape,
    /// Where each part is in the shape.
    places: HashMap<Option<String>, usize>,
    /// Triangles of all parts.
    triangles: usize,
}

impl MeshBuilder {
    /// The number of the vertex at a place.
    pub fn vertex(&mut self, point: DVec3) -> u32 {
        // Adding +0 makes −0 and +0 one.
        let key = (point + DVec3::ZERO).to_array().map(f64::to_bits);
        let vertices = &mut self.shape.vertices;
        *self.numbers.entry(key).or_insert_with(|| {
            vertices.push(point);
            (vertices.len() - 1) as u32
        })
    }

    /// Where a vertex is.
    pub fn place(&self, vertex: u32) -> DVec3 {
        self.shape.vertices[vertex as usize]
    }

    /// Adds triangles to the part of a name, which begins with them where it is new.
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

    /// Triangles, or vertices where they are more.
    pub fn size(&self) -> usize {
        self.triangles.max(self.shape.vertices.len())
    }

    /// The shape.
    pub fn finish(self) -> GeometryShape {
        self.shape
    }
}
