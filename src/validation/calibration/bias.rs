//! Bias of each entry: the part of the deviation from the truth that is the same in all runs.

use super::FULL;
use crate::validation::statistics::ComparedEntry;

/// Maximum of an entry's mean deviation, as a share of the error that the entry states.
const SHARE_OF_STATED: f64 = 1.0 / 3.0;
/// Minimum share of the entries within that limit in a full campaign.
const MOST_ENTRIES: f64 = 0.99;
/// Margin in standard errors of the mean before an entry counts as beyond that limit.
const BEYOND: f64 = 4.0;

/// Sums over the runs of a campaign for each entry.
#[derive(Clone, Debug, Default)]
pub struct Biases {
    runs: usize,
    entries: Vec<BiasSums>,
}

#[derive(Clone, Copy, Debug, Default)]
struct BiasSums {
    deviation_lx: f64,
    squared_lx2: f64,
    stated_lx2: f64,
    truth_lx: f64,
}

impl BiasSums {
    fn mean_lx(&self, runs: usize) -> f64 {
        self.deviation_lx / runs as f64
    }

    /// Standard error of the mean deviation in lx, including the truth's own error.
    fn error_lx(&self, runs: usize) -> f64 {
        let count = runs.max(2) as f64;
        let variance = (self.squared_lx2 / count - self.mean_lx(runs).powi(2)).max(0.0) / (count - 1.0);
        variance.sqrt().hypot(self.truth_lx)
    }

    fn stated_lx(&self, runs: usize) -> f64 {
        (self.stated_lx2 / runs as f64).sqrt()
    }
}

impl Biases {
    /// Adds one run.
    pub(super) fn add(&mut self, entries: &[ComparedEntry]) {
        self.entries.resize(entries.len(), BiasSums::default());
        self.runs += 1;
        for (sums, entry) in self.entries.iter_mut().zip(entries) {
            sums.deviation_lx += entry.deviation();
            sums.squared_lx2 += entry.deviation().powi(2);
            sums.stated_lx2 += entry.standard_error.powi(2);
            sums.truth_lx = entry.allowance();
        }
    }

    fn noisy(&self) -> impl Iterator<Item = &BiasSums> {
        self.entries.iter().filter(|sums| sums.stated_lx2 > 0.0)
    }

    /// Share of the entries whose mean deviation is at most a third of their stated error.
    pub fn share_within(&self) -> f64 {
        let is_within = |sums: &&BiasSums| sums.mean_lx(self.runs).abs() <= SHARE_OF_STATED * sums.stated_lx(self.runs);
        self.noisy().filter(is_within).count() as f64 / self.noisy().count().max(1) as f64
    }

    /// Largest excess of a mean deviation over four of its own standard errors, relative to the error that the entry states. It is
    /// 0 if random errors explain all deviations.
    pub fn worst(&self) -> f64 {
        let beyond = |sums: &BiasSums| {
            (sums.mean_lx(self.runs).abs() - BEYOND * sums.error_lx(self.runs)) / sums.stated_lx(self.runs)
        };
        self.noisy().map(beyond).fold(0.0, f64::max)
    }

    /// Returns whether the bias is small compared with the stated errors. The share of entries only counts in a full campaign,
    /// since it is uncertain with few seeds.
    pub fn is_small(&self) -> bool {
        self.worst() <= SHARE_OF_STATED && (self.runs < FULL || self.share_within() >= MOST_ENTRIES)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::random::{Purpose, Stream};

    /// 300 runs of 100 entries with approximately normal errors of 1 lx (twelve uniform variates; seed 1). The first `off` entries
    /// have the bias `bias_lx`.
    fn biases(bias_lx: f64, off: usize) -> Biases {
        let mut stream = Stream::new(1, Purpose::Pilot, 0, 0);
        let mut biases = Biases::default();
        for run in 0..300 {
            stream.seek(run);
            let entries: Vec<ComparedEntry> = (0..100)
                .map(|i| {
                    let error: f64 = (0..12).map(|_| stream.unit() - 0.5).sum();
                    let bias_lx = if i < off { bias_lx } else { 0.0 };
                    ComparedEntry {
                        measured: error + bias_lx,
                        standard_error: 1.0,
                        weight: 1.0,
                        ..ComparedEntry::default()
                    }
                })
                .collect();
            biases.add(&entries);
        }
        biases
    }

    /// The mean of 300 runs has a standard error of 0.058 lx. A third of the stated error is 5.8 of these (α = 1e-8 per entry).
    #[test]
    fn a_bias_of_half_the_stated_error_at_two_entries_of_a_hundred_is_refused_and_none_is_not() {
        assert!(biases(0.0, 0).is_small());
        assert!(!biases(0.5, 2).is_small());
        assert!(!biases(0.8, 1).is_small());
    }
}
