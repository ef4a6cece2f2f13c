//! What others ask of a luminaire's light, whatever its kind: where it stands, where it aims, what it is called.

use glam::DVec3;

use super::Emission;
use crate::scene::openings::Openings;
use crate::scene::photometry::Opening;

/// What is asked of an emission. Each kind says what it has in [`Emission::facts`].
#[derive(Default)]
pub struct EmissionFacts<'a> {
    pub kind_name: &'static str,
    pub words: &'static str,
    pub place_m: Option<DVec3>,
    pub radius_m: f64,
    /// Of a flat elliptical opening: half axes that a plan draws, and the size of the hole in it, as a share.
    pub half_axes_m: Option<[DVec3; 2]>,
    pub hole: f64,
    pub aim: Option<DVec3>,
    pub c0: Option<DVec3>,
    pub intensity_cd: Option<f64>,
    pub exitance_lm_m2: Option<f64>,
    pub surfaces: &'a [u32],
    /// Its own luminous opening, which has an extent and is met by no ray.
    pub opening: Option<Opening>,
    pub is_black_ball: bool,
    /// Of daylight: where it enters the scene.
    pub openings: Option<&'a Openings>,
}

impl Emission {
    /// Name of its kind, as `luxmc inspect` has it.
    pub fn kind_name(&self) -> &'static str {
        self.facts().kind_name
    }

    /// What lists of luminaires call it.
    pub fn words(&self) -> &'static str {
        self.facts().words
    }

    /// Whether it comes from afar: from the sky or the sun.
    pub fn is_daylight(&self) -> bool {
        self.openings().is_some()
    }

    /// Where it stands, in m: a point, or the middle of an opening or a ball; `None` for surfaces and for what comes from afar.
    pub fn place_m(&self) -> Option<DVec3> {
        self.facts().place_m
    }

    /// Radius in m of the ball about its place that rays may start from or meet; openings, which are small, count as their middle.
    pub fn radius_m(&self) -> f64 {
        self.facts().radius_m
    }

    /// Unit vector of γ = 0, where it has one; the way that the sun's light takes.
    pub fn aim(&self) -> Option<DVec3> {
        self.facts().aim
    }

    /// Where C0 of a photometric luminaire points.
    pub fn c0(&self) -> Option<DVec3> {
        self.facts().c0
    }

    /// Maintained intensity in cd of a point, on its axis if it has one.
    pub fn intensity_cd(&self) -> Option<f64> {
        self.facts().intensity_cd
    }

    /// Maintained exitance in lm/m² of what is uniformly bright.
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

    /// Middle and radius in m of a black ball that stands in the way of light.
    pub fn black_ball_m(&self) -> Option<(DVec3, f64)> {
        let facts = self.facts();
        facts.place_m.filter(|_| facts.is_black_ball).map(|center_m| (center_m, facts.radius_m))
    }

    /// Where light from afar enters the scene.
    pub fn openings(&self) -> Option<&Openings> {
        self.facts().openings
    }
}
