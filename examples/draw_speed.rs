//! Draws the README's plot of speed against error, and prints its table, from the latest rows of `benches/history.csv`.
//!
//!     cargo bench --bench time_to_error -- --record
//!     cargo run --release --example draw_speed -- docs/images/speed-against-error.svg

use std::path::Path;

use luxmc::validation::studies::{PlotLine, log_log};

/// Targets in the columns of the table.
const TARGETS: [f64; 4] = [0.03, 0.01, 0.003, 0.001];
/// True errors in the columns of the second table.
const TRUE_ERRORS: [f64; 3] = [0.01, 0.003, 0.001];

/// Shorter forms of words in the history for which the legend has no room.
const SHORTER: [(&str, &str); 5] = [
    ("3072 elements as given", "given"),
    ("12 triangles that adapt", "adapting"),
    ("elements as given", "elements"),
    ("elements that adapt", "adapting"),
    (", receivers", ""),
];

/// A row of the history.
struct Row {
    date: String,
    machine: String,
    name: String,
    target_error: f64,
    compute_s: f64,
    true_error: String,
}

fn read(path: &Path) -> Result<Vec<Row>, String> {
    let wrong = |error: csv::Error| format!("{}: {error}", path.display());
    let mut reader = csv::Reader::from_path(path).map_err(wrong)?;
    let header = reader.headers().map_err(wrong)?.clone();
    let mut rows = Vec::new();
    for record in reader.records() {
        let record = record.map_err(wrong)?;
        let text = |column: &str| {
            let at = header.iter().position(|name| name == column);
            at.and_then(|at| record.get(at)).ok_or_else(|| format!("{}: no column {column}", path.display()))
        };
        let number = |column: &str| {
            text(column)?.parse::<f64>().map_err(|error| format!("{}: {column}: {error}", path.display()))
        };
        rows.push(Row {
            date: text("date")?.to_owned(),
            machine: text("machine")?.to_owned(),
            name: format!("{}, {}", text("scene")?, text("map")?),
            target_error: number("target_error")?,
            compute_s: number("compute_s")?,
            true_error: text("true_error")?.to_owned(),
        });
    }
    Ok(rows)
}

/// A number with two significant digits.
fn short(number: f64) -> String {
    let digits = (1.0 - number.abs().log10().floor()).clamp(0.0, 6.0) as usize;
    format!("{number:.digits$}")
}

/// Seconds to a true error, interpolated between runs with a larger and a smaller one. `known` holds true errors and seconds, largest error
/// first.
fn seconds_to(known: &[(f64, f64)], error: f64) -> Option<f64> {
    let around = known.windows(2).find(|pair| pair[0].0 >= error && error >= pair[1].0)?;
    let [(worse, sooner_s), (better, later_s)] = [around[0], around[1]];
    let share = (worse / error).ln() / (worse / better).ln();
    Some(sooner_s * (later_s / sooner_s).powf(share))
}

fn main() -> Result<(), String> {
    let out = std::env::args().nth(1).ok_or("name the SVG file to write")?;
    let rows = read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("benches/history.csv"))?;
    let last = rows.last().ok_or("the history is empty: cargo bench --bench time_to_error -- --record")?;
    let same: Vec<&Row> = rows.iter().filter(|row| row.machine == last.machine).collect();
    let mut names: Vec<&str> = Vec::new();
    same.iter().for_each(|row| {
        if !names.contains(&row.name.as_str()) {
            names.push(&row.name);
        }
    });
    let latest = |name: &str, target: f64| same.iter().rev().find(|row| row.name == name && row.target_error == target);

    println!("Seconds of computing on two threads (true error); {}, latest rows up to {}.\n", last.machine, last.date);
    println!("| scene, map | 3 % | 1 % | 0.3 % | 0.1 % |\n| --- | ---: | ---: | ---: | ---: |");
    let mut lines = Vec::new();
    for name in &names {
        let cells: Vec<String> = TARGETS
            .iter()
            .map(|target| match latest(name, *target) {
                None => "–".to_owned(),
                Some(row) => match row.true_error.parse::<f64>() {
                    Ok(error) => format!("{} s ({} %)", short(row.compute_s), short(100.0 * error)),
                    Err(_) => format!("{} s", short(row.compute_s)),
                },
            })
            .collect();
        println!("| {name} | {} |", cells.join(" | "));
        let places = TARGETS.iter().filter_map(|target| Some((100.0 * target, latest(name, *target)?.compute_s)));
        let short_name = SHORTER.iter().fold((*name).to_owned(), |name, (long, short)| name.replace(long, short));
        lines.push(PlotLine { name: short_name, places: places.collect() });
    }
    let picture = log_log(
        ["target error, %: 0.1, 0.3, 1 and 3 from left to right", "seconds of computing on two threads"],
        &lines,
    );
    println!("\nSeconds to a true error, between the rows by powers of it.\n");
    println!("| scene, map | 1 % | 0.3 % | 0.1 % |\n| --- | ---: | ---: | ---: |");
    for name in &names {
        let known = TARGETS.iter().filter_map(|target| {
            let row = latest(name, *target)?;
            Some((row.true_error.parse::<f64>().ok()?, row.compute_s))
        });
        let known: Vec<(f64, f64)> = known.collect();
        let cells = TRUE_ERRORS.map(|error| seconds_to(&known, error).map_or("–".to_owned(), short));
        if !known.is_empty() {
            println!("| {name} | {} |", cells.join(" | "));
        }
    }
    std::fs::write(&out, picture).map_err(|error| format!("{out}: {error}"))
}
