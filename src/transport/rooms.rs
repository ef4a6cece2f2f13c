//! Rooms of a scene: closed shells that face inward. No light gets from one to another, so nothing is shared between them.

use crate::check::{Shell, plain_shells_of_geometries};
use crate::scene::Scene;

/// Largest number of rooms that are told apart. The others count as one with what lies in no room.
const MOST_ROOMS: usize = u8::MAX as usize;

/// Number of the room of each triangle, from 1: the room that it encloses, or the smallest one whose bounding box contains the middle of
/// its shell. 0 if there is none. `None` if the scene has fewer than two rooms.
pub(super) fn rooms_of_triangles(scene: &Scene) -> Option<Vec<u8>> {
    let shells = plain_shells_of_geometries(scene);
    let is_room = |shell: &&Shell| shell.closed && shell.volume_m3 < 0.0;
    let rooms: Vec<&Shell> = shells.iter().filter(is_room).take(MOST_ROOMS).collect();
    if rooms.len() < 2 {
        return None;
    }
    let room_of = |shell: &Shell| {
        if let Some(own) = rooms.iter().position(|room| std::ptr::eq(*room, shell)) {
            return own as u8 + 1;
        }
        let [low_m, high_m] = shell.bounds_m();
        let middle_m = 0.5 * (low_m + high_m);
        let is_around = |room: &Shell| {
            let [low_m, high_m] = room.bounds_m();
            middle_m.cmpge(low_m).all() && middle_m.cmple(high_m).all()
        };
        let around = rooms.iter().enumerate().filter(|(_, room)| is_around(room));
        let smallest = around.min_by(|(_, one), (_, other)| other.volume_m3.total_cmp(&one.volume_m3));
        smallest.map_or(0, |(number, _)| number as u8 + 1)
    };
    let mut numbers = vec![0; scene.triangles.len()];
    for shell in &shells {
        let number = room_of(shell);
        shell.triangles.iter().for_each(|triangle| numbers[*triangle as usize] = number);
    }
    Some(numbers)
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::check::scene_from_json;

    fn rooms(geometry: &str) -> (Scene, Option<Vec<u8>>) {
        let text = format!(
            r#"{{ "version": 1, "materials": {{ "m": {{ "type": "diffuse", "reflectance": 0.5 }} }}, "geometry": [ {geometry} ],
                "luminaires": [ {{ "name": "a", "type": "point", "position": [1,1,1], "luminous_flux_lm": 1000 }} ] }}"#
        );
        let scene = scene_from_json(&text, None, Path::new(".")).expect("a valid scene");
        let numbers = rooms_of_triangles(&scene);
        (scene, numbers)
    }

    const ONE: &str =
        r#"{ "name": "one", "type": "box", "min": [0,0,0], "max": [4,3,2.7], "facing": "inward", "material": "m" }"#;
    const NEXT: &str =
        r#"{ "name": "next", "type": "box", "min": [4,0,0], "max": [7,3,2.7], "facing": "inward", "material": "m" }"#;
    const DESK: &str = r#"{ "name": "desk", "type": "box", "min": [5,1,0], "max": [6,2,0.7], "material": "m" }"#;
    const ROOF: &str =
        r#"{ "name": "roof", "type": "rectangle", "origin": [0,0,5], "u": [7,0,0], "v": [0,3,0], "material": "m" }"#;

    /// A desk belongs to the room around it, a roof to none.
    #[test]
    fn rooms_are_told_apart_and_furniture_belongs_to_them() {
        let (scene, numbers) = rooms(&[ONE, NEXT, DESK, ROOF].join(", "));
        let numbers = numbers.expect("two rooms");
        for (triangle, number) in (0..).zip(&numbers) {
            let expected = match scene.surface_of(triangle).name.split('/').next() {
                Some("one") => 1,
                Some("next" | "desk") => 2,
                _ => 0,
            };
            assert_eq!(*number, expected, "{}", scene.surface_of(triangle).name);
        }
    }

    /// One room, even with a desk, needs no numbers; nor do two that face outward.
    #[test]
    fn a_single_room_has_no_numbers() {
        assert!(
            rooms(&[ONE, DESK.replace("[5,1,0]", "[1,1,0]").replace("[6,2,", "[2,2,").as_str()].join(", ")).1.is_none()
        );
        assert!(rooms(&[ONE, &NEXT.replace("inward", "outward")].join(", ")).1.is_none());
    }
}
