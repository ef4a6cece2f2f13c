//! Solves a scene while Python's thread listens for interruptions.

use std::collections::BTreeMap;
use std::sync::Mutex;
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::time::Duration;

use luxmc::solver::Progress;
use luxmc::{Failure, RunOptions, RunStory, SceneRun};
use pyo3::exceptions::{PyKeyboardInterrupt, PyRuntimeError};
use pyo3::prelude::*;

use crate::failure::raised;
use crate::progress::Watched;
use crate::result::Solution;
use crate::scene::Scene;

/// Time between two checks for interruptions and news.
const LOOK_EVERY: Duration = Duration::from_millis(50);

/// Numbers that a listener gets: share of the work done, stated error and target if there are any, rays, chains, remaining seconds if
/// known, seconds so far.
type News = (f64, Option<f64>, Option<f64>, u64, u64, Option<f64>, f64);

/// Solves a scene. `options` are those of `luxmc solve` by their names. `listener` is called with news from time to time. The solver works
/// without the interpreter's lock. A KeyboardInterrupt, or an exception of the listener, ends it with what it has. The exception of a
/// listener is then raised.
#[pyfunction]
pub fn solve(
    py: Python<'_>,
    scene: &Scene,
    options: BTreeMap<String, String>,
    command: String,
    listener: Option<Bound<'_, PyAny>>,
) -> PyResult<Solution> {
    let watched = Watched::new();
    let mut of_run = RunOptions::default();
    for (name, value) in &options {
        of_run.set(name, value).map_err(|failure| raised(py, failure))?;
    }
    luxmc::cli::limit_memory(None);
    let checked = py.detach(|| SceneRun::new(scene.scene.clone(), &scene.name, of_run));
    let run = checked.map_err(|failure| raised(py, failure))?;
    let mut fault = None;
    let solved = std::thread::scope(|scope| {
        let (done, end) = channel();
        let end = Mutex::new(end);
        let (run, watched) = (&run, &watched);
        scope.spawn(move || done.send(run.solve(watched)).ok());
        listen(py, watched, &end, listener.as_ref(), &mut fault)
    });
    if let Some(fault) = fault {
        return Err(fault);
    }
    let solution = solved?.map_err(|failure| raised(py, failure))?;
    let story = RunStory {
        scene: scene.name.clone(),
        command,
        threads: run.threads(),
        read_s: scene.read_s,
        computed_s: watched.elapsed_s(),
        plots: None,
        language: luxmc::output::Language::ENGLISH,
        part: luxmc::output::PartOfRun::Whole,
    };
    Ok(Solution::new(run, solution, story))
}

/// Waits for the end of a run, and passes news and interruptions on.
fn listen(
    py: Python<'_>,
    watched: &Watched,
    end: &Mutex<Receiver<Result<luxmc::Solution, Failure>>>,
    listener: Option<&Bound<'_, PyAny>>,
    fault: &mut Option<PyErr>,
) -> PyResult<Result<luxmc::Solution, Failure>> {
    loop {
        let waited = py.detach(|| wait(end));
        match waited {
            Ok(solved) => return Ok(solved),
            Err(RecvTimeoutError::Disconnected) => {
                return Err(PyRuntimeError::new_err("the run ended without a result: a fault of luxmc itself"));
            }
            Err(RecvTimeoutError::Timeout) => {}
        }
        if py.check_signals().is_err() {
            watched.interrupt();
        }
        let (Some(listener), Some(progress), true) = (listener, watched.news(), fault.is_none()) else { continue };
        if let Err(error) = listener.call1(news(&progress)) {
            watched.interrupt();
            // An interruption during the listener's work is treated like any other.
            *fault = (!error.is_instance_of::<PyKeyboardInterrupt>(py)).then_some(error);
        }
    }
}

/// Waits up to `LOOK_EVERY`. A thread that panicked while it held the lock counts as gone.
fn wait<T>(end: &Mutex<Receiver<T>>) -> Result<T, RecvTimeoutError> {
    end.lock().map_err(|_| RecvTimeoutError::Disconnected)?.recv_timeout(LOOK_EVERY)
}

fn news(progress: &Progress) -> News {
    (
        progress.fraction,
        progress.estimated_error,
        progress.target_error,
        progress.rays,
        progress.chains,
        progress.remaining_s.map(|left_s| left_s.expected).filter(|left_s| left_s.is_finite()),
        progress.wall_s,
    )
}
