//! glTF files made by hand, valid and hostile ones.

use std::path::Path;

use serde_json::{Value, json};

use super::super::units::LengthUnit;
use super::*;

/// A square of two triangles in glTF's ground plane, front up, 2 m by 1 m, with 16-bit indices.
fn square() -> (Value, Vec<u8>) {
    let mut bytes = Vec::new();
    for number in [0.0_f32, 0.0, 0.0, 2.0, 0.0, 0.0, 2.0, 0.0, -1.0, 0.0, 0.0, -1.0] {
        bytes.extend(number.to_le_bytes());
    }
    for index in [0_u16, 1, 2, 0, 2, 3] {
        bytes.extend(index.to_le_bytes());
    }
    let json = json!({
        "asset": { "version": "2.0" },
        "scene": 0,
        "scenes": [ { "nodes": [0] } ],
        "nodes": [ { "mesh": 0 } ],
        "meshes": [ { "primitives": [ { "attributes": { "POSITION": 0 }, "indices": 1, "material": 0 } ] } ],
        "materials": [ { "name": "Light oak" } ],
        "accessors": [
            { "bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", "min": [0, 0, -1], "max": [2, 0, 0] },
            { "bufferView": 1, "componentType": 5123, "count": 6, "type": "SCALAR" }
        ],
        "bufferViews": [
            { "buffer": 0, "byteOffset": 0, "byteLength": 48 },
            { "buffer": 0, "byteOffset": 48, "byteLength": 12 }
        ],
        "buffers": [ { "byteLength": 60 } ]
    });
    (json, bytes)
}

fn glb(json: &Value, binary: &[u8]) -> Vec<u8> {
    let json = json.to_string().into_bytes();
    let header = gltf::binary::Header { magic: *b"glTF", version: 2, length: 0 };
    Glb { header, json: json.into(), bin: Some(binary.into()) }.to_vec().expect("memory takes it")
}

fn read_in(path: &Path, bytes: &[u8], unit: usize) -> Result<(GeometryShape, Vec<String>), SceneError> {
    let mut warnings = Vec::new();
    Ok((read(path, bytes, LengthUnit::of(unit), &mut warnings)?, warnings))
}

fn read_glb(json: &Value, binary: &[u8]) -> Result<(GeometryShape, Vec<String>), SceneError> {
    read_in(Path::new("test.glb"), &glb(json, binary), 0)
}

fn normal_of(shape: &GeometryShape) -> DVec3 {
    let [a, b, c] = shape.parts[0].triangles[0].map(|vertex| shape.vertices[vertex as usize]);
    (b - a).cross(c - a).normalize()
}

#[test]
fn y_up_becomes_z_up_and_metres_the_scenes_unit() {
    let (json, bytes) = square();
    let (shape, warnings) = read_glb(&json, &bytes).expect("valid");
    assert!(warnings.is_empty(), "{warnings:?}");
    let places = [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [2.0, 1.0, 0.0], [0.0, 1.0, 0.0]].map(DVec3::from);
    assert_eq!(shape.vertices, places);
    assert_eq!(shape.parts[0].name.as_deref(), Some("Light oak"));
    assert_eq!(shape.parts[0].triangles, [[0, 1, 2], [0, 2, 3]]);
    assert_eq!(normal_of(&shape), DVec3::Z);
    let (shape, _) = read_in(Path::new("test.glb"), &glb(&json, &bytes), 1).expect("valid");
    assert_eq!(shape.vertices[2], DVec3::new(2000.0, 1000.0, 0.0));
}

#[test]
fn transforms_of_nodes_follow_each_other_and_mirrored_fronts_stay_fronts() {
    let (mut json, bytes) = square();
    let half = 0.5_f64.sqrt();
    json["scenes"][0]["nodes"] = json!([1]);
    // A quarter turn about glTF's y within a shift. The turn does not affect the shift.
    json["nodes"] = json!([
        { "mesh": 0, "rotation": [0.0, half, 0.0, half], "scale": [1.0, 1.0, 3.0] },
        { "children": [0, 2], "translation": [10.0, 20.0, 30.0] },
        { "mesh": 0, "matrix": [-1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 5.0, 0.0, 0.0, 1.0] }
    ]);
    let (shape, _) = read_glb(&json, &bytes).expect("valid");
    // (2, 0, −1) is scaled to (2, 0, −3), turned to (−3, 0, −2), shifted to (7, 20, 28). With z up it is (7, −28, 20).
    assert!(shape.vertices[2].distance(DVec3::new(7.0, -28.0, 20.0)) < 1e-6, "{}", shape.vertices[2]);
    assert_eq!(shape.parts[0].triangles.len(), 4);
    for triangle in &shape.parts[0].triangles {
        let [a, b, c] = triangle.map(|vertex| shape.vertices[vertex as usize]);
        assert!((b - a).cross(c - a).z > 0.0, "a front faces down");
    }
}

