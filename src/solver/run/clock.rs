//! How fast a run's rays are: start-up, reading and building are no part of it, and pilots only as long as there is nothing else.

use serde::{Deserialize, Serialize};

use crate::control::Forecast;

/// Rays of the maps, over those of pilots, after which the rate is that of the maps alone.
const ENOUGH_RAYS: f64 = 0.25;
/// Standard deviation of the logarithm of the rate at which a run goes on, about that of pilots and about its own. Measured in
/// six kinds of rooms on a busy machine.
const DEVIATION_BY_PILOTS: f64 = 0.35;
const DEVIATION: f64 = 0.1;
/// A ray of a pilot takes so many times as long as one of a run, since pilots look for what is in sight and how to sample it (1.4 to 2.7
/// in five made-up rooms).
const PILOT_OVER_RUN: f64 = 2.0;
/// No ray takes less, in s: a clock that stands still tells nothing.
const LEAST_SECONDS: f64 = 1e-12;

/// When a run's parts began.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub(super) struct Clock {
    /// Wall time at which pilots were begun.
    begun_wall_s: f64,
    /// Rays and wall time at their end.
    piloted: Option<(u64, f64)>,
}

impl Clock {
    /// Pilots begin.
    pub fn begun(wall_s: f64) -> Clock {
        Clock { begun_wall_s: wall_s, piloted: None }
    }

    /// Wall time at which pilots were begun.
    pub fn begun_wall_s(&self) -> f64 {
        self.begun_wall_s
    }

    /// Pilots have ended.
    pub fn pilots_end(&mut self, rays: u64, wall_s: f64) {
        self.piloted = Some((rays, wall_s));
    }

    /// Whether pilots have ended.
    pub fn has_piloted(&self) -> bool {
        self.piloted.is_some()
    }

    /// Seconds that a ray of the run took, where enough of them were traced.
    fn seconds_of_own(&self, rays: u64, wall_s: f64) -> Option<f64> {
        let (pilot_rays, pilots_wall_s) = self.piloted?;
        let own = rays.saturating_sub(pilot_rays) as f64;
        let is_enough = own > 0.0 && own >= ENOUGH_RAYS * pilot_rays as f64;
        is_enough.then(|| (wall_s - pilots_wall_s) / own)
    }

    /// Seconds that a ray took, those of pilots too.
    fn seconds_of_any(&self, rays: u64, wall_s: f64) -> f64 {
        (wall_s - self.begun_wall_s) / rays.max(1) as f64
    }

    /// Rays over the seconds that they took: those of the run, or of the pilots as long as there are few others.
    pub fn rays_per_s(&self, rays: u64, wall_s: f64) -> f64 {
        let seconds = self.seconds_of_own(rays, wall_s).unwrap_or_else(|| self.seconds_of_any(rays, wall_s));
        1.0 / seconds.max(LEAST_SECONDS)
    }

    /// Seconds that rays which are left will take, of which so many were timed by their kinds, at the rate of the run so far and at theirs.
    pub fn seconds_of(&self, left: Forecast, (timed_rays, timed_s): (f64, f64), rays: u64, wall_s: f64) -> Forecast {
        let by_pilots = || (self.seconds_of_any(rays, wall_s) / PILOT_OVER_RUN, DEVIATION_BY_PILOTS);
        let of_own = self.seconds_of_own(rays, wall_s).map(|seconds| (seconds, DEVIATION));
        let (seconds, deviation_ln) = of_own.unwrap_or_else(by_pilots);
        if timed_rays <= 0.0 || left.expected <= 0.0 {
            return left.times(seconds, deviation_ln);
        }
        let share = (timed_rays / left.expected).min(1.0);
        left.times(share * timed_s / timed_rays + (1.0 - share) * seconds, deviation_ln)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A run of 1,000 pilot rays in 1 s and 3,000 of its own in 2 s is to trace 6,000 more: at its rate in 4 s; where half of them were
    /// timed and take 0.1 ms each, in 2.3 s; and where more were timed than are left, as these.
    #[test]
    fn rays_that_were_timed_take_what_they_took() {
        let mut clock = Clock::begun(5.0);
        clock.pilots_end(1000, 6.0);
        let left = Forecast { expected: 6000.0, low: 5000.0, high: 8000.0 };
        let seconds = |timed: (f64, f64)| clock.seconds_of(left, timed, 4000, 8.0);
        assert!((seconds((0.0, 0.0)).expected - 4.0).abs() < 1e-12);
        // After pilots alone: half of what their rays took.
        assert!((clock.seconds_of(left, (0.0, 0.0), 1000, 6.0).expected - 3.0).abs() < 1e-12);
        assert!((seconds((3000.0, 0.3)).expected - 2.3).abs() < 1e-12);
        assert!((seconds((9000.0, 0.9)).expected - 0.6).abs() < 1e-12);
        let known = seconds((3000.0, 0.3));
        assert!(known.low < 2.3 * 5.0 / 6.0 && known.high > 2.3 * 8.0 / 6.0, "the rate is not certain: {known:?}");
    }
}
