//! Luminance, local estimation and glare against exact values or other methods.

use std::f64::consts::PI;
use std::path::Path;

use glam::DVec3;
use luxmc::analytic::sobolev::{SobolevPlane, SobolevProblem, sobolev};
use luxmc::base::glare::unified_glare_rating;
use luxmc::base::position_index::position_index;
use luxmc::check::scene_from_json;
use luxmc::geometry::Meeting;
use luxmc::sampling::random::{Purpose, Stream};
use luxmc::sampling::reflection::{LobeKind, Pair};
use luxmc::scene::{Emission, ReceiverPoint, Scene};
use luxmc::solver::{MapSelection, Method, Settings, Solution, solve};
use luxmc::transport::World;

use crate::common::{Silent, scene, slow, with_chains};

fn from_text(text: &str) -> Scene {
    scene_from_json(text, None, Path::new(".")).unwrap_or_else(|error| panic!("{error}"))
}

fn by_method(scene: &Scene, method: Method, seed: u64, chains: u64) -> Solution {
    let maps = MapSelection::Receivers;
    solve(scene, &Settings { method, seed, chains: Some(chains), maps, ..Settings::default() }, &Silent)
}

const PLANES: &str = r#""materials": { "grey": { "type": "diffuse", "reflectance": 0.5 } },
  "geometry": [
    { "name": "plane 1", "type": "rectangle", "origin": [-100, -100, 0], "u": [200, 0, 0], "v": [0, 200, 0], "material": "grey" },
    { "name": "plane 2", "type": "rectangle", "origin": [-100, -100, 1], "u": [0, 200, 0], "v": [200, 0, 0], "material": "grey" } ],
  "luminaires": [ { "name": "source", "type": "point", "position": [0, 0, 0.5], "intensity_cd": 1 } ]"#;

/// An eye looks at right angles between two mirrors that absorb nothing and sees an endless row of mirrors. The run must end. The floor, in
/// another direction, has the luminance ρE/π of the direct light and of the source's images.
#[test]
fn a_sight_between_perfect_mirrors_ends() {
    let mirror = |name: &str, y: f64, u: &str, v: &str| {
        format!(
            r#"{{ "name": "{name}", "type": "rectangle", "origin": [-5, {y}, 0], "u": {u}, "v": {v}, "material": "mirror" }}"#
        )
    };
    let scene = from_text(&format!(
        r#"{{ "version": 1, "materials": {{ "mirror": {{ "type": "mirror", "reflectance": 1 }}, "grey": {{ "type": "diffuse", "reflectance": 0.5 }} }},
          "geometry": [ {}, {}, {{ "name": "floor", "type": "rectangle", "origin": [-5, 0, 0], "u": [10, 0, 0], "v": [0, 1, 0], "material": "grey" }} ],
          "luminaires": [ {{ "name": "source", "type": "point", "position": [0, 0.5, 2], "intensity_cd": 100 }} ],
          "receivers": [ {{ "name": "across", "type": "luminance", "position": [1, 0.5, 1], "directions": [[0, 1, 0]] }},
                         {{ "name": "down", "type": "luminance", "position": [1, 0.5, 1], "directions": [[0, 0, -1]] }} ] }}"#,
        mirror("left", 0.0, "[0, 0, 3]", "[10, 0, 0]"),
        mirror("right", 1.0, "[10, 0, 0]", "[0, 0, 3]"),
    ));
    let solution = by_method(&scene, Method::Collision, 3, 10_000);
    let values = |name: &str| &solution.maps.iter().find(|map| map.name == name).expect("the map").values;
    assert_eq!(values("across").value, [0.0]);
    // The images are whole numbers of metres beside the source, on either side. All light comes from them.
    let light = |image: i32| 100.0 * 2.0 / (1.0 + 4.0 + f64::from(image).powi(2)).powf(1.5);
    // The light comes from 2 m, so that mirrors 3 m high reflect all of its paths.
    let exact = 0.5 / PI * (-2000..=2000).map(light).sum::<f64>();
    let (value, error) = (values("down").value[0], values("down").standard_error[0]);
    assert!((value - exact).abs() < 6.0 * error + 0.02 * exact, "{value} ± {error}, exactly {exact}");
    assert!((1.1 * value - exact).abs() > 6.0 * error + 0.02 * exact, "{value} ± {error}, exactly {exact}");
}

