//! Stores the state of a run if requested, and resumes from a stored state.

use super::kept::{KeptRun, RunState};
use super::state::Run;
use crate::control::Forecast;
use crate::solver::StopReason;

impl Run<'_> {
    /// Stores the state if the observer wants it now.
    pub(super) fn keep_if_due(&self) {
        if let Some(keeper) = self.observer.keeper().filter(|keeper| keeper.is_due()) {
            keeper.keep(&self.state(), &self.progress(), None);
        }
    }

    /// Stores the state at which the work ended.
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
            selection_by_cell: self.context.world.selection_by_cell(),
            wall_s: self.observer.wall_s(),
        }
    }

    /// Resumes from a stored state. If the target has changed, maps that were judged are judged anew, and forecasts of the first target
    /// give way to the present values of their time.
    pub(super) fn take_up(&mut self, kept: KeptRun) {
        let world = self.context.world;
        world.take_selection_by_cell(kept.selection_by_cell);
        (self.jobs, self.sets, self.most_bytes_of_cells) = (kept.jobs, kept.sets, kept.most_bytes_of_cells);
        (self.convergence, self.spending, self.clock) = (kept.convergence, kept.spending, kept.clock);
        for job in &mut self.jobs {
            job.take_numbering(&world.elements);
            if job.met {
                job.run_checks(self.target_error);
            }
        }
        if kept.target_error != self.target_error {
            (0..self.jobs.len()).for_each(|index| self.aim_anew(index));
            for row in &mut self.convergence {
                (row.forecast_rays, row.forecast_wall_s) =
                    (Forecast::known(row.rays as f64), Forecast::known(row.wall_s));
            }
        }
    }

    /// Judges a map by another target than the one that it had before.
    fn aim_anew(&mut self, index: usize) {
        let target_error = self.target_error;
        let job = &mut self.jobs[index];
        if let (Some(adaptive), Some(target)) = (&mut job.adapting.adaptive, target_error) {
            adaptive.aim_at(target);
        }
        (job.met, job.adapting.finest, job.looks.refused) = (false, false, false);
        let is_whole = job.map.direct_samples.partial == 0 && job.map.indirect_samples.partial == 0;
        if job.is_judged() && is_whole {
            self.look(index);
        }
    }
}
