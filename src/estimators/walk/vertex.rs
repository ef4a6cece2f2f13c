//! Light that a walk finds at one of its vertices, and how the walk leaves the vertex.

use std::f64::consts::{FRAC_1_PI, PI};

use glam::DVec3;

use crate::estimators::cache::{Cache, CacheAnswer, Met, WalkEvent};
use crate::estimators::direct::{SampleCost, Sight, one_light_sample, one_light_sample_beside_packets};
use crate::estimators::highlights::{sample_highlights, share_of_walk};
use crate::estimators::images::{ImageResponse, Trail, sample_areas_beside_rays, sample_points_in_mirrors};
use crate::estimators::receiver::Receiver;
use crate::geometry::{Origin, SurfaceHit};
use crate::sampling::emitter_tree::Cut;
use crate::sampling::random::Stream;
use crate::sampling::reflection::{Bsdf, LobeKind, Pair, Reflection, Scattered, Translucent};
use crate::transport::{
    ConnectedFrom, ConnectingPoint, ConnectingSide, LaterLandings, MetFrom, Mirrors, NearLuminaires, SampledPlace,
    Traced, TriangleSide, World,
};

/// Probability with which a vertex along a walk searches for areas in mirrors and for highlights. A search takes as long as several rays,
/// and its light has been reflected once more than that of the receiver's own search. (Measured for highlights: squared error times rays in
/// four rooms: 0.5 1.00, 1 1.04.)
const ON_THE_WAY: f64 = 0.25;

/// How a walk left the last vertex at which it took light samples.
pub(super) enum Departure {
    /// Light samples have found all luminaires that the ray can meet directly.
    Seen,
    /// Along a lobe: light samples have found these luminaires too, and both are weighted.
    Lobe(LobeRay),
    /// Past a mirror: light samples have found only the luminaires to which the ray's trail leads.
    Mirrored,
}

/// A ray drawn from a lobe, and its start.
pub(super) struct LobeRay {
    lobe_per_sr: f64,
    spot: TriangleSide,
    point_m: DVec3,
    normal: DVec3,
}

/// Light that the emitters on a ray add, in lm/m²: their exitance, times the share that the ray counts.
///
/// Take a lobe f and an emitter of luminance L that gives illuminance E and is chosen with probability p. A light sample draws the
/// direction with density p L cos θ/E, and the ray draws it with density f cos θ. The ray's share is z/(1 + z), z = f E/(p L).
pub(super) fn met_lm_m2(
    world: &World,
    departure: &Departure,
    trail: &Option<Trail>,
    met: impl Iterator<Item = u32>,
    cut: &mut Cut,
) -> f64 {
    let mut sum_lm_m2 = 0.0;
    for index in met {
        let emitter = &world.emitters.list()[index as usize];
        let exitance_lm_m2 = emitter.exitance_lm_m2().unwrap_or(0.0);
        let share = match departure {
            Departure::Seen => 0.0,
            Departure::Mirrored => match (trail, &world.mirrors) {
                (Some(trail), Some(mirrors)) if mirrors.walks_sample_areas() => {
                    trail.share_of_ray(world, mirrors, index)
                }
                _ => 1.0,
            },
            Departure::Lobe(ray) => {
                let unshadowed_lx = emitter.unshadowed_lx(ray.point_m, ray.normal);
                let probability = world.choices(ray.spot, ray.point_m, ray.normal, cut).probability(index);
                let looked = probability * exitance_lm_m2 / PI;
                let rayed = ray.lobe_per_sr * unshadowed_lx;
                if looked > 0.0 && unshadowed_lx > 0.0 { rayed / (rayed + looked) } else { 1.0 }
            }
        };
        sum_lm_m2 += share * exitance_lm_m2;
    }
    sum_lm_m2
}

/// A point where a walk met a surface that scatters.
pub(super) struct Vertex<'a> {
    pub world: &'a World,
    pub hit: &'a SurfaceHit,
    /// The side of a triangle at which light samples are taken.
    pub spot: TriangleSide,
    /// Direction of the walk's ray.
    pub direction: DVec3,
    /// Normal of the side at which light is sampled: `seen`, or the opposite normal if light comes through a sheet.
    pub normal: DVec3,
    /// Normal of the side from which the walk came.
    pub seen: DVec3,
    /// The point for the tracer, on the side at which light is sampled.
    pub origin: &'a Origin,
    /// Previous point of the walk, if it made a light-path connection (looked back) and this point scatters diffusely.
    pub connected_from: Option<ConnectedFrom>,
}

