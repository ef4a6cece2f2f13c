//! Sources of exact numbers, as written in a case.

use std::path::PathBuf;

use serde::Deserialize;

use super::truth_room::RoomTruth;
use super::truth_sobolev::SobolevTruth;

/// Source of the exact numbers of a comparison, as written in a case.
#[derive(Clone, Debug, Deserialize)]
#[serde(tag = "function", rename_all = "kebab-case", deny_unknown_fields)]
pub enum TruthSpec {
    /// Two infinite diffuse planes and a point source (Sobolev 1944).
    Sobolev(SobolevTruth),
    /// A closed enclosure of uniform reflectance with the mean Φ/(S(1−ρ)). In a sphere the indirect part is the same everywhere.
    UniformEnclosure {
        /// Flux of all luminaires in lm.
        luminous_flux_lm: f64,
        /// Reflectance of every surface.
        reflectance: f64,
        /// Area in m² of the ideal shape that the mesh approximates, if it differs from the mesh's own area.
        ideal_area_m2: Option<f64>,
    },
    /// Two hemispheres of a sphere about the origin, `upper` (z > 0) and `lower`, with a point source on the axis.
    TwoHemispheres {
        /// Flux of the isotropic source in lm.
        luminous_flux_lm: f64,
        /// Radius of the ideal sphere in m.
        radius_m: f64,
        /// Height of the source above the centre in m.
        source_height_m: f64,
        /// Reflectance of the upper half.
        upper_reflectance: f64,
        /// Reflectance of the lower half.
        lower_reflectance: f64,
    },
    /// A diffusely luminous sphere inside a concentric one: surfaces `inner` and `outer`.
    ConcentricSpheres {
        /// Flux of the inner sphere in lm.
        luminous_flux_lm: f64,
        /// Radius of the ideal inner sphere in m.
        inner_radius_m: f64,
        /// Radius of the ideal outer sphere in m.
        outer_radius_m: f64,
        /// Reflectance of the inner sphere.
        inner_reflectance: f64,
        /// Reflectance of the outer sphere.
        outer_reflectance: f64,
    },
    /// A closed geometry in which every surface emits (1−ρ)πL₀: L = L₀ in every direction, E = πL₀ on every side.
    Isothermal {
        /// L₀ in cd/m².
        luminance_cd_m2: f64,
    },
    /// An empty rectangular room with diffuse faces and an isotropic point source.
    BoxRoom(RoomTruth),
    /// A column of a CSV file beside the case, made by the program beside it.
    Reference {
        /// File name; default `reference.csv`.
        #[serde(default = "reference_file")]
        file: String,
        /// Column of the exact values in lx.
        column: String,
        /// Known relative error of the values, as a fraction.
        #[serde(default)]
        uncertainty: f64,
        /// If given, only rows with this text in the column `set` are used.
        set: Option<String>,
    },
    /// A stored long run: the directory of a `luxmc solve` of the same scene with another seed.
    Run {
        /// Path of the directory, relative to the case's folder.
        folder: PathBuf,
    },
}

fn reference_file() -> String {
    "reference.csv".to_owned()
}
