//! Runs the built program in a temporary directory.
#![allow(dead_code)]

use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

/// A program that runs longer than this hangs. No run here takes nearly as long on a busy machine.
const HANGS_AFTER: Duration = Duration::from_secs(180);

/// Path of a scene for these tests.
pub fn scene(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/cli").join(name)
}

/// The program with these arguments.
pub fn luxmc(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_luxmc"));
    command.args(arguments);
    command
}

/// Runs the program to its end.
pub fn run(arguments: &[&str]) -> Output {
    luxmc(arguments).output().expect("the program starts")
}

/// Starts a program, keeps its output and calls `while_it_runs` with its process id. A program that hangs is ended and fails the test.
pub fn run_or_hang(mut command: Command, while_it_runs: impl FnOnce(u32)) -> Output {
    let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("the program starts");
    while_it_runs(child.id());
    let started = Instant::now();
    while child.try_wait().expect("a child").is_none() {
        if started.elapsed() > HANGS_AFTER {
            child.kill().expect("it can be ended");
            panic!("the program has not ended: {command:?}");
        }
        std::thread::sleep(Duration::from_millis(10));
    }
    child.wait_with_output().expect("it ended")
}

/// Interrupts a program like Ctrl-C.
#[cfg(unix)]
pub fn interrupt(id: u32) {
    signal(id, "-INT");
}

/// Sends a signal to a program.
#[cfg(unix)]
pub fn signal(id: u32, signal: &str) {
    let sent = Command::new("kill").args([signal, id.to_string().as_str()]).status();
    assert!(sent.is_ok_and(|status| status.success()));
}

/// Temporary directory of a test. It is deleted with this value.
pub struct Home(tempfile::TempDir);

impl Home {
    pub fn new() -> Home {
        Home(tempfile::tempdir().expect("a temporary directory"))
    }

    /// Path of a name in the directory.
    pub fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }
}

/// Runs `solve` on a scene of these tests.
pub fn solve(scene_name: &str, out: &Path, more: &[&str]) -> Output {
    solve_file(&scene(scene_name), out, more)
}

/// Runs `solve` on a scene file.
pub fn solve_file(scene: &Path, out: &Path, more: &[&str]) -> Output {
    let mut arguments = vec!["solve", text(scene), "--out", text(out)];
    arguments.extend(more);
    run(&arguments)
}

/// Exit code.
pub fn code(output: &Output) -> i32 {
    output.status.code().expect("the program ended by itself")
}

/// Standard error as text.
pub fn errors(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// Standard output as text.
pub fn results(output: &Output) -> String {
    String::from_utf8(output.stdout.clone()).expect("the standard output is UTF-8")
}

/// A path as an argument.
pub fn text(path: &Path) -> &str {
    path.to_str().expect("test paths are UTF-8")
}

/// Names in a directory, sorted.
pub fn listing(path: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(path).expect("the directory is there");
    let mut names: Vec<String> =
        entries.map(|entry| entry.expect("readable").file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

/// A CSV file: header and rows.
pub fn table(path: &Path) -> (Vec<String>, Vec<Vec<String>>) {
    let mut reader = csv::Reader::from_path(path).expect("the file is there");
    let header = reader.headers().expect("a header").iter().map(str::to_owned).collect();
    let rows = reader.records().map(|row| row.expect("a row").iter().map(str::to_owned).collect()).collect();
    (header, rows)
}

/// The summary of a run.
pub fn summary(out: &Path) -> serde_json::Value {
    let text = std::fs::read_to_string(out.join("summary.json")).expect("the summary is there");
    serde_json::from_str(&text).expect("the summary is JSON")
}

/// Tables that contain no times.
const TABLES: [&str; 3] = ["elements.csv", "receivers.csv", "tables.csv"];
/// Keys of the summary that contain times, the memory or the number of threads.
const TIMES: [&str; 7] = ["read_s", "build_s", "compute_s", "write_s", "wall_s", "peak_memory_bytes", "threads"];

impl Home {
    /// All results of a run without times: tables, history and summary.
    pub fn told(&self, out: &str) -> Vec<String> {
        let read = |name: &str| std::fs::read_to_string(self.path(out).join(name));
        let mut all: Vec<String> = TABLES.iter().filter_map(|name| read(name).ok()).collect();
        let (header, rows) = table(&self.path(out).join("convergence.csv"));
        let is_time: Vec<bool> = header.iter().map(|name| name.contains("wall")).collect();
        let without = |row: &Vec<String>| {
            row.iter().zip(&is_time).filter(|(_, time)| !**time).map(|(cell, _)| cell.clone()).collect()
        };
        all.extend(rows.iter().map(without).map(|row: Vec<String>| row.join(",")));
        let mut summary = summary(&self.path(out));
        let keys = summary.as_object_mut().expect("an object");
        keys.retain(|key, _| !TIMES.contains(&key.as_str()));
        let spent = keys["spent"].as_object_mut().expect("an object");
        spent.values_mut().for_each(|of| drop(of.as_object_mut().expect("an object").remove("seconds")));
        if let Some(merged) = keys["merged"].as_object_mut() {
            merged.remove("compute_s");
        }
        all.push(summary.to_string());
        all
    }
}
