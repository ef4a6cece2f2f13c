//! Luminaires seen in flat mirrors. No ray of a walk meets a point, and few meet a small ball, a small panel or the sun, so their images
//! are searched for.
//!
//! A sequence of facets is drawn step by step ([`Beam`]). At every step one emitter and a point of it are chosen. If the beam contains the
//! point, the path is followed back from facet to facet and counts in full. Each path has one sequence, which is drawn with a known
//! probability, so it counts once and without bias (docs/methods.md (16)). Rays meet areas by way of the same facets. Both paths count,
//! weighted by their densities.

use std::f64::consts::PI;

use glam::DVec3;

use crate::estimators::receiver::Receiver;
use crate::geometry::Origin;
use crate::sampling::beam::{Beam, Facet, MirrorPlace, Step as Reached};
use crate::sampling::emitter_tree::Cut;
use crate::sampling::random::Stream;
use crate::transport::{Mirrors, Traced, World};

/// Least probability of continuing after a weak reflection. Panes get brighter at grazing angles, so the middle of a beam alone must not
/// decide.
const LEAST_SURVIVAL: f64 = 0.1;

/// Reflectance from which on every sequence continues past its first facet. Where light of a luminaire comes by one mirror alone, chance
/// would only add random error, in whole steps of a sample: all replicas may agree on a wrong number of them.
const STRONG: f64 = 0.5;

/// Share of sequences that continue past a step, beyond the reflectance. Sequences between perfect mirrors have no end of their own: the
/// share that continues past the first step falls as (d + 6)⁻⁵ᐟ². This is slower than the squares of what images give between two mirrors
/// (d⁻⁴), so the variance stays finite. It is faster than d⁻², so the work stays finite too: following a path back takes as many rays as it
/// has facets.
fn decay(depth: u32) -> f64 {
    let ratio = f64::from(depth + 5) / f64::from(depth + 6);
    if depth == 1 { 1.0 } else { ratio * ratio * ratio.sqrt() }
}

/// Maximum number of facets on a path that both an image search and a ray may find. Image searches stop there, and rays count everything
/// beyond.
const MOST_SHARED: usize = 12;

/// One part of the response of a point to light from a direction.
#[derive(Clone, Copy)]
pub struct ImageResponse {
    /// Factor on an illuminance of 1 lx from that direction.
    pub factor: f64,
    /// Density of the rays that find the same light, per sr and over the cosine. 0 if no ray does.
    pub ray_per_sr: f64,
}

/// Path of a ray by mirrors, from a point that has searched for areas in them.
#[derive(Clone, Copy)]
pub struct Trail {
    point_m: DVec3,
    normal: DVec3,
    /// Density of the ray per sr and over the cosine, for every image search.
    ray_per_sr: f64,
    /// Share of light that the mirrors and panes on the path leave.
    share: f64,
    facets: [u16; MOST_SHARED],
    count: usize,
    has_passed: bool,
}

impl Trail {
    /// Trail of a ray that starts at a point which searches for areas with a probability of `chance` (1: always).
    pub fn from(point_m: DVec3, normal: DVec3, ray_per_sr: f64, chance: f64) -> Trail {
        let facets = [0; MOST_SHARED];
        Trail { point_m, normal, ray_per_sr: ray_per_sr / chance, share: 1.0, facets, count: 0, has_passed: false }
    }

    /// The start of a ray that has met neither mirror nor pane: its point in m, normal, and density per sr and over the cosine for every
    /// search. `None` if it has.
    #[inline]
    pub fn straight(&self) -> Option<(DVec3, DVec3, f64)> {
        (self.count == 0 && !self.has_passed).then_some((self.point_m, self.normal, self.ray_per_sr))
    }

    /// The trail after a mirror that reflects a share. `None` if no image search gets there.
    pub fn mirrored(mut self, facet: Option<u16>, share: f64) -> Option<Trail> {
        *self.facets.get_mut(self.count)? = facet?;
        self.count += 1;
        self.share *= share;
        Some(self)
    }

