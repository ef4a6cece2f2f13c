//! STL, binary and text: triangles without materials. Every solid with a name is a part.

use std::io::Cursor;
use std::path::Path;

use glam::DVec3;

use super::error::SceneError;
use super::limits::MOST_MESH_TRIANGLES;
use super::mesh_builder::{MeshBuilder, refusal};
use super::parse;
use super::shapes::GeometryShape;

/// Number of bytes of a binary file before its triangles. The last four of them hold the number of triangles.
const HEADER_BYTES: usize = 84;
/// Number of bytes of a triangle: its normal, three corners, and two bytes in which some programs write a colour.
const TRIANGLE_BYTES: usize = 50;
/// First word of text files. Some programs write it at the beginning of binary files too.
const SOLID: &str = "solid";

/// Reads a mesh. The function overwrites the first byte of a binary file.
///
/// # Errors
///
/// Files that are damaged or cut short, corners with non-finite coordinates, and files without a triangle.
pub(super) fn read(path: &Path, bytes: &mut [u8], warnings: &mut Vec<String>) -> Result<GeometryShape, SceneError> {
    let mut mesh = MeshBuilder::default();
    let said = triangles_said(bytes);
    let needed = said.map(bytes_needed);
    if is_binary(bytes) {
        let Some(needed) = needed.filter(|needed| *needed <= bytes.len() as u64) else {
            let expected = match needed {
                Some(needed) => {
                    format!("{needed} bytes for {} triangles, as its header says", said.unwrap_or_default())
                }
                None => format!("\"{SOLID}\", or a header of {HEADER_BYTES} bytes"),
            };
            let what = "the STL file is cut short, or it is not an STL file";
            return Err(refusal(path, what, format!("{} bytes", bytes.len()), &expected));
        };
        if needed < bytes.len() as u64 {
            let beyond = bytes.len() as u64 - needed;
            warnings.push(format!("{}: {beyond} bytes behind the last triangle were skipped", path.display()));
        }
        // The file is binary. A blank hides the word of text files at its beginning.
        bytes[0] = b' ';
        add_solid(path, &mut mesh, None, bytes)?;
    } else {
        let text = parse::text_of(bytes, path, "the STL file")?;
        for solid in solids(text) {
            let (first, rest) = solid.split_once('\n').unwrap_or((solid, ""));
            let name = first.trim()[SOLID.len()..].trim();
            let whole = format!("{SOLID} \n{rest}");
            add_solid(path, &mut mesh, Some(name).filter(|name| !name.is_empty()), whole.as_bytes())?;
        }
    }
    let shape = mesh.finish();
    if shape.parts.is_empty() {
        return Err(refusal(path, "a mesh without a triangle", "no triangle", "an STL file with triangles"));
    }
    Ok(shape)
}

/// Whether a file is binary: it has the length that its header gives, or does not begin with the word of text files.
fn is_binary(bytes: &[u8]) -> bool {
    let is_as_long = triangles_said(bytes).map(bytes_needed) == Some(bytes.len() as u64);
    is_as_long || !bytes.trim_ascii_start().starts_with(SOLID.as_bytes())
}

/// Number of triangles in the header of a binary file; `None` without a complete header.
fn triangles_said(bytes: &[u8]) -> Option<u32> {
    bytes.get(HEADER_BYTES - 4..HEADER_BYTES).and_then(|count| count.try_into().ok()).map(u32::from_le_bytes)
}

/// Number of bytes of a binary file with `triangles` triangles.
fn bytes_needed(triangles: u32) -> u64 {
    HEADER_BYTES as u64 + TRIANGLE_BYTES as u64 * u64::from(triangles)
}

/// The last two bytes of each triangle of a binary file; none for a text file.
pub(super) fn bytes_behind_triangles(bytes: &[u8]) -> impl Iterator<Item = [u8; 2]> {
    let triangles = if is_binary(bytes) { bytes.get(HEADER_BYTES..).unwrap_or_default() } else { &[] };
    triangles.chunks_exact(TRIANGLE_BYTES).map(|triangle| [triangle[TRIANGLE_BYTES - 2], triangle[TRIANGLE_BYTES - 1]])
}

/// The solids of a text, each with its first line.
fn solids(text: &str) -> impl Iterator<Item = &str> {
    let mut rest = text.trim_start();
    std::iter::from_fn(move || {
        if rest.is_empty() {
            return None;
        }
        let mut end = 0;
        for line in rest.split_inclusive('\n') {
            if end > 0 && line.trim_start().starts_with(SOLID) {
                break;
            }
            end += line.len();
        }
        let (solid, others) = rest.split_at(end);
        rest = others.trim_start();
        Some(solid)
    })
}

