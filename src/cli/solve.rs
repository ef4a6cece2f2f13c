//! `luxmc solve`: reads the scene, proves the directory writable, computes, writes and reports.

use std::path::Path;
use std::time::Instant;

use super::beforehand::{Beforehand, Kinds};
use super::checkpoint::CheckpointKeeper;
use super::dry_run::{self, dry_run};
use super::exit::Failure;
use super::kept_back::{KeptBack, Machine, Work, files_about, needs_trial, trial};
use super::memory::limit_memory;
use super::number_text::{percent, significant, time};
use super::patience::meanwhile;
use super::progress::{Watcher, heed_interruptions};
use super::results::{closing_lines, counted, exit_of, tell_results};
use super::run::{RunStory, SceneRun};
use super::solve_arguments::{Resumption, SolveArguments, command_again, command_without_output, options};
use super::time_guard::TimeGuard;
use super::verdict_target;
use super::{Outcome, checkpoint, console, share};
use crate::check::{read_scene, skip_checks};
use crate::maps::MapKind;
use crate::output::{PartOfRun, ResultDirectory, ShareHeader, share_file};
use crate::scene::under_way::reading_so_far;
use crate::scene::{Elements, Scene, allow_large_files};
use crate::solver::{ElementChoice, GoingOn, MapSums, Portion, Settings, ShareRecord, Solution, map_requests};

/// Solves a scene.
pub fn run(arguments: &SolveArguments, started: Instant) -> Outcome {
    run_from(arguments, None, started)
}

/// Refuses options that a run for verdicts cannot be combined with.
fn check_verdict_target(arguments: &SolveArguments) -> Result<(), Failure> {
    verdict_target::check(
        arguments.target,
        [
            (
                "--share",
                arguments.share.is_some(),
                "verdicts are known once shares are merged; a share cannot run until they are decided",
            ),
            (
                "--receivers-part",
                arguments.receivers_part.is_some(),
                "verdicts are known once parts are merged; a part cannot run until they are decided",
            ),
            (
                "--checkpoint",
                arguments.checkpoint.is_some(),
                "a run for verdicts starts again for each error, and keeps no checkpoint",
            ),
            ("--dry-run", arguments.dry_run, "a dry run forecasts the work for errors, not for verdicts"),
        ],
    )
}

/// Sets up the whole process: interruptions, the memory limit, and the checks to skip.
fn set_up(arguments: &SolveArguments) -> Result<(), Failure> {
    heed_interruptions();
    check_verdict_target(arguments)?;
    limit_memory(arguments.memory_limit);
    if arguments.allow_large {
        allow_large_files();
    }
    skip_checks(&arguments.skip_check);
    Ok(())
}

/// Under a time limit, gives the guard and the user an estimate, from the scene file, of the time until rays start.
fn announce(
    arguments: &SolveArguments,
    scene_file: &Path,
    limit_s: Option<f64>,
    guard: &TimeGuard,
) -> Option<Beforehand> {
    let limit_s = limit_s?;
    let scene = Beforehand::of(scene_file, Kinds::of(arguments.maps.as_deref()))?;
    guard.expect(scene);
    if let Some(line) = scene.line(limit_s) {
        console::message(&line);
    }
    Some(scene)
}

/// Makes the directory for the results, and proves that a checkpoint can be written. If it cannot, a new directory is removed.
fn open_results(arguments: &SolveArguments, out: &Path, guard: &TimeGuard) -> Result<ResultDirectory, Failure> {
    let new = (!out.exists()).then(|| out.to_owned());
    let (directory, checkpoint) = guard.undisturbed(new, || {
        let directory = ResultDirectory::open(out)?;
        Ok::<_, Failure>((directory, arguments.checkpoint.as_ref().map(|path| checkpoint::prove(path))))
    })?;
    if let Some(Err(failure)) = checkpoint {
        directory.withdraw();
        return Err(failure);
    }
    Ok(directory)
}

/// Number of element sides of a scene if their map is requested, else 0.
fn sides_requested(scene: &Scene, settings: &Settings) -> usize {
    let is_requested = map_requests(scene, &settings.maps).iter().any(|(kind, _)| *kind == MapKind::Elements);
    if is_requested { Elements::of(scene).len() } else { 0 }
}

