//! What single scores show of a map's variance: their spread, and the largest of them.
//!
//! Replicas show how a map scatters, but not whether its variance exists. A tail of rare large scores appears in them only after one such
//! score has come. The largest scores so far reveal the tail earlier. Every task keeps its own largest scores, which are merged after each
//! slice, so that chains share no data.

use std::f64::consts::FRAC_1_SQRT_2;
use std::ops::Range;

use serde::{Deserialize, Serialize};

use crate::base::pareto::pareto_shape;

/// Number of largest scores kept of a part of a map.
const LARGEST: usize = 1024;

/// Deviations of single scores from the level of their entry, each times the square root of the entry's weight: sums and the largest
/// values. The map's squared error is the sum of their squares divided by the square of the number of samples.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Scores {
    /// Number of scores counted.
    pub count: u64,
    /// Number of scores of single entries that these stand for. Neighbours that share walks score together.
    pub of_entries: u64,
    /// Sum of the squared deviations.
    pub squares: f64,
    /// Sum of the fourth powers of the deviations.
    pub fourths: f64,
    /// The largest deviations, plus at most as many newer ones that are not yet sorted out.
    largest: Vec<f64>,
    /// A deviation at or below this value is not among the largest.
    floor: f64,
}

impl Scores {
    /// Returns an empty set for a task that adds to `whole`. It does not keep values that cannot be among the largest of `whole`.
    pub fn for_task(whole: &Scores) -> Scores {
        Scores { floor: whole.floor, ..Scores::default() }
    }

    /// Adds a weighted deviation, 0 or more, of `entries` entries together.
    #[inline]
    pub fn add(&mut self, deviation: f64, entries: u64) {
        let square = deviation * deviation;
        self.count += 1;
        self.of_entries += entries;
        self.squares += square;
        self.fourths += square * square;
        if deviation > self.floor {
            self.keep(deviation);
        }
    }

    #[cold]
    fn keep(&mut self, deviation: f64) {
        self.largest.push(deviation);
        if self.largest.len() >= 2 * LARGEST {
            self.sort_out();
        }
    }

    fn sort_out(&mut self) {
        if self.largest.len() <= LARGEST {
            return;
        }
        let (_, least, _) = self.largest.select_nth_unstable_by(LARGEST - 1, |one, other| other.total_cmp(one));
        self.floor = *least;
        self.largest.truncate(LARGEST);
    }

    /// Adds what a task has counted.
    pub fn merge(&mut self, task: Scores) {
        self.count += task.count;
        self.of_entries += task.of_entries;
        self.squares += task.squares;
        self.fourths += task.fourths;
        self.largest.extend(task.largest);
        if self.largest.len() >= 2 * LARGEST {
            self.sort_out();
        }
    }

    /// Returns the same set with every deviation multiplied by `factor`.
    fn scaled(self, factor: f64) -> Scores {
        let square = factor * factor;
        Scores {
            count: self.count,
            of_entries: self.of_entries,
            squares: square * self.squares,
            fourths: square * square * self.fourths,
            largest: self.largest.into_iter().map(|deviation| factor * deviation).collect(),
            floor: factor * self.floor,
        }
    }

    /// Returns what the scores show of a part of a map with `samples` samples of every entry and `all` scores in total.
    pub fn evidence(&self, samples: f64, all: f64) -> ScoreEvidence {
        let mut largest = self.largest.clone();
        largest.sort_by(|one, other| other.total_cmp(one));
        // The largest scores follow a generalised Pareto distribution only in the limit. At most three square roots of their number are
        // used (Vehtari et al. 2024, "Pareto smoothed importance sampling"). At most the scores of one entry are used, because entries
        // differ in size.
        let most = (3.0 * (self.count as f64).sqrt()).min(samples) as usize;
        let tail = LARGEST.min(largest.len()).min(most).saturating_sub(1);
        let threshold = largest.get(tail).copied().unwrap_or(0.0);
        let excesses: Vec<f64> = largest[..tail].iter().map(|score| score - threshold).collect();
        // The counted scores stand for all scores.
        let scale = if self.of_entries > 0 { all / self.of_entries as f64 } else { 0.0 };
        let squared_samples = (samples * samples).max(f64::MIN_POSITIVE);
        ScoreEvidence {
            weighted_variance: scale * self.squares / squared_samples,
            fourth: scale * self.fourths / (squared_samples * squared_samples),
            tail,
            tail_variance: largest[..tail].iter().map(|score| score * score).sum::<f64>() / squared_samples,
            shape: pareto_shape(&excesses),
        }
    }
}

