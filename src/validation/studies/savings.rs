//! Studies of the savings by each acceleration, and by the sparse tree.

use std::sync::atomic::{AtomicU64, Ordering};

use glam::DVec3;

use super::open_air::{Lamps, Things, gazebo, playground, scene_text};
use super::study_scene::{Lit, StudyScene, grid, relative_rms};
use super::{Findings, StudyWishes};
use crate::check::read_scene;
use crate::light_mesh::{Accelerations, Options};
use crate::validation::report::Table;
use crate::validation::words::{grouped, percent, significant, whole_percent};

/// Height above the lawn in m at which receivers are tested. Points under solids are left out, since nobody sees them.
const SOUNDING_M: f64 = 0.01;
/// Edge of the open-air scenes in m.
const EDGE_M: f64 = 400.0;
/// Steps of the papers in m, and their radii in steps.
const STEPS_M: [f64; 2] = [2.0, 1.0];
const RADII: [f64; 2] = [2.1, 3.1];
/// Numbers of receivers along an edge for the comparison with shadow rays; then those of a quick study.
const EDGES: [usize; 3] = [512, 1024, 2048];
const EDGES_QUICK: [usize; 2] = [48, 96];
/// Steps in m and radii in steps of meshes for the comparison with shadow rays: the papers' point density, half of it in space, and
/// half of it along every edge.
const MESHES: [(f64, f64); 5] = [(1.0, 2.1), (1.26, 2.1), (2.0, 2.1), (1.0, 3.1), (2.0, 3.1)];
/// Share of the time with MU1 alone that the papers saved.
const PAPERS: [(&str, f64); 2] = [("gazebo", 0.65), ("playground", 0.50)];

struct TimeSaved {
    name: &'static str,
    study: StudyScene,
    points_m: Vec<DVec3>,
}

/// Both scenes with their visible receivers: `edge`² on the lawn, without those under solids.
fn places(edge: usize) -> Result<Vec<TimeSaved>, String> {
    let make = |name: &'static str, things: Things, depth: f64| -> Result<TimeSaved, String> {
        let (study, points_m) = place_of(name, &things, depth, Lamps::Points, edge)?;
        Ok(TimeSaved { name, study, points_m })
    };
    Ok(vec![make("gazebo", gazebo(), 400.0)?, make("playground", playground(), 350.0)?])
}

/// A scene of solids with its lamps, and the visible ones of `edge`² receivers on its lawn.
pub fn place_of(
    name: &str,
    things: &Things,
    depth: f64,
    lamps: Lamps,
    edge: usize,
) -> Result<(StudyScene, Vec<DVec3>), String> {
    let study = StudyScene::of(read(name, &scene_text(name, "things.obj", depth, 2, lamps), things)?);
    let mut points_m = grid(DVec3::ZERO, [EDGE_M, depth], edge);
    points_m.retain(|point_m| !study.solids.holds(&study.world.tracer, *point_m + DVec3::Z * SOUNDING_M).0);
    Ok((study, points_m))
}

/// Reads a scene with a mesh file. Both files are in a temporary folder of their own while they are read.
fn read(name: &str, text: &str, things: &Things) -> Result<crate::scene::Scene, String> {
    static READ: AtomicU64 = AtomicU64::new(0);
    let number = READ.fetch_add(1, Ordering::Relaxed);
    let folder = std::env::temp_dir().join(format!("luxmc-{}-{number}-{name}", std::process::id()));
    let wrong = |error: std::io::Error| format!("{}: {error}", folder.display());
    std::fs::create_dir_all(&folder).map_err(wrong)?;
    std::fs::write(folder.join("things.obj"), &things.text).map_err(wrong)?;
    let file = folder.join("scene.json");
    std::fs::write(&file, text).map_err(wrong)?;
    let scene = read_scene(&file).map_err(|error| error.to_string());
    std::fs::remove_dir_all(&folder).map_err(wrong)?;
    scene
}

fn options(step_m: f64, ratio: f64, level: usize) -> Options {
    let accelerations =
        Accelerations { tree: true, templates: level > 0, outer_first: level > 1, inside_flags: level > 2 };
    Options { step_m, radius_m: ratio * step_m, accelerations }
}

