//! Objects used in many kinds of rooms.

use glam::DVec3;

use super::dice::{Dice, rounded};
use super::draft::{Draft, Patch};
use super::solid::Solid;

/// Name of the region of receivers under tables.
pub const UNDER_TABLES: &str = "under tables";
/// Name of the region of receivers behind shelves and cupboards.
pub const BEHIND_SHELVES: &str = "behind shelves";
/// Ratio of a room's longest side to the edges of elements on its walls.
const ELEMENTS_ALONG: f64 = 12.0;

/// A vector in m.
pub fn at(x: f64, y: f64, z: f64) -> DVec3 {
    DVec3::new(x, y, z)
}

/// A parallelogram rounded to whole millimetres.
pub fn patch(origin_m: DVec3, u_m: DVec3, v_m: DVec3) -> Patch {
    Patch { origin_m: origin_m.map(rounded), u_m: u_m.map(rounded), v_m: v_m.map(rounded) }
}

/// An upward-facing horizontal rectangle, from its lowest corner and its sides.
pub fn looking_up(x: f64, y: f64, z: f64, width_m: f64, depth_m: f64) -> Patch {
    patch(at(x, y, z), at(width_m, 0.0, 0.0), at(0.0, depth_m, 0.0))
}

/// A downward-facing horizontal rectangle, from its lowest corner and its sides.
pub fn looking_down(x: f64, y: f64, z: f64, width_m: f64, depth_m: f64) -> Patch {
    patch(at(x, y, z), at(0.0, depth_m, 0.0), at(width_m, 0.0, 0.0))
}

/// Adds the paints of floor, ceiling and walls with random reflectances in these ranges.
pub fn paints(draft: &mut Draft, dice: &mut Dice, floor: [f64; 2], ceiling: [f64; 2], walls: [f64; 2]) {
    for (name, [low, high]) in [("floor", floor), ("ceiling", ceiling), ("walls", walls)] {
        let reflectance = dice.between(low, high);
        draft.paint(name, reflectance);
    }
}

/// Adds paints as in most rooms.
pub fn usual_paints(draft: &mut Draft, dice: &mut Dice) {
    paints(draft, dice, [0.1, 0.4], [0.5, 0.85], [0.3, 0.75]);
}

/// Adds an empty box room from the origin; returns its size in m.
pub fn box_room(draft: &mut Draft, dice: &mut Dice, x: [f64; 2], y: [f64; 2], z: [f64; 2]) -> DVec3 {
    let size_m = at(dice.between(x[0], x[1]), dice.between(y[0], y[1]), dice.between(z[0], z[1]));
    draft.room(DVec3::ZERO, size_m, rounded(size_m.max_element() / ELEMENTS_ALONG));
    size_m
}

/// Adds the grid "work plane" over a box room, with about 400 points and nearly square cells.
pub fn work_plane(draft: &mut Draft, dice: &mut Dice, size_m: DVec3) {
    let height_m = dice.between(0.76, 0.9);
    let columns = ((400.0 * size_m.x / size_m.y).sqrt().round() as usize).clamp(4, 130);
    draft.grid("work plane", [0.0, 0.0, height_m], [size_m.x, size_m.y], [columns, (400 / columns).max(3)]);
}

/// Adds a block relative to a corner of the floor plan. If it is turned, x and y of sizes and offsets are exchanged.
fn part(draft: &mut Draft, material: &str, corner_m: DVec3, is_turned: bool, low: [f64; 3], high: [f64; 3]) {
    let place = |[x, y, z]: [f64; 3]| corner_m + if is_turned { at(y, x, z) } else { at(x, y, z) };
    draft.thing(material, Solid::block(place(low), place(high)));
}

