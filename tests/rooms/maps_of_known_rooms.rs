//! Whole runs against rooms whose answer is known.

use luxmc::analytic::box_room::{BoxRoom, RoomFace, RoomSource};
use luxmc::control::Forecast;
use luxmc::maps::Estimate;
use luxmc::scene::{Elements, Emission, Luminaire, ReceiverLayout, Scene};
use luxmc::solver::{ConvergenceRow, MapSelection, Solution, StopReason};

use crate::common::{T15_QUANTILE_95_4, cube, scene, slow, to_target, with_chains};

/// Mean by area of the indirect light of the element map in lx.
fn mean_indirect_lx(scene: &Scene, solution: &Solution) -> f64 {
    let elements = Elements::of(scene);
    let map = &solution.maps[0];
    let (mut sum, mut area) = (0.0, 0.0);
    for (index, indirect_lx) in map.values.indirect.iter().enumerate() {
        let area_m2 = elements.area_m2(scene, elements.element(index as u32));
        sum += area_m2 * indirect_lx;
        area += area_m2;
    }
    sum / area
}

fn mean_and_error(values: &[f64]) -> Estimate {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let squares: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
    Estimate { value: mean, standard_error: (squares / (n * (n - 1.0))).sqrt() }
}

#[test]
fn cie_171_case_5_8_averages_are_met() {
    // Eight seeds (0 to 7): the mean is within 3.5 standard errors (t with 7 degrees of freedom, α = 1 %), and the standard error is ≤ 0.2
    // % (0.1 % in the slow run). A reflectance that is 1 % off, which changes the mean by 4 % and more, must be detected. A chain's hits
    // scatter as widely as their mean, so that 0.1 % takes a million chains. That and the reflectance 0.99 are left to the slow run.
    let (share, most_error) = if slow() { (1, 1e-3) } else { (4, 2e-3) };
    let cases = [(0.8, 1_250.0 / 3.0, 170_000), (0.95, 23_750.0 / 12.0, 170_000), (0.99, 10_312.5, 400_000)];
    for (reflectance, average_lx, chains) in cases.into_iter().take(if slow() { 3 } else { 2 }) {
        let scene = cube(reflectance, 1.0);
        let means: Vec<f64> = (0..8)
            .map(|seed| mean_indirect_lx(&scene, &with_chains(&scene, seed, MapSelection::Elements, chains / share)))
            .collect();
        let mean = mean_and_error(&means);
        assert!(mean.standard_error < most_error * average_lx, "ρ = {reflectance}: {mean:?}");
        let z = (mean.value - average_lx) / mean.standard_error;
        assert!(z.abs() < 3.5, "ρ = {reflectance}: {mean:?} against {average_lx}, z = {z}");
        let faulty_lx = 0.99 * reflectance * 10_000.0 / (96.0 * (1.0 - 0.99 * reflectance));
        let z = (mean.value - faulty_lx) / mean.standard_error;
        assert!(z.abs() > 3.5, "ρ = {reflectance}: the planted fault passed, z = {z}");
    }
}

#[test]
fn the_map_of_the_cube_is_that_of_radiosity_with_exact_form_factors() {
    // Receivers on the floor and elements of the floor at ρ = 0.8 against an independent method. Pooled over 6 seeds (N = 384 and 768
    // correlated values), |z| is inside its own quantile in 95.4 % ± 4 %.
    let reflectance = 0.8;
    let room = BoxRoom {
        size_m: [4.0; 3],
        reflectances: [reflectance; 6],
        sources: vec![RoomSource::Point {
            position: glam::DVec3::splat(2.0),
            intensity_cd: 10_000.0 / (4.0 * std::f64::consts::PI),
        }],
    };
    let truth = room.solve().expect("a valid room");
    let scene = cube(reflectance, 0.75);
    let points = &scene.receivers[0].points;
    let exact: Vec<f64> = points
        .iter()
        .map(|point| truth.on_face(RoomFace::Floor, point.position_m.x, point.position_m.y).expect("on it").total_lx())
        .collect();
    let (mut inside, mut all, mut worst_mean) = (0u32, 0u32, 0.0f64);
    let mut sums = vec![0.0; exact.len()];
    for seed in 0..6 {
        let solution = to_target(&scene, seed, MapSelection::Receivers, 0.01);
        let values = &solution.maps[0].values;
        for (index, exact_lx) in exact.iter().enumerate() {
            let z = (values.value[index] - exact_lx) / values.standard_error[index];
            inside += u32::from(z.abs() < T15_QUANTILE_95_4);
            all += 1;
            sums[index] += values.value[index] / exact_lx - 1.0;
        }
    }
    for sum in &sums {
        worst_mean = worst_mean.max((sum / 6.0).abs());
    }
    let share = f64::from(inside) / f64::from(all);
    assert!((share - 0.954).abs() < 0.04, "{share} of {all} points inside");
    assert!(worst_mean < 0.02, "worst mean deviation {worst_mean}");
    let bias = sums.iter().sum::<f64>() / (6.0 * sums.len() as f64);
    assert!(bias.abs() < 0.002, "mean deviation {bias}");
}

