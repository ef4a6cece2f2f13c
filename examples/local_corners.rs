//! Receivers closer and closer to the edge of an isothermal box, by local estimation, its plain kernel and walks. Does the error bar hold,
//! and how much work does an error of 1 % take?
//!
//!     cargo run --release --example local_corners -- [local|local-naive|collision] [chains] [seeds]
//!
//! The true illuminance is πL₀ everywhere. "cost" is the counted rays times the squared true error in percent, which is the number of rays
//! for an error of 1 %.

use luxmc::check::scene_from_json;
use luxmc::solver::{MapSelection, Method, Settings, Silent, solve};

/// Student's t at 15 degrees of freedom for 68.27 % and 95.45 %.
const ONE_SIGMA: f64 = 1.0338;
const TWO_SIGMA: f64 = 2.1812;
/// Number of receivers along the edge.
const POINTS: f64 = 32.0;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let name = std::env::args().nth(1).unwrap_or("local".to_owned());
    let method = match name.as_str() {
        "local" => Method::Local,
        "local-naive" => Method::LocalNaive,
        _ => Method::Collision,
    };
    let chains: u64 = std::env::args().nth(2).map_or(Ok(4096), |text| text.parse())?;
    let seeds: u64 = std::env::args().nth(3).map_or(Ok(200), |text| text.parse())?;
    println!("{name}: distance/m, within 1 and 2 standard errors, true RMS error, rays, rays to 1 %");
    for distance_m in [0.1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6] {
        // Receivers are on the floor and face up. The wall beside it fills half of their field of view.
        let text = format!(
            r#"{{ "version": 1,
  "materials": {{ "grey": {{ "type": "diffuse", "reflectance": 0.5 }} }},
  "geometry": [ {{ "name": "box", "type": "box", "min": [0,0,0], "max": [2,2,2], "facing": "inward", "material": "grey" }} ],
  "luminaires": [ {{ "name": "glow", "type": "area", "surface": "box", "exitance_lm_m2": 157.07963267948966 }} ],
  "receivers": [ {{ "name": "edge", "type": "grid", "origin": [{distance_m}, 0.5, 0.0], "u": [0,1,0], "v": [-1e-9,0,0], "columns": 32, "rows": 1 }} ] }}"#
        );
        let scene = scene_from_json(&text, None, std::path::Path::new("."))?;
        let exact_lx = std::f64::consts::PI * 100.0;
        let (mut within, mut squares, mut rays, mut cost) = ([0u32; 2], 0.0, 0, 0.0);
        for seed in 0..seeds {
            let settings =
                Settings { method, seed, chains: Some(chains), maps: MapSelection::Receivers, ..Settings::default() };
            let solution = solve(&scene, &settings, &Silent);
            let values = &solution.maps[0].values;
            let mut of_run = 0.0;
            for (value, error) in values.value.iter().zip(&values.standard_error) {
                let off = (value - exact_lx).abs();
                within[0] += u32::from(off <= ONE_SIGMA * error);
                within[1] += u32::from(off <= TWO_SIGMA * error);
                of_run += (value / exact_lx - 1.0).powi(2) / POINTS;
            }
            squares += of_run;
            rays += solution.rays;
            cost += solution.rays as f64 * of_run * 1e4;
        }
        let runs = seeds as f64;
        let share = |count: u32| 100.0 * f64::from(count) / (runs * POINTS);
        println!(
            "{distance_m:8.0e}  {:5.1} %  {:5.1} %  {:8.3} %  {:9.0}  {:12.0}",
            share(within[0]),
            share(within[1]),
            100.0 * (squares / runs).sqrt(),
            rays as f64 / runs,
            cost / runs
        );
    }
    Ok(())
}
