//! The run: jobs go forward in slices until the stop rule, a limit or the user ends it.

mod clock;
mod cutting;
mod expectations;
mod forecast;
mod history;
mod keeping;
mod kept;
mod long_over;
mod map_states;
mod next;
mod observer;
mod progress;
mod requests;

mod state;

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

pub use self::expectations::{Expectation, expectations};
pub use self::kept::{GoingOn, Keeper, KeptRun, RunState};
use self::long_over::give_up_long_paths;
pub use self::long_over::is_long_over;
use self::observer::LaterObserver;
pub use self::observer::{Observer, Silent};
pub use self::progress::{Progress, SlowestMap};
use self::requests::adapts;
pub use self::requests::map_requests;
use self::state::{Run, SHARE_OF_MEMORY};
use super::context::Context;
use super::finish::{Ending, finish};
use super::job::Job;
use super::pace::{Pace, TimeLeft};
use super::portion::{MapOfShare, MapSums, Portion, sums_of};
use super::spending::Activity;
use super::{DEFAULT_TARGET_ERROR, Settings, Solution, StopReason};
use crate::base::memory::limit_bytes;
use crate::estimators::roulette::world_for_walks;
use crate::scene::{Scene, joined};

/// Share of a time limit after which elements are not cut further before the run. Each round of cutting takes up to four times the work of
/// the one before.
const CUTTING_SHARE: f64 = 0.05;
/// Solves a scene for the requested maps.
/// The maps depend on the scene, the settings and how far the run went, never on threads: all sums grow in an order that the replicas fix.
/// Names in `settings.maps` must be those of receiver sets, or `elements`.
pub fn solve(scene: &Scene, settings: &Settings, observer: &dyn Observer) -> Solution {
    solve_as(scene, settings, None, None, observer).0
}

/// Resumes a stored run with the settings that it had, or with another target.
/// The scene must be the same to the last bit.
pub fn resume(scene: &Scene, settings: &Settings, going_on: GoingOn, observer: &dyn Observer) -> Solution {
    solve_as(scene, settings, None, Some(going_on), observer).0
}

/// Solves a whole scene, or a portion of the run, which leaves its sums. It starts from the beginning or resumes a stored run.
pub(super) fn solve_as(
    scene: &Scene,
    settings: &Settings,
    portion: Option<Portion>,
    going_on: Option<GoingOn>,
    observer: &dyn Observer,
) -> (Solution, Vec<(MapOfShare, MapSums)>) {
    let started = Instant::now();
    let world = world_for_walks(scene);
    let build_s = started.elapsed().as_secs_f64();
    observer.ready();
    let pace = match (settings.time_limit_s, settings.chains) {
        (_, Some(_)) => Pace::of_chains(),
        (Some(limit_s), None) => Pace::within(limit_s),
        (None, None) => Pace::steady(),
    };
    let observer = &LaterObserver::of(observer, going_on.as_ref());
    let time_limit_s = observer.time_limit_s(settings, going_on.as_ref());
    let settings = &Settings { time_limit_s, ..settings.clone() };
    let target_error = target_of(settings, portion);
    let adapt_to = adapts(settings, &world).then(|| target_error.unwrap_or(DEFAULT_TARGET_ERROR));
    let (seed, method) = (portion.map_or(settings.seed, |portion| portion.seed(settings.seed)), settings.method);
    let planned_error = settings.target_error.unwrap_or(DEFAULT_TARGET_ERROR);
    let is_later_than = |share: f64| settings.time_limit_s.is_some_and(|limit_s| observer.wall_s() > share * limit_s);
    // A checkpoint holds whole slices. If checkpoints are written, an interruption waits for the end of the present slice.
    let heeds_user = AtomicBool::new(true);
    let time_left = || match () {
        _ if is_long_over(settings, observer) => TimeLeft::LongOver,
        _ if heeds_user.load(Ordering::Relaxed) && observer.is_interrupted() || is_later_than(1.0) => TimeLeft::None,
        _ if is_later_than(CUTTING_SHARE) => TimeLeft::Little,
        _ => TimeLeft::Enough,
    };
    let context = Context {
        scene,
        world: &world,
        seed,
        method,
        target_error: planned_error,
        to_target: settings.chains.is_none(),
        adapt_to,
        time_left: &time_left,
        pace,
    };
    give_up_long_paths(&world, settings, observer.wall_s());
    let mut run = Run::new(&context, settings, target_error, observer, limit_bytes() / SHARE_OF_MEMORY);
    let kept_s = going_on.as_ref().map_or(0.0, |going_on| going_on.kept.compute_s());
    let is_whole = match going_on {
        Some(going_on) => {
            run.take_up(going_on.kept);
            true
        }
        None => run.begin(),
    };
    heeds_user.store(observer.keeper().is_none() || !is_whole, Ordering::Relaxed);
    observer.progress(&run.progress());
    let stop_reason = run.work();
    run.map_states.forget();
    if is_whole {
        run.keep_end(stop_reason);
    }
    heeds_user.store(true, Ordering::Relaxed);
    // A single sample, if no more are requested, may have taken all the time available.
    let in_haste =
        matches!(stop_reason, StopReason::TimeLimit | StopReason::Interrupted) || time_left() <= TimeLeft::None;
    run.give_every_map_a_start(in_haste);
    let left_out = run.leave_out();
    run.judge_all(in_haste);
    let compute_s = kept_s + started.elapsed().as_secs_f64() - build_s;
    let (mut solution, jobs) = solution_of(run, stop_reason, [build_s, compute_s]);
    tell_left_out(&mut solution, &left_out);
    let sums = if portion.is_some() { jobs.into_iter().map(sums_of).collect() } else { Vec::new() };
    (solution, sums)
}

