//! What residual walks measure of the error of a map's cells, at each of three scales, and what remains of it after correction.
//!
//! For single entries, the first step of a walk and its later steps are separate scales. The first step measures the error of the cells that
//! the entry's own rays look up. Later steps measure the error of cells that are looked up from all over the room. Their sum differs little
//! from one entry of a region to the next, but in bright rooms, where walks have many steps, it scatters most. Where walks do not show how
//! small this difference is, it is taken as a share of the first step's error: docs/methods.md (52).

use serde::{Deserialize, Serialize};

use super::REPLICAS;

/// Standard errors of the squared bias that are added to it in the stated error.
pub(super) const SURE: f64 = 0.5;

/// Number of standard errors at which a plan takes half of a squared error as real.
const TO_BELIEVE: f64 = 2.0;

/// Scales of the cells' error beside the mean over the map: regions, and for single entries the first step of walks and all later steps.
pub type OfScales = [f64; 3];
const REGIONS: usize = 0;
const FIRST_STEP: usize = 1;
const LATER_STEPS: usize = 2;

/// Squared error of single entries by later steps, as a share of that by the first step, where walks do not measure it better. Its standard
/// deviation is taken to be as large.
const LATER_OF_FIRST: f64 = 0.25;

/// What walks measure of the error of a map's cells. All values are in lx², averaged over the map; arrays hold the scales of regions, of
/// first steps and of later steps.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ResidualState {
    /// Squared bias that both halves share. It can be negative by chance.
    pub common: OfScales,
    /// Squared random error of the cells, for the mean of both halves. It can be negative by chance.
    pub chance: OfScales,
    /// Standard error of the sum of `common` and `chance`.
    pub standard_error: OfScales,
    /// Variance of the walks' result in one replica.
    pub variance: OfScales,
    /// Variance of a replica's correction, averaged over the entries.
    pub correction_variance: f64,
    /// Share of the entries without walks, by weight.
    pub silent_share: f64,
}

/// Remaining squared error of the cells, in lx².
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub struct RemainingError {
    /// Part that both halves share, with its uncertainty. It is stated as bias.
    pub common: f64,
    /// Random part, which the difference of the halves shows.
    pub chance: f64,
}

/// Squared error of one scale in lx².
#[derive(Clone, Copy)]
struct ScaleSquares {
    /// The whole, and the random part of the cells.
    both: f64,
    chance: f64,
    /// Standard error of the whole.
    standard_error: f64,
}

impl ResidualState {
    /// Returns the squared error of a scale, as walks measure it and, for later steps, as the first step lets expect it. It can be negative
    /// by chance.
    fn of_scale(&self, scale: usize) -> ScaleSquares {
        let measured = self.measured(scale);
        if scale != LATER_STEPS {
            return measured;
        }
        // docs/methods.md (52)
        let first = self.measured(FIRST_STEP);
        let expected = LATER_OF_FIRST * (first.both.max(0.0) + first.standard_error);
        let variance = expected * expected + measured.standard_error * measured.standard_error;
        if variance <= 0.0 {
            return measured;
        }
        let of_walks = expected * expected / variance;
        ScaleSquares {
            both: of_walks * measured.both + (1.0 - of_walks) * expected,
            chance: of_walks * measured.chance,
            standard_error: expected * measured.standard_error / variance.sqrt(),
        }
    }

    /// Returns the squared error of a scale as walks measure it.
    fn measured(&self, scale: usize) -> ScaleSquares {
        let (common, chance) = (self.common[scale], self.chance[scale]);
        ScaleSquares { both: common + chance, chance, standard_error: self.standard_error[scale] }
    }

    /// Returns the share of each scale that is corrected.
    fn shares(&self) -> OfScales {
        std::array::from_fn(|scale| {
            let squared = self.of_scale(scale).both.max(0.0);
            let all = squared + self.variance[scale] / REPLICAS as f64;
            if all > 0.0 { squared / all } else { 0.0 }
        })
    }

    /// Returns the share of the entries, by weight, that have no walks of their own at a scale.
    fn silent_at(&self, scale: usize) -> f64 {
        if scale == REGIONS { 0.0 } else { self.silent_share }
    }

    /// Returns the state for cells with `times` as many samples: their squared random error falls as 1/`times`, their squared bias as
    /// 1/√`times`.
    fn with_samples(self, times: f64) -> ResidualState {
        ResidualState {
            common: self.common.map(|common| common / times.sqrt()),
            chance: self.chance.map(|chance| chance / times),
            ..self
        }
    }

    /// Returns what is expected to be measured with `walks` times as many walks and `samples` times as many samples of the cells. Of each
    /// squared error, the part that is significant against its standard error is real and stays. The rest is chance of the walks so far, of
    /// which 1/`walks` remains.
    pub fn expected(self, walks: f64, samples: f64) -> ResidualState {
        let kept: OfScales = std::array::from_fn(|scale| {
            let squared = self.measured(scale).both;
            let error = TO_BELIEVE * self.standard_error[scale];
            let real = if squared > 0.0 { squared * squared / (squared * squared + error * error) } else { 0.0 };
            real + (1.0 - real) / walks
        });
        let scaled = |of: OfScales| std::array::from_fn(|scale| kept[scale] * of[scale]);
        let standard_error = self.standard_error.map(|error| error / walks);
        let variance = self.variance.map(|variance| variance / walks);
        ResidualState { common: scaled(self.common), chance: scaled(self.chance), standard_error, variance, ..self }
            .with_samples(samples)
    }

    /// Returns the remaining error after the correction by walks.
    pub fn remaining_lx2(&self) -> RemainingError {
        self.remaining_by(self.shares(), SURE)
    }

    /// Returns the remaining error after correction by these shares. `sure` standard errors are added to the measured values.
    pub(super) fn remaining_by(&self, shares: OfScales, sure: f64) -> RemainingError {
        let (mut both, mut chance, mut variance) = (0.0, 0.0, 0.0);
        for (scale, share) in shares.into_iter().enumerate() {
            let silent = self.silent_at(scale);
            let kept = (1.0 - silent) * (1.0 - share).powi(2) + silent;
            let squares = self.of_scale(scale);
            both += kept * squares.both;
            chance += kept * squares.chance;
            variance += (kept * squares.standard_error).powi(2);
        }
        let both = f64::max(both, 0.0);
        let chance = chance.clamp(0.0, both);
        RemainingError { common: both - chance + sure * variance.sqrt(), chance }
    }

    /// Returns the variance of the correction in one replica, apart from that of the map's mean. Where cells have little error, little of
    /// it is corrected.
    pub fn correction_lx2(&self) -> f64 {
        let corrected = self.shares().into_iter().zip(self.variance).enumerate();
        corrected.map(|(scale, (share, variance))| (1.0 - self.silent_at(scale)) * share.powi(2) * variance).sum()
    }

    /// Returns the state that would result if all entries had walks, the same number each.
    pub fn over_all(self) -> ResidualState {
        let had = 1.0 - self.silent_share;
        let mut variance = self.variance;
        variance[REGIONS] *= had;
        let standard_error = self.standard_error.map(|error| error * had.sqrt());
        ResidualState { standard_error, variance, silent_share: 0.0, ..self }
    }
}
