//! `luxmc solve --share` and `luxmc merge` as their users see them.

use std::path::{Path, PathBuf};

use sha2::{Digest, Sha256};

use crate::cli_support::*;

const TABLES: [&str; 4] = ["elements.csv", "receivers.csv", "tables.csv", "convergence.csv"];

impl Home {
    /// Computes a share of the small room. `more` holds further options.
    fn share(&self, name: &str, share: &str, more: &[&str]) -> PathBuf {
        let out = self.path(name);
        let options = [&["--share", share, "--chains", "2000", "--plots", "none", "--quiet"], more].concat();
        let output = solve("room.json", &out, &options);
        assert_eq!(code(&output), 0, "{}", errors(&output));
        out
    }

    /// Merges directories. Returns the exit code and standard error.
    fn merge(&self, shares: &[&Path], out: &str, more: &[&str]) -> (i32, String) {
        let out = self.path(out);
        let mut arguments = vec!["merge", "--out", text(&out)];
        arguments.extend(shares.iter().map(|share| text(share)));
        arguments.extend(more);
        let output = run(&arguments);
        (code(&output), errors(&output))
    }

    fn summary(&self, name: &str) -> serde_json::Value {
        let bytes = std::fs::read(self.path(name).join("summary.json")).expect("written");
        serde_json::from_slice(&bytes).expect("JSON")
    }

    fn tables(&self, name: &str) -> [Vec<u8>; 4] {
        TABLES.map(|table| std::fs::read(self.path(name).join(table)).expect("written"))
    }
}

#[test]
fn the_order_of_directories_and_threads_leave_the_bytes_as_they_are_and_more_shares_join() {
    let home = Home::new();
    // Walks leave only random error, so that a number of shares can be stated.
    let options = ["--target-error", "0.5%", "--method", "collision"];
    let shares: Vec<PathBuf> = (1..=3).map(|k| home.share(&k.to_string(), &format!("{k}/3"), &options)).collect();
    assert!(home.summary("2")["share"] == serde_json::json!({"number": 2, "of": 3}), "{}", home.summary("2")["share"]);
    let [one, two, three] = [0, 1, 2].map(|index| shares[index].as_path());
    let (exit, told) = home.merge(&[one, two, three], "forward", &[]);
    assert!(exit == 3 && told.contains("more shares") && told.contains("0.500 %"), "{exit} {told}");
    let (exit, told) = home.merge(&[three, one, two], "backward", &["--threads", "1", "--quiet"]);
    assert!(exit == 3, "{told}");
    assert!(home.tables("forward") == home.tables("backward"), "the order shows");
    let summary = home.summary("forward");
    assert_eq!(summary["merged"]["shares"], 3);
    assert!(summary["merged"]["more_shares_needed"].as_f64().is_some_and(|more| more >= 1.0), "{summary}");
    assert!(summary["stop_reason"] == "shares" && summary["target_met"] == false);
    assert_eq!(summary["chains"].as_u64(), (1..=3).map(|k| home.summary(&k.to_string())["chains"].as_u64()).sum());

    let fourth = home.share("4", "4/4", &options);
    let (exit, told) = home.merge(&[one, two, three, &fourth], "four", &["--target-error", "90%"]);
    assert!(exit == 0 && told.contains("target met"), "{exit} {told}");
    assert!(home.tables("forward") != home.tables("four"), "a further share changes nothing");
    let page = std::fs::read_to_string(home.path("four").join("report.html")).expect("written");
    assert!(page.contains("--share k/4") && page.contains("luxmc merge"));
}