fn add_solid(path: &Path, mesh: &mut MeshBuilder, part: Option<&str>, bytes: &[u8]) -> Result<(), SceneError> {
    let of = part.map(|part| format!(" of solid {part:?}")).unwrap_or_default();
    let refuse = |number: usize, got: String| {
        let expected = "facets of three corners, each of three finite numbers";
        refusal(path, format!("triangle {number}{of} of the STL file cannot be read"), got, expected)
    };
    let mut bytes = Cursor::new(bytes);
    let triangles = stl_io::create_stl_reader(&mut bytes).map_err(|error| refuse(1, error.to_string()))?;
    let mut read = Vec::new();
    for (number, triangle) in (1..).zip(triangles) {
        let triangle = triangle.map_err(|error| refuse(number, error.to_string()))?;
        let corners = triangle.vertices.map(|corner| DVec3::from(corner.0.map(f64::from)));
        if let Some(corner) = corners.iter().find(|corner| !corner.is_finite()) {
            return Err(refuse(number, format!("a corner at {corner}")));
        }
        read.push(corners.map(|corner| mesh.vertex(corner)));
        if mesh.size().max(read.len()) > MOST_MESH_TRIANGLES {
            return Err(refuse(number, format!("more than {MOST_MESH_TRIANGLES} triangles")));
        }
    }
    if !read.is_empty() {
        mesh.add(part, read);
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn binary(header: &str, triangles: &[[[f32; 3]; 3]]) -> Vec<u8> {
        let mut bytes = header.as_bytes().to_vec();
        bytes.resize(80, 0);
        bytes.extend((triangles.len() as u32).to_le_bytes());
        for triangle in triangles {
            bytes.extend([0; 12]);
            triangle.iter().flatten().for_each(|number| bytes.extend(number.to_le_bytes()));
            bytes.extend([0; 2]);
        }
        bytes
    }

    const SQUARE: [[[f32; 3]; 3]; 2] =
        [[[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [2.0, 1.0, 0.0]], [[0.0, 0.0, 0.0], [2.0, 1.0, 0.0], [0.0, 1.0, 0.0]]];

    fn text(name: &str) -> String {
        let facets: String = SQUARE
            .iter()
            .map(|corners| {
                let lines: String = corners.iter().map(|[x, y, z]| format!("vertex {x} {y} {z}\n")).collect();
                format!("facet normal 0 0 1\nouter loop\n{lines}endloop\nendfacet\n")
            })
            .collect();
        format!("solid {name}\n{facets}endsolid {name}\n")
    }

    fn read_bytes(bytes: &[u8]) -> Result<GeometryShape, SceneError> {
        read(Path::new("test.stl"), &mut bytes.to_vec(), &mut Vec::new())
    }

    #[test]
    fn binary_and_text_are_the_same_mesh() {
        let of_text = read_bytes(text("").as_bytes()).expect("text");
        for header in ["", "solid of a program that writes this in binary files too"] {
            let shape = read_bytes(&binary(header, &SQUARE)).expect("binary");
            assert_eq!(shape.vertices, of_text.vertices);
            assert_eq!(shape.parts[0].triangles, [[0, 1, 2], [0, 2, 3]]);
            assert_eq!(shape.parts[0].name, None);
        }
    }

    #[test]
    fn solids_of_a_text_are_parts() {
        let shape = read_bytes(format!("{}\n{}", text("desk"), text("lid of it")).as_bytes()).expect("two solids");
        let names: Vec<_> = shape.parts.iter().map(|part| (part.name.as_deref(), part.triangles.len())).collect();
        assert_eq!(names, [(Some("desk"), 2), (Some("lid of it"), 2)]);
    }

    #[test]
    fn files_cut_short_and_wrong_numbers_are_refused() {
        let whole = binary("", &SQUARE);
        for length in 0..whole.len() {
            assert!(read_bytes(&whole[..length]).is_err(), "{length} bytes were read");
        }
        let mut many = whole.clone();
        many[80..84].copy_from_slice(&u32::MAX.to_le_bytes());
        assert!(read_bytes(&many).expect_err("too many").to_string().contains("4294967295 triangles"));
        assert!(read_bytes(&binary("", &[])).expect_err("none").to_string().contains("without a triangle"));
        for wrong in [f32::NAN, f32::NEG_INFINITY] {
            let mut triangles = SQUARE;
            triangles[1][2][0] = wrong;
            let error = read_bytes(&binary("", &triangles)).expect_err("no finite place").to_string();
            assert!(error.contains("triangle 2"), "{error}");
        }
        let sound = text("a");
        let end = sound.rfind("endsolid").expect("it ends");
        for broken in [&sound[..end], &sound[..end / 2], "solid a\n", "solid a\nfacet normal 0 0\n"] {
            assert!(read_bytes(broken.as_bytes()).is_err(), "{broken}");
        }
        assert!(read_bytes(sound.replace("vertex 2 1 0", "vertex 2 nan 0").as_bytes()).is_err());
    }
}
