//! Common parts of the studies: a scene prepared for meshes, its receivers, and several ways to light them.

use std::fmt::Write as _;
use std::path::Path;
use std::time::Instant;

use glam::DVec3;
use rayon::prelude::*;

use super::wheel::Wheel;
use crate::check::scene_from_json;
use crate::estimators::receiver::Receiver;
use crate::light_mesh::exact::sample_all_emitters;
use crate::light_mesh::{
    Counts, Lattice, LightMesh, NEVER, Options, SamplePlacing, Samples, Solids, Surroundings, Workroom,
};
use crate::sampling::random::{Purpose, Stream};
use crate::scene::Scene;
use crate::transport::{Traced, World};

/// Number of receivers that a thread computes at a time.
const CHUNK: usize = 1024;

/// A scene prepared for meshes.
pub struct StudyScene {
    /// The scene.
    pub scene: Scene,
    /// Data to trace rays.
    pub world: World,
    /// Its closed solids.
    pub solids: Solids,
    /// Light samples of its luminaires.
    pub samples: Samples,
}

/// Results and cost of a run.
#[derive(Clone, Debug, Default)]
pub struct Lit {
    /// Illuminance of every computed receiver, lx.
    pub lx: Vec<f64>,
    /// Counts of the mesh's work.
    pub counts: Counts,
    /// Rays for all receivers.
    pub rays: u64,
    /// Seconds for all receivers.
    pub seconds: f64,
    /// Only every n-th receiver was computed (n = `every`). Seconds and rays are scaled to all receivers.
    pub every: usize,
    /// Bytes of the mesh.
    pub bytes: u64,
    /// Bytes of a mesh over the whole scene with every point stored.
    pub dense_bytes: f64,
}

impl StudyScene {
    /// Prepares a scene.
    pub fn of(scene: Scene) -> StudyScene {
        let world = World::new(&scene);
        let samples = Samples::of(&world, SamplePlacing::Stratified, 0);
        StudyScene { solids: Solids::of(&scene), samples, world, scene }
    }

    /// A scene of black surfaces from its geometry and luminaires.
    pub fn black(geometry: &str, luminaires: &str) -> Result<StudyScene, String> {
        let text = format!(
            r#"{{ "version": 1, "materials": {{ "black": {{ "type": "diffuse", "reflectance": 0 }} }},
                "geometry": [{geometry}], "luminaires": [{luminaires}] }}"#
        );
        scene_from_json(&text, None, Path::new(".")).map(StudyScene::of).map_err(|error| error.to_string())
    }

    fn around(&self) -> Surroundings<'_> {
        let StudyScene { scene, world, solids, samples } = self;
        Surroundings { scene, world, solids, samples, give_up: NEVER }
    }

    /// Computes the illuminance of upward-facing receivers by a mesh.
    pub fn by_mesh(&self, points_m: &[DVec3], options: Options) -> Result<Lit, String> {
        let started = Instant::now();
        let mut bounds_m = [DVec3::INFINITY, DVec3::NEG_INFINITY];
        points_m.iter().for_each(|point_m| bounds_m = [bounds_m[0].min(*point_m), bounds_m[1].max(*point_m)]);
        let mesh = LightMesh::new(self.around(), bounds_m, options)
            .ok_or_else(|| format!("a mesh of {} m has more points than numbers for them", options.step_m))?;
        let chunks: Vec<(Vec<f64>, Counts)> = points_m
            .par_chunks(CHUNK)
            .map(|chunk| {
                let mut room = Workroom::default();
                let lx = chunk.iter().map(|point_m| {
                    let origin = self.world.tracer.side_origin(*point_m, DVec3::Z);
                    mesh.direct(&Receiver { point_m: *point_m, normal: DVec3::Z, origin: &origin }, &mut room)
                        .illuminance_lx
                });
                (lx.collect(), room.counts)
            })
            .collect();
        let seconds = started.elapsed().as_secs_f64();
        let mut lit = Lit { every: 1, seconds, bytes: mesh.bytes(), ..Lit::default() };
        for (part, counts) in chunks {
            lit.lx.extend(part);
            lit.counts += counts;
        }
        lit.rays = lit.counts.rays();

        // A dense mesh that does not depend on the receivers has to cover the whole scene.
        let low_m = self.scene.vertices_m.iter().fold(DVec3::INFINITY, |low_m, vertex_m| low_m.min(*vertex_m));
        let high_m = self.scene.vertices_m.iter().fold(DVec3::NEG_INFINITY, |high_m, vertex_m| high_m.max(*vertex_m));
        let whole = Lattice::over([low_m, high_m], options.step_m, options.radius_m);
        let bytes_per_point = mesh.dense_bytes() / mesh.lattice.points();
        lit.dense_bytes = whole.map_or(f64::INFINITY, |whole| whole.points()) * bytes_per_point;
        Ok(lit)
    }

    /// Computes the illuminance by shadow rays to every luminaire, `samples` times each, for as many receivers as `most_rays` allows.
    pub fn by_rays(&self, points_m: &[DVec3], samples: u64, most_rays: f64) -> Lit {
        let all_rays = (points_m.len() * self.world.emitters.list().len()) as f64 * samples as f64;
        self.every_so_many(points_m, (all_rays / most_rays).ceil().max(1.0) as usize, |number, receiver| {
            let mut stream = Stream::new(1, Purpose::LightMesh, 0, 0);
            let mut sum = Traced::default();
            for sample in 0..samples {
                stream.seek_quasi((number << 32) | sample, number, sample);
                sum += sample_all_emitters(&self.world, receiver, &mut stream);
            }
            sum / samples as f64
        })
    }

    /// Computes the illuminance by a shadow ray to each of `count` points of each area, each point as a point source.
    pub fn by_points(&self, points_m: &[DVec3], count: usize, most_rays: f64) -> Lit {
        let sources = Samples::of(&self.world, SamplePlacing::Count(count), 0);
        let every = ((points_m.len() * sources.len()) as f64 / most_rays).ceil().max(1.0) as usize;
        self.every_so_many(points_m, every, |_, receiver| sources.as_point_sources_lx(&self.world, receiver))
    }

    fn every_so_many(&self, points_m: &[DVec3], every: usize, light: impl Fn(u64, &Receiver) -> Traced + Sync) -> Lit {
        let started = Instant::now();
        let asked: Vec<(u64, DVec3)> = (0u64..).zip(points_m.iter().copied()).step_by(every).collect();
        let found: Vec<Traced> = asked
            .par_iter()
            .map(|(number, point_m)| {
                let origin = self.world.tracer.side_origin(*point_m, DVec3::Z);
                light(*number, &Receiver { point_m: *point_m, normal: DVec3::Z, origin: &origin })
            })
            .collect();
        let scale = points_m.len() as f64 / asked.len().max(1) as f64;
        Lit {
            seconds: started.elapsed().as_secs_f64() * scale,
            rays: (found.iter().map(|light| light.rays).sum::<u64>() as f64 * scale) as u64,
            lx: found.into_iter().map(|light| light.value).collect(),
            every,
            ..Lit::default()
        }
    }
}