/// Study of the time saved by MU2, MU3 and MU4 compared with MU1 alone.
pub fn accelerations(wishes: &mut StudyWishes) -> Result<Findings, String> {
    let (edge, steps_m, radii): (usize, &[f64], &[f64]) =
        if wishes.quick { (96, &STEPS_M[..1], &RADII[..1]) } else { (1024, &STEPS_M, &RADII) };
    let mut found = Findings::of(
        "light-mesh-savings",
        "Two open-air scenes 400 m wide, two lamps, receivers on the lawn (without those under objects). MU1: the ray tree. MU2: templates of the mesh points near a receiver. MU3: outer points first. MU4: flags of points inside solids. Each column adds one acceleration to those before it. Debelov and Novikov (2009) saved 65% of the time with MU1 alone on a scene of 300 triangles, and 50% on one of 27,000. Errors are against shadow rays; all shadows here are hard, so the error is that of the mesh's blur.",
    );
    let mut rows = Vec::new();
    for place in places(edge)? {
        let exact = place.study.by_rays(&place.points_m, 1, f64::INFINITY);
        let triangles = place.study.scene.triangles.len();
        let mut least = [f64::INFINITY; 2];
        for step_m in steps_m {
            for ratio in radii {
                (wishes.tell)(&format!("{}: h = {step_m} m, R = {ratio} h", place.name));
                let runs = (0..4)
                    .map(|level| place.study.by_mesh(&place.points_m, options(*step_m, *ratio, level)))
                    .collect::<Result<Vec<Lit>, String>>()?;
                let of_time: fn(&Lit) -> f64 = |run| run.seconds;
                let of_rays: fn(&Lit) -> f64 = |run| run.rays as f64 * 1e-6;
                for (index, (what, of)) in [("time, s", of_time), ("rays, 10⁶", of_rays)].into_iter().enumerate() {
                    let saved = |from: usize, to: usize| 1.0 - of(&runs[to]) / of(&runs[from]).max(f64::MIN_POSITIVE);
                    least[index] = least[index].min(saved(0, 3));
                    let mut row = head(&place, *step_m, *ratio, what);
                    row.extend(runs.iter().map(|run| significant(of(run), 3)));
                    row.extend([saved(0, 3), saved(0, 1), saved(1, 2), saved(2, 3)].map(whole_percent));
                    rows.push(row);
                }
                let mut row = head(&place, *step_m, *ratio, "RMS error");
                row.extend(runs.iter().map(|run| percent(relative_rms(run, &exact))));
                row.extend(vec![String::new(); 4]);
                rows.push(row);
            }
        }
        let asked = PAPERS.iter().find(|(name, _)| *name == place.name).map_or(0.0, |(_, share)| *share);
        found.results.push(format!(
            "{} ({} triangles, {} receivers): all accelerations save at least {} of the time and {} of the rays with MU1 alone; the paper saved {} of the time.",
            place.name,
            grouped(triangles as u64),
            grouped(place.points_m.len() as u64),
            whole_percent(least[0]),
            whole_percent(least[1]),
            whole_percent(asked)
        ));
    }
    let header =
        vec!["scene", "step, m", "R/h", "", "MU1", "+ MU2", "+ MU3", "+ MU4", "saved by all", "MU2", "MU3", "MU4"];
    found.tables.push(("Savings".to_owned(), Table { header, text_columns: vec![0, 3], rows }));
    against_rays(wishes, &mut found)?;
    Ok(found)
}

