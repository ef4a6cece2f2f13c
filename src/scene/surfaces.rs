//! Reads `geometry`: every type becomes placed triangles in metres, part by part.

use std::collections::{HashMap, HashSet};
use std::ops::Range;
use std::path::Path;
use std::sync::Arc;

use glam::DVec3;

use super::bodies::Body;
use super::error::SceneError;
use super::given;
use super::keys::{
    ABOVE_ZERO, ANY_LENGTH, BOOLEAN, Form, Key, NOT_EMPTY, ObjectKinds, TEXT, TYPE, VECTOR, ValueShape, form, needed,
    optional,
};
use super::limits::{MOST_SPHERE_FREQUENCY, MOST_SPHERE_TRIANGLES};
use super::materials::Material;
use super::mesh_builder::UNNAMED_PART;
use super::mesh_file::MeshFile;
use super::model::{MaterialId, Surface, SurfaceId};
use super::names::{listed, place_words};
use super::placing::{self, Placing};
use super::reader::{Fields, Node, meant};
use super::reported::Reporting;
use super::series::{self, WrittenBody};
use super::shapes::{self, BOX_FACES, GeometryShape, ShapePart};
use super::under_way;
use super::units::LengthUnit;
use super::weld::weld;

/// The kinds of geometry.
pub(super) const KINDS: ObjectKinds =
    ObjectKinds { name: "Geometry", doc: "Geometry.", forms: &[BOX, RECTANGLE, MESH, SPHERE, HARMONICS] };

#[rustfmt::skip]
const BOX: Form = form("box",
    "An axis-parallel box; its faces are NAME/floor, /ceiling, /x_min, /x_max, /y_min and /y_max.", &[NAMED, &[
    needed("min", VECTOR, "[0, 0, 0]", "Lowest corner."),
    needed("max", VECTOR, "[8, 6, 3]", "Highest corner."),
    facing("Which side of the faces is their front (outward by default)."),
    optional("material", TEXT, "Material of all faces that `materials` does not name."),
    optional("materials", ValueShape::Object(&BOX_MATERIALS), "Materials of single faces."),
], &placed(EDGE)]);
#[rustfmt::skip]
const RECTANGLE: Form = form("rectangle", "A rectangle; its normal is u × v.", &[NAMED, &[
    needed("origin", VECTOR, "[0, 0, 0]", "A corner."),
    needed("u", VECTOR, "[1, 0, 0]", "Vector from the corner along one side."),
    needed("v", VECTOR, "[0, 1, 0]", "Vector from the corner along the other side."),
    MATERIAL,
], &placed(EDGE)]);
#[rustfmt::skip]
const MESH: Form = form("mesh",
    "A mesh from a Wavefront OBJ file, its parts NAME/USEMTL, or from a glTF 2.0 file, its parts NAME/MATERIAL; STL and PLY too. Or of \
     `vertices` and `faces` that stand here.", &[NAMED, &[
    optional("file", TEXT, "The OBJ, glTF, GLB, STL or PLY file.").such_as("\"desks.obj\", or \"vertices\" and \"faces\""),
    optional("vertices", ValueShape::List(&VECTOR, ANY_LENGTH), "Vertices instead of a file."),
    optional("faces", ValueShape::List(&ValueShape::List(&ValueShape::Index, ANY_LENGTH), NOT_EMPTY),
        "The numbers of the vertices of each face, from 0, counter-clockwise seen from its front.")
        .such_as("[[0, 1, 2], …]: the numbers of the vertices of each face, from 0"),
    optional("material", TEXT, "Material of all parts without one of their own."),
    optional("materials", ValueShape::Map(&TEXT),
        "Materials by the file's `usemtl` or material names; otherwise the scene's material of that name is used."),
], &placed(EDGE)]).either(&[&["file"], &["vertices", "faces"]]);
#[rustfmt::skip]
const SPHERE: Form = form("sphere", "A sphere, as triangles inscribed in it.", &[NAMED, &[
    needed("center", VECTOR, "[0, 0, 1]", "Centre."),
    needed("radius", ABOVE_ZERO, "0.3", "Radius."),
    facing(FRONT),
    MATERIAL,
], &placed("Longest edge of the sphere's triangles.")]);
#[rustfmt::skip]
const HARMONICS: Form = form("spherical_harmonics",
    "A smooth closed body whose radius by direction is a series of spherical harmonics; rays meet it exactly.",
    &[NAMED, series::OWN_KEYS, &[facing(FRONT), MATERIAL], &placed("Longest chord of the body's elements.")]);

