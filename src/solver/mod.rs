//! The run. Every map is a job. Its 16 replicas go forward in slices over threads and are merged in order, until the stop rule or a limit
//! ends the run.

mod adapt;
mod allotment;
mod choice;
mod coarse;
mod contact;
mod context;
mod empty_maps;
mod ends;
mod finer;
mod finish;
mod gathering;
mod glare;
mod glare_rating;
mod guide;
mod job;
mod local;
mod merge;
mod order;
mod pace;
mod passes;
mod pilot;
mod portion;
mod regions;
mod run;
mod share;
mod side_losses;
mod sky_components;
mod solution;
mod sparse;
mod spending;
mod starts;
mod streams;
mod surface_tables;
mod until_decided;
mod verdicts;

pub use glare_rating::{GlareRating, worst_of_sets};
pub use job::Hindrance;
pub use merge::{Merged, MoreShares, merge};
pub use portion::{MapOfShare, MapSums, Portion, Share};
pub use run::{
    Expectation, GoingOn, Keeper, KeptRun, Observer, Progress, RunState, Silent, SlowestMap, expectations,
    is_long_over, map_requests, resume, solve,
};
pub use share::{ShareRecord, resume_share, solve_share};
pub use solution::*;
pub use spending::{Activity, Spending};
pub use until_decided::{VerdictLadder, solve_to_verdicts};
pub use verdicts::{Finding, Verdict, verdicts};
