//! Study of the cost of a run as its scene grows: triangles, luminaires, receivers.

use std::fmt::Write as _;
use std::time::Instant;

use super::pictures::{PlotLine, log_log};
use super::slopes::Slope;
use super::{Findings, StudyWishes};
use crate::check::read_scene;
use crate::scene::Scene;
use crate::solver::{ElementChoice, MapSelection, Method, Settings, Solution, solve};
use crate::validation::measure::Stopwatch;
use crate::validation::report::Table;
use crate::validation::words::{grouped, significant};

/// Target error of every run.
const TARGET_ERROR: f64 = 0.01;
/// Number of runs of each size, with different seeds. Seconds are those of the fastest run, all else medians. Runs longer than
/// `DEAR_S` are not repeated.
const REPEATS: u64 = 3;
const DEAR_S: f64 = 30.0;
/// A slope above this counts as more than linear. The margin covers noise of the clock, and of the error check at which a run ends.
const LINEAR: f64 = 1.05;
/// Size of the room in m, and low and high corner of each piece of its furniture.
const ROOM_M: [f64; 3] = [8.0, 6.0, 3.0];
const FURNITURE_M: [[[f64; 3]; 2]; 6] = [
    [[1.0, 1.0, 0.02], [2.4, 1.8, 0.74]],
    [[1.0, 4.0, 0.02], [2.4, 4.8, 0.74]],
    [[4.0, 1.0, 0.02], [5.4, 1.8, 0.74]],
    [[4.0, 4.0, 0.02], [5.4, 4.8, 0.74]],
    [[6.9, 1.0, 0.02], [7.4, 5.0, 1.9]],
    [[3.1, 2.2, 0.02], [3.2, 3.8, 1.6]],
];
/// Height of luminaires and of receivers in m.
const LAMPS_M: f64 = 2.9;
const WORK_PLANE_M: f64 = 0.8;

const SETTING: &str = "A room of 8 m × 6 m × 3 m with desks, a cupboard and a partition, reflectances 0.2 to 0.7, illuminance on a work plane to 1 % by the method auto. Points inside furniture (one in twenty) are left out. Triangles: the same surfaces, split ever finer by a mesh file; 6 point luminaires, 1,024 receivers. Luminaires: one flux shared by more and more of them in a square array, as points that shine down and as square panels; 1,024 receivers, about 1,000 triangles. Receivers: an ever finer grid; 6 point luminaires. Three seeds of each size (one if a run takes over 30 s). Seconds are those of the fastest run, since other work on the machine only adds time; the rest are medians. Slopes are exponents: cost ∝ size^slope, through all sizes and between the two largest that differ by a factor of 8 or more; 1 is linear. Seconds depend on the machine and its load, rays do not.";

/// Results for one size.
struct SizeRow {
    size: f64,
    triangles: usize,
    luminaires: usize,
    receivers: usize,
    read_s: f64,
    build_s: f64,
    compute_s: f64,
    rays: f64,
    stated_error: f64,
    method: String,
}

/// The sizes of a scene.
struct Wish {
    /// Approximate number of triangles.
    triangles: usize,
    /// Numbers of luminaires along the two edges of the array, and whether they are panels.
    lamps: [usize; 2],
    panels: bool,
    /// Numbers of receivers along the edges of the grid.
    grid: [usize; 2],
}

/// Default sizes while another size changes.
const USUAL: Wish = Wish { triangles: 1000, lamps: [3, 2], panels: false, grid: [32, 32] };

/// Adds a mesh of right-angled triangles over the sides of a box. With `inward` they face inwards.
fn add_box(text: &mut String, vertices: &mut usize, [low, high]: [[f64; 3]; 2], edge_m: f64, inward: bool) {
    for axis in 0..3 {
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        let parts = [u, v].map(|k| (((high[k] - low[k]) / edge_m).round() as usize).max(1));
        for is_high in [false, true] {
            let first = *vertices + 1;
            for j in 0..=parts[1] {
                for i in 0..=parts[0] {
                    let mut at = [0.0; 3];
                    at[axis] = if is_high { high[axis] } else { low[axis] };
                    at[u] = low[u] + (high[u] - low[u]) * i as f64 / parts[0] as f64;
                    at[v] = low[v] + (high[v] - low[v]) * j as f64 / parts[1] as f64;
                    // Writing to a string cannot fail.
                    writeln!(text, "v {:.7} {:.7} {:.7}", at[0], at[1], at[2]).ok();
                    *vertices += 1;
                }
            }
            for j in 0..parts[1] {
                for i in 0..parts[0] {
                    let corner = |di: usize, dj: usize| first + (j + dj) * (parts[0] + 1) + i + di;
                    let (a, b, c, d) = (corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1));
                    if is_high != inward {
                        writeln!(text, "f {a} {b} {c}\nf {a} {c} {d}").ok();
                    } else {
                        writeln!(text, "f {a} {c} {b}\nf {a} {d} {c}").ok();
                    }
                }
            }
        }
    }
}

