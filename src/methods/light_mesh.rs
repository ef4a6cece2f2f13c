//! The light-mesh method: solves a scene by light meshes and shadow rays instead of chains.

use std::sync::OnceLock;
use std::time::Instant;

use crate::control::Forecast;
use crate::estimators::roulette::world_for_walks;
use crate::light_mesh::{
    Accelerations, DirectPlan, Entries, IndirectForm, IndirectPlan, LEAST_RADIUS_PER_STEP, MOST_RADIUS_PER_STEP,
    MapPlan, NotForLightMesh, Planner, RADIUS_PER_STEP, SamplePlacing, Samples, Solids, Surroundings, TracedMap, Why,
    Wishes, check,
};
use crate::maps::{MapError, MapKind, MapResult, PACKETS_OF_A_BOUND};
use crate::scene::{Elements, Scene, joined};
use crate::solver::{ConvergenceRow, ErrorParts, Observer, Progress, Settings, Solution, Spending, StopReason};
use crate::solver::{DEFAULT_TARGET_ERROR, map_requests};
use crate::transport::World;

use super::light_mesh_words::{said, step_not_taken, why_in_words};

/// Maximum number of further plans for a map after the first, while the last check of the map misses the target.
const MOST_ATTEMPTS: u32 = 3;
/// Factor on the error that the next plan aims at, relative to the plan before it.
const NEXT_CAUTION: f64 = 0.7;
/// Offset between the map numbers of two successive plans. Each plan thereby checks at points of its own.
const ATTEMPT: u32 = 1 << 8;
/// Smallest limit on the rays of a map that the target does not bind. Otherwise its limit is the rays that the maps before it took.
const LEAST_RAYS: f64 = 1e7;

/// Time in s, by the run's clock, that a map with no result yet may continue after the run should end.
const PATIENCE_S: f64 = 0.6;

/// How the light mesh of a run is made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeshChoice {
    /// Step in m. `None`: found by refinement.
    pub step_m: Option<f64>,
    /// Radius in m. `None`: 1.25 steps.
    pub radius_m: Option<f64>,
    /// Form in which mesh points store indirect light.
    pub form: IndirectForm,
    /// Accelerations in use.
    pub accelerations: Accelerations,
}

impl MeshChoice {
    /// Checks that step and radius are positive, finite and in an allowed ratio to each other.
    ///
    /// # Errors
    /// Returns the given value and the expected value in words.
    pub fn check(&self) -> Result<(), (String, String)> {
        let lengths = [self.step_m, self.radius_m];
        if let Some(length_m) =
            lengths.into_iter().flatten().find(|length_m| !(*length_m > 0.0 && length_m.is_finite()))
        {
            return Err((format!("{length_m} m"), "lengths above 0 in metres".to_owned()));
        }
        let Some(radius_m) = self.radius_m else { return Ok(()) };
        let step_m = self.step_m.unwrap_or(radius_m / RADIUS_PER_STEP);
        let ratio = radius_m / step_m;
        if (LEAST_RADIUS_PER_STEP..=MOST_RADIUS_PER_STEP).contains(&ratio) {
            return Ok(());
        }
        Err((
            format!("a radius of {radius_m} m, {ratio:.3} times the step of {step_m} m"),
            format!("{LEAST_RADIUS_PER_STEP} to {MOST_RADIUS_PER_STEP} times"),
        ))
    }
}

impl Default for MeshChoice {
    fn default() -> MeshChoice {
        MeshChoice { step_m: None, radius_m: None, form: IndirectForm::Directional, accelerations: Accelerations::ALL }
    }
}

