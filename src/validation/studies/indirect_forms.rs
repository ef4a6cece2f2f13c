//! Study of the forms of indirect light on a mesh: what a point stores of reflected light, and how a receiver point uses it.
//!
//! Debelov and Sevastyanov (2001, eqs. 4 to 6) store one number, the light from all sides, and average it with a weight φ₅. luxmc
//! stores the illuminance of a plane through the point that faces as the receiver point does. Both forms use the same points.

use glam::DVec3;
use rayon::prelude::*;

use super::interpolation::Interpolation;
use super::pictures::{PlotLine, log_log};
use super::study_scene::{HALL_M, Lit, StudyScene, grid, hall_with_crates, relative_rms};
use super::{Findings, StudyWishes};
use crate::check::scene_from_json;
use crate::estimators::receiver::Receiver;
use crate::estimators::walk::{sample_arriving_lx, sample_indirect_lx};
use crate::light_mesh::{Index, Lattice, RADIUS_PER_STEP};
use crate::sampling::emitter_tree::Cut;
use crate::sampling::random::{Purpose, Stream};
use crate::sampling::warp::{cosine_hemisphere, uniform_sphere};
use crate::validation::report::Table;
use crate::validation::words::{percent, signed_percent, significant};

/// Number of lamps along an edge of the hall.
const LAMPS: usize = 3;
/// Map numbers of the random streams: walks from receiver points, from mesh points to all sides, and from mesh points upwards.
const STREAMS: [u32; 3] = [0, 1, 2];

/// Form in which a mesh point stores indirect light, as an illuminance of the receiver point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum StudiedForm {
    /// Light from all sides; a surface receives a quarter of it (2001, eq. 4).
    Scalar,
    /// Illuminance of a plane through the point that faces up.
    Plane,
}

const FORMS: [(StudiedForm, &str); 2] = [(StudiedForm::Plane, "plane"), (StudiedForm::Scalar, "scalar")];

/// Illuminance in lx by both forms at the free points of a mesh.
struct FreePoints {
    lattice: Lattice,
    kept_lx: Vec<Option<[f64; 2]>>,
}

impl FreePoints {
    fn over(study: &StudyScene, points_m: &[DVec3], step_m: f64, walks: u64) -> Option<FreePoints> {
        let mut bounds_m = [DVec3::INFINITY, DVec3::NEG_INFINITY];
        points_m.iter().for_each(|point_m| bounds_m = [bounds_m[0].min(*point_m), bounds_m[1].max(*point_m)]);
        let lattice = Lattice::over(bounds_m, step_m, RADIUS_PER_STEP * step_m)?;
        let gather = |number: u64| {
            let position_m = lattice.position_m(index_of(&lattice, number));
            let tracer = &study.world.tracer;
            // No receiver point uses layers above its interpolation radius.
            let is_asked = position_m.z > 0.0 && position_m.z < RADIUS_PER_STEP * step_m;
            if !is_asked || study.solids.holds(tracer, position_m).0 {
                return None;
            }
            let origin = tracer.free_origin(position_m);
            let mut cut = Cut::default();
            Some(FORMS.map(|(form, _)| {
                let mut stream = Stream::new(1, Purpose::LightMesh, STREAMS[1 + form as usize], 0);
                let mut sum_lx = 0.0;
                for walk in 0..walks {
                    stream.seek_quasi((number << 32) | walk, number, walk);
                    let direction = match form {
                        StudiedForm::Scalar => uniform_sphere(stream.pair()),
                        StudiedForm::Plane => cosine_hemisphere(DVec3::Z, stream.pair()),
                    };
                    // Samples are π times the luminance. Their mean over all sides is a quarter of ∫ L dω, their cosine-weighted
                    // mean the illuminance.
                    sum_lx += sample_arriving_lx(&study.world, origin, direction, &mut cut, &mut stream).value;
                }
                sum_lx / walks as f64
            }))
        };
        let kept_lx = (0..lattice.points() as u64).into_par_iter().map(gather).collect();
        Some(FreePoints { lattice, kept_lx })
    }

    fn illuminance_lx(&self, place_m: DVec3, form: usize, interpolation: Interpolation) -> f64 {
        let about = interpolation.about(&self.lattice, place_m, |[i, j, k]| {
            let [columns, rows, _] = self.lattice.counts.map(|count| count as usize);
            self.kept_lx[(k as usize * rows + j as usize) * columns + i as usize].map(|kept_lx| kept_lx[form])
        });
        about.iter().map(|(kept_lx, weight)| weight * kept_lx).sum()
    }
}

fn index_of(lattice: &Lattice, number: u64) -> Index {
    let [columns, rows, _] = lattice.counts.map(u64::from);
    [number % columns, number / columns % rows, number / (columns * rows)].map(|place| place as i32)
}

