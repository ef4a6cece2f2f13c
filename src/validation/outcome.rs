//! The outcome of a case: its runs, its comparisons and whether it passes.

use super::case::{Case, CaseRun};
use super::comparison::Comparison;
use super::demand::{Part, parts_of};
use super::error::CaseError;
use super::exact_side::ExactSide;
use super::measure::{MeasuredRun, Stopwatch, record_of, settings_of};
use super::run_method::RunMethod;
use super::statistics::{EntrySet, Statistics};
use super::verdict::{Check, judge};
use crate::solver::{Solution, solve};

/// The outcome of a case that was run.
#[derive(Clone, Debug)]
pub struct CaseOutcome {
    /// The case's name.
    pub name: String,
    /// Heading of the case.
    pub title: String,
    /// The physics in two sentences.
    pub physics: String,
    /// Further remarks for the reader.
    pub remarks: Vec<String>,
    /// Sources of the truth and of the geometry.
    pub sources: Vec<String>,
    /// Cost of every run.
    pub runs: Vec<MeasuredRun>,
    /// Outcomes of the comparisons.
    pub comparisons: Vec<ComparisonOutcome>,
}

/// One comparison and its verdict.
#[derive(Clone, Debug)]
pub struct ComparisonOutcome {
    /// The comparison as the case defines it.
    pub comparison: Comparison,
    /// The run, if the case has several and the comparison belongs to one.
    pub run: Option<String>,
    /// Measured and exact numbers.
    pub set: EntrySet,
    /// Statistics of their deviations.
    pub statistics: Statistics,
    /// The conditions and whether they hold.
    pub checks: Vec<Check>,
}

impl CaseOutcome {
    /// Returns whether every comparison passes.
    pub fn passes(&self) -> bool {
        self.comparisons.iter().all(ComparisonOutcome::passes)
    }

    /// Seconds of computing over all runs.
    pub fn seconds(&self) -> f64 {
        self.runs.iter().map(|run| run.seconds).sum()
    }

    /// Rays of all runs.
    pub fn rays(&self) -> u64 {
        self.runs.iter().map(|run| run.rays).sum()
    }
}

impl ComparisonOutcome {
    /// Returns whether every condition holds.
    pub fn passes(&self) -> bool {
        self.checks.iter().all(|check| check.holds)
    }

    /// Name of the comparison, with its run if there are several.
    pub fn heading(&self) -> String {
        match &self.run {
            Some(run) => format!("{}: {run}", self.comparison.name),
            None => self.comparison.name.clone(),
        }
    }
}

/// Runs a case and its comparisons. `tell` receives the name of every run that begins.
///
/// # Errors
///
/// A comparison that the truth or the map cannot answer.
pub fn run_case(case: &Case, tell: &mut dyn FnMut(&str)) -> Result<CaseOutcome, CaseError> {
    let mut runs = Vec::new();
    let mut parts: Vec<(Option<String>, Comparison, EntrySet)> = Vec::new();
    for run in &case.runs {
        tell(&run.name);
        let exact = exact_sides(case, run)?;
        for part in parts_of(run, run.method.as_ref(), &exact) {
            let solution = match &run.method {
                None => solve(&run.scene, &part.settings, &Stopwatch::starting_now()),
                Some(method) => method
                    .solve(&run.scene, &part.settings, &Stopwatch::starting_now())
                    .map_err(|reason| not_by(case, &run.name, method, reason))?,
            };
            runs.push(record_of_part(run, &part, &solution));
            for number in part.comparisons {
                let comparison = &run.comparisons[number];
                let set = exact[number].beside(&solution)?;
                parts.push((name_in_tables(case, run, comparison), comparison.clone(), set));
            }
        }
    }
    Ok(outcome_of(case, runs, parts))
}

