//! Result tables: average, minimum, maximum and uniformities with their errors.

use std::f64::consts::FRAC_1_SQRT_2;

use super::REPLICAS;
use super::grid_slopes::CellSlopes;
use super::replicas::{ReplicaMap, half_means, standard_error};
use super::{Estimate, RareScores, TableKind, TableRow, judge};
use crate::scene::{EvaluationGrid, GridPart};

/// Relative spread of replicas that counts as rounding, not chance. Sums of thousands of entries agree up to a few units of the last of 53
/// bits.
const ROUNDING_OF_SPREAD: f64 = 1e-14;

/// Evaluation points of the minimum and maximum.
#[derive(Clone, Copy)]
pub enum Places<'a> {
    /// The entries themselves: the receiver points of the set.
    Entries,
    /// The cells of a grid on a surface. Without a grid there are no evaluation points.
    Grid {
        /// The grid.
        grid: Option<&'a EvaluationGrid>,
        /// Root mean square in lx of the variation that each element of the map does not show. Empty where elements stand for their means
        /// only.
        discretisation_lx: &'a [f64],
        /// Change in each cell by planes through the means of elements. Empty where elements have slopes of their own.
        slopes: &'a [CellSlopes],
    },
}

/// Entries of a map that make one row, with the row's name.
pub struct TableSubject<'a> {
    /// Name of the surface or receiver set.
    pub name: &'a str,
    /// Subject of the row.
    pub kind: TableKind,
    /// `front` or `back`.
    pub side: &'static str,
    /// Entries of the map.
    pub entries: &'a [usize],
    /// Weight of each of these entries; 0 leaves it out.
    pub weights: &'a [f64],
    /// Total area in m² that the row stands for.
    pub area_m2: f64,
    /// Area in m² of this that is hidden by contact. The entries are means over this area too.
    pub covered_area_m2: f64,
    /// Evaluation points of the minimum and maximum.
    pub places: Places<'a>,
    /// Statistics of rare scores in the map ([`ReplicaMap::rare_scores`]).
    pub rare_scores: RareScores,
    /// Remaining error of the cells in the average, in the unit of the map's quantity, if walks have measured it.
    pub average_left: Option<f64>,
}

/// Value at an evaluation point in every replica, and the part of its error that the replicas do not show.
struct PlaceReplicas {
    replicas: [f64; REPLICAS],
    /// Indirect part of the mean.
    indirect: f64,
    shared_error: f64,
}

impl PlaceReplicas {
    fn of_entry(map: &ReplicaMap, entry: usize) -> PlaceReplicas {
        PlaceReplicas {
            replicas: std::array::from_fn(|replica| map.value(replica, entry)),
            indirect: map.indirect(entry),
            shared_error: map.cells_error.as_ref().map_or(0.0, |error| error.by_site[entry]),
        }
    }

    /// Evaluates a cell of a grid. Its elements look up the same cache cells and share their error, so these errors add up. Their
    /// discretisation errors are independent.
    fn of_cell(
        map: &ReplicaMap,
        parts: &[GridPart],
        discretisation_lx: &[f64],
        slopes: Option<&CellSlopes>,
    ) -> PlaceReplicas {
        let area_m2: f64 = parts.iter().map(|part| part.area_m2).sum();
        let (mut replicas, mut indirect, mut of_cells_lx, mut lost_lx2) = ([0.0; REPLICAS], 0.0, 0.0, 0.0);
        for part in parts {
            let (element, share) = (part.element as usize, part.scale * part.area_m2 / area_m2);
            for (replica, lx) in replicas.iter_mut().enumerate() {
                *lx += share * map.shown_lx(replica, element, part.at);
            }
            indirect += share * map.indirect(element);
            of_cells_lx += share * map.cells_error.as_ref().map_or(0.0, |error| error.by_site[element]);
            lost_lx2 += (share * discretisation_lx.get(element).copied().unwrap_or(0.0)).powi(2);
        }
        if let Some(slopes) = slopes {
            for (replica, lx) in replicas.iter_mut().enumerate() {
                let element_lx = |(element, weight): &(u32, f64)| weight * map.value(replica, *element as usize);
                *lx += slopes.weights.iter().map(element_lx).sum::<f64>();
            }
            lost_lx2 += slopes.lost_lx2;
        }
        PlaceReplicas { replicas, indirect, shared_error: of_cells_lx.hypot(lost_lx2.sqrt()) }
    }

