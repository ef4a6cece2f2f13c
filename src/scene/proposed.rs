//! A proposed scene: what `luxmc convert` writes.

use serde_json::{Map, Value, json};

/// A scene file in the making.
#[derive(Clone, Debug)]
pub struct Proposal {
    /// Every material, as the model tells it and as the scene has it.
    pub materials: Vec<ProposedMaterial>,
    /// The materials of the scene file.
    pub(super) laws: Map<String, Value>,
    /// Its geometry.
    pub(super) geometry: Vec<Value>,
    /// Its luminaires.
    pub(super) luminaires: Vec<Value>,
    /// What was passed over, what stands in, what is to be looked at.
    pub warnings: Vec<String>,
}

/// A material of a proposed scene.
#[derive(Clone, Debug)]
pub struct ProposedMaterial {
    /// Its name in model and scene.
    pub name: String,
    /// Triangles of a mesh, or surfaces of a Radiance scene, that are made of it.
    pub surfaces: usize,
    /// What it does to light, as the scene file says it.
    pub law: Value,
    /// Where that comes from, and what is not known.
    pub known: String,
}

impl Proposal {
    /// The scene file.
    pub fn scene_file(&self, title: &str) -> Value {
        json!({
            "version": 1,
            "title": title,
            "length_unit": "m",
            "materials": self.laws,
            "geometry": self.geometry,
            "luminaires": self.luminaires,
        })
    }
}