/// Keys and documents that several kinds of geometry share.
const NAMED: &[Key] = &[needed("name", TEXT, "\"room\"", "Name of the geometry."), TYPE];
const MATERIAL: Key = needed("material", TEXT, "…", "Material.");
const EDGE: &str = "Triangles are split into elements until no edge is longer.";
const FRONT: &str = "Which side is the front (outward by default).";

const fn facing(doc: &'static str) -> Key {
    optional("facing", ValueShape::Choice(&FACINGS), doc)
}

#[rustfmt::skip]
const fn placed(edge_doc: &'static str) -> [Key; 4] {
    [
        optional("two_sided", BOOLEAN, "Whether both sides reflect and are reported."),
        optional("max_element_edge", ABOVE_ZERO, edge_doc),
        optional("report", BOOLEAN, "Whether the report and the terminal list it (area luminaires: false by default)."),
        optional("transform", ValueShape::Object(&placing::FORM), "Scale, rotation and translation."),
    ]
}

#[rustfmt::skip]
const BOX_MATERIALS: Form = form("BoxMaterials", "Materials of single faces of a box.", &[&[
    optional("floor", TEXT, "Lowest z."),
    optional("ceiling", TEXT, "Highest z."),
    optional("walls", TEXT, "All four walls."),
    optional("x_min", TEXT, "Wall at the lowest x."),
    optional("x_max", TEXT, "Wall at the highest x."),
    optional("y_min", TEXT, "Wall at the lowest y."),
    optional("y_max", TEXT, "Wall at the highest y."),
]]);
/// Values of `facing`.
const FACINGS: [&str; 2] = ["outward", "inward"];

/// Most element sides of a scene: the sums of a run take some hundred bytes per element side.
const MOST_CELLS: f64 = 33_554_432.0;
/// Largest coordinate in m, so that volumes and squared areas stay finite.
const LARGEST_COORDINATE_M: f64 = 1e15;
/// Least height of a triangle as a fraction of its longest edge. Below it the normal depends on the rounding of the coordinates.
const SMALLEST_RELATIVE_HEIGHT: f64 = 1e-12;
/// Fraction by which an edge may exceed the limit, so that 3 m in pieces of 0.3 m are ten pieces and not eleven.
const EDGE_ROUNDING: f64 = 1e-12;

/// All triangles of the scene read so far.
#[derive(Default)]
pub(super) struct Surfaces {
    pub vertices_m: Vec<DVec3>,
    pub triangles: Vec<[u32; 3]>,
    pub divisions: Vec<u32>,
    pub triangle_surfaces: Vec<SurfaceId>,
    pub surfaces: Vec<Surface>,
    pub bodies: Vec<Arc<Body>>,
    /// For every surface, how its geometry decides about reports.
    pub reporting: Vec<Reporting>,
    /// Names of geometries and parts, each with the path of the value that gave it.
    names: HashMap<String, String>,
    /// Surfaces by their own name and by the name of their geometry.
    by_name: HashMap<String, Range<SurfaceId>>,
    cells: f64,
    /// Number of triangles of all spheres.
    sphere_triangles: f64,
}

/// Data that geometry refers to.
pub(super) struct GeometryContext<'a> {
    pub unit: LengthUnit,
    pub base_dir: &'a Path,
    pub materials: &'a [Material],
    by_name: HashMap<&'a str, MaterialId>,
}

impl<'a> GeometryContext<'a> {
    /// Makes the context, with an index of the materials by name.
    pub fn of(unit: LengthUnit, base_dir: &'a Path, materials: &'a [Material]) -> GeometryContext<'a> {
        let by_name = materials.iter().zip(0..).map(|(material, id)| (material.name.as_str(), id)).collect();
        GeometryContext { unit, base_dir, materials, by_name }
    }

    fn material(&self, node: &Node) -> Result<MaterialId, SceneError> {
        let name = node.text()?;
        let names = || self.materials.iter().map(|material| material.name.as_str());
        let refuse = || node.refuse(format!("there is no material {name:?}"), listed(names()), meant(name, names()));
        self.by_name.get(name).copied().ok_or_else(refuse)
    }
}

