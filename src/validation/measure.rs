//! Costs of runs, and the measured values of a comparison.

use std::time::Instant;

use super::case::CaseRun;
use super::comparison::{Comparison, What};
use super::exact::LightPart;
use super::statistics::EntrySet;
use super::truth_enclosure::mesh_area_m2;
use crate::maps::{MapKind, MapResult, REPLICAS, TableRow, standard_error};
use crate::scene::{Elements, Scene};
use crate::solver::{ElementChoice, MapSelection, Observer, Settings, Solution, StopReason};

/// Cost of a run and how it ended.
#[derive(Clone, Debug)]
pub struct MeasuredRun {
    /// Name of the run.
    pub name: String,
    /// Names of the estimators of the compared maps.
    pub methods: Vec<String>,
    /// Seed of the random numbers.
    pub seed: u64,
    /// Number of chains for all maps.
    pub chains: u64,
    /// Number of rays.
    pub rays: u64,
    /// Seconds for building and computing.
    pub seconds: f64,
    /// Target for the stated error, if there was one.
    pub target_error: Option<f64>,
    /// Largest stated error of the bound maps.
    pub stated_error: f64,
    /// Reason of the end.
    pub stop_reason: StopReason,
    /// Degrees of freedom of the standard errors.
    pub degrees_of_freedom: f64,
}

/// An observer that only counts the seconds since its start.
pub struct Stopwatch {
    started: Instant,
}

impl Stopwatch {
    /// Creates an observer whose clock starts now.
    pub fn starting_now() -> Stopwatch {
        Stopwatch { started: Instant::now() }
    }
}

impl Observer for Stopwatch {
    fn wall_s(&self) -> f64 {
        self.started.elapsed().as_secs_f64()
    }
}

/// Settings of a run, with only the maps that comparisons use.
pub fn settings_of(run: &CaseRun) -> Settings {
    let mut names: Vec<String> = run.comparisons.iter().map(|comparison| comparison.map.clone()).collect();
    names.sort();
    names.dedup();
    Settings {
        method: crate::solver::Method::Collision,
        elements: ElementChoice::Given,
        seed: run.seed,
        target_error: run.target_error,
        chains: run.chains,
        time_limit_s: run.time_limit_s,
        maps: MapSelection::Named(names),
        threads: None,
    }
}

/// Records the cost of a run.
pub fn record_of(run: &CaseRun, solution: &Solution) -> MeasuredRun {
    let mut methods: Vec<String> = solution.maps.iter().map(|map| map.method.clone()).collect();
    methods.sort();
    methods.dedup();
    MeasuredRun {
        name: run.name.clone(),
        methods,
        seed: solution.seed,
        chains: solution.chains,
        rays: solution.rays,
        seconds: solution.build_s + solution.compute_s,
        target_error: solution.target_error,
        stated_error: solution.estimated_error,
        stop_reason: solution.stop_reason,
        degrees_of_freedom: solution.replicas.saturating_sub(1) as f64,
    }
}

/// Adds a run's measured values to the exact values of a comparison.
///
/// # Errors
///
/// A map without the compared values.
pub(super) fn fill_in_measured(
    set: &mut EntrySet,
    run: &CaseRun,
    comparison: &Comparison,
    solution: &Solution,
) -> Result<(), String> {
    set.degrees_of_freedom = solution.replicas.saturating_sub(1) as f64;
    let map = map_named(solution, &comparison.map)?;
    if comparison.what.is_one_number() {
        let (value_lx, error_lx) = match comparison.what {
            What::Ugr => rating(map, solution)?,
            _ => average(&run.scene, comparison, map, solution)?,
        };
        for entry in &mut set.entries {
            (entry.measured, entry.standard_error) = (value_lx, error_lx);
        }
        set.independent = 1.0;
        return Ok(());
    }
    for entry in &mut set.entries {
        (entry.measured, entry.standard_error) = measured(map, entry.index, comparison.light);
    }
    let rows = map.tables.iter().filter(|row| match map.kind {
        MapKind::Elements => comparison.takes_in(&row.name, geometry_of(&run.scene, &row.name)),
        MapKind::Receivers(_) => true,
    });
    set.average_error = Some(mean_error_lx(&rows.collect::<Vec<_>>()));

    // Walks shared by neighbours and chains that serve many points correlate the points' errors.
    set.independent = map.error.degrees_of_freedom.min(set.entries.len() as f64);
    Ok(())
}

