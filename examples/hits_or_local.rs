//! Receivers by local estimation against hits counted on small elements: rays and seconds to an equal true error.
//!
//!     cargo run --release --example hits_or_local -- [seeds]
//!
//! Points are in the centre of elements on a surface. Counting uses the value of the element around the point, local estimation that of the
//! point itself. Both are compared with the exact value at the point. Elements are so small that the error of a mean over them is below the
//! required error. Their number does not slow the chains down. Counting gets as many chains as bring its error to that of local estimation,
//! according to a first run and error ∝ N^(−½). It is then run and judged at that number.

use std::path::Path;

use luxmc::analytic::sobolev::{SobolevPlane, SobolevProblem, sobolev};
use luxmc::check::scene_from_json;
use luxmc::scene::Scene;
use luxmc::solver::{MapSelection, Method, Settings, Silent, Solution, solve};

const SOBOLEV: &str = r#"{ "version": 1, "materials": { "grey": { "type": "diffuse", "reflectance": 0.5 } },
  "geometry": [
    { "name": "strip", "type": "rectangle", "origin": [-0.05, -0.05, 0], "u": [3.1, 0, 0], "v": [0, 0.1, 0], "material": "grey", "max_element_edge": 0.15 },
    { "name": "left", "type": "rectangle", "origin": [-100, -100, 0], "u": [99.95, 0, 0], "v": [0, 200, 0], "material": "grey" },
    { "name": "right", "type": "rectangle", "origin": [3.05, -100, 0], "u": [96.95, 0, 0], "v": [0, 200, 0], "material": "grey" },
    { "name": "below", "type": "rectangle", "origin": [-0.05, -100, 0], "u": [3.1, 0, 0], "v": [0, 99.95, 0], "material": "grey" },
    { "name": "above", "type": "rectangle", "origin": [-0.05, 0.05, 0], "u": [3.1, 0, 0], "v": [0, 99.95, 0], "material": "grey" },
    { "name": "plane 2", "type": "rectangle", "origin": [-100, -100, 1], "u": [0, 200, 0], "v": [200, 0, 0], "material": "grey" } ],
  "luminaires": [ { "name": "source", "type": "point", "position": [0, 0, 0.5], "intensity_cd": 1 } ],
  "receivers": [ POINTS ] }"#;
const CUBE: &str = r#"{ "version": 1, "materials": { "grey": { "type": "diffuse", "reflectance": 0.5 } },
  "geometry": [ { "name": "room", "type": "box", "min": [0,0,0], "max": [2,2,2], "facing": "inward", "material": "grey", "max_element_edge": 0.1 } ],
  "luminaires": [ { "name": "source", "type": "point", "position": [0.7, 0.8, 1.4], "luminous_flux_lm": 1000 } ],
  "receivers": [ POINTS ] }"#;
/// Largest number of receivers.
const MOST: usize = 1000;

struct Case {
    name: &'static str,
    scene: Scene,
    /// Elements that contain the receivers.
    elements: Vec<usize>,
    truth_lx: Vec<f64>,
}

fn run(scene: &Scene, method: Method, maps: MapSelection, chains: u64, seed: u64) -> Solution {
    solve(scene, &Settings { method, seed, chains: Some(chains), maps, ..Settings::default() }, &Silent)
}

