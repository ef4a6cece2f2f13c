//! Runs `luxmc` on hostile inputs and checks its output: no abort, no run beyond its limits, no incomplete result, no NaN or infinity.
//! Every execution can be repeated with its seed.
//!
//!     cargo run --release --manifest-path fuzz/cli/Cargo.toml -- --luxmc target/release/luxmc --count 10000 --seed 1
//!
//! First the files of the corpus are run unchanged, with every method, and then mutations of them. Findings are kept with their files and
//! their command in `--keep`. The exit code is 1 if there are any.

mod mutate;
mod numbers;
mod random;
mod watch;

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use mutate::mutate;
use random::Random;
use watch::{Limits, run};

const METHODS: [&str; 7] = ["auto", "gather", "collision", "local", "local-naive", "light-mesh", "radiosity"];

/// The `--memory-limit` of all runs.
const MEMORY_KIB: u64 = 256 << 10;

struct Wishes {
    luxmc: PathBuf,
    corpus: PathBuf,
    keep: PathBuf,
    count: u64,
    first: u64,
    seed: u64,
    beyond_s: f64,
}

fn wishes() -> Result<Wishes, String> {
    let home = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut wishes = Wishes {
        luxmc: PathBuf::from("target/release/luxmc"),
        corpus: home.join("corpus"),
        keep: PathBuf::from("target/fuzz-cli"),
        count: 1000,
        first: 0,
        seed: 1,
        beyond_s: 1.0,
    };
    let mut arguments = std::env::args().skip(1);
    while let Some(name) = arguments.next() {
        let value = arguments.next().ok_or(format!("{name} needs a value"))?;
        let number = || value.parse::<u64>().map_err(|_| format!("{name}: not a whole number: {value}"));
        match name.as_str() {
            "--luxmc" => wishes.luxmc = value.into(),
            "--corpus" => wishes.corpus = value.into(),
            "--keep" => wishes.keep = value.into(),
            "--count" => wishes.count = number()?,
            "--first" => wishes.first = number()?,
            "--seed" => wishes.seed = number()?,
            "--beyond" => wishes.beyond_s = number()? as f64,
            _ => {
                return Err(format!(
                    "no option {name}; there are --luxmc, --corpus, --keep, --count, --first, --seed and --beyond"
                ));
            }
        }
    }
    Ok(wishes)
}

/// The folders of the corpus sorted by name: each holds a scene and the files that it names.
fn corpus(folder: &Path) -> Result<Vec<PathBuf>, String> {
    let entries = std::fs::read_dir(folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    let mut folders: Vec<PathBuf> = entries.flatten().map(|entry| entry.path()).filter(|path| path.is_dir()).collect();
    folders.sort();
    if folders.is_empty() { Err(format!("{}: no corpus", folder.display())) } else { Ok(folders) }
}

fn files_of(folder: &Path) -> Vec<PathBuf> {
    let mut files: Vec<PathBuf> =
        std::fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path()).collect();
    files.sort();
    files
}

/// Copies a folder of the corpus. If `random` is given, one or two of its files are changed.
fn lay_out(from: &Path, to: &Path, mut random: Option<&mut Random>) -> std::io::Result<()> {
    std::fs::remove_dir_all(to).ok();
    std::fs::create_dir_all(to)?;
    let files = files_of(from);
    // In folders with other files, the scene is changed every second time.
    let changed =
        random.as_mut().map(|random| if random.below(2) == 0 { usize::MAX } else { random.below(files.len()) });
    for (number, file) in files.iter().enumerate() {
        let Some(name) = file.file_name() else { continue };
        let bytes = std::fs::read(file)?;
        let is_changed =
            changed.is_some_and(|changed| changed == number || (changed == usize::MAX && name == "scene.json"));
        let bytes = match &mut random {
            Some(random) if is_changed => mutate(&bytes, random),
            _ => bytes,
        };
        std::fs::write(to.join(name), bytes)?;
    }
    Ok(())
}