    /// The trail after a pane that transmits a share.
    pub fn passed(self, share: f64) -> Trail {
        Trail { share: self.share * share, has_passed: true, ..self }
    }

    /// Share of an area's light that the ray counts where it meets the area. It is z/(1 + z), with z the density of the ray over the
    /// density with which image searches find the same light (docs/methods.md (44)).
    pub fn share_of_ray(&self, world: &World, mirrors: &Mirrors, number: u32) -> f64 {
        let mut beam = Beam::above(self.point_m, self.normal);
        let mut normal = self.normal;
        let mut probability = 1.0;
        for (facet, depth) in self.facets[..self.count].iter().zip(1..) {
            let number = usize::from(*facet);
            let facet = &mirrors.facets[number];
            let (Some(chosen), Some(step)) = (beam.probability(&mirrors.facets, number), beam.step_to(facet)) else {
                return 1.0;
            };
            probability *= chosen * survival(world, facet, &step, depth);
            beam.reflect(facet, &step);
            normal -= 2.0 * normal.dot(facet.normal) * facet.normal;
        }
        let emitter = &world.emitters.list()[number as usize];
        let (weight, total) = weights_of_areas(world, mirrors, beam.apex_m, normal);
        let luminance_cd_m2 = emitter.exitance_lm_m2().unwrap_or(0.0) / PI;
        let sampled = probability * weight(&number) / total * luminance_cd_m2;
        let rayed = self.ray_per_sr * self.share * emitter.unshadowed_lx(beam.apex_m, normal);
        if sampled > 0.0 { rayed / (rayed + sampled) } else { 1.0 }
    }
}

/// Weights with which areas are chosen at a step of a beam: the weight of each, and the sum of all.
fn weights_of_areas(world: &World, mirrors: &Mirrors, apex_m: DVec3, normal: DVec3) -> (impl Fn(&u32) -> f64, f64) {
    let weight = move |number: &u32| world.emitters.list()[*number as usize].importance_lx(apex_m, normal);
    (weight, mirrors.areas.iter().map(weight).sum())
}

/// Probability with which a sequence of facets continues past one of them.
fn survival(world: &World, facet: &Facet, step: &Reached, depth: u32) -> f64 {
    let share = world.bsdf(facet.triangle()).mirror_share(step.cosine);
    if depth == 1 && share >= STRONG { 1.0 } else { share.max(LEAST_SURVIVAL) * decay(depth) }
}

/// A point of an emitter, chosen at a step of a beam.
struct Chosen {
    position_m: DVec3,
    origin: Origin,
    /// Illuminance in lx at the image of the receiving point, with its cosine, without mirror losses and occlusion, divided by the
    /// probability of the choice.
    brought_lx: f64,
    /// Luminance of an area, in cd/m². 0 for points and the sun.
    luminance_cd_m2: f64,
}

/// State of a beam at a step.
struct BeamPosition {
    /// Image of the receiving point and of its normal.
    apex_m: DVec3,
    normal: DVec3,
    /// Normal of the last facet.
    facet_normal: DVec3,
}

