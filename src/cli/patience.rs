//! Reports that silent work goes on: reading a large scene, and making it ready for rays.

use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::{Duration, Instant};

use super::console;
use super::number_text::time;

/// Time between two lines.
const INTERVAL: Duration = Duration::from_secs(5);
/// Largest time of reading and making ready, as a factor of the time limit and further seconds.
const OVER: f64 = 1.1;
const BEYOND_S: f64 = 1.0;

/// Seconds from the start after which a process with a time limit ends if it is not ready.
pub fn latest_s(limit_s: f64) -> f64 {
    OVER * limit_s + BEYOND_S
}

/// Does work, and every few seconds prints what it is, with the seconds since the process started. Prints nothing if `quiet`, or as
/// soon as the work reports on itself.
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
            // The channel closes when the work ends, even by a panic.
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

    /// Work that waits for its messages does end, and no message follows its end.
    #[test]
    fn long_work_is_reported_of_until_it_ends() {
        let (sender, heard) = channel();
        let tell = move || {
            sender.send(()).ok();
        };
        let heard = telling_every(Duration::from_millis(1), tell, || {
            let twice = heard.recv().is_ok() && heard.recv().is_ok();
            (twice, heard)
        });
        assert!(heard.0, "not told of");
        // The sender is gone.
        while heard.1.try_recv().is_ok() {}
        assert!(heard.1.recv().is_err());
    }
}
