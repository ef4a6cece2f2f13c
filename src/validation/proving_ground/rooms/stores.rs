//! Rooms full of objects: shelves, clutter, a hall of racks.

use glam::DVec3;

use super::dice::{Dice, rounded};
use super::draft::Draft;
use super::furniture::{
    BEHIND_SHELVES, UNDER_TABLES, at, box_room, ceiling_panels, lattice, looking_down, looking_up, paints, patch,
    shelf, usual_paints, work_plane,
};
use super::solid::Solid;

fn goods_paints(draft: &mut Draft, dice: &mut Dice) {
    for (name, low, high) in [("wood", 0.2, 0.7), ("steel", 0.2, 0.7), ("goods", 0.1, 0.7), ("panel", 0.5, 0.8)] {
        let reflectance = dice.between(low, high);
        draft.paint(name, reflectance);
    }
}

/// Rows of open shelves with goods on them, and narrow aisles.
pub fn shelves(draft: &mut Draft, dice: &mut Dice) {
    usual_paints(draft, dice);
    goods_paints(draft, dice);
    let size_m = box_room(draft, dice, [4.0, 9.0], [4.0, 8.0], [2.4, 3.4]);
    work_plane(draft, dice, size_m);
    let [depth_m, aisle_m] = [dice.between(0.28, 0.5), dice.between(0.8, 1.4)];
    let height_m = dice.between(1.6, size_m.z - 0.25);
    let mut y = dice.between(0.012, 0.06);
    while y + depth_m < size_m.y - 0.01 {
        let from_m = dice.between(0.02, 0.6);
        let length_m = rounded(dice.between(0.6, 0.95) * (size_m.x - from_m));
        shelf(draft, dice, at(from_m, y, 0.0), at(length_m, depth_m, height_m), false);
        if y < 0.1 {
            let back = patch(at(from_m, 0.0, 0.0), at(0.0, 0.0, height_m), at(length_m, 0.0, 0.0));
            draft.region("behind the last shelf", back);
        }
        y = rounded(y + depth_m + aisle_m);
    }
    if dice.chance(0.5) {
        let counts = lattice(dice, size_m, [5.0, 12.0]);
        ceiling_panels(draft, dice, size_m, counts, 500.0);
    } else {
        for _ in 0..dice.count(2, 6) {
            let place_m = at(
                dice.between(0.4, size_m.x - 0.4),
                dice.between(0.4, size_m.y - 0.4),
                rounded(size_m.z - dice.between(0.08, 0.2)),
            );
            let flux_lm = dice.between(600.0, 3000.0);
            draft.lamp(place_m, flux_lm);
        }
    }
}

/// Thousands of small boxes on the floor and on tables.
pub fn many_things(draft: &mut Draft, dice: &mut Dice) {
    usual_paints(draft, dice);
    goods_paints(draft, dice);
    draft.paint("toys", dice.between(0.05, 0.9));
    let size_m = box_room(draft, dice, [4.0, 10.0], [4.0, 9.0], [2.4, 3.6]);
    work_plane(draft, dice, size_m);
    let count = dice.count(2000, 6000);
    let on_floor = dice.between(0.4, 0.8);
    // Tables along the walls. Their boards and the floor below carry objects too.
    let [table_m, depth_m] = [dice.between(0.68, 0.74), dice.between(0.5, 0.8)];
    let top_m = table_m + 0.03;
    let far_m = size_m.y - depth_m;
    for (y, length_m) in [(0.0, size_m.x * dice.between(0.5, 1.0)), (far_m, size_m.x * dice.between(0.3, 0.9))] {
        draft.block("wood", [0.0, y, table_m], [length_m, y + depth_m, top_m]);
        draft.region(UNDER_TABLES, looking_up(0.0, y, 0.0, length_m, depth_m));
        draft.region(UNDER_TABLES, looking_down(0.0, y, table_m, length_m, depth_m));
        strew(draft, dice, [0.0, y, top_m], [length_m, y + depth_m], (count as f64 * (1.0 - on_floor) / 2.0) as usize);
    }
    strew(draft, dice, [0.0, 0.0, 0.0], [size_m.x, size_m.y], (count as f64 * on_floor) as usize);
    if dice.chance(0.6) {
        let counts = lattice(dice, size_m, [6.0, 20.0]);
        ceiling_panels(draft, dice, size_m, counts, 400.0);
    } else {
        for _ in 0..dice.count(1, 5) {
            let place_m = at(
                dice.between(0.5, size_m.x - 0.5),
                dice.between(0.5, size_m.y - 0.5),
                rounded(size_m.z - dice.between(0.1, 0.5)),
            );
            let flux_lm = dice.between(800.0, 4000.0);
            draft.lamp(place_m, flux_lm);
        }
    }
}

