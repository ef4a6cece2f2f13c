//! Time to a target error on 1 and 2 threads: cube and office elements, office and hall receivers.
//!
//! `cargo bench --bench time_to_error` prints a table and writes it to `target/time_to_error.csv`. The hall needs its
//! mesh (`cargo run --release --example make_hall`) and is left out without it.

use std::path::Path;

use luxmc::scene::read_scene;
use luxmc::solver::{MapSelection, Observer, Progress, Settings, solve};

struct Silent;

impl Observer for Silent {
    fn progress(&self, _: &Progress) {}
    fn is_interrupted(&self) -> bool {
        false
    }
    fn wall_s(&self) -> f64 {
        0.0
    }
}

/// Scene, maps, and the target errors that a benchmark can wait for.
const RUNS: &[(&str, MapSelection, &[f64])] = &[
    ("cube", MapSelection::Elements, &[0.03, 0.01, 0.003]),
    ("office", MapSelection::Elements, &[0.03, 0.01]),
    ("office", MapSelection::Receivers, &[0.03, 0.01, 0.003]),
    ("hall", MapSelection::Receivers, &[0.03, 0.01]),
];

fn main() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut table = String::from("scene,maps,target_error,threads,compute_s,rays,estimated_error,speed_up\n");
    for (name, maps, targets) in RUNS {
        let path = root.join("scenes").join(format!("{name}.json"));
        let Ok(scene) = read_scene(&path) else {
            eprintln!("{name} is left out: it cannot be read (the hall's mesh is made by the example make_hall)");
            continue;
        };
        for target_error in *targets {
            let mut single_s = 0.0;
            for threads in [1, 2] {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a thread pool");
                let settings = Settings {
                    method: luxmc::solver::Method::Auto,
                    elements: luxmc::solver::ElementChoice::Given,
                    seed: 0,
                    target_error: Some(*target_error),
                    chains: None,
                    time_limit_s: None,
                    maps: maps.clone(),
                    threads: Some(threads),
                };
                let solution = pool.install(|| solve(&scene, &settings, &Silent));
                if threads == 1 {
                    single_s = solution.compute_s;
                }
                let row = format!(
                    "{name},{maps:?},{target_error},{threads},{:.3},{},{:.5},{:.2}\n",
                    solution.compute_s,
                    solution.rays,
                    solution.estimated_error,
                    single_s / solution.compute_s
                );
                eprint!("{row}");
                table.push_str(&row);
            }
        }
    }
    let file = root.join("target").join("time_to_error.csv");
    if let Err(error) = std::fs::write(&file, &table) {
        eprintln!("{}: {error}", file.display());
    }
    println!("{table}");
}
