//! Study of the size from which light meshes are faster: time and rays against the number of luminaires and of receivers.

use glam::DVec3;

use super::pictures::{PlotLine, log_log};
use super::study_scene::{HALL_M, Lit, grid, hall, relative_rms};
use super::{Findings, StudyWishes};
use crate::light_mesh::{Accelerations, Options, RADIUS_PER_STEP};
use crate::validation::report::Table;
use crate::validation::words::{grouped, percent, significant};

/// Step of the mesh in m.
const STEP_M: f64 = 0.1;
/// Maximum number of shadow rays of a run. Beyond it only every n-th receiver sends rays, and the time is scaled up.
const MOST_RAYS: f64 = 4e7;

const SETTING: &str = "A black hall of 20 m × 20 m × 4 m with 24 crates, point lamps in a square array under its ceiling, a grid of receivers on its floor. Mesh: h = 0.1 m, R = 1.25 h, all accelerations. Errors are relative RMS errors against shadow rays. Times marked * were measured on a subset of the receivers, evenly spread, and scaled to all.";

/// One size of the problem.
struct CrossingRow {
    luminaires: usize,
    receivers: usize,
    rays: Lit,
    mesh: Lit,
    error: f64,
}

fn measure(edge: usize, count: usize, wishes: &mut StudyWishes) -> Result<CrossingRow, String> {
    let study = hall(edge)?;
    let points_m = grid(DVec3::ZERO, [HALL_M, HALL_M], count);
    let options = Options { step_m: STEP_M, radius_m: RADIUS_PER_STEP * STEP_M, accelerations: Accelerations::ALL };
    (wishes.tell)(&format!("{} luminaires, {count}² receivers", edge * edge));
    let mesh = study.by_mesh(&points_m, options)?;
    let rays = study.by_rays(&points_m, 1, MOST_RAYS);
    let error = relative_rms(&mesh, &rays);
    Ok(CrossingRow { luminaires: edge * edge, receivers: points_m.len(), rays, mesh, error })
}

fn table(rows: &[CrossingRow]) -> Table {
    let cells = |row: &CrossingRow| {
        let mark = if row.rays.every > 1 { "*" } else { "" };
        vec![
            grouped(row.luminaires as u64),
            grouped(row.receivers as u64),
            grouped(row.rays.rays),
            grouped(row.mesh.rays),
            significant(row.rays.rays as f64 / row.mesh.rays.max(1) as f64, 3),
            format!("{}{mark}", significant(row.rays.seconds, 3)),
            significant(row.mesh.seconds, 3),
            significant(row.rays.seconds / row.mesh.seconds, 3),
            percent(row.error),
        ]
    };
    Table {
        header: vec![
            "luminaires",
            "receivers",
            "shadow rays",
            "rays of the mesh",
            "rays saved by",
            "time of shadow rays, s",
            "time of the mesh, s",
            "faster by",
            "RMS error",
        ],
        text_columns: Vec::new(),
        rows: rows.iter().map(cells).collect(),
    }
}

/// Size at which a ratio passes 1, interpolated between measured sizes by straight lines on logarithmic axes.
fn crossing(rows: &[CrossingRow], size: fn(&CrossingRow) -> f64, gain: fn(&CrossingRow) -> f64) -> Option<f64> {
    let pair = rows.windows(2).find(|pair| gain(&pair[0]) < 1.0 && gain(&pair[1]) >= 1.0)?;
    let (low, high) = (gain(&pair[0]).ln(), gain(&pair[1]).ln());
    let share = -low / (high - low);
    Some(((1.0 - share) * size(&pair[0]).ln() + share * size(&pair[1]).ln()).exp())
}

/// Rounds a size to two digits, since the interpolation is not more accurate.
fn two_digits(size: f64) -> u64 {
    let unit = 10f64.powf(size.log10().floor() - 1.0).max(1.0);
    ((size / unit).round() * unit) as u64
}

fn by_time(row: &CrossingRow) -> f64 {
    row.rays.seconds / row.mesh.seconds
}

fn by_count(row: &CrossingRow) -> f64 {
    row.rays.rays as f64 / row.mesh.rays.max(1) as f64
}

