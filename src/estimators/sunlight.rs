//! Light of many suns at once: one surface point is tested for all of them.

use glam::DVec3;

use super::receiver::Receiver;
use crate::geometry::{Meeting, Origin};
use crate::sampling::random::Stream;
use crate::sampling::reflection::{Bsdf, LobeKind};
use crate::sampling::warp::uniform_cone;
use crate::scene::{Openings, Scene, body_of};
use crate::transport::{MOST_PANES, World};

/// A triangle certainly hides a sun if the ray crosses it this far within its edges, as weights of its corners.
const WITHIN_EDGES: f64 = 1e-4;

/// A direction up to this angle beyond the rim of a cone, in radians, may be in it.
const BEYOND_RIM_RAD: f64 = 1e-9;

/// Suns that each give 1 lx perpendicular to their rays, by their directions.
#[derive(Clone, Debug)]
pub struct Suns {
    /// Unit directions of their centres.
    pub towards: Vec<DVec3>,
    /// Sine of half the angle that their disks subtend, and one minus its cosine.
    pub disk: [f64; 2],
}

impl Suns {
    /// Passes each sun that lights a point to `found`, by its number, with the illuminance in lx. One point of its disk represents the
    /// whole disk. Returns the number of rays.
    ///
    /// The point of the disk is drawn uniformly over its solid angle. The ground hides what is below the horizon. Suns come in order of
    /// time, so the triangle that hides one sun mostly hides the next. It is tested first, without a ray. With `openings`, light enters
    /// only through them.
    pub fn find_all(
        &self,
        around: (&Scene, &World),
        place: &Receiver,
        openings: Option<&Openings>,
        stream: &mut Stream,
        found: impl FnMut(usize, f64),
    ) -> u64 {
        self.find_some(0..self.towards.len(), around, place, (openings, stream), found)
    }

    /// The same for some of the suns, by their numbers.
    pub fn find_some(
        &self,
        which: impl Iterator<Item = usize>,
        (scene, world): (&Scene, &World),
        place: &Receiver,
        (openings, stream): (Option<&Openings>, &mut Stream),
        mut found: impl FnMut(usize, f64),
    ) -> u64 {
        let [sine, one_minus_cosine] = self.disk;
        let full = 2.0 * one_minus_cosine / (sine * sine);
        let cones = openings.map(|openings| cones_of(openings, place.point_m));
        let mut hidden_by: Option<u32> = None;
        let mut rays = 0;
        for number in which {
            let middle = &self.towards[number];
            if place.normal.dot(*middle) <= -sine || middle.z <= -sine {
                continue;
            }
            let towards = uniform_cone(*middle, one_minus_cosine, stream.pair());
            let cosine = place.normal.dot(towards);
            if cosine <= 0.0 || towards.z <= 0.0 {
                continue;
            }
            if cones.as_ref().is_some_and(|cones| !cones.iter().any(|cone| holds(cone, towards))) {
                continue;
            }
            if hidden_by.is_some_and(|triangle| hides(scene.corners_m(triangle), place.point_m, towards)) {
                continue;
            }
            let (passed, hidden, way_rays) = way_out(world, place.origin, towards);
            rays += way_rays;
            let is_flat = |triangle: &u32| body_of(&scene.bodies, *triangle).is_none();
            hidden_by = hidden.filter(is_flat).or(hidden_by);
            if passed > 0.0 {
                found(number, full * cosine * passed);
            }
        }
        rays
    }
}

/// Share of the light that leaves the scene from a point, the triangle that hides the rest, and the number of rays.
pub fn way_out(world: &World, from: &Origin, towards: DVec3) -> (f64, Option<u32>, u64) {
    let mut here = *from;
    let mut passed = 1.0;
    for rays in 1..=MOST_PANES {
        let hit = match world.tracer.first_hit(&here, towards) {
            Meeting::Nothing => return (passed, None, rays),
            Meeting::Ball(_) => return (0.0, None, rays),
            Meeting::Surface(hit) => hit,
        };
        let Bsdf::Glass(glass) = world.bsdf(hit.triangle) else {
            return (0.0, Some(hit.triangle), rays);
        };
        passed *= glass.shares(world.normal_at(&hit).dot(towards))[1];
        here = world.leave(&hit, LobeKind::Passed);
    }
    (0.0, None, MOST_PANES)
}

/// Whether a ray crosses a triangle well within its edges.
#[inline]
fn hides([a, b, c]: [DVec3; 3], from_m: DVec3, towards: DVec3) -> bool {
    let (to_b, to_c) = (b - a, c - a);
    let across = towards.cross(to_c);
    let volume = to_b.dot(across);
    let offset = from_m - a;
    let around = offset.cross(to_b);
    // Weights of the second and third corner, and the distance to the crossing, each times the volume.
    let scale = volume.signum();
    let (second, third) = (scale * offset.dot(across), scale * towards.dot(around));
    let size = volume.abs();
    let least = WITHIN_EDGES * size;
    second > least && third > least && second + third < size - least && scale * to_c.dot(around) > WITHIN_EDGES * size
}

/// The planes through a point and the edges of each opening, with their normals inward.
fn cones_of(openings: &Openings, point_m: DVec3) -> Vec<[DVec3; 3]> {
    let cone = |corners_m: &[DVec3; 3]| {
        let [a, b, c] = corners_m.map(|corner_m| corner_m - point_m);
        let sign = a.dot(b.cross(c)).signum();
        [a.cross(b), b.cross(c), c.cross(a)].map(|normal| sign * normal.normalize_or_zero())
    };
    openings.fronts_m.iter().map(cone).collect()
}

/// Whether a direction lies in a cone. Its rim and a rounding error beyond it are included.
#[inline]
fn holds(cone: &[DVec3; 3], towards: DVec3) -> bool {
    cone.iter().all(|normal| normal.dot(towards) >= -BEYOND_RIM_RAD)
}
