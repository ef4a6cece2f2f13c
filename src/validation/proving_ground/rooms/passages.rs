//! Rooms through which people walk: corridors, doors, stairs.

use glam::DVec3;

use super::dice::{Dice, rounded};
use super::draft::Draft;
use super::furniture::{at, box_room, looking_down, looking_up, paints, patch, shelf, usual_paints};
use super::solid::Solid;

/// A long corridor with doors in niches.
pub fn corridor(draft: &mut Draft, dice: &mut Dice) {
    usual_paints(draft, dice);
    draft.paint("doors", dice.between(0.1, 0.6));
    draft.paint("panel", dice.between(0.5, 0.85));
    let niche_m = dice.between(0.15, 0.6);
    let (length, width, height) = ([10.0, 30.0], dice.between(1.4, 2.6), [2.3, 3.0]);
    let across = rounded(width + 2.0 * niche_m);
    let size_m = box_room(draft, dice, length, [across, across], height);
    let head_m = dice.between(2.02, 2.15);
    for side in [0.0, size_m.y - niche_m] {
        let mut x = 0.0;
        while x < size_m.x {
            // A piece of wall, then a niche with a door at its back.
            let end = rounded((x + dice.between(1.0, 4.0)).min(size_m.x));
            draft.block("walls", [x, side, 0.0], [end, side + niche_m, size_m.z]);
            let to = rounded(end + dice.between(0.85, 1.2));
            if to > size_m.x - 0.2 {
                if end < size_m.x {
                    draft.block("walls", [end, side, 0.0], [size_m.x, side + niche_m, size_m.z]);
                }
                break;
            }
            draft.block("walls", [end, side, head_m], [to, side + niche_m, size_m.z]);
            let door = if side == 0.0 { [0.0, 0.04] } else { [size_m.y - 0.04, size_m.y] };
            draft.block("doors", [end + 0.05, door[0], 0.0], [to - 0.05, door[1], head_m - 0.04]);
            let [width_m, up_m] = [at(to - end, 0.0, 0.0), at(0.0, 0.0, head_m)];
            let back = if side == 0.0 {
                patch(at(end, 0.04, 0.0), up_m, width_m)
            } else {
                patch(at(end, size_m.y - 0.04, 0.0), width_m, up_m)
            };
            draft.region("doors in niches", back);
            x = to;
        }
    }
    let z = dice.between(0.02, 1.0);
    let columns = (size_m.x * 4.0) as usize;
    draft.grid("work plane", [0.0, niche_m, z], [size_m.x, size_m.y - niche_m], [columns.min(80), 5]);
    let count = dice.count(3, 8);
    let kind = dice.count(0, 2);
    let washer = ("wall_washer.ldt", include_str!("../../../../scenes/luminaires/wall_washer.ldt"));
    let flux_lm = rounded(size_m.x * width * dice.between(100.0, 400.0) / count as f64);
    for lamp in 0..count {
        let x = rounded(size_m.x * (lamp as f64 + 0.5) / count as f64);
        let y = rounded(0.5 * size_m.y);
        match kind {
            0 => draft.lamp(at(x, y, rounded(size_m.z - dice.between(0.1, 0.4))), flux_lm),
            1 => draft.photometric(washer, at(x, y, size_m.z - 0.05), DVec3::NEG_Z, 1.0),
            _ => {
                let panel = looking_down(x - 0.3, y - 0.07, size_m.z - 0.04, 0.6, 0.14);
                draft.panel("panel", panel, rounded(flux_lm / 0.084));
            }
        }
    }
}

