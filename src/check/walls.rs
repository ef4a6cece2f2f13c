//! The walls around an observer, from which the tabular method takes the background luminance of a glare rating.

use glam::DVec3;

use super::shells::{Shell, size_m};
use crate::base::quadrature::GOLDEN;
use crate::scene::{Background, GlareObserver, Quantity, ReceiverPoint, Scene};

/// Number of points that represent the walls. The mean over this many evenly spread points is within 1% of the mean over the whole walls
/// (0.03 in the rating).
const POINTS: u32 = 64;
/// Sine of the largest angle, 10°, by which a wall leans from the vertical.
const LEAN: f64 = 0.17365;
/// A closed room, whose fronts face inward, lies around an eye if its winding number there is below minus this.
const WITHIN: f64 = 0.5;
/// The eye of a standard room lies in a wall and at the height of the floor. Therefore the room around it is determined this far ahead of
/// it and above it, as a fraction of the scene's size.
const AHEAD: f64 = 1e-5;
/// An eye this far behind the plane of a wall, as a fraction of the scene's size, still counts as in the plane.
const IN_PLANE: f64 = 1e-6;

/// Moves the points of glare ratings by the tabular method to the walls.
///
/// The walls are the upright faces that face the eye, between the height of the eye and that of the luminaires (the mean weighted by flux).
/// They belong to the smallest closed room around the eye, or else to the whole scene.
pub(super) fn place_backgrounds(scene: &mut Scene, shells: &[Shell]) {
    for set in 0..scene.receivers.len() {
        if scene.receivers[set].quantity != Quantity::Glare(Background::Tabular) {
            continue;
        }
        let observers = &scene.receivers[set].observers;
        let rooms: Vec<Option<usize>> = observers.iter().map(|observer| room_about(scene, shells, observer)).collect();
        let is_one_room = rooms.iter().all(|room| *room == rooms[0]);
        let points = match observers.first() {
            Some(observer) if is_one_room => points_on_walls(scene, rooms[0].map(|room| &shells[room]), observer),
            _ => Vec::new(),
        };
        let receivers = &mut scene.receivers[set];
        if points.is_empty() {
            receivers.quantity = Quantity::Glare(Background::Observer);
            let what = if is_one_room {
                "no wall between the heights of eye and luminaires"
            } else {
                "the observers are not all in one room"
            };
            let instead = "the background luminance is taken at the eye";
            scene.warnings.push(format!("{}: {what}; {instead}", receivers.name));
        } else {
            receivers.points = points;
        }
    }
}

/// Returns the smallest closed room around an observer, by its index in the list of shells.
fn room_about(scene: &Scene, shells: &[Shell], observer: &GlareObserver) -> Option<usize> {
    let ahead_m = observer.eye_m + AHEAD * size_m(scene) * (observer.view + DVec3::Z);
    let volume_m3 = |place: &usize| shells[*place].volume_m3.abs();
    (0..shells.len())
        .filter(|place| shells[*place].winding(ahead_m) < -WITHIN)
        .min_by(|one, other| volume_m3(one).total_cmp(&volume_m3(other)))
}

/// Returns points spread evenly over the walls, each with its normal.
fn points_on_walls(scene: &Scene, room: Option<&Shell>, observer: &GlareObserver) -> Vec<ReceiverPoint> {
    let eye_m = observer.eye_m;
    let Some(top_m) = luminaire_height_m(scene).filter(|height_m| *height_m > eye_m.z) else {
        return Vec::new();
    };
    let in_plane_m = IN_PLANE * size_m(scene);
    let mut pieces: Vec<([DVec3; 3], DVec3, f64)> = Vec::new();
    let mut add = |triangle: u32| {
        let corners_m = scene.corners_m(triangle);
        let two_sided = scene.surfaces[scene.triangle_surfaces[triangle as usize] as usize].two_sided;
        let front = scene.triangle_normal(triangle);
        let depth_m = front.dot(eye_m - corners_m[0]);
        let normal = if two_sided && depth_m < 0.0 { -front } else { front };
        if front.z.abs() > LEAN || (depth_m < -in_plane_m && !two_sided) {
            return;
        }
        let wall = between_heights(&corners_m, eye_m.z, top_m);
        for next in 2..wall.len() {
            let piece = [wall[0], wall[next - 1], wall[next]];
            let area_m2 = 0.5 * (piece[1] - piece[0]).cross(piece[2] - piece[0]).length();
            pieces.push((piece, normal, area_m2));
        }
    };
    match room {
        Some(shell) => shell.triangles.iter().copied().for_each(&mut add),
        None => (0..scene.triangles.len() as u32).for_each(&mut add),
    }
    spread(&pieces)
}

