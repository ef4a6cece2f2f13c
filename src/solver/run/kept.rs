//! What a run keeps of itself so that it can go on from there: all that decides what it does next.
//!
//! A run is kept between two slices of work. What follows from the scene alone is made anew when it goes on; streams of random numbers
//! are known by what they are for, so that they have no state. The rest goes on as if nothing had happened in between: the run that goes
//! on comes to the same bytes as the one that was never interrupted. Its clock stands still in between.

use serde::{Deserialize, Serialize};

use super::clock::Clock;
use super::progress::Progress;
use crate::chain::SelectionByCell;
use crate::solver::gathering::CellSets;
use crate::solver::job::Job;
use crate::solver::spending::Spending;
use crate::solver::{ConvergenceRow, StopReason};

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
    pub(super) jobs: &'a [Job],
    pub(super) sets: &'a Option<CellSets>,
    pub(super) most_bytes_of_cells: u64,
    pub(super) convergence: &'a [ConvergenceRow],
    pub(super) spending: Spending,
    pub(super) clock: Clock,
    pub(super) target_error: Option<f64>,
    pub(super) selection_by_cell: Option<&'a SelectionByCell>,
    pub(super) wall_s: f64,
}

/// The state of a run, as it was read.
#[derive(Deserialize)]
pub struct KeptRun {
    pub(super) jobs: Vec<Job>,
    pub(super) sets: Option<CellSets>,
    pub(super) most_bytes_of_cells: u64,
    pub(super) convergence: Vec<ConvergenceRow>,
    pub(super) spending: Spending,
    pub(super) clock: Clock,
    pub(super) target_error: Option<f64>,
    pub(super) selection_by_cell: Option<SelectionByCell>,
    pub(super) wall_s: f64,
}

/// A kept run, and what is asked of it when it goes on.
pub struct GoingOn {
    /// Where it stood.
    pub kept: KeptRun,
    /// Seconds from the start of the process at which this part of it ends, in place of the limit of the whole.
    pub time_limit_s: Option<f64>,
}

impl KeptRun {
    /// Seconds of computing up to then.
    pub(super) fn compute_s(&self) -> f64 {
        self.wall_s - self.clock.begun_wall_s()
    }
}
