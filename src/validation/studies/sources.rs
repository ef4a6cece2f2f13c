//! Study of the method that the papers compare with: an area replaced by a number of point sources.

use glam::DVec3;

use super::pictures::{PlotLine, log_log};
use super::study_scene::{HALL_M, Lit, StudyScene, grid, hall_with_crates, relative_rms};
use super::{Findings, StudyWishes};
use crate::light_mesh::{Accelerations, Options, RADIUS_PER_STEP};
use crate::validation::report::Table;
use crate::validation::words::{grouped, percent, significant};

/// Number of points that replace an area (Debelov and Novikov 2009 show 1, 5 and 225).
const COUNTS: [usize; 4] = [1, 5, 25, 225];
/// Times of the paper in its own units, where it gives them.
const PAPER: [Option<f64>; 4] = [Some(2.0), Some(6.0), None, Some(172.0)];
/// Points of the dense quadrature that is the truth, and number of receivers for which it is computed.
const DENSE: usize = 64 * 64;
const PLACES: usize = 4096;
/// Step of the mesh in m.
const MESH_STEP_M: f64 = 0.1;

/// Study of time, rays and error for each number of points, and for the mesh.
pub fn sources(wishes: &mut StudyWishes) -> Result<Findings, String> {
    let count = if wishes.quick { 64 } else { 500 };
    let mut found = Findings::of(
        "light-mesh-sources",
        "A black hall of 20 m × 20 m with 24 crates under one bright ball of 0.3 m at a height of 3.5 m; a grid of receivers on its floor. The ball is replaced by 1, 5, 25 or 225 points with a shadow ray to each; the mesh (h = 0.1 m, R = 1.25 h) uses 64 points on it. Errors are against a quadrature with 4,096 points on the ball. Debelov and Novikov (2009) report times of 2 : 6 : 172 for pictures with 1, 5 and 225 sources. A picture sends a view ray to every point besides the shadow rays: counted in this way, N sources cost 1 + N rays a point.",
    );
    let ball =
        r#"{ "name": "ball", "type": "sphere", "center": [9.3,10.4,3.5], "radius": 0.3, "luminous_flux_lm": 5000 }"#;
    let study = StudyScene::black(&hall_with_crates(), ball)?;
    let points_m = grid(DVec3::ZERO, [HALL_M, HALL_M], count);
    (wishes.tell)("the truth by a dense quadrature");
    let exact = study.by_points(&points_m, DENSE, (DENSE * PLACES.min(points_m.len())) as f64);
    let mut lines = [PlotLine::new("point sources"), PlotLine::new("light mesh")];
    let mut rows = Vec::new();
    let mut first_s = None;
    let mut ratios = Vec::new();
    let mut row = |name: String, lit: &Lit, paper: Option<f64>| {
        let first_s = *first_s.get_or_insert(lit.seconds);
        ratios.push(lit.seconds / first_s);
        vec![
            name,
            grouped(lit.rays),
            significant(lit.seconds, 3),
            significant(lit.seconds / first_s, 3),
            significant(1.0 + lit.rays as f64 / points_m.len() as f64, 3),
            paper.map_or("–".to_owned(), |paper| significant(paper, 3)),
            percent(relative_rms(lit, &exact)),
        ]
    };
    for (number, paper) in COUNTS.into_iter().zip(PAPER) {
        (wishes.tell)(&format!("{number} points"));
        let lit = study.by_points(&points_m, number, f64::INFINITY);
        lines[0].places.push((lit.seconds, 100.0 * relative_rms(&lit, &exact)));
        rows.push(row(if number == 1 { "1 point".to_owned() } else { format!("{number} points") }, &lit, paper));
    }
    (wishes.tell)("the mesh");
    let options =
        Options { step_m: MESH_STEP_M, radius_m: RADIUS_PER_STEP * MESH_STEP_M, accelerations: Accelerations::ALL };
    let lit = study.by_mesh(&points_m, options)?;
    lines[1].places.push((lit.seconds, 100.0 * relative_rms(&lit, &exact)));
    rows.push(row(format!("mesh, h = {MESH_STEP_M} m"), &lit, None));
    found.results.push(format!(
        "Times of 1, 5, 25 and 225 points are as 1 : {}; the mesh takes {} times as long as one point.",
        ratios[1..COUNTS.len()].iter().map(|ratio| significant(*ratio, 2)).collect::<Vec<_>>().join(" : "),
        significant(ratios[COUNTS.len()], 2)
    ));
    let header =
        vec!["source", "rays", "time, s", "over 1 point", "rays a place, view included", "paper's times", "RMS error"];
    found.tables.push(("Point sources and mesh".to_owned(), Table { header, text_columns: vec![0], rows }));
    found.pictures.push(("Error against time".to_owned(), log_log(["time, s", "RMS error, %"], &lines)));
    Ok(found)
}
