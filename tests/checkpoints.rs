//! Runs that are kept between two slices of work and go on from there come to the bytes of a run that was not interrupted.

use std::path::Path;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use luxmc::scene::{Scene, scene_from_json};
use luxmc::solver::{
    Activity, ElementChoice, GoingOn, Keeper, KeptRun, MapSelection, Method, Observer, Progress, RunState, Settings,
    Silent, Solution, StopReason, resume, solve,
};

/// A bright room with a shelf, a glossy table and several luminaires.
const ROOM: &str = r#"{ "version": 1,
  "materials": { "plaster": { "type": "diffuse", "reflectance": 0.7 }, "wood": { "type": "diffuse", "reflectance": 0.3 },
    "lacquer": { "type": "phong", "diffuse_reflectance": 0.3, "specular_reflectance": 0.2, "exponent": 20 } },
  "geometry": [
    { "name": "room", "type": "box", "min": [0,0,0], "max": [5,4,2.8], "facing": "inward", "material": "plaster", "max_element_edge": 2 },
    { "name": "shelf", "type": "box", "min": [2,1,0], "max": [2.4,3,1.9], "material": "wood" },
    { "name": "table", "type": "rectangle", "origin": [3,1,0.75], "u": [1.2,0,0], "v": [0,0.8,0], "material": "TABLE", "two_sided": true },
    { "name": "panel", "type": "rectangle", "origin": [3,2,2.79], "u": [0,0.6,0], "v": [0.6,0,0], "material": "plaster" } ],
  "luminaires": [
    { "name": "panel", "type": "area", "surface": "panel", "luminous_flux_lm": 3000 },
    { "name": "spot", "type": "point", "position": [1,1,2.5], "distribution": "lambertian", "aim": [0,0,-1], "luminous_flux_lm": 700 },
    { "name": "bulb", "type": "sphere", "center": [1,3,2.3], "radius": 0.1, "luminous_flux_lm": 900 } ],
  "receivers": [
    { "name": "plane", "type": "grid", "origin": [0.4,0.4,0.8], "u": [4.2,0,0], "v": [0,3.2,0], "columns": 9, "rows": 7 },
    { "name": "view", "type": "luminance", "position": [0.5,0.5,1.2], "directions": [[1,0.2,0],[1,1,-0.2],[0.9,0.1,-0.4]] },
    { "name": "glare", "type": "ugr", "position": [0.5,0.5,1.2], "view_direction": [1,1,0] } ] }"#;

fn room(table: &str) -> Scene {
    scene_from_json(&ROOM.replace("TABLE", table), None, Path::new(".")).expect("a valid scene")
}

/// Keeps the states that it is to, by the number of the slice; the first so many slices alone are done.
struct Notes {
    every: usize,
    slices: AtomicUsize,
    last: usize,
    states: Mutex<Vec<Vec<u8>>>,
}

impl Notes {
    fn new(every: usize, last: usize) -> Notes {
        Notes { every, slices: AtomicUsize::new(0), last, states: Mutex::default() }
    }

    fn states(self) -> Vec<Vec<u8>> {
        self.states.into_inner().expect("no thread has panicked")
    }
}

impl Observer for Notes {
    fn keeper(&self) -> Option<&dyn Keeper> {
        Some(self)
    }

    fn is_interrupted(&self) -> bool {
        self.slices.load(Ordering::Relaxed) >= self.last
    }
}

impl Keeper for Notes {
    fn is_due(&self) -> bool {
        self.slices.fetch_add(1, Ordering::Relaxed) % self.every == 0
    }

    fn keep(&self, state: &RunState, _: &Progress, _: Option<StopReason>) {
        self.states.lock().expect("no thread has panicked").push(bytes_of(state));
    }
}

fn bytes_of(state: &RunState) -> Vec<u8> {
    postcard::to_stdvec(state).expect("a state can be written")
}

