//! Results that cannot be written: a clear error, exit code 4, and the results of the previous run are still whole.
#![cfg(unix)]

use std::path::Path;
use std::process::{Command, Output};
use std::time::Duration;

use crate::cli_support::{code, errors, interrupt, listing, luxmc, run_or_hang, scene, solve, summary, text};

/// Every file in a directory with its bytes.
fn contents(path: &Path) -> Vec<(String, Vec<u8>)> {
    listing(path).into_iter().map(|name| (name.clone(), std::fs::read(path.join(name)).expect("readable"))).collect()
}

#[test]
fn a_full_disk_leaves_the_earlier_results_whole() {
    let home = tempfile::tempdir().expect("a temporary directory");
    let out = home.path().join("out");
    assert_eq!(code(&solve("room.json", &out, &["--chains", "2000"])), 0);
    let before = contents(&out);

    // A limit of 16 blocks per file replaces a full disk: elements.csv is larger.
    let script = "trap '' XFSZ; ulimit -f 16; exec \"$@\"";
    let output = Command::new("sh")
        .args([
            "-c",
            script,
            "sh",
            env!("CARGO_BIN_EXE_luxmc"),
            "solve",
            text(&scene("room.json")),
            "--out",
            text(&out),
        ])
        .args(["--chains", "3000"])
        .output()
        .expect("the shell starts");
    assert_eq!(code(&output), 4, "{}", errors(&output));
    let told = errors(&output);
    assert!(told.contains("cannot be written") && told.contains("remedy") && told.contains("elements.csv"), "{told}");
    assert!(contents(&out) == before, "the earlier results changed: {:?}", listing(&out));
}

/// An endless run, interrupted some time after its directory exists and after `beside` has run.
#[cfg(unix)]
fn interrupted_run(out: &Path, beside: impl FnOnce()) -> Output {
    let scene = scene("room.json");
    run_or_hang(luxmc(&["solve", text(&scene), "--out", text(out), "--target-error", "0.0000001%"]), |id| {
        while !out.exists() {
            std::thread::sleep(Duration::from_millis(20));
        }
        std::thread::sleep(Duration::from_millis(500));
        beside();
        interrupt(id);
    })
}

#[cfg(unix)]
#[test]
fn a_directory_that_vanishes_during_the_run_ends_with_4() {
    let home = tempfile::tempdir().expect("a temporary directory");
    let out = home.path().join("out");
    let output = interrupted_run(&out, || std::fs::remove_dir_all(&out).expect("removed"));
    assert_eq!(code(&output), 4, "{}", errors(&output));
    assert!(errors(&output).contains("remedy"), "{}", errors(&output));
}

#[cfg(target_os = "linux")]
#[test]
fn a_directory_in_use_is_refused_at_once_and_the_first_run_goes_on() {
    let home = tempfile::tempdir().expect("a temporary directory");
    let out = home.path().join("out");
    let first = interrupted_run(&out, || {
        let second = solve("room.json", &out, &["--chains", "1000"]);
        assert_eq!(code(&second), 4, "{}", errors(&second));
        assert!(errors(&second).contains("another run"), "{}", errors(&second));
    });
    assert_eq!(code(&first), 130, "{}", errors(&first));
    assert!(summary(&out)["files"].is_array());
}

#[cfg(target_os = "linux")]
#[test]
fn a_file_system_that_takes_no_files_and_a_full_standard_output_end_with_4() {
    let output = solve("room.json", Path::new("/proc/luxmc"), &["--chains", "1000"]);
    assert_eq!(code(&output), 4, "{}", errors(&output));
    let full = std::fs::File::options().write(true).open("/dev/full").expect("there");
    let output = luxmc(&["inspect", text(&scene("room.json"))]).stdout(full).output().expect("the program starts");
    assert_eq!(code(&output), 4, "{}", errors(&output));
    assert!(errors(&output).contains("standard output"), "{}", errors(&output));
}

#[test]
fn a_read_only_directory_and_a_file_in_its_place_are_refused_before_the_run() {
    use std::os::unix::fs::PermissionsExt;
    let home = tempfile::tempdir().expect("a temporary directory");

    // A file has the name of the directory or of a directory above it.
    let file = home.path().join("file");
    std::fs::write(&file, "mine").expect("written");
    for out in [file.clone(), file.join("out")] {
        let output = solve("room.json", &out, &["--target-error", "0.001%"]);
        assert_eq!(code(&output), 4, "{}", errors(&output));
        assert!(errors(&output).contains("file") && errors(&output).contains("remedy"), "{}", errors(&output));
    }
    assert_eq!(std::fs::read(&file).expect("still there"), b"mine");

    // A directory without write permission that contains results. For the superuser every directory is writable.
    let out = home.path().join("out");
    assert_eq!(code(&solve("room.json", &out, &["--chains", "2000"])), 0);
    let before = contents(&out);
    std::fs::set_permissions(&out, PermissionsExt::from_mode(0o555)).expect("changed");
    let is_writable = std::fs::write(out.join("probe"), "").is_ok();
    let output = solve("room.json", &out, &["--chains", "3000"]);
    std::fs::set_permissions(&out, PermissionsExt::from_mode(0o755)).expect("changed back");
    if is_writable {
        eprintln!("skipped: this user may write into read-only directories");
        return;
    }
    assert_eq!(code(&output), 4, "{}", errors(&output));
    assert!(errors(&output).contains("remedy"), "{}", errors(&output));
    assert!(contents(&out) == before, "the earlier results changed: {:?}", listing(&out));
}

#[test]
fn a_file_that_vanished_is_reported_with_who_named_it() {
    let home = tempfile::tempdir().expect("a temporary directory");
    let scene_path = home.path().join("room.json");
    std::fs::copy(scene("room.json"), &scene_path).expect("copied");
    let output =
        luxmc(&["solve", text(&scene_path), "--out", text(&home.path().join("out"))]).output().expect("starts");
    assert_eq!(code(&output), 2, "{}", errors(&output));
    assert!(errors(&output).contains("probes.csv") && errors(&output).contains("named by"), "{}", errors(&output));
    assert!(!home.path().join("out").exists());
}