fn tell_crossing(rows: &[CrossingRow], what: &str, size: fn(&CrossingRow) -> f64) -> String {
    let words = |gain: fn(&CrossingRow) -> f64| match crossing(rows, size, gain) {
        Some(size) => format!("from about {} {what} on", grouped(two_digits(size))),
        None if rows.iter().all(|row| gain(row) >= 1.0) => format!("with every tested number of {what}"),
        None => format!("with no tested number of {what}"),
    };
    format!("The mesh is faster {}; it sends fewer rays {}.", words(by_time), words(by_count))
}

fn finish(name: &'static str, rows: &[CrossingRow], what: &str, size: fn(&CrossingRow) -> f64) -> Findings {
    let mut found = Findings::of(name, SETTING);
    found.results.push(tell_crossing(rows, what, size));
    if let Some(best) = rows.iter().max_by(|one, other| by_time(one).total_cmp(&by_time(other))) {
        found.results.push(format!(
            "With {} luminaires and {} receivers it is {} times as fast, with an error of {}.",
            best.luminaires,
            grouped(best.receivers as u64),
            significant(by_time(best), 3),
            percent(best.error)
        ));
    }
    found.tables.push(("Rays and times".to_owned(), table(rows)));
    for (axis, of) in [("time, s", (|lit| lit.seconds) as fn(&Lit) -> f64), ("rays", |lit| lit.rays as f64)] {
        let lines = [("shadow rays", 0), ("light mesh", 1)].map(|(name, which)| PlotLine {
            name: name.to_owned(),
            places: rows.iter().map(|row| (size(row), of(if which == 0 { &row.rays } else { &row.mesh }))).collect(),
        });
        found.pictures.push((format!("{axis} against the number of {what}"), log_log([what, axis], &lines)));
    }
    found
}

/// Study of time against the number of luminaires, 1 to 225.
pub fn over_luminaires(wishes: &mut StudyWishes) -> Result<Findings, String> {
    let (edges, count): (&[usize], usize) =
        if wishes.quick { (&[1, 3, 8], 80) } else { (&[1, 2, 3, 5, 7, 8, 10, 15], 500) };
    let rows = edges.iter().map(|edge| measure(*edge, count, wishes)).collect::<Result<Vec<_>, _>>()?;
    Ok(finish("light-mesh-luminaires", &rows, "luminaires", |row| row.luminaires as f64))
}

/// Study of time against the number of receivers, 50² to 2,000².
pub fn over_receivers(wishes: &mut StudyWishes) -> Result<Findings, String> {
    let (edge, counts): (usize, &[usize]) =
        if wishes.quick { (3, &[20, 60, 150]) } else { (8, &[50, 125, 250, 500, 1000, 2000]) };
    let rows = counts.iter().map(|count| measure(edge, *count, wishes)).collect::<Result<Vec<_>, _>>()?;
    Ok(finish("light-mesh-receivers", &rows, "receivers", |row| row.receivers as f64))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Shadow rays cost 1 for each of n receivers, the mesh 100 for any n. They cross at 100, not at 101.
    #[test]
    fn the_crossing_is_where_both_cost_the_same() {
        let row = |n: usize, mesh: f64| CrossingRow {
            luminaires: n,
            receivers: 1,
            rays: Lit { seconds: n as f64, ..Lit::default() },
            mesh: Lit { seconds: mesh, ..Lit::default() },
            error: 0.0,
        };
        let at = |mesh: f64| {
            let rows = [10, 50, 300].map(|n| row(n, mesh));
            crossing(&rows, |row| row.luminaires as f64, by_time).expect("they cross")
        };
        assert!((at(100.0) - 100.0).abs() < 1e-9, "{}", at(100.0));
        assert!((at(101.0) - 100.0).abs() > 0.5);
        assert!(crossing(&[row(10, 1.0), row(20, 1.0)], |row| row.luminaires as f64, by_time).is_none());
        assert_eq!([1.68, 32_849.0, 99.6].map(two_digits), [2, 33_000, 100]);
    }
}