#[test]
fn strips_and_fans_keep_their_fronts() {
    for (mode, order) in [(5, [0_u16, 1, 3, 2]), (6, [0, 1, 2, 3])] {
        let (mut json, mut bytes) = square();
        bytes.truncate(48);
        order.iter().for_each(|index| bytes.extend(index.to_le_bytes()));
        json["meshes"][0]["primitives"][0]["mode"] = json!(mode);
        json["accessors"][1]["count"] = json!(4);
        json["bufferViews"][1]["byteLength"] = json!(8);
        json["buffers"][0]["byteLength"] = json!(56);
        let (shape, _) = read_glb(&json, &bytes).expect("valid");
        assert_eq!(shape.parts[0].triangles.len(), 2);
        let mut area = 0.0;
        for triangle in &shape.parts[0].triangles {
            let [a, b, c] = triangle.map(|vertex| shape.vertices[vertex as usize]);
            area += 0.5 * (b - a).cross(c - a).z;
        }
        assert_eq!(area, 2.0, "mode {mode}");
    }
}

#[test]
fn buffers_come_from_beside_the_file_and_from_data_uris() {
    let (mut json, bytes) = square();
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("test.gltf");
    std::fs::write(folder.path().join("my buffer.bin"), &bytes).expect("written");
    for uri in
        ["my%20buffer.bin", "./my buffer.bin", &format!("data:application/octet-stream;base64,{}", base_64(&bytes))]
    {
        json["buffers"][0]["uri"] = json!(uri);
        let (shape, _) = read_in(&path, json.to_string().as_bytes(), 0).expect(uri);
        assert_eq!(shape.vertices.len(), 4);
    }
}

fn base_64(bytes: &[u8]) -> String {
    base64::Engine::encode(&base64::prelude::BASE64_STANDARD, bytes)
}

#[test]
fn nothing_outside_the_folder_is_read() {
    let (mut json, bytes) = square();
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("secret.bin"), &bytes).expect("written");
    std::fs::create_dir(folder.path().join("model")).expect("made");
    let path = folder.path().join("model/test.gltf");
    let absolute = folder.path().join("secret.bin").display().to_string();
    for (uri, says) in [
        ("../secret.bin", "outside"),
        ("%2e%2e/secret.bin", "outside"),
        ("..%2Fsecret.bin", "outside"),
        ("a/../../secret.bin", "outside"),
        ("..\\secret.bin", "outside"),
        (&absolute, "outside"),
        ("", "outside"),
        ("http://localhost/secret.bin", "nothing is fetched"),
        ("file:///secret.bin", "nothing is fetched"),
        ("data:text/plain,abc", "cut short"),
        ("data:application/octet-stream;base64,§", "not valid base64"),
        ("missing.bin", "cannot be read"),
    ] {
        json["buffers"][0]["uri"] = json!(uri);
        let error = read_in(&path, json.to_string().as_bytes(), 0).expect_err(uri);
        assert!(error.to_string().contains(says), "{uri}: {error}");
    }
}

#[test]
fn a_file_cut_short_anywhere_is_refused() {
    let (json, bytes) = square();
    let whole = glb(&json, &bytes);
    for length in 0..whole.len() {
        let mut cut = whole[..length].to_vec();
        assert!(read_in(Path::new("cut.glb"), &cut, 0).is_err(), "{length} bytes were read");
        // A header that agrees with the cut does not make the file valid.
        if length >= 12 {
            cut[8..12].copy_from_slice(&(length as u32).to_le_bytes());
            assert!(read_in(Path::new("cut.glb"), &cut, 0).is_err(), "{length} bytes with their header were read");
        }
    }
}

