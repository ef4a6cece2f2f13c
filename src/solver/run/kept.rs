//! The stored state of a run, from which it can resume: everything that decides what it does next.
//! A run is stored between two slices of work. What follows from the scene alone is rebuilt when the run resumes. Streams of random numbers
//! are identified by their purpose, so they have no state. A resumed run comes to the same bytes as one that was never interrupted. Its
//! clock does not run in between.

use serde::{Deserialize, Serialize};

use super::clock::Clock;
use super::progress::Progress;
use crate::solver::gathering::CellSets;
use crate::solver::job::Job;
use crate::solver::spending::Spending;
use crate::solver::{ConvergenceRow, StopReason};
use crate::transport::SelectionByCell;

/// Stores a run's state from time to time.
pub trait Keeper: Sync {
    /// Whether the state must be stored now. It is called after every slice of work.
    fn is_due(&self) -> bool;
    /// Stores the state. It is called once more when the work ends, with the reason.
    fn keep(&self, state: &RunState, progress: &Progress, ended: Option<StopReason>);
}

/// The state of a run, for writing.
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

/// The state of a run, as read.
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

/// A stored run, and the options for resuming it.
pub struct GoingOn {
    /// The stored state.
    pub kept: KeptRun,
    /// Seconds from the start of the process at which this part of the run ends. It replaces the limit of the whole run.
    pub time_limit_s: Option<f64>,
}

impl KeptRun {
    /// Seconds of computing before the state was stored.
    pub(super) fn compute_s(&self) -> f64 {
        self.wall_s - self.clock.begun_wall_s()
    }
}
