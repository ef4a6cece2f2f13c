//! Pure decisions: when a map is right enough, how much work that takes, and when to look again.

mod adapt;
mod gather;
mod schedule;
mod stop;

pub use adapt::{ElementLoss, cuts_for};
pub use gather::{GatherNeed, GatherState, gather_need};
pub use schedule::next_judgement;
pub use stop::{CONFIDENCE, accepts, margin, needed_work};