/// Values that every geometry has, whatever its type.
struct GeometryKeys<'a> {
    node: Node<'a>,
    fields: Fields<'a>,
    kind: &'static str,
    name_node: Node<'a>,
    name: &'a str,
    two_sided: bool,
    /// Longest edge of an element, in the file's unit.
    longest_edge: Option<f64>,
    reporting: Reporting,
    placing: Placing,
}

impl Surfaces {
    /// Reads all geometry.
    pub fn read(node: &Node, around: &GeometryContext, warnings: &mut Vec<String>) -> Result<Surfaces, SceneError> {
        let mut surfaces = Surfaces::default();
        let items = node.items("geometry")?;
        if items.is_empty() {
            let remedy = "add at least one, such as { \"name\": \"room\", \"type\": \"box\", … }";
            return Err(node.refuse("the scene has no geometry", "at least one geometry", remedy));
        }
        let count = items.len();
        for (number, item) in items.into_iter().enumerate() {
            under_way::begin("geometry", count);
            under_way::reached(number);
            surfaces.add(&item, around, warnings)?;
        }
        Ok(surfaces)
    }

    /// Returns the surfaces with a name: those of a whole geometry, or one part.
    pub fn named(&self, node: &Node) -> Result<Vec<SurfaceId>, SceneError> {
        let name = node.text()?;
        let Some(found) = self.by_name.get(name) else {
            let mut known: Vec<&str> = self.names.keys().map(String::as_str).collect();
            known.sort_unstable();
            let remedy = meant(name, known.iter().copied());
            return Err(node.refuse(format!("there is no surface {name:?}"), listed(known.iter().copied()), remedy));
        };
        Ok(found.clone().collect())
    }

    /// Area of one side of a surface in m².
    pub fn area_m2(&self, surface: SurfaceId) -> f64 {
        let triangles = &self.surfaces[surface as usize].triangles;
        triangles
            .clone()
            .map(|triangle| {
                let [a, b, c] = self.triangles[triangle as usize].map(|vertex| self.vertices_m[vertex as usize]);
                0.5 * (b - a).cross(c - a).length()
            })
            .sum()
    }

    fn add(&mut self, node: &Node, around: &GeometryContext, warnings: &mut Vec<String>) -> Result<(), SceneError> {
        let common = self.common_of(node)?;
        let (shape, body) = self.shape_of(&common, around, warnings)?;
        let part_names: Vec<Option<&str>> = shape.parts.iter().map(|part| part.name.as_deref()).collect();
        let materials = part_materials(&common.fields, common.kind, &part_names, around)?;
        let first_vertex = self.place_vertices(&common, &shape, around)?;
        let first_surface = self.surfaces.len() as SurfaceId;
        let longest_edge_m = common.longest_edge.map(|edge| around.unit.length_m(edge));
        let mut dropped: Vec<[u32; 3]> = Vec::new();
        for (part, material) in shape.parts.iter().zip(materials) {
            let two_sided = common.two_sided || around.materials[material as usize].bsdf.is_two_sided();
            let surface = self.begin_surface(&common, part, material, two_sided)?;
            for triangle in &part.triangles {
                let triangle = triangle.map(|vertex| first_vertex as u32 + vertex);
                match self.divisions_of(triangle, longest_edge_m) {
                    Some(divisions) => self.push(triangle, divisions, two_sided),
                    None => dropped.push(triangle),
                }
                self.check_size(&common)?;
            }
            self.end_surface(surface, common.reporting, warnings);
        }
        if let Some(body) = body {
            if !dropped.is_empty() {
                let expected = "leaves with an area";
                let what = format!("{:?} is too flat", common.name);
                return Err(node.refuse(what, expected, "check its coefficients"));
            }
            let all = &self.surfaces[first_surface as usize].triangles;
            self.bodies.push(body.placed(&common.placing, around.unit, all.start));
        }
        let name = common.name;
        if let Some([first, ..]) = dropped.first() {
            let place_m = self.vertices_m[*first as usize];
            let (count, which) = (dropped.len(), if dropped.len() == 1 { "at" } else { "the first at" });
            warnings.push(format!(
                "{name}: {count} triangles without an area were dropped ({which} {})",
                place_words(place_m)
            ));
        }
        let surfaces = first_surface..self.surfaces.len() as SurfaceId;
        if surfaces.is_empty() {
            let expected = "at least one triangle with an area";
            return Err(node.refuse(format!("{name:?} has no area"), expected, "check its coordinates"));
        }
        self.by_name.insert(name.to_string(), surfaces);
        Ok(())
    }