/// One unbiased sample of the illuminance in lx that images of the sun and of point-like emitters give at a point, times `response` to the
/// direction of the light; and the number of rays.
pub fn sample_points_in_mirrors(
    world: &World,
    mirrors: &Mirrors,
    receiver: &Receiver,
    response: impl Fn(DVec3) -> f64,
    cut: &mut Cut,
    stream: &mut Stream,
) -> Traced {
    let count = |lx: f64, towards: DVec3, _: &Chosen| lx * response(towards);
    let of_sun = match mirrors.sun {
        Some(number) => sample_by_facets(world, &mirrors.facets, receiver, u32::MAX, count, stream, |step, stream| {
            let sample = world.emitters.list()[number as usize].light_sample(step.apex_m, step.normal, stream)?;
            let origin = world.origin(&sample.place?);
            let position_m = world.tracer.position_m(&origin);
            Some(Chosen { position_m, origin, brought_lx: sample.unshadowed_lx, luminance_cd_m2: 0.0 })
        }),
        None => Traced::default(),
    };
    let Some(points) = &mirrors.points else {
        return of_sun;
    };
    let of_points = sample_by_facets(world, &mirrors.facets, receiver, u32::MAX, count, stream, |step, stream| {
        let variate = stream.fine_unit();
        let (sample, chosen) = points.choose(step.apex_m, step.facet_normal, variate, cut, stream)?;
        let offset_m = step.apex_m - sample.point.position_m;
        let cosine = -offset_m.normalize_or_zero().dot(step.normal);
        if cosine <= 0.0 {
            return None;
        }
        let intensity_cd = sample.emitter.intensity_from_cd(&sample.point, offset_m.normalize_or_zero());
        let brought_lx = intensity_cd * cosine / offset_m.length_squared() / chosen;
        let origin = world.origin(&sample.place);
        Some(Chosen { position_m: sample.point.position_m, origin, brought_lx, luminance_cd_m2: 0.0 })
    });
    of_sun + of_points
}

/// One unbiased sample of the illuminance in lx that images of balls and areas give at a point, and the number of rays. The caller must
/// omit what a ray meets by way of these facets.
pub fn sample_area_images(world: &World, mirrors: &Mirrors, receiver: &Receiver, stream: &mut Stream) -> Traced {
    sample_area_images_with(world, mirrors, receiver, |_| 1.0, stream)
}

/// The same times `response` to the direction of the light.
pub fn sample_area_images_with(
    world: &World,
    mirrors: &Mirrors,
    receiver: &Receiver,
    response: impl Fn(DVec3) -> f64,
    stream: &mut Stream,
) -> Traced {
    sample_areas_by_facets(world, mirrors, receiver, u32::MAX, |lx, towards, _| lx * response(towards), stream)
}

/// The part of it that is not left to rays, for points that also send rays. `responses` gives each part of the response for the direction
/// of the light. The search is made with a probability of `chance` (1: always). The ray's share, [`Trail::share_of_ray`], must use the same
/// probability.
pub fn sample_areas_beside_rays(
    world: &World,
    mirrors: &Mirrors,
    receiver: &Receiver,
    chance: f64,
    responses: impl Fn(DVec3) -> [ImageResponse; 2],
    stream: &mut Stream,
) -> Traced {
    if chance < 1.0 && !stream.happens(chance) {
        return Traced::default();
    }
    // 1/(1 + z), with z the density of a ray over that of the image search: docs/methods.md (44).
    let count = |lx: f64, towards: DVec3, chosen: &Chosen| {
        let lx = lx / chance;
        responses(towards)
            .iter()
            .map(|part| part.factor * lx / (1.0 + part.ray_per_sr * lx / chosen.luminance_cd_m2))
            .sum()
    };
    sample_areas_by_facets(world, mirrors, receiver, MOST_SHARED as u32, count, stream)
}

/// Searches for areas in mirrors, by way of at most `deepest` facets.
fn sample_areas_by_facets(
    world: &World,
    mirrors: &Mirrors,
    receiver: &Receiver,
    deepest: u32,
    count: impl Fn(f64, DVec3, &Chosen) -> f64,
    stream: &mut Stream,
) -> Traced {
    sample_by_facets(world, &mirrors.facets, receiver, deepest, count, stream, |step, stream| {
        let list = world.emitters.list();
        let (weight, total) = weights_of_areas(world, mirrors, step.apex_m, step.normal);
        let mut rest = stream.fine_unit() * total;
        let last = mirrors.areas.iter().rposition(|number| weight(number) > 0.0)?;
        let met = mirrors.areas[..last].iter().find(|number| {
            let here = weight(number);
            let found = rest < here;
            rest -= here;
            found
        });
        let number = met.unwrap_or(&mirrors.areas[last]);
        let emitter = &list[*number as usize];
        let sample = emitter.light_sample(step.apex_m, step.normal, stream)?;
        let origin = world.origin(&sample.place?);
        let position_m = world.tracer.position_m(&origin);
        let luminance_cd_m2 = emitter.exitance_lm_m2()? / PI;
        let brought_lx = sample.unshadowed_lx * total / weight(number);
        Some(Chosen { position_m, origin, brought_lx, luminance_cd_m2 })
    })
}

