//! Daylight coefficients: illuminance of a receiver for each cd/m² of a part of the sky, by walks that serve all parts at once.
//!
//! The illuminance at a point is linear in the sky's luminances, E = Σ_p C_p L_p (docs/methods.md (37)). A walk under a sky of 1 cd/m² all
//! around scores as a walk for indirect illuminance does. The light found by each light sample and by way of mirrors is credited to the
//! direction that it comes from. So one set of walks is unbiased for every part of every sky.
//!
//! A walk does not test where the sun shines. It reports the scattering surface points that it met, and the illuminance at the receiver for
//! light that arrives there.

use std::f64::consts::PI;

use glam::DVec3;

use super::direct::{DirectPass, SampleCost, one_light_sample};
use super::receiver::Receiver;
use super::walk::MOST_RAYS_OF_A_WALK;
use crate::geometry::{Meeting, Origin, SurfaceHit};
use crate::sampling::emitter::{LightSample, Place};
use crate::sampling::emitter_tree::Cut;
use crate::sampling::random::Stream;
use crate::sampling::reflection::{Bsdf, LobeKind, Pair};
use crate::sampling::sky_openings::are_left_within;
use crate::sampling::warp::cosine_hemisphere;
use crate::scene::Openings;
use crate::transport::{TriangleSide, World};

/// A point where a walk met a surface that scatters light towards the receiver.
pub struct MetPlace<'a> {
    /// The side of a triangle that is lit.
    pub spot: TriangleSide,
    /// Weights of the second and third corner.
    pub barycentric: [f64; 2],
    response: Response<'a>,
}

/// Illuminance at the receiver for light that arrives at a met point.
enum Response<'a> {
    /// In lx for each lx, equal for all directions.
    Even(f64),
    /// By a BSDF that depends on direction: the BSDF, the normal, and the direction to the receiver.
    Directed(&'a Bsdf, DVec3, DVec3),
}

impl MetPlace<'_> {
    /// Illuminance at the receiver over that at the point, if it does not depend on the direction.
    #[inline]
    pub fn brings_evenly(&self) -> Option<f64> {
        match self.response {
            Response::Even(share) => Some(share),
            Response::Directed(..) => None,
        }
    }

    /// Illuminance at the receiver over the illuminance that the point receives from a unit direction.
    #[inline]
    pub fn brings(&self, towards: DVec3) -> f64 {
        match self.response {
            Response::Even(share) => share,
            Response::Directed(bsdf, normal, leaving) => PI * bsdf.eval_per_sr(&Pair { normal, towards, leaving }),
        }
    }
}

/// Path by which light of the sky comes to a receiver: the split of the daylight factor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SkyPath {
    /// Directly, or through panes.
    Straight,
    /// Reflected by a surface that the receiver sees beyond an opening.
    FromOutside,
    /// Reflected by a surface that the receiver sees on its own side.
    FromInside,
}

/// Number of paths by which light of the sky comes.
pub const SKY_WAYS: usize = 3;

impl SkyPath {
    /// Component of the daylight factor in which light from a direction counts. Direct light from the ground has been reflected outside.
    #[inline]
    pub fn component(self, towards: DVec3) -> SkyPath {
        if self == SkyPath::Straight && towards.z <= 0.0 { SkyPath::FromOutside } else { self }
    }
}

/// Receives the results of a walk.
pub trait CoefficientTally {
    /// Adds illuminance in lx at the receiver from a unit direction.
    fn add_sky(&mut self, towards: DVec3, lx: f64, way: SkyPath);

    /// Reports a surface point that would light the receiver.
    fn met(&mut self, place: &MetPlace);
}

/// Takes one walk from a receiver and returns the number of rays. The only luminaire of the scene is a sky, which has 1 cd/m² all around
/// for coefficients.
pub fn walk_for_coefficients(
    (world, openings): (&World, &Openings),
    receiver: &Receiver,
    (pass, cut): (&mut DirectPass, &mut Cut),
    tally: &mut impl CoefficientTally,
    stream: &mut Stream,
) -> u64 {
    let direction = cosine_hemisphere(receiver.normal, stream.pair());
    let rays = follow((world, openings), (*receiver.origin, direction), cut, tally, stream);
    let shadow_rays = pass.parts_at_point(world, receiver, stream, |lx, sample| {
        if let Some(towards) = direction_of(sample, receiver.point_m) {
            tally.add_sky(towards, lx, SkyPath::Straight);
        }
    });
    rays + shadow_rays
}

