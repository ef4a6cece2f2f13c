//! Study of the choices of the method `auto`: the same maps to the same targets by `auto` and by every method that it can choose.

use std::path::Path;
use std::time::Instant;

use super::{Findings, StudyWishes};
use crate::check::{read_scene, scene_from_json};
use crate::scene::Scene;
use crate::solver::{ElementChoice, MapSelection, Method, Observer, Progress, Settings, Solution, StopReason, solve};
use crate::validation::find::find_cases;
use crate::validation::report::Table;
use crate::validation::words::{percent, scientific, significant};

/// Maximum cost of `auto` relative to the best fixed method.
const MOST_RATIO: f64 = 1.3;
/// Number of seeds for each run.
const SEEDS: u64 = 3;
/// A run shorter than this is repeated `REPEATS_OF_SHORT` times and its shortest time counts, since other programs may use the processors.
const SHORT_S: f64 = 0.3;
const REPEATS_OF_SHORT: usize = 4;
/// A fixed method is stopped when it has taken this multiple of the rays of `auto`, and at least `LEAST_RAYS`.
const PATIENCE: f64 = 3.0;
const LEAST_RAYS: f64 = 1e6;
/// Target errors.
const TARGETS: [f64; 3] = [0.05, 0.03, 0.01];

const SETTING: &str = "Every map is computed to the same targets by auto and by each fixed method that auto could have chosen instead: counting or walks (collision), gathering (gather) and, for receivers, local estimation (local). Values are means of three seeds. Rays are all counted rays, including pilots and abandoned methods. The ratio is auto's cost over that of the best of the others, in rays and in seconds, each against its own best. Auto considers work: rays, and the choice among luminaires besides them; so it may take more rays than another method and less time. Runs below 0.3 s are repeated four times, and the least time counts. Gathering is not a choice on Sobolev's planes, where its error bars do not hold (“–”). A method that has taken three times auto's rays is stopped (“>”). Light meshes and radiosity, which auto never chooses, are in the case comparisons.";

const CUBE: &str = r#"{ "version": 1, "materials": { "paint": { "type": "diffuse", "reflectance": 0.8 } },
    "geometry": [ { "name": "cube", "type": "box", "min": [0,0,0], "max": [4,4,4], "facing": "inward", "material": "paint"EDGE } ],
    "luminaires": [ { "name": "source", "type": "point", "position": [2,2,2], "luminous_flux_lm": 10000 } ] }"#;

/// The fixed methods.
const FIXED: [(&str, Method); 3] =
    [("collision", Method::Collision), ("gather", Method::Gather), ("local", Method::Local)];

/// One map of a scene.
struct Subject {
    name: &'static str,
    scene: Scene,
    maps: MapSelection,
    elements: ElementChoice,
    targets: &'static [f64],
    /// Name of a method whose error bars are wrong there, and which is therefore excluded.
    untrue: Option<&'static str>,
}

fn cube(edge: &str) -> Result<Scene, String> {
    scene_from_json(&CUBE.replace("EDGE", edge), None, Path::new(".")).map_err(|error| error.to_string())
}

/// The scene of a case's first run.
fn scene_of_case(name: &str) -> Result<(Scene, std::path::PathBuf), String> {
    let found = find_cases(&[name.to_owned()], None).map_err(|error| error.to_string())?;
    let mut case = found.cases.into_iter().next().ok_or_else(|| format!("no case \"{name}\""))?;
    Ok((case.runs.swap_remove(0).scene, case.folder))
}

