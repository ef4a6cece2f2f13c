//! The radiosity method: meshes are refined until a stop rule ends the run.

use std::time::Instant;

use crate::control::Forecast;
use crate::maps::{MapKind, MapResult};
use crate::radiosity::{NotARoom, Radiosity};
use crate::scene::{Elements, Scene};
use crate::solver::{
    ConvergenceRow, ErrorParts, MapCheck, Observer, Progress, Settings, Solution, Spending, StopReason,
};
use crate::solver::{DEFAULT_TARGET_ERROR, is_long_over, map_requests};

/// A finer mesh takes about 16 times as long as the one before. A run with a time limit starts no mesh that would end late.
const NEXT_MESH_TAKES: f64 = 16.0;
/// Least relative uncertainty of the flux in the check of the map, as a part of the emitted flux: the rounding of the sums.
const LEAST_FLUX_ERROR: f64 = 1e-9;

/// Solves a room by radiosity for the requested maps.
///
/// # Errors
/// Fails with the part of the scene that radiosity cannot compute, or cannot compute in the given time.
pub fn solve_by_radiosity(scene: &Scene, settings: &Settings, observer: &dyn Observer) -> Result<Solution, NotARoom> {
    let started = Instant::now();
    // No rays are traced, and building the meshes already reads the clock.
    observer.ready();
    let begun_wall_s = observer.wall_s();
    let target_error =
        settings.target_error.or_else(|| settings.time_limit_s.is_none().then_some(DEFAULT_TARGET_ERROR));
    let requests = map_requests(scene, &settings.maps);
    let mut radiosity = Radiosity::new_within(scene, &|| is_long_over(settings, observer))?;
    let mut convergence = Vec::new();
    let mut last_s = started.elapsed().as_secs_f64();
    let (maps, estimated_error, stop_reason) = loop {
        let maps: Vec<MapResult> = requests.iter().map(|(kind, _)| radiosity.map(*kind)).collect();
        let bound = maps.iter().zip(&requests).filter(|(_, (_, bound))| *bound);
        let estimated_error = bound.map(|(map, _)| map.error.estimated).fold(0.0, f64::max);
        let wall_s = observer.wall_s();
        convergence.push(judged(estimated_error, wall_s));
        observer.progress(&progress(estimated_error, target_error, wall_s));
        let late = |limit_s: f64| wall_s + NEXT_MESH_TAKES * last_s > limit_s;
        let met = target_error.is_some_and(|target| estimated_error <= target);
        let stop = if maps.iter().all(|map| map.values.standard_error.iter().all(|error| *error == 0.0)) {
            Some(StopReason::Exact)
        } else if met {
            Some(StopReason::TargetMet)
        } else if observer.is_interrupted() {
            Some(StopReason::Interrupted)
        } else if settings.time_limit_s.is_some_and(late) {
            Some(StopReason::TimeLimit)
        } else {
            let refining = Instant::now();
            let finest = !radiosity.refine();
            last_s = refining.elapsed().as_secs_f64();
            finest.then_some(StopReason::FinestMesh)
        };
        if let Some(stop) = stop {
            break (maps, estimated_error, stop);
        }
    };
    let met = |error: f64| target_error.map(|target| error <= target);
    let map_check = map_check(scene, &radiosity, &maps);
    let maps = maps.into_iter().zip(&requests).map(|(map, (_, bound))| {
        let target_met = met(map.error.estimated);
        MapResult { bound: *bound, target_met, ..map }
    });
    Ok(Solution {
        elements: Elements::of(scene),
        paths_not_found: Vec::new(),
        notes: Vec::new(),
        method: "radiosity".to_owned(),
        seed: settings.seed,
        target_error,
        chains: 0,
        rays: 0,
        replicas: 0,
        maps: maps.collect(),
        glare: Vec::new(),
        estimated_error,
        target_met: met(estimated_error),
        stop_reason,
        flux_balance: Err("radiosity traces no chains".to_owned()),
        map_check,
        convergence,
        spending: Spending::default(),
        begun_wall_s,
        build_s: 0.0,
        compute_s: started.elapsed().as_secs_f64(),
        warnings: Vec::new(),
    })
}

/// A row of the convergence history: the error of the mesh.
fn judged(estimated_error: f64, wall_s: f64) -> ConvergenceRow {
    ConvergenceRow {
        wall_s,
        rays: 0,
        chains: 0,
        error: ErrorParts::bias(estimated_error),
        judged: true,
        forecast_rays: Forecast::known(0.0),
        forecast_wall_s: Forecast::known(wall_s),
    }
}

/// The progress of the run for the observer.
fn progress(estimated_error: f64, target_error: Option<f64>, wall_s: f64) -> Progress {
    Progress {
        estimated_error: Some(estimated_error),
        target_error,
        chains: 0,
        rays: 0,
        forecast_rays: None,
        remaining_s: None,
        slowest_map: None,
        fraction: target_error.map_or(0.0, |target| (target / estimated_error.max(target)).min(1.0)),
        wall_s,
    }
}

fn map_check(scene: &Scene, radiosity: &Radiosity, maps: &[MapResult]) -> Result<MapCheck, String> {
    let elements = maps.iter().find(|map| map.kind == MapKind::Elements).ok_or("the element map was not requested")?;
    let flux = radiosity.absorbed_flux(elements);
    let emitted_lm = scene.luminous_flux_lm();
    let deviation_lm = flux.absorbed_lm - emitted_lm;
    Ok(MapCheck {
        absorbed_by_map_lm: flux.absorbed_lm,
        standard_error_lm: flux.estimated_error_lm,
        z_score: deviation_lm / flux.estimated_error_lm.max(LEAST_FLUX_ERROR * emitted_lm).max(f64::MIN_POSITIVE),
    })
}
