//! What is given up when a time limit passed long ago.

use std::time::{Duration, Instant};

use super::observer::Observer;
use crate::solver::Settings;
use crate::transport::World;

/// A map that shows nothing yet is worked on until this factor times the limit, plus this many seconds, have passed.
pub const LONG_OVER: f64 = 1.1;
pub const PATIENCE_S: f64 = 0.5;

/// Whether a time limit passed so long ago that maps that show nothing yet are left out.
pub fn is_long_over(settings: &Settings, observer: &dyn Observer) -> bool {
    settings.time_limit_s.is_some_and(|limit_s| observer.wall_s() > LONG_OVER * limit_s + PATIENCE_S)
}

/// Sets the time after which long paths are given up: a single path may take longer than all the time that a limit leaves. A clock that
/// stands still ends nothing.
pub fn give_up_long_paths(world: &World, settings: &Settings, wall_s: f64) {
    let Some(limit_s) = settings.time_limit_s.filter(|_| wall_s > 0.0) else {
        return;
    };
    let left = Duration::try_from_secs_f64(patience_s(Some(limit_s), wall_s)).ok();
    if let Some(time) = left.and_then(|left| Instant::now().checked_add(left)) {
        world.patience.end_at(time);
    }
}

/// Seconds that are left of a time limit and the patience beyond it; infinite without a limit.
pub fn patience_s(limit_s: Option<f64>, wall_s: f64) -> f64 {
    limit_s.map_or(f64::INFINITY, |limit_s| (LONG_OVER * limit_s + PATIENCE_S - wall_s).max(0.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// With a limit of 3 s, 1 s is left after 2.8 s. So a slice of 0.8 s starts and one of 1.6 s does not. From 3.8 s on nothing is left.
    #[test]
    fn work_that_would_end_long_after_the_limit_has_no_room() {
        let room = |wall_s: f64| (1e6 * patience_s(Some(3.0), wall_s)).round() / 1e6;
        assert_eq!([room(2.8), room(3.7), room(4.0)], [1.0, 0.1, 0.0]);
        assert_eq!(patience_s(None, 1e6), f64::INFINITY);
    }
}
