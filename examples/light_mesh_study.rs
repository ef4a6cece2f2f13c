//! The light-mesh study: what a mesh costs and what it changes, beside shadow rays from every receiver.
//!
//! `cargo run --release --example light_mesh_study -- OUT [a b c d e]` (from the project's root; b and c need
//! `cargo run --release --example make_light_mesh_scenes` first)
//!
//! Writes tables (`a.md`, …) and pictures (`a.svg`, …) into OUT. Times are of this machine and load; rays are counted.

use std::error::Error;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::time::Instant;

use glam::DVec3;
use luxmc::chain::Stage;
use luxmc::estimators::direct::Receiver;
use luxmc::light_mesh::exact::look_at_all;
use luxmc::light_mesh::{
    Accelerations, Counts, Lattice, LightMesh, Options, Placing, Samples, Solids, Surroundings, Workroom,
};
use luxmc::sampling::random::{Purpose, Stream};
use luxmc::scene::{Scene, read_scene, scene_from_json};
use plotters::prelude::*;
use rayon::prelude::*;

type Outcome<T> = Result<T, Box<dyn Error>>;

/// Shadow rays that a run of the rival may take; beyond it the time follows from the rate.
const MOST_RAYS: f64 = 4e7;
/// Receivers that a thread takes at a time.
const CHUNK: usize = 1024;

/// A scene ready for meshes.
struct World {
    scene: Scene,
    stage: Stage,
    solids: Solids,
    samples: Samples,
}

impl World {
    fn of(scene: Scene) -> World {
        let stage = Stage::new(&scene);
        let samples = Samples::of(&stage, Placing::Stratified, 0);
        World { solids: Solids::of(&scene), samples, stage, scene }
    }

    fn around(&self) -> Surroundings<'_> {
        Surroundings { scene: &self.scene, stage: &self.stage, solids: &self.solids, samples: &self.samples }
    }
}

/// `count`² points of a level rectangle.
fn grid(low: DVec3, size: [f64; 2], count: usize) -> Vec<DVec3> {
    let at = |number: usize, size: f64| size * (number as f64 + 0.5) / count as f64;
    (0..count * count).map(|i| low + DVec3::new(at(i % count, size[0]), at(i / count, size[1]), 0.0)).collect()
}

/// What a run gave and took.
struct Run {
    lx: Vec<f64>,
    counts: Counts,
    rays: u64,
    seconds: f64,
    bytes: u64,
    dense_bytes: f64,
}

fn by_mesh(world: &World, points_m: &[DVec3], options: Options) -> Outcome<Run> {
    let started = Instant::now();
    let mut bounds_m = [DVec3::INFINITY, DVec3::NEG_INFINITY];
    points_m.iter().for_each(|point_m| bounds_m = [bounds_m[0].min(*point_m), bounds_m[1].max(*point_m)]);
    let mesh = LightMesh::new(world.around(), bounds_m, options).ok_or("the mesh is out of proportion")?;
    let chunks: Vec<(Vec<f64>, Counts)> = points_m
        .par_chunks(CHUNK)
        .map(|chunk| {
            let mut room = Workroom::default();
            let lx = chunk.iter().map(|point_m| {
                let origin = world.stage.tracer.side_origin(*point_m, DVec3::Z);
                mesh.direct(&Receiver { point_m: *point_m, normal: DVec3::Z, origin: &origin }, &mut room)
                    .illuminance_lx
            });
            (lx.collect(), room.counts)
        })
        .collect();
    let seconds = started.elapsed().as_secs_f64();
    let mut counts = Counts::default();
    let mut lx = Vec::with_capacity(points_m.len());
    for (part, more) in chunks {
        lx.extend(part);
        counts += more;
    }
    // A mesh over the whole scene, as one that knows nothing of the receivers would have to store.
    let (mut low_m, mut high_m) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for vertex_m in &world.scene.vertices_m {
        (low_m, high_m) = (low_m.min(*vertex_m), high_m.max(*vertex_m));
    }
    let whole = Lattice::over([low_m, high_m], options.step_m, options.radius_m);
    let bytes_per_point = mesh.dense_bytes() / mesh.lattice.points();
    let dense_bytes = whole.map_or(f64::INFINITY, |whole| whole.points()) * bytes_per_point;
    Ok(Run { lx, counts, rays: counts.rays(), seconds, bytes: mesh.bytes(), dense_bytes })
}