/// Adds a desk on four legs at a corner of the floor plan, with the region under it. Needs "wood" and "steel".
pub fn desk(draft: &mut Draft, dice: &mut Dice, corner_m: DVec3, is_turned: bool) {
    let [width_m, depth_m, height_m] = [dice.between(1.1, 1.6), dice.between(0.6, 0.8), dice.between(0.68, 0.75)];
    let leg_m = dice.between(0.03, 0.07);
    let (board, end) = (rounded(height_m - 0.03), [rounded(width_m - leg_m), rounded(depth_m - leg_m)]);
    part(draft, "wood", corner_m, is_turned, [0.0, 0.0, board], [width_m, depth_m, height_m]);
    for x in [0.0, end[0]] {
        for y in [0.0, end[1]] {
            part(draft, "steel", corner_m, is_turned, [x, y, 0.0], [x + leg_m, y + leg_m, board]);
        }
    }
    if dice.chance(0.6) {
        let [x, y] = [rounded(0.3 * width_m), rounded(0.6 * depth_m)];
        part(draft, "steel", corner_m, is_turned, [x, y, height_m], [x + 0.5, y + 0.04, height_m + 0.42]);
    }
    let [x_m, y_m] = if is_turned { [depth_m, width_m] } else { [width_m, depth_m] };
    draft.region(UNDER_TABLES, looking_up(corner_m.x, corner_m.y, corner_m.z, x_m, y_m));
    draft.region(UNDER_TABLES, looking_down(corner_m.x, corner_m.y, corner_m.z + board, x_m, y_m));
}

/// Adds a chair about half a metre square at a corner of the floor plan. Needs "wood" and "steel".
pub fn chair(draft: &mut Draft, dice: &mut Dice, corner_m: DVec3, is_turned: bool) {
    let [seat_m, back_m] = [dice.between(0.4, 0.48), dice.between(0.8, 1.05)];
    part(draft, "wood", corner_m, is_turned, [0.0, 0.0, seat_m - 0.03], [0.44, 0.44, seat_m]);
    part(draft, "wood", corner_m, is_turned, [0.0, 0.0, seat_m], [0.44, 0.03, back_m]);
    for x in [0.01, 0.4] {
        for y in [0.01, 0.4] {
            part(draft, "steel", corner_m, is_turned, [x, y, 0.0], [x + 0.03, y + 0.03, seat_m - 0.03]);
        }
    }
}

/// Adds desks with chairs over a rectangle of the floor plan.
pub fn desks(draft: &mut Draft, dice: &mut Dice, low_m: [f64; 2], high_m: [f64; 2], share: f64) {
    const CELL_M: f64 = 2.0;
    let counts = [0, 1].map(|axis| ((high_m[axis] - low_m[axis]) / CELL_M) as usize);
    for column in 0..counts[0] {
        for row in 0..counts[1] {
            let corner_m = at(
                low_m[0] + CELL_M * column as f64 + dice.between(0.0, 0.2),
                low_m[1] + CELL_M * row as f64 + dice.between(0.0, 0.2),
                0.0,
            );
            if (column + row > 0 && !dice.chance(share))
                || !draft.is_clear(corner_m, corner_m + at(CELL_M, CELL_M, 1.2))
            {
                continue;
            }
            // The desk's board is up to 0.8 m deep, and the chair stands partly under it.
            let is_turned = dice.chance(0.4);
            let aside_m = dice.between(0.1, 0.5);
            let to_chair_m = if is_turned { at(0.0, aside_m, 0.0) } else { at(aside_m, 0.0, 0.0) };
            let to_desk_m = if is_turned { at(0.5, 0.0, 0.0) } else { at(0.0, 0.5, 0.0) };
            chair(draft, dice, corner_m + to_chair_m, is_turned);
            desk(draft, dice, corner_m + to_desk_m, is_turned);
        }
    }
}

/// Adds cupboards along the wall of highest y. The gap behind them is a region of receivers. Needs "wood".
pub fn cupboards(draft: &mut Draft, dice: &mut Dice, size_m: DVec3) {
    let mut x = dice.between(0.05, 0.5);
    loop {
        let [width_m, height_m, depth_m] = [dice.between(0.6, 1.4), dice.between(1.0, 2.1), dice.between(0.3, 0.5)];
        if x + width_m > size_m.x - 0.05 {
            return;
        }
        let gap_m = dice.between(0.015, 0.08);
        let back_m = rounded(size_m.y - gap_m);
        draft.block("wood", [x, back_m - depth_m, 0.0], [x + width_m, back_m, height_m]);
        draft.region(BEHIND_SHELVES, patch(at(x, size_m.y, 0.0), at(width_m, 0.0, 0.0), at(0.0, 0.0, height_m)));
        x = rounded(x + width_m + dice.between(0.02, 1.5));
    }
}

