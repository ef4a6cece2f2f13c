//! What reading a luminaire takes, and what several types read alike.

use std::path::Path;

use glam::DVec3;

use super::error::SceneError;
use super::photometric_luminaire::PhotometricFiles;
use super::reader::{Fields, Node};
use super::units::LengthUnit;

/// What luminaires refer to.
pub(super) struct LuminaireContext<'a> {
    pub unit: LengthUnit,
    pub base_dir: &'a Path,
    pub surfaces: &'a dyn NamedSurfaces,
}

/// Surfaces that luminaires name.
pub(super) trait NamedSurfaces {
    /// Numbers of the surfaces of a name.
    fn named(&self, node: &Node) -> Result<Vec<u32>, SceneError>;
    /// Area of one side in m².
    fn area_m2(&self, surface: u32) -> f64;
    /// Whether it is a smooth body of spherical harmonics.
    fn is_body(&self, surface: u32) -> bool;
}

/// A luminaire that is being read.
pub(super) struct LuminaireReading<'a> {
    pub fields: &'a Fields<'a>,
    pub name: &'a str,
    pub around: &'a LuminaireContext<'a>,
    /// Dimming × maintenance factor.
    pub maintained: f64,
    pub files: &'a mut PhotometricFiles,
    pub warnings: &'a mut Vec<String>,
}

impl LuminaireReading<'_> {
    /// A place in m.
    pub fn place_m(&self, key: &str) -> Result<DVec3, SceneError> {
        Ok(self.around.unit.point_m(self.fields.need(key, "[4, 3, 2.5]")?.vector()?))
    }

    /// The direction of γ = 0.
    pub fn aim(&self) -> Result<DVec3, SceneError> {
        self.fields.get("aim").map_or(Ok(-DVec3::Z), |node| node.direction())
    }

    /// Flux and exitance of a uniformly emitting area.
    pub fn flux_and_exitance(&self, area_m2: f64) -> Result<(f64, f64), SceneError> {
        let (which, node) = self.fields.one_of(["exitance_lm_m2", "luminous_flux_lm"])?;
        let given = self.maintained * node.at_least_zero(["the exitance", "the luminous flux"][which])?;
        Ok(match which {
            0 => (given * area_m2, given),
            _ => (given, given / area_m2),
        })
    }
}
