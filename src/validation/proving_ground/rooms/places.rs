//! Positions of receivers: on all kinds of surfaces, in corners, and in the regions that a room defines.

use std::f64::consts::PI;
use std::fmt::Write as _;

use glam::DVec3;
use serde_json::json;

use super::dice::Dice;
use super::draft::{Draft, Face, Patch, RoomFile, Wall};
use super::solid::Solid;

/// Number of receivers on each kind of surface, and number of further receivers distributed by area.
const ON_EACH_KIND: usize = 12;
const BY_AREA: usize = 320;
/// Number of receivers in corners, and in each region.
const IN_CORNERS: usize = 100;
const IN_REGION: usize = 80;
/// Range of distances in m from the edge for receivers in corners.
const FROM_EDGE_M: [f64; 2] = [0.003, 0.15];
/// Two walls form a corner if the cosine of the angle between their normals is below this.
const CORNER_COSINE: f64 = 0.8;
/// A receiver with a solid this near in front of it, in m, is hidden by contact. The light between a box and the floor below it is
/// not of interest.
const CONTACT_M: f64 = 1e-3;
/// Maximum number of positions tried per receiver.
const TRIES: usize = 30;

/// Position, normal and area of a receiver.
#[derive(Clone, Copy, Debug)]
struct ReceiverPlace {
    position_m: DVec3,
    normal: DVec3,
    area_m2: f64,
}

/// Adds the receiver sets "surfaces", "corners" and one for each region of the draft.
pub fn add_points(draft: &mut Draft, dice: &mut Dice) {
    let surfaces = on_surfaces(draft, dice);
    add_set(draft, "surfaces", &surfaces);
    let corners = in_corners(draft, dice);
    add_set(draft, "corners", &corners);
    let mut names: Vec<String> = Vec::new();
    for (name, _) in &draft.regions {
        if !names.contains(name) {
            names.push(name.clone());
        }
    }
    for name in names {
        let places = in_region(draft, dice, &name);
        add_set(draft, &name, &places);
    }
}

fn add_set(draft: &mut Draft, name: &str, places: &[ReceiverPlace]) {
    if places.is_empty() {
        return;
    }
    let file = format!("{}.csv", name.replace(' ', "-"));
    let mut text = String::from("x,y,z,nx,ny,nz,area\n");
    for ReceiverPlace { position_m: p, normal: n, area_m2 } in places {
        // Writing to a string cannot fail.
        writeln!(text, "{},{},{},{},{},{},{area_m2}", p.x, p.y, p.z, n.x, n.y, n.z).ok();
    }
    draft.receivers.push(json!({ "name": name, "type": "points", "file": file }));
    draft.files.push(RoomFile { name: file, text });
}

/// Returns up to `count` positions from `make` that are not hidden by contact. Each represents an equal share of the visible area.
fn uncovered(
    draft: &Draft,
    dice: &mut Dice,
    count: usize,
    area_m2: f64,
    mut make: impl FnMut(&mut Dice) -> (DVec3, DVec3),
) -> Vec<ReceiverPlace> {
    let mut places = Vec::with_capacity(count);
    let mut tried = 0;
    while places.len() < count && tried < TRIES * count {
        tried += 1;
        let (position_m, normal) = make(dice);
        if draft.is_in_the_air(position_m + CONTACT_M * normal) {
            places.push(ReceiverPlace { position_m, normal, area_m2 });
        }
    }
    places.iter_mut().for_each(|place| place.area_m2 = area_m2 / tried as f64);
    places
}

fn area_and_normal(face: &Face) -> (f64, DVec3) {
    let [a, b, c] = face.corners_m;
    let cross_m2 = (b - a).cross(c - a);
    (0.5 * cross_m2.length(), cross_m2.normalize_or_zero())
}

fn on_triangle(dice: &mut Dice, corners_m: [DVec3; 3]) -> DVec3 {
    let [a, b, c] = corners_m;
    let root = dice.unit().sqrt();
    let share = dice.unit();
    a + (root * (1.0 - share)) * (b - a) + (root * share) * (c - a)
}

