//! How much work a slice is: a fixed number of rays, or as few as fit between two looks at the clock where rays are slow; and what
//! time a run has left.

use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};
use std::time::Duration;

use super::spending::Activity;

/// Rays of a slice, about: a fraction of a second's work where rays take a microsecond.
pub const RAYS_PER_SLICE: f64 = 400_000.0;
/// Rays of the first slice of a run that a time limit may end, and the fewest of any.
const FIRST_RAYS: f64 = 20_000.0;
const FEWEST_RAYS: f64 = 64.0;
/// Rays of the first slice of a run of a fixed number of chains, and the most of any: the clock has no say in how large they are,
/// but a limit may end the run after each of them, and there are rays of 25 µs.
const FIRST_RAYS_OF_CHAINS: f64 = 4_000.0;
const MOST_RAYS_OF_CHAINS: f64 = 50_000.0;
/// A slice may take this share of a time limit, and never longer than so many seconds.
const SHARE_OF_LIMIT: f64 = 0.02;
const LONGEST_SLICE_S: f64 = 0.25;
/// The next slice has at most so many times the rays of the one before, or so small a part of them.
const MOST_GROWTH: f64 = 4.0;
const LEAST_GROWTH: f64 = 0.01;

/// What time a run has left, for work that takes long between two slices. Results hang on it only where a limit or the user ends
/// the run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum TimeLeft {
    /// None for long: what a map could still gain is given up.
    LongOver,
    /// None: a limit has passed, or the user wants to stop.
    None,
    /// Too little for cutting elements before the run.
    Little,
    /// Enough.
    Enough,
}

/// Kinds of work.
const KINDS: usize = Activity::ALL.len();

/// The rays of the next slice, of every kind of work by itself where the clock has a say: rays of one kind may take a hundred times as long
/// as those of another.
///
/// Only a run that nothing but a time limit may end early goes by the clock: where it ends is a matter of time there anyway.
/// With a fixed number of chains the same slices make the same sums, bit by bit.
#[derive(Debug)]
pub struct Pace {
    /// Rays of the next slice of each kind of work, as bits.
    rays: [AtomicU64; KINDS],
    /// The kind of the slice at hand.
    kind: AtomicUsize,
    /// Seconds that a slice may take.
    slice_s: f64,
    /// Most rays of a slice that grows with every one done, whatever it took.
    growing_to: Option<f64>,
}

impl Pace {
    /// Slices of one size.
    pub fn steady() -> Pace {
        Pace::of(RAYS_PER_SLICE, f64::INFINITY, None)
    }

    /// Slices that are small at first, each twice the one before up to a size: the same ones on every machine.
    pub fn of_chains() -> Pace {
        Pace::of(FIRST_RAYS_OF_CHAINS, f64::INFINITY, Some(MOST_RAYS_OF_CHAINS))
    }

    /// Slices that take a small part of a time limit.
    pub fn within(limit_s: f64) -> Pace {
        Pace::of(FIRST_RAYS, (SHARE_OF_LIMIT * limit_s).min(LONGEST_SLICE_S), None)
    }

    fn of(rays: f64, slice_s: f64, growing_to: Option<f64>) -> Pace {
        let rays = std::array::from_fn(|_| AtomicU64::new(rays.to_bits()));
        Pace { rays, kind: AtomicUsize::new(0), slice_s, growing_to }
    }

    /// The next slice is of such work.
    pub fn turn_to(&self, activity: Activity) {
        if self.slice_s.is_finite() {
            self.kind.store(activity as usize, Ordering::Relaxed);
        }
    }

    fn of_this_kind(&self) -> &AtomicU64 {
        &self.rays[self.kind.load(Ordering::Relaxed)]
    }

    /// Rays of the next slice, about.
    pub fn rays_per_slice(&self) -> f64 {
        f64::from_bits(self.of_this_kind().load(Ordering::Relaxed))
    }