/// A diffuse plane has the luminance ρE/π in every direction, by walks and by double local estimation.
///
/// 29 directions from a height of 0.5, up to 70° from the vertical. E is by Sobolev's integral at each point below the line of sight. Every
/// deviation is within 5.5 standard errors (t with 15 degrees of freedom: α = 6e-5 each), the mean one within 4.5 of its own. The planted
/// fault, 2 % more light, is rejected by the mean.
#[test]
fn diffuse_planes_look_alike_from_every_angle() {
    let scene = from_text(&format!(
        r#"{{ "version": 1, {PLANES}, "receivers": [ {{ "name": "fan", "type": "luminance", "position": [1, 0.2, 0.5],
          "fan": {{ "direction": [0, 0, -1], "axis": [0, 1, 0], "from_deg": -70, "to_deg": 70, "count": 29 }} }} ] }}"#
    ));
    let problem = SobolevProblem { h1: 0.5, rho1: 0.5, rho2: 0.5 };
    for (method, chains) in [(Method::Collision, 29 * 80_000), (Method::Local, 60_000)] {
        let solution = by_method(&scene, method, 5, chains);
        let values = &solution.maps[0].values;
        let (mut sum, mut square) = (0.0, 0.0);
        for (index, point) in scene.receivers[0].points.iter().enumerate() {
            let reach = 0.5 / -point.normal.z;
            let seen = point.position_m + reach * point.normal;
            let e = sobolev(&problem, SobolevPlane::One, seen.truncate().length()).expect("a value").total_lx;
            let exact = 0.5 * e / PI;
            let (value, error) = (values.value[index], values.standard_error[index]);
            assert!((value - exact).abs() < 5.5 * error, "{method:?} {index}: {value} ± {error}, exactly {exact}");
            sum += value / exact - 1.0;
            square += (error / exact).powi(2);
        }
        // Walks are independent. Errors of shared chains add linearly in the worst case, not as squares.
        let share = if method == Method::Collision { square.sqrt() / 29.0 } else { (square / 29.0).sqrt() };
        assert!((sum / 29.0).abs() < 4.5 * share, "{method:?}: {} ± {share}", sum / 29.0);
        assert!(0.02 - (sum / 29.0).abs() > 4.5 * share, "{method:?}: the fault passed, {} ± {share}", sum / 29.0);
    }
}

/// In an isothermal box E = πL₀ everywhere. On the floor at 0.1 m and 1e-5 m from a wall (in the slow run also at 1e-3 m, with sixteen
/// times the chains), the error bars of local estimation cover the truth at their nominal 95 %, t with 15 degrees of freedom, within 4.5 %.
/// There are 200 seeds × 8 correlated points; 200 independent seeds alone have a standard deviation of 1.5 %. The root mean square error
/// does not grow towards the wall. The bars of the plain kernel cover less than half.
#[test]
fn local_estimation_holds_its_error_bars_in_corners() {
    let mut errors = Vec::new();
    let (distances_m, chains) = if slow() { (vec![1e-1, 1e-3, 1e-5], 1024) } else { (vec![1e-1, 1e-5], 64) };
    for distance_m in distances_m {
        let scene = from_text(&format!(
            r#"{{ "version": 1, "materials": {{ "grey": {{ "type": "diffuse", "reflectance": 0.5 }} }},
          "geometry": [ {{ "name": "box", "type": "box", "min": [0,0,0], "max": [2,2,2], "facing": "inward", "material": "grey" }} ],
          "luminaires": [ {{ "name": "glow", "type": "area", "surface": "box", "exitance_lm_m2": 157.07963267948966 }} ],
          "receivers": [ {{ "name": "edge", "type": "grid", "origin": [{distance_m}, 0.5, 0], "u": [0,1,0], "v": [-1e-9,0,0], "columns": 8, "rows": 1 }} ] }}"#
        ));
        let run = |method: Method, seeds: u64| {
            let (mut within, mut squares) = (0.0, 0.0);
            for seed in 0..seeds {
                let solution = by_method(&scene, method, seed, chains);
                let values = &solution.maps[0].values;
                for (value, error) in values.value.iter().zip(&values.standard_error) {
                    within += f64::from(u8::from((value - 100.0 * PI).abs() < 2.131 * error));
                    squares += (value / (100.0 * PI) - 1.0).powi(2);
                }
            }
            let count = 8.0 * seeds as f64;
            (within / count, (squares / count).sqrt())
        };
        let (within, error) = run(Method::Local, 200);
        assert!((within - 0.95).abs() < 0.045, "{distance_m} m: {within}");
        errors.push(error);
        if distance_m < 0.01 {
            let (within, _) = run(Method::LocalNaive, 20);
            assert!(within < 0.5, "the plain kernel at {distance_m} m: {within}");
        }
    }
    assert!(errors[errors.len() - 1] < 1.5 * errors[0], "{errors:?}");
}

