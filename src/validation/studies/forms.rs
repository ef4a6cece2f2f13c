//! Study of the forms of direct light on a mesh: what a point stores, and how a receiver point uses the mesh points around it.
//!
//! Debelov and Sevastyanov (2001) store one number at each point: the light received from all visible luminaires, without their
//! identity. Debelov and Novikov (2009) store which luminaires are visible. Here both forms use the same points, so that nothing
//! else differs.

use glam::DVec3;
use rayon::prelude::*;

use super::interpolation::{DirectForm, Interpolation};
use super::pictures::{PlotLine, log_log};
use super::study_scene::{HALL_M, Lit, StudyScene, grid, hall, relative_rms};
use super::{Findings, StudyWishes};
use crate::light_mesh::{Index, Lattice, RADIUS_PER_STEP};
use crate::validation::report::Table;
use crate::validation::words::{percent, signed_percent, significant};

/// Length in m added to distances so that the falloff has no pole: φ = Const + r of the 2001 paper.
const FALLOFF_M: f64 = 1.0;
/// Number of lamps along an edge of the hall. A machine word can store the visibility of all lamps from a point.
const LAMPS: usize = 7;

/// Data at a point: a bit for each visible lamp, and the share of the unoccluded light from the visible lamps.
#[derive(Clone, Copy)]
struct Known {
    sees: u64,
    share: f64,
}

/// Mesh points over the hall's floor.
struct FloorPoints<'a> {
    study: &'a StudyScene,
    lattice: Lattice,
    known: Vec<Option<Known>>,
}