#[test]
fn hostile_numbers_are_refused() {
    let change = |pointer: &str, value: Value| {
        let (mut json, bytes) = square();
        let (above, key) = pointer.rsplit_once('/').expect("a pointer");
        json.pointer_mut(above).expect(pointer)[key] = value;
        read_glb(&json, &bytes).expect_err(pointer).to_string()
    };
    for (pointer, value, says) in [
        ("/accessors/0/count", json!(3), "does not exist"),
        ("/accessors/0/count", json!(4_000_000_000_u32), "extends beyond its buffer view"),
        ("/accessors/1/count", json!(u64::MAX), "extends beyond its buffer view"),
        ("/accessors/1/count", json!(7), "extends beyond its buffer view"),
        ("/accessors/1/count", json!(5), "whole number of triangles"),
        ("/accessors/0/byteOffset", json!(9_007_199_254_740_992_u64), "extends beyond its buffer view"),
        ("/accessors/0/bufferView", json!(9), "not valid glTF"),
        ("/accessors/0/type", json!("VEC2"), "positions of an unsupported type"),
        ("/accessors/1/componentType", json!(5126), "indices of an unsupported type"),
        ("/accessors/0/sparse", sparse(), "is sparse"),
        ("/bufferViews/0/byteLength", json!(9_007_199_254_740_992_u64), "extends beyond its buffer"),
        ("/bufferViews/0/byteOffset", json!(50), "extends beyond its buffer"),
        ("/bufferViews/0/byteStride", json!(4), "elements that overlap"),
        ("/buffers/0/byteLength", json!(61_000), "cut short"),
        ("/meshes/0/primitives/0/attributes/POSITION", json!(2), "positions that do not exist"),
        ("/meshes/0/primitives/0/attributes/NORMAL", json!(2), "not valid glTF"),
        ("/meshes/0/primitives/0/indices", json!(2), "not valid glTF"),
        ("/nodes/0/children", json!([0]), "reached twice"),
        ("/nodes/0/children", json!([5]), "not valid glTF"),
        ("/nodes/0/rotation", json!([0, 0, 0, 0]), "no finite position"),
        ("/nodes/0/scale", json!([1e30, 1e300, 1]), "not valid glTF"),
        ("/scenes/0/nodes", json!([0, 0]), "reached twice"),
        ("/scenes/0/nodes", json!([]), "without a triangle"),
        ("/scene", json!(4), "not valid glTF"),
        ("/extensionsRequired", json!(["KHR_draco_mesh_compression"]), "compressed in a way that is not supported"),
        ("/extensionsRequired", json!(["KHR_materials_ior", "ACME_shape"]), "extension that is not supported"),
        ("/accessors/0/componentType", json!(5125), "positions of an unsupported type"),
        ("/asset/version", json!(7), "not valid glTF"),
    ] {
        let message = change(pointer, value);
        assert!(message.contains(says), "{pointer}: {says:?} is not in\n{message}");
        for line in ["got: ", "expected: ", "remedy: "] {
            assert!(message.contains(line), "{pointer}: {message}");
        }
    }
}

fn sparse() -> Value {
    json!({ "count": 1, "indices": { "bufferView": 1, "componentType": 5123 }, "values": { "bufferView": 0 } })
}

#[test]
fn places_that_are_no_numbers_are_refused() {
    for wrong in [f32::NAN, f32::INFINITY] {
        let (json, mut bytes) = square();
        bytes[16..20].copy_from_slice(&wrong.to_le_bytes());
        let error = read_glb(&json, &bytes).expect_err("no finite position").to_string();
        assert!(error.contains("vertex 1 has no finite position"), "{error}");
    }
}

#[test]
fn many_nodes_of_one_large_mesh_are_refused_before_they_fill_memory() {
    let (mut json, mut bytes) = square();
    let corners = 3_000_000_usize;
    bytes.truncate(48);
    bytes.resize(48 + 2 * corners, 0);
    json["accessors"][1]["count"] = json!(corners);
    json["bufferViews"][1]["byteLength"] = json!(2 * corners);
    json["buffers"][0]["byteLength"] = json!(bytes.len());
    json["nodes"] = vec![json!({ "mesh": 0 }); 1000].into();
    json["scenes"][0]["nodes"] = (0..1000).collect::<Vec<u32>>().into();
    let error = read_glb(&json, &bytes).expect_err("too much").to_string();
    assert!(error.contains("too many triangles") || error.contains("need too many vertices"), "{error}");
}

#[test]
fn what_is_passed_over_and_matters_is_said() {
    let (mut json, bytes) = square();
    for (list, more) in [
        ("/meshes/0/primitives", json!({ "attributes": { "POSITION": 0 }, "mode": 1 })),
        ("/meshes/0/primitives", json!({ "attributes": { "POSITION": 0 }, "indices": 1, "material": 2 })),
        ("/meshes/0/primitives", json!({ "attributes": { "POSITION": 0 }, "indices": 1 })),
        ("/scenes", json!({ "nodes": [0] })),
        ("/materials", json!({ "name": "Light oak" })),
        ("/materials", json!({})),
    ] {
        json.pointer_mut(list).and_then(Value::as_array_mut).expect(list).push(more);
    }
    json["extensionsUsed"] = json!(["KHR_lights_punctual", "KHR_materials_ior", "ACME_shape"]);
    let (shape, warnings) = read_glb(&json, &bytes).expect("valid");
    let said = warnings.join("\n");
    for says in ["1 primitives of lines", "2 scenes", "\"Light oak\"", "KHR_lights_punctual", "ACME_shape"] {
        assert!(said.contains(says), "{says}: {said}");
    }
    assert!(!said.contains("KHR_materials_ior"), "{said}");
    let names: Vec<_> = shape.parts.iter().map(|part| part.name.as_deref()).collect();
    assert_eq!(names, [Some("Light oak"), Some("material 2"), None]);

    json["scenes"] = json!([{ "nodes": [0] }]);
    json["nodes"] = json!([{ "mesh": 0 }, { "mesh": 0 }]);
    let (_, warnings) = read_glb(&json, &bytes).expect("valid");
    assert!(warnings.iter().any(|warning| warning.contains("1 nodes with a mesh belong to no scene")), "{warnings:?}");
}

