//! Adaptive elements against the exact light at every point: their errors, shadows and bytes.

use glam::DVec3;
use luxmc::analytic::box_room::{BoxRoom, RoomFace, RoomSource};
use luxmc::scene::{Elements, Scene};
use luxmc::solver::{ElementChoice, MapSelection, Method, Settings, Solution, solve};

use crate::common::{Silent, scene_of};

fn adapted(scene: &Scene, seed: u64, target_error: f64) -> Solution {
    adapted_by(Method::Auto, scene, seed, target_error)
}

fn adapted_by(method: Method, scene: &Scene, seed: u64, target_error: f64) -> Solution {
    let settings = Settings {
        method,
        elements: ElementChoice::Adaptive,
        seed,
        target_error: Some(target_error),
        maps: MapSelection::Elements,
        ..Settings::default()
    };
    solve(scene, &settings, &Silent)
}

/// Pieces along an element's edge in which it is compared. At the edge of a shadow, coarser pieces blur what elements show.
const PIECES: u32 = 24;

/// Relative RMS deviation of what the elements show from the exact light over their whole area. With `slopes` false only their means are
/// used.
fn true_error(scene: &Scene, solution: &Solution, exact_lx: &dyn Fn(DVec3, DVec3) -> f64, slopes: bool) -> f64 {
    let (elements, map) = (&solution.elements, &solution.maps[0]);
    let (mut squares, mut sum, mut area_sum_m2) = (0.0, 0.0, 0.0);
    for index in 0..elements.len() {
        let element = elements.element(index as u32);
        let [a, b, c] = elements.corners_m(scene, element);
        let normal = scene.triangle_normal(element.triangle);
        let area_m2 = elements.area_m2(scene, element) / f64::from(PIECES * PIECES);
        for piece in 0..PIECES * PIECES {
            let corners = luxmc::scene::elements::part_corners(PIECES, piece);
            let [u, v] = [0, 1].map(|k| (corners[0][k] + corners[1][k] + corners[2][k]) / 3.0);
            let exact = exact_lx(a + u * (b - a) + v * (c - a), normal);
            let shown = if slopes { map.values.at_lx(index, [u, v]) } else { map.values.value[index] };
            squares += area_m2 * (shown - exact).powi(2);
            sum += area_m2 * exact;
            area_sum_m2 += area_m2;
        }
    }
    (squares / area_sum_m2).sqrt() / (sum / area_sum_m2)
}

/// Mean of some numbers in standard errors of that mean.
fn z_score(numbers: &[f64]) -> f64 {
    let count = numbers.len() as f64;
    let mean = numbers.iter().sum::<f64>() / count;
    let squares: f64 = numbers.iter().map(|number| (number - mean).powi(2)).sum();
    mean / (squares / (count * (count - 1.0))).sqrt()
}

