//! How fast a run's rays are. Start-up, reading and building are not included. Pilots are included only while there are no other rays.

use serde::{Deserialize, Serialize};

use crate::control::Forecast;

/// Ratio of the rays of the maps to those of pilots from which on the rate is that of the maps alone.
const ENOUGH_RAYS: f64 = 0.25;
/// Standard deviation of the logarithm of the rate to come. The first value applies to an estimate from pilots, the second to one from the
/// run's own rate. Measured in six kinds of rooms on a busy machine.
const DEVIATION_BY_PILOTS: f64 = 0.35;
const DEVIATION: f64 = 0.1;
/// Ratio of the time of a pilot's ray to that of a ray of the run. Pilots search for what is visible and how to sample it (1.4 to 2.7 in
/// five made-up rooms).
const PILOT_OVER_RUN: f64 = 2.0;
/// Lower limit for the seconds per ray, in s, since a clock that stands still gives no rate.
const LEAST_SECONDS: f64 = 1e-12;

/// When the parts of a run began.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub(super) struct Clock {
    /// Wall time at which pilots began.
    begun_wall_s: f64,
    /// Rays and wall time at the end of the pilots.
    piloted: Option<(u64, f64)>,
}

impl Clock {
    /// Starts the clock when pilots begin.
    pub fn begun(wall_s: f64) -> Clock {
        Clock { begun_wall_s: wall_s, piloted: None }
    }

    /// Wall time at which pilots began.
    pub fn begun_wall_s(&self) -> f64 {
        self.begun_wall_s
    }

    /// Records that pilots have ended.
    pub fn pilots_end(&mut self, rays: u64, wall_s: f64) {
        self.piloted = Some((rays, wall_s));
    }

    /// Whether pilots have ended.
    pub fn has_piloted(&self) -> bool {
        self.piloted.is_some()
    }

    /// Seconds per ray of the run without pilots, if enough of these rays were traced.
    fn seconds_of_own(&self, rays: u64, wall_s: f64) -> Option<f64> {
        let (pilot_rays, pilots_wall_s) = self.piloted?;
        let own = rays.saturating_sub(pilot_rays) as f64;
        let is_enough = own > 0.0 && own >= ENOUGH_RAYS * pilot_rays as f64;
        is_enough.then(|| (wall_s - pilots_wall_s) / own)
    }

    /// Seconds per ray, including those of pilots.
    fn seconds_of_any(&self, rays: u64, wall_s: f64) -> f64 {
        (wall_s - self.begun_wall_s) / rays.max(1) as f64
    }

    /// Rays per second: those of the run, or of the pilots while there are few others.
    pub fn rays_per_s(&self, rays: u64, wall_s: f64) -> f64 {
        let seconds = self.seconds_of_own(rays, wall_s).unwrap_or_else(|| self.seconds_of_any(rays, wall_s));
        1.0 / seconds.max(LEAST_SECONDS)
    }

    /// Seconds that the remaining rays will take. `timed_rays` of them take `timed_s` by the measured speed of their kinds; the others go
    /// at the rate of the run so far.
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

    /// A run of 1,000 pilot rays in 1 s and 3,000 of its own in 2 s has 6,000 more rays to trace. At its own rate they take 4 s. If half of
    /// them were timed at 0.1 ms each, they take 2.3 s. If more were timed than are left, all take the timed seconds per ray.
    #[test]
    fn rays_that_were_timed_take_what_they_took() {
        let mut clock = Clock::begun(5.0);
        clock.pilots_end(1000, 6.0);
        let left = Forecast { expected: 6000.0, low: 5000.0, high: 8000.0 };
        let seconds = |timed: (f64, f64)| clock.seconds_of(left, timed, 4000, 8.0);
        assert!((seconds((0.0, 0.0)).expected - 4.0).abs() < 1e-12);
        // After pilots alone: half of the time that their rays took.
        assert!((clock.seconds_of(left, (0.0, 0.0), 1000, 6.0).expected - 3.0).abs() < 1e-12);
        assert!((seconds((3000.0, 0.3)).expected - 2.3).abs() < 1e-12);
        assert!((seconds((9000.0, 0.9)).expected - 0.6).abs() < 1e-12);
        let known = seconds((3000.0, 0.3));
        assert!(known.low < 2.3 * 5.0 / 6.0 && known.high > 2.3 * 8.0 / 6.0, "the rate is not certain: {known:?}");
    }
}
