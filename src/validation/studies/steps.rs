//! Study of the error of a mesh against its step and radius.

use glam::DVec3;

use super::pictures::{PlotLine, log_log};
use super::study_scene::{HALL_M, grid, hall, relative_rms};
use super::{Findings, StudyWishes};
use crate::light_mesh::{Accelerations, Options};
use crate::validation::report::Table;
use crate::validation::words::percent;

/// Radii in steps.
const RATIOS: [f64; 4] = [0.9, 1.25, 2.1, 3.1];
/// Below this step in m, receivers with wide radii share no mesh points any more. Finer steps then show nothing new.
const WIDE_FROM_M: f64 = 0.004;
/// Radii in steps that count as wide.
const WIDE: f64 = 2.0;

/// Study of the errors at steps from 0.8 m to 1 mm.
pub fn steps(wishes: &mut StudyWishes) -> Result<Findings, String> {
    let (steps_m, count): (&[f64], usize) = if wishes.quick {
        (&[0.8, 0.2, 0.05], 60)
    } else {
        (&[0.8, 0.4, 0.2, 0.1, 0.05, 0.02, 0.01, 0.004, 0.002, 0.001], 200)
    };
    let study = hall(7)?;
    let points_m = grid(DVec3::ZERO, [HALL_M, HALL_M], count);
    let exact = study.by_rays(&points_m, 1, f64::INFINITY);
    let mut found = Findings::of(
        "light-mesh-steps",
        "A black hall of 20 m × 20 m with 24 crates, 49 point lamps, a grid of receivers on its floor. Relative RMS errors against shadow rays.",
    );
    let mut lines = RATIOS.map(|ratio| PlotLine::new(format!("R = {ratio} h")));
    let mut rows = Vec::new();
    for step_m in steps_m {
        (wishes.tell)(&format!("h = {step_m} m"));
        let mut row = vec![step_m.to_string()];
        for (ratio, line) in RATIOS.iter().zip(&mut lines) {
            if *ratio > WIDE && *step_m < WIDE_FROM_M {
                row.push("–".to_owned());
                continue;
            }
            let options = Options { step_m: *step_m, radius_m: ratio * step_m, accelerations: Accelerations::ALL };
            let error = relative_rms(&study.by_mesh(&points_m, options)?, &exact);
            row.push(percent(error));
            line.places.push((*step_m, 100.0 * error));
        }
        rows.push(row);
    }
    if let (Some((first_m, first)), Some((last_m, last))) = (lines[1].places.first(), lines[1].places.last()) {
        let slope = (last / first).ln() / (last_m / first_m).ln();
        found.results.push(format!(
            "With R = 1.25 h the error falls from {} at {first_m} m to {} at {last_m} m, in proportion to h to the power of {slope:.2}.",
            percent(0.01 * first),
            percent(0.01 * last)
        ));
    }
    let header = vec!["step, m", "R/h = 0.9", "1.25", "2.1", "3.1"];
    found.tables.push(("Errors".to_owned(), Table { header, text_columns: Vec::new(), rows }));
    found.pictures.push(("Error against step".to_owned(), log_log(["step, m", "RMS error, %"], &lines)));
    Ok(found)
}
