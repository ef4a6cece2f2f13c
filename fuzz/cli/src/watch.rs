//! Runs one execution under limits and checks its results.

use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use crate::numbers::{fault_of, word_in};

/// Address space of a run in KiB. Above it the system refuses memory. Threads and the program itself take some of it.
const ADDRESS_SPACE_KIB: u64 = 2 << 20;
/// Processor seconds after which a run is ended from outside.
const LONGEST_S: f64 = 20.0;
/// The same in wall seconds, for runs that wait without working. A busy machine does not slow a run down by that much.
const LONGEST_WAIT_S: f64 = 600.0;
/// A run may take this many times the minimum time that it stated beforehand.
const TOLD_TIMES: f64 = 1.5;
/// Seconds that inspecting a scene may take, which has no limit of its own.
const READING_S: f64 = 10.0;
/// Resident memory in KiB of the program itself and its threads, in addition to what it counts.
const PROGRAM_KIB: u64 = 64 << 10;

/// Limits of an execution.
pub struct Limits {
    /// Its `--time-limit`.
    pub time_limit_s: f64,
    /// Seconds allowed beyond 1.1 times the time limit: reading, the last slice, and writing.
    pub beyond_s: f64,
    /// Its `--memory-limit`, if any.
    pub memory_kib: Option<u64>,
    /// Whether it writes results.
    pub writes: bool,
}

/// How an execution ended.
pub struct Outcome {
    /// Its exit code in words.
    pub ended: String,
    /// The fault, if any.
    pub fault: Option<String>,
    /// Whether the time was the only fault.
    pub is_late: bool,
}

/// Runs the program in a folder.
pub fn run(luxmc: &Path, arguments: &[String], folder: &Path, limits: &Limits) -> Outcome {
    let out = folder.join("out");
    std::fs::remove_dir_all(&out).ok();
    let errors = folder.join("stderr.txt");
    let Ok(errors_file) = std::fs::File::create(&errors) else {
        return broken("the folder cannot be written");
    };
    let script = format!("ulimit -v {ADDRESS_SPACE_KIB}; exec \"$0\" \"$@\"");
    let mut command = Command::new("sh");
    command.arg("-c").arg(script).arg(luxmc).args(arguments).current_dir(folder);
    let (started, busy_before_s) = (Instant::now(), busy_s());
    let shown = folder.join("stdout.txt");
    let Ok(shown_file) = std::fs::File::create(&shown) else {
        return broken("the folder cannot be written");
    };
    let Ok(mut child) = command.stdin(Stdio::null()).stdout(shown_file).stderr(errors_file).spawn() else {
        return broken("it cannot be started");
    };
    let mut peak_kib = 0;
    let status = loop {
        peak_kib = peak_kib.max(peak_kib_of(child.id()).unwrap_or(0));
        match child.try_wait() {
            Ok(Some(status)) => break status,
            Ok(None) if is_endless(child.id(), started.elapsed().as_secs_f64()) => {
                child.kill().ok();
                child.wait().ok();
                let fault = Some(format!("no end within {LONGEST_S} s of the processor or {LONGEST_WAIT_S} s"));
                return Outcome { ended: "without end".to_owned(), fault, is_late: true };
            }
            Ok(None) => std::thread::sleep(Duration::from_millis(1)),
            Err(_) => return broken("it cannot be waited for"),
        }
    };
    // On a busy machine the wall time is no measure of the work. Where the system reports the processor time, that counts.
    let passed_s = started.elapsed().as_secs_f64();
    let took_s = busy_before_s.zip(busy_s()).map_or(passed_s, |(before, after)| after - before);
    let said = std::fs::read_to_string(&errors).unwrap_or_default();
    // A run has one limit for all its work, including reading and writing.
    let reading_s = if limits.writes { 0.0 } else { READING_S };
    let by_limit_s = 1.1 * limits.time_limit_s + limits.beyond_s;
    let is_late = took_s > by_limit_s.max(TOLD_TIMES * told_s(&said)) + reading_s;
    let fault = match status.code() {
        None => Some(format!("it was ended by a signal ({status})")),
        _ if said.contains("panicked at") => Some("it panicked".to_owned()),
        Some(code @ (0 | 2 | 3 | 4)) => left(&out, code, limits).or_else(|| {
            let shown = std::fs::read_to_string(&shown).unwrap_or_default();
            word_in(&shown).map(|word| format!("it shows {word}"))
        }),
        Some(code) => Some(format!("exit code {code}")),
    };
    let fault = fault.or_else(|| {
        let most_kib = limits.memory_kib? + PROGRAM_KIB;
        (peak_kib > most_kib).then(|| format!("it took {peak_kib} KiB of memory, of {most_kib}"))
    });
    let late = is_late.then(|| format!("it took {took_s:.2} s for a limit of {} s", limits.time_limit_s));
    let ended = status.code().map_or("by a signal".to_owned(), |code| format!("with exit code {code}"));
    Outcome { ended, is_late: fault.is_none() && late.is_some(), fault: fault.or(late) }
}

