//! `scene.glb`: the elements in false colours, for programs that open glTF: viewers, Blender, browsers.

use std::collections::BTreeMap;

use glam::DVec3;
use gltf::Glb;
use gltf::binary::Header;
use serde_json::{Value, json};

use super::StreamedFile;
use super::color::{Ink, perceptual};
use super::scale::{SHARE_IN_SCALE, end_of_scale_lx};
use super::streamed::unwritable;
use crate::maps::{MapKind, MapResult};
use crate::scene::{Elements, MaterialId, Scene, Side};
use crate::solver::Solution;

/// Number of intervals of the colour legend.
const STOPS: u32 = 8;

/// Largest number of surfaces that each become a node. A node takes a kilobyte, and more than ten times that while the file is
/// made. No viewer lists more.
const MOST_NODES: usize = 4096;

/// Bytes of an element side (three corners), and largest number of bytes of all sides. The format counts in 32 bits, and JSON takes
/// some of that.
const BYTES_OF_A_SIDE: u64 = 3 * (12 + 8 + 4 + 4);
const MOST_BYTES: u64 = (1 << 32) - (64 << 20);

/// glTF's codes for single-precision numbers and for whole numbers of two bytes.
const FLOAT: u32 = 5126;
const UNSIGNED_SHORT: u32 = 5123;
/// glTF's code for a buffer of vertices.
const ARRAY_BUFFER: u32 = 34962;

/// The element map as a GLB file. Each surface is a node (each material, if there are very many surfaces). Each element side is a
/// triangle, as in `scene.vtp`, with its colour, illuminance and standard error at every corner. `None` if no element map was
/// computed, or if the file would exceed the format's 4 GB.
///
/// Colours are linear and unlit; `asset.extras` describes their meaning.
pub fn glb_file<'a>(scene: &'a Scene, solution: &'a Solution) -> Option<StreamedFile<'a>> {
    const NAME: &str = "scene.glb";
    let map = solution.maps.iter().find(|map| map.kind == MapKind::Elements)?;
    if solution.elements.len() as u64 * BYTES_OF_A_SIDE > MOST_BYTES {
        return None;
    }
    Some(StreamedFile::new(NAME, move |writer| {
        let model = Model::of(scene, &solution.elements, map);
        let glb = Glb {
            header: Header { magic: *b"glTF", version: 2, length: 0 },
            json: model.json.to_string().into_bytes().into(),
            bin: Some(model.binary.into()),
        };
        glb.to_writer(writer).map_err(|error| match error {
            gltf::Error::Io(error) => unwritable(NAME, &error),
            error => unwritable(NAME, &std::io::Error::other(error.to_string())),
        })
    }))
}

/// The two parts of a GLB file.
struct Model {
    json: Value,
    binary: Vec<u8>,
}

impl Model {
    fn of(scene: &Scene, elements: &Elements, map: &MapResult) -> Model {
        let area_m2 = |index: usize| elements.area_m2(scene, elements.element(index as u32));
        let lit = map.values.value.iter().enumerate().map(|(index, lx)| (*lx, area_m2(index)));
        // If everything is dark, any scale will do.
        let end_lx = end_of_scale_lx(lit.collect()).unwrap_or(1.0);
        let center_m = center_m(scene);
        let mut parts = Parts::default();
        let mut nodes = Vec::new();
        let mut meshes = Vec::new();
        for SceneNode { name, material, sides } in nodes_of(scene, elements, MOST_NODES) {
            let vertices = Vertices::of(scene, elements, map, &sides, center_m, end_lx);
            let attributes = json!({
                "POSITION": parts.vectors(&vertices.positions),
                "COLOR_0": parts.colors(&vertices.colors),
                "_ILLUMINANCE_LX": parts.numbers(&vertices.illuminances_lx),
                "_STANDARD_ERROR_LX": parts.numbers(&vertices.standard_errors_lx),
            });
            nodes.push(json!({ "name": name, "mesh": meshes.len() }));
            meshes.push(json!({ "name": name, "primitives": [{ "attributes": attributes, "material": material }] }));
        }
        let all: Vec<usize> = (0..nodes.len()).collect();
        let root = nodes.len();
        nodes.push(json!({ "name": scene.title, "translation": center_m, "children": all }));
        let unlit = |name: &String| {
            json!({ "name": name, "extensions": { "KHR_materials_unlit": {} },
                    "pbrMetallicRoughness": { "metallicFactor": 0, "roughnessFactor": 1 } })
        };
        let materials: Vec<Value> = scene.materials.iter().map(|material| unlit(&material.name)).collect();
        let json = json!({
            "asset": { "version": "2.0", "generator": concat!("luxmc ", env!("CARGO_PKG_VERSION")), "extras": legend(end_lx) },
            "extensionsUsed": ["KHR_materials_unlit"],
            "scene": 0,
            "scenes": [{ "name": scene.title, "nodes": [root] }],
            "nodes": nodes,
            "meshes": meshes,
            "materials": materials,
            "accessors": parts.accessors,
            "bufferViews": parts.views,
            "buffers": [{ "byteLength": parts.binary.len() }],
        });
        Model { json, binary: parts.binary }
    }
}

