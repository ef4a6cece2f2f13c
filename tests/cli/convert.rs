//! `luxmc convert`: models of other programs become scenes, and hostile ones are refused.

use serde_json::Value;

use crate::cli_support::{self, *};

/// A closed room of 4 m × 3 m × 2.5 m in Radiance: plaster, a glass pane in front of a wall, a sphere, a pillar, a bright square under the
/// ceiling that emits downward, and things that are not read.
const ROOM: &str = "# from another program
void plastic plaster 0 0 5 .7 .7 .7 0 0
void plastic lacquer
0
0
5 .2 .2 .2 .05 .1
void glass pane 0 0 3 .96 .96 .96
void light bright 0 0 3 10 10 10
void colorfunc stripes 4 a b c stripes.cal 0 0
stripes plastic wallpaper 0 0 5 .5 .5 .5 0 0
void alias paint plaster
paint polygon floor 0 0 12 0 0 0 4 0 0 4 3 0 0 3 0
plaster polygon ceiling 0 0 12 0 0 2.5 0 3 2.5 4 3 2.5 4 0 2.5
plaster polygon south 0 0 12 0 0 0 0 0 2.5 4 0 2.5 4 0 0
wallpaper polygon north 0 0 12 0 3 0 4 3 0 4 3 2.5 0 3 2.5
plaster polygon west 0 0 12 0 0 0 0 3 0 0 3 2.5 0 0 2.5
plaster polygon east 0 0 12 4 0 0 4 0 2.5 4 3 2.5 4 3 0
pane polygon window 0 0 12 1 2.9 1 1 2.9 2 3 2.9 2 3 2.9 1
lacquer sphere ball 0 0 4 1 1 .5 .3
lacquer cylinder pillar 0 0 7 3 2 0 3 2 2.4 .1
bright polygon square 0 0 12 1.5 1 2.4 1.5 2 2.4 2.5 2 2.4 2.5 1 2.4
void glow sky_glow 0 0 4 1 1 1 0
sky_glow source sky 0 0 4 0 0 1 180
!touch harm.txt
";

fn read(path: &std::path::Path) -> String {
    std::fs::read_to_string(path).expect("there")
}

fn convert(model: &str, text: &str) -> (tempfile::TempDir, std::process::Output) {
    let home = tempfile::tempdir().expect("a temporary directory");
    let path = home.path().join(model);
    std::fs::write(&path, text).expect("written");
    let out = home.path().join("scene.json");
    let output = run(&["convert", cli_support::text(&path), "--out", cli_support::text(&out)]);
    (home, output)
}

#[test]
fn a_radiance_room_becomes_a_scene_that_is_solved() {
    let (home, output) = convert("room.rad", ROOM);
    assert_eq!(code(&output), 0, "{}", errors(&output));
    let told = results(&output);
    for (material, words) in
        [("plaster", "reflectance 0.7"), ("lacquer", "phong"), ("pane", "glass"), ("wallpaper", "pattern is skipped")]
    {
        let row = told.lines().find(|line| line.starts_with(material)).unwrap_or_else(|| panic!("{material}: {told}"));
        assert!(row.contains(words), "{row}");
    }
    let warnings = errors(&output);
    for words in ["!touch harm.txt", "type source", "type colorfunc"] {
        assert!(warnings.contains(words), "{words}: {warnings}");
    }
    assert!(!home.path().join("harm.txt").exists() && !std::path::Path::new("harm.txt").exists());

    let scene = home.path().join("scene.json");
    let inspected = run(&["inspect", text(&scene), "--json"]);
    assert_eq!(code(&inspected), 0, "{}", errors(&inspected));
    let inspected: Value = serde_json::from_str(&results(&inspected)).expect("JSON");
    // A square metre with a white radiance of 10 W/(sr m²): π · 179 lm/W · 10.
    let flux_lm = inspected["luminaires"][0]["luminous_flux_lm"].as_f64().expect("a flux");
    assert!((flux_lm / (std::f64::consts::PI * 1790.0) - 1.0).abs() < 1e-9, "{flux_lm}");
    let area_m2 = |name: &str| {
        let surfaces = inspected["surfaces"].as_array().expect("surfaces");
        surfaces
            .iter()
            .find(|surface| surface["name"] == name)
            .and_then(|surface| surface["area_m2"].as_f64())
            .expect(name)
    };
    assert!((area_m2("plaster") - (12.0 + 10.0 + 15.0)).abs() < 1e-9, "ceiling and three walls");
    assert!((area_m2("paint") - 12.0).abs() < 1e-9, "the floor, by its alias");
    let pillar_m2 = 2.4 * 24.0 * 0.2 * (std::f64::consts::PI / 24.0).sin();
    assert!((area_m2("lacquer") - pillar_m2).abs() < 1e-9, "{}", area_m2("lacquer"));

    let out = home.path().join("out");
    let solved = run(&["solve", text(&scene), "--out", text(&out), "--chains", "2000", "--plots", "none", "--quiet"]);
    assert_eq!(code(&solved), 0, "{}", errors(&solved));
    let balance = &summary(&out)["flux_balance"];
    let lm = |key: &str| balance[key].as_f64().expect(key);
    assert!(
        (lm("absorbed_lm") / lm("emitted_lm") - 1.0).abs() < 1e-6,
        "the room is closed and no light gets lost: {balance}"
    );
}