/// Shrinks every object in the room by a hundredth about its own centre. Surfaces that touch, whose illuminance would not be defined, then
/// have gaps of at least 0.25 mm, in which the truth holds too.
fn open_gaps(scene: &mut Scene) {
    let mut part: Vec<usize> = (0..scene.vertices_m.len()).collect();
    let mut changed = true;
    while changed {
        changed = false;
        for triangle in &scene.triangles {
            let least = triangle.iter().map(|vertex| part[*vertex as usize]).min().unwrap_or(0);
            for vertex in triangle {
                changed |= part[*vertex as usize] != least;
                part[*vertex as usize] = least;
            }
        }
    }
    for root in 1..part.len() {
        let members: Vec<usize> = (0..part.len()).filter(|vertex| part[*vertex] == root).collect();
        let middle = members.iter().map(|vertex| scene.vertices_m[*vertex]).sum::<glam::DVec3>() / members.len() as f64;
        for vertex in members {
            scene.vertices_m[vertex] = middle + 0.99 * (scene.vertices_m[vertex] - middle);
        }
    }
}

/// The office with every surface emitting what its own reflectance leaves: luminance 1000/π cd/m² everywhere.
fn isothermal_office() -> (Scene, f64) {
    let mut scene = scene("office.json");
    open_gaps(&mut scene);
    let illuminance_lx = 1000.0;
    scene.luminaires = scene
        .surfaces
        .iter()
        .enumerate()
        .map(|(id, surface)| {
            let reflectance = scene.materials[surface.material as usize].bsdf.diffuse_reflectance();
            let exitance_lm_m2 = (1.0 - reflectance) * illuminance_lx;
            let area_m2: f64 = surface.triangles.clone().map(|triangle| scene.triangle_area_m2(triangle)).sum();
            Luminaire {
                name: surface.name.clone(),
                luminous_flux_lm: exitance_lm_m2 * area_m2,
                dimming: 1.0,
                maintenance_factor: 1.0,
                power_w: None,
                product: None,
                emission: Emission::Area { surfaces: vec![id as u32], front: true, back: false, exitance_lm_m2 },
            }
        })
        .collect();
    // Coarse elements: the truth is the same for all, and a run is shorter.
    scene.divisions.iter_mut().for_each(|divisions| *divisions = (*divisions).min(3));
    let grid = scene.receivers.swap_remove(0);
    let points = grid.points.into_iter().step_by(13).filter(|point| !point.inside).collect();
    scene.receivers = vec![luxmc::scene::ReceiverSet {
        quantity: luxmc::scene::Quantity::Perpendicular,
        name: grid.name,
        layout: ReceiverLayout::Points,
        points,
        observers: Vec::new(),
        requirements: Vec::new(),
    }];
    (scene, illuminance_lx)
}

#[test]
#[ignore = "takes long: .ci/run runs it"]
fn an_isothermal_office_has_the_same_illuminance_everywhere_within_its_error_bars() {
    // Kirchhoff: E = πL₀ at every element and receiver. Pooled over the seeds, |z| is within Student's quantile with 15 degrees of freedom
    // in 95.4 % ± 2 % (200 seeds in the slow run; 8 here with ± 3 %). The mean is within 4.5 of its errors (t with 7 degrees of freedom, α
    // = 0.3 %). A truth moved by 1 % must be detected by the mean.
    let (scene, truth_lx) = isothermal_office();
    let seeds = if slow() { 200 } else { 8 };
    let tolerance = if slow() { 0.02 } else { 0.03 };
    let mut inside = [0u32; 2];
    let mut all = [0u32; 2];
    let mut means = [Vec::new(), Vec::new()];
    for seed in 0..seeds {
        let solution = with_chains(&scene, seed, MapSelection::All, 30_000);
        for (kind, map) in solution.maps.iter().enumerate() {
            let mut sum = 0.0;
            let mut count = 0.0;
            for (illuminance_lx, error_lx) in map.values.value.iter().zip(&map.values.standard_error) {
                let z = (illuminance_lx - truth_lx) / error_lx;
                inside[kind] += u32::from(z.abs() < T15_QUANTILE_95_4);
                all[kind] += 1;
                sum += illuminance_lx;
                count += 1.0;
            }
            means[kind].push(sum / count);
        }
    }
    for kind in 0..2 {
        let share = f64::from(inside[kind]) / f64::from(all[kind]);
        assert!((share - 0.954).abs() < tolerance, "map {kind}: {share} of {} inside", all[kind]);
        let mean = mean_and_error(&means[kind]);
        let z = (mean.value - truth_lx) / mean.standard_error;
        assert!(z.abs() < 4.5, "map {kind}: {mean:?}, z = {z}");
        let z = (mean.value - 1.01 * truth_lx) / mean.standard_error;
        assert!(z.abs() > 4.5, "map {kind}: the planted fault passed, {mean:?}");
    }
}