/// Solves a scene by light meshes for the requested maps.
///
/// # Errors
/// Fails with the part of the scene that light meshes cannot compute.
pub fn solve_by_light_mesh(
    scene: &Scene,
    settings: &Settings,
    choice: &MeshChoice,
    observer: &dyn Observer,
) -> Result<Solution, NotForLightMesh> {
    let requests = map_requests(scene, &settings.maps);
    check_requests(scene, settings)?;
    let started = Instant::now();
    let world = world_for_walks(scene);
    let build_s = started.elapsed().as_secs_f64();
    observer.ready();
    let begun_wall_s = observer.wall_s();
    let solids = Solids::of(scene);
    let samples = Samples::of(&world, SamplePlacing::Stratified, settings.seed);
    // A step or radius that the user gives is used unchanged, unless the user also sets a target error.
    let is_given = choice.step_m.is_some() || choice.radius_m.is_some();
    let no_rule = settings.time_limit_s.is_none() && !is_given;
    let target_error = settings.target_error.or_else(|| no_rule.then_some(DEFAULT_TARGET_ERROR));
    let is_late = || settings.time_limit_s.is_some_and(|limit_s| observer.wall_s() >= limit_s);
    let stopped_s = OnceLock::new();
    let stop = || {
        let stops = observer.is_interrupted() || is_late();
        if stops {
            stopped_s.get_or_init(|| observer.wall_s());
        }
        stops
    };
    let is_long_over = || stop() && stopped_s.get().is_some_and(|at_s| observer.wall_s() - at_s > PATIENCE_S);
    let mut planner = Planner {
        around: Surroundings { scene, world: &world, solids: &solids, samples: &samples, give_up: &is_long_over },
        wishes: Wishes {
            step_m: choice.step_m,
            radius_m: choice.radius_m,
            form: choice.form,
            accelerations: choice.accelerations,
            // If only a time limit is given, the step is refined for the default target as far as the time allows.
            target_error: target_error.or_else(|| (!is_given).then_some(DEFAULT_TARGET_ERROR)),
            seed: settings.seed,
        },
        caution: 1.0,
        by_places: false,
        most_rays: f64::INFINITY,
        stop: &stop,
    };

    let mut run = trace_maps(&mut planner, &requests, target_error, observer);
    run.tell_at_the_end(scene, &world, &solids);
    let end = match () {
        _ if observer.is_interrupted() => StopReason::Interrupted,
        _ if is_late() => StopReason::TimeLimit,
        _ => StopReason::FinestMesh,
    };
    let compute_s = started.elapsed().as_secs_f64() - build_s;
    Ok(solution_of(
        scene,
        &world,
        run,
        RunFrame { seed: settings.seed, target_error, end, begun_wall_s, build_s, compute_s },
    ))
}

/// Plans and computes the requested maps.
fn trace_maps(
    planner: &mut Planner,
    requests: &[(MapKind, bool)],
    target_error: Option<f64>,
    observer: &dyn Observer,
) -> LightMeshFindings {
    let mut run = LightMeshFindings { traced: requests.iter().map(|_| None).collect(), ..LightMeshFindings::default() };
    let finds_step = planner.wishes.step_m.is_none();
    let mut finest_m: Option<f64> = None;
    // Maps that the target binds come first.
    let mut order: Vec<usize> = (0..requests.len()).collect();
    order.sort_by_key(|index| !requests[*index].1);
    for (done, index) in order.into_iter().enumerate() {
        let (kind, bound) = requests[index];
        if !bound && finds_step {
            // A map that the target does not bind is not refined. It takes the finest step of the maps that the target binds.
            planner.wishes.step_m = finest_m;
        }
        if (planner.around.give_up)() {
            run.left_out.push((kind, bound));
            continue;
        }
        let may_draw = bound && finds_step && planner.wishes.radius_m.is_none();
        let entries = Entries::of(&planner.around, kind, planner.wishes.seed, planner.wishes.target_error, may_draw);
        planner.most_rays = if bound { f64::INFINITY } else { LEAST_RAYS.max(run.rays as f64) };
        let target = target_error.filter(|_| bound);
        let Some((plan, map)) = best_attempt(planner, &entries, index as u32, bound, target, &mut run.rays) else {
            run.left_out.push((kind, bound));
            continue;
        };
        let misses_near_luminaires = may_miss_near_luminaires(&planner.around, &entries, &plan);
        run.tell(&map, &plan, [planner.around.samples.len(), entries.places()], misses_near_luminaires);
        if bound && let Some(facts) = &map.mesh {
            finest_m = Some(finest_m.map_or(facts.step_m, |finest_m| finest_m.min(facts.step_m)));
        }
        let fraction = (done + 1) as f64 / requests.len() as f64;
        run.record(&map, bound, target_error, fraction, observer);
        let dark_upper_bound = dark_upper_bound(planner.around.world, &entries, &map);
        let is_dark = dark_upper_bound.is_some();
        let target_met = target_error.map(|target| map.upper_error <= target && !is_dark && !misses_near_luminaires);
        let error = MapError { dark_upper_bound, ..map.map.error };
        let result = MapResult { bound, target_met, error, ..map.map };
        run.traced[index] = Some(TracedMap { map: result, ..map });
    }
    run
}

