//! Rooms of unusual shape: attics, vaults, meshes with faults.

use std::f64::consts::PI;

use glam::DVec3;

use super::dice::{Dice, rounded};
use super::draft::{Draft, Wall};
use super::furniture::{at, ceiling_panels, chair, desk, looking_down, patch, usual_paints};
use super::solid::Solid;

/// A prism along x as a room. Its cross-section is in y and z, counter-clockwise as seen from high x, with the paint of each side.
fn prism(length_m: f64, section_m: &[[f64; 2]], paints: &[&str]) -> Vec<Wall> {
    let count = section_m.len();
    let corner = |x: f64, index: usize| at(x, section_m[index % count][0], section_m[index % count][1]);
    let mut walls: Vec<Wall> = (0..count)
        .map(|side| Wall {
            material: paints[side].to_owned(),
            corners_m: vec![
                corner(0.0, side),
                corner(length_m, side),
                corner(length_m, side + 1),
                corner(0.0, side + 1),
            ],
        })
        .collect();
    let material = "walls".to_owned();
    walls.push(Wall { material: material.clone(), corners_m: (0..count).map(|index| corner(0.0, index)).collect() });
    walls.push(Wall { material, corners_m: (0..count).rev().map(|index| corner(length_m, index)).collect() });
    walls
}

/// Returns whether a point is inside a convex room, at least `margin_m` from its walls.
fn is_within(walls: &[Wall], place_m: DVec3, margin_m: f64) -> bool {
    walls.iter().all(|wall| (place_m - wall.corners_m[0]).dot(wall.normal()) >= margin_m)
}

/// An attic with hundreds of stray triangles.
pub fn attic(draft: &mut Draft, dice: &mut Dice) {
    usual_paints(draft, dice);
    for (name, low, high) in [("roof", 0.2, 0.8), ("scraps", 0.1, 0.8), ("wood", 0.2, 0.6)] {
        let reflectance = dice.between(low, high);
        draft.paint(name, reflectance);
    }
    let [length_m, width_m, knee_m] = [dice.between(5.0, 12.0), dice.between(4.0, 8.0), dice.between(0.9, 1.4)];
    let ridge_m = rounded(knee_m + dice.between(1.2, 2.5));
    let middle_m = rounded(width_m * dice.between(0.4, 0.6));
    let section_m = [[0.0, 0.0], [width_m, 0.0], [width_m, knee_m], [middle_m, ridge_m], [0.0, knee_m]];
    let walls = prism(length_m, &section_m, &["floor", "walls", "roof", "roof", "walls"]);
    draft.room_of_walls(walls.clone());
    let height_m = dice.between(0.5, 0.85);
    draft.grid("work plane", [0.0, 0.0, height_m], [length_m, width_m], [24, 16]);
    let beam_m = rounded(middle_m - 0.06);
    draft.block("wood", [0.0, beam_m, ridge_m - 0.4], [length_m, beam_m + 0.12, ridge_m - 0.25]);
    let sizes_m = [dice.between(0.03, 0.1), dice.between(0.15, 0.6)];
    let mut strays = dice.count(200, 900);
    while strays > 0 {
        let middle = at(dice.unit() * length_m, dice.unit() * width_m, dice.unit() * ridge_m);
        let size_m = dice.log_between(sizes_m[0], sizes_m[1]);
        let corners_m: Vec<DVec3> = (0..3).map(|_| middle + size_m * dice.direction()).collect();
        let area_m2 = (corners_m[1] - corners_m[0]).cross(corners_m[2] - corners_m[0]).length();
        let fits = corners_m.iter().all(|corner| is_within(&walls, *corner, 0.01));
        if fits && area_m2 > 1e-3 * size_m * size_m {
            draft.sheet("scraps", &corners_m, &[vec![0, 1, 2]]);
            strays -= 1;
        }
    }
    for _ in 0..dice.count(1, 3) {
        let flux_lm = dice.between(800.0, 4000.0);
        let place_m = at(dice.between(0.4, length_m - 0.4), middle_m, rounded(ridge_m - dice.between(0.5, 0.9)));
        draft.lamp(place_m, flux_lm);
    }
}

