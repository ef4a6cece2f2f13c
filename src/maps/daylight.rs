//! Daylight factors: illuminance divided by that of an open horizontal plane under the same sky.

use super::{Estimate, MapResult};
use crate::scene::{DaylightTargets, ReceiverPoint};

/// Shares of the area that EN 17037 requires above the target and above the minimum daylight factor.
pub const SHARES_WANTED: [f64; 2] = [0.5, 0.95];

/// Sky component in % below which a point counts as one without a view of the sky: it lies beyond the no-sky line.
pub const NO_SKY_PERCENT: f64 = 0.02;

/// Bisection steps for the ends of the median's interval.
const BISECTIONS: u32 = 32;

/// Daylight factors of a receiver set.
#[derive(Clone, Debug)]
pub struct DaylightFactors {
    /// Name of the receiver set.
    pub name: String,
    /// Illuminance in lx of an open horizontal plane.
    pub outside_lx: f64,
    /// Mean over all points, weighted by area, in %.
    pub average_percent: Estimate,
    /// Minimum over all points in %.
    pub minimum_percent: Estimate,
    /// Median in %: half of the area has a higher value.
    pub median_percent: Estimate,
    /// Targets D_T and D_TM of EN 17037 in %.
    pub targets_percent: [f64; 2],
    /// Shares of the area above these two targets, 0 to 1.
    pub shares_above: [Estimate; 2],
    /// Probabilities, 0 to 1, that these shares reach the required ones: see [`SHARES_WANTED`].
    pub certainties: [f64; 2],
    /// Components of the mean, where they are known.
    pub components: Option<ComponentMeans>,
}

/// Mean components of the daylight factor.
#[derive(Clone, Copy, Debug)]
pub struct ComponentMeans {
    /// Sky component, externally and internally reflected component in %. Their sum is the mean daylight factor.
    pub percents: [Estimate; 3],
    /// Share of the area beyond the no-sky line: see [`NO_SKY_PERCENT`].
    pub without_sky: Estimate,
}

impl DaylightFactors {
    /// Returns the daylight factors of a map with the points of its set. `None` if the outside is dark or no point counts.
    pub fn of(map: &MapResult, points: &[ReceiverPoint], outside_lx: f64, targets: DaylightTargets) -> Option<Self> {
        let percent = |lx: f64| 100.0 * lx / outside_lx;
        let factor = |estimate: Estimate| Estimate {
            value: percent(estimate.value),
            standard_error: percent(estimate.standard_error),
        };
        let mut places: Vec<(Estimate, f64)> =
            map.counted(points).map(|(estimate, weight)| (factor(estimate), weight)).collect();
        let row = map.tables.first()?;
        if outside_lx <= 0.0 || places.is_empty() {
            return None;
        }
        places.sort_by(|one, other| one.0.value.total_cmp(&other.0.value));
        let targets_percent = [targets.target_percent, targets.minimum_percent];
        let average_percent = factor(row.average);
        let shares_above = targets_percent.map(|target| known_share_above(&places, average_percent, target));
        Some(DaylightFactors {
            name: map.name.clone(),
            outside_lx,
            average_percent,
            minimum_percent: factor(row.minimum),
            median_percent: median_with_error(&places, average_percent),
            targets_percent,
            shares_above,
            certainties: [0, 1].map(|which| certainty(shares_above[which], SHARES_WANTED[which])),
            components: component_means(map, points, outside_lx, average_percent),
        })
    }
}

/// Computes means over the area. Random errors of the points are independent. The map's common error can be the same for all points.
fn component_means(
    map: &MapResult,
    points: &[ReceiverPoint],
    outside_lx: f64,
    average_percent: Estimate,
) -> Option<ComponentMeans> {
    let components = &map.values.sky_components_lx;
    let counted: Vec<(&[Estimate; 3], f64)> = (components.iter().zip(points))
        .filter(|(_, point)| !point.inside && point.weight > 0.0)
        .map(|(components, point)| (components, point.weight))
        .collect();
    let all: f64 = counted.iter().map(|(_, weight)| weight).sum();
    if counted.is_empty() {
        return None;
    }
    let percent = 100.0 / outside_lx;
    let percents = [0, 1, 2].map(|which| {
        let sum: f64 = counted.iter().map(|(components, weight)| weight * components[which].value).sum();
        let squares: f64 =
            counted.iter().map(|(components, weight)| (weight * components[which].standard_error).powi(2)).sum();
        let value = percent * sum / all;
        let alike = if average_percent.value > 0.0 { value / average_percent.value } else { 1.0 };
        let standard_error = (percent * squares.sqrt() / all).hypot(alike * average_percent.standard_error);
        Estimate { value, standard_error }
    });
    let skies: Vec<(Estimate, f64)> = counted
        .iter()
        .map(|([sky, ..], weight)| {
            (Estimate { value: percent * sky.value, standard_error: percent * sky.standard_error }, *weight)
        })
        .collect();
    let seen = known_share_above(&skies, average_percent, NO_SKY_PERCENT);
    Some(ComponentMeans { percents, without_sky: Estimate { value: 1.0 - seen.value, ..seen } })
}

