//! The luminance that an eye sees in a direction.
//!
//! The line of sight ends at the sub-point r′ (through panes and mirrors: [`trace_sight`]). Three kinds of light are seen there: luminaires
//! on the line itself; their light scattered once, at r′; and light that reaches r′ after reflections. The first two are the *direct* part.
//! Every luminaire is sampled from r′. For a lobe, the lobe's own ray also finds luminaires, and both are weighted by their densities. The
//! third is a walk from r′ (docs/methods.md (21)), drawn by the BSDF, which is reciprocal.

use std::f64::consts::PI;

use glam::DVec3;

use super::direct::{DirectPass, MOST_EACH};
use super::images::ImageResponse;
use super::receiver::Receiver;
use super::sight::{SMALL_SHARE, SMALL_SHARE_OF_LUMINAIRES, Seen, SubPoint, trace_sight};
use super::walk::{evenly, sample_arriving_share_lx, searched_lx, trail_from};
use crate::geometry::{Meeting, Origin};
use crate::sampling::emitter::Emitter;
use crate::sampling::emitter_tree::Cut;
use crate::sampling::random::Stream;
use crate::sampling::reflection::{Bsdf, LobeKind, Pair};
use crate::transport::{Traced, World};

/// One unbiased sample of the luminance in cd/m² that an eye sees of luminaires and of their light reflected once, and the number of rays.
/// The receiver's normal is the direction of view.
pub fn sample_seen_cd_m2(world: &World, eye: &Receiver, pass: &mut DirectPass, stream: &mut Stream) -> Traced {
    let mut ends = Vec::new();
    let mut seen_cd_m2 = 0.0;
    let rays = trace_sight(world, eye.origin, eye.normal, SMALL_SHARE_OF_LUMINAIRES, stream, |seen| match seen {
        Seen::Luminaire(luminaire) => seen_cd_m2 += luminaire.luminance_cd_m2,
        Seen::Surface(end) => ends.push(end),
    });
    let mut sum = Traced { value: seen_cd_m2, rays };
    for end in &ends {
        let luminance = match world.bsdf(end.hit.triangle) {
            Bsdf::Diffuse(bsdf) => bsdf.reflectance / PI * pass.at_point(world, &end.receiver(), stream),
            Bsdf::Translucent(bsdf) => {
                let front = pass.at_point(world, &end.receiver(), stream);
                let behind = end.behind(world);
                let back = pass.at_point(world, &end.receiver_behind(&behind), stream);
                (bsdf.reflectance * front + bsdf.transmittance * back) / PI
            }
            bsdf if bsdf.is_specular() => Traced::default(),
            bsdf => glossy_cd_m2(world, end, bsdf, stream),
        };
        sum += end.share * luminance;
    }
    sum
}

/// One unbiased sample of the luminance in cd/m² of light that was reflected at least once before it reaches the surface that an eye sees,
/// and the number of rays.
pub fn sample_interreflected_cd_m2(world: &World, eye: &Receiver, cut: &mut Cut, stream: &mut Stream) -> Traced {
    let mut ends = Vec::new();
    let rays = trace_sight(world, eye.origin, eye.normal, SMALL_SHARE, stream, |seen| {
        if let Seen::Surface(end) = seen {
            ends.push(end);
        }
    });
    let mut sum = Traced { value: 0.0, rays };
    for end in &ends {
        sum += end.share * end.sample_rest_cd_m2(world, |_, _, _| [1.0; 2], cut, stream);
    }
    sum
}