/// The minimum time in s that a run stated beforehand, whatever is computed; 0 if it stated none.
fn told_s(said: &str) -> f64 {
    let told = said.split_once(", whatever is computed").and_then(|(before, _)| {
        let seconds = before.strip_suffix(" more").unwrap_or(before).strip_suffix(" s")?;
        seconds.rsplit(' ').next()
    });
    told.and_then(|seconds| seconds.parse().ok()).unwrap_or(0.0)
}

/// The peak memory of a process so far, where the system reports it.
fn peak_kib_of(process: u32) -> Option<u64> {
    let status = std::fs::read_to_string(format!("/proc/{process}/status")).ok()?;
    status.split_once("VmHWM:")?.1.split_whitespace().next()?.parse().ok()
}

/// Whether a run that is still going has used up its time: the processor time where the system reports it.
fn is_endless(process: u32, passed_s: f64) -> bool {
    let longest_s = [LONGEST_S, LONGEST_WAIT_S];
    match times_s(&process.to_string()) {
        _ if passed_s <= longest_s[0] => false,
        Some(times_s) => times_s[0] > longest_s[0] || passed_s > longest_s[1],
        None => true,
    }
}

/// Processor seconds of all children so far.
fn busy_s() -> Option<f64> {
    Some(times_s("self")?[1])
}

/// Processor seconds of a process and of its children that have ended.
fn times_s(process: &str) -> Option<[f64; 2]> {
    const TICKS_PER_S: f64 = 100.0;
    let stat = std::fs::read_to_string(format!("/proc/{process}/stat")).ok()?;
    // After the name in brackets, user and system time of the process are the 12th and 13th numbers, followed by those of its children.
    let numbers: Vec<f64> =
        stat.rsplit_once(')')?.1.split_whitespace().skip(1).filter_map(|number| number.parse().ok()).collect();
    let [own, children] = [numbers.get(10..12)?, numbers.get(12..14)?].map(|pair| pair.iter().sum::<f64>());
    Some([own / TICKS_PER_S, children / TICKS_PER_S])
}

fn broken(why: &str) -> Outcome {
    Outcome { ended: "broken".to_owned(), fault: Some(why.to_owned()), is_late: false }
}

/// The fault in the files that a run has left.
fn left(out: &Path, code: i32, limits: &Limits) -> Option<String> {
    if !limits.writes {
        return None;
    }
    let is_whole = out.join("summary.json").is_file();
    match code {
        0 | 3 if !is_whole => return Some(format!("exit code {code} without summary.json")),
        2 if out.exists() => return Some("refused, and yet something was written".to_owned()),
        4 if is_whole => return Some("exit code 4, and yet there is a summary.json".to_owned()),
        _ => {}
    }
    let files = std::fs::read_dir(out).into_iter().flatten().flatten().map(|entry| entry.path());
    files.filter(|path| code != 4 && !path.is_dir()).find_map(|path| fault_of(&path))
}