/// Local estimation agrees with walks for emitting, mirroring and transmitting surfaces: the means agree within 4.5 standard errors of
/// their difference, and 5 % more light (the planted fault) is rejected.
#[test]
fn local_estimation_agrees_with_walks_on_every_material() {
    let scene = from_text(
        r#"{ "version": 1,
      "materials": { "grey": { "type": "diffuse", "reflectance": 0.6 }, "mirror": { "type": "mirror", "reflectance": 0.8 },
        "lacquer": { "type": "phong", "diffuse_reflectance": 0.3, "specular_reflectance": 0.4, "exponent": 30 },
        "shade": { "type": "translucent", "diffuse_reflectance": 0.4, "diffuse_transmittance": 0.3 },
        "pane": { "type": "glass", "refractive_index": 1.5, "internal_transmittance": 0.95 } },
      "geometry": [
        { "name": "room", "type": "box", "min": [0,0,0], "max": [4,3,3], "facing": "inward", "material": "grey",
          "materials": { "floor": "lacquer", "x_max": "mirror" } },
        { "name": "pane", "type": "rectangle", "origin": [2,0,0], "u": [0,3,0], "v": [0,0,3], "material": "pane" },
        { "name": "shade", "type": "rectangle", "origin": [0.5,1,2], "u": [1,0,0], "v": [0,1,0], "material": "shade" } ],
      "luminaires": [ { "name": "lamp", "type": "point", "position": [1,1.5,2.5], "intensity_cd": 100 },
        { "name": "globe", "type": "sphere", "center": [3,2,2], "radius": 0.1, "luminous_flux_lm": 800 } ],
      "receivers": [
        { "name": "plane", "type": "grid", "origin": [0.3,0.5,0.7], "u": [3,0,0], "v": [0,2,0], "columns": 4, "rows": 3 },
        { "name": "cylinders", "type": "grid", "origin": [0.3,0.5,1.2], "u": [3,0,0], "v": [0,2,0], "columns": 2, "rows": 2,
          "quantity": "semi-cylindrical", "direction": [0,1,0] },
        { "name": "eye", "type": "luminance", "position": [0.5,0.4,1.5],
          "directions": [[0.1,1,-0.3],[1,0.5,0],[0.5,1,-1],[1,1.8,0.4],[0.3,1,0.62],[1,0.2,-0.8]] } ] }"#,
    );
    let mut runs = [Method::Collision, Method::Local].map(|method| {
        solve(
            &scene,
            &Settings {
                method,
                seed: 9,
                target_error: Some(0.02),
                maps: MapSelection::Receivers,
                ..Settings::default()
            },
            &Silent,
        )
    });
    let units: Vec<&str> = runs[0].maps.iter().map(|map| map.quantity.unit()).collect();
    assert_eq!(units, ["lx", "lx", "cd/m²"]);
    for map in 0..3 {
        let [walks, local] = &mut runs;
        let averages = [&walks.maps[map], &local.maps[map]].map(|map| map.tables[0].average);
        let error = averages[0].standard_error.hypot(averages[1].standard_error);
        let off = averages[1].value - averages[0].value;
        assert!(off.abs() < 4.5 * error, "{}: {averages:?}", walks.maps[map].name);
        assert!(0.05 * averages[0].value - off.abs() > 4.5 * error, "{}: the fault passed", walks.maps[map].name);
    }
}

