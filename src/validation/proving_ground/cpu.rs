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
    let text = std::fs::read_to_string(THREAD_TIME).ok()?;
    text.split_whitespace().next()?.parse::<f64>().ok().map(|time_ns| 1e-9 * time_ns)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Work of a tenth of a second with parallel loops is measured; sleep is not.
    #[test]
    fn work_counts_and_sleep_does_not() {
        use rayon::prelude::*;
        let busy = || {
            let started = Instant::now();
            let mut sum = 0u64;
            while started.elapsed().as_secs_f64() < 0.1 {
                sum = sum.wrapping_add((0..10_000u64).into_par_iter().map(|i| i ^ sum).sum());
            }
            assert_ne!(sum, 1);
        };
        let timed = |work: &(dyn Fn() + Sync)| {
            on_one_thread(|| {
                let clock = ThreadClock::starting_now();
                work();
                clock.cpu_s()
            })
        };
        let busy_s = timed(&busy);
        assert!(busy_s > 0.0 && busy_s < 0.2, "{busy_s}");
        if thread_s().is_some() {
            let asleep_s = timed(&|| std::thread::sleep(std::time::Duration::from_millis(100)));
            assert!(asleep_s < 0.05, "{asleep_s}");
        }
    }
}
