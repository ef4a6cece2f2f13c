//! Smooth bodies of spherical harmonics against truths that need no mesh.
//!
//! Comparisons with randomness allow 5 standard errors of 16 replicas (t with 15 degrees of freedom, some 2e-4 each) with the seed below.
//! They must detect a planted fault of 2 %.

use std::f64::consts::PI;
use std::fmt::Write;
use std::path::Path;

use glam::DVec3;
use luxmc::base::harmonics::{HarmonicSeries, direction};
use luxmc::check::{NoFit, fit_harmonics, scene_from_json};
use luxmc::geometry::{Meeting, Tracer};
use luxmc::scene::{Elements, Scene, Side};
use luxmc::solver::{MapSelection, Method, Settings, Silent, Solution, solve};

const SEED: u64 = 31;
const WITHIN: f64 = 5.0;
const PLANTED: f64 = 0.02;

/// A body of degree 7, about 1 m in radius.
fn lumpy() -> String {
    let mut text = String::new();
    for l in 0..8 {
        for m in -l..=l {
            let c = if l == 0 { 3.545 } else { 0.34 * f64::sin(7.3 * f64::from(l * l + l + m)) / f64::from(l + 1) };
            write!(text, "{}[{l},{m},{c}]", if l == 0 { "" } else { "," }).expect("texts take everything");
        }
    }
    text
}

fn scene_of(materials: &str, geometry: &str, luminaires: &str, receivers: &str) -> Scene {
    let text = format!(
        r#"{{ "version": 1, "materials": {{ {materials} }}, "geometry": [ {geometry} ], "luminaires": [ {luminaires} ],
        "receivers": [ {receivers} ] }}"#
    );
    scene_from_json(&text, None, Path::new(env!("CARGO_MANIFEST_DIR"))).unwrap_or_else(|error| panic!("{error}"))
}

fn solved(scene: &Scene, method: Method, chains: u64, maps: MapSelection) -> Solution {
    let settings = Settings { seed: SEED, chains: Some(chains), method, maps, ..Settings::default() };
    solve(scene, &settings, &Silent)
}

/// Mean by area over the elements of a geometry.
fn mean_of(scene: &Scene, solution: &Solution, name: &str, part: impl Fn(usize) -> f64) -> f64 {
    let elements = Elements::of(scene);
    let (mut sum, mut area_m2) = (0.0, 0.0);
    for index in 0..elements.len() {
        let element = elements.element(index as u32);
        if scene.surface_of(element.triangle).geometry == name {
            let own_m2 = elements.area_m2(scene, element);
            sum += own_m2 * part(index);
            area_m2 += own_m2;
        }
    }
    assert!(!solution.maps.is_empty() && area_m2 > 0.0);
    sum / area_m2
}