/// Shadow rays to every luminaire, from every `every`-th receiver; seconds and rays are of all.
fn by_rays(world: &World, points_m: &[DVec3], every: usize) -> Run {
    let started = Instant::now();
    let asked: Vec<DVec3> = points_m.iter().copied().step_by(every).collect();
    let found: Vec<(f64, u64)> = asked
        .par_iter()
        .map(|point_m| {
            let origin = world.stage.tracer.side_origin(*point_m, DVec3::Z);
            let mut stream = Stream::new(0, Purpose::LightMesh, 0, 0);
            look_at_all(&world.stage, &Receiver { point_m: *point_m, normal: DVec3::Z, origin: &origin }, &mut stream)
        })
        .collect();
    let scale = points_m.len() as f64 / asked.len() as f64;
    Run {
        seconds: started.elapsed().as_secs_f64() * scale,
        rays: (found.iter().map(|(_, rays)| rays).sum::<u64>() as f64 * scale) as u64,
        lx: found.into_iter().map(|(lx, _)| lx).collect(),
        counts: Counts::default(),
        bytes: 0,
        dense_bytes: 0.0,
    }
}

fn relative_rms(found: &[f64], exact: &[f64], every: usize) -> f64 {
    let squares: f64 = found.iter().step_by(every).zip(exact).map(|(f, e)| (f - e).powi(2)).sum();
    let mean = exact.iter().sum::<f64>() / exact.len() as f64;
    (squares / exact.len() as f64).sqrt() / mean
}

/// A hall of 20 m × 20 m × 4 m with 24 crates and `edge`² lamps under its ceiling.
fn hall(edge: usize) -> Outcome<Scene> {
    let mut wheel = 5u64;
    let mut turn = || {
        wheel = wheel.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (wheel >> 40) as f64 / (1u64 << 24) as f64
    };
    let mut geometry = String::from(
        r#"{ "name": "room", "type": "box", "min": [0,0,0], "max": [20,20,4], "facing": "inward", "material": "black" }"#,
    );
    for crate_number in 0..24 {
        let (x, y) = (1.0 + 17.0 * turn(), 1.0 + 17.0 * turn());
        let (width, depth, height) = (0.5 + turn(), 0.5 + turn(), 0.5 + 1.7 * turn());
        write!(
            geometry,
            r#", {{ "name": "crate {crate_number}", "type": "box", "min": [{x},{y},0], "max": [{},{},{height}], "material": "black" }}"#,
            x + width,
            y + depth
        )?;
    }
    let (first, across) = (10.0 / edge as f64, 20.0 - 20.0 / edge as f64);
    let array = if edge > 1 {
        format!(r#", "columns": {edge}, "rows": {edge}, "u": [{across},0,0], "v": [0,{across},0]"#)
    } else {
        String::new()
    };
    let text = format!(
        r#"{{ "version": 1, "materials": {{ "black": {{ "type": "diffuse", "reflectance": 0 }} }},
            "geometry": [{geometry}],
            "luminaires": [ {{ "name": "lamp", "type": "point", "position": [{first},{first},3.8], "intensity_cd": 100{array} }} ] }}"#
    );
    Ok(scene_from_json(&text, None, Path::new("."))?)
}

