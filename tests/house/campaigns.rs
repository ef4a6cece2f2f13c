//! Checks that .ci/run runs the tests that `cargo test` leaves out, or runs with fewer seeds, before a change lands.

use std::fs;
use std::path::{Path, PathBuf};

use crate::rust_files;

fn script() -> String {
    fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join(".ci/run")).unwrap()
}

/// Test binaries and their files that have slow campaigns, as pairs (binary, file).
fn tests_with_campaigns() -> Vec<(String, String)> {
    let tests = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests");
    let slow = ["if slow()", "LUXMC_SLOW_TESTS"];
    let parts_of = |path: PathBuf| {
        let inside = path.with_extension("");
        let inside = inside.strip_prefix(&tests).unwrap().to_str().unwrap().to_owned();
        let (binary, file) = inside.split_once('/').unwrap_or((&inside, "tests"));
        (binary.to_owned(), file.to_owned())
    };
    let has_campaign = |text: &str| slow.iter().any(|word| text.contains(word));
    let helpers = ["common", "house"];
    let found = rust_files(&tests).into_iter().filter(|(_, text)| has_campaign(text)).map(|(path, _)| parts_of(path));
    found.filter(|(binary, _)| !helpers.contains(&binary.as_str())).collect()
}

#[test]
fn all_slow_campaigns_are_run_before_a_change_lands() {
    let script = script();
    let (_, slow) = script.split_once("LUXMC_SLOW_TESTS=1").expect("slow campaigns");
    let named = |word: &str| slow.split_whitespace().any(|other| other == word);
    let campaigns = tests_with_campaigns();
    assert!(campaigns.len() > 4, "{campaigns:?}");
    let is_run = |binary: &str, file: &str| slow.contains(&format!("--test {binary} ")) && named(&format!("{file}::"));
    let left_out: Vec<_> = campaigns.iter().filter(|(binary, file)| !is_run(binary, file)).collect();
    assert!(left_out.is_empty() && named("--lib"), ".ci/run leaves out the slow campaigns of {left_out:?}");
}

#[test]
fn tests_that_the_test_command_leaves_out_are_run_before_a_change_lands() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let files: Vec<_> = ["src", "tests"].iter().flat_map(|folder| rust_files(&root.join(folder))).collect();
    let ignored = concat!("#[", "ignore");
    let left_out: usize = files.iter().map(|(_, text)| text.matches(ignored).count()).sum();
    let script = script();
    let is_run = |script: &str| {
        script.lines().any(|line| line == "cargo test --release --locked --no-fail-fast --tests -- --ignored")
    };
    assert!(left_out > 0 && is_run(&script), "{left_out} tests are run by nobody");
    assert!(!is_run(&script.replace("--ignored", "")), "the planted fault passed");
    let told = format!("{ignored} = \"takes long: .ci/run runs it\"]");
    let untold = files.iter().filter(|(_, text)| text.matches(ignored).count() != text.matches(&told).count());
    assert_eq!(untold.map(|(path, _)| path.display().to_string()).collect::<Vec<_>>(), [""; 0]);
}
