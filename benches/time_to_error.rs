//! Time to a target error on 1 and 2 threads, and the true error reached, scene by scene.
//!
//! `cargo bench --bench time_to_error` prints a table and writes it to `target/time_to_error.csv`. Names of scenes after `--` run only
//! these. `--record` adds the rows to `benches/history.csv`, from which the example `draw_speed` makes the README's table and plot. The
//! hall needs its mesh (`cargo run --release --example make_hall`) and is left out without it.

use std::fs::OpenOptions;
use std::io::Write as _;
use std::path::Path;

use glam::DVec3;
use luxmc::analytic::box_room::{BoxRoom, BoxRoomSolution, RoomFace, RoomSource};
use luxmc::check::{read_scene, scene_from_json};
use luxmc::maps::MapResult;
use luxmc::scene::Scene;
use luxmc::scene::elements::part_corners;
use luxmc::solver::{ElementChoice, MapSelection, Method, Settings, Silent, Solution, solve};
use luxmc::validation::utc_date;

/// Columns of the history.
const HEADER: &str = "date,machine,load_per_processor,threads,scene,map,target_error,compute_s,processor_s,rays,true_error,stated_error,seeds,speed_up_of_two_threads\n";
/// Number of seeds whose median time, mean rays and mean squared errors are reported.
const SEEDS: u64 = 3;
/// Number of runs for every seed, alternately with one thread and two. The quickest counts, because other work on the machine only adds
/// time. Slow runs are not repeated.
const REPEATS: u32 = 4;
const DEAR_S: f64 = 1.0;
/// Pieces along an edge in which an adaptive element is compared.
const PIECES: u32 = 6;
/// Points along half an edge of the cube at which its exact light is tabulated.
const STEPS: usize = 64;
/// Edge of the cube in m.
const CUBE_M: f64 = 4.0;

/// The reference for the true error of a run.
enum Truth {
    /// Exact form factors. Given elements are judged by their means, adaptive ones at every point.
    Cube(Box<CubeTruth>),
    /// The stored long run of the office: values and standard errors of every receiver set.
    LongRun(Vec<(String, Vec<(f64, f64)>)>),
    /// No truth is known.
    None,
}

struct CubeTruth {
    exact: BoxRoomSolution,
    /// Illuminance in lx of a quarter of a face. All faces and quarters are alike.
    table_lx: Vec<Vec<f64>>,
}

impl CubeTruth {
    fn new() -> CubeTruth {
        let intensity_cd = 10_000.0 / (4.0 * std::f64::consts::PI);
        let source = RoomSource::Point { position: DVec3::splat(0.5 * CUBE_M), intensity_cd };
        let room = BoxRoom { size_m: [CUBE_M; 3], reflectances: [0.8; 6], sources: vec![source] };
        let exact = room.solve().expect("the room absorbs");
        let at = |i: usize, j: usize| {
            let [u, v] = [i, j].map(|step| 0.5 * CUBE_M * step as f64 / STEPS as f64);
            exact.on_face(RoomFace::Floor, u, v).expect("on the face").total_lx()
        };
        let table_lx = (0..=STEPS).map(|i| (0..=STEPS).map(|j| at(i, j)).collect()).collect();
        CubeTruth { exact, table_lx }
    }

    /// Illuminance in lx at a point of a face, bilinear in the table.
    fn at_lx(&self, point: DVec3, normal: DVec3) -> f64 {
        let axes: Vec<usize> = (0..3).filter(|axis| normal[*axis].abs() < 0.5).collect();
        let [(i, x), (j, y)] = [axes[0], axes[1]].map(|axis| {
            let place = point[axis].min(CUBE_M - point[axis]).max(0.0) / (0.5 * CUBE_M) * STEPS as f64;
            let cell = (place as usize).min(STEPS - 1);
            (cell, place - cell as f64)
        });
        let table = &self.table_lx;
        (1.0 - x) * ((1.0 - y) * table[i][j] + y * table[i][j + 1])
            + x * ((1.0 - y) * table[i + 1][j] + y * table[i + 1][j + 1])
    }

    /// Squared relative error of an element map.
    fn squared_error(&self, scene: &Scene, solution: &Solution) -> f64 {
        let (elements, map) = (&solution.elements, &solution.maps[0]);
        let adapts = !map.values.slopes_lx.is_empty();
        let pieces = if adapts { PIECES } else { 1 };
        let (mut squares, mut sum, mut area_sum_m2) = (0.0, 0.0, 0.0);
        for index in 0..elements.len() {
            let element = elements.element(index as u32);
            let [a, b, c] = elements.corners_m(scene, element);
            let normal = scene.triangle_normal(element.triangle);
            let area_m2 = elements.area_m2(scene, element) / f64::from(pieces * pieces);
            for piece in 0..pieces * pieces {
                let (shown, exact) = if adapts {
                    let corners = part_corners(pieces, piece);
                    let [u, v] = [0, 1].map(|k| (corners[0][k] + corners[1][k] + corners[2][k]) / 3.0);
                    (map.values.at_lx(index, [u, v]), self.at_lx(a + u * (b - a) + v * (c - a), normal))
                } else {
                    let mean = self.exact.triangle_mean([a, b, c]).expect("on a face");
                    (map.values.value[index], mean.total_lx())
                };
                squares += area_m2 * (shown - exact).powi(2);
                sum += area_m2 * exact;
                area_sum_m2 += area_m2;
            }
        }
        squares / area_sum_m2 / (sum / area_sum_m2).powi(2)
    }
}

