//! What an eye sees along a direction: luminaires, and the surface points whose light the mesh provides.
//!
//! After Debelov and Novikov (2009). They add two terms to a surface's light from the mesh: k_s times the light of its mirror image, and
//! k_t times the light behind it. Here k_s and k_t are the mirror's reflectance and the pane's two shares at the angle of the ray. The
//! luminance of the surface at the end is ρ/π times its illuminance; a translucent sheet adds τ/π times that of the other side.
//!
//! For a glossy surface this is its diffuse part. The rest comes from rays along the lobe, by the same recursion, and from luminaires,
//! which light samples find too.

use std::f64::consts::{FRAC_1_PI, PI};

use glam::DVec3;

use crate::estimators::direct::MOST_EACH;
use crate::estimators::images::{sample_area_images_with, sample_points_in_mirrors};
use crate::estimators::luminance::{light_from_gloss_cd_m2, share_of_ray};
use crate::estimators::receiver::Receiver;
use crate::estimators::sight::{SMALL_SHARE, Seen, SubPoint, trace_sight};
use crate::geometry::Origin;
use crate::sampling::emitter::Emitter;
use crate::sampling::emitter_tree::Cut;
use crate::sampling::random::Stream;
use crate::sampling::reflection::{Bsdf, Pair};
use crate::transport::World;

/// Largest probability that a ray continues from one glossy surface to the next. Between two surfaces that absorb nothing it would never
/// end.
const MOST_SURVIVAL: f64 = 0.95;
/// Number of bits of a stream's index that count the rays of a direction.
const RAY_BITS: u32 = 32;

/// A surface point that a direction of view shows.
#[derive(Clone, Copy)]
pub struct SeenPlace {
    /// Position in m, on the side of the surface whose light is seen.
    pub point_m: DVec3,
    /// Unit normal of that side.
    pub normal: DVec3,
    /// Where its rays start.
    pub origin: Origin,
    /// Luminance in cd/m² that reaches the eye for each lx that the side receives.
    pub weight_per_sr: f64,
}

impl SeenPlace {
    /// Returns the surface point as a receiver.
    pub fn receiver(&self) -> Receiver<'_> {
        Receiver { point_m: self.point_m, normal: self.normal, origin: &self.origin }
    }
}

/// Settings for tracing lines of sight.
#[derive(Clone, Copy)]
pub struct Eye<'a> {
    /// The scene.
    pub world: &'a World,
    /// Share below which a branch of a line of sight continues only with a probability. Its weight compensates for this.
    pub small_share: f64,
    /// Rays along the gloss of the surfaces that the eye sees.
    pub gloss: GlossRays,
    /// Whether luminaires are counted; otherwise only surface points.
    pub with_luminaires: bool,
    /// Whether gloss samples images of ball and area luminaires. It then leaves out these luminaires where its rays meet them by way of any
    /// mirror.
    pub samples_area_images: bool,
}

/// Number of rays along the gloss of a surface that an eye sees.
#[derive(Clone, Copy)]
pub enum GlossRays {
    /// One ray, with the next numbers of the stream.
    One,
    /// This many rays, spread evenly by a sequence that belongs to the number of the direction.
    Even(u32, u64),
}

/// What a direction shows besides surface points.
#[derive(Clone, Copy, Debug, Default)]
pub struct Shown {
    /// Luminance of luminaires in cd/m².
    pub luminaires_cd_m2: f64,
    /// Whether gloss is seen, so that the result has random error.
    pub has_gloss: bool,
    /// Rays used.
    pub rays: u64,
}

