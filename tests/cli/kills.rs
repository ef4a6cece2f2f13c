//! Kills at random moments: a run that is started again gives the same bytes, and only the work since the last checkpoint is lost.
//!
//! `LUXMC_SLOW_TESTS=1` kills 60 times, 20 times each for runs with checkpoints, shares and merges. Otherwise there are 6 kills. Seeds
//! determine the moments.
#![cfg(unix)]

use std::path::Path;
use std::process::{Child, Stdio};
use std::time::{Duration, Instant};

use luxmc::sampling::random::{Purpose, Stream};
use serde_json::Value;

use crate::cli_support::*;

/// Kills of one run, after which it runs to its end.
const MOST_KILLS_OF_A_RUN: u32 = 4;

/// Draws the moments of the kills.
fn moments(seed: u64) -> Stream {
    Stream::new(seed, Purpose::Pilot, 0, 0)
}

fn kills_wanted() -> u32 {
    if std::env::var_os("LUXMC_SLOW_TESTS").is_some_and(|value| value == "1") { 20 } else { 2 }
}

fn start(arguments: &[&str]) -> Child {
    luxmc(arguments).stdout(Stdio::null()).stderr(Stdio::null()).spawn().expect("the program starts")
}

/// Kills a program after a time, unless it has ended. Returns whether it was killed.
fn killed_after(mut child: Child, seconds: f64) -> bool {
    let (begun, until) = (Instant::now(), Duration::from_secs_f64(seconds));
    while begun.elapsed() < until {
        if child.try_wait().expect("a child").is_some() {
            return false;
        }
        std::thread::sleep(Duration::from_micros(200));
    }
    child.kill().expect("it can be ended");
    child.wait().expect("it ended").code().is_none()
}

/// The header of a checkpoint or of another file for continuing.
fn header(path: &Path) -> Option<Value> {
    let bytes = std::fs::read(path).ok()?;
    Some(serde_json::from_slice(bytes.split(|byte| *byte == b'\n').nth(1)?).expect("a whole header"))
}

/// Rays in a checkpoint; 0 without one.
fn rays_kept(file: &Path) -> u64 {
    header(file).map_or(0, |header| header["rays"].as_u64().expect("a number"))
}

/// Seconds that a program takes.
fn seconds_of(arguments: &[&str]) -> f64 {
    let begun = Instant::now();
    let output = run(arguments);
    assert!(code(&output) == 0 || code(&output) == 3, "{}", errors(&output));
    begun.elapsed().as_secs_f64()
}

/// Runs a program to its end. It is killed some times and continues from its checkpoint each time. Returns the number of kills.
fn killed_to_the_end(moments: &mut Stream, solve: &[&str], file: &Path, run_s: f64) -> u32 {
    let resume = ["resume", text(file), "--quiet"];
    let mut kills = 0;
    while kills < MOST_KILLS_OF_A_RUN {
        let before = rays_kept(file);
        let child = start(if file.exists() { &resume } else { solve });
        if !killed_after(child, moments.unit() * run_s) {
            break;
        }
        kills += 1;
        // There is always a whole checkpoint, and its rays never decrease.
        assert!(rays_kept(file) >= before, "the work of an earlier checkpoint is lost");
    }
    let output = run(if file.exists() { &resume } else { solve });
    assert!(code(&output) == 0 || code(&output) == 3, "{}", errors(&output));
    kills
}

#[test]
fn runs_with_checkpoints_that_are_killed_at_random_moments_come_to_the_same_bytes() {
    let home = Home::new();
    let room = scene("room.json");
    let mut kills = 0;
    for seed in 0.. {
        let mut moments = moments(1000 + seed);
        let method = ["collision", "gather", "local", "auto"][seed as usize % 4];
        let [whole, killed, file] = ["whole", "killed", "ckpt"].map(|name| home.path(&format!("{seed}-{name}")));
        let seed = seed.to_string();
        let options = |out: &'static str| -> Vec<String> {
            let out = home.path(&format!("{seed}-{out}"));
            let options = ["--method", method, "--target-error", "0.2%", "--seed", &seed, "--plots", "none", "--quiet"];
            let all = ["solve", text(&room), "--out", text(&out)].into_iter().chain(options);
            all.map(str::to_owned).collect()
        };
        let (plain, kept) = (options("whole"), options("killed"));
        let plain: Vec<&str> = plain.iter().map(String::as_str).collect();
        let mut kept: Vec<&str> = kept.iter().map(String::as_str).collect();
        kept.extend(["--checkpoint", text(&file), "--checkpoint-every", "20ms"]);
        let run_s = seconds_of(&plain);
        kills += killed_to_the_end(&mut moments, &kept, &file, run_s);
        assert!(home.told(text(&killed)) == home.told(text(&whole)), "{method}, seed {seed}: other bytes");
        if kills >= kills_wanted() {
            break;
        }
    }
    println!("checkpoints: {kills} kills, the same bytes after each run");
}