#[test]
fn what_cannot_be_merged_is_refused_and_nothing_is_written() {
    let home = Home::new();
    let one = home.share("1", "1/2", &[]);
    let two = home.share("2", "2/2", &[]);
    let refused = |shares: &[&Path], words: &[&str]| {
        let (exit, told) = home.merge(shares, "none", &[]);
        assert_eq!(exit, 2, "{words:?}: {told}");
        assert!(words.iter().all(|word| told.contains(word)), "{words:?}: {told}");
        assert!(!home.path("none").exists(), "{words:?}: something was written");
    };
    refused(&[&one], &["share 2 of 2 is missing", "--share 2/2"]);
    refused(&[&one, &two, &two], &["share 2 is given twice"]);
    refused(&[&one, &home.share("seed", "2/2", &["--seed", "1"])], &["different seeds"]);
    refused(&[&one, &home.share("method", "2/2", &["--method", "collision"])], &["different methods", "collision"]);
    refused(&[&one, &home.share("maps", "2/2", &["--maps", "probes"])], &["different maps"]);
    refused(&[&one, &home.share("target", "2/2", &["--target-error", "1%"])], &["different targets", "--target-error"]);
    refused(&[&one, &home.path("absent")], &["cannot be read", "share.luxmc"]);

    // Another scene, which differs by one number only in a late digit.
    let other = home.path("other.json");
    let probes = std::fs::read(scene("probes.csv")).expect("there");
    std::fs::write(home.path("probes.csv"), probes).expect("written");
    let room = std::fs::read_to_string(scene("room.json")).expect("there");
    std::fs::write(&other, room.replace("\"reflectance\": 0.25", "\"reflectance\": 0.2500000001")).expect("written");
    let out = home.path("elsewhere");
    let output = solve_file(&other, &out, &["--share", "2/2", "--chains", "2000", "--plots", "none", "--quiet"]);
    assert_eq!(code(&output), 0, "{}", errors(&output));
    refused(&[&one, &out], &["different scenes"]);
    let (exit, told) = home.merge(&[&one, &two], "none", &["--scene", text(&other)]);
    assert!(exit == 2 && told.contains("not the one that the shares computed"), "{told}");
    let (exit, told) = home.merge(&[&one, &two], "2", &[]);
    assert!(exit == 2 && told.contains("overwrite a share") && two.join("share.luxmc").exists(), "{told}");
}

/// Changes the bytes of a share's file in a separate directory.
fn changed(home: &Home, share: &Path, name: &str, change: impl Fn(Vec<u8>) -> Vec<u8>) -> PathBuf {
    let directory = home.path(name);
    std::fs::create_dir(&directory).expect("made");
    let bytes = std::fs::read(share.join("share.luxmc")).expect("there");
    std::fs::write(directory.join("share.luxmc"), change(bytes)).expect("written");
    directory
}

#[test]
fn damaged_files_and_a_share_under_another_number_are_refused() {
    let home = Home::new();
    let (one, two) = (home.share("1", "1/2", &[]), home.share("2", "2/2", &[]));
    let refused = |other: &Path, word: &str| {
        let (exit, told) = home.merge(&[&one, other], "none", &[]);
        assert!(exit == 2 && told.contains(word), "{word}: {told}");
        assert!(!home.path("none").exists(), "{word}: something was written");
    };
    let last = |mut bytes: Vec<u8>| {
        *bytes.last_mut().expect("not empty") ^= 1;
        bytes
    };
    refused(&changed(&home, &two, "bit", last), "sums that do not match");
    refused(&changed(&home, &two, "cut", |bytes| bytes[..bytes.len() - 8].to_vec()), "bytes, where its header");
    refused(&changed(&home, &two, "header", |bytes| bytes[..200].to_vec()), "ends within its header");
    let forged = |mut bytes: Vec<u8>| {
        let at = bytes.windows(8).position(|part| part == b"\"seed\":0").expect("a seed");
        bytes[at + 7] = b'1';
        bytes
    };
    refused(&changed(&home, &two, "digit", forged), "a header that does not match");
    refused(&changed(&home, &two, "foreign", |_| b"luxmc share 2 0\n{}\n".to_vec()), "another version of the format");

    // The first share under the number of the second, with a valid digest. Its sums reveal it.
    let renumbered = |bytes: Vec<u8>| {
        let lines: Vec<&[u8]> = bytes.splitn(3, |byte| *byte == b'\n').collect();
        let header = String::from_utf8(lines[1].to_vec()).expect("UTF-8").replacen("\"number\":1", "\"number\":2", 1);
        let digest: String = Sha256::digest(&header).iter().map(|byte| format!("{byte:02x}")).collect();
        [format!("luxmc share 1 {digest}\n{header}\n").as_bytes(), lines[2]].concat()
    };
    let twin = changed(&home, &one, "twin", renumbered);
    refused(&twin, "are the same");
    assert_eq!(home.merge(&[&one, &two], "both", &[]).0, 0);
}

