//! Verdicts of a solution on the scene's requirements.

use super::glare_rating::worst_of_sets;
use super::{GlareRating, Solution};
use crate::base::glare::LEAST_RATING;
use crate::control::{Certainty, Limit, Ruling, certainty};
use crate::maps::{Estimate, MapKind, MapResult, ROUNDING_OF_SUMS};
use crate::scene::{Measure, ReceiverSet, Requirement, Scene};

/// Change of a rating per change of the logarithm of the background.
const RATING_PER_LOG: f64 = 8.0 / std::f64::consts::LN_10;

/// A point that meets a limit by this many of its standard errors does not miss it by chance.
const FAR_ENOUGH: f64 = 4.0;

/// A requirement of a receiver set and its verdict.
#[derive(Clone, Debug)]
pub struct Verdict {
    /// Index of the set among the scene's receiver sets.
    pub set: usize,
    /// The requirement.
    pub requirement: Requirement,
    /// The finding.
    pub finding: Finding,
}

/// Finding on a requirement.
#[derive(Clone, Debug, PartialEq)]
pub enum Finding {
    /// A value, and its certainty relative to the limit. If a statistical check failed, the certainty is not used.
    Value {
        /// The value with its error, including that of the method.
        estimate: Estimate,
        /// Certainty that the requirement is met or missed.
        certainty: Certainty,
        /// Whether the error is reliable.
        is_reliable: bool,
    },
    /// No luminaire causes glare: the rating is below the scale.
    BelowScale,
    /// No value, with the reason.
    Nothing(&'static str),
}

impl Verdict {
    /// Whether the requirement is met, missed or undecided.
    pub fn ruling(&self) -> Ruling {
        match &self.finding {
            Finding::Value { certainty, is_reliable: true, .. } => certainty.ruling,
            Finding::BelowScale => Ruling::Met,
            Finding::Value { .. } | Finding::Nothing(_) => Ruling::Undecided,
        }
    }

    /// Why it is undecided even if the interval alone may decide it; `None` if the interval decides.
    pub fn doubt(&self) -> Option<&'static str> {
        match self.finding {
            Finding::Value { is_reliable: false, .. } => Some("a statistical check failed"),
            Finding::Nothing(reason) => Some(reason),
            _ => None,
        }
    }
}