/// Places receivers at the centres of lit elements of a surface, evenly chosen.
fn case(name: &'static str, text: &str, surface: &str) -> Result<Case, Box<dyn std::error::Error>> {
    let folder = Path::new("scenes");
    let bare = scene_from_json(&text.replace("POINTS", ""), None, folder)?;
    let numbering = luxmc::scene::Elements::of(&bare);
    let on_surface: Vec<usize> = (0..numbering.len())
        .filter(|index| bare.surface_of(numbering.element(*index as u32).triangle).name == surface)
        .collect();
    let stride = on_surface.len().div_ceil(MOST);
    let elements: Vec<usize> = on_surface.iter().step_by(stride).copied().collect();
    let mut points = String::from("x,y,z,nx,ny,nz\n");
    for element in &elements {
        let side = numbering.element(*element as u32);
        let [a, b, c] = numbering.corners_m(&bare, side);
        let (middle, normal) = ((a + b + c) / 3.0, bare.triangle_normal(side.triangle));
        points += &format!("{},{},{},{},{},{}\n", middle.x, middle.y, middle.z, normal.x, normal.y, normal.z);
    }
    let file = std::env::temp_dir().join(format!("hits_or_local_{}_{name}.csv", std::process::id()));
    std::fs::write(&file, points)?;
    let set = format!(r#"{{ "name": "points", "type": "points", "file": {:?} }}"#, file.display().to_string());
    let scene = scene_from_json(&text.replace("POINTS", &set), None, folder)?;
    std::fs::remove_file(&file)?;
    let truth_lx = if name == "sobolev" {
        let problem = SobolevProblem { h1: 0.5, rho1: 0.5, rho2: 0.5 };
        let radius = |point: &luxmc::scene::ReceiverPoint| point.position_m.truncate().length();
        let values = scene.receivers[0].points.iter().map(|point| sobolev(&problem, SobolevPlane::One, radius(point)));
        values.map(|value| value.map(|value| value.total_lx)).collect::<Result<_, _>>()?
    } else {
        // A long run by gathering, which shares no random numbers and no estimator with either.
        let settings = Settings {
            method: Method::Gather,
            seed: 4711,
            target_error: Some(0.003),
            maps: MapSelection::Receivers,
            ..Settings::default()
        };
        solve(&scene, &settings, &Silent).maps[0].values.value.clone()
    };
    Ok(Case { name, scene, elements, truth_lx })
}

/// True relative error of values at the receivers.
fn true_error(case: &Case, values_lx: &[f64]) -> f64 {
    let squares: f64 = values_lx.iter().zip(&case.truth_lx).map(|(value, truth)| (value - truth).powi(2)).sum();
    (squares / values_lx.len() as f64).sqrt() / (case.truth_lx.iter().sum::<f64>() / case.truth_lx.len() as f64)
}

/// Means over seeds: root mean square error, rays, seconds.
fn measured(case: &Case, method: Method, chains: u64, seeds: u64) -> [f64; 3] {
    let mut sums = [0.0; 3];
    for seed in 0..seeds {
        let by_elements = method == Method::Collision;
        let maps = if by_elements { MapSelection::Elements } else { MapSelection::Receivers };
        let solution = run(&case.scene, method, maps, chains, seed);
        let values = &solution.maps[0].values.value;
        let values: Vec<f64> =
            if by_elements { case.elements.iter().map(|element| values[*element]).collect() } else { values.clone() };
        sums[0] += true_error(case, &values).powi(2) / seeds as f64;
        sums[1] += solution.rays as f64 / seeds as f64;
        sums[2] += solution.compute_s / seeds as f64;
    }
    [sums[0].sqrt(), sums[1], sums[2]]
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let seeds: u64 = std::env::args().nth(1).map_or(Ok(4), |text| text.parse())?;
    let office = std::fs::read_to_string("scenes/office.json")?;
    let mut office: serde_json::Value = serde_json::from_str(&office)?;
    office["receivers"] = serde_json::json!(["POINTS"]);
    let office = office.to_string().replace("\"POINTS\"", "POINTS");
    println!(
        "scene: receivers; local: chains, true error, rays, s; counting: chains, true error, rays, s; rays and time at equal error over those of local"
    );
    let cases =
        [case("cube", CUBE, "room/floor")?, case("sobolev", SOBOLEV, "strip")?, case("office", &office, "room/floor")?];
    for (case, chains) in cases.iter().zip([2048, 2048, 4096]) {
        let local = measured(case, Method::Local, chains, seeds);
        let first_chains = 400_000;
        let first = measured(case, Method::Collision, first_chains, 1);
        let scaled = (first_chains as f64 * (first[0] / local[0]).powi(2)).min(2e7) as u64;
        let counting = measured(case, Method::Collision, scaled, 1);
        // A remaining difference of the errors is corrected by error ∝ N^(−½).
        let rest = (counting[0] / local[0]).powi(2);
        println!(
            "{}: {}; {chains}, {:.2} %, {:.0}, {:.3} s; {scaled}, {:.2} %, {:.0}, {:.3} s; {:.1} × rays, {:.1} × time",
            case.name,
            case.elements.len(),
            100.0 * local[0],
            local[1],
            local[2],
            100.0 * counting[0],
            counting[1],
            counting[2],
            rest * counting[1] / local[1],
            rest * counting[2] / local[2]
        );
    }
    Ok(())
}
