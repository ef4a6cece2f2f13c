//! The angular distribution of the luminance of glossy planes under a bright ball, by local estimation against plain backward paths; after
//! figure 6 of V. S. Zheltov and V. P. Budak, "Local Monte Carlo estimation methods in the solution of global illumination equation".
//!
//!     cargo run --release --example phong_fan -- OUT.svg [chains] [error of the paths in %]
//!
//! Every direction gets as many paths as are needed for the required standard error (0.13 %), according to the spread of 4,096 others.
//! Prints both values of every direction with their standard errors, and the wall time of each method.

use std::f64::consts::PI;
use std::ops::Range;
use std::path::Path;
use std::time::Instant;

use glam::DVec3;
use luxmc::check::scene_from_json;
use luxmc::geometry::Meeting;
use luxmc::output::axes::{ChartFrame, Scale};
use luxmc::output::color::{BLUE, SOFT, VERMILION};
use luxmc::output::picture::{Pen, Picture, Words};
use luxmc::sampling::random::{Purpose, Stream};
use luxmc::sampling::reflection::{LobeKind, Pair};
use luxmc::scene::ReceiverPoint;
use luxmc::solver::{MapSelection, Method, Settings, Silent, solve};
use luxmc::transport::World;
use rayon::prelude::*;

const SCENE: &str = r#"{ "version": 1,
  "materials": { "lacquer": { "type": "phong", "diffuse_reflectance": 0.3, "specular_reflectance": 0.4, "exponent": 20 } },
  "geometry": [
    { "name": "plane 1", "type": "rectangle", "origin": [-50, -50, 0], "u": [100, 0, 0], "v": [0, 100, 0], "material": "lacquer" },
    { "name": "plane 2", "type": "rectangle", "origin": [-50, -50, 1], "u": [0, 100, 0], "v": [100, 0, 0], "material": "lacquer" } ],
  "luminaires": [ { "name": "ball", "type": "sphere", "center": [0, 0, 0.5], "radius": 0.2, "luminous_flux_lm": 10 } ],
  "receivers": [ { "name": "fan", "type": "luminance", "position": [0.9, 0, 0.01],
    "fan": { "direction": [0, 0, -1], "axis": [0, 1, 0], "from_deg": -80, "to_deg": 80, "count": 17 } } ] }"#;
/// Centre of the ball in m.
const BALL_M: DVec3 = DVec3::new(0.0, 0.0, 0.5);
const RADIUS_M: f64 = 0.2;
/// Pilot paths from which the number of the other paths follows.
const PILOT_PATHS: u64 = 4096;

/// Result of the plain paths of a direction.
struct Plain {
    mean_cd_m2: f64,
    error_cd_m2: f64,
    paths: u64,
}

