//! Reserves part of a time limit for the work after computing: judging, tables, plots, pages and models.

use std::time::{Duration, Instant};

use rayon::prelude::*;

use super::number_text::time;
use super::patience::latest_s;
use crate::output::{MOST_SURFACES, plotted_sets, shortest};

/// Trials; pieces that each thread writes in one trial; numbers of one piece; and the seconds that a usual core takes to write one
/// number.
const TRIALS: usize = 3;
const PIECES: u32 = 8;
const NUMBERS_OF_A_PIECE: u32 = 1000;
const A_NUMBER_S: f64 = 300e-9;
/// Largest slowness that a trial of a few milliseconds can justify.
const MOST_SLOWNESS: f64 = 2.5;
/// Share of the work after computing that one thread does while the others wait.
const ALONE: f64 = 0.25;
/// Share of the permitted overrun of a limit that is planned for. The rest is left for the last piece of work and for chance.
const COUNTED_ON: f64 = 0.5;
/// Share of a limit that computing gets in any case, for a first error check.
const LEAST_COMPUTING: f64 = 0.25;

/// Files of every run, and further files of each receiver set: two plots, two plots of its halves, and a sensor grid.
const FILES: usize = 12;
const FILES_OF_A_SET: usize = 4;

/// Measures how many times longer work takes here and now than on a usual core, on the threads of the pool. The result is the
/// median of a few trials, since a thread may have to wait for others at times.
pub fn trial() -> f64 {
    let write = |piece: u32| -> usize {
        let numbers = piece * NUMBERS_OF_A_PIECE..(piece + 1) * NUMBERS_OF_A_PIECE;
        numbers.map(|number| shortest(1.0 / f64::from(number + 1)).len()).sum()
    };
    let threads = rayon::current_num_threads() as u32;
    let mut times_s = [0.0; TRIALS].map(|_: f64| {
        let begun = Instant::now();
        std::hint::black_box((0..PIECES * threads).into_par_iter().with_max_len(1).map(write).sum::<usize>());
        begun.elapsed().as_secs_f64()
    });
    times_s.sort_by(f64::total_cmp);
    let usual_s = f64::from(PIECES * NUMBERS_OF_A_PIECE) * A_NUMBER_S;
    (times_s[TRIALS / 2] / usual_s).clamp(1.0 / MOST_SLOWNESS, MOST_SLOWNESS)
}

/// The work of a run besides computing, whatever is computed.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Work {
    /// Seconds of a usual core for making ready, and for judging and writing.
    pub readying_s: f64,
    pub ending_s: f64,
    /// Number of files that are written.
    pub files: usize,
}

/// The machine on which the run works.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Machine {
    /// How many times longer work takes here than on a usual core, with all threads busy.
    pub slowness: f64,
    pub threads: usize,
    /// Time that writing a file takes in addition.
    pub a_file: Duration,
}

/// Whether the speed of the machine matters. It does not if even a slow machine judges and writes within the planned overrun.
pub fn needs_trial(limit_s: f64, work: &Work) -> bool {
    MOST_SLOWNESS * work.ending_s > COUNTED_ON * (latest_s(limit_s) - limit_s)
}

/// Approximate number of files of a run with maps of this many receiver sets and surfaces.
pub fn files_about(sets: usize, surfaces: usize) -> usize {
    FILES + FILES_OF_A_SET * plotted_sets(sets) + surfaces.min(MOST_SURFACES)
}

/// How a limit is divided between computing and the work after it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KeptBack {
    limit_s: f64,
    readying_s: f64,
    ending_s: f64,
    /// When computing ends, in s from the start of the process.
    pub computing_until_s: f64,
}

impl KeptBack {
    /// Divides a limit, `now_s` seconds after the start of the process.
    pub fn of(limit_s: f64, now_s: f64, work: Work, machine: Machine) -> KeptBack {
        let Machine { slowness, threads, a_file } = machine;
        let threads = threads.max(1) as f64;
        let readying_s = slowness * work.readying_s;
        let files_s = work.files as f64 * a_file.as_secs_f64() / threads;
        let ending_s = slowness * work.ending_s * (ALONE + (1.0 - ALONE) / threads) + files_s;
        let end_s = limit_s + COUNTED_ON * (latest_s(limit_s) - limit_s);
        let least_s = (now_s + readying_s + LEAST_COMPUTING * limit_s).min(limit_s);
        KeptBack { limit_s, readying_s, ending_s, computing_until_s: (end_s - ending_s).clamp(least_s, limit_s) }
    }

