//! Shows the progress of a run: a bar on a terminal, sparse lines elsewhere, nothing if quiet.

use std::io::IsTerminal;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, OnceLock};
use std::time::Instant;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use super::checkpoint::CheckpointKeeper;
use super::console;
use super::exit::Exit;
use super::number_text::{count, percent, time};
use super::time_guard::TimeGuard;
use crate::control::Forecast;
use crate::output::remove_unfinished_results;
use crate::solver::{Hindrance, Keeper, Observer, Progress};

/// Seconds between two lines if there is no terminal.
const LINE_INTERVAL_S: f64 = 5.0;
/// A forecast of more seconds gets a line of its own, with a remedy.
const LONG_S: f64 = 3600.0;
/// A forecast of more seconds is reported as "never".
const NEVER_S: f64 = 30.0 * 86_400.0;
/// Seconds of a run from which its forecast is believed. Before, the lower end of its interval is used.
const BELIEVED_FROM_S: f64 = 10.0;
/// Length of a run, in s, that a user may accept instead.
const PATIENCE_S: f64 = 600.0;
/// Number of steps of the bar.
const BAR_STEPS: u64 = 1000;

/// A second interruption within this many seconds of the first counts as the same: `timeout` and shells signal both a process and
/// its group.
const SAME_INTERRUPTION_S: f64 = 1.0;

/// Time of the first interruption.
static INTERRUPTED: OnceLock<Instant> = OnceLock::new();

/// From now on the first interruption (Ctrl-C, or a polite kill) ends the run with its results. Another one, more than a second
/// later, ends the process at once.
pub fn heed_interruptions() {
    let handler = || {
        let first = INTERRUPTED.get_or_init(Instant::now);
        if first.elapsed().as_secs_f64() > SAME_INTERRUPTION_S {
            remove_unfinished_results();
            std::process::exit(i32::from(Exit::Interrupted.number()));
        }
    };
    // If the handler cannot be set, an interruption ends the process as it would by default: no reason not to run.
    ctrlc::set_handler(handler).ok();
}

/// Whether the user has requested the end of the run.
pub fn is_interrupted() -> bool {
    INTERRUPTED.get().is_some()
}

enum Display {
    Quiet,
    Bar(ProgressBar),
    Lines(Mutex<f64>),
}

/// Shows a run on the terminal.
pub struct Watcher {
    /// Keeps the run's state in checkpoints, if requested.
    pub keeper: Option<CheckpointKeeper>,
    started: Instant,
    run_started_s: f64,
    display: Display,
    /// Whether the line on a very long run has been printed.
    has_reported: AtomicBool,
    /// Whether the line on a target that is out of reach has been printed.
    has_reported_reach: AtomicBool,
    /// Whether the run has reported progress.
    has_begun: AtomicBool,
    /// Ends the process if the run is not ready in time.
    guard: Option<TimeGuard>,
}

impl Watcher {
    /// Watches a run of a process that started at `started`.
    pub fn new(started: Instant, quiet: bool, keeper: Option<CheckpointKeeper>) -> Watcher {
        let run_started_s = started.elapsed().as_secs_f64();
        let display = if quiet {
            Display::Quiet
        } else if std::io::stderr().is_terminal() {
            Display::Bar(bar())
        } else {
            Display::Lines(Mutex::new(run_started_s))
        };
        Watcher {
            keeper,
            started,
            run_started_s,
            display,
            has_reported: AtomicBool::new(false),
            has_reported_reach: AtomicBool::new(false),
            has_begun: AtomicBool::new(false),
            guard: None,
        }
    }

    /// The same, with a guard that is released once the run is ready.
    pub fn guarded_by(self, guard: TimeGuard) -> Watcher {
        Watcher { guard: Some(guard), ..self }
    }

    /// Whether the run has reported progress.
    pub fn has_begun(&self) -> bool {
        self.has_begun.load(Ordering::Relaxed)
    }

