//! Study of the width of soft shadows: a ball's real penumbra, and the penumbra of a mesh for a ball and for a point.

use glam::DVec3;

use super::pictures::{PlotLine, profiles};
use super::study_scene::StudyScene;
use super::{Findings, StudyWishes};
use crate::light_mesh::{Accelerations, Options};
use crate::validation::report::Table;

/// Heights of the board's faces and of the source above the floor, in m.
const BOARD_M: [f64; 2] = [2.0, 2.4];
const SOURCE_M: f64 = 4.4;
/// Radius of the ball in m.
const BALL_M: f64 = 0.2;
/// Number of points across the edge, and half the width that they span in m.
const PLACES: usize = 2001;
const HALF_M: f64 = 1.0;

fn study(lamp: &str) -> Result<StudyScene, String> {
    let geometry = format!(
        r#"{{ "name": "floor", "type": "box", "min": [-10,-10,-1], "max": [10,10,0], "material": "black" }},
           {{ "name": "board", "type": "box", "min": [-10,-10,{}], "max": [0,10,{}], "material": "black" }}"#,
        BOARD_M[0], BOARD_M[1]
    );
    StudyScene::black(&geometry, lamp)
}

/// Width in m between 10 % and 90 % of the light far from the edge.
fn width_m(lx: &[f64]) -> f64 {
    let full = lx[lx.len() - 1];
    let first = |share: f64| lx.iter().position(|lx| *lx >= share * full).unwrap_or(0);
    (first(0.9) - first(0.1)) as f64 * 2.0 * HALF_M / (PLACES - 1) as f64
}

/// Width of the ball's whole penumbra by similar triangles, in m. Under the board its lower edge hides the ball, beside it the
/// upper edge.
fn whole_width_m() -> f64 {
    BOARD_M.iter().map(|edge_m| BALL_M * edge_m / (SOURCE_M - edge_m)).sum()
}

/// Study of profiles across the shadow of an edge.
pub fn penumbra(wishes: &mut StudyWishes) -> Result<Findings, String> {
    let samples = if wishes.quick { 256 } else { 4096 };
    let line_m: Vec<DVec3> =
        (0..PLACES).map(|i| DVec3::new(HALF_M * (2.0 * i as f64 / (PLACES - 1) as f64 - 1.0), 0.0137, 0.0)).collect();
    let mut found = Findings::of(
        "light-mesh-penumbra",
        "The shadow of a board's edge 2 m above the floor, with the source at 4.4 m straight above the edge. Widths are measured between one tenth and nine tenths of the light on the open side. A mesh that samples points of the ball finds its real penumbra as h decreases. A mesh that samples only one point gives an edge of its own width, whatever the size of the source: the papers' soft shadow, right for one size of source at one distance.",
    );
    let ball = study(&format!(
        r#"{{ "name": "ball", "type": "sphere", "center": [0,0,{SOURCE_M}], "radius": {BALL_M}, "luminous_flux_lm": 1000 }}"#
    ))?;
    let point = study(&format!(
        r#"{{ "name": "point", "type": "point", "position": [0,0,{SOURCE_M}], "luminous_flux_lm": 1000 }}"#
    ))?;
    (wishes.tell)("the ball by shadow rays");
    let exact = ball.by_rays(&line_m, samples, f64::INFINITY);
    let real_m = width_m(&exact.lx);
    let mut lines = Vec::new();
    let mut add_line = |name: &str, lx: &[f64]| {
        let full = lx[lx.len() - 1];
        let places = line_m.iter().zip(lx).map(|(point_m, lx)| (point_m.x, lx / full)).collect();
        lines.push(PlotLine { name: name.to_owned(), places });
    };
    add_line("ball, shadow rays", &exact.lx);
    let mut rows = vec![vec![
        format!("ball of {BALL_M} m"),
        format!("{samples} shadow rays from every point"),
        String::new(),
        String::new(),
        format!("{real_m:.3}"),
        String::new(),
    ]];
    let of_ball: &[(f64, f64)] = if wishes.quick {
        &[(0.02, 1.25), (0.2, 2.1)]
    } else {
        &[(0.02, 1.25), (0.05, 1.25), (0.1, 1.25), (0.1, 2.1), (0.2, 2.1)]
    };
    let of_point: &[(f64, f64)] = if wishes.quick {
        &[(0.1, 2.1), (0.15, 2.1)]
    } else {
        &[(0.02, 2.1), (0.05, 2.1), (0.1, 2.1), (0.15, 2.1), (0.2, 2.1), (0.1, 3.1)]
    };
    let mut finest = None;
    for (source, study, sizes) in [("ball", &ball, of_ball), ("point", &point, of_point)] {
        for (step_m, ratio) in sizes {
            (wishes.tell)(&format!("the {source} by a mesh of {step_m} m, R = {ratio} h"));
            let options = Options { step_m: *step_m, radius_m: ratio * step_m, accelerations: Accelerations::ALL };
            let lit = study.by_mesh(&line_m, options)?;
            let width = width_m(&lit.lx);
            if source == "ball" && finest.is_none() {
                finest = Some(width);
            }
            if (source == "ball" && *step_m == 0.2) || (source == "point" && *step_m == 0.15) {
                add_line(&format!("{source}, mesh of {step_m} m, R = {ratio} h"), &lit.lx);
            }
            rows.push(vec![
                if source == "ball" { format!("ball of {BALL_M} m") } else { source.to_owned() },
                if source == "ball" { "mesh, 64 points of the ball" } else { "softened by the mesh alone" }.to_owned(),
                step_m.to_string(),
                ratio.to_string(),
                format!("{width:.3}"),
                format!("{:.2}", width / real_m),
            ]);
        }
    }
    found.results.push(format!(
        "By similar triangles the whole penumbra of the ball is {:.3} m wide, {real_m:.3} m between one tenth and nine tenths; the finest mesh finds {:.3} m.",
        whole_width_m(),
        finest.unwrap_or(f64::NAN)
    ));
    let header = vec!["source", "how", "step, m", "R/h", "width 10–90 %, m", "over the real one"];
    found.tables.push(("Widths".to_owned(), Table { header, text_columns: vec![0, 1], rows }));
    found.pictures.push((
        "Profiles across the edge".to_owned(),
        profiles(["position across the edge, m", "illuminance over that of the open side"], [-0.6, 0.6], &lines),
    ));
    Ok(found)
}
