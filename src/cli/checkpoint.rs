//! Checkpoints of a run: where and how often they are written, and which messages report them.

use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::time::Instant;

use super::console;
use super::exit::Failure;
use super::method::MethodChoice;
use super::number_text::{count, percent, time};
use super::results::counted;
use super::solve_arguments::{Resumption, SolveArguments};
use crate::output::{
    CheckpointFile, CheckpointHeader, SealedError, prove_checkpoint, read_checkpoint, write_checkpoint,
};
use crate::solver::{GoingOn, Keeper, Progress, RunState, Solution, StopReason};

/// Default seconds between two checkpoints.
pub const USUAL_INTERVAL_S: f64 = 60.0;
/// Largest share of a run's time that writing may take. If writing takes more, checkpoints become less frequent.
const MOST_SHARE: f64 = 0.02;
/// Stop reasons after which a run has done all the work that was requested.
const DONE: [StopReason; 4] = [StopReason::TargetMet, StopReason::Chains, StopReason::Exact, StopReason::FinestMesh];

/// Writes the checkpoints of a run.
pub struct CheckpointKeeper {
    path: PathBuf,
    interval_s: f64,
    started: Instant,
    header: CheckpointHeader,
    written: Mutex<Written>,
}

/// The latest checkpoint.
#[derive(Clone, Copy, Default)]
struct Written {
    /// Seconds from the start of the process at which it was on the disk, and seconds that writing took.
    at_s: f64,
    took_s: f64,
    /// Number of checkpoints so far, seconds that writing all of them took, and whether the latest could not be written.
    count: u32,
    all_s: f64,
    has_failed: bool,
}

impl CheckpointKeeper {
    /// Writes checkpoints at an interval in s, for a run of a process that started at `started`.
    pub fn new(path: PathBuf, interval_s: Option<f64>, started: Instant, header: CheckpointHeader) -> CheckpointKeeper {
        let written = Mutex::new(Written { at_s: started.elapsed().as_secs_f64(), ..Written::default() });
        CheckpointKeeper { path, interval_s: interval_s.unwrap_or(USUAL_INTERVAL_S), started, header, written }
    }

    /// The message at the end of a run. If work is left, it gives the command that resumes the run.
    pub fn closing_line(&self, solution: &Solution) -> Option<String> {
        let written = *self.written.lock().ok()?;
        if written.has_failed {
            return Some(format!(
                "warning: the latest checkpoint could not be written; {} contains an earlier one, if any",
                self.path.display()
            ));
        }
        if written.count == 0 {
            return Some("no checkpoint was written: the run ended before its pilots did".to_owned());
        }
        let path = self.path.display();
        let how = match DONE.contains(&solution.stop_reason) {
            true => format!("luxmc resume {path} --target-error … continues to a smaller error"),
            false => format!("luxmc resume {path} continues from there"),
        };
        let (times, all) = (counted(written.count as usize, "time"), time(written.all_s));
        Some(format!("checkpoint in {path}: {how} (written {times}, {all} in all)"))
    }
}

impl Keeper for CheckpointKeeper {
    fn is_due(&self) -> bool {
        let now_s = self.started.elapsed().as_secs_f64();
        let Ok(written) = self.written.lock() else { return false };
        now_s - written.at_s >= self.interval_s.max(written.took_s / MOST_SHARE)
    }

    fn keep(&self, state: &RunState, progress: &Progress, ended: Option<StopReason>) {
        let begun_s = self.started.elapsed().as_secs_f64();
        let header = CheckpointHeader {
            stop_reason: ended.map(|reason| reason.name().to_owned()),
            rays: progress.rays,
            estimated_error: progress.estimated_error,
            wall_s: progress.wall_s,
            ..self.header.clone()
        };
        let outcome = write_checkpoint(&self.path, &header, state);
        let Ok(mut written) = self.written.lock() else { return };
        written.at_s = self.started.elapsed().as_secs_f64();
        written.took_s = written.at_s - begun_s;
        written.all_s += written.took_s;
        match outcome {
            Ok(()) => (written.count, written.has_failed) = (written.count + 1, false),
            Err(error) => {
                // The warning appears once: the run goes on, and the earlier checkpoint stays.
                if !written.has_failed {
                    console::message(&format!(
                        "warning: the checkpoint {} cannot be written ({error}): the run continues and will try again",
                        self.path.display()
                    ));
                }
                written.has_failed = true;
            }
        }
    }
}

