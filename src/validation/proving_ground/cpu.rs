//! Processor seconds of a piece of work.

use std::time::Instant;

/// Linux file whose first number is the run time of the calling thread in ns.
const THREAD_TIME: &str = "/proc/thread-self/schedstat";

/// Measures the processor seconds of a thread. If the system does not provide them, it measures elapsed time.
pub struct ThreadClock {
    started: Instant,
    before_s: Option<f64>,
}

impl ThreadClock {
    /// Starts measuring now.
    pub fn starting_now() -> ThreadClock {
        ThreadClock { started: Instant::now(), before_s: thread_s() }
    }

    /// Seconds since the start. The thread that started the clock must call it.
    pub fn cpu_s(&self) -> f64 {
        match (self.before_s, thread_s()) {
            (Some(before_s), Some(now_s)) => now_s - before_s,
            _ => self.started.elapsed().as_secs_f64(),
        }
    }
}

/// Runs work on one thread, so that a [`ThreadClock`] started in it measures all of the work.
pub fn on_one_thread<T: Send>(work: impl FnOnce() -> T + Send) -> T {
    match rayon::ThreadPoolBuilder::new().num_threads(1).build() {
        Ok(pool) => pool.install(work),
        Err(_) => work(),
    }
}

fn thread_s() -> Option<f64> {
    run_time_s(&std::fs::read_to_string(THREAD_TIME).ok()?)
}

/// Run time of a thread in the text of [`THREAD_TIME`].
fn run_time_s(text: &str) -> Option<f64> {
    text.split_whitespace().next()?.parse::<f64>().ok().map(|time_ns| 1e-9 * time_ns)
}

#[cfg(test)]
mod tests {
    use std::collections::HashSet;
    use std::thread::{ThreadId, current};

    use rayon::prelude::*;

    use super::*;

    /// A clock of the thread then measures all of the work.
    #[test]
    fn parallel_loops_stay_on_the_thread_of_the_work() {
        let threads = on_one_thread(|| {
            let loops: HashSet<ThreadId> = (0..10_000).into_par_iter().map(|_| current().id()).collect();
            (loops, HashSet::from([current().id()]))
        });
        assert_eq!(threads.0, threads.1);
        assert!(!threads.0.contains(&current().id()), "the work has a thread of its own");
    }

    #[test]
    fn the_run_time_is_the_first_number_in_ns() {
        let told_s = run_time_s("2500000000 700 31\n").expect("a number");
        assert!((told_s - 2.5).abs() < 1e-12, "{told_s}");
        assert_eq!([run_time_s(""), run_time_s("none 700 31")], [None, None]);
    }
}