/// The room and its furniture with edges of about `edge_m`, as an OBJ file.
fn room_mesh(edge_m: f64) -> String {
    let (mut text, mut vertices) = (String::new(), 0);
    text.push_str("o room\nusemtl walls\n");
    add_box(&mut text, &mut vertices, [[0.0; 3], ROOM_M], edge_m, true);
    text.push_str("o furniture\nusemtl wood\n");
    for piece in FURNITURE_M {
        add_box(&mut text, &mut vertices, piece, edge_m, false);
    }
    text
}

/// Edge in m of the mesh's parts for this number of triangles.
fn edge_m_for(triangles: usize) -> f64 {
    let area = |size: [f64; 3]| 2.0 * (size[0] * size[1] + size[1] * size[2] + size[2] * size[0]);
    let furniture: f64 = FURNITURE_M.iter().map(|[low, high]| area([0, 1, 2].map(|k| high[k] - low[k]))).sum();
    (2.0 * (area(ROOM_M) + furniture) / triangles as f64).sqrt()
}

fn scene_text(wish: &Wish) -> String {
    let count = wish.lamps[0] * wish.lamps[1];
    let flux_lm = 18_000.0 / count as f64;
    let spacing = [0, 1].map(|k| ROOM_M[k] / wish.lamps[k] as f64);
    let first = spacing.map(|spacing_m| 0.5 * spacing_m);
    let mut panels = String::new();
    let luminaires = if wish.panels {
        // All panels together always cover the same share of the ceiling.
        let edges = spacing.map(|spacing_m| 0.3 * spacing_m);
        let mut luminaires = Vec::new();
        for index in 0..count {
            let at = [index % wish.lamps[0], index / wish.lamps[0]];
            let low = [0, 1].map(|k| first[k] + spacing[k] * at[k] as f64 - 0.5 * edges[k]);
            write!(
                panels,
                r#", {{ "name": "panel {index}", "type": "rectangle", "origin": [{},{},{LAMPS_M}], "u": [0,{},0], "v": [{},0,0], "material": "white" }}"#,
                low[0], low[1], edges[1], edges[0]
            )
            .ok();
            luminaires.push(format!(
                r#"{{ "name": "lamp {index}", "type": "area", "surface": "panel {index}", "luminous_flux_lm": {flux_lm} }}"#
            ));
        }
        luminaires.join(", ")
    } else {
        format!(
            r#"{{ "name": "lamps", "type": "point", "distribution": "lambertian", "position": [{},{},{LAMPS_M}], "luminous_flux_lm": {flux_lm}{} }}"#,
            first[0],
            first[1],
            if count == 1 {
                String::new()
            } else {
                let across = [0, 1].map(|k| ROOM_M[k] - spacing[k]);
                format!(
                    r#", "columns": {}, "rows": {}, "u": [{},0,0], "v": [0,{},0]"#,
                    wish.lamps[0], wish.lamps[1], across[0], across[1]
                )
            }
        )
    };
    format!(
        r#"{{ "version": 1,
            "materials": {{ "walls": {{ "type": "diffuse", "reflectance": 0.5 }}, "wood": {{ "type": "diffuse", "reflectance": 0.3 }},
                            "white": {{ "type": "diffuse", "reflectance": 0.7 }} }},
            "geometry": [ {{ "name": "room", "type": "mesh", "file": "room.obj", "materials": {{ "walls": "walls", "wood": "wood" }} }}{panels} ],
            "luminaires": [ {luminaires} ],
            "receivers": [ {{ "name": "work plane", "type": "grid", "origin": [0.25,0.25,{WORK_PLANE_M}], "u": [7.5,0,0], "v": [0,5.5,0],
                             "columns": {}, "rows": {} }} ] }}"#,
        wish.grid[0], wish.grid[1]
    )
}