/// Standard error of the mean over table rows, from the spread of the replicas' own means. Rows share chains, so their errors are
/// correlated and must not be added in squares. Errors without replicas are biases, which may all have the same sign.
fn mean_error_lx(rows: &[&TableRow]) -> f64 {
    if let [row] = rows {
        return row.average.standard_error;
    }
    let area_m2: f64 = rows.iter().map(|row| row.area_m2).sum();
    let mean = |of: &dyn Fn(&TableRow) -> f64| rows.iter().map(|row| row.area_m2 * of(row)).sum::<f64>() / area_m2;
    if rows.iter().any(|row| row.replica_averages.len() != REPLICAS) {
        return mean(&|row| row.average.standard_error);
    }
    standard_error(|replica| mean(&|row| row.replica_averages[replica]))
}

fn map_named<'a>(solution: &'a Solution, name: &str) -> Result<&'a MapResult, String> {
    solution.maps.iter().find(|map| map.name == name).ok_or_else(|| format!("the method gave no map \"{name}\""))
}

/// Measured value and standard error of one entry of a map. The error is that of the total. Direct light that is reported
/// separately has no error of its own if something is reflected, and counts as exact.
fn measured(map: &MapResult, index: usize, light: LightPart) -> (f64, f64) {
    let values = &map.values;
    let error_lx = values.standard_error[index];
    match light {
        LightPart::Total => (values.value[index], error_lx),
        LightPart::Indirect => (values.indirect[index], error_lx),
        LightPart::Direct if values.indirect[index] == 0.0 => (values.direct[index], error_lx),
        LightPart::Direct => (values.direct[index], 0.0),
    }
}

fn geometry_of<'a>(scene: &'a Scene, surface: &str) -> &'a str {
    scene.surfaces.iter().find(|known| known.name == surface).map_or("", |known| known.geometry.as_str())
}

/// UGR of a map's only observer, and its standard error.
fn rating(map: &MapResult, solution: &Solution) -> Result<(f64, f64), String> {
    let rating = solution.glare.iter().find(|rating| map.kind == MapKind::Receivers(rating.set));
    let ugr = rating.and_then(|rating| rating.ugr).ok_or_else(|| format!("\"{}\" has no glare rating", map.name))?;
    Ok((ugr.value, ugr.standard_error))
}

/// Mean over a surface, a receiver set or the whole enclosure, and its standard error, in lx.
fn average(scene: &Scene, comparison: &Comparison, map: &MapResult, solution: &Solution) -> Result<(f64, f64), String> {
    let is_receiver_set = matches!(map.kind, MapKind::Receivers(_));
    let (total_lx, standard_error_lx) = match (&comparison.surface, is_receiver_set) {
        (Some(name), false) => {
            let row = map.tables.iter().find(|row| row.name == *name && row.side == "front");
            let row = row.ok_or_else(|| format!("the table has no row \"{name}\": name one part of a geometry"))?;
            (row.average.value, row.average.standard_error)
        }
        (None, true) => {
            let row = map.tables.first().ok_or("the receiver set has no table")?;
            (row.average.value, row.average.standard_error)
        }
        (None, false) => enclosure_average(scene, solution)?,
        (Some(_), true) => return Err("a receiver set has no surfaces".to_owned()),
    };
    let direct_lx = match comparison.light {
        LightPart::Total => 0.0,
        _ => direct_average(scene, comparison, map),
    };
    let value_lx = if comparison.light == LightPart::Direct { direct_lx } else { total_lx - direct_lx };
    Ok((value_lx, standard_error_lx))
}

/// Mean over a whole enclosure of uniform reflectance: the absorbed flux over (1 − ρ) and the area. The check of the map has the
/// replicas' spread of this sum, which the rows of a table do not give.
fn enclosure_average(scene: &Scene, solution: &Solution) -> Result<(f64, f64), String> {
    let reflectance = |material: u32| scene.materials[material as usize].bsdf.reflectance_at_every_angle();
    let first = reflectance(scene.surfaces[0].material);
    let is_one = scene.surfaces.iter().all(|surface| reflectance(surface.material) == first);
    let Some(first) = first.filter(|_| is_one) else {
        return Err("the mean over all surfaces needs one reflectance; name a surface".to_owned());
    };
    if first == 0.0 {
        return black_average(scene, solution);
    }
    let check = solution.map_check.as_ref().map_err(|reason| format!("no mean over all surfaces: {reason}"))?;
    let scale = 1.0 / ((1.0 - first) * mesh_area_m2(scene, None));
    Ok((check.absorbed_by_map_lm * scale, check.standard_error_lm * scale))
}

