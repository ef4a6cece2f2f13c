//! Light meshes as a method like the others.

use std::sync::OnceLock;
use std::time::Instant;

use crate::chain::Stage;
use crate::control::Forecast;
use crate::estimators::roulette::stage_for_walks;
use crate::light_mesh::{
    Accelerations, DirectPlan, Entries, IndirectForm, IndirectPlan, LEAST_RADIUS_PER_STEP, MOST_RADIUS_PER_STEP,
    MapPlan, NotForLightMesh, Planner, RADIUS_PER_STEP, SamplePlacing, Samples, Solids, Surroundings, TracedMap, Why,
    Wishes, check,
};
use crate::maps::{MapError, MapKind, MapResult};
use crate::scene::{Elements, Scene, joined};
use crate::solver::{ConvergenceRow, ErrorParts, Observer, Progress, Settings, Solution, Spending, StopReason};
use crate::solver::{DEFAULT_TARGET_ERROR, PACKETS_OF_A_BOUND, map_requests};

use super::light_mesh_words::{said, step_not_taken, why_in_words};

/// Plans of a map after the first whose last check missed the target.
const MOST_ATTEMPTS: u32 = 3;
/// Part of the target that the next plan aims at, over that of the one before.
const NEXT_CAUTION: f64 = 0.7;
/// Step between the maps' numbers of one plan and the next: each checks at places of its own.
const ATTEMPT: u32 = 1 << 8;
/// A map that the target does not bind takes about as many rays as those that it binds at most, or as many as this.
const LEAST_RAYS: f64 = 1e7;

/// How long in s, by the run's clock, a map that shows nothing yet goes on when the run was to end.
const PATIENCE_S: f64 = 0.6;

/// How the light mesh of a run is made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeshChoice {
    /// Step in m; `None`: found by refining.
    pub step_m: Option<f64>,
    /// Radius in m; `None`: 1.25 steps.
    pub radius_m: Option<f64>,
    /// What mesh points keep of indirect light.
    pub form: IndirectForm,
    /// What saves time.
    pub accelerations: Accelerations,
}

impl MeshChoice {
    /// Whether step and radius go together.
    ///
    /// # Errors
    /// What was given, and what was expected.
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

/// Solves a scene for the maps asked for by light meshes.
///
/// # Errors
/// What of the scene light meshes cannot compute.
pub fn solve_by_light_mesh(
    scene: &Scene,
    settings: &Settings,
    choice: &MeshChoice,
    observer: &dyn Observer,
) -> Result<Solution, NotForLightMesh> {
    let requests = map_requests(scene, &settings.maps);
    check_requests(scene, settings)?;
    let started = Instant::now();
    let stage = stage_for_walks(scene);
    let build_s = started.elapsed().as_secs_f64();
    observer.ready();
    let begun_wall_s = observer.wall_s();
    let solids = Solids::of(scene);
    let samples = Samples::of(&stage, SamplePlacing::Stratified, settings.seed);
    // A step that the user gives is taken as it is, if no error is asked for besides.
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
        around: Surroundings { scene, stage: &stage, solids: &solids, samples: &samples, give_up: &is_long_over },
        wishes: Wishes {
            step_m: choice.step_m,
            radius_m: choice.radius_m,
            form: choice.form,
            accelerations: choice.accelerations,
            // A time limit alone has a step found for the usual target, as far as the time goes.
            target_error: target_error.or_else(|| (!is_given).then_some(DEFAULT_TARGET_ERROR)),
            seed: settings.seed,
        },
        caution: 1.0,
        by_places: false,
        most_rays: f64::INFINITY,
        stop: &stop,
    };

    let mut run = trace_maps(&mut planner, &requests, target_error, observer);
    run.tell_at_the_end(scene, &stage, &solids);
    let end = match () {
        _ if observer.is_interrupted() => StopReason::Interrupted,
        _ if is_late() => StopReason::TimeLimit,
        _ => StopReason::FinestMesh,
    };
    let compute_s = started.elapsed().as_secs_f64() - build_s;
    Ok(solution_of(
        scene,
        &stage,
        run,
        RunFrame { seed: settings.seed, target_error, end, begun_wall_s, build_s, compute_s },
    ))
}

