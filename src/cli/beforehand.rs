//! What a scene takes whatever is computed: reading and checking it, making it ready for rays, writing. Told before the work where a time
//! limit is shorter.

use std::fs::{metadata, read};
use std::path::Path;

use serde::Deserialize;
use serde::de::IgnoredAny;

use super::number_text::time;

/// Seconds of one core of some 2 GHz for reading and checking, and for the rest: making ready, a first look, and writing. Measured on a
/// million luminaires of one array and of one entry each, 100,000 rectangles, and meshes of one and ten million triangles
/// (`docs/performance.md`).
type Seconds = [f64; 2];
const A_LUMINAIRE: Seconds = [4e-6, 4e-6];
const A_GEOMETRY: Seconds = [32e-6, 35e-6];
const A_BYTE_OF_A_MESH: Seconds = [40e-9, 60e-9];
const A_BYTE_OF_THE_SCENE: Seconds = [15e-9, 0.0];

/// Luminaires that a scene may have.
const MOST_LUMINAIRES: f64 = 1e6;

/// As much of a scene file as tells how large the scene is.
#[derive(Deserialize)]
struct Outline {
    #[serde(default)]
    geometry: Vec<Geometry>,
    #[serde(default)]
    luminaires: Vec<Array>,
}

#[derive(Deserialize)]
struct Geometry {
    file: Option<String>,
}

#[derive(Deserialize)]
struct Array {
    #[serde(default = "one")]
    columns: f64,
    #[serde(default = "one")]
    rows: f64,
    #[serde(rename = "type")]
    _kind: Option<IgnoredAny>,
}

fn one() -> f64 {
    1.0
}

/// What a scene takes, by its file and the sizes of those that it names.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Beforehand {
    reading_s: f64,
    rest_s: f64,
}

impl Beforehand {
    /// Of a scene file; `None` where it cannot be read as one, which the reader will tell.
    pub fn of(scene: &Path) -> Option<Beforehand> {
        // A device or a pipe is the reader's to refuse.
        metadata(scene).ok().filter(|data| data.is_file())?;
        let bytes = read(scene).ok()?;
        let outline: Outline = serde_json::from_slice(&bytes).ok()?;
        let folder = scene.parent().unwrap_or(Path::new(""));
        let meshes = outline.geometry.iter().filter_map(|geometry| geometry.file.as_ref());
        let mesh_bytes = meshes.filter_map(|file| Some(metadata(folder.join(file)).ok()?.len() as f64)).sum();
        // More are refused.
        let luminaires =
            outline.luminaires.iter().map(|array| (array.columns * array.rows).clamp(0.0, MOST_LUMINAIRES));
        let parts: [(f64, Seconds); 4] = [
            (luminaires.sum::<f64>().min(MOST_LUMINAIRES), A_LUMINAIRE),
            (outline.geometry.len() as f64, A_GEOMETRY),
            (mesh_bytes, A_BYTE_OF_A_MESH),
            (bytes.len() as f64, A_BYTE_OF_THE_SCENE),
        ];
        let [reading_s, rest_s] = [0, 1].map(|part| parts.iter().map(|(count, seconds)| count * seconds[part]).sum());
        Some(Beforehand { reading_s, rest_s })
    }

    /// What is told before reading where a limit is shorter than all that.
    pub fn line(&self, limit_s: f64) -> Option<String> {
        (self.reading_s + self.rest_s > limit_s).then(|| {
            format!(
                "warning: reading this scene takes about {} of a usual core, and making it ready for rays and writing about {} more, \
                 whatever is computed: the time limit of {} is exceeded by that and leaves no time for more than a first look",
                time(self.reading_s),
                time(self.rest_s),
                time(limit_s)
            )
        })
    }

    /// Seconds of the rest on a machine on which reading took so long.
    pub fn rest_after_s(&self, read_s: f64) -> f64 {
        if self.reading_s > 0.0 { self.rest_s * read_s / self.reading_s } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(text: &str, files: &[(&str, usize)]) -> Option<Beforehand> {
        let folder = tempfile::tempdir().expect("a folder");
        for (name, size) in files {
            std::fs::write(folder.path().join(name), vec![b' '; *size]).expect("a file");
        }
        let scene = folder.path().join("scene.json");
        std::fs::write(&scene, text).expect("a file");
        Beforehand::of(&scene)
    }

    #[test]
    fn arrays_geometries_and_meshes_are_counted_before_they_are_read() {
        let lamps =
            of(r#"{ "luminaires": [ { "type": "point", "columns": 1000, "rows": 1000 } ] }"#, &[]).expect("read");
        assert!((lamps.reading_s - 4.0).abs() < 0.1 && lamps.rest_s > 1.0, "{lamps:?}");
        assert_eq!(lamps.rest_after_s(2.0 * lamps.reading_s), 2.0 * lamps.rest_s);
        let line = lamps.line(1.0).expect("told");
        assert!(line.contains("about 4.0 s") && line.contains("time limit of 1.0 s"), "{line}");
        assert_eq!(lamps.line(60.0), None);

        let boxes = vec![r#"{ "name": "a" }"#; 100_000].join(",");
        let boxes = of(&format!(r#"{{ "geometry": [ {boxes} ], "luminaires": [ {{ "type": "point" }} ] }}"#), &[]);
        assert!(boxes.expect("read").line(1.0).is_some());

        let mesh = r#"{ "geometry": [ { "type": "mesh", "file": "a.obj" } ], "luminaires": [] }"#;
        let mesh = |size| of(mesh, &[("a.obj", size)]).expect("read");
        assert!(mesh(1 << 10).line(0.1).is_none() && mesh(4 << 20).line(0.1).is_some());

        // What is no scene is the reader's to refuse.
        assert_eq!((of("{", &[]), of(r#"{ "geometry": 3 }"#, &[])), (None, None));
    }
}
