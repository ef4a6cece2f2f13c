//! Packets of near emitters: where they land, and what a point receives from there.
//!
//! A path from a walk's point z by way of a surface point x to an emitter is found in two ways: the walk meets x and takes a light sample
//! there, or z connects to a packet that landed at x. A path from z by way of y and x is found in three ways: the walk meets both, or it
//! meets y and connects to x, or z connects to a packet that was reflected at x and landed at y. Each way counts with the share of its
//! density (multiple importance sampling: Veach and Guibas, 1995, "Optimally combining sampling techniques for Monte Carlo rendering"): see
//! docs/methods.md (42) and (55).

use std::f64::consts::PI;

use glam::DVec3;

use super::World;
use super::near_emitters::NearEmitters;
use crate::geometry::{Meeting, Origin, SurfaceHit};
use crate::sampling::random::Stream;
use crate::sampling::reflection::{Bsdf, LobeKind};
use crate::sampling::warp::cosine_hemisphere;

/// A surface or receiver point in m and its unit normal.
pub type PointAndNormal = (DVec3, DVec3);

/// A point from which a light-path connection to a packet has been made.
#[derive(Clone, Copy, Debug)]
pub struct ConnectedFrom {
    /// The point in m and its unit normal.
    pub place: PointAndNormal,
    /// The point in m for which the packet's emitter was drawn.
    pub drawn_for_m: DVec3,
    /// How the walk met the point. `None` if the point before it makes no connections to second landings.
    pub met: Option<MetFrom>,
    /// Whether it makes connections to second landings of packets too.
    pub lands_twice: bool,
}

/// How a walk met a point, coming from a point that makes connections to second landings of packets.
#[derive(Clone, Copy, Debug)]
pub struct MetFrom {
    /// Density in 1/m² with which walks meet it.
    met_per_m2: f64,
    /// The point in m for which the emitter of the packet was drawn.
    drawn_for_m: DVec3,
}

impl ConnectedFrom {
    /// How a walk from here meets a place. `None` if no connections to second landings are made here, or if they do not see the place.
    pub fn meets(&self, place: PointAndNormal) -> Option<MetFrom> {
        let met_per_m2 = if self.lands_twice { seen_per_m2(place, self.place) } else { 0.0 };
        (met_per_m2 > 0.0).then_some(MetFrom { met_per_m2, drawn_for_m: self.drawn_for_m })
    }
}

/// Result of a light-path connection to the spot where a packet of a near luminaire has landed.
#[derive(Clone, Copy, Debug)]
pub struct PacketConnection {
    /// Illuminance of the start point, in lx.
    pub lx: f64,
    /// Illuminance of the start point by way of the packet's second landing, in lx.
    pub second_lx: f64,
    /// Rays traced.
    pub rays: u64,
    /// Density in 1/m², at the spot, of walks from the start point.
    pub met_per_m2: f64,
    /// Density in 1/m² of packets at the same point.
    pub lit_per_m2: f64,
}

impl PacketConnection {
    pub(super) fn nothing(rays: u64) -> PacketConnection {
        PacketConnection { lx: 0.0, second_lx: 0.0, rays, met_per_m2: 0.0, lit_per_m2: 0.0 }
    }
}

/// A surface point where a light sample of a near luminaire is taken.
pub struct SampledPlace {
    /// The point in m and the normal of the side that the luminaire lights.
    pub lit: PointAndNormal,
    /// Normal of the side from which the walk came.
    pub seen: DVec3,
    /// Share of the light that leaves towards the walk.
    pub leaving: f64,
}

/// Share of a packet's light that a surface sends on.
enum Leaving {
    /// One side reflects the light, by its reflectance.
    Reflected(f64),
    /// A sheet scatters the light to both sides.
    EitherSide { reflected: f64, passed: f64 },
}

/// A side of a surface from which the light of a packet leaves.
struct LitSide {
    origin: Origin,
    place: PointAndNormal,
    /// Share of the light that leaves here.
    leaving: f64,
}

/// Surface point where a packet of a near luminaire has landed.
pub struct LitSpot {
    /// The emitter.
    emitter: u32,
    /// Probability that the emitter was drawn, over its flux in lm.
    drawn_per_lm: f64,
    /// The surface point.
    pub hit: SurfaceHit,
    /// Unit normal of the lit side.
    pub normal: DVec3,
    leaving: Leaving,
}

/// Diffuse surface point where a packet has landed after it was reflected at its spot.
pub struct SecondLanding {
    side: LitSide,
    pub place: PointAndNormal,
    origin: Origin,
    pub reflectance: f64,
}

