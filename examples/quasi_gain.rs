//! The gain by quasi-random points for each estimator: the relative error against the number of samples, from random numbers and from
//! scrambled Sobol points, and the fitted exponents α of error ∝ N^(−α).
//!
//!     cargo run --release --example quasi_gain -- [repetitions]
//!
//! Every estimator is unbiased, so that its error is the spread over independent repetitions: root mean square over the entries of their
//! standard deviations, divided by the root mean square of the entries.

use std::path::Path;

use luxmc::analytic::sobolev::{SobolevPlane, SobolevProblem, sobolev_at_radii};
use luxmc::check::scene_from_json;
use luxmc::estimators::cache::{Cache, CacheAnswer, Met};
use luxmc::estimators::local::{Anchors, BRANCHES, Connecting};
use luxmc::estimators::receiver::Receiver;
use luxmc::estimators::reception::sample_reflected;
use luxmc::estimators::walk::{sample_indirect_lx, walk_indirect_lx};
use luxmc::sampling::emitter_tree::Cut;
use luxmc::sampling::random::{Purpose, Stream};
use luxmc::scene::Scene;
use luxmc::transport::World;
use rayon::prelude::*;

const COUNTS: [u64; 5] = [16, 64, 256, 1024, 4096];

fn planes(receivers: &str) -> String {
    format!(
        r#"{{ "version": 1, "materials": {{ "grey": {{ "type": "diffuse", "reflectance": 0.5 }} }},
  "geometry": [
    {{ "name": "plane 1", "type": "rectangle", "origin": [-100, -100, 0], "u": [200, 0, 0], "v": [0, 200, 0], "material": "grey" }},
    {{ "name": "plane 2", "type": "rectangle", "origin": [-100, -100, 1], "u": [0, 200, 0], "v": [200, 0, 0], "material": "grey" }} ],
  "luminaires": [ {{ "name": "source", "type": "point", "position": [0, 0, 0.5], "intensity_cd": 1 }} ],
  "receivers": [ {receivers} ] }}"#
    )
}

const LINE: &str = r#"{ "name": "line", "type": "grid", "origin": [0, -0.5, 0], "u": [3, 0, 0], "v": [0, 1, 0], "columns": 31, "rows": 1 }"#;
const FAN: &str = r#"{ "name": "fan", "type": "luminance", "position": [1, 0, 0.5],
  "fan": { "direction": [0, 0, -1], "axis": [0, 1, 0], "from_deg": -70, "to_deg": 70, "count": 29 } }"#;
const CUBE: &str = r#"{ "version": 1, "materials": { "grey": { "type": "diffuse", "reflectance": 0.5 } },
  "geometry": [ { "name": "cube", "type": "box", "min": [0,0,0], "max": [1,1,1], "facing": "inward", "material": "grey", "max_element_edge": EDGE } ],
  "luminaires": [ { "name": "source", "type": "point", "position": [0.5, 0.5, 0.5], "luminous_flux_lm": 1000 } ] }"#;

fn scene_of(text: &str) -> Result<Scene, Box<dyn std::error::Error>> {
    Ok(scene_from_json(text, None, Path::new("."))?)
}

/// Goes to sample `number` of a sequence, or to random numbers of the same index.
fn start(stream: &mut Stream, quasi: bool, sequence: u64, number: u64) {
    let index = sequence << 40 | number;
    if quasi { stream.seek_quasi(index, sequence, number) } else { stream.seek(index) }
}

/// Spread of an estimator's entries over repetitions, as a share of their size.
fn spread(repetitions: u32, run: impl Fn(&mut Stream) -> Vec<f64> + Sync) -> f64 {
    let runs: Vec<Vec<f64>> = (0..repetitions)
        .into_par_iter()
        .map(|repetition| run(&mut Stream::new(20_000, Purpose::Pilot, 0, repetition)))
        .collect();
    let count = f64::from(repetitions);
    let (mut variance, mut size) = (0.0, 0.0);
    for entry in 0..runs[0].len() {
        let mean = runs.iter().map(|run| run[entry]).sum::<f64>() / count;
        variance += runs.iter().map(|run| (run[entry] - mean).powi(2)).sum::<f64>() / (count - 1.0);
        size += mean * mean;
    }
    (variance / size).sqrt()
}

