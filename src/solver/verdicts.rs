//! What a solution says of the scene's requirements.

use super::glare::worst_of_sets;
use super::{GlareRating, Solution};
use crate::base::glare::LEAST_RATING;
use crate::control::{Certainty, Limit, Ruling, certainty};
use crate::maps::{Estimate, MapKind, MapResult};
use crate::scene::{Measure, ReceiverSet, Requirement, Scene};

/// How much a rating changes by the logarithm of the background.
const RATING_PER_LOG: f64 = 8.0 / std::f64::consts::LN_10;

/// A place that keeps a limit by so many of its standard errors does not miss it by chance.
const FAR_ENOUGH: f64 = 4.0;

/// A requirement of a receiver set and whether it is kept.
#[derive(Clone, Debug)]
pub struct Verdict {
    /// The set's place among the scene's receiver sets.
    pub set: usize,
    /// What is required.
    pub requirement: Requirement,
    /// What was found.
    pub finding: Finding,
}

/// What was found of a requirement.
#[derive(Clone, Debug, PartialEq)]
pub enum Finding {
    /// A value, with what its error says of the limit; where a statistical check failed, that is not relied on.
    Value {
        /// The value with its error, that of the method included.
        estimate: Estimate,
        /// What it says.
        certainty: Certainty,
        /// Whether the error is to be relied on.
        is_reliable: bool,
    },
    /// No luminaire glares: the rating lies below the scale.
    BelowScale,
    /// Nothing, with the reason.
    Nothing(&'static str),
}

impl Verdict {
    /// Whether the requirement is kept.
    pub fn ruling(&self) -> Ruling {
        match &self.finding {
            Finding::Value { certainty, is_reliable: true, .. } => certainty.ruling,
            Finding::BelowScale => Ruling::Met,
            Finding::Value { .. } | Finding::Nothing(_) => Ruling::Undecided,
        }
    }

    /// Why it is undecided though the interval may say more; `None` where the interval tells.
    pub fn doubt(&self) -> Option<&'static str> {
        match self.finding {
            Finding::Value { is_reliable: false, .. } => Some("a statistical check failed"),
            Finding::Nothing(reason) => Some(reason),
            _ => None,
        }
    }
}

/// Verdicts on all requirements of a scene, set by set in file order.
///
/// The error of a value is that of the tables and, in quadrature, what even and odd halves share: the bias that the map states.
pub fn verdicts(scene: &Scene, solution: &Solution) -> Vec<Verdict> {
    let worst = worst_of_sets(&solution.glare);
    let mut verdicts = Vec::new();
    for (set, receivers) in scene.receivers.iter().enumerate() {
        let map = solution.maps.iter().find(|map| map.kind == MapKind::Receivers(set));
        let rating = worst.iter().find(|(rating, _)| rating.set == set).map(|(rating, _)| *rating);
        for requirement in &receivers.requirements {
            let finding = match (map, requirement.measure) {
                (None, _) => Finding::Nothing("not computed"),
                (Some(map), Measure::Ugr) => of_rating(solution, rating, map, requirement),
                (Some(map), _) => of_illuminance(receivers, map, requirement),
            };
            verdicts.push(Verdict { set, requirement: *requirement, finding });
        }
    }
    verdicts
}

fn of_rating(solution: &Solution, rating: Option<&GlareRating>, map: &MapResult, requirement: &Requirement) -> Finding {
    let Some(rating) = rating else { return Finding::Nothing("no observer is rated") };
    let bias = RATING_PER_LOG * map.error.bias;
    match rating.ugr {
        Some(ugr) => {
            let of_set = solution.glare.iter().filter(|other| other.set == rating.set);
            let chances = chances(of_set.filter_map(|rating| rating.ugr), requirement.limit, false);
            found(map, requirement, ugr, bias, chances, [0.0, f64::INFINITY])
        }
        // Without glare the rating is below the scale's beginning, and no limit lies there.
        None if rating.is_low() && requirement.limit >= LEAST_RATING => Finding::BelowScale,
        None => Finding::Nothing("nothing lights the background"),
    }
}

fn of_illuminance(receivers: &ReceiverSet, map: &MapResult, requirement: &Requirement) -> Finding {
    let Some(row) = map.tables.iter().find(|row| row.name == receivers.name && row.places > 0) else {
        return Finding::Nothing("no point counts");
    };
    let (measure, limit) = (requirement.measure, requirement.limit);
    if !measure.is_illuminance() && row.average_lx.value <= 0.0 {
        return Finding::Nothing("no light was found");
    }
    let points = || {
        let counted = receivers.points.iter().zip(0..).filter(|(point, _)| !point.inside && point.weight > 0.0);
        counted.map(|(_, index): (_, usize)| Estimate {
            value: map.values.illuminance_lx[index],
            standard_error: map.values.standard_error_lx[index],
        })
    };
    let (estimate, chances) = match measure {
        Measure::AverageLx | Measure::Ugr => (row.average_lx, 1),
        Measure::MinimumLx => (row.minimum_lx, chances(points(), limit, true)),
        Measure::MaximumLx => (row.maximum_lx, chances(points(), limit, false)),
        Measure::UniformityU0 => (row.uniformity_u0, chances(points(), limit * row.average_lx.value, true)),
        Measure::UniformityUd => (row.uniformity_ud, chances(points(), limit * row.maximum_lx.value, true)),
    };
    // Without replicas all of the stated error is bias, and the row tells it.
    let bias = if row.replica_averages_lx.is_empty() { 0.0 } else { map.error.bias * estimate.value.abs() };
    let greatest = if measure.is_illuminance() { f64::INFINITY } else { 1.0 };
    found(map, requirement, estimate, bias, chances, [0.0, greatest])
}

/// Places that may miss a limit by chance: those that keep it by less than [`FAR_ENOUGH`] of their errors.
fn chances(places: impl Iterator<Item = Estimate>, limit: f64, is_at_least: bool) -> usize {
    let spare = |value: f64| if is_at_least { value - limit } else { limit - value };
    places.filter(|place| spare(place.value) < FAR_ENOUGH * place.standard_error).count()
}

fn found(
    map: &MapResult,
    requirement: &Requirement,
    told: Estimate,
    bias: f64,
    chances: usize,
    range: [f64; 2],
) -> Finding {
    let estimate = Estimate { standard_error: told.standard_error.hypot(bias), ..told };
    let limit = Limit { value: requirement.limit, is_at_least: requirement.measure.is_at_least(), chances };
    Finding::Value {
        estimate,
        certainty: certainty(estimate, &limit, range),
        is_reliable: map.checks.iter().all(|check| check.passed),
    }
}
