//! Walks from a receiver back towards the luminaires: the simplest unbiased estimator of indirect illuminance with finite variance.
//!
//! E_indirect(x) = ∫ ρ(r′)/π · E(r′) cos θ dω. A direction drawn with density cos θ/π leaves exactly ρ(r′) E(r′) to score, so
//! docs/methods.md (1) becomes docs/methods.md (5). The direct part of E(r′) is computed at r′. For the indirect part the walk continues
//! with its weight times ρ, and by roulette if the weight has become small: see [`crate::transport::Roulette`]. No score contains a 1/r² of two
//! surfaces, so corners are harmless.
//!
//! At every vertex that scatters, one light sample finds the visible luminaires, and another sample finds those in flat mirrors. The walk's
//! own ray finds the rest: luminaires that it meets by way of curved mirrors, and, for the lobe of a glossy surface, luminaires that it
//! meets directly. There light sample and ray are combined by their densities (Veach and Guibas, 1995, "Optimally combining sampling
//! techniques for Monte Carlo rendering"), so every path counts once.

mod vertex;

use std::f64::consts::{FRAC_1_PI, PI};

use glam::DVec3;

use self::vertex::{Departure, Vertex, connecting_point, from_near_luminaires_lx, met_lm_m2};
pub use self::vertex::{evenly, searched_lx, trail_from};
use crate::estimators::cache::{Cache, CacheAnswer, Met, WalkEvent};
use crate::estimators::images::Trail;
use crate::estimators::receiver::Receiver;
use crate::geometry::{Meeting, Origin, SurfaceHit};
use crate::sampling::emitter_tree::Cut;
use crate::sampling::random::Stream;
use crate::sampling::reflection::{Bsdf, Diffuse, LobeKind};
use crate::sampling::warp::cosine_hemisphere;
use crate::transport::{ConnectedFrom, ConnectingPoint, LaterLandings, MetFrom, NearLuminaires, Traced, World};

/// A cache without content: walks continue until they are absorbed or leave.
struct Blank;

impl Cache for Blank {
    #[inline]
    fn look_up(&mut self, _: &Met, _: &mut Cut, _: &mut Stream) -> (CacheAnswer, u64) {
        (CacheAnswer::Nothing, 0)
    }
}

/// One unbiased sample of the indirect illuminance at a receiver in lx, and the number of rays.
pub fn sample_indirect_lx(world: &World, receiver: &Receiver, cut: &mut Cut, stream: &mut Stream) -> Traced {
    walk_indirect_lx(world, receiver, &mut Blank, cut, stream)
}

/// One sample of the indirect illuminance at a receiver in lx, and the number of rays. The walk ends at the first diffuse surface whose
/// indirect light the cache supplies. The sample is as accurate as the cache.
pub fn walk_indirect_lx(
    world: &World,
    receiver: &Receiver,
    cache: &mut impl Cache,
    cut: &mut Cut,
    stream: &mut Stream,
) -> Traced {
    let variates = stream.pair();
    let ([sampled_lx, arriving_lx], rays) = walk_parts_lx(world, receiver, variates, cache, cut, stream);
    Traced { value: sampled_lx + arriving_lx, rays }
}

/// Returns two parts in lx and the number of rays: what samples taken at the receiver find, and what arrives along the direction given by
/// two variates in [0, 1).
#[inline]
pub fn walk_parts_lx<C: Cache>(
    world: &World,
    receiver: &Receiver,
    variates: [f64; 2],
    cache: &mut C,
    cut: &mut Cut,
    stream: &mut Stream,
) -> ([f64; 2], u64) {
    let mut sampled = searched_lx(world, receiver, 1.0, |_| evenly(1.0, FRAC_1_PI), cut, stream);
    if let Some(lights) = &world.near_luminaires {
        let place = (receiver.point_m, receiver.normal);
        let point = ConnectingPoint::receiver(place, receiver.origin, in_sight::<C>(world, lights));
        sampled += from_near_luminaires_lx((world, lights), &point, 1.0, cache, stream);
    }
    let arriving = arriving_lx(world, receiver, variates, cache, cut, stream);
    ([sampled.value, arriving.value], sampled.rays + arriving.rays)
}

/// Illuminance in lx that arrives along the direction given by two variates, without what samples taken at the receiver find; and the
/// number of rays.
#[inline]
pub fn arriving_lx(
    world: &World,
    receiver: &Receiver,
    variates: [f64; 2],
    cache: &mut impl Cache,
    cut: &mut Cut,
    stream: &mut Stream,
) -> Traced {
    arriving_beside_packets_lx(world, (receiver, receiver.point_m), variates, cache, cut, stream)
}

