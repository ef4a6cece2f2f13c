//! What a run is expected to take, from its pilots and a few slices of work: for several targets and methods, and the error that a time
//! limit affords.

use super::observer::Observer;
use super::requests::{adapts, choose_jobs};
use super::state::{Run, SHARE_OF_MEMORY};
use crate::base::memory::limit_bytes;
use crate::control::Forecast;
use crate::estimators::roulette::world_for_walks;
use crate::scene::Scene;
use crate::solver::context::Context;
use crate::solver::job::{Engine, Job, RAYS_PER_SLICE};
use crate::solver::pace::{Pace, TimeLeft};
use crate::solver::{Method, Settings};

/// Bytes that a gathering ray leaves behind, including those of cells.
const BYTES_OF_A_RAY: f64 = 16.0;
/// Slices of work that time a map's rays. They are as short as those of a run with a limit of this many seconds.
const SLICES: u32 = 5;
const PACE_S: f64 = 1.0;
/// Range of errors that is searched for the one that a time limit affords, and the number of bisections of it.
const ERRORS: [f64; 2] = [1e-5, 1.0];
const HALVINGS: u32 = 40;

/// Expected cost of a run to a target.
#[derive(Clone, Debug)]
pub struct Expectation {
    /// How maps are estimated.
    pub method: Method,
    /// Names, as in results, of the engines that estimate the bound maps.
    pub engines: Vec<&'static str>,
    /// Target as a fraction.
    pub target_error: f64,
    /// Rays, including those of pilots.
    pub rays: Forecast,
    /// Seconds of computing.
    pub compute_s: Forecast,
    /// Bytes that cells, and what is gathered through them, take in addition to the maps.
    pub bytes_of_cells: f64,
}

/// Runs the pilots of a scene with each method for each target, and returns what runs would take. Combinations whose pilots find no light
/// are left out.
/// Seconds come from the rate of a few slices of work. No map is produced. Of the settings, only seed, maps and elements are used.
pub fn expectations(
    scene: &Scene,
    settings: &Settings,
    methods: &[Method],
    targets: &[f64],
    observer: &dyn Observer,
) -> Vec<Expectation> {
    let world = world_for_walks(scene);
    let time_left = || if observer.is_interrupted() { TimeLeft::LongOver } else { TimeLeft::Enough };
    let mut expected = Vec::new();
    for (method, target) in methods.iter().flat_map(|method| targets.iter().map(move |target| (*method, *target))) {
        if observer.is_interrupted() {
            break;
        }
        let settings =
            Settings { method, target_error: Some(target), chains: None, time_limit_s: None, ..settings.clone() };
        let context = Context {
            scene,
            world: &world,
            seed: settings.seed,
            method,
            target_error: target,
            to_target: true,
            adapt_to: adapts(&settings, &world).then_some(target),
            time_left: &time_left,
            pace: Pace::within(PACE_S),
        };
        let mut run = Run::new(&context, &settings, Some(target), observer, u64::MAX);
        run.jobs = whole_jobs(&context, &settings);
        run.start_gathering();
        run.clock.pilots_end(run.all_rays(), observer.wall_s());
        run.time_some_slices();
        expected.extend(run.expectation(method, target));
    }
    expected
}

/// Jobs whose elements are already cut.
fn whole_jobs(context: &Context, settings: &Settings) -> Vec<Job> {
    let mut jobs = choose_jobs(context, &settings.maps);
    for job in &mut jobs {
        while job.cut_on(context, RAYS_PER_SLICE) {}
    }
    jobs
}

impl Run<'_> {
    /// Works a little on every bound map, to measure how fast its rays are.
    fn time_some_slices(&mut self) {
        for job in self.jobs.iter_mut().filter(|job| job.bound && !job.map.is_empty()) {
            job.next_judgement = job.first_samples();
            for _ in 0..SLICES {
                if job.advance(self.context, self.sets.as_mut(), job.next_judgement) {
                    break;
                }
            }
        }
    }

    /// What the run is expected to take, by its pilots.
    fn expectation(&self, method: Method, target_error: f64) -> Option<Expectation> {
        let rays = self.all_rays();
        let (left, seconds) = self.remaining(rays, self.observer.wall_s())?;
        let bound = || self.jobs.iter().filter(|job| job.bound);
        let mut engines: Vec<&str> = bound().map(|job| job.engine.name()).collect();
        engines.dedup();
        let gathers = bound().any(|job| job.engine == Engine::Gather);
        let most_bytes = limit_bytes() as f64 / SHARE_OF_MEMORY as f64;
        Some(Expectation {
            method,
            engines,
            target_error,
            rays: Forecast::known(rays as f64).plus(left.rays),
            compute_s: seconds,
            bytes_of_cells: if gathers { (BYTES_OF_A_RAY * left.rays.expected).min(most_bytes) } else { 0.0 },
        })
    }

    /// The error that a time limit affords, by the pilots. `None` if a pilot found no light or if there is no time left. `None` also if
    /// something else may end the run: chains, or a target that fits in.
    pub(super) fn affordable_error(&self) -> Option<Forecast> {
        if self.settings.chains.is_some() {
            return None;
        }
        let (rays, wall_s) = (self.all_rays(), self.observer.wall_s());
        let left_s = (self.settings.time_limit_s? - wall_s).max(0.0);
        let affordable = left_s * self.clock.rays_per_s(rays, wall_s);
        if affordable <= 0.0 {
            return None;
        }
        let rays_to = |error: f64| {
            let bound = self.jobs.iter().filter(|job| job.bound && !job.map.is_empty());
            bound
                .map(|job| job.rays_left(self.context, error))
                .try_fold(Forecast::default(), |sum, left| Some(sum.plus(left?)))
        };
        let error_of = |part: fn(&Forecast) -> f64| -> Option<f64> {
            let [mut low, mut high] = ERRORS;
            for _ in 0..HALVINGS {
                let middle = f64::sqrt(low * high);
                if part(&rays_to(middle)?) > affordable { low = middle } else { high = middle }
            }
            Some(high)
        };
        let least = self.settings.target_error.unwrap_or(0.0);
        let expected = error_of(|rays| rays.expected).filter(|error| (least..ERRORS[1]).contains(error))?;
        Some(Forecast { expected, low: error_of(|rays| rays.low)?, high: error_of(|rays| rays.high)? })
    }
}
