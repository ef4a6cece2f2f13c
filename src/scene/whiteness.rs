//! How much a closed room absorbs of the light in it: where that is next to nothing, no chain ends in good time.

use std::f64::consts::PI;

use glam::DVec3;

use super::model::{Emission, Scene, Surface};
use super::shells::{Enclosures, Shell, shells_of_scene};

/// Where surfaces absorb less than this share on average, a packet meets more than 10,000 of them, and not even pilots end in
/// good time. A hair less than a ten-thousandth: sums over a room of ρ = 0.9999 round.
pub(super) const LEAST_ABSORBED: f64 = 0.9999e-4;

/// Mean share, by area, that is absorbed by what stands about a luminaire in a closed room which no light can leave: of all such
/// rooms in which nearly white surfaces stand the least. `None` where there is none.
pub(super) fn absorbed_share(scene: &Scene) -> Option<f64> {
    if scene.surfaces.iter().all(|surface| absorbed_by(scene, surface) >= LEAST_ABSORBED) {
        return None;
    }
    let shells = shells_of_scene(scene);
    let enclosures = Enclosures::of(scene, &shells);
    let lit = || scene.luminaires.iter().filter(|luminaire| luminaire.luminous_flux_lm > 0.0);
    let starts_m: Vec<DVec3> = lit().flat_map(|luminaire| enclosures.starts_m(&luminaire.emission)).collect();
    let is_around = |room: &Shell, point_m: DVec3| room.winding(point_m).abs() > 0.5;
    let smallest_around = |start_m: &DVec3| {
        let around = enclosures.shells().filter(|room| is_around(room, *start_m));
        around.min_by(|one, other| one.volume_m3.abs().total_cmp(&other.volume_m3.abs()))
    };
    let mut rooms: Vec<&Shell> = Vec::new();
    for room in starts_m.iter().filter_map(smallest_around) {
        if !rooms.iter().any(|known| std::ptr::eq(*known, room)) {
            rooms.push(room);
        }
    }
    let absorbed_in = |room: &Shell| {
        let mut sums = Sums::default();
        for shell in &shells {
            let is_room = std::ptr::eq(shell, room);
            let is_lit = |point_m| is_around(room, point_m) && (is_room || !is_around(shell, point_m));
            sums.add_shell(scene, shell, enclosures.step_m(), is_lit);
        }
        for luminaire in &scene.luminaires {
            if let Emission::Sphere { center_m, radius_m, .. } = luminaire.emission
                && is_around(room, center_m)
            {
                sums.add(4.0 * PI * radius_m * radius_m, 1.0);
            }
        }
        sums.absorbed_m2 / sums.area_m2
    };
    rooms.into_iter().map(absorbed_in).min_by(f64::total_cmp)
}

/// Share of the light on a surface's front that it absorbs.
fn absorbed_by(scene: &Scene, surface: &Surface) -> f64 {
    1.0 - scene.materials[surface.material as usize].law.returned_share()
}

/// Area, and how much of it absorbs.
#[derive(Default)]
struct Sums {
    area_m2: f64,
    absorbed_m2: f64,
}

impl Sums {
    fn add(&mut self, area_m2: f64, absorbed: f64) {
        self.area_m2 += area_m2;
        self.absorbed_m2 += absorbed * area_m2;
    }

    /// Adds the sides of a shell that light of a room can reach.
    fn add_shell(&mut self, scene: &Scene, shell: &Shell, step_m: f64, is_lit: impl Fn(DVec3) -> bool) {
        for triangle in &shell.triangles {
            let surface = scene.surface_of(*triangle);
            let middle_m = scene.corners_m(*triangle).iter().sum::<DVec3>() / 3.0;
            let area_m2 = scene.triangle_area_m2(*triangle);
            let step = step_m * scene.triangle_normal(*triangle);
            let front = absorbed_by(scene, surface);
            let back = if surface.two_sided { front } else { 1.0 };
            for (side_m, absorbed) in [(middle_m + step, front), (middle_m - step, back)] {
                if is_lit(side_m) {
                    self.add(area_m2, absorbed);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::scene::scene_from_json;

    fn read(white: f64, rest: &str) -> Result<(), String> {
        let text = format!(
            r#"{{ "version": 1, "materials": {{ "white": {{ "type": "diffuse", "reflectance": {white} }}, "grey": {{ "type": "diffuse", "reflectance": 0.2 }} }},
            "geometry": [ {{ "name": "room", "type": "box", "min": [0,0,0], "max": [4,4,3], "facing": "inward", "material": "white" }} {rest} ],
            "luminaires": [ {{ "name": "lamp", "type": "point", "position": [2,2,2.5], "luminous_flux_lm": 1000 }} ] }}"#
        );
        scene_from_json(&text, None, std::path::Path::new(".")).map(|_| ()).map_err(|error| error.to_string())
    }

    fn chest(min: [f64; 3], edge_m: f64, material: &str) -> String {
        let max = min.map(|low| low + edge_m);
        format!(r#", {{ "name": "chest", "type": "box", "min": {min:?}, "max": {max:?}, "material": "{material}" }}"#)
    }

    /// A grey chest of 10 cm in a room of 80 m² absorbs 0.8 · 0.06 / 80.06 = 6e-4 of it; one of 1 cm a hundredth of that.
    #[test]
    fn a_white_room_needs_enough_that_absorbs_in_it() {
        assert!(read(1.0, &chest([1.0, 1.0, 1.0], 0.1, "grey")).is_ok());
        let refused = read(1.0, &chest([1.0, 1.0, 1.0], 0.01, "grey")).expect_err("nearly nothing absorbs");
        assert!(refused.contains("6.0e-6") && refused.contains("next to nothing absorbs"), "{refused}");
    }

    #[test]
    fn what_stands_outside_of_a_room_absorbs_nothing_of_its_light() {
        let around = r#", { "name": "house", "type": "box", "min": [-1,-1,-1], "max": [9,9,9], "facing": "inward", "material": "grey" }"#;
        assert!(read(1.0, around).is_err());
        assert!(read(0.9999, around).is_ok());
        assert!(read(1.0, &chest([5.0, 5.0, 1.0], 1.0, "grey")).is_err());
    }

    /// The back of a single sheet absorbs all that falls on it.
    #[test]
    fn backs_of_sheets_absorb() {
        let sheet = r#", { "name": "sheet", "type": "rectangle", "origin": [1,1,1], "u": [1,0,0], "v": [0,1,0], "material": "white" }"#;
        assert!(read(1.0, sheet).is_ok());
        let both = sheet.replace(r#""material""#, r#""two_sided": true, "material""#);
        assert!(read(1.0, &both).is_err());
    }
}