#[test]
fn shares_and_parts_that_are_killed_at_random_moments_merge_to_the_same_bytes() {
    let home = Home::new();
    let room = scene("room.json");
    let mut kills = 0;
    for seed in 0.. {
        let mut moments = moments(2000 + seed);
        let by_parts = seed % 2 == 1;
        for name in ["whole", "killed"] {
            for number in 1..=2 {
                let [out, file] = [format!("{seed}/{name}/{number}"), format!("{seed}-{name}-{number}.ckpt")]
                    .map(|name| home.path(&name));
                let (portion, seed) = (format!("{number}/2"), seed.to_string());
                let mut arguments = vec!["solve", text(&room), "--out", text(&out), "--seed", &seed];
                arguments.extend(["--maps", "receivers", "--chains", "200000", "--plots", "none", "--quiet"]);
                arguments.extend([if by_parts { "--receivers-part" } else { "--share" }, &portion]);
                if name == "whole" {
                    seconds_of(&arguments);
                    continue;
                }
                let kept = ["--checkpoint", text(&file), "--checkpoint-every", "20ms"];
                let run_s =
                    summary(&home.path(&format!("{seed}/whole/{number}")))["wall_s"].as_f64().expect("a number");
                kills += killed_to_the_end(&mut moments, &[&arguments[..], &kept].concat(), &file, run_s);
            }
            let shares = [1, 2].map(|number| home.path(&format!("{seed}/{name}/{number}")));
            let out = home.path(&format!("{seed}/{name}/all"));
            seconds_of(&[
                "merge",
                text(&shares[0]),
                text(&shares[1]),
                "--out",
                text(&out),
                "--plots",
                "none",
                "--quiet",
            ]);
        }
        let [whole, killed] = ["whole", "killed"].map(|name| home.told(&format!("{seed}/{name}/all")));
        assert!(whole == killed, "seed {seed}: other bytes");
        if kills >= kills_wanted() {
            break;
        }
    }
    println!("shares and parts: {kills} kills, the same bytes after each merge");
}

#[test]
fn merges_that_are_killed_at_random_moments_leave_shares_and_whole_results() {
    let home = Home::new();
    let room = scene("room.json");
    let shares: Vec<String> = (1..=6)
        .map(|number| {
            let out = home.path(&format!("share-{number}"));
            let portion = format!("{number}/6");
            let options =
                ["--share", &portion, "--chains", "4000", "--target-error", "1%", "--plots", "none", "--quiet"];
            seconds_of(&[&["solve", text(&room), "--out", text(&out)][..], &options].concat());
            text(&out).to_owned()
        })
        .collect();
    let merge_into = |out: &str| -> Vec<String> {
        let all = ["merge", "--quiet", "--out", out].into_iter().map(str::to_owned);
        all.chain(shares.iter().cloned()).collect()
    };
    let once = |out: &str| {
        let arguments = merge_into(out);
        seconds_of(&arguments.iter().map(String::as_str).collect::<Vec<_>>())
    };
    let (whole, killed) = (home.path("whole"), home.path("killed"));
    let run_s = once(text(&whole));
    let told = home.told(text(&whole));
    let (mut moments, mut kills) = (moments(3000), 0);
    while kills < kills_wanted() {
        let arguments = merge_into(text(&killed));
        let child = start(&arguments.iter().map(String::as_str).collect::<Vec<_>>());
        kills += u32::from(killed_after(child, moments.unit() * run_s));
        // The summary is written last. If it exists, everything is whole.
        if killed.join("summary.json").exists() {
            assert!(home.told(text(&killed)) == told, "a result that is not whole");
        }
    }
    once(text(&killed));
    assert!(home.told(text(&killed)) == told, "other bytes");
    println!("merges: {kills} kills, shares as they were and the same bytes at the end");
}
