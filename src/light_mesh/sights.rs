//! What an eye sees in each direction of a set: the recursion through mirrors and panes, ended at surfaces that scatter.
//!
//! After Debelov and Novikov (2009), who add to what a mesh says of a surface k_s times what its mirror image shows and k_t
//! times what lies behind. Here k_s and k_t are the mirror's reflectance and the pane's two shares at the angle of the ray,
//! and the luminance of the surface at the end is ρ/π times its illuminance (of a translucent sheet τ/π times that of the
//! other side besides).

use std::f64::consts::PI;

use rayon::prelude::*;

use super::exact::MeshPlace;
use crate::chain::Stage;
use crate::estimators::sight::{Seen, SubPoint, look_along};
use crate::sampling::random::{Purpose, Stream};
use crate::sampling::reflection::{Law, Pair};
use crate::scene::{ReceiverPoint, ReceiverSet};

/// A branch of a line of sight that carries less than this goes on by chance, with a weight that makes up for it.
const FAINT_SHARE: f64 = 0.01;
/// The map number of the streams that thin faint branches.
const SIGHTS: u32 = u32::MAX - 3;

/// A place that a direction of view shows.
#[derive(Clone, Copy)]
pub struct SeenPlace {
    /// The side of the surface whose light is seen.
    pub spot: MeshPlace,
    /// Luminance in cd/m² that gets to the eye for each lx that the side receives.
    pub weight_per_sr: f64,
}

/// What the directions of a set show.
pub struct Sights {
    /// Places of all directions, one after the other.
    places: Vec<SeenPlace>,
    /// Where the places of each direction begin; one more entry ends the last.
    starts: Vec<usize>,
    luminaires_cd_m2: Vec<f64>,
    /// Places of the direction that has most.
    pub most_places: usize,
    /// Whether a faint branch was decided by chance.
    pub has_chance: bool,
    /// Rays that it took.
    pub rays: u64,
}

/// One direction, followed.
struct Sight {
    places: Vec<SeenPlace>,
    luminaires_cd_m2: f64,
    rays: u64,
}

impl Sights {
    /// Follows every direction of a set.
    pub fn of(stage: &Stage, set: &ReceiverSet, seed: u64, set_number: u32) -> Sights {
        let follow = |(number, point): (usize, &ReceiverPoint)| {
            let mut stream = Stream::new(seed, Purpose::LightMesh, SIGHTS, set_number);
            stream.seek(number as u64);
            let mut sight = Sight { places: Vec::new(), luminaires_cd_m2: 0.0, rays: 0 };
            if point.inside {
                return sight;
            }
            let eye = stage.tracer.side_origin(point.position_m, point.normal);
            sight.rays = look_along(stage, &eye, point.normal, FAINT_SHARE, &mut stream, |seen| match seen {
                Seen::Luminaire(luminance_cd_m2) => sight.luminaires_cd_m2 += luminance_cd_m2,
                Seen::Surface(end) => end_at(stage, &end, &mut sight.places),
            });
            sight
        };
        let followed: Vec<Sight> = set.points.par_iter().enumerate().map(follow).collect();
        let most_places = followed.iter().map(|sight| sight.places.len()).max().unwrap_or(0).max(1);
        let mut sights = Sights {
            places: Vec::new(),
            starts: vec![0],
            luminaires_cd_m2: followed.iter().map(|sight| sight.luminaires_cd_m2).collect(),
            most_places,
            has_chance: stage.has_specular(),
            rays: followed.iter().map(|sight| sight.rays).sum(),
        };
        for sight in followed {
            sights.places.extend(sight.places);
            sights.starts.push(sights.places.len());
        }
        sights
    }

    /// Places of all directions.
    pub fn places(&self) -> usize {
        self.places.len()
    }

    /// All places that are seen.
    pub fn spots(&self) -> impl Iterator<Item = &MeshPlace> {
        self.places.iter().map(|place| &place.spot)
    }

    /// What a direction shows of surfaces.
    pub fn places_of(&self, direction: usize) -> &[SeenPlace] {
        &self.places[self.starts[direction]..self.starts[direction + 1]]
    }

    /// Luminance of the luminaires that a direction shows.
    pub fn luminaires_cd_m2(&self, direction: usize) -> f64 {
        self.luminaires_cd_m2[direction]
    }
}

/// The sides of a surface whose light its sub-point sends to the eye.
pub(super) fn end_at(stage: &Stage, end: &SubPoint, places: &mut Vec<SeenPlace>) {
    let mut add = |spot: MeshPlace, share: f64| {
        if share > 0.0 {
            places.push(SeenPlace { spot, weight_per_sr: end.share * share / PI });
        }
    };
    let front = MeshPlace::at_origin(end.point_m, end.normal, end.origin);
    match stage.law(end.hit.triangle) {
        Law::Diffuse(law) => add(front, law.reflectance),
        Law::Translucent(law) => {
            add(front, law.reflectance);
            add(MeshPlace::at_origin(end.point_m, -end.normal, end.behind(stage)), law.transmittance);
        }
        // A scene with lobes is refused (see `check`); of a lobe of no reflectance the diffuse part is all there is.
        law if law.is_specular() => {}
        law => {
            let pair = Pair { normal: end.normal, towards: end.normal, leaving: -end.direction };
            add(front, PI * law.spread_per_sr(&pair));
        }
    }
}
