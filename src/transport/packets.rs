//! Packets of near emitters: where they land, and what a point receives from there.
//!
//! A path from a walk's point to an emitter is found in several ways: the walk meets all of its surface points and takes a light sample at
//! the last one, or it meets some of them and then connects to a packet that has landed at all the others, from surface to surface. Each
//! way counts with the share of its density (multiple importance sampling: Veach and Guibas, 1995, "Optimally combining sampling techniques
//! for Monte Carlo rendering"): see docs/methods.md (42) and (55). Between two surface points that both a walk and a packet may meet, both
//! densities are the same, so it takes only running sums to weigh all ways.

use std::f64::consts::PI;

use glam::DVec3;

use super::World;
use super::near_emitters::NearEmitters;
use super::traced::Traced;
use crate::geometry::{Meeting, Origin, SurfaceHit};
use crate::sampling::random::Stream;
use crate::sampling::reflection::{Bsdf, LobeKind};
use crate::sampling::warp::cosine_hemisphere;

/// Factor on the probability with which a surface that a packet has met sends it on. Packets in a lampshade would go on for long.
const GOES_ON: f64 = 0.5;

/// A surface or receiver point in m and its unit normal.
pub type PointAndNormal = (DVec3, DVec3);

/// Later landings of packets, after the first, to which a point connects.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LaterLandings {
    /// To the first landing alone.
    None,
    /// To those on surfaces that scatter light to both sides.
    OnSheets,
    /// To all.
    All,
}

impl LaterLandings {
    #[inline]
    fn include(self, is_sheet: bool) -> bool {
        match self {
            LaterLandings::None => false,
            LaterLandings::OnSheets => is_sheet,
            LaterLandings::All => true,
        }
    }
}

/// A point from which a light-path connection to a packet has been made.
#[derive(Clone, Copy, Debug)]
pub struct ConnectedFrom {
    /// The point in m and its unit normal.
    pub place: PointAndNormal,
    /// The point in m for which the packet's emitter was drawn.
    pub drawn_for_m: DVec3,
    /// How the walk met the point. `None` if the point before it makes no connections to later landings there.
    pub met: Option<MetFrom>,
    /// Share of the light that the point sends on along the walk; 1 for receivers.
    pub sends: f64,
    /// To which later landings of packets it connects too.
    pub later: LaterLandings,
}

/// How a walk met a point, coming from a point that makes connections to later landings of packets.
#[derive(Clone, Copy, Debug)]
pub struct MetFrom {
    /// Probability over flux of packets drawn by flux, over the density of walks at the point, in m²/lm.
    drawn_m2_per_lm: f64,
    /// [`MetFrom::density_per_lx`] of the point before.
    before_per_lx: f64,
}

impl MetFrom {
    /// Density of packets that land at the point, and of those that land at points of the walk before it, over that of walks that meet them,
    /// for an illuminance of 1 lx at the spot. The surfaces between the spot and the point send on all light; the point sends on the share
    /// `sends`.
    #[inline]
    fn density_per_lx(&self, sends: f64) -> f64 {
        GOES_ON * (self.drawn_m2_per_lm + sends * self.before_per_lx)
    }
}

impl ConnectedFrom {
    /// How a walk from here meets a place. `None` if no connections to later landings there are made here, or if they do not see the place.
    #[inline]
    pub(super) fn meets(
        &self,
        near: &NearEmitters,
        is_sheet: bool,
        place: impl FnOnce() -> PointAndNormal,
    ) -> Option<MetFrom> {
        let met_per_m2 = if self.later.include(is_sheet) { seen_per_m2(place(), self.place) } else { 0.0 };
        (met_per_m2 > 0.0).then(|| MetFrom {
            drawn_m2_per_lm: near.drawn_by_flux_per_lm() / met_per_m2,
            before_per_lx: self.density_per_lx(),
        })
    }

    /// The same density for walks that go on from here.
    #[inline]
    fn density_per_lx(&self) -> f64 {
        self.met.map_or(0.0, |met| met.density_per_lx(self.sends))
    }
}

/// Result of a light-path connection to the spot where a packet of a near luminaire has landed.
#[derive(Clone, Copy, Debug)]
pub struct PacketConnection {
    /// Illuminance of the start point, in lx.
    pub lx: f64,
    /// Illuminance of the start point by way of the packet's later landings, in lx.
    pub later_lx: f64,
    /// Rays traced.
    pub rays: u64,
    /// Density in 1/m², at the spot, of walks from the start point.
    pub met_per_m2: f64,
    /// Density in 1/m² of packets at the same point.
    pub lit_per_m2: f64,
}

impl PacketConnection {
    pub(super) fn nothing(rays: u64) -> PacketConnection {
        PacketConnection { lx: 0.0, later_lx: 0.0, rays, met_per_m2: 0.0, lit_per_m2: 0.0 }
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
    /// Share of its light that it sends on along the walk; 1 for receivers.
    pub sends: f64,
    /// Factor by which that light counts.
    pub factor: f64,
}

/// A point that connects to packets, by one side or by either side of a sheet.
#[derive(Clone, Copy)]
pub struct ConnectingPoint<'a> {
    /// The side, or the front of the sheet.
    pub front: ConnectingSide<'a>,
    /// The other side of the sheet.
    pub behind: Option<ConnectingSide<'a>>,
    /// How a walk met the point. `None` if the point before it makes no connections to later landings there.
    pub met: Option<MetFrom>,
    /// To which later landings it connects too.
    pub later: LaterLandings,
}

