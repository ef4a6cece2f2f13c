//! PLY, text and binary: polygons over vertices, without materials.

use std::path::Path;

use glam::DVec3;
use ply_rs_bw::parser::{Parser, Reader};
use ply_rs_bw::ply::{Property, PropertyAccess, PropertyAccessResult};

use super::error::SceneError;
use super::limits::{MOST_CORNERS, MOST_MESH_TRIANGLES};
use super::mesh_builder::{MeshBuilder, refusal};
use super::polygon::triangulate;
use super::shapes::GeometryShape;

/// The properties of a vertex that are read.
pub(super) const PLACES: [&str; 3] = ["x", "y", "z"];
/// The properties of a face that are read. A face has one of them.
pub(super) const CORNERS: [&str; 2] = ["vertex_indices", "vertex_index"];

/// Reads a mesh. Warnings name the ignored parts of the file that matter.
///
/// # Errors
///
/// Files that are damaged or cut short, corners that do not exist or have non-finite coordinates, and files without a face.
pub(super) fn read(path: &Path, bytes: &[u8], warnings: &mut Vec<String>) -> Result<GeometryShape, SceneError> {
    let refuse = |error: &dyn std::fmt::Display| {
        // The parser's message has several lines.
        let got = error.to_string().split_whitespace().collect::<Vec<&str>>().join(" ");
        refusal(
            path,
            "the PLY file is damaged or cut short",
            got,
            "an undamaged PLY file with numbers written as 0.5 or 5e-1",
        )
    };
    let mut reader = Reader::new(bytes);
    let header = Parser::<Passed>::new().read_header(&mut reader).map_err(|error| refuse(&error))?;
    let mut vertices: Vec<PlyVertex> = Vec::new();
    let mut faces: Vec<PlyFace> = Vec::new();
    for element in header.elements.values() {
        // Every element takes at least one byte, so no header can request more than the file has.
        let most = bytes.len().min(MOST_MESH_TRIANGLES);
        if element.count > most || (element.properties.is_empty() && element.count > 0) {
            let got = format!("{} of {:?} with {} properties", element.count, element.name, element.properties.len());
            let expected = format!("at most {most} elements, each with a property");
            return Err(refusal(path, "the PLY header announces more elements than the file can hold", got, &expected));
        }
        match element.name.as_str() {
            "vertex" => {
                let read = Parser::new().read_payload_for_element(&mut reader, element, &header);
                vertices = read.map_err(|error| refuse(&error))?;
            }
            "face" => {
                let read = Parser::new().read_payload_for_element(&mut reader, element, &header);
                faces = read.map_err(|error| refuse(&error))?;
            }
            other => {
                let read = Parser::<Passed>::new().read_payload_for_element(&mut reader, element, &header);
                read.map_err(|error| refuse(&error))?;
                warnings.push(format!("{}: {} elements {other:?} were skipped", path.display(), element.count));
            }
        }
    }
    let mut mesh = MeshBuilder::default();
    let mut numbers: Vec<Option<u32>> = vec![None; vertices.len()];
    let mut triangles = Vec::new();
    for (number, face) in faces.iter().enumerate() {
        let refuse = |what: &str, got: String, expected: &str| {
            refusal(path, format!("face {number} of the PLY file {what}"), got, expected)
        };
        if !(3..=MOST_CORNERS).contains(&face.corners.len()) {
            let expected = format!("3 to {MOST_CORNERS} corners in \"vertex_indices\"");
            return Err(refuse(
                "has too few or too many corners",
                format!("{} corners", face.corners.len()),
                &expected,
            ));
        }
        let mut corners = Vec::with_capacity(face.corners.len());
        for corner in &face.corners {
            let index = usize::try_from(*corner).ok().filter(|index| *index < vertices.len());
            let Some(index) = index else {
                let expected = format!("an index below {}", vertices.len());
                return Err(refuse("names a vertex that does not exist", corner.to_string(), &expected));
            };
            let place = vertices[index].place;
            if !place.is_finite() {
                return Err(refuse(
                    "has a corner without a finite position",
                    place.to_string(),
                    "x, y and z of every vertex",
                ));
            }
            corners.push(*numbers[index].get_or_insert_with(|| mesh.vertex(place)));
        }
        let places: Vec<DVec3> = corners.iter().map(|corner| mesh.place(*corner)).collect();
        triangles.extend(triangulate(&places).into_iter().map(|triangle| triangle.map(|corner| corners[corner])));
    }
    if triangles.is_empty() {
        let got = format!("{} vertices, no face", vertices.len());
        return Err(refusal(path, "a mesh without a face", got, "a PLY file with faces, not a cloud of points"));
    }
    mesh.add(None, triangles);
    Ok(mesh.finish())
}

/// An element that is ignored.
struct Passed;

impl PropertyAccess for Passed {
    fn new() -> Passed {
        Passed
    }
}

/// A position; not a number where the file gives no coordinate.
struct PlyVertex {
    place: DVec3,
}