/// Solves a scene from the beginning, or resumes from a checkpoint.
pub fn run_from(arguments: &SolveArguments, resumption: Option<Resumption>, started: Instant) -> Outcome {
    set_up(arguments)?;
    let scene_file = resumption.as_ref().map_or(&arguments.scene, |resumption| &resumption.scene);
    let limit_s = resumption.as_ref().map_or(arguments.time_limit, |resumption| resumption.time_limit_s);
    let guard = TimeGuard::of(limit_s, started);
    let beforehand = announce(arguments, scene_file, limit_s, &guard);
    let reading = || format!("reading and checking {}: {}", scene_file.display(), reading_so_far());
    let scene = meanwhile(reading, started, arguments.quiet, || false, || read_scene(scene_file))?;
    let read_s = started.elapsed().as_secs_f64();
    guard.has_read(read_s);
    let mut run = SceneRun::new(scene, &arguments.scene.display().to_string(), options(arguments)?)?;
    let (scene, settings) = (run.scene(), run.settings());
    let portion = arguments.portion();
    if let Some(portion) = portion {
        share::check(portion, scene, settings, arguments.method)?;
    }
    if let (Some(path), None) = (&arguments.checkpoint, &resumption) {
        checkpoint::check(path, arguments.method)?;
    }
    let going_on =
        resumption.as_ref().map(|resumption| checkpoint::take_up(resumption, run.scene_digest())).transpose()?;
    let Some(out) = arguments.out.as_ref().filter(|_| !arguments.dry_run) else {
        dry_run::check(arguments.method)?;
        guard.let_go();
        return run.on_its_threads(|| dry_run(scene, settings, arguments.method, started, arguments.quiet));
    };
    let directory = open_results(arguments, out, &guard)?;

    let quiet = arguments.quiet;
    let tell = |line: &str| {
        if !quiet {
            console::message(line)
        }
    };
    tell(&opening_line(arguments, scene, settings, run.threads()));

    for warning in &scene.warnings {
        console::message(&format!("warning: {warning}"));
    }

    let computing_until_s = beforehand.zip(limit_s).map(|(known, limit_s)| {
        let kept_back = keep_back(&run, known, [limit_s, read_s, started.elapsed().as_secs_f64()], &directory);
        time_to_compute(kept_back, known.line(limit_s).is_some(), [limit_s, read_s], &tell)
    });
    let going_on = going_on.map(|going_on| GoingOn { time_limit_s: computing_until_s, ..going_on });
    if let (Some(until_s), None) = (computing_until_s, &resumption) {
        run.compute_until(until_s);
    }

    if let Some(resumption) = &resumption {
        tell(&format!("resuming from {}", checkpoint::words_on(&resumption.file)));
    }
    let keeper = arguments.checkpoint.as_ref().map(|path| {
        let header = checkpoint::header(run.scene_digest(), [scene_file, &arguments.scene, out], arguments);
        CheckpointKeeper::new(path.clone(), arguments.checkpoint_every, started, header)
    });
    let watcher = Watcher::new(started, quiet, keeper).guarded_by(guard);
    let mut of_portion = None;
    let solve = || match portion {
        None => run.solve_from(going_on, &watcher),
        Some(portion) => {
            let (solution, record, sums) = run.solve_share(portion, going_on, &watcher);
            of_portion = Some((portion, record, sums));
            Ok(solution)
        }
    };
    let readying = || "preparing the scene for rays, and pilots".to_owned();
    let solution: Result<_, Failure> = meanwhile(readying, started, quiet, || watcher.has_begun(), solve);
    watcher.finish();
    let solution = match solution {
        Ok(solution) => solution,
        Err(failure) => {
            directory.withdraw();
            return Err(failure);
        }
    };

    let computed_s = started.elapsed().as_secs_f64();
    let ended = EndedRun { run: &run, scene_file, read_s, computed_s };
    ended.write(arguments, &solution, of_portion, directory)?;

    tell_results(run.scene(), &solution, arguments.language, tell)?;
    notes_on(arguments, &solution).for_each(|note| tell(&format!("note: {note}")));
    tell(&closing_lines(&solution, &out.display().to_string(), computed_s));
    if let Some(line) = watcher.keeper.as_ref().and_then(|keeper| keeper.closing_line(&solution)) {
        tell(&line);
    }
    Ok(exit_of(&solution))
}

/// Second of the run at which computing ends, so that the time kept back for writing suffices. Reports this, unless `was_reported`. The
/// array holds the limit and the seconds of reading.
fn time_to_compute(kept_back: KeptBack, was_reported: bool, [limit_s, read_s]: [f64; 2], tell: &dyn Fn(&str)) -> f64 {
    match late_line(limit_s, read_s, &kept_back).or_else(|| kept_back.warning().filter(|_| !was_reported)) {
        Some(line) => console::message(&line),
        None => kept_back.line().iter().for_each(|line| tell(line)),
    }
    kept_back.computing_until_s
}

/// A run that has ended, with facts for its results besides the solution.
struct EndedRun<'a> {
    run: &'a SceneRun,
    scene_file: &'a Path,
    read_s: f64,
    computed_s: f64,
}

