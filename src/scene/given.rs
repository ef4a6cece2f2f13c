//! Meshes and points with their numbers in the scene file itself, as programs write them.

use glam::DVec3;

use super::error::SceneError;
use super::limits::{MOST_CORNERS, MOST_MESH_TRIANGLES};
use super::mesh_builder::MeshBuilder;
use super::model::ReceiverPoint;
use super::polygon::triangulate;
use super::reader::{Fields, Node};
use super::shapes::GeometryShape;
use super::units::LengthUnit;
use super::vectors::direction;

/// Count of the numbers of a point: position and normal, without and with its area.
const POINT: [usize; 2] = [6, 7];

/// Refuses a key that has no meaning together with another one.
fn refuse_beside(fields: &Fields, key: &str, other: &str, expected: &str) -> Result<(), SceneError> {
    let Some(node) = fields.get(key) else { return Ok(()) };
    Err(node.refuse_as(
        format!("\"{key}\" has no meaning together with \"{other}\""),
        format!("\"{key}\" and \"{other}\""),
        expected,
        "delete one of them",
    ))
}

/// Returns the vertices of a mesh in the scene file, or `None` for a mesh in a file of its own.
///
/// # Errors
///
/// `"file"` together with `"vertices"`, or `"faces"` without `"vertices"`.
pub(super) fn vertices<'a>(fields: &Fields<'a>) -> Result<Option<Node<'a>>, SceneError> {
    let expected = "either \"file\", or \"vertices\" and \"faces\"";
    let Some(vertices) = fields.get("vertices") else {
        refuse_beside(fields, "faces", "file", expected)?;
        return Ok(None);
    };
    refuse_beside(fields, "file", "vertices", expected)?;
    Ok(Some(vertices))
}

/// Reads a mesh of vertices and faces. The corners of a face run counter-clockwise as seen from its front.
///
/// # Errors
///
/// Vertices that are not three numbers, faces of fewer than three corners or of too many, corners that do not exist, no face at all.
pub(super) fn mesh(fields: &Fields, vertices: &Node) -> Result<GeometryShape, SceneError> {
    let faces_node = fields.need("faces")?;
    let places = vertices.items("vertices")?.iter().map(Node::vector).collect::<Result<Vec<DVec3>, _>>()?;
    let mut mesh = MeshBuilder::default();
    let mut numbers: Vec<Option<u32>> = vec![None; places.len()];
    let mut triangles = Vec::new();
    for face in faces_node.items("faces")? {
        let corner_nodes = face.items("the numbers of vertices")?;
        if !(3..=MOST_CORNERS).contains(&corner_nodes.len()) {
            return Err(face.refuse_as(
                "a face has too few or too many corners",
                format!("{} corners", corner_nodes.len()),
                format!("3 to {MOST_CORNERS} numbers of vertices"),
                "correct the face, or cut it into triangles",
            ));
        }
        let mut corners = Vec::with_capacity(corner_nodes.len());
        for node in &corner_nodes {
            let number = node.number()?;
            let index = number as usize;
            if number < 0.0 || number.fract() != 0.0 || index >= places.len() {
                let expected = format!("a whole number from 0 to {}", places.len().saturating_sub(1));
                return Err(node.refuse(
                    "a face names a vertex that does not exist",
                    expected,
                    "vertices are counted from 0",
                ));
            }
            corners.push(*numbers[index].get_or_insert_with(|| mesh.vertex(places[index])));
        }
        let around: Vec<DVec3> = corners.iter().map(|corner| mesh.place(*corner)).collect();
        triangles.extend(triangulate(&around).into_iter().map(|triangle| triangle.map(|corner| corners[corner])));
        if triangles.len() > MOST_MESH_TRIANGLES {
            let expected = format!("at most {MOST_MESH_TRIANGLES} triangles");
            return Err(faces_node.refuse("the mesh has too many faces", expected, "use a coarser mesh"));
        }
    }
    if triangles.is_empty() {
        return Err(faces_node.refuse("a mesh without a face", "at least one face", "add faces"));
    }
    mesh.add(None, triangles);
    Ok(mesh.finish())
}

/// Returns the points of a receiver set in the scene file, or `None` for points in a file of their own.
///
/// # Errors
///
/// Both forms at once, points that are not six or seven numbers, normals of length 0, areas that are not above 0, no point at all.
pub(super) fn points(fields: &Fields, unit: LengthUnit) -> Result<Option<Vec<ReceiverPoint>>, SceneError> {
    let Some(node) = fields.get("points") else { return Ok(None) };
    refuse_beside(fields, "file", "points", "either \"file\" or \"points\"")?;
    let rows = node.items("points")?;
    if rows.is_empty() {
        return Err(node.refuse("a receiver set without a point", "at least one point", "add [x, y, z, nx, ny, nz]"));
    }
    let columns = rows[0].items("numbers")?.len();
    rows.iter().map(|row| point(row, columns, unit)).collect::<Result<_, _>>().map(Some)
}

fn point(row: &Node, columns: usize, unit: LengthUnit) -> Result<ReceiverPoint, SceneError> {
    let numbers = row.items("numbers")?;
    if numbers.len() != columns || !POINT.contains(&columns) {
        return Err(row.refuse_as(
            "a point has the wrong number of values",
            format!("{} numbers", numbers.len()),
            "[x, y, z, nx, ny, nz], or an area as seventh number at every point",
            "give position and normal of every point",
        ));
    }
    let values = numbers.iter().map(Node::number).collect::<Result<Vec<f64>, _>>()?;
    let normal = direction(DVec3::new(values[3], values[4], values[5]));
    if normal == DVec3::ZERO {
        let expected = "the direction that the point faces";
        return Err(row.refuse_as("a normal of length 0", "0, 0, 0", expected, "give nx, ny, nz"));
    }
    let weight =
        numbers.get(POINT[0]).map_or(Ok(1.0), |node| node.above_zero("an area").map(|area| unit.area_m2(area)))?;
    Ok(ReceiverPoint {
        position_m: unit.point_m(DVec3::new(values[0], values[1], values[2])),
        normal,
        weight,
        inside: false,
    })
}