/// A glossy plane under a bright ball, seen along a fan of directions. Results by light samples, lobes and walks combined, and by double
/// local estimation, are compared with backward paths. These draw a direction in the ball's cone at every vertex and share only the BSDF
/// with the estimators. Five directions, 200,000 paths each: within 4.9 standard errors of the difference. In the mean over the directions,
/// 2 % less light (the planted fault) is rejected.
#[test]
fn glossy_planes_shine_as_plain_paths_say() {
    let scene = from_text(
        r#"{ "version": 1,
      "materials": { "lacquer": { "type": "phong", "diffuse_reflectance": 0.3, "specular_reflectance": 0.4, "exponent": 20 } },
      "geometry": [
        { "name": "plane 1", "type": "rectangle", "origin": [-50, -50, 0], "u": [100, 0, 0], "v": [0, 100, 0], "material": "lacquer" },
        { "name": "plane 2", "type": "rectangle", "origin": [-50, -50, 1], "u": [0, 100, 0], "v": [100, 0, 0], "material": "lacquer" } ],
      "luminaires": [ { "name": "ball", "type": "sphere", "center": [0, 0, 0.5], "radius": 0.2, "luminous_flux_lm": 10 } ],
      "receivers": [ { "name": "fan", "type": "luminance", "position": [0.9, 0, 0.3],
        "fan": { "direction": [0, 0, -1], "axis": [0, 1, 0], "from_deg": -50, "to_deg": 70, "count": 5 } } ] }"#,
    );
    const PATHS: u64 = 200_000;
    const FAULT: f64 = 0.02;
    let walks = with_chains(&scene, 1, MapSelection::Receivers, 5 * (1 << 18));
    let local = by_method(&scene, Method::Local, 2, 1 << 16);
    let world = World::new(&scene);
    let ball_cd_m2 = world.emitters.list()[0].exitance_lm_m2().expect("a ball") / PI;
    let (mut mean, mut mean_square) = (0.0, 0.0f64);
    for (index, point) in scene.receivers[0].points.iter().enumerate() {
        let mut stream = Stream::new(77, Purpose::Pilot, index as u32, 0);
        let (mut sum, mut squares) = (0.0, 0.0);
        for path in 0..PATHS {
            stream.seek(path);
            let luminance = ball_cd_m2 * backward_path(&world, point, &mut stream);
            sum += luminance;
            squares += luminance * luminance;
        }
        let plain = sum / PATHS as f64;
        let plain_error = ((squares / PATHS as f64 - plain * plain) / PATHS as f64).sqrt();
        for (method, solution) in [("walks", &walks), ("local", &local)] {
            let values = &solution.maps[0].values;
            let error = plain_error.hypot(values.standard_error[index]);
            let off = values.value[index] - plain;
            let value = values.value[index];
            assert!(off.abs() < 4.9 * error, "{method} {index}: {value} against {plain} ± {error}");
            if method == "walks" {
                mean += off / plain / 5.0;
                mean_square += (error / plain / 5.0).powi(2);
            }
        }
    }
    // Walks of different directions are independent.
    let error = mean_square.sqrt();
    assert!(mean.abs() < 4.5 * error, "{mean} ± {error}");
    assert!(FAULT - mean.abs() > 4.5 * error, "the planted fault passed: {mean} ± {error}");
}

/// One backward path to the ball of radius 0.2 at (0, 0, 0.5). Returns its luminance divided by that of the ball.
fn backward_path(world: &World, eye: &ReceiverPoint, stream: &mut Stream) -> f64 {
    let (mut origin, mut direction) = (world.tracer.free_origin(eye.position_m), eye.normal);
    let mut sum = 0.0;
    while let Meeting::Surface(hit) = world.tracer.first_hit(&origin, direction) {
        let normal = world.normal(hit.triangle, hit.side);
        let bsdf = world.bsdf(hit.triangle);
        origin = world.leave(&hit, LobeKind::Spread);
        let offset = DVec3::new(0.0, 0.0, 0.5) - world.tracer.position_m(&origin);
        let one_minus_cos = 1.0 - (1.0 - 0.04 / offset.length_squared()).sqrt();
        let [u, v] = stream.pair();
        let cosine = 1.0 - u * one_minus_cos;
        let sine = (1.0 - cosine * cosine).max(0.0).sqrt();
        let axis = offset.normalize();
        let (across, upright) = axis.any_orthonormal_pair();
        let (turn_sine, turn_cosine) = (2.0 * PI * v).sin_cos();
        let towards = cosine * axis + sine * (turn_cosine * across + turn_sine * upright);
        if towards.dot(normal) > 0.0 && matches!(world.tracer.first_hit(&origin, towards), Meeting::Ball(_)) {
            let pair = Pair { normal, towards, leaving: -direction };
            sum += bsdf.eval_per_sr(&pair) * towards.dot(normal) * 2.0 * PI * one_minus_cos;
        }
        let Some(scattered) = bsdf.sample(direction, normal, stream) else { break };
        direction = scattered.direction;
    }
    sum
}

