//! Share files made to do harm, with valid digests. A merge refuses them or gives finite results. It never panics, waits or exceeds its
//! memory.

use std::path::{Path, PathBuf};

use serde_json::{Value, json};
use sha2::{Digest, Sha256};

use crate::cli_support::*;

/// Number of changed files that are merged.
const TRIES: u64 = 100;
/// Number of elements of a list that are tried.
const FEW: usize = 20;

/// Numbers that the program never writes into a header.
fn hostile_numbers() -> [Value; 9] {
    [
        json!(0),
        json!(1),
        json!(-1),
        json!(u64::MAX),
        json!(u32::MAX),
        json!(1e300),
        json!(-1e300),
        json!(5e-324),
        json!(1u64 << 40),
    ]
}

/// Splits a file into header and sums.
fn parts(file: &[u8]) -> (Value, Vec<u8>) {
    let lines: Vec<&[u8]> = file.splitn(3, |byte| *byte == b'\n').collect();
    (serde_json::from_slice(lines[1]).expect("JSON"), lines[2].to_vec())
}

fn digest(bytes: &[u8]) -> String {
    Sha256::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect()
}

/// Joins header and sums to a file with valid digests.
fn sealed(mut header: Value, sums: &[u8]) -> Vec<u8> {
    header["sums_sha256"] = digest(sums).into();
    let header = header.to_string();
    [format!("luxmc share 1 {}\n{header}\n", digest(header.as_bytes())).as_bytes(), sums].concat()
}

/// Paths of all numbers in a value, by the keys that lead to them.
fn numbers(value: &Value, path: &str, found: &mut Vec<String>) {
    match value {
        Value::Number(_) => found.push(path.to_owned()),
        Value::Array(list) => {
            // The first few represent the rest. A map has thousands of largest scores.
            let few = list.iter().take(FEW).enumerate();
            few.for_each(|(at, value)| numbers(value, &format!("{path}/{at}"), found))
        }
        Value::Object(map) => map.iter().for_each(|(key, value)| numbers(value, &format!("{path}/{key}"), found)),
        _ => {}
    }
}

struct Shares {
    home: tempfile::TempDir,
    first: PathBuf,
    second: Vec<u8>,
}

impl Shares {
    fn new() -> Shares {
        let home = tempfile::tempdir().expect("a folder");
        let share = |number: &str| {
            let out = home.path().join(number);
            let share = format!("{number}/2");
            let options = ["--share", share.as_str(), "--chains", "2000", "--plots", "none", "--quiet"];
            let output = solve("room.json", &out, &options);
            assert_eq!(code(&output), 0, "{}", errors(&output));
            out
        };
        let (first, second) = (share("1"), share("2"));
        let second = std::fs::read(second.join("share.luxmc")).expect("there");
        Shares { home, first, second }
    }

    /// Merges the first share and this one. Returns the exit code and standard error.
    fn merge(&self, file: &[u8], what: &str) -> (i32, String) {
        let (changed, out) = (self.home.path().join("changed"), self.home.path().join("out"));
        std::fs::create_dir_all(&changed).expect("made");
        std::fs::write(changed.join("share.luxmc"), file).expect("written");
        std::fs::remove_dir_all(&out).ok();
        let arguments = [
            "merge",
            text(&self.first),
            text(&changed),
            "--out",
            text(&out),
            "--plots",
            "none",
            "--memory-limit",
            "512MB",
        ];
        let output = run_or_hang(luxmc(&arguments), |_| ());
        let told = errors(&output);
        let exit = output.status.code().unwrap_or_else(|| panic!("{what}: ended by a signal: {told}"));
        assert!([0, 2, 3, 4].contains(&exit) && !told.contains("panicked"), "{what}: {exit} {told}");
        if exit == 2 {
            assert!(!out.exists(), "{what}: refused, and something was written");
        } else if exit != 4 {
            check_numbers(&out, what);
        }
        (exit, told)
    }
}

