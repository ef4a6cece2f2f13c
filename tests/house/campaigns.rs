//! Checks that .ci/run runs the tests that `cargo test` leaves out, or runs with fewer seeds, before a change lands.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use crate::{module_of, rust_files};

/// Tests whose slow form .ci/run leaves out, each with the reason.
const LEFT_OUT: [(&str, &str); 2] = [
    (
        "rooms gather::gathered_maps_of_the_cube_are_those_of_radiosity_and_their_errors_hold",
        "the mean of its 300 seeds is 4.8 of its standard errors too low, a sixth of the stated error (README, known limits)",
    ),
    (
        "rooms maps_of_known_rooms::an_isothermal_office_has_the_same_illuminance_everywhere_within_its_error_bars",
        "its 200 seeds take some 45 minutes of processor time, longer than all other slow campaigns together",
    ),
];

/// Words of code that ask whether slow campaigns are requested.
const ASKS: [&str; 2] = ["slow()", "LUXMC_SLOW_TESTS"];

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn script() -> String {
    fs::read_to_string(root().join(".ci/run")).unwrap()
}

/// A test that does more if slow campaigns are requested.
struct SlowForm {
    /// Its binary, or `--lib`.
    binary: String,
    /// Its name within the binary, with its modules.
    name: String,
    is_ignored: bool,
}

/// A function with its attributes and its code.
struct Function<'a> {
    name: &'a str,
    attributes: Vec<&'a str>,
    code: String,
}

/// The functions of formatted code, with those of its modules.
fn functions(text: &str) -> Vec<Function<'_>> {
    let (mut found, mut attributes): (Vec<Function>, Vec<&str>) = (Vec::new(), Vec::new());
    let mut end = None;
    for line in text.lines() {
        let code = line.trim_start();
        if let Some(last) = end.take() {
            found.last_mut().unwrap().code.extend([line, "\n"]);
            end = Some(last).filter(|last| line != *last);
        } else if let Some((_, rest)) = format!(" {code}").split_once(" fn ") {
            let indent = &line[..line.len() - code.len()];
            end = Some(format!("{indent}}}")).filter(|_| !line.ends_with(['}', ';']));
            let start = line.len() - rest.len();
            let name = line[start..].split(['(', '<']).next().unwrap();
            found.push(Function { name, attributes: std::mem::take(&mut attributes), code: format!("{line}\n") });
        } else if code.starts_with("#[") {
            attributes.push(code);
        } else {
            attributes.clear();
        }
    }
    found
}

/// Whether code calls a function of this name.
fn calls(code: &str, name: &str) -> bool {
    let begins = |at: usize| !code[..at].ends_with(|c: char| c.is_alphanumeric() || c == '_');
    code.match_indices(&format!("{name}(")).any(|(at, _)| begins(at) && !code[..at].ends_with("fn "))
}

/// The tests of a file that ask whether slow campaigns are requested, by themselves or by a function of the file.
fn slow_forms(binary: &str, module: &str, text: &str) -> Vec<SlowForm> {
    let functions = functions(text);
    let mut slow: BTreeSet<&str> = BTreeSet::new();
    let asks = |function: &Function, slow: &BTreeSet<&str>| {
        ASKS.iter().any(|word| function.code.contains(word)) || slow.iter().any(|name| calls(&function.code, name))
    };
    loop {
        let more = functions.iter().find(|function| !slow.contains(function.name) && asks(function, &slow));
        let Some(more) = more else { break };
        slow.insert(more.name);
    }
    let has = |function: &Function, attribute: &str| function.attributes.iter().any(|line| line.starts_with(attribute));
    let tests = functions.iter().filter(|function| has(function, "#[test]") && slow.contains(function.name));
    let form = |function: &Function| SlowForm {
        binary: binary.to_owned(),
        name: [module, function.name].into_iter().filter(|part| !part.is_empty()).collect::<Vec<_>>().join("::"),
        is_ignored: has(function, concat!("#[", "ignore")),
    };
    tests.map(form).collect()
}