/// Arguments of one execution and its limits.
fn arguments(method: &str, beyond_s: f64, random: &mut Random) -> (Vec<String>, Limits) {
    if random.below(6) == 0 {
        let mut all = vec!["inspect".to_owned(), "scene.json".to_owned()];
        all.extend((random.below(2) == 0).then(|| "--json".to_owned()));
        return (all, Limits { time_limit_s: 0.0, beyond_s, memory_kib: None, writes: false });
    }
    let time_limit_s = [0.03, 0.06, 0.1, 0.3][random.below(4)];
    let mut all: Vec<String> = [
        "solve",
        "scene.json",
        "--out",
        "out",
        "--quiet",
        "--threads",
        "1",
        "--memory-limit",
        "256MiB",
        "--method",
        method,
        "--time-limit",
    ]
    .map(str::to_owned)
    .to_vec();
    all.push(format!("{time_limit_s}"));
    let mut add = |name: &str, value: String| all.extend([name.to_owned(), value]);
    add("--seed", random.below(1000).to_string());
    if random.below(8) != 0 {
        add("--plots", "none".to_owned());
    }
    match random.below(4) {
        0 => add("--target-error", ["0.1%", "1%", "20%"][random.below(3)].to_owned()),
        1 if !["light-mesh", "radiosity"].contains(&method) => {
            add("--chains", ["1", "1000", "100000"][random.below(3)].to_owned());
        }
        _ => {}
    }
    match random.below(6) {
        0 => add("--maps", "all".to_owned()),
        1 => add("--maps", "elements".to_owned()),
        2 => add("--elements", "given".to_owned()),
        _ => {}
    }
    (all, Limits { time_limit_s, beyond_s, memory_kib: Some(MEMORY_KIB), writes: true })
}

fn campaign(wishes: &Wishes) -> Result<u64, String> {
    let folders = corpus(&wishes.corpus)?;
    let work = wishes.keep.join("work");
    let luxmc = std::fs::canonicalize(&wishes.luxmc).map_err(|error| format!("{}: {error}", wishes.luxmc.display()))?;
    let plain = (folders.len() * METHODS.len()) as u64;
    let mut findings = 0;
    let mut codes = std::collections::BTreeMap::new();
    for execution in wishes.first..wishes.first + wishes.count {
        let mut random = Random::of(wishes.seed, execution);
        let is_plain = execution < plain;
        let (folder, method) = if is_plain {
            (execution as usize / METHODS.len(), METHODS[execution as usize % METHODS.len()])
        } else {
            (random.below(folders.len()), METHODS[random.below(METHODS.len())])
        };
        let mutation = (!is_plain).then_some(&mut random);
        lay_out(&folders[folder], &work, mutation).map_err(|error| format!("{}: {error}", work.display()))?;
        let (arguments, limits) = arguments(method, wishes.beyond_s, &mut random);
        let mut outcome = run(&luxmc, &arguments, &work, &limits);
        // On a busy machine a run can be late once. A run that does not keep its limit is late again.
        if outcome.is_late {
            outcome = run(&luxmc, &arguments, &work, &limits);
        }
        *codes.entry(outcome.ended.clone()).or_insert(0) += 1;
        if let Some(fault) = outcome.fault {
            findings += 1;
            let kept = wishes.keep.join(format!("seed-{}-{execution}", wishes.seed));
            std::fs::remove_dir_all(&kept).ok();
            std::fs::rename(&work, &kept).map_err(|error| format!("{}: {error}", kept.display()))?;
            let command = format!("luxmc {}", arguments.join(" "));
            std::fs::write(kept.join("command.txt"), format!("{command}\n{fault}\n")).ok();
            println!(
                "execution {execution}, from {}: {fault}\n  {command}\n  in {}",
                folders[folder].display(),
                kept.display()
            );
        }
    }
    std::fs::remove_dir_all(&work).ok();
    let codes: Vec<String> = codes.iter().map(|(ended, count)| format!("{count} {ended}")).collect();
    println!("{} executions, seed {}: {}; {findings} findings", wishes.count, wishes.seed, codes.join(", "));
    Ok(findings)
}

fn main() -> ExitCode {
    match wishes().and_then(|wishes| campaign(&wishes)) {
        Ok(0) => ExitCode::SUCCESS,
        Ok(_) => ExitCode::FAILURE,
        Err(why) => {
            eprintln!("{why}");
            ExitCode::from(2)
        }
    }
}
