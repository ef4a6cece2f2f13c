//! Validation: cases that compare luxmc's results with exact values.
//!
//! A case is a folder with a `case.json`, described in `docs/validation.md`. [`find_cases`] finds cases at run time and
//! [`run_case`] runs one. `report_html`, `report_md` and [`case_csv`] report the results.

mod calibration;
mod case;
mod case_of_run;
mod comparison;
mod demand;
mod error;
mod exact;
mod exact_side;
mod fields;
mod find;
mod forecasts;
mod ladder;
mod ladder_report;
mod measure;
mod methods;
mod outcome;
mod plots;
pub mod proving_ground;
mod reference;
mod report;
mod report_html;
mod report_md;
mod rivals;
mod run_method;
mod statistics;
mod stored_run;
pub mod studies;
mod truth;
mod truth_enclosure;
mod truth_room;
mod truth_sobolev;
mod truth_spec;
mod verdict;
mod words;

pub use calibration::{
    Campaign, CampaignSettings, SeedRun, calibrate, calibration_csv, calibration_html, calibration_md,
    calibration_pictures, calibration_table,
};
pub use case::{Case, CaseRun};
pub use case_of_run::case_of_stored_run;
pub use comparison::{Comparison, Criterion, What};
pub use error::CaseError;
pub use exact::{Exact, LightPart};
pub use find::{FoundCases, find_cases};
pub use forecasts::{ForecastSums, JudgedForecast, judged_forecasts};
pub use ladder::{Ladder, Rung, climb};
pub use ladder_report::{ladder_csv, ladder_html, ladder_md};
pub use methods::{ComparedMethod, METHODS};
pub use outcome::{CaseOutcome, ComparisonOutcome, run_case, run_case_by};
pub use report::{Table, Validation};
pub use report_html::report_html;
pub use report_md::{case_csv, report_md};
pub use run_method::{RunMethod, method_names};
pub use statistics::{ComparedEntry, EntrySet, Statistics};
pub use truth_spec::TruthSpec;
pub use verdict::Check;
pub use words::date as utc_date;