impl<'a> ConnectingPoint<'a> {
    /// A receiver.
    pub fn receiver(place: PointAndNormal, origin: &'a Origin, later: LaterLandings) -> ConnectingPoint<'a> {
        let front = ConnectingSide { place, origin, sends: 1.0, factor: 1.0 };
        ConnectingPoint { front, behind: None, met: None, later }
    }

    /// The side that faces a point in m.
    fn facing(&self, point_m: DVec3) -> &ConnectingSide<'a> {
        let (front_m, normal) = self.front.place;
        let behind = self.behind.as_ref().filter(|_| (point_m - front_m).dot(normal) < 0.0);
        behind.unwrap_or(&self.front)
    }

    /// Density of packets that land here or before on the walk: [`MetFrom::density_per_lx`].
    fn density_per_lx(&self, side: &ConnectingSide) -> f64 {
        self.met.map_or(0.0, |met| met.density_per_lx(side.sends))
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

/// A packet at a landing after its first one, and what weighs the paths to there.
pub struct LandedAgain<'a> {
    spot: &'a LitSpot,
    /// Illuminance of the emitter at the spot in lx.
    lit_lx: f64,
    /// The side from which it left the landing before.
    from: LeavingSide,
    landing: Landing,
    /// Product of the shares that all surfaces before this one have sent on, and that of the factors on their probabilities.
    sent: f64,
    continued: f64,
    /// Density of all ways of finding the path so far, over that of walks that meet all of its points.
    found: f64,
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

    /// The point in m, and the normal of the side on which the packet has landed.
    fn place(&self, world: &World) -> PointAndNormal {
        self.side(world, LobeKind::Spread).place
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

    /// The side from which a packet leaves, if the surface sends it on, and where it lands next; and the number of rays traced.
    fn send_on(&self, world: &World, stream: &mut Stream) -> (Option<(LeavingSide, Landing)>, u64) {
        let [reflected, passed] = self.shares;
        let fate = stream.unit() / GOES_ON;
        if fate >= reflected + passed {
            return (None, 0);
        }
        let from = self.side(world, if fate < reflected { LobeKind::Spread } else { LobeKind::SpreadThrough });
        let direction = cosine_hemisphere(from.place.1, stream.pair());
        let (landing, rays) = Landing::of(world, from.origin, direction, stream);
        (landing.map(|landing| (from, landing)), rays)
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
    /// and against later landings at the point, if walks met it from where these count. Its rays are those that test visibility.
    pub fn seen_from(&self, world: &World, to: &ConnectingPoint) -> PacketConnection {
        let side = self.landing.side_towards(world, to.front.place.0);
        let to_side = to.facing(side.place.0);
        let (lit_per_m2, lit_lx) = self.lit(world, side.place.0);
        let met_per_m2 = seen_per_m2(side.place, to_side.place);
        if side.share <= 0.0 || met_per_m2 <= 0.0 || lit_lx <= 0.0 {
            return PacketConnection::nothing(0);
        }
        let found = PacketConnection { met_per_m2, lit_per_m2, ..PacketConnection::nothing(0) };
        if to_side.factor <= 0.0 {
            return found;
        }
        let later = lit_lx * side.share * to.density_per_lx(to_side);
        let all = 1.0 + world.roulette.connection_chance * (lit_per_m2 / met_per_m2 + later);
        let passed = world.transmittance(to_side.origin, &side.origin);
        PacketConnection { lx: to_side.factor * passed * lit_lx * side.share / all, rays: 1, ..found }
    }

    /// The packet where it lands next, if its spot sends it on, and the number of rays traced.
    pub fn land_again(
        &self,
        world: &World,
        near: &NearEmitters,
        stream: &mut Stream,
    ) -> (Option<LandedAgain<'_>>, u64) {
        let (next, rays) = self.landing.send_on(world, stream);
        let landed = next.and_then(|(from, landing)| {
            let (_, lit_lx) = self.lit(world, from.place.0);
            let place = landing.place(world);
            let drawn_m2_per_lm = near.drawn_per_lm(self.emitter, place.0) / seen_per_m2(from.place, place);
            let found = 1.0 + world.roulette.connection_chance * lit_lx * drawn_m2_per_lm;
            let sent = from.share;
            let landed = LandedAgain { spot: self, lit_lx, from, landing, sent, continued: GOES_ON, found };
            found.is_finite().then_some(landed)
        });
        (landed, rays)
    }
}

impl LandedAgain<'_> {
    /// Illuminance that a point receives from this landing in lx, times its factor, and the number of rays that test visibility. It is
    /// weighted against walks that meet all or some of the packet's landings, and against later landings at the point.
    pub fn seen_from(&self, world: &World, near: &NearEmitters, to: &ConnectingPoint) -> Traced {
        if !to.later.include(self.landing.is_sheet) {
            return Traced::default();
        }
        let side = self.landing.side_towards(world, to.front.place.0);
        let to_side = to.facing(side.place.0);
        let met_per_m2 = seen_per_m2(side.place, to_side.place);
        if met_per_m2 <= 0.0 || side.share <= 0.0 || to_side.factor <= 0.0 {
            return Traced::default();
        }
        let drawn_per_lm = near.drawn_by_flux_per_lm();
        let others_m2_per_lm = drawn_per_lm / met_per_m2 + side.share * to.density_per_lx(to_side);
        let all = self.found + self.density_lx(world) * others_m2_per_lm;
        let weight = drawn_per_lm / (self.spot.drawn_per_lm * all);
        let lx = self.lit_lx * self.sent * side.share * weight;
        Traced { value: to_side.factor * lx * world.transmittance(to_side.origin, &side.origin), rays: 1 }
    }

    /// What turns a density per lx at the spot, such as [`MetFrom::density_per_lx`], into that of this packet: the illuminance there in lx, times
    /// the share of it that arrives here and the probability of a connection.
    fn density_lx(&self, world: &World) -> f64 {
        world.roulette.connection_chance * self.lit_lx * self.sent * self.continued
    }

    /// The packet where it lands next, if this surface sends it on, and the number of rays traced.
    pub fn land_again(mut self, world: &World, near: &NearEmitters, stream: &mut Stream) -> (Option<Self>, u64) {
        let (next, rays) = self.landing.send_on(world, stream);
        let landed = next.and_then(|(from, landing)| {
            let met_per_m2 = seen_per_m2(from.place, landing.place(world));
            self.found += self.density_lx(world) * near.drawn_by_flux_per_lm() / met_per_m2;
            self.sent *= from.share;
            self.continued *= GOES_ON;
            (self.from, self.landing) = (from, landing);
            self.found.is_finite().then_some(self)
        });
        (landed, rays)
    }

    /// Ratio to a density in 1/m² of the harmonic sum of two: that of packets at the spot, and that of reflected packets here.
    pub fn ratio_to(&self, world: &World, per_m2: f64) -> f64 {
        let lit_per_m2 = self.lit_lx * self.spot.drawn_per_lm;
        let between_per_m2 = seen_per_m2(self.from.place, self.landing.place(world));
        1.0 / (per_m2 / lit_per_m2 + per_m2 / between_per_m2)
    }

    /// Share of the light that the surface sends on, to both sides together.
    pub fn leaving(&self) -> f64 {
        self.landing.shares.iter().sum()
    }
}

impl SampledPlace {
    /// Density of packets here, over that of walks from `from`, for an illuminance of 1 lx. Packets are drawn by flux.
    #[inline]
    pub(super) fn packets_per_lx(&self, world: &World, near: &NearEmitters, from: &ConnectedFrom) -> f64 {
        let others_m2_per_lm = self.others_m2_per_lm(near.drawn_by_flux_per_lm(), from);
        world.roulette.connection_chance * others_m2_per_lm.unwrap_or(0.0)
    }

    /// Weight of a light sample of a near emitter, beside the connections to packets. A walk met the place from `from`, where it made a
    /// connection: docs/methods.md (42) and (55).
    #[inline]
    pub(super) fn share(&self, world: &World, near: &NearEmitters, emitter: u32, from: &ConnectedFrom) -> f64 {
        let Some(others_m2_per_lm) = self.others_m2_per_lm(near.drawn_per_lm(emitter, from.drawn_for_m), from) else {
            return 1.0;
        };
        let lx = world.emitters.list()[emitter as usize].unshadowed_lx(self.lit.0, self.lit.1);
        1.0 / (1.0 + world.roulette.connection_chance * lx * others_m2_per_lm)
    }

    /// Density of packets, first and later landings, over that of walks from `from`, for 1 lx and if each vertex makes a connection. The
    /// probability that a packet is the emitter's is given over its flux in lm. `None` if the walk met the place by rounding alone: a
    /// connection does not see it.
    #[inline]
    fn others_m2_per_lm(&self, drawn_per_lm: f64, from: &ConnectedFrom) -> Option<f64> {
        let met_per_m2 = seen_per_m2((self.lit.0, self.seen), from.place);
        (met_per_m2 > 0.0).then(|| drawn_per_lm / met_per_m2 + self.leaving * from.density_per_lx())
    }
}

/// Density in 1/m² with which cosine-distributed rays from one point meet another, without occlusion.
fn seen_per_m2((point_m, normal): PointAndNormal, (from_m, from_normal): PointAndNormal) -> f64 {
    let offset_m = point_m - from_m;
    let square_m2 = offset_m.length_squared();
    let cosines = offset_m.dot(from_normal).max(0.0) * (-offset_m.dot(normal)).max(0.0);
    if cosines > 0.0 { cosines / (PI * square_m2 * square_m2) } else { 0.0 }
}
