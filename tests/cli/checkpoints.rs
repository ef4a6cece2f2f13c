//! `luxmc solve --checkpoint` and `luxmc resume` as their users see them.

use std::path::Path;
use std::process::{Child, Stdio};
use std::time::{Duration, Instant};

use serde_json::Value;
use sha2::{Digest, Sha256};

use crate::cli_support::*;

/// A program that has written no checkpoint after this time never will.
const HANGS_AFTER: Duration = Duration::from_secs(120);

impl Home {
    /// Solves the small room without checkpoints.
    fn solve(&self, out: &str, options: &[&str]) -> i32 {
        let output = solve("room.json", &self.path(out), &[options, &QUIET].concat());
        code(&output)
    }

    /// Starts a run that keeps checkpoints as often as possible.
    fn start(&self, out: &str, file: &str, options: &[&str]) -> Child {
        let (room, out, file) = (scene("room.json"), self.path(out), self.path(file));
        let mut arguments = vec!["solve", text(&room), "--out", text(&out), "--checkpoint", text(&file)];
        arguments.extend(["--checkpoint-every", "1ms"]);
        arguments.extend(options.iter().chain(&QUIET));
        luxmc(&arguments).stdout(Stdio::null()).stderr(Stdio::piped()).spawn().expect("the program starts")
    }

    /// Continues from a checkpoint to the end. Returns the exit code and standard error.
    fn resume(&self, file: &str, options: &[&str]) -> (i32, String) {
        let file = self.path(file);
        let mut arguments = vec!["resume", text(&file)];
        arguments.extend(options);
        let output = run(&arguments);
        (code(&output), errors(&output))
    }
}

const QUIET: [&str; 3] = ["--plots", "none", "--quiet"];

/// Digest of the state in a checkpoint, if there is a checkpoint.
fn state_of(file: &Path) -> Option<String> {
    let bytes = std::fs::read(file).ok()?;
    let header: Value = serde_json::from_slice(bytes.split(|byte| *byte == b'\n').nth(1)?).ok()?;
    Some(header["state_sha256"].as_str()?.to_owned())
}

/// Kills a program as soon as its checkpoint changes. Returns whether it was still running.
fn killed_at_the_next_checkpoint(mut child: Child, file: &Path) -> bool {
    let (before, started) = (state_of(file), Instant::now());
    while state_of(file) == before || state_of(file).is_none() {
        if child.try_wait().expect("a child").is_some() {
            return false;
        }
        assert!(started.elapsed() < HANGS_AFTER, "no checkpoint is written");
    }
    child.kill().expect("it can be ended");
    !child.wait().expect("it ended").success()
}

/// Kills a run again and again, and compares its final result with that of an uninterrupted run.
fn killed_runs_come_to_the_same(options: &[&str], least_kills: usize) {
    let home = Home::new();
    let exit = home.solve("whole", options);
    let file = home.path("run.ckpt");
    let mut kills = usize::from(killed_at_the_next_checkpoint(home.start("killed", "run.ckpt", options), &file));
    for _ in 1..2 * least_kills {
        let again = luxmc(&["resume", text(&file), "--quiet"]).stdout(Stdio::null()).spawn().expect("it starts");
        kills += usize::from(killed_at_the_next_checkpoint(again, &file));
    }
    assert!(kills >= least_kills, "{kills} kills: {options:?}");
    let (exit_again, told) = home.resume("run.ckpt", &["--quiet"]);
    assert_eq!((exit_again, exit), (0, 0), "{told}");
    assert!(home.told("killed") == home.told("whole"), "{options:?}: {:#?}", differences(&home));
    let other = [options, &["--seed", "1"]].concat();
    home.solve("other", &other);
    assert!(home.told("other") != home.told("whole"), "the comparison sees nothing");
}

fn differences(home: &Home) -> Vec<(String, String)> {
    let pairs = home.told("killed").into_iter().zip(home.told("whole"));
    let short = |text: String| text.chars().take(400).collect::<String>();
    pairs.filter(|(one, other)| one != other).map(|(one, other)| (short(one), short(other))).take(3).collect()
}

#[test]
fn walks_that_are_killed_go_on_to_the_same_bytes() {
    killed_runs_come_to_the_same(&["--method", "collision", "--target-error", "0.3%"], 3);
}

#[test]
fn gathering_that_is_killed_goes_on_to_the_same_bytes() {
    killed_runs_come_to_the_same(&["--method", "gather", "--target-error", "0.5%"], 3);
}

#[test]
fn fixed_chains_of_all_maps_that_are_killed_go_on_to_the_same_bytes() {
    killed_runs_come_to_the_same(&["--maps", "all", "--elements", "given", "--chains", "60000"], 3);
}

