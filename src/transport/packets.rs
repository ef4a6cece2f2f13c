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
    #[inline]
    pub fn meets(&self, place: impl FnOnce() -> PointAndNormal) -> Option<MetFrom> {
        let met_per_m2 = if self.lands_twice { seen_per_m2(place(), self.place) } else { 0.0 };
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

/// A side of a surface, or a receiver, that connects to packets.
#[derive(Clone, Copy)]
pub struct ConnectingSide<'a> {
    /// The point in m and its unit normal.
    pub place: PointAndNormal,
    /// The point for the tracer.
    pub origin: &'a Origin,
    /// Factor by which its illuminance counts.
    pub factor: f64,
}

/// A point that connects to packets, by one side or by either side of a sheet.
#[derive(Clone, Copy)]
pub struct ConnectingPoint<'a> {
    /// The side, or the front of the sheet.
    pub front: ConnectingSide<'a>,
    /// The other side of the sheet.
    pub behind: Option<ConnectingSide<'a>>,
    /// How a walk met the point. `None` if the point before it makes no connections to second landings.
    pub met: Option<MetFrom>,
    /// Whether it connects to second landings too.
    pub lands_twice: bool,
}

impl<'a> ConnectingPoint<'a> {
    /// A receiver. It connects to first landings alone.
    pub fn receiver(place: PointAndNormal, origin: &'a Origin) -> ConnectingPoint<'a> {
        let front = ConnectingSide { place, origin, factor: 1.0 };
        ConnectingPoint { front, behind: None, met: None, lands_twice: false }
    }

    /// The side that faces a point in m.
    fn facing(&self, point_m: DVec3) -> &ConnectingSide<'a> {
        let (front_m, normal) = self.front.place;
        let behind = self.behind.as_ref().filter(|_| (point_m - front_m).dot(normal) < 0.0);
        behind.unwrap_or(&self.front)
    }
}

/// A side of a surface from which the light of a packet leaves.
struct LeavingSide {
    origin: Origin,
    place: PointAndNormal,
    /// Share of the light that leaves here.
    share: f64,
}

/// Surface point where a packet has landed.
struct Landing {
    hit: SurfaceHit,
    /// Unit normal of the side on which it has landed.
    normal: DVec3,
    /// Shares of its light that the surface reflects and transmits.
    shares: [f64; 2],
    is_sheet: bool,
}

/// Surface point where a packet of a near luminaire has landed.
pub struct LitSpot {
    /// The emitter.
    emitter: u32,
    /// Probability that the emitter was drawn, over its flux in lm.
    drawn_per_lm: f64,
    landing: Landing,
}

/// Surface point where a packet has landed after its spot has reflected it.
pub struct SecondLanding {
    /// The side of the spot from which it came.
    from: LeavingSide,
    landing: Landing,
}

impl Landing {
    /// Where a packet's ray lands past panes, and the number of rays traced. `None` if no surface that scatters is met, or if a pane does
    /// not let the packet pass.
    fn of(world: &World, mut origin: Origin, direction: DVec3, stream: &mut Stream) -> (Option<Landing>, u64) {
        let mut rays = 0;
        loop {
            rays += 1;
            let Meeting::Surface(hit) = world.tracer.first_hit(&origin, direction) else {
                return (None, rays);
            };
            if !world.receives(hit.triangle, hit.side) || world.is_touched(&origin, &hit) {
                return (None, rays);
            }
            let normal = world.normal_at(&hit);
            match world.bsdf(hit.triangle) {
                bsdf @ (Bsdf::Diffuse(_) | Bsdf::Translucent(_)) => {
                    let is_sheet = matches!(bsdf, Bsdf::Translucent(_));
                    return (Some(Landing { hit, normal, shares: bsdf.diffuse_shares(), is_sheet }), rays);
                }
                bsdf @ Bsdf::Glass(_) => match bsdf.sample(direction, normal, stream) {
                    Some(scattered) if scattered.lobe == LobeKind::Passed => {
                        origin = world.leave(&hit, scattered.lobe);
                    }
                    _ => return (None, rays),
                },
                _ => return (None, rays),
            }
        }
    }