impl Eye<'_> {
    /// Traces a line of sight. Adds the surface points seen to `places`.
    pub fn trace(&self, from: &Origin, direction: DVec3, stream: &mut Stream, places: &mut Vec<SeenPlace>) -> Shown {
        let (mut shown, mut ends) = (Shown::default(), Vec::new());
        shown.rays += trace_sight(self.world, from, direction, self.small_share, stream, |seen| match seen {
            Seen::Luminaire(luminaire) => shown.luminaires_cd_m2 += luminaire.luminance_cd_m2,
            Seen::Surface(end) => ends.push(end),
        });
        let mut cut = Cut::default();
        for (number, end) in (0u64..).zip(&ends) {
            end_at(self.world, end, end.share, places);
            let Some(gloss) = Gloss::of(self.world, end) else { continue };
            shown.has_gloss = true;
            self.sample_gloss(&gloss, number, &mut cut, stream, places, &mut shown);
        }
        shown
    }

    /// Samples the gloss of a surface that is seen, with all rays.
    fn sample_gloss(
        &self,
        gloss: &Gloss,
        number: u64,
        cut: &mut Cut,
        stream: &mut Stream,
        places: &mut Vec<SeenPlace>,
        shown: &mut Shown,
    ) {
        let share = gloss.end.share;
        let rays = match self.gloss {
            GlossRays::One => 1,
            GlossRays::Even(count, _) => (f64::from(count) * share.min(1.0)).ceil().max(1.0) as u64,
        };
        // Light samples of point luminaires have no random error if there are no mirrors: one pass is enough.
        let list = self.world.emitters.list();
        let is_exact = |emitter: &Emitter| emitter.is_single_point();
        let once = list.len() <= MOST_EACH && self.world.mirrors.is_none() && list.iter().all(is_exact);
        let passes = if once { 1 } else { rays };
        let mut ends = Vec::new();
        for ray in 0..rays {
            if let GlossRays::Even(_, direction) = self.gloss {
                let index = ((direction + 1) << RAY_BITS) | ((number << (RAY_BITS - 8)) + ray);
                stream.seek_quasi(index, (number << RAY_BITS) | direction, ray);
            }
            self.send_ray(gloss, share * gloss.reflectance / rays as f64, stream, &mut ends, shown);
            if ray < passes {
                self.sample_luminaires(gloss, share / passes as f64, cut, stream, shown);
            }
            while let Some((end, weight)) = ends.pop() {
                end_at(self.world, &end, weight, places);
                let Some(gloss) = Gloss::of(self.world, &end) else { continue };
                self.sample_luminaires(&gloss, weight, cut, stream, shown);
                let survival = gloss.reflectance.min(MOST_SURVIVAL);
                if stream.happens(survival) {
                    self.send_ray(&gloss, weight * gloss.reflectance / survival, stream, &mut ends, shown);
                }
            }
        }
    }

    /// Traces a ray along gloss. What it meets counts with a weight. Surfaces are added to `ends`.
    fn send_ray(
        &self,
        gloss: &Gloss,
        weight: f64,
        stream: &mut Stream,
        ends: &mut Vec<(SubPoint, f64)>,
        shown: &mut Shown,
    ) {
        let Gloss { end, bsdf, .. } = *gloss;
        let Some(scattered) = bsdf.sample_gloss(end.direction, end.normal, stream) else { return };
        let origin = self.world.leave(&end.hit, scattered.lobe);
        let per_sr = gloss.response_per_sr(scattered.direction);
        let list = self.world.emitters.list();
        let mut luminaires_cd_m2 = 0.0;
        shown.rays += trace_sight(self.world, &origin, scattered.direction, SMALL_SHARE, stream, |seen| match seen {
            Seen::Luminaire(luminaire) => {
                // Light samples find all light of openings, and a share of the light that comes straight from other luminaires. They find
                // all light of images if images of areas are sampled.
                let Some(emitter) = luminaire.emitter.map(|number| &list[number as usize]) else { return };
                let share = match luminaire.is_straight {
                    true => share_of_ray(self.world, emitter, &end.receiver(), per_sr),
                    false if self.samples_area_images => 0.0,
                    false => 1.0,
                };
                luminaires_cd_m2 += share * luminaire.luminance_cd_m2;
            }
            Seen::Surface(next) => {
                let weight = weight * next.share;
                ends.push((next, weight));
            }
        });
        if self.with_luminaires {
            shown.luminaires_cd_m2 += weight * luminaires_cd_m2;
        }
    }

    /// Takes light samples of luminaires from gloss, and of point luminaires in flat mirrors.
    fn sample_luminaires(&self, gloss: &Gloss, weight: f64, cut: &mut Cut, stream: &mut Stream, shown: &mut Shown) {
        if !self.with_luminaires || self.world.emitters.list().is_empty() {
            return;
        }
        let responses = |pair: &Pair| [0.0, gloss.response_per_sr(pair.towards)];
        let sampled = light_from_gloss_cd_m2(self.world, gloss.end, responses, stream);
        shown.luminaires_cd_m2 += weight * sampled.value;
        shown.rays += sampled.rays;
        if let Some(mirrors) = &self.world.mirrors {
            let response = |towards: DVec3| gloss.response_per_sr(towards);
            let receiver = gloss.end.receiver();
            let mut images = sample_points_in_mirrors(self.world, mirrors, &receiver, response, cut, stream);
            if self.samples_area_images {
                images += sample_area_images_with(self.world, mirrors, &receiver, response, stream);
            }
            shown.luminaires_cd_m2 += weight * images.value;
            shown.rays += images.rays;
        }
    }
}

/// A glossy surface that is seen.
struct Gloss<'a> {
    end: &'a SubPoint,
    bsdf: &'a Bsdf,
    /// Reflectance without the diffuse part.
    reflectance: f64,
}

impl<'a> Gloss<'a> {
    /// Returns the gloss at a sub-point; `None` for a surface without gloss.
    fn of(world: &'a World, end: &'a SubPoint) -> Option<Gloss<'a>> {
        let bsdf = world.bsdf(end.hit.triangle);
        let is_glossy = !bsdf.is_specular() && !matches!(bsdf, Bsdf::Diffuse(_) | Bsdf::Translucent(_));
        let reflectance = bsdf.total(1.0) - bsdf.diffuse_part();
        (is_glossy && reflectance > 0.0).then_some(Gloss { end, bsdf, reflectance })
    }

    /// Returns the luminance towards the eye for each lx that comes from a direction, without the diffuse part.
    fn response_per_sr(&self, towards: DVec3) -> f64 {
        let pair = Pair { normal: self.end.normal, towards, leaving: -self.end.direction };
        (self.bsdf.eval_per_sr(&pair) - FRAC_1_PI * self.bsdf.diffuse_part()).max(0.0)
    }
}

/// Adds the sides of a surface whose light reaches the eye from a sub-point, with a weight.
fn end_at(world: &World, end: &SubPoint, weight: f64, places: &mut Vec<SeenPlace>) {
    let mut add = |normal: DVec3, origin: Origin, share: f64| {
        if share > 0.0 {
            places.push(SeenPlace { point_m: end.point_m, normal, origin, weight_per_sr: weight * share / PI });
        }
    };
    match world.bsdf(end.hit.triangle) {
        Bsdf::Diffuse(bsdf) => add(end.normal, end.origin, bsdf.reflectance),
        Bsdf::Translucent(bsdf) => {
            add(end.normal, end.origin, bsdf.reflectance);
            add(-end.normal, end.behind(world), bsdf.transmittance);
        }
        bsdf => add(end.normal, end.origin, bsdf.diffuse_part()),
    }
}