/// Adds an open shelf along x with goods on its boards. Receivers are at the back of its bays. Needs "wood" and "goods".
pub fn shelf(draft: &mut Draft, dice: &mut Dice, corner_m: DVec3, size_m: DVec3, is_turned: bool) {
    const BOARD_M: f64 = 0.02;
    let bays = ((size_m.x / 0.9).round() as usize).max(1);
    let levels = ((size_m.z / 0.38).round() as usize).max(2);
    let level_m = size_m.z / levels as f64;
    let post = |x: f64| ([x, 0.0, 0.0], [x + BOARD_M, size_m.y, size_m.z]);
    for bay in 0..=bays {
        let x = rounded((size_m.x - BOARD_M) * bay as f64 / bays as f64);
        let (low, high) = post(x);
        part(draft, "wood", corner_m, is_turned, low, high);
    }
    for bay in 0..bays {
        let first_m = rounded((size_m.x - BOARD_M) * bay as f64 / bays as f64) + BOARD_M;
        let last_m = rounded((size_m.x - BOARD_M) * (bay + 1) as f64 / bays as f64);
        for level in 0..levels {
            let z = rounded(0.06 + (level_m - 0.01) * level as f64);
            part(draft, "wood", corner_m, is_turned, [first_m, 0.0, z], [last_m, size_m.y, z + BOARD_M]);
            let mut x = first_m + dice.between(0.005, 0.05);
            while dice.chance(0.85) {
                let [width_m, depth_m, height_m] =
                    [dice.between(0.04, 0.35), size_m.y * dice.between(0.4, 0.95), level_m * dice.between(0.3, 0.8)];
                if x + width_m > last_m - 0.005 {
                    break;
                }
                let top_m = rounded(z + BOARD_M + height_m);
                let low = [x, 0.01, z + BOARD_M];
                part(draft, "goods", corner_m, is_turned, low, [x + width_m, rounded(0.01 + depth_m), top_m]);
                x = rounded(x + width_m + dice.between(0.004, 0.1));
            }
            // The back part of the board, behind the goods.
            let deep_m = at(first_m, rounded(0.7 * size_m.y), z + BOARD_M);
            let [x_m, y_m] = [last_m - first_m, 0.3 * size_m.y];
            let deep = if is_turned {
                looking_up(corner_m.x + deep_m.y, corner_m.y + deep_m.x, corner_m.z + deep_m.z, y_m, x_m)
            } else {
                looking_up(corner_m.x + deep_m.x, corner_m.y + deep_m.y, corner_m.z + deep_m.z, x_m, y_m)
            };
            draft.region(BEHIND_SHELVES, deep);
        }
    }
}

/// Adds evenly spaced panels below the ceiling that emit downwards, with `lm_per_m2` of floor area in total. Needs "panel".
pub fn ceiling_panels(draft: &mut Draft, dice: &mut Dice, size_m: DVec3, counts: [usize; 2], lm_per_m2: f64) {
    let [width_m, depth_m] = [dice.between(0.3, 1.2), dice.between(0.15, 0.6)];
    let drop_m = dice.between(0.02, 0.5);
    let count = counts[0] * counts[1];
    let exitance_lm_m2 = rounded(lm_per_m2 * size_m.x * size_m.y / (count as f64 * width_m * depth_m));
    for column in 0..counts[0] {
        for row in 0..counts[1] {
            let x = rounded(size_m.x * (column as f64 + 0.5) / counts[0] as f64 - 0.5 * width_m);
            let y = rounded(size_m.y * (row as f64 + 0.5) / counts[1] as f64 - 0.5 * depth_m);
            let z = rounded(size_m.z - drop_m);
            draft.panel("panel", looking_down(x.max(0.01), y.max(0.01), z, width_m, depth_m), exitance_lm_m2);
        }
    }
}

/// Numbers of columns and rows of luminaires, with about one luminaire per `m2_each` square metres.
pub fn lattice(dice: &mut Dice, size_m: DVec3, m2_each: [f64; 2]) -> [usize; 2] {
    let each_m2 = dice.between(m2_each[0], m2_each[1]);
    let count = (size_m.x * size_m.y / each_m2).max(1.0);
    let columns = ((count * size_m.x / size_m.y).sqrt().round() as usize).max(1);
    [columns, ((count / columns as f64).round() as usize).max(1)]
}