    fn mean(&self) -> f64 {
        self.replicas.iter().sum::<f64>() / REPLICAS as f64
    }

    /// Returns the error of the point's mean, as in the point's own row of a file. It is the replicas' spread, widened where few
    /// scores bring the light, with the error that the replicas share.
    fn error(&self, map: &ReplicaMap, rare_scores: RareScores) -> f64 {
        let spread = map.squared_error(|replica| self.replicas[replica]).sqrt();
        rare_scores.bar(spread, self.indirect).hypot(self.shared_error)
    }
}

/// The minimum or maximum of a row's evaluation points: of the mean over all replicas, and of the means that leave one replica
/// out.
struct Extreme {
    sign: f64,
    whole: f64,
    without: [f64; REPLICAS],
    /// Extreme of each half alone, and the value of the other half at the same point.
    of_halves: [[f64; 2]; 2],
    place: usize,
    /// Error of the point that has the extreme.
    error: f64,
}

impl Extreme {
    /// Returns an extreme without a value. `sign` is 1 for the minimum and −1 for the maximum.
    fn new(sign: f64) -> Extreme {
        let worst = sign * f64::INFINITY;
        let (without, of_halves) = ([worst; REPLICAS], [[worst; 2]; 2]);
        Extreme { sign, whole: worst, without, of_halves, place: 0, error: 0.0 }
    }

    fn take(&mut self, map: &ReplicaMap, rare_scores: RareScores, number: usize, place: &PlaceReplicas) {
        let beyond = |value: f64, than: f64| self.sign * value < self.sign * than;
        let sum: f64 = place.replicas.iter().sum();
        for (without, value) in self.without.iter_mut().zip(&place.replicas) {
            let rest = (sum - value) / (REPLICAS - 1) as f64;
            *without = if beyond(rest, *without) { rest } else { *without };
        }
        let [even, odd] = half_means(|replica| place.replicas[replica]);
        for (best, half) in self.of_halves.iter_mut().zip([[even, odd], [odd, even]]) {
            *best = if beyond(half[0], best[0]) { half } else { *best };
        }
        let mean = place.mean();
        if beyond(mean, self.whole) {
            (self.whole, self.place, self.error) = (mean, number, place.error(map, rare_scores));
        }
    }

    /// Returns the distance by which chance may have pulled the extreme beyond the true value: docs/methods.md (43). It is 0 if both
    /// halves have the extreme at the same point.
    fn pulled(&self) -> f64 {
        let elsewhere = 0.5 * (self.of_halves[0][1] + self.of_halves[1][1]);
        (self.sign * (elsewhere - self.whole)).max(0.0) * FRAC_1_SQRT_2
    }

    /// Evaluates `of`, a quantity that depends on the extreme and on the replica left out (`None`: none), with its error. The error is the
    /// largest of the jackknife error, the point's own error times `per_unit`, and `least_error`. The distance by which chance may have
    /// pulled the extreme is added in quadrature.
    fn estimate(&self, of: impl Fn(f64, Option<usize>) -> f64, per_unit: f64, least_error: f64) -> Estimate {
        let spread = jackknife_error(|replica| of(self.without[replica], Some(replica)));
        let standard_error = spread.max(per_unit * self.error).max(least_error).hypot(per_unit * self.pulled());
        let value = of(self.whole, None);
        // An exact value has an error of 0, despite the rounding of the jackknife.
        Estimate {
            value,
            standard_error: if standard_error > ROUNDING_OF_SPREAD * value { standard_error } else { 0.0 },
        }
    }
}

