//! Hostile input: any file is either read or refused, quickly and with little memory.

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::path::{Path, PathBuf};
use std::sync::mpsc;
use std::time::Duration;

use luxmc::check::{inspect, scene_from_json};
use luxmc::scene::photometry::{parse_eulumdat, parse_ies};
use luxmc::scene::{mesh_from_obj, receiver_points_from_csv};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

/// Counts the bytes that a thread allocates.
struct Counting;

thread_local! {
    static ASKED_BYTES: Cell<usize> = const { Cell::new(0) };
}

// SAFETY: every call is passed on to the system's allocator. The counter is a constant-initialised cell, which allocates nothing.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        ASKED_BYTES.with(|asked| asked.set(asked.get().wrapping_add(layout.size())));
        unsafe { System.alloc(layout) }
    }
    unsafe fn dealloc(&self, place: *mut u8, layout: Layout) {
        unsafe { System.dealloc(place, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// Bytes that this thread allocates while `work` runs.
fn bytes_asked_by(work: impl FnOnce()) -> usize {
    let before = ASKED_BYTES.get();
    work();
    ASKED_BYTES.get().wrapping_sub(before)
}

/// Runs `work` in a thread. The test fails after minutes if it hangs; shorter times do not matter.
fn without_hanging(work: impl FnOnce() + Send + 'static) {
    let (tell, told) = mpsc::channel();
    let thread = std::thread::spawn(move || {
        work();
        tell.send(()).ok();
    });
    if let Err(mpsc::RecvTimeoutError::Timeout) = told.recv_timeout(HANGS_AFTER) {
        panic!("not done after {HANGS_AFTER:?}");
    }
    thread.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic));
}

/// Far longer than a busy machine needs for work that grows with the size of the input.
const HANGS_AFTER: Duration = Duration::from_secs(180);
/// Limit of the bytes that a refused object may allocate. It is enough for the error and its message, and less than a thousandth of the
/// objects that are refused here.
const MOST_REFUSAL_BYTES: usize = 64 << 10;

fn corpus(reader: &str) -> Vec<Vec<u8>> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("fuzz/corpus").join(reader);
    let entries = std::fs::read_dir(&folder).unwrap_or_else(|error| panic!("{}: {error}", folder.display()));
    let mut paths: Vec<PathBuf> = entries.map(|entry| entry.expect("readable").path()).collect();
    paths.sort();
    assert!(paths.len() >= 2, "no corpus in {}", folder.display());
    paths.iter().map(|path| std::fs::read(path).expect("readable")).collect()
}

/// Passes bytes to a reader. Any answer is accepted, but there must be one.
fn read_as(reader: &str, bytes: &[u8]) {
    let text = String::from_utf8_lossy(bytes);
    let said = match reader {
        "scene" => scene_from_json(&text, None, Path::new("/nowhere"))
            .map(|scene| inspect(&scene).warnings.len())
            .err()
            .map(|e| e.to_string()),
        "obj" => mesh_from_obj(&text, Path::new("mesh.obj")).err().map(|error| error.to_string()),
        "ies" => parse_ies(bytes, None).err().map(|error| error.to_string()),
        "ldt" => parse_eulumdat(bytes).err().map(|error| error.to_string()),
        "points" => receiver_points_from_csv(&text, Path::new("p.csv")).err().map(|error| error.to_string()),
        other => panic!("no reader {other}"),
    };
    assert!(said.is_none_or(|message| !message.is_empty()));
}

const READERS: [&str; 5] = ["scene", "obj", "ies", "ldt", "points"];
const PATCHES: [&str; 20] = [
    "",
    "-",
    "1e9",
    "1e308",
    "-1e308",
    "1e-320",
    "4294967296",
    "NaN",
    "inf",
    "\u{0}",
    "\u{1a}",
    "é",
    "\"",
    "{",
    "]",
    ",",
    "/",
    "\\\n",
    "\r",
    "f -1 -2 -3\n",
];

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, rng_seed: RngSeed::Fixed(9), failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn any_bytes_are_read_or_refused(bytes in prop::collection::vec(any::<u8>(), 0..600)) {
        READERS.iter().for_each(|reader| read_as(reader, &bytes));
    }

    #[test]
    fn good_files_with_faults_are_read_or_refused(
        which in any::<prop::sample::Index>(), at in any::<prop::sample::Index>(), length in 0usize..9,
        patch in prop::sample::select(PATCHES.to_vec()), again in any::<prop::sample::Index>(), flip in any::<u8>(),
    ) {
        for reader in READERS {
            let files = corpus(reader);
            let mut bytes = files[which.index(files.len())].clone();
            let from = at.index(bytes.len());
            bytes.splice(from..(from + length).min(bytes.len()), patch.bytes());
            if !bytes.is_empty() {
                let place = again.index(bytes.len());
                bytes[place] ^= flip;
            }
            read_as(reader, &bytes);
            bytes.truncate(from);
            read_as(reader, &bytes);
        }
    }
}