/// Spreads points so that equal areas have equal numbers of points, evenly in the order of the pieces.
fn spread(pieces: &[([DVec3; 3], DVec3, f64)]) -> Vec<ReceiverPoint> {
    let all_m2: f64 = pieces.iter().map(|piece| piece.2).sum();
    if all_m2 <= 0.0 {
        return Vec::new();
    }
    let mut rest = pieces.iter();
    let (mut piece, mut before_m2) = (rest.next(), 0.0);
    let mut points = Vec::new();
    for number in 0..POINTS {
        let at_m2 = all_m2 * (f64::from(number) + 0.5) / f64::from(POINTS);
        while let Some((_, _, area_m2)) = piece
            && before_m2 + area_m2 < at_m2
        {
            before_m2 += area_m2;
            piece = rest.next();
        }
        let Some(([a, b, c], normal, area_m2)) = piece else {
            break;
        };
        let along = ((at_m2 - before_m2) / area_m2).clamp(0.0, 1.0).sqrt();
        let across = (f64::from(number) * GOLDEN).fract();
        let position_m = *a + along * ((1.0 - across) * (*b - *a) + across * (*c - *a));
        points.push(ReceiverPoint { position_m, normal: *normal, weight: 1.0, inside: false });
    }
    points
}

/// Returns the part of a triangle between two heights: a convex polygon.
fn between_heights(corners_m: &[DVec3; 3], low_m: f64, high_m: f64) -> Vec<DVec3> {
    let above = |polygon: &[DVec3], height_of: &dyn Fn(DVec3) -> f64| {
        let mut kept = Vec::new();
        for (index, from) in polygon.iter().enumerate() {
            let to = polygon[(index + 1) % polygon.len()];
            let (h, g) = (height_of(*from), height_of(to));
            if h >= 0.0 {
                kept.push(*from);
            }
            if (h > 0.0 && g < 0.0) || (h < 0.0 && g > 0.0) {
                kept.push(from.lerp(to, h / (h - g)));
            }
        }
        kept
    };
    above(&above(corners_m, &|point| point.z - low_m), &|point| high_m - point.z)
}

/// Returns the mean height of the luminaires in m, weighted by flux; `None` without light.
fn luminaire_height_m(scene: &Scene) -> Option<f64> {
    let (mut sum, mut flux_lm) = (0.0, 0.0);
    for luminaire in &scene.luminaires {
        let emission = &luminaire.emission;
        let height_m = match emission.place_m() {
            Some(place_m) => place_m.z,
            None if emission.is_daylight() => continue,
            None => {
                let triangles =
                    emission.surfaces().iter().flat_map(|id| scene.surfaces[*id as usize].triangles.clone());
                let (mut moment, mut all_m2) = (0.0, 0.0);
                for triangle in triangles {
                    let area_m2 = scene.triangle_area_m2(triangle);
                    moment += area_m2 * scene.corners_m(triangle).iter().map(|corner| corner.z).sum::<f64>() / 3.0;
                    all_m2 += area_m2;
                }
                if all_m2 > 0.0 { moment / all_m2 } else { 0.0 }
            }
        };
        sum += luminaire.luminous_flux_lm * height_m;
        flux_lm += luminaire.luminous_flux_lm;
    }
    (flux_lm > 0.0).then(|| sum / flux_lm)
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::check::scene_from_json;

    fn room(more: &str, eye: &str) -> Scene {
        let text = format!(
            r#"{{ "version": 1, "materials": {{ "grey": {{ "type": "diffuse", "reflectance": 0.5 }} }},
              "geometry": [ {{ "name": "room", "type": "box", "min": [0,0,0], "max": [4,2,3], "facing": "inward", "material": "grey" }}{more} ],
              "luminaires": [ {{ "name": "lamp", "type": "point", "position": [2,1,2.8], "intensity_cd": 1 }} ],
              "receivers": [ {{ "name": "eye", "type": "ugr", "position": {eye}, "view_direction": [1,0,0], "background": "tabular" }} ] }}"#
        );
        scene_from_json(&text, None, Path::new(".")).unwrap_or_else(|error| panic!("{error}"))
    }

    /// 64 points stand on four walls in proportion to the walls' lengths, between eye and luminaire, and face the room. Another room beside
    /// it and a cupboard in it get no points.
    #[test]
    fn points_lie_on_the_walls_of_the_room() {
        let more = r#", { "name": "next", "type": "box", "min": [5,0,0], "max": [9,2,3], "facing": "inward", "material": "grey" },
            { "name": "cupboard", "type": "box", "min": [1,0.5,0], "max": [1.5,0.8,2], "material": "grey" }"#;
        for eye in ["[0.5, 1, 1.2]", "[0, 1, 1.2]"] {
            let scene = room(more, eye);
            let points = &scene.receivers[0].points;
            assert_eq!(points.len(), 64);
            for point in points {
                assert!((1.2..=2.8).contains(&point.position_m.z) && point.position_m.x <= 4.0, "{point:?}");
                let onwards = point.position_m + 0.01 * point.normal;
                assert!(onwards.x > 0.0 && onwards.x < 4.0 && onwards.y > 0.0 && onwards.y < 2.0, "{point:?}");
            }
            let short = points.iter().filter(|point| point.normal.x.abs() > 0.5).count();
            assert!((20..=23).contains(&short), "{short}");
            let mean_m = points.iter().map(|point| point.position_m.z).sum::<f64>() / 64.0;
            assert!((mean_m - 2.0).abs() < 0.02, "{mean_m}");
        }
    }

    #[test]
    fn without_walls_the_background_is_the_observers() {
        let scene = room("", "[0.5, 1, 2.9]");
        assert_eq!(scene.receivers[0].quantity, Quantity::Glare(Background::Observer));
        assert_eq!(scene.receivers[0].points.len(), 1);
        assert!(scene.warnings.iter().any(|warning| warning.contains("no wall between")));
    }
}