impl LitSpot {
    /// Where a packet of an emitter lands, and the number of rays traced. `None` if it lands on no surface that scatters. The probability
    /// with which the emitter was drawn is given over its flux in lm.
    pub fn land(world: &World, (emitter, drawn_per_lm): (u32, f64), stream: &mut Stream) -> (Option<LitSpot>, u64) {
        let emitted = world.emitters.list()[emitter as usize].emit(stream);
        let origin = world.origin(&emitted.place);
        let (hit, rays) = past_panes(world, origin, emitted.direction, stream);
        let spot = hit.and_then(|hit| {
            let leaving = match world.bsdf(hit.triangle) {
                Bsdf::Diffuse(bsdf) => Leaving::Reflected(bsdf.reflectance),
                Bsdf::Translucent(bsdf) => {
                    Leaving::EitherSide { reflected: bsdf.reflectance, passed: bsdf.transmittance }
                }
                _ => return None,
            };
            Some(LitSpot { emitter, drawn_per_lm, hit, normal: world.normal_at(&hit), leaving })
        });
        (spot, rays)
    }

    /// Reflectance of a surface that scatters light only to the lit side. `None` for a sheet.
    pub fn reflectance(&self) -> Option<f64> {
        match self.leaving {
            Leaving::Reflected(reflectance) => Some(reflectance),
            Leaving::EitherSide { .. } => None,
        }
    }

    /// Density in 1/m² of such packets at a point of the spot's surface in m, and the emitter's illuminance there in lx.
    pub fn lit(&self, world: &World, point_m: DVec3) -> (f64, f64) {
        let lx = world.emitters.list()[self.emitter as usize].unshadowed_lx(point_m, self.normal);
        (lx * self.drawn_per_lm, lx)
    }

    /// The side from which light leaves in a direction of this kind.
    fn side(&self, world: &World, lobe: LobeKind) -> LitSide {
        let origin = world.leave(&self.hit, lobe);
        let point_m = world.tracer.position_m(&origin);
        match (lobe, &self.leaving) {
            (LobeKind::SpreadThrough, Leaving::EitherSide { passed, .. }) => {
                LitSide { origin, place: (point_m, -self.normal), leaving: *passed }
            }
            (_, Leaving::Reflected(reflected) | Leaving::EitherSide { reflected, .. }) => {
                LitSide { origin, place: (point_m, self.normal), leaving: *reflected }
            }
        }
    }

    /// Illuminance of a point from the spot, weighted against walks that meet the spot from the point, or that met the point itself from a
    /// point with connections to second landings. Its rays are those that test visibility.
    pub fn seen_from(
        &self,
        world: &World,
        near: &NearEmitters,
        (to, to_origin): (PointAndNormal, &Origin),
        met: Option<MetFrom>,
    ) -> PacketConnection {
        let is_behind = self.reflectance().is_none() && {
            let lit_m = world.tracer.position_m(&world.leave(&self.hit, LobeKind::Spread));
            (to.0 - lit_m).dot(self.normal) < 0.0
        };
        let side = self.side(world, if is_behind { LobeKind::SpreadThrough } else { LobeKind::Spread });
        let found = self.unoccluded(world, near, &side, to, met, self.drawn_per_lm);
        if found.lx <= 0.0 {
            return found;
        }
        let passed = world.transmittance(to_origin, &side.origin);
        PacketConnection { lx: passed * found.lx, rays: 1, ..found }
    }

    /// The same without occlusion. Packets for the point are drawn with a probability of `drawn_per_lm`, over the emitter's flux in lm.
    fn unoccluded(
        &self,
        world: &World,
        near: &NearEmitters,
        side: &LitSide,
        to: PointAndNormal,
        met: Option<MetFrom>,
        drawn_per_lm: f64,
    ) -> PacketConnection {
        let (point_m, _) = side.place;
        let (met_per_m2, lit_lx) = (seen_per_m2(side.place, to), self.lit(world, point_m).1);
        if side.leaving <= 0.0 || met_per_m2 <= 0.0 || lit_lx <= 0.0 {
            return PacketConnection::nothing(0);
        }
        let second = met.map_or(0.0, |met| met.second_per_lm(near, self.emitter, side.leaving, met_per_m2));
        let all_per_m2 = met_per_m2 + world.roulette.connection_chance * lit_lx * (drawn_per_lm + second);
        let lx = lit_lx * side.leaving * met_per_m2 / all_per_m2;
        PacketConnection { lx, met_per_m2, lit_per_m2: lit_lx * drawn_per_lm, ..PacketConnection::nothing(0) }
    }

    /// Where the packet lands next, if its spot reflects it and if it lands on a diffuse surface, and the number of rays traced.
    pub fn land_again(&self, world: &World, stream: &mut Stream) -> (Option<SecondLanding>, u64) {
        let fate = stream.unit();
        let lobe = match self.leaving {
            Leaving::Reflected(reflected) if fate < reflected => LobeKind::Spread,
            Leaving::EitherSide { reflected, .. } if fate < reflected => LobeKind::Spread,
            Leaving::EitherSide { reflected, passed } if fate < reflected + passed => LobeKind::SpreadThrough,
            _ => return (None, 0),
        };
        let side = self.side(world, lobe);
        let direction = cosine_hemisphere(side.place.1, stream.pair());
        let (hit, rays) = past_panes(world, side.origin, direction, stream);
        let landing = hit.and_then(|hit| {
            let Bsdf::Diffuse(bsdf) = world.bsdf(hit.triangle) else {
                return None;
            };
            let origin = world.leave(&hit, LobeKind::Spread);
            let place = (world.tracer.position_m(&origin), world.normal_at(&hit));
            Some(SecondLanding { side, place, origin, reflectance: bsdf.reflectance })
        });
        (landing, rays)
    }