/// The list of a scene that holds an object.
#[derive(Clone, Copy, PartialEq)]
enum List {
    Geometry,
    Luminaires,
    Receivers,
}

/// A scene with these objects, a plain room and one lamp.
fn scene_text(objects: &[(List, &str)]) -> String {
    let of = |list: List| objects.iter().filter(move |(of, _)| *of == list).map(|(_, object)| *object);
    let room =
        r#"{ "name": "room", "type": "box", "min": [0,0,0], "max": [4,3,2], "facing": "inward", "material": "m" }"#;
    let lamp = r#"{ "name": "lamp", "type": "point", "position": [2,1,1], "intensity_cd": 1 }"#;
    let join = |items: Vec<&str>| items.join(", ");
    format!(
        r#"{{ "version": 1, "materials": {{ "m": {{ "type": "diffuse", "reflectance": 0.5 }} }},
        "geometry": [ {} ], "luminaires": [ {} ], "receivers": [ {} ] }}"#,
        join(std::iter::once(room).chain(of(List::Geometry)).collect()),
        join(std::iter::once(lamp).chain(of(List::Luminaires)).collect()),
        join(of(List::Receivers).collect()),
    )
}

/// A scene with these objects in one list.
fn scene_with(list: List, objects: &[&str]) -> String {
    scene_text(&objects.iter().map(|object| (list, *object)).collect::<Vec<(List, &str)>>())
}

/// The error of a refused scene, and the bytes that were allocated until the refusal.
fn refusal(text: &str) -> (String, usize) {
    let mut told = None;
    let bytes = bytes_asked_by(|| told = scene_from_json(text, None, Path::new(".")).err());
    (told.expect("the scene is refused").to_string(), bytes)
}

/// Bytes that the last of these objects allocates by itself: the difference from a scene that has a plain string in its place.
fn bytes_asked_by_the_last(list: List, objects: &[&str], says: &str) -> usize {
    let (told, bytes) = refusal(&scene_with(list, objects));
    assert!(told.contains(says), "{told}");
    let mut others = objects.to_vec();
    *others.last_mut().expect("an object") = "\"nothing\"";
    bytes.saturating_sub(refusal(&scene_with(list, &others)).1)
}

/// Checks that the last object is refused before anything of its size is allocated.
fn refused(list: List, objects: &[&str], says: &str) {
    let bytes = bytes_asked_by_the_last(list, objects, says);
    assert!(bytes < MOST_REFUSAL_BYTES, "{bytes} bytes were asked for before it was told: {says}");
}

fn sphere(name: &str, max_element_edge: &str) -> String {
    format!(
        r#"{{ "name": "{name}", "type": "sphere", "center": [1,1,1], "radius": 0.5, "material": "m", "max_element_edge": {max_element_edge} }}"#
    )
}

fn panel(max_element_edge: &str) -> String {
    format!(
        r#"{{ "name": "p", "type": "rectangle", "origin": [1,1,1], "u": [1,0,0], "v": [0,1,0], "material": "m", "max_element_edge": {max_element_edge} }}"#
    )
}

fn grid(name: &str, columns: u64, rows: u64) -> String {
    format!(
        r#"{{ "name": "{name}", "type": "grid", "origin": [1,1,1], "u": [1,0,0], "v": [0,1,0], "columns": {columns}, "rows": {rows} }}"#
    )
}

