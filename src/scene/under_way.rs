//! Progress of reading, for display only: the result of reading never depends on it.

use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};

/// What is being read.
static WHAT: Mutex<String> = Mutex::new(String::new());
/// Amount read so far, and total amount.
static DONE: AtomicU64 = AtomicU64::new(0);
static ALL: AtomicU64 = AtomicU64::new(0);

/// Begins a step of reading: its name, and its number of bytes or entries (0 if unknown).
pub(crate) fn begin(what: impl Into<String>, all: usize) {
    if let Ok(mut name) = WHAT.lock() {
        *name = what.into();
    }
    DONE.store(0, Ordering::Relaxed);
    ALL.store(all as u64, Ordering::Relaxed);
}

/// Records that `done` bytes or entries of the current step are read.
#[inline]
pub(super) fn reached(done: usize) {
    DONE.store(done as u64, Ordering::Relaxed);
}

/// Returns the name of the current step and its progress in percent: `hall.obj, 20 %`.
pub(crate) fn reading_so_far() -> String {
    let what = WHAT.lock().map(|what| what.clone()).unwrap_or_default();
    let (done, all) = (DONE.load(Ordering::Relaxed), ALL.load(Ordering::Relaxed));
    let share = (100 * done.min(all)).checked_div(all);
    share.map_or(what.clone(), |share| format!("{what}, {share} %"))
}
