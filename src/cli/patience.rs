//! Says that work goes on which tells nothing of itself: reading a large scene, and making it ready for rays.

use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::{Duration, Instant};

use super::console;
use super::number_text::time;

/// Time between two lines.
const INTERVAL: Duration = Duration::from_secs(5);
/// What reading and making ready may take over a time limit, as a factor and in s.
const OVER: f64 = 1.1;
const BEYOND_S: f64 = 1.0;

/// Seconds from the start after which a process ends that is not ready, where its time is limited.
pub fn latest_s(limit_s: f64) -> f64 {
    OVER * limit_s + BEYOND_S
}

/// Does work, and says every few seconds what it is, with the seconds since the process started; nothing where it is to be quiet, or
/// as soon as the work tells of itself.
pub fn meanwhile<T>(
    what: impl Fn() -> String + Send,
    started: Instant,
    quiet: bool,
    tells_of_itself: impl Fn() -> bool + Send,
    work: impl FnOnce() -> T,
) -> T {
    if quiet {
        return work();
    }
    let tell = move || {
        if !tells_of_itself() {
            console::message(&format!("{:>8}: {}", time(started.elapsed().as_secs_f64()), what()));
        }
    };
    telling_every(INTERVAL, tell, work)
}

fn telling_every<T>(interval: Duration, tell: impl Fn() + Send, work: impl FnOnce() -> T) -> T {
    let (working, end) = channel::<()>();
    std::thread::scope(|scope| {
        scope.spawn(move || {
            // The channel closes with the work, whether it came to an end or not.
            while end.recv_timeout(interval) == Err(RecvTimeoutError::Timeout) {
                tell();
            }
        });
        let outcome = work();
        drop(working);
        outcome
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Work that ends only once it was told of does end, and nothing is told after it.
    #[test]
    fn long_work_is_told_of_until_it_ends() {
        let (told, heard) = channel();
        let tell = move || {
            told.send(()).ok();
        };
        let heard = telling_every(Duration::from_millis(1), tell, || {
            let twice = heard.recv().is_ok() && heard.recv().is_ok();
            (twice, heard)
        });
        assert!(heard.0, "not told of");
        // Who could tell is gone.
        while heard.1.try_recv().is_ok() {}
        assert!(heard.1.recv().is_err());
    }
}
