//! Walks for indirect light: those of receivers, and other walks where flat mirrors show balls and areas, which sample the images directly.
//! A random ray towards a mirror meets a small ball there very rarely. A map would then consist of the few rays that do.
//!
//! Light that reaches a diffuse surface, or the receiver point itself, by way of mirrors alone is counted by samples of images
//! ([`crate::estimators::images`]). It is left out where a walk's ray meets it. Light that reaches glossy surfaces and sheets by way of
//! mirrors is met by random rays as before. Each path ends at one surface before its mirrors, so it is counted exactly once.

use glam::DVec3;

use super::mesh::Surroundings;
use crate::estimators::cache::{Cache, CacheAnswer, Met};
use crate::estimators::images::{sample_area_images, sample_points_in_mirrors};
use crate::estimators::receiver::Receiver;
use crate::estimators::sight::MANY_MIRRORS;
use crate::estimators::walk::{sample_arriving_lx, sample_indirect_lx, walk_arriving_lx};
use crate::geometry::{Meeting, Origin};
use crate::sampling::emitter_tree::Cut;
use crate::sampling::random::{Purpose, Stream};
use crate::sampling::warp::cosine_hemisphere;
use crate::transport::{Traced, World};

/// Number of halves of the walks, for the random error.
pub const HALVES: usize = 2;
/// Map number of the random streams of walks from receiver points.
const FROM_PLACES: u32 = u32::MAX - 2;
/// Map number of the random streams for samples of mirror images.
const IMAGES: u32 = u32::MAX - 4;

/// Returns the light in lx that images in flat mirrors bring to a receiver point, and the number of rays.
fn sample_images(around: &Surroundings, receiver: &Receiver, cut: &mut Cut, stream: &mut Stream) -> Traced {
    let world = around.world;
    let Some(mirrors) = &world.mirrors else {
        return Traced::default();
    };
    let mut images = sample_points_in_mirrors(world, mirrors, receiver, |_| 1.0, cut, stream);
    if around.samples_area_images() {
        images += sample_area_images(world, mirrors, receiver, stream);
    }
    images
}

/// Returns one unbiased sample of the indirect illuminance at a receiver in lx, and the number of rays.
pub fn sample_at_place_lx(around: &Surroundings, receiver: &Receiver, cut: &mut Cut, stream: &mut Stream) -> Traced {
    if !around.samples_area_images() {
        return sample_indirect_lx(around.world, receiver, cut, stream);
    }
    let direction = cosine_hemisphere(receiver.normal, stream.pair());
    let images = sample_images(around, receiver, cut, stream);
    images + sample_along_lx(around, *receiver.origin, direction, cut, stream)
}

/// Returns one unbiased sample of π times the reflected luminance that arrives along a direction, in lx, and the number of rays. If images
/// are sampled, it excludes luminaires seen in mirrors along this direction.
pub fn sample_along_lx(
    around: &Surroundings,
    origin: Origin,
    direction: DVec3,
    cut: &mut Cut,
    stream: &mut Stream,
) -> Traced {
    let world = around.world;
    if !around.samples_area_images() {
        return sample_arriving_lx(world, origin, direction, cut, stream);
    }
    let (mut origin, mut direction) = (origin, direction);
    let mut sum = Traced::default();
    loop {
        let (past, mirror_rays) = past_mirrors(world, origin, direction, stream);
        sum.rays += mirror_rays;
        let Some((start, towards)) = past else { return sum };
        let mut halt = Halt { around, at: None };
        sum += walk_arriving_lx(world, start, towards, &mut halt, cut, stream);
        match halt.at {
            Some(vertex) if stream.unit() < vertex.reflectance => {
                (origin, direction) = (vertex.origin, cosine_hemisphere(vertex.normal, stream.pair()));
            }
            _ => return sum,
        }
    }
}

