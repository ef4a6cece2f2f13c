//! `luxmc solve --dry-run`: forecasts the cost of a target from pilots alone.

use std::time::Instant;

use super::exit::Failure;
use super::memory::needed_bytes;
use super::method::MethodChoice;
use super::number_text::{count, percent, significant, time};
use super::progress::Watcher;
use super::text_table::text_table;
use super::{Outcome, console};
use crate::control::Forecast;
use crate::methods::check_light_mesh;
use crate::radiosity::Radiosity;
use crate::scene::Scene;
use crate::solver::{DEFAULT_TARGET_ERROR, Expectation, MapSelection, Method, Settings, expectations};

/// Targets that are reported besides the requested one.
const TARGETS: [f64; 4] = [0.03, 0.01, 0.003, 0.001];

/// Methods whose cost pilots can forecast.
const PILOTED: [Method; 4] = [Method::Auto, Method::Gather, Method::Collision, Method::Local];

/// Prints the forecast cost of a scene for every method that applies, or for the requested one.
pub fn dry_run(scene: &Scene, settings: &Settings, method: MethodChoice, started: Instant, quiet: bool) -> Outcome {
    let mut targets = TARGETS.to_vec();
    if let Some(target) = settings.target_error.filter(|target| !TARGETS.contains(target)) {
        targets.push(target);
        targets.sort_by(|a, b| b.total_cmp(a));
    }
    let requested = |piloted: &Method| *piloted == settings.method || method == MethodChoice::AUTO;
    let methods: Vec<Method> =
        PILOTED.into_iter().filter(requested).filter(|of| applies(*of, scene, settings)).collect();
    let watcher = Watcher::new(started, true, None);
    let expected = expectations(scene, settings, &methods, &targets, &watcher);
    if expected.is_empty() {
        console::message("no forecast: the pilots found no light in a map that the target binds");
    }
    let map_bytes = needed_bytes(scene, settings) as f64;
    console::result(&table(&expected, map_bytes))?;
    if !quiet {
        let target = settings.target_error.unwrap_or(DEFAULT_TARGET_ERROR);
        console::message(&format!(
            "forecasts by pilots only, with the interval that contains 90 % of runs; a run to {} updates its \
             forecast at every error check",
            percent(target)
        ));
        let mut others = Vec::new();
        others.extend(Radiosity::check(scene).is_ok().then_some("radiosity"));
        others.extend(check_light_mesh(scene, settings).is_ok().then_some("light-mesh"));
        if method == MethodChoice::AUTO && !others.is_empty() {
            console::message(&format!("not forecast, since they have no pilots: {}", others.join(", ")));
        }
    }
    Ok(super::exit::Exit::Done)
}

/// Whether a method differs from collision (walks and counts) in this scene. Local estimation differs only if receiver sets are
/// computed.
fn applies(method: Method, scene: &Scene, settings: &Settings) -> bool {
    method != Method::Local || !scene.receivers.is_empty() && settings.maps != MapSelection::Elements
}

fn table(expected: &[Expectation], map_bytes: f64) -> String {
    let rows = expected.iter().map(|run| {
        let [low_s, high_s] = [run.compute_s.low, run.compute_s.high].map(time);
        vec![
            run.method.name().to_owned(),
            run.engines.join(", "),
            percent(run.target_error),
            count(run.rays.expected),
            between(run.rays, count),
            time(run.compute_s.expected),
            format!("{low_s} to {high_s}"),
            megabytes(map_bytes + run.bytes_of_cells),
        ]
    });
    let header = ["method", "estimates by", "target", "rays", "90 % of runs", "time", "90 % of runs", "memory"];
    text_table(&header, &[0, 1], rows)
}

fn between(forecast: Forecast, show: fn(f64) -> String) -> String {
    format!("{} to {}", show(forecast.low), show(forecast.high))
}

fn megabytes(bytes: f64) -> String {
    format!("{} MB", significant((bytes / 1e6).max(1.0), 2))
}

/// Refuses a method without pilots.
pub fn check(method: MethodChoice) -> Result<(), Failure> {
    let Some(name) = method.name_without_chains() else { return Ok(()) };
    Err(Failure::Usage {
        what: format!("{name} has no pilot that could forecast a run"),
        got: format!("--dry-run with --method {name}"),
        expected: "--method auto, gather, collision or local".to_owned(),
        remedy: format!("leave out --method, or run {name} with a --time-limit"),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_run_is_reported_in_one_line_with_its_intervals() {
        let expected = Expectation {
            method: Method::Gather,
            engines: vec!["gather", "walk"],
            target_error: 0.003,
            rays: Forecast { expected: 1.5e6, low: 1e6, high: 2e6 },
            compute_s: Forecast { expected: 3.0, low: 2.0, high: 6.5 },
            bytes_of_cells: 3e7,
        };
        let text = table(&[expected], 2e7);
        let line = text.lines().nth(1).unwrap_or_default();
        let cells: Vec<&str> = line.split("  ").map(str::trim).filter(|cell| !cell.is_empty()).collect();
        assert_eq!(
            cells,
            ["gather", "gather, walk", "0.300 %", "1.50 M", "1.00 M to 2.00 M", "3.0 s", "2.0 s to 6.5 s", "50 MB"]
        );
    }
}
