//! A room while it is furnished: the contents of its scene file, and surfaces for receivers.

use std::fmt::Write as _;

use glam::DVec3;
use serde_json::{Value, json};

use super::solid::Solid;

/// Maintenance factor of all luminaires.
const MAINTENANCE_FACTOR: f64 = 0.8;

/// A file used by a scene.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RoomFile {
    /// Path relative to the scene file.
    pub name: String,
    /// Text of the file.
    pub text: String,
}

/// A triangle on which receivers may lie. Its corners are counter-clockwise as seen from the front.
#[derive(Clone, Copy, Debug)]
pub struct Face {
    /// Corners in m.
    pub corners_m: [DVec3; 3],
    /// Index of its kind of surface.
    pub group: usize,
}

/// A parallelogram on which a region of receivers lies. The receivers face along u × v.
#[derive(Clone, Copy, Debug)]
pub struct Patch {
    /// A corner in m.
    pub origin_m: DVec3,
    /// First side in m.
    pub u_m: DVec3,
    /// Second side in m.
    pub v_m: DVec3,
}

/// A flat convex polygon of a room's shell. Its front faces the room.
#[derive(Clone, Debug)]
pub struct Wall {
    /// Name of the material, which is also the kind of surface.
    pub material: String,
    /// Corners in m, counter-clockwise as seen from the room.
    pub corners_m: Vec<DVec3>,
}

impl Wall {
    /// Unit normal into the room.
    pub fn normal(&self) -> DVec3 {
        let [a, b, c] = [0, 1, 2].map(|corner| self.corners_m[corner]);
        (b - a).cross(c - a).normalize()
    }
}

/// Triangles of an OBJ file, part by part.
#[derive(Clone, Debug, Default)]
struct MeshText {
    text: String,
    vertices: usize,
    material: String,
}

impl MeshText {
    fn push(&mut self, material: &str, corners_m: &[DVec3], faces: &[Vec<usize>]) {
        // Writing to a string cannot fail.
        for corner in corners_m {
            writeln!(self.text, "v {} {} {}", corner.x, corner.y, corner.z).ok();
        }
        if self.material != material {
            writeln!(self.text, "usemtl {material}").ok();
            self.material = material.to_owned();
        }
        for face in faces {
            let numbers: Vec<String> = face.iter().map(|corner| (self.vertices + corner + 1).to_string()).collect();
            writeln!(self.text, "f {}", numbers.join(" ")).ok();
        }
        self.vertices += corners_m.len();
    }
}

/// A room that is being furnished.
#[derive(Clone, Debug, Default)]
pub struct Draft {
    pub(super) materials: serde_json::Map<String, Value>,
    geometry: Vec<Value>,
    luminaires: Vec<Value>,
    pub(super) receivers: Vec<Value>,
    pub(super) files: Vec<RoomFile>,
    /// Closed objects, one-sided.
    things: MeshText,
    /// Sheets, two-sided.
    sheets: MeshText,
    /// Shell of the room, if it is not a box.
    shell: MeshText,
    pub(super) walls: Vec<Wall>,
    pub(super) faces: Vec<Face>,
    pub(super) groups: Vec<String>,
    pub(super) solids: Vec<Solid>,
    /// Patches of regions: name of the region and patch.
    pub(super) regions: Vec<(String, Patch)>,
}

impl Draft {
    /// Adds a diffuse material.
    pub fn paint(&mut self, name: &str, reflectance: f64) {
        self.material(name, json!({ "type": "diffuse", "reflectance": reflectance }));
    }

    /// Adds any material in the format of the scene file.
    pub fn material(&mut self, name: &str, material: Value) {
        self.materials.insert(name.to_owned(), material);
    }

    /// Adds the room itself as a box. Floor, ceiling and walls have the materials of these names.
    pub fn room(&mut self, low_m: DVec3, high_m: DVec3, longest_edge_m: f64) {
        self.geometry.push(json!({
            "name": "room", "type": "box", "min": low_m.to_array(), "max": high_m.to_array(), "facing": "inward",
            "material": "walls", "materials": { "floor": "floor", "ceiling": "ceiling" },
            "max_element_edge": longest_edge_m,
        }));
        let at = |corner: usize| {
            let pick = |axis: usize| if corner >> axis & 1 == 1 { high_m[axis] } else { low_m[axis] };
            DVec3::new(pick(0), pick(1), pick(2))
        };
        let faces = [
            ("floor", [0, 1, 3, 2]),
            ("ceiling", [4, 6, 7, 5]),
            ("walls", [0, 2, 6, 4]),
            ("walls", [1, 5, 7, 3]),
            ("walls", [0, 4, 5, 1]),
            ("walls", [2, 3, 7, 6]),
        ];
        for (material, corners) in faces {
            let corners_m = corners.map(at).to_vec();
            self.notice_polygon(material, &corners_m);
            self.walls.push(Wall { material: material.to_owned(), corners_m });
        }
    }