impl Vertex<'_> {
    /// Light that leaves a diffuse surface in lm/m² if the cache ends the walk here, `None` if the walk continues; and the number of rays.
    #[inline]
    pub fn cached_lm_m2(
        &self,
        (reflectance, is_first): (f64, bool),
        shares: [f64; 2],
        cache: &mut impl Cache,
        cut: &mut Cut,
        stream: &mut Stream,
    ) -> (Option<f64>, u64) {
        let met = Met { hit: self.hit, receiver: self.receiver(), direction: self.direction, reflectance, is_first };
        let (answer, rays) = cache.look_up(&met, cut, stream);
        match answer {
            CacheAnswer::Nothing => (None, rays),
            CacheAnswer::Stop => (Some(0.0), rays),
            CacheAnswer::End(known_lx) => {
                // The cached illuminance includes the images in mirrors.
                let sight = self.light_sample(cut, stream);
                let (direct_lx, direct_rays) = sight.map_or((0.0, 0), |sight| (self.direct_lx(&sight), 1));
                (Some(reflectance * (shares[0] * direct_lx + shares[1] * known_lx)), rays + direct_rays)
            }
        }
    }

    /// State of a walk that leaves from here by a BSDF: its trail by mirrors, and how the luminaires that its next ray meets are counted.
    #[inline]
    pub fn depart(
        &self,
        bsdf: &Bsdf,
        scattered: &Scattered,
        (trail, departure): (Option<Trail>, Departure),
    ) -> (Option<Trail>, Departure) {
        let Vertex { world, normal, direction, .. } = *self;
        let pair = Pair { normal, towards: -direction, leaving: scattered.direction };
        match scattered.lobe {
            LobeKind::Glossy => {
                let point_m = world.tracer.position_m(self.origin);
                let lobe_per_sr = bsdf.lobe_per_sr(&pair);
                let trail = trail_from(world, ON_THE_WAY, || (point_m, normal, lobe_per_sr));
                (trail, Departure::Lobe(LobeRay { lobe_per_sr, spot: self.spot, point_m, normal }))
            }
            LobeKind::Mirrored => {
                let facet = |mirrors: &Mirrors| mirrors.number(self.hit.triangle, self.hit.side);
                let facet = world.mirrors.as_ref().and_then(facet);
                let on = |trail: Trail| trail.mirrored(facet, bsdf.mirror_share(normal.dot(direction)));
                (trail.and_then(on), Departure::Mirrored)
            }
            LobeKind::Passed => {
                let share = || if let Bsdf::Glass(glass) = bsdf { glass.shares(normal.dot(direction))[1] } else { 1.0 };
                (trail.map(|trail| trail.passed(share())), departure)
            }
            LobeKind::Spread | LobeKind::SpreadThrough => {
                let side = if scattered.lobe == LobeKind::SpreadThrough { -normal } else { normal };
                let trail = trail_from(world, ON_THE_WAY, || {
                    let spread_per_sr = match bsdf {
                        // Only one side, chosen at random, searches for areas: both count by their shares.
                        Bsdf::Translucent(bsdf) => bsdf.total(1.0) * FRAC_1_PI,
                        bsdf => bsdf.spread_per_sr(&pair),
                    };
                    (world.tracer.position_m(self.origin), side, spread_per_sr)
                });
                (trail, Departure::Seen)
            }
        }
    }

    pub fn receiver(&self) -> Receiver<'_> {
        Receiver { point_m: self.world.tracer.position_m(self.origin), normal: self.normal, origin: self.origin }
    }

    /// One light sample. Near luminaires are chosen by what the light-path connection leaves to it.
    #[inline]
    fn light_sample(&self, cut: &mut Cut, stream: &mut Stream) -> Option<Sight<'_>> {
        let packets_per_lx = || {
            let beside = self.world.near_luminaires.as_ref().zip(self.connected_from);
            beside.map_or(0.0, |(lights, from)| lights.packets_per_lx(self.world, &self.sampled_place(), &from))
        };
        let cost = (SampleCost::Cheap, packets_per_lx);
        one_light_sample_beside_packets(self.world, self.spot, &self.receiver(), cost, cut, stream)
    }

    fn sampled_place(&self) -> SampledPlace {
        let [reflected, passed] = self.world.bsdf(self.hit.triangle).diffuse_shares();
        let leaving = if self.seen == self.normal { reflected } else { passed };
        let lit = (self.world.tracer.position_m(self.origin), self.normal);
        SampledPlace { lit, seen: self.seen, leaving }
    }

    /// Direct light of a light sample in lx, without the share that the light-path connection has found.
    #[inline]
    fn direct_lx(&self, sight: &Sight) -> f64 {
        let share = match (&self.world.near_luminaires, self.connected_from) {
            (Some(lights), Some(from)) => {
                lights.share_of_light_sample(self.world, sight.index, &self.sampled_place(), &from)
            }
            _ => 1.0,
        };
        share * sight.direct_lx()
    }

    /// Light that leaves diffusely, in lm/m²: direct light and light from images in mirrors, each with its share; and the number of rays.
    #[inline]
    pub fn spread_lm_m2(
        &self,
        reflectance: f64,
        shares: [f64; 2],
        mut tell: impl FnMut(WalkEvent),
        cut: &mut Cut,
        stream: &mut Stream,
    ) -> Traced {
        let [direct, mirrored] = shares.map(|share| share * reflectance);
        let responses = |_| evenly(mirrored, reflectance * FRAC_1_PI);
        let sight = match direct > 0.0 {
            true => self.light_sample(cut, stream),
            false => None,
        };
        let sampled = sight.map_or(Traced::default(), |sight| {
            let counted_lm_m2 = direct * self.direct_lx(&sight);
            if self.connected_from.is_some() && self.world.is_near(sight.index) {
                let lm_m2 = direct * sight.direct_lx();
                tell(WalkEvent::FoundNear { emitter: sight.index, lm_m2, counted_lm_m2 });
            }
            Traced { value: counted_lm_m2, rays: 1 }
        });
        sampled + searched_lx(self.world, &self.receiver(), ON_THE_WAY, responses, cut, stream)
    }

    /// The same for one side of a translucent sheet, chosen at random by its share.
    pub fn translucent_lm_m2(
        &self,
        bsdf: &Translucent,
        [shares, shares_behind]: [[f64; 2]; 2],
        cut: &mut Cut,
        stream: &mut Stream,
    ) -> Traced {
        if stream.unit() * bsdf.total(1.0) < bsdf.reflectance {
            return self.spread_lm_m2(bsdf.total(1.0), shares, |_| (), cut, stream);
        }
        let behind = self.world.leave(self.hit, LobeKind::SpreadThrough);
        let (triangle, side) = self.spot;
        Vertex { spot: (triangle, side.other()), normal: -self.normal, origin: &behind, ..*self }.spread_lm_m2(
            bsdf.total(1.0),
            shares_behind,
            |_| (),
            cut,
            stream,
        )
    }

    /// Direct light that a glossy surface sends back along the walk, as π times its luminance. Shares for luminaires and for images in
    /// mirrors apply to the part of the BSDF outside the lobe.
    pub fn glossy_lm_m2(
        &self,
        bsdf: &Bsdf,
        [direct, mirrored]: [f64; 2],
        trail: &Option<Trail>,
        cut: &mut Cut,
        stream: &mut Stream,
    ) -> Traced {
        let receiver = self.receiver();
        let pair = |towards: DVec3| Pair { normal: self.normal, towards, leaving: -self.direction };
        let responses = |towards: DVec3| {
            let pair = pair(towards);
            let (spread_per_sr, lobe_per_sr) = (bsdf.spread_per_sr(&pair), bsdf.lobe_per_sr(&pair));
            let spread = ImageResponse { factor: PI * mirrored * spread_per_sr, ray_per_sr: spread_per_sr };
            [spread, ImageResponse { factor: PI * lobe_per_sr, ray_per_sr: lobe_per_sr }]
        };
        let mirrored = searched_lx(self.world, &receiver, ON_THE_WAY, responses, cut, stream);
        let Some(sight) = one_light_sample(self.world, self.spot, &receiver, SampleCost::Full, cut, stream) else {
            return mirrored;
        };
        let pair = pair(sight.towards);
        let brought_lx = sight.unshadowed_lx / sight.probability;
        let lobe = bsdf.lobe_per_sr(&pair) * brought_lx;
        // The light sample's share, 1/(1 + z), beside the ray's share in `met_lm_m2`.
        let lobe = match sight.emitter.exitance_lm_m2() {
            Some(exitance_lm_m2) => lobe / (1.0 + lobe * PI / exitance_lm_m2),
            None if lobe > 0.0 => lobe * share_of_walk(self.world, trail, (self.hit, self.direction), &sight, cut),
            None => 0.0,
        };
        let sampled_lm_m2 = PI * (direct * bsdf.spread_per_sr(&pair) * brought_lx + lobe) * sight.transmittance;
        mirrored + Traced { value: sampled_lm_m2, rays: 1 }
    }
}

