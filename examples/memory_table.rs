//! Memory per triangle, element, receiver, luminaire, and gathering ray: the difference of the peaks of two runs of the program, divided by
//! the difference of their counts. The same for a cell and for a sample in it, by filling cells only.
//!
//!     cargo build --release && cargo run --release --example memory_table -- target/release/luxmc

use std::error::Error;
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use glam::DVec3;
use luxmc::base::memory::{CountedMemory, peak_bytes};
use luxmc::caches::{CellGrid, CellLight, CellSample, Lookup};
use serde_json::Value;

#[global_allocator]
static MEMORY: CountedMemory = CountedMemory;

/// What is counted: its name, the condition, a scene with about that number of it, and arguments.
struct Row {
    name: &'static str,
    condition: &'static str,
    counts: [usize; 2],
    scene: fn(usize, &Path) -> std::io::Result<String>,
    arguments: &'static [&'static str],
    /// The exact count, from the summary.
    count_of: fn(&Value) -> f64,
}

const ONE_POINT: &str =
    r#"{ "name": "p", "type": "grid", "origin": [1,1,1], "u": [1,0,0], "v": [0,1,0], "columns": 1, "rows": 1 }"#;
const LAMP: &str = r#"{ "name": "l", "type": "point", "position": [5,5,2.5], "luminous_flux_lm": 1000 }"#;
const WALKS: &[&str] = &["--method", "collision", "--chains", "1", "--maps", "receivers"];

fn scene(geometry: &str, edge: &str, luminaires: &str, receivers: &str) -> String {
    format!(
        r#"{{ "version": 1, "materials": {{ "m": {{ "type": "diffuse", "reflectance": 0.5 }} }},
  "geometry": [ {{ "name": "room", "type": "box", "min": [0,0,0], "max": [10,10,3], "facing": "inward", "material": "m"{edge} }}{geometry} ],
  "luminaires": [ {luminaires} ], "receivers": [ {receivers} ] }}"#
    )
}

/// A terrain of about `count` triangles in an OBJ file.
fn triangles(count: usize, folder: &Path) -> std::io::Result<String> {
    let side = (0.5 * count as f64).sqrt() as usize;
    let mut text = String::new();
    for (i, j) in (0..=side).flat_map(|i| (0..=side).map(move |j| (i, j))) {
        let (x, y) = (1.0 + 8.0 * i as f64 / side as f64, 1.0 + 8.0 * j as f64 / side as f64);
        writeln!(text, "v {x} {y} {}", 0.2 + 0.05 * (3.0 * x).sin() * (2.0 * y).cos()).ok();
    }
    for (i, j) in (0..side).flat_map(|i| (0..side).map(move |j| (i, j))) {
        let corner = |i: usize, j: usize| i * (side + 1) + j + 1;
        let [a, b, c, d] = [corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)];
        writeln!(text, "f {a} {b} {c}\nf {a} {c} {d}").ok();
    }
    std::fs::write(folder.join("terrain.obj"), text)?;
    let mesh = r#", { "name": "terrain", "type": "mesh", "file": "terrain.obj", "material": "m", "two_sided": true }"#;
    Ok(scene(mesh, "", LAMP, ONE_POINT))
}

