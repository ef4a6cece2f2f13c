//! Bias entry by entry: what of the deviation from the truth is the same in all runs.

use super::FULL;
use crate::validation::statistics::ComparedEntry;

/// The mean deviation of an entry may be this share of the error that it states.
const SHARE_OF_STATED: f64 = 1.0 / 3.0;
/// Share of the entries for which that holds in a full campaign.
const MOST_ENTRIES: f64 = 0.99;
/// Standard errors of the mean by which no entry may exceed it.
const BEYOND: f64 = 4.0;

/// Sums over the runs of a campaign, entry by entry.
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

    /// Standard error of the mean deviation, the truth's own included.
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
            sums.deviation_lx += entry.deviation_lx();
            sums.squared_lx2 += entry.deviation_lx().powi(2);
            sums.stated_lx2 += entry.standard_error_lx.powi(2);
            sums.truth_lx = entry.allowance_lx();
        }
    }

    fn noisy(&self) -> impl Iterator<Item = &BiasSums> {
        self.entries.iter().filter(|sums| sums.stated_lx2 > 0.0)
    }

    /// Share of the entries whose mean deviation is at most a third of what they state.
    pub fn share_within(&self) -> f64 {
        let is_within = |sums: &&BiasSums| sums.mean_lx(self.runs).abs() <= SHARE_OF_STATED * sums.stated_lx(self.runs);
        self.noisy().filter(is_within).count() as f64 / self.noisy().count().max(1) as f64
    }

    /// Largest mean deviation, four of its own standard errors less, over the error that the entry states; 0 where chance
    /// explains all.
    pub fn worst(&self) -> f64 {
        let beyond = |sums: &BiasSums| {
            (sums.mean_lx(self.runs).abs() - BEYOND * sums.error_lx(self.runs)) / sums.stated_lx(self.runs)
        };
        self.noisy().map(beyond).fold(0.0, f64::max)
    }

    /// Whether bias is small beside what is stated; the share of entries tells little in a campaign of few seeds.
    pub fn is_small(&self) -> bool {
        self.worst() <= SHARE_OF_STATED && (self.runs < FULL || self.share_within() >= MOST_ENTRIES)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::random::{Purpose, Stream};

    /// 300 runs of 100 entries with errors of 1 lx, about normal (twelve uniform variates; seed 1), off by `bias_lx` in the
    /// first `off` of them.
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
                        measured_lx: error + bias_lx,
                        standard_error_lx: 1.0,
                        weight: 1.0,
                        ..ComparedEntry::default()
                    }
                })
                .collect();
            biases.add(&entries);
        }
        biases
    }

    /// The mean of 300 runs has an error of 0.058 lx: a third of what is stated is 5.8 of them (α = 1e-8 an entry).
    #[test]
    fn a_bias_of_half_the_stated_error_at_two_entries_of_a_hundred_is_refused_and_none_is_not() {
        assert!(biases(0.0, 0).is_small());
        assert!(!biases(0.5, 2).is_small());
        assert!(!biases(0.8, 1).is_small());
    }
}