#[test]
#[ignore = "takes long: .ci/run runs it"]
fn twelve_triangles_show_the_light_of_a_room_at_every_point() {
    // CIE 171 case 5.8 at ρ = 0.8 on 12 triangles, target 2 %: 16 seeds. The true error of means and slopes against the exact light at
    // every point is at or below the target in at least 14 (α = 0.4 % for a rule that keeps 95 %). Its square does not exceed that of the
    // stated error by 4 standard errors. Without the discretisation, or with means instead of slopes, it must. The stated error
    // intentionally contains one standard error of the discretisation more than its mean. Over 64 seeds, where the elements gather, it is
    // 1.22 times the true error, and at most 1.3 times is allowed.
    let scene = scene_of(
        r#"{"version": 1, "materials": {"paint": {"type": "diffuse", "reflectance": 0.8}},
            "geometry": [{"name": "cube", "type": "box", "min": [0,0,0], "max": [4,4,4], "facing": "inward",
                          "material": "paint"}],
            "luminaires": [{"name": "source", "type": "point", "position": [2,2,2], "luminous_flux_lm": 10000}]}"#,
    );
    let intensity_cd = 10_000.0 / (4.0 * std::f64::consts::PI);
    let source = RoomSource::Point { position: DVec3::splat(2.0), intensity_cd };
    let room = BoxRoom { size_m: [4.0; 3], reflectances: [0.8; 6], sources: vec![source] };
    let exact = room.solve().expect("the room absorbs");
    // All faces are alike, and so are their eight mirrored parts. The table holds one quarter and is bilinear between its points.
    const STEPS: usize = 40;
    let table: Vec<Vec<f64>> = (0..=STEPS)
        .map(|i| {
            let at = |j: usize| {
                let [u, v] = [i, j].map(|step| 2.0 * step as f64 / STEPS as f64);
                exact.on_face(RoomFace::Floor, u, v).expect("on the face").total_lx()
            };
            (0..=STEPS).map(at).collect()
        })
        .collect();
    let exact_lx = |point: DVec3, normal: DVec3| {
        let places: Vec<f64> =
            (0..3).filter(|axis| normal[*axis].abs() < 0.5).map(|axis| point[axis].min(4.0 - point[axis])).collect();
        let cell = |place: f64| ((place / 2.0 * STEPS as f64) as usize).min(STEPS - 1);
        let (i, j) = (cell(places[0]), cell(places[1]));
        let (x, y) = (places[0] / 2.0 * STEPS as f64 - i as f64, places[1] / 2.0 * STEPS as f64 - j as f64);
        (1.0 - x) * ((1.0 - y) * table[i][j] + y * table[i][j + 1])
            + x * ((1.0 - y) * table[i + 1][j] + y * table[i + 1][j + 1])
    };

    let runs: Vec<Solution> = (0..16).map(|seed| adapted(&scene, seed, 0.02)).collect();
    let errors: Vec<f64> = runs.iter().map(|run| true_error(&scene, run, &exact_lx, true)).collect();
    assert!(runs.iter().all(|run| run.target_met == Some(true)));
    let met = errors.iter().filter(|error| **error <= 0.02).count();
    assert!(met >= 14, "{met} of 16 at or under the target: {errors:?}");
    let counts: Vec<usize> = runs.iter().map(|run| run.elements.len()).collect();
    assert!(counts.iter().all(|count| (48..2000).contains(count)), "{counts:?}");

    let stated = |with: &dyn Fn(&Solution) -> f64| -> Vec<f64> { runs.iter().map(with).collect() };
    let agrees = |errors: &[f64], stated: &[f64]| {
        let differences: Vec<f64> = errors.iter().zip(stated).map(|(e, s)| e * e - s * s).collect();
        z_score(&differences)
    };
    let whole = stated(&|run| run.maps[0].error.estimated);
    let z = agrees(&errors, &whole);
    assert!(z < 4.0, "z = {z}: true {errors:?}, stated {whole:?}");
    let mean_square = |errors: &[f64]| errors.iter().map(|error| error * error).sum::<f64>() / errors.len() as f64;
    let excess = (mean_square(&whole) / mean_square(&errors)).sqrt();
    assert!(excess < 1.3, "{excess} times the true error is stated");
    let means: Vec<f64> = runs.iter().map(|run| true_error(&scene, run, &exact_lx, false)).collect();
    assert!(agrees(&means, &whole) > 4.0, "means for slopes must show: {}", agrees(&means, &whole));
    // With counted chains no bias is stated in addition.
    let counted: Vec<Solution> = (0..16).map(|seed| adapted_by(Method::Collision, &scene, seed, 0.03)).collect();
    let errors: Vec<f64> = counted.iter().map(|run| true_error(&scene, run, &exact_lx, true)).collect();
    let random: Vec<f64> = counted.iter().map(|run| run.maps[0].error.random).collect();
    let left_out = agrees(&errors, &random);
    assert!(left_out > 4.0, "discretisation left out must show: {left_out}");
}