    /// The side from which light leaves in a direction of this kind.
    fn side(&self, world: &World, lobe: LobeKind) -> LeavingSide {
        let origin = world.leave(&self.hit, lobe);
        let point_m = world.tracer.position_m(&origin);
        let [reflected, passed] = self.shares;
        match lobe {
            LobeKind::SpreadThrough => LeavingSide { origin, place: (point_m, -self.normal), share: passed },
            _ => LeavingSide { origin, place: (point_m, self.normal), share: reflected },
        }
    }

    /// The side from which light leaves towards a point in m.
    fn side_towards(&self, world: &World, point_m: DVec3) -> LeavingSide {
        let front = self.side(world, LobeKind::Spread);
        let is_behind = self.is_sheet && (point_m - front.place.0).dot(self.normal) < 0.0;
        if is_behind { self.side(world, LobeKind::SpreadThrough) } else { front }
    }
}

impl LitSpot {
    /// Where a packet of an emitter lands, and the number of rays traced. `None` if it lands on no surface that scatters. The probability
    /// with which the emitter was drawn is given over its flux in lm.
    pub fn land(world: &World, (emitter, drawn_per_lm): (u32, f64), stream: &mut Stream) -> (Option<LitSpot>, u64) {
        let emitted = world.emitters.list()[emitter as usize].emit(stream);
        let (landing, rays) = Landing::of(world, world.origin(&emitted.place), emitted.direction, stream);
        (landing.map(|landing| LitSpot { emitter, drawn_per_lm, landing }), rays)
    }

    /// The surface point.
    pub fn hit(&self) -> &SurfaceHit {
        &self.landing.hit
    }

    /// Unit normal of the lit side.
    pub fn normal(&self) -> DVec3 {
        self.landing.normal
    }

    /// Reflectance of a surface that scatters light only to the lit side. `None` for a sheet.
    pub fn reflectance(&self) -> Option<f64> {
        (!self.landing.is_sheet).then_some(self.landing.shares[0])
    }

    /// Density in 1/m² of such packets at a point of the spot's surface in m, and the emitter's illuminance there in lx.
    pub fn lit(&self, world: &World, point_m: DVec3) -> (f64, f64) {
        let lx = world.emitters.list()[self.emitter as usize].unshadowed_lx(point_m, self.landing.normal);
        (lx * self.drawn_per_lm, lx)
    }

    /// Illuminance that a point receives from the spot, times its factor. It is weighted against walks that meet the spot from the point,
    /// and against second landings at the point, if walks met it from where these count. Its rays are those that test visibility.
    pub fn seen_from(&self, world: &World, near: &NearEmitters, to: &ConnectingPoint) -> PacketConnection {
        let (side, met) = (self.landing.side_towards(world, to.front.place.0), to.met);
        let to = to.facing(side.place.0);
        let found = self.unoccluded(world, near, &side, to.place, met, self.drawn_per_lm);
        if found.lx <= 0.0 || to.factor <= 0.0 {
            return PacketConnection { lx: 0.0, ..found };
        }
        let passed = world.transmittance(to.origin, &side.origin);
        PacketConnection { lx: to.factor * passed * found.lx, rays: 1, ..found }
    }

    /// The same for one side without occlusion and factor. Packets for the point are drawn with a probability of `drawn_per_lm`, over the
    /// emitter's flux in lm.
    fn unoccluded(
        &self,
        world: &World,
        near: &NearEmitters,
        side: &LeavingSide,
        to: PointAndNormal,
        met: Option<MetFrom>,
        drawn_per_lm: f64,
    ) -> PacketConnection {
        let (met_per_m2, lit_lx) = (seen_per_m2(side.place, to), self.lit(world, side.place.0).1);
        if side.share <= 0.0 || met_per_m2 <= 0.0 || lit_lx <= 0.0 {
            return PacketConnection::nothing(0);
        }
        let second = met.map_or(0.0, |met| met.second_per_lm(near, self.emitter, side.share, met_per_m2));
        let all_per_m2 = met_per_m2 + world.roulette.connection_chance * lit_lx * (drawn_per_lm + second);
        let lx = lit_lx * side.share * met_per_m2 / all_per_m2;
        PacketConnection { lx, met_per_m2, lit_per_m2: lit_lx * drawn_per_lm, ..PacketConnection::nothing(0) }
    }

