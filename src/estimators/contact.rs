//! Points hidden by contact: something stands on them, for example a partition on the floor, or they lie inside a solid.
//!
//! A surface touches the point or lies a little above it, or the point sees only the backs of one-sided surfaces. Its illuminance is 0, and
//! nobody sees it. A sheet with a black back, for example a luminaire's panel under the ceiling, hides nothing by contact: flat rays find
//! the gap beside it.

use std::f64::consts::TAU;

use glam::DVec3;

use crate::geometry::{Meeting, Origin, SurfaceHit};
use crate::sampling::random::Stream;
use crate::sampling::reflection::LobeKind;
use crate::sampling::warp::cosine_hemisphere;
use crate::scene::Side;
use crate::transport::World;

/// Number of rays that must all meet backs. A point that sees backs beside other things is not hidden.
const RAYS: u64 = 12;
/// Number of flat rays all around that must also all meet backs, and their elevation in rad. A sheet hides all of them only if it extends
/// fifty times as far as it lies above the point.
const FLAT_RAYS: u64 = 8;
const RISE_RAD: f64 = 0.02;
/// Maximum distance of something that stands on a point, in multiples of the position accuracy.
const CLOSE: f64 = 10.0;
/// Most surfaces along a ray among which the end of a solid is searched.
const MOST_SURFACES: u64 = 64;

/// Whether a point with a unit normal is hidden by contact, and the number of rays traced to determine this.
pub fn is_in_contact(world: &World, origin: &Origin, normal: DVec3, stream: &mut Stream) -> (bool, u64) {
    let pressing = world.tracer.pressing_triangle(origin);
    if pressing.is_some_and(|triangle| world.receives(triangle, Side::Back)) {
        // A sheet lies there.
        return (true, 1);
    }
    let close_m = CLOSE * world.tracer.position_accuracy_m();
    let (along, across) = normal.any_orthonormal_pair();
    let (mut rays, mut sees_back) = (1, false);
    for ray in 1..=RAYS + FLAT_RAYS {
        // The first ray follows the normal, directly into what lies just above the point.
        let direction = match ray {
            1 => normal,
            2..=RAYS => cosine_hemisphere(normal, stream.pair()),
            _ => {
                let (sine, cosine) = (TAU * ((ray - RAYS) as f64 + stream.unit()) / FLAT_RAYS as f64).sin_cos();
                RISE_RAD.sin() * normal + RISE_RAD.cos() * (cosine * along + sine * across)
            }
        };
        rays += 1;
        let Meeting::Surface(hit) = world.tracer.first_hit_from_there(origin, direction) else {
            return (false, rays);
        };
        if ray == 1 && hit.distance_m < close_m {
            return (true, rays);
        }
        if !world.receives(hit.triangle, hit.side) {
            sees_back = true;
            continue;
        }
        // A solid that stands there may contain others: where beams cross, a ray within one meets the other from outside. A wall in the
        // same plane that belongs to the next room stands nowhere: rays meet no back without a front before.
        let (within, further_rays) =
            if pressing.is_some() { starts_within(world, hit, direction) } else { (Some(false), 0) };
        rays += further_rays;
        match within {
            Some(true) => sees_back = true,
            Some(false) => return (false, rays),
            None => {}
        }
    }
    (sees_back, rays)
}