#[cfg(unix)]
#[test]
fn a_run_that_its_user_interrupts_goes_on_to_the_same_bytes() {
    let home = Home::new();
    let options = ["--maps", "work plane", "--target-error", "0.3%", "--method", "collision"];
    home.solve("whole", &options);
    let file = home.path("run.ckpt");
    let child = home.start("killed", "run.ckpt", &options);
    let started = Instant::now();
    while state_of(&file).is_none() {
        assert!(started.elapsed() < HANGS_AFTER, "no checkpoint is written");
    }
    interrupt(child.id());
    let output = child.wait_with_output().expect("it ends");
    assert_eq!(code(&output), 130, "{}", errors(&output));
    assert_eq!(summary(&home.path("killed"))["stop_reason"], "interrupted");
    let (exit, told) = home.resume("run.ckpt", &[]);
    assert!(exit == 0 && told.contains("resuming from") && told.contains("ended by interrupted"), "{exit} {told}");
    assert!(told.contains("--target-error … continues to a smaller error"), "{told}");
    assert!(home.told("killed") == home.told("whole"), "{:#?}", differences(&home));
}

#[test]
fn a_limit_ends_a_part_of_a_run_and_a_smaller_error_goes_on() {
    let home = Home::new();
    let options = ["--method", "collision", "--target-error", "0.3%"];
    home.solve("whole", &options);
    let file = home.path("run.ckpt");
    assert!(killed_at_the_next_checkpoint(home.start("killed", "run.ckpt", &options), &file));
    let (exit, told) = home.resume("run.ckpt", &["--time-limit", "1ms"]);
    assert!(exit == 3 && told.contains("resume") && told.contains("continues from there"), "{exit} {told}");
    assert_eq!(home.resume("run.ckpt", &["--quiet"]).0, 0);
    assert!(home.told("killed") == home.told("whole"), "{:#?}", differences(&home));
    // Once more, with no work left to do.
    assert_eq!(home.resume("run.ckpt", &["--quiet"]).0, 0);
    assert!(home.told("killed") == home.told("whole"), "{:#?}", differences(&home));

    let first = summary(&home.path("killed"));
    let (exit, told) = home.resume("run.ckpt", &["--target-error", "0.2%", "--out", text(&home.path("finer"))]);
    assert_eq!(exit, 0, "{told}");
    let finer = summary(&home.path("finer"));
    assert!(finer["target_met"] == true && finer["target_error"] == 0.002, "{finer}");
    assert!(finer["estimated_error"].as_f64() < Some(0.002), "{finer}");
    let [before, after] = [&first, &finer].map(|summary| summary["rays"].as_f64().expect("a number"));
    assert!(after > 1.1 * before && after < 6.0 * before, "{before} {after}");
}

#[test]
fn a_share_goes_on_to_the_same_sums() {
    let home = Home::new();
    let options = ["--share", "2/3", "--maps", "receivers", "--chains", "60000"];
    home.solve("whole", &options);
    assert!(killed_at_the_next_checkpoint(home.start("killed", "run.ckpt", &options), &home.path("run.ckpt")));
    assert_eq!(home.resume("run.ckpt", &["--quiet"]).0, 0);
    let digest = |out: &str| {
        let bytes = std::fs::read(home.path(out).join("share.luxmc")).expect("written");
        let header: Value =
            serde_json::from_slice(bytes.split(|byte| *byte == b'\n').nth(1).expect("a header")).expect("JSON");
        header["sums_sha256"].clone()
    };
    assert_eq!(digest("whole"), digest("killed"));
}