/// Runs a case by a method other than its own. Runs and comparisons that the method cannot compute are left out, and `tell`
/// receives the reason. `None` if nothing is left.
///
/// # Errors
///
/// A truth that cannot be computed.
pub fn run_case_by(
    case: &Case,
    method: &RunMethod,
    tell: &mut dyn FnMut(&str),
) -> Result<Option<CaseOutcome>, CaseError> {
    let mut runs = Vec::new();
    let mut parts: Vec<(Option<String>, Comparison, EntrySet)> = Vec::new();
    for run in &case.runs {
        if let Err(reason) = method.applies(&run.scene, &settings_of(run)) {
            tell(&format!("{}: left out: {reason}", run.name));
            continue;
        }
        tell(&run.name);
        let exact = exact_sides(case, run)?;
        for part in parts_of(run, Some(method), &exact) {
            let solution = match method.solve(&run.scene, &part.settings, &Stopwatch::starting_now()) {
                Ok(solution) => solution,
                Err(reason) => {
                    tell(&format!("{}: left out: {reason}", run.name));
                    continue;
                }
            };
            let before = parts.len();
            for number in &part.comparisons {
                let comparison = &run.comparisons[*number];
                match exact[*number].beside(&solution) {
                    Ok(set) => parts.push((name_in_tables(case, run, comparison), comparison.clone(), set)),
                    Err(reason) => tell(&format!("{}: \"{}\" left out: {reason}", run.name, comparison.name)),
                }
            }
            if parts.len() > before {
                runs.push(record_of_part(run, &part, &solution));
            }
        }
    }
    Ok((!parts.is_empty()).then(|| outcome_of(case, runs, parts)))
}

fn exact_sides<'a>(case: &'a Case, run: &'a CaseRun) -> Result<Vec<ExactSide<'a>>, CaseError> {
    run.comparisons.iter().map(|comparison| ExactSide::new(case, run, comparison)).collect()
}

/// Name of the run shown beside a comparison, if the case has several runs and the comparison belongs to one.
fn name_in_tables(case: &Case, run: &CaseRun, comparison: &Comparison) -> Option<String> {
    (case.runs.len() > 1 && !comparison.what.is_one_number()).then(|| run.name.clone())
}

fn record_of_part(run: &CaseRun, part: &Part, solution: &Solution) -> MeasuredRun {
    let record = record_of(run, solution);
    let name = part.map.as_ref().map_or(record.name.clone(), |map| format!("{}: {map}", record.name));
    MeasuredRun { name, ..record }
}

fn not_by(case: &Case, run: &str, method: &RunMethod, reason: String) -> CaseError {
    let what = format!("the run \"{run}\" cannot be computed by {}", method.name());
    CaseError::new(&case.folder, what, reason, "a scene that the method can compute", "name another method")
}

fn outcome_of(case: &Case, runs: Vec<MeasuredRun>, parts: Vec<(Option<String>, Comparison, EntrySet)>) -> CaseOutcome {
    let comparisons = merge_averages(parts).into_iter().map(|(run, comparison, set)| {
        let statistics = set.statistics();
        let checks = judge(&set, &statistics, &comparison.criterion);
        ComparisonOutcome { comparison, run, set, statistics, checks }
    });
    CaseOutcome {
        name: case.name.clone(),
        title: case.title.clone(),
        physics: case.physics.clone(),
        remarks: case.remarks.clone(),
        sources: case.sources.clone(),
        runs,
        comparisons: comparisons.collect(),
    }
}

/// Merges averages of the same name into one comparison, for all their runs and surfaces.
fn merge_averages(parts: Vec<(Option<String>, Comparison, EntrySet)>) -> Vec<(Option<String>, Comparison, EntrySet)> {
    let mut merged: Vec<(Option<String>, Comparison, EntrySet)> = Vec::new();
    for (run, comparison, mut set) in parts {
        let same = |other: &&mut (Option<String>, Comparison, EntrySet)| {
            comparison.what.is_one_number() && other.1.what == comparison.what && other.1.name == comparison.name
        };
        match merged.iter_mut().find(same) {
            Some((_, _, whole)) => {
                whole.entries.append(&mut set.entries);
                whole.independent += set.independent;
                whole.across_runs = true;
            }
            None => merged.push((run, comparison, set)),
        }
    }

    // Averages are labelled by their run, their surface, or both, depending on what distinguishes them.
    for (_, _, set) in merged.iter_mut().filter(|(_, comparison, _)| comparison.what.is_one_number()) {
        set.across_runs = true;
        let differ = |of: fn(&super::statistics::ComparedEntry) -> &str| {
            set.entries.iter().any(|entry| of(entry) != of(&set.entries[0]))
        };
        let (runs_differ, labels_differ) = (differ(|entry| &entry.run), differ(|entry| &entry.label));
        for entry in &mut set.entries {
            entry.label = match (runs_differ, labels_differ) {
                (true, true) => format!("{}, {}", entry.run, entry.label),
                (true, false) => entry.run.clone(),
                _ => entry.label.clone(),
            };
        }
    }
    merged
}