/// Times and rays against the number of luminaires and of receivers.
fn study_a(out: &Path) -> Outcome<()> {
    const STEP_M: f64 = 0.1;
    let options = Options { step_m: STEP_M, radius_m: 1.25 * STEP_M, accelerations: Accelerations::ALL };
    let mut table = String::from(
        "| luminaires | receivers | rays: shadow rays | rays: mesh | rays saved by | time: shadow rays / s | time: mesh / s | faster by | RMS error |\n| --: | --: | --: | --: | --: | --: | --: | --: | --: |\n",
    );
    let mut by_luminaires = [Vec::new(), Vec::new()];
    let mut by_receivers = [Vec::new(), Vec::new()];
    let cases = [1, 3, 5, 7, 8, 10, 15]
        .map(|edge| (edge, 500))
        .into_iter()
        .chain([50, 125, 250, 1000, 2000].map(|count| (8, count)));
    for (edge, count) in cases {
        let world = World::of(hall(edge)?);
        let points_m = grid(DVec3::ZERO, [20.0, 20.0], count);
        let mesh = by_mesh(&world, &points_m, options)?;
        let every = ((points_m.len() * edge * edge) as f64 / MOST_RAYS).ceil() as usize;
        let exact = by_rays(&world, &points_m, every);
        writeln!(
            table,
            "| {} | {count}² | {} | {} | {:.2} | {:.3}{} | {:.3} | {:.2} | {:.2} % |",
            edge * edge,
            exact.rays,
            mesh.rays,
            exact.rays as f64 / mesh.rays as f64,
            exact.seconds,
            if every > 1 { "*" } else { "" },
            mesh.seconds,
            exact.seconds / mesh.seconds,
            100.0 * relative_rms(&mesh.lx, &exact.lx, every),
        )?;
        if count == 500 {
            by_luminaires[0].push(((edge * edge) as f64, exact.seconds));
            by_luminaires[1].push(((edge * edge) as f64, mesh.seconds));
        }
        if edge == 8 {
            by_receivers[0].push(((count * count) as f64, exact.seconds));
            by_receivers[1].push(((count * count) as f64, mesh.seconds));
        }
    }
    by_receivers.iter_mut().for_each(|line| line.sort_by(|one, other| one.0.total_cmp(&other.0)));
    std::fs::write(out.join("a.md"), table)?;
    let names = ["shadow rays", "light mesh"];
    chart(&out.join("a-luminaires.svg"), "500² receivers", ["luminaires", "time / s"], &names, &by_luminaires)?;
    chart(&out.join("a-receivers.svg"), "64 luminaires", ["receivers", "time / s"], &names, &by_receivers)
}

/// Shares of the accelerations, and memory (c).
fn study_b(out: &Path) -> Outcome<()> {
    let mut table = String::from(
        "| scene | step | R/h | | MU1 | + MU2 | + MU3 | + MU4 | saved by all | by MU2, MU3, MU4 |\n| --- | --: | --: | --- | --: | --: | --: | --: | --: | --- |\n",
    );
    let mut memory = String::from(
        "| scene | step | R/h | points used | MB sparse | MB dense | dense / sparse |\n| --- | --: | --: | --: | --: | --: | --: |\n",
    );
    for (name, depth) in [("gazebo", 400.0), ("playground", 350.0)] {
        let world = World::of(read_scene(Path::new(&format!("scenes/{name}.json")))?);
        // Receivers under things are seen by nobody and are left out, as a picture leaves them out.
        let mut points_m = grid(DVec3::ZERO, [400.0, depth], 1024);
        let above = |point_m: &DVec3| world.solids.holds(&world.stage.tracer, *point_m + DVec3::Z * 0.01).0;
        points_m.retain(|point_m| !above(point_m));
        let exact = by_rays(&world, &points_m, 1);
        for step_m in [2.0, 1.0] {
            for ratio in [2.1, 3.1] {
                let mut accelerations = Accelerations::TREE_ALONE;
                let mut runs = Vec::new();
                for level in 0..4 {
                    accelerations.templates = level > 0;
                    accelerations.outer_first = level > 1;
                    accelerations.inside_flags = level > 2;
                    let options = Options { step_m, radius_m: ratio * step_m, accelerations };
                    runs.push(by_mesh(&world, &points_m, options)?);
                }
                let saved =
                    |of: &dyn Fn(&Run) -> f64, from: usize, to: usize| 100.0 * (1.0 - of(&runs[to]) / of(&runs[from]));
                let seconds = |run: &Run| run.seconds;
                let rays = |run: &Run| run.rays as f64;
                for (what, of) in [("time / s", &seconds as &dyn Fn(&Run) -> f64), ("rays / 10⁶", &rays)] {
                    let unit = if what.starts_with("rays") { 1e-6 } else { 1.0 };
                    let numbers: Vec<String> = runs.iter().map(|run| format!("{:.2}", unit * of(run))).collect();
                    writeln!(
                        table,
                        "| {name} | {step_m} | {ratio} | {what} | {} | {:.0} % | {:.0} %, {:.0} %, {:.0} % |",
                        numbers.join(" | "),
                        saved(of, 0, 3),
                        saved(of, 0, 1),
                        saved(of, 1, 2),
                        saved(of, 2, 3)
                    )?;
                }
                let errors: Vec<String> =
                    runs.iter().map(|run| format!("{:.2} %", 100.0 * relative_rms(&run.lx, &exact.lx, 1))).collect();
                writeln!(table, "| {name} | {step_m} | {ratio} | RMS error | {} | | |", errors.join(" | "))?;
                let last = &runs[3];
                writeln!(
                    memory,
                    "| {name} | {step_m} | {ratio} | {} | {:.2} | {:.1} | {:.0} |",
                    last.counts.points,
                    last.bytes as f64 / 1e6,
                    last.dense_bytes / 1e6,
                    last.dense_bytes / last.bytes as f64
                )?;
            }
        }
    }
    std::fs::write(out.join("b.md"), table)?;
    std::fs::write(out.join("c.md"), memory)?;
    Ok(())
}

