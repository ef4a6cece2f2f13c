//! glTF 2.0 and GLB: triangles of all nodes of a scene, in parts by material.
//!
//! Metres become the scene's unit. The upward y axis of glTF becomes the scene's upward z axis. The reader ignores the appearance of materials:
//! the scene file gives their reflection.

use std::borrow::Cow;
use std::collections::HashMap;
use std::path::Path;

use glam::{DMat3, DMat4, DQuat, DVec3};
use gltf::accessor::{DataType, Dimensions};
use gltf::mesh::{Mode, Primitive};
use gltf::scene::Transform;
use gltf::{Document, Glb, Node};
use serde::Deserialize;

use super::error::SceneError;
use super::gltf_buffers::{AccessorElements, Buffers};
use super::gltf_extensions;
use super::limits::{MOST_MESH_READS, MOST_MESH_TRIANGLES};
use super::mesh_builder::{MeshBuilder, refusal};
use super::shapes::GeometryShape;
use super::units::LengthUnit;

/// First bytes of a GLB file.
const MAGIC: &[u8] = b"glTF";
/// Number of bytes before the first chunk of a GLB file.
const HEADER_BYTES: u32 = 12;
/// The version that is read, of glTF and of its container.
const VERSION: u32 = 2;

/// Reads a mesh. Warnings name the ignored parts of the file that matter.
///
/// # Errors
///
/// Damaged files, references that lead nowhere, buffers outside the folder, and files without a triangle.
pub(super) fn read(
    path: &Path,
    bytes: &[u8],
    unit: LengthUnit,
    warnings: &mut Vec<String>,
) -> Result<GeometryShape, SceneError> {
    let (json, binary) = chunks(path, bytes)?;
    let document = document(path, described(path, &json)?)?;
    let mut reader = GltfReader {
        path,
        unit,
        buffers: Buffers::new(path, &document, binary.as_deref()),
        mesh: MeshBuilder::default(),
        reads: 0,
        passed_over: 0,
        bent: 0,
        aside: 0,
    };
    reader.scene(&document)?;
    reader.warn(&document, warnings);
    let shape = reader.mesh.finish();
    if shape.parts.is_empty() {
        let got = format!("{} nodes, no triangle", document.nodes().len());
        return Err(refusal(path, "a mesh without a triangle", got, "a glTF scene with a mesh of triangles"));
    }
    Ok(shape)
}

fn not_valid(path: &Path, error: &dyn std::fmt::Display) -> SceneError {
    refusal(path, "not valid glTF", error.to_string(), "glTF 2.0")
}

/// Parses the JSON text of a file.
fn described(path: &Path, json: &[u8]) -> Result<gltf::json::Root, SceneError> {
    #[derive(Deserialize)]
    struct Versioned {
        asset: Asset,
    }
    #[derive(Deserialize)]
    struct Asset {
        version: String,
    }
    gltf::json::deserialize::from_slice(json).map_err(|error| match serde_json::from_slice::<Versioned>(json) {
        Ok(Versioned { asset }) if !asset.version.starts_with(&format!("{VERSION}.")) => {
            of_another_version(path, &asset.version)
        }
        _ => not_valid(path, &error),
    })
}

fn of_another_version(path: &Path, version: &str) -> SceneError {
    let remedy = "export the model again as glTF 2.0, or convert it with a tool for glTF files";
    let what = "the version of the glTF file is not supported".to_owned();
    SceneError::of_file(path, what, format!("version {version}"), "glTF 2.0", remedy)
}

/// Makes a document with checked references. The library reads the accessor of positions before it checks that the accessor exists. This
/// function therefore refuses missing accessors first.
fn document(path: &Path, mut root: gltf::json::Root) -> Result<Document, SceneError> {
    gltf_extensions::refuse_unread(path, &mut root)?;
    if let Some(refusal) = gltf_extensions::is_packed(path, &root) {
        return Err(refusal);
    }
    let positions = gltf::json::validation::Checked::Valid(gltf::Semantic::Positions);
    for (number, mesh) in root.meshes.iter().enumerate() {
        let named = mesh.primitives.iter().filter_map(|primitive| primitive.attributes.get(&positions));
        if let Some(index) = named.map(|index| index.value()).find(|index| *index >= root.accessors.len()) {
            let what = format!("mesh {number}: positions that do not exist");
            let got = format!("accessor {index} of {}", root.accessors.len());
            return Err(refusal(path, what, got, "the number of an accessor of the file"));
        }
    }
    Document::from_json(root).map_err(|error| not_valid(path, &error))
}

/// The JSON and, for a GLB file, the binary chunk.
type Chunks<'b> = (Cow<'b, [u8]>, Option<Cow<'b, [u8]>>);

