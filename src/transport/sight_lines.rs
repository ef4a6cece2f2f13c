//! Rays that show where light passes in a scene, before packets start.

use super::World;
use super::sides_by_area::{SidesByArea, TriangleSide};
use crate::geometry::{Meeting, Origin, SurfaceHit};
use crate::sampling::random::{Purpose, Stream};
use crate::sampling::warp::{cosine_hemisphere, uniform_triangle};
use crate::scene::{Scene, Side};

/// Number of rays from surfaces that show where boxes are clear.
const LINES: u64 = 128;
/// Seed of the streams of these rays and packets.
const SEED: u64 = 0;

/// Traces rays from points evenly spread over all surfaces, in directions in which they reflect. Passes those that meet a surface to `see`.
pub fn see_from_surfaces(
    scene: &Scene,
    world: &World,
    rays: u64,
    stream: &mut Stream,
    mut see: impl FnMut(&Origin, &SurfaceHit),
) {
    let fronts: Vec<TriangleSide> = (0..scene.triangles.len() as u32).map(|triangle| (triangle, Side::Front)).collect();
    if fronts.is_empty() {
        return;
    }
    let sides = SidesByArea::of(scene, &fronts);
    for ray in 0..rays {
        stream.seek_quasi(ray, 2, ray);
        let (triangle, front) = sides.at(stream.unit());
        let is_back = stream.unit() < 0.5 && world.receives(triangle, Side::Back);
        let side = if is_back { Side::Back } else { front };
        let barycentric = uniform_triangle(stream.pair());
        let direction = cosine_hemisphere(world.normal_on(triangle, barycentric, side), stream.pair());
        let origin = world.tracer.surface_origin(triangle, barycentric, side);
        if let Meeting::Surface(hit) = world.tracer.first_hit(&origin, direction) {
            see(&origin, &hit);
        }
    }
}

/// Returns the ends of rays from surfaces to the next, and of shadow rays from there to a luminaire in sight.
pub(super) fn sight_lines(scene: &Scene, world: &World) -> Vec<[Origin; 2]> {
    let emitters = world.emitters.list();
    let mut of_luminaires = Stream::new(SEED, Purpose::Pilot, 5, 0);
    let mut lines = Vec::new();
    see_from_surfaces(scene, world, LINES, &mut Stream::new(SEED, Purpose::Pilot, 4, 0), |from, hit| {
        let here = world.tracer.surface_origin(hit.triangle, hit.barycentric, hit.side);
        lines.push([*from, here]);
        let drawn = (of_luminaires.unit() * emitters.len() as f64) as usize;
        let near = emitters.get(drawn).filter(|emitter| !emitter.is_far());
        let place_m = world.tracer.position_m(&here);
        let sample = near.and_then(|emitter| emitter.light_sample(place_m, world.normal_at(hit), &mut of_luminaires));
        let there = sample.and_then(|sample| sample.place).map(|place| world.origin(&place));
        lines.extend(there.filter(|there| !world.tracer.is_occluded(&here, there)).map(|there| [here, there]));
    });
    lines
}