/// Computes the table row of a part of a map.
///
/// The average is linear, so its error is the spread of the replicas' own averages. Minimum and maximum are the extremes of the unmodified
/// values, so that all tables, pictures and files agree. Noise pulls the extremes apart. A jackknife could correct this, but the random
/// error of the correction costs more than it gains: see docs/calibration.md, "Least values". Their errors include the distance by which
/// noise may have pulled.
///
/// Where no packet has met the minimum point, all replicas agree on it by chance. Its error is then the bound of that point, or the average
/// if this is smaller.
pub fn table_row(map: &ReplicaMap, subject: &TableSubject) -> TableRow {
    let weight_sum: f64 = subject.weights.iter().sum();
    let counted = || subject.entries.iter().zip(subject.weights).filter(|(_, weight)| **weight > 0.0);
    let shown = weight_sum - subject.covered_area_m2;
    let of_replica = |replica: usize| {
        counted().map(|(entry, weight)| weight * map.value(replica, *entry)).sum::<f64>() / shown.max(f64::MIN_POSITIVE)
    };
    let averages: Vec<f64> = if shown > 0.0 { (0..REPLICAS).map(of_replica).collect() } else { vec![0.0; REPLICAS] };
    let unseen = map.unseen_bound(counted().map(|(entry, _)| *entry));
    let mean = averages.iter().sum::<f64>() / REPLICAS as f64;
    // Walks give the error that the replicas of a half share through their cells, if they have measured it.
    let left = subject.average_left.unwrap_or(0.0);
    let spread = match subject.average_left {
        Some(_) => map.squared_error(|replica| averages[replica]).sqrt(),
        None => standard_error(|replica| averages[replica]),
    };
    let spread = Some(spread).filter(|spread| *spread > ROUNDING_OF_SPREAD * mean).unwrap_or(0.0);
    let average = Estimate { value: mean, standard_error: spread.hypot(left).max(unseen) };

    let (mut least, mut most) = (Extreme::new(1.0), Extreme::new(-1.0));
    let mut places = 0;
    let mut take = |number: usize, place: PlaceReplicas| {
        least.take(map, subject.rare_scores, number, &place);
        most.take(map, subject.rare_scores, number, &place);
        places += 1;
    };
    let cells: &[Vec<GridPart>] = match subject.places {
        Places::Entries => {
            counted().for_each(|(entry, _)| take(*entry, PlaceReplicas::of_entry(map, *entry)));
            &[]
        }
        Places::Grid { grid, discretisation_lx, slopes } => {
            let cells = grid.map_or(&[][..], |grid| grid.cells.as_slice());
            let all = cells.iter().enumerate();
            let cell = |number: usize, parts| PlaceReplicas::of_cell(map, parts, discretisation_lx, slopes.get(number));
            all.for_each(|(number, parts)| take(number, cell(number, parts)));
            cells
        }
    };
    let judgement = judge(map, counted().map(|(entry, weight)| (*entry, *weight)));
    let error_of_mean = if mean > 0.0 { average.standard_error / mean } else { 0.0 };
    let mut row = TableRow {
        name: subject.name.to_owned(),
        kind: subject.kind,
        side: subject.side,
        average,
        minimum: Estimate::default(),
        maximum: Estimate::default(),
        uniformity_u0: Estimate::default(),
        uniformity_ud: Estimate::default(),
        pulled: [least.pulled(), most.pulled()],
        places,
        area_m2: subject.area_m2 - subject.covered_area_m2,
        covered_area_m2: subject.covered_area_m2,
        // A mean of few elements that share chains may be less certain than the elements' own errors say.
        estimated_error: judgement.error_of_part().max(error_of_mean),
        replica_averages: averages,
    };
    if places == 0 {
        return row;
    }
    let bound = average.value.max(average.standard_error);
    let least_unseen = match subject.places {
        Places::Entries => map.unseen_bound(std::iter::once(least.place)),
        Places::Grid { .. } => map.unseen_bound(cells[least.place].iter().map(|part| part.element as usize)),
    };
    let least_unseen = least_unseen.min(bound);
    let without =
        |replica: usize| (average.value * REPLICAS as f64 - row.replica_averages[replica]) / (REPLICAS - 1) as f64;
    let average_of = |left_out: Option<usize>| left_out.map_or(average.value, without);
    let ratio = |part: f64, whole: f64| if whole > 0.0 { part / whole } else { 0.0 };
    let (per_average, per_most) = (ratio(1.0, average.value), ratio(1.0, most.whole));
    let share = |value: f64, left_out: Option<usize>| ratio(value, average_of(left_out)).clamp(0.0, 1.0);
    let u0 = least.estimate(share, per_average, (per_average * least_unseen).min(1.0));
    let ud_of = |value: f64, left_out: Option<usize>| {
        ratio(value, left_out.map_or(most.whole, |replica| most.without[replica])).clamp(0.0, 1.0)
    };
    let ud = least.estimate(ud_of, per_most, (per_most * least_unseen).min(1.0));
    // Contribution of the maximum to the ratio's error, beside that of the minimum.
    let of_most = ud.value * per_most * most.error.hypot(most.pulled());
    row.minimum = least.estimate(|value, _| value.clamp(0.0, average.value.max(0.0)), 1.0, least_unseen);
    row.maximum = most.estimate(|value, _| value.max(0.0), 1.0, 0.0);
    row.uniformity_u0 = Estimate { standard_error: u0.standard_error.hypot(u0.value * per_average * left), ..u0 };
    row.uniformity_ud = Estimate { standard_error: ud.standard_error.hypot(of_most), ..ud };
    row
}

