//! Rooms in which people work.

use glam::DVec3;
use serde_json::json;

use super::dice::{Dice, rounded};
use super::draft::Draft;
use super::furniture::{
    at, box_room, ceiling_panels, cupboards, desks, lattice, looking_down, looking_up, paints, patch, shelf,
    usual_paints, work_plane,
};

fn furniture_paints(draft: &mut Draft, dice: &mut Dice) {
    for (name, low, high) in [("wood", 0.2, 0.6), ("steel", 0.15, 0.7), ("panel", 0.5, 0.85)] {
        let reflectance = dice.between(low, high);
        draft.paint(name, reflectance);
    }
}

/// Desks, chairs and cupboards under panels.
pub fn furnished(draft: &mut Draft, dice: &mut Dice) {
    usual_paints(draft, dice);
    furniture_paints(draft, dice);
    let size_m = box_room(draft, dice, [5.0, 12.0], [4.0, 9.0], [2.5, 3.4]);
    work_plane(draft, dice, size_m);
    cupboards(draft, dice, size_m);
    let share = dice.between(0.4, 1.0);
    desks(draft, dice, [0.2, 0.1], [size_m.x - 0.1, size_m.y - 0.6], share);
    let counts = lattice(dice, size_m, [6.0, 16.0]);
    let lm_per_m2 = dice.between(150.0, 900.0);
    ceiling_panels(draft, dice, size_m, counts, lm_per_m2);
    if dice.chance(0.5) {
        let place_m = at(dice.between(0.3, size_m.x - 0.3), dice.between(0.3, size_m.y - 0.7), 1.3);
        draft.lamp(place_m, 400.0);
    }
}

/// Luminaires that emit only towards the ceiling.
pub fn uplit(draft: &mut Draft, dice: &mut Dice) {
    usual_paints(draft, dice);
    furniture_paints(draft, dice);
    let size_m = box_room(draft, dice, [4.0, 11.0], [3.5, 8.0], [2.4, 3.8]);
    work_plane(draft, dice, size_m);
    let share = dice.between(0.2, 0.8);
    desks(draft, dice, [0.3, 0.1], [size_m.x - 0.1, size_m.y - 0.4], share);
    let count = dice.count(1, 5);
    let flux_lm = rounded(size_m.x * size_m.y * dice.between(200.0, 900.0) / count as f64);
    let is_panel = dice.chance(0.6);
    for _ in 0..count {
        let below_m = dice.between(0.12, 0.9);
        let [x, y, z] =
            [dice.between(0.4, size_m.x - 1.2), dice.between(0.3, size_m.y - 0.8), rounded(size_m.z - below_m)];
        if is_panel {
            let [width_m, depth_m] = [dice.between(0.2, 0.8), dice.between(0.1, 0.5)];
            draft.panel("panel", looking_up(x, y, z, width_m, depth_m), rounded(flux_lm / (width_m * depth_m)));
        } else {
            // A dish below the point hides it from below.
            draft.plate(
                &format!("dish {}", draft.luminaire_count()),
                "panel",
                looking_up(x - 0.2, y - 0.2, z - 0.06, 0.4, 0.4),
            );
            draft.spot(at(x, y, z), at(0.0, 0.0, 1.0), flux_lm);
        }
    }
}

/// White surfaces everywhere: light is reflected many times.
pub fn white(draft: &mut Draft, dice: &mut Dice) {
    paints(draft, dice, [0.86, 0.92], [0.88, 0.92], [0.88, 0.92]);
    draft.paint("wood", 0.9);
    draft.paint("steel", 0.9);
    draft.paint("panel", 0.9);
    let size_m = box_room(draft, dice, [3.0, 9.0], [3.0, 8.0], [2.3, 4.0]);
    work_plane(draft, dice, size_m);
    for _ in 0..dice.count(1, 3) {
        let [x, y] = [dice.between(0.3, size_m.x - 0.9), dice.between(0.3, size_m.y - 0.9)];
        let [width_m, depth_m, height_m] =
            [dice.between(0.2, 0.6), dice.between(0.2, 0.6), dice.between(0.5, size_m.z - 0.3)];
        if draft.is_clear(at(x, y, 0.0), at(x + width_m, y + depth_m, height_m)) {
            draft.block("wood", [x, y, 0.0], [x + width_m, y + depth_m, height_m]);
        }
    }
    desks(draft, dice, [0.3, 0.3], [2.4, 2.4], 1.0);
    for _ in 0..dice.count(1, 4) {
        let below_m = dice.between(0.2, 0.8);
        let place_m =
            at(dice.between(0.3, size_m.x - 0.3), dice.between(0.3, size_m.y - 0.3), rounded(size_m.z - below_m));
        let flux_lm = dice.between(200.0, 2000.0);
        if !draft.is_inside(place_m) {
            draft.lamp(place_m, flux_lm);
        }
    }
    ceiling_panels(draft, dice, size_m, [1, 1], 100.0);
}