/// The same beside packets of near luminaires that were drawn for another point in m.
#[inline]
pub fn arriving_beside_packets_lx<C: Cache>(
    world: &World,
    (receiver, drawn_for_m): (&Receiver, DVec3),
    variates: [f64; 2],
    cache: &mut C,
    cut: &mut Cut,
    stream: &mut Stream,
) -> Traced {
    let place = (receiver.point_m, receiver.normal);
    let connected_from =
        |lights| ConnectedFrom { place, drawn_for_m, met: None, sends: 1.0, later: in_sight::<C>(world, lights) };
    let start = Start {
        origin: *receiver.origin,
        direction: cosine_hemisphere(receiver.normal, variates),
        trail: trail_from(world, 1.0, || (receiver.point_m, receiver.normal, FRAC_1_PI)),
        connected_from: world.near_luminaires.as_ref().map(connected_from),
    };
    follow_lm_m2(world, start, |_, _| [1.0; 2], cache, cut, stream)
}

/// One unbiased sample of a part of the indirect illuminance, and the number of rays. `share_of` weights the light that the first
/// scattering surface spreads to the receiver. It gets the surface point (in m) and the unit normal of its lit side. It returns one share
/// for light directly from luminaires and one for light reflected before. Light from a lobe or a mirror counts in full.
pub fn sample_share_lx(
    world: &World,
    receiver: &Receiver,
    share_of: impl Fn(DVec3, DVec3) -> [f64; 2],
    cut: &mut Cut,
    stream: &mut Stream,
) -> Traced {
    let direction = cosine_hemisphere(receiver.normal, stream.pair());
    let mirrored = searched_lx(world, receiver, 1.0, |_| evenly(1.0, FRAC_1_PI), cut, stream);
    let trail = trail_from(world, 1.0, || (receiver.point_m, receiver.normal, FRAC_1_PI));
    let start = Start { origin: *receiver.origin, direction, trail, connected_from: None };
    mirrored + follow_lm_m2(world, start, share_of, &mut Blank, cut, stream)
}

/// One unbiased sample of π times the reflected luminance that arrives along a direction, in lx, and the number of rays. It equals the
/// illuminance of a surface that sees this luminance everywhere. Points in mirrors along the direction are not included.
pub fn sample_arriving_lx(
    world: &World,
    origin: Origin,
    direction: DVec3,
    cut: &mut Cut,
    stream: &mut Stream,
) -> Traced {
    walk_arriving_lx(world, origin, direction, &mut Blank, cut, stream)
}

/// The same with a cache, which supplies what comes after diffuse surfaces or counts it by itself.
pub fn walk_arriving_lx(
    world: &World,
    origin: Origin,
    direction: DVec3,
    cache: &mut impl Cache,
    cut: &mut Cut,
    stream: &mut Stream,
) -> Traced {
    let start = Start { origin, direction, trail: None, connected_from: None };
    follow_lm_m2(world, start, |_, _| [1.0; 2], cache, cut, stream)
}

/// One unbiased sample of a part of it, weighted as in [`sample_share_lx`]. A trail means that the start point has searched for areas in
/// mirrors.
pub fn sample_arriving_share_lx(
    world: &World,
    (origin, trail): (Origin, Option<Trail>),
    direction: DVec3,
    share_of: impl Fn(DVec3, DVec3) -> [f64; 2],
    cut: &mut Cut,
    stream: &mut Stream,
) -> Traced {
    let start = Start { origin, direction, trail, connected_from: None };
    follow_lm_m2(world, start, share_of, &mut Blank, cut, stream)
}

/// The first ray of a walk.
struct Start {
    /// Start point.
    origin: Origin,
    /// Unit direction.
    direction: DVec3,
    /// Its path by mirrors, if the start point has searched for areas in mirrors.
    trail: Option<Trail>,
    /// Start point and normal, if that point has made a light-path connection to near luminaires (looked back).
    connected_from: Option<ConnectedFrom>,
}

/// Rays after which a walk is given up: thirty times the expected length in the whitest room that is accepted. A walk reaches it only in a
/// white space that no luminaire's light enters, where it would never end.
pub const MOST_RAYS_OF_A_WALK: u64 = 600_000;