/// Returns the median with its error. The error has two parts: the independent errors of the points, and the error that all points share,
/// known from the mean's error.
///
/// For the first part, values for which the share of the weight above them is one half within its error may be the median. Where few points
/// lie near the median, this interval is too wide. The error of the median point itself then limits it.
fn median_with_error(places: &[(Estimate, f64)], average: Estimate) -> Estimate {
    let median = median(places);
    let alike = if average.value > 0.0 {
        median.value * average.standard_error / average.value
    } else {
        average.standard_error
    };
    let reach = 4.0 * places.iter().map(|(place, _)| place.standard_error).fold(0.0, f64::max);
    let ends = [places[0].0.value - reach, places[places.len() - 1].0.value + reach];
    // The share falls from 1 to 0 as the value grows.
    let last_where = |holds: &dyn Fn(Estimate) -> bool| {
        let [mut low, mut high] = ends;
        for _ in 0..BISECTIONS {
            let middle = 0.5 * (low + high);
            *(if holds(share_above(places, middle)) { &mut low } else { &mut high }) = middle;
        }
        low
    };
    let highest = last_where(&|share| share.value + share.standard_error >= 0.5);
    let lowest = last_where(&|share| share.value - share.standard_error > 0.5);
    let scattered = (0.5 * (highest - lowest)).clamp(0.0, median.standard_error);
    Estimate { value: median.value, standard_error: scattered.hypot(alike) }
}

/// Returns the value that half of the weight exceeds, with the error of the point that has it. `places` must be sorted by value.
fn median(places: &[(Estimate, f64)]) -> Estimate {
    let half: f64 = 0.5 * places.iter().map(|(_, weight)| weight).sum::<f64>();
    let mut before = 0.0;
    for pair in places.windows(2) {
        before += pair[0].1;
        // Exactly half of the weight ends between two points: return their mean.
        if before == half {
            return Estimate {
                value: 0.5 * (pair[0].0.value + pair[1].0.value),
                standard_error: pair[0].0.standard_error.max(pair[1].0.standard_error),
            };
        }
        if before > half {
            return pair[0].0;
        }
    }
    places[places.len() - 1].0
}

/// Returns the share of the weight above a value. Each point lies above it with the probability that follows from its error. The error of
/// the share treats the points as independent.
fn share_above(places: &[(Estimate, f64)], limit: f64) -> Estimate {
    let all: f64 = places.iter().map(|(_, weight)| weight).sum();
    let (mut share, mut variance) = (0.0, 0.0);
    for (place, weight) in places {
        let above = certainty(*place, limit);
        share += weight * above;
        variance += (weight / all).powi(2) * above * (1.0 - above);
    }
    Estimate { value: share / all, standard_error: variance.sqrt() }
}

/// Returns the share of the area above a limit, whether light was found or not.
fn known_share_above(places: &[(Estimate, f64)], average: Estimate, limit: f64) -> Estimate {
    unlit_share(average, limit).unwrap_or_else(|| share_above(places, limit))
}

/// Returns the share of the area above a limit if no light was found yet, and `None` if some was. Points then have no errors of their own.
/// Light that may have been missed is the mean's error, the same for all points.
fn unlit_share(average: Estimate, limit: f64) -> Option<Estimate> {
    let above = certainty(average, limit);
    let unlit = Estimate { value: above, standard_error: (above * (1.0 - above)).sqrt() };
    (average.value == 0.0 && average.standard_error > 0.0).then_some(unlit)
}