/// Slope of ln error against ln N.
fn exponent(errors: &[f64]) -> f64 {
    let points: Vec<(f64, f64)> =
        COUNTS.iter().zip(errors).map(|(count, error)| ((*count as f64).ln(), error.ln())).collect();
    let count = points.len() as f64;
    let (x, y) = (points.iter().map(|p| p.0).sum::<f64>() / count, points.iter().map(|p| p.1).sum::<f64>() / count);
    -points.iter().map(|p| (p.0 - x) * (p.1 - y)).sum::<f64>() / points.iter().map(|p| (p.0 - x).powi(2)).sum::<f64>()
}

fn show(name: &str, repetitions: u32, run: impl Fn(&mut Stream, bool, u64) -> Vec<f64> + Sync) {
    let errors = [false, true]
        .map(|quasi| COUNTS.map(|count| spread(repetitions, |stream: &mut Stream| run(stream, quasi, count))));
    let alphas = errors.map(|errors| exponent(&errors));
    let cells: Vec<String> = (0..COUNTS.len())
        .map(|place| format!("{:.2}, {:.2}", 100.0 * errors[0][place], 100.0 * errors[1][place]))
        .collect();
    println!("| {name} | {} | {:.2} | {:.2} |", cells.join(" | "), alphas[0], alphas[1]);
}

/// The exact indirect illuminance of Sobolev's planes, read from a fine table.
struct Exact<'a> {
    table_lx: &'a [f64],
}

/// Steps of the table for a distance of 1.
const STEPS: f64 = 100.0;