/// A long and narrow duct or gallery with few lamps.
pub fn long_thin(draft: &mut Draft, dice: &mut Dice) {
    paints(draft, dice, [0.1, 0.5], [0.3, 0.8], [0.3, 0.8]);
    draft.paint("trays", dice.between(0.2, 0.7));
    let size_m = box_room(draft, dice, [45.0, 80.0], [1.2, 2.0], [2.0, 2.5]);
    let height_m = dice.between(0.05, 0.9);
    draft.grid("work plane", [0.0, 0.0, height_m], [size_m.x, size_m.y], [130, 3]);
    for tray in 0..dice.count(1, 3) {
        let z = rounded(1.2 + 0.35 * tray as f64);
        let reach_m = dice.between(0.1, 0.35);
        let end_m = rounded(size_m.x * dice.between(0.6, 1.0));
        draft.block("trays", [0.0, 0.01, z], [end_m, 0.01 + reach_m, z + 0.02]);
        draft.region("under trays", looking_down(0.0, 0.01, z, end_m, reach_m));
    }
    let every_m = dice.between(6.0, 14.0);
    let flux_lm = dice.between(600.0, 3000.0);
    let file = ("downlight.ldt", include_str!("../../../../scenes/luminaires/downlight.ldt"));
    let photometric = dice.chance(0.3);
    let mut x = dice.between(0.5, 4.0);
    while x < size_m.x - 0.3 {
        // Some lamps are missing, but never the first one.
        if draft.luminaire_count() == 0 || dice.chance(0.7) {
            let place_m = at(x, rounded(size_m.y * dice.between(0.4, 0.6)), size_m.z - 0.15);
            if photometric {
                draft.photometric(file, place_m, DVec3::NEG_Z, 1.0);
            } else {
                draft.lamp(place_m, flux_lm);
            }
        }
        x = rounded(x + every_m);
    }
}

/// Two rooms with a slightly open door between them. Only one of them is lit.
pub fn door_ajar(draft: &mut Draft, dice: &mut Dice) {
    usual_paints(draft, dice);
    for (name, low, high) in [("doors", 0.2, 0.7), ("wood", 0.2, 0.6), ("goods", 0.2, 0.7), ("panel", 0.5, 0.8)] {
        let reflectance = dice.between(low, high);
        draft.paint(name, reflectance);
    }
    let size_m = box_room(draft, dice, [6.0, 10.0], [3.0, 5.0], [2.4, 3.0]);
    let wall_m = rounded(size_m.x * dice.between(0.4, 0.6));
    let thick_m = dice.between(0.1, 0.25);
    let end_m = rounded(wall_m + thick_m);
    let [hinge_m, width_m, head_m] = [dice.between(0.6, size_m.y - 1.6), dice.between(0.8, 0.95), 2.03];
    let latch_m = rounded(hinge_m + width_m);
    draft.block("walls", [wall_m, 0.0, 0.0], [end_m, hinge_m, size_m.z]);
    draft.block("walls", [wall_m, latch_m, 0.0], [end_m, size_m.y, size_m.z]);
    draft.block("walls", [wall_m, hinge_m, head_m], [end_m, latch_m, size_m.z]);
    // The leaf turns about its hinge into the second room and leaves a gap of 6 to 14 cm at its far end.
    let gap_m = dice.between(0.06, 0.14);
    let leaf_m = width_m - 0.01;
    let angle_rad = (gap_m / leaf_m).asin();
    let half_m = at(0.02, 0.5 * leaf_m, 0.5 * (head_m - 0.02));
    let hinge = at(end_m - 0.02, hinge_m + 0.005, 0.01 + half_m.z);
    let center_m = hinge + at(half_m.y * angle_rad.sin(), half_m.y * angle_rad.cos(), 0.0);
    let leaf = Solid::Block { low_m: center_m - half_m, high_m: center_m + half_m, turn_rad: -angle_rad };
    draft.thing("doors", leaf);
    let z = dice.between(0.76, 0.9);
    draft.grid("work plane", [0.0, 0.0, z], [wall_m, size_m.y], [18, 12]);
    draft.grid("work plane next door", [end_m, 0.0, z], [size_m.x, size_m.y], [18, 12]);
    let next_m = size_m.x - end_m;
    draft.region("next door", looking_up(end_m, 0.0, 0.0, next_m, size_m.y));
    draft.region("next door", looking_down(end_m, 0.0, size_m.z, next_m, size_m.y));
    draft.region("next door", patch(at(size_m.x, 0.0, 0.0), at(0.0, 0.0, size_m.z), at(0.0, size_m.y, 0.0)));
    let shelf_m = at(rounded(dice.between(0.8, next_m - 0.9)), 0.3, 1.8);
    shelf(draft, dice, at(size_m.x - shelf_m.x - 0.1, size_m.y - 0.32, 0.0), shelf_m, false);
    if dice.chance(0.5) {
        let panel = looking_down(rounded(0.5 * wall_m - 0.3), 1.0, size_m.z - 0.03, 0.6, 0.6);
        draft.panel("panel", panel, dice.between(5000.0, 15000.0));
    } else {
        let place_m = at(dice.between(0.5, wall_m - 0.8), dice.between(0.5, size_m.y - 0.5), size_m.z - 0.3);
        let flux_lm = dice.between(2000.0, 6000.0);
        draft.lamp(place_m.map(rounded), flux_lm);
    }
}

