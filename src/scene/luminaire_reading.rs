//! The context for reading a luminaire, and the reading that several types share.

use std::path::Path;

use glam::DVec3;

use super::error::SceneError;
use super::keys::{COUNT, FROM_ZERO, Key, SHARE, TEXT, TYPE, VECTOR, ValueShape, needed, optional};
use super::photometric_luminaire::{FileDistribution, PhotometricFiles};
use super::reader::{Fields, Node};
use super::unique_names::name;
use super::units::LengthUnit;

/// Values of `side`.
const SIDES: [&str; 3] = ["front", "back", "both"];

/// Keys of every luminaire.
#[rustfmt::skip]
pub(super) const COMMON: &[Key] = &[
    name("Name of the luminaire."),
    TYPE,
    optional("dimming", SHARE, "Dimming level, 0 to 1."),
    optional("maintenance_factor", SHARE, "Maintenance factor."),
    optional("power_w", FROM_ZERO, "Electric power of one luminaire in W, undimmed and including the ballast; by default the value in the photometric file."),
];
/// Keys of an array of equal luminaires.
#[rustfmt::skip]
pub(super) const ARRAY: &[Key] = &[
    optional("columns", COUNT, "Luminaires in a row: an array of copies, named \"NAME 1\", \"NAME 2\", … row by row; the first is at this position."),
    optional("rows", COUNT, "Rows of the array."),
    optional("u", VECTOR, "Vector from the first to the last column of the array.").such_as("[6, 0, 0]"),
    optional("v", VECTOR, "Vector from the first to the last row of the array.").such_as("[6, 0, 0]"),
];
/// Key of the direction of γ = 0.
pub(super) const AIM: Key = optional("aim", VECTOR, "Direction of γ = 0; [0, 0, −1] by default.");
/// Keys of the brightness of an extended luminaire, one of which is given.
pub(super) const EXITANCE: Key = optional("exitance_lm_m2", FROM_ZERO, "Exitance in lm/m².");
pub(super) const FLUX: Key = optional("luminous_flux_lm", FROM_ZERO, "Luminous flux in lm.");
pub(super) const EXITANCE_OR_FLUX: &[&[&str]] = &[&["exitance_lm_m2"], &["luminous_flux_lm"]];
/// Keys of a luminous surface.
pub(super) const SURFACE: Key =
    needed("surface", TEXT, "\"panel\"", "A geometry or a part of one; it keeps its material.");
pub(super) const SIDE: Key = optional("side", ValueShape::Choice(&SIDES), "Which side emits (front by default).");

/// Key of a position.
pub(super) const fn place(key: &'static str, doc: &'static str) -> Key {
    needed(key, VECTOR, "[4, 3, 2.5]", doc)
}

/// Data that luminaires refer to.
pub(super) struct LuminaireContext<'a> {
    pub unit: LengthUnit,
    pub base_dir: &'a Path,
    pub surfaces: &'a dyn NamedSurfaces,
}

/// Surfaces that luminaires name.
pub(super) trait NamedSurfaces {
    /// Numbers of the surfaces with a name.
    fn named(&self, node: &Node) -> Result<Vec<u32>, SceneError>;
    /// Area of one side in m².
    fn area_m2(&self, surface: u32) -> f64;
    /// Whether it is a smooth body of spherical harmonics.
    fn is_body(&self, surface: u32) -> bool;
}

/// A luminaire during its reading.
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
    /// Position in m.
    pub fn place_m(&self, key: &str) -> Result<DVec3, SceneError> {
        Ok(self.around.unit.point_m(self.fields.need(key)?.vector()?))
    }

    /// The direction of γ = 0.
    pub fn aim(&self) -> Result<DVec3, SceneError> {
        self.fields.get("aim").map_or(Ok(-DVec3::Z), |node| node.direction())
    }

    /// Luminous flux in lm and exitance in lm/m² of a uniformly emitting area.
    pub fn flux_and_exitance(&self, area_m2: f64) -> Result<(f64, f64), SceneError> {
        let (which, node) = self.fields.one_of(["exitance_lm_m2", "luminous_flux_lm"])?;
        let given = self.maintained * node.amount(["the exitance", "the luminous flux"][which])?;
        Ok(match which {
            0 => (given * area_m2, given),
            _ => (given, given / area_m2),
        })
    }

    /// Returns the surfaces that a luminaire names, whether their fronts and their backs emit, and the emitting area in m².
    pub fn emitting_surfaces(&self) -> Result<(Vec<u32>, [bool; 2], f64), SceneError> {
        let named = self.around.surfaces;
        let node = self.fields.need("surface")?;
        let surfaces = named.named(&node)?;
        if surfaces.iter().any(|id| named.is_body(*id)) {
            let expected = "a surface of flat triangles, or a luminaire of type sphere";
            return Err(node.refuse(
                "a body of spherical harmonics cannot emit",
                expected,
                "use a mesh as the luminous surface",
            ));
        }
        let side = self.fields.get("side").map_or(Ok(0), |node| node.choice())?;
        let (front, back) = (SIDES[side] != "back", SIDES[side] != "front");
        let one_side_m2: f64 = surfaces.iter().map(|id| named.area_m2(*id)).sum();
        Ok((surfaces, [front, back], if front && back { 2.0 * one_side_m2 } else { one_side_m2 }))
    }

    /// Returns the content of the photometric file that a luminaire names. The file's warnings are added to the scene's.
    pub fn distribution(&mut self) -> Result<&FileDistribution, SceneError> {
        let node = self.fields.need("file")?;
        let file = self.files.named(&node, self.around.base_dir)?;
        self.warnings.extend(file.warnings.iter().map(|warning| format!("{}: {warning}", self.name)));
        Ok(file)
    }
}
