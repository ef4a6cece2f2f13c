//! The exact values of a comparison, computed once for any number of measured runs.

use super::case::{CASE_FILE, Case, CaseRun};
use super::comparison::{Along, Comparison, ELEMENT_MAP, PublishedNumbers, What};
use super::error::CaseError;
use super::exact::{LightPart, TruthSite};
use super::measure::fill_in_measured;
use super::statistics::{ComparedEntry, EntrySet};
use super::truth::Truth;
use crate::scene::{Elements, Scene};
use crate::solver::Solution;

/// Exact values of all entries of a comparison.
pub struct ExactSide<'a> {
    case: &'a Case,
    run: &'a CaseRun,
    comparison: &'a Comparison,
    exact: EntrySet,
    share_of_all: f64,
}

impl<'a> ExactSide<'a> {
    /// Computes the exact values.
    ///
    /// # Errors
    ///
    /// A truth that does not give the requested values.
    pub fn new(case: &'a Case, run: &'a CaseRun, comparison: &'a Comparison) -> Result<ExactSide<'a>, CaseError> {
        let truth = Truth::prepare(comparison, &run.scene, &case.rooms, &case.folder)?;
        let made = |comparison: &Comparison| match comparison.what {
            What::Average | What::Ugr => average(comparison, &truth),
            What::Points => points(&run.scene, comparison, &truth),
            What::Elements => elements(&run.scene, comparison, &truth),
        };
        let mut entries = made(comparison).map_err(|what| refused(case, run, comparison, what))?;
        let sum_lx =
            |entries: &[ComparedEntry]| entries.iter().map(|entry| entry.weight * entry.exact.value).sum::<f64>();
        let share_of_all = match comparison.light {
            LightPart::Total => 1.0,
            // If the truth has only one part of the light, that part counts as all light.
            LightPart::Direct | LightPart::Indirect => {
                made(&Comparison { light: LightPart::Total, ..comparison.clone() })
                    .map_or(1.0, |all| (sum_lx(&entries) / sum_lx(&all)).clamp(0.0, 1.0))
            }
        };
        for entry in &mut entries {
            entry.run.clone_from(&run.name);
        }
        let exact = EntrySet {
            entries,
            truth_in_words: truth.in_words(),
            truth_average_error: truth.average_error_lx(),
            ..EntrySet::default()
        };
        Ok(ExactSide { case, run, comparison, exact, share_of_all })
    }

    /// Share of the compared part of the light in all light, 0 to 1.
    pub fn share_of_all(&self) -> f64 {
        self.share_of_all
    }

    /// The exact values.
    pub fn entries(&self) -> &[ComparedEntry] {
        &self.exact.entries
    }

    /// Returns the exact values together with a run's measured values.
    ///
    /// # Errors
    ///
    /// A map without the compared values.
    pub fn beside(&self, solution: &Solution) -> Result<EntrySet, CaseError> {
        let mut set = self.exact.clone();
        fill_in_measured(&mut set, self.run, self.comparison, solution)
            .map_err(|what| refused(self.case, self.run, self.comparison, what))?;
        Ok(set)
    }
}

fn refused(case: &Case, run: &CaseRun, comparison: &Comparison, got: String) -> CaseError {
    let what = format!("the comparison \"{}\" of the run \"{}\" cannot be made", comparison.name, run.name);
    CaseError::new(
        &case.folder.join(CASE_FILE),
        what,
        got,
        "values that both the truth and the map have",
        "correct the case",
    )
}

fn entry_of(truth: &Truth, comparison: &Comparison, site: &TruthSite, label: String) -> Result<ComparedEntry, String> {
    let beside = match &comparison.beside {
        Some(PublishedNumbers { column: Some(column), .. }) => truth.beside(column, site)?,
        Some(beside) => beside.value_lx,
        None => None,
    };
    Ok(ComparedEntry {
        label,
        exact: truth.exact(site, comparison.light)?,
        beside,
        weight: 1.0,
        ..ComparedEntry::default()
    })
}

fn average(comparison: &Comparison, truth: &Truth) -> Result<Vec<ComparedEntry>, String> {
    let whole = if comparison.map == ELEMENT_MAP { "all surfaces" } else { &comparison.map };
    let label = comparison.surface.clone().unwrap_or_else(|| whole.to_owned());
    Ok(vec![entry_of(truth, comparison, &TruthSite::Average { surface: comparison.surface.as_deref() }, label)?])
}

fn points(scene: &Scene, comparison: &Comparison, truth: &Truth) -> Result<Vec<ComparedEntry>, String> {
    let set = scene.receivers.iter().find(|set| set.name == comparison.map).ok_or("no such receiver set")?;
    let mut entries = Vec::new();
    for (index, point) in set.points.iter().enumerate().filter(|(_, point)| !point.inside) {
        let along_m = comparison.axis.as_ref().map(|axis| match axis.along {
            Along::X => point.position_m.x,
            Along::Y => point.position_m.y,
            Along::Z => point.position_m.z,
        });
        let label = match (&comparison.labels, &comparison.axis, along_m) {
            (Some(labels), _, _) => labels[index].clone(),
            (None, Some(axis), Some(along_m)) => format!("{} = {} m", axis.along.name(), rounded(along_m)),
            _ => (index + 1).to_string(),
        };
        let site = TruthSite::Point { position_m: point.position_m, normal: point.normal, index };
        let entry = entry_of(truth, comparison, &site, label)?;
        entries.push(ComparedEntry { index, weight: point.weight, along_m, ..entry });
    }
    Ok(entries)
}

/// Rounds a coordinate to the micrometre for a label.
fn rounded(along_m: f64) -> f64 {
    (along_m * 1e6).round() / 1e6
}

fn elements(scene: &Scene, comparison: &Comparison, truth: &Truth) -> Result<Vec<ComparedEntry>, String> {
    let elements = Elements::of(scene);
    let mut entries = Vec::new();
    for index in 0..elements.len() {
        let element = elements.element(index as u32);
        let surface = scene.surface_of(element.triangle);
        if !comparison.takes_in(&surface.name, &surface.geometry) {
            continue;
        }
        let site = TruthSite::Element { corners_m: elements.corners_m(scene, element), surface: &surface.name, index };
        let entry = entry_of(truth, comparison, &site, format!("{} {index}", surface.name))?;
        entries.push(ComparedEntry { index, weight: elements.area_m2(scene, element), ..entry });
    }
    Ok(entries)
}