/// Error against step and radius.
fn study_d(out: &Path) -> Outcome<()> {
    let world = World::of(hall(7)?);
    let points_m = grid(DVec3::ZERO, [20.0, 20.0], 200);
    let exact = by_rays(&world, &points_m, 1);
    let ratios = [0.9, 1.25, 2.1, 3.1];
    let mut table = String::from("| step / m | R/h = 0.9 | 1.25 | 2.1 | 3.1 |\n| --: | --: | --: | --: | --: |\n");
    let mut lines = ratios.map(|_| Vec::new());
    for step_m in [0.8, 0.4, 0.2, 0.1, 0.05, 0.02, 0.01, 0.004, 0.002, 0.001] {
        let mut row = Vec::new();
        for (ratio, line) in ratios.iter().zip(&mut lines) {
            // Sets of the widest radius share no points any more: there is nothing to be learned from finer ones.
            if *ratio > 2.0 && step_m < 0.004 {
                row.push("–".to_owned());
                continue;
            }
            let options = Options { step_m, radius_m: ratio * step_m, accelerations: Accelerations::ALL };
            let error = relative_rms(&by_mesh(&world, &points_m, options)?.lx, &exact.lx, 1);
            row.push(format!("{:.3} %", 100.0 * error));
            line.push((step_m, 100.0 * error));
        }
        writeln!(table, "| {step_m} | {} |", row.join(" | "))?;
    }
    std::fs::write(out.join("d.md"), table)?;
    let names = ["R = 0.9 h", "R = 1.25 h", "R = 2.1 h", "R = 3.1 h"];
    chart(&out.join("d.svg"), "49 luminaires, 200² receivers", ["step / m", "RMS error / %"], &names, &lines)
}