fn chunks<'b>(path: &Path, bytes: &'b [u8]) -> Result<Chunks<'b>, SceneError> {
    if !bytes.starts_with(MAGIC) {
        return Ok((Cow::Borrowed(bytes), None));
    }
    let number = |at: usize| bytes.get(at..at + 4)?.try_into().ok().map(u32::from_le_bytes);
    if let Some(version) = number(4).filter(|version| *version != VERSION) {
        return Err(of_another_version(path, &version.to_string()));
    }
    let said = number(8).unwrap_or(0);
    let Some(whole) = bytes.get(..said as usize).filter(|_| said >= HEADER_BYTES) else {
        let expected = format!("{said} bytes, as its header says");
        return Err(refusal(path, "the GLB file is cut short or damaged", format!("{} bytes", bytes.len()), &expected));
    };
    let glb = Glb::from_slice(whole)
        .map_err(|error| refusal(path, "the GLB file is damaged", error.to_string(), "GLB version 2"))?;
    Ok((glb.json, glb.bin))
}

struct GltfReader<'a> {
    path: &'a Path,
    unit: LengthUnit,
    buffers: Buffers<'a>,
    mesh: MeshBuilder,
    /// Number of vertices and corners read so far.
    reads: usize,
    /// Number of primitives that are lines or points.
    passed_over: usize,
    /// Number of meshes with bones or morph targets.
    bent: usize,
    /// Number of nodes with a mesh that do not belong to the scene.
    aside: usize,
}