/// In the office the rating follows from a quadrature over the luminaires (60 × 60 parts of each troffer, all visible) and from the
/// indirect illuminance of a receiver at the eye from another seed.
#[test]
fn the_glare_of_the_office_is_that_of_a_quadrature() {
    let mut office = scene("office.json");
    let eye = DVec3::new(0.4, 3.0, 1.2);
    let observer = from_text(&format!(
        r#"{{ "version": 1, {PLANES}, "receivers": [
          {{ "name": "desk", "type": "ugr", "position": [0.4, 3.0, 1.2], "view_direction": [1, 0, 0] }},
          {{ "name": "upright", "type": "grid", "origin": [0.4, 3.0, 1.2], "u": [0, 1e-9, 0], "v": [0, 0, 1e-9], "columns": 1, "rows": 1 }} ] }}"#
    ));
    office.receivers = observer.receivers;
    let maps = |name: &str| MapSelection::Named(vec![name.to_owned()]);
    let rated = with_chains(&office, 1, maps("desk"), 400_000);
    let upright = with_chains(&office, 2, maps("upright"), 400_000);
    let rating = &rated.glare[0];
    let ugr = rating.ugr.expect("a rating");

    let mut sum = 0.0;
    for luminaire in &office.luminaires {
        match &luminaire.emission {
            Emission::Area { surfaces, exitance_lm_m2, .. } => {
                for triangle in surfaces.iter().flat_map(|id| office.surfaces[*id as usize].triangles.clone()) {
                    const N: u32 = 60;
                    let [a, b, c] = office.corners_m(triangle);
                    let part_m2 = office.triangle_area_m2(triangle) / f64::from(N * N);
                    for i in 0..N {
                        for j in 0..N {
                            // The centres of a square grid, folded onto the triangle.
                            let (mut u, mut v) =
                                ((f64::from(i) + 0.5) / f64::from(N), (f64::from(j) + 0.49) / f64::from(N));
                            if u + v > 1.0 {
                                (u, v) = (1.0 - u, 1.0 - v);
                            }
                            let offset = a + u * (b - a) + v * (c - a) - eye;
                            let towards = offset.normalize();
                            let Ok(p) = position_index(DVec3::X, towards) else { continue };
                            let cosine = office.triangle_normal(triangle).dot(-towards).max(0.0);
                            let luminance = exitance_lm_m2 / PI;
                            sum += luminance * luminance * part_m2 * cosine / offset.length_squared() / (p * p);
                        }
                    }
                }
            }
            Emission::Photometric { position_m, frame, web, opening, scale } => {
                let offset = *position_m - eye;
                let towards = offset.normalize();
                let Ok(p) = position_index(DVec3::X, towards) else { continue };
                let luxmc::scene::photometry::Opening::Disk { diameter_m } = *opening else { panic!("a disk") };
                let area = PI / 4.0 * diameter_m * diameter_m * towards.z.abs();
                let intensity = scale * web.intensity_towards_cd(frame, -towards);
                sum += intensity * intensity / (area * offset.length_squared() * p * p);
            }
            _ => panic!("the office has troffers and downlights"),
        }
    }
    assert!((rating.glare_sum.value / sum - 1.0).abs() < 2e-3, "{:?} {sum}", rating.glare_sum);
    let background = upright.maps[0].values.indirect[0] / PI;
    let background_error = upright.maps[0].values.standard_error[0] / PI;
    let expected = unified_glare_rating(background, sum).expect("a rating");
    let error = ugr.standard_error.hypot(8.0 / 10f64.ln() * background_error / background);
    assert!((ugr.value - expected).abs() < 4.0 * error, "{ugr:?} {expected} ± {error}");
    // A background 2 % off (the planted fault) changes the rating by 0.069.
    assert!(0.069 - (ugr.value - expected).abs() > 4.0 * error, "the fault passed: {ugr:?} {expected} ± {error}");
}