/// Width of the shadow of an edge: a ball's penumbra, and what a mesh makes of a point.
fn study_e(out: &Path) -> Outcome<()> {
    let scene = |lamp: &str| -> Outcome<World> {
        let text = format!(
            r#"{{ "version": 1, "materials": {{ "black": {{ "type": "diffuse", "reflectance": 0 }} }},
                "geometry": [ {{ "name": "floor", "type": "box", "min": [-10,-10,-1], "max": [10,10,0], "material": "black" }},
                              {{ "name": "board", "type": "box", "min": [-10,-10,2], "max": [0,10,2.4], "material": "black" }} ],
                "luminaires": [{lamp}] }}"#
        );
        Ok(World::of(scene_from_json(&text, None, Path::new("."))?))
    };
    let ball = |radius_m: f64| {
        format!(
            r#"{{ "name": "ball", "type": "sphere", "center": [0,0,4.4], "radius": {radius_m}, "luminous_flux_lm": 1000 }}"#
        )
    };
    let point = r#"{ "name": "point", "type": "point", "position": [0,0,4.4], "luminous_flux_lm": 1000 }"#;
    let line_m: Vec<DVec3> = (0..=2000).map(|i| DVec3::new(-1.0 + f64::from(i) / 1000.0, 0.0137, 0.0)).collect();
    // Width between a tenth and nine tenths of the light far from the edge.
    let width = |lx: &[f64]| {
        let full = lx[lx.len() - 1];
        let first = |share: f64| lx.iter().position(|lx| *lx >= share * full).unwrap_or(0);
        (first(0.9) - first(0.1)) as f64 / 1000.0
    };
    let mut table =
        String::from("| source | how | step / m | R/h | width 10–90 % / m |\n| --- | --- | --: | --: | --: |\n");
    let mut lines: Vec<Vec<(f64, f64)>> = Vec::new();
    let mut names = Vec::new();
    let mut add = |name: &str, lx: &[f64]| {
        names.push(name.to_owned());
        lines.push(line_m.iter().zip(lx).map(|(point_m, lx)| (point_m.x, *lx)).collect());
    };
    let radius_m = 0.2;
    let world = scene(&ball(radius_m))?;
    let mut exact = vec![0.0; line_m.len()];
    const LOOKS: u64 = 4000;
    exact.par_iter_mut().enumerate().for_each(|(number, lx)| {
        let mut stream = Stream::new(1, Purpose::LightMesh, 0, 0);
        let origin = world.stage.tracer.side_origin(line_m[number], DVec3::Z);
        for look in 0..LOOKS {
            stream.seek(((number as u64) << 32) | look);
            let receiver = Receiver { point_m: line_m[number], normal: DVec3::Z, origin: &origin };
            *lx += look_at_all(&world.stage, &receiver, &mut stream).0 / LOOKS as f64;
        }
    });
    writeln!(table, "| ball of 0.2 m | {LOOKS} shadow rays from every place | | | {:.3} |", width(&exact))?;
    add("ball, shadow rays", &exact);
    let mesh = |world: &World, step_m: f64, ratio: f64| {
        by_mesh(world, &line_m, Options { step_m, radius_m: ratio * step_m, accelerations: Accelerations::ALL })
    };
    for (step_m, ratio) in [(0.02, 1.25), (0.1, 1.25), (0.1, 2.1), (0.2, 2.1)] {
        let run = mesh(&world, step_m, ratio)?;
        writeln!(
            table,
            "| ball of 0.2 m | mesh, 64 points of the ball | {step_m} | {ratio} | {:.3} |",
            width(&run.lx)
        )?;
        if step_m == 0.1 && ratio == 2.1 {
            add("ball, mesh of 0.1 m, R = 2.1 h", &run.lx);
        }
    }
    let world = scene(point)?;
    for (step_m, ratio) in [(0.02, 2.1), (0.05, 2.1), (0.1, 2.1), (0.15, 2.1), (0.2, 2.1), (0.1, 3.1)] {
        let run = mesh(&world, step_m, ratio)?;
        writeln!(table, "| point | mesh alone softens the edge | {step_m} | {ratio} | {:.3} |", width(&run.lx))?;
        if step_m == 0.15 {
            add("point, mesh of 0.15 m, R = 2.1 h", &run.lx);
        }
    }
    std::fs::write(out.join("e.md"), table)?;
    let full = lines[0].last().map_or(1.0, |place| place.1);
    lines.iter_mut().flatten().for_each(|place| place.1 /= full);
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    profile(&out.join("e.svg"), &names, &lines)
}

const COLOURS: [RGBColor; 4] =
    [RGBColor(0, 114, 178), RGBColor(213, 94, 0), RGBColor(0, 158, 115), RGBColor(204, 121, 167)];

