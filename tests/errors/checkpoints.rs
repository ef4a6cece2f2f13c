//! Runs that are saved between two slices and continued give the same bytes as an uninterrupted run.

use std::path::Path;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use luxmc::check::scene_from_json;
use luxmc::scene::Scene;
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

/// Saves the state after the first slice, whenever the number of slices has grown fivefold, and at the end.
#[derive(Default)]
struct Notes {
    slices: AtomicUsize,
    next: AtomicUsize,
    states: Mutex<Vec<Vec<u8>>>,
}

impl Observer for Notes {
    fn keeper(&self) -> Option<&dyn Keeper> {
        Some(self)
    }
}

impl Keeper for Notes {
    fn is_due(&self) -> bool {
        let (slice, next) = (self.slices.fetch_add(1, Ordering::Relaxed), self.next.load(Ordering::Relaxed));
        if slice == next {
            self.next.store(5 * next + 4, Ordering::Relaxed);
        }
        slice == next
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

/// Everything in a solution but its times.
fn told(solution: &Solution) -> String {
    let Solution { maps, elements, glare, convergence, spending, notes, warnings, .. } = solution;
    let rows: Vec<_> =
        convergence.iter().map(|row| (row.rays, row.chains, row.error, row.judged, row.forecast_rays)).collect();
    let rays = Activity::ALL.map(|activity| spending.rays(activity));
    let ends = (solution.stop_reason, solution.target_met, solution.estimated_error, solution.chains, solution.rays);
    let checks = (&solution.flux_balance, &solution.map_check);
    format!("{ends:?}\n{rays:?}\n{checks:?}\n{notes:?}\n{warnings:?}\n{rows:?}\n{glare:?}\n{elements:?}\n{maps:?}")
}

/// Checks that runs continued from each state between slices give the result of the uninterrupted run. Returns the states.
fn goes_on_as_before(scene: &Scene, settings: &Settings, least_states: usize) -> Vec<Vec<u8>> {
    let whole = told(&solve(scene, settings, &Silent));
    let notes = Notes::default();
    assert!(whole == told(&solve(scene, settings, &notes)), "keeping changes the run: {settings:?}");
    let states = notes.states.into_inner().expect("no thread has panicked");
    assert!(states.len() >= least_states, "{} states: {settings:?}", states.len());
    for (number, state) in states.iter().enumerate() {
        let again = told(&resume(scene, settings, going_on(kept_of(state)), &Silent));
        assert!(again == whole, "state {number}: {settings:?}\n{}", first_difference(&again, &whole));
    }
    states
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
    goes_on_as_before(&scene, &to(0.01, Method::Auto, &["plane"]), 2);
    goes_on_as_before(&scene, &to(0.02, Method::Gather, &["plane"]), 2);
    goes_on_as_before(&scene, &to(0.02, Method::Local, &["plane"]), 2);
    let walks = to(0.02, Method::Collision, &["plane"]);
    let states = goes_on_as_before(&scene, &walks, 2);

    // The planted faults are found: a single sum that is off by 10⁻⁸ of its value, and random numbers of another seed from there on.
    let whole = told(&resume(&scene, &walks, going_on(kept_of(&states[0])), &Silent));
    let is_sum = |bytes: &[u8]| (10.0..1e5).contains(&f64::from_le_bytes(bytes.try_into().expect("eight bytes")));
    let mut state = states[0].clone();
    let sums = state.windows(64).position(|bytes| bytes.chunks_exact(8).all(is_sum)).expect("eight sums in a row");
    state[sums + 3] ^= 1;
    assert!(told(&resume(&scene, &walks, going_on(kept_of(&state)), &Silent)) != whole, "a sum that is off passed");
    let other = Settings { seed: 1, ..walks };
    assert!(told(&resume(&scene, &other, going_on(kept_of(&states[0])), &Silent)) != whole, "another seed passed");
}

#[test]
fn elements_go_on_given_and_adaptive() {
    let scene = room("wood");
    for (elements, method, target_error) in [
        (ElementChoice::Given, Method::Collision, 0.05),
        (ElementChoice::Given, Method::Gather, 0.05),
        (ElementChoice::Adaptive, Method::Collision, 0.15),
        (ElementChoice::Adaptive, Method::Gather, 0.15),
    ] {
        goes_on_as_before(&scene, &Settings { elements, ..to(target_error, method, &["elements"]) }, 2);
    }
}

#[test]
fn luminance_glare_gloss_and_fixed_chains_go_on() {
    let scene = room("lacquer");
    goes_on_as_before(&scene, &Settings { target_error: Some(0.05), ..Settings::default() }, 2);
    goes_on_as_before(&scene, &Settings { chains: Some(10_000), ..Settings::default() }, 2);
}
