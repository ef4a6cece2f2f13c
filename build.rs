//! Gives the program the commit that it is built from, if it is known: from the environment, from the file that cargo adds to packages, or
//! from git. Without any of them the build still works.

use std::path::Path;
use std::process::Command;

/// Names the commit for builds from a tree without git. In a tree with git, builds with it do not depend on the tree's commits.
const VARIABLE: &str = "LUXMC_COMMIT";
/// File in which cargo stores the commit of a package.
const OF_PACKAGE: &str = ".cargo_vcs_info.json";
/// Number of digits of the commit that are kept.
const DIGITS: usize = 12;

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rerun-if-env-changed={VARIABLE}");
    let named = std::env::var(VARIABLE).ok().filter(|name| !name.trim().is_empty());
    let commit = named.or_else(of_package).or_else(of_git).unwrap_or_default();
    let commit: String = commit.trim().chars().filter(|letter| !letter.is_control()).take(DIGITS).collect();
    println!("cargo::rustc-env=LUXMC_BUILT_FROM={commit}");
    println!("cargo::rustc-env=LUXMC_BUILT_FOR={}", std::env::var("TARGET").unwrap_or_default());
}

fn of_package() -> Option<String> {
    let text = std::fs::read_to_string(OF_PACKAGE).ok()?;
    let (_, rest) = text.split_once("\"sha1\"")?;
    rest.split('"').nth(1).map(str::to_owned)
}

fn of_git() -> Option<String> {
    // A tree inside another project must not get that project's commit.
    if !Path::new(".git").exists() {
        return None;
    }
    let commit = git(&["rev-parse", "HEAD"])?;
    let branch = git(&["symbolic-ref", "--quiet", "HEAD"]);
    for name in ["HEAD", "packed-refs"].into_iter().chain(branch.as_deref()) {
        let path = git(&["rev-parse", "--git-path", name]).filter(|path| Path::new(path).exists());
        path.iter().for_each(|path| println!("cargo::rerun-if-changed={path}"));
    }
    Some(commit)
}

fn git(arguments: &[&str]) -> Option<String> {
    let output = Command::new("git").args(arguments).output().ok().filter(|output| output.status.success())?;
    Some(String::from_utf8(output.stdout).ok()?.trim().to_owned()).filter(|text| !text.is_empty())
}
