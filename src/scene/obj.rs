//! Wavefront OBJ: vertices and polygons, in parts by `usemtl`.
//!
//! The reader ignores what concerns only appearance (`vt`, `vn`, `mtllib`, smoothing, groups). The order of the corners gives the front of a
//! face. The scene file gives its material.

use std::ops::Range;

use glam::DVec3;

use super::error::SceneError;
use super::limits::MOST_CORNERS;
use super::mesh_builder::MeshBuilder;
use super::polygon::triangulate;
use super::reader::{Source, shortened};
use super::shapes::GeometryShape;
use super::under_way;

/// Statements that do not describe the surfaces of the shape.
pub(super) const PASSED_OVER: [&str; 10] = ["vt", "vn", "vp", "o", "g", "s", MATERIALS_FILE, "usemap", "maplib", "lod"];
/// The statement that names a file of materials. Such files are not read.
pub(super) const MATERIALS_FILE: &str = "mtllib";
/// Statements of shapes without an area.
const WITHOUT_AREA: [&str; 2] = ["l", "p"];

/// Reads a mesh. Warnings name the ignored parts of the file that matter.
///
/// # Errors
///
/// Malformed vertices and faces, corners that do not exist, and files without a face. The errors give their positions.
pub(super) fn read(source: &Source, warnings: &mut Vec<String>) -> Result<GeometryShape, SceneError> {
    let mut reader = ObjReader { source, vertices: Vec::new(), mesh: MeshBuilder::default(), part: None };
    let mut strange: Vec<(usize, &str)> = Vec::new();
    let mut lines = StatementWords { text: source.text, next: 0, line: 0 };
    let name = source.path.file_name().unwrap_or_default().to_string_lossy();
    under_way::begin(name, source.text.len());
    while let Some(words) = lines.statement() {
        under_way::reached(lines.next);
        let Some((keyword, arguments)) = words.split_first() else { continue };
        let numbers = || arguments.split(|word| source.text[word.clone()].starts_with('#')).next().unwrap_or_default();
        match &source.text[keyword.clone()] {
            "v" => reader.vertex(keyword, numbers())?,
            "f" => reader.face(keyword, numbers())?,
            "usemtl" => reader.use_material(keyword, arguments)?,
            word if word.starts_with('#') || PASSED_OVER.contains(&word) => {}
            word => strange.push((lines.line, word)),
        }
    }
    if let Some((line, word)) = strange.first() {
        let reason = if WITHOUT_AREA.contains(word) { "lines and points have no area" } else { "unknown" };
        warnings.push(format!(
            "{}: {} statements were skipped, first \"{}\" in line {line} ({reason})",
            source.path.display(),
            strange.len(),
            shortened(word)
        ));
    }
    let shape = reader.mesh.finish();
    if shape.parts.is_empty() {
        return Err(source.refuse(
            0..1,
            "",
            "a mesh without a face",
            format!("{} vertices, no face", reader.vertices.len()),
            "a Wavefront OBJ file with lines such as \"f 1 2 3\"",
            "export polygons as OBJ",
        ));
    }
    Ok(shape)
}

struct ObjReader<'a> {
    source: &'a Source<'a>,
    /// For every vertex of the file, its number in the shape. Exactly coincident vertices share one number.
    vertices: Vec<u32>,
    mesh: MeshBuilder,
    part: Option<String>,
}

impl ObjReader<'_> {
    fn refuse(&self, range: &Range<usize>, what: &str, expected: &str, remedy: &str) -> SceneError {
        let got = format!("{:?}", shortened(&self.source.text[range.clone()]));
        self.source.refuse(range.clone(), "", what, got, expected, remedy)
    }

    fn vertex(&mut self, keyword: &Range<usize>, arguments: &[Range<usize>]) -> Result<(), SceneError> {
        if arguments.len() < 3 {
            let line = keyword.start..arguments.last().unwrap_or(keyword).end;
            return Err(self.refuse(&line, "a vertex needs three coordinates", "v x y z", "complete the line"));
        }
        let mut point = DVec3::ZERO;
        for axis in 0..3 {
            point[axis] = match self.source.text[arguments[axis].clone()].parse::<f64>() {
                Ok(value) if value.is_finite() => value,
                _ => {
                    return Err(self.refuse(
                        &arguments[axis],
                        "a coordinate is not a finite number",
                        "a number",
                        "correct it",
                    ));
                }
            };
        }
        let number = self.mesh.vertex(point);
        self.vertices.push(number);
        Ok(())
    }

    fn face(&mut self, keyword: &Range<usize>, arguments: &[Range<usize>]) -> Result<(), SceneError> {
        if arguments.len() < 3 {
            let line = keyword.start..arguments.last().unwrap_or(keyword).end;
            return Err(self.refuse(&line, "a face needs three corners", "f a b c …", "complete the line"));
        }
        if arguments.len() > MOST_CORNERS {
            let line = keyword.start..arguments.last().unwrap_or(keyword).end;
            let expected = format!("at most {MOST_CORNERS} corners");
            return Err(self.refuse(
                &line,
                "a face has too many corners",
                &expected,
                "split it in the program that made it",
            ));
        }
        let numbers = arguments.iter().map(|corner| self.corner(corner)).collect::<Result<Vec<u32>, _>>()?;
        let points: Vec<DVec3> = numbers.iter().map(|number| self.mesh.place(*number)).collect();
        let triangles = triangulate(&points).into_iter().map(|triangle| triangle.map(|corner| numbers[corner]));
        self.mesh.add(self.part.as_deref(), triangles);
        Ok(())
    }

    /// Returns the vertex of `7`, `7/1`, `7//3` or `7/1/3`. Negative numbers count back from the last vertex so far.
    fn corner(&self, range: &Range<usize>) -> Result<u32, SceneError> {
        let text = &self.source.text[range.clone()];
        let mut numbers = text.split('/');
        let vertex = numbers.next().and_then(|number| number.parse::<i64>().ok());
        let rest_is_numbers =
            numbers.clone().count() <= 2 && numbers.all(|number| number.is_empty() || number.parse::<i64>().is_ok());
        let (Some(vertex), true) = (vertex, rest_is_numbers) else {
            return Err(self.refuse(
                range,
                "a face's corner is not a vertex number",
                "7, 7/1, 7//3 or 7/1/3",
                "correct it",
            ));
        };
        let known = self.vertices.len() as i64;
        let index = if vertex > 0 { vertex - 1 } else { known.saturating_add(vertex) };
        if vertex == 0 || index < 0 || index >= known {
            let expected = format!("a number from 1 to {known}, or -1 to -{known}: the vertices so far");
            return Err(self.refuse(
                range,
                "a face names a vertex that does not exist",
                &expected,
                "correct the number; numbers begin at 1",
            ));
        }
        Ok(self.vertices[index as usize])
    }

    fn use_material(&mut self, keyword: &Range<usize>, arguments: &[Range<usize>]) -> Result<(), SceneError> {
        let (Some(first), Some(last)) = (arguments.first(), arguments.last()) else {
            return Err(self.refuse(keyword, "usemtl without a name", "usemtl NAME", "complete the line"));
        };
        self.part = Some(self.source.text[first.start..last.end].to_string());
        Ok(())
    }
}