/// A black floor of 4 m under a lamp at 3 m, with a plate of 1 m at half the height.
fn shadow() -> (Scene, impl Fn(DVec3, DVec3) -> f64) {
    let scene = scene_of(
        r#"{"version": 1, "materials": {"black": {"type": "diffuse", "reflectance": 0}},
            "geometry": [
              {"name": "floor", "type": "rectangle", "origin": [0,0,0], "u": [4,0,0], "v": [0,4,0], "material": "black"},
              {"name": "plate", "type": "rectangle", "origin": [1.3,1.1,1.5], "u": [1,0,0], "v": [0,1,0], "material": "black"}],
            "luminaires": [{"name": "lamp", "type": "point", "position": [2,2,3], "intensity_cd": 900}]}"#,
    );
    let lamp = DVec3::new(2.0, 2.0, 3.0);
    let exact_lx = move |point: DVec3, _: DVec3| {
        let to_lamp = lamp - point;
        let crossing = point + to_lamp * ((1.5 - point.z) / to_lamp.z);
        let hidden = point.z < 1.0 && (1.3..2.3).contains(&crossing.x) && (1.1..2.1).contains(&crossing.y);
        if hidden { 0.0 } else { 900.0 * to_lamp.z / to_lamp.length().powi(3) }
    };
    (scene, exact_lx)
}

#[test]
fn the_edge_of_a_shadow_is_found_and_its_error_reported() {
    // Exact light with a hard shadow on 4 triangles, target 3 %: 5 seeds. Every true error is at or below the target. The mean square of
    // the true errors is that of the stated ones within 15 %. (8 seeds scatter by some 4 %, 5 by 5 %; 24 had 0.96, and 1.20 when the pilot
    // sampled large elements no more often than small ones and missed corners that the edge cuts off.) The stated random part alone would
    // miss most of it. The elements at the edge are finer than the rest. With elements of one size there would be several times as many.
    let (scene, exact_lx) = shadow();
    let (mut true_squares, mut stated_squares, mut random_squares) = (0.0, 0.0, 0.0);
    for seed in 0..5 {
        let run = adapted(&scene, seed, 0.03);
        let error = true_error(&scene, &run, &exact_lx, true);
        let stated = run.maps[0].error.estimated;
        assert!(run.target_met == Some(true) && error <= 0.03, "seed {seed}: {error} against {stated}");
        true_squares += error.powi(2);
        stated_squares += stated.powi(2);
        random_squares += run.maps[0].error.random.powi(2);
        let areas =
            (0..run.elements.len() as u32).map(|index| run.elements.area_m2(&scene, run.elements.element(index)));
        let (least, most) = areas.fold((f64::INFINITY, 0.0f64), |(low, high), area| (low.min(area), high.max(area)));
        assert!(most / least > 200.0, "{least} to {most}");
        let uniform = 16.0 / least;
        assert!(uniform > 4.0 * run.elements.len() as f64, "{} of {uniform}", run.elements.len());
    }
    let ratio = true_squares / stated_squares;
    assert!((0.85..1.15).contains(&ratio), "mean square of true over stated errors: {ratio}");
    assert!(
        true_squares > 2.0 * random_squares,
        "the random part alone must not tell: {true_squares} {random_squares}"
    );
}

#[test]
fn adapted_maps_are_the_same_for_any_number_of_threads() {
    let scene = scene_of(
        r#"{"version": 1, "materials": {"paint": {"type": "diffuse", "reflectance": 0.6}},
            "geometry": [{"name": "room", "type": "box", "min": [0,0,0], "max": [5,3,2.5], "facing": "inward", "material": "paint"},
                         {"name": "desk", "type": "rectangle", "origin": [1,1,0.8], "u": [1.6,0,0], "v": [0,0.8,0], "two_sided": true, "material": "paint"},
                         {"name": "panel", "type": "rectangle", "origin": [2,1,2.4], "u": [0,0.6,0], "v": [0.6,0,0], "material": "paint"}],
            "luminaires": [{"name": "light", "type": "area", "surface": "panel", "exitance_lm_m2": 5000}]}"#,
    );
    let with_threads = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads start");
        pool.install(|| adapted(&scene, 3, 0.05))
    };
    let [one, three] = [1, 3].map(with_threads);
    assert!(one.elements.len() > Elements::of(&scene).len());
    assert_eq!(one.elements.len(), three.elements.len());
    assert_eq!(one.maps[0].values.value, three.maps[0].values.value);
    assert_eq!(one.maps[0].values.slopes_lx, three.maps[0].values.slopes_lx);
    assert_eq!(one.maps[0].error, three.maps[0].error);
}

