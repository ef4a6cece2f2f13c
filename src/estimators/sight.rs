//! Lines of sight: what an eye sees along a direction, through panes and by way of mirrors, up to the surface that
//! scatters.

use std::f64::consts::PI;

use glam::DVec3;
use serde::{Deserialize, Serialize};

use crate::chain::Stage;
use crate::geometry::{Meeting, Origin, SurfaceHit};
use crate::sampling::random::Stream;
use crate::sampling::reflection::{Bsdf, LobeKind, mirrored};

/// A branch of a line of sight (mirrored or passed by a pane) that carries less than this share goes on by chance only.
pub const SMALL_SHARE: f64 = 0.1;
/// The same where luminaires themselves are looked for: a bright one in a pane outshines all else of a picture, and whether it is there
/// must not be left to chance.
pub const SMALL_SHARE_OF_LUMINAIRES: f64 = 0.01;
/// A line of sight that has met so many mirrors and panes goes on by chance only, whatever it carries: between two mirrors that
/// face each other and absorb nothing it would never end.
pub const MANY_MIRRORS: u32 = 1000;
/// An opening may lie this many times the tracer's accuracy behind a surface and still be seen: it is mounted on it.
const MOUNTING: f64 = 8.0;

/// The surface at which a line of sight ends: the sub-point.
#[derive(Serialize, Deserialize)]
pub struct SubPoint {
    /// Where.
    pub hit: SurfaceHit,
    /// Direction in which the line of sight arrives.
    pub direction: DVec3,
    /// Unit normal of the side that is seen.
    pub normal: DVec3,
    /// The place for the tracer, on that side.
    pub origin: Origin,
    /// The place in m.
    pub point_m: DVec3,
    /// Share of its luminance that gets to the eye.
    pub share: f64,
}

/// A luminaire on a line of sight.
pub struct SeenLuminaire {
    /// Luminance in cd/m², with what panes and mirrors let pass.
    pub luminance_cd_m2: f64,
    /// Its number, if rays can meet it: none of a luminous opening, of the sky and the sun.
    pub emitter: Option<u32>,
    /// Whether no mirror is on the way.
    pub is_straight: bool,
}

/// What is on a line of sight.
pub enum Seen {
    /// A luminaire.
    Luminaire(SeenLuminaire),
    /// A surface that scatters.
    Surface(SubPoint),
}

/// Follows a line of sight and shows what is on it; returns the number of rays.
///
/// At panes it goes both ways, weighed by their shares. Branches below a small share go on by chance, with a weight that
/// makes up for it.
pub fn look_along(
    stage: &Stage,
    eye: &Origin,
    direction: DVec3,
    small_share: f64,
    stream: &mut Stream,
    mut show: impl FnMut(Seen),
) -> u64 {
    let mut rays = 0;
    let mut branches = vec![(*eye, direction, 1.0, 0, true)];
    while let Some((origin, direction, mut share, met, is_straight)) = branches.pop() {
        let luminaire = |luminance_cd_m2: f64, emitter: Option<u32>| {
            Seen::Luminaire(SeenLuminaire { luminance_cd_m2, emitter, is_straight })
        };
        if met > MANY_MIRRORS {
            if stream.unit() >= 0.5 {
                continue;
            }
            share *= 2.0;
        }
        if share < small_share {
            if stream.unit() * small_share >= share {
                continue;
            }
            share = small_share;
        }
        rays += 1;
        let meeting = stage.tracer.first_hit(&origin, direction);
        let from_m = stage.tracer.position_m(&origin);
        let reach_m = match &meeting {
            Meeting::Surface(hit) => {
                let cosine = stage.normal_at(hit).dot(direction).abs();
                hit.distance_m + MOUNTING * stage.tracer.position_accuracy_m() / cosine.max(1e-3)
            }
            Meeting::Ball(luminaire) => stage
                .emitters
                .of_ball(*luminaire)
                .map_or(f64::INFINITY, |index| stage.emitters.list()[index as usize].ball_at_m(from_m, direction)),
            Meeting::Nothing => f64::INFINITY,
        };
        for emitter in stage.emitters.list() {
            if let Some((distance_m, luminance_cd_m2)) = emitter.opening_on_sight(from_m, direction)
                && distance_m <= reach_m
            {
                show(luminaire(share * luminance_cd_m2, None));
            }
        }
        let own_cd_m2 = |index: u32| stage.emitters.list()[index as usize].exitance_lm_m2().unwrap_or(0.0) / PI;
        let hit = match meeting {
            Meeting::Surface(hit) => hit,
            Meeting::Ball(ball) => {
                let emitter = stage.emitters.of_ball(ball);
                show(luminaire(share * emitter.map_or(0.0, own_cd_m2), emitter));
                continue;
            }
            Meeting::Nothing => {
                if let Some(sky) = stage.emitters.sky() {
                    show(luminaire(share * sky.luminance_cd_m2(direction), None));
                }
                if let Some(sun) = stage.emitters.sun() {
                    show(luminaire(share * sun.luminance_cd_m2(direction), None));
                }
                continue;
            }
        };
        for index in stage.emitters.on_surface(hit.triangle, hit.side) {
            show(luminaire(share * own_cd_m2(index), Some(index)));
        }
        let bsdf = stage.bsdf(hit.triangle);
        if bsdf.is_black() || !stage.receives(hit.triangle, hit.side) {
            continue;
        }
        let normal = stage.normal_at(&hit);
        let cosine = normal.dot(direction);
        if bsdf.is_specular() {
            branches.push((
                stage.leave(&hit, LobeKind::Mirrored),
                mirrored(direction, normal),
                share * bsdf.mirror_share(cosine),
                met + 1,
                false,
            ));
            if let Bsdf::Glass(glass) = bsdf {
                let passed = stage.leave(&hit, LobeKind::Passed);
                branches.push((passed, direction, share * glass.shares(cosine)[1], met + 1, is_straight));
            }
        } else {
            let origin = stage.leave(&hit, LobeKind::Spread);
            let point_m = stage.tracer.position_m(&origin);
            show(Seen::Surface(SubPoint { hit, direction, normal, origin, point_m, share }));
        }
    }
    rays
}
