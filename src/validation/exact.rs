//! Exact values, and what of a scene they are asked for.

use glam::DVec3;
use serde::Deserialize;

/// Which part of the light is compared.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum LightPart {
    /// What has met nothing on its way.
    Direct,
    /// The rest.
    Indirect,
    /// All of it.
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

/// What is asked about.
#[derive(Clone, Copy, Debug)]
pub enum TruthSite<'a> {
    /// A point of a receiver set and its place in it.
    Point {
        /// Place in m.
        position_m: DVec3,
        /// Unit normal of the receiving side.
        normal: DVec3,
        /// Place in the set.
        index: usize,
    },
    /// The mean over an element.
    Element {
        /// Corners in m.
        corners_m: [DVec3; 3],
        /// Its surface.
        surface: &'a str,
        /// Place in the map.
        index: usize,
    },
    /// The mean over a surface, or over all of a map.
    Average {
        /// The surface, if it is one.
        surface: Option<&'a str>,
    },
}

/// An exact value with what stands between it and the scene that is solved, all in lx.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Exact {
    /// The value.
    pub value_lx: f64,
    /// Error of the value itself.
    pub uncertainty_lx: f64,
    /// What the discretisation changes: mesh against ideal shape, or element mean against the value at its centre.
    pub discretisation_lx: f64,
    /// The part of the discretisation that the value does not account for.
    pub unaccounted_lx: f64,
    /// Upper estimate of what the finite model lacks.
    pub truncation_lx: f64,
}
