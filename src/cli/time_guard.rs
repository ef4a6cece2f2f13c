//! Enforces a time limit before computing begins. A process that still reads its scene, or makes it ready for rays, at 1.1 times
//! its limit plus one second has no result. It then ends with a message, by a thread that waits for nothing else.

use std::path::PathBuf;
use std::process::exit;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};
use std::time::{Duration, Instant};

use super::beforehand::Beforehand;
use super::console;
use super::exit::Failure;
use super::number_text::time;
use super::patience::latest_s;
use crate::base::memory::used_bytes;
use crate::scene::under_way::reading_so_far;

/// Time between two checks of the memory that must be given back.
const LOOK: Duration = Duration::from_millis(50);
/// Seconds that the end of a process takes, and seconds that the system takes for every byte that it gets back. It took 0.2 s for 2
/// GB, and half as much again on a busy machine.
const ENDING_S: f64 = 0.02;
const GIVING_BACK_S_A_BYTE: f64 = 0.15e-9;
/// A limit leaves time to compute if it is at least this multiple of the time that the scene takes whatever is computed.
const LIMIT_OVER_ALL: f64 = 2.0;

/// Ends the process with a message, unless it is released in time.
pub struct TimeGuard(Arc<Watched>);

#[derive(Default)]
struct Watched {
    /// Whether the run was released from the guard.
    is_let_go: AtomicBool,
    beforehand: OnceLock<Beforehand>,
    read_s: OnceLock<f64>,
    /// The results directory, if it was made for this run. Whoever makes it, or ends the process, holds this lock.
    made: Mutex<Option<PathBuf>>,
}

impl TimeGuard {
    /// Guards a process that started at `started`. Without a limit it guards nothing.
    pub fn of(limit_s: Option<f64>, started: Instant) -> TimeGuard {
        let watched = Arc::new(Watched::default());
        let end = limit_s.and_then(|limit_s| Some((limit_s, Duration::try_from_secs_f64(latest_s(limit_s)).ok()?)));
        if let Some((limit_s, most)) = end {
            let watched = Arc::clone(&watched);
            std::thread::spawn(move || {
                while let Some(left) = most.checked_sub(started.elapsed() + giving_back(used_bytes())) {
                    std::thread::sleep(left.min(LOOK));
                }
                watched.end(limit_s, started);
            });
        }
        TimeGuard(watched)
    }

    /// Takes the estimate of the scene's time from the sizes of its files.
    pub fn expect(&self, beforehand: Beforehand) {
        self.0.beforehand.set(beforehand).ok();
    }

    /// Records that the scene was read after `read_s` seconds.
    pub fn has_read(&self, read_s: f64) {
        self.0.read_s.set(read_s).ok();
    }

    /// Runs `make`, which writes to the disk, so that the guard cannot end the process meanwhile. If the process is ended later, a
    /// new `directory` for the results is removed.
    pub fn undisturbed<T>(&self, directory: Option<PathBuf>, make: impl FnOnce() -> T) -> T {
        let mut made = self.0.made.lock().unwrap_or_else(PoisonError::into_inner);
        let done = make();
        *made = directory;
        done
    }

    /// Releases the run: the work that follows checks the clock itself.
    pub fn let_go(&self) {
        self.0.is_let_go.store(true, Ordering::SeqCst);
    }
}

/// Time from the decision to end until the process is gone.
fn giving_back(bytes: u64) -> Duration {
    Duration::from_secs_f64(ENDING_S + GIVING_BACK_S_A_BYTE * bytes as f64)
}

impl Drop for TimeGuard {
    fn drop(&mut self) {
        self.let_go();
    }
}

impl Watched {
    /// Ends the process, unless it was released.
    fn end(&self, limit_s: f64, started: Instant) {
        let made = self.made.lock().unwrap_or_else(PoisonError::into_inner);
        if self.is_let_go.load(Ordering::SeqCst) {
            return;
        }
        let failure = self.failure(limit_s, started.elapsed().as_secs_f64());
        console::message(&format!("luxmc: error: {failure}"));
        if let Some(directory) = &*made {
            std::fs::remove_dir(directory).ok();
        }
        exit(i32::from(failure.exit().number()))
    }

    /// The message: what has been done in the seconds so far, and how long all of it would take.
    fn failure(&self, limit_s: f64, now_s: f64) -> Failure {
        let (until, done) = match self.read_s.get() {
            None => ("its scene was read", format!("reading had reached {} after {}", reading_so_far(), time(now_s))),
            Some(read_s) => (
                "its scene was ready for rays",
                format!("reading took {}, and preparing was not finished after {}", time(*read_s), time(now_s)),
            ),
        };
        let by_sizes = self.beforehand.get().map_or([0.0; 2], Beforehand::seconds);
        let all_s = by_sizes.iter().sum::<f64>().max(now_s);
        Failure::Usage {
            what: format!("the time limit ends the run before {until}"),
            got: format!("a limit of {}; {done}", time(limit_s)),
            expected: format!(
                "some {} or more: by the sizes of its files, reading takes about {} on a typical core, preparing \
                 and writing {}",
                time(LIMIT_OVER_ALL * all_s),
                time(by_sizes[0]),
                time(by_sizes[1])
            ),
            remedy: "raise --time-limit, or make the scene smaller; nothing was written".to_owned(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_done_and_how_long_all_takes_is_reported() {
        let watched = Watched::default();
        let reading = watched.failure(1.0, 2.1).to_string();
        assert!(reading.contains("before its scene was read") && reading.contains("after 2.1 s"), "{reading}");
        assert!(reading.contains("some 4.2 s or more") && reading.contains("--time-limit"), "{reading}");
        watched.read_s.set(0.9).expect("unset");
        let readying = watched.failure(1.0, 2.1).to_string();
        assert!(readying.contains("ready for rays") && readying.contains("reading took 0.90 s"), "{readying}");
        assert_eq!(watched.failure(1.0, 2.1).exit().number(), 2);
    }

    /// A process with 2 GB to give back ends a third of a second before the limit.
    #[test]
    fn giving_memory_back_is_reckoned_with() {
        assert!((giving_back(2_000_000_000).as_secs_f64() - 0.32).abs() < 1e-9);
        assert_eq!(giving_back(0), Duration::from_millis(20));
    }

    #[test]
    fn a_limit_that_no_clock_counts_to_guards_nothing() {
        TimeGuard::of(Some(f64::MAX), Instant::now());
        let guard = TimeGuard::of(None, Instant::now());
        guard.let_go();
        assert!(guard.0.is_let_go.load(Ordering::SeqCst));
    }

    #[test]
    fn what_is_made_is_known_once_it_is_made() {
        let guard = TimeGuard::of(None, Instant::now());
        let is_held = guard.undisturbed(Some(PathBuf::from("out")), || guard.0.made.try_lock().is_err());
        assert!(is_held, "the process can end while it is made");
        assert_eq!(*guard.0.made.lock().expect("free"), Some(PathBuf::from("out")));
    }
}
