//! A proposed scene: the output of `luxmc convert`.

use glam::DVec3;
use serde_json::{Map, Value, json};

use super::names::place_words;

/// Reflectance of materials about which nothing is known.
pub(super) const UNKNOWN_REFLECTANCE: f64 = 0.5;
/// Name of the lamp that is added if a model has none.
pub const STAND_IN: &str = "stand-in";
/// Flux of that lamp in lm.
const STAND_IN_LM: f64 = 1000.0;
/// Position of that lamp beside a model that is no room: above and to one side. It is an offset from the middle, in sizes of the model.
const BESIDE: DVec3 = DVec3::new(0.4, -0.6, 0.8);

/// The content of a scene file before it is written.
#[derive(Clone, Debug, Default)]
pub struct Proposal {
    /// Every material: its data in the model and in the scene.
    pub materials: Vec<ProposedMaterial>,
    /// The materials of the scene file.
    pub(super) bsdfs: Map<String, Value>,
    /// Its geometry.
    pub(super) geometry: Vec<Value>,
    /// Its luminaires.
    pub(super) luminaires: Vec<Value>,
    /// Its receivers.
    pub(super) receivers: Vec<Value>,
    /// Lowest and highest corner in m.
    pub(super) bounds_m: [DVec3; 2],
    /// Warnings: ignored content, stand-ins, and what the user should check.
    pub warnings: Vec<String>,
    /// Warnings of the mesh reader. Reading the scene file reports them again.
    pub reader_warnings: Vec<String>,
}

/// A material of a proposed scene.
#[derive(Clone, Debug)]
pub struct ProposedMaterial {
    /// Its name in model and scene.
    pub name: String,
    /// Number of triangles of a mesh, or of surfaces of a Radiance scene, with this material.
    pub surfaces: usize,
    /// Its reflection, as in the scene file.
    pub bsdf: Value,
    /// Source of these values, and what is unknown.
    pub known: String,
}

impl Proposal {
    /// Returns the scene file.
    pub fn scene_file(&self, title: &str) -> Value {
        let mut file = json!({
            "version": 1,
            "title": title,
            "length_unit": "m",
            "materials": self.bsdfs,
            "geometry": self.geometry,
            "luminaires": self.luminaires,
        });
        if !self.receivers.is_empty() {
            file["receivers"] = json!(self.receivers);
        }
        file
    }

    /// Adds a lamp in the middle of a model that has none.
    pub(super) fn let_a_lamp_stand_in(&mut self) {
        let [low_m, high_m] = self.bounds_m;
        self.stand_in(0.5 * (low_m + high_m), "in its middle");
    }

    /// Moves the added lamp out of a solid model. Inside it would light nothing.
    pub fn put_the_stand_in_beside(&mut self) {
        self.luminaires.pop();
        self.warnings.pop();
        let [low_m, high_m] = self.bounds_m;
        self.stand_in(0.5 * (low_m + high_m) + low_m.distance(high_m) * BESIDE, "above and beside it");
    }

    fn stand_in(&mut self, place_m: DVec3, reason: &str) {
        self.luminaires.push(json!({ "name": STAND_IN, "type": "point", "position": place_m.to_array(),
                                     "luminous_flux_lm": STAND_IN_LM }));
        self.warnings.push(format!(
            "no luminaire was read from the model: a point of {STAND_IN_LM} lm {reason}, {}, stands in",
            place_words(place_m)
        ));
    }

    /// Adds a receiver set for each file of sensors. `files` are their names in the scene file.
    pub fn receive_at(&mut self, files: impl IntoIterator<Item = String>) {
        for (number, file) in files.into_iter().enumerate() {
            let stem = std::path::Path::new(&file).file_stem().map(|stem| stem.to_string_lossy().into_owned());
            let name = stem.filter(|name| !name.trim().is_empty()).unwrap_or(format!("sensors {number}"));
            self.receivers.push(json!({ "name": name, "type": "points", "file": file }));
        }
    }
}
