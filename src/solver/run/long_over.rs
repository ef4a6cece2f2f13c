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

/// Rays that end within a time limit and the patience beyond it, so many a second; without a limit all do.
pub fn rays_in_patience(limit_s: Option<f64>, wall_s: f64, rays_per_s: f64) -> f64 {
    limit_s.map_or(f64::INFINITY, |limit_s| (LONG_OVER * limit_s + PATIENCE_S - wall_s).max(0.0) * rays_per_s)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of rays that take a tenth of a millisecond 10,000 end a second after 2.8 s of 3, so that a slice of 8,000 is begun and one of 16,000
    /// is not; after 3.8 s none is.
    #[test]
    fn rays_that_would_end_long_after_the_limit_have_no_room() {
        let room = |wall_s: f64| rays_in_patience(Some(3.0), wall_s, 1e4).round();
        assert_eq!([room(2.8), room(3.7), room(4.0)], [10_000.0, 1000.0, 0.0]);
        assert_eq!(rays_in_patience(None, 1e6, 1e4), f64::INFINITY);
    }
}