#[test]
fn damaged_foreign_and_changed_checkpoints_are_refused() {
    let home = Home::new();
    for name in ["room.json", "probes.csv"] {
        std::fs::copy(scene(name), home.path(name)).expect("copied");
    }
    let room = home.path("room.json");
    let file = home.path("run.ckpt");
    let kept = ["--checkpoint", text(&file), "--chains", "2000"];
    let output = solve_file(&room, &home.path("out"), &[&kept[..], &QUIET].concat());
    assert_eq!(code(&output), 0, "{}", errors(&output));
    let bytes = std::fs::read(&file).expect("written");
    let refused = |name: &str, bytes: &[u8], words: &[&str]| {
        std::fs::write(home.path(name), bytes).expect("written");
        let (exit, told) = home.resume(name, &["--out", text(&home.path("none"))]);
        assert_eq!(exit, 2, "{name}: {told}");
        assert!(words.iter().all(|word| told.contains(word)), "{name}: {told}");
        assert!(!home.path("none").exists(), "{name}: something was written");
    };
    for place in [1.0, 0.5, 0.9] {
        let mut flipped = bytes.clone();
        let header = bytes.iter().enumerate().filter(|(_, byte)| **byte == b'\n').nth(1).expect("two lines").0;
        let place = header + 1 + ((bytes.len() - header - 2) as f64 * place) as usize;
        flipped[place] ^= 4;
        refused("bit", &flipped, &["a state that does not match", "remedy"]);
    }
    refused("cut", &bytes[..bytes.len() - 1], &["a state that does not match"]);
    refused("longer", &[&bytes[..], b"x"].concat(), &["a state that does not match"]);
    refused("header", &bytes[..150], &["ends within its header"]);
    refused("empty", b"", &["ends within its header"]);
    refused("scene", &std::fs::read(&room).expect("there"), &["another beginning"]);
    refused("version", &[b"luxmc checkpoint 2", &bytes[18..]].concat(), &["another version of the format"]);
    let (exit, told) = home.resume("absent", &[]);
    assert!(exit == 2 && told.contains("cannot be read"), "{told}");

    // A checkpoint of another version of the program, with a valid digest.
    let lines: Vec<&[u8]> = bytes.splitn(3, |byte| *byte == b'\n').collect();
    let own = format!("\"luxmc\":\"{}\"", env!("CARGO_PKG_VERSION"));
    let header = String::from_utf8(lines[1].to_vec()).expect("UTF-8").replace(&own, "\"luxmc\":\"0.0.1\"");
    let digest: String = Sha256::digest(&header).iter().map(|byte| format!("{byte:02x}")).collect();
    let other = [format!("luxmc checkpoint 1 {digest}\n{header}\n").as_bytes(), lines[2]].concat();
    refused("program", &other, &["another version of luxmc", "0.0.1"]);

    // The scene with a number changed by 10⁻¹⁰, and then restored.
    let text_of_room = std::fs::read_to_string(&room).expect("there");
    std::fs::write(&room, text_of_room.replace("\"reflectance\": 0.25", "\"reflectance\": 0.2500000001"))
        .expect("written");
    refused("changed", &bytes, &["has changed since", "digest"]);
    std::fs::write(&room, text_of_room).expect("written");
    assert_eq!(home.resume("run.ckpt", &["--quiet"]).0, 0);
}

#[test]
fn a_checkpoint_that_cannot_be_written_any_more_is_reported_and_the_run_goes_on() {
    let home = Home::new();
    let folder = home.path("folder");
    std::fs::create_dir(&folder).expect("made");
    let child = home.start("out", "folder/run.ckpt", &["--method", "collision", "--target-error", "0.3%"]);
    let started = Instant::now();
    while state_of(&folder.join("run.ckpt")).is_none() {
        assert!(started.elapsed() < HANGS_AFTER, "no checkpoint is written");
    }
    std::fs::rename(&folder, home.path("elsewhere")).expect("moved");
    let output = child.wait_with_output().expect("it ends");
    assert_eq!(code(&output), 0, "{}", errors(&output));
    assert_eq!(errors(&output).matches("cannot be written").count(), 1, "{}", errors(&output));
    assert_eq!(summary(&home.path("out"))["target_met"], true);
    // A run whose files were moved continues from where they are now.
    assert_eq!(home.resume("elsewhere/run.ckpt", &["--quiet"]).0, 0);
}

#[test]
fn what_cannot_be_kept_is_refused_before_the_run() {
    let home = Home::new();
    let refused = |options: &[&str], words: &[&str]| {
        let output = solve("room.json", &home.path("none"), options);
        assert_eq!(code(&output), 2, "{options:?}: {}", errors(&output));
        assert!(words.iter().all(|word| errors(&output).contains(word)), "{options:?}: {}", errors(&output));
        assert!(!home.path("none").exists(), "{options:?}");
    };
    let file = home.path("run.ckpt");
    refused(&["--checkpoint", text(&file), "--method", "light-mesh"], &["keeps no checkpoints", "collision"]);
    refused(&["--checkpoint-every", "10s"], &["--checkpoint"]);
    refused(&["--checkpoint", text(&home.path("absent/run.ckpt"))], &["cannot be written", "directory"]);
    refused(&["--checkpoint", text(&home.path(""))], &["is a directory"]);
    std::fs::write(home.path("notes.txt"), "mine").expect("written");
    refused(&["--checkpoint", text(&home.path("notes.txt"))], &["exists and is not a checkpoint"]);
    // A run that is not done is not overwritten by mistake. A run that is done is overwritten.
    let options = ["--method", "collision", "--target-error", "0.3%"];
    assert!(killed_at_the_next_checkpoint(home.start("killed", "run.ckpt", &options), &file));
    refused(&["--checkpoint", text(&file), "--chains", "1000"], &["unfinished run", "luxmc resume"]);
    let done = home.path("done.ckpt");
    for _ in 0..2 {
        let output =
            solve("room.json", &home.path("out"), &["--checkpoint", text(&done), "--chains", "1000", "--quiet"]);
        assert_eq!(code(&output), 0, "{}", errors(&output));
    }
}
