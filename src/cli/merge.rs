//! `luxmc merge`: merges the shares of a run into one result.

use std::path::{Path, PathBuf};
use std::time::{Instant, SystemTime, UNIX_EPOCH};

use clap::Args;

use super::exit::Failure;
use super::memory::{check_memory, limit_memory};
use super::method::{self, Plots};
use super::number_text::percent;
use super::patience::meanwhile;
use super::proportions::check_proportions;
use super::results::{closing_lines, counted, exit_of, stage_results, tell_results};
use super::run::thread_pool;
use super::share::options_of;
use super::{Outcome, console, values};
use crate::base::memory::peak_bytes;
use crate::check::{MeshCheck, read_scene, skip_checks};
use crate::control::Forecast;
use crate::geometry::position_accuracy_m;
use crate::maps::MapKind;
use crate::output::{
    Language, PartOfRun, ReportContext, ResultDirectory, RunRecord, SealedError, ShareFile, read_share, summary_file,
};
use crate::scene::under_way::reading_so_far;
use crate::scene::{Elements, ReceiversPart, Scene, allow_large_files};
use crate::solver::{
    ElementChoice, MapOfShare, MapSelection, Merged, Method, MoreShares, Portion, Settings, Share, ShareRecord,
    StopReason, merge,
};

const EXAMPLES: &str = "\
Examples:
  luxmc solve office.json --out out/1 --share 1/2 --chains 1e6 --target-error 0.5%
  luxmc solve office.json --out out/2 --share 2/2 --chains 1e6 --target-error 0.5%
  luxmc merge out/1 out/2 --out out/all              checks the target, and reports how many more shares it takes
  luxmc solve office.json --out out/3 --share 3/3 --chains 1e6 --target-error 0.5%
  luxmc merge out/1 out/2 out/3 --out out/all        adds a further share
  luxmc solve campus.json --out part/1 --receivers-part 1/2 --target-error 1%
  luxmc solve campus.json --out part/2 --receivers-part 2/2 --target-error 1%
  luxmc merge part/* --out out/all                   combines parts of the receivers

The result does not depend on the order of the directories. All shares from the first to the last must be given, each once, and each with
all parts of the receivers. They must have the same scene, seed, method and version of luxmc.";

/// Arguments of `luxmc merge`.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct MergeArguments {
    /// Directories of all shares or parts, written by luxmc solve --share or --receivers-part
    #[arg(value_name = "DIR", required = true)]
    shares: Vec<PathBuf>,
    /// Directory for the merged results; created if missing, other files in it stay
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Target for the stated relative error of every bound map: 1% or 0.01 [default: that of the shares]
    #[arg(long, value_name = "ERROR", value_parser = values::target_error, allow_hyphen_values = true)]
    target_error: Option<f64>,
    /// Scene file, if it is no longer where the shares found it
    #[arg(long, value_name = "SCENE")]
    scene: Option<PathBuf>,
    /// Plots: svg, png, both separated by a comma, or none [default: svg]
    #[arg(long, value_name = "FORMATS", value_parser = method::plots)]
    plots: Option<Plots>,
    /// Language of report, plots and the table on the terminal: en or de
    #[arg(long, value_name = "CODE", default_value = "en", value_parser = Language::of_code)]
    language: Language,
    /// Worker threads; results do not depend on them [default: all processors]
    #[arg(long, value_name = "T", value_parser = values::threads, allow_hyphen_values = true)]
    threads: Option<usize>,
    /// Memory that the merge may use: 2GB, 512MiB [default: what the machine has left]
    #[arg(long, value_name = "MEMORY", value_parser = values::bytes, allow_hyphen_values = true)]
    memory_limit: Option<u64>,
    /// Read files of any size; without this option, files above 512 MiB (photometric files above 64 MiB) are refused as probable mistakes
    #[arg(long)]
    allow_large: bool,
    /// Checks of meshes to skip, separated by commas: faults, overlaps, advice, insides (then points inside of solids count). The
    /// warnings of the run list the skipped checks
    #[arg(long, value_name = "CHECKS", value_delimiter = ',', value_parser = values::mesh_check)]
    skip_check: Vec<MeshCheck>,
    /// No notes on standard error; warnings and errors stay
    #[arg(long)]
    quiet: bool,
}

/// Merges shares.
pub fn run(arguments: &MergeArguments, started: Instant) -> Outcome {
    limit_memory(arguments.memory_limit);
    if arguments.allow_large {
        allow_large_files();
    }
    skip_checks(&arguments.skip_check);
    let shares = read_shares(&arguments.shares)?;
    let target_error = target_of(arguments, &shares)?;
    check_out(arguments)?;
    let first = &shares[0];
    let path = arguments.scene.as_ref().unwrap_or(&first.header.scene_path);
    let reading = || format!("reading and checking {}: {}", path.display(), reading_so_far());
    let mut scene = meanwhile(reading, started, arguments.quiet, || false, || read_scene(path))?;
    check_proportions(&mut scene, &path.display().to_string())?;
    let read_s = started.elapsed().as_secs_f64();
    check_scene(&scene, path, &shares)?;
    let mut maps: Vec<String> = shares.iter().flat_map(map_names).collect();
    maps.sort();
    maps.dedup();
    let settings = Settings {
        method: method_of(first)?,
        elements: ElementChoice::Given,
        seed: first.header.seed,
        target_error,
        maps: MapSelection::Named(maps),
        threads: arguments.threads,
        ..Settings::default()
    };
    check_memory(&scene, &settings)?;
    let pool = thread_pool(arguments.threads)?;
    let directory = ResultDirectory::open(&arguments.out)?;
    let tell = |line: &str| {
        if !arguments.quiet {
            console::message(line)
        }
    };
    tell(&opening_line(&first.header.scene, &shares, target_error));
    for warning in &scene.warnings {
        console::message(&format!("warning: {warning}"));
    }
    let records: Vec<ShareRecord> = shares.iter().map(|share| share.header.record.clone()).collect();
    let merging = || merge(&scene, &settings, &records, |index| shares[index].sums());
    let merged = meanwhile(|| "merging".to_owned(), started, arguments.quiet, || false, || pool.install(merging));
    let merged = match merged {
        Ok(merged) => merged,
        Err(error) => {
            directory.withdraw();
            return Err(error.into());
        }
    };
    let merging = Merging {
        scene: &scene,
        target_error,
        shares: &shares,
        plots: arguments.plots,
        language: arguments.language,
        read_s,
        started,
        threads: pool.current_num_threads(),
    };
    let Merged { solution, .. } = merging.write(merged, directory)?;
    let compute_s = records.iter().map(|record| record.compute_s).sum();

    tell_results(&scene, &solution, arguments.language, tell)?;
    for note in &solution.notes {
        tell(&format!("note: {note}"));
    }
    tell(&closing_lines(&solution, &arguments.out.display().to_string(), compute_s));
    Ok(exit_of(&solution))
}

/// The data of a merge besides its solution.
pub struct Merging<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// The target error as a fraction, if the merged maps are judged against one.
    pub target_error: Option<f64>,
    /// All shares, in order.
    pub shares: &'a [ShareFile],
    /// Formats of plots; `None`: SVG.
    pub plots: Option<Plots>,
    /// Language of pages and plots.
    pub language: Language,
    /// Seconds that reading the scene took.
    pub read_s: f64,
    /// Start of the process.
    pub started: Instant,
    /// Worker threads.
    pub threads: usize,
}

impl Merging<'_> {
    /// Adds the warnings and notes on the shares to the solution, and writes all files.
    ///
    /// # Errors
    ///
    /// Files that cannot be written.
    pub fn write(&self, merged: Merged, mut directory: ResultDirectory) -> Result<Merged, Failure> {
        let Merged { mut solution, more } = merged;
        let (scene, shares) = (self.scene, self.shares);
        solution.warnings.extend(interrupted_line(shares));
        solution.notes.extend(more.map(|more| words_on_more(&more, shares, self.target_error.unwrap_or(0.0))));
        let compute_s = shares.iter().map(|share| share.header.record.compute_s).sum();
        let write_started = Instant::now();
        let context = ReportContext {
            scene: shares[0].header.scene.clone(),
            command: commands_again(shares),
            repeats_digits: shares.iter().all(|share| share.header.stop_reason == StopReason::Chains.name()),
            unix_time_s: SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |since| since.as_secs()),
            wall_s: compute_s,
            threads: shares.iter().map(|share| share.header.threads).max().unwrap_or(1),
            language: self.language,
        };
        stage_results(scene, &solution, &context, self.plots, &mut directory)?;
        let record = RunRecord {
            scene: context.scene,
            read_s: self.read_s,
            write_s: write_started.elapsed().as_secs_f64(),
            wall_s: self.started.elapsed().as_secs_f64(),
            threads: self.threads,
            peak_memory_bytes: peak_bytes(),
            position_accuracy_m: position_accuracy_m(scene),
            files: directory.names(),
            part: PartOfRun::Merged {
                shares: whole_shares(shares),
                receivers_parts: parts_of(shares),
                compute_s,
                more,
            },
        };
        directory.stage(&summary_file(scene, &solution, &record))?;
        directory.commit()?;
        Ok(Merged { solution, more })
    }
}

/// Reads the headers of all shares and sorts the shares by number.
fn read_shares(directories: &[PathBuf]) -> Result<Vec<ShareFile>, SealedError> {
    let mut shares = directories.iter().map(|directory| read_share(directory)).collect::<Result<Vec<_>, _>>()?;
    shares.sort_by_key(number_of);
    check_twins(&shares)?;
    let first = &shares[0];
    for share in &shares[1..] {
        check_alike(first, share)?;
    }
    check_numbers(&shares)?;
    Ok(shares)
}

/// Number of a share, and of its part of the receivers.
fn number_of(share: &ShareFile) -> (u32, u32) {
    (share.header.share.number, share.header.record.part.number)
}

/// The same with the number of parts. It differs between runs that divide the receivers differently.
fn portion_of(share: &ShareFile) -> (u32, ReceiversPart) {
    (share.header.share.number, share.header.record.part)
}

/// Number of parts into which the receivers of every share are divided.
fn parts_of(shares: &[ShareFile]) -> u32 {
    shares[0].header.record.part.of
}

/// Number of shares, each with all its parts.
fn whole_shares(shares: &[ShareFile]) -> usize {
    shares.len() / parts_of(shares) as usize
}

fn map_names(share: &ShareFile) -> impl Iterator<Item = String> {
    share.header.record.maps.iter().map(|map| map.name.clone())
}

/// Names a share by its number: `share 2`, `part 3 of the receivers`, or both.
fn words_on(share: &ShareFile) -> String {
    let (Share { number, of }, part) = (share.header.share, share.header.record.part);
    match () {
        _ if part.of == 1 => format!("share {number}"),
        _ if of == 1 => format!("part {} of the receivers", part.number),
        _ => format!("part {} of the receivers of share {number}", part.number),
    }
}

/// Refuses a share that is given twice, under its own number or another. It would count as two but give the information of one.
fn check_twins(shares: &[ShareFile]) -> Result<(), SealedError> {
    let mut by_sums: Vec<&ShareFile> = shares.iter().collect();
    by_sums.sort_by_key(|share| (&share.header.sums_sha256, number_of(share)));
    let in_order = shares.windows(2).map(|pair| (&pair[0], &pair[1]));
    let same_number = in_order.into_iter().find(|(one, other)| portion_of(one) == portion_of(other));
    // Shares that are exact have equal sums for a good reason.
    let same_sums = by_sums
        .windows(2)
        .map(|pair| (pair[0], pair[1]))
        .find(|(one, other)| one.header.sums_sha256 == other.header.sums_sha256 && !one.header.record.is_exact);
    let Some((one, other)) = same_number.or(same_sums) else { return Ok(()) };
    Err(SealedError {
        path: other.path.clone(),
        what: match portion_of(one) == portion_of(other) {
            true => format!("{} is given twice", words_on(one)),
            false => {
                format!("{} and {} are the same: their sums are equal to the last bit", words_on(one), words_on(other))
            }
        },
        got: format!("the other one in {}", one.path.display()),
        expected: "every share once, each with its own sums".to_owned(),
        remedy: "leave one of them out".to_owned(),
    })
}

/// Refuses shares that do not belong to one run.
fn check_alike(first: &ShareFile, other: &ShareFile) -> Result<(), SealedError> {
    let (ours, theirs) = (&first.header, &other.header);
    let names = [first, other].map(words_on);
    let differ = |what: &str, got: String, expected: String| SealedError {
        path: other.path.clone(),
        what: format!("{} and {} are {what}", names[0], names[1]),
        got,
        expected: format!("{expected}, as in {}", first.path.display()),
        remedy: "compute all shares with the same luxmc, scene, seed, method and choice of maps".to_owned(),
    };
    let digits =
        |header: &crate::output::ShareHeader| format!("{} (digest {:.16}…)", header.scene, header.scene_digest);
    let maps = |header: &crate::output::ShareHeader| {
        let map =
            |map: &crate::solver::MapOfShare| format!("{}{}", map.name, if map.bound { "" } else { " (unbound)" });
        header.record.maps.iter().map(map).collect::<Vec<_>>().join(", ")
    };
    if ours.luxmc != theirs.luxmc {
        return Err(differ("of different versions of luxmc", theirs.luxmc.clone(), ours.luxmc.clone()));
    }
    if ours.scene_digest != theirs.scene_digest {
        return Err(differ("of different scenes", digits(theirs), digits(ours)));
    }
    if ours.seed != theirs.seed {
        return Err(differ("of runs with different seeds", theirs.seed.to_string(), ours.seed.to_string()));
    }
    if ours.method != theirs.method {
        return Err(differ("by different methods", theirs.method.clone(), ours.method.clone()));
    }
    let parts = |header: &crate::output::ShareHeader| counted(header.record.part.of as usize, "part");
    if ours.record.part.of != theirs.record.part.of {
        return Err(differ("of runs that divide the receivers differently", parts(theirs), parts(ours)));
    }
    // A small set may have points in some parts only. Which parts must have it is known once the scene is read.
    let (mine, its) = (&ours.record.maps, &theirs.record.maps);
    if ours.record.part.of == 1 && !are_of_same_maps(mine, its) {
        return Err(differ("of different maps", maps(theirs), maps(ours)));
    }
    Ok(())
}

fn are_of_same_maps(mine: &[MapOfShare], its: &[MapOfShare]) -> bool {
    let entries = |maps: &[MapOfShare]| maps.iter().map(|map| map.entries).collect::<Vec<_>>();
    entries(mine) == entries(its) && mine.iter().zip(its).all(|(one, other)| one.is_of_same_map(other))
}

/// Refuses a set of shares with gaps.
fn check_numbers(shares: &[ShareFile]) -> Result<(), SealedError> {
    let all = shares.iter().map(|share| share.header.share.of).max().unwrap_or(0);
    let parts = u64::from(parts_of(shares));
    // The shares are sorted and distinct, so this is fast even if four thousand million of them are expected.
    let there = shares.iter().map(number_of).filter(|(number, _)| (1..=all).contains(number));
    let missing = (u64::from(all) * parts).saturating_sub(there.clone().count() as u64);
    if missing == 0 {
        return Ok(());
    }
    let place = |(number, part): (u32, u32)| u64::from(number - 1) * parts + u64::from(part) - 1;
    let first = there.zip(0..).take_while(|(number, at)| place(*number) == *at).count() as u64;
    let share = Share { number: (first / parts) as u32 + 1, of: all };
    let part = ReceiversPart { number: (first % parts) as u32 + 1, of: parts as u32 };
    let (by_share, by_part) = (all > 1 || parts == 1, parts > 1);
    let mut names = Vec::new();
    names.extend(by_share.then(|| format!("share {} of {all}", share.number)));
    names.extend(by_part.then(|| format!("part {} of {parts} of the receivers", part.number)));
    let more = if missing > 1 { format!(" and {} more are", missing - 1) } else { " is".to_owned() };
    let portion = Portion { share: by_share.then_some(share), part: by_part.then_some(part) };
    Err(SealedError {
        path: shares[0].path.clone(),
        what: format!("{}{more} missing", names.join(", ")),
        got: counted(shares.len(), if by_part { "part" } else { "share" }),
        expected: format!("all {}, the number that one of them states", u64::from(all) * parts),
        remedy: format!("compute it: {}{} --out DIR", shares[0].header.command, options_of(portion)),
    })
}

/// The target that the merged maps are judged against: the requested one, or else that of the shares.
fn target_of(arguments: &MergeArguments, shares: &[ShareFile]) -> Result<Option<f64>, SealedError> {
    let first = shares[0].header.target_error;
    if arguments.target_error.is_some() {
        return Ok(arguments.target_error);
    }
    match shares.iter().find(|share| share.header.target_error != first) {
        None => Ok(first),
        Some(other) => {
            let words = |target: Option<f64>| target.map_or("no target".to_owned(), percent);
            Err(SealedError {
                path: other.path.clone(),
                what: "the shares have different targets".to_owned(),
                got: words(other.header.target_error),
                expected: format!("{}, as in {}", words(first), shares[0].path.display()),
                remedy: "choose one with --target-error".to_owned(),
            })
        }
    }
}

/// Refuses to write into the directory of a share, since its files would be removed.
fn check_out(arguments: &MergeArguments) -> Result<(), Failure> {
    let place = |path: &Path| path.canonicalize().ok();
    let out = place(&arguments.out);
    let is_share = out.is_some() && arguments.shares.iter().any(|share| place(share) == out);
    if !is_share {
        return Ok(());
    }
    Err(Failure::Usage {
        what: "the merged results would overwrite a share".to_owned(),
        got: format!("--out {}", arguments.out.display()),
        expected: "a directory that is not a share".to_owned(),
        remedy: "name another directory".to_owned(),
    })
}

/// Refuses a scene other than the computed one.
fn check_scene(scene: &Scene, path: &Path, shares: &[ShareFile]) -> Result<(), SealedError> {
    let (share, digest) = (&shares[0], scene.digest());
    let header = &share.header;
    let elements = Elements::of(scene).len();
    let entries = |kind: MapKind, part: ReceiversPart| match kind {
        MapKind::Elements => {
            if part.of == 1 {
                elements
            } else {
                0
            }
        }
        MapKind::Receivers(set) => scene.receivers.get(set).map_or(0, |receivers| part.points_of(receivers, set)),
    };
    let fits = |share: &ShareFile| {
        let record = &share.header.record;
        record.maps.iter().all(|map| entries(map.kind, record.part) == map.entries)
    };
    if digest == header.scene_digest && shares.iter().all(fits) {
        return check_parts(shares, |kind, part| entries(kind, part) > 0);
    }
    Err(SealedError {
        path: path.to_path_buf(),
        what: "the scene is not the one that the shares computed, or it has changed since".to_owned(),
        got: format!("digest {digest:.16}…"),
        expected: format!("digest {:.16}…, as in {}", header.scene_digest, share.path.display()),
        remedy: "restore the scene as it was, name it with --scene, or compute the shares again".to_owned(),
    })
}

/// Refuses parts of the receivers with different maps. Each part must have the maps of which it has points.
fn check_parts(shares: &[ShareFile], has: impl Fn(MapKind, ReceiversPart) -> bool) -> Result<(), SealedError> {
    let mut all: Vec<&MapOfShare> = Vec::new();
    for map in shares.iter().flat_map(|share| &share.header.record.maps) {
        if !all.iter().any(|known| known.kind == map.kind) {
            all.push(map);
        }
    }
    for share in shares {
        let record = &share.header.record;
        let lacks = |map: &&&MapOfShare| match record.map(map.kind) {
            Some(own) => !own.is_of_same_map(map),
            None => has(map.kind, record.part),
        };
        if let Some(map) = all.iter().find(lacks) {
            return Err(SealedError {
                path: share.path.clone(),
                what: format!("{} has different maps from the others", words_on(share)),
                got: map_names(share).collect::<Vec<_>>().join(", "),
                expected: format!("\"{}\" as well", map.name),
                remedy: "compute all parts with the same choice of maps".to_owned(),
            });
        }
    }
    Ok(())
}

fn method_of(share: &ShareFile) -> Result<Method, SealedError> {
    let name = &share.header.method;
    Method::ALL.into_iter().find(|method| method.name() == name).ok_or_else(|| SealedError {
        path: share.path.clone(),
        what: "the share was computed by a method that cannot be merged".to_owned(),
        got: name.clone(),
        expected: Method::ALL.map(Method::name).join(", "),
        remedy: "compute the shares again with one of those".to_owned(),
    })
}

fn opening_line(scene: &str, shares: &[ShareFile], target_error: Option<f64>) -> String {
    let target = target_error.map_or(String::new(), |target| format!(", target {}", percent(target)));
    let what = words_on_all(shares);
    format!("luxmc {}: {scene}: {what} to merge{target}", env!("CARGO_PKG_VERSION"))
}

/// Words for the number of shares and of their parts.
fn words_on_all(shares: &[ShareFile]) -> String {
    let (whole, parts) = (whole_shares(shares), parts_of(shares));
    match (whole, parts) {
        (_, 1) => counted(whole, "share"),
        (1, _) => format!("{parts} parts of the receivers"),
        _ => format!("{whole} shares of {parts} parts of the receivers each"),
    }
}

/// The warning that names interrupted shares. The work that they had done still counts.
fn interrupted_line(shares: &[ShareFile]) -> Option<String> {
    let cut: Vec<String> = shares
        .iter()
        .filter(|share| share.header.stop_reason == StopReason::Interrupted.name())
        .map(words_on)
        .collect();
    let were = if cut.len() == 1 { "was" } else { "were" };
    (!cut.is_empty()).then(|| {
        format!(
            "{} {were} interrupted before all requested work was done: compute again what must be complete",
            cut.join(", ")
        )
    })
}

/// The commands that reproduce the merged result.
fn commands_again(shares: &[ShareFile]) -> String {
    let (count, parts, command) = (whole_shares(shares), parts_of(shares), &shares[0].header.command);
    let (options, directory, each) = match (count, parts) {
        (_, 1) => (format!("--share k/{count}"), "k", format!("each k from 1 to {count}")),
        (1, _) => (format!("--receivers-part p/{parts}"), "p", format!("each p from 1 to {parts}")),
        _ => (
            format!("--share k/{count} --receivers-part p/{parts}"),
            "k-p",
            format!("each k from 1 to {count} and p from 1 to {parts}"),
        ),
    };
    format!("{command} {options} --out {SHARES_IN}/{directory}    for {each}\nluxmc merge {SHARES_IN}/* --out out")
}

/// Directory in which the commands of a report put the shares.
const SHARES_IN: &str = "shares";

/// Words on how many shares the target still needs.
fn words_on_more(more: &MoreShares, shares: &[ShareFile], target_error: f64) -> String {
    let target = percent(target_error);
    let with_parts = match parts_of(shares) {
        1 => String::new(),
        parts => format!(", each with all {parts} parts of the receivers"),
    };
    match more {
        MoreShares::None => format!("{} meet the target of {target}", words_on_all(shares)),
        MoreShares::About(Forecast { expected, low, high }) => {
            let count = |number: &f64| format!("{number:.0}");
            let interval = if low < high { format!(" ({} to {})", count(low), count(high)) } else { String::new() };
            let is_one = *expected == 1.0;
            format!(
                "about {} more {}{interval} of the same size would meet the target of {target}: give {} the next {}{with_parts}, and merge all",
                count(expected),
                if is_one { "share" } else { "shares" },
                if is_one { "it" } else { "them" },
                if is_one { "number" } else { "numbers" }
            )
        }
        MoreShares::NoNumber => format!(
            "no number of shares of this size is known to meet the target of {target}: the part of their error that \
             is not random is above it, or no light was found; give each more chains, or compute all by --method \
             collision"
        ),
    }
}