/// Black or nearly black surfaces.
pub fn dark(draft: &mut Draft, dice: &mut Dice) {
    paints(draft, dice, [0.02, 0.08], [0.02, 0.12], [0.02, 0.12]);
    for (name, low, high) in [("wood", 0.02, 0.1), ("steel", 0.03, 0.15), ("panel", 0.0, 0.1)] {
        let reflectance = dice.between(low, high);
        draft.paint(name, reflectance);
    }
    let size_m = box_room(draft, dice, [4.0, 11.0], [4.0, 9.0], [2.4, 4.5]);
    work_plane(draft, dice, size_m);
    cupboards(draft, dice, size_m);
    let share = dice.between(0.2, 0.9);
    desks(draft, dice, [0.3, 0.1], [size_m.x - 0.1, size_m.y - 0.7], share);
    if dice.chance(0.5) {
        let counts = lattice(dice, size_m, [8.0, 20.0]);
        ceiling_panels(draft, dice, size_m, counts, 300.0);
    } else {
        for _ in 0..dice.count(2, 6) {
            let place_m = at(
                dice.between(0.4, size_m.x - 0.4),
                dice.between(0.4, size_m.y - 0.7),
                rounded(size_m.z - dice.between(0.1, 0.9)),
            );
            let flux_lm = dice.between(300.0, 2500.0);
            draft.lamp(place_m, flux_lm);
        }
    }
}

/// Floor and furniture with Phong reflection, and a large mirror on a wall.
pub fn glossy(draft: &mut Draft, dice: &mut Dice) {
    paints(draft, dice, [0.1, 0.4], [0.5, 0.8], [0.3, 0.7]);
    let lobe = |diffuse: f64, specular: f64, exponent: f64| {
        json!({
            "type": "phong", "diffuse_reflectance": diffuse, "specular_reflectance": specular, "exponent": exponent,
        })
    };
    for (name, diffuse) in [("floor", 0.2), ("wood", 0.3), ("steel", 0.1)] {
        let [specular, exponent] = [dice.between(0.05, 0.45), rounded(dice.log_between(5.0, 400.0))];
        draft.material(name, lobe(diffuse, specular, exponent));
    }
    draft.paint("panel", 0.7);
    draft.material("mirror", json!({ "type": "mirror", "reflectance": dice.between(0.7, 0.92) }));
    let size_m = box_room(draft, dice, [4.0, 10.0], [3.5, 8.0], [2.5, 3.4]);
    work_plane(draft, dice, size_m);
    // The mirror is in front of the wall of lowest x.
    let [from_m, height_m] = [dice.between(0.2, 1.0), dice.between(1.0, size_m.z - 0.6)];
    let width_m = rounded((size_m.y - from_m) * dice.between(0.5, 0.95));
    draft.plate("mirror", "mirror", patch(at(0.012, from_m, 0.4), at(0.0, width_m, 0.0), at(0.0, 0.0, height_m)));
    cupboards(draft, dice, size_m);
    let share = dice.between(0.3, 0.8);
    desks(draft, dice, [0.3, 0.1], [size_m.x - 0.1, size_m.y - 0.7], share);
    let ball_m = at(size_m.x - 0.5, 0.5, 0.35);
    if draft.is_clear(ball_m - DVec3::splat(0.35), ball_m + DVec3::splat(0.35)) {
        draft.ball("ball", "mirror", ball_m, 0.3);
    }
    match dice.count(0, 2) {
        0 => {
            let counts = lattice(dice, size_m, [6.0, 14.0]);
            ceiling_panels(draft, dice, size_m, counts, 400.0);
        }
        1 => {
            for x in [0.3, 0.7] {
                let z = rounded(size_m.z - dice.between(0.2, 0.5));
                let flux_lm = dice.between(1000.0, 4000.0);
                draft.lamp(at(rounded(x * size_m.x), rounded(0.45 * size_m.y), z), flux_lm);
            }
        }
        _ => {
            let file = ("troffer.ies", include_str!("../../../../scenes/luminaires/troffer.ies"));
            for x in [0.25, 0.75] {
                let place_m = at(rounded(x * size_m.x), rounded(0.5 * size_m.y), size_m.z - 0.02);
                draft.photometric(file, place_m, at(0.0, 0.0, -1.0), 0.9);
            }
        }
    }
}

