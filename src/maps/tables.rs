//! Result tables: average, minimum, maximum and uniformities with their errors.

use super::replicas::{REPLICAS, ReplicaMap, standard_error};
use super::{Estimate, TableKind, TableRow, judge};

/// Spread of replicas over their mean that is rounding, not chance: sums of thousands of entries agree to some units of
/// the last of 53 bits.
const ROUNDING: f64 = 1e-14;

/// Which entries of a map make one row, and how it is called.
pub struct TableSubject<'a> {
    /// Surface or receiver set.
    pub name: &'a str,
    /// What it is.
    pub kind: TableKind,
    /// `front` or `back`.
    pub side: &'static str,
    /// Entries of the map.
    pub entries: &'a [usize],
    /// Weight of each of these entries; 0 leaves it out.
    pub weights: &'a [f64],
    /// Area in m² that the row stands for.
    pub area_m2: f64,
}

/// Sums up a part of a map.
///
/// The average is linear, so its error is the spread of the replicas' own averages. Minimum and U0 are not: noise
/// pulls a minimum down. They are judged by the jackknife, which leaves out one replica at a time and takes the bias off
/// to first order; the result is kept between 0 and the average, where every minimum lies. Where the least entry is one
/// that no packet has met, all replicas agree on it by chance: the bound of that entry, or the average, is its error then.
pub fn table_row(map: &ReplicaMap, subject: &TableSubject) -> TableRow {
    let weight_sum: f64 = subject.weights.iter().sum();
    let counted = || subject.entries.iter().zip(subject.weights).filter(|(_, weight)| **weight > 0.0);
    let average = |replica: usize| {
        counted().map(|(entry, weight)| weight * map.illuminance_lx(replica, *entry)).sum::<f64>()
            / weight_sum.max(f64::MIN_POSITIVE)
    };
    let averages: Vec<f64> = (0..REPLICAS).map(average).collect();
    let unseen_lx = map.unseen_bound_lx(counted().map(|(entry, _)| *entry));
    let mean_lx = averages.iter().sum::<f64>() / REPLICAS as f64;
    let spread_lx = Some(standard_error(|replica| averages[replica])).filter(|spread| *spread > ROUNDING * mean_lx);
    let average_lx = Estimate { value: mean_lx, standard_error: spread_lx.unwrap_or(0.0).max(unseen_lx) };
    // The minimum of the mean over all replicas, and of the means that leave one replica out.
    let mut minima = [f64::INFINITY; REPLICAS + 1];
    let mut maximum_lx = 0.0f64;
    let mut least = None;
    for (entry, _) in counted() {
        let replicas: [f64; REPLICAS] = std::array::from_fn(|replica| map.illuminance_lx(replica, *entry));
        let sum: f64 = replicas.iter().sum();
        maximum_lx = maximum_lx.max(sum / REPLICAS as f64);
        for (replica, value) in replicas.iter().enumerate() {
            minima[replica] = minima[replica].min((sum - value) / (REPLICAS - 1) as f64);
        }
        if sum / (REPLICAS as f64) < minima[REPLICAS] {
            minima[REPLICAS] = sum / REPLICAS as f64;
            least = Some(*entry);
        }
    }
    if weight_sum <= 0.0 {
        minima = [0.0; REPLICAS + 1];
    }
    let without = |replica: usize| (average_lx.value * REPLICAS as f64 - averages[replica]) / (REPLICAS - 1) as f64;
    let ratio = |minimum: f64, average: f64| if average > 0.0 { minimum / average } else { 0.0 };
    let mut minimum_lx = jackknife(minima[REPLICAS], average_lx.value, |replica| minima[replica]);
    let mut uniformity_u0 =
        jackknife(ratio(minima[REPLICAS], average_lx.value), 1.0, |replica| ratio(minima[replica], without(replica)));
    let most_lx = average_lx.value.max(average_lx.standard_error);
    let least_unseen_lx = map.unseen_bound_lx(least.into_iter()).min(most_lx);
    minimum_lx.standard_error = minimum_lx.standard_error.max(least_unseen_lx);
    uniformity_u0.standard_error = uniformity_u0.standard_error.max(ratio(least_unseen_lx, average_lx.value).min(1.0));
    let judgement = judge(map, counted().map(|(entry, weight)| (*entry, *weight)));
    TableRow {
        name: subject.name.to_owned(),
        kind: subject.kind,
        side: subject.side,
        average_lx,
        minimum_lx,
        maximum_lx,
        uniformity_u0,
        uniformity_ud: ratio(minimum_lx.value, maximum_lx),
        area_m2: subject.area_m2,
        estimated_error: judgement.halves_error,
        replica_averages_lx: averages,
    }
}

