//! `mpirun -n P luxmc solve …`: one run over many processes. In each round every rank computes a share. Rank 0 then merges all
//! shares so far, judges the target once, writes the results so far, and sets the size of the next round.
//!
//! A round is counted in chains and not in seconds, so that the same scene, seed and number of ranks give the same bytes. If a rank
//! is lost, only its share of the current round is lost.

use std::path::Path;
use std::time::{Duration, Instant};

use mpi::Threading;
use mpi::collective::SystemOperation;
use mpi::topology::SimpleCommunicator;
use mpi::traits::{Communicator, CommunicatorCollectives, Destination, MatchedReceiveVec, Source};

use super::exit::{Exit, Failure};
use super::merge::Merging;
use super::number_text::{count, percent, time};
use super::progress::{Watcher, heed_interruptions, is_interrupted};
use super::results::{closing_lines, counted, exit_of, tell_results};
use super::run::SceneRun;
use super::solve::opening_line;
use super::solve_arguments::{SolveArguments, command_without_output, options};
use super::{Outcome, console, share};
use crate::check::{read_scene, skip_checks};
use crate::output::{OutputError, ResultDirectory, SHARE_FILE, ShareFile, ShareHeader, read_share, share_file};
use crate::scene::allow_large_files;
use crate::solver::{
    DEFAULT_TARGET_ERROR, ElementChoice, MapSelection, Merged, MoreShares, Portion, Settings, Share, Solution,
    StopReason, map_requests, merge,
};

/// Chains of every rank in the first round: at most about a second of work.
const FIRST_CHAINS: u64 = 200_000;
/// Largest and smallest work of a round, as multiples of the work of all rounds before it.
const MOST_GROWTH: f64 = 3.0;
const LEAST_GROWTH: f64 = 0.1;
/// Factor on the forecast work, since a round that falls short costs another round.
const BEYOND_FORECAST: f64 = 1.05;
/// Time between two checks for a message.
const BETWEEN_LOOKS: Duration = Duration::from_millis(2);
/// A silent rank counts as lost after this many seconds, or after this multiple of the time that the round took the leader,
/// whichever is longer.
const LOST_AFTER_S: f64 = 60.0;
const LOST_AFTER_ROUNDS: f64 = 3.0;
/// Seconds of waiting for shares that an interruption cut short. Schedulers soon end a process that does not end by itself.
const GRACE_S: f64 = 0.5;
/// Largest number of bytes of a message: MPI counts them in 32 bits.
const MESSAGE: usize = 1 << 30;

/// Environment variables by which a process recognises that it runs under MPI.
const SIGNS: [&str; 4] = ["OMPI_COMM_WORLD_SIZE", "PMIX_RANK", "PMI_SIZE", "MPI_LOCALNRANKS"];

/// Solves a scene over all ranks; `None` if there is only one.
pub fn run(arguments: &SolveArguments, started: Instant) -> Option<Outcome> {
    if !SIGNS.iter().any(|name| std::env::var_os(name).is_some()) {
        return None;
    }
    let (universe, _) = mpi::initialize_with_threading(Threading::Funneled)?;
    let world = universe.world();
    if world.size() == 1 {
        return None;
    }
    heed_interruptions();
    Some(solve(&world, arguments, started))
}

fn solve(world: &SimpleCommunicator, arguments: &SolveArguments, started: Instant) -> Outcome {
    let ready = readied(world, arguments);
    // Either all ranks begin or none: a rank that cannot begin says so, and the others end with it.
    let (own, mut worst) = (i32::from(ready.is_err()), 0);
    world.all_reduce_into(&own, &mut worst, SystemOperation::max());
    let run = match ready {
        Ok(run) if worst == 0 => run,
        Ok(_) => return Ok(Exit::Refused),
        // Rank 0 alone reports an error that all ranks share.
        Err(failure) if world.rank() == 0 => return Err(failure),
        Err(failure) => {
            console::message(&format!("luxmc: rank {}: {failure}", world.rank()));
            return Ok(Exit::Refused);
        }
    };
    let rank = Rank { world, arguments, run: &run, started, read_s: started.elapsed().as_secs_f64() };
    let outcome = if world.rank() == 0 { rank.lead() } else { rank.follow() };
    // The other ranks would wait for this one, so all are aborted. Written results stay.
    outcome.inspect_err(|failure| {
        console::message(&format!("luxmc: error: rank {}: {failure}", world.rank()));
        world.abort(i32::from(failure.exit().number()));
    })
}