/// General data of a run: its seed and target, the reason of its end if it misses the target, and its times.
struct RunFrame {
    seed: u64,
    target_error: Option<f64>,
    end: StopReason,
    begun_wall_s: f64,
    build_s: f64,
    compute_s: f64,
}

fn solution_of(scene: &Scene, world: &World, run: LightMeshFindings, frame: RunFrame) -> Solution {
    let LightMeshFindings { traced, left_out, rays, convergence, notes, warnings } = run;
    let RunFrame { seed, target_error, end, begun_wall_s, build_s, compute_s } = frame;
    let maps: Vec<MapResult> = traced.into_iter().flatten().map(|map| map.map).collect();
    let estimated_error = maps.iter().filter(|map| map.bound).map(|map| map.error.estimated).fold(0.0, f64::max);
    let all_meet = || maps.iter().filter(|map| map.bound).all(|map| map.target_met == Some(true));
    let target_met = target_error.map(|_| !left_out.iter().any(|(_, bound)| *bound) && all_meet());
    let stop_reason = match (is_exact(&maps), target_met) {
        (true, _) => StopReason::Exact,
        (_, Some(true)) => StopReason::TargetMet,
        _ => end,
    };
    Solution {
        elements: Elements::of(scene),
        method: "light-mesh".to_owned(),
        seed,
        target_error,
        chains: 0,
        rays,
        replicas: 0,
        maps,
        glare: Vec::new(),
        estimated_error,
        target_met,
        stop_reason,
        flux_balance: Err("light meshes trace no chains".to_owned()),
        map_check: Err("light meshes trace no chains".to_owned()),
        convergence,
        spending: Spending::default(),
        begun_wall_s,
        build_s,
        compute_s,
        paths_not_found: world.paths_not_found.clone(),
        warnings,
        notes,
    }
}

/// Results of a light-mesh run so far.
#[derive(Default)]
struct LightMeshFindings {
    /// The requested maps, in the order of the requests.
    traced: Vec<Option<TracedMap>>,
    /// Maps left out because the run ended, with a flag: `true` if the target binds the map.
    left_out: Vec<(MapKind, bool)>,
    rays: u64,
    convergence: Vec<ConvergenceRow>,
    notes: Vec<String>,
    warnings: Vec<String>,
}

impl LightMeshFindings {
    /// Records notes on how a map was computed and warnings about it. `points` counts the light samples, `places` the points of the
    /// map.
    fn tell(&mut self, map: &TracedMap, plan: &MapPlan, [points, places]: [usize; 2], misses_near_luminaires: bool) {
        let name = &map.map.name;
        self.notes.extend(said(map, plan, points, places));
        self.warnings.extend(step_not_taken(map, plan));
        if misses_near_luminaires {
            self.warnings.push(format!(
                "light mesh: \"{name}\": a luminaire nearly touches a surface, and walks may miss the spot that it \
                 lights; the stated error may not include this; --method auto finds the spot"
            ));
        }
        if let DirectPlan::Rays(why @ Why::TooFine(_)) = &plan.direct {
            self.warnings.push(format!("\"{name}\" has no mesh: {}; shadow rays replace it", why_in_words(why)));
        }
    }

    /// Records the run's error including this map, and reports the progress to the observer.
    fn record(
        &mut self,
        map: &TracedMap,
        bound: bool,
        target_error: Option<f64>,
        fraction: f64,
        observer: &dyn Observer,
    ) {
        let own_error = if bound { map.map.error.estimated } else { 0.0 };
        let estimated_error = self.traced.iter().flatten().map(bound_error).fold(own_error, f64::max);
        let (rays, wall_s) = (self.rays, observer.wall_s());
        if bound {
            self.convergence.push(ConvergenceRow {
                wall_s,
                rays,
                chains: 0,
                error: ErrorParts::bias(estimated_error),
                judged: true,
                forecast_rays: Forecast::known(rays as f64),
                forecast_wall_s: Forecast::known(wall_s),
            });
        }
        observer.progress(&Progress {
            estimated_error: Some(estimated_error),
            target_error,
            chains: 0,
            rays,
            forecast_rays: None,
            remaining_s: None,
            slowest_map: None,
            fraction,
            wall_s,
        });
    }

