//! Exact values, and the points, elements and averages of a scene that have them.

use glam::DVec3;
use serde::Deserialize;

/// Part of the light that is compared.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum LightPart {
    /// Direct light, which has met no surface on its way.
    Direct,
    /// Indirect light: the rest.
    Indirect,
    /// All light.
    #[default]
    Total,
}

impl LightPart {
    /// Name in words.
    pub fn name(self) -> &'static str {
        match self {
            LightPart::Direct => "direct",
            LightPart::Indirect => "indirect",
            LightPart::Total => "total",
        }
    }
}

/// Where an exact value is needed.
#[derive(Clone, Copy, Debug)]
pub enum TruthSite<'a> {
    /// A point of a receiver set and its index in it.
    Point {
        /// Position in m.
        position_m: DVec3,
        /// Unit normal of the receiving side.
        normal: DVec3,
        /// Index in the set.
        index: usize,
    },
    /// The mean over an element.
    Element {
        /// Corners in m.
        corners_m: [DVec3; 3],
        /// Its surface.
        surface: &'a str,
        /// Index in the map.
        index: usize,
    },
    /// The mean over a surface or over a whole map.
    Average {
        /// The surface, if the mean is over one.
        surface: Option<&'a str>,
    },
}

/// An exact value and its differences from the scene that is solved, all in the unit of the map's quantity.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Exact {
    /// The value.
    pub value: f64,
    /// Uncertainty of the value itself.
    pub uncertainty: f64,
    /// Change by the discretisation: mesh against ideal shape, or element mean against the value at its centre.
    pub discretisation: f64,
    /// The part of the discretisation that the value does not account for.
    pub unaccounted: f64,
    /// Upper estimate of the light that the finite model lacks.
    pub truncation: f64,
}