/// Relative RMS error of a run compared with exact values of every n-th receiver.
pub fn relative_rms(found: &Lit, exact: &Lit) -> f64 {
    let pairs = found.lx.iter().step_by(exact.every / found.every.max(1)).zip(&exact.lx);
    let squares: f64 = pairs.map(|(found, exact)| (found - exact).powi(2)).sum();
    let count = exact.lx.len().max(1) as f64;
    (squares / count).sqrt() / (exact.lx.iter().sum::<f64>() / count)
}

/// `edge`² points of a horizontal rectangle, at the middles of equal cells.
pub fn grid(low_m: DVec3, size_m: [f64; 2], edge: usize) -> Vec<DVec3> {
    let at = |number: usize, size_m: f64| size_m * (number as f64 + 0.5) / edge as f64;
    (0..edge * edge).map(|i| low_m + DVec3::new(at(i % edge, size_m[0]), at(i / edge, size_m[1]), 0.0)).collect()
}

/// Edge of the hall's floor in m.
pub const HALL_M: f64 = 20.0;

/// A black hall of 20 m × 20 m × 4 m with 24 crates and `edge`² lamps under its ceiling.
pub fn hall(edge: usize) -> Result<StudyScene, String> {
    let (first, across) = (0.5 * HALL_M / edge as f64, HALL_M - HALL_M / edge as f64);
    let array = if edge > 1 {
        format!(r#", "columns": {edge}, "rows": {edge}, "u": [{across},0,0], "v": [0,{across},0]"#)
    } else {
        String::new()
    };
    let lamp = format!(
        r#"{{ "name": "lamp", "type": "point", "position": [{first},{first},3.8], "intensity_cd": 100{array} }}"#
    );
    StudyScene::black(&hall_with_crates(), &lamp)
}

/// The hall's geometry; its crates are always the same.
pub fn hall_with_crates() -> String {
    let mut wheel = Wheel(5);
    let mut turn = || wheel.turn();
    let mut geometry = format!(
        r#"{{ "name": "room", "type": "box", "min": [0,0,0], "max": [{HALL_M},{HALL_M},4], "facing": "inward", "material": "black" }}"#
    );
    for crate_number in 0..24 {
        let (x, y) = (1.0 + 17.0 * turn(), 1.0 + 17.0 * turn());
        let (width, depth, height) = (0.5 + turn(), 0.5 + turn(), 0.5 + 1.7 * turn());
        // Writing to a string cannot fail.
        write!(
            geometry,
            r#", {{ "name": "crate {crate_number}", "type": "box", "min": [{x},{y},0], "max": [{},{},{height}], "material": "black" }}"#,
            x + width,
            y + depth
        )
        .ok();
    }
    geometry
}