#[test]
fn options_that_make_no_share_are_refused() {
    let home = Home::new();
    let refused = |options: &[&str], word: &str| {
        let output = solve("room.json", &home.path("none"), options);
        assert_eq!(code(&output), 2, "{options:?}: {}", errors(&output));
        assert!(errors(&output).contains(word), "{options:?}: {}", errors(&output));
        assert!(!home.path("none").exists());
    };
    refused(&["--share", "1/2"], "--chains N or --time-limit");
    refused(&["--share", "1/2", "--target-error", "1%"], "--chains N or --time-limit");
    refused(&["--share", "1/2", "--chains", "2000", "--maps", "elements"], "--elements given");
    refused(&["--share", "1/2", "--time-limit", "1s", "--method", "light-mesh"], "is not random");
    for wrong in ["0/2", "3/2", "1", "a/2", "1/2/3"] {
        refused(&["--share", wrong, "--chains", "2000"], "3/8");
    }
    // Shares of a scene without randomness are equal, which is allowed. A lamp alone lights the floor, and the surface that could reflect
    // stays dark.
    let dark_shelf = r#""geometry": [ { "name": "shelf", "type": "rectangle", "origin": [-1, -1, 3], "u": [2, 0, 0], "v": [0, 2, 0],
        "material": "grey" },"#;
    let text_of_scene = std::fs::read_to_string(scene("black.json")).expect("there");
    let with_shelf = text_of_scene
        .replace("\"geometry\": [", dark_shelf)
        .replace("\"materials\": {", "\"materials\": { \"grey\": { \"type\": \"diffuse\", \"reflectance\": 0.5 },");
    let shelf = home.path("shelf.json");
    std::fs::write(&shelf, with_shelf).expect("written");
    let black = ["1/2", "2/2"].map(|share| {
        let out = home.path(&share.replace('/', "-"));
        let output = solve_file(&shelf, &out, &["--share", share, "--chains", "2000", "--maps", "below", "--quiet"]);
        assert_eq!(code(&output), 0, "{}", errors(&output));
        out
    });
    let reason = home.summary("1-2")["stop_reason"].clone();
    assert_eq!(reason, "chains", "walks look for light that is not there");
    let sums = black.each_ref().map(|out| std::fs::read(out.join("tables.csv")).expect("written"));
    let (exit, told) = home.merge(&[&black[0], &black[1]], "black", &[]);
    assert!(exit == 0 && sums[0] == sums[1], "{exit} {told}");

    // A share that ends by its time limit has done its work, whatever the target of the whole.
    let out = home.path("timed");
    let output =
        solve("room.json", &out, &["--share", "1/1", "--time-limit", "300ms", "--target-error", "0.001%", "--quiet"]);
    assert_eq!(code(&output), 0, "{}", errors(&output));
    let (exit, told) = home.merge(&[&out], "all", &[]);
    assert!(exit == 3 && told.contains("target"), "{exit} {told}");
}