/// Returns the probability that the true value is at least `limit`.
pub fn certainty(estimate: Estimate, limit: f64) -> f64 {
    let beyond = estimate.value - limit;
    if estimate.standard_error > 0.0 {
        0.5 * libm::erfc(-beyond / (std::f64::consts::SQRT_2 * estimate.standard_error))
    } else {
        f64::from(u8::from(beyond >= 0.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::random::{Purpose, Stream};

    fn place(value: f64, standard_error: f64, weight: f64) -> (Estimate, f64) {
        (Estimate { value, standard_error }, weight)
    }

    #[test]
    fn medians_go_by_weight() {
        let even = [place(1.0, 0.1, 1.0), place(2.0, 0.2, 1.0), place(4.0, 0.1, 1.0), place(8.0, 0.1, 1.0)];
        assert_eq!((median(&even).value, median(&even).standard_error), (3.0, 0.2));
        let uneven = [place(1.0, 0.1, 5.0), place(2.0, 0.2, 1.0), place(4.0, 0.1, 1.0)];
        assert_eq!(median(&uneven).value, 1.0);
        assert_eq!(median(&uneven[2..]).value, 4.0);
    }

    /// 101 points from 1 to 3 with errors of 0.2 each, drawn 500 times (sums of twelve random numbers, seed 1). The scatter of the
    /// median agrees with its stated error within a third. The error of the median's own point, the planted fault, does not agree. An error
    /// that all points share remains unchanged.
    #[test]
    fn medians_scatter_by_their_stated_error() {
        let truth = |number: usize| 1.0 + 0.02 * number as f64;
        let mut stream = Stream::new(1, Purpose::Pilot, 0, 0);
        let mut normal = || (0..12).map(|_| stream.unit()).sum::<f64>() - 6.0;
        let (mut sum, mut squares, mut stated) = (0.0, 0.0, 0.0);
        for _ in 0..500 {
            let mut places: Vec<_> = (0..101).map(|number| place(truth(number) + 0.2 * normal(), 0.2, 1.0)).collect();
            places.sort_by(|one, other| one.0.value.total_cmp(&other.0.value));
            let median = median_with_error(&places, Estimate { value: 2.0, standard_error: 0.0 });
            sum += median.value;
            squares += median.value * median.value;
            stated += median.standard_error / 500.0;
        }
        let scatter = (squares / 500.0 - (sum / 500.0f64).powi(2)).sqrt();
        assert!((stated / scatter - 1.0).abs() < 0.34, "{stated} stated, {scatter} found");
        assert!((0.2 / scatter - 1.0).abs() > 0.34, "the planted fault passed");
        let sure = [place(1.0, 0.0, 1.0), place(2.0, 0.0, 1.0), place(3.0, 0.0, 1.0)];
        assert_eq!(median_with_error(&sure, Estimate { value: 2.0, standard_error: 0.1 }).standard_error, 0.1);
        assert_eq!(median_with_error(&sure, Estimate { value: 2.0, standard_error: 0.0 }).standard_error, 0.0);
        // Where no light was found yet, the median is as uncertain as the mean.
        let unlit = [place(0.0, 0.0, 1.0), place(0.0, 0.0, 1.0)];
        assert_eq!(median_with_error(&unlit, Estimate { value: 0.0, standard_error: 1.2 }).standard_error, 1.2);
    }

    #[test]
    fn shares_count_places_by_what_is_known_of_them() {
        let sure = [place(1.0, 0.0, 1.0), place(2.0, 0.0, 1.0), place(3.0, 0.0, 2.0)];
        let share = share_above(&sure, 2.0);
        assert_eq!((share.value, share.standard_error), (0.75, 0.0));
        // A point on the limit is above it with probability one half. It is the only uncertainty here.
        let doubtful = [place(1.0, 0.0, 1.0), place(2.0, 0.1, 1.0), place(3.0, 0.0, 2.0)];
        let share = share_above(&doubtful, 2.0);
        assert!((share.value - 0.625).abs() < 1e-9 && (share.standard_error - 0.125).abs() < 1e-9, "{share:?}");
        // No light was found yet: whether the area lies above the limit is unknown until the mean's bound is far below it.
        let unlit = |error: f64| unlit_share(Estimate { value: 0.0, standard_error: error }, 2.0).expect("unlit");
        assert!((unlit(2.0).value - 0.158_655_254).abs() < 1e-7 && unlit(2.0).standard_error > 0.36);
        assert!(unlit(0.1).value < 1e-9 && unlit(0.1).standard_error < 1e-9);
        assert!(unlit_share(Estimate { value: 1.0, standard_error: 2.0 }, 2.0).is_none());
        assert!((certainty(Estimate { value: 3.0, standard_error: 1.0 }, 2.0) - 0.841_344_746).abs() < 1e-7);
    }
}