/// One sample of π times the luminance that comes along a ray, without the emitters visible from its start, and the number of rays. Light
/// that the first surface spreads is weighted by the shares of its point and normal.
fn follow_lm_m2(
    world: &World,
    start: Start,
    share_of: impl Fn(DVec3, DVec3) -> [f64; 2],
    cache: &mut impl Cache,
    cut: &mut Cut,
    stream: &mut Stream,
) -> Traced {
    let Start { origin, direction, trail, connected_from } = start;
    let mut walk = Walk {
        world,
        origin,
        direction,
        trail,
        connected_from,
        departure: Departure::Seen,
        has_scattered: false,
        surfaces: 0,
        weight: 1.0,
        found: Traced::default(),
    };
    while walk.found.rays < MOST_RAYS_OF_A_WALK && !world.patience.is_over(walk.surfaces) {
        walk.found.rays += 1;
        walk.surfaces += 1;
        let goes_on = match world.tracer.first_hit(&walk.origin, walk.direction) {
            Meeting::Surface(hit) => walk.meet(&hit, &share_of, cache, cut, stream),
            Meeting::Ball(luminaire) => {
                walk.find_emitters(world.emitters.of_ball(luminaire).into_iter(), cut);
                false
            }
            Meeting::Nothing => {
                walk.find_sky();
                false
            }
        };
        if !goes_on {
            return walk.found;
        }
    }
    world.patience.note_walk_given_up();
    walk.found
}

/// Later landings to which receivers connect. Light from sheets is in caches that supply light.
fn in_sight<C: Cache>(world: &World, lights: &NearLuminaires) -> LaterLandings {
    if C::SUPPLIES { LaterLandings::None } else { lights.later_landings_of_receivers(world) }
}

/// Whether vertices of walks on a surface connect to packets of near luminaires.
fn connects<C: Cache>(bsdf: &Bsdf) -> bool {
    match bsdf {
        Bsdf::Diffuse(_) => true,
        Bsdf::Translucent(_) => !C::SUPPLIES,
        _ => false,
    }
}

/// State of a walk.
struct Walk<'a> {
    world: &'a World,
    /// Origin of its next ray.
    origin: Origin,
    direction: DVec3,
    trail: Option<Trail>,
    connected_from: Option<ConnectedFrom>,
    departure: Departure,
    /// Whether a surface has scattered it. Shares no longer apply then.
    has_scattered: bool,
    /// Number of surfaces and balls met, plus one for the sky.
    surfaces: u64,
    weight: f64,
    /// Light found so far in lm/m², and all rays of the walk.
    found: Traced,
}