    /// Prints once that a run will take very long, and once that its target is out of reach.
    fn tell_of_long_run(&self, progress: &Progress) {
        if matches!(self.display, Display::Quiet) {
            return;
        }
        let runs_s = progress.wall_s - self.run_started_s;
        let Some(line) = long_run_line(progress, runs_s) else { return };
        let is_out_of_reach = runs_s >= BELIEVED_FROM_S && hindrance(progress).is_some_and(Hindrance::is_out_of_reach);
        let has_reported = if is_out_of_reach { &self.has_reported_reach } else { &self.has_reported };
        if has_reported.swap(true, Ordering::Relaxed) {
            return;
        }
        match &self.display {
            Display::Bar(bar) => bar.println(line),
            _ => console::message(&line),
        }
    }

    /// Clears the bar, so that lines can follow.
    pub fn finish(&self) {
        if let Display::Bar(bar) = &self.display {
            bar.finish_and_clear();
        }
    }
}

fn bar() -> ProgressBar {
    let bar = ProgressBar::with_draw_target(Some(BAR_STEPS), ProgressDrawTarget::stderr());
    if let Ok(style) = ProgressStyle::with_template("{bar:12} {wide_msg}") {
        bar.set_style(style.progress_chars("━╸ "));
    }
    bar
}

impl Observer for Watcher {
    fn ready(&self) {
        if let Some(guard) = &self.guard {
            guard.let_go();
        }
    }

    fn progress(&self, progress: &Progress) {
        self.has_begun.store(true, Ordering::Relaxed);
        self.tell_of_long_run(progress);
        match &self.display {
            Display::Quiet => {}
            Display::Bar(bar) => {
                bar.set_position((progress.fraction * BAR_STEPS as f64) as u64);
                bar.set_message(line(progress, self.run_started_s));
            }
            Display::Lines(last_s) => {
                let Ok(mut last_s) = last_s.lock() else { return };
                if progress.wall_s - *last_s >= LINE_INTERVAL_S {
                    *last_s = progress.wall_s;
                    console::message(&format!("{:>8}: {}", time(progress.wall_s), line(progress, self.run_started_s)));
                }
            }
        }
    }

    fn expects(&self, error: Forecast, target: Option<f64>) {
        let line = limit_line(error, target);
        match &self.display {
            Display::Quiet => {}
            Display::Bar(bar) => bar.println(line),
            Display::Lines(_) => console::message(&line),
        }
    }

    fn is_interrupted(&self) -> bool {
        is_interrupted()
    }

    fn keeper(&self) -> Option<&dyn Keeper> {
        self.keeper.as_ref().map(|keeper| keeper as &dyn Keeper)
    }

    fn wall_s(&self) -> f64 {
        self.started.elapsed().as_secs_f64()
    }
}

/// The line of progress: error, target, remaining time with its interval, rays with their forecast, and speed. The most important
/// comes first, since a narrow terminal cuts off the end.
fn line(progress: &Progress, run_started_s: f64) -> String {
    let mut parts = Vec::new();
    match (progress.estimated_error, progress.target_error) {
        (Some(error), Some(target)) => parts.push(format!("error {} (target {})", percent(error), percent(target))),
        (Some(error), None) => parts.push(format!("error {}", percent(error))),
        (None, Some(target)) => parts.push(format!("target {}", percent(target))),
        (None, None) => {}
    }
    let running_s = progress.wall_s - run_started_s;
    if is_out_of_reach(progress, running_s) {
        parts.push("out of reach so far".to_owned());
    } else if let Some(remaining_s) = progress.remaining_s {
        parts.push(remaining(remaining_s));
    }
    match progress.forecast_rays {
        Some(all) => parts.push(format!("{} of {} rays", count(progress.rays as f64), count(all.expected))),
        None => parts.push(format!("{} rays", count(progress.rays as f64))),
    }
    if running_s > 0.0 {
        parts.push(format!("{:.1} Mrays/s", progress.rays as f64 / running_s / 1e6));
    }
    parts.join(", ")
}

/// The line on a time limit: the error that it is expected to afford, and whether it comes before the target.
fn limit_line(error: Forecast, target: Option<f64>) -> String {
    let [low, expected, high] = [error.low, error.expected, error.high].map(percent);
    let comes_first =
        target.map_or(String::new(), |target| format!("comes before the target of {} and ", percent(target)));
    format!(
        "forecast by the pilots: the time limit {comes_first}allows a stated error of about {expected} ({low} to \
         {high} in 90 % of runs)"
    )
}