/// The direction of a light sample of the sky.
fn direction_of(look: &LightSample, from_m: DVec3) -> Option<DVec3> {
    match look.place {
        Some(Place::Free(end_m)) => (end_m - from_m).try_normalize(),
        _ => None,
    }
}

fn follow(
    (world, openings): (&World, &Openings),
    (mut origin, mut direction): (Origin, DVec3),
    cut: &mut Cut,
    tally: &mut impl CoefficientTally,
    stream: &mut Stream,
) -> u64 {
    let mut rays = 0;
    let mut is_mirrored = false;
    // It is determined by the first surface that scatters.
    let mut way = SkyPath::FromInside;
    let mut has_scattered = false;
    while rays < MOST_RAYS_OF_A_WALK {
        rays += 1;
        let hit = match world.tracer.first_hit(&origin, direction) {
            Meeting::Surface(hit) => hit,
            Meeting::Ball(_) => return rays,
            Meeting::Nothing => {
                // No light sample finds the sky in a mirror.
                if let Some(sky) = world.emitters.sky().filter(|_| is_mirrored) {
                    tally.add_sky(direction, PI * sky.luminance_cd_m2(direction), way);
                }
                return rays;
            }
        };
        let from_m = world.tracer.position_m(&origin);
        if !has_scattered && are_left_within(openings, from_m, direction, hit.distance_m) {
            way = SkyPath::FromOutside;
        }
        let bsdf = world.bsdf(hit.triangle);
        if bsdf.is_black() || !world.receives(hit.triangle, hit.side) {
            return rays;
        }
        if bsdf.scatters() {
            has_scattered = true;
            rays += sample_from(world, (&hit, direction, bsdf, way), cut, tally, stream);
        }
        let Some(scattered) = bsdf.sample(direction, world.normal_at(&hit), stream) else {
            return rays;
        };
        origin = world.leave(&hit, scattered.lobe);
        direction = scattered.direction;
        is_mirrored = match scattered.lobe {
            LobeKind::Mirrored => true,
            LobeKind::Passed => is_mirrored,
            LobeKind::Spread | LobeKind::Glossy | LobeKind::SpreadThrough => false,
        };
    }
    world.patience.note_walk_given_up();
    rays
}

/// Reports a surface point that scatters, and takes a light sample of the sky from it. Returns the number of rays.
fn sample_from(
    world: &World,
    (hit, direction, bsdf, sky_path): (&SurfaceHit, DVec3, &Bsdf, SkyPath),
    cut: &mut Cut,
    tally: &mut impl CoefficientTally,
    stream: &mut Stream,
) -> u64 {
    let met_normal = world.normal_at(hit);
    // A sheet transmits the light that arrives at its other side.
    let total = bsdf.total(1.0);
    let is_behind = matches!(bsdf, Bsdf::Translucent(sheet) if stream.unit() * total >= sheet.reflectance);
    let (lobe, normal, side) = match is_behind {
        true => (LobeKind::SpreadThrough, -met_normal, hit.side.other()),
        false => (LobeKind::Spread, met_normal, hit.side),
    };
    let response = match bsdf {
        Bsdf::Diffuse(_) | Bsdf::Translucent(_) => Response::Even(total),
        bsdf => Response::Directed(bsdf, normal, -direction),
    };
    let place = MetPlace { spot: (hit.triangle, side), barycentric: hit.barycentric, response };
    tally.met(&place);
    let origin = world.leave(hit, lobe);
    let receiver = Receiver { point_m: world.tracer.position_m(&origin), normal, origin: &origin };
    let cost = if matches!(place.response, Response::Even(_)) { SampleCost::Cheap } else { SampleCost::Full };
    let Some(sight) = one_light_sample(world, place.spot, &receiver, cost, cut, stream) else {
        return 0;
    };
    let lx = sight.direct_lx();
    if lx > 0.0 {
        tally.add_sky(sight.towards, place.brings(sight.towards) * lx, sky_path);
    }
    1
}