/// Jackknife over the replicas: the value less its first-order bias, kept from 0 to `most`, and its standard error.
fn jackknife(whole: f64, most: f64, without: impl Fn(usize) -> f64) -> Estimate {
    let n = REPLICAS as f64;
    let mean = (0..REPLICAS).map(&without).sum::<f64>() / n;
    let squares: f64 = (0..REPLICAS).map(|replica| (without(replica) - mean).powi(2)).sum();
    Estimate {
        value: (n * whole - (n - 1.0) * mean).clamp(0.0, most.max(0.0)),
        standard_error: ((n - 1.0) / n * squares).sqrt(),
    }
}

#[cfg(test)]
mod tests {
    use super::super::replicas::Unit;
    use super::*;

    fn row(map: &ReplicaMap) -> TableRow {
        let entries: Vec<usize> = (0..map.len()).collect();
        let weights = vec![1.0; map.len()];
        let subject = TableSubject {
            name: "wall",
            kind: TableKind::Surface,
            side: "front",
            entries: &entries,
            weights: &weights,
            area_m2: map.len() as f64,
        };
        table_row(map, &subject)
    }

    /// 1,600 packets of 1 lm on average met three of four elements of 1 m² of equal light; `met` says how often the first.
    fn counted(met: f64) -> ReplicaMap {
        let mut map = ReplicaMap::new(4, Unit::Packets { luminous_flux_lm: 1600.0, area_m2: vec![1.0; 4] });
        map.indirect_samples.complete = 100;
        map.direct_samples.complete = 1;
        for slab in &mut map.indirect {
            slab.copy_from_slice(&[met, 20.0, 20.0, 20.0]);
        }
        map
    }

    /// All replicas agree that an element is dark where no packet has met it: that is no certainty. The bound is that of
    /// three packets, 3 lx here. One that they all met as often has no error (the planted fault would be to bound it too).
    #[test]
    fn a_minimum_that_no_packet_has_met_is_not_exact() {
        let unmet = row(&counted(0.0));
        assert_eq!(unmet.minimum_lx.value, 0.0);
        assert!((unmet.minimum_lx.standard_error - 3.0).abs() < 1e-12, "{:?}", unmet.minimum_lx);
        let share = 3.0 / unmet.average_lx.value;
        assert!((unmet.uniformity_u0.standard_error - share).abs() < 1e-12, "{:?}", unmet.uniformity_u0);
        let met = row(&counted(1.0));
        assert!(met.minimum_lx.value > 0.0 && met.minimum_lx.standard_error < 1e-9, "{:?}", met.minimum_lx);
    }

    /// Light without chance differs between replicas by rounding alone, which is no error; a part in a million is one.
    #[test]
    fn rounding_is_no_standard_error() {
        let lit = |last: f64| {
            let mut map = ReplicaMap::new(2, Unit::Lux);
            map.direct_samples.complete = 3;
            for (replica, slab) in map.direct.iter_mut().enumerate() {
                slab.copy_from_slice(&[0.3, 0.1 + if replica == 7 { last } else { 0.0 }]);
            }
            row(&map).average_lx.standard_error
        };
        assert_eq!(lit(2e-17), 0.0);
        assert!(lit(1e-7) > 0.0);
    }
}