/// Whether a ray that meets a surface started within a solid: on its way it meets more backs than fronts. `None` if it meets surfaces that
/// touch front to front, as that of a solid and of the floor below it, or the walls of two rooms in one plane: the order in which it
/// passes them is not known. Also returns the number of further rays.
fn starts_within(world: &World, first: SurfaceHit, direction: DVec3) -> (Option<bool>, u64) {
    let (mut hit, mut entered) = (first, 0i32);
    for rays in 0..MOST_SURFACES {
        if world.tracer.pressing_triangle(&world.leave(&hit, LobeKind::Spread)).is_some() {
            return (None, rays);
        }
        // Two-sided sheets enclose nothing.
        if !world.receives(hit.triangle, Side::Back) {
            entered += if hit.side == Side::Front { 1 } else { -1 };
        }
        if entered < 0 {
            return (Some(true), rays);
        }
        let beyond = world.leave(&hit, LobeKind::SpreadThrough);
        match world.tracer.first_hit_from_there(&beyond, direction) {
            Meeting::Surface(next) => hit = next,
            _ => return (Some(false), rays + 1),
        }
    }
    (None, MOST_SURFACES)
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::check::scene_from_json;
    use crate::estimators::element::Element;
    use crate::sampling::random::Purpose;
    use crate::scene::Scene;

    /// Visits random points of each element of a surface, as shares of its edges.
    fn for_each_point(
        (scene, world): (&Scene, &World),
        surface: &str,
        points: u64,
        seed: u64,
        mut visit: impl FnMut(&Element, [f64; 2], &mut Stream),
    ) {
        let surface = scene.surfaces.iter().position(|each| each.name == surface).expect("a surface") as u32;
        let mut stream = Stream::new(seed, Purpose::Pilot, 0, 0);
        for index in world.elements.of_surface(scene, surface) {
            let element = Element::of(world, scene, &world.elements, index);
            for point in 0..points {
                stream.seek((u64::from(index) << 32) | point);
                let at = element.draw(world, &mut stream);
                visit(&element, at, &mut stream);
            }
        }
    }

    /// Two beams cross below a ceiling, and one of them ends at a wall. A duct passes through the ceiling. At 20,000 points of each element
    /// of both surfaces (seed 3), the hidden points are those in the footprints, up to 0.1 mm from the edges. Two planted faults give other
    /// results at some points: a ray whose hit may be seen from beside its origin, and a ray that starts within a beam and meets the other
    /// beam from outside.
    #[test]
    fn covered_is_what_lies_in_a_footprint_up_to_its_edge() {
        let text = r#"{ "version": 1, "materials": { "m": { "type": "diffuse", "reflectance": 0.5 } },
            "geometry": [
                { "name": "room", "type": "box", "min": [0,0,0], "max": [4.1,3.3,2.7], "facing": "inward", "material": "m" },
                { "name": "one", "type": "box", "min": [1.01,1.03,2.3], "max": [1.17,2.51,2.7], "facing": "outward", "material": "m" },
                { "name": "other", "type": "box", "min": [0,1.6,2.35], "max": [2.2,1.76,2.7], "facing": "outward", "material": "m" },
                { "name": "duct", "type": "box", "min": [3.0,0.5,2.3], "max": [3.3,0.8,3.1], "facing": "outward", "material": "m" } ],
            "luminaires": [ { "name": "a", "type": "point", "position": [3,2,1.5], "luminous_flux_lm": 10000 } ] }"#;
        let scene = scene_from_json(text, None, Path::new(".")).expect("a valid scene");
        let world = World::new(&scene);
        // Minimum and maximum along the two axes that follow in the room's order.
        let on_ceiling = [[1.01, 1.17, 1.03, 2.51], [0.0, 2.2, 1.6, 1.76], [3.0, 3.3, 0.5, 0.8]];
        let surfaces = [("room/ceiling", &on_ceiling[..]), ("room/x_min", &[[1.6, 1.76, 2.35, 2.7]][..])];
        for (name, footprints) in surfaces {
            let (mut inside, mut near_edges, mut beside, mut within) = (0, 0, 0, 0);
            for_each_point((&scene, &world), name, 20_000, 3, |element, at, stream| {
                let point_m = element.point_m(&world, at);
                let (u, v) = if name == "room/ceiling" { (point_m.x, point_m.y) } else { (point_m.y, point_m.z) };
                // Depth inside the footprint that contains it most deeply.
                let depth_m = |[a, b, c, d]: &[f64; 4]| (u - a).min(b - u).min(v - c).min(d - v);
                let depth_m = footprints.iter().map(depth_m).fold(f64::NEG_INFINITY, f64::max);
                if depth_m.abs() < 1e-4 {
                    return;
                }
                let (in_contact, _) = element.is_in_contact(&world, at, stream);
                assert_eq!(in_contact, depth_m > 0.0, "{name} {point_m} {depth_m}");
                if depth_m > 0.0 {
                    let (origin, normal) = (element.origin(&world, at), element.normal_at(&world, at));
                    let met = world.tracer.first_hit(&origin, cosine_hemisphere(normal, stream.pair()));
                    let straight = world.tracer.first_hit_from_there(&origin, normal);
                    let shows = |met: &Meeting| matches!(met, Meeting::Surface(hit) if world.receives(hit.triangle, hit.side) && hit.distance_m > 1e-3);
                    inside += 1;
                    near_edges += u32::from(depth_m < 5e-3);
                    beside += u32::from(shows(&met));
                    within += u32::from(shows(&straight));
                }
            });
            assert!(inside > 100 && near_edges > 5, "{name}: {inside} {near_edges}");
            assert!(beside > 0, "{name}: the planted fault told the same, {beside} {within}");
            assert!(name == "room/ceiling" || within > 0, "{name}: the planted fault told the same");
        }
    }

    /// Two rooms share the plane of a wall, and a cupboard stands against it in one of them. At 5,000 points of each element of the wall on
    /// either side (seed 5), the hidden points are those behind the cupboard, up to 0.1 mm from its edges. Planted fault: that the front of
    /// another surface touches the wall hides all of it.
    #[test]
    fn the_next_room_covers_no_wall() {
        let text = r#"{ "version": 1, "materials": { "m": { "type": "diffuse", "reflectance": 0.5 } },
            "geometry": [
                { "name": "one", "type": "box", "min": [0,0,0], "max": [4,3,2.7], "facing": "inward", "material": "m" },
                { "name": "next", "type": "box", "min": [4,0,0], "max": [7,3,2.7], "facing": "inward", "material": "m" },
                { "name": "third", "type": "box", "min": [-2,0,0], "max": [0,3,2.7], "facing": "inward", "material": "m" },
                { "name": "cupboard", "type": "box", "min": [3.5,1,0], "max": [4,2,1.9], "facing": "outward", "material": "m" } ],
            "luminaires": [ { "name": "a", "type": "point", "position": [2,1.5,1.5], "luminous_flux_lm": 10000 } ] }"#;
        let scene = scene_from_json(text, None, Path::new(".")).expect("a valid scene");
        let world = World::new(&scene);
        for (name, has_cupboard) in [("one/x_max", true), ("next/x_min", false)] {
            let (mut hidden, mut fault) = (0, 0);
            for_each_point((&scene, &world), name, 5_000, 5, |element, at, stream| {
                let [_, y, z] = element.point_m(&world, at).to_array();
                let depth_m = (y - 1.0).min(2.0 - y).min(1.9 - z);
                if depth_m.abs() < 1e-4 {
                    return;
                }
                let (in_contact, _) = element.is_in_contact(&world, at, stream);
                assert_eq!(in_contact, has_cupboard && depth_m > 0.0, "{name} y {y} z {z}");
                hidden += u32::from(in_contact);
                fault += u32::from(world.tracer.pressing_triangle(&element.origin(&world, at)).is_some());
            });
            assert!((hidden > 100) == has_cupboard && fault > 2 * hidden + 100, "{name}: {hidden} {fault}");
        }
    }

    /// A panel of 0.6 m with a black back hangs 10 cm below a ceiling, and another 2 cm. Of 20,000 points on each element of the ceiling
    /// (seed 4), none is hidden by contact. Without flat rays (the planted fault) some would be: only one ray in ten finds the gap.
    #[test]
    fn a_sheet_covers_nothing() {
        let text = r#"{ "version": 1, "materials": { "m": { "type": "diffuse", "reflectance": 0.5 } },
            "geometry": [
                { "name": "room", "type": "box", "min": [0,0,0], "max": [4,3,2.7], "facing": "inward", "material": "m" },
                { "name": "panel", "type": "rectangle", "origin": [1,1,2.6], "u": [0,0.6,0], "v": [0.6,0,0], "material": "m" },
                { "name": "low", "type": "rectangle", "origin": [2.5,1,2.68], "u": [0,0.6,0], "v": [0.6,0,0], "material": "m" } ],
            "luminaires": [ { "name": "a", "type": "area", "surface": "panel", "luminous_flux_lm": 10000 } ] }"#;
        let scene = scene_from_json(text, None, Path::new(".")).expect("a valid scene");
        let world = World::new(&scene);
        let mut in_the_dark = 0;
        for_each_point((&scene, &world), "room/ceiling", 20_000, 4, |element, at, stream| {
            let (origin, normal) = (element.origin(&world, at), element.normal_at(&world, at));
            let meets_back = |direction: DVec3| {
                let met = world.tracer.first_hit_from_there(&origin, direction);
                matches!(met, Meeting::Surface(hit) if !world.receives(hit.triangle, hit.side))
            };
            in_the_dark += u32::from((0..RAYS).all(|_| meets_back(cosine_hemisphere(normal, stream.pair()))));
            assert!(!is_in_contact(&world, &origin, normal, stream).0, "{}", element.point_m(&world, at));
        });
        assert!(in_the_dark > 100, "the planted fault told the same: {in_the_dark}");
    }
}