/// All tests with a slow form.
fn all_slow_forms() -> Vec<SlowForm> {
    let tests = root().join("tests");
    let of_binary = |(path, text): &(PathBuf, String)| {
        let inside = path.with_extension("");
        let inside = inside.strip_prefix(&tests).unwrap().to_str().unwrap();
        let (binary, file) = inside.split_once('/').unwrap_or((inside, ""));
        let helpers = ["common", "house"];
        if helpers.contains(&binary) { Vec::new() } else { slow_forms(binary, &file.replace('/', "::"), text) }
    };
    let of_binaries: Vec<SlowForm> = rust_files(&tests).iter().flat_map(of_binary).collect();
    let source = root().join("src");
    let sources = rust_files(&source);
    let of_library = sources.iter().flat_map(|(path, text)| {
        let name = path.file_name().unwrap().to_str().unwrap();
        let included = format!("#[path = \"{name}\"]\nmod tests;");
        let includes = |(other, text): &&(PathBuf, String)| other.parent() == path.parent() && text.contains(&included);
        let (home, inner) = sources.iter().find(includes).map_or((path, None), |(home, _)| (home, Some("tests")));
        let module = module_of(home.strip_prefix(&source).unwrap().to_str().unwrap());
        let in_file = if text.contains("#[cfg(test)]\nmod tests {") { Some("tests") } else { None };
        let module: Vec<&str> = module.iter().map(String::as_str).chain(inner).chain(in_file).collect();
        slow_forms("--lib", &module.join("::"), text)
    });
    of_binaries.into_iter().chain(of_library).collect()
}

/// The slow forms that a script leaves out, sorted: tests of a binary that it does not name, of no name that it asks for, skipped by a name,
/// or ignored.
fn left_out(script: &str, forms: &[SlowForm]) -> Vec<String> {
    let (_, command) = script.split_once("LUXMC_SLOW_TESTS=1").expect("slow campaigns");
    let command = command.replace("\\\n", " ");
    let command = command.lines().next().unwrap();
    let (binaries, names) = command.split_once(" -- ").expect("names of tests");
    let words: Vec<&str> = names.split_whitespace().collect();
    let skipped: Vec<&str> = words.windows(2).filter(|pair| pair[0] == "--skip").map(|pair| pair[1]).collect();
    let asked = words.iter().filter(|word| !word.starts_with('-') && !skipped.contains(word));
    let with_ignored = words.contains(&"--include-ignored");
    let is_run = |form: &&SlowForm| {
        let binary = if form.binary == "--lib" { " --lib ".to_owned() } else { format!(" --test {} ", form.binary) };
        format!("{binaries} ").contains(&binary)
            && asked.clone().any(|part| form.name.contains(part))
            && !skipped.iter().any(|part| form.name.contains(part))
            && (with_ignored || !form.is_ignored)
    };
    let names: BTreeSet<String> =
        forms.iter().filter(|form| !is_run(form)).map(|form| format!("{} {}", form.binary, form.name)).collect();
    names.into_iter().collect()
}

#[test]
fn all_slow_campaigns_are_run_before_a_change_lands() {
    let (script, forms) = (script(), all_slow_forms());
    assert!(forms.len() > 12 && forms.iter().any(|form| form.binary == "--lib"), "{} slow forms", forms.len());
    let known: Vec<&str> = LEFT_OUT.iter().map(|(name, _)| *name).collect();
    assert!(
        known.is_sorted() && LEFT_OUT.iter().all(|(_, reason)| reason.len() > 20),
        "a reason for each of {known:?}"
    );
    assert_eq!(left_out(&script, &forms), known, "slow forms that .ci/run leaves out, and those that may be");
}

#[test]
fn slow_campaigns_that_are_skipped_or_ignored_are_seen() {
    let text = "fn seeds() -> u64 {\n    if slow() { 300 } else { 8 }\n}\n\n#[test]\nfn quick() {}\n\n\
        #[test]\nfn by_itself() {\n    if slow() {}\n}\n\n#[test]\nfn by_a_helper() {\n    seeds();\n}\n\n\
        #[test]\nIGNORED\nfn ignored() {\n    seeds();\n}\n"
        .replace("IGNORED", concat!("#[", "ignore = \"takes long\"]"));
    let forms = slow_forms("rooms", "file", &text);
    let left_out = |arguments: &str| {
        left_out(&format!("LUXMC_SLOW_TESTS=1 cargo test --lib --test rooms \\\n    -- {arguments}\n"), &forms)
    };
    let [helper, itself, ignored] = ["rooms file::by_a_helper", "rooms file::by_itself", "rooms file::ignored"];
    assert_eq!(left_out("file::"), [ignored]);
    assert_eq!(left_out("file:: --include-ignored"), [""; 0]);
    assert_eq!(left_out("file:: --include-ignored --skip by_a"), [helper]);
    assert_eq!(left_out("file::by_a --include-ignored"), [itself, ignored]);
    assert_eq!(left_out("other::"), [helper, itself, ignored]);
}

#[test]
fn tests_that_the_test_command_leaves_out_are_run_before_a_change_lands() {
    let files: Vec<_> = ["src", "tests"].iter().flat_map(|folder| rust_files(&root().join(folder))).collect();
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