#[test]
fn a_closed_lumpy_body_holds_its_light_and_leaks_none() {
    let body = format!(
        r#"{{ "name": "body", "type": "spherical_harmonics", "facing": "inward", "coefficients": [{}], "material": "paint" }}"#,
        lumpy()
    );
    let lamp = r#"{ "name": "lamp", "type": "point", "position": [0.1,0.05,0.2], "luminous_flux_lm": 1000 }"#;
    let scene = scene_of(r#""paint": { "type": "diffuse", "reflectance": 0.7 }"#, &body, lamp, "");
    let area_m2 = scene.bodies[0].area_m2();
    let expected_lx = 1000.0 / (area_m2 * 0.3);
    let solution = solved(&scene, Method::Collision, 400_000, MapSelection::Elements);
    let values = &solution.maps[0].values;
    let mean_lx = mean_of(&scene, &solution, "body", |index| values.value[index]);
    // 400,000 chains with 10/3 arrivals each: the number of arrivals has the variance ρ/(1−ρ)² per chain.
    let sigma = (0.7f64 / 0.3 / 0.3 / 400_000.0).sqrt() * 0.3;
    let off = (mean_lx / expected_lx - 1.0) / sigma;
    assert!(off.abs() < WITHIN, "{mean_lx} {expected_lx}: {off} σ");
    assert!(((mean_lx * (1.0 + PLANTED)) / expected_lx - 1.0).abs() / sigma > WITHIN);
    let balance = solution.flux_balance.as_ref().expect("chains balance");
    assert_eq!((balance.escaped_lm, balance.back_face_lm), (0.0, 0.0));
}

#[test]
#[ignore = "takes long: .ci/run runs it"]
fn white_bodies_change_nothing_in_an_isothermal_room_whatever_the_method() {
    let materials =
        r#""grey": { "type": "diffuse", "reflectance": 0.5 }, "white": { "type": "diffuse", "reflectance": 1 }"#;
    let geometry = format!(
        r#"{{ "name": "room", "type": "box", "min": [0,0,0], "max": [4,4,3], "facing": "inward", "material": "grey" }},
        {{ "name": "body", "type": "spherical_harmonics", "coefficients": [{}], "material": "white",
           "transform": {{ "scale": 0.8, "rotate_deg": [20,35,50], "translate": [1.9,2.1,1.4] }} }}"#,
        lumpy()
    );
    let walls = r#"{ "name": "walls", "type": "area", "surface": "room", "exitance_lm_m2": 157.07963267949 }"#;
    let plane = r#"{ "name": "plane", "type": "grid", "origin": [0.5,0.5,0.2], "u": [3,0,0], "v": [0,3,0], "columns": 3, "rows": 3 }"#;
    let scene = scene_of(materials, &geometry, walls, plane);
    let expected_lx = 100.0 * PI;
    // The random error that cells of a gathering share is no part of an element's standard error. The number of packets must be large
    // enough.
    for (method, chains) in [(Method::Collision, 200_000), (Method::Local, 20_000), (Method::Gather, 400_000)] {
        let solution = solved(&scene, method, chains, MapSelection::All);
        for map in &solution.maps {
            // The limit is 5 σ for the points and 9 σ for each of some thousand elements.
            let within = if map.values.value.len() > 100 { 9.0 } else { WITHIN };
            for (index, (lx, error_lx)) in map.values.value.iter().zip(&map.values.standard_error).enumerate() {
                assert!(
                    (lx - expected_lx).abs() <= within * error_lx.max(1e-3 * expected_lx),
                    "{method:?} {index}: {lx} ± {error_lx}, exact {expected_lx}"
                );
            }
        }
        let elements = solution.maps.iter().find(|map| map.values.value.len() > 100).expect("an element map");
        let mean_lx = mean_of(&scene, &solution, "body", |index| elements.values.value[index]);
        assert!((mean_lx / expected_lx - 1.0).abs() < 0.01, "{method:?}: {mean_lx}");
        assert!((mean_lx * (1.0 + PLANTED) / expected_lx - 1.0).abs() > 0.01);
    }
}

#[test]
fn rays_leave_the_side_they_start_from_and_meet_what_is_there() {
    let geometry = format!(
        r#"{{ "name": "body", "type": "spherical_harmonics", "coefficients": [{}], "material": "white", "two_sided": true }},
           {{ "name": "floor", "type": "rectangle", "origin": [-500,-500,-3], "u": [1000,0,0], "v": [0,1000,0], "material": "white" }}"#,
        lumpy()
    );
    let lamp = r#"{ "name": "lamp", "type": "point", "position": [0,0,9], "luminous_flux_lm": 1000 }"#;
    let scene = scene_of(r#""white": { "type": "diffuse", "reflectance": 0.5 }"#, &geometry, lamp, "");
    let (tracer, body) = (Tracer::new(&scene), &scene.bodies[0]);
    // The scene is a thousand times as large as the body, so that f32 resolves 30 µm.
    let mut again = 0;
    for k in 0..20_000u32 {
        let k_f = f64::from(k);
        let triangle = k % body.triangles.end;
        let at = [k_f * 0.618 % 0.5, k_f * 0.377 % 0.5];
        let (place_m, front) = body.place(triangle, at);
        let towards = direction((k_f * 0.7548) % 2.0 - 1.0, 2.4 * k_f);
        let side = if towards.dot(front) > 0.0 { Side::Front } else { Side::Back };
        if towards.dot(front).abs() < 1e-4 {
            continue;
        }
        match tracer.first_hit(&tracer.surface_origin(triangle, at, side), towards) {
            // A ray from inside meets the inside. A ray from outside meets the outside or what is beyond.
            Meeting::Surface(hit) if body.triangles.contains(&hit.triangle) => {
                assert_eq!(hit.side, side, "ray {k}");
                let met_m = body.place(hit.triangle, hit.barycentric).0;
                let found_m = place_m + hit.distance_m * towards;
                assert!(met_m.distance(found_m) < 1e-3, "ray {k}: {met_m} {found_m}");
                again += u32::from(side == Side::Front);
            }
            Meeting::Surface(_) | Meeting::Nothing => assert_eq!(side, Side::Front, "ray {k} leaked"),
            Meeting::Ball(_) => panic!("there is no ball"),
        }
    }
    assert!((10..5000).contains(&again), "{again} rays from the outside met a lump");
}

/// A closed mesh of an ellipsoid with half axes 1, 0.8 and 0.6 m.
fn ellipsoid_obj(rows: usize) -> String {
    let columns = 2 * rows;
    let mut text = String::from("v 0 0 0.6\nv 0 0 -0.6\n");
    for row in 1..rows {
        for column in 0..columns {
            let d = direction((PI * row as f64 / rows as f64).cos(), 2.0 * PI * column as f64 / columns as f64);
            writeln!(text, "v {} {} {}", d.x, 0.8 * d.y, 0.6 * d.z).expect("texts take everything");
        }
    }
    let corner = |row: usize, column: usize| 3 + (row - 1) * columns + column % columns;
    for column in 0..columns {
        writeln!(text, "f 1 {} {}", corner(1, column), corner(1, column + 1)).expect("texts take everything");
        writeln!(text, "f 2 {} {}", corner(rows - 1, column + 1), corner(rows - 1, column))
            .expect("texts take everything");
        for row in 1..rows - 1 {
            let [a, b] = [corner(row, column), corner(row, column + 1)];
            let [c, d] = [corner(row + 1, column + 1), corner(row + 1, column)];
            writeln!(text, "f {a} {d} {c}\nf {a} {c} {b}").expect("texts take everything");
        }
    }
    text
}

#[test]
fn an_ellipsoid_is_fitted_with_the_error_that_is_reported() {
    let folder = tempfile::TempDir::new().expect("a folder");
    std::fs::write(folder.path().join("e.obj"), ellipsoid_obj(96)).expect("written");
    let text = r#"{ "version": 1, "materials": { "m": { "type": "diffuse", "reflectance": 0.5 } },
        "geometry": [ { "name": "e", "type": "mesh", "file": "e.obj", "material": "m" } ],
        "luminaires": [ { "name": "l", "type": "point", "position": [0,0,9], "intensity_cd": 1 } ] }"#;
    let scene = scene_from_json(text, None, folder.path()).unwrap_or_else(|error| panic!("{error}"));
    let exact = |d: DVec3| (d / DVec3::new(1.0, 0.8, 0.6)).length_recip();
    let mut last = f64::INFINITY;
    for degree in [2, 6, 12, 20] {
        let fit = fit_harmonics(&scene, degree).expect("star-shaped");
        assert!(fit.center_m.length() < 1e-6 && fit.rms_error_m < last);
        last = fit.rms_error_m;
        // Compared with the ellipsoid itself, from which the mesh differs by some 3e-4.
        let differences = (0..4000).map(|k| {
            let d = direction(1.0 - (f64::from(k) + 0.5) / 2000.0, 2.4 * f64::from(k));
            (fit.series.value_and_slope(d).0 - exact(d)).powi(2)
        });
        let rms_m = (differences.sum::<f64>() / 4000.0).sqrt();
        assert!((rms_m - fit.rms_error_m).abs() < 5e-4, "degree {degree}: {rms_m} and {} told", fit.rms_error_m);
        if degree == 20 {
            // Volume 4π/3 abc, by the series. The mesh's volume is 0.1 % smaller.
            let series = HarmonicSeries::new(fit.series.coefficients().to_vec());
            let text = format!(
                r#"{{ "name": "b", "type": "spherical_harmonics", "coefficients": [{}], "material": "m" }}"#,
                (0..=20usize)
                    .flat_map(|l| (-(l as i64)..=l as i64).map(move |m| (l, m)))
                    .map(|(l, m)| format!("[{l},{m},{:e}]", series.coefficients()[(l * l + l) + m as usize]))
                    .collect::<Vec<_>>()
                    .join(",")
            );
            let lamp = r#"{ "name": "l", "type": "point", "position": [0,0,9], "intensity_cd": 1 }"#;
            let body = scene_of(r#""m": { "type": "diffuse", "reflectance": 0.5 }"#, &text, lamp, "");
            let volume_m3 = 4.0 / 3.0 * PI * 0.48;
            assert!((body.bodies[0].volume_m3() / volume_m3 - 1.0).abs() < 2e-3);
            // Area by quadrature over the ellipsoid itself: |r_θ × r_φ| on a fine grid.
            let (mut area_m2, steps) = (0.0, 400);
            for i in 0..steps {
                let theta = PI * (f64::from(i) + 0.5) / f64::from(steps);
                for j in 0..2 * steps {
                    let phi = PI * (f64::from(j) + 0.5) / f64::from(steps);
                    let d = direction(theta.cos(), phi);
                    let stretched = DVec3::new(0.48 * d.x, 0.6 * d.y, 0.8 * d.z);
                    area_m2 += stretched.length() * theta.sin() * (PI / f64::from(steps)).powi(2);
                }
            }
            assert!((body.bodies[0].area_m2() / area_m2 - 1.0).abs() < 1e-3, "{} {area_m2}", body.bodies[0].area_m2());
        }
    }
    assert!(last < 2e-3);
}

#[test]
fn a_torus_has_no_fit() {
    let folder = tempfile::TempDir::new().expect("a folder");
    let (around, across) = (24, 12);
    let mut obj = String::new();
    for i in 0..around {
        for j in 0..across {
            let (a, b) = (2.0 * PI * f64::from(i) / f64::from(around), 2.0 * PI * f64::from(j) / f64::from(across));
            let r = 1.0 + 0.3 * b.cos();
            writeln!(obj, "v {} {} {}", r * a.cos(), r * a.sin(), 0.3 * b.sin()).expect("texts take everything");
        }
    }
    let corner = |i: u32, j: u32| 1 + (i % 24) * 12 + j % 12;
    for i in 0..24 {
        for j in 0..12 {
            writeln!(obj, "f {} {} {} {}", corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1))
                .expect("texts take everything");
        }
    }
    std::fs::write(folder.path().join("t.obj"), obj).expect("written");
    let text = r#"{ "version": 1, "materials": { "m": { "type": "diffuse", "reflectance": 0.5 } },
        "geometry": [ { "name": "t", "type": "mesh", "file": "t.obj", "material": "m" } ],
        "luminaires": [ { "name": "l", "type": "point", "position": [0,0,9], "intensity_cd": 1 } ] }"#;
    let scene = scene_from_json(text, None, folder.path()).unwrap_or_else(|error| panic!("{error}"));
    assert!(matches!(fit_harmonics(&scene, 5), Err(NoFit::NotStarShaped { crossings, .. }) if crossings != 1));
}

