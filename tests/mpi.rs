//! `mpirun -n P luxmc solve …` as its users see it. The result has the same bytes as shares merged by hand. A run that loses a rank leaves
//! what was merged.
//!
//! It is built only with `--features mpi`. Without `mpirun` in the path there is nothing to run.
#![cfg(all(feature = "mpi", unix))]

mod cli_support;

use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use cli_support::*;

/// The program on `count` ranks on this machine.
fn ranks(count: usize, arguments: &[&str]) -> Command {
    let mut command = Command::new("mpirun");
    command.args(["--allow-run-as-root", "--oversubscribe", "--bind-to", "none", "-n", &count.to_string()]);
    command.arg(env!("CARGO_BIN_EXE_luxmc")).args(arguments).stdout(Stdio::null()).stderr(Stdio::piped());
    command
}

fn has_mpirun() -> bool {
    Command::new("mpirun").arg("--version").stdout(Stdio::null()).status().is_ok_and(|status| status.success())
}

#[test]
fn ranks_come_to_the_bytes_of_shares_merged() {
    if !has_mpirun() {
        return;
    }
    let home = Home::new();
    let room = scene("room.json");
    for count in [2, 3] {
        let [by_ranks, by_hand] = ["ranks", "hand"].map(|name| home.path(&format!("{name}-{count}")));
        let shared = ["--maps", "receivers", "--target-error", "1%", "--plots", "none", "--quiet", "--threads", "1"];
        let all = (count * 20_000).to_string();
        let arguments = [&["solve", text(&room), "--out", text(&by_ranks), "--chains", &all][..], &shared].concat();
        let output = ranks(count, &arguments).output().expect("it starts");
        assert!([0, 3].contains(&code(&output)), "{}", errors(&output));
        let mut merge = vec!["merge".to_owned(), "--out".to_owned(), text(&by_hand).to_owned(), "--quiet".to_owned()];
        for number in 1..=count {
            let out = home.path(&format!("{count}-{number}"));
            let share = format!("{number}/{count}");
            let own = ["solve", text(&room), "--out", text(&out), "--chains", "20000", "--share", &share];
            assert_eq!(code(&run(&[&own[..], &shared].concat())), 0);
            merge.push(text(&out).to_owned());
        }
        run(&merge.iter().map(String::as_str).collect::<Vec<_>>());
        for name in ["receivers.csv", "tables.csv"] {
            let [one, other] = [&by_ranks, &by_hand].map(|out| std::fs::read(out.join(name)).expect("written"));
            assert!(one == other, "{count} ranks: {name}");
        }
    }
}

#[test]
fn rounds_go_on_to_the_target_and_bad_usage_ends_all_ranks() {
    if !has_mpirun() {
        return;
    }
    let home = Home::new();
    let (room, out) = (scene("room.json"), home.path("out"));
    let arguments = ["solve", text(&room), "--out", text(&out), "--maps", "receivers", "--target-error", "0.2%"];
    let output = ranks(2, &[&arguments[..], &["--method", "collision", "--threads", "1", "--plots", "none"]].concat())
        .output()
        .expect("it starts");
    assert_eq!(code(&output), 0, "{}", errors(&output));
    let told = summary(&out);
    assert!(told["target_met"] == true && told["merged"]["shares"].as_u64() >= Some(2), "{told}");
    let output =
        ranks(2, &["solve", text(&room), "--out", text(&home.path("none")), "--share", "1/2", "--chains", "9"])
            .output()
            .expect("it starts");
    assert!(code(&output) == 2 && errors(&output).contains("ranks divide the work"), "{}", errors(&output));
    assert!(!home.path("none").exists());
}

/// A killed rank ends the job, as MPI requires. The files contain everything that was merged until then, and they are whole.
#[test]
fn a_lost_rank_leaves_what_was_merged() {
    if !has_mpirun() {
        return;
    }
    let home = Home::new();
    let (room, out) = (scene("room.json"), home.path("out"));
    let arguments = ["solve", text(&room), "--out", text(&out), "--maps", "receivers", "--target-error", "0.001%"];
    let mut child =
        ranks(2, &[&arguments[..], &["--method", "collision", "--threads", "1", "--plots", "none"]].concat())
            .spawn()
            .expect("it starts");
    let begun = Instant::now();
    while !out.join("summary.json").exists() {
        assert!(begun.elapsed() < Duration::from_secs(120), "no round has ended");
        std::thread::sleep(Duration::from_millis(10));
    }
    let listed = Command::new("pgrep").args(["-P", &child.id().to_string()]).output().expect("pgrep");
    let last = String::from_utf8_lossy(&listed.stdout).lines().last().map(str::to_owned).expect("ranks");
    signal(last.trim().parse().expect("a number"), "-KILL");
    assert!(!child.wait().expect("it ends").success());
    let told = summary(&out);
    assert!(told["merged"]["shares"].as_u64() >= Some(2) && told["target_met"] == false, "{told}");
    assert!(home.told(text(&out)).len() > 2);
}