    /// Reads the values that all geometry types share, and reserves the geometry's name.
    fn common_of<'a>(&mut self, node: &Node<'a>) -> Result<GeometryKeys<'a>, SceneError> {
        let form = &KINDS.forms[node.fields("a geometry")?.kind(&KINDS)?];
        let kind = form.name;
        let fields = node.object(&format!("a {kind} geometry"), form)?;
        let name_node = fields.need("name")?;
        let name = name_node.name()?;
        self.claim(&name_node, name)?;
        let two_sided = fields.get("two_sided").map_or(Ok(false), |node| node.boolean())?;
        let longest_edge = fields.get("max_element_edge").map(|node| node.amount("the longest edge")).transpose()?;
        let reporting = match (fields.get("report"), kind) {
            (Some(node), _) => Reporting::Asked(node.boolean()?),
            (None, "mesh") => Reporting::Part,
            (None, "box" | "sphere" | "spherical_harmonics") if faces_inward(&fields)? => Reporting::Room,
            (None, _) => Reporting::Housing,
        };
        let placing = fields.get("transform").map_or(Ok(Placing::HERE), |node| Placing::read(&node))?;
        Ok(GeometryKeys {
            node: node.clone(),
            fields,
            kind,
            name_node,
            name,
            two_sided,
            longest_edge,
            reporting,
            placing,
        })
    }

    /// Returns the shape in the file's unit. For a smooth body it also returns the body that its triangles represent.
    fn shape_of(
        &mut self,
        common: &GeometryKeys,
        around: &GeometryContext,
        warnings: &mut Vec<String>,
    ) -> Result<(GeometryShape, Option<WrittenBody>), SceneError> {
        let fields = &common.fields;
        let shape = match common.kind {
            "spherical_harmonics" => {
                let (shape, body) = series::read(fields, around.base_dir, faces_inward(fields)?)?;
                return Ok((shape, Some(body)));
            }
            "box" => read_box(fields)?,
            "rectangle" => read_rectangle(fields, common.name, warnings)?,
            "mesh" => read_mesh(fields, around, warnings)?,
            _ => self.read_sphere(common, warnings)?,
        };
        Ok((shape, None))
    }

    /// Adds the placed vertices of a shape in metres. Returns the number of the first one.
    fn place_vertices(
        &mut self,
        common: &GeometryKeys,
        shape: &GeometryShape,
        around: &GeometryContext,
    ) -> Result<usize, SceneError> {
        let first_vertex = self.vertices_m.len();
        for vertex in &shape.vertices {
            let place_m = around.unit.point_m(common.placing.apply(*vertex));
            if !place_m.is_finite() || place_m.abs().max_element() > LARGEST_COORDINATE_M {
                let expected = format!("coordinates up to {LARGEST_COORDINATE_M:e} m");
                return Err(common.node.refuse_as(
                    format!("{:?} is too large", common.name),
                    place_words(place_m),
                    expected,
                    "check numbers and length_unit",
                ));
            }
            self.vertices_m.push(place_m);
        }
        Ok(first_vertex)
    }

    /// Begins a surface without triangles, and reserves the part's name.
    fn begin_surface(
        &mut self,
        common: &GeometryKeys,
        part: &ShapePart,
        material: MaterialId,
        two_sided: bool,
    ) -> Result<Surface, SceneError> {
        let name = match &part.name {
            Some(part) => format!("{}/{part}", common.name),
            None => common.name.to_string(),
        };
        if part.name.is_some() {
            self.claim(&common.name_node, &name)?;
        }
        let first = self.triangles.len() as u32;
        Ok(Surface { name, geometry: common.name.to_string(), material, two_sided, triangles: first..first })
    }

    /// Stores a surface with all triangles added since its beginning. A surface without triangles is left out.
    fn end_surface(&mut self, mut surface: Surface, reporting: Reporting, warnings: &mut Vec<String>) {
        surface.triangles.end = self.triangles.len() as u32;
        if surface.triangles.is_empty() {
            warnings.push(format!("{}: left out, because none of its triangles has an area", surface.name));
            return;
        }
        let id = self.surfaces.len() as SurfaceId;
        self.by_name.insert(surface.name.clone(), id..id + 1);
        self.reporting.push(reporting);
        self.surfaces.push(surface);
    }

    /// Checks that the scene is small enough to be computed.
    fn check_size(&self, common: &GeometryKeys) -> Result<(), SceneError> {
        if self.cells <= MOST_CELLS && self.vertices_m.len() <= u32::MAX as usize {
            return Ok(());
        }
        let blamed = common.fields.get("max_element_edge").unwrap_or_else(|| common.node.clone());
        let expected = format!("at most {MOST_CELLS} elements in a scene");
        Err(blamed.refuse("the scene has too many elements", expected, "allow longer edges"))
    }

    fn read_sphere(&mut self, common: &GeometryKeys, warnings: &mut Vec<String>) -> Result<GeometryShape, SceneError> {
        let GeometryKeys { fields, name, placing, longest_edge, .. } = common;
        let center = fields.need("center")?.vector()?;
        let radius = fields.need("radius")?.amount("the radius")?;
        let inward = faces_inward(fields)?;
        let frequency = shapes::sphere_frequency(radius * placing.scale, *longest_edge);
        if let (Some(node), true) = (fields.get("max_element_edge"), frequency > f64::from(MOST_SPHERE_FREQUENCY)) {
            let finest = 2.0 * radius * placing.scale / f64::from(MOST_SPHERE_FREQUENCY);
            let expected = format!("an edge of at least {finest:.3e}");
            return Err(node.refuse("the sphere would need too many triangles", expected, "allow longer edges"));
        }
        self.sphere_triangles += 20.0 * frequency * frequency;
        if self.sphere_triangles > MOST_SPHERE_TRIANGLES {
            let blamed = fields.get("max_element_edge").unwrap_or_else(|| fields.node().clone());
            let expected = format!("at most {MOST_SPHERE_TRIANGLES:e} triangles of all spheres together");
            return Err(blamed.refuse("the spheres would need too many triangles", expected, "allow longer edges"));
        }
        let shape = shapes::icosphere(center, radius, inward, frequency as u32);
        let exact = 4.0 * std::f64::consts::PI * radius * radius;
        let area: f64 = shape.parts[0]
            .triangles
            .iter()
            .map(|triangle| {
                let [a, b, c] = triangle.map(|vertex| shape.vertices[vertex as usize]);
                0.5 * (b - a).cross(c - a).length()
            })
            .sum();
        warnings.push(format!(
            "{name}: the sphere is approximated by {} inscribed triangles; their area is {:.3} % too small",
            shape.parts[0].triangles.len(),
            100.0 * (1.0 - area / exact)
        ));
        Ok(shape)
    }

    fn claim(&mut self, node: &Node, name: &str) -> Result<(), SceneError> {
        if let Some(first) = self.names.insert(name.to_string(), node.json_path()) {
            return Err(node.refuse_as(
                format!("the surface name {name:?} is given twice"),
                format!("{name:?} again; {first} has it already"),
                "a name that no other geometry or part has",
                "rename one of the two",
            ));
        }
        Ok(())
    }

    /// Number of parts into which each edge of a triangle is cut; `None` for a triangle without an area.
    fn divisions_of(&self, triangle: [u32; 3], longest_edge_m: Option<f64>) -> Option<f64> {
        let [a, b, c] = triangle.map(|vertex| self.vertices_m[vertex as usize]);
        let longest_m = a.distance(b).max(b.distance(c)).max(c.distance(a));
        let twice_area_m2 = (b - a).cross(c - a).length();
        if twice_area_m2 <= SMALLEST_RELATIVE_HEIGHT * longest_m * longest_m {
            return None;
        }
        Some(longest_edge_m.map_or(1.0, |edge_m| (longest_m / edge_m * (1.0 - EDGE_ROUNDING)).ceil().max(1.0)))
    }

    fn push(&mut self, triangle: [u32; 3], divisions: f64, two_sided: bool) {
        self.cells += divisions * divisions * if two_sided { 2.0 } else { 1.0 };
        self.triangles.push(triangle);
        self.divisions.push(divisions as u32);
        self.triangle_surfaces.push(self.surfaces.len() as SurfaceId);
    }
}

