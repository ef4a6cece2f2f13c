//! Methods to compare light meshes with: shadow rays from every receiver, to a fixed number of points for each luminous area.

use std::time::Instant;

use crate::light_mesh::{
    Accelerations, Entries, IndirectForm, NEVER, Planner, SamplePlacing, Samples, Solids, Surroundings, Wishes,
};
use crate::maps::MapResult;
use crate::methods::check_light_mesh;
use crate::scene::{Elements, Scene};
use crate::solver::{Observer, Settings, Solution, Spending, StopReason, map_requests};
use crate::transport::World;

/// Checks that these methods can compute the requested maps. They compute only direct light.
pub fn check_points(scene: &Scene, settings: &Settings) -> Result<(), String> {
    check_light_mesh(scene, settings).map_err(|error| error.to_string())?;
    if World::new(scene).reflects() {
        return Err("shadow rays compute direct light only, and surfaces of this scene reflect".to_owned());
    }
    Ok(())
}

/// Computes direct light with a shadow ray to each of `count` points of every triangle, ball and opening that emits. A point
/// luminaire is one point. Each map is computed once, without refinement.
pub fn solve_by_points(
    scene: &Scene,
    settings: &Settings,
    count: usize,
    observer: &dyn Observer,
) -> Result<Solution, String> {
    check_points(scene, settings)?;
    let started = Instant::now();
    let world = World::new(scene);
    let build_s = started.elapsed().as_secs_f64();
    let solids = Solids::of(scene);
    let points = Samples::of(&world, SamplePlacing::Count(count), settings.seed);
    let stop = || observer.is_interrupted();
    let planner = Planner {
        around: Surroundings { scene, world: &world, solids: &solids, samples: &points, give_up: NEVER },
        wishes: Wishes {
            step_m: None,
            radius_m: None,
            form: IndirectForm::Directional,
            accelerations: Accelerations::ALL,
            target_error: settings.target_error,
            seed: settings.seed,
        },
        caution: 1.0,
        by_places: false,
        most_rays: f64::INFINITY,
        stop: &stop,
    };
    let (mut maps, mut rays, mut estimated_error, mut check_s) = (Vec::new(), 0, 0.0f64, 0.0);
    for (number, (kind, bound)) in map_requests(scene, &settings.maps).into_iter().enumerate() {
        let checking = Instant::now();
        let entries = Entries::of(&planner.around, kind, settings.seed, settings.target_error, false);
        let traced = planner.trace_points(&entries, number as u32, &points);
        // The check belongs to the stated error, not to the compared method, so its time is subtracted. Its share of the time is
        // estimated by its share of the rays.
        let all_rays = (traced.effort.rays() + traced.check_rays).max(1);
        check_s += checking.elapsed().as_secs_f64() * traced.check_rays as f64 / all_rays as f64;
        rays += traced.effort.rays();
        if bound {
            estimated_error = estimated_error.max(traced.map.error.estimated);
        }
        maps.push(MapResult { bound, ..traced.map });
    }
    Ok(Solution {
        elements: Elements::of(scene),
        method: format!("points-{count}"),
        seed: settings.seed,
        target_error: settings.target_error,
        chains: 0,
        rays,
        replicas: 0,
        maps,
        glare: Vec::new(),
        estimated_error,
        target_met: settings.target_error.map(|_| false),
        stop_reason: StopReason::FinestMesh,
        flux_balance: Err("shadow rays trace no chains".to_owned()),
        map_check: Err("shadow rays trace no chains".to_owned()),
        convergence: Vec::new(),
        spending: Spending::default(),
        begun_wall_s: 0.0,
        build_s,
        compute_s: started.elapsed().as_secs_f64() - build_s - check_s,
        paths_not_found: Vec::new(),
        notes: Vec::new(),
        warnings: Vec::new(),
    })
}