/// Returns the standard error by the jackknife over the replicas.
fn jackknife_error(without: impl Fn(usize) -> f64) -> f64 {
    let n = REPLICAS as f64;
    let mean = (0..REPLICAS).map(&without).sum::<f64>() / n;
    let squares: f64 = (0..REPLICAS).map(|replica| (without(replica) - mean).powi(2)).sum();
    ((n - 1.0) / n * squares).sqrt()
}

#[cfg(test)]
mod tests {
    use super::super::replicas::Unit;
    use super::*;
    use crate::sampling::random::{Purpose, Stream};

    fn row(map: &ReplicaMap) -> TableRow {
        row_by(map, map.rare_scores(), None)
    }

    fn row_by(map: &ReplicaMap, rare_scores: RareScores, average_left: Option<f64>) -> TableRow {
        let entries: Vec<usize> = (0..map.len()).collect();
        let weights = vec![1.0; map.len()];
        let subject = TableSubject {
            name: "wall",
            kind: TableKind::Surface,
            side: "front",
            entries: &entries,
            weights: &weights,
            area_m2: map.len() as f64,
            covered_area_m2: 0.0,
            places: Places::Entries,
            rare_scores,
            average_left,
        };
        table_row(map, &subject)
    }

    /// Builds a map where 1,600 packets of 1 lm meet four elements of 1 m². Three elements have equal light; `met` is the number of packets
    /// of the first in each replica.
    fn counted(met: f64) -> ReplicaMap {
        let mut map = ReplicaMap::new(4, Unit::Packets { luminous_flux_lm: 1600.0, area_m2: vec![1.0; 4] });
        map.indirect_samples.complete = 100;
        map.direct_samples.complete = 1;
        for slab in &mut map.indirect {
            slab.copy_from_slice(&[met, 20.0, 20.0, 20.0]);
        }
        map
    }

    /// Where no packet has met an element, all replicas agree that it is dark, but this is not certain. The bound is that of three packets,
    /// here 3 lx. An element that all replicas met equally often has no error (the planted fault would bound it too).
    #[test]
    fn a_minimum_that_no_packet_has_met_is_not_exact() {
        let unmet = row(&counted(0.0));
        assert_eq!(unmet.minimum.value, 0.0);
        assert!((unmet.minimum.standard_error - 3.0).abs() < 1e-12, "{:?}", unmet.minimum);
        let share = 3.0 / unmet.average.value;
        assert!((unmet.uniformity_u0.standard_error - share).abs() < 1e-12, "{:?}", unmet.uniformity_u0);
        let met = row(&counted(1.0));
        assert!(met.minimum.value > 0.0, "{:?}", met.minimum);
        // Thirds are rounded, but count as exact.
        let rounded = row(&counted(1.0 / 3.0));
        assert_eq!([met, rounded].map(|row| [row.minimum, row.maximum].map(|lx| lx.standard_error)), [[0.0; 2]; 2]);
    }