    /// Records notes and warnings about the run as a whole: open triangles, maps left out, paths not found and dark maps.
    fn tell_at_the_end(&mut self, scene: &Scene, world: &World, solids: &Solids) {
        if solids.open_triangles() > 0 && self.traced.iter().flatten().any(|map| map.mesh.is_some()) {
            self.notes.push(format!(
                "light mesh: {} of {} triangles belong to no closed solid; every mesh point near them was tested \
                 with its own ray",
                solids.open_triangles(),
                scene.triangles.len()
            ));
        }
        let names: Vec<String> = self.left_out.iter().map(|(kind, _)| format!("\"{}\"", kind.name(scene))).collect();
        let (verb, it_was) = if names.len() == 1 { ("is", "it was") } else { ("are", "they were") };
        self.warnings.extend((!names.is_empty()).then(|| {
            format!("light mesh: {} {verb} left out: the run had to end long before {it_was} computed", joined(&names))
        }));
        self.warnings.extend(world.paths_not_found.iter().map(|paths| format!("not found: {paths}")));
        for map in self.traced.iter().flatten().map(|map| &map.map) {
            let Some(bound) = map.dark_bound_words() else { continue };
            self.warnings.push(format!(
                "no light was found in \"{}\": its mean is below about {bound}; chains (--method collision) show \
                 more of maps as dark as this",
                map.name
            ));
        }
    }
}

/// The stated error of a map that the target binds; 0 for other maps.
fn bound_error(map: &TracedMap) -> f64 {
    if map.map.bound { map.map.error.estimated } else { 0.0 }
}

/// Returns whether there is at least one map and all maps are free of error.
fn is_exact(maps: &[MapResult]) -> bool {
    let is_known = |map: &MapResult| map.error.estimated == 0.0 && map.error.dark_upper_bound.is_none();
    !maps.is_empty() && maps.iter().all(is_known)
}

/// Upper bound on the mean of a map in which no light was found, in the unit of its values, from the number of rays per point. `None` where
/// light was found, and where no surface reflects, so that shadow rays alone give the whole light.
fn dark_upper_bound(world: &World, entries: &Entries, map: &TracedMap) -> Option<f64> {
    let weight: f64 = entries.weights.iter().sum();
    let is_dark = map.map.values.value.iter().all(|value| *value == 0.0);
    let flux_lm = world.emitters.luminous_flux_lm();
    (is_dark && world.reflects() && flux_lm > 0.0 && weight > 0.0).then(|| {
        let rays_a_place = (map.effort.rays() as f64 / entries.places().max(1) as f64).max(1.0);
        PACKETS_OF_A_BOUND * flux_lm / (rays_a_place * weight)
    })
}