/// Reads the scene, and refuses options that cannot be combined with rounds.
fn readied(world: &SimpleCommunicator, arguments: &SolveArguments) -> Result<SceneRun, Failure> {
    let beside = [
        ("--share", arguments.share.is_some()),
        ("--receivers-part", arguments.receivers_part.is_some()),
        ("--checkpoint", arguments.checkpoint.is_some()),
        ("--dry-run", arguments.dry_run),
        ("--target", arguments.target.is_some()),
    ];
    if let Some((option, _)) = beside.into_iter().find(|(_, is_given)| *is_given) {
        return Err(Failure::Usage {
            what: "ranks divide the work themselves, and write the merged results after every round".to_owned(),
            got: format!("{option} in {} ranks of MPI", world.size()),
            expected: "--target-error, --chains or --time-limit".to_owned(),
            remedy: format!("leave out {option}, or run without mpirun"),
        });
    }
    super::memory::limit_memory(arguments.memory_limit);
    if arguments.allow_large {
        allow_large_files();
    }
    skip_checks(&arguments.skip_check);
    let scene = read_scene(&arguments.scene)?;
    let run = SceneRun::new(scene, &arguments.scene.display().to_string(), options(arguments)?)?;
    let of_a_round = Settings { chains: Some(FIRST_CHAINS), ..run.settings().clone() };
    share::check(Portion::from(Share::WHOLE), run.scene(), &of_a_round, arguments.method)?;
    Ok(run)
}

/// A process of the run.
struct Rank<'a> {
    world: &'a SimpleCommunicator,
    arguments: &'a SolveArguments,
    run: &'a SceneRun,
    started: Instant,
    read_s: f64,
}