/// Response of a point that treats light from all directions alike, and the density of its rays.
pub fn evenly(factor: f64, ray_per_sr: f64) -> [ImageResponse; 2] {
    [ImageResponse { factor, ray_per_sr }, ImageResponse { factor: 0.0, ray_per_sr }]
}

/// The trail of a ray from a point that searches for areas in mirrors and for highlights with a probability of `chance`. `None` if there are
/// none. Only if there are some, `start` computes the point, its normal, and the ray's density per sr and over the cosine.
#[inline]
pub fn trail_from(world: &World, chance: f64, start: impl FnOnce() -> (DVec3, DVec3, f64)) -> Option<Trail> {
    let samples_areas = world.mirrors.as_ref().is_some_and(Mirrors::walks_sample_areas);
    (samples_areas || world.gloss.is_some()).then(|| {
        let (point_m, normal, ray_per_sr) = start();
        Trail::from(point_m, normal, ray_per_sr, chance)
    })
}

/// Illuminance of a point from images in mirrors and from highlights, if there can be any, weighted by its responses. Areas and highlights
/// are searched with a probability of `chance`, and share their light with the rays of [`trail_from`].
#[inline]
pub fn searched_lx(
    world: &World,
    receiver: &Receiver,
    chance: f64,
    responses: impl Fn(DVec3) -> [ImageResponse; 2],
    cut: &mut Cut,
    stream: &mut Stream,
) -> Traced {
    let mut sum = Traced::default();
    if let Some(gloss) = &world.gloss {
        sum += sample_highlights((world, gloss), receiver, chance, &responses, cut, stream);
    }
    let Some(mirrors) = &world.mirrors else {
        return sum;
    };
    let to_points = |towards: DVec3| responses(towards).iter().map(|part| part.factor).sum();
    sum += sample_points_in_mirrors(world, mirrors, receiver, to_points, cut, stream);
    if mirrors.walks_sample_areas() {
        sum += sample_areas_beside_rays(world, mirrors, receiver, chance, responses, stream);
    }
    sum
}