/// Verdicts on all requirements of a scene, set by set in file order.
/// The error of a value is that of the tables combined in quadrature with the error that even and odd halves share: the bias that the map
/// states.
pub fn verdicts(scene: &Scene, solution: &Solution) -> Vec<Verdict> {
    let worst = worst_of_sets(&solution.glare);
    let mut verdicts = Vec::new();
    // A direct index: with ten thousand sets a search for each would take long.
    let mut maps: Vec<Option<&MapResult>> = vec![None; scene.receivers.len()];
    for map in solution.maps.iter().rev() {
        if let MapKind::Receivers(set) = map.kind {
            maps[set] = Some(map);
        }
    }
    let required = scene.receivers.iter().enumerate().filter(|(_, receivers)| !receivers.requirements.is_empty());
    for (set, receivers) in required {
        let map = maps[set];
        let rating = worst.iter().find(|(rating, _)| rating.set == set).map(|(rating, _)| *rating);
        for requirement in &receivers.requirements {
            let finding = match (map, requirement.measure) {
                (None, _) => Finding::Nothing("not computed"),
                (Some(map), Measure::Ugr) => of_rating(solution, rating, map, requirement),
                (Some(map), measure) if measure.is_direct() => of_direct_light(receivers, map, requirement),
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
            let places: Vec<Estimate> = of_set.filter_map(|rating| rating.ugr).collect();
            found(map, requirement, ugr, bias, &places, [0.0, f64::INFINITY])
        }
        // Without glare the rating is below the start of the scale, and no limit is there.
        None if rating.is_low() && requirement.limit >= LEAST_RATING => Finding::BelowScale,
        None => Finding::Nothing("nothing lights the background"),
    }
}

fn of_illuminance(receivers: &ReceiverSet, map: &MapResult, requirement: &Requirement) -> Finding {
    let Some(row) = map.tables.iter().find(|row| row.name == receivers.name && row.places > 0) else {
        return Finding::Nothing("no point is counted");
    };
    let measure = requirement.measure;
    if !measure.is_illuminance() && row.average.value <= 0.0 {
        return Finding::Nothing("no light was found");
    }
    // The value that each point would give if it were the least or the greatest.
    let places = |over: f64| -> Vec<Estimate> {
        let place = |(point, _): (Estimate, f64)| Estimate {
            value: point.value / over,
            standard_error: point.standard_error / over,
        };
        map.counted(&receivers.points).map(place).collect()
    };
    // The verdict itself accounts for the pull of random error on extreme values, by the number of points. So it is removed from the error
    // here.
    let alone = |estimate: Estimate, pulled: f64| Estimate {
        standard_error: (estimate.standard_error.powi(2) - pulled.powi(2)).max(0.0).sqrt(),
        ..estimate
    };
    let [least_lx, most_lx] = row.pulled;
    let (mean_lx, greatest_lx) = (row.average.value, row.maximum.value);
    let (estimate, places) = match measure {
        // Direct light has tables of its own: see `of_direct_light`.
        Measure::AverageLx | Measure::Ugr | Measure::DirectMinimumLx | Measure::DirectUniformityUd => {
            (row.average, Vec::new())
        }
        Measure::MinimumLx => (alone(row.minimum, least_lx), places(1.0)),
        Measure::MaximumLx => (alone(row.maximum, most_lx), places(1.0)),
        Measure::UniformityU0 => (alone(row.uniformity_u0, least_lx / mean_lx), places(mean_lx)),
        Measure::UniformityUd => {
            let pulled = least_lx.hypot(row.uniformity_ud.value * most_lx) / greatest_lx;
            (alone(row.uniformity_ud, pulled), places(greatest_lx))
        }
    };
    // Without replicas the stated error is all bias, and the row contains it.
    let bias = if row.replica_averages.is_empty() { 0.0 } else { map.error.bias * estimate.value.abs() };
    let greatest = if measure.is_illuminance() { f64::INFINITY } else { 1.0 };
    found(map, requirement, estimate, bias, &places, [0.0, greatest])
}

/// The least direct light, or its ratio to the greatest: light that has met nothing on its way, times the share of the flux that counts.
fn of_direct_light(receivers: &ReceiverSet, map: &MapResult, requirement: &Requirement) -> Finding {
    let (values, errors_lx) = (&map.values.direct, &map.values.direct_standard_error);
    if errors_lx.len() != values.len() {
        return Finding::Nothing("this method gives no error of direct light");
    }
    let counted = receivers.points.iter().enumerate().filter(|(_, point)| !point.inside && point.weight > 0.0);
    let points: Vec<Estimate> = counted
        .map(|(index, _)| Estimate {
            value: requirement.flux_factor * values[index],
            // Replicas that differ only by rounding count as equal.
            standard_error: match errors_lx[index] > ROUNDING_OF_SUMS * values[index] {
                true => requirement.flux_factor * errors_lx[index],
                false => 0.0,
            },
        })
        .collect();
    let by_value = |one: &&Estimate, other: &&Estimate| one.value.total_cmp(&other.value);
    let (Some(least), Some(greatest)) = (points.iter().min_by(by_value), points.iter().max_by(by_value)) else {
        return Finding::Nothing("no point is counted");
    };
    if requirement.measure == Measure::DirectMinimumLx {
        return found(map, requirement, *least, 0.0, &points, [0.0, f64::INFINITY]);
    }
    if greatest.value <= 0.0 {
        return Finding::Nothing("no light was found");
    }
    let over_greatest = |point: &Estimate| Estimate {
        value: point.value / greatest.value,
        standard_error: point.standard_error / greatest.value,
    };
    let places: Vec<Estimate> = points.iter().map(over_greatest).collect();
    let ratio = over_greatest(least);
    let of_greatest = ratio.value * greatest.standard_error / greatest.value;
    let estimate = Estimate { standard_error: ratio.standard_error.hypot(of_greatest), ..ratio };
    found(map, requirement, estimate, 0.0, &places, [0.0, 1.0])
}

/// Judges a value by its error, and by the points of which it is the least or greatest; for a mean there are none.
fn found(
    map: &MapResult,
    requirement: &Requirement,
    estimate: Estimate,
    bias: f64,
    places: &[Estimate],
    range: [f64; 2],
) -> Finding {
    let estimate = Estimate { standard_error: estimate.standard_error.hypot(bias), ..estimate };
    let (limit, is_at_least) = (requirement.limit, requirement.measure.is_at_least());
    let spare = |place: &Estimate| if is_at_least { place.value - limit } else { limit - place.value };
    let chances = places.iter().filter(|place| spare(place) < FAR_ENOUGH * place.standard_error).count();
    let weakest = places
        .iter()
        .filter(|place| place.standard_error > 0.0)
        .min_by(|one, other| (spare(one) / one.standard_error).total_cmp(&(spare(other) / other.standard_error)));
    let weakest = weakest.map(|place| Estimate { standard_error: place.standard_error.hypot(bias), ..*place });
    let limit = Limit { value: limit, is_at_least, chances: chances.max(1), weakest };
    Finding::Value {
        estimate,
        certainty: certainty(estimate, &limit, range),
        is_reliable: map.checks.iter().all(|check| check.passed),
    }
}