/// Lines on logarithmic axes.
fn chart(path: &Path, title: &str, axes: [&str; 2], names: &[&str], lines: &[Vec<(f64, f64)>]) -> Outcome<()> {
    let all = || lines.iter().flatten().filter(|place| place.1 > 0.0);
    let span = |of: fn(&(f64, f64)) -> f64| {
        all().fold((f64::INFINITY, 0.0f64), |(low, high), place| (low.min(of(place)), high.max(of(place))))
    };
    let (x, y) = (span(|place| place.0), span(|place| place.1));
    let root = SVGBackend::new(path, (760, 460)).into_drawing_area();
    root.fill(&WHITE)?;
    let mut chart = ChartBuilder::on(&root)
        .caption(title, ("sans-serif", 18))
        .margin(12)
        .x_label_area_size(44)
        .y_label_area_size(64)
        .build_cartesian_2d((x.0 / 1.2..x.1 * 1.2).log_scale(), (y.0 / 1.5..y.1 * 1.5).log_scale())?;
    chart
        .configure_mesh()
        .x_desc(axes[0])
        .y_desc(axes[1])
        .x_label_formatter(&|number| format!("{number}"))
        .y_label_formatter(&|number| format!("{number}"))
        .light_line_style(RGBColor(236, 236, 236))
        .draw()?;
    for (index, (name, line)) in names.iter().zip(lines).enumerate() {
        let colour = COLOURS[index % COLOURS.len()];
        let drawn: Vec<(f64, f64)> = line.iter().copied().filter(|place| place.1 > 0.0).collect();
        chart
            .draw_series(LineSeries::new(drawn.clone(), colour.stroke_width(2)))?
            .label(*name)
            .legend(move |(x, y)| PathElement::new([(x, y), (x + 20, y)], colour.stroke_width(2)));
        chart.draw_series(drawn.into_iter().map(|place| Circle::new(place, 3, colour.filled())))?;
    }
    chart.configure_series_labels().background_style(WHITE.mix(0.8)).position(SeriesLabelPosition::UpperLeft).draw()?;
    root.present()?;
    Ok(())
}

/// Profiles across an edge.
fn profile(path: &Path, names: &[&str], lines: &[Vec<(f64, f64)>]) -> Outcome<()> {
    let root = SVGBackend::new(path, (760, 420)).into_drawing_area();
    root.fill(&WHITE)?;
    let mut chart = ChartBuilder::on(&root)
        .caption("Shadow of an edge 2 m above the floor, source at 4.4 m", ("sans-serif", 18))
        .margin(12)
        .x_label_area_size(44)
        .y_label_area_size(64)
        .build_cartesian_2d(-0.6..0.6, 0.0..1.1)?;
    chart
        .configure_mesh()
        .x_desc("place across the edge / m")
        .y_desc("illuminance over the open side's")
        .light_line_style(WHITE)
        .draw()?;
    for (index, (name, line)) in names.iter().zip(lines).enumerate() {
        let colour = COLOURS[index % COLOURS.len()];
        let drawn = line.iter().copied().filter(|place| place.0.abs() < 0.6);
        chart
            .draw_series(LineSeries::new(drawn, colour.stroke_width(2)))?
            .label(*name)
            .legend(move |(x, y)| PathElement::new([(x, y), (x + 20, y)], colour.stroke_width(2)));
    }
    chart.configure_series_labels().background_style(WHITE.mix(0.8)).position(SeriesLabelPosition::UpperLeft).draw()?;
    root.present()?;
    Ok(())
}

fn main() -> Outcome<()> {
    let mut arguments = std::env::args().skip(1);
    let out = PathBuf::from(arguments.next().ok_or("usage: light_mesh_study OUT [a b c d e]")?);
    std::fs::create_dir_all(&out)?;
    let asked: Vec<String> = arguments.collect();
    let wants = |name: &str| asked.is_empty() || asked.iter().any(|asked| asked == name);
    if wants("a") {
        study_a(&out)?;
    }
    if wants("b") || wants("c") {
        study_b(&out)?;
    }
    if wants("d") {
        study_d(&out)?;
    }
    if wants("e") {
        study_e(&out)?;
    }
    Ok(())
}