    /// Adds the room itself as a mesh of convex polygons.
    pub fn room_of_walls(&mut self, walls: Vec<Wall>) {
        for wall in walls {
            let face = (0..wall.corners_m.len()).collect();
            self.shell.push(&wall.material, &wall.corners_m, &[face]);
            self.notice_polygon(&wall.material, &wall.corners_m);
            self.walls.push(wall);
        }
    }

    /// Adds a closed object, seen from outside.
    pub fn thing(&mut self, material: &str, solid: Solid) {
        let (corners_m, faces) = solid.surface();
        self.things.push(material, &corners_m, &faces);
        for face in faces {
            let polygon: Vec<DVec3> = face.into_iter().map(|corner| corners_m[corner]).collect();
            self.notice_polygon(material, &polygon);
        }
        self.solids.push(solid);
    }

    /// Adds a closed box along the axes.
    pub fn block(&mut self, material: &str, low_m: [f64; 3], high_m: [f64; 3]) {
        self.thing(material, Solid::block(DVec3::from(low_m), DVec3::from(high_m)));
    }

    /// Adds a closed mesh that is not a simple solid. Receivers may lie on it, but it is ignored in tests for hidden receivers.
    pub fn mesh(&mut self, material: &str, corners_m: &[DVec3], faces: &[Vec<usize>]) {
        self.things.push(material, corners_m, faces);
        self.notice_mesh(material, corners_m, faces);
    }

    /// Adds faces that reflect on both sides.
    pub fn sheet(&mut self, material: &str, corners_m: &[DVec3], faces: &[Vec<usize>]) {
        self.sheets.push(material, corners_m, faces);
        self.notice_mesh(material, corners_m, faces);
        let backs: Vec<Vec<usize>> = faces.iter().map(|face| face.iter().rev().copied().collect()).collect();
        self.notice_mesh(material, corners_m, &backs);
    }

    /// Adds faces of the room itself that reflect on both sides, in either orientation. Receivers lie on the side towards the room.
    pub fn skin(&mut self, material: &str, inward: DVec3, corners_m: &[DVec3], faces: &[Vec<usize>]) {
        self.sheets.push(material, corners_m, faces);
        for face in faces {
            let mut polygon: Vec<DVec3> = face.iter().map(|corner| corners_m[*corner]).collect();
            if (polygon[1] - polygon[0]).cross(polygon[2] - polygon[0]).dot(inward) < 0.0 {
                polygon.reverse();
            }
            self.notice_polygon(material, &polygon);
        }
    }

    /// Adds a rectangle that reflects on both sides. Its front faces along u × v.
    pub fn plate(&mut self, name: &str, material: &str, patch: Patch) {
        let Patch { origin_m, u_m, v_m } = patch;
        self.geometry.push(json!({
            "name": name, "type": "rectangle", "origin": origin_m.to_array(), "u": u_m.to_array(), "v": v_m.to_array(),
            "material": material, "two_sided": true,
        }));
        let corners_m = [origin_m, origin_m + u_m, origin_m + u_m + v_m, origin_m + v_m];
        self.notice_polygon(material, &corners_m);
        let back_m: Vec<DVec3> = corners_m.into_iter().rev().collect();
        self.notice_polygon(material, &back_m);
    }

    /// Adds a ball as a sphere of the scene file.
    pub fn ball(&mut self, name: &str, material: &str, center_m: DVec3, radius_m: f64) {
        self.geometry.push(json!({
            "name": name, "type": "sphere", "center": center_m.to_array(), "radius": radius_m, "material": material,
        }));
        self.solids.push(Solid::Ball { center_m, radius_m });
    }

    /// Adds a luminaire in the format of the scene file, without its name and maintenance factor.
    pub fn luminaire(&mut self, mut luminaire: Value) {
        luminaire["name"] = json!(format!("lamp {}", self.luminaires.len() + 1));
        luminaire["maintenance_factor"] = json!(MAINTENANCE_FACTOR);
        self.luminaires.push(luminaire);
    }

    /// Adds an isotropic point.
    pub fn lamp(&mut self, position_m: DVec3, luminous_flux_lm: f64) {
        self.luminaire(
            json!({ "type": "point", "position": position_m.to_array(), "luminous_flux_lm": luminous_flux_lm }),
        );
    }

    /// Adds a Lambertian point.
    pub fn spot(&mut self, position_m: DVec3, aim: DVec3, luminous_flux_lm: f64) {
        self.luminaire(json!({
            "type": "point", "distribution": "lambertian", "position": position_m.to_array(), "aim": aim.to_array(),
            "luminous_flux_lm": luminous_flux_lm,
        }));
    }

