//! Luminaires seen in flat mirrors: no ray of a walk meets a point, and few meet a small ball or panel or the sun, so their images
//! are looked for.
//!
//! A sequence of facets is drawn step by step ([`Beam`]); at every step one emitter is chosen and a point of it, and if
//! the beam holds that, the path is followed back from facet to facet and counts in full. Each path has one sequence,
//! which is drawn with a known probability: counted once, without bias (docs/methods.md (16)).

use glam::DVec3;

use crate::chain::{Mirrors, Stage};
use crate::estimators::direct::Receiver;
use crate::geometry::Origin;
use crate::sampling::beam::{Beam, Facet};
use crate::sampling::emitter_tree::Cut;
use crate::sampling::random::Stream;

/// Least probability of going on after a weak reflection, so that panes, which grow bright at grazing angles, are not
/// judged by the middle of a beam alone.
const LEAST_SURVIVAL: f64 = 0.1;

/// Sequences between perfect mirrors have no end of their own: the share that goes on past the first step falls as
/// (d + 6)⁻⁵ᐟ². That is slower than the squares of what images bring between two mirrors (d⁻⁴), so that the variance stays
/// finite, and faster than d⁻², so that the work does: following a path back takes as many rays as it has facets.
fn decay(depth: u32) -> f64 {
    if depth == 1 { 1.0 } else { (f64::from(depth + 5) / f64::from(depth + 6)).powf(2.5) }
}

/// A point of an emitter, as it is chosen at a step of a beam.
struct Chosen {
    position_m: DVec3,
    origin: Origin,
    /// What it brings to the image of the place in lx, its cosine included, as if no mirror took anything and nothing
    /// stood between; over the probability of its choice.
    brought_lx: f64,
}

/// Where a beam has come to.
struct Step {
    /// The image of the place, and of its normal.
    apex_m: DVec3,
    normal: DVec3,
    /// Normal of the last facet.
    facet_normal: DVec3,
}

/// One unbiased sample of what images of the sun and of point-like emitters bring to a place in lx, times `response` to the direction
/// that it comes from; and the rays it took.
pub fn look_into_mirrors(
    stage: &Stage,
    mirrors: &Mirrors,
    receiver: &Receiver,
    response: impl Fn(DVec3) -> f64,
    cut: &mut Cut,
    stream: &mut Stream,
) -> (f64, u64) {
    let (sun_lx, sun_rays) = match mirrors.sun {
        Some(number) => look_by_facets(stage, &mirrors.facets, receiver, &response, stream, |step, stream| {
            let look = stage.emitters.list()[number as usize].look(step.apex_m, step.normal, stream)?;
            let origin = stage.origin(&look.place?);
            let position_m = stage.tracer.position_m(&origin);
            Some(Chosen { position_m, origin, brought_lx: look.unshadowed_lx })
        }),
        None => (0.0, 0),
    };
    let Some(points) = &mirrors.points else {
        return (sun_lx, sun_rays);
    };
    let (lx, rays) = look_by_facets(stage, &mirrors.facets, receiver, &response, stream, |step, stream| {
        let variate = stream.fine_unit();
        let (look, chosen) = points.choose(step.apex_m, step.facet_normal, variate, cut, stream)?;
        let offset_m = step.apex_m - look.point.position_m;
        let cosine = -offset_m.normalize_or_zero().dot(step.normal);
        if cosine <= 0.0 {
            return None;
        }
        let intensity_cd = look.emitter.intensity_from_cd(&look.point, offset_m.normalize_or_zero());
        let brought_lx = intensity_cd * cosine / offset_m.length_squared() / chosen;
        Some(Chosen { position_m: look.point.position_m, origin: stage.origin(&look.place), brought_lx })
    });
    (sun_lx + lx, sun_rays + rays)
}

