//! Where exact numbers come from, as a case names it.

use std::path::PathBuf;

use serde::Deserialize;

use super::truth_room::RoomTruth;
use super::truth_sobolev::SobolevTruth;

/// Where the exact numbers of a comparison come from, as a case writes it.
#[derive(Clone, Debug, Deserialize)]
#[serde(tag = "function", rename_all = "kebab-case", deny_unknown_fields)]
pub enum TruthSpec {
    /// Two infinite diffuse planes and a point source (Sobolev 1944).
    Sobolev(SobolevTruth),
    /// A closed enclosure of one reflectance: the mean is Φ/(S(1−ρ)); in a sphere the indirect part is so everywhere.
    UniformEnclosure {
        /// Flux of all luminaires in lm.
        luminous_flux_lm: f64,
        /// Reflectance of every surface.
        reflectance: f64,
        /// Area of the shape that the mesh stands for, in m², where it is not the mesh's own.
        ideal_area_m2: Option<f64>,
    },
    /// A sphere about the origin of two hemispheres, `upper` (z > 0) and `lower`, with a point source on the axis.
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
    /// A diffusely bright sphere within a concentric one: surfaces `inner` and `outer`.
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
    /// Every surface emits (1−ρ)πL₀ in a closed geometry: L = L₀ in every direction, E = πL₀ on every side.
    Isothermal {
        /// L₀ in cd/m².
        luminance_cd_m2: f64,
    },
    /// An empty rectangular room of diffuse faces and an isotropic point source.
    BoxRoom(RoomTruth),
    /// A column of a CSV file beside the case, made by the program that lies beside it.
    Reference {
        /// File name; without it `reference.csv`.
        #[serde(default = "reference_file")]
        file: String,
        /// Column of the exact values in lx.
        column: String,
        /// Known error of the values, as a fraction.
        #[serde(default)]
        uncertainty: f64,
        /// Rows that count: those with this text in the column `set`.
        set: Option<String>,
    },
    /// A stored long run: the directory of a `luxmc solve` of the same scene with another seed.
    Run {
        /// The directory, from the case's folder.
        folder: PathBuf,
    },
}

fn reference_file() -> String {
    "reference.csv".to_owned()
}