/// The scene, and the seconds to read it.
fn scene_of(wish: &Wish) -> Result<(Scene, f64), String> {
    let folder = tempfile::tempdir().map_err(|error| format!("a temporary folder: {error}"))?;
    let wrong = |error: std::io::Error| format!("{}: {error}", folder.path().display());
    std::fs::write(folder.path().join("room.obj"), room_mesh(edge_m_for(wish.triangles))).map_err(wrong)?;
    let file = folder.path().join("scene.json");
    std::fs::write(&file, scene_text(wish)).map_err(wrong)?;
    let started = Instant::now();
    let scene = read_scene(&file).map_err(|error| error.to_string())?;
    Ok((scene, started.elapsed().as_secs_f64()))
}

fn measure(wish: &Wish, size_of: fn(&SizeRow) -> f64, wishes: &mut StudyWishes) -> Result<SizeRow, String> {
    let (scene, read_s) = scene_of(wish)?;
    let luminaires = wish.lamps[0] * wish.lamps[1];
    let receivers = wish.grid[0] * wish.grid[1];
    let mut runs: Vec<Solution> = Vec::new();
    for seed in 0..REPEATS {
        let settings = Settings {
            method: Method::Auto,
            elements: ElementChoice::Given,
            seed,
            target_error: Some(TARGET_ERROR),
            maps: MapSelection::Receivers,
            ..Settings::default()
        };
        runs.push(solve(&scene, &settings, &Stopwatch::starting_now()));
        if wishes.quick || runs.iter().any(|run| run.compute_s > DEAR_S) {
            break;
        }
    }
    let median = |of: fn(&Solution) -> f64| {
        let mut numbers: Vec<f64> = runs.iter().map(of).collect();
        numbers.sort_by(f64::total_cmp);
        numbers[numbers.len() / 2]
    };
    let least = |of: fn(&Solution) -> f64| runs.iter().map(of).fold(f64::INFINITY, f64::min);
    let mut methods: Vec<&str> = runs.iter().flat_map(|run| &run.maps).map(|map| map.method.as_str()).collect();
    methods.sort_unstable();
    methods.dedup();
    let mut row = SizeRow {
        size: 0.0,
        triangles: scene.triangles.len(),
        luminaires,
        receivers,
        read_s,
        build_s: least(|run| run.build_s),
        compute_s: least(|run| run.compute_s),
        rays: median(|run| run.rays as f64),
        stated_error: median(|run| run.estimated_error),
        method: methods.join(" and "),
    };
    row.size = size_of(&row);
    (wishes.tell)(&format!(
        "{} triangles, {luminaires} luminaires, {receivers} receivers: {} s",
        row.triangles,
        significant(row.compute_s, 3)
    ));
    Ok(row)
}