/// The target that ends a run. A share has none, since its target is that of the merged maps. A run without any stop rule gets the default
/// target.
fn target_of(settings: &Settings, portion: Option<Portion>) -> Option<f64> {
    let is_share = portion.is_some_and(|portion| portion.share.is_some());
    let is_endless = settings.chains.is_none() && settings.time_limit_s.is_none();
    settings.target_error.filter(|_| !is_share).or_else(|| is_endless.then_some(DEFAULT_TARGET_ERROR))
}

/// The solution of a run that has ended, and its jobs.
fn solution_of(run: Run, stop_reason: StopReason, [build_s, compute_s]: [f64; 2]) -> (Solution, Vec<Job>) {
    let Run { context, settings, target_error, mut jobs, convergence, mut spending, clock, .. } = run;
    for job in &jobs {
        spending += job.work.spending;
        spending.add(Activity::Pilots, job.work.pilot_rays, Duration::ZERO);
    }
    let begun_wall_s = clock.begun_wall_s();
    let ending = Ending { target_error, convergence, spending, stop_reason, begun_wall_s, build_s, compute_s };
    (finish(context, settings, &mut jobs, ending), jobs)
}

/// Reports maps that are left out. A bound map that is left out did not meet its target. If all bound maps are left out, the error is
/// unknown.
fn tell_left_out(solution: &mut Solution, left_out: &[(String, bool)]) {
    if left_out.iter().any(|(_, bound)| *bound) {
        solution.target_met = solution.target_met.map(|_| false);
        if !solution.maps.iter().any(|map| map.bound) {
            solution.estimated_error = f64::INFINITY;
        }
    }
    // All of ten thousand sets may be left out, so one sentence reports them together.
    let names: Vec<String> = left_out.iter().map(|(name, _)| format!("\"{name}\"")).collect();
    let (verb, whose) = if names.len() == 1 { ("is", "its") } else { ("are", "their") };
    solution.warnings.extend((!names.is_empty()).then(|| {
        format!("{} {verb} left out: the run had to end long before each of {whose} points had a value", joined(&names))
    }));
}
