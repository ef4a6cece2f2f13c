//! The angular distribution of the luminance of glossy planes under a bright ball, luxmc's own against plain backward
//! paths; after figure 6 of V. S. Zheltov and V. P. Budak, "Local Monte Carlo estimation methods in the solution of global
//! illumination equation".
//!
//!     cargo run --release --example phong_fan -- OUT.svg [paths]

use std::f64::consts::PI;
use std::path::Path;

use glam::DVec3;
use luxmc::chain::Stage;
use luxmc::geometry::Meeting;
use luxmc::output::axes::{Frame, Scale};
use luxmc::output::color::{BLUE, SOFT, VERMILION};
use luxmc::output::picture::{Pen, Picture, Words};
use luxmc::sampling::random::{Purpose, Stream};
use luxmc::sampling::reflection::{Pair, Way};
use luxmc::scene::{ReceiverPoint, scene_from_json};
use luxmc::solver::{MapSelection, Method, Observer, Progress, Settings, solve};
use rayon::prelude::*;

const SCENE: &str = r#"{ "version": 1,
  "materials": { "lacquer": { "type": "phong", "diffuse_reflectance": 0.3, "specular_reflectance": 0.4, "exponent": 20 } },
  "geometry": [
    { "name": "plane 1", "type": "rectangle", "origin": [-50, -50, 0], "u": [100, 0, 0], "v": [0, 100, 0], "material": "lacquer" },
    { "name": "plane 2", "type": "rectangle", "origin": [-50, -50, 1], "u": [0, 100, 0], "v": [100, 0, 0], "material": "lacquer" } ],
  "luminaires": [ { "name": "ball", "type": "sphere", "center": [0, 0, 0.5], "radius": 0.2, "luminous_flux_lm": 10 } ],
  "receivers": [ RECEIVERS ] }"#;
/// The ball.
const BALL_M: DVec3 = DVec3::new(0.0, 0.0, 0.5);
const RADIUS_M: f64 = 0.2;
/// Directions, and the angles of the first and the last from the normal.
const DIRECTIONS: usize = 33;
const WIDEST_DEG: f64 = 80.0;

struct Silent;

impl Observer for Silent {
    fn progress(&self, _: &Progress) {}
    fn is_interrupted(&self) -> bool {
        false
    }
    fn wall_s(&self) -> f64 {
        0.0
    }
}