#[test]
fn what_is_no_body_is_refused_with_its_place() {
    let refused = |body: &str, luminaire: &str| {
        let text = format!(
            r#"{{ "version": 1, "materials": {{ "m": {{ "type": "diffuse", "reflectance": 0.5 }} }},
            "geometry": [ {{ "name": "b", "type": "spherical_harmonics", {body}, "material": "m" }} ], "luminaires": [ {luminaire} ] }}"#
        );
        scene_from_json(&text, None, Path::new(".")).expect_err("refused").to_string()
    };
    let lamp = r#"{ "name": "l", "type": "point", "position": [0,0,9], "intensity_cd": 1 }"#;
    for (body, words) in [
        (r#""coefficients": [[0,0,1],[2,0,3]]"#, "not above 0 in all directions"),
        (r#""coefficients": [[0,0,1],[1,2,0.1]]"#, "not a term of a series"),
        (r#""coefficients": [[0,0,1],[0,0,1]]"#, "not a term of a series"),
        (r#""coefficients": [[0,0,1],[32,0,0.1]]"#, "0 to 31"),
        (r#""file": "nowhere.csv""#, "nowhere.csv"),
    ] {
        let message = refused(body, lamp);
        assert!(message.contains(words), "{message}");
    }
    let bright = r#"{ "name": "a", "type": "area", "surface": "b", "luminous_flux_lm": 1 }"#;
    assert!(refused(r#""coefficients": [[0,0,1]]"#, bright).contains("cannot emit"));
}