impl GltfReader<'_> {
    fn scene(&mut self, document: &Document) -> Result<(), SceneError> {
        let Some(scene) = document.default_scene().or_else(|| document.scenes().next()) else {
            let got = format!("{} nodes, no scene", document.nodes().len());
            return Err(refusal(self.path, "the glTF file has no scene", got, "a scene that names its nodes"));
        };
        let mut reached = vec![false; document.nodes().len()];
        let mut waiting: Vec<(Node, DMat4)> = scene.nodes().map(|node| (node, DMat4::IDENTITY)).collect();
        waiting.reverse();
        while let Some((node, above)) = waiting.pop() {
            if std::mem::replace(&mut reached[node.index()], true) {
                let what = format!("node {} is reached twice", node.index());
                return Err(refusal(self.path, what, "a cycle, or a node with two parents", "nodes that form a tree"));
            }
            let placed = above * matrix_of(node.transform());
            if let Some(mesh) = node.mesh() {
                self.bent += usize::from(node.skin().is_some() || mesh.weights().is_some());
                for primitive in mesh.primitives() {
                    let place = format!("mesh {}, primitive {}", mesh.index(), primitive.index());
                    self.primitive(&primitive, placed, &place)?;
                }
            }
            let children: Vec<(Node, DMat4)> = node.children().map(|child| (child, placed)).collect();
            waiting.extend(children.into_iter().rev());
        }
        self.aside = document.nodes().filter(|node| node.mesh().is_some() && !reached[node.index()]).count();
        Ok(())
    }

    fn primitive(&mut self, primitive: &Primitive, placed: DMat4, place: &str) -> Result<(), SceneError> {
        let path = self.path;
        let refuse = |what: &str, got: String, expected: &str| refusal(path, format!("{place}: {what}"), got, expected);
        if matches!(primitive.mode(), Mode::Points | Mode::Lines | Mode::LineLoop | Mode::LineStrip) {
            self.passed_over += 1;
            return Ok(());
        }
        let Some(positions) = primitive.get(&gltf::Semantic::Positions) else {
            return Err(refuse("no positions", "no attribute POSITION".to_owned(), "an attribute POSITION"));
        };
        if positions.dimensions() != Dimensions::Vec3 || positions.data_type() == DataType::U32 {
            let got = format!("{:?} of {:?}", positions.dimensions(), positions.data_type());
            return Err(refuse(
                "positions of an unsupported type",
                got,
                "VEC3 of FLOAT, or of whole numbers of 8 or 16 bits",
            ));
        }
        let point_of = point_reader(positions.data_type(), positions.normalized());
        self.buffers.load(&positions)?;
        if let Some(indices) = primitive.indices() {
            let kind = indices.data_type();
            if !matches!(kind, DataType::U8 | DataType::U16 | DataType::U32)
                || indices.dimensions() != Dimensions::Scalar
            {
                let got = format!("{:?} of {kind:?}", indices.dimensions());
                return Err(refuse("indices of an unsupported type", got, "SCALAR of unsigned whole numbers"));
            }
            self.buffers.load(&indices)?;
        }
        let places = self.buffers.elements(&positions)?;
        let corners = Corners {
            indices: primitive.indices().map(|indices| self.buffers.elements(&indices)).transpose()?,
            vertices: places.count,
        };
        self.reads = self.reads.saturating_add(places.count).saturating_add(corners.count());
        if self.reads > MOST_MESH_READS {
            let got = format!("{} vertices and corners so far", self.reads);
            return Err(refuse(
                "the nodes need too many vertices and corners",
                got,
                &format!("at most {MOST_MESH_READS}"),
            ));
        }

        // Maps corners to vertices of the mesh. A mirroring transform reverses the triangles.
        let mirrors = DMat3::from_mat4(placed).determinant() < 0.0;
        let name = part_name(primitive);
        let mut numbers: Vec<Option<u32>> = vec![None; places.count];
        let mut triangles = Vec::new();
        for triple in triples(primitive.mode(), corners.count()) {
            let mut triangle = [0; 3];
            for (number, corner) in triangle.iter_mut().zip(triple) {
                let index = corners.at(corner);
                let Some(known) = numbers.get_mut(index) else {
                    let expected = format!("an index from 0 to {}", places.count.saturating_sub(1));
                    return Err(refuse("a triangle names a vertex that does not exist", index.to_string(), &expected));
                };
                *number = match *known {
                    Some(number) => number,
                    None => {
                        let point = placed.transform_point3(point_of(places.at(index)));
                        if !point.is_finite() {
                            let what = format!("vertex {index} has no finite position");
                            return Err(refuse(
                                &what,
                                point.to_string(),
                                "numbers, and transforms that keep them finite",
                            ));
                        }
                        let upright = DVec3::new(point.x, -point.z, point.y);
                        *known.insert(self.mesh.vertex(self.unit.point_of_m(upright)))
                    }
                };
            }
            if mirrors {
                triangle.swap(1, 2);
            }
            triangles.push(triangle);
        }
        if !corners.count().is_multiple_of(3) && primitive.mode() == Mode::Triangles {
            let got = format!("{} corners", corners.count());
            return Err(refuse("not a whole number of triangles", got, "three corners for each triangle"));
        }
        if !triangles.is_empty() {
            self.mesh.add(name.as_deref(), triangles);
        }
        if self.mesh.size() > MOST_MESH_TRIANGLES {
            let expected = format!("at most {MOST_MESH_TRIANGLES}");
            return Err(refuse("too many triangles or vertices", self.mesh.size().to_string(), &expected));
        }
        Ok(())
    }

    fn warn(&self, document: &Document, warnings: &mut Vec<String>) {
        let path = self.path.display();
        let scenes = document.scenes().len();
        if scenes > 1 {
            warnings.push(format!("{path}: one of {scenes} scenes was read, the default or first one"));
        } else if self.aside > 0 {
            warnings.push(format!("{path}: {} nodes with a mesh belong to no scene and were skipped", self.aside));
        }
        if self.passed_over > 0 {
            warnings.push(format!(
                "{path}: {} primitives of lines or points were skipped; they have no area",
                self.passed_over
            ));
        }
        if self.bent > 0 || document.animations().len() > 0 {
            warnings.push(format!(
                "{path}: bones, morph targets and animations were skipped; meshes are read in their rest pose"
            ));
        }
        for extension in gltf_extensions::passed_over(document) {
            warnings.push(format!("{path}: the additions of the extension {extension} were skipped"));
        }
        let mut named: HashMap<&str, usize> = HashMap::new();
        for name in document.materials().filter_map(|material| material.name()) {
            *named.entry(name.trim()).or_default() += 1;
        }
        let mut twice: Vec<&str> =
            named.into_iter().filter(|(name, count)| *count > 1 && !name.is_empty()).map(|(name, _)| name).collect();
        twice.sort_unstable();
        if let Some(first) = twice.first() {
            warnings.push(format!(
                "{path}: {} names belong to several materials each, first {first:?}; their triangles are one part",
                twice.len()
            ));
        }
    }
}

/// Corners of a primitive, by its indices or in the order of its vertices.
struct Corners<'b> {
    indices: Option<AccessorElements<'b>>,
    vertices: usize,
}

impl Corners<'_> {
    fn count(&self) -> usize {
        self.indices.as_ref().map_or(self.vertices, |indices| indices.count)
    }

    fn at(&self, corner: usize) -> usize {
        let Some(indices) = &self.indices else { return corner };
        indices.at(corner).iter().rev().fold(0, |number, byte| number << 8 | usize::from(*byte))
    }
}