impl SubPoint {
    /// The side that is seen, as a receiver.
    pub fn receiver(&self) -> Receiver<'_> {
        Receiver { point_m: self.point_m, normal: self.normal, origin: &self.origin }
    }

    /// Start point of rays on the other side.
    pub fn behind(&self, world: &World) -> Origin {
        world.leave(&self.hit, LobeKind::SpreadThrough)
    }

    /// The other side, as a receiver.
    pub fn receiver_behind<'a>(&self, behind: &'a Origin) -> Receiver<'a> {
        Receiver { point_m: self.point_m, normal: -self.normal, origin: behind }
    }

    /// One walk from the sub-point: luminance in cd/m² of light that reaches it by reflections, and the number of rays. `share_of` weights
    /// the light that the first surface spreads towards it. It gets the lobe by which the walk leaves the sub-point, and the first
    /// surface's point and normal.
    pub fn sample_rest_cd_m2(
        &self,
        world: &World,
        share_of: impl Fn(LobeKind, DVec3, DVec3) -> [f64; 2],
        cut: &mut Cut,
        stream: &mut Stream,
    ) -> Traced {
        let receiver = self.receiver();
        let bsdf = world.bsdf(self.hit.triangle);
        let responses = |towards: DVec3| {
            let pair = Pair { normal: self.normal, towards, leaving: -self.direction };
            [bsdf.spread_per_sr(&pair), bsdf.lobe_per_sr(&pair)]
                .map(|per_sr| ImageResponse { factor: per_sr, ray_per_sr: per_sr })
        };
        let mut sum = searched_lx(world, &receiver, 1.0, responses, cut, stream);
        if let Bsdf::Translucent(bsdf) = bsdf {
            let behind = self.behind(world);
            let per_sr = bsdf.transmittance / PI;
            let responses = |_: DVec3| evenly(per_sr, per_sr);
            sum += searched_lx(world, &self.receiver_behind(&behind), 1.0, responses, cut, stream);
        }
        // The walk runs against the light. The BSDF is reciprocal.
        let Some(scattered) = bsdf.sample(self.direction, self.normal, stream) else {
            return sum;
        };
        let origin = world.leave(&self.hit, scattered.lobe);
        let trail = trail_from(world, 1.0, || {
            let pair = Pair { normal: self.normal, towards: -self.direction, leaving: scattered.direction };
            let ray_per_sr =
                if scattered.lobe == LobeKind::Glossy { bsdf.lobe_per_sr(&pair) } else { bsdf.spread_per_sr(&pair) };
            let side = if scattered.lobe == LobeKind::SpreadThrough { -self.normal } else { self.normal };
            (self.point_m, side, ray_per_sr)
        });
        let share_of = |point_m: DVec3, normal: DVec3| share_of(scattered.lobe, point_m, normal);
        sum + sample_arriving_share_lx(world, (origin, trail), scattered.direction, share_of, cut, stream) / PI
    }
}

/// Light of luminaires that a glossy sub-point sends to the eye, from light samples and a ray along the lobe.
fn glossy_cd_m2(world: &World, end: &SubPoint, bsdf: &Bsdf, stream: &mut Stream) -> Traced {
    let responses = |pair: &Pair| [bsdf.spread_per_sr(pair), bsdf.lobe_per_sr(pair)];
    let mut sum = light_from_gloss_cd_m2(world, end, responses, stream);
    let Some(scattered) = bsdf.sample(end.direction, end.normal, stream) else {
        return sum;
    };
    if scattered.lobe != LobeKind::Glossy {
        return sum;
    }
    let pair = Pair { normal: end.normal, towards: scattered.direction, leaving: -end.direction };
    let lobe_per_sr = bsdf.lobe_per_sr(&pair);
    let (met, rays) = first_luminaires(world, &end.origin, scattered.direction);
    sum.rays += rays;
    for (index, transmittance) in met {
        let emitter = &world.emitters.list()[index as usize];
        let share = share_of_ray(world, emitter, &end.receiver(), lobe_per_sr);
        sum.value += transmittance * share * emitter.exitance_lm_m2().unwrap_or(0.0) / PI;
    }
    sum
}

/// Mean number of light samples of each luminaire in one pass. Up to [`MOST_EACH`] luminaires get one each. Of more luminaires, that number
/// is chosen uniformly at random: this is simple, and the ray knows the probability.
fn light_samples_per_emitter(emitters: usize) -> f64 {
    emitters.min(MOST_EACH) as f64 / emitters as f64
}