    /// Seconds for making ready, judging and writing.
    pub fn rest_s(&self) -> f64 {
        self.readying_s + self.ending_s
    }

    /// The warning before a run that cannot end in time.
    pub fn warning(&self) -> Option<String> {
        let is_late = self.computing_until_s + self.ending_s > latest_s(self.limit_s);
        is_late.then(|| {
            format!(
                "warning: error checks, writing, and preparation of this scene for rays take about {}, whatever is \
                 computed: the time limit of {} is exceeded, which leaves time for a first result only",
                time(self.rest_s()),
                time(self.limit_s)
            )
        })
    }

    /// The note before a run that ends in time because computing ends before the limit.
    pub fn line(&self) -> Option<String> {
        let kept_s = self.limit_s - self.computing_until_s;
        (kept_s > 0.0).then(|| {
            format!(
                "{} of the time limit of {} are reserved: error checks and writing take about {}",
                time(kept_s),
                time(self.limit_s),
                time(self.ending_s)
            )
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const USUAL: Machine = Machine { slowness: 1.0, threads: 1, a_file: Duration::ZERO };

    fn kept(limit_s: f64, now_s: f64, ending_s: f64) -> KeptBack {
        KeptBack::of(limit_s, now_s, Work { ending_s, ..Work::default() }, USUAL)
    }

    /// A run that writes little has its whole limit for computing, and prints no note.
    #[test]
    fn nothing_is_kept_back_for_what_takes_little() {
        let usual = kept(10.0, 0.1, 0.9);
        assert_eq!((usual.computing_until_s, usual.line(), usual.warning()), (10.0, None, None));
    }

    /// The time of long work after computing is subtracted from the limit, but a first error check stays possible. A warning
    /// reports what cannot fit.
    #[test]
    fn what_takes_long_comes_off_the_limit() {
        let long = kept(10.0, 0.1, 4.0);
        assert!((long.computing_until_s - 7.0).abs() < 1e-12 && long.warning().is_none(), "{long:?}");
        let line = long.line().unwrap_or_default();
        assert!(line.contains("3.0 s of the time limit of 10 s") && line.contains("about 4.0 s"), "{line}");
        let too_long = kept(10.0, 0.5, 30.0);
        assert_eq!(too_long.computing_until_s, 0.5 + 10.0 * LEAST_COMPUTING);
        let warning = too_long.warning().unwrap_or_default();
        assert!(warning.contains("take about 30 s") && warning.contains("time limit of 10 s"), "{warning}");
        // A limit that reading has used up is not changed.
        assert_eq!(kept(10.0, 11.0, 30.0).computing_until_s, 10.0);
        // Making ready comes before the first error check.
        let ready = KeptBack::of(10.0, 0.5, Work { readying_s: 2.0, ending_s: 30.0, files: 0 }, USUAL);
        assert_eq!((ready.computing_until_s, ready.rest_s()), (2.5 + 10.0 * LEAST_COMPUTING, 32.0));
    }

    /// Threads share all of the work except one part; each file adds its own time.
    #[test]
    fn threads_and_files_count() {
        let work = Work { readying_s: 0.0, ending_s: 4.0, files: 100 };
        let of = |threads, a_file| KeptBack::of(10.0, 0.0, work, Machine { slowness: 2.0, threads, a_file }).ending_s;
        assert_eq!([1, 2].map(|threads| of(threads, Duration::ZERO)), [8.0, 8.0 * (ALONE + 0.5 * (1.0 - ALONE))]);
        assert_eq!(of(1, Duration::from_millis(20)), 10.0);
        // Only some of ten thousand sets are plotted.
        assert!(files_about(10_000, 10) < 300 && files_about(3, 10_000) < 300);
    }

    /// A trial itself takes time. A small scene under a limit of milliseconds has no trial.
    #[test]
    fn what_is_done_in_no_time_has_no_trial() {
        let of = |ending_s: f64| Work { ending_s, ..Work::default() };
        assert!(!needs_trial(0.03, &of(0.1)) && needs_trial(0.03, &of(0.3)));
        assert!(!needs_trial(600.0, &of(10.0)) && needs_trial(600.0, &of(20.0)));
    }

    #[test]
    fn a_trial_tells_something() {
        let slowness = trial();
        assert!((1.0 / MOST_SLOWNESS..=MOST_SLOWNESS).contains(&slowness), "{slowness}");
    }
}