/// One backward path: at every vertex the law towards a direction drawn uniformly in the cone that the ball fills, if
/// nothing stands before it. Returns the luminance over that of the ball.
fn backward_path(stage: &Stage, eye: &ReceiverPoint, stream: &mut Stream) -> f64 {
    let (mut origin, mut direction) = (stage.tracer.free_origin(eye.position_m), eye.normal);
    let mut sum = 0.0;
    while let Meeting::Surface(hit) = stage.tracer.first_hit(&origin, direction) {
        let normal = stage.normal(hit.triangle, hit.side);
        let law = stage.law(hit.triangle);
        origin = stage.leave(&hit, Way::Spread);
        let offset = BALL_M - stage.tracer.position_m(&origin);
        let one_minus_cos = 1.0 - (1.0 - RADIUS_M * RADIUS_M / offset.length_squared()).sqrt();
        let [u, v] = stream.pair();
        let cosine = 1.0 - u * one_minus_cos;
        let sine = (1.0 - cosine * cosine).max(0.0).sqrt();
        let axis = offset.normalize();
        let (across, upright) = axis.any_orthonormal_pair();
        let (turn_sine, turn_cosine) = (2.0 * PI * v).sin_cos();
        let towards = cosine * axis + sine * (turn_cosine * across + turn_sine * upright);
        if towards.dot(normal) > 0.0 && matches!(stage.tracer.first_hit(&origin, towards), Meeting::Ball(_)) {
            let pair = Pair { normal, towards, leaving: -direction };
            sum += law.eval_per_sr(&pair) * towards.dot(normal) * 2.0 * PI * one_minus_cos;
        }
        let Some(scattered) = law.sample(direction, normal, stream) else { break };
        direction = scattered.direction;
    }
    sum
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let out = std::env::args().nth(1).ok_or("name the SVG file")?;
    let paths: u64 = std::env::args().nth(2).map_or(Ok(200_000), |text| text.parse())?;
    // Every direction looks at the same point of the lower plane, 0.9 from the foot of the ball's centre.
    let angle = |index: usize| -WIDEST_DEG + 2.0 * WIDEST_DEG * index as f64 / (DIRECTIONS - 1) as f64;
    let receivers: Vec<String> = (0..DIRECTIONS)
        .map(|index| {
            let (sine, cosine) = angle(index).to_radians().sin_cos();
            let reach = 0.05;
            format!(
                r#"{{ "name": "{index}", "type": "luminance", "position": [{}, 0, {}], "directions": [[{}, 0, {}]] }}"#,
                0.9 - reach * sine,
                reach * cosine,
                sine,
                -cosine
            )
        })
        .collect();
    let scene = scene_from_json(&SCENE.replace("RECEIVERS", &receivers.join(",")), None, Path::new("."))?;
    let settings = |method| Settings {
        method,
        seed: 1,
        chains: Some(1 << 18),
        maps: MapSelection::Receivers,
        ..Settings::default()
    };
    let own = solve(&scene, &settings(Method::Collision), &Silent);
    let stage = Stage::new(&scene);
    let ball_cd_m2 = stage.emitters.list()[0].exitance_lm_m2().ok_or("a ball")? / PI;
    let plain: Vec<(f64, f64)> = scene
        .receivers
        .par_iter()
        .enumerate()
        .map(|(index, set)| {
            let mut stream = Stream::new(77, Purpose::Pilot, index as u32, 0);
            let (mut sum, mut squares) = (0.0, 0.0);
            for path in 0..paths {
                stream.seek(path);
                let luminance = ball_cd_m2 * backward_path(&stage, &set.points[0], &mut stream);
                sum += luminance;
                squares += luminance * luminance;
            }
            let mean = sum / paths as f64;
            (mean, ((squares / paths as f64 - mean * mean) / paths as f64).sqrt())
        })
        .collect();

    println!("angle/°  luxmc/(cd/m²)  ±  plain paths  ±  deviation/%");
    let (mut squares, mut expected) = (0.0, 0.0);
    let mut greatest = 0.0f64;
    for (index, (map, (other, other_error))) in own.maps.iter().zip(&plain).enumerate() {
        let values = &map.values;
        let (value, error) = (values.illuminance_lx[0], values.standard_error_lx[0]);
        squares += (value / other - 1.0).powi(2);
        expected += (error / value).powi(2) + (other_error / other).powi(2);
        greatest = greatest.max(value);
        println!(
            "{:6.1}  {value:.5}  {error:.5}  {other:.5}  {other_error:.5}  {:.2}",
            angle(index),
            100.0 * (value / other - 1.0)
        );
    }
    let root = |sum: f64| 100.0 * (sum / DIRECTIONS as f64).sqrt();
    println!("RMS deviation {:.2} %, of which chance explains {:.2} %", root(squares), root(expected));

    let mut picture = Picture::new(820.0, 500.0, "Luminance of a glossy plane over the angle");
    picture.words(
        Words::new("Glossy plane under a bright ball: luminance over the angle of view", [60.0, 28.0], 16.0).bold(),
    );
    picture.words(
        Words::new(
            "line: luxmc; dots: plain backward paths. ρ = 0.3 + 0.4, exponent 20, point 0.9 from the ball's foot",
            [60.0, 48.0],
            12.0,
        )
        .ink(SOFT),
    );
    let frame = Frame {
        left: 80.0,
        top: 66.0,
        width: 700.0,
        height: 360.0,
        x: Scale::linear(-90.0, 90.0),
        y: Scale::linear(0.0, 1.1 * greatest),
    };
    frame.draw_plain(&mut picture, ["angle from the normal / °", "luminance / cd/m²"]);
    let line = (0..DIRECTIONS).map(|index| frame.spot(angle(index), own.maps[index].values.illuminance_lx[0]));
    picture.line(line.collect(), Pen::new(BLUE, 1.8));
    for (index, (value, _)) in plain.iter().enumerate() {
        picture.disk(frame.spot(angle(index), *value), 3.0, VERMILION);
    }
    std::fs::write(&out, picture.svg())?;
    Ok(())
}