/// Indirect illuminance of points by walks from each point.
fn by_walks(study: &StudyScene, points_m: &[DVec3], walks: u64) -> Lit {
    let walk_from = |(number, point_m): (u64, &DVec3)| {
        let origin = study.world.tracer.side_origin(*point_m, DVec3::Z);
        let receiver = Receiver { point_m: *point_m, normal: DVec3::Z, origin: &origin };
        let mut stream = Stream::new(1, Purpose::LightMesh, STREAMS[0], 0);
        let mut cut = Cut::default();
        let mut sum_lx = 0.0;
        for walk in 0..walks {
            stream.seek_quasi((number << 32) | walk, number, walk);
            sum_lx += sample_indirect_lx(&study.world, &receiver, &mut cut, &mut stream).value;
        }
        sum_lx / walks as f64
    };
    let numbered: Vec<(u64, &DVec3)> = (0..).zip(points_m).collect();
    Lit { lx: numbered.into_par_iter().map(walk_from).collect(), every: 1, ..Lit::default() }
}

/// Measures the errors of both forms with every interpolation, from coarse to fine meshes.
pub fn indirect_forms(wishes: &mut StudyWishes) -> Result<Findings, String> {
    let (counts, edge, walks, of_places): (&[usize], usize, u64, u64) =
        if wishes.quick { (&[10, 20], 17, 128, 256) } else { (&[10, 20, 40, 80], 47, 512, 4096) };
    let geometry = hall_with_crates().replace("black", "grey");
    let (first, across) = (0.5 * HALL_M / LAMPS as f64, HALL_M - HALL_M / LAMPS as f64);
    let scene = format!(
        r#"{{ "version": 1, "materials": {{ "grey": {{ "type": "diffuse", "reflectance": 0.5 }} }}, "geometry": [{geometry}],
            "luminaires": [{{ "name": "lamp", "type": "point", "position": [{first},{first},3.0], "intensity_cd": 500,
                "columns": {LAMPS}, "rows": {LAMPS}, "u": [{across},0,0], "v": [0,{across},0] }}] }}"#
    );
    let scene = scene_from_json(&scene, None, std::path::Path::new(".")).map_err(|error| error.to_string())?;
    let study = StudyScene::of(scene);
    let mut points_m = grid(DVec3::ZERO, [HALL_M, HALL_M], edge);
    // Points under crates are dark and do not test the interpolation.
    points_m.retain(|point_m| !study.solids.holds(&study.world.tracer, *point_m + 1e-3 * DVec3::Z).0);
    (wishes.tell)(&format!("{} points, {of_places} walks each", points_m.len()));
    let exact = by_walks(&study, &points_m, of_places);
    let mean_lx = exact.lx.iter().sum::<f64>() / exact.lx.len() as f64;
    let mut found = Findings::of(
        "light-mesh-indirect",
        "The hall of the study of steps with surfaces that reflect a half, and nine lamps at 3 m that shine to all sides; receivers on its floor beside the crates, indirect light alone. Both forms use the same mesh points, without those inside solids and without local visibility. *Scalar* stores the light from all sides, of which a surface gets a quarter (Debelov and Sevastyanov 2001, eqs. 4 to 6). *Plane* stores the light that an upward plane through the point receives. Receivers interpolate from the nearest point, from the corners of their cell, or from all points within R = 1.25 h with a weight φ₅ of 1 (as in the 2001 paper) or of 1 − d/R. Errors are against walks from the receivers.",
    );
    let (mut rows, mut lines, mut finest) = (Vec::new(), Vec::new(), Vec::new());
    for (number, count) in counts.iter().enumerate() {
        let step_m = HALL_M / *count as f64;
        (wishes.tell)(&format!("{count}² cells, h = {step_m} m"));
        let points = FreePoints::over(&study, &points_m, step_m, walks)
            .ok_or("a mesh with more points than numbers for them")?;
        let ways = (0..FORMS.len()).flat_map(|form| wishes.only.interpolations().map(move |way| (form, way)));
        for (place, (form, interpolation)) in ways.enumerate() {
            let lx = points_m.iter().map(|point_m| points.illuminance_lx(*point_m, form, interpolation)).collect();
            let lit = Lit { lx, every: 1, ..Lit::default() };
            let error = relative_rms(&lit, &exact);
            let mean = lit.lx.iter().sum::<f64>() / lit.lx.len() as f64;
            let name = FORMS[form].1;
            rows.push(vec![
                count.to_string(),
                significant(step_m, 3),
                name.to_owned(),
                interpolation.name().to_owned(),
                significant(error * mean_lx, 3),
                percent(error),
                signed_percent(mean / mean_lx - 1.0),
            ]);
            if number == 0 {
                lines.push(PlotLine::new(format!("{name}, {}", interpolation.name())));
            }
            lines[place].places.push((step_m, 100.0 * error));
            if number + 1 == counts.len() {
                finest.push((form, error));
            }
        }
    }
    let least = |of: usize| {
        finest.iter().filter(|(form, _)| *form == of).map(|(_, error)| *error).fold(f64::INFINITY, f64::min)
    };
    found.results.push(format!(
        "The mean is {} lx. On the finest mesh the error of planes is {} at best and that of the scalar {}: no weight shows from which direction the light of one number comes.",
        significant(mean_lx, 3),
        percent(least(0)),
        percent(least(1))
    ));
    let header =
        vec!["cells along an edge", "h, m", "a point keeps", "taken from", "RMS error, lx", "RMS error", "mean off by"];
    found.tables.push(("Errors of indirect light".to_owned(), Table { header, text_columns: vec![2, 3], rows }));
    found.pictures.push(("Error against step".to_owned(), log_log(["step, m", "RMS error, %"], &lines)));
    Ok(found)
}