/// What the scores show of a part of a map.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ScoreEvidence {
    /// Contribution of the part to the map's squared error, times the sum of weights, in the square of the map's unit times that of weights.
    pub weighted_variance: f64,
    /// Sum of the squares of single scores' contributions to `weighted_variance`.
    pub fourth: f64,
    /// Number of largest scores from which the tail is estimated.
    pub tail: usize,
    /// Contribution of these scores to `weighted_variance`.
    pub tail_variance: f64,
    /// Shape of the tail: 0 exponential, from ½ on of infinite variance. `None` if too few scores, or no differing scores, give it,
    /// and for counted packets, whose tail is bounded.
    pub shape: Option<f64>,
}

/// Scores of a part of a map, sorted by what they deviate from.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct PartScores {
    /// Deviations from the entry's level. They are used if they are at least as many as `stepped`.
    levelled: Scores,
    /// Deviations from the previous score, divided by √2, as long as the entry has no level.
    stepped: Scores,
}

impl PartScores {
    /// Returns an empty set for a task that adds to `whole`.
    pub fn for_task(whole: &PartScores) -> PartScores {
        PartScores { levelled: Scores::for_task(&whole.levelled), stepped: Scores::for_task(&whole.stepped) }
    }

    /// Adds what a task has counted.
    pub fn merge(&mut self, task: PartScores) {
        self.levelled.merge(task.levelled);
        self.stepped.merge(task.stepped);
    }

    /// Returns the same set with every deviation multiplied by `factor`.
    pub fn scaled(self, factor: f64) -> PartScores {
        PartScores { levelled: self.levelled.scaled(factor), stepped: self.stepped.scaled(factor) }
    }

    /// Adds a weighted score as its own deviation, with level 0.
    #[inline]
    pub fn add(&mut self, score: f64) {
        self.levelled.add(score, 1);
    }

    /// Returns a counter for the scores of an entry with this weight and level.
    #[inline]
    pub fn of_entry(&mut self, weight: f64, level: Option<f64>) -> EntryScores<'_> {
        let (scores, root_weight) = match level {
            Some(_) => (&mut self.levelled, weight.max(0.0).sqrt()),
            None => (&mut self.stepped, weight.max(0.0).sqrt() * FRAC_1_SQRT_2),
        };
        EntryScores { scores, root_weight, moves: level.is_none(), level: level.unwrap_or(f64::NAN) }
    }

    /// Returns a counter for the scores of entries that score together, with these weights and levels. If one entry has no level, none is
    /// taken to have one.
    pub fn of_group(&mut self, entries: impl Iterator<Item = (f64, Option<f64>)>) -> GroupScores<'_> {
        let mut group: Vec<(f64, f64)> = Vec::new();
        let mut moves = false;
        for (weight, level) in entries {
            moves |= level.is_none();
            group.push((weight.max(0.0).sqrt(), level.unwrap_or(f64::NAN)));
        }
        if moves {
            group
                .iter_mut()
                .for_each(|(root_weight, level)| (*root_weight, *level) = (*root_weight * FRAC_1_SQRT_2, f64::NAN));
        }
        GroupScores { scores: if moves { &mut self.stepped } else { &mut self.levelled }, entries: group, moves }
    }

    /// Returns what the scores show: see [`Scores::evidence`].
    pub fn evidence(&self, samples: f64, all: f64) -> ScoreEvidence {
        let chosen = if self.levelled.count >= self.stepped.count { &self.levelled } else { &self.stepped };
        chosen.evidence(samples, all)
    }
}

/// Counter for the scores of one entry.
pub struct EntryScores<'a> {
    scores: &'a mut Scores,
    root_weight: f64,
    moves: bool,
    level: f64,
}

impl EntryScores<'_> {
    /// Adds a score.
    #[inline]
    pub fn add(&mut self, score: f64) {
        if !self.level.is_nan() {
            self.scores.add(self.root_weight * (score - self.level).abs(), 1);
        }
        if self.moves {
            self.level = score;
        }
    }
}

/// Counter for a group of entries that score together from the same samples. The group counts as one score: the square root of the sum of
/// the squared deviations.
pub struct GroupScores<'a> {
    scores: &'a mut Scores,
    /// Square root of each entry's weight, and its level.
    entries: Vec<(f64, f64)>,
    moves: bool,
}

