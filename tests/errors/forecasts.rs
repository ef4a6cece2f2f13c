//! Forecasts of a run's end: from the pilot on, at intervals, and before anything is computed. Also the two halves from which errors are
//! estimated.

use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use luxmc::control::Forecast;
use luxmc::solver::{ConvergenceRow, MapSelection, Method, Observer, Progress, Settings, expectations, solve};

use crate::common::{Silent, cube, scene, slow, to_target, with_chains};

/// Largest step between rows, as a share of the run's rays.
fn widest_step(rows: &[&ConvergenceRow]) -> f64 {
    let all = rows.last().expect("rows").rays as f64;
    rows.windows(2).map(|pair| (pair[1].rays - pair[0].rays) as f64 / all).fold(0.0, f64::max)
}

/// A cube by counting (collision). The first row comes when at most 2 % of the rays are traced and gives the pilot's forecast. No two rows
/// are more than 5 % of the run apart. Every interval contains its forecast, and the last row is the final result. With every third row
/// alone the steps exceed 5 %.
#[test]
fn the_history_of_a_run_begins_with_its_pilot_and_has_no_gaps() {
    let run = to_target(&cube(0.8, 0.5), 0, MapSelection::Elements, 0.008);
    let rows: Vec<&ConvergenceRow> = run.convergence.iter().collect();
    let (first, last) = (rows[0], rows[rows.len() - 1]);
    assert!(!first.judged && first.rays as f64 <= 0.02 * run.rays as f64, "{first:?}");
    assert!(first.forecast_rays.low < run.rays as f64 && (run.rays as f64) < first.forecast_rays.high, "{first:?}");
    assert!(last.judged && last.forecast_rays == Forecast::known(run.rays as f64), "{last:?}");
    let thinned: Vec<&ConvergenceRow> = rows.iter().copied().step_by(3).collect();
    assert!(widest_step(&rows) <= 0.05 && widest_step(&thinned) > 0.05, "{} rows", rows.len());
    for row in rows {
        let rays = row.forecast_rays;
        assert!(rays.low <= rays.expected && rays.expected <= rays.high && rays.low >= row.rays as f64, "{row:?}");
        let parts = row.error.random.hypot(row.error.bias).hypot(row.error.discretisation);
        assert!((parts / row.error.estimated - 1.0).abs() < 1e-9, "{row:?}");
    }
}

/// Pilots alone forecast the rays of the cube by counting (collision) to 1 %. The run with the same seed lies in the interval for 1 % and
/// not in that for 3 %. Smaller targets take more rays by every method.
#[test]
fn a_dry_run_tells_the_rays_of_the_run() {
    let scene = cube(0.8, 0.5);
    let settings =
        Settings { maps: MapSelection::Elements, elements: luxmc::solver::ElementChoice::Given, ..Settings::default() };
    let methods = [Method::Auto, Method::Gather, Method::Collision];
    let targets = [0.03, 0.01, 0.003];
    let told = expectations(&scene, &settings, &methods, &targets, &Silent);
    assert_eq!(told.len(), methods.len() * targets.len());
    for of_method in told.chunks(targets.len()) {
        let rays: Vec<f64> = of_method.iter().map(|run| run.rays.expected).collect();
        assert!(rays.is_sorted() && rays[2] > 2.0 * rays[0], "{rays:?}");
    }
    let rays = to_target(&scene, 0, MapSelection::Elements, 0.01).rays as f64;
    let holds = |interval: Forecast| interval.low <= rays && rays <= interval.high;
    let by_counts: Vec<Forecast> = told[6..].iter().map(|run| run.rays).collect();
    assert!(holds(by_counts[1]) && !holds(by_counts[0]), "{rays} {by_counts:?}");
}

/// A clock that advances by 1 ms at each reading, with the forecasts that it received. Its run ends with its first progress report.
struct Counting {
    readings: AtomicU64,
    has_begun: AtomicBool,
    expected: Mutex<Vec<Forecast>>,
}

impl Observer for Counting {
    fn progress(&self, _: &Progress) {
        self.has_begun.store(true, Ordering::Relaxed);
    }
    fn expects(&self, error: Forecast, _: Option<f64>) {
        self.expected.lock().expect("one thread").push(error);
    }
    fn is_interrupted(&self) -> bool {
        self.has_begun.load(Ordering::Relaxed)
    }
    fn wall_s(&self) -> f64 {
        1e-3 * self.readings.fetch_add(1, Ordering::Relaxed) as f64
    }
}