impl Walk<'_> {
    /// Adds the emitters that the ray meets, as far as light samples did not find them.
    #[inline]
    fn find_emitters(&mut self, met: impl Iterator<Item = u32>, cut: &mut Cut) {
        self.found.value += self.weight * met_lm_m2(self.world, &self.departure, &self.trail, met, cut);
    }

    /// Adds the sky seen in a mirror, where no light sample finds it.
    fn find_sky(&mut self) {
        let sky = self.world.emitters.sky().filter(|_| matches!(self.departure, Departure::Mirrored));
        self.found.value += self.weight * sky.map_or(0.0, |sky| PI * sky.luminance_cd_m2(self.direction));
    }

    /// Adds the light found at a surface. Returns whether the walk continues from there.
    #[inline]
    fn meet<C: Cache>(
        &mut self,
        hit: &SurfaceHit,
        share_of: &impl Fn(DVec3, DVec3) -> [f64; 2],
        cache: &mut C,
        cut: &mut Cut,
        stream: &mut Stream,
    ) -> bool {
        let world = self.world;
        if !matches!(self.departure, Departure::Seen) {
            self.find_emitters(world.emitters.on_surface(hit.triangle, hit.side), cut);
        }
        let bsdf = world.bsdf(hit.triangle);
        if bsdf.is_black() || !world.receives(hit.triangle, hit.side) {
            return false;
        }
        let normal = world.normal_at(hit);
        let origin = world.leave(hit, LobeKind::Spread);
        self.origin = origin;
        let shares_of =
            |lit: DVec3| if self.has_scattered { [1.0; 2] } else { share_of(world.tracer.position_m(&origin), lit) };
        let shares = shares_of(normal);
        if shares == [0.0; 2] && matches!(bsdf, Bsdf::Diffuse(_)) {
            return false;
        }
        let is_sheet = matches!(bsdf, Bsdf::Translucent(_));
        // Light that a sheet transmits has arrived at its other side.
        let shares_behind = if is_sheet { shares_of(-normal) } else { shares };
        let from = self.connected_from.filter(|_| matches!(bsdf, Bsdf::Diffuse(_) | Bsdf::Translucent(_)));
        let vertex = Vertex {
            world,
            hit,
            spot: (hit.triangle, hit.side),
            direction: self.direction,
            normal,
            seen: normal,
            origin: &origin,
            connected_from: from,
        };
        let is_first_met = self.surfaces == 1;
        if let Bsdf::Diffuse(bsdf) = bsdf {
            let (known_lm_m2, known_rays) =
                vertex.cached_lm_m2((bsdf.reflectance, is_first_met), shares, cache, cut, stream);
            self.found.rays += known_rays;
            if let Some(known_lm_m2) = known_lm_m2 {
                self.found.value += self.weight * known_lm_m2;
                return false;
            }
        }
        let met = from
            .zip(world.near_luminaires.as_ref())
            .and_then(|(from, lights)| lights.meets(&from, is_sheet, || (world.tracer.position_m(&origin), normal)));
        let direct = match bsdf {
            Bsdf::Diffuse(bsdf) => {
                let tell = |event: WalkEvent| {
                    if is_first_met {
                        cache.observe(&event)
                    }
                };
                vertex.spread_lm_m2(bsdf.reflectance, shares, tell, cut, stream)
            }
            Bsdf::Translucent(bsdf) => vertex.translucent_lm_m2(bsdf, [shares, shares_behind], cut, stream),
            bsdf if bsdf.is_specular() => Traced::default(),
            bsdf => vertex.glossy_lm_m2(bsdf, shares, &self.trail, cut, stream),
        };
        self.found += self.weight * direct;
        if let Some(lights) = world.near_luminaires.as_ref().filter(|_| connects::<C>(bsdf)) {
            let behind = is_sheet.then(|| world.leave(hit, LobeKind::SpreadThrough));
            let later = (met, lights.later_landings());
            let point = connecting_point(&vertex, bsdf, [shares[1], shares_behind[1]], behind.as_ref(), later);
            let near = from_near_luminaires_lx((world, lights), &point, self.weight, cache, stream);
            self.found += self.weight * near;
        }
        self.leave(&Vertex { connected_from: None, ..vertex }, met, [shares[1], shares_behind[1]], cache, stream)
    }

    /// Continues the walk from a surface, unless the surface absorbs it or transmits none of the counted light. Returns whether the walk
    /// continues. The shares apply to light that was reflected before: one for what the surface reflects, one for what it transmits.
    #[inline]
    fn leave<C: Cache>(
        &mut self,
        vertex: &Vertex,
        met: Option<MetFrom>,
        [share, share_behind]: [f64; 2],
        cache: &mut C,
        stream: &mut Stream,
    ) -> bool {
        let Vertex { world, hit, normal, .. } = *vertex;
        let bsdf = world.bsdf(hit.triangle);
        let scattered = match bsdf {
            Bsdf::Diffuse(bsdf) => {
                let Some(survivor) = world.roulette.survivor_weight(self.weight * bsdf.reflectance, stream) else {
                    return false;
                };
                self.weight = survivor;
                cache.observe(&WalkEvent::GoesOn { weight: survivor, before: self.found });
                Some(Diffuse::spread(normal, stream))
            }
            bsdf => bsdf.sample(self.direction, normal, stream),
        };
        let Some(scattered) = scattered else {
            return false;
        };
        let here = world.near_luminaires.as_ref().filter(|_| connects::<C>(bsdf)).map(|lights| {
            let point_m = world.tracer.position_m(vertex.origin);
            let [reflected, passed] = bsdf.diffuse_shares();
            let is_through = scattered.lobe == LobeKind::SpreadThrough;
            let (left, sends) = if is_through { (-normal, passed) } else { (normal, reflected) };
            let place = (point_m, left);
            ConnectedFrom { place, drawn_for_m: point_m, met, sends, later: lights.later_landings() }
        });
        if scattered.lobe.leads_through() {
            self.origin = world.leave(hit, scattered.lobe);
        }
        self.has_scattered |= scattered.lobe != LobeKind::Passed;
        self.connected_from = match scattered.lobe {
            LobeKind::Passed => self.connected_from,
            LobeKind::Spread | LobeKind::SpreadThrough => here,
            _ => None,
        };
        match scattered.lobe {
            LobeKind::Spread => self.weight *= share,
            LobeKind::SpreadThrough => self.weight *= share_behind,
            _ => {}
        }
        let before = (self.trail.take(), std::mem::replace(&mut self.departure, Departure::Seen));
        let left = Vertex { origin: &self.origin, ..*vertex };
        (self.trail, self.departure) = left.depart(bsdf, &scattered, before);
        self.direction = scattered.direction;
        self.weight > 0.0
    }
}

#[cfg(test)]
mod tests;