fn on_surfaces(draft: &Draft, dice: &mut Dice) -> Vec<ReceiverPlace> {
    let areas_m2: Vec<f64> = draft.faces.iter().map(|face| area_and_normal(face).0).collect();
    let balls: Vec<(DVec3, f64)> = draft
        .solids
        .iter()
        .filter_map(|solid| match solid {
            Solid::Ball { center_m, radius_m } => Some((*center_m, *radius_m)),
            _ => None,
        })
        .collect();
    let balls_m2: f64 = balls.iter().map(|(_, radius_m)| 4.0 * PI * radius_m * radius_m).sum();
    let all_m2 = areas_m2.iter().sum::<f64>() + balls_m2;
    let count = |area_m2: f64| ON_EACH_KIND + (BY_AREA as f64 * area_m2 / all_m2) as usize;

    let mut places = Vec::new();
    for group in 0..draft.groups.len() {
        let faces: Vec<usize> = (0..draft.faces.len()).filter(|face| draft.faces[*face].group == group).collect();
        let mut upto_m2 = 0.0;
        let sums_m2: Vec<f64> = faces
            .iter()
            .map(|face| {
                upto_m2 += areas_m2[*face];
                upto_m2
            })
            .collect();
        places.extend(uncovered(draft, dice, count(upto_m2), upto_m2, |dice| {
            let chosen_m2 = upto_m2 * dice.unit();
            let index = sums_m2.partition_point(|sum_m2| *sum_m2 <= chosen_m2).min(faces.len() - 1);
            let face = &draft.faces[faces[index]];
            (on_triangle(dice, face.corners_m), area_and_normal(face).1)
        }));
    }
    if !balls.is_empty() {
        places.extend(uncovered(draft, dice, count(balls_m2), balls_m2, |dice| {
            let (center_m, radius_m) = *dice.one_of(&balls);
            let normal = dice.direction();
            (center_m + radius_m * normal, normal)
        }));
    }
    places
}

/// An edge of the shell where two walls meet, for receivers on one of the walls.
struct ShellEdge {
    ends_m: [DVec3; 2],
    /// Normal of that wall, and the direction on it away from the edge.
    normal: DVec3,
    away: DVec3,
}

fn edges(walls: &[Wall]) -> Vec<ShellEdge> {
    let mut edges = Vec::new();
    for (index, wall) in walls.iter().enumerate() {
        let corners_m = &wall.corners_m;
        for from in 0..corners_m.len() {
            let (a, b) = (corners_m[from], corners_m[(from + 1) % corners_m.len()]);
            let meets = |(other, neighbour): (usize, &Wall)| {
                let holds = |end_m: DVec3| neighbour.corners_m.iter().any(|corner| corner.distance(end_m) < CONTACT_M);
                other != index && holds(a) && holds(b) && wall.normal().dot(neighbour.normal()) < CORNER_COSINE
            };
            if walls.iter().enumerate().any(meets) {
                let normal = wall.normal();
                // The polygon is counter-clockwise: its inside is to the left of each edge.
                edges.push(ShellEdge { ends_m: [a, b], normal, away: normal.cross(b - a).normalize() });
            }
        }
    }
    edges
}

fn in_corners(draft: &Draft, dice: &mut Dice) -> Vec<ReceiverPlace> {
    let edges = edges(&draft.walls);
    if edges.is_empty() {
        return Vec::new();
    }
    let length_m: f64 = edges.iter().map(|edge| edge.ends_m[0].distance(edge.ends_m[1])).sum();
    uncovered(draft, dice, IN_CORNERS, length_m * FROM_EDGE_M[1], |dice| {
        let edge = dice.one_of(&edges);
        let [a, b] = edge.ends_m;
        let from_edge_m = dice.log_between(FROM_EDGE_M[0], FROM_EDGE_M[1]);
        // A third of the positions is also near an end of the edge, where three walls meet.
        let margin_m = from_edge_m.min(0.4 * a.distance(b));
        let along_m = match dice.count(0, 5) {
            0 => margin_m,
            1 => a.distance(b) - margin_m,
            _ => margin_m + (a.distance(b) - 2.0 * margin_m) * dice.unit(),
        };
        (a + along_m * (b - a).normalize() + from_edge_m * edge.away, edge.normal)
    })
}

fn in_region(draft: &Draft, dice: &mut Dice, name: &str) -> Vec<ReceiverPlace> {
    let patches: Vec<Patch> =
        draft.regions.iter().filter(|(region, _)| region == name).map(|(_, patch)| *patch).collect();
    let area_m2: f64 = patches.iter().map(|patch| patch.u_m.cross(patch.v_m).length()).sum();
    uncovered(draft, dice, IN_REGION, area_m2, |dice| {
        let Patch { origin_m, u_m, v_m } = dice.one_of(&patches);
        let [first, second] = [dice.unit(), dice.unit()];
        (*origin_m + first * *u_m + second * *v_m, u_m.cross(*v_m).normalize())
    })
}