/// One pass of light samples from a glossy sub-point: luminance that they give to the eye in cd/m², and the number of rays. The first of
/// the two responses (in 1/sr) counts in full. The second is weighted against a ray along it, which counts [`share_of_ray`] of what it
/// meets.
pub fn light_from_gloss_cd_m2(
    world: &World,
    end: &SubPoint,
    responses: impl Fn(&Pair) -> [f64; 2],
    stream: &mut Stream,
) -> Traced {
    let receiver = end.receiver();
    let list = world.emitters.list();
    let samples = list.len().min(MOST_EACH);
    let light_samples_per_emitter = light_samples_per_emitter(list.len());
    let mut sum = Traced::default();
    let shift = stream.fine_unit();
    for sample in 0..samples {
        let place = (sample as f64 + shift) / samples as f64;
        let index =
            if samples == list.len() { sample } else { ((place * list.len() as f64) as usize).min(list.len() - 1) };
        let emitter = &list[index];
        let Some(found) = emitter.light_sample(receiver.point_m, receiver.normal, stream) else {
            continue;
        };
        let Some(place) = found.place else {
            continue;
        };
        sum.rays += 1;
        let origin = world.origin(&place);
        let transmittance = world.transmittance(receiver.origin, &origin);
        if transmittance <= 0.0 {
            continue;
        }
        let towards = (world.tracer.position_m(&origin) - receiver.point_m).normalize_or(receiver.normal);
        let pair = Pair { normal: end.normal, towards, leaving: -end.direction };
        let brought_lx = found.unshadowed_lx / light_samples_per_emitter;
        let [spread_per_sr, lobe_per_sr] = responses(&pair);
        let lobe_cd_m2 = lobe_per_sr * brought_lx;
        let lobe_cd_m2 =
            lobe_cd_m2 * share_of_light_samples(emitter, lobe_per_sr, found.unshadowed_lx, light_samples_per_emitter);
        sum.value += transmittance * (spread_per_sr * brought_lx + lobe_cd_m2);
    }
    sum
}

/// Share of an area's light that a ray along the lobe counts where it meets the area, beside a pass of light samples.
pub fn share_of_ray(world: &World, emitter: &Emitter, receiver: &Receiver, lobe_per_sr: f64) -> f64 {
    let unshadowed_lx = emitter.unshadowed_lx(receiver.point_m, receiver.normal);
    1.0 - share_of_light_samples(
        emitter,
        lobe_per_sr,
        unshadowed_lx,
        light_samples_per_emitter(world.emitters.list().len()),
    )
}

/// Share of the lobe's light that light samples count; the lobe's ray counts the rest. It is 1/(1 + z), z = fE/(nL), with n light samples
/// of the emitter on average (docs/methods.md (15)). Points, which no ray meets, count by light samples alone.
fn share_of_light_samples(
    emitter: &Emitter,
    lobe_per_sr: f64,
    unshadowed_lx: f64,
    light_samples_per_emitter: f64,
) -> f64 {
    let Some(exitance_lm_m2) = emitter.exitance_lm_m2() else {
        return 1.0;
    };
    let sampled = light_samples_per_emitter * exitance_lm_m2 / PI;
    let rayed = lobe_per_sr * unshadowed_lx;
    if rayed + sampled > 0.0 && unshadowed_lx > 0.0 { sampled / (sampled + rayed) } else { 0.0 }
}

/// The luminaires that a ray meets directly or through panes, each with the transmittance of the panes before it, and the number of rays.
fn first_luminaires(world: &World, from: &Origin, direction: DVec3) -> (Vec<(u32, f64)>, u64) {
    let mut origin = *from;
    let mut transmittance = 1.0;
    let mut met = Vec::new();
    let mut rays = 0;
    while transmittance > 0.0 {
        rays += 1;
        match world.tracer.first_hit(&origin, direction) {
            Meeting::Nothing => break,
            Meeting::Ball(luminaire) => {
                met.extend(world.emitters.of_ball(luminaire).map(|index| (index, transmittance)));
                break;
            }
            Meeting::Surface(hit) => {
                met.extend(world.emitters.on_surface(hit.triangle, hit.side).map(|index| (index, transmittance)));
                let Bsdf::Glass(glass) = world.bsdf(hit.triangle) else {
                    break;
                };
                transmittance *= glass.shares(world.normal_at(&hit).dot(direction))[1];
                origin = world.leave(&hit, LobeKind::Passed);
            }
        }
    }
    (met, rays)
}