/// Panels at the top of deep coffers in the ceiling, so that light comes out of wells.
pub fn coffers(draft: &mut Draft, dice: &mut Dice) {
    usual_paints(draft, dice);
    furniture_paints(draft, dice);
    draft.paint("beams", dice.between(0.3, 0.85));
    let size_m = box_room(draft, dice, [4.0, 9.0], [4.0, 8.0], [2.8, 4.0]);
    work_plane(draft, dice, size_m);
    let share = dice.between(0.3, 0.8);
    desks(draft, dice, [0.3, 0.1], [size_m.x - 0.1, size_m.y - 0.4], share);
    let counts = lattice(dice, size_m, [4.0, 9.0]).map(|count| count.clamp(2, 5));
    let [depth_m, width_m] = [dice.between(0.2, 0.6), dice.between(0.1, 0.3)];
    let low_m = rounded(size_m.z - depth_m);
    let cell_m = [size_m.x / counts[0] as f64, size_m.y / counts[1] as f64];
    // Beams along x from wall to wall, and pieces along y between them.
    let line = |axis: usize, index: usize| rounded(cell_m[axis] * index as f64 - 0.5 * width_m);
    for row in 1..counts[1] {
        let y = line(1, row);
        draft.block("beams", [0.0, y, low_m], [size_m.x, y + width_m, size_m.z]);
    }
    for column in 1..counts[0] {
        let x = line(0, column);
        for row in 0..counts[1] {
            let from = if row == 0 { 0.0 } else { line(1, row) + width_m };
            let to = if row + 1 == counts[1] { size_m.y } else { line(1, row + 1) };
            draft.block("beams", [x, from, low_m], [x + width_m, to, size_m.z]);
        }
    }
    let [side_x_m, side_y_m] = [rounded(0.35 * cell_m[0]), rounded(0.35 * cell_m[1])];
    let exitance_lm_m2 = dice.between(1500.0, 6000.0);
    for column in 0..counts[0] {
        for row in 0..counts[1] {
            if column + row == 0 || dice.chance(0.8) {
                let x = rounded(cell_m[0] * (column as f64 + 0.5) - 0.5 * side_x_m);
                let y = rounded(cell_m[1] * (row as f64 + 0.5) - 0.5 * side_y_m);
                let panel = looking_down(x, y, size_m.z - 0.01, side_x_m, side_y_m);
                draft.panel("panel", panel, exitance_lm_m2);
                let shaded = looking_down(rounded(cell_m[0] * column as f64 + width_m), y, size_m.z, 0.05, side_y_m);
                draft.region("in coffers", shaded);
            }
        }
    }
}

/// A glass partition, and lampshades that transmit light.
pub fn panes(draft: &mut Draft, dice: &mut Dice) {
    usual_paints(draft, dice);
    furniture_paints(draft, dice);
    draft.paint("goods", dice.between(0.2, 0.7));
    draft.material(
        "glass",
        json!({ "type": "glass", "refractive_index": 1.52, "internal_transmittance": dice.between(0.8, 0.99) }),
    );
    let reflected = dice.between(0.3, 0.5);
    draft.material(
        "shade",
        json!({ "type": "translucent", "diffuse_reflectance": reflected, "diffuse_transmittance": dice.between(0.2, 0.45) }),
    );
    let size_m = box_room(draft, dice, [5.0, 10.0], [4.0, 8.0], [2.5, 3.3]);
    work_plane(draft, dice, size_m);
    let pane_m = rounded(size_m.x * dice.between(0.4, 0.6));
    let [from_m, to_m] = [dice.between(0.0, 0.5), rounded(size_m.y - dice.between(0.0, 0.9))];
    draft.plate(
        "pane",
        "glass",
        patch(at(pane_m, from_m, 0.0), at(0.0, to_m - from_m, 0.0), at(0.0, 0.0, rounded(size_m.z - 0.2))),
    );
    desks(draft, dice, [0.2, 0.1], [pane_m - 0.1, size_m.y - 0.4], 0.6);
    let shelf_m = at(rounded(size_m.x - pane_m - 0.6), 0.35, 1.9);
    shelf(draft, dice, at(pane_m + 0.3, size_m.y - 0.37, 0.0), shelf_m, false);
    for _ in 0..dice.count(2, 4) {
        let is_left = dice.chance(0.7);
        let x = if is_left { dice.between(0.4, pane_m - 0.4) } else { dice.between(pane_m + 0.4, size_m.x - 0.4) };
        let y = dice.between(0.4, size_m.y - 0.8);
        let z = rounded(size_m.z - dice.between(0.4, 0.7));
        let half_m = dice.between(0.15, 0.25);
        let side_m = 2.0 * half_m;
        // A shade around the point, open at top and bottom.
        let corner_m = at(x - half_m, y - half_m, z - 0.12);
        let up_m = at(0.0, 0.0, 0.24);
        let number = draft.luminaire_count();
        let sides = [
            patch(corner_m, at(side_m, 0.0, 0.0), up_m),
            patch(corner_m + at(0.0, side_m, 0.0), at(side_m, 0.0, 0.0), up_m),
            patch(corner_m, at(0.0, side_m, 0.0), up_m),
            patch(corner_m + at(side_m, 0.0, 0.0), at(0.0, side_m, 0.0), up_m),
        ];
        for (index, side) in sides.into_iter().enumerate() {
            draft.plate(&format!("shade {number}.{index}"), "shade", side);
        }
        let flux_lm = dice.between(600.0, 2500.0);
        draft.lamp(at(x, y, z), flux_lm);
    }
}