impl EndedRun<'_> {
    /// Writes the results; for a portion, also its sums.
    fn write(
        &self,
        arguments: &SolveArguments,
        solution: &Solution,
        of_portion: Option<(Portion, ShareRecord, Vec<MapSums>)>,
        directory: ResultDirectory,
    ) -> Result<(), Failure> {
        let story = RunStory {
            scene: arguments.scene.display().to_string(),
            command: command_again(arguments, solution),
            threads: self.run.threads(),
            read_s: self.read_s,
            computed_s: self.computed_s,
            plots: arguments.plots,
            language: arguments.language,
            part: of_portion.as_ref().map_or(PartOfRun::Whole, |(portion, ..)| PartOfRun::Portion(*portion)),
        };
        let share = of_portion.as_ref().map(|(portion, record, sums)| {
            let (digest, settings) = (self.run.scene_digest(), self.run.settings());
            let header = share::header(digest, self.scene_file, settings, solution, *portion, record.clone());
            let command = command_without_output(arguments, solution);
            share_file(ShareHeader { command, threads: self.run.threads(), scene: story.scene.clone(), ..header }, sums)
        });
        self.run.on_its_threads(|| story.write(self.run.scene(), solution, share, directory)).map(|_| ())
    }
}

/// The notes that a user should read with the results.
fn notes_on<'a>(arguments: &SolveArguments, solution: &'a Solution) -> impl Iterator<Item = &'a str> {
    let binds_elements = solution.maps.iter().any(|map| map.bound && map.kind == MapKind::Elements);
    let is_idle = arguments.elements == ElementChoice::Given && !binds_elements;
    let idle = "--elements given changes nothing here, since the target does not bind the element map";
    is_idle.then_some(idle).into_iter().chain(solution.notes.iter().map(String::as_str))
}

pub(super) fn opening_line(arguments: &SolveArguments, scene: &Scene, settings: &Settings, threads: usize) -> String {
    let mut rules = Vec::new();
    rules.extend(arguments.share.map(|share| format!("share {} of {}", share.number, share.of)));
    rules.extend(arguments.receivers_part.map(|part| format!("part {} of {} of the receivers", part.number, part.of)));
    rules.extend(arguments.target.map(|_| "until verdicts are decided".to_owned()));
    rules.extend(settings.target_error.map(|error| format!("target {}", percent(error))));
    rules.extend(settings.chains.map(|chains| counted(chains as usize, "chain")));
    rules.extend(settings.time_limit_s.map(|limit_s| format!("time limit {}", time(limit_s))));
    if rules.is_empty() {
        rules.push("target 1 %".to_owned());
    }
    format!(
        "luxmc {}: {}: {} triangles, {} element sides, {} of {} lm, {}; {}; {}",
        env!("CARGO_PKG_VERSION"),
        arguments.scene.display(),
        scene.triangles.len(),
        Elements::of(scene).len(),
        counted(scene.luminaires.len(), "luminaire"),
        significant(scene.luminous_flux_lm(), 5),
        counted(scene.receivers.len(), "receiver set"),
        rules.join(", "),
        counted(threads, "thread")
    )
}

/// Divides a limit between computing and the work after it, from the estimate by the scene's files. The array holds the limit, the
/// seconds of reading, and the seconds so far.
fn keep_back(
    run: &SceneRun,
    known: Beforehand,
    [limit_s, read_s, now_s]: [f64; 3],
    directory: &ResultDirectory,
) -> KeptBack {
    let (scene, settings) = (run.scene(), run.settings());
    let known = known.with_sides(sides_requested(scene, settings));
    let needs_trial = needs_trial(limit_s, &known.work());
    let tried = || if needs_trial { run.on_its_threads(trial) } else { 1.0 };
    let machine =
        Machine { slowness: known.slowness(read_s, tried), threads: run.threads(), a_file: directory.took_a_file() };
    let requested = map_requests(scene, &settings.maps);
    let sets = requested.iter().filter(|(kind, _)| *kind != MapKind::Elements).count();
    let surfaces = if sets < requested.len() { scene.surfaces.len() } else { 0 };
    KeptBack::of(limit_s, now_s, Work { files: files_about(sets, surfaces), ..known.work() }, machine)
}

/// The warning before the run if reading alone has used up the limit.
fn late_line(limit_s: f64, read_s: f64, kept_back: &KeptBack) -> Option<String> {
    (read_s >= limit_s).then(|| {
        format!(
            "warning: reading and checking the scene took {}, more than the time limit of {}: the run gives a first \
             result only; preparation and writing take some {} more. A limit of at least twice the total leaves time \
             to compute",
            time(read_s),
            time(limit_s),
            time(kept_back.rest_s())
        )
    })
}
