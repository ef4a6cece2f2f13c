//! Light meshes that are interrupted, and maps of many receivers.

use std::sync::LazyLock;
use std::sync::atomic::{AtomicU64, Ordering};

use luxmc::analytic::sobolev::{SobolevPlane, SobolevProblem, sobolev};
use luxmc::light_mesh::tracing::{DirectBy, IndirectBy, light_of};
use luxmc::light_mesh::{Entries, NEVER, SamplePlacing, Samples, Solids, Surroundings};
use luxmc::maps::MapKind;
use luxmc::methods::{MeshChoice, solve_by_light_mesh};
use luxmc::scene::Scene;
use luxmc::solver::{MapSelection, Observer, Settings, Solution, StopReason};
use luxmc::transport::World;

use crate::common::{Silent, scene_of};

/// Sobolev's planes 1 m apart, a source half way between them, and a square grid of 3 m on the lower plane.
fn planes(columns: u32) -> Scene {
    scene_of(&format!(
        r#"{{ "version": 1, "materials": {{ "grey": {{ "type": "diffuse", "reflectance": 0.5 }} }},
            "geometry": [
              {{ "name": "1", "type": "rectangle", "origin": [-100,-100,0], "u": [200,0,0], "v": [0,200,0], "material": "grey" }},
              {{ "name": "2", "type": "rectangle", "origin": [-100,-100,1], "u": [0,200,0], "v": [200,0,0], "material": "grey" }}],
            "luminaires": [{{ "name": "source", "type": "point", "position": [0,0,0.5], "intensity_cd": 1 }}],
            "receivers": [{{ "name": "grid", "type": "grid", "origin": [0,-1.5,0], "u": [3,0,0], "v": [0,3,0], "columns": {columns}, "rows": {columns} }}] }}"#
    ))
}

/// Reflected light by Sobolev's integral, every centimetre up to 4 m: one table for all tests.
static SOBOLEV_LX: LazyLock<Vec<f64>> = LazyLock::new(|| {
    let problem = SobolevProblem { h1: 0.5, rho1: 0.5, rho2: 0.5 };
    let at = |radius_m: f64| sobolev(&problem, SobolevPlane::One, radius_m).expect("a sound problem").reflected_lx;
    (0..=400).map(|step| at(0.01 * f64::from(step))).collect()
});

/// Reflected light at the grid's points and the mean of all light, interpolated in the table of radii.
fn exact_lx(scene: &Scene) -> (Vec<f64>, f64) {
    let table = &*SOBOLEV_LX;
    let points = &scene.receivers[0].points;
    let reflected_lx: Vec<f64> = points
        .iter()
        .map(|point| {
            let place = 100.0 * point.position_m.truncate().length();
            let (low, part) = (place as usize, place.fract());
            table[low] * (1.0 - part) + table[low + 1] * part
        })
        .collect();
    let direct_lx = |radius_m: f64| 0.5 / (0.25 + radius_m * radius_m).powf(1.5);
    let sum: f64 =
        points.iter().zip(&reflected_lx).map(|(point, lx)| lx + direct_lx(point.position_m.truncate().length())).sum();
    let mean_lx = sum / points.len() as f64;
    (reflected_lx, mean_lx)
}

/// RMS error of the reflected light, divided by the mean of all light.
fn relative_rms(found_lx: &[f64], (exact_lx, mean_lx): &(Vec<f64>, f64)) -> f64 {
    let squares: f64 = found_lx.iter().zip(exact_lx).map(|(found, exact)| (found - exact).powi(2)).sum();
    (squares / exact_lx.len() as f64).sqrt() / mean_lx
}

fn solved(scene: &Scene, target_error: f64, seed: u64, observer: &(dyn Observer + Sync)) -> Solution {
    let settings =
        Settings { seed, target_error: Some(target_error), maps: MapSelection::Receivers, ..Settings::default() };
    solve_by_light_mesh(scene, &settings, &MeshChoice::default(), observer).expect("it can be computed")
}

/// Sixteen times as many receivers take less than three times as many rays, and both maps are as accurate as they state. (Walks from every
/// point would take sixteen times as many rays, the planted fault.)
fn more_receivers_cost_little(seed: u64) {
    let rays = [60, 240].map(|columns| {
        let scene = planes(columns);
        let solution = solved(&scene, 0.02, seed, &Silent);
        let error = relative_rms(&solution.maps[0].values.indirect, &exact_lx(&scene));
        assert_eq!(solution.stop_reason, StopReason::TargetMet);
        assert!(error <= 0.02, "seed {seed}: {error}");
        assert!(error <= 1.5 * solution.estimated_error, "seed {seed}: {error} {}", solution.estimated_error);
        solution.rays
    });
    assert!(rays[1] < 3 * rays[0], "{rays:?}");
}

#[test]
fn many_receivers_cost_little_more_than_few() {
    more_receivers_cost_little(1);
}

#[test]
#[ignore = "takes long: .ci/run runs it"]
fn many_receivers_cost_little_more_than_few_by_another_seed() {
    more_receivers_cost_little(3);
}

/// Interrupts after `most` requests.
struct CutAfter {
    asked: AtomicU64,
    most: u64,
}

impl Observer for CutAfter {
    fn is_interrupted(&self) -> bool {
        self.asked.fetch_add(1, Ordering::Relaxed) >= self.most
    }
    fn wall_s(&self) -> f64 {
        0.0
    }
}

/// A run is interrupted before the first mesh, within a trial or within the map. It always shows a mesh that is more accurate than 16 walks
/// from every point, and it states its error.
#[test]
fn a_run_that_is_cut_shows_the_best_that_it_has() {
    let scene = planes(60);
    let exact = exact_lx(&scene);
    let world = World::new(&scene);
    let (solids, samples) = (Solids::of(&scene), Samples::of(&world, SamplePlacing::Stratified, 1));
    let around = Surroundings { scene: &scene, world: &world, solids: &solids, samples: &samples, give_up: NEVER };
    let entries = Entries::of(&around, MapKind::Receivers(0), 1, None, false);
    let all: Vec<usize> = (0..entries.weights.len()).collect();
    let none = DirectBy::Rays { first: 0, passes: 0 };
    let (lights, _) = light_of(&around, &entries, &all, &none, &IndirectBy::Walks([0, 16]), 1, 0);
    let few: Vec<f64> = lights.iter().map(|light| light.indirect_mean()).collect();
    let of_few_walks = relative_rms(&few, &exact);

    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a thread");
    let whole = CutAfter { asked: AtomicU64::new(0), most: u64::MAX };
    pool.install(|| solved(&scene, 0.01, 1, &whole));
    let asked = whole.asked.into_inner();
    for part in [0.0, 0.1, 0.3, 0.5, 0.9] {
        let observer = CutAfter { asked: AtomicU64::new(0), most: (part * asked as f64) as u64 };
        let solution = pool.install(|| solved(&scene, 0.01, 1, &observer));
        let map = &solution.maps[0];
        let error = relative_rms(&map.values.indirect, &exact);
        let stated = map.error.estimated;
        assert_eq!(solution.stop_reason, StopReason::Interrupted, "{part}");
        assert!(error < 0.8 * of_few_walks, "{part}: {error} {of_few_walks}");
        assert!(error < 1.5 * stated && stated < 3.0 * error, "{part}: {error} {stated}");
    }
}