/// The meaning of the colours.
fn legend(end_lx: f64) -> Value {
    let stop = |number: u32| {
        let share = f64::from(number) / f64::from(STOPS);
        json!({ "illuminance_lx": share * end_lx, "srgb": perceptual(share) })
    };
    json!({
        "colors": "COLOR_0 shows the illuminance on a linear scale (viridis); values beyond its end have the last colour",
        "stops": (0..=STOPS).map(stop).collect::<Vec<Value>>(),
        "share_of_area_within": SHARE_IN_SCALE,
        "_ILLUMINANCE_LX": "illuminance at the corner, in lx",
        "_STANDARD_ERROR_LX": "standard error of the element's mean, in lx",
    })
}

/// The middle of the scene in glTF's axes, rounded to the file's precision. Positions relative to it lose only a precision that
/// matches their own size.
fn center_m(scene: &Scene) -> [f32; 3] {
    let low_m = scene.vertices_m.iter().copied().reduce(DVec3::min).unwrap_or(DVec3::ZERO);
    let high_m = scene.vertices_m.iter().copied().reduce(DVec3::max).unwrap_or(DVec3::ZERO);
    upright(0.5 * (low_m + high_m)).map(|number| number as f32)
}

/// Converts to glTF's axes, in which y points up.
fn upright(point: DVec3) -> [f64; 3] {
    [point.x, point.z, -point.y]
}

/// Element sides that form one object of the file.
struct SceneNode<'a> {
    name: &'a str,
    material: MaterialId,
    sides: Vec<u32>,
}

/// The element sides by surface, or by material if there are more than `most` surfaces.
fn nodes_of<'a>(scene: &'a Scene, elements: &Elements, most: usize) -> Vec<SceneNode<'a>> {
    let by_surface = scene.surfaces.len() <= most;
    let mut nodes: BTreeMap<u32, SceneNode> = BTreeMap::new();
    for index in 0..elements.len() as u32 {
        let id = scene.triangle_surfaces[elements.element(index).triangle as usize];
        let surface = &scene.surfaces[id as usize];
        let material = surface.material;
        let (key, name) = match by_surface {
            true => (id, surface.name.as_str()),
            false => (material, scene.materials[material as usize].name.as_str()),
        };
        nodes.entry(key).or_insert_with(|| SceneNode { name, material, sides: Vec::new() }).sides.push(index);
    }
    nodes.into_values().collect()
}

/// Vertices of element sides, three for each side.
#[derive(Default)]
struct Vertices {
    positions: Vec<[f32; 3]>,
    colors: Vec<[u16; 4]>,
    illuminances_lx: Vec<f32>,
    standard_errors_lx: Vec<f32>,
}

impl Vertices {
    fn of(
        scene: &Scene,
        elements: &Elements,
        map: &MapResult,
        sides: &[u32],
        center_m: [f32; 3],
        end_lx: f64,
    ) -> Vertices {
        let mut vertices = Vertices::default();
        for index in sides {
            let element = elements.element(*index);
            let corners_m = elements.corners_m(scene, element);
            let at_lx = map.values.at_corners_lx(*index as usize);
            let turned = if element.side == Side::Front { [0, 1, 2] } else { [0, 2, 1] };
            for corner in turned {
                let place = upright(corners_m[corner]);
                let about_center = |axis: usize| (place[axis] - f64::from(center_m[axis])) as f32;
                vertices.positions.push([0, 1, 2].map(about_center));
                vertices.colors.push(linear(perceptual(at_lx[corner] / end_lx)));
                vertices.illuminances_lx.push(single(at_lx[corner]));
                vertices.standard_errors_lx.push(single(map.values.standard_error[*index as usize]));
            }
        }
        vertices
    }
}

/// A number in single precision; larger numbers are clamped to the largest.
fn single(number: f64) -> f32 {
    number.clamp(f64::from(f32::MIN), f64::from(f32::MAX)) as f32
}

