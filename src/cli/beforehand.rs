//! Estimates the time that a scene takes whatever is computed: reading, checking, making it ready for rays, and writing. The user
//! gets a warning before the work if a time limit is shorter.

use std::fs::{metadata, read};
use std::path::Path;

use serde::Deserialize;
use serde::de::IgnoredAny;

use super::kept_back::Work;
use super::number_text::time;
use super::patience::latest_s;

/// Seconds of one core of about 2 GHz: first for reading and checking, then for the rest (making ready, a first error check and
/// writing). Measured on 100,000 rectangles and on a million luminaires, of one array and of one entry each. Also measured on
/// meshes of 0.5 to 5.8 million triangles, on a million points, and on photometric files of 8 to 55 MB (`docs/performance.md`).
type Seconds = [f64; 2];
const A_LUMINAIRE: Seconds = [4.5e-6, 4e-6];
const A_GEOMETRY: Seconds = [32e-6, 35e-6];
const A_TRIANGLE_OF_A_MESH: Seconds = [2.7e-6, 4e-6];
const A_BYTE_OF_TEXT: Seconds = [40e-9, 0.0];
const A_POINT: Seconds = [0.2e-6, 0.0];
/// Seconds of one core for the work after computing (judging, tables, a model and the page): for one element side, one point and
/// one receiver set whose map is computed.
const AN_ELEMENT_S: f64 = 14e-6;
const A_POINT_S: f64 = 8e-6;
const A_SET_S: f64 = 120e-6;

/// Reading that is expected to take longer than this, in s, shows how fast the machine is.
const TELLING_S: f64 = 0.1;

/// Bytes of a file for each triangle of a closed mesh, by the file's extension.
const BYTES_OF_A_TRIANGLE: [(&str, f64); 4] = [("gltf", 18.0), ("glb", 18.0), ("ply", 19.0), ("stl", 50.0)];
const BYTES_OF_AN_OBJ_TRIANGLE: f64 = 36.0;

/// Largest numbers of luminaires and of points that a scene may have.
const MOST_LUMINAIRES: f64 = 1e6;
const MOST_POINTS: f64 = 4e6;

/// The parts of a scene file from which the size of the scene is estimated.
#[derive(Deserialize)]
struct Outline {
    #[serde(default)]
    geometry: Vec<Geometry>,
    #[serde(default)]
    luminaires: Vec<ArrayPlaces>,
    #[serde(default)]
    receivers: Vec<ArrayPlaces>,
}

#[derive(Deserialize)]
struct Geometry {
    file: Option<String>,
    #[serde(default)]
    two_sided: bool,
}

#[derive(Deserialize)]
struct ArrayPlaces {
    file: Option<String>,
    #[serde(default = "one")]
    columns: f64,
    #[serde(default = "one")]
    rows: f64,
    #[serde(rename = "type")]
    _kind: Option<IgnoredAny>,
}

impl ArrayPlaces {
    fn len(&self, most: f64) -> f64 {
        (self.columns * self.rows).clamp(0.0, most)
    }
}

fn one() -> f64 {
    1.0
}

/// The kinds of maps that are computed.
#[derive(Clone, Copy)]
pub struct Kinds {
    elements: bool,
    receivers: bool,
}

impl Kinds {
    /// The kinds of maps that `--maps` names.
    pub fn of(maps: Option<&str>) -> Kinds {
        match maps {
            None | Some("all") => Kinds { elements: true, receivers: true },
            Some(maps) => Kinds {
                elements: maps.split(',').any(|name| name.trim() == "elements"),
                receivers: maps.trim() != "elements",
            },
        }
    }
}

/// Estimated work of a scene, from its file and from the sizes of the files that it names.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Beforehand {
    reading_s: f64,
    readying_s: f64,
    /// Element sides, points and receiver sets whose maps are computed.
    sides: f64,
    points: f64,
    sets: f64,
}