/// One unbiased sample of what images of balls and areas bring to a place in lx, times `response` to the direction that it comes from;
/// and the rays it took. Whoever looks so leaves out what a ray meets by way of these facets: see [`Mirrors::shows_areas_in`].
pub fn look_for_areas(
    stage: &Stage,
    mirrors: &Mirrors,
    receiver: &Receiver,
    response: impl Fn(DVec3) -> f64,
    stream: &mut Stream,
) -> (f64, u64) {
    look_by_facets(stage, &mirrors.facets, receiver, response, stream, |step, stream| {
        let list = stage.emitters.list();
        let weight = |number: &u32| list[*number as usize].importance(step.apex_m, step.normal);
        let total: f64 = mirrors.areas.iter().map(weight).sum();
        let mut rest = stream.fine_unit() * total;
        let last = mirrors.areas.iter().rposition(|number| weight(number) > 0.0)?;
        let met = mirrors.areas[..last].iter().find(|number| {
            let here = weight(number);
            let found = rest < here;
            rest -= here;
            found
        });
        let number = met.unwrap_or(&mirrors.areas[last]);
        let look = list[*number as usize].look(step.apex_m, step.normal, stream)?;
        let origin = stage.origin(&look.place?);
        let position_m = stage.tracer.position_m(&origin);
        Some(Chosen { position_m, origin, brought_lx: look.unshadowed_lx * total / weight(number) })
    })
}

/// One sample of what emitters bring to a place by way of facets; `choose` picks a point of one at every step.
fn look_by_facets(
    stage: &Stage,
    facets: &[Facet],
    receiver: &Receiver,
    response: impl Fn(DVec3) -> f64,
    stream: &mut Stream,
    mut choose: impl FnMut(&Step, &mut Stream) -> Option<Chosen>,
) -> (f64, u64) {
    let mut beam = Beam::above(receiver.point_m, receiver.normal);
    let mut normal = receiver.normal;
    let mut path: Vec<(usize, DVec3)> = Vec::new();
    let mut probability = 1.0;
    let (mut sum, mut rays) = (0.0, 0);
    for depth in 1.. {
        let Some(step) = beam.choose(facets, stream.fine_unit()) else {
            break;
        };
        let facet = &facets[step.facet];
        let survival = stage.law(facet.triangle).mirror_share(step.cosine).max(LEAST_SURVIVAL) * decay(depth);
        if stream.unit() >= survival {
            break;
        }
        probability *= step.probability * survival;
        path.push((step.facet, beam.apex_m));
        beam = beam.reflected(facet, &step);
        normal -= 2.0 * normal.dot(facet.normal) * facet.normal;
        let here = Step { apex_m: beam.apex_m, normal, facet_normal: facet.normal };
        let Some(chosen) = choose(&here, stream) else { continue };
        if beam.holds(chosen.position_m) {
            let (share, direction, path_rays) = follow(stage, facets, receiver, &path, beam.apex_m, &chosen);
            rays += path_rays;
            if share > 0.0 {
                sum += share * chosen.brought_lx * response(direction) / probability;
            }
        }
    }
    (sum, rays)
}

/// Share of a point's light that gets to the receiver along one path by way of mirrors, the direction that it comes from,
/// and the rays it took.
fn follow(
    stage: &Stage,
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
        let Some((point_m, barycentric)) = facet.crossing(seen_from_m, target_m) else {
            return (0.0, DVec3::ZERO, rays);
        };
        let cosine = (target_m - point_m).normalize_or_zero().dot(facet.normal);
        let here = stage.tracer.surface_origin(facet.triangle, barycentric, facet.side);
        share *= stage.law(facet.triangle).mirror_share(cosine) * stage.transmittance(&here, &target);
        rays += 1;
        if share <= 0.0 {
            return (0.0, DVec3::ZERO, rays);
        }
        (target_m, target, seen_from_m) = (point_m, here, *before_m);
    }
    share *= stage.transmittance(receiver.origin, &target);
    (share, (target_m - receiver.point_m).normalize_or_zero(), rays + 1)
}