/// Refuses, before the run, a checkpoint that cannot work. The method must compute in rounds of rays, and the file must be free and
/// writable.
///
/// # Errors
///
/// The reason, with a remedy.
pub fn check(path: &Path, method: MethodChoice) -> Result<(), Failure> {
    if let Some(name) = method.name_without_chains() {
        return refuse(
            "this method keeps no checkpoints: it does not compute in rounds that could be resumed",
            format!("--checkpoint {} --method {name}", path.display()),
            "auto, gather, collision or local",
            "leave out --checkpoint, or name one of those methods",
        );
    }
    if path.is_dir() {
        return refuse(
            "the checkpoint is a directory",
            path.display().to_string(),
            "the name of a file",
            "name a file in it",
        );
    }
    if path.exists() {
        match read_checkpoint(path) {
            Ok(file) if is_done(&file) => {}
            Ok(file) => {
                return refuse(
                    "the file is the checkpoint of an unfinished run",
                    words_on(&file),
                    "a file that does not exist yet, or the checkpoint of a finished run",
                    "resume it with luxmc resume FILE, delete it, or name another file",
                );
            }
            Err(error) => {
                return refuse(
                    "a file of this name exists and is not a checkpoint",
                    format!("{}: {}", path.display(), error.got),
                    "a file that does not exist yet, or the checkpoint of a finished run",
                    "name another file",
                );
            }
        }
    }
    Ok(())
}

/// Proves that a checkpoint can be written at this path.
///
/// # Errors
///
/// The answer of the system.
pub fn prove(path: &Path) -> Result<(), Failure> {
    prove_checkpoint(path).or_else(|error| {
        // The name of the temporary probe file would mean nothing to the user.
        let error = error.to_string();
        let reason = error.split(" at path ").next().unwrap_or_default();
        refuse(
            "the checkpoint cannot be written",
            format!("{}: {reason}", path.display()),
            "a file in an existing directory with permission to write",
            "create the directory, allow writing there, or name another file",
        )
    })
}

/// Returns the state from which a run resumes, if its scene is unchanged.
///
/// # Errors
///
/// The scene has changed, or the state is not the one that was written.
pub fn take_up(resumption: &Resumption, digest: String) -> Result<GoingOn, SealedError> {
    let file = &resumption.file;
    if digest != file.header.scene_digest {
        return Err(SealedError {
            path: resumption.scene.clone(),
            what: "the scene is not the one that the run computed, or it has changed since".to_owned(),
            got: format!("digest {digest:.16}…"),
            expected: format!("digest {:.16}…, as in {}", file.header.scene_digest, file.path.display()),
            remedy: "restore the scene as it was, name it with --scene, or start a new run".to_owned(),
        });
    }
    Ok(GoingOn { kept: file.state()?, time_limit_s: resumption.time_limit_s })
}

/// The header of a run's checkpoints, from the digest of the scene, the scene file, its name and the directory of the results.
pub fn header(
    scene_digest: String,
    [scene_file, name, out]: [&PathBuf; 3],
    arguments: &SolveArguments,
) -> CheckpointHeader {
    let absolute = |path: &PathBuf| std::path::absolute(path).unwrap_or_else(|_| path.clone());
    CheckpointHeader {
        luxmc: env!("CARGO_PKG_VERSION").to_owned(),
        scene: name.display().to_string(),
        scene_path: absolute(scene_file),
        scene_digest,
        out: absolute(out),
        arguments: serde_json::to_value(arguments).unwrap_or_default(),
        stop_reason: None,
        rays: 0,
        estimated_error: None,
        wall_s: 0.0,
        state_sha256: String::new(),
    }
}

fn refuse(what: &str, got: String, expected: &str, remedy: &str) -> Result<(), Failure> {
    let [what, expected, remedy] = [what, expected, remedy].map(str::to_owned);
    Err(Failure::Usage { what, got, expected, remedy })
}

/// Whether the run has done all that was requested.
fn is_done(file: &CheckpointFile) -> bool {
    DONE.iter().any(|reason| file.header.stop_reason.as_deref() == Some(reason.name()))
}

/// Describes a checkpoint: its run, and how far the run has come.
pub fn words_on(file: &CheckpointFile) -> String {
    let header = &file.header;
    let error = header.estimated_error.map_or(String::new(), |error| format!(", error {}", percent(error)));
    let ended = header.stop_reason.as_ref().map_or(String::new(), |reason| format!(", ended by {reason}"));
    format!(
        "{}: {} after {} rays in {}{error}{ended}",
        file.path.display(),
        header.scene,
        count(header.rays as f64),
        time(header.wall_s)
    )
}