impl Beforehand {
    /// Estimates the work of a scene file. Returns `None` if the file cannot be read as a scene; the reader reports that later.
    pub fn of(scene: &Path, kinds: Kinds) -> Option<Beforehand> {
        // The reader refuses a device or a pipe.
        metadata(scene).ok().filter(|data| data.is_file())?;
        let bytes = read(scene).ok()?;
        let outline: Outline = serde_json::from_slice(&bytes).ok()?;
        let folder = scene.parent().unwrap_or(Path::new(""));
        let size = |file: &str| metadata(folder.join(file)).map_or(0.0, |data| data.len() as f64);
        let meshes = outline.geometry.iter().filter_map(|geometry| Some((geometry, geometry.file.as_ref()?)));
        let (mut triangles, mut sides) = (0.0, outline.geometry.len() as f64);
        for (geometry, file) in meshes {
            let count = size(file) / bytes_of_a_triangle(file);
            triangles += count;
            sides += if geometry.two_sided { 2.0 * count } else { count };
        }
        // The reader refuses larger counts. A photometric file that several luminaires share is read once.
        let luminaires = outline.luminaires.iter().map(|array| array.len(MOST_LUMINAIRES)).sum::<f64>();
        let points = outline.receivers.iter().map(|array| array.len(MOST_POINTS)).sum::<f64>();
        let mut tables: Vec<&String> =
            outline.luminaires.iter().chain(&outline.receivers).filter_map(|array| array.file.as_ref()).collect();
        tables.sort();
        tables.dedup();
        let text = bytes.len() as f64 + tables.iter().map(|file| size(file)).sum::<f64>();
        let parts: [(f64, Seconds); 5] = [
            (luminaires.min(MOST_LUMINAIRES), A_LUMINAIRE),
            (outline.geometry.len() as f64, A_GEOMETRY),
            (triangles, A_TRIANGLE_OF_A_MESH),
            (text, A_BYTE_OF_TEXT),
            (points.min(MOST_POINTS), A_POINT),
        ];
        let [reading_s, readying_s] =
            [0, 1].map(|part| parts.iter().map(|(count, seconds)| count * seconds[part]).sum());
        let of_receivers = |count: f64| if kinds.receivers { count } else { 0.0 };
        Some(Beforehand {
            reading_s,
            readying_s,
            sides: if kinds.elements { sides } else { 0.0 },
            points: of_receivers(points.min(MOST_POINTS)),
            sets: of_receivers(outline.receivers.len() as f64),
        })
    }

    /// The same estimate with the true number of element sides, which is known once the scene is read. A file alone does not show
    /// how finely a surface is divided.
    pub fn with_sides(self, sides: usize) -> Beforehand {
        Beforehand { sides: sides as f64, ..self }
    }

    /// The work of the run besides reading and computing, without the number of files.
    pub fn work(&self) -> Work {
        Work { readying_s: self.readying_s, ending_s: self.ending_s(), files: 0 }
    }

    /// Seconds of one core for the work after computing.
    fn ending_s(&self) -> f64 {
        self.sides * AN_ELEMENT_S + self.points * A_POINT_S + self.sets * A_SET_S
    }

    /// The same, with making ready before it.
    fn rest_s(&self) -> f64 {
        self.readying_s + self.ending_s()
    }

    /// The warning before reading, if the time limit is shorter than the estimated total.
    pub fn line(&self, limit_s: f64) -> Option<String> {
        let comes_to = match self.reading_s {
            reading_s if reading_s > latest_s(limit_s) => "ends the run during reading, and nothing will be written",
            _ => "is exceeded, which leaves time for a first result only",
        };
        (self.reading_s + self.rest_s() > limit_s).then(|| {
            format!(
                "warning: reading this scene takes about {} on a typical core; writing, and preparation for \
                 rays, take about {} more, whatever is computed: the time limit of {} {comes_to}",
                time(self.reading_s),
                time(self.rest_s()),
                time(limit_s)
            )
        })
    }

    /// Seconds of one core: for reading and checking, and for the rest.
    pub fn seconds(&self) -> [f64; 2] {
        [self.reading_s, self.rest_s()]
    }

    /// How many times longer the work takes here than on a usual core, from the measured time of reading. If reading is too short
    /// to show the speed of the machine, `trial` measures it.
    pub fn slowness(&self, read_s: f64, trial: impl FnOnce() -> f64) -> f64 {
        if self.reading_s > TELLING_S { read_s / self.reading_s } else { trial() }
    }
}

