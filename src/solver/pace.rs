//! How much work a slice is: a fixed number of rays, or as few as fit between two readings of the clock if rays are slow. Also the time that a
//! run has left.

use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use serde::{Deserialize, Serialize};

use super::spending::Activity;

/// Approximate rays of a slice: a fraction of a second's work if rays take a microsecond.
pub const RAYS_PER_SLICE: f64 = 400_000.0;
/// Rays of a map's first slice of a kind in a run that a limit may end, and the fewest of any slice: some rays take 0.1 ms.
const FIRST_RAYS: f64 = 1_000.0;
const FEWEST_RAYS: f64 = 64.0;
/// Most rays of a slice in a run of a fixed number of chains. The clock does not control the size of slices there, but a limit may end the
/// run after each of them.
const MOST_RAYS_OF_CHAINS: f64 = 50_000.0;
/// A slice may take this share of a time limit, and never longer than this many seconds.
const SHARE_OF_LIMIT: f64 = 0.02;
const LONGEST_SLICE_S: f64 = 0.25;
/// Largest and smallest ratio of the rays of the next slice to those of the one before.
const MOST_RATIO: f64 = 4.0;
const LEAST_RATIO: f64 = 0.01;

/// The time that a run has left, for work that takes long between two slices. Results depend on it only if a limit or the user ends the
/// run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum TimeLeft {
    /// The time was over long ago: maps stop even if they could still gain.
    LongOver,
    /// No time: a limit has passed, or the user wants to stop.
    None,
    /// Too little for cutting elements before the run.
    Little,
    /// Enough.
    Enough,
}

/// Seconds that a slice may take under a time limit.
pub fn slice_s(limit_s: f64) -> f64 {
    (SHARE_OF_LIMIT * limit_s).min(LONGEST_SLICE_S)
}

/// The rays of a map's next slice of each kind of work, 0 if none was done yet. Rays of one kind may take a hundred times as long as those
/// of another. The same holds for rays of two neighbouring maps.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub struct SliceSizes([f64; Activity::ALL.len()]);

/// The rays of the present slice, and the rule for the next one.
/// Only a run that nothing but a time limit may end early uses the clock: its end depends on time anyway. With a fixed number of chains the
/// same slices make the same sums, bit by bit.
#[derive(Debug)]
pub struct Pace {
    /// Rays of a map's first slice of a kind, as bits.
    first: AtomicU64,
    /// Rays of the present slice, as bits.
    rays: AtomicU64,
    /// Seconds that a slice may take.
    slice_s: f64,
    /// Upper limit of the rays of a slice, if slices grow with every one done regardless of time.
    growing_to: Option<f64>,
}

impl Pace {
    /// Slices of one size.
    pub fn steady() -> Pace {
        Pace::of(RAYS_PER_SLICE, f64::INFINITY, None)
    }

    /// Slices that are small at first, each twice the one before up to a limit. They are the same on every machine.
    pub fn of_chains() -> Pace {
        Pace::of(FIRST_RAYS, f64::INFINITY, Some(MOST_RAYS_OF_CHAINS))
    }

    /// Slices that take a small part of a time limit.
    pub fn within(limit_s: f64) -> Pace {
        Pace::of(FIRST_RAYS, slice_s(limit_s), None)
    }

    fn of(rays: f64, slice_s: f64, growing_to: Option<f64>) -> Pace {
        Pace { first: AtomicU64::new(rays.to_bits()), rays: AtomicU64::new(rays.to_bits()), slice_s, growing_to }
    }

    /// Sets the first slices from the time that rays of pilots took.
    pub fn begin(&self, rays: u64, took: Duration) {
        if self.slice_s.is_finite() && rays > 0 {
            let fitting = rays as f64 * self.slice_s / took.as_secs_f64().max(f64::MIN_POSITIVE);
            self.first.store(fitting.clamp(FEWEST_RAYS, FIRST_RAYS).to_bits(), Ordering::Relaxed);
        }
    }

    /// Rays of a map's next slice of a kind of work, approximately.
    pub fn rays_of_next(&self, sizes: &SliceSizes, activity: Activity) -> f64 {
        let rays = sizes.0[activity as usize];
        if rays > 0.0 { rays } else { f64::from_bits(self.first.load(Ordering::Relaxed)) }
    }

