//! A proposed scene: what `luxmc convert` writes.

use glam::DVec3;
use serde_json::{Map, Value, json};

use super::names::place_words;

/// Reflectance of what nothing is known of.
pub(super) const UNKNOWN_REFLECTANCE: f64 = 0.5;
/// Name of the lamp that stands in where a model has none.
pub const STAND_IN: &str = "stand-in";
/// Its flux in lm.
const STAND_IN_LM: f64 = 1000.0;
/// Where it stands beside what is no room, from the middle in sizes of the model: above, and to one side.
const BESIDE: DVec3 = DVec3::new(0.4, -0.6, 0.8);

/// A scene file in the making.
#[derive(Clone, Debug, Default)]
pub struct Proposal {
    /// Every material, as the model tells it and as the scene has it.
    pub materials: Vec<ProposedMaterial>,
    /// The materials of the scene file.
    pub(super) laws: Map<String, Value>,
    /// Its geometry.
    pub(super) geometry: Vec<Value>,
    /// Its luminaires.
    pub(super) luminaires: Vec<Value>,
    /// Its receivers.
    pub(super) receivers: Vec<Value>,
    /// Lowest and highest corner in m.
    pub(super) bounds_m: [DVec3; 2],
    /// What was passed over, what stands in, what is to be looked at.
    pub warnings: Vec<String>,
    /// What the reader of a mesh passed over; who reads the scene file is told it again.
    pub reader_warnings: Vec<String>,
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
        let mut file = json!({
            "version": 1,
            "title": title,
            "length_unit": "m",
            "materials": self.laws,
            "geometry": self.geometry,
            "luminaires": self.luminaires,
        });
        if !self.receivers.is_empty() {
            file["receivers"] = json!(self.receivers);
        }
        file
    }

    /// A lamp in the middle, where the model has none.
    pub(super) fn let_a_lamp_stand_in(&mut self) {
        let [low_m, high_m] = self.bounds_m;
        self.stand_in(0.5 * (low_m + high_m), "in its middle");
    }

    /// Moves the lamp that stands in out of a model that is solid: there it would light nothing.
    pub fn put_the_stand_in_beside(&mut self) {
        self.luminaires.pop();
        self.warnings.pop();
        let [low_m, high_m] = self.bounds_m;
        self.stand_in(0.5 * (low_m + high_m) + low_m.distance(high_m) * BESIDE, "above and beside it");
    }

    fn stand_in(&mut self, place_m: DVec3, told: &str) {
        self.luminaires.push(json!({ "name": STAND_IN, "type": "point", "position": place_m.to_array(),
                                     "luminous_flux_lm": STAND_IN_LM }));
        self.warnings.push(format!(
            "the model has no luminaire that is read: a point of {STAND_IN_LM} lm {told}, {}, stands in",
            place_words(place_m)
        ));
    }

    /// Sets of receivers at the sensors of files, each under its name in the scene file.
    pub fn receive_at(&mut self, files: impl IntoIterator<Item = String>) {
        for (number, file) in files.into_iter().enumerate() {
            let stem = std::path::Path::new(&file).file_stem().map(|stem| stem.to_string_lossy().into_owned());
            let name = stem.filter(|name| !name.trim().is_empty()).unwrap_or(format!("sensors {number}"));
            self.receivers.push(json!({ "name": name, "type": "points", "file": file }));
        }
    }
}