/// An opaque colour in glTF's form: linear, with two bytes a channel. Source: IEC 61966-2-1.
fn linear(ink: Ink) -> [u16; 4] {
    let channel = |code: u8| {
        let c = f64::from(code) / 255.0;
        let linear = if c <= 0.04045 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) };
        (linear * f64::from(u16::MAX)).round() as u16
    };
    let [red, green, blue] = ink.map(channel);
    [red, green, blue, u16::MAX]
}

/// Accessors and the bytes that they read, in sequence.
#[derive(Default)]
struct Parts {
    binary: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
}

impl Parts {
    fn vectors(&mut self, vectors: &[[f32; 3]]) -> usize {
        let bound = |pick: fn(f32, f32) -> f32| -> [f32; 3] {
            let all = vectors.iter().copied();
            all.reduce(|a, b| [0, 1, 2].map(|axis| pick(a[axis], b[axis]))).unwrap_or_default()
        };
        let (min, max) = (bound(f32::min), bound(f32::max));
        let bytes = vectors.iter().flatten().flat_map(|number| number.to_le_bytes());
        let accessor =
            json!({ "componentType": FLOAT, "type": "VEC3", "count": vectors.len(), "min": min, "max": max });
        self.add(bytes, accessor)
    }

    fn colors(&mut self, colors: &[[u16; 4]]) -> usize {
        let bytes = colors.iter().flatten().flat_map(|number| number.to_le_bytes());
        let accessor =
            json!({ "componentType": UNSIGNED_SHORT, "type": "VEC4", "count": colors.len(), "normalized": true });
        self.add(bytes, accessor)
    }

    fn numbers(&mut self, numbers: &[f32]) -> usize {
        let bytes = numbers.iter().flat_map(|number| number.to_le_bytes());
        self.add(bytes, json!({ "componentType": FLOAT, "type": "SCALAR", "count": numbers.len() }))
    }

    /// Appends bytes, a multiple of four, and the accessor that reads them. Returns the accessor's number.
    fn add(&mut self, bytes: impl Iterator<Item = u8>, mut accessor: Value) -> usize {
        let start = self.binary.len();
        self.binary.extend(bytes);
        let length = self.binary.len() - start;
        accessor["bufferView"] = json!(self.views.len());
        self.views.push(json!({ "buffer": 0, "byteOffset": start, "byteLength": length, "target": ARRAY_BUFFER }));
        self.accessors.push(accessor);
        self.accessors.len() - 1
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::check::scene_from_json;

    /// An element of 10⁻⁶⁰ m² may have an error too large for single precision.
    #[test]
    fn numbers_beyond_four_bytes_are_the_largest() {
        assert_eq!([2.5, 1e60, -1e60].map(single), [2.5, f32::MAX, f32::MIN]);
    }

    /// Three rectangles of two materials: one node each, or one node for each material if that would be too many. All sides are
    /// present either way.
    #[test]
    fn very_many_surfaces_are_a_node_a_material() {
        let rectangle = |number: usize, material: &str| {
            format!(
                r#"{{ "name": "r{number}", "type": "rectangle", "origin": [{number},0,0], "u": [0.5,0,0], "v": [0,1,0], "material": "{material}" }}"#
            )
        };
        let text = format!(
            r#"{{ "version": 1, "materials": {{ "a": {{ "type": "diffuse", "reflectance": 0.5 }}, "b": {{ "type": "diffuse", "reflectance": 0.2 }} }},
            "geometry": [ {}, {}, {} ],
            "luminaires": [ {{ "name": "l", "type": "point", "position": [0,0,2], "luminous_flux_lm": 1 }} ] }}"#,
            rectangle(0, "a"),
            rectangle(1, "b"),
            rectangle(2, "a")
        );
        let scene = scene_from_json(&text, None, std::path::Path::new(".")).expect("a valid scene");
        let elements = Elements::of(&scene);
        let told = |most: usize| -> Vec<(String, usize)> {
            let nodes = nodes_of(&scene, &elements, most).into_iter();
            nodes.map(|node| (node.name.to_owned(), node.sides.len())).collect()
        };
        let named = |all: &[(&str, usize)]| -> Vec<(String, usize)> {
            all.iter().map(|(name, count)| ((*name).to_owned(), *count)).collect()
        };
        assert_eq!(told(3), named(&[("r0", 2), ("r1", 2), ("r2", 2)]));
        assert_eq!(told(2), named(&[("a", 4), ("b", 2)]));
    }
}
