//! What a run keeps of itself so that it can go on from there: all that decides what it does next.
//!
//! A run is kept between two slices of work. What follows from the scene alone is made anew when it goes on; streams of random numbers
//! are known by what they are for, so that they have no state. The rest goes on as if nothing had happened in between: the run that goes
//! on comes to the same bytes as the one that was never interrupted. Its clock stands still in between.

use serde::{Deserialize, Serialize};

use super::super::gathering::CellSets;
use super::super::job::Job;
use super::super::spending::Spending;
use super::super::{ConvergenceRow, Settings, Solution, StopReason};
use super::clock::Clock;
use super::{Observer, Progress, Run, solve_as};
use crate::chain::SelectionByCell;
use crate::control::Forecast;
use crate::scene::Scene;

/// Keeps a run's state from time to time.
pub trait Keeper: Sync {
    /// Whether the state is to be kept now; asked after every slice of work.
    fn is_due(&self) -> bool;
    /// Keeps the state; once more where the work ends, with the reason.
    fn keep(&self, state: &RunState, progress: &Progress, ended: Option<StopReason>);
}

/// The state of a run, to be written.
#[derive(Serialize)]
pub struct RunState<'a> {
    jobs: &'a [Job],
    sets: &'a Option<CellSets>,
    most_bytes_of_cells: u64,
    convergence: &'a [ConvergenceRow],
    spending: Spending,
    clock: Clock,
    target_error: Option<f64>,
    selection_by_cell: Option<&'a SelectionByCell>,
    wall_s: f64,
}

/// The state of a run, as it was read.
#[derive(Deserialize)]
pub struct KeptRun {
    jobs: Vec<Job>,
    sets: Option<CellSets>,
    most_bytes_of_cells: u64,
    convergence: Vec<ConvergenceRow>,
    spending: Spending,
    clock: Clock,
    target_error: Option<f64>,
    selection_by_cell: Option<SelectionByCell>,
    wall_s: f64,
}

/// A kept run, and what is asked of it when it goes on.
pub struct GoingOn {
    /// Where it stood.
    pub kept: KeptRun,
    /// Seconds from the start of the process at which this part of it ends, in place of the limit of the whole.
    pub time_limit_s: Option<f64>,
}

/// Goes on with a run from where it was kept, with the settings that it had, or another target.
///
/// The scene is the same to the last bit.
pub fn resume(scene: &Scene, settings: &Settings, going_on: GoingOn, observer: &dyn Observer) -> Solution {
    solve_as(scene, settings, None, Some(going_on), observer).0
}

/// An observer whose clock goes on from where that of a kept run stood.
pub(super) struct LaterObserver<'a> {
    observer: &'a dyn Observer,
    /// Seconds by which it is ahead.
    ahead_s: f64,
}

impl<'a> LaterObserver<'a> {
    /// Of a run that goes on, or begins.
    pub fn of(observer: &'a dyn Observer, going_on: Option<&GoingOn>) -> LaterObserver<'a> {
        let ahead_s = going_on.map_or(0.0, |going_on| going_on.kept.wall_s - observer.wall_s());
        LaterObserver { observer, ahead_s }
    }

    /// The limit in seconds of the whole run's clock.
    pub fn time_limit_s(&self, settings: &Settings, going_on: Option<&GoingOn>) -> Option<f64> {
        let of_part_s = going_on.and_then(|going_on| going_on.time_limit_s);
        of_part_s.map(|limit_s| limit_s + self.ahead_s).or(settings.time_limit_s)
    }
}

impl Observer for LaterObserver<'_> {
    fn ready(&self) {
        self.observer.ready();
    }

    fn progress(&self, progress: &Progress) {
        self.observer.progress(progress);
    }

    fn expects(&self, error: Forecast, target: Option<f64>) {
        self.observer.expects(error, target);
    }

    fn is_interrupted(&self) -> bool {
        self.observer.is_interrupted()
    }

    fn wall_s(&self) -> f64 {
        self.ahead_s + self.observer.wall_s()
    }

    fn keeper(&self) -> Option<&dyn Keeper> {
        self.observer.keeper()
    }
}

impl KeptRun {
    /// Seconds of computing up to then.
    pub(super) fn compute_s(&self) -> f64 {
        self.wall_s - self.clock.begun_wall_s()
    }
}

impl Run<'_> {
    /// Keeps the state where the observer wants that now.
    pub(super) fn keep_if_due(&self) {
        if let Some(keeper) = self.observer.keeper().filter(|keeper| keeper.is_due()) {
            keeper.keep(&self.state(), &self.progress(), None);
        }
    }

    /// Keeps the state at which the work ended.
    pub(super) fn keep_end(&self, stop_reason: StopReason) {
        if let Some(keeper) = self.observer.keeper() {
            keeper.keep(&self.state(), &self.progress(), Some(stop_reason));
        }
    }

    fn state(&self) -> RunState<'_> {
        RunState {
            jobs: &self.jobs,
            sets: &self.sets,
            most_bytes_of_cells: self.most_bytes_of_cells,
            convergence: &self.convergence,
            spending: self.spending,
            clock: self.clock,
            target_error: self.target_error,
            selection_by_cell: self.context.stage.selection_by_cell(),
            wall_s: self.observer.wall_s(),
        }
    }

    /// Goes on from a kept state; a map that was judged is judged anew where the target is another one.
    pub(super) fn take_up(&mut self, kept: KeptRun) {
        let stage = self.context.stage;
        stage.take_selection_by_cell(kept.selection_by_cell);
        (self.jobs, self.sets, self.most_bytes_of_cells) = (kept.jobs, kept.sets, kept.most_bytes_of_cells);
        (self.convergence, self.spending, self.clock) = (kept.convergence, kept.spending, kept.clock);
        for job in &mut self.jobs {
            job.take_numbering(&stage.elements);
            if job.met {
                job.run_checks(self.target_error);
            }
        }
        if kept.target_error != self.target_error {
            (0..self.jobs.len()).for_each(|index| self.aim_anew(index));
        }
    }

    /// Judges a map by another target than the one that it went for.
    fn aim_anew(&mut self, index: usize) {
        let target_error = self.target_error;
        let job = &mut self.jobs[index];
        if let (Some(adaptive), Some(target)) = (&mut job.adapting.adaptive, target_error) {
            adaptive.aim_at(target);
        }
        (job.met, job.adapting.finest, job.looks.refused) = (false, false, false);
        let is_whole = job.map.direct_samples.ahead == 0 && job.map.indirect_samples.ahead == 0;
        if job.is_judged() && is_whole {
            self.look(index);
        }
    }
}