#[test]
fn a_black_scene_traces_no_chains() {
    let scene = cube(0.0, 1.0);
    let solution = to_target(&scene, 0, MapSelection::All, 0.01);
    assert_eq!(solution.chains, 0);
    assert_eq!(solution.stop_reason, StopReason::Exact);
    assert!(solution.maps.iter().all(|map| map.values.indirect.iter().all(|lx| *lx == 0.0)));
    assert!(solution.maps[0].values.standard_error.iter().all(|error_lx| *error_lx < 1e-9));
    let area_mean: f64 = solution.maps[0].tables.iter().map(|row| row.average.value * row.area_m2).sum();
    assert!((area_mean / 10_000.0 - 1.0).abs() < 1e-12, "all of the flux arrives: {area_mean}");
}

#[test]
#[ignore = "takes long: .ci/run runs it"]
fn the_forecast_holds_from_two_hundredths_of_the_run_on() {
    // 40 seeds. Once 2 % of the rays are traced, the forecast is within 5 % of the rays really needed in 9 of 10 runs. Its 90 % interval
    // contains them in 31 or more (fewer: once in 200 times). An interval with a sixteenth of the width is refused. (An eighth of the upper
    // part, where the interval allows for a refusal by a check, is as wide as the scatter of most runs.)
    let scene = cube(0.8, 0.75);
    let seeds = 40;
    let (mut good, mut held, mut held_by_a_sixteenth) = (0, 0, 0);
    for seed in 0..seeds {
        let solution = to_target(&scene, seed, MapSelection::Elements, 0.02);
        let needed = solution.rays as f64;
        let early = |row: &&ConvergenceRow| row.judged && row.rays as f64 >= 0.02 * needed;
        let early = solution.convergence.iter().find(early).expect("a judgement");
        good += u32::from((early.forecast_rays.expected / needed - 1.0).abs() <= 0.05);
        let Forecast { expected, low, high } = early.forecast_rays;
        let holds =
            |part: f64| expected - part * (expected - low) <= needed && needed <= expected + part * (high - expected);
        held += u32::from(holds(1.0));
        held_by_a_sixteenth += u32::from(holds(0.0625));
    }
    assert!(good * 10 >= seeds as u32 * 9, "{good} of {seeds} forecasts within 5%");
    assert!(held >= 31 && held_by_a_sixteenth < 31, "{held} and {held_by_a_sixteenth} of {seeds} intervals hold");
}

#[test]
fn runs_that_say_target_met_are_at_or_under_it() {
    // True relative RMS error of the cube's element map when the run reported "target met". It is at or below the target in at least 92.5 %
    // of 300 seeds in the slow run, and in 36 of 40 seeds otherwise (α = 4.8 % for a rule that keeps 95 %). With true errors a third larger,
    // the planted fault, it is not. The runs take at most 1.3 times the chains of an oracle that stops when the expected error equals the
    // target.
    let reflectance = 0.5;
    let scene = cube(reflectance, 1.5);
    let elements = Elements::of(&scene);
    let truth = BoxRoom {
        size_m: [4.0; 3],
        reflectances: [reflectance; 6],
        sources: vec![RoomSource::Point {
            position: glam::DVec3::splat(2.0),
            intensity_cd: 10_000.0 / (4.0 * std::f64::consts::PI),
        }],
    }
    .solve()
    .expect("a valid room");
    let exact: Vec<f64> = (0..elements.len() as u32)
        .map(|index| {
            truth.triangle_mean(elements.corners_m(&scene, elements.element(index))).expect("on a face").total_lx()
        })
        .collect();
    let seeds = if slow() { 300 } else { 40 };
    let target_error = 0.02;
    let (mut met, mut met_with_fault, mut true_squares, mut chains) = (0, 0, 0.0, 0.0);
    for seed in 0..seeds {
        let solution = to_target(&scene, seed, MapSelection::Elements, target_error);
        let values = &solution.maps[0].values.value;
        let (mut squares, mut sum, mut area) = (0.0, 0.0, 0.0);
        for (index, (value, exact)) in values.iter().zip(&exact).enumerate() {
            let area_m2 = elements.area_m2(&scene, elements.element(index as u32));
            squares += area_m2 * (value - exact).powi(2);
            sum += area_m2 * exact;
            area += area_m2;
        }
        let true_error = (squares / area).sqrt() / (sum / area);
        met += u32::from(true_error <= target_error);
        met_with_fault += u32::from(4.0 / 3.0 * true_error <= target_error);
        true_squares += true_error * true_error * solution.chains as f64;
        chains += solution.chains as f64;
    }
    let least = if slow() { 0.925 } else { 0.90 };
    let share = |met: u32| f64::from(met) / seeds as f64;
    assert!(share(met) >= least, "{met} of {seeds} truly met");
    assert!(share(met_with_fault) < least, "the planted fault passed: {met_with_fault} of {seeds} truly met");
    // Expected squared error times chains is a constant of the estimator. It gives the oracle's chains.
    let oracle = true_squares / seeds as f64 / (target_error * target_error);
    let cost = chains / seeds as f64 / oracle;
    assert!(cost < 1.3, "{cost} times the oracle's chains");
}