fn subjects(wishes: &mut StudyWishes) -> Result<Vec<Subject>, String> {
    let (given, adaptive) = (ElementChoice::Given, ElementChoice::Adaptive);
    let of = |name, scene, maps, elements| Subject { name, scene, maps, elements, targets: &TARGETS, untrue: None };
    let mut subjects =
        vec![of("cube, 3,072 elements given", cube(r#", "max_element_edge": 0.36"#)?, MapSelection::Elements, given)];
    if wishes.quick {
        subjects[0].targets = &TARGETS[..1];
        return Ok(subjects);
    }
    let (elements, receivers) = (MapSelection::Elements, MapSelection::Receivers);
    subjects.push(of("cube, 12 triangles, elements that adapt", cube("")?, elements.clone(), adaptive));
    let (office, folder) = scene_of_case("office")?;
    subjects.push(of("office, elements given", office.clone(), elements.clone(), given));
    subjects.push(Subject {
        targets: &TARGETS[..2],
        ..of("office, elements that adapt", office.clone(), elements, adaptive)
    });
    subjects.push(of("office, receivers", office, receivers.clone(), given));
    let named = |name: &str| MapSelection::Named(vec![name.to_owned()]);
    subjects.push(of("room of six reflectances, points", scene_of_case("room")?.0, named("points"), given));
    let planes = of("Sobolev's planes, points", scene_of_case("sobolev")?.0, receivers.clone(), given);
    // The light of 200 m wide planes is concentrated in a few patches. Only 67 % of the error bars of `gather` covered the truth.
    subjects.push(Subject { untrue: Some("gather"), ..planes });
    subjects.push(of("isothermal office, work plane", scene_of_case("isothermal")?.0, named("work plane"), given));
    match read_scene(&folder.join("../../scenes/hall.json")) {
        Ok(hall) => subjects.push(Subject { targets: &TARGETS[1..2], ..of("hall, receivers", hall, receivers, given) }),
        Err(_) => (wishes.tell)("the hall is left out: its mesh is made by the example make_hall"),
    }
    Ok(subjects)
}

/// Observer that ends a run after too many rays.
struct RayLimit {
    started: Instant,
    rays: std::sync::atomic::AtomicU64,
    most_rays: f64,
}

impl Observer for RayLimit {
    fn progress(&self, progress: &Progress) {
        self.rays.store(progress.rays, std::sync::atomic::Ordering::Relaxed);
    }

    fn is_interrupted(&self) -> bool {
        self.rays.load(std::sync::atomic::Ordering::Relaxed) as f64 > self.most_rays
    }

    fn wall_s(&self) -> f64 {
        self.started.elapsed().as_secs_f64()
    }
}

/// Mean cost of the runs of one method.
#[derive(Clone, Debug, Default)]
struct MethodCost {
    rays: f64,
    seconds: f64,
    /// Whether every run met the target within the ray limit.
    arrived: bool,
    /// Names of the estimators of the maps.
    estimators: String,
}

fn cost(subject: &Subject, target_error: f64, method: Method, seeds: u64, most_rays: f64) -> MethodCost {
    let mut runs: Vec<Solution> = Vec::new();
    for seed in 0..seeds {
        let settings = Settings {
            method,
            elements: subject.elements,
            seed,
            target_error: Some(target_error),
            maps: subject.maps.clone(),
            ..Settings::default()
        };
        let once = || {
            let observer = RayLimit { started: Instant::now(), rays: Default::default(), most_rays };
            solve(&subject.scene, &settings, &observer)
        };
        let mut run = once();
        for _ in 0..if run.compute_s < SHORT_S { REPEATS_OF_SHORT } else { 0 } {
            run.compute_s = run.compute_s.min(once().compute_s);
        }
        runs.push(run);
        if runs.iter().any(|run| run.stop_reason == StopReason::Interrupted) {
            break;
        }
    }
    let mean = |of: &dyn Fn(&Solution) -> f64| runs.iter().map(of).sum::<f64>() / runs.len() as f64;
    let mut estimators: Vec<&str> = runs.iter().flat_map(|run| &run.maps).map(|map| map.method.as_str()).collect();
    estimators.sort_unstable();
    estimators.dedup();
    MethodCost {
        rays: mean(&|run| run.rays as f64),
        seconds: mean(&|run| run.compute_s),
        arrived: runs.iter().all(|run| matches!(run.stop_reason, StopReason::TargetMet | StopReason::Exact)),
        estimators: estimators.join(" and "),
    }
}

/// Cost of `auto` over the smallest cost of the fixed methods that met the target, with the name of that method.
fn ratio(auto: &MethodCost, fixed: &[(&'static str, MethodCost)], of: fn(&MethodCost) -> f64) -> (f64, &'static str) {
    let arrived = fixed.iter().filter(|(_, cost)| cost.arrived);
    let best = arrived.min_by(|one, other| of(&one.1).total_cmp(&of(&other.1)));
    match best {
        _ if !auto.arrived => (f64::INFINITY, "none"),
        Some((name, cost)) => (of(auto) / of(cost), name),
        // All other methods were stopped at three times the rays of `auto`.
        None => (1.0 / PATIENCE, "auto"),
    }
}

fn cell(cost: &MethodCost, of: fn(&MethodCost) -> f64, words: fn(f64) -> String) -> String {
    format!("{}{}", if cost.arrived { "" } else { "> " }, words(of(cost)))
}

/// Compares rays and seconds of `auto` and of the fixed methods.
pub fn choice(wishes: &mut StudyWishes) -> Result<Findings, String> {
    let mut found = Findings::of("choice", SETTING);
    let seeds = if wishes.quick { 1 } else { SEEDS };
    let (mut by_rays, mut by_seconds, mut worse) = (Vec::new(), Vec::new(), Vec::new());
    let mut worst = [(0.0, String::new()), (0.0, String::new())];
    for subject in subjects(wishes)? {
        for target_error in subject.targets {
            let place = format!("{} to {}", subject.name, percent(*target_error));
            (wishes.tell)(&place);
            let auto = cost(&subject, *target_error, Method::Auto, seeds, f64::INFINITY);
            let most_rays = (PATIENCE * auto.rays).max(LEAST_RAYS);
            let fixed: Vec<(&'static str, MethodCost)> = FIXED
                .iter()
                .filter(|(name, _)| subject.untrue != Some(*name))
                .filter(|(_, method)| *method != Method::Local || subject.maps != MapSelection::Elements)
                .map(|(name, method)| (*name, cost(&subject, *target_error, *method, seeds, most_rays)))
                .collect();
            let of_name = |name: &str| fixed.iter().find(|(known, _)| *known == name).map(|(_, cost)| cost);
            let rays: fn(&MethodCost) -> f64 = |cost| cost.rays;
            let seconds: fn(&MethodCost) -> f64 = |cost| cost.seconds;
            for (index, (rows, of, words)) in [
                (&mut by_rays, rays, scientific as fn(f64) -> String),
                (&mut by_seconds, seconds, |seconds| significant(seconds, 2)),
            ]
            .into_iter()
            .enumerate()
            {
                let (times, best) = ratio(&auto, &fixed, of);
                let mut row = vec![subject.name.to_owned(), percent(*target_error), cell(&auto, of, words)];
                row.extend(FIXED.map(|(name, _)| of_name(name).map_or("–".to_owned(), |cost| cell(cost, of, words))));
                let words = |times: f64, best: &str| match best {
                    "auto" => format!("< {}", significant(times, 2)),
                    _ => format!("{} ({best})", significant(times, 3)),
                };
                row.extend([words(times, best), auto.estimators.clone()]);
                rows.push(row);
                if times > worst[index].0 {
                    worst[index] = (times, place.clone());
                }
                if index == 1 && times > MOST_RATIO {
                    worse.push(format!("{place} ({} times {best})", significant(times, 3)));
                }
            }
        }
    }
    let [rays, seconds] = worst;
    found.results.push(format!(
        "In seconds auto takes at most {} times the best ({}); in rays {} times ({}).",
        significant(seconds.0, 3),
        seconds.1,
        significant(rays.0, 3),
        rays.1
    ));
    found.results.push(if worse.is_empty() {
        format!("In seconds it is never above {MOST_RATIO} times.")
    } else {
        format!("In seconds it is above {MOST_RATIO} times for: {}.", worse.join("; "))
    });
    let header = vec!["map", "target", "auto", "collision", "gather", "local", "over the best", "auto took"];
    for (caption, rows) in [("Seconds of computing", by_seconds), ("Rays", by_rays)] {
        found.tables.push((caption.to_owned(), Table { header: header.clone(), text_columns: vec![0, 7], rows }));
    }
    Ok(found)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_ratio_is_to_the_best_that_arrived() {
        let cost = |rays: f64, arrived: bool| MethodCost { rays, seconds: 1.0, arrived, estimators: String::new() };
        let fixed = [("collision", cost(50.0, false)), ("gather", cost(100.0, true)), ("local", cost(80.0, true))];
        let of: fn(&MethodCost) -> f64 = |cost| cost.rays;
        assert_eq!(ratio(&cost(140.0, true), &fixed[..2], of), (1.4, "gather"));
        assert_eq!(ratio(&cost(140.0, true), &fixed, of), (1.75, "local"));
        assert_eq!(ratio(&cost(30.0, true), &fixed[..1], of), (1.0 / PATIENCE, "auto"));
        assert_eq!(ratio(&cost(30.0, false), &fixed, of).0, f64::INFINITY);
    }
}