impl<'a> FloorPoints<'a> {
    /// Traces shadow rays from every point above the floor to all lamps. Points inside solids have no data.
    fn over(study: &'a StudyScene, points_m: &[DVec3], step_m: f64) -> Option<FloorPoints<'a>> {
        let mut bounds_m = [DVec3::INFINITY, DVec3::NEG_INFINITY];
        points_m.iter().for_each(|point_m| bounds_m = [bounds_m[0].min(*point_m), bounds_m[1].max(*point_m)]);
        let lattice = Lattice::over(bounds_m, step_m, RADIUS_PER_STEP * step_m)?;
        let known = (0..lattice.points() as usize).into_par_iter().map(|number| views_around(study, &lattice, number));
        Some(FloorPoints { known: known.collect(), study, lattice })
    }

    fn of(&self, index: Index) -> Option<&Known> {
        self.known[number_of(&self.lattice, index)].as_ref()
    }

    /// Illuminance in lx at a point that faces up.
    fn illuminance_lx(&self, place_m: DVec3, form: DirectForm, interpolation: Interpolation) -> f64 {
        let about = interpolation.about(&self.lattice, place_m, |index| self.of(index));
        let lamps = self.study.world.emitters.list();
        let share_of = |lamp: usize| -> f64 {
            let of_point = |(known, weight): &(&Known, f64)| match form {
                DirectForm::Visibility => weight * (known.sees >> lamp & 1) as f64,
                DirectForm::Scalar => weight * known.share,
            };
            about.iter().map(of_point).sum()
        };
        let light = |(number, lamp): (usize, &crate::sampling::emitter::Emitter)| {
            share_of(number) * lamp.unshadowed_lx(place_m, DVec3::Z)
        };
        lamps.iter().enumerate().map(light).sum()
    }
}

fn number_of(lattice: &Lattice, [i, j, k]: Index) -> usize {
    let [columns, rows, _] = lattice.counts.map(|count| count as usize);
    (k as usize * rows + j as usize) * columns + i as usize
}

fn views_around(study: &StudyScene, lattice: &Lattice, number: usize) -> Option<Known> {
    let [columns, rows, _] = lattice.counts.map(|count| count as usize);
    let index = [number % columns, number / columns % rows, number / (columns * rows)].map(|place| place as i32);
    let position_m = lattice.position_m(index);
    let tracer = &study.world.tracer;
    if position_m.z <= 0.0 || study.solids.holds(tracer, position_m).0 {
        return None;
    }
    let origin = tracer.free_origin(position_m);
    let (mut sees, mut seen, mut all) = (0, 0.0, 0.0);
    for (lamp, emitter) in study.world.emitters.list().iter().enumerate() {
        let lamp_m = emitter.center_m();
        let falling = emitter.luminous_flux_lm / (FALLOFF_M + lamp_m.distance(position_m));
        all += falling;
        if !tracer.is_occluded(&origin, &tracer.free_origin(lamp_m)) {
            sees |= 1 << lamp;
            seen += falling;
        }
    }
    Some(Known { sees, share: seen / all })
}

/// Measures the errors of both forms with every interpolation, from coarse to fine meshes.
pub fn forms(wishes: &mut StudyWishes) -> Result<Findings, String> {
    let (counts, edge): (&[usize], usize) = if wishes.quick { (&[20, 40], 80) } else { (&[20, 40, 80, 100, 200], 250) };
    let study = hall(LAMPS)?;
    let points_m = grid(DVec3::ZERO, [HALL_M, HALL_M], edge);
    let exact = study.by_rays(&points_m, 1, f64::INFINITY);
    let mut found = Findings::of(
        "light-mesh-forms",
        "The black hall of the study of steps, 20 m × 20 m, with 24 crates and 49 point lamps; receivers on its floor. Both forms use the same mesh points, without those inside solids and without local visibility. *Visibility* stores which lamps a point sees and weights each lamp's own light by the share of points that see it (Debelov and Novikov 2009). *Scalar* stores one number, Σ V Φ/(1 m + r) over Σ Φ/(1 m + r), and multiplies the unhidden light of all lamps by it (Debelov and Sevastyanov 2001, eqs. 1 to 3, made a share so that it has a unit). Receivers interpolate from the nearest point, from the corners of their cell, or from all points within R = 1.25 h with a weight φ₄ of 1 (as in the 2001 paper) or of 1 − d/R. Errors are against shadow rays.",
    );
    let mean_lx = exact.lx.iter().sum::<f64>() / exact.lx.len() as f64;
    let mut rows = Vec::new();
    let mut lines: Vec<PlotLine> = Vec::new();
    let mut finest: Vec<(DirectForm, f64)> = Vec::new();
    for (number, count) in counts.iter().enumerate() {
        let step_m = HALL_M / *count as f64;
        (wishes.tell)(&format!("{count}² cells, h = {step_m} m"));
        let points =
            FloorPoints::over(&study, &points_m, step_m).ok_or("a mesh with more points than numbers for them")?;
        let asked = DirectForm::ALL.into_iter().filter(|form| wishes.only.takes(*form));
        let ways = asked.flat_map(|form| wishes.only.interpolations().map(move |way| (form, way)));
        for (place, (form, interpolation)) in ways.enumerate() {
            let lx = points_m.par_iter().map(|point_m| points.illuminance_lx(*point_m, form, interpolation)).collect();
            let lit = Lit { lx, every: 1, ..Lit::default() };
            let error = relative_rms(&lit, &exact);
            let mean = lit.lx.iter().sum::<f64>() / lit.lx.len() as f64;
            rows.push(vec![
                count.to_string(),
                significant(step_m, 3),
                form.name().to_owned(),
                interpolation.name().to_owned(),
                significant(error * mean_lx, 3),
                percent(error),
                signed_percent(mean / mean_lx - 1.0),
            ]);
            if number == 0 {
                lines.push(PlotLine::new(format!("{}, {}", form.name(), interpolation.name())));
            }
            lines[place].places.push((step_m, 100.0 * error));
            if number + 1 == counts.len() {
                finest.push((form, error));
            }
        }
    }
    let least = |of: DirectForm| {
        finest.iter().filter(|(form, _)| *form == of).map(|(_, error)| *error).fold(f64::INFINITY, f64::min)
    };
    let [visibility, scalar] = DirectForm::ALL.map(least);
    if visibility.is_finite() && scalar.is_finite() {
        found.results.push(format!(
            "On the finest mesh the error of visibility is {} at best and that of the scalar {}: one number does not contain which lamp is hidden, and no finer mesh adds that.",
            percent(visibility),
            percent(scalar)
        ));
    } else {
        found.results.push(format!("On the finest mesh the error is {} at best.", percent(visibility.min(scalar))));
    }
    let header =
        vec!["cells along an edge", "h, m", "a point keeps", "taken from", "RMS error, lx", "RMS error", "mean off by"];
    found.tables.push(("Errors".to_owned(), Table { header, text_columns: vec![2, 3], rows }));
    found.pictures.push(("Error against step".to_owned(), log_log(["step, m", "RMS error, %"], &lines)));
    Ok(found)
}