    /// Where the packet lands next, if its spot reflects or transmits it, and the number of rays traced.
    pub fn land_again(&self, world: &World, stream: &mut Stream) -> (Option<SecondLanding>, u64) {
        let [reflected, passed] = self.landing.shares;
        let fate = stream.unit();
        if fate >= reflected + passed {
            return (None, 0);
        }
        let lobe = if fate < reflected { LobeKind::Spread } else { LobeKind::SpreadThrough };
        let from = self.landing.side(world, lobe);
        let direction = cosine_hemisphere(from.place.1, stream.pair());
        let (landing, rays) = Landing::of(world, from.origin, direction, stream);
        (landing.map(|landing| SecondLanding { from, landing }), rays)
    }

    /// Illuminance that a point receives by way of a second landing in lx, times its factor, and the number of rays that test visibility. It
    /// is weighted against walks from the point that meet the landing.
    pub fn seen_by_second_landing(
        &self,
        world: &World,
        near: &NearEmitters,
        second: &SecondLanding,
        to: &ConnectingPoint,
    ) -> (f64, u64) {
        let side = second.landing.side_towards(world, to.front.place.0);
        let drawn_for_m = to.front.place.0;
        let to = to.facing(side.place.0);
        let met_per_m2 = seen_per_m2(side.place, to.place);
        if met_per_m2 <= 0.0 || side.share <= 0.0 || to.factor <= 0.0 {
            return (0.0, 0);
        }
        let (landed_m, _) = side.place;
        let met = Some(MetFrom { met_per_m2, drawn_for_m });
        let drawn_per_lm = near.drawn_per_lm(self.emitter, landed_m);
        let found = self.unoccluded(world, near, &second.from, (landed_m, second.landing.normal), met, drawn_per_lm);
        if found.lx <= 0.0 {
            return (0.0, 0);
        }
        (to.factor * side.share * found.lx * world.transmittance(to.origin, &side.origin), 1)
    }

    /// Ratio to a density in 1/m² of the harmonic sum of two: that of packets at the spot, and that of reflected packets at the landing.
    pub fn ratio_at(&self, world: &World, second: &SecondLanding, per_m2: f64) -> f64 {
        let (lit_per_m2, _) = self.lit(world, second.from.place.0);
        let landed_m = second.landing.side(world, LobeKind::Spread).place.0;
        let between_per_m2 = seen_per_m2(second.from.place, (landed_m, second.landing.normal));
        1.0 / (per_m2 / lit_per_m2 + per_m2 / between_per_m2)
    }
}

impl SecondLanding {
    /// Share of the light that the surface sends on, to both sides together.
    pub fn leaving(&self) -> f64 {
        self.landing.shares.iter().sum()
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

impl SampledPlace {
    /// Weight of a light sample of a near emitter, beside the connections to packets. A walk met the place from `from`, where it made a
    /// connection: docs/methods.md (42) and (55).
    #[inline]
    pub(super) fn share(&self, world: &World, near: &NearEmitters, emitter: u32, from: &ConnectedFrom) -> f64 {
        let met_per_m2 = seen_per_m2((self.lit.0, self.seen), from.place);
        if met_per_m2 <= 0.0 {
            // The walk met the point by rounding alone: a connection does not see it.
            return 1.0;
        }
        let lx = world.emitters.list()[emitter as usize].unshadowed_lx(self.lit.0, self.lit.1);
        let second = from.met.map_or(0.0, |met| met.second_per_lm(near, emitter, self.leaving, met_per_m2));
        let drawn_per_lm = near.drawn_per_lm(emitter, from.drawn_for_m);
        met_per_m2 / (met_per_m2 + world.roulette.connection_chance * lx * (drawn_per_lm + second))
    }
}

/// Density in 1/m² with which cosine-distributed rays from one point meet another, without occlusion.
fn seen_per_m2((point_m, normal): PointAndNormal, (from_m, from_normal): PointAndNormal) -> f64 {
    let offset_m = point_m - from_m;
    let square_m2 = offset_m.length_squared();
    let cosines = offset_m.dot(from_normal).max(0.0) * (-offset_m.dot(normal)).max(0.0);
    if cosines > 0.0 { cosines / (PI * square_m2 * square_m2) } else { 0.0 }
}