/// The sides by which a vertex of a walk connects to packets of near luminaires, with what they send along the walk. The shares count for
/// what the vertex reflects, and for what a sheet transmits from its other side, `behind`.
pub(super) fn connecting_point<'a>(
    vertex: &Vertex<'a>,
    bsdf: &Bsdf,
    [share, share_behind]: [f64; 2],
    behind: Option<&'a Origin>,
    (met, later): (Option<MetFrom>, LaterLandings),
) -> ConnectingPoint<'a> {
    let [reflectance, transmittance] = bsdf.diffuse_shares();
    let side = |normal: DVec3, origin: &'a Origin, share: f64, sends: f64| {
        let place = (vertex.world.tracer.position_m(origin), normal);
        ConnectingSide { place, origin, sends, factor: share * sends }
    };
    ConnectingPoint {
        front: side(vertex.normal, vertex.origin, share, reflectance),
        behind: behind.map(|origin| side(-vertex.normal, origin, share_behind, transmittance)),
        met,
        later,
    }
}

/// Illuminance of a point by way of the surfaces that near luminaires light: see [`NearLuminaires`]. The cache is informed of its weight in
/// the walk.
#[inline]
pub(super) fn from_near_luminaires_lx(
    (world, lights): (&World, &NearLuminaires),
    point: &ConnectingPoint,
    weight: f64,
    cache: &mut impl Cache,
    stream: &mut Stream,
) -> Traced {
    let found = lights.connect_to_packet(world, point, stream);
    cache.observe(&WalkEvent::Connected { weight, found: &found });
    Traced { value: found.lx + found.later_lx, rays: found.rays }
}