fn faces_inward(fields: &Fields) -> Result<bool, SceneError> {
    fields.get("facing").map_or(Ok(false), |node| Ok(FACINGS[node.choice()?] == "inward"))
}

fn read_box(fields: &Fields) -> Result<GeometryShape, SceneError> {
    let min = fields.need("min")?.vector()?;
    let max_node = fields.need("max")?;
    let max = max_node.vector()?;
    for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
        if min[axis] >= max[axis] {
            return Err(max_node.refuse_as(
                format!("the box has no extent along {name}"),
                format!("min {} and max {}", min[axis], max[axis]),
                "each number of \"max\" above the one of \"min\"",
                "swap the two, or use a rectangle for a flat surface",
            ));
        }
    }
    Ok(shapes::cuboid(min, max, faces_inward(fields)?))
}

fn read_rectangle(fields: &Fields, name: &str, warnings: &mut Vec<String>) -> Result<GeometryShape, SceneError> {
    let origin = fields.need("origin")?.vector()?;
    let u = fields.need("u")?.vector()?;
    let v_node = fields.need("v")?;
    let v = v_node.vector()?;
    if !super::vectors::span_a_plane(u, v) {
        let expected = "two vectors that span an area";
        return Err(v_node.refuse_as(
            format!("the rectangle {name:?} has no area"),
            "\"u\" and \"v\" that are parallel or 0",
            expected,
            "correct \"u\" or \"v\"",
        ));
    }
    if !super::vectors::are_perpendicular(u, v) {
        warnings.push(format!("{name}: its sides are not at right angles; it is taken as a parallelogram"));
    }
    Ok(shapes::parallelogram(origin, u, v))
}

