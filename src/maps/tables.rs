//! Result tables: average, minimum, maximum and uniformities with their errors.

use super::replicas::{REPLICAS, ReplicaMap, standard_error};
use super::{Estimate, TableKind, TableRow, judge};

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
/// to first order; the result is kept between 0 and the average, where every minimum lies.
pub fn table_row(map: &ReplicaMap, subject: &TableSubject) -> TableRow {
    let weight_sum: f64 = subject.weights.iter().sum();
    let counted = || subject.entries.iter().zip(subject.weights).filter(|(_, weight)| **weight > 0.0);
    let average = |replica: usize| {
        counted().map(|(entry, weight)| weight * map.illuminance_lx(replica, *entry)).sum::<f64>()
            / weight_sum.max(f64::MIN_POSITIVE)
    };
    let averages: Vec<f64> = (0..REPLICAS).map(average).collect();
    let unseen_lx = map.unseen_bound_lx(counted().map(|(entry, _)| *entry));
    let average_lx = Estimate {
        value: averages.iter().sum::<f64>() / REPLICAS as f64,
        standard_error: standard_error(|replica| averages[replica]).max(unseen_lx),
    };
    // The minimum of the mean over all replicas, and of the means that leave one replica out.
    let mut minima = [f64::INFINITY; REPLICAS + 1];
    let mut maximum_lx = 0.0f64;
    for (entry, _) in counted() {
        let replicas: [f64; REPLICAS] = std::array::from_fn(|replica| map.illuminance_lx(replica, *entry));
        let sum: f64 = replicas.iter().sum();
        maximum_lx = maximum_lx.max(sum / REPLICAS as f64);
        for (replica, value) in replicas.iter().enumerate() {
            minima[replica] = minima[replica].min((sum - value) / (REPLICAS - 1) as f64);
        }
        minima[REPLICAS] = minima[REPLICAS].min(sum / REPLICAS as f64);
    }
    if weight_sum <= 0.0 {
        minima = [0.0; REPLICAS + 1];
    }
    let without = |replica: usize| (average_lx.value * REPLICAS as f64 - averages[replica]) / (REPLICAS - 1) as f64;
    let ratio = |minimum: f64, average: f64| if average > 0.0 { minimum / average } else { 0.0 };
    let minimum_lx = jackknife(minima[REPLICAS], average_lx.value, |replica| minima[replica]);
    let uniformity_u0 =
        jackknife(ratio(minima[REPLICAS], average_lx.value), 1.0, |replica| ratio(minima[replica], without(replica)));
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