#[test]
fn meshes_keep_their_file_and_tell_what_is_not_known() {
    let square = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nusemtl Oak\nf 1 2 3\nusemtl Paint\nf 1 3 4\n";
    let (home, output) = convert("square.obj", square);
    assert_eq!(code(&output), 0, "{}", errors(&output));
    assert!(results(&output).lines().any(|line| line.starts_with("Oak") && line.contains("not known")));
    for words in ["unit", "stands in"] {
        assert!(errors(&output).contains(words), "{}", errors(&output));
    }
    let scene: Value = serde_json::from_str(&read(&home.path().join("scene.json"))).expect("JSON");
    assert_eq!(scene["geometry"][0]["file"], "square.obj");
    assert_eq!(scene["materials"]["Paint"]["reflectance"], 0.5);
    assert_eq!(code(&run(&["inspect", text(&home.path().join("scene.json"))])), 0);

    // The scene's name is told. From another folder, it refers to the model by the way there, so that both can be moved together.
    assert!(errors(&output).contains("made ") && errors(&output).contains("luxmc inspect"), "{}", errors(&output));
    let beside = home.path().join("scenes/room.json");
    std::fs::create_dir(home.path().join("scenes")).expect("made");
    assert_eq!(code(&run(&["convert", text(&home.path().join("square.obj")), "--out", text(&beside)])), 0);
    let from_beside: Value = serde_json::from_str(&read(&beside)).expect("JSON");
    assert_eq!(from_beside["geometry"][0]["file"], "../square.obj");
    assert_eq!(code(&run(&["inspect", text(&beside)])), 0);

    // An existing scene is not overwritten without an option.
    let again = ["convert", text(&home.path().join("square.obj")), "--out", text(&home.path().join("scene.json"))]
        .map(str::to_owned);
    let again: Vec<&str> = again.iter().map(String::as_str).collect();
    let refused = run(&again);
    assert!(code(&refused) == 2 && errors(&refused).contains("--overwrite"), "{}", errors(&refused));
    assert_eq!(code(&run(&[&again[..], &["--overwrite"]].concat())), 0);
}

