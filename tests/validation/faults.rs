//! Cases of the project with planted faults: each case must detect what it is made for. It runs unchanged, with less work, and passes. Then
//! a number of its scene is off by some per cent, and it fails.

use std::fs;
use std::path::Path;

use luxmc::validation::{Case, run_case};
use serde_json::{Value, json};
use tempfile::TempDir;

/// A case with one run and one comparison, and a fault in it.
struct Planted {
    case: &'static str,
    /// Number of the run, and the number of its chains; 0 keeps the case's own.
    run: (usize, u64),
    comparison: &'static str,
    /// Path in the scene, and the faulty value.
    fault: (&'static str, Value),
}

/// Copies the case's folder, keeps one run and one comparison in it, and returns whether it passes.
fn passes(planted: &Planted, with_fault: bool) -> bool {
    let house = Path::new(env!("CARGO_MANIFEST_DIR")).join("validation").join(planted.case);
    let home = TempDir::new().expect("a folder");
    for file in fs::read_dir(&house).expect("a case").flatten().filter(|file| file.path().is_file()) {
        fs::copy(file.path(), home.path().join(file.file_name())).expect("a copy");
    }
    let mut case: Value =
        serde_json::from_str(&fs::read_to_string(house.join("case.json")).expect("a case")).expect("JSON");
    let mut run = case["runs"][planted.run.0].take();
    if planted.run.1 > 0 {
        run["chains"] = json!(planted.run.1);
        run.as_object_mut().expect("a run").remove("target_error");
    }
    let is_of_run = |one: &Value| one["runs"].as_array().is_none_or(|runs| runs.contains(&run["name"]));
    let compared = case["compare"].as_array().expect("comparisons").iter();
    let is_it = |one: &&Value| one["name"] == planted.comparison && is_of_run(one);
    let one: Vec<Value> = compared.filter(is_it).cloned().collect();
    case["runs"] = json!([run]);
    assert_eq!(one.len(), 1, "{}: {}", planted.case, planted.comparison);
    case["compare"] = json!(one);
    if with_fault {
        let place = case["scene"].pointer_mut(planted.fault.0).expect("the place of the fault");
        assert_ne!(*place, planted.fault.1, "no fault");
        *place = planted.fault.1.clone();
    }
    fs::write(home.path().join("case.json"), case.to_string()).expect("a case");
    let case = Case::read(home.path()).unwrap_or_else(|error| panic!("{error}"));
    run_case(&case, &mut |_| {}).unwrap_or_else(|error| panic!("{error}")).passes()
}

fn all_see_their_faults(planted: &[Planted]) {
    for planted in planted {
        assert!(passes(planted, false), "{}, {}: it fails as it is", planted.case, planted.comparison);
        assert!(!passes(planted, true), "{}, {}: the planted fault passed", planted.case, planted.comparison);
    }
}

#[test]
fn cases_of_spheres_see_the_faults_that_are_planted_in_them() {
    all_see_their_faults(&[
        Planted {
            case: "harmonics-sphere",
            run: (0, 300_000),
            comparison: "mean of the sphere",
            fault: ("/materials/paint/reflectance", json!(0.79)),
        },
        // A shift of 1 cm from the source: direct light changes by 2 % of itself from side to side.
        Planted {
            case: "harmonics-off-centre",
            run: (0, 4096),
            comparison: "direct light",
            fault: ("/geometry/0/center/0", json!(-0.134)),
        },
    ]);
}

#[test]
#[ignore = "takes long: .ci/run runs it"]
fn cases_of_bodies_in_rooms_see_the_faults_that_are_planted_in_them() {
    all_see_their_faults(&[
        // A body that absorbs one hundredth more: its mean is 3 % lower.
        Planted {
            case: "harmonics-enclosure",
            run: (0, 300_000),
            comparison: "mean of the body",
            fault: ("/materials/paint/reflectance", json!(0.69)),
        },
        // A white body that absorbs a tenth of what it receives: the room is darker by 1.5 %.
        Planted {
            case: "harmonics-isothermal",
            run: (0, 200_000),
            comparison: "mean of the white body",
            fault: ("/materials/white/reflectance", json!(0.9)),
        },
    ]);
}

#[test]
fn cases_of_luminance_see_the_faults_that_are_planted_in_them() {
    all_see_their_faults(&[
        Planted {
            case: "luminance-mirrors",
            run: (0, 34 * 1024),
            comparison: "eye",
            fault: ("/materials/mirror/reflectance", json!(0.88)),
        },
        Planted {
            case: "luminance-mirrors",
            run: (1, 34 * 1024),
            comparison: "eye",
            fault: ("/materials/pane/refractive_index", json!(1.56)),
        },
        Planted {
            case: "luminance-elements",
            run: (0, 4096),
            comparison: "diffuse",
            fault: ("/materials/grey/reflectance", json!(0.49)),
        },
        Planted {
            case: "luminance-elements",
            run: (0, 4096),
            comparison: "glossy",
            fault: ("/materials/lacquer/exponent", json!(21)),
        },
        Planted {
            case: "luminance-elements",
            run: (1, 4096),
            comparison: "mirror",
            fault: ("/materials/mirror/reflectance", json!(0.88)),
        },
        Planted {
            case: "luminance-mirrors",
            run: (0, 16),
            comparison: "balls",
            fault: ("/materials/mirror/reflectance", json!(0.88)),
        },
    ]);
}

#[test]
fn cases_of_light_meshes_see_the_faults_that_are_planted_in_them() {
    all_see_their_faults(&[
        // A board whose edge is off by 3 cm.
        Planted {
            case: "light-mesh-penumbra",
            run: (1, 0),
            comparison: "points across the penumbra",
            fault: ("/geometry/1/u/0", json!(6.03)),
        },
        Planted {
            case: "light-mesh-sobolev",
            run: (0, 0),
            comparison: "plane 2, reflected light",
            fault: ("/materials/plane 1/reflectance", json!(0.47)),
        },
    ]);
}

#[test]
fn cases_of_gloss_see_the_faults_that_are_planted_in_them() {
    all_see_their_faults(&[
        // A sheet that reflects 2 % less.
        Planted {
            case: "intensity-reflectors",
            run: (0, 2_000_000),
            comparison: "intensities",
            fault: ("/materials/sheet/reflectance", json!(0.88)),
        },
        Planted {
            case: "luminance-phong",
            run: (0, 300_000),
            comparison: "all light",
            fault: ("/materials/lacquer/exponent", json!(26)),
        },
    ]);
}