/// A barrel vault with columns, balls and a curved bench.
pub fn curved(draft: &mut Draft, dice: &mut Dice) {
    usual_paints(draft, dice);
    for (name, low, high) in
        [("vault", 0.4, 0.85), ("columns", 0.3, 0.8), ("wood", 0.2, 0.6), ("balls", 0.2, 0.9), ("panel", 0.5, 0.8)]
    {
        let reflectance = dice.between(low, high);
        draft.paint(name, reflectance);
    }
    let [length_m, width_m, spring_m] = [dice.between(5.0, 12.0), dice.between(4.0, 7.0), dice.between(1.6, 2.6)];
    let facets = dice.count(10, 48);
    let radius_m = 0.5 * width_m;
    let rise = dice.between(0.4, 1.0);
    let mut section_m = vec![[0.0, 0.0], [width_m, 0.0]];
    let mut paints = vec!["floor", "walls"];
    for facet in 0..=facets {
        let angle = PI * facet as f64 / facets as f64;
        section_m.push([radius_m + radius_m * angle.cos(), spring_m + rise * radius_m * angle.sin()]);
        paints.push(if facet < facets { "vault" } else { "walls" });
    }
    // The arc ends exactly above the origin; this removes its rounding error.
    section_m[facets + 2][0] = 0.0;
    let walls = prism(length_m, &section_m, &paints);
    draft.room_of_walls(walls.clone());
    let height_m = dice.between(0.3, 0.9);
    draft.grid("work plane", [0.0, 0.0, height_m], [length_m, width_m], [26, 15]);
    let sides = dice.count(12, 64);
    for index in 0..dice.count(1, 3) {
        for y in [0.25 * width_m, 0.75 * width_m] {
            let foot_m = at(length_m * (index as f64 + 0.5) / 3.0, y, 0.0).map(rounded);
            let column =
                Solid::Column { foot_m, radius_m: dice.between(0.1, 0.3), height_m: dice.between(1.0, 1.5), sides };
            draft.thing("columns", column);
        }
    }
    for index in 0..dice.count(2, 6) {
        let radius_m = dice.between(0.08, 0.35);
        let center_m = at(dice.between(0.5, length_m - 0.5), dice.between(0.5, width_m - 0.5), radius_m + 0.002);
        let reach_m = DVec3::splat(radius_m);
        // The bench is around the middle of the room.
        let from_middle_m = (center_m.x - 0.5 * length_m).hypot(center_m.y - 0.5 * width_m);
        if from_middle_m > 1.15 + radius_m && draft.is_clear(center_m - reach_m, center_m + reach_m) {
            draft.ball(&format!("ball {index}"), "balls", center_m, radius_m);
        }
    }
    // A gap under the bench lets some light through.
    bench(draft, dice, at(rounded(0.5 * length_m), rounded(0.5 * width_m), 0.04));
    let count = dice.count(1, 4);
    for lamp in 0..count {
        let place_m = at(length_m * (lamp as f64 + 0.5) / count as f64, 0.5 * width_m, spring_m).map(rounded);
        let flux_lm = dice.between(800.0, 3000.0);
        if dice.chance(0.5) {
            draft.lamp(place_m, flux_lm);
        } else {
            draft.panel("panel", looking_down(place_m.x - 0.2, place_m.y - 0.2, spring_m, 0.4, 0.4), flux_lm / 0.16);
        }
    }
}

/// Adds a bench in the form of a quarter ring: a closed curved mesh.
fn bench(draft: &mut Draft, dice: &mut Dice, middle_m: DVec3) {
    let segments = dice.count(8, 40);
    let [inner_m, outer_m, height_m] = [dice.between(0.5, 0.7), dice.between(0.8, 1.1), dice.between(0.3, 0.5)];
    let mut corners_m = Vec::new();
    for index in 0..=segments {
        let angle = 0.5 * PI * index as f64 / segments as f64;
        for (radius_m, z) in [(inner_m, 0.0), (outer_m, 0.0), (outer_m, height_m), (inner_m, height_m)] {
            corners_m.push(middle_m + at(radius_m * angle.cos(), radius_m * angle.sin(), z));
        }
    }
    let mut faces = vec![vec![0, 1, 2, 3]];
    for segment in 0..segments {
        for side in 0..4 {
            let (a, b) = (4 * segment + side, 4 * segment + (side + 1) % 4);
            faces.push(vec![b, a, a + 4, b + 4]);
        }
    }
    faces.push((0..4).rev().map(|side| 4 * segments + side).collect());
    draft.mesh("wood", &corners_m, &faces);
}