    /// Goes on with slices of so many rays.
    pub fn go_on(&self, rays: f64) {
        self.rays.iter().for_each(|of_kind| of_kind.store(rays.to_bits(), Ordering::Relaxed));
    }

    /// Learns from pilots how long rays take.
    pub fn begin(&self, rays: u64, took: Duration) {
        if self.slice_s.is_finite() && rays > 0 {
            let fitting = rays as f64 * self.slice_s / took.as_secs_f64().max(f64::MIN_POSITIVE);
            self.go_on(fitting.clamp(FEWEST_RAYS, FIRST_RAYS));
        }
    }

    fn set(&self, rays: f64) {
        self.of_this_kind().store(rays.clamp(FEWEST_RAYS, RAYS_PER_SLICE).to_bits(), Ordering::Relaxed);
    }

    /// Learns from how long a slice took.
    pub fn note(&self, took: Duration) {
        if let Some(most) = self.growing_to {
            self.set((2.0 * self.rays_per_slice()).min(most));
        }
        if self.slice_s.is_finite() {
            let growth = (self.slice_s / took.as_secs_f64().max(f64::MIN_POSITIVE)).clamp(LEAST_GROWTH, MOST_GROWTH);
            self.set(growth * self.rays_per_slice());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slices_shrink_where_rays_are_slow_and_grow_again_where_they_are_quick() {
        let pace = Pace::within(1.0);
        // Rays of a millisecond, of which pilots know: no slice takes longer than a fiftieth of the limit, or has the fewest.
        pace.begin(2000, Duration::from_secs(2));
        let mut rays = Vec::new();
        for _ in 0..6 {
            rays.push(pace.rays_per_slice());
            pace.note(Duration::from_secs_f64(1e-3 * pace.rays_per_slice()));
        }
        assert!(rays.iter().all(|rays| *rays <= FEWEST_RAYS), "{rays:?}");
        for _ in 0..12 {
            pace.note(Duration::from_secs_f64(1e-8 * pace.rays_per_slice()));
        }
        assert_eq!(pace.rays_per_slice(), RAYS_PER_SLICE);
        // With a fixed number of chains slices grow alike, however long they take.
        let sizes = |took: Duration| -> Vec<f64> {
            let pace = Pace::of_chains();
            pace.begin(2000, took);
            let size = |_| {
                pace.note(took);
                pace.rays_per_slice()
            };
            (0..6).map(size).collect()
        };
        let slow = sizes(Duration::from_secs(2));
        assert_eq!(slow, sizes(Duration::from_micros(2)));
        assert_eq!([slow[0], slow[5]], [2.0 * FIRST_RAYS_OF_CHAINS, MOST_RAYS_OF_CHAINS]);
        // Without a limit the clock has no say.
        let steady = Pace::steady();
        steady.note(Duration::from_secs(100));
        assert_eq!(steady.rays_per_slice(), RAYS_PER_SLICE);
    }

    /// Slices that grow while rays are quick leave those of other rays as small as they were: a slice of direct light in a place where its
    /// rays take fifty times as long would else take fifty times as long.
    #[test]
    fn slices_of_one_kind_grow_by_themselves() {
        let pace = Pace::within(1.0);
        pace.begin(2000, Duration::from_millis(20));
        pace.turn_to(Activity::Chains);
        for _ in 0..6 {
            pace.note(Duration::from_secs_f64(1e-8 * pace.rays_per_slice()));
        }
        assert_eq!(pace.rays_per_slice(), RAYS_PER_SLICE);
        pace.turn_to(Activity::Direct);
        assert_eq!(pace.rays_per_slice(), 2000.0);
        // Where the clock has no say, all slices are of one size, whatever they are of.
        let chains = Pace::of_chains();
        chains.turn_to(Activity::Chains);
        chains.note(Duration::ZERO);
        chains.turn_to(Activity::Direct);
        assert_eq!(chains.rays_per_slice(), 2.0 * FIRST_RAYS_OF_CHAINS);
    }
}
