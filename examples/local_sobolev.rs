//! Sobolev's problem by local estimation: the error of 31 points from 2,048 chains over 40 seeds, and the time of a run.
//!
//!     cargo run --release --example local_sobolev -- [local|local-naive|collision] [chains] [first seed]
//!
//! Prints the medians over the seeds of the root mean square and of the worst relative error of total illuminance, the
//! mean number of rays, and the shortest and the median time of a run on one thread.

use std::time::Instant;

use luxmc::analytic::sobolev::{SobolevPlane, SobolevProblem, sobolev_at_radii};
use luxmc::check::scene_from_json;
use luxmc::solver::{MapSelection, Method, Settings, Silent, solve};

const SEEDS: u64 = 40;
const SCENE: &str = r#"{ "version": 1,
  "materials": { "grey": { "type": "diffuse", "reflectance": 0.5 } },
  "geometry": [
    { "name": "plane 1", "type": "rectangle", "origin": [-100, -100, 0], "u": [200, 0, 0], "v": [0, 200, 0], "material": "grey" },
    { "name": "plane 2", "type": "rectangle", "origin": [-100, -100, 1], "u": [0, 200, 0], "v": [200, 0, 0], "material": "grey" } ],
  "luminaires": [ { "name": "source", "type": "point", "position": [0, 0, 0.5], "intensity_cd": 1 } ],
  "receivers": [ { "name": "line", "type": "grid", "origin": [0, -0.5, 0], "u": [3, 0, 0], "v": [0, 1, 0], "columns": 31, "rows": 1 } ] }"#;

fn median(values: &mut [f64]) -> f64 {
    values.sort_by(f64::total_cmp);
    let half = values.len() / 2;
    (values[half] + values[values.len() - 1 - half]) / 2.0
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let name = std::env::args().nth(1).unwrap_or("local".to_owned());
    let method = match name.as_str() {
        "local" => Method::Local,
        "local-naive" => Method::LocalNaive,
        _ => Method::Collision,
    };
    let chains: u64 = std::env::args().nth(2).map_or(Ok(2048), |text| text.parse())?;
    let first_seed: u64 = std::env::args().nth(3).map_or(Ok(0), |text| text.parse())?;
    let scene = scene_from_json(SCENE, None, std::path::Path::new("."))?;
    let radii: Vec<f64> = (0..31).map(|point| 0.1 * f64::from(point)).collect();
    let problem = SobolevProblem { h1: 0.5, rho1: 0.5, rho2: 0.5 };
    let exact = sobolev_at_radii(&problem, SobolevPlane::One, &radii)?;
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;

    let (mut rms, mut worst, mut times_ms, mut rays) = (Vec::new(), Vec::new(), Vec::new(), 0);
    for seed in first_seed..first_seed + SEEDS {
        let settings =
            Settings { method, seed, chains: Some(chains), maps: MapSelection::Receivers, ..Settings::default() };
        let started = Instant::now();
        let solution = pool.install(|| solve(&scene, &settings, &Silent));
        times_ms.push(1e3 * started.elapsed().as_secs_f64());
        rays += solution.rays;
        let values = &solution.maps[0].values.value;
        let errors = values.iter().zip(&exact).map(|(value, exact)| value / exact.total_lx - 1.0);
        let errors: Vec<f64> = errors.collect();
        rms.push((errors.iter().map(|error| error * error).sum::<f64>() / errors.len() as f64).sqrt());
        worst.push(errors.iter().fold(0.0, |most: f64, error| most.max(error.abs())));
    }
    println!(
        "{name}, {chains} chains: RMS {:.2} %, worst {:.2} % (medians of {SEEDS} seeds from {first_seed}), {} rays, {:.1} ms at least and \
         {:.1} ms in the median on one thread",
        100.0 * median(&mut rms),
        100.0 * median(&mut worst),
        rays / SEEDS,
        times_ms.iter().copied().fold(f64::INFINITY, f64::min),
        median(&mut times_ms)
    );
    Ok(())
}
