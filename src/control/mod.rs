//! Pure decisions on a map: whether its error is small enough, whether that error is credible, how much work is needed, and when to judge
//! the error again.

mod adapt;
mod checks;
mod forecast;
mod gathering;
mod plan_bounds;
mod schedule;
mod stop;
mod verdict;

pub use adapt::{ElementLoss, cuts_for};
pub use checks::{effective_scores, spare_for_tail, statistical_checks};
pub use forecast::{FORECAST_SHARES, Forecast, ONE_IN_TWENTY, deviation_of_work, work_for_tail, work_to_pass};
pub use gathering::{GatheringGrowth, GatheringParts, KINDS};
pub use schedule::{GROWTH_AFTER_REFUSAL, after_refusal, next_judgement};
pub use stop::{CONFIDENCE, EXPONENT_OF_INDEPENDENT_SAMPLES, accepts, margin, needed_work};
pub use verdict::{Certainty, INTERVAL, Limit, Ruling, certainty, is_decided_at_look};