/// Plans and computes a map until its last check meets the target, if there is a target. If the run is ended in between, the
/// attempt with the smallest upper error is kept, even an earlier one. `None` if the map is given up without any result.
fn best_attempt<'a>(
    planner: &mut Planner<'a>,
    entries: &Entries,
    number: u32,
    bound: bool,
    target_error: Option<f64>,
    rays: &mut u64,
) -> Option<(MapPlan<'a>, TracedMap)> {
    (planner.caution, planner.by_places) = (1.0, false);
    let mut best: Option<(MapPlan<'a>, TracedMap)> = None;
    for attempt in 0.. {
        let plan = planner.plan(entries, number + attempt * ATTEMPT, bound);
        let map = planner.trace(entries, number + attempt * ATTEMPT, &plan);
        *rays += map.effort.rays() + map.check_rays;
        if (planner.around.give_up)() {
            return best;
        }
        let missed = target_error.is_some_and(|target| map.upper_error > target);
        let is_cut = (planner.stop)();
        if let Some(before) = best.take_if(|(_, before)| missed && is_cut && before.upper_error <= map.upper_error) {
            return Some(before);
        }
        if !missed || attempt == MOST_ATTEMPTS || is_cut {
            return Some((plan, map));
        }
        if best.as_ref().is_none_or(|(_, before)| map.upper_error < before.upper_error) {
            best = Some((plan, map));
        }
        // The last attempt uses no mesh. Its error is random only and needs no margin.
        planner.by_places = attempt + 1 == MOST_ATTEMPTS;
        planner.caution = if planner.by_places { 1.0 } else { NEXT_CAUTION * planner.caution };
    }
    unreachable!("attempts end")
}

/// Checks that light meshes can compute the requested maps.
///
/// # Errors
/// Fails with the part of the scene that they cannot compute.
pub fn check_requests(scene: &Scene, settings: &Settings) -> Result<(), NotForLightMesh> {
    let sets = map_requests(scene, &settings.maps).into_iter().filter_map(|(kind, _)| match kind {
        MapKind::Receivers(set) => Some(set),
        MapKind::Elements => None,
    });
    check(scene, sets)
}

/// Returns whether a luminaire nearly touches a surface, while the walks make no light-path connections to nearby luminaires. These
/// walks miss the bright spot, and so does the check of the map.
fn may_miss_near_luminaires(around: &Surroundings, entries: &Entries, plan: &MapPlan) -> bool {
    let touches = around.world.near_luminaires.as_ref().is_some_and(|near| near.touch());
    let by_mesh = matches!(plan.indirect, IndirectPlan::Mesh(_));
    touches && (around.samples_area_images() || by_mesh && !plan.connects_to_packets(around, entries))
}

#[cfg(test)]
mod tests {
    use std::path::Path;
    use std::sync::atomic::{AtomicU64, Ordering};

    use super::*;
    use crate::check::scene_from_json;
    use crate::light_mesh::NEVER;

    /// A run that ends during its second attempt returns the map of the first attempt, which has the smaller measured error. It
    /// does not return the unfinished result of the second (planted fault: returning it without comparison).
    #[test]
    fn a_run_that_is_cut_keeps_the_better_attempt() {
        let room = r#"{ "version": 1, "materials": { "grey": { "type": "diffuse", "reflectance": 0.5 } },
            "geometry": [{ "name": "room", "type": "box", "min": [0,0,0], "max": [4,4,3], "facing": "inward", "material": "grey" }],
            "luminaires": [{ "name": "lamp", "type": "point", "position": [1,1.5,2.2], "intensity_cd": 100 }],
            "receivers": [{ "name": "grid", "type": "grid", "origin": [0.2,0.2,0], "u": [3.6,0,0], "v": [0,3.6,0], "columns": 30, "rows": 30 }] }"#;
        let scene = scene_from_json(room, None, Path::new(".")).unwrap_or_else(|error| panic!("{error}"));
        let world = World::new(&scene);
        let (solids, samples) = (Solids::of(&scene), Samples::of(&world, SamplePlacing::Stratified, 1));
        let around = Surroundings { scene: &scene, world: &world, solids: &solids, samples: &samples, give_up: NEVER };
        let entries = Entries::of(&around, MapKind::Receivers(0), 1, None, false);
        let (asked, most) = (AtomicU64::new(0), AtomicU64::new(u64::MAX));
        let stop = || asked.fetch_add(1, Ordering::Relaxed) >= most.load(Ordering::Relaxed);
        let wishes = Wishes {
            step_m: None,
            radius_m: None,
            form: IndirectForm::Directional,
            accelerations: Accelerations::ALL,
            target_error: Some(0.005),
            seed: 1,
        };
        let mut planner =
            Planner { around, wishes, caution: 1.0, by_places: false, most_rays: f64::INFINITY, stop: &stop };
        let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a thread");
        pool.install(|| {
            let plan = planner.plan(&entries, 0, true);
            let first = planner.trace(&entries, 0, &plan);
            let of_first = asked.swap(0, Ordering::Relaxed);

            // No attempt meets this target, so another attempt follows each one.
            most.store(of_first + 10, Ordering::Relaxed);
            let kept = best_attempt(&mut planner, &entries, 0, true, Some(1e-9), &mut 0);
            let (_, kept) = kept.expect("a map is kept");
            assert!(asked.load(Ordering::Relaxed) > of_first + 10, "the second attempt was begun");
            assert_eq!(kept.map.values.value, first.map.values.value);

            planner.caution = NEXT_CAUTION;
            let plan = planner.plan(&entries, ATTEMPT, true);
            let second = planner.trace(&entries, ATTEMPT, &plan);
            assert!(second.upper_error > first.upper_error, "{} {}", second.upper_error, first.upper_error);
        });
    }
}