impl Cache for Exact<'_> {
    fn look_up(&mut self, met: &Met, _: &mut Cut, _: &mut Stream) -> (CacheAnswer, u64) {
        let place = met.receiver.point_m.truncate().length() * STEPS;
        let index = place as usize;
        let lx = match self.table_lx.get(index..index + 2) {
            Some(both) => both[0] + (place - index as f64) * (both[1] - both[0]),
            None => 0.0,
        };
        (CacheAnswer::End(lx), 0)
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let repetitions: u32 = std::env::args().nth(1).map_or(Ok(64), |text| text.parse())?;
    println!("error in %: random numbers, Sobol points; N = {COUNTS:?}; {repetitions} repetitions");

    for edge in ["1", "0.25"] {
        let scene = scene_of(&CUBE.replace("EDGE", edge))?;
        let world = World::new(&scene);
        let name = format!("hits counted on elements, cube, {} elements", world.elements.len());
        show(&name, repetitions, |stream, quasi, count| {
            let mut hits = vec![0.0; world.elements.len()];
            for chain in 0..count {
                start(stream, quasi, 0, chain);
                world.trace_chain(0.0, stream, |arrival| {
                    let hit = &arrival.hit;
                    if arrival.bounces > 0
                        && let Some(element) = world.elements.element_at(hit.triangle, hit.barycentric, hit.side)
                    {
                        hits[element as usize] += 1.0 / count as f64;
                    }
                });
            }
            hits
        });
    }

    let scene = scene_of(&planes(LINE))?;
    let world = World::new(&scene);
    let receivers = &scene.receivers[0];
    let origins: Vec<_> =
        receivers.points.iter().map(|point| world.tracer.side_origin(point.position_m, point.normal)).collect();
    let over_points = |stream: &mut Stream, quasi: bool, count: u64, sample: &dyn Fn(&Receiver, &mut Stream) -> f64| {
        let each = receivers.points.iter().zip(&origins).enumerate().map(|(entry, (point, origin))| {
            let receiver = Receiver { point_m: point.position_m, normal: point.normal, origin };
            let samples = (0..count).map(|number| {
                start(stream, quasi, entry as u64, number);
                sample(&receiver, stream)
            });
            samples.sum::<f64>() / count as f64
        });
        each.collect::<Vec<f64>>()
    };
    show("walks at receivers, planes", repetitions, |stream, quasi, count| {
        over_points(stream, quasi, count, &|receiver, stream| {
            sample_indirect_lx(&world, receiver, &mut Cut::default(), stream).value
        })
    });
    let problem = SobolevProblem { h1: 0.5, rho1: 0.5, rho2: 0.5 };
    let radii: Vec<f64> = (0..=(20.0 * STEPS) as u32).map(|step| f64::from(step) / STEPS).collect();
    let table_lx: Vec<f64> =
        sobolev_at_radii(&problem, SobolevPlane::One, &radii)?.iter().map(|value| value.reflected_lx).collect();
    show("gathering rays with a perfect cache, planes", repetitions, |stream, quasi, count| {
        over_points(stream, quasi, count, &|receiver, stream| {
            let mut cache = Exact { table_lx: &table_lx };
            walk_indirect_lx(&world, receiver, &mut cache, &mut Cut::default(), stream).value
        })
    });

    for (name, receivers) in
        [("local estimation, planes", LINE), ("double local estimation, planes, 29 directions", FAN)]
    {
        let scene = scene_of(&planes(receivers))?;
        let world = World::new(&scene);
        let set = &scene.receivers[0];
        let mut anchors = Anchors::of(&world, set, 1, 1);
        anchors.set_levels(&world, 0.23);
        anchors.set_walk_rates();
        let flux_lm = world.emitters.luminous_flux_lm();
        // As the pilot would choose: 8 chains per walk.
        let connecting = Connecting { bound: 4.0 * std::f64::consts::PI * 8.0 / flux_lm, threshold: 0.0 };
        show(name, repetitions, |stream, quasi, count| {
            let mut sums = vec![0.0; set.points.len()];
            let (mut vertices, mut scores) = (Vec::new(), Vec::new());
            for chain in 0..count {
                start(stream, quasi, 0, chain * u64::from(BRANCHES + 1));
                if quasi {
                    stream.seek_quasi(chain * u64::from(BRANCHES + 1), 0, chain);
                }
                vertices.clear();
                let mut share = 1.0;
                world.trace_branches(0.0, stream, BRANCHES, chain * u64::from(BRANCHES + 1) + 1, |arrival| {
                    vertices.extend(anchors.vertex(&world, arrival, share));
                    share = 1.0 / f64::from(BRANCHES);
                });
                for vertex in &vertices {
                    anchors.connect(&world, vertex, &connecting, 0.0, &mut scores, |entry, score| {
                        sums[entry] += flux_lm * score / count as f64;
                    });
                }
            }
            let walks = (count / 8).max(1);
            for (entry, sum) in sums.iter_mut().enumerate() {
                for walk in 0..walks {
                    start(stream, quasi, 1 + entry as u64, walk);
                    let rest = anchors.sample_rest(&world, set, entry, connecting.bound, &mut Cut::default(), stream);
                    *sum += rest.value / walks as f64;
                }
            }
            sums
        });
    }

    let scene = scene_of(&planes(FAN))?;
    let world = World::new(&scene);
    let set = &scene.receivers[0];
    show("walks from sub-points, planes, 29 directions", repetitions, |stream, quasi, count| {
        let each = set.points.iter().enumerate().map(|(entry, point)| {
            let origin = world.tracer.side_origin(point.position_m, point.normal);
            let receiver = Receiver { point_m: point.position_m, normal: point.normal, origin: &origin };
            let samples = (0..count).map(|number| {
                start(stream, quasi, entry as u64, number);
                sample_reflected(&world, set.quantity, &receiver, &mut Cut::default(), stream).value
            });
            samples.sum::<f64>() / count as f64
        });
        each.collect()
    });
    Ok(())
}
