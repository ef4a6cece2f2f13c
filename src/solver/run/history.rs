//! The state of a run: the rows of its history, and reports to its observer.

use super::map_states::may_evaluate_all;
use super::progress::Progress;
use super::state::Run;
use crate::control::Forecast;
use crate::solver::ConvergenceRow;
use crate::solver::job::Job;

/// The history gets a row when a map was judged, and without a judgement after this share of the forecast run or of the rays so far. The
/// smaller of the two steps counts, since early forecasts may be far too long.
const STEP_OF_ROWS: f64 = 0.02;
const GROWTH_OF_ROWS: f64 = 0.1;

impl Run<'_> {
    /// Adds a row to the history: when a map was judged, and at regular steps of rays.
    pub(super) fn record(&mut self, judged: bool) {
        let is_due = match self.convergence.last() {
            Some(last) => {
                let step = (STEP_OF_ROWS * last.forecast_rays.expected).min(GROWTH_OF_ROWS * last.rays as f64);
                self.all_rays() as f64 >= last.rays as f64 + step
            }
            None => true,
        };
        let rays = self.all_rays();
        if !(judged || is_due) || !may_evaluate_all(self.jobs.len(), rays, self.recorded_at) {
            return;
        }
        self.recorded_at = Some(rays);
        let affordable = rays as f64 / self.convergence.len().max(1) as f64;
        for job in self.jobs.iter_mut().filter(|job| job.bound) {
            job.judge_for_forecast(affordable);
        }
        self.map_states.forget();
        let row = self.convergence_row();
        self.convergence.extend(row);
    }

    /// Reports the state of the run.
    pub(super) fn tell(&mut self) {
        let rays = self.all_rays();
        if may_evaluate_all(self.jobs.len(), rays, self.last_row_rays) {
            self.last_row_rays = Some(rays);
            self.observer.progress(&self.progress());
        }
    }

    /// Adds the last row: the final state.
    pub(super) fn record_end(&mut self) {
        let Some(row) = self.convergence_row() else {
            return;
        };
        let (rays, wall_s) = (Forecast::known(row.rays as f64), Forecast::known(row.wall_s));
        self.convergence.push(ConvergenceRow { forecast_rays: rays, forecast_wall_s: wall_s, ..row });
    }

    /// The state of the run as a row of its history. `None` while nothing is known about the error of any bound map.
    fn convergence_row(&self) -> Option<ConvergenceRow> {
        let (rays, wall_s) = (self.all_rays(), self.observer.wall_s());
        let bound = || self.jobs.iter().filter(|job| job.bound && !job.map.is_empty());
        let errors = bound().filter_map(|job| job.error_so_far(self.context));
        let error = errors.max_by(|a, b| a.estimated.total_cmp(&b.estimated))?;
        let (left, remaining_s) = self.remaining(rays, wall_s).unwrap_or_default();
        Some(ConvergenceRow {
            wall_s,
            rays,
            chains: self.jobs.iter().map(Job::chains).sum::<u64>(),
            error,
            judged: bound().all(Job::is_judged),
            forecast_rays: Forecast::known(rays as f64).plus(left.rays),
            forecast_wall_s: Forecast::known(wall_s).plus(remaining_s),
        })
    }

    /// The state of the run, with a forecast if a target, chains or a limit end it.
    pub(super) fn progress(&self) -> Progress {
        let judged = || self.jobs.iter().filter(|job| job.bound && job.has_been_judged());
        let (rays, wall_s) = (self.all_rays(), self.observer.wall_s());
        let remaining = self.remaining(rays, wall_s);
        let time_fraction = self.settings.time_limit_s.map_or(0.0, |limit_s| wall_s / limit_s);
        let rays_left = remaining.as_ref().map_or(f64::INFINITY, |(left, _)| left.rays.expected);
        let work_fraction = rays as f64 / (rays as f64 + rays_left).max(1.0);
        let errors = judged().filter_map(|job| job.error_so_far(self.context)).map(|error| error.estimated);
        Progress {
            estimated_error: errors.reduce(f64::max),
            target_error: self.target_error,
            chains: self.jobs.iter().map(Job::chains).sum::<u64>(),
            rays,
            forecast_rays: remaining.as_ref().map(|(left, _)| Forecast::known(rays as f64).plus(left.rays)),
            remaining_s: remaining.as_ref().map(|(_, seconds)| *seconds),
            slowest_map: remaining.and_then(|(left, _)| left.slowest).map(|(name, _)| name),
            fraction: work_fraction.max(time_fraction).min(1.0),
            wall_s,
        }
    }
}