    /// Adds a rectangle that emits from its front and reflects on both sides.
    pub fn panel(&mut self, material: &str, patch: Patch, exitance_lm_m2: f64) {
        let name = format!("panel {}", self.geometry.len());
        self.plate(&name, material, patch);
        self.luminaire(json!({ "type": "area", "surface": name, "exitance_lm_m2": exitance_lm_m2 }));
    }

    /// Adds a luminaire with a photometric file, which is stored with the room.
    pub fn photometric(&mut self, file: (&str, &str), position_m: DVec3, aim: DVec3, dimming: f64) {
        let (name, text) = file;
        if self.files.iter().all(|known| known.name != name) {
            self.files.push(RoomFile { name: name.to_owned(), text: text.to_owned() });
        }
        self.luminaire(json!({
            "type": "photometric", "file": name, "position": position_m.to_array(), "aim": aim.to_array(),
            "dimming": dimming,
        }));
    }

    /// Number of luminaires so far.
    pub fn luminaire_count(&self) -> usize {
        self.luminaires.len()
    }

    /// Adds a grid of upward-facing receivers over a rectangle of the floor plan. The margin at the ends is half a cell.
    pub fn grid(&mut self, name: &str, low_m: [f64; 3], high_m: [f64; 2], counts: [usize; 2]) {
        let margin_m = |axis: usize| 0.5 * (high_m[axis] - low_m[axis]) / counts[axis] as f64;
        let size_m = |axis: usize| high_m[axis] - low_m[axis] - 2.0 * margin_m(axis);
        self.receivers.push(json!({
            "name": name, "type": "grid",
            "origin": [low_m[0] + margin_m(0), low_m[1] + margin_m(1), low_m[2]],
            "u": [size_m(0), 0, 0], "v": [0, size_m(1), 0], "columns": counts[0], "rows": counts[1],
        }));
    }

    /// Adds a patch to a region of receivers.
    pub fn region(&mut self, name: &str, patch: Patch) {
        self.regions.push((name.to_owned(), patch));
    }

    /// Returns whether a point is inside a solid.
    pub fn is_inside(&self, place_m: DVec3) -> bool {
        self.solids.iter().any(|solid| solid.contains(place_m))
    }

    /// Returns whether a point is in the air of the room, whose walls form a convex body.
    pub fn is_in_the_air(&self, place_m: DVec3) -> bool {
        let is_before = |wall: &Wall| (place_m - wall.corners_m[0]).dot(wall.normal()) > 0.0;
        self.walls.iter().all(is_before) && !self.is_inside(place_m)
    }

    /// Returns whether no solid overlaps a box along the axes.
    pub fn is_clear(&self, low_m: DVec3, high_m: DVec3) -> bool {
        let apart = |solid: &Solid| {
            let [low, high] = solid.bounds_m();
            high.cmple(low_m).any() || low.cmpge(high_m).any()
        };
        self.solids.iter().all(apart)
    }

    fn notice_mesh(&mut self, material: &str, corners_m: &[DVec3], faces: &[Vec<usize>]) {
        for face in faces {
            let polygon: Vec<DVec3> = face.iter().map(|corner| corners_m[*corner]).collect();
            self.notice_polygon(material, &polygon);
        }
    }

    /// Records a convex polygon as a surface for receivers.
    fn notice_polygon(&mut self, group: &str, corners_m: &[DVec3]) {
        let number = self.groups.iter().position(|known| known == group).unwrap_or_else(|| {
            self.groups.push(group.to_owned());
            self.groups.len() - 1
        });
        for last in 2..corners_m.len() {
            let corners_m = [corners_m[0], corners_m[last - 1], corners_m[last]];
            self.faces.push(Face { corners_m, group: number });
        }
    }

    /// The scene file and the files that it uses.
    pub(super) fn finish(mut self, title: &str) -> (String, Vec<RoomFile>) {
        let meshes = [("shell", self.shell, false), ("things", self.things, false), ("sheets", self.sheets, true)];
        for (name, mesh, two_sided) in meshes {
            if mesh.vertices == 0 {
                continue;
            }
            let file = format!("{name}.obj");
            self.geometry.push(json!({ "name": name, "type": "mesh", "file": file, "two_sided": two_sided }));
            self.files.push(RoomFile { name: file, text: mesh.text });
        }
        let scene = json!({
            "version": 1, "title": title, "length_unit": "m", "materials": self.materials, "geometry": self.geometry,
            "luminaires": self.luminaires, "receivers": self.receivers,
        });
        (format!("{scene:#}\n"), self.files)
    }
}