    /// Sets the rays of the present slice: it is of this kind of work on a map.
    pub fn turn_to(&self, sizes: &SliceSizes, activity: Activity) {
        self.rays.store(self.rays_of_next(sizes, activity).to_bits(), Ordering::Relaxed);
    }

    /// Rays of the present slice, approximately.
    pub fn rays_per_slice(&self) -> f64 {
        f64::from_bits(self.rays.load(Ordering::Relaxed))
    }

    /// Sets the size of the next slice of this kind from the time that the present one took.
    pub fn note(&self, sizes: &mut SliceSizes, activity: Activity, took: Duration) {
        let rays = self.rays_of_next(sizes, activity);
        let next = match self.growing_to {
            Some(most) => (2.0 * rays).min(most),
            None if self.slice_s.is_finite() => {
                let growth = self.slice_s / took.as_secs_f64().max(f64::MIN_POSITIVE);
                growth.clamp(LEAST_RATIO, MOST_RATIO) * rays
            }
            None => rays,
        };
        sizes.0[activity as usize] = next.clamp(FEWEST_RAYS, RAYS_PER_SLICE);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rays of `slices` slices of one kind in a row, whose rays take `ray_s` seconds each.
    fn rays_of_slices(pace: &Pace, sizes: &mut SliceSizes, activity: Activity, ray_s: f64, slices: usize) -> Vec<f64> {
        let slice = |_| {
            pace.turn_to(sizes, activity);
            let rays = pace.rays_per_slice();
            pace.note(sizes, activity, Duration::from_secs_f64(ray_s * rays));
            rays
        };
        (0..slices).map(slice).collect()
    }

    #[test]
    fn slices_shrink_where_rays_are_slow_and_grow_again_where_they_are_quick() {
        let (pace, mut sizes) = (Pace::within(1.0), SliceSizes::default());
        // Rays take a millisecond, as pilots have measured. No slice takes longer than a fiftieth of the limit, or it has the fewest rays.
        pace.begin(2000, Duration::from_secs(2));
        let rays = rays_of_slices(&pace, &mut sizes, Activity::Walks, 1e-3, 6);
        assert!(rays.iter().all(|rays| *rays <= FEWEST_RAYS), "{rays:?}");
        let rays = rays_of_slices(&pace, &mut sizes, Activity::Walks, 1e-8, 12);
        assert_eq!(rays.last(), Some(&RAYS_PER_SLICE));
        // With a fixed number of chains slices grow equally, however long they take.
        let of_chains = |ray_s: f64| {
            let (pace, mut sizes) = (Pace::of_chains(), SliceSizes::default());
            pace.begin(2000, Duration::from_secs_f64(2000.0 * ray_s));
            rays_of_slices(&pace, &mut sizes, Activity::Chains, ray_s, 8)
        };
        let slow = of_chains(1e-3);
        assert_eq!(slow, of_chains(1e-9));
        assert_eq!([slow[0], slow[1], slow[7]], [FIRST_RAYS, 2.0 * FIRST_RAYS, MOST_RAYS_OF_CHAINS]);
        // Without a limit the clock does not control slices.
        let steady = rays_of_slices(&Pace::steady(), &mut SliceSizes::default(), Activity::Walks, 1.0, 3);
        assert_eq!(steady, [RAYS_PER_SLICE; 3]);
    }

    /// Slices that grow while rays are quick leave the slices of other kinds and of other maps small. If rays of these take a hundred times
    /// as long, their slices would otherwise take a hundred times as long.
    #[test]
    fn slices_of_one_kind_and_of_one_map_grow_by_themselves() {
        for pace in [Pace::within(1.0), Pace::of_chains()] {
            let mut sizes = SliceSizes::default();
            assert!(rays_of_slices(&pace, &mut sizes, Activity::Chains, 1e-8, 8)[7] >= MOST_RAYS_OF_CHAINS);
            assert_eq!(pace.rays_of_next(&sizes, Activity::Direct), FIRST_RAYS);
            assert_eq!(pace.rays_of_next(&SliceSizes::default(), Activity::Chains), FIRST_RAYS);
        }
    }
}