fn bytes_of_a_triangle(file: &str) -> f64 {
    let ending = Path::new(file).extension().map(|ending| ending.to_string_lossy().to_lowercase()).unwrap_or_default();
    let known = BYTES_OF_A_TRIANGLE.iter().find(|(name, _)| *name == ending);
    known.map_or(BYTES_OF_AN_OBJ_TRIANGLE, |(_, bytes)| *bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    const ALL: Kinds = Kinds { elements: true, receivers: true };

    fn of(text: &str, files: &[(&str, usize)], kinds: Kinds) -> Option<Beforehand> {
        let folder = tempfile::tempdir().expect("a folder");
        for (name, size) in files {
            std::fs::write(folder.path().join(name), vec![b' '; *size]).expect("a file");
        }
        let scene = folder.path().join("scene.json");
        std::fs::write(&scene, text).expect("a file");
        Beforehand::of(&scene, kinds)
    }

    #[test]
    fn arrays_geometries_and_meshes_are_counted_before_they_are_read() {
        let lamps =
            of(r#"{ "luminaires": [ { "type": "point", "columns": 1000, "rows": 1000 } ] }"#, &[], ALL).expect("read");
        assert!((lamps.reading_s - 4.5).abs() < 0.1 && lamps.rest_s() > 1.0, "{lamps:?}");
        assert_eq!(lamps.slowness(2.0 * lamps.reading_s, || 7.0), 2.0);
        let line = lamps.line(1.0).expect("told");
        assert!(line.contains("about 4.5 s") && line.contains("time limit of 1.0 s ends the run during"), "{line}");
        let line = lamps.line(5.0).expect("told");
        assert!(line.contains("time limit of 5.0 s is exceeded") && line.contains("a first result"), "{line}");
        assert_eq!(lamps.line(60.0), None);

        let boxes = vec![r#"{ "name": "a" }"#; 100_000].join(",");
        let boxes = of(&format!(r#"{{ "geometry": [ {boxes} ], "luminaires": [ {{ "type": "point" }} ] }}"#), &[], ALL);
        assert!(boxes.expect("read").line(1.0).is_some());

        let mesh = r#"{ "geometry": [ { "type": "mesh", "file": "a.obj" } ], "luminaires": [] }"#;
        let mesh = |size, kinds| of(mesh, &[("a.obj", size)], kinds).expect("read");
        assert!(mesh(1 << 10, ALL).line(0.1).is_none() && mesh(4 << 20, ALL).line(0.1).is_some());
        let receivers = Kinds::of(Some("receivers"));
        assert!(mesh(4 << 20, receivers).rest_s() < 0.5 * mesh(4 << 20, Kinds::of(Some("desk, elements"))).rest_s());

        // A rectangle that is divided into a million elements is one geometry in its file. Reading takes no time here, so the trial
        // decides.
        let floor = of(r#"{ "geometry": [ { "name": "floor" } ], "luminaires": [] }"#, &[], ALL).expect("read");
        assert_eq!(floor.slowness(0.02, || 1.5), 1.5);
        assert!(floor.rest_s() < 1e-3);
        let ending_s = floor.with_sides(1_000_000).work().ending_s;
        assert!((ending_s - 1e6 * AN_ELEMENT_S).abs() < 0.01, "{ending_s}");

        // Ten thousand sets of one point each take longer than their points alone.
        let sets = vec![r#"{ "name": "a", "type": "points" }"#; 10_000].join(",");
        let sets = of(&format!(r#"{{ "receivers": [ {sets} ] }}"#), &[], ALL).expect("read");
        assert!(sets.ending_s() > 5.0 * 10_000.0 * A_POINT_S, "{sets:?}");

        // A file of points counts with its size. A photometric file that two luminaires share is read once.
        let text =
            r#"{ "luminaires": [ { "file": "a.ies" }, { "file": "a.ies" } ], "receivers": [ { "file": "p.csv" } ] }"#;
        let tables = of(text, &[("a.ies", 1 << 20), ("p.csv", 1 << 20)], ALL).expect("read");
        assert!((tables.reading_s - 2.0 * 1.048_576 * 0.04).abs() < 1e-3, "{tables:?}");

        // The reader refuses a file that is no scene.
        assert_eq!((of("{", &[], ALL), of(r#"{ "geometry": 3 }"#, &[], ALL)), (None, None));
    }
}