/// Adds boxes on a rectangle, one per cell of a lattice, rotated at random.
fn strew(draft: &mut Draft, dice: &mut Dice, low_m: [f64; 3], high_m: [f64; 2], count: usize) {
    let [width_m, depth_m] = [high_m[0] - low_m[0], high_m[1] - low_m[1]];
    let cell_m = (width_m * depth_m / count.max(1) as f64).sqrt();
    let [columns, rows] = [(width_m / cell_m) as usize, (depth_m / cell_m) as usize];
    for column in 0..columns {
        for row in 0..rows {
            let center_m =
                at(low_m[0] + cell_m * (column as f64 + 0.5), low_m[1] + cell_m * (row as f64 + 0.5), low_m[2]);
            // Half of the diagonal stays within the cell for any rotation.
            let half_m = at(dice.between(0.1, 0.33) * cell_m, dice.between(0.1, 0.33) * cell_m, 0.0);
            let height_m = dice.log_between(0.02, 0.35);
            let material = *dice.one_of(&["goods", "toys", "wood", "steel"]);
            let low = (center_m - half_m).map(rounded);
            let high = (center_m + half_m + at(0.0, 0.0, height_m)).map(rounded);
            let is_turned = dice.chance(0.7);
            let turn_rad = if is_turned { dice.between(0.0, 1.5) } else { 0.0 };
            if high.cmpgt(low).all() {
                draft.thing(material, Solid::Block { low_m: low, high_m: high, turn_rad });
            }
        }
    }
}

/// A hall of racks: tens of thousands of triangles and about a hundred luminaires.
pub fn hall(draft: &mut Draft, dice: &mut Dice) {
    paints(draft, dice, [0.15, 0.35], [0.4, 0.7], [0.3, 0.6]);
    goods_paints(draft, dice);
    let size_m = box_room(draft, dice, [40.0, 70.0], [24.0, 42.0], [8.0, 12.0]);
    work_plane(draft, dice, size_m);
    let [bay_m, depth_m, level_m] = [2.8, dice.between(1.0, 1.3), dice.between(1.4, 1.9)];
    let levels = dice.count(3, 5).min(((size_m.z - 1.8) / level_m) as usize);
    let aisle_m = dice.between(2.6, 4.0);
    let bays = ((size_m.x - 8.0) / bay_m) as usize;
    let mut y = dice.between(0.1, 2.0);
    while y + depth_m < size_m.y - 0.1 {
        rack(draft, dice, at(4.0, y, 0.0), bays, levels, at(bay_m, depth_m, level_m));
        let length_m = bay_m * bays as f64;
        draft.region("in racks", looking_up(4.0, y, 0.0, length_m, depth_m));
        if y < 1.0 {
            let up_m = at(0.0, 0.0, level_m * levels as f64);
            draft.region(BEHIND_SHELVES, patch(at(4.0, 0.0, 0.0), up_m, at(length_m, 0.0, 0.0)));
        }
        y = rounded(y + depth_m + aisle_m);
    }
    let columns = (size_m.x / dice.between(4.5, 6.0)) as usize;
    let rows = (size_m.y / dice.between(3.0, 4.5)) as usize;
    let z = rounded(size_m.z - dice.between(0.4, 1.5));
    let photometric = dice.chance(0.3);
    let flux_lm = dice.between(3000.0, 9000.0);
    let file = ("troffer.ies", include_str!("../../../../scenes/luminaires/troffer.ies"));
    for column in 0..columns {
        for row in 0..rows {
            let place_m = at(
                rounded(size_m.x * (column as f64 + 0.5) / columns as f64),
                rounded(size_m.y * (row as f64 + 0.5) / rows as f64),
                z,
            );
            if draft.is_inside(place_m) {
                continue;
            }
            if photometric {
                draft.photometric(file, place_m, DVec3::NEG_Z, 1.0);
            } else {
                draft.lamp(place_m, flux_lm);
            }
        }
    }
}

/// Adds a rack: posts, boards and pallets with goods.
fn rack(draft: &mut Draft, dice: &mut Dice, corner_m: DVec3, bays: usize, levels: usize, size_m: DVec3) {
    let mut block = |material: &str, low: DVec3, high: DVec3| {
        draft.block(material, (corner_m + low).to_array(), (corner_m + high).to_array());
    };
    for post in 0..=bays {
        let x = size_m.x * post as f64;
        for y in [0.0, size_m.y - 0.1] {
            block("steel", at(x, y, 0.0), at(x + 0.1, y + 0.1, size_m.z * levels as f64));
        }
    }
    for bay in 0..bays {
        let x = size_m.x * bay as f64 + 0.11;
        for level in 0..levels {
            let z = size_m.z * level as f64;
            if level > 0 {
                block("steel", at(x, 0.11, z - 0.08), at(x + size_m.x - 0.12, size_m.y - 0.11, z - 0.01));
            }
            let mut from_m = x + 0.05;
            while dice.chance(0.8) {
                let width_m = dice.between(0.5, 1.2);
                if from_m + width_m > x + size_m.x - 0.15 {
                    break;
                }
                let high = at(from_m + width_m, size_m.y - 0.15, z + dice.between(0.3, size_m.z - 0.3));
                block("goods", at(from_m, 0.15, z), high);
                from_m += width_m + 0.05;
            }
        }
    }
}
