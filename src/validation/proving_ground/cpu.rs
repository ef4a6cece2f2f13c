//! Seconds of a processor that a piece of work takes.

use std::time::Instant;

/// Where Linux tells how long the asking thread has run, in ns, as the first number.
const THREAD_TIME: &str = "/proc/thread-self/schedstat";

/// Counts the processor's seconds that a thread takes. Where the system does not tell them they are those of the clock.
pub struct ThreadClock {
    started: Instant,
    before_s: Option<f64>,
}

impl ThreadClock {
    /// Counts from now on.
    pub fn starting_now() -> ThreadClock {
        ThreadClock { started: Instant::now(), before_s: thread_s() }
    }

    /// Seconds since it was started; asked by the thread that started it.
    pub fn cpu_s(&self) -> f64 {
        match (self.before_s, thread_s()) {
            (Some(before_s), Some(now_s)) => now_s - before_s,
            _ => self.started.elapsed().as_secs_f64(),
        }
    }
}

/// Runs something on one thread alone, so that a [`ThreadClock`] started in it counts all of its work.
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

    /// Work of a tenth of a second, with parallel loops in it, is counted; sleeping is not.
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