/// Compares times, rays and points of meshes with all accelerations to a shadow ray from every receiver to every lamp. It varies
/// the number of receivers and the density of mesh points.
fn against_rays(wishes: &mut StudyWishes, found: &mut Findings) -> Result<(), String> {
    let (edges, meshes): (&[usize], &[(f64, f64)]) =
        if wishes.quick { (&EDGES_QUICK, &MESHES[..2]) } else { (&EDGES, &MESHES) };
    let mut rows = Vec::new();
    let (mut quicker, mut grown) = (Vec::new(), Vec::new());
    let mut first: Vec<u64> = Vec::new();
    for edge in edges {
        let mut number = 0;
        for place in places(*edge)? {
            (wishes.tell)(&format!("{}: {edge}² receivers", place.name));
            let exact = place.study.by_rays(&place.points_m, 1, f64::INFINITY);
            let mut of_densest_s = None;
            for (step_m, ratio) in meshes {
                let run = place.study.by_mesh(&place.points_m, options(*step_m, *ratio, 3))?;
                let densest_s = *of_densest_s.get_or_insert(run.seconds);
                if first.len() == number {
                    first.push(run.counts.points);
                }
                if edge == &edges[edges.len() - 1] {
                    quicker.push(run.seconds / exact.seconds);
                    grown.push(run.counts.points as f64 / first[number] as f64 - 1.0);
                }
                number += 1;
                rows.push(vec![
                    place.name.to_owned(),
                    format!("{edge}²"),
                    significant(*step_m, 3),
                    ratio.to_string(),
                    grouped(run.counts.points),
                    significant(exact.rays as f64 * 1e-6, 3),
                    significant(run.rays as f64 * 1e-6, 3),
                    significant(exact.seconds, 3),
                    significant(run.seconds, 3),
                    significant(run.seconds / exact.seconds, 2),
                    significant(densest_s / run.seconds, 2),
                    percent(relative_rms(&run, &exact)),
                ]);
            }
        }
    }
    let [least, most] = [f64::min as fn(f64, f64) -> f64, f64::max]
        .map(|pick| quicker.iter().copied().reduce(pick).unwrap_or(f64::NAN));
    found.results.push(format!(
        "At {}² receivers a mesh takes {} to {} times the time of a shadow ray to every lamp. {} times as many receivers along an edge use {} to {} more mesh points.",
        edges[edges.len() - 1],
        significant(least, 2),
        significant(most, 2),
        edges[edges.len() - 1] / edges[0],
        whole_percent(grown.iter().copied().fold(f64::INFINITY, f64::min)),
        whole_percent(grown.iter().copied().fold(0.0, f64::max)),
    ));
    let header = vec![
        "scene",
        "receivers",
        "step, m",
        "R/h",
        "points used",
        "shadow rays, 10⁶",
        "mesh rays, 10⁶",
        "shadow rays, s",
        "mesh, s",
        "mesh / shadow rays",
        "quicker than first",
        "RMS error",
    ];
    let caption = "Against shadow rays; steps of 1 m, of 1.26 m (half as many points in space) and of 2 m (half as many along an edge)";
    found.tables.push((caption.to_owned(), Table { header, text_columns: vec![0], rows }));
    Ok(())
}

fn head(place: &TimeSaved, step_m: f64, ratio: f64, what: &str) -> Vec<String> {
    vec![place.name.to_owned(), step_m.to_string(), ratio.to_string(), what.to_owned()]
}

/// Study of the memory of the sparse tree, compared with storing every point of a mesh over the whole scene.
pub fn memory(wishes: &mut StudyWishes) -> Result<Findings, String> {
    let (edge, steps_m): (usize, &[f64]) = if wishes.quick { (96, &STEPS_M[..1]) } else { (1024, &STEPS_M) };
    let mut found = Findings::of(
        "light-mesh-memory",
        "The scenes of the study of savings. Sparse: memory that the run used. Dense: a word of bits and a byte for every point of a mesh over the whole scene.",
    );
    let (mut rows, mut least, mut most) = (Vec::new(), f64::INFINITY, 0.0f64);
    for place in places(edge)? {
        for step_m in steps_m {
            for ratio in RADII {
                (wishes.tell)(&format!("{}: h = {step_m} m, R = {ratio} h", place.name));
                let run = place.study.by_mesh(&place.points_m, options(*step_m, ratio, 3))?;
                let saved = run.dense_bytes / run.bytes as f64;
                (least, most) = (least.min(saved), most.max(saved));
                rows.push(vec![
                    place.name.to_owned(),
                    step_m.to_string(),
                    ratio.to_string(),
                    grouped(run.counts.points),
                    significant(run.bytes as f64 * 1e-6, 3),
                    significant(run.dense_bytes * 1e-6, 3),
                    significant(saved, 2),
                ]);
            }
        }
    }
    found.results.push(format!(
        "The sparse tree takes {} to {} times less memory than a dense mesh.",
        significant(least, 2),
        significant(most, 2)
    ));
    let header = vec!["scene", "step, m", "R/h", "points used", "sparse, MB", "dense, MB", "dense / sparse"];
    found.tables.push(("Memory".to_owned(), Table { header, text_columns: vec![0], rows }));
    Ok(found)
}
