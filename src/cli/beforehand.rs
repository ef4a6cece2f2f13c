//! What a scene takes whatever is computed: reading and checking it, making it ready for rays, writing. Told before the work where a time
//! limit is shorter.

use std::fs::{metadata, read};
use std::path::Path;

use serde::Deserialize;
use serde::de::IgnoredAny;

use super::kept_back::Work;
use super::number_text::time;
use super::patience::latest_s;

/// Seconds of one core of some 2 GHz for reading and checking, and for the rest: making ready, a first look, and writing. Measured on
/// 100,000 rectangles, a million luminaires of one array and of one entry each, meshes of 0.5 to 5.8 million triangles, a million points
/// and photometric files of 8 to 55 MB (`docs/performance.md`).
type Seconds = [f64; 2];
const A_LUMINAIRE: Seconds = [4.5e-6, 4e-6];
const A_GEOMETRY: Seconds = [32e-6, 35e-6];
const A_TRIANGLE_OF_A_MESH: Seconds = [2.7e-6, 4e-6];
const A_BYTE_OF_TEXT: Seconds = [40e-9, 0.0];
const A_POINT: Seconds = [0.2e-6, 0.0];
/// The same seconds of what comes after computing, of an element side, a point and a receiver set whose map is computed: judging, tables,
/// a model and the page.
const AN_ELEMENT_S: f64 = 14e-6;
const A_POINT_S: f64 = 8e-6;
const A_SET_S: f64 = 120e-6;

/// Reading that takes as long as this tells how fast a machine is.
const TELLING_S: f64 = 0.1;

/// Bytes that a triangle of a closed mesh takes in a file, by its ending.
const BYTES_OF_A_TRIANGLE: [(&str, f64); 4] = [("gltf", 18.0), ("glb", 18.0), ("ply", 19.0), ("stl", 50.0)];
const BYTES_OF_AN_OBJ_TRIANGLE: f64 = 36.0;

/// Luminaires that a scene may have, and points.
const MOST_LUMINAIRES: f64 = 1e6;
const MOST_POINTS: f64 = 4e6;

/// As much of a scene file as tells how large the scene is.
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

/// Which maps are computed, by their kinds.
#[derive(Clone, Copy)]
pub struct Kinds {
    elements: bool,
    receivers: bool,
}

impl Kinds {
    /// Of what `--maps` asks for.
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

/// What a scene takes, by its file and the sizes of those that it names.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Beforehand {
    reading_s: f64,
    readying_s: f64,
    /// Element sides, points and sets whose maps are computed.
    sides: f64,
    points: f64,
    sets: f64,
}

impl Beforehand {
    /// Of a scene file; `None` where it cannot be read as one, which the reader will tell.
    pub fn of(scene: &Path, kinds: Kinds) -> Option<Beforehand> {
        // A device or a pipe is the reader's to refuse.
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
        // More are refused. A photometric file that many share is read once.
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

    /// The same with as many element sides as the scene has, once it is read: of a surface that is cut finely a file says little.
    pub fn with_sides(self, sides: usize) -> Beforehand {
        Beforehand { sides: sides as f64, ..self }
    }

    /// What the run does beside reading and computing, files left out.
    pub fn work(&self) -> Work {
        Work { readying_s: self.readying_s, ending_s: self.ending_s(), files: 0 }
    }

    /// Seconds of one core for what comes after computing.
    fn ending_s(&self) -> f64 {
        self.sides * AN_ELEMENT_S + self.points * A_POINT_S + self.sets * A_SET_S
    }

    /// The same with making ready before it.
    fn rest_s(&self) -> f64 {
        self.readying_s + self.ending_s()
    }

    /// What is told before reading where a limit is shorter than all that.
    pub fn line(&self, limit_s: f64) -> Option<String> {
        let comes_to = match self.reading_s {
            reading_s if reading_s > latest_s(limit_s) => "ends the run while it reads, and nothing will be written",
            _ => "is exceeded by that and leaves no time for more than a first look",
        };
        (self.reading_s + self.rest_s() > limit_s).then(|| {
            format!(
                "warning: reading this scene takes about {} of a usual core, and making it ready for rays and writing about {} more, \
                 whatever is computed: the time limit of {} {comes_to}",
                time(self.reading_s),
                time(self.rest_s()),
                time(limit_s)
            )
        })
    }

    /// Seconds of one core for reading and checking, and for the rest.
    pub fn seconds(&self) -> [f64; 2] {
        [self.reading_s, self.rest_s()]
    }

    /// How many times as long as on a usual core work takes where reading took so long, or else by a trial; reading that takes next to
    /// nothing tells nothing of a machine.
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
        assert!(line.contains("about 4.5 s") && line.contains("time limit of 1.0 s ends the run while"), "{line}");
        let line = lamps.line(5.0).expect("told");
        assert!(line.contains("time limit of 5.0 s is exceeded") && line.contains("a first look"), "{line}");
        assert_eq!(lamps.line(60.0), None);

        let boxes = vec![r#"{ "name": "a" }"#; 100_000].join(",");
        let boxes = of(&format!(r#"{{ "geometry": [ {boxes} ], "luminaires": [ {{ "type": "point" }} ] }}"#), &[], ALL);
        assert!(boxes.expect("read").line(1.0).is_some());

        let mesh = r#"{ "geometry": [ { "type": "mesh", "file": "a.obj" } ], "luminaires": [] }"#;
        let mesh = |size, kinds| of(mesh, &[("a.obj", size)], kinds).expect("read");
        assert!(mesh(1 << 10, ALL).line(0.1).is_none() && mesh(4 << 20, ALL).line(0.1).is_some());
        let receivers = Kinds::of(Some("receivers"));
        assert!(mesh(4 << 20, receivers).rest_s() < 0.5 * mesh(4 << 20, Kinds::of(Some("desk, elements"))).rest_s());

        // A rectangle that is cut into a million elements is one geometry in its file. Where reading takes nothing the rest is what it is.
        let floor = of(r#"{ "geometry": [ { "name": "floor" } ], "luminaires": [] }"#, &[], ALL).expect("read");
        assert_eq!(floor.slowness(0.02, || 1.5), 1.5);
        assert!(floor.rest_s() < 1e-3);
        let ending_s = floor.with_sides(1_000_000).work().ending_s;
        assert!((ending_s - 1e6 * AN_ELEMENT_S).abs() < 0.01, "{ending_s}");

        // Ten thousand sets of a point each take longer than their points alone do.
        let sets = vec![r#"{ "name": "a", "type": "points" }"#; 10_000].join(",");
        let sets = of(&format!(r#"{{ "receivers": [ {sets} ] }}"#), &[], ALL).expect("read");
        assert!(sets.ending_s() > 5.0 * 10_000.0 * A_POINT_S, "{sets:?}");

        // Points and what luminaires say of themselves, read once where many share it.
        let text =
            r#"{ "luminaires": [ { "file": "a.ies" }, { "file": "a.ies" } ], "receivers": [ { "file": "p.csv" } ] }"#;
        let tables = of(text, &[("a.ies", 1 << 20), ("p.csv", 1 << 20)], ALL).expect("read");
        assert!((tables.reading_s - 2.0 * 1.048_576 * 0.04).abs() < 1e-3, "{tables:?}");

        // What is no scene is the reader's to refuse.
        assert_eq!((of("{", &[], ALL), of(r#"{ "geometry": 3 }"#, &[], ALL)), (None, None));
    }
}