/// Plans and computes the maps that are asked for.
fn trace_maps(
    planner: &mut Planner,
    requests: &[(MapKind, bool)],
    target_error: Option<f64>,
    observer: &dyn Observer,
) -> LightMeshFindings {
    let mut run = LightMeshFindings { traced: requests.iter().map(|_| None).collect(), ..LightMeshFindings::default() };
    let finds_step = planner.wishes.step_m.is_none();
    let mut finest_m: Option<f64> = None;
    // Maps that the target binds go first.
    let mut order: Vec<usize> = (0..requests.len()).collect();
    order.sort_by_key(|index| !requests[*index].1);
    for (done, index) in order.into_iter().enumerate() {
        let (kind, bound) = requests[index];
        if !bound && finds_step {
            // What the target does not bind is not refined: it takes the finest step of what is bound.
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
        let misses_near_lights = may_miss_near_lights(&planner.around, &entries, &plan);
        run.tell(&map, &plan, [planner.around.samples.len(), entries.places()], misses_near_lights);
        if bound && let Some(facts) = &map.mesh {
            finest_m = Some(finest_m.map_or(facts.step_m, |finest_m| finest_m.min(facts.step_m)));
        }
        let fraction = (done + 1) as f64 / requests.len() as f64;
        run.record(&map, bound, target_error, fraction, observer);
        let dark_upper_bound_lx = dark_upper_bound_lx(planner.around.stage, &entries, &map);
        let is_dark = dark_upper_bound_lx.is_some();
        let target_met = target_error.map(|target| map.upper_error <= target && !is_dark && !misses_near_lights);
        let error = MapError { dark_upper_bound_lx, ..map.map.error };
        let result = MapResult { bound, target_met, error, ..map.map };
        run.traced[index] = Some(TracedMap { map: result, ..map });
    }
    run
}

/// What frames a run: what it was to reach, why it ended if it did not, and its times.
struct RunFrame {
    seed: u64,
    target_error: Option<f64>,
    end: StopReason,
    begun_wall_s: f64,
    build_s: f64,
    compute_s: f64,
}

fn solution_of(scene: &Scene, stage: &Stage, run: LightMeshFindings, frame: RunFrame) -> Solution {
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
        paths_not_found: stage.paths_not_found.clone(),
        warnings,
        notes,
    }
}

/// What a run by light meshes has found so far.
#[derive(Default)]
struct LightMeshFindings {
    /// The maps asked for, in their order.
    traced: Vec<Option<TracedMap>>,
    /// Maps that the run's end left out, and whether the target binds them.
    left_out: Vec<(MapKind, bool)>,
    rays: u64,
    convergence: Vec<ConvergenceRow>,
    notes: Vec<String>,
    warnings: Vec<String>,
}

impl LightMeshFindings {
    /// Says how a map was computed, of so many points in a set and places, and what may be wrong with it.
    fn tell(&mut self, map: &TracedMap, plan: &MapPlan, [points, places]: [usize; 2], misses_near_lights: bool) {
        let name = &map.map.name;
        self.notes.extend(said(map, plan, points, places));
        self.warnings.extend(step_not_taken(map, plan));
        if misses_near_lights {
            self.warnings.push(format!(
                "light mesh: \"{name}\": a luminaire nearly touches a surface, and walks may miss the spot that it lights: the stated error may leave it out; --method auto finds it"
            ));
        }
        if let DirectPlan::Rays(why @ Why::TooFine(_)) = &plan.direct {
            self.warnings.push(format!("\"{name}\" has no mesh: {}; shadow rays replace it", why_in_words(why)));
        }
    }

    /// Records how exact the run is with a map, and tells how much of it is done.
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

    /// Says what the run as a whole has left open.
    fn tell_at_the_end(&mut self, scene: &Scene, stage: &Stage, solids: &Solids) {
        if solids.open_triangles() > 0 && self.traced.iter().flatten().any(|map| map.mesh.is_some()) {
            self.notes.push(format!(
                "light mesh: {} of {} triangles belong to no closed solid; near them every mesh point was tested by a ray of its own",
                solids.open_triangles(),
                scene.triangles.len()
            ));
        }
        let names: Vec<String> = self.left_out.iter().map(|(kind, _)| format!("\"{}\"", kind.name(scene))).collect();
        let (verb, it_was) = if names.len() == 1 { ("is", "it was") } else { ("are", "they were") };
        self.warnings.extend((!names.is_empty()).then(|| {
            format!("light mesh: {} {verb} left out: the run was to end long before {it_was} computed", joined(&names))
        }));
        self.warnings.extend(stage.paths_not_found.iter().map(|paths| format!("not found: {paths}")));
        for map in self.traced.iter().flatten().map(|map| &map.map) {
            let Some(bound) = map.error.dark_bound_words() else { continue };
            self.warnings.push(format!(
                "no light was found in \"{}\": its mean is below {bound}, about; chains (--method collision) tell more of what is so dark",
                map.name
            ));
        }
    }
}

/// The stated error of a map that the target binds; 0 of others.
fn bound_error(map: &TracedMap) -> f64 {
    if map.map.bound { map.map.error.estimated } else { 0.0 }
}