#[test]
fn base_colours_are_proposed_as_reflectances() {
    // A triangle in the JSON itself, with a grey material that is half transparent.
    let gltf = r#"{ "asset": { "version": "2.0" }, "scene": 0, "scenes": [{ "nodes": [0] }], "nodes": [{ "mesh": 0 }],
      "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 }, "material": 0 }] }],
      "materials": [{ "name": "Grey", "alphaMode": "BLEND", "pbrMetallicRoughness": { "baseColorFactor": [0.25, 0.25, 0.25, 0.5], "metallicFactor": 0 } }],
      "accessors": [{ "bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0] }],
      "bufferViews": [{ "buffer": 0, "byteLength": 36 }],
      "buffers": [{ "byteLength": 36, "uri": "data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAACAPwAAgD8AAAAA" }] }"#;
    let (home, output) = convert("model.gltf", gltf);
    assert_eq!(code(&output), 0, "{}", errors(&output));
    assert!(results(&output).contains("transparent"), "{}", results(&output));
    let scene: Value = serde_json::from_str(&read(&home.path().join("scene.json"))).expect("JSON");
    assert_eq!(scene["materials"]["Grey"]["reflectance"], 0.25);
}

/// A model's file can contain things that no reader supports. Each is named once.
#[test]
fn what_is_not_read_of_a_model_is_named() {
    let triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 1\nvt 0 0\nvt 1 0\nmtllib looks of it.mtl\nusemtl Oak\nf 1 2 3\n";
    let header = "element vertex 3\nproperty float x\nproperty float y\nproperty float z\nproperty uchar red\nelement face 1\nproperty list uchar int vertex_indices\nproperty uchar green\nelement edge 1\nproperty int vertex1\nend_header";
    let ply = format!("ply\nformat ascii 1.0\n{header}\n0 0 0 9\n1 0 0 9\n0 1 0 9\n3 0 1 2 9\n1\n");
    let mut stl = format!("{:80}\u{1}\0\0\0{}", "from another program", "\0".repeat(36 + 12)).into_bytes();
    stl[84 + 12 + 12 + 3] = 0x40;
    stl[84 + 12 + 24 + 4 + 3] = 0x40;
    stl.extend([31, 0]);
    let stl = String::from_utf8(stl).expect("small numbers alone");
    let gltf = r#"{ "asset": { "version": "2.0" }, "extensionsUsed": ["KHR_materials_sheen", "ACME_marks"], "scene": 0,
      "scenes": [{ "nodes": [0, 1] }], "nodes": [{ "mesh": 0 }, { "camera": 0 }], "animations": [],
      "cameras": [{ "type": "perspective", "perspective": { "yfov": 1, "znear": 0.1 } }],
      "images": [{ "uri": "oak.png" }], "textures": [{ "source": 0 }],
      "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0, "COLOR_0": 0 } }] }],
      "accessors": [{ "bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0] }],
      "bufferViews": [{ "buffer": 0, "byteLength": 36 }],
      "buffers": [{ "byteLength": 36, "uri": "data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA" }] }"#;
    let of_gltf = ["1 cameras", "1 textures", "COLOR_0 of vertices", "KHR_materials_sheen", "ACME_marks"];
    for (model, file, named) in [
        (
            "a.obj",
            triangle,
            &["the materials of \"looks of it.mtl\"", "2 statements \"vt\"", "1 statements \"vn\""][..],
        ),
        ("a.ply", &ply, &["red of vertices", "green of faces", "1 elements \"edge\""]),
        ("a.stl", &stl, &["two bytes behind each triangle"]),
        ("a.gltf", gltf, &of_gltf),
    ] {
        let (_, output) = convert(model, file);
        assert_eq!(code(&output), 0, "{model}: {}", errors(&output));
        for words in named {
            assert_eq!(errors(&output).matches(words).count(), 1, "{model}, {words}: {}", errors(&output));
        }
    }
}

/// A material of an unsupported kind is listed as not known, and so is an alias of it.
#[test]
fn radiance_materials_of_other_kinds_are_reported_as_not_known() {
    let window = "void BSDF clear 6 0.0 clear.xml 0 0 1 . 0 0\nvoid alias pane clear\nvoid plastic a 0 0 5 .5 .5 .5 0 0\na polygon floor 0 0 9 0 0 0 1 0 0 0 1 0\nclear polygon south 0 0 9 0 0 0 1 0 0 0 0 1\npane polygon west 0 0 9 0 0 0 0 1 0 0 0 1\n";
    let (home, output) = convert("window.rad", window);
    assert_eq!(code(&output), 0, "{}", errors(&output));
    for material in ["clear", "pane"] {
        let told = results(&output);
        let row = told.lines().find(|line| line.starts_with(material)).unwrap_or_else(|| panic!("{material}: {told}"));
        assert!(row.contains("not known: materials of type BSDF are not supported"), "{row}");
    }
    assert!(errors(&output).contains("1 of type BSDF"), "{}", errors(&output));
    let scene: Value = serde_json::from_str(&read(&home.path().join("scene.json"))).expect("JSON");
    assert_eq!(scene["materials"]["pane"]["reflectance"], 0.5);
}

#[test]
fn hostile_models_are_refused_and_nothing_is_written() {
    let polygon = "void plastic a 0 0 5 .5 .5 .5 0 0\na polygon p 0 0 9 0 0 0 1 0 0 0 1 0\n";
    assert_eq!(code(&convert("sound.rad", polygon).1), 0);
    for (old, new, says) in [
        ("a polygon", "b polygon", "no supported material"),
        ("9 0 0 0", "8 0 0 0", "the file ends"),
        ("9 0 0 0 1 0 0 0 1 0", "8 0 0 0 1 0 0 0 1", "wrong number"),
        ("9 0 0 0", "9 0 0 inf", "not a finite number"),
        ("9 0 0 0", "900000000000 0 0 0", "not a count"),
        ("polygon p 0 0 9 0 0 0 1 0 0 0 1 0", "sphere p 0 0 4 0 0 0 -1", "radius"),
        ("polygon p 0 0 9 0 0 0 1 0 0 0 1 0", "cylinder p 0 0 7 0 0 0 0 0 0 1", "no axis"),
        ("polygon p 0 0 9 0 0 0 1 0 0 0 1 0", "cylinder p 0 0 7 0 0 0 0 0 1e308 1e308", "no axis"),
        ("polygon p 0 0 9 0 0 0 1 0 0 0 1 0", "cylinder p 0 0 7 0 0 0 0 0 1e30 1e30", "large"),
        ("a polygon p 0 0 9 0 0 0 1 0 0 0 1 0", "", "without a surface"),
        ("void plastic a", "a plastic a", "closed circle"),
    ] {
        assert!(polygon.contains(old), "{old}");
        let (home, output) = convert("room.rad", &polygon.replace(old, new));
        // A scene with a far too large dimension is written, with a request to correct it. A material that names itself as its modifier is
        // accepted.
        match says {
            "large" => assert!(code(&output) == 0 && errors(&output).contains(says), "{}", errors(&output)),
            "closed circle" => assert_eq!(code(&output), 0, "{}", errors(&output)),
            _ => {
                assert_eq!(code(&output), 2, "{new}: {}", errors(&output));
                assert!(errors(&output).contains(says), "{new}: {}", errors(&output));
                assert!(!home.path().join("scene.json").exists(), "{new}");
            }
        }
    }
    let circle = format!("b colorfunc c 0 0 0\nc colorfunc b 0 0 0\n{}", polygon.replace("a polygon", "b polygon"));
    let (_, output) = convert("room.rad", &circle);
    assert!(code(&output) == 2 && errors(&output).contains("no supported material"), "{}", errors(&output));
    let (_, output) = convert("room.rad", "void light l 0 0 3 1 1");
    assert!(code(&output) == 2 && errors(&output).contains("the file ends"), "{}", errors(&output));
}

/// A file that ends in the middle of its last primitive is never read as complete.
#[test]
fn radiance_files_cut_short_are_refused() {
    let whole = "void plastic a 0 0 5 .5 .5 .5 0 0\na polygon p 0 0 9 0 0 0 1 0 0 0 1 0";
    let first = whole.find('\n').expect("two lines") + 2;
    for length in (first..whole.len() - 1).step_by(3) {
        let (_, output) = convert("room.rad", &whole[..length]);
        assert_eq!(code(&output), 2, "{:?}: {}", &whole[..length], errors(&output));
        assert!(errors(&output).contains("line 2"), "{}", errors(&output));
    }
}

/// Files as honeybee writes them: materials without a newline at their end, surfaces, a separate pane, and sensors.
#[test]
fn several_files_of_radiance_are_one_scene_and_sensors_its_receivers() {
    let home = tempfile::tempdir().expect("a temporary directory");
    let write = |name: &str, words: &str| {
        let path = home.path().join(name);
        std::fs::write(&path, words).expect("written");
        text(&path).to_owned()
    };
    let room = write("room.rad", "wall polygon floor 0 0 12 0 0 0 4 0 0 4 3 0 0 3 0\nwall sphere ball 0 0 4 2 1 1 .2");
    let wall = write("room.mat", "void plastic wall\n0\n0\n5 0.5 0.5 0.5 0.0 0.0");
    let pane = write("pane.rad", "pane polygon window 0 0 12 0 3 0 4 3 0 4 3 2 0 3 2");
    let glass = write("pane.mat", "void glass pane\n0\n0\n3 0.6 0.6 0.6");
    let grid = write("desk.pts", "1 1 0.8 0 0 1\n3 1 0.8 0 0 1\n");
    let out = home.path().join("scene.json");
    let output = run(&["convert", &room, &wall, &grid, &pane, &glass, "--out", text(&out)]);
    assert_eq!(code(&output), 0, "{}", errors(&output));
    let scene: Value = serde_json::from_str(&read(&out)).expect("JSON");
    assert_eq!(scene["title"], "room");
    let names: Vec<&String> = scene["materials"].as_object().expect("materials").keys().collect();
    assert_eq!(names, ["pane", "wall"]);
    assert_eq!(scene["receivers"], serde_json::json!([{ "name": "desk", "type": "points", "file": "desk.pts" }]));
    let inspected = run(&["inspect", text(&out), "--json"]);
    assert_eq!(code(&inspected), 0, "{}", errors(&inspected));
    let inspected: Value = serde_json::from_str(&results(&inspected)).expect("JSON");
    assert_eq!(inspected["totals"]["receiver_points"], 2);

    // An error names the file that contains it. Files that do not form one scene are refused.
    let broken = write("broken.rad", "\nwall polygon p 0 0 9 0 0 0");
    let output = run(&["convert", &wall, &room, &broken, "--out", text(&home.path().join("other.json"))]);
    assert!(code(&output) == 2 && errors(&output).contains("broken.rad, line 2"), "{}", errors(&output));
    let mesh = write("box.obj", BOX);
    for models in [vec![mesh.as_str(), wall.as_str()], vec![grid.as_str()]] {
        let output = run(&[&["convert", "--out", "never.json"][..], &models].concat());
        assert!(code(&output) == 2 && errors(&output).contains("do not form one scene"), "{}", errors(&output));
    }
}

/// A closed box of 1 m whose faces point outward.
const BOX: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\nf 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";

/// The substitute lamp is useful: it hangs in the middle of a room, and stands outside of a solid.
#[test]
fn the_lamp_that_stands_in_lights_a_solid_from_outside_and_a_room_from_inside() {
    let turned: String = BOX
        .lines()
        .map(|line| match line.strip_prefix("f ") {
            Some(corners) => {
                let mut corners: Vec<&str> = corners.split(' ').collect();
                corners.reverse();
                format!("f {}\n", corners.join(" "))
            }
            None => format!("{line}\n"),
        })
        .collect();
    for (model, is_inside) in [(BOX, false), (turned.as_str(), true)] {
        let (home, output) = convert("box.obj", model);
        assert_eq!(code(&output), 0, "{}", errors(&output));
        assert!(!errors(&output).contains("inside of a closed solid"), "{}", errors(&output));
        let path = home.path().join("scene.json");
        let scene: Value = serde_json::from_str(&read(&path)).expect("JSON");
        let place: Vec<f64> = scene["luminaires"][0]["position"]
            .as_array()
            .expect("a place")
            .iter()
            .map(|number| number.as_f64().expect("a number"))
            .collect();
        assert_eq!(place.iter().all(|number| (0.0..=1.0).contains(number)), is_inside, "{place:?}");
        let out = home.path().join("out");
        let solved =
            run(&["solve", text(&path), "--out", text(&out), "--chains", "2000", "--plots", "none", "--quiet"]);
        assert_eq!(code(&solved), 0, "{}", errors(&solved));
        let balance = &summary(&out)["flux_balance"];
        let absorbed_lm = balance["absorbed_lm"].as_f64().expect("a flux");
        assert!(absorbed_lm > if is_inside { 990.0 } else { 1.0 }, "{balance}");
    }
}
