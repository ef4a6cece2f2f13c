//! The accuracy that a case requires of a run: the target for methods that stop by a target, where the case gives none.

use statrs::distribution::{ContinuousCDF, Normal};

use super::case::CaseRun;
use super::comparison::{Criterion, What};
use super::exact_side::ExactSide;
use super::measure::settings_of;
use super::run_method::RunMethod;
use super::statistics::ComparedEntry;
use crate::solver::{DEFAULT_TARGET_ERROR, Settings};

/// Probability that one of the values exceeds its bound although the stated error is the true error.
const ONE_IN_A_HUNDRED: f64 = 0.01;
/// Share of a bound on the RMS error that a run may use, because the stated error is itself uncertain.
const SHARE_OF_RMS: f64 = 0.8;

/// Assumed share of a map's RMS error that is common to all its values and remains in their mean. Random errors average out in a
/// mean, and mesh errors change their sign from point to point.
const SHARED_BY_ALL: f64 = 0.5;

/// Maps of a run that one stop rule serves, and their comparisons.
pub struct Part {
    /// Name of the map, if it is one of several parts.
    pub map: Option<String>,
    /// Settings of this part.
    pub settings: Settings,
    /// Indices of its comparisons in the run.
    pub comparisons: Vec<usize>,
}

/// Divides a run into parts, each with a stop rule. `exact` belongs to the run's comparisons. Only a method without any stop rule
/// gets targets from the criteria, map by map. Otherwise the run is one part.
pub fn parts_of(run: &CaseRun, method: Option<&RunMethod>, exact: &[ExactSide]) -> Vec<Part> {
    let settings = settings_of(run);
    let all: Vec<usize> = (0..run.comparisons.len()).collect();
    if !method.is_some_and(|method| method.lacks_rule(&settings)) {
        return vec![Part { map: None, settings, comparisons: all }];
    }
    let mut maps: Vec<(String, Vec<usize>)> = Vec::new();
    for (number, comparison) in run.comparisons.iter().enumerate() {
        match maps.iter_mut().find(|(name, _)| *name == comparison.map) {
            Some((_, numbers)) => numbers.push(number),
            None => maps.push((comparison.map.clone(), vec![number])),
        }
    }
    let target_of = |numbers: &[usize]| {
        let needed = numbers.iter().filter_map(|number| {
            let comparison = &run.comparisons[*number];
            let exact = &exact[*number];
            // A target applies to all light, a comparison perhaps to a part of it. Without light in that part nothing is required.
            let needed = needed_error(comparison.what, &comparison.criterion, exact.entries())
                .map(|needed| exact.share_of_all() * needed)
                .filter(|needed| *needed > 0.0);
            // A loose criterion never gives a target looser than the default, since the compared values may be darker than their
            // map.
            needed.map(|needed| needed.min(DEFAULT_TARGET_ERROR))
        });
        needed.reduce(f64::min)
    };
    let targets: Vec<Option<f64>> = maps.iter().map(|(_, numbers)| target_of(numbers)).collect();
    if targets.windows(2).all(|pair| pair[0] == pair[1]) {
        let target_error = targets.into_iter().flatten().next();
        return vec![Part { map: None, settings: Settings { target_error, ..settings }, comparisons: all }];
    }
    maps.into_iter()
        .zip(targets)
        .map(|((name, comparisons), target_error)| {
            let maps = crate::solver::MapSelection::Named(vec![name.clone()]);
            Part { map: Some(name), settings: Settings { target_error, maps, ..settings.clone() }, comparisons }
        })
        .collect()
}

/// The RMS error relative to the mean at which a map meets a criterion; `None` if the criterion requires no accuracy. Errors are
/// assumed to be equally large everywhere, in lx.
fn needed_error(what: What, criterion: &Criterion, exact: &[ComparedEntry]) -> Option<f64> {
    // In a map that must be completely dark, no accuracy target can make a wrong value right.
    if exact.iter().all(|entry| entry.exact.value <= 0.0) {
        return None;
    }
    let of_rms = criterion.true_error.map(|most| SHARE_OF_RMS * most.0);
    let of_worst = criterion.worst.map(|most| match what {
        What::Average | What::Ugr => most.0 / SHARED_BY_ALL,
        // Every value is judged relative to itself, and one of many values deviates far.
        What::Points | What::Elements => {
            let weight: f64 = exact.iter().map(|entry| entry.weight).sum();
            let mean_lx = exact.iter().map(|entry| entry.weight * entry.exact.value).sum::<f64>() / weight;
            let sizes = exact.iter().map(|entry| entry.exact.value / mean_lx).filter(|size| *size > 0.0);
            let strays = -Normal::standard().inverse_cdf(ONE_IN_A_HUNDRED / (2 * exact.len().max(1)) as f64);
            most.0 * sizes.fold(1.0, f64::min) / strays
        }
    });
    [of_rms, of_worst].into_iter().flatten().reduce(f64::min)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::validation::exact::Exact;
    use crate::validation::fields::Fraction;

    fn entries(values_lx: &[f64]) -> Vec<ComparedEntry> {
        let entry = |value_lx: &f64| ComparedEntry {
            weight: 1.0,
            exact: Exact { value: *value_lx, ..Exact::default() },
            ..ComparedEntry::default()
        };
        values_lx.iter().map(entry).collect()
    }

    /// Of nine values, one exceeds 3.26 normal deviations with a probability of 1 %. The darkest value has a third of the mean.
    #[test]
    fn a_run_is_asked_for_what_its_worst_value_may_be_off_by() {
        let exact = entries(&[50.0, 150.0, 150.0, 150.0, 150.0, 150.0, 150.0, 200.0, 200.0]);
        let asks = |worst: Option<f64>, true_error: Option<f64>, coverage_alpha: Option<f64>| Criterion {
            worst: worst.map(Fraction),
            worst_difference: None,
            true_error: true_error.map(Fraction),
            coverage_alpha,
        };
        let needed = needed_error(What::Points, &asks(Some(0.003), None, None), &exact).expect("a bound");
        assert!((needed / (0.003 / 3.0 / 3.26) - 1.0).abs() < 0.005, "{needed}");
        assert_eq!(needed_error(What::Average, &asks(Some(0.003), None, None), &exact), Some(0.006));
        assert_eq!(needed_error(What::Points, &asks(None, Some(0.01), None), &exact), Some(0.008));
        let both = needed_error(What::Points, &asks(Some(0.003), Some(0.0001), None), &exact);
        assert_eq!(both, Some(0.00008));
        assert_eq!(needed_error(What::Elements, &asks(None, None, Some(0.001)), &exact), None);
        // Points without light do not require errors of 0.
        let needed = needed_error(What::Points, &asks(Some(0.003), None, None), &entries(&[0.0, 10.0]));
        assert!(needed.is_some_and(|needed| needed > 0.0005));
        assert_eq!(needed_error(What::Elements, &asks(Some(0.00001), None, None), &entries(&[0.0, 0.0])), None);
    }
}