impl Rank<'_> {
    fn number(&self) -> u32 {
        self.world.rank() as u32
    }

    fn ranks(&self) -> u32 {
        self.world.size() as u32
    }

    /// The bytes of this rank's share file for a round.
    fn share(&self, round: u32, chains: u64, watcher: &Watcher) -> Result<Vec<u8>, OutputError> {
        let share = Share { number: round * self.ranks() + self.number() + 1, of: (round + 1) * self.ranks() };
        let settings = Settings { chains: Some(chains), ..self.run.settings().clone() };
        let (solution, record, sums) = self.run.solve_share_by(&settings, share.into(), watcher);
        let digest = self.run.scene_digest();
        let header = share::header(digest, &self.arguments.scene, &settings, &solution, share.into(), record);
        let command = command_without_output(self.arguments, &solution);
        let header = ShareHeader { command, threads: self.run.threads(), ..header };
        Ok(share_file(header, &sums).made()?.bytes)
    }

    /// Computes shares on the orders of rank 0.
    fn follow(&self) -> Outcome {
        let watcher = Watcher::new(self.started, true, None);
        let leader = self.world.process_at_rank(0);
        loop {
            let Some(message) = leader.immediate_matched_probe() else {
                std::thread::sleep(BETWEEN_LOOKS);
                continue;
            };
            let (order, _) = message.matched_receive_vec::<u64>();
            let &[round, chains] = &order[..] else { return Ok(Exit::Done) };
            if chains == 0 {
                return Ok(Exit::Done);
            }
            let bytes = self.share(round as u32, chains, &watcher)?;
            leader.send(&(bytes.len() as u64).to_le_bytes()[..]);
            bytes.chunks(MESSAGE).for_each(|part| leader.send(part));
        }
    }

    /// Orders rounds, merges and judges.
    fn lead(&self) -> Outcome {
        let out = self.arguments.out.as_deref().unwrap_or(Path::new("."));
        let tell = |line: &str| {
            if !self.arguments.quiet {
                console::message(line)
            }
        };
        // The directory is proven writable before the work.
        drop(ResultDirectory::open(out)?);
        let opening = opening_line(self.arguments, self.run.scene(), self.run.settings(), self.run.threads());
        tell(&format!("{opening}; {}", counted(self.world.size() as usize, "rank")));
        for warning in &self.run.scene().warnings {
            console::message(&format!("warning: {warning}"));
        }
        let spool = spool()?;
        let mut others = self.all();
        let mut shares: Vec<ShareFile> = Vec::new();
        let (mut chains, mut chains_so_far) = (self.first_chains(), 0);
        let mut is_whole = true;
        for round in 0.. {
            for other in &others {
                self.world.process_at_rank(*other).send(&[u64::from(round), chains][..]);
            }
            let begun = Instant::now();
            let watcher = Watcher::new(self.started, self.arguments.quiet, None);
            let own = self.share(round, chains, &watcher);
            watcher.finish();
            let collected = self.collect(&others, own?, begun);
            for rank in &collected.lost {
                console::message(&format!("warning: rank {rank} is lost: the run continues without it"));
                others.retain(|other| other != rank);
                is_whole = false;
            }
            for (rank, bytes) in collected.files.into_iter().enumerate() {
                let directory = spool.path().join(format!("{round}-{rank}"));
                shares.extend(bytes.map(|bytes| kept(&directory, &bytes)).transpose()?);
            }
            let (solution, more) = self.merged(&shares, out)?;
            chains_so_far += chains;
            tell(&self.round_line(round, &shares, &solution));
            let next =
                if is_interrupted() { None } else { self.next_chains(&solution, more, shares.len(), chains_so_far) };
            match next {
                Some(next) => chains = next,
                None => {
                    // A scheduler may end the process at any moment, so the spool goes first.
                    drop(spool);
                    self.dismiss(&others);
                    // Rank 0 receives late messages, since their senders would wait for ever.
                    let left = self.collect(&collected.late, Vec::new(), Instant::now());
                    tell_results(self.run.scene(), &solution, self.arguments.language, tell)?;
                    solution.notes.iter().for_each(|note| tell(&format!("note: {note}")));
                    tell(&closing_lines(&solution, &out.display().to_string(), self.started.elapsed().as_secs_f64()));
                    let exit = if is_interrupted() { Exit::Interrupted } else { exit_of(&solution) };
                    if !is_whole || !left.late.is_empty() {
                        // Aborts instead of waiting for lost ranks.
                        self.world.abort(i32::from(exit.number()));
                    }
                    return Ok(exit);
                }
            }
        }
        Ok(Exit::Done)
    }

    fn all(&self) -> Vec<i32> {
        (1..self.world.size()).collect()
    }

    fn dismiss(&self, others: &[i32]) {
        others.iter().for_each(|other| self.world.process_at_rank(*other).send(&[0u64, 0][..]));
    }

    /// Waits for the shares of the other ranks; the rank's own share is there already.
    fn collect(&self, others: &[i32], own: Vec<u8>, begun: Instant) -> Collected {
        let own_s = begun.elapsed().as_secs_f64();
        let mut boxes: Vec<Inbox> = (0..self.world.size()).map(|_| Inbox::default()).collect();
        boxes[0] = Inbox { length: Some(own.len()), bytes: own };
        let mut interrupted: Option<Instant> = None;
        loop {
            let open = || others.iter().copied().filter(|other| !boxes[*other as usize].is_full());
            if open().next().is_none() {
                break;
            }
            let patience_s = LOST_AFTER_S.max(LOST_AFTER_ROUNDS * own_s);
            let waited_s = begun.elapsed().as_secs_f64() - own_s;
            if is_interrupted() {
                let since = *interrupted.get_or_insert_with(Instant::now);
                if since.elapsed().as_secs_f64() > GRACE_S {
                    break;
                }
            } else if waited_s > patience_s {
                break;
            }
            match self.world.any_process().immediate_matched_probe() {
                None => std::thread::sleep(BETWEEN_LOOKS),
                Some(message) => {
                    let (bytes, status) = message.matched_receive_vec::<u8>();
                    boxes[status.source_rank() as usize].take(bytes);
                }
            }
        }
        let late: Vec<i32> = others.iter().copied().filter(|other| !boxes[*other as usize].is_full()).collect();
        let lost = if is_interrupted() { Vec::new() } else { late.clone() };
        let full = |inbox: Inbox| (inbox.is_full() && !inbox.bytes.is_empty()).then_some(inbox.bytes);
        Collected { files: boxes.into_iter().map(full).collect(), lost, late }
    }

    /// Merges all shares so far and writes the results. Earlier results stay until the new ones are complete.
    fn merged(&self, shares: &[ShareFile], out: &Path) -> Result<(Solution, Option<MoreShares>), Failure> {
        let scene = self.run.scene();
        let maps = map_requests(scene, &self.run.settings().maps).into_iter();
        let settings = Settings {
            elements: ElementChoice::Given,
            target_error: self.target_error(),
            maps: MapSelection::Named(maps.map(|(kind, _)| kind.name(scene).to_owned()).collect()),
            chains: None,
            time_limit_s: None,
            ..self.run.settings().clone()
        };
        let records: Vec<_> = shares.iter().map(|share| share.header.record.clone()).collect();
        let merged = self.run.on_its_threads(|| merge(scene, &settings, &records, |index| shares[index].sums()))?;
        let more = merged.more;
        let merging = Merging {
            scene,
            target_error: settings.target_error,
            shares,
            plots: self.arguments.plots,
            language: self.arguments.language,
            read_s: self.read_s,
            started: self.started,
            threads: self.run.threads(),
        };
        let Merged { solution, .. } = merging.write(merged, ResultDirectory::open(out)?)?;
        Ok((solution, more))
    }

    /// The target error, if it is requested or if nothing else ends the run.
    fn target_error(&self) -> Option<f64> {
        let settings = self.run.settings();
        let without_rule = settings.chains.is_none() && settings.time_limit_s.is_none();
        settings.target_error.or(without_rule.then_some(DEFAULT_TARGET_ERROR))
    }

    fn first_chains(&self) -> u64 {
        let all = self.run.settings().chains;
        all.map_or(FIRST_CHAINS, |chains| chains.div_ceil(u64::from(self.ranks())))
    }

    /// Chains of every rank in the next round; `None` if the run ends.
    fn next_chains(&self, solution: &Solution, more: Option<MoreShares>, shares: usize, so_far: u64) -> Option<u64> {
        let settings = self.run.settings();
        let is_late = settings.time_limit_s.is_some_and(|limit_s| self.started.elapsed().as_secs_f64() >= limit_s);
        let is_done = solution.target_met == Some(true) || solution.stop_reason == StopReason::Exact;
        if settings.chains.is_some() || is_late || is_done {
            return None;
        }
        let growth = match more {
            Some(MoreShares::About(more)) => {
                (BEYOND_FORECAST * (1.0 + more.expected / shares as f64) - 1.0).clamp(LEAST_GROWTH, MOST_GROWTH)
            }
            // Without a forecast the work doubles: a larger share has less systematic error. Only a limit ends such a run.
            _ => 1.0,
        };
        Some((growth * so_far as f64).ceil() as u64)
    }

    fn round_line(&self, round: u32, shares: &[ShareFile], solution: &Solution) -> String {
        format!(
            "{:>8}: round {}: {} merged, {} rays, error {}",
            time(self.started.elapsed().as_secs_f64()),
            round + 1,
            counted(shares.len(), "share"),
            count(solution.rays as f64),
            percent(solution.estimated_error)
        )
    }
}