/// Parts of the receivers give the same bytes in any order. Every point occurs once, under its own number.
#[test]
fn parts_of_the_receivers_merge_into_one_result_and_other_sets_of_them_are_refused() {
    let home = Home::new();
    let part = |name: &str, part: &str, more: &[&str]| {
        let out = home.path(name);
        let options =
            [&["--receivers-part", part, "--target-error", "3%", "--plots", "none", "--quiet"], more].concat();
        let output = solve("room.json", &out, &options);
        assert_eq!(code(&output), 0, "{}", errors(&output));
        out
    };
    let parts: Vec<PathBuf> = (1..=3).map(|k| part(&k.to_string(), &format!("{k}/3"), &[])).collect();
    let [one, two, three] = [0, 1, 2].map(|index| parts[index].as_path());
    assert_eq!(home.summary("2")["receivers_part"], serde_json::json!({"number": 2, "of": 3}));
    assert_eq!(home.summary("2")["stop_reason"], "target_met");
    let (exit, told) = home.merge(&[one, two, three], "forward", &[]);
    assert!(exit == 0 && told.contains("3 parts of the receivers"), "{exit} {told}");
    assert_eq!(home.merge(&[three, one, two], "backward", &["--threads", "1", "--quiet"]).0, 0);
    let read = |name: &str| {
        ["receivers.csv", "tables.csv", "convergence.csv"]
            .map(|table| std::fs::read(home.path(name).join(table)).expect("written"))
    };
    assert!(read("forward") == read("backward"), "the order shows");
    let merged = home.summary("forward")["merged"].clone();
    assert!(merged["shares"] == 1 && merged["receivers_parts"] == 3, "{merged}");

    // Positions and numbers are those of a run of the whole.
    let output = solve("room.json", &home.path("whole"), &["--maps", "receivers", "--target-error", "3%", "--quiet"]);
    assert_eq!(code(&output), 0, "{}", errors(&output));
    let places = |name: &str| -> Vec<Vec<String>> {
        table(&home.path(name).join("receivers.csv")).1.into_iter().map(|row| row[..8].to_vec()).collect()
    };
    assert_eq!(places("forward"), places("whole"));
    let of_two = places("2");
    assert!(of_two.iter().all(|row| places("whole").contains(row)) && of_two[0][1] == "1", "{of_two:?}");

    let refused = |shares: &[&Path], words: &[&str]| {
        let (exit, told) = home.merge(shares, "none", &[]);
        assert_eq!(exit, 2, "{words:?}: {told}");
        assert!(words.iter().all(|word| told.contains(word)), "{words:?}: {told}");
        assert!(!home.path("none").exists(), "{words:?}: something was written");
    };
    refused(&[one, three], &["part 2 of 3 of the receivers is missing", "--receivers-part 2/3"]);
    refused(&[one, two, three, three], &["part 3 of the receivers is given twice"]);
    refused(&[one, two, &part("of-two", "2/2", &[])], &["divide the receivers differently", "3 parts"]);
    refused(&[one, two, &part("seed", "3/3", &["--seed", "1"])], &["different seeds"]);
    refused(&[one, &part("maps", "2/3", &["--maps", "work plane"]), three], &["different maps"]);
    refused(&[one, two, &home.share("share", "1/1", &[])], &["divide the receivers differently"]);
    let other = home.path("other.json");
    std::fs::write(home.path("probes.csv"), std::fs::read(scene("probes.csv")).expect("there")).expect("written");
    let room = std::fs::read_to_string(scene("room.json")).expect("there");
    std::fs::write(&other, room.replace("\"reflectance\": 0.25", "\"reflectance\": 0.2500000001")).expect("written");
    let foreign = home.path("foreign");
    let output = solve_file(&other, &foreign, &["--receivers-part", "3/3", "--target-error", "3%", "--quiet"]);
    assert_eq!(code(&output), 0, "{}", errors(&output));
    refused(&[one, two, &foreign], &["different scenes"]);

    // A second share of every part is merged too.
    let more = ["--share", "2/2", "--chains", "2000"];
    let second: Vec<PathBuf> = (1..=3).map(|k| part(&format!("second-{k}"), &format!("{k}/3"), &more)).collect();
    let all: Vec<&Path> = parts.iter().chain(&second).map(PathBuf::as_path).collect();
    refused(&all[..5], &["share 2 of 2, part 3 of 3 of the receivers is missing", "--share 2/2 --receivers-part 3/3"]);
    let (exit, told) = home.merge(&all, "both", &[]);
    // With so few chains, two points may or may not have known largest scores, by chance. Without them the target is not reported as met.
    assert!([0, 3].contains(&exit) && told.contains("2 shares of 3 parts of the receivers each"), "{exit} {told}");

    let refused = |options: &[&str], word: &str| {
        let output = solve("room.json", &home.path("none"), options);
        assert_eq!(code(&output), 2, "{options:?}: {}", errors(&output));
        assert!(errors(&output).contains(word), "{options:?}: {}", errors(&output));
        assert!(!home.path("none").exists());
    };
    refused(&["--receivers-part", "1/3", "--maps", "elements"], "elements cannot be divided");
    refused(&["--receivers-part", "99999/99999"], "has no receivers");
    refused(&["--receivers-part", "4/3"], "no such part");
    refused(&["--receivers-part", "1/3", "--method", "light-mesh"], "is not random");
    refused(&["--receivers-part", "1/3", "--share", "1/2"], "--chains N or --time-limit");
}

/// The scripts of `scenes/cluster`, run as a scheduler runs them: Slurm counts tasks from 1, Kubernetes from 0.
#[cfg(unix)]
#[test]
fn the_scripts_for_clusters_make_shares_and_merge_them() {
    let home = Home::new();
    let scripts = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/cluster");
    let program = Path::new(env!("CARGO_BIN_EXE_luxmc")).parent().expect("a folder");
    let path = format!("{}:{}", program.display(), std::env::var("PATH").unwrap_or_default());
    let script = |name: &str, index: Option<(&str, &str)>| {
        let mut command = std::process::Command::new("sh");
        command.arg(scripts.join(name)).env("PATH", &path).envs(index);
        command.env("SCENE", scene("room.json")).env("OUT", home.path("out")).env("SHARES", "2");
        command.env("CHAINS", "2000").env("TARGET", "50%").env("OPTIONS", "--maps probes --seed 4");
        command.output().expect("sh starts")
    };
    for index in [("SLURM_ARRAY_TASK_ID", "1"), ("JOB_COMPLETION_INDEX", "1")] {
        let output = script("share.sh", Some(index));
        assert_eq!(code(&output), 0, "{}", errors(&output));
    }
    assert_eq!(listing(&home.path("out/shares")), ["1", "2"]);
    assert_eq!(home.summary("out/shares/2")["seed"], 4);
    let output = script("merge.sh", None);
    assert_eq!(code(&output), 0, "{}", errors(&output));
    assert_eq!(home.summary("out/merged")["merged"]["shares"], 2);
    assert_ne!(code(&script("share.sh", None)), 0, "a share without a number");
}