fn kept_of(bytes: &[u8]) -> KeptRun {
    postcard::from_bytes(bytes).expect("a state can be read")
}

fn going_on(kept: KeptRun) -> GoingOn {
    GoingOn { kept, time_limit_s: None }
}

/// All that a solution tells but times.
fn told(solution: &Solution) -> String {
    let Solution { maps, elements, glare, convergence, spending, notes, warnings, .. } = solution;
    let rows: Vec<_> =
        convergence.iter().map(|row| (row.rays, row.chains, row.error, row.judged, row.forecast_rays)).collect();
    let rays = Activity::ALL.map(|activity| spending.rays(activity));
    let ends = (solution.stop_reason, solution.target_met, solution.estimated_error, solution.chains, solution.rays);
    let checks = (&solution.flux_balance, &solution.map_check);
    format!("{ends:?}\n{rays:?}\n{checks:?}\n{notes:?}\n{warnings:?}\n{rows:?}\n{glare:?}\n{elements:?}\n{maps:?}")
}

/// Runs that go on from a state between any two slices come to what the run came to that was not interrupted.
fn goes_on_as_before(scene: &Scene, settings: &Settings, least_states: usize) {
    let notes = Notes::new(1, usize::MAX);
    let whole = told(&solve(scene, settings, &notes));
    assert!(whole == told(&solve(scene, settings, &Silent)), "keeping changes the run: {settings:?}");
    let states = notes.states();
    assert!(states.len() >= least_states, "{} states: {settings:?}", states.len());
    let last = states.len() - 1;
    let mut cuts = vec![0, 1, last / 4, last / 2, 3 * last / 4, last - 1, last];
    cuts.dedup();
    for cut in cuts {
        let again = told(&resume(scene, settings, going_on(kept_of(&states[cut])), &Silent));
        assert!(again == whole, "state {cut} of {last}: {settings:?}\n{}", first_difference(&again, &whole));
    }
}

fn first_difference(one: &str, other: &str) -> String {
    let place = one.bytes().zip(other.bytes()).take_while(|(one, other)| one == other).count();
    let around = |text: &str| text.get(place.saturating_sub(120)..(place + 80).min(text.len())).map(str::to_owned);
    format!("{:?}\n{:?}", around(one), around(other))
}

fn to(target_error: f64, method: Method, maps: &[&str]) -> Settings {
    Settings {
        method,
        target_error: Some(target_error),
        maps: MapSelection::Named(maps.iter().map(|name| (*name).to_owned()).collect()),
        ..Settings::default()
    }
}

#[test]
fn receivers_go_on_by_every_method() {
    let scene = room("wood");
    goes_on_as_before(&scene, &to(0.004, Method::Auto, &["plane"]), 4);
    goes_on_as_before(&scene, &to(0.01, Method::Gather, &["plane"]), 4);
    goes_on_as_before(&scene, &to(0.01, Method::Collision, &["plane"]), 4);
    goes_on_as_before(&scene, &to(0.01, Method::Local, &["plane"]), 4);
    goes_on_as_before(&scene, &to(0.02, Method::LocalNaive, &["plane"]), 2);
}

#[test]
fn elements_go_on_given_and_adaptive() {
    let scene = room("wood");
    for elements in [ElementChoice::Given, ElementChoice::Adaptive] {
        for method in [Method::Auto, Method::Gather, Method::Collision] {
            goes_on_as_before(&scene, &Settings { elements, ..to(0.02, method, &["elements"]) }, 3);
        }
    }
}

#[test]
fn luminance_glare_gloss_and_fixed_chains_go_on() {
    let scene = room("lacquer");
    let all = Settings { target_error: Some(0.02), ..Settings::default() };
    goes_on_as_before(&scene, &all, 4);
    let chains = Settings { chains: Some(40_000), ..Settings::default() };
    goes_on_as_before(&scene, &chains, 6);
    goes_on_as_before(&scene, &Settings { method: Method::Collision, ..chains }, 6);
}