/// A stairwell: flights, landings, posts of railings.
pub fn stairs(draft: &mut Draft, dice: &mut Dice) {
    usual_paints(draft, dice);
    for (name, low, high) in [("steps", 0.2, 0.6), ("steel", 0.1, 0.6), ("panel", 0.5, 0.8)] {
        let reflectance = dice.between(low, high);
        draft.paint(name, reflectance);
    }
    let steps = dice.count(7, 11);
    let [rise_m, tread_m, flight_m] = [dice.between(0.15, 0.19), dice.between(0.25, 0.3), dice.between(1.0, 1.5)];
    let landing_m = rounded(rise_m * (steps + 1) as f64);
    let run_m = rounded(tread_m * steps as f64);
    let eye_m = dice.between(0.05, 0.5);
    let width = 2.0 * flight_m + eye_m;
    let (from, length) = (dice.between(1.2, 2.2), dice.between(1.2, 1.8));
    let x_m = rounded(from + run_m + length);
    let z_m = rounded(2.0 * landing_m + dice.between(1.6, 2.4));
    let size_m = box_room(draft, dice, [x_m, x_m], [width, width], [z_m, z_m]);
    // The first flight goes up along x, solid or made of slabs. The second flight returns above.
    let is_solid = dice.chance(0.5);
    for step in 0..steps {
        let (x, top) = (from + tread_m * step as f64, rise_m * (step + 1) as f64);
        let bottom = if is_solid { 0.0 } else { top - 0.05 };
        draft.block("steps", [x, 0.0, bottom], [x + tread_m, flight_m, top]);
        draft.region("treads", looking_up(x, 0.0, top, tread_m, flight_m));
        let (x, top) = (from + run_m - tread_m * (step + 1) as f64, landing_m + rise_m * (step + 1) as f64);
        let y = flight_m + eye_m;
        draft.block("steps", [x, y, top - 0.05], [x + tread_m, size_m.y, top]);
        draft.region("treads", looking_up(x, y, top, tread_m, flight_m));
        draft.region("under the stairs", looking_down(x, y, top - 0.05, tread_m, flight_m));
        if dice.chance(0.8) {
            draft.block("steel", [x + 0.1, y + 0.03, top], [x + 0.12, y + 0.05, top + 0.9]);
        }
    }
    let landing = from + run_m;
    draft.block("steps", [landing, 0.0, landing_m - 0.15], [size_m.x, size_m.y, landing_m]);
    draft.block("steps", [0.0, flight_m + eye_m, 2.0 * landing_m - 0.15], [from, size_m.y, 2.0 * landing_m - 0.01]);
    draft.region("under the stairs", looking_up(landing, 0.0, 0.0, size_m.x - landing, size_m.y));
    draft.region("under the stairs", looking_down(landing, 0.0, landing_m - 0.15, size_m.x - landing, size_m.y));
    let z = dice.between(0.02, 0.9);
    draft.grid("work plane", [0.0, 0.0, z], [size_m.x, size_m.y], [24, 12]);
    for _ in 0..dice.count(1, 3) {
        let z = dice.between(1.9, size_m.z - 0.4);
        let place_m = at(dice.between(0.3, size_m.x - 0.3), 0.12, z);
        let flux_lm = dice.between(500.0, 2500.0);
        if !draft.is_inside(place_m) {
            draft.lamp(place_m, flux_lm);
        }
    }
    let panel = looking_down(rounded(0.4 * size_m.x), rounded(0.5 * size_m.y - 0.3), size_m.z - 0.03, 0.6, 0.6);
    draft.panel("panel", panel, dice.between(2000.0, 8000.0));
}