/// Remaining seconds, with the interval that holds them in nine runs of ten.
fn remaining(left_s: Forecast) -> String {
    let [low, expected, high] = [left_s.low, left_s.expected, left_s.high].map(time);
    if low == high { format!("{expected} left") } else { format!("{expected} left ({low} to {high})") }
}

/// The same without "left", for a run whose end is not near.
fn within(left_s: Forecast) -> String {
    remaining(left_s).replacen(" left", "", 1)
}

/// The obstacle other than chance that keeps the slowest map from its target.
fn hindrance(progress: &Progress) -> Option<&Hindrance> {
    progress.slowest_map.as_ref()?.hindrance.as_ref()
}

/// Whether the run has lasted long enough to state that no plan takes the slowest map to its target.
fn is_out_of_reach(progress: &Progress, runs_s: f64) -> bool {
    runs_s >= BELIEVED_FROM_S && hindrance(progress).is_some_and(Hindrance::is_out_of_reach)
}

/// The line on a forecast of more than an hour, with its cause and a remedy. `None` if the run is shorter, has no target, or its
/// first seconds leave the forecast open.
fn long_run_line(progress: &Progress, runs_s: f64) -> Option<String> {
    let (left_s, target) = (progress.remaining_s?, progress.target_error?);
    let is_out_of_reach = is_out_of_reach(progress, runs_s);
    let remaining_s = if runs_s >= BELIEVED_FROM_S { left_s.expected } else { left_s.low };
    if remaining_s <= LONG_S && !is_out_of_reach {
        return None;
    }
    let when = match left_s.expected {
        _ if is_out_of_reach => "is out of reach so far".to_owned(),
        left_s if left_s > NEVER_S => "will practically never be met at this rate".to_owned(),
        _ => format!("is met in some {} at this rate", within(left_s)),
    };
    // The error falls with the square root of the work.
    let easier = target * ((runs_s + left_s.expected) / PATIENCE_S).sqrt();
    let remedy = match hindrance(progress) {
        Some(Hindrance::Cells(_)) if is_out_of_reach => "--method collision has no such error".to_owned(),
        Some(Hindrance::Elements(_)) => {
            "smaller elements at the start (max_element_edge) may help, and --elements given computes only their means"
                .to_owned()
        }
        _ if easier < 1.0 => format!("--target-error {:.2}% takes some {}", 100.0 * easier, time(PATIENCE_S)),
        _ => "a larger error or fewer maps (--maps) take less time".to_owned(),
    };
    let (target, cause) = (percent(target), cause(progress, is_out_of_reach));
    Some(format!(
        "forecast: the target of {target} {when}{cause}; {remedy}; Ctrl-C or --time-limit end the run with the \
         results so far"
    ))
}

