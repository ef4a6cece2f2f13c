//! Rooms in which the luminaires make the light difficult to compute.

use glam::DVec3;

use super::dice::{Dice, rounded};
use super::draft::Draft;
use super::furniture::{at, box_room, cupboards, desks, looking_down, patch, usual_paints, work_plane};

fn furniture_paints(draft: &mut Draft, dice: &mut Dice) {
    for (name, low, high) in [("wood", 0.15, 0.6), ("steel", 0.15, 0.6), ("panel", 0.4, 0.8)] {
        let reflectance = dice.between(low, high);
        draft.paint(name, reflectance);
    }
}

/// A single spotlight: nearly all light comes from its bright spot.
pub fn one_spotlight(draft: &mut Draft, dice: &mut Dice) {
    usual_paints(draft, dice);
    furniture_paints(draft, dice);
    let size_m = box_room(draft, dice, [4.0, 9.0], [4.0, 8.0], [2.5, 4.0]);
    work_plane(draft, dice, size_m);
    cupboards(draft, dice, size_m);
    let share = dice.between(0.2, 0.7);
    desks(draft, dice, [0.3, 0.1], [size_m.x - 0.1, size_m.y - 0.7], share);
    let place_m = at(
        rounded(size_m.x * dice.between(0.3, 0.7)),
        rounded(size_m.y * dice.between(0.3, 0.7)),
        rounded(size_m.z - dice.between(0.35, 0.6)),
    );
    if dice.chance(0.5) {
        let file = ("spotlight.ies", include_str!("../../../../scenes/luminaires/spotlight.ies"));
        let mut aim = dice.direction().map(rounded);
        aim.z = -aim.z.abs() - 0.3;
        draft.photometric(file, place_m, aim, 1.0);
        return;
    }
    // A point source deep in a dark tube.
    draft.paint("tube", 0.04);
    let [half_m, long_m] = [dice.between(0.03, 0.07), dice.between(0.15, 0.35)];
    let side_m = 2.0 * half_m;
    let corner_m = place_m + at(-half_m, -half_m, -long_m);
    let up_m = at(0.0, 0.0, long_m + 0.03);
    let sides = [
        patch(corner_m, at(side_m, 0.0, 0.0), up_m),
        patch(corner_m + at(0.0, side_m, 0.0), at(side_m, 0.0, 0.0), up_m),
        patch(corner_m, at(0.0, side_m, 0.0), up_m),
        patch(corner_m + at(side_m, 0.0, 0.0), at(0.0, side_m, 0.0), up_m),
        patch(corner_m + up_m, at(side_m, 0.0, 0.0), at(0.0, side_m, 0.0)),
    ];
    for (index, side) in sides.into_iter().enumerate() {
        draft.plate(&format!("tube {index}"), "tube", side);
    }
    let flux_lm = dice.between(2000.0, 9000.0);
    draft.spot(place_m, DVec3::NEG_Z, flux_lm);
}

/// Many dim lamps and a very bright one, hidden by a partition from a part of the room.
pub fn dim_and_bright(draft: &mut Draft, dice: &mut Dice) {
    usual_paints(draft, dice);
    furniture_paints(draft, dice);
    let size_m = box_room(draft, dice, [6.0, 14.0], [5.0, 10.0], [2.5, 4.0]);
    work_plane(draft, dice, size_m);
    let wall_m = rounded(size_m.x * dice.between(0.3, 0.5));
    let [to_m, high_m] = [rounded(size_m.y * dice.between(0.7, 0.95)), rounded(size_m.z * dice.between(0.75, 1.0))];
    draft.block("walls", [wall_m, 0.0, 0.0], [wall_m + 0.12, to_m, high_m]);
    draft.region("behind the partition", patch(at(wall_m + 0.12, 0.0, 0.0), at(0.0, to_m, 0.0), at(0.0, 0.0, high_m)));
    let share = dice.between(0.3, 0.9);
    desks(draft, dice, [wall_m + 0.3, 0.1], [size_m.x - 0.1, size_m.y - 0.2], share);
    let bright_lm = dice.log_between(3e4, 3e5);
    let bright_m = at(dice.between(0.4, wall_m - 0.4), dice.between(0.4, size_m.y - 0.6), rounded(size_m.z - 0.4));
    draft.lamp(bright_m, rounded(bright_lm));
    for lamp in 0..dice.count(30, 140) {
        let place_m = at(
            dice.between(0.15, size_m.x - 0.15),
            dice.between(0.15, size_m.y - 0.15),
            dice.between(1.4, size_m.z - 0.08),
        );
        let flux_lm = rounded(dice.log_between(0.3, 500.0));
        if draft.is_inside(place_m) {
            continue;
        }
        if lamp % 4 == 0 && lamp < 120 {
            draft.spot(place_m, DVec3::NEG_Z, flux_lm);
        } else {
            draft.lamp(place_m, flux_lm);
        }
    }
    let panel = looking_down(rounded(size_m.x - 1.2), 0.4, size_m.z - 0.05, 0.6, 0.3);
    draft.panel("panel", panel, dice.between(5.0, 2000.0));
}
