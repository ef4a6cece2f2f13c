//! Errors that light meshes state for single points and for maps, compared with exact light.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicU64, Ordering};

use luxmc::estimators::receiver::Receiver;
use luxmc::light_mesh::exact::sample_all_emitters;
use luxmc::methods::{MeshChoice, solve_by_light_mesh};
use luxmc::sampling::random::{Purpose, Stream};
use luxmc::scene::Scene;
use luxmc::solver::{MapSelection, Observer, Settings, Solution, StopReason};
use luxmc::transport::World;

use crate::common::{Silent, scene_of};

/// A hall with three racks under rows of lamps, and a grid on its floor.
fn hall(reflectance: f64, columns: u32) -> Scene {
    let racks: String = (0..3)
        .map(|number| {
            let x = 2.0 + 3.0 * f64::from(number);
            let end = x + 0.6;
            format!(
                r#", {{ "name": "rack {number}", "type": "box", "min": [{x},1,0], "max": [{end},7,2.2], "material": "grey" }}"#
            )
        })
        .collect();
    scene_of(&format!(
        r#"{{ "version": 1, "materials": {{ "grey": {{ "type": "diffuse", "reflectance": {reflectance} }} }},
            "geometry": [{{ "name": "room", "type": "box", "min": [0,0,0], "max": [11,8,4], "facing": "inward", "material": "grey" }}{racks}],
            "luminaires": [{{ "name": "lamps", "type": "point", "position": [1,1,3.7], "luminous_flux_lm": 1500, "distribution": "lambertian",
              "columns": 6, "rows": 5, "u": [9,0,0], "v": [0,6,0] }}],
            "receivers": [{{ "name": "floor", "type": "grid", "origin": [0.1,0.1,0], "u": [10.8,0,0], "v": [0,7.8,0], "columns": {columns}, "rows": {columns} }}] }}"#
    ))
}

fn exact_lx(scene: &Scene) -> Vec<f64> {
    let world = World::new(scene);
    let mut stream = Stream::new(0, Purpose::Pilot, 0, 0);
    let light = |point: &luxmc::scene::ReceiverPoint| {
        let origin = world.tracer.side_origin(point.position_m, point.normal);
        let receiver = Receiver { point_m: point.position_m, normal: point.normal, origin: &origin };
        sample_all_emitters(&world, &receiver, &mut stream).value
    };
    scene.receivers[0].points.iter().map(light).collect()
}

fn given_step(step_m: f64) -> MeshChoice {
    MeshChoice { step_m: Some(step_m), ..MeshChoice::default() }
}

fn settings(seed: u64) -> Settings {
    Settings { seed, maps: MapSelection::Receivers, ..Settings::default() }
}

/// Two error bars hold at 93 % or more of the points of every kind that has at least 100 points (seed 1; shadow rays are exact; a normal
/// error would give 95 %). With bars a fifth as long, the planted fault, they do not.
#[test]
fn bars_of_single_places_hold_in_each_kind() {
    let scene = hall(0.0, 200);
    let exact = exact_lx(&scene);
    let solution = solve_by_light_mesh(&scene, &settings(1), &given_step(0.1), &Silent).expect("it can be computed");
    let values = &solution.maps[0].values;
    let mut kinds: BTreeMap<u64, Vec<f64>> = BTreeMap::new();
    for (entry, bar_lx) in values.standard_error.iter().enumerate().filter(|(_, bar_lx)| **bar_lx > 0.0) {
        let bars_off = (values.value[entry] - exact[entry]).abs() / bar_lx;
        kinds.entry(bar_lx.to_bits()).or_default().push(bars_off);
    }
    let held = |bars: f64| {
        let large = kinds.iter().filter(|(_, off)| off.len() >= 100);
        let shares = large.map(|(bar_lx, off)| {
            let held = off.iter().filter(|off| **off <= bars).count() as f64 / off.len() as f64;
            (f64::from_bits(*bar_lx), off.len(), held)
        });
        shares.collect::<Vec<(f64, usize, f64)>>()
    };
    let found = held(2.0);
    assert!(found.len() >= 6, "{found:?}");
    assert!(found.iter().all(|(.., held)| *held >= 0.93), "{found:?}");
    assert!(held(0.4).iter().any(|(.., held)| *held < 0.93));
}

/// A clock that advances by `step_s` seconds at each reading.
struct Clock {
    readings: AtomicU64,
    step_s: f64,
}

impl Observer for Clock {
    fn wall_s(&self) -> f64 {
        self.step_s * self.readings.fetch_add(1, Ordering::Relaxed) as f64
    }
}

fn late(limit_s: f64, step_s: f64, choice: &MeshChoice) -> Solution {
    let clock = Clock { readings: AtomicU64::new(0), step_s };
    let settings = Settings { time_limit_s: Some(limit_s), ..settings(1) };
    solve_by_light_mesh(&hall(0.5, 40), &settings, choice, &clock).expect("it can be computed")
}

/// A given step is used unchanged, also with a time limit. If a target conflicts with it, there is a warning.
#[test]
fn a_given_step_is_taken_as_it_is() {
    let by_mesh = late(1e9, 1.0, &given_step(0.5));
    assert!(by_mesh.target_met.is_none() && by_mesh.notes.iter().any(|note| note.contains("step 0.5000 m")));
    assert!(!by_mesh.warnings.iter().any(|warning| warning.contains("given step")), "{:?}", by_mesh.warnings);
    let with_target = Settings { target_error: Some(0.01), ..settings(1) };
    let refused =
        solve_by_light_mesh(&hall(0.0, 40), &with_target, &given_step(0.5), &Silent).expect("it can be computed");
    assert!(refused.warnings.iter().any(|warning| warning.contains("given step")), "{:?}", refused.warnings);
}

/// A run whose time is over from the start does only the work that gives each of 1,600 points a value and an error. This takes a twentieth
/// of the rays of a full check (128 points, 2 × 2,048 walks, some four rays each), which used to come after the end. The clock stands
/// still, so that only rays count. If the clock advances by a second at each reading, the map is left out and named.
#[test]
fn what_comes_after_the_end_is_short() {
    for choice in [given_step(0.5), given_step(2.0), MeshChoice::default()] {
        let solution = late(0.0, 0.0, &choice);
        assert_eq!(solution.stop_reason, StopReason::TimeLimit);
        assert!(solution.rays < 600_000, "{} rays", solution.rays);
        assert!(solution.maps[0].values.value.iter().filter(|lx| **lx > 0.0).count() > 1000);
    }
    let given_up = late(0.0, 1.0, &given_step(0.5));
    assert!(given_up.maps.is_empty(), "{} maps", given_up.maps.len());
    assert!(given_up.warnings.iter().any(|warning| warning.contains("is left out")), "{:?}", given_up.warnings);
}