/// A run that a time limit ends reports once which error it expects to reach, and a smaller one with more time. A run whose target fits
/// into the limit reports nothing of this kind.
#[test]
fn a_time_limit_alone_says_what_it_affords() {
    let scene = scene("office.json");
    let told = |time_limit_s: f64, target_error: Option<f64>| {
        let clock =
            Counting { readings: AtomicU64::new(0), has_begun: AtomicBool::new(false), expected: Mutex::default() };
        let settings = Settings {
            time_limit_s: Some(time_limit_s),
            target_error,
            maps: MapSelection::Receivers,
            ..Settings::default()
        };
        solve(&scene, &settings, &clock);
        clock.expected.into_inner().expect("one thread")
    };
    let (short, long) = (told(80.0, None), told(320.0, None));
    assert_eq!((short.len(), long.len(), told(80.0, Some(0.9)).len()), (1, 1, 0));
    assert!(long[0].expected < short[0].expected && short[0].expected < 1.0, "{short:?} {long:?}");
    assert!(short[0].low < short[0].expected && short[0].expected < short[0].high, "{short:?}");
}

/// Keeps the reported errors in order.
#[derive(Default)]
struct Errors(Mutex<Vec<Option<f64>>>);

impl Observer for Errors {
    fn progress(&self, progress: &Progress) {
        self.0.lock().expect("one thread").push(progress.estimated_error);
    }
    fn is_interrupted(&self) -> bool {
        false
    }
    fn wall_s(&self) -> f64 {
        0.0
    }
}

/// Elements of a cube that are divided several times on the way to 1 %. Once an error is known, every later report has one. While the finer
/// elements have no error yet, it is that of the coarser ones.
#[test]
fn an_error_that_was_reported_stays_told_while_elements_are_cut() {
    let errors = Errors::default();
    let settings = Settings {
        target_error: Some(0.01),
        maps: MapSelection::Elements,
        elements: luxmc::solver::ElementChoice::Adaptive,
        ..Settings::default()
    };
    let scene = cube(0.8, 10.0);
    let run = solve(&scene, &settings, &errors);
    assert!(run.elements.len() > 4 * scene.triangles.len(), "{} elements", run.elements.len());
    let told = errors.0.into_inner().expect("one thread");
    let first = told.iter().position(Option::is_some).expect("an error");
    assert!(first + 2 < told.len() && told[first..].iter().all(Option::is_some), "{told:?}");
}

/// Two-sided quantile of the normal distribution at α = 0.1 %.
const WITHIN: f64 = 3.29;

/// Covariance of the errors of the even and the odd halves: the mean of their product over the runs, summed over the entries, in its own
/// standard errors. The truth of an entry is taken as the mean of each half over all runs, so that independent halves give 0. A share of
/// the even halves is added to the odd ones.
fn dependence(halves: &[Vec<[f64; 2]>], share: f64) -> f64 {
    let runs = halves.len() as f64;
    let planted = |[even, odd]: [f64; 2]| [even, odd + share * even];
    let mut products = vec![0.0; halves.len()];
    for entry in 0..halves[0].len() {
        let mean = |half: usize| halves.iter().map(|run| planted(run[entry])[half]).sum::<f64>() / runs;
        let means = [mean(0), mean(1)];
        for (product, run) in products.iter_mut().zip(halves) {
            let both = planted(run[entry]);
            *product += (both[0] - means[0]) * (both[1] - means[1]);
        }
    }
    let mean = products.iter().sum::<f64>() / runs;
    let squares: f64 = products.iter().map(|product| (product - mean).powi(2)).sum();
    mean / (squares / (runs * (runs - 1.0))).sqrt()
}

/// Even and odd halves of a cube's elements, by counting (collision) and by gathering, have independent errors (seeds 0 to 59, all 300 in
/// the slow campaign; α = 0.1 % for each method). The planted fault must be found: odd halves to which a third of the even ones is added,
/// 15 % in the slow campaign.
#[test]
fn even_and_odd_halves_know_nothing_of_each_other() {
    let scene = cube(0.8, 2.0);
    let (seeds, fault) = if slow() { (300, 0.15) } else { (60, 0.33) };
    let of_run = |run: luxmc::solver::Solution| run.maps[0].values.halves.clone();
    let counted = |seed: u64| of_run(with_chains(&scene, seed, MapSelection::Elements, 2000));
    let gathered = |seed: u64| {
        let settings = Settings {
            method: Method::Gather,
            elements: luxmc::solver::ElementChoice::Given,
            seed,
            chains: Some(2000),
            maps: MapSelection::Elements,
            ..Settings::default()
        };
        of_run(solve(&scene, &settings, &Silent))
    };
    for (name, run) in [("counting", &counted as &dyn Fn(u64) -> Vec<[f64; 2]>), ("gathering", &gathered)] {
        let halves: Vec<Vec<[f64; 2]>> = (0..seeds).map(run).collect();
        assert!(halves[0].len() > 20, "{name}: {} elements", halves[0].len());
        let z = dependence(&halves, 0.0);
        assert!(z.abs() < WITHIN, "{name}: {z} standard errors");
        let z = dependence(&halves, fault);
        assert!(z > WITHIN, "{name}: the planted fault passed, {z} standard errors");
    }
}