/// The result of a round.
struct Collected {
    /// Shares that have arrived, by rank.
    files: Vec<Option<Vec<u8>>>,
    /// Ranks that count as lost, and all ranks that have not sent.
    lost: Vec<i32>,
    late: Vec<i32>,
}

/// The part of another rank's share that has arrived.
#[derive(Default)]
struct Inbox {
    length: Option<usize>,
    bytes: Vec<u8>,
}

impl Inbox {
    fn is_full(&self) -> bool {
        self.length.is_some_and(|length| self.bytes.len() >= length)
    }

    fn take(&mut self, part: Vec<u8>) {
        match (self.length, <[u8; 8]>::try_from(part.as_slice())) {
            (None, Ok(length)) => self.length = Some(u64::from_le_bytes(length) as usize),
            _ => self.bytes.extend(part),
        }
    }
}

/// Makes a temporary directory for shares, which lasts until the run ends.
fn spool() -> Result<tempfile::TempDir, Failure> {
    let directory = tempfile::Builder::new().prefix("luxmc-mpi-").tempdir();
    directory.map_err(|error| unspooled(&std::env::temp_dir(), &error))
}

fn kept(directory: &Path, bytes: &[u8]) -> Result<ShareFile, Failure> {
    let written = std::fs::create_dir(directory).and_then(|()| std::fs::write(directory.join(SHARE_FILE), bytes));
    written.map_err(|error| unspooled(directory, &error))?;
    Ok(read_share(directory)?)
}

fn unspooled(place: &Path, error: &std::io::Error) -> Failure {
    Failure::Usage {
        what: "the shares of the ranks cannot be stored".to_owned(),
        got: format!("{}: {error}", place.display()),
        expected: "a temporary folder with space for the share of every rank and round".to_owned(),
        remedy: "name another folder by TMPDIR, or free some space".to_owned(),
    }
}