/// The corners of every triangle, by the primitive's mode.
fn triples(mode: Mode, corners: usize) -> impl Iterator<Item = [usize; 3]> {
    let count = if mode == Mode::Triangles { corners / 3 } else { corners.saturating_sub(2) };
    (0..count).map(move |triangle| match mode {
        Mode::TriangleStrip if triangle % 2 == 1 => [triangle, triangle + 2, triangle + 1],
        Mode::TriangleStrip => [triangle, triangle + 1, triangle + 2],
        Mode::TriangleFan => [triangle + 1, triangle + 2, 0],
        _ => [3 * triangle, 3 * triangle + 1, 3 * triangle + 2],
    })
}

/// Returns a function that makes a point from the bytes of three numbers. Whole numbers (KHR_mesh_quantization) are the coordinates
/// themselves, or normalized: then the greatest number stands for 1.
fn point_reader(kind: DataType, is_normalized: bool) -> impl Fn(&[u8]) -> DVec3 {
    let (size, greatest) = match kind {
        DataType::I8 => (1, f64::from(i8::MAX)),
        DataType::U8 => (1, f64::from(u8::MAX)),
        DataType::I16 => (2, f64::from(i16::MAX)),
        DataType::U16 => (2, f64::from(u16::MAX)),
        DataType::U32 | DataType::F32 => (4, 1.0),
    };
    move |bytes| {
        let number = |axis: usize| match (kind, &bytes[size * axis..][..size]) {
            (DataType::I8, [byte]) => f64::from(i8::from_le_bytes([*byte])),
            (DataType::U8, [byte]) => f64::from(*byte),
            (DataType::I16, [low, high]) => f64::from(i16::from_le_bytes([*low, *high])),
            (DataType::U16, [low, high]) => f64::from(u16::from_le_bytes([*low, *high])),
            (_, bytes) => f64::from(f32::from_le_bytes(bytes.try_into().unwrap_or_default())),
        };
        let point = DVec3::new(number(0), number(1), number(2));
        if is_normalized { (point / greatest).max(DVec3::NEG_ONE) } else { point }
    }
}

fn matrix_of(transform: Transform) -> DMat4 {
    match transform {
        Transform::Matrix { matrix } => DMat4::from_cols_array_2d(&matrix.map(|column| column.map(f64::from))),
        Transform::Decomposed { translation, rotation, scale } => DMat4::from_scale_rotation_translation(
            DVec3::from(scale.map(f64::from)),
            DQuat::from_array(rotation.map(f64::from)).normalize(),
            DVec3::from(translation.map(f64::from)),
        ),
    }
}

/// The appearance of a material. It is meant for the eye and says little about the reflection of light.
pub(super) struct Appearance {
    /// Linear red, green and blue. They multiply a texture if there is one.
    pub base_color: [f64; 3],
    pub is_metal: bool,
    pub has_texture: bool,
    pub is_transparent: bool,
    pub is_emissive: bool,
}

/// Reads the description in a file, without the numbers of its meshes.
///
/// # Errors
///
/// Damaged files.
pub(super) fn description(path: &Path, bytes: &[u8]) -> Result<Document, SceneError> {
    let (json, _) = chunks(path, bytes)?;
    document(path, described(path, &json)?)
}

/// Appearances of all materials, by the names of the parts that have them.
pub(super) fn appearances(document: &Document) -> HashMap<String, Appearance> {
    let appearance = |material: gltf::Material| {
        let surface = material.pbr_metallic_roughness();
        let (color, has_texture, is_metal) = match material.pbr_specular_glossiness() {
            Some(other) => (other.diffuse_factor(), other.diffuse_texture().is_some(), false),
            None => (
                surface.base_color_factor(),
                surface.base_color_texture().is_some(),
                surface.metallic_factor() > 0.5 && surface.metallic_roughness_texture().is_none(),
            ),
        };
        let [red, green, blue, alpha] = color.map(f64::from);
        let lets_through = material.transmission().is_some_and(|transmission| transmission.transmission_factor() > 0.0);
        let appearance = Appearance {
            base_color: [red, green, blue],
            is_metal,
            has_texture,
            is_transparent: lets_through || alpha < 1.0 || material.alpha_mode() == gltf::material::AlphaMode::Blend,
            is_emissive: material.emissive_factor().iter().any(|part| *part > 0.0),
        };
        Some((material_name(&material)?, appearance))
    };
    document.materials().filter_map(appearance).collect()
}

/// Returns the name of a primitive's material, or its number if it has no name.
fn part_name(primitive: &Primitive) -> Option<String> {
    material_name(&primitive.material())
}

fn material_name(material: &gltf::Material) -> Option<String> {
    let number = material.index()?;
    let name: String = material.name().unwrap_or_default().trim().replace(char::is_control, " ");
    Some(if name.is_empty() { format!("material {number}") } else { name })
}

#[cfg(test)]
#[path = "gltf_tests.rs"]
mod tests;