#[test]
fn extensions_of_appearance_that_a_file_needs_keep_nothing_from_being_read() {
    let (mut json, bytes) = square();
    for name in ["KHR_materials_specular", "KHR_texture_basisu", "EXT_texture_webp", "KHR_lights_punctual", "KHR_xmp"] {
        json["extensionsRequired"] = json!([name]);
        json["extensionsUsed"] = json!([name]);
        let (shape, _) = read_glb(&json, &bytes).expect(name);
        assert_eq!(shape.parts[0].triangles.len(), 2, "{name}");
    }
}

#[test]
fn positions_may_be_whole_numbers_normalized_or_not() {
    // The corners of the square in shorts of 1/65534 of a metre each way, and in bytes of a metre.
    for (kind, stride, is_normalized, scale) in [(5122, 8, true, 2.0), (5123, 8, true, 2.0), (5120, 4, false, 1.0)] {
        let (mut json, _) = square();
        let greatest: i32 = if kind == 5123 { 65535 } else { 32767 };
        let mut bytes = Vec::new();
        for corner in [[0, 0], [2, 0], [2, 1], [0, 1]] {
            for number in [corner[0], 0, corner[1], 0] {
                match kind {
                    5120 => bytes.push(number as u8),
                    _ => bytes.extend((((number * greatest) / 2) as u16).to_le_bytes()),
                }
            }
        }
        json["bufferViews"][0] = json!({ "buffer": 0, "byteLength": bytes.len(), "byteStride": stride });
        json["bufferViews"][1]["byteOffset"] = json!(bytes.len());
        for index in [0_u16, 2, 1, 0, 3, 2] {
            bytes.extend(index.to_le_bytes());
        }
        json["buffers"][0]["byteLength"] = json!(bytes.len());
        json["accessors"][0]["componentType"] = json!(kind);
        json["accessors"][0]["normalized"] = json!(is_normalized);
        json["nodes"][0]["scale"] = json!([scale, scale, scale]);
        json["extensionsRequired"] = json!(["KHR_mesh_quantization"]);
        json["extensionsUsed"] = json!(["KHR_mesh_quantization"]);
        let (shape, _) = read_glb(&json, &bytes).expect("valid");
        for (vertex, place) in shape.vertices.iter().zip([[0.0, 0.0], [2.0, -1.0], [2.0, 0.0], [0.0, -1.0]]) {
            assert!(vertex.distance(DVec3::new(place[0], place[1], 0.0)) < 1e-4, "{kind}: {vertex}");
        }
        assert_eq!(normal_of(&shape), DVec3::Z, "{kind}");
    }
}

#[test]
fn files_of_version_1_are_refused_by_their_version() {
    let (json, bytes) = square();
    let mut first = glb(&json, &bytes);
    first[4] = 1;
    let error = read_in(Path::new("test.glb"), &first, 0).expect_err("version 1").to_string();
    assert!(error.contains("version 1") && error.contains("as glTF 2.0"), "{error}");
    let text = json!({ "asset": { "version": "1.0" }, "accessors": { "position": {} } }).to_string();
    let error = read_in(Path::new("test.gltf"), text.as_bytes(), 0).expect_err("version 1").to_string();
    assert!(error.contains("version 1.0"), "{error}");
}

#[test]
fn meshes_that_are_packed_though_their_file_does_not_say_that_readers_must_know_it_are_refused_by_name() {
    let (mut json, bytes) = square();
    json["extensionsUsed"] = json!(["KHR_draco_mesh_compression"]);
    json["accessors"][0].as_object_mut().expect("an accessor").remove("bufferView");
    let error = read_glb(&json, &bytes).expect_err("packed").to_string();
    assert!(error.contains("compressed") && error.contains("KHR_draco_mesh_compression"), "{error}");
}
