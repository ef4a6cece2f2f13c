//! How far reading has come, for those who wait for it. Words alone: nothing that is read hangs on them.

use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};

/// What is being read.
static WHAT: Mutex<String> = Mutex::new(String::new());
/// How much of it has been, of how much in all.
static DONE: AtomicU64 = AtomicU64::new(0);
static ALL: AtomicU64 = AtomicU64::new(0);

/// A part of reading begins: what it is about, and how many bytes or entries that are; 0 where nobody knows.
pub(crate) fn begin(what: impl Into<String>, all: usize) {
    if let Ok(mut name) = WHAT.lock() {
        *name = what.into();
    }
    DONE.store(0, Ordering::Relaxed);
    ALL.store(all as u64, Ordering::Relaxed);
}

/// So many bytes or entries of that part are behind.
#[inline]
pub(super) fn reached(done: usize) {
    DONE.store(done as u64, Ordering::Relaxed);
}

/// What is being read, and how much of it has been in percent: `hall.obj, 20 %`.
pub(crate) fn reading_so_far() -> String {
    let what = WHAT.lock().map(|what| what.clone()).unwrap_or_default();
    let (done, all) = (DONE.load(Ordering::Relaxed), ALL.load(Ordering::Relaxed));
    let share = (100 * done.min(all)).checked_div(all);
    share.map_or(what.clone(), |share| format!("{what}, {share} %"))
}