/// Statements of a text: words between white space. A backslash at the end of a line joins the next line.
struct StatementWords<'t> {
    text: &'t str,
    next: usize,
    line: usize,
}

impl StatementWords<'_> {
    fn statement(&mut self) -> Option<Vec<Range<usize>>> {
        let mut words = Vec::new();
        let mut joined = true;
        if self.next >= self.text.len() {
            return None;
        }
        while joined && self.next < self.text.len() {
            let start = self.next;
            let end = self.text[start..].find('\n').map_or(self.text.len(), |newline| start + newline);
            self.next = end + 1;
            self.line += 1;
            let line = self.text[start..end].trim_end();
            joined = line.ends_with('\\');
            let line = line.strip_suffix('\\').unwrap_or(line);
            words.extend(line.split_whitespace().map(|word| {
                let offset = word.as_ptr() as usize - self.text.as_ptr() as usize;
                offset..offset + word.len()
            }));
        }
        Some(words)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    fn read_text(text: &str) -> Result<(GeometryShape, Vec<String>), SceneError> {
        let mut warnings = Vec::new();
        let shape = read(&Source { text, path: Path::new("test.obj") }, &mut warnings)?;
        Ok((shape, warnings))
    }

    #[test]
    fn all_ways_to_name_a_corner_mean_the_same_vertex() {
        let vertices = "v 0 0 0\nv 1 0 0\nv 1 1 0\nvt 0 0\nvn 0 0 1\n";
        for face in
            ["f 1 2 3", "f 1/1 2/1 3/1", "f 1//1 2//1 3//1", "f 1/1/1 2/1/1 3/1/1", "f -3 -2 -1", "f 1 2 \\\n 3"]
        {
            let (shape, warnings) = read_text(&format!("{vertices}{face}\n")).expect(face);
            assert_eq!(shape.parts[0].triangles, [[0, 1, 2]], "{face}");
            assert!(warnings.is_empty());
        }
    }

    #[test]
    fn parts_follow_usemtl_and_not_groups() {
        let (shape, _) = read_text(
            "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3\nusemtl Light oak\ng top\nf 1 2 3 4\nusemtl steel\nf 1 3 4\no x\nusemtl Light oak\nf 2 3 4\n",
        )
        .expect("a valid file");
        let names: Vec<_> = shape.parts.iter().map(|part| (part.name.as_deref(), part.triangles.len())).collect();
        assert_eq!(names, [(None, 1), (Some("Light oak"), 3), (Some("steel"), 1)]);
    }

    #[test]
    fn vertices_that_coincide_exactly_are_one_and_no_others() {
        let (shape, _) =
            read_text("v 0 0 0\nv 1 0 0\nv 1 1 0\nv -0 0 0\nv 1 1 1e-300\nf 1 2 3\nf 4 2 5").expect("valid");
        assert_eq!(shape.vertices.len(), 4);
        assert_eq!(shape.parts[0].triangles, [[0, 1, 2], [0, 1, 3]]);
    }

    #[test]
    fn faults_are_named_with_line_and_column() {
        for (text, line, column) in [
            ("v 0 0\n", 1, 1),
            ("v 0 0 0\nv 0 x 0\n", 2, 5),
            ("v 0 0 inf\n", 1, 7),
            ("v 0 0 0\nf 1 1 2\n", 2, 7),
            ("v 0 0 0\nf 1 0 1\n", 2, 5),
            ("v 0 0 0\nf 1 1/a 1\n", 2, 5),
            ("v 0 0 0\nf 1 -9223372036854775808 1\n", 2, 5),
            ("v 0 0 0\nf 1 1\n", 2, 1),
            ("usemtl\n", 1, 1),
            ("", 1, 1),
        ] {
            let error = read_text(text).expect_err(text);
            let place = error.place.as_ref().expect("a place");
            assert_eq!((place.line, place.column), (line, column), "{error}");
        }
    }

    #[test]
    fn what_is_passed_over_and_matters_is_said() {
        let (_, warnings) = read_text("v 0 0 0\nv 1 0 0\nv 1 1 0\nl 1 2\nf 1 2 3\n").expect("valid");
        assert!(warnings.len() == 1 && warnings[0].contains("line 4"), "{warnings:?}");
    }
}
