//! Lines of sight: what an eye sees along a direction, through panes and by way of mirrors, up to the surface that scatters.

use std::f64::consts::PI;

use glam::DVec3;
use serde::{Deserialize, Serialize};

use crate::geometry::{Meeting, Origin, SurfaceHit};
use crate::sampling::random::Stream;
use crate::sampling::reflection::{Bsdf, LobeKind, mirrored};
use crate::transport::World;

/// A branch of a line of sight (reflected or transmitted by a pane) that carries less than this share continues only by chance.
pub const SMALL_SHARE: f64 = 0.1;
/// The same limit for lines of sight that search for luminaires themselves. A bright luminaire in a pane outshines all else in a picture,
/// so its presence must not depend on chance.
pub const SMALL_SHARE_OF_LUMINAIRES: f64 = 0.01;
/// A line of sight that has met more than this number of mirrors and panes continues only by chance, whatever it carries. Between two
/// facing mirrors that absorb nothing it would never end.
pub const MANY_MIRRORS: u32 = 1000;
/// An opening may lie this many times the tracer's accuracy behind a surface and still be seen, since it is mounted on that surface.
const MOUNTING: f64 = 8.0;

/// The surface at which a line of sight ends: the sub-point.
#[derive(Serialize, Deserialize)]
pub struct SubPoint {
    /// The hit point.
    pub hit: SurfaceHit,
    /// Direction in which the line of sight arrives.
    pub direction: DVec3,
    /// Unit normal of the side that is seen.
    pub normal: DVec3,
    /// The point for the tracer, on that side.
    pub origin: Origin,
    /// The point in m.
    pub point_m: DVec3,
    /// Share of its luminance that reaches the eye.
    pub share: f64,
}

/// A luminaire on a line of sight.
pub struct SeenLuminaire {
    /// Luminance in cd/m², reduced by the panes and mirrors on the way.
    pub luminance_cd_m2: f64,
    /// Number of the emitter, if rays can meet it. `None` for a luminous opening, the sky and the sun.
    pub emitter: Option<u32>,
    /// Whether there is no mirror on the way.
    pub is_straight: bool,
}

/// Object on a line of sight.
pub enum Seen {
    /// A luminaire.
    Luminaire(SeenLuminaire),
    /// A surface that scatters.
    Surface(SubPoint),
}

/// Follows a line of sight and passes what is on it to `show`. Returns the number of rays.
///
/// At panes it follows both branches, weighted by their shares. Branches below a small share continue by chance, with a weight that
/// compensates for this.
pub fn trace_sight(
    world: &World,
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
        let meeting = world.tracer.first_hit(&origin, direction);
        let from_m = world.tracer.position_m(&origin);
        let reach_m = match &meeting {
            Meeting::Surface(hit) => {
                let cosine = world.normal_at(hit).dot(direction).abs();
                hit.distance_m + MOUNTING * world.tracer.position_accuracy_m() / cosine.max(1e-3)
            }
            Meeting::Ball(luminaire) => world
                .emitters
                .of_ball(*luminaire)
                .map_or(f64::INFINITY, |index| world.emitters.list()[index as usize].ball_at_m(from_m, direction)),
            Meeting::Nothing => f64::INFINITY,
        };
        for emitter in world.emitters.list() {
            if let Some((distance_m, luminance_cd_m2)) = emitter.opening_on_sight(from_m, direction)
                && distance_m <= reach_m
            {
                show(luminaire(share * luminance_cd_m2, None));
            }
        }
        let own_cd_m2 = |index: u32| world.emitters.list()[index as usize].exitance_lm_m2().unwrap_or(0.0) / PI;
        let hit = match meeting {
            Meeting::Surface(hit) => hit,
            Meeting::Ball(ball) => {
                let emitter = world.emitters.of_ball(ball);
                show(luminaire(share * emitter.map_or(0.0, own_cd_m2), emitter));
                continue;
            }
            Meeting::Nothing => {
                if let Some(sky) = world.emitters.sky() {
                    show(luminaire(share * sky.luminance_cd_m2(direction), None));
                }
                if let Some(sun) = world.emitters.sun() {
                    show(luminaire(share * sun.luminance_cd_m2(direction), None));
                }
                continue;
            }
        };
        for index in world.emitters.on_surface(hit.triangle, hit.side) {
            show(luminaire(share * own_cd_m2(index), Some(index)));
        }
        let bsdf = world.bsdf(hit.triangle);
        if bsdf.is_black() || !world.receives(hit.triangle, hit.side) {
            continue;
        }
        let normal = world.normal_at(&hit);
        let cosine = normal.dot(direction);
        if bsdf.is_specular() {
            branches.push((
                world.leave(&hit, LobeKind::Mirrored),
                mirrored(direction, normal),
                share * bsdf.mirror_share(cosine),
                met + 1,
                false,
            ));
            if let Bsdf::Glass(glass) = bsdf {
                let passed = world.leave(&hit, LobeKind::Passed);
                branches.push((passed, direction, share * glass.shares(cosine)[1], met + 1, is_straight));
            }
        } else {
            let origin = world.leave(&hit, LobeKind::Spread);
            let point_m = world.tracer.position_m(&origin);
            show(Seen::Surface(SubPoint { hit, direction, normal, origin, point_m, share }));
        }
    }
    rays
}
