//! Sides of triangles that no luminaire can light, whatever is in between: ceilings above luminaires that shine down, floors below floor
//! lights, the undersides of shelves. Light samples from there would find nothing and are omitted.

use rayon::prelude::*;

use super::World;
use crate::sampling::emitter::Reach;
use crate::scene::{Scene, Side, body_of};

/// Number of sides times emitters up to which every side is tested against every emitter: one second of work.
const MOST_TESTS: usize = 200_000_000;
/// Rounding error of a height, as a share of the longest distance in a scene.
const ROUNDING_OF_HEIGHT: f64 = 1e-12;

/// Marks the sides that no emitter of a scene can light.
pub(super) fn mark_unlit(scene: &Scene, world: &mut World) {
    let reaches: Vec<Reach> = world.emitters.list().iter().map(|emitter| emitter.reach()).collect();
    if reaches.len().saturating_mul(scene.triangles.len()) > MOST_TESTS {
        return;
    }
    let tolerance_m = ROUNDING_OF_HEIGHT * world.tracer.longest_m();
    world.triangles.par_iter_mut().enumerate().for_each_init(
        || 0,
        |latest, (triangle, optics)| {
            if body_of(&scene.bodies, triangle as u32).is_some() {
                return;
            }
            let corners_m = scene.corners_m(triangle as u32);
            // No ray starts from the backs of one-sided surfaces.
            for side in Side::of_surface(optics.two_sided).iter().copied() {
                let normal = if side == Side::Front { optics.normal } else { -optics.normal };
                let lights = |reach: &Reach| reach.may_light(&corners_m, normal, tolerance_m);
                // The emitter that lit the previous triangle mostly lights this one too.
                let first = reaches.get(*latest).and_then(|reach| lights(reach).then_some(*latest));
                match first.or_else(|| reaches.iter().position(lights)) {
                    Some(emitter) => *latest = emitter,
                    None => optics.unlit[side as usize] = true,
                }
            }
        },
    );
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::check::scene_from_json;

    #[test]
    fn a_ceiling_with_panels_in_it_is_unlit_and_the_rest_of_the_room_is_not() {
        let room = |lamp: &str| {
            let text = r#"{ "version": 1, "materials": { "grey": { "type": "diffuse", "reflectance": 0.5 } },
                "geometry": [ { "name": "room", "type": "box", "min": [0,0,0], "max": [3,2,1], "facing": "inward", "material": "grey" },
                              { "name": "panel", "type": "rectangle", "origin": [1,1,1], "u": [0,0.5,0], "v": [0.5,0,0], "material": "grey" } ],
                "luminaires": [ LAMP ] }"#;
            let scene = scene_from_json(&text.replace("LAMP", lamp), None, Path::new(".")).expect("a room");
            let world = World::new(&scene);
            let (ceiling, rest): (Vec<u32>, Vec<u32>) =
                (0..12).partition(|triangle| world.normal(*triangle, Side::Front).z < -0.5);
            [ceiling, rest].map(|sides| sides.iter().filter(|side| world.is_unlit((**side, Side::Front))).count())
        };
        let panel = r#"{ "name": "a", "type": "area", "surface": "panel", "luminous_flux_lm": 100 }"#;
        assert_eq!(room(panel), [2, 0]);
        let point = r#"{ "name": "a", "type": "point", "position": [1,1,0.5], "luminous_flux_lm": 100 }"#;
        assert_eq!(room(point), [0, 0]);
    }
}
