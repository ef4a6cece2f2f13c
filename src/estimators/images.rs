//! Point-like luminaires seen in flat mirrors: no ray of a walk meets a point, so its images are looked for.
//!
//! A sequence of facets is drawn step by step ([`Beam`]); at every step one point-like emitter is chosen, and if the
//! beam holds it, the path is followed back from facet to facet and counts in full. Each path has one sequence, which is
//! drawn with a known probability: counted once, without bias.

use glam::DVec3;

use crate::chain::{Mirrors, Stage};
use crate::estimators::direct::Receiver;
use crate::geometry::Origin;
use crate::sampling::beam::Beam;
use crate::sampling::emitter::PointLook;
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

/// One unbiased sample of what images of point-like emitters bring to a place in lx, times `response` to the direction
/// that it comes from; and the rays it took.
pub fn look_into_mirrors(
    stage: &Stage,
    mirrors: &Mirrors,
    receiver: &Receiver,
    response: impl Fn(DVec3) -> f64,
    cut: &mut Cut,
    stream: &mut Stream,
) -> (f64, u64) {
    let mut beam = Beam::above(receiver.point_m, receiver.normal);
    let mut path: Vec<(usize, DVec3)> = Vec::new();
    let mut probability = 1.0;
    let (mut sum, mut rays) = (0.0, 0);
    for depth in 1.. {
        let Some(step) = beam.choose(&mirrors.facets, stream.fine_unit()) else {
            break;
        };
        let facet = &mirrors.facets[step.facet];
        let survival = stage.law(facet.triangle).mirror_share(step.cosine).max(LEAST_SURVIVAL) * decay(depth);
        if stream.unit() >= survival {
            break;
        }
        probability *= step.probability * survival;
        path.push((step.facet, beam.apex_m));
        beam = beam.reflected(facet, &step);
        let variate = stream.fine_unit();
        let Some((look, chosen)) = mirrors.points.choose(beam.apex_m, facet.normal, variate, cut, stream) else {
            continue;
        };
        if beam.holds(look.position_m) {
            let (lx, direction, path_rays) = follow(stage, mirrors, receiver, &path, beam.apex_m, &look);
            rays += path_rays;
            if lx > 0.0 {
                sum += lx * response(direction) / (probability * chosen);
            }
        }
    }
    (sum, rays)
}

/// Illuminance in lx that one path by way of mirrors brings, the direction that it comes from, and the rays it took.
fn follow(
    stage: &Stage,
    mirrors: &Mirrors,
    receiver: &Receiver,
    path: &[(usize, DVec3)],
    image_m: DVec3,
    look: &PointLook,
) -> (f64, DVec3, u64) {
    const NOTHING: (f64, DVec3, u64) = (0.0, DVec3::ZERO, 0);
    let mut seen_from_m = image_m;
    let mut target_m = look.position_m;
    let mut target: Origin = stage.origin(&look.place);
    let mut share = 1.0;
    let mut rays = 0;
    for (facet, before_m) in path.iter().rev() {
        let facet = &mirrors.facets[*facet];
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
    let direction = (target_m - receiver.point_m).normalize_or_zero();
    let cosine = direction.dot(receiver.normal);
    if cosine <= 0.0 {
        return NOTHING;
    }
    share *= stage.transmittance(receiver.origin, &target);
    let offset_m = image_m - look.position_m;
    let intensity_cd = look.emitter.intensity_cd(offset_m.normalize_or_zero());
    (intensity_cd * cosine / offset_m.length_squared() * share, direction, rays + 1)
}