    /// Returns the share of `maps` maps (seed 5) of 40 points whose stated interval of the minimum contains the minimum of their means. The
    /// interval is ±2.13 standard errors (Student's t of 15 degrees of freedom). In a replica two scores reach a point on average. Each
    /// brings the square of an exponential variable in lx, times the point's number. The second result, the planted fault, uses bars
    /// without the skewness of the scores.
    fn held_of_skewed(maps: u64) -> [f64; 2] {
        let mut stream = Stream::new(5, Purpose::Pilot, 0, 0);
        let mut held = [0.0; 2];
        for number in 0..maps {
            stream.seek(number);
            let mut exponential = || -(1.0 - stream.unit()).ln();
            let mut map = ReplicaMap::new(40, Unit::Scores);
            map.indirect_samples.complete = 1;
            for (entry, slab) in (0..40).flat_map(|entry| (0..REPLICAS).map(move |slab| (entry, slab))) {
                let mut time = exponential();
                while time < 2.0 {
                    map.indirect[slab][entry] += (1.0 + entry as f64) * exponential().powi(2);
                    time += exponential();
                }
            }
            for (held, rare_scores) in held.iter_mut().zip([map.rare_scores(), RareScores::default()]) {
                let least_lx = row_by(&map, rare_scores, None).minimum;
                *held += f64::from(u8::from((least_lx.value - 4.0).abs() <= 2.13 * least_lx.standard_error));
            }
        }
        held.map(|count| count / maps as f64)
    }

    /// At α = 10⁻⁴ a true share of at least 0.93 of 1,000 maps gives a measured share of at least 0.90.
    #[test]
    fn the_interval_of_a_minimum_of_skewed_scores_holds_by_bars_that_know_it() {
        let [held, forgetful] = held_of_skewed(1000);
        assert!(held > 0.90 && forgetful < 0.90, "{held} {forgetful}");
    }

    /// The minimum of a row and the row of its point state the same number with the same error.
    #[test]
    fn the_minimum_is_reported_as_its_point_is() {
        let mut map = ReplicaMap::new(4, Unit::Scores);
        map.indirect_samples.complete = 1;
        for (replica, slab) in map.indirect.iter_mut().enumerate() {
            let rare = f64::from(u8::from(replica % 5 == 0));
            slab.copy_from_slice(&[1.0 + 20.0 * rare, 60.0 + 20.0 * rare, 70.0 - rare, 80.0]);
        }
        let (values, row) = (map.values(), row(&map));
        assert_eq!(row.minimum.value, values.value[0]);
        assert!((row.minimum.standard_error / values.standard_error[0] - 1.0).abs() < 1e-12, "{row:?} {values:?}");
    }

    /// Returns the share of 1,000 maps (seed 3) whose stated interval contains the true minimum. The interval is ±1.96 standard errors
    /// times a factor. The 60 points start at 100 lx and increase by 1 lx each, with a random error of 4 lx in a replica.
    fn held(factor: f64) -> f64 {
        let mut stream = Stream::new(3, Purpose::Pilot, 0, 0);
        let is_held = |number: u64| {
            stream.seek(number);
            let mut map = ReplicaMap::new(60, Unit::Scores);
            map.direct_samples.complete = 1;
            for slab in &mut map.direct {
                for (entry, lx) in slab.iter_mut().enumerate() {
                    let normal = (0..12).map(|_| stream.unit()).sum::<f64>() - 6.0;
                    *lx = 100.0 + entry as f64 + 4.0 * normal;
                }
            }
            let least_lx = row(&map).minimum;
            f64::from(u8::from((least_lx.value - 100.0).abs() <= factor * 1.96 * least_lx.standard_error))
        };
        (0..1000).map(is_held).sum::<f64>() / 1000.0
    }

