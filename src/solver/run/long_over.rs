//! What is given up when a time limit has long passed.

use std::time::{Duration, Instant};

use super::Observer;
use crate::chain::Stage;
use crate::solver::Settings;

/// A map that shows nothing yet is worked on until so many times the limit and so many seconds more have passed.
pub const LONG_OVER: f64 = 1.1;
pub const PATIENCE_S: f64 = 0.5;

/// Whether a time limit has passed so long ago that what shows nothing yet is left out.
pub fn is_long_over(settings: &Settings, observer: &dyn Observer) -> bool {
    settings.time_limit_s.is_some_and(|limit_s| observer.wall_s() > LONG_OVER * limit_s + PATIENCE_S)
}

/// Lets long paths be given up once that is so: a single one may take longer than all that a limit leaves. A clock that stands ends nothing.
pub fn give_up_long_paths(stage: &Stage, settings: &Settings, wall_s: f64) {
    let Some(limit_s) = settings.time_limit_s.filter(|_| wall_s > 0.0) else {
        return;
    };
    let left_s = (LONG_OVER * limit_s + PATIENCE_S - wall_s).max(0.0);
    let left = Duration::try_from_secs_f64(left_s).ok();
    if let Some(time) = left.and_then(|left| Instant::now().checked_add(left)) {
        stage.patience.end_at(time);
    }
}
