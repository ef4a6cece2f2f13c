//! Study of shadows by the techniques of games, compared with the light mesh and shadow rays: errors in lx, and costs.

pub mod depth_map;
pub mod wedges;

use std::time::Instant;

use glam::DVec3;
use rayon::prelude::*;

use super::open_air::{Lamps, gazebo, playground};
use super::savings::place_of;
use super::study_scene::{Lit, StudyScene};
use super::{Findings, StudyWishes};
use crate::light_mesh::{Accelerations, Options};
use crate::transport::Traced;
use crate::validation::report::Table;
use crate::validation::words::{grouped, percent, signed_percent, significant};
use depth_map::DepthMap;
use wedges::Wedges;

/// Radius of both lamps in m: the scenes are 400 m wide, the lamps 220 and 260 m high.
const BALL_M: f64 = 8.0;
/// Light samples of every lamp from each point for the truth, and the truth's maximum number of rays.
const SHADOW_RAYS_OF_TRUTH: u64 = 256;
const MOST_RAYS: f64 = 2e7;
/// Search radius of single-sample soft shadows for the edge of a hard shadow, in m.
const REACH_M: f64 = 5.0;

/// A technique to make shadows from a shadow map.
enum MapShadow {
    /// Percentage-closer filtering over `edge`² texels.
    Filtered { edge: i64 },
    /// Single-sample soft shadows.
    SingleSample,
}

/// The scene with balls as lamps, and with points in their place.
struct LitScene {
    name: &'static str,
    balls: StudyScene,
    points: StudyScene,
    points_m: Vec<DVec3>,
    size_m: [f64; 2],
}

impl LitScene {
    /// Illuminance by all lamps at every point, from the visible share of each lamp. `seen` returns this share and the rays traced.
    fn lit_by(&self, started: Instant, made: u64, seen: impl Fn(usize, DVec3) -> Traced + Sync) -> Lit {
        let lamps = self.balls.world.emitters.list();
        let light = |place_m: &DVec3| {
            lamps.iter().enumerate().fold(Traced::default(), |sum, (lamp, emitter)| {
                sum + emitter.unshadowed_lx(*place_m, DVec3::Z) * seen(lamp, *place_m)
            })
        };
        let found: Vec<Traced> = self.points_m.par_iter().map(light).collect();
        let rays = made + found.iter().map(|light| light.rays).sum::<u64>();
        let lx = found.into_iter().map(|light| light.value).collect();
        Lit { lx, rays, seconds: started.elapsed().as_secs_f64(), every: 1, ..Lit::default() }
    }

    fn lamps_m(&self) -> Vec<DVec3> {
        self.balls.world.emitters.list().iter().map(|emitter| emitter.center_m()).collect()
    }

    fn by_map(&self, edge: usize, rival: &MapShadow) -> Lit {
        let started = Instant::now();
        let map = |lamp_m| DepthMap::of(&self.points, lamp_m, self.size_m, [edge; 2]);
        let maps: Vec<DepthMap> = self.lamps_m().into_iter().map(map).collect();
        let made = maps.iter().map(|map| map.rays).sum();
        self.lit_by(started, made, |lamp, place_m| match rival {
            MapShadow::Filtered { edge } => Traced { value: maps[lamp].share_of_lit(place_m, *edge), rays: 0 },
            MapShadow::SingleSample => Traced { value: maps[lamp].single_sample(place_m, REACH_M), rays: 0 },
        })
    }

    fn by_silhouettes(&self, outward_alone: bool) -> Lit {
        let started = Instant::now();
        let wedges = |lamp_m| Wedges::of(&self.points, lamp_m, BALL_M, self.size_m);
        let wedges: Vec<Wedges> = self.lamps_m().into_iter().map(wedges).collect();
        self.lit_by(started, 0, |lamp, place_m| {
            let seen = wedges[lamp].seen_from(place_m);
            Traced { value: if outward_alone { seen.outward } else { seen.wedges }, rays: 1 }
        })
    }
}

/// Errors in lx compared with the truth of every n-th point: root mean square, largest, and mean.
fn errors_lx(found: &Lit, exact: &Lit) -> [f64; 3] {
    let off: Vec<f64> =
        found.lx.iter().step_by(exact.every / found.every).zip(&exact.lx).map(|(found, exact)| found - exact).collect();
    let count = off.len() as f64;
    let square = off.iter().map(|lx| lx * lx).sum::<f64>() / count;
    let worst = off.iter().fold(0.0, |worst: f64, lx| worst.max(lx.abs()));
    [square.sqrt(), worst, off.iter().sum::<f64>() / count]
}