    /// At α = 10⁻⁴ a true share of at least 0.93 gives a measured share of at least 0.90. Bars of half the length are the planted fault.
    #[test]
    fn the_interval_of_a_minimum_holds_and_a_shorter_one_does_not() {
        let [held, shorter] = [held(1.0), held(0.5)];
        assert!(held > 0.90 && shorter < 0.90, "{held} {shorter}");
    }

    /// Returns the share of 500 maps (seed 8) whose stated interval of ±2.13 standard errors contains the true minimum. The 400 points are
    /// equally bright, with a random error of 4 lx in a replica. The second result, the planted fault, uses the bar of the minimum point
    /// alone.
    fn held_of_equals() -> [f64; 2] {
        let mut stream = Stream::new(8, Purpose::Pilot, 0, 0);
        let mut held = [0.0; 2];
        for number in 0..500 {
            stream.seek(number);
            let mut map = ReplicaMap::new(400, Unit::Scores);
            map.direct_samples.complete = 1;
            for lx in map.direct.iter_mut().flatten() {
                *lx = 100.0 + 4.0 * ((0..12).map(|_| stream.unit()).sum::<f64>() - 6.0);
            }
            let (least_lx, values) = (row(&map).minimum, map.values());
            let least = values.value.iter().position(|lx| *lx == least_lx.value).expect("a point");
            for (held, error_lx) in held.iter_mut().zip([least_lx.standard_error, values.standard_error[least]]) {
                *held += f64::from(u8::from((least_lx.value - 100.0).abs() <= 2.13 * error_lx));
            }
        }
        held.map(|count| count / 500.0)
    }

    /// At α = 10⁻⁴ a true share of 0.94 gives a measured share of at least 0.895.
    #[test]
    fn the_interval_of_a_minimum_knows_that_it_was_the_least_of_many() {
        let [held, of_the_point] = held_of_equals();
        assert!(held > 0.895 && of_the_point < 0.3, "{held} {of_the_point}");
    }

    /// Minimum and maximum are those of the unmodified values. Both have errors.
    #[test]
    fn extremes_are_those_of_the_values_themselves() {
        let mut map = ReplicaMap::new(3, Unit::Scores);
        map.direct_samples.complete = 1;
        for (replica, slab) in map.direct.iter_mut().enumerate() {
            let noise = if replica % 4 < 2 { 1.0 } else { -1.0 };
            slab.copy_from_slice(&[10.0 + noise, 10.5 - noise, 30.0 + noise]);
        }
        let row = row(&map);
        assert!((row.minimum.value - 10.0).abs() < 1e-12 && (row.maximum.value - 30.0).abs() < 1e-12);
        assert!((row.uniformity_ud.value - 1.0 / 3.0).abs() < 1e-12 && row.places == 3);
        assert!(row.maximum.standard_error > 0.2 && row.uniformity_ud.standard_error > 0.0, "{row:?}");
    }

    /// What cells leave unknown of a mean is part of the row's error, though all replicas agree.
    #[test]
    fn the_error_of_a_row_is_not_below_that_of_its_mean() {
        let row = row_by(&counted(20.0), RareScores::default(), Some(16.0));
        let of_mean = row.average.standard_error / row.average.value;
        assert!(of_mean > 0.02 && row.estimated_error >= of_mean, "{row:?}");
    }

    /// Light without random error differs between replicas only by rounding, which is not an error. A difference of one part in a million
    /// is an error.
    #[test]
    fn rounding_is_no_standard_error() {
        let lit = |last: f64| {
            let mut map = ReplicaMap::new(2, Unit::Scores);
            map.direct_samples.complete = 3;
            for (replica, slab) in map.direct.iter_mut().enumerate() {
                slab.copy_from_slice(&[0.3, 0.1 + if replica == 7 { last } else { 0.0 }]);
            }
            row(&map).average.standard_error
        };
        assert_eq!(lit(2e-17), 0.0);
        assert!(lit(1e-7) > 0.0);
    }
}
