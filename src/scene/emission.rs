//! What all kinds of light sources can be asked for.

use glam::DVec3;

use super::model::Emission;

impl Emission {
    /// Whether it comes from afar: from the sky or the sun.
    pub fn is_daylight(&self) -> bool {
        matches!(self, Emission::Sky { .. } | Emission::Sun { .. })
    }

    /// Where it stands, in m: a point, or the middle of an opening or a ball; `None` for surfaces and for what comes from afar.
    pub fn place_m(&self) -> Option<DVec3> {
        match self {
            Emission::Isotropic { position_m, .. }
            | Emission::Lambertian { position_m, .. }
            | Emission::Photometric { position_m, .. } => Some(*position_m),
            Emission::Sphere { center_m, .. } => Some(*center_m),
            Emission::Area { .. } | Emission::Sky { .. } | Emission::Sun { .. } => None,
        }
    }
}
