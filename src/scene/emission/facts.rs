//! Data on a luminaire's light that other code needs for every kind: position, aim and name.

use glam::DVec3;

use super::Emission;
use crate::scene::openings::Openings;
use crate::scene::photometry::Opening;

/// Data of an emission. [`Emission::facts`] gives them for each kind.
#[derive(Default)]
pub struct EmissionFacts<'a> {
    pub kind_name: &'static str,
    pub words: &'static str,
    pub place_m: Option<DVec3>,
    pub radius_m: f64,
    /// For a flat elliptical opening: half axes in m that a plan draws, and the size of the hole in it as a share.
    pub half_axes_m: Option<[DVec3; 2]>,
    pub hole: f64,
    pub aim: Option<DVec3>,
    pub c0: Option<DVec3>,
    pub intensity_cd: Option<f64>,
    pub exitance_lm_m2: Option<f64>,
    pub surfaces: &'a [u32],
    /// The luminaire's own luminous opening. It has an extent, but rays do not hit it.
    pub opening: Option<Opening>,
    pub is_black_ball: bool,
    /// For daylight: where it enters the scene.
    pub openings: Option<&'a Openings>,
}

impl Emission {
    /// Name of its kind, as in `luxmc inspect`.
    pub fn kind_name(&self) -> &'static str {
        self.facts().kind_name
    }

    /// Name in lists of luminaires.
    pub fn words(&self) -> &'static str {
        self.facts().words
    }

    /// Whether it is daylight: from the sky or the sun.
    pub fn is_daylight(&self) -> bool {
        self.openings().is_some()
    }

    /// Position in m: a point, or the middle of an opening or a ball. `None` for surfaces and for daylight.
    pub fn place_m(&self) -> Option<DVec3> {
        self.facts().place_m
    }

    /// Radius in m of the ball about its position where rays may start or hit. Photometric openings are small and count as their middle: 0. A
    /// ring has its outer radius.
    pub fn radius_m(&self) -> f64 {
        self.facts().radius_m
    }

    /// Unit vector of γ = 0, if it has one. For the sun: the direction in which its light travels.
    pub fn aim(&self) -> Option<DVec3> {
        self.facts().aim
    }

    /// Direction of C0 of a photometric luminaire.
    pub fn c0(&self) -> Option<DVec3> {
        self.facts().c0
    }

    /// Maintained intensity in cd of a point source, on its axis if it has one.
    pub fn intensity_cd(&self) -> Option<f64> {
        self.facts().intensity_cd
    }

    /// Maintained exitance in lm/m² of a uniformly bright luminaire.
    pub fn exitance_lm_m2(&self) -> Option<f64> {
        self.facts().exitance_lm_m2
    }

    /// Numbers of the surfaces that emit.
    pub fn surfaces(&self) -> &[u32] {
        self.facts().surfaces
    }

    /// Its luminous opening.
    pub fn opening(&self) -> Option<Opening> {
        self.facts().opening
    }

    /// Middle and radius in m of a black ball that blocks light.
    pub fn black_ball_m(&self) -> Option<(DVec3, f64)> {
        let facts = self.facts();
        facts.place_m.filter(|_| facts.is_black_ball).map(|center_m| (center_m, facts.radius_m))
    }

    /// Openings through which daylight enters the scene.
    pub fn openings(&self) -> Option<&Openings> {
        self.facts().openings
    }
}