/// Follows a ray by way of mirrors and through panes until it goes elsewhere; `None` if it is absorbed. Luminaires that it meets are not
/// counted.
fn past_mirrors(
    world: &World,
    mut origin: Origin,
    mut direction: DVec3,
    stream: &mut Stream,
) -> (Option<(Origin, DVec3)>, u64) {
    for rays in 1..=u64::from(MANY_MIRRORS) {
        let Meeting::Surface(hit) = world.tracer.first_hit(&origin, direction) else {
            return (Some((origin, direction)), rays);
        };
        let bsdf = world.bsdf(hit.triangle);
        if !bsdf.is_specular() || !world.receives(hit.triangle, hit.side) {
            return (Some((origin, direction)), rays);
        }
        let normal = world.normal_at(&hit);
        let Some(scattered) = bsdf.sample(direction, normal, stream) else { return (None, rays) };
        origin = world.leave(&hit, scattered.lobe);
        direction = scattered.direction;
    }
    // Mirrors that face each other and absorb nothing: light after `MANY_MIRRORS` reflections is lost.
    (None, u64::from(MANY_MIRRORS))
}

/// Ends a walk at the first diffuse surface, with the light of images there, and records where this is.
struct Halt<'a> {
    around: &'a Surroundings<'a>,
    at: Option<DiffuseVertex>,
}

/// A diffuse surface that a walk has met.
struct DiffuseVertex {
    origin: Origin,
    normal: DVec3,
    reflectance: f64,
}

impl Cache for Halt<'_> {
    const SUPPLIES: bool = true;

    fn look_up(&mut self, met: &Met, cut: &mut Cut, stream: &mut Stream) -> (CacheAnswer, u64) {
        let receiver = &met.receiver;
        self.at =
            Some(DiffuseVertex { origin: *receiver.origin, normal: receiver.normal, reflectance: met.reflectance });
        let images = sample_images(self.around, receiver, cut, stream);
        (CacheAnswer::End(images.value), images.rays)
    }
}

/// Returns the light in lx from images of luminaires in flat mirrors at a receiver point, in two halves, and the number of rays. Harmonics
/// would blur these images.
pub fn images_at_place_lx(
    around: &Surroundings,
    receiver: &Receiver,
    place_number: u64,
    samples: u32,
    seed: u64,
    cut: &mut Cut,
) -> ([f64; HALVES], u64) {
    if around.world.mirrors.is_none() {
        return ([0.0; HALVES], 0);
    }
    let (mut sum_lx, mut rays) = ([0.0; HALVES], 0);
    for (half, sum_lx) in sum_lx.iter_mut().enumerate() {
        let mut stream = Stream::new(seed, Purpose::LightMesh, IMAGES, half as u32);
        for sample in 0..samples {
            stream.seek_quasi((place_number << 32) | u64::from(sample), place_number, u64::from(sample));
            let images = sample_images(around, receiver, cut, &mut stream);
            *sum_lx += images.value / f64::from(samples);
            rays += images.rays;
        }
    }
    (sum_lx, rays)
}

/// Returns the indirect illuminance in lx by walks from the receiver point itself, in two halves, and the number of rays. `walks` holds the
/// number of the first walk and the count.
pub fn walks_at_place_lx(
    around: &Surroundings,
    receiver: &Receiver,
    place_number: u64,
    walks: [u32; 2],
    seed: u64,
    cut: &mut Cut,
) -> ([f64; HALVES], u64) {
    in_halves(place_number, walks, seed, |stream| sample_at_place_lx(around, receiver, cut, stream))
}

/// Returns the means of `count` samples from the number `first` on, in two halves, and the number of rays. The sequence of each half is
/// spread evenly.
pub fn in_halves(
    place_number: u64,
    [first, count]: [u32; 2],
    seed: u64,
    mut sample: impl FnMut(&mut Stream) -> Traced,
) -> ([f64; HALVES], u64) {
    let mut stream = Stream::new(seed, Purpose::LightMesh, FROM_PLACES, 0);
    let (mut sums, mut rays) = ([0.0; HALVES], 0);
    for walk in first..first + count {
        let half = walk as usize % HALVES;
        let sequence = HALVES as u64 * place_number + half as u64;
        stream.seek_quasi((place_number << 32) | u64::from(walk), sequence, u64::from(walk) / HALVES as u64);
        let sampled = sample(&mut stream);
        rays += sampled.rays;
        sums[half] += sampled.value;
    }
    (sums.map(|sum| sum * HALVES as f64 / f64::from(count.max(1))), rays)
}