/// Checks that no table and no summary contains NaN or infinity.
fn check_numbers(out: &Path, what: &str) {
    for name in listing(out).iter().filter(|name| name.ends_with(".csv") || name.ends_with(".json")) {
        let text = std::fs::read_to_string(out.join(name)).expect("UTF-8");
        let mut words = text.split(|letter: char| !letter.is_ascii_alphanumeric());
        let word = words.find(|word| ["NaN", "nan", "inf", "Infinity", "infinity"].contains(word));
        assert_eq!(word, None, "{what}: {name}");
    }
}

#[test]
fn numbers_of_a_header_may_be_any() {
    let shares = Shares::new();
    let (header, sums) = parts(&shares.second);
    assert_eq!(sealed(header.clone(), &sums), shares.second, "a file is made again byte for byte");
    let mut places = Vec::new();
    numbers(&header, "", &mut places);
    assert!(places.len() > 60, "{}", places.len());
    let hostile = hostile_numbers();
    let mut refused = 0;
    for number in 0..TRIES {
        // The steps through places and values have no common divisor with their numbers.
        let place = &places[(number as usize * 37 + 11) % places.len()];
        let value = &hostile[number as usize % hostile.len()];
        let mut changed = header.clone();
        *changed.pointer_mut(place).expect("a place") = value.clone();
        let (exit, _) = shares.merge(&sealed(changed, &sums), &format!("{place} = {value}"));
        refused += usize::from(exit == 2);
    }
    assert!(refused > 5, "only {refused} were refused");
}

#[test]
fn a_share_of_thousands_of_millions_tells_how_many_are_missing() {
    let shares = Shares::new();
    let (mut header, sums) = parts(&shares.second);
    header["share"]["of"] = json!(u32::MAX);
    let (exit, told) = shares.merge(&sealed(header, &sums), "of");
    assert!(exit == 2 && told.contains("share 3 of 4294967295 and 4294967292 more are missing"), "{exit} {told}");
}

#[test]
fn sums_that_are_no_numbers_and_files_that_are_none_are_refused() {
    let shares = Shares::new();
    let (header, sums) = parts(&shares.second);
    for value in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, f64::MAX, -1e71] {
        let mut changed = sums.clone();
        changed[80..88].copy_from_slice(&value.to_le_bytes());
        let (exit, told) = shares.merge(&sealed(header.clone(), &changed), "sums");
        assert!(exit == 2 && told.contains("sums that are not numbers"), "{value}: {exit} {told}");
    }
    // A value just within the limit may give a result, but no infinite one.
    let mut changed = sums.clone();
    changed[80..88].copy_from_slice(&9e69f64.to_le_bytes());
    shares.merge(&sealed(header.clone(), &changed), "a large number");
    let mut changed = header.clone();
    changed["record"]["rays"] = json!(u64::MAX);
    let (exit, told) = shares.merge(&sealed(changed, &sums), "rays");
    assert!(exit == 2 && told.contains("counts 18446744073709551615"), "{exit} {told}");
    for (file, word) in [
        (&b""[..], "ends within its header"),
        (&[0; 4096][..], "ends within its header"),
        (&b"luxmc share 1 \n{}\n"[..], "digest"),
    ] {
        let (exit, told) = shares.merge(file, "no share");
        assert!(exit == 2 && told.contains(word), "{exit} {told}");
    }
}

/// A pipe does not block the program, and a device is not read without end.
#[cfg(unix)]
#[test]
fn pipes_and_devices_are_no_shares() {
    let shares = Shares::new();
    for (name, make) in [("pipe", "mkfifo share.luxmc"), ("device", "ln -s /dev/zero share.luxmc")] {
        let folder = shares.home.path().join(name);
        std::fs::create_dir(&folder).expect("made");
        let made = std::process::Command::new("sh").args(["-c", make]).current_dir(&folder).status();
        assert!(made.is_ok_and(|status| status.success()), "{make}");
        let out = shares.home.path().join("none");
        let output = run_or_hang(luxmc(&["merge", text(&shares.first), text(&folder), "--out", text(&out)]), |_| ());
        let told = errors(&output);
        assert!(code(&output) == 2 && told.contains("device or pipe"), "{name}: {told}");
    }
}
