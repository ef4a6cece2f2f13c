//! Rooms of a scene: closed pieces of surface that face inward. No light gets from one to another, so nothing is shared between them.

use glam::DVec3;

use crate::scene::Scene;

/// Largest number of rooms that are told apart. The others count as one with what lies in no room.
const MOST_ROOMS: usize = u8::MAX as usize;
/// A piece is closed if its triangles, as vectors of their areas, add up to less than this share of its area.
const CLOSED: f64 = 1e-9;

/// A piece of surface whose triangles are connected by vertices.
#[derive(Clone)]
struct ConnectedPiece {
    /// Sum of the triangles' normals times their areas, in m².
    area_vector_m2: DVec3,
    area_m2: f64,
    /// Signed volume in m³ about its first corner; negative if it faces inward.
    volume_m3: f64,
    first_m: DVec3,
    low_m: DVec3,
    high_m: DVec3,
}

impl ConnectedPiece {
    fn from(first_m: DVec3) -> ConnectedPiece {
        ConnectedPiece {
            area_vector_m2: DVec3::ZERO,
            area_m2: 0.0,
            volume_m3: 0.0,
            first_m,
            low_m: DVec3::INFINITY,
            high_m: DVec3::NEG_INFINITY,
        }
    }

    fn add(&mut self, corners_m: [DVec3; 3]) {
        let [a, b, c] = corners_m.map(|corner| corner - self.first_m);
        let vector_m2 = 0.5 * (b - a).cross(c - a);
        self.area_vector_m2 += vector_m2;
        self.area_m2 += vector_m2.length();
        self.volume_m3 += a.dot(b.cross(c)) / 6.0;
        for corner in corners_m {
            (self.low_m, self.high_m) = (self.low_m.min(corner), self.high_m.max(corner));
        }
    }

    fn is_room(&self) -> bool {
        self.volume_m3 < 0.0 && self.area_vector_m2.length() < CLOSED * self.area_m2
    }

    fn holds(&self, point_m: DVec3) -> bool {
        point_m.cmpge(self.low_m).all() && point_m.cmple(self.high_m).all()
    }
}

/// Number of the room of each triangle, from 1: the room that it encloses, or the smallest one whose bounding box contains the middle of
/// its piece. 0 if there is none. `None` if the scene has fewer than two rooms.
pub(super) fn rooms_of_triangles(scene: &Scene) -> Option<Vec<u8>> {
    let (pieces, piece_of) = connected_pieces(scene);
    let mut rooms: Vec<&ConnectedPiece> = pieces.iter().filter(|piece| piece.is_room()).collect();
    rooms.truncate(MOST_ROOMS);
    if rooms.len() < 2 {
        return None;
    }
    let room_of = |piece: &ConnectedPiece| {
        if let Some(own) = rooms.iter().position(|room| std::ptr::eq(*room, piece)) {
            return own as u8 + 1;
        }
        let middle_m = 0.5 * (piece.low_m + piece.high_m);
        let around = rooms.iter().enumerate().filter(|(_, room)| room.holds(middle_m));
        let smallest = around.min_by(|(_, one), (_, other)| other.volume_m3.total_cmp(&one.volume_m3));
        smallest.map_or(0, |(number, _)| number as u8 + 1)
    };
    let numbers: Vec<u8> = pieces.iter().map(room_of).collect();
    Some(piece_of.into_iter().map(|piece| numbers[piece as usize]).collect())
}

/// The pieces of a scene's surface in the order of their first triangles, and the number of the piece of each triangle.
fn connected_pieces(scene: &Scene) -> (Vec<ConnectedPiece>, Vec<u32>) {
    let mut leads_to: Vec<u32> = (0..scene.vertices_m.len() as u32).collect();
    for [a, b, c] in &scene.triangles {
        let root = end(&mut leads_to, *a);
        for vertex in [*b, *c] {
            let other = end(&mut leads_to, vertex);
            leads_to[other as usize] = root;
        }
    }
    let mut pieces: Vec<ConnectedPiece> = Vec::new();
    // The piece of each vertex at the end of a path, once known.
    let mut numbers = vec![None; scene.vertices_m.len()];
    let piece_of = (0..scene.triangles.len() as u32).map(|triangle| {
        let corners_m = scene.corners_m(triangle);
        let root = end(&mut leads_to, scene.triangles[triangle as usize][0]);
        let number = *numbers[root as usize].get_or_insert(pieces.len() as u32);
        if number as usize == pieces.len() {
            pieces.push(ConnectedPiece::from(corners_m[0]));
        }
        pieces[number as usize].add(corners_m);
        number
    });
    let piece_of = piece_of.collect();
    (pieces, piece_of)
}

/// The vertex at the end of a path, which is halved on the way.
fn end(leads_to: &mut [u32], mut vertex: u32) -> u32 {
    while leads_to[vertex as usize] != vertex {
        let next = leads_to[vertex as usize];
        leads_to[vertex as usize] = leads_to[next as usize];
        vertex = next;
    }
    vertex
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
