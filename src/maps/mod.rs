//! Replicas of a map in an even and an odd half, and their merging into maps with errors.

mod averages;
mod children;
mod daylight;
mod detail;
mod grid_slopes;
mod history;
mod judge;
mod rare_scores;
mod replicas;
mod residual_state;
mod residuals;
mod result;
mod scores;
mod stated;
mod tables;

pub use averages::{RemainingInAverage, remaining_by_average};
pub use children::ChildElement;
pub use daylight::{ComponentMeans, DaylightFactors, NO_SKY_PERCENT, SHARES_WANTED, certainty};
pub use detail::{Detail, DirectDetail, IndirectDetail, Variation};
pub use grid_slopes::{CellSlopes, grid_slopes};
pub use history::{History, PastJudgement};
pub use judge::{Judgement, judge};
pub use rare_scores::RareScores;
pub use replicas::{ReplicaMap, Tally, Unit, standard_error};
pub use residual_state::{RemainingError, ResidualState};
pub use residuals::{CellsError, Measured, MeasuredPart, Residuals, half_squares, within_halves};
pub use result::*;
pub use scores::{EntryScores, GroupScores, Levels, PartScores, ScoreEvidence, Scores};
pub use stated::{StatedValues, grid_places, stated_row, worst_case_error};
pub use tables::{Places, TableSubject, table_row};

/// Number of independent replicas of every map: eight even and eight odd.
pub const REPLICAS: usize = 16;
/// Number of replicas in one half.
pub const HALF: usize = REPLICAS / 2;

/// Relative errors up to this are rounding of sums, not chance.
pub const ROUNDING_OF_SUMS: f64 = 1e-12;

/// Numerator of the 95 % confidence bound: if none of N packets went somewhere, less than 3/N of the flux goes there.
pub const PACKETS_OF_A_BOUND: f64 = 3.0;