/// Whether there are maps, and all of them are without an error.
fn is_exact(maps: &[MapResult]) -> bool {
    let is_known = |map: &MapResult| map.error.estimated == 0.0 && map.error.dark_upper_bound_lx.is_none();
    !maps.is_empty() && maps.iter().all(is_known)
}

/// What the mean of a map in which no light was found is below in lx, by the number of rays for each place; `None` where light was
/// found, and where none can be reflected, so that shadow rays tell all.
fn dark_upper_bound_lx(stage: &Stage, entries: &Entries, map: &TracedMap) -> Option<f64> {
    let weight: f64 = entries.weights.iter().sum();
    let is_dark = map.map.values.illuminance_lx.iter().all(|lx| *lx == 0.0);
    let flux_lm = stage.emitters.luminous_flux_lm();
    (is_dark && stage.reflects() && flux_lm > 0.0 && weight > 0.0).then(|| {
        let rays_a_place = (map.effort.rays() as f64 / entries.places().max(1) as f64).max(1.0);
        PACKETS_OF_A_BOUND * flux_lm / (rays_a_place * weight)
    })
}

/// Plans and computes a map until its last check meets the target, if there is one. A run that is ended on the way keeps what
/// is nearest to the light by its own measurement, be it of an earlier attempt; `None` where it is given up with nothing to show.
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
        // The last go is without a mesh: its error is chance alone, and needs no caution.
        planner.by_places = attempt + 1 == MOST_ATTEMPTS;
        planner.caution = if planner.by_places { 1.0 } else { NEXT_CAUTION * planner.caution };
    }
    unreachable!("attempts end")
}

/// Whether light meshes can compute the maps that are asked for.
///
/// # Errors
/// What of the scene they cannot compute.
pub fn check_requests(scene: &Scene, settings: &Settings) -> Result<(), NotForLightMesh> {
    let sets = map_requests(scene, &settings.maps).into_iter().filter_map(|(kind, _)| match kind {
        MapKind::Receivers(set) => Some(set),
        MapKind::Elements => None,
    });
    check(scene, sets)
}

/// Whether a luminaire nearly touches a surface in a scene or map whose walks do not look back from what it lights: they miss
/// the spot, and so does what checks them.
fn may_miss_near_lights(around: &Surroundings, entries: &Entries, plan: &MapPlan) -> bool {
    let touches = around.stage.near_lights.as_ref().is_some_and(|near| near.touch());
    let by_mesh = matches!(plan.indirect, IndirectPlan::Mesh(_));
    touches && (around.looks_for_areas() || by_mesh && !plan.looks_back(around, entries))
}

#[cfg(test)]
mod tests {
    use std::path::Path;
    use std::sync::atomic::{AtomicU64, Ordering};

    use super::*;
    use crate::check::scene_from_json;
    use crate::light_mesh::NEVER;

    /// A run that is ended in its second attempt shows the map of the first, which is nearer to the light by its own
    /// measurement; what the second has by then is not (the planted fault: it would be shown without a choice).
    #[test]
    fn a_run_that_is_cut_keeps_the_better_attempt() {
        let room = r#"{ "version": 1, "materials": { "grey": { "type": "diffuse", "reflectance": 0.5 } },
            "geometry": [{ "name": "room", "type": "box", "min": [0,0,0], "max": [4,4,3], "facing": "inward", "material": "grey" }],
            "luminaires": [{ "name": "lamp", "type": "point", "position": [1,1.5,2.2], "intensity_cd": 100 }],
            "receivers": [{ "name": "grid", "type": "grid", "origin": [0.2,0.2,0], "u": [3.6,0,0], "v": [0,3.6,0], "columns": 30, "rows": 30 }] }"#;
        let scene = scene_from_json(room, None, Path::new(".")).unwrap_or_else(|error| panic!("{error}"));
        let stage = Stage::new(&scene);
        let (solids, samples) = (Solids::of(&scene), Samples::of(&stage, SamplePlacing::Stratified, 1));
        let around = Surroundings { scene: &scene, stage: &stage, solids: &solids, samples: &samples, give_up: NEVER };
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

            // Nothing meets this target, so that every attempt is followed by another.
            most.store(of_first + 10, Ordering::Relaxed);
            let kept = best_attempt(&mut planner, &entries, 0, true, Some(1e-9), &mut 0);
            let (_, kept) = kept.expect("a map is kept");
            assert!(asked.load(Ordering::Relaxed) > of_first + 10, "the second attempt was begun");
            assert_eq!(kept.map.values.illuminance_lx, first.map.values.illuminance_lx);

            planner.caution = NEXT_CAUTION;
            let plan = planner.plan(&entries, ATTEMPT, true);
            let second = planner.trace(&entries, ATTEMPT, &plan);
            assert!(second.upper_error > first.upper_error, "{} {}", second.upper_error, first.upper_error);
        });
    }
}