fn luminance(name: &str, how: &str) -> String {
    format!(r#"{{ "name": "{name}", "type": "luminance", "position": [2,1,1], {how} }}"#)
}

fn fan(name: &str, count: u32) -> String {
    luminance(name, &format!(r#""fan": {{ "direction": [1,0,0], "from_deg": 0, "to_deg": 90, "count": {count} }}"#))
}

fn view(name: &str, columns: u32) -> String {
    let how =
        format!(r#""view": {{ "direction": [1,0,0], "field_deg": [90, 60], "columns": {columns}, "rows": 1000 }}"#);
    luminance(name, &how)
}

fn array(name: &str, columns: u64) -> String {
    format!(
        r#"{{ "name": "{name}", "type": "point", "position": [1,1,1], "intensity_cd": 1, "columns": {columns}, "rows": 1, "u": [1,0,0] }}"#
    )
}

#[test]
fn a_few_bytes_that_ask_for_millions_are_refused_before_they_are_made() {
    refused(List::Geometry, &[&sphere("s", "1e-9")], "too many triangles");
    refused(List::Geometry, &[&sphere("s", "0.0012")], "too many triangles");
    // Each of the two objects alone is allowed. The second one is refused before it is made. This also holds for grids, fans, views and
    // arrays.
    refused(List::Geometry, &[&sphere("one", "0.01"), &sphere("other", "0.0019")], "too many triangles");
    for edge in ["1e-5", "1e-300", "1e-4"] {
        refused(List::Geometry, &[&panel(edge)], "too many elements");
    }

    let points = "too many points";
    refused(List::Receivers, &[&grid("g", 4_294_967_295, 4_294_967_295)], points);
    refused(List::Receivers, &[&grid("g", 1_000_000_000, 1)], points);
    refused(List::Receivers, &[&grid("one", 1000, 100), &grid("other", 1000, 3950)], points);
    let fine = r#"{ "name": "g", "type": "grid", "surface": "room/floor", "spacing": 1e-9 }"#;
    refused(List::Receivers, &[fine], points);
    refused(List::Receivers, &[&view("v", 2_000_000)], points);
    refused(List::Receivers, &[&fan("one", 100_000), &fan("other", 3_950_000)], points);
    refused(List::Receivers, &[&fan("one", 100_000), &view("other", 3950)], points);
    refused(List::Receivers, &[&view("one", 100), &view("other", 3950)], points);

    refused(List::Luminaires, &[&array("a", 1_000_000_000)], "too many luminaires");
    refused(List::Luminaires, &[&array("one", 50_000), &array("other", 960_000)], "too many luminaires");
}

/// The planted faults: objects that are made before the scene is refused. Each has a hundredth or less of the size of those above, and
/// still exceeds the limit. (Elements take no memory until they are requested.)
#[test]
fn what_is_made_before_it_is_refused_is_counted() {
    let made = |list: List, object: &str| {
        let after = bytes_asked_by_the_last(list, &[object, "\"nothing\""], "");
        let (_, with) = refusal(&scene_with(list, &[object, "\"nothing\""]));
        let (_, without) = refusal(&scene_with(list, &["\"nothing\""]));
        assert!(after < MOST_REFUSAL_BYTES, "{after} bytes of another object were counted");
        with - without
    };
    for (list, object) in [
        (List::Geometry, sphere("s", "0.03")),
        (List::Receivers, grid("g", 100, 100)),
        (List::Receivers, fan("f", 10_000)),
        (List::Luminaires, array("a", 1000)),
    ] {
        let bytes = made(list, &object);
        assert!(bytes > MOST_REFUSAL_BYTES, "{bytes} bytes for {object}");
    }
}

#[test]
fn a_face_with_very_many_corners_is_refused_and_many_parts_are_read_quickly() {
    let corners = 5000;
    let mut text: String = (0..corners).map(|n| format!("v {n} {} 0\n", n % 2)).collect();
    text += "f";
    (1..=corners).for_each(|n| text += &format!(" {n}"));
    let error = mesh_from_obj(&text, Path::new("m.obj")).expect_err("too many corners");
    assert!(error.to_string().contains("at most 1024 corners"), "{error}");

    // A search through all names for each part would take minutes.
    without_hanging(|| {
        let mut text = "v 0 0 0\nv 1 0 0\nv 0 1 0\n".to_string();
        (0..400_000).for_each(|part| text += &format!("usemtl part {part}\nf 1 2 3\n"));
        assert_eq!(mesh_from_obj(&text, Path::new("m.obj")).expect("valid").parts.len(), 400_000);
    });
}

#[cfg(unix)]
#[test]
fn devices_and_folders_are_no_files() {
    for name in ["/dev/zero", "/dev", "/dev/stdin"] {
        let mesh = format!(r#"{{ "name": "d", "type": "mesh", "file": "{name}", "material": "m" }}"#);
        if !Path::new(name).metadata().is_ok_and(|metadata| metadata.is_file()) {
            refused(List::Geometry, &[&mesh], "cannot be read");
        }
    }
}

#[test]
fn luminaires_outside_are_reported_in_one_warning() {
    let array = r#"{ "name": "a", "type": "point", "position": [1,1,9], "intensity_cd": 1, "columns": 500, "rows": 20, "u": [1,0,0], "v": [0,1,0] }"#;
    let scene = scene_from_json(&scene_text(&[(List::Luminaires, array)]), None, Path::new(".")).expect("valid");
    let told = scene.warnings.iter().filter(|warning| warning.contains("bounding box")).count();
    assert_eq!((scene.luminaires.len(), told), (10_001, 1));
}

#[test]
fn many_luminaires_in_fine_spheres_are_checked_at_once() {
    // 20,000 luminaires inside a sphere of 80,000 triangles. The search for the surface that encloses a luminaire takes 104 million steps
    // at most. A test of all triangles for each luminaire would take 1,600 million, and the sphere would be reported as open.
    let sphere = r#"{ "name": "s", "type": "sphere", "center": [0,0,0], "radius": 1000, "facing": "inward", "material": "m", "max_element_edge": 20 }"#;
    let array = r#"{ "name": "a", "type": "point", "position": [1,1,9], "intensity_cd": 1, "columns": 200, "rows": 100, "u": [1,0,0], "v": [0,1,0] }"#;
    let text = scene_text(&[(List::Geometry, sphere), (List::Luminaires, array)]);
    let scene = scene_from_json(&text, None, Path::new(".")).expect("valid");
    assert!(scene.triangles.len() > 50_000 && scene.luminaires.len() == 20_001);
    assert!(inspect(&scene).closed);
}
