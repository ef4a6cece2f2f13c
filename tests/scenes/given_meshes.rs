//! Meshes and points whose numbers are in the scene file itself.

use std::path::Path;

use luxmc::{Scene, SceneError, scene_from_json};

/// A tent of four vertices above a floor, with points in the scene file.
const SCENE: &str = r#"{ "version": 1, "length_unit": "mm",
  "materials": { "paint": { "type": "diffuse", "reflectance": 0.5 } },
  "geometry": [ { "name": "tent", "type": "mesh", "material": "paint",
                  "vertices": [[0, 0, 0], [4000, 0, 0], [4000, 3000, 0], [0, 3000, 0], [2000, 1500, 2500]],
                  "faces": [[0, 1, 2, 3], [1, 0, 4], [2, 1, 4], [3, 2, 4], [0, 3, 4]] } ],
  "luminaires": [ { "name": "lamp", "type": "point", "position": [2000, 1500, 1000], "intensity_cd": 100 } ],
  "receivers": [ { "name": "probes", "type": "points", "points": [[2000, 1500, 10, 0, 0, 2, 1000000], [1000, 1500, 10, 0, 0, 1, 500000]] } ] }"#;

fn read(text: &str) -> Result<Scene, SceneError> {
    scene_from_json(text, None, Path::new("."))
}

#[test]
fn a_mesh_and_points_in_the_scene_file_are_read_in_its_unit() {
    let scene = read(SCENE).expect("valid");
    assert_eq!((scene.vertices_m.len(), scene.triangles.len(), scene.surfaces.len()), (5, 6, 1));
    assert!((scene.triangle_area_m2(0) + scene.triangle_area_m2(1) - 12.0).abs() < 1e-12);
    assert_eq!(scene.triangle_normal(0).z, 1.0);
    let points = &scene.receivers[0].points;
    assert_eq!((points[0].position_m.x, points[0].normal.z, points[0].weight, points[1].weight), (2.0, 1.0, 1.0, 0.5));
}

#[test]
fn hostile_meshes_and_points_are_refused_with_their_place() {
    for (old, new, place) in [
        ("[0, 1, 2, 3]", "[0, 1, 2, 5]", "geometry[0].faces[0][3]"),
        ("[0, 1, 2, 3]", "[0, 1, 2, -1]", "geometry[0].faces[0][3]"),
        ("[0, 1, 2, 3]", "[0, 1.5, 2, 3]", "geometry[0].faces[0][1]"),
        ("[0, 1, 2, 3]", "[0, 1, 1e300]", "geometry[0].faces[0][2]"),
        ("[0, 1, 2, 3]", "[0, 1]", "geometry[0].faces[0]"),
        ("[2000, 1500, 2500]", "[2000, 1500]", "geometry[0].vertices[4]"),
        ("[2000, 1500, 2500]", "[2000, 1500, 1e999]", "geometry[0].vertices[4][2]"),
        ("[2000, 1500, 2500]", "[2000, 1500, \"x\"]", "geometry[0].vertices[4][2]"),
        ("\"faces\": [", "\"file\": \"a.obj\", \"faces\": [", "geometry[0].file"),
        ("\"vertices\": [", "\"file\": \"a.obj\", \"vertexes\": [", "geometry[0].vertexes"),
        ("0, 0, 2, 1000000", "0, 0, 0, 1000000", "receivers[0].points[0]"),
        ("0, 0, 2, 1000000", "0, 0, 2, 0", "receivers[0].points[0][6]"),
        ("0, 0, 2, 1000000", "0, 0, 2", "receivers[0].points[1]"),
        ("0, 0, 2, 1000000", "0, 0", "receivers[0].points[0]"),
        ("\"points\": [", "\"file\": \"p.csv\", \"points\": [", "receivers[0].file"),
    ] {
        assert_eq!(SCENE.matches(old).count(), 1, "{old}");
        let error = read(&SCENE.replace(old, new)).expect_err(new);
        let found = error.place.as_ref().map(|place| place.json_path.clone());
        assert_eq!(found.as_deref(), Some(place), "{new}: {error}");
    }
    let (without_faces, _) = SCENE.split_once(",\n                  \"faces\"").expect("faces");
    let (_, rest) = SCENE.split_once("[0, 3, 4]]").expect("faces");
    assert!(read(&format!("{without_faces}{rest}")).expect_err("no faces").to_string().contains("\"faces\""));
    let none = SCENE.replace("[[0, 1, 2, 3], [1, 0, 4], [2, 1, 4], [3, 2, 4], [0, 3, 4]]", "[]");
    assert!(read(&none).expect_err("no face").to_string().contains("without a face"));
    let empty = SCENE.replace("[[2000, 1500, 10, 0, 0, 2, 1000000], [1000, 1500, 10, 0, 0, 1, 500000]]", "[]");
    assert!(read(&empty).expect_err("no point").to_string().contains("without a point"));
}