/// Study of every shadow technique on both scenes.
pub fn shadow_rivals(wishes: &mut StudyWishes) -> Result<Findings, String> {
    let (edge, maps): (usize, [usize; 2]) = if wishes.quick { (64, [128, 256]) } else { (512, [512, 2048]) };
    let mut found = Findings::of(
        "shadow-rivals",
        "The open-air scenes of the studies of light meshes, 400 m wide, with two balls of 8 m radius 220 and 260 m high as lamps; receivers on the lawn. *Shadow map*: a texel stores how far light from a lamp's centre reaches, and the share of lit texels around a point is its light (percentage-closer filtering; Reeves, Salesin and Cook 1987). *Single-sample*: light changes evenly over 5 m to either side of the map's hard edge (Brabec and Seidel 2002). *Wedges*: soft shadow volumes of the silhouettes seen from a lamp's centre (Assarsson and Akenine-Möller 2003). *Outward*: points that the centre does not light are black, and the light increases outside of them (Parker, Shirley and Smits 1998). All use the same formula for the unhidden illuminance, so they differ only in shadows. Errors are against 256 shadow rays to each ball. Here a ray fills a texel; games leave that to the graphics card, so only times of the same kind can be compared.",
    );
    let mut rows = Vec::new();
    for (name, things, depth) in [("gazebo", gazebo(), 400.0), ("playground", playground(), 350.0)] {
        let (balls, points_m) = place_of(name, &things, depth, Lamps::Balls { radius_m: BALL_M }, edge)?;
        let (points, _) = place_of(name, &things, depth, Lamps::Points, 2)?;
        let lit_scene = LitScene { name, balls, points, points_m, size_m: [400.0, depth] };
        (wishes.tell)(&format!("{name}: {SHADOW_RAYS_OF_TRUTH} shadow rays to each lamp"));
        let exact = lit_scene.balls.by_rays(
            &lit_scene.points_m,
            SHADOW_RAYS_OF_TRUTH,
            if wishes.quick { 1e6 } else { MOST_RAYS },
        );
        let mean_lx = exact.lx.iter().sum::<f64>() / exact.lx.len() as f64;
        let mut ways: Vec<(String, Lit)> = Vec::new();
        for texels in maps {
            for edge in [3, 15] {
                (wishes.tell)(&format!("{name}: shadow map of {texels}², {edge}² texels"));
                let lit = lit_scene.by_map(texels, &MapShadow::Filtered { edge });
                ways.push((format!("shadow map {texels}², filter {edge}²"), lit));
            }
        }
        let texels = maps[0] * 2;
        (wishes.tell)(&format!("{name}: single-sample soft shadows, map of {texels}²"));
        ways.push((format!("single-sample, map {texels}²"), lit_scene.by_map(texels, &MapShadow::SingleSample)));
        (wishes.tell)(&format!("{name}: silhouettes"));
        ways.push(("outward".to_owned(), lit_scene.by_silhouettes(true)));
        ways.push(("wedges".to_owned(), lit_scene.by_silhouettes(false)));
        for step_m in if wishes.quick { [8.0, 4.0] } else { [2.0, 1.0] } {
            (wishes.tell)(&format!("{name}: light mesh of {step_m} m"));
            let options = Options { step_m, radius_m: 1.25 * step_m, accelerations: Accelerations::ALL };
            ways.push((format!("light mesh, h = {step_m} m"), lit_scene.balls.by_mesh(&lit_scene.points_m, options)?));
        }
        for looks in [1, 4, 16] {
            (wishes.tell)(&format!("{name}: {looks} shadow rays to each lamp"));
            ways.push((
                format!("shadow rays, {looks} a lamp"),
                lit_scene.balls.by_rays(&lit_scene.points_m, looks, f64::INFINITY),
            ));
        }
        let least = |what: &str| {
            let those = ways.iter().filter(|(way, _)| way.starts_with(what));
            those.map(|(_, lit)| errors_lx(lit, &exact)[0]).fold(f64::INFINITY, f64::min)
        };
        found.results.push(format!(
            "{name} ({} triangles, {} receivers, mean {} lx): the errors are {} lx at best for shadow maps, {} for single-sample soft shadows, {} for outward ones, {} for wedges, {} for the light mesh; {} for 16 shadow rays to each lamp.",
            grouped(lit_scene.balls.scene.triangles.len() as u64),
            grouped(lit_scene.points_m.len() as u64),
            significant(mean_lx, 3),
            significant(least("shadow map"), 3),
            significant(least("single-sample"), 3),
            significant(least("outward"), 3),
            significant(least("wedges"), 3),
            significant(least("light mesh"), 3),
            significant(least("shadow rays, 16"), 3),
        ));
        rows.extend(ways.iter().map(|(way, lit)| {
            let [rms_lx, worst_lx, mean_off_lx] = errors_lx(lit, &exact);
            vec![
                lit_scene.name.to_owned(),
                way.clone(),
                significant(rms_lx, 3),
                percent(rms_lx / mean_lx),
                significant(worst_lx, 3),
                signed_percent(mean_off_lx / mean_lx),
                significant(lit.rays as f64 * 1e-6, 3),
                significant(lit.seconds, 3),
            ]
        }));
    }
    let header =
        vec!["scene", "shadows", "RMS error, lx", "RMS error", "worst, lx", "mean off by", "rays, 10⁶", "time, s"];
    found.tables.push(("Errors and costs".to_owned(), Table { header, text_columns: vec![0, 1], rows }));
    Ok(found)
}