#[test]
fn given_elements_stay_as_they_are() {
    let (scene, _) = shadow();
    let settings = Settings { target_error: Some(0.03), ..Settings::default() };
    let run = solve(&scene, &settings, &Silent);
    assert_eq!(run.elements.len(), Elements::of(&scene).len());
    assert!(run.maps[0].values.slopes_lx.is_empty() && run.maps[0].error.discretisation == 0.0);
}

/// A closed room with a cupboard on its floor. All surfaces emit what they do not reflect of 100 lx.
fn isothermal_room() -> Scene {
    let [size, foot] = [[4.0, 3.0, 2.5], [0.6, 0.7, 0.9]];
    let faces = |name: &str, [x, y, z]: [f64; 3]| {
        let sides = [
            ("x_min", y * z),
            ("x_max", y * z),
            ("y_min", x * z),
            ("y_max", x * z),
            ("floor", x * y),
            ("ceiling", x * y),
        ];
        sides.map(|(side, area_m2)| {
            let luminous_flux_lm = 0.5 * 100.0 * area_m2;
            format!(
                r#"{{"name": "{name} {side}", "type": "area", "surface": "{name}/{side}", "luminous_flux_lm": {luminous_flux_lm}}}"#
            )
        })
    };
    let luminaires = [faces("room", size), faces("cupboard", foot)].concat().join(", ");
    scene_of(&format!(
        r#"{{"version": 1, "materials": {{"paint": {{"type": "diffuse", "reflectance": 0.5}}}},
            "geometry": [
              {{"name": "room", "type": "box", "min": [0,0,0], "max": [4,3,2.5], "facing": "inward", "material": "paint"}},
              {{"name": "cupboard", "type": "box", "min": [1.1,0.8,0], "max": [1.7,1.5,0.9], "facing": "outward", "material": "paint"}}],
            "luminaires": [{luminaires}]}}"#
    ))
}

#[test]
fn what_stands_on_a_floor_darkens_nothing_beside_it() {
    // In an isothermal room of 24 triangles every point not hidden by contact has 100 lx (Kirchhoff 1860). A cupboard of 0.6 m by 0.7 m
    // hides 0.42 m² of the floor. Target 2 %, 8 seeds: outside of the hidden area the elements are within the target, for at least seven of
    // the eight seeds and with few elements. The dark area is not larger than that under the cupboard and the cupboard's own bottom. Means
    // over whole elements (the planted fault) are wrong by at least a third more. All runs are by gathering: counted packets would include
    // those that the hidden floor itself emits.
    let scene = isothermal_room();
    let error_of = |elements: ElementChoice, seed: u64| {
        let settings = Settings {
            elements,
            seed,
            target_error: Some(0.02),
            maps: MapSelection::Elements,
            method: Method::Gather,
            ..Settings::default()
        };
        let solution = solve(&scene, &settings, &Silent);
        let values = &solution.maps[0].values;
        let (mut squares, mut lit_m2, mut dark_m2) = (0.0, 0.0, 0.0);
        for (index, lx) in values.value.iter().enumerate() {
            let area_m2 = solution.elements.area_m2(&scene, solution.elements.element(index as u32));
            if *lx < 1.0 {
                dark_m2 += area_m2;
                continue;
            }
            lit_m2 += area_m2;
            for middle in [[0.5, 0.0], [0.0, 0.5], [0.5, 0.5]] {
                let shown = if values.slopes_lx.is_empty() { *lx } else { values.at_lx(index, middle) };
                squares += area_m2 / 3.0 * (shown / 100.0 - 1.0).powi(2);
            }
        }
        ((squares / lit_m2).sqrt(), dark_m2, solution.elements.len())
    };
    let runs: Vec<_> = (0..8).map(|seed| error_of(ElementChoice::Adaptive, seed)).collect();
    let met = runs.iter().filter(|(error, ..)| *error <= 0.02).count();
    assert!(met >= 7, "{runs:?}");
    assert!(runs.iter().all(|(_, dark_m2, count)| *dark_m2 <= 0.85 && *count < 3000), "{runs:?}");
    let (faulty, ..) = error_of(ElementChoice::Given, 0);
    let mean = runs.iter().map(|(error, ..)| error).sum::<f64>() / 8.0;
    assert!(faulty > 1.3 * mean, "means over whole elements pass: {faulty} beside {mean}");
}