    /// Illuminance of a point in lx by way of a second landing, weighted against walks from the point that meet the landing, and the number
    /// of rays that test visibility.
    pub fn seen_by_second_landing(
        &self,
        world: &World,
        near: &NearEmitters,
        landing: &SecondLanding,
        (to, to_origin): (PointAndNormal, &Origin),
    ) -> (f64, u64) {
        let met_per_m2 = seen_per_m2(landing.place, to);
        if met_per_m2 <= 0.0 {
            return (0.0, 0);
        }
        let met = Some(MetFrom { met_per_m2, drawn_for_m: to.0 });
        let drawn_per_lm = near.drawn_per_lm(self.emitter, landing.place.0);
        let found = self.unoccluded(world, near, &landing.side, landing.place, met, drawn_per_lm);
        if found.lx <= 0.0 {
            return (0.0, 0);
        }
        (landing.reflectance * found.lx * world.transmittance(to_origin, &landing.origin), 1)
    }

    /// Ratio to a density in 1/m² of the harmonic sum of two: that of packets at the spot, and that of reflected packets at the landing.
    pub fn ratio_at(&self, world: &World, landing: &SecondLanding, per_m2: f64) -> f64 {
        let (lit_per_m2, _) = self.lit(world, landing.side.place.0);
        let between_per_m2 = seen_per_m2(landing.side.place, landing.place);
        1.0 / (per_m2 / lit_per_m2 + per_m2 / between_per_m2)
    }
}

impl MetFrom {
    /// Density of second landings relative to that of walks that met the point, per illuminance in lx at a spot that the point sees with the
    /// density `seen_per_m2`, in 1/m², and that sends on the share `leaving`.
    #[inline]
    fn second_per_lm(&self, near: &NearEmitters, emitter: u32, leaving: f64, seen_per_m2: f64) -> f64 {
        leaving * near.drawn_per_lm(emitter, self.drawn_for_m) * seen_per_m2 / self.met_per_m2
    }
}

/// Weight of a light sample of a near emitter at a diffuse point, beside the connections to packets. A walk met the point from `from`, where
/// it made a connection: docs/methods.md (42) and (55).
#[inline]
pub(super) fn share_of_light_sample(
    world: &World,
    near: &NearEmitters,
    emitter: u32,
    place: &SampledPlace,
    from: &ConnectedFrom,
) -> f64 {
    let met_per_m2 = seen_per_m2((place.lit.0, place.seen), from.place);
    if met_per_m2 <= 0.0 {
        // The walk met the point by rounding alone: a connection does not see it.
        return 1.0;
    }
    let lx = world.emitters.list()[emitter as usize].unshadowed_lx(place.lit.0, place.lit.1);
    let second = from.met.map_or(0.0, |met| met.second_per_lm(near, emitter, place.leaving, met_per_m2));
    let drawn_per_lm = near.drawn_per_lm(emitter, from.drawn_for_m);
    met_per_m2 / (met_per_m2 + world.roulette.connection_chance * lx * (drawn_per_lm + second))
}

/// The first surface on a packet's ray that is not a pane, and the number of rays traced. `None` if it meets none, or one that only absorbs,
/// or if a pane does not let the packet pass.
fn past_panes(world: &World, mut origin: Origin, direction: DVec3, stream: &mut Stream) -> (Option<SurfaceHit>, u64) {
    let mut rays = 0;
    loop {
        rays += 1;
        let Meeting::Surface(hit) = world.tracer.first_hit(&origin, direction) else {
            return (None, rays);
        };
        if !world.receives(hit.triangle, hit.side) || world.is_touched(&origin, &hit) {
            return (None, rays);
        }
        let bsdf = world.bsdf(hit.triangle);
        if !matches!(bsdf, Bsdf::Glass(_)) {
            return (Some(hit), rays);
        }
        match bsdf.sample(direction, world.normal_at(&hit), stream) {
            Some(scattered) if scattered.lobe == LobeKind::Passed => origin = world.leave(&hit, scattered.lobe),
            _ => return (None, rays),
        }
    }
}

/// Density in 1/m² with which cosine-distributed rays from one point meet another, without occlusion.
fn seen_per_m2((point_m, normal): PointAndNormal, (from_m, from_normal): PointAndNormal) -> f64 {
    let offset_m = point_m - from_m;
    let square_m2 = offset_m.length_squared();
    let cosines = offset_m.dot(from_normal).max(0.0) * (-offset_m.dot(normal)).max(0.0);
    if cosines > 0.0 { cosines / (PI * square_m2 * square_m2) } else { 0.0 }
}