/// The known cause of a long run; empty if none is known.
fn cause(progress: &Progress, is_out_of_reach: bool) -> String {
    let Some(map) = &progress.slowest_map else {
        return String::new();
    };
    let name = &map.name;
    match (&map.hindrance, map.error) {
        (Some(Hindrance::Cells(bias)), _) if is_out_of_reach => format!(
            ": the error that the cells of \"{name}\" have in common, {}, exceeds it by itself, and walks remove it \
             slowly",
            percent(*bias)
        ),
        (Some(Hindrance::Elements(lost)), _) => format!(
            ": the discretisation error of the elements of \"{name}\", {}, exceeds it by itself until they are \
             subdivided",
            percent(*lost)
        ),
        (Some(Hindrance::Check(times)), _) => format!(
            "; most of it goes to \"{name}\", where a statistical check has rejected the error {}",
            if *times == 1 { "once".to_owned() } else { format!("{times} times") }
        ),
        (_, Some(error)) => format!("; most of it goes to \"{name}\" (its error so far {})", percent(error)),
        (_, None) => format!("; most of it goes to \"{name}\""),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::solver::SlowestMap;

    fn at(remaining_s: Forecast, hindrance: Option<Hindrance>) -> Progress {
        Progress {
            estimated_error: Some(0.05),
            target_error: Some(0.01),
            chains: 1,
            rays: 1,
            forecast_rays: None,
            remaining_s: Some(remaining_s),
            slowest_map: Some(SlowestMap { name: "corners".to_owned(), error: Some(0.05), hindrance }),
            fraction: 0.0,
            wall_s: 20.0,
        }
    }

    /// A forecast of more than an hour is reported with its cause and a remedy; a shorter one is not.
    #[test]
    fn a_forecast_beyond_an_hour_is_reported_with_its_cause() {
        let line_of = |remaining_s: f64| long_run_line(&at(Forecast::known(remaining_s), None), 20.0);
        assert_eq!(line_of(3500.0), None);
        let line = line_of(7180.0).unwrap_or_default();
        assert!(line.contains("1 h 59 min") && line.contains("\"corners\"") && line.contains("3.46%"), "{line}");
        let line = line_of(f64::INFINITY).unwrap_or_default();
        assert!(line.contains("never") && line.contains("--maps"), "{line}");
    }

    /// At the start a forecast is reported only if its whole interval exceeds an hour.
    #[test]
    fn the_pilots_tell_of_a_long_run_before_it() {
        let by_pilots = |low: f64| long_run_line(&at(Forecast { expected: 9000.0, low, high: 20_000.0 }, None), 0.1);
        assert_eq!(by_pilots(3000.0), None);
        let line = by_pilots(4000.0).unwrap_or_default();
        assert!(line.contains("2 h 30 min (1 h 6 min to 5 h 33 min)"), "{line}");
    }

    /// An error shared by cells that exceeds the target, and that no plan takes below it, is reported as out of reach, however
    /// short the forecast. Elements that lose more than the target, and a check that refuses, are reported as their own causes.
    #[test]
    fn what_exceeds_the_target_by_itself_is_reported() {
        let line_of =
            |remaining_s: f64, hindrance| long_run_line(&at(Forecast::known(remaining_s), Some(hindrance)), 20.0);
        let line = line_of(60.0, Hindrance::Cells(0.02)).unwrap_or_default();
        assert!(
            line.contains("out of reach") && line.contains("2.00 %") && line.contains("--method collision"),
            "{line}"
        );
        let line_beside = super::line(&at(Forecast::known(60.0), Some(Hindrance::Cells(0.02))), 0.0);
        assert!(line_beside.contains("out of reach so far") && !line_beside.contains(" left"), "{line_beside}");
        assert_eq!(line_of(60.0, Hindrance::Elements(0.02)), None);
        let line = line_of(7200.0, Hindrance::Elements(0.02)).unwrap_or_default();
        assert!(line.contains("\"corners\", 2.00 %") && line.contains("max_element_edge"), "{line}");
        let line = line_of(7200.0, Hindrance::Check(2)).unwrap_or_default();
        assert!(line.contains("rejected the error 2 times"), "{line}");
    }

    #[test]
    fn a_limit_before_the_target_is_reported() {
        let error = Forecast { expected: 0.006, low: 0.004, high: 0.01 };
        let (with, without) = (limit_line(error, Some(0.001)), limit_line(error, None));
        assert!(
            with.contains("comes before the target of 0.100 % and allows a stated error of about 0.600 %"),
            "{with}"
        );
        assert!(without.contains("the time limit allows"), "{without}");
    }

    #[test]
    fn a_line_tells_error_target_forecast_and_speed() {
        let progress = Progress {
            estimated_error: Some(0.0123),
            target_error: Some(0.01),
            chains: 1_500_000,
            rays: 8_000_000,
            forecast_rays: Some(Forecast::known(1.2e7)),
            remaining_s: Some(Forecast { expected: 1.2, low: 0.9, high: 1.8 }),
            slowest_map: None,
            fraction: 0.6,
            wall_s: 2.5,
        };
        assert_eq!(
            line(&progress, 0.5),
            "error 1.23 % (target 1.00 %), 1.2 s left (0.90 s to 1.8 s), 8.00 M of 12.0 M rays, 4.0 Mrays/s"
        );
    }
}
