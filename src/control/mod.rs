//! Pure decisions: when a map is right enough, how much work that takes, and when to look again.

mod adapt;
mod exponent;
mod gather;
mod schedule;
mod stop;

pub use adapt::{ElementLoss, cuts_for};
pub use exponent::{ErrorHistory, USUAL_EXPONENT};
pub use gather::{GatherNeed, GatherState, gather_need};
pub use schedule::next_judgement;
pub use stop::{CONFIDENCE, accepts, margin, needed_work};