fn elements(count: usize, _: &Path) -> std::io::Result<String> {
    let edge = (2.0 * 320.0 / count as f64).sqrt();
    Ok(scene("", &format!(r#", "max_element_edge": {edge}"#), LAMP, ONE_POINT))
}

fn points(count: usize, _: &Path) -> std::io::Result<String> {
    let side = (count as f64).sqrt() as usize;
    let grid = format!(
        r#"{{ "name": "p", "type": "grid", "origin": [1,1,1], "u": [8,0,0], "v": [0,8,0], "columns": {side}, "rows": {side} }}"#
    );
    Ok(scene("", "", LAMP, &grid))
}

fn luminaires(count: usize, _: &Path) -> std::io::Result<String> {
    let array = format!(
        r#"{{ "name": "l", "type": "point", "distribution": "lambertian", "position": [1,1,2.5], "luminous_flux_lm": 10,
        "columns": {}, "rows": 100, "u": [8,0,0], "v": [0,8,0] }}"#,
        count / 100
    );
    Ok(scene("", "", &array, ONE_POINT))
}

fn rays(_: usize, folder: &Path) -> std::io::Result<String> {
    points(2500, folder)
}

fn map_rays(summary: &Value) -> f64 {
    ["gathering", "cells"].iter().filter_map(|kind| summary["spent"][kind]["rays"].as_f64()).sum()
}

fn number(key: &'static str, summary: &Value) -> f64 {
    summary[key].as_f64().unwrap_or(0.0)
}

const fn receivers(condition: &'static str, arguments: &'static [&'static str]) -> Row {
    Row {
        name: "receiver",
        condition,
        counts: [10_000, 40_000],
        scene: points,
        arguments,
        count_of: |summary| number("count", summary),
    }
}

const ROWS: [Row; 8] = [
    Row {
        name: "triangle of a mesh file",
        condition: "read from OBJ, two-sided, one receiver",
        counts: [50_000, 200_000],
        scene: triangles,
        arguments: WALKS,
        count_of: |summary| number("triangles", summary),
    },
    Row {
        name: "element",
        condition: "as given, by counting, with `elements.csv`, `scene.vtp` and `scene.glb`",
        counts: [20_000, 80_000],
        scene: elements,
        arguments: &["--method", "collision", "--chains", "1", "--maps", "elements", "--elements", "given"],
        count_of: |summary| number("elements", summary),
    },
    Row {
        name: "element",
        condition: "that adapts and gathers, with the same files",
        counts: [20_000, 80_000],
        scene: elements,
        arguments: &["--method", "gather", "--chains", "1", "--maps", "elements"],
        count_of: |summary| number("elements", summary),
    },
    receivers("of a grid, by walks, with `receivers.csv`", WALKS),
    receivers("the same by gathering", &["--method", "gather", "--chains", "1", "--maps", "receivers"]),
    receivers("the same by local estimation", &["--method", "local", "--chains", "1", "--maps", "receivers"]),
    Row {
        name: "luminaire",
        condition: "of an array, one receiver",
        counts: [50_000, 200_000],
        scene: luminaires,
        arguments: WALKS,
        count_of: |summary| number("count", summary),
    },
    Row {
        name: "ray that fills or looks up cells",
        condition: "2,500 receivers by gathering to 1 and 0.1 %",
        counts: [0, 1],
        scene: rays,
        arguments: &["--method", "gather", "--maps", "receivers", "--target-error"],
        count_of: map_rays,
    },
];

/// Runs the program and returns its peak memory in bytes and the count.
fn measure(luxmc: &Path, row: &Row, run: usize, folder: &Path) -> Result<(f64, f64), Box<dyn Error>> {
    let count = row.counts[run];
    std::fs::write(folder.join("scene.json"), (row.scene)(count, folder)?)?;
    let mut command = Command::new(luxmc);
    command.arg("solve").arg(folder.join("scene.json")).args(row.arguments);
    if row.arguments.last() == Some(&"--target-error") {
        command.arg(["1%", "0.1%"][run]);
    }
    let out = folder.join("out");
    command.args(["--plots", "none", "--quiet", "--threads", "1", "--out"]).arg(&out);
    let status = command.stdout(Stdio::null()).stderr(Stdio::null()).status()?;
    if !matches!(status.code(), Some(0 | 3)) {
        return Err(format!("{}: {status}", row.name).into());
    }
    let mut summary: Value = serde_json::from_slice(&std::fs::read(out.join("summary.json"))?)?;
    summary["count"] = count.into();
    Ok((number("peak_memory_bytes", &summary), (row.count_of)(&summary)))
}

/// Cells along either edge of a square of 10 m, and samples in each, of two fillings.
const CELLS: [[usize; 2]; 2] = [[400, 1], [800, 1]];
const SAMPLES: [[usize; 2]; 2] = [[800, 2], [800, 8]];

/// Fills cells with samples and solves for their light. Returns the peak memory so far, the number of cells and that of samples.
fn fill_cells([across, samples]: [usize; 2]) -> [f64; 3] {
    let mut cells = CellLight::new(CellGrid::new([DVec3::ZERO, DVec3::splat(10.0)], [0.3; 3], 0.1));
    let lookups = (0..across * across).map(|place| {
        let [column, row] = [place % across, place / across].map(|number| (number as f64 + 0.5) * 10.0 / across as f64);
        let point_m = DVec3::new(column, row, 0.0);
        Lookup { point_m, normal: DVec3::Z, distance_m: 0.1 }
    });
    let look_up = |lookup: Lookup| {
        let key = cells.grid.key(&lookup, |_| true);
        cells.grid.cell(key)
    };
    let asked: Vec<u32> = lookups.map(look_up).collect();
    for (place, cell) in asked.iter().enumerate() {
        for _ in 0..samples {
            cells.book(*cell);
            let next = asked[(place + 1) % asked.len()];
            cells.add(CellSample { cell: *cell, plain_lx: 100.0, reflectance: 0.5, next });
        }
    }
    cells.solve();
    [peak_bytes() as f64, cells.grid.len() as f64, cells.sample_count() as f64]
}

fn print_row(name: &str, condition: &str, [first, second]: [(f64, f64); 2]) {
    println!(
        "| {name} | {condition} | {:.0}; {:.0} | {:.1}; {:.1} | {:.0} |",
        first.1,
        second.1,
        first.0 / 1e6,
        second.0 / 1e6,
        (second.0 - first.0) / (second.1 - first.1)
    );
}

fn main() -> Result<(), Box<dyn Error>> {
    let luxmc = PathBuf::from(std::env::args().nth(1).unwrap_or_else(|| "target/release/luxmc".to_owned()));
    let folder = tempfile::tempdir()?;
    println!("| a | where | numbers | peak in MB | bytes each |\n| --- | --- | ---: | ---: | ---: |");
    for row in &ROWS {
        let [first, second] = [measure(&luxmc, row, 0, folder.path())?, measure(&luxmc, row, 1, folder.path())?];
        print_row(row.name, row.condition, [first, second]);
    }
    let cells = CELLS.map(fill_cells).map(|[peak, cells, _]| (peak, cells));
    print_row("cell of the gathering cache", "with one sample, solved for", cells);
    let samples = SAMPLES.map(fill_cells).map(|[peak, _, samples]| (peak, samples));
    print_row("further sample in a cell", "in 640,000 places, solved for", samples);
    Ok(())
}