/// One backward path. At every vertex it evaluates the BSDF towards a direction drawn uniformly in the cone of the ball, if nothing hides
/// it. Returns the luminance divided by that of the ball.
fn backward_path(world: &World, eye: &ReceiverPoint, stream: &mut Stream) -> f64 {
    let (mut origin, mut direction) = (world.tracer.free_origin(eye.position_m), eye.normal);
    let mut sum = 0.0;
    while let Meeting::Surface(hit) = world.tracer.first_hit(&origin, direction) {
        let normal = world.normal(hit.triangle, hit.side);
        let bsdf = world.bsdf(hit.triangle);
        origin = world.leave(&hit, LobeKind::Spread);
        let offset = BALL_M - world.tracer.position_m(&origin);
        let one_minus_cos = 1.0 - (1.0 - RADIUS_M * RADIUS_M / offset.length_squared()).sqrt();
        let [u, v] = stream.pair();
        let cosine = 1.0 - u * one_minus_cos;
        let sine = (1.0 - cosine * cosine).max(0.0).sqrt();
        let axis = offset.normalize();
        let (across, upright) = axis.any_orthonormal_pair();
        let (turn_sine, turn_cosine) = (2.0 * PI * v).sin_cos();
        let towards = cosine * axis + sine * (turn_cosine * across + turn_sine * upright);
        if towards.dot(normal) > 0.0 && matches!(world.tracer.first_hit(&origin, towards), Meeting::Ball(_)) {
            let pair = Pair { normal, towards, leaving: -direction };
            sum += bsdf.eval_per_sr(&pair) * towards.dot(normal) * 2.0 * PI * one_minus_cos;
        }
        let Some(scattered) = bsdf.sample(direction, normal, stream) else { break };
        direction = scattered.direction;
    }
    sum
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let out = std::env::args().nth(1).ok_or("name the SVG file")?;
    let chains: u64 = std::env::args().nth(2).map_or(Ok(1 << 21), |text| text.parse())?;
    let asked_percent: f64 = std::env::args().nth(3).map_or(Ok(0.13), |text| text.parse())?;
    let scene = scene_from_json(SCENE, None, Path::new("."))?;
    let eyes = &scene.receivers[0].points;
    // Negative where the line of sight goes towards the ball's foot.
    let angle = |index: usize| eyes[index].normal.x.atan2(-eyes[index].normal.z).to_degrees();
    let settings = Settings {
        method: Method::Local,
        seed: 1,
        chains: Some(chains),
        maps: MapSelection::Receivers,
        ..Settings::default()
    };
    let started = Instant::now();
    let own = solve(&scene, &settings, &Silent);
    let own_s = started.elapsed().as_secs_f64();
    let own = &own.maps[0].values;
    let world = World::new(&scene);
    let ball_cd_m2 = world.emitters.list()[0].exitance_lm_m2().ok_or("a ball")? / PI;
    let started = Instant::now();
    let plain: Vec<Plain> = (0..eyes.len())
        .into_par_iter()
        .map(|index| {
            let mut stream = Stream::new(77, Purpose::Pilot, index as u32, 0);
            let mut follow = |paths: Range<u64>| {
                let count = paths.end - paths.start;
                let (mut sum, mut squares) = (0.0, 0.0);
                for path in paths {
                    stream.seek(path);
                    let luminance_cd_m2 = ball_cd_m2 * backward_path(&world, &eyes[index], &mut stream);
                    sum += luminance_cd_m2;
                    squares += luminance_cd_m2 * luminance_cd_m2;
                }
                let mean_cd_m2 = sum / count as f64;
                let variance = squares / count as f64 - mean_cd_m2 * mean_cd_m2;
                Plain { mean_cd_m2, error_cd_m2: (variance / count as f64).sqrt(), paths: count }
            };
            let pilot = follow(0..PILOT_PATHS);
            let over = 100.0 * pilot.error_cd_m2 / pilot.mean_cd_m2 / asked_percent;
            let paths = (PILOT_PATHS as f64 * over * over).ceil().max(PILOT_PATHS as f64) as u64;
            follow(PILOT_PATHS..PILOT_PATHS + paths)
        })
        .collect();
    let plain_s = started.elapsed().as_secs_f64();

    println!("angle/°  luxmc/(cd/m²)  ±/%  plain paths  ±/%  paths  deviation/%  over its standard error");
    let (mut squares, mut expected, mut most, mut greatest) = (0.0, 0.0, 0.0f64, 0.0f64);
    for (index, plain) in plain.iter().enumerate() {
        let (value, error) = (own.value[index], own.standard_error[index]);
        let (own_part, plain_part) = (error / value, plain.error_cd_m2 / plain.mean_cd_m2);
        let (deviation, chance) = (value / plain.mean_cd_m2 - 1.0, own_part.hypot(plain_part));
        squares += deviation * deviation;
        expected += chance * chance;
        most = most.max((deviation / chance).abs());
        greatest = greatest.max(value);
        println!(
            "{:6.1}  {value:.5}  {:.2}  {:.5}  {:.2}  {:9}  {:5.2}  {:5.2}",
            angle(index),
            100.0 * own_part,
            plain.mean_cd_m2,
            100.0 * plain_part,
            plain.paths,
            100.0 * deviation,
            deviation / chance
        );
    }
    let root = |sum: f64| 100.0 * (sum / eyes.len() as f64).sqrt();
    println!(
        "RMS deviation {:.2} %, of which chance explains {:.2} %; at most {most:.1} standard errors; {own_s:.0} s and {plain_s:.0} s",
        root(squares),
        root(expected)
    );

    let mut picture = Picture::new(820.0, 500.0, "Luminance of a glossy plane over the angle");
    picture.words(
        Words::new("Glossy plane under a bright ball: luminance over the angle of view", [60.0, 28.0], 16.0).bold(),
    );
    picture.words(
        Words::new(
            "line: luxmc; dots: plain backward paths. ρ = 0.3 + 0.4, exponent 20, point 0.9 m from the ball's foot",
            [60.0, 48.0],
            12.0,
        )
        .ink(SOFT),
    );
    let frame = ChartFrame {
        left: 80.0,
        top: 66.0,
        width: 700.0,
        height: 360.0,
        x: Scale::linear(-90.0, 90.0),
        y: Scale::linear(0.0, 1.1 * greatest),
    };
    frame.draw_plain(&mut picture, ["angle from the normal / °", "luminance / cd/m²"]);
    let line = (0..eyes.len()).map(|index| frame.spot(angle(index), own.value[index]));
    picture.line(line.collect(), Pen::new(BLUE, 1.8));
    for (index, plain) in plain.iter().enumerate() {
        picture.disk(frame.spot(angle(index), plain.mean_cd_m2), 3.0, VERMILION);
    }
    std::fs::write(&out, picture.svg())?;
    Ok(())
}
