//! Decides when a path is given up: soon after the time of a run is long over. Only in nearly white spaces are paths so long that a run
//! waits for one of them.

use std::sync::OnceLock;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;

/// Surfaces that a path meets between two checks of the clock. A path that meets fewer is never given up.
pub const SURFACES_BETWEEN_CLOCKS: u64 = 256;

/// How long paths may continue. Without an end time they continue until they end by themselves, or have met very many surfaces.
#[derive(Debug, Default)]
pub struct Patience {
    ends_at: OnceLock<Instant>,
    walks_given_up: AtomicU64,
}

impl Patience {
    /// Sets the time after which paths that are still long under way are given up. Only the first call has an effect.
    pub fn end_at(&self, time: Instant) {
        self.ends_at.get_or_init(|| time);
    }

    /// Whether a path that has met `surfaces` surfaces is given up.
    #[inline]
    pub fn is_over(&self, surfaces: u64) -> bool {
        surfaces > 0 && surfaces.is_multiple_of(SURFACES_BETWEEN_CLOCKS) && self.has_ended()
    }

    #[cold]
    fn has_ended(&self) -> bool {
        self.ends_at.get().is_some_and(|time| Instant::now() >= *time)
    }

    /// Records that a walk was given up. Its score lacks what it would have found.
    #[cold]
    pub fn note_walk_given_up(&self) {
        self.walks_given_up.fetch_add(1, Ordering::Relaxed);
    }

    /// Number of walks given up, by this clock or because they had met very many surfaces.
    pub fn walks_given_up(&self) -> u64 {
        self.walks_given_up.load(Ordering::Relaxed)
    }
}