impl Truth {
    /// Squared true error of the worst map. The random error of the stored run is subtracted as a mean of squares.
    fn squared_error(&self, scene: &Scene, solution: &Solution) -> Option<f64> {
        match self {
            Truth::Cube(cube) => Some(cube.squared_error(scene, solution)),
            Truth::LongRun(sets) => {
                let of_map = |map: &MapResult| {
                    let (_, rows) = sets.iter().find(|(name, _)| *name == map.name).expect("a stored set");
                    let pairs = || map.values.value.iter().zip(rows);
                    let squares: f64 = pairs().map(|(lx, (stored, error))| (lx - stored).powi(2) - error * error).sum();
                    let mean = rows.iter().map(|(lx, _)| lx).sum::<f64>() / rows.len() as f64;
                    squares / rows.len() as f64 / (mean * mean)
                };
                solution.maps.iter().map(of_map).reduce(f64::max)
            }
            Truth::None => None,
        }
    }
}

fn long_run(root: &Path, scene: &Scene) -> Truth {
    let path = root.join("validation/office/long-run/receivers.csv");
    let mut reader = csv::Reader::from_path(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    let mut sets: Vec<_> = scene.receivers.iter().map(|set| (set.name.clone(), Vec::new())).collect();
    for row in reader.records().map(|row| row.expect("a row")) {
        let number = |column: usize| row[column].parse::<f64>().expect("a number");
        let (_, rows) = sets.iter_mut().find(|(name, _)| *name == row[0]).expect("a receiver set of the scene");
        rows.push((number(8), number(9)));
    }
    Truth::LongRun(sets)
}

/// A map of a scene, and the targets that a benchmark can wait for.
struct Subject {
    scene_name: &'static str,
    map_name: &'static str,
    scene: Scene,
    maps: MapSelection,
    elements: ElementChoice,
    truth: Truth,
    targets: &'static [f64],
}

/// The scene of the cube without its `max_element_edge`: two triangles per face.
fn plain_cube(root: &Path) -> Scene {
    let text = std::fs::read_to_string(root.join("scenes/cube.json")).expect("the cube");
    let mut value: serde_json::Value = serde_json::from_str(&text).expect("the cube");
    let cube = value["geometry"][0].as_object_mut().expect("a box");
    cube.remove("max_element_edge").expect("an edge");
    scene_from_json(&value.to_string(), None, root).expect("the cube")
}

fn subjects(root: &Path, asked: &[String]) -> Vec<Subject> {
    let is_asked = |name: &str| asked.is_empty() || asked.iter().any(|asked| asked == name);
    let (given, most, all, some) =
        (ElementChoice::Given, &[0.03, 0.01, 0.003, 0.001], &[0.03, 0.01, 0.003], &[0.03, 0.01]);
    let mut subjects = Vec::new();
    let mut add = |scene_name, map_name, scene, maps, elements, truth, targets| {
        subjects.push(Subject { scene_name, map_name, scene, maps, elements, truth, targets });
    };
    let scene = |name: &str| read_scene(&root.join("scenes").join(format!("{name}.json")));
    let (elements, receivers) = (MapSelection::Elements, MapSelection::Receivers);
    if is_asked("cube") {
        let truth = || Truth::Cube(Box::new(CubeTruth::new()));
        let cube = scene("cube").expect("the cube");
        add("cube", "3072 elements as given", cube, elements.clone(), given, truth(), most);
        let plain = plain_cube(root);
        add("cube", "12 triangles that adapt", plain, elements.clone(), ElementChoice::Adaptive, truth(), all);
    }
    if is_asked("office") {
        let office = scene("office").expect("the office");
        let truth = long_run(root, &office);
        add("office", "receivers", office.clone(), receivers.clone(), given, truth, all);
        add("office", "elements as given", office.clone(), elements.clone(), given, Truth::None, some);
        add("office", "elements that adapt", office, elements, ElementChoice::Adaptive, Truth::None, some);
    }
    if is_asked("hall") {
        match scene("hall") {
            Ok(hall) => add("hall", "receivers", hall, receivers, given, Truth::None, some),
            Err(_) => eprintln!("the hall is left out: its mesh is made by the example make_hall"),
        }
    }
    subjects
}

/// Results of runs.
struct Told {
    /// Seconds of computing with two threads.
    compute_s: f64,
    /// Processor seconds of both threads together.
    processor_s: f64,
    /// Processor seconds of the single thread divided by those of the busier of two threads. This is the gain of two threads if nothing
    /// else needs the processors.
    speed_up: f64,
    rays: f64,
    true_error: Option<f64>,
    stated_error: f64,
}

/// Processor seconds of this thread, as Linux reports them; otherwise 0.
fn worked_s() -> f64 {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").unwrap_or_default();
    text.split(' ').next().and_then(|number| number.parse::<f64>().ok()).map_or(0.0, |nanoseconds| nanoseconds * 1e-9)
}

fn median(mut numbers: Vec<f64>) -> f64 {
    numbers.sort_by(f64::total_cmp);
    numbers[numbers.len() / 2]
}

fn measured(subject: &Subject, target_error: f64) -> Told {
    let pools =
        [1, 2].map(|threads| rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a thread pool"));
    let mut runs: Vec<Solution> = Vec::new();
    let (mut compute_s, mut processor_s, mut speed_up) = (Vec::new(), Vec::new(), Vec::new());
    for seed in 0..SEEDS {
        // For one and for two threads: wall time, and the processor time of the busiest thread and of all threads.
        let mut least = [[f64::INFINITY; 3]; 2];
        let mut solution = None;
        for _ in 0..REPEATS {
            for (pool, least) in pools.iter().zip(&mut least) {
                let settings = Settings {
                    method: Method::Auto,
                    elements: subject.elements,
                    seed,
                    target_error: Some(target_error),
                    maps: subject.maps.clone(),
                    ..Settings::default()
                };
                let before = pool.broadcast(|_| worked_s());
                let run = pool.install(|| solve(&subject.scene, &settings, &Silent));
                let worked: Vec<f64> =
                    pool.broadcast(|_| worked_s()).iter().zip(before).map(|(after, before)| after - before).collect();
                let told = [run.compute_s, worked.iter().copied().fold(0.0, f64::max), worked.iter().sum()];
                least.iter_mut().zip(told).for_each(|(least, told)| *least = least.min(told));
                solution = Some(run);
            }
            if least[1][0] > DEAR_S {
                break;
            }
        }
        runs.extend(solution);
        let [single, double] = least;
        compute_s.push(double[0]);
        processor_s.push(double[2]);
        speed_up.push(single[1] / double[1]);
    }
    let count = runs.len() as f64;
    let squares: Option<Vec<f64>> = runs.iter().map(|run| subject.truth.squared_error(&subject.scene, run)).collect();
    Told {
        compute_s: median(compute_s),
        processor_s: median(processor_s),
        speed_up: median(speed_up),
        rays: runs.iter().map(|run| run.rays as f64).sum::<f64>() / count,
        true_error: squares.map(|squares| (squares.iter().sum::<f64>() / count).max(0.0).sqrt()),
        stated_error: (runs.iter().map(|run| run.estimated_error.powi(2)).sum::<f64>() / count).sqrt(),
    }
}

/// Name of the processor, as the system reports it.
fn machine() -> String {
    let text = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let name = text.lines().find(|line| line.starts_with("model name")).and_then(|line| line.split(": ").nth(1));
    let count = std::thread::available_parallelism().map_or(1, usize::from);
    format!("{} ({count} threads)", name.unwrap_or(std::env::consts::ARCH).trim()).replace(',', " ")
}

/// Processes that ran or waited in the last minute, divided by the number of processors. Above 1 the seconds include other work too.
fn load() -> f64 {
    let text = std::fs::read_to_string("/proc/loadavg").unwrap_or_default();
    let running: Option<f64> = text.split(' ').next().and_then(|number| number.parse().ok());
    running.unwrap_or(0.0) / std::thread::available_parallelism().map_or(1.0, |count| count.get() as f64)
}

fn main() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let asked: Vec<String> = arguments.iter().filter(|argument| !argument.starts_with("--")).cloned().collect();
    let since = std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH);
    let (date, machine) = (utc_date(since.map_or(0, |since| since.as_secs())), machine());
    let mut rows = String::new();
    for subject in subjects(root, &asked) {
        for target_error in subject.targets {
            let told = measured(&subject, *target_error);
            let true_error = told.true_error.map_or("unknown".to_owned(), |error| format!("{error:.6}"));
            let row = format!(
                "{date},{machine},{:.2},2,{},{},{target_error},{:.4},{:.4},{:.0},{true_error},{:.6},{SEEDS},{:.3}\n",
                load(),
                subject.scene_name,
                subject.map_name,
                told.compute_s,
                told.processor_s,
                told.rays,
                told.stated_error,
                told.speed_up
            );
            eprint!("{row}");
            rows.push_str(&row);
        }
    }
    let file = root.join("target").join("time_to_error.csv");
    if let Err(error) = std::fs::write(&file, format!("{HEADER}{rows}")) {
        eprintln!("{}: {error}", file.display());
    }
    if arguments.iter().any(|argument| argument == "--record") {
        let file = root.join("benches/history.csv");
        let is_new = !file.exists();
        let opened = OpenOptions::new().create(true).append(true).open(&file);
        let text = if is_new { format!("{HEADER}{rows}") } else { rows.clone() };
        if let Err(error) = opened.and_then(|mut opened| opened.write_all(text.as_bytes())) {
            eprintln!("{}: {error}", file.display());
        }
    }
    println!("{HEADER}{rows}");
}