impl PropertyAccess for PlyVertex {
    fn new() -> PlyVertex {
        PlyVertex { place: DVec3::NAN }
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        let Some(axis) = PLACES.iter().position(|place| *place == name) else {
            return PropertyAccessResult::Ignored;
        };
        self.place[axis] = match property {
            Property::Char(number) => f64::from(number),
            Property::UChar(number) => f64::from(number),
            Property::Short(number) => f64::from(number),
            Property::UShort(number) => f64::from(number),
            Property::Int(number) => f64::from(number),
            Property::UInt(number) => f64::from(number),
            Property::Float(number) => f64::from(number),
            Property::Double(number) => number,
            _ => return PropertyAccessResult::UnsupportedType,
        };
        PropertyAccessResult::Set
    }
}

/// The vertices of a polygon.
struct PlyFace {
    corners: Vec<i64>,
}

impl PropertyAccess for PlyFace {
    fn new() -> PlyFace {
        PlyFace { corners: Vec::new() }
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        if !CORNERS.contains(&name) {
            return PropertyAccessResult::Ignored;
        }
        self.corners = match property {
            Property::ListChar(list) => list.into_iter().map(i64::from).collect(),
            Property::ListUChar(list) => list.into_iter().map(i64::from).collect(),
            Property::ListShort(list) => list.into_iter().map(i64::from).collect(),
            Property::ListUShort(list) => list.into_iter().map(i64::from).collect(),
            Property::ListInt(list) => list.into_iter().map(i64::from).collect(),
            Property::ListUInt(list) => list.into_iter().map(i64::from).collect(),
            _ => return PropertyAccessResult::UnsupportedType,
        };
        PropertyAccessResult::Set
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const HEAD: &str = "element vertex 4\nproperty float x\nproperty float y\nproperty float z\nproperty uchar red\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n";

    fn text(vertices: &str, face: &str) -> Vec<u8> {
        format!("ply\nformat ascii 1.0\ncomment made by hand\n{HEAD}{vertices}{face}\n").into_bytes()
    }

    const SQUARE: &str = "0 0 0 255\n2 0 0 255\n2 1 0 255\n0 1 0 255\n";

    fn binary(big: bool) -> Vec<u8> {
        let order = if big { "big" } else { "little" };
        let mut bytes = format!("ply\nformat binary_{order}_endian 1.0\n{HEAD}").into_bytes();
        for place in [[0.0_f32, 0.0, 0.0], [2.0, 0.0, 0.0], [2.0, 1.0, 0.0], [0.0, 1.0, 0.0]] {
            place.iter().for_each(|number| bytes.extend(if big { number.to_be_bytes() } else { number.to_le_bytes() }));
            bytes.push(255);
        }
        bytes.push(4);
        (0..4_i32).for_each(|index| bytes.extend(if big { index.to_be_bytes() } else { index.to_le_bytes() }));
        bytes
    }

    fn read_bytes(bytes: &[u8]) -> Result<GeometryShape, SceneError> {
        read(Path::new("test.ply"), bytes, &mut Vec::new())
    }

    #[test]
    fn text_and_binary_are_the_same_mesh() {
        let places = [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [2.0, 1.0, 0.0], [0.0, 1.0, 0.0]].map(DVec3::from);
        for bytes in [text(SQUARE, "4 0 1 2 3"), binary(false), binary(true)] {
            let shape = read_bytes(&bytes).expect("valid");
            assert_eq!(shape.vertices, places);
            assert_eq!(shape.parts[0].triangles.len(), 2);
            for triangle in &shape.parts[0].triangles {
                let [a, b, c] = triangle.map(|vertex| shape.vertices[vertex as usize]);
                assert!((b - a).cross(c - a).z > 0.0, "a front faces down");
            }
        }
    }

    #[test]
    fn files_cut_short_are_refused() {
        let whole = binary(false);
        for length in 0..whole.len() {
            assert!(read_bytes(&whole[..length]).is_err(), "{length} bytes were read");
        }
    }

    #[test]
    fn hostile_files_are_refused() {
        for (face, says) in [
            ("4 0 1 2 4", "does not exist"),
            ("4 0 1 2 -1", "does not exist"),
            ("2 0 1", "too few or too many"),
            ("0", "too few or too many"),
        ] {
            let error = read_bytes(&text(SQUARE, face)).expect_err(face).to_string();
            assert!(error.contains(says), "{face}: {error}");
        }
        for wrong in ["nan", "inf", "1e999", "x"] {
            assert!(read_bytes(&text(&SQUARE.replacen('2', wrong, 1), "4 0 1 2 3")).is_err(), "{wrong} was read");
        }
        let sound = String::from_utf8(text(SQUARE, "4 0 1 2 3")).expect("text");
        for (old, new) in [
            ("element vertex 4", "element vertex 4000000000"),
            ("element face 1", "element face 18446744073709551615"),
            ("element face 1", "element nothing 4000000000\nelement face 1"),
            ("property float z\n", ""),
            ("element face 1\nproperty list uchar int vertex_indices\n", ""),
            ("format ascii 1.0", "format binary_little_endian 1.0"),
        ] {
            assert!(read_bytes(sound.replace(old, new).as_bytes()).is_err(), "{new} was read");
        }
    }
}