/// Mean over all surfaces of a black scene. The errors of its elements are errors of direct light, sampled independently.
fn black_average(scene: &Scene, solution: &Solution) -> Result<(f64, f64), String> {
    let map = map_named(solution, "elements")?;
    let elements = Elements::of(scene);
    let (mut flux_lm, mut square, mut area_m2) = (0.0, 0.0, 0.0);
    for index in 0..elements.len() {
        let own_m2 = elements.area_m2(scene, elements.element(index as u32));
        flux_lm += own_m2 * map.values.value[index];
        square += (own_m2 * map.values.standard_error[index]).powi(2);
        area_m2 += own_m2;
    }
    Ok((flux_lm / area_m2, square.sqrt() / area_m2))
}

fn direct_average(scene: &Scene, comparison: &Comparison, map: &MapResult) -> f64 {
    let (mut sum, mut weights) = (0.0, 0.0);
    let mut add = |weight: f64, direct_lx: f64| {
        sum += weight * direct_lx;
        weights += weight;
    };
    match map.kind {
        MapKind::Elements => {
            let elements = Elements::of(scene);
            for index in 0..elements.len() {
                let element = elements.element(index as u32);
                let surface = scene.surface_of(element.triangle);
                if comparison.takes_in(&surface.name, &surface.geometry) {
                    add(elements.area_m2(scene, element), map.values.direct[index]);
                }
            }
        }
        MapKind::Receivers(set) => {
            for (index, point) in scene.receivers[set].points.iter().enumerate().filter(|(_, point)| !point.inside) {
                add(point.weight, map.values.direct[index]);
            }
        }
    }
    if weights > 0.0 { sum / weights } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::maps::{Estimate, TableKind};
    use crate::sampling::random::{Purpose, Stream};

    /// Two rows of mean 1. Their replicas share a part of the noise, which has size `sigma` in each replica.
    fn rows(seed: u64, shared: f64, sigma: f64) -> [TableRow; 2] {
        let mut averages = [vec![0.0; REPLICAS], vec![0.0; REPLICAS]];
        for replica in 0..REPLICAS {
            let mut stream = Stream::new(seed, Purpose::Pilot, 0, replica as u32);
            stream.seek(0);
            let mut normal = || (0..12).map(|_| stream.unit()).sum::<f64>() - 6.0;
            let common = shared.sqrt() * normal();
            for row in &mut averages {
                row[replica] = 1.0 + sigma * (common + (1.0 - shared).sqrt() * normal());
            }
        }
        averages.map(|averages| TableRow {
            name: String::new(),
            kind: TableKind::Surface,
            side: "front",
            average: Estimate {
                value: averages.iter().sum::<f64>() / REPLICAS as f64,
                standard_error: standard_error(|replica| averages[replica]),
            },
            minimum: Estimate::default(),
            maximum: Estimate::default(),
            uniformity_u0: Estimate::default(),
            uniformity_ud: Estimate::default(),
            pulled: [0.0; 2],
            places: 1,
            covered_area_m2: 0.0,
            area_m2: 1.0,
            estimated_error: 0.0,
            replica_averages: averages,
        })
    }

    #[test]
    fn the_error_of_a_mean_knows_that_rows_share_chains() {
        // With 4000 seeds the squared error must be σ²/16 · (1 + shared)/2 within 4 of its own standard errors (relative
        // √(2/(15·4000)) = 0.58 %). Planted faults: the rows' errors added in squares, and errors that are 2 % too large.
        let (sigma, shared, seeds) = (0.01, 0.8, 4000);
        let truth = sigma * sigma / 16.0 * (1.0 + shared) / 2.0;
        let tolerance = 4.0 * truth * (2.0 / (15.0 * f64::from(seeds))).sqrt();
        let (mut honest, mut in_squares) = (0.0, 0.0);
        for seed in 0..seeds {
            let rows = rows(seed as u64, shared, sigma);
            honest += mean_error_lx(&[&rows[0], &rows[1]]).powi(2) / f64::from(seeds);
            let square: f64 = rows.iter().map(|row| row.average.standard_error.powi(2)).sum();
            in_squares += square / 4.0 / f64::from(seeds);
        }
        assert!((honest - truth).abs() < tolerance, "{honest} {truth} ± {tolerance}");
        for fault in [in_squares, honest * 1.02 * 1.02] {
            assert!((fault - truth).abs() > tolerance, "a planted fault passed: {fault} {truth} ± {tolerance}");
        }
    }

    #[test]
    fn errors_without_replicas_add_up() {
        let mut pair = rows(0, 0.0, 0.01);
        for row in &mut pair {
            row.replica_averages.clear();
            row.average.standard_error = 0.02;
        }
        assert!((mean_error_lx(&[&pair[0], &pair[1]]) - 0.02).abs() < 1e-15);
    }
}