/// One sample of the light that emitters give to a point by way of at most `deepest` facets. `choose` picks a point of an emitter at every
/// step. `count` weights the light from it.
fn sample_by_facets(
    world: &World,
    facets: &[Facet],
    receiver: &Receiver,
    deepest: u32,
    count: impl Fn(f64, DVec3, &Chosen) -> f64,
    stream: &mut Stream,
    mut choose: impl FnMut(&BeamPosition, &mut Stream) -> Option<Chosen>,
) -> Traced {
    let mut beam = Beam::above(receiver.point_m, receiver.normal);
    let mut normal = receiver.normal;
    let mut path: Vec<(usize, DVec3)> = Vec::new();
    let mut probability = 1.0;
    let mut sum = Traced::default();
    for depth in 1..=deepest {
        let Some((number, chosen_facet)) = beam.choose(facets, stream.fine_unit()) else {
            break;
        };
        let facet = &facets[number];
        let Some(step) = beam.step_to(facet) else {
            break;
        };
        let survival = survival(world, facet, &step, depth);
        if stream.unit() >= survival {
            break;
        }
        probability *= chosen_facet * survival;
        path.push((number, beam.apex_m));
        beam.reflect(facet, &step);
        normal -= 2.0 * normal.dot(facet.normal) * facet.normal;
        let here = BeamPosition { apex_m: beam.apex_m, normal, facet_normal: facet.normal };
        let Some(chosen) = choose(&here, stream) else { continue };
        if beam.holds(chosen.position_m) {
            let (share, direction, path_rays) = follow(world, facets, receiver, &path, beam.apex_m, &chosen);
            sum.rays += path_rays;
            if share > 0.0 {
                sum.value += count(share * chosen.brought_lx / probability, direction, &chosen);
            }
        }
    }
    sum
}

/// Share of a point's light that reaches the receiver along one path by way of mirrors, the direction that it comes from, and the number of
/// rays.
fn follow(
    world: &World,
    facets: &[Facet],
    receiver: &Receiver,
    path: &[(usize, DVec3)],
    image_m: DVec3,
    chosen: &Chosen,
) -> (f64, DVec3, u64) {
    let mut seen_from_m = image_m;
    let mut target_m = chosen.position_m;
    let mut target: Origin = chosen.origin;
    let mut share = 1.0;
    let mut rays = 0;
    for (facet, before_m) in path.iter().rev() {
        let facet = &facets[*facet];
        let Some(MirrorPlace { point_m, triangle, weights }) = facet.crossing(seen_from_m, target_m) else {
            return (0.0, DVec3::ZERO, rays);
        };
        let cosine = (target_m - point_m).normalize_or_zero().dot(facet.normal);
        let here = world.tracer.surface_origin(triangle, weights, facet.side);
        share *= world.bsdf(triangle).mirror_share(cosine) * world.transmittance(&here, &target);
        rays += 1;
        if share <= 0.0 {
            return (0.0, DVec3::ZERO, rays);
        }
        (target_m, target, seen_from_m) = (point_m, here, *before_m);
    }
    share *= world.transmittance(receiver.origin, &target);
    (share, (target_m - receiver.point_m).normalize_or_zero(), rays + 1)
}