/// A cost with its name.
type Named = (&'static str, fn(&SizeRow) -> f64);

const COSTS: [Named; 4] = [
    ("computing", |row| row.compute_s),
    ("rays", |row| row.rays),
    ("reading", |row| row.read_s),
    ("building", |row| row.build_s),
];

fn sizes_table(rows: &[SizeRow]) -> Table {
    let cells = |row: &SizeRow| {
        vec![
            grouped(row.triangles as u64),
            grouped(row.luminaires as u64),
            grouped(row.receivers as u64),
            significant(row.read_s, 2),
            significant(row.build_s, 2),
            significant(row.compute_s, 3),
            grouped(row.rays as u64),
            significant(row.rays * 1e-6 / row.compute_s, 3),
            significant(100.0 * row.stated_error, 3),
            row.method.clone(),
        ]
    };
    Table {
        header: vec![
            "triangles",
            "luminaires",
            "receivers",
            "reading, s",
            "building, s",
            "computing, s",
            "rays",
            "million rays a second",
            "stated error, %",
            "method",
        ],
        text_columns: vec![9],
        rows: rows.iter().map(cells).collect(),
    }
}

/// Adds tables and pictures of a series to the findings, and its slopes to the list of all slopes.
fn add(found: &mut Findings, what: &str, rows: &[SizeRow], slopes: &mut Vec<Vec<String>>, above: &mut Vec<String>) {
    let mut lines = Vec::new();
    for (cost, of) in COSTS {
        let places: Vec<(f64, f64)> = rows.iter().map(|row| (row.size, of(row))).collect();
        if let Some(slope) = Slope::through(&places) {
            slopes.push(vec![
                what.to_owned(),
                cost.to_owned(),
                format!("{:.2} ± {:.2}", slope.fitted, slope.standard_error).replace('-', "−"),
                format!("{:.2}", slope.last).replace('-', "−"),
            ]);
            if slope.fitted > LINEAR || slope.last > LINEAR {
                above.push(format!("{cost} over {what} ({:.2}, at the end {:.2})", slope.fitted, slope.last));
            }
        }
        if cost != "rays" {
            lines.push(PlotLine { name: format!("{cost}, s"), places });
        }
    }
    found.tables.push((format!("More and more {what}"), sizes_table(rows)));
    found.pictures.push((format!("Seconds against the number of {what}"), log_log([what, "seconds"], &lines)));
    let rays = [PlotLine { name: "rays".to_owned(), places: rows.iter().map(|row| (row.size, row.rays)).collect() }];
    found.pictures.push((format!("Rays against the number of {what}"), log_log([what, "rays"], &rays)));
}

/// Study of the cost against triangles, luminaires and receivers.
pub fn scaling(wishes: &mut StudyWishes) -> Result<Findings, String> {
    let mut found = Findings::of("scaling", SETTING);
    let (mut slopes, mut above) = (Vec::new(), Vec::new());

    let triangles: &[usize] =
        if wishes.quick { &[1000, 10_000] } else { &[1000, 3000, 10_000, 30_000, 100_000, 300_000, 1_000_000] };
    let mut rows = Vec::new();
    for triangles in triangles {
        rows.push(measure(&Wish { triangles: *triangles, ..USUAL }, |row| row.triangles as f64, wishes)?);
    }
    add(&mut found, "triangles", &rows, &mut slopes, &mut above);

    let lamps: &[[usize; 2]] =
        if wishes.quick { &[[1, 1], [4, 3]] } else { &[[1, 1], [2, 2], [4, 3], [8, 5], [12, 9], [20, 16], [40, 25]] };
    for (what, panels) in [("point luminaires", false), ("panels", true)] {
        let mut rows = Vec::new();
        for lamps in lamps {
            let wish = Wish { lamps: *lamps, panels, ..USUAL };
            rows.push(measure(&wish, |row| row.luminaires as f64, wishes)?);
        }
        add(&mut found, what, &rows, &mut slopes, &mut above);
    }

    let grids: &[[usize; 2]] = if wishes.quick {
        &[[10, 10], [32, 32]]
    } else {
        &[[10, 10], [20, 16], [40, 25], [64, 50], [125, 80], [200, 160], [400, 250], [640, 500], [1250, 800]]
    };
    let mut rows = Vec::new();
    for grid in grids {
        rows.push(measure(&Wish { grid: *grid, ..USUAL }, |row| row.receivers as f64, wishes)?);
    }
    add(&mut found, "receivers", &rows, &mut slopes, &mut above);

    found.results.push(if above.is_empty() {
        format!("No slope is above linear (by more than {:.2}).", LINEAR - 1.0)
    } else {
        format!("Above linear: {}.", above.join("; "))
    });
    if let (Some(first), Some(last)) = (triangles.first(), triangles.last()) {
        let [first, last] = [*first as f64, *last as f64];
        let sorting = 1.0 + (last.ln().ln() - first.ln().ln()) / (last.ln() - first.ln());
        found.results.push(format!(
            "Reading and building sort triangles, which takes n log n: over all sizes that corresponds to a slope of {sorting:.2}."
        ));
    }
    let header = vec!["against", "cost", "slope of all sizes", "slope at the end"];
    found.tables.insert(0, ("Slopes".to_owned(), Table { header, text_columns: vec![0, 1], rows: slopes }));
    Ok(found)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// For any cutting the room is closed, its surfaces face inwards, and its area stays the same.
    #[test]
    fn cutting_finer_changes_no_surface() {
        let areas = [1000, 4000].map(|triangles| {
            let (scene, _) = scene_of(&Wish { triangles, ..USUAL }).expect("a scene");
            let count = scene.triangles.len() as f64 / triangles as f64;
            assert!((0.7..1.4).contains(&count), "{count}");
            // Furniture crosses the work plane, and no maintenance factor is set. Any other warning means a fault of the mesh.
            let known = |warning: &&String| warning.contains("maintenance_factor") || warning.contains("closed solid");
            assert_eq!(scene.warnings.iter().filter(known).count(), scene.warnings.len(), "{:?}", scene.warnings);
            scene.area_m2()
        });
        assert!((areas[0] / areas[1] - 1.0).abs() < 1e-6, "{areas:?}");
    }

    #[test]
    fn panels_and_points_bring_the_same_flux() {
        for panels in [false, true] {
            let (scene, _) = scene_of(&Wish { lamps: [4, 3], panels, ..USUAL }).expect("a scene");
            let flux_lm: f64 = scene.luminaires.iter().map(|luminaire| luminaire.luminous_flux_lm).sum();
            assert!((flux_lm - 18_000.0).abs() < 1e-6, "{flux_lm}");
        }
    }
}