impl GroupScores<'_> {
    /// Adds one score of every entry.
    pub fn add(&mut self, scores: &[f64]) {
        let deviations =
            self.entries.iter().zip(scores).map(|((root_weight, level), score)| root_weight * (score - level));
        let square: f64 = deviations.map(|deviation| deviation * deviation).sum();
        if !square.is_nan() {
            self.scores.add(square.sqrt(), self.entries.len() as u64);
        }
        if self.moves {
            self.entries.iter_mut().zip(scores).for_each(|((_, level), score)| *level = *score);
        }
    }
}

/// Levels from which the scores of a map's entries deviate: the mean of an entry's first samples. They stay fixed. Moving levels would mix
/// distributions of different widths, which looks like a tail.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Levels {
    values: Vec<f64>,
}

impl Levels {
    /// Sets the levels of those `entries` (out of `count`) that have none yet. `mean` returns `None` for an entry without samples; this
    /// entry keeps no level.
    pub fn fix(&mut self, entries: Range<usize>, count: usize, mean: impl Fn(usize) -> Option<f64>) {
        if self.values.len() < entries.end {
            self.values.reserve_exact(count.saturating_sub(self.values.len()));
            self.values.resize(entries.end, f64::NAN);
        }
        for entry in entries {
            if self.values[entry].is_nan() {
                self.values[entry] = mean(entry).unwrap_or(f64::NAN);
            }
        }
    }

    /// Returns the level of an entry, once it has one.
    #[inline]
    pub fn of(&self, entry: usize) -> Option<f64> {
        self.values.get(entry).copied().filter(|level| !level.is_nan())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_largest_are_kept_however_the_work_is_shared_out() {
        let scores: Vec<f64> = (0..10_000u64).map(|n| (n * 7919 % 10_007) as f64).collect();
        let mut in_one = Scores::default();
        scores.iter().for_each(|score| in_one.add(*score, 1));
        let mut in_parts = Scores::default();
        for part in scores.chunks(777) {
            let mut task = Scores::for_task(&in_parts);
            part.iter().for_each(|score| task.add(*score, 1));
            in_parts.merge(task);
        }
        let (one, other) = (in_one.evidence(1e4, 1e4), in_parts.evidence(1e4, 1e4));
        assert_eq!((in_one.count, one.tail, one.shape), (in_parts.count, other.tail, other.shape));
        assert_eq!((one.tail_variance, one.weighted_variance), (other.tail_variance, other.weighted_variance));
        let mut sorted = scores.clone();
        sorted.sort_by(|a, b| b.total_cmp(a));
        let exact: f64 = sorted[..one.tail].iter().map(|score| score * score).sum();
        assert!((1e8 * one.tail_variance / exact - 1.0).abs() < 1e-12);
        assert!(one.shape.is_some_and(|shape| shape < -0.5), "a uniform tail has an end: {:?}", one.shape);
    }

    #[test]
    fn entries_that_score_together_say_as_much_of_the_variance_in_fewer_scores() {
        // Four entries, 1,000 samples of a level of 1 with one deviation for all: a quarter of the scores, the same squared error.
        let deviation = |sample: u64| 0.1 * (sample % 7) as f64;
        let (mut apart, mut together) = (PartScores::default(), PartScores::default());
        for sample in 0..1000 {
            for _ in 0..4 {
                apart.of_entry(2.0, Some(1.0)).add(1.0 + deviation(sample));
            }
            together.of_group((0..4).map(|_| (2.0, Some(1.0)))).add(&[1.0 + deviation(sample); 4]);
        }
        let effective = |evidence: ScoreEvidence| evidence.weighted_variance.powi(2) / evidence.fourth;
        let [apart, together] = [apart, together].map(|scores| scores.evidence(1000.0, 4000.0));
        assert!((together.weighted_variance / apart.weighted_variance - 1.0).abs() < 1e-12);
        assert!((effective(apart) / effective(together) - 4.0).abs() < 1e-9);
        // Without a level the group waits for a first score. Equal samples then have a deviation of 0.
        let mut scores = PartScores::default();
        let mut group = scores.of_group([(1.0, None), (1.0, Some(2.0))].into_iter());
        (0..3).for_each(|_| group.add(&[3.0, 4.0]));
        let evidence = scores.evidence(3.0, 6.0);
        assert_eq!((evidence.weighted_variance, scores.stepped.count, scores.stepped.of_entries), (0.0, 2, 4));
    }

    #[test]
    fn constant_scores_have_no_tail() {
        let mut scores = PartScores::default();
        let mut entry = scores.of_entry(2.0, None);
        (0..5000).for_each(|_| entry.add(3.0));
        let evidence = scores.evidence(5000.0, 5000.0);
        assert_eq!((evidence.weighted_variance, evidence.shape), (0.0, None));
    }
}