fn read_mesh(
    fields: &Fields,
    around: &GeometryContext,
    warnings: &mut Vec<String>,
) -> Result<GeometryShape, SceneError> {
    if let Some(vertices) = given::vertices(fields)? {
        return given::mesh(fields, &vertices);
    }
    let node = fields.need("file")?;
    let path = around.base_dir.join(node.name()?);
    let read = MeshFile::open(&path).and_then(|mut file| file.shape(around.unit, warnings));
    let mut shape = read.map_err(|error| error.named_by(node.as_namer()))?;
    if let Some((count, place)) = weld(&mut shape) {
        warnings.push(format!(
            "{}: {count} vertices along open edges had practically the same position as others and were merged with them (the first at {place} in the file)",
            path.display()
        ));
    }

    // A file without materials is one surface. In a file with materials, the faces before the first one form a part of their own.
    if shape.parts.len() > 1 {
        for part in &mut shape.parts {
            part.name.get_or_insert_with(|| UNNAMED_PART.into());
        }
    }
    Ok(shape)
}

/// Returns the material of every part.
fn part_materials(
    fields: &Fields,
    kind: &str,
    parts: &[Option<&str>],
    around: &GeometryContext,
) -> Result<Vec<MaterialId>, SceneError> {
    let whole = fields.get("material").map(|node| around.material(&node)).transpose()?;
    let mut own: HashMap<&str, MaterialId> = HashMap::new();
    if let Some(node) = fields.get("materials") {
        let mut overrides = node.fields("materials of a geometry")?;
        let known: HashSet<&str> = parts.iter().flatten().copied().collect();
        if kind == "box" {
            overrides = overrides.of(&BOX_MATERIALS)?;
        }
        for entry in overrides.entries() {
            if kind == "mesh" && !known.contains(entry.name) {
                let names = || parts.iter().flatten().copied();
                let what = format!("the mesh has no part {:?}", entry.name);
                return Err(overrides.refuse_key(&entry, what, listed(names()), meant(entry.name, names())));
            }
            own.insert(entry.name, around.material(&entry.value)?);
        }
    }

    // The part's own entry counts first. Then follow the `walls` entry for a box, and the material of the same name for a mesh.
    let of_part = |part: Option<&str>| {
        let by_name = |name: &str| match kind {
            "box" if BOX_FACES[2..].contains(&name) => own.get("walls").copied(),
            "mesh" => around.by_name.get(name).copied(),
            _ => None,
        };
        part.and_then(|name| own.get(name).copied().or_else(|| by_name(name))).or(whole).ok_or_else(|| {
            let (what, remedy) = match part {
                Some(part) if kind == "mesh" => (
                    format!("no material for the mesh's part {part:?}"),
                    format!("add \"materials\": {{ {part:?}: … }}, or a \"material\" for the whole mesh"),
                ),
                Some(part) => (format!("no material for the box's {part}"), "add \"material\": …".into()),
                None => ("a geometry without a material".into(), "add \"material\": …".into()),
            };
            let known = listed(around.materials.iter().map(|material| material.name.as_str()));
            fields.node().refuse(what, format!("\"material\" with one of {known}"), remedy)
        })
    };
    parts.iter().map(|part| of_part(*part)).collect()
}