/// A room whose mesh has typical faults of exported models. All its faces reflect on both sides.
pub fn faulty_input(draft: &mut Draft, dice: &mut Dice) {
    usual_paints(draft, dice);
    for (name, low, high) in [("wood", 0.2, 0.6), ("steel", 0.2, 0.6), ("fins", 0.2, 0.7), ("panel", 0.5, 0.8)] {
        let reflectance = dice.between(low, high);
        draft.paint(name, reflectance);
    }
    let size_m = at(dice.between(4.0, 8.0), dice.between(3.5, 7.0), dice.between(2.4, 3.4));
    // A grid of quads. Some are divided along one edge only, which makes T-junctions. Some face the wrong way, and some are
    // duplicated.
    let faults = dice.between(0.1, 0.4);
    let room = [
        ("floor", at(0.0, 0.0, 0.0), at(size_m.x, 0.0, 0.0), at(0.0, size_m.y, 0.0)),
        ("ceiling", at(0.0, 0.0, size_m.z), at(0.0, size_m.y, 0.0), at(size_m.x, 0.0, 0.0)),
        ("walls", at(0.0, 0.0, 0.0), at(0.0, 0.0, size_m.z), at(size_m.x, 0.0, 0.0)),
        ("walls", at(0.0, size_m.y, 0.0), at(size_m.x, 0.0, 0.0), at(0.0, 0.0, size_m.z)),
        ("walls", at(0.0, 0.0, 0.0), at(0.0, size_m.y, 0.0), at(0.0, 0.0, size_m.z)),
        ("walls", at(size_m.x, 0.0, 0.0), at(0.0, 0.0, size_m.z), at(0.0, size_m.y, 0.0)),
    ];
    for (material, origin_m, u_m, v_m) in room {
        faulty_wall(draft, dice, material, origin_m, u_m, v_m, faults);
        let corners_m = vec![origin_m, origin_m + u_m, origin_m + u_m + v_m, origin_m + v_m];
        draft.walls.push(Wall { material: material.to_owned(), corners_m });
    }
    let height_m = dice.between(0.5, 0.9);
    draft.grid("work plane", [0.0, 0.0, height_m], [size_m.x, size_m.y], [22, 18]);
    // Three or more sheets that meet in one edge.
    for _ in 0..dice.count(2, 5) {
        let foot_m = at(dice.between(0.6, size_m.x - 0.6), dice.between(0.6, size_m.y - 0.6), 0.0);
        let top_m = foot_m + at(0.0, 0.0, dice.between(0.4, 1.8));
        let mut corners_m = vec![foot_m, top_m];
        let mut faces = Vec::new();
        for _ in 0..dice.count(3, 5) {
            let direction = dice.direction();
            let away_m = dice.between(0.2, 0.5) * at(direction.x, direction.y, 0.0).normalize_or(DVec3::X);
            let first = corners_m.len();
            corners_m.extend([foot_m + away_m, top_m + away_m]);
            faces.push(vec![0, 1, first + 1, first]);
        }
        draft.sheet("fins", &corners_m, &faces);
    }
    // Needles, and furniture whose parts overlap.
    let needle_m = at(0.2, rounded(0.5 * size_m.y), 1.1);
    for index in 0..12 {
        let up_m = at(0.0, 0.0, 0.002 + 1e-4 * index as f64);
        let start_m = needle_m + at(0.0, 0.0, 0.05 * index as f64);
        draft.sheet("steel", &[start_m, start_m + at(2.0, 0.3, 0.0), start_m + up_m], &[vec![0, 1, 2]]);
    }
    let corner_m = at(rounded(0.5 * size_m.x), 0.3, 0.0);
    desk(draft, dice, corner_m, false);
    chair(draft, dice, corner_m + at(0.4, 0.5, 0.0), false);
    draft.block("wood", [size_m.x - 1.2, size_m.y - 1.0, 0.0], [size_m.x - 0.4, size_m.y - 0.4, 1.0]);
    draft.block("wood", [size_m.x - 0.9, size_m.y - 0.8, 0.5], [size_m.x - 0.1, size_m.y - 0.2, 1.4]);
    let back_m = at(rounded(size_m.x - 1.2), size_m.y, 0.0);
    draft.region("behind the blocks", patch(back_m, at(1.1, 0.0, 0.0), at(0.0, 0.0, 1.4)));
    if dice.chance(0.5) {
        ceiling_panels(draft, dice, size_m, [2, 2], 400.0);
    } else {
        for x in [0.3, 0.7] {
            let flux_lm = dice.between(800.0, 3000.0);
            draft.lamp(at(x * size_m.x, 0.4 * size_m.y, size_m.z - 0.3).map(rounded), flux_lm);
        }
    }
}

/// Adds a wall of quads with the given share of faults.
fn faulty_wall(
    draft: &mut Draft,
    dice: &mut Dice,
    material: &str,
    origin_m: DVec3,
    u_m: DVec3,
    v_m: DVec3,
    share: f64,
) {
    let [columns, rows] = [dice.count(2, 6), dice.count(2, 5)];
    let inward = u_m.cross(v_m);
    let place = |column: f64, row: f64| origin_m + column / columns as f64 * u_m + row / rows as f64 * v_m;
    for column in 0..columns {
        for row in 0..rows {
            let (c, r) = (column as f64, row as f64);
            let quad = [place(c, r), place(c + 1.0, r), place(c + 1.0, r + 1.0), place(c, r + 1.0)];
            let faces = |order: [usize; 4]| {
                let [a, b, d, e] = order;
                vec![vec![a, b, d], vec![a, d, e]]
            };
            if dice.chance(share) {
                // The middle of one edge is a corner here but not in the neighbour.
                let middle = place(c + 0.5, r);
                let corners_m = [quad[0], middle, quad[1], quad[2], quad[3]];
                draft.skin(material, inward, &corners_m, &[vec![0, 1, 4], vec![1, 3, 4], vec![1, 2, 3]]);
            } else if dice.chance(share) {
                draft.skin(material, inward, &quad, &faces([3, 2, 1, 0]));
            } else {
                draft.skin(material, inward, &quad, &faces([0, 1, 2, 3]));
                if dice.chance(share) {
                    // The same quad again, and a coplanar piece over a part of it.
                    draft.skin(material, inward, &quad, &faces([1, 2, 3, 0]));
                    let piece = [
                        place(c + 0.2, r + 0.2),
                        place(c + 0.7, r + 0.3),
                        place(c + 0.4, r + 0.8),
                        place(c + 0.2, r + 0.6),
                    ];
                    draft.skin(material, inward, &piece, &faces([0, 1, 2, 3]));
                }
            }
        }
    }
}
