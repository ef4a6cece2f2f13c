//! Statistical checks of a map before a run may claim its target. They follow the checks that transport codes print with every tally.
//!
//! The stop rule trusts the spread of the replicas. That spread is worthless in three cases: the scores have no variance, few scores carry
//! all of it, or samples repeat. Each check detects one of these.

use statrs::distribution::{ContinuousCDF, StudentsT};

use super::needed_work;
use super::stop::fisher_quantile;
use crate::maps::{History, Judgement, PastJudgement, REPLICAS, ScoreEvidence, StatisticalCheck};

/// Approximate probability that a sound run fails a single comparison. There are four comparisons.
const ALPHA: f64 = 5e-5;
/// Factor by which squared error times work may grow beyond chance. Direct light advances in whole passes, and quasi-random points in
/// rounds.
const ALLOWED_GROWTH: f64 = 1.5;
/// Shares of the work at which the past is compared with the present, and the range that counts as near each share.
const HALF: (f64, [f64; 2]) = (0.5, [0.3, 0.75]);
const QUARTER: (f64, [f64; 2]) = (0.25, [0.05, 0.35]);
/// Share of the degrees of freedom that is relied on, since they are themselves estimated.
const SURE_DEGREES: f64 = 0.5;
/// Tails of at least this shape have no variance.
const INFINITE_VARIANCE: f64 = 0.5;
/// A tail counts as infinite from this many standard errors below that shape on. This detects over 95% of the infinite ones.
const SAFE_SIDE: f64 = 2.4;
/// Least number of the largest scores from which a tail can be judged.
const LEAST_TAIL: usize = 200;
/// Greatest value that a check reports.
const MOST_REPORTED: f64 = 1e9;
/// A tail with less than this share of the variance does not matter yet, whatever its shape. If scores fall off with shape ⅔, twice the
/// samples raise its estimate of the squared error by 2^⅓ − 1 of that share. This is less than a tenth.
const LEAST_TAIL_SHARE: f64 = 0.25;
/// Multiple of its squared error from which on scores without variance do not matter, if the map tolerates it. Sums of these scores lie
/// within three times the spread of their parts, nine times in ten at a shape of ⅔, since the largest scores make that spread.
const SPARE_FOR_TAILS: f64 = 9.0;
/// Scores that must effectively carry the variance of a map that only just meets its target. Single scores then make the variance no more
/// uncertain than the replicas do in a map of three degrees of freedom, √(2/45).
pub(super) const ENOUGH_SCORES: f64 = 20.0;
/// A map that was held up for few scores alone passes at this multiple of its samples at that time. What still carries the variance is then
/// a score so rare that the spread errs on the safe side.
pub(super) const LONGEST_WAIT: u64 = 4;
/// Relative deviations below this are rounding errors of sums.
const ONLY_ROUNDING: f64 = 1e-9;

/// Judges a map. `parts` holds the evidence from the scores of direct and of indirect light. `held_since` is the number of samples at which
/// a check first held the map up. `target_error` is the target of the run, if any, as a fraction of the mean.
pub fn statistical_checks(
    history: &History,
    parts: [ScoreEvidence; 2],
    judgement: &Judgement,
    held_since: Option<u64>,
    target_error: Option<f64>,
) -> Vec<StatisticalCheck> {
    let is_judged = judgement.mean > 0.0 && !judgement.dark && !judgement.unseen;
    let Some(now) = history.last().filter(|_| is_judged) else {
        return Vec::new();
    };
    let past = |(share, between)| history.at_share(share, between);
    let rounding = ONLY_ROUNDING * judgement.mean;
    // How many times its squared error the map could tolerate, margin included.
    let spare = target_error.map_or(1.0, |target| 1.0 / needed_work(target, judgement, 0.5)).max(1.0);
    let has_waited = held_since.is_some_and(|samples| now.samples >= LONGEST_WAIT * samples);
    vec![
        mean_check(now, [past(HALF), past(QUARTER)], rounding),
        growth_check("error", now, past(QUARTER), |look| look.samples as f64, rounding),
        growth_check("figure of merit", now, past(HALF), |look| look.rays as f64, rounding),
        tail_check(parts, spare),
        scores_check(parts, spare, has_waited),
    ]
}

fn check(name: &'static str, value: Option<f64>, limit: f64, passed: bool, explanation: &str) -> StatisticalCheck {
    // Any error exceeds that of an earlier look that had no error at all, so the ratio is capped.
    let value = value.map(|value| value.min(MOST_REPORTED));
    StatisticalCheck { name, passed, value, limit, explanation: explanation.to_owned() }
}

/// The mean settles: the samples after a look must agree with those before it, by Student's t over the replicas.
fn mean_check(now: &PastJudgement, past: [Option<&PastJudgement>; 2], rounding: f64) -> StatisticalCheck {
    let limit = student_quantile(1.0 - 0.5 * ALPHA);
    let deviations = past.into_iter().flatten().map(|then| {
        let (before, all) = (then.samples as f64, now.samples as f64);
        let steps: [f64; REPLICAS] = std::array::from_fn(|replica| {
            let since = (all * now.means[replica] - before * then.means[replica]) / (all - before);
            since - then.means[replica]
        });
        let mean = steps.iter().sum::<f64>() / REPLICAS as f64;
        let squares: f64 = steps.iter().map(|step| (step - mean).powi(2)).sum();
        let error = (squares / (REPLICAS * (REPLICAS - 1)) as f64).sqrt();
        if mean.abs() <= rounding { 0.0 } else { mean.abs() / error }
    });
    let value = deviations.reduce(f64::max);
    let passed = value.is_none_or(|value| value <= limit);
    check("mean", value, limit, passed, "the map's mean drifts: later samples do not agree with earlier ones")
}

/// Squared error times work must not grow, by Fisher's F. The part that the two nested estimates share is removed.
fn growth_check(
    name: &'static str,
    now: &PastJudgement,
    then: Option<&PastJudgement>,
    work: impl Fn(&PastJudgement) -> f64,
    rounding: f64,
) -> StatisticalCheck {
    let explanation =
        "the error does not fall with the square root of the work: samples repeat, or their variance is not finite";
    let Some(then) = then.filter(|then| now.squared_error > rounding.powi(2) && then.samples < now.samples) else {
        return check(name, None, ALLOWED_GROWTH, true, explanation);
    };
    let degrees = SURE_DEGREES * (REPLICAS - 1) as f64 * now.degrees_of_freedom.min(then.degrees_of_freedom);
    let shared = then.samples as f64 / now.samples as f64;
    let limit = ALLOWED_GROWTH * fisher_quantile([degrees.clamp(7.0, 1e6) / (1.0 - shared); 2], 1.0 - ALPHA);
    let growth = work(now) * now.squared_error / (work(then) * then.squared_error).max(f64::MIN_POSITIVE);
    check(name, Some(growth), limit, growth <= limit, explanation)
}

/// A tail that may have no variance.
struct HeavyTail<'a> {
    part: &'a ScoreEvidence,
    /// Shape from which on the tail counts as infinite.
    limit: f64,
    /// Multiple of its squared error that the map must tolerate for the tail not to matter.
    spare: f64,
}

impl HeavyTail<'_> {
    fn is_heavy(&self) -> bool {
        self.excess() > 0.0
    }

    fn excess(&self) -> f64 {
        self.part.shape.unwrap_or(f64::NEG_INFINITY) - self.limit
    }
}

/// Shape from which on a tail of `scores` scores counts as one without variance.
fn limit_of_shape(scores: usize) -> f64 {
    INFINITE_VARIANCE - uncertainty_of_shape(scores)
}

/// Number of standard errors that is on the safe side, of the shape of a tail of `scores` scores.
fn uncertainty_of_shape(scores: usize) -> f64 {
    SAFE_SIDE * (1.0 + INFINITE_VARIANCE) / (scores as f64).sqrt()
}

/// Of the tails that carry enough of the variance to matter, returns the heaviest for its number of scores.
fn heaviest_tail(parts: &[ScoreEvidence; 2]) -> Option<HeavyTail<'_>> {
    let variance: f64 = parts.iter().map(|part| part.weighted_variance).sum();
    let telling = parts.iter().filter(|part| {
        part.tail >= LEAST_TAIL && part.shape.is_some() && part.tail_variance > LEAST_TAIL_SHARE * variance
    });
    let tails = telling.map(|part| HeavyTail {
        part,
        limit: limit_of_shape(part.tail),
        // The scores outside the tail have a variance.
        spare: 1.0 + (SPARE_FOR_TAILS - 1.0) * (part.tail_variance / variance).min(1.0),
    });
    tails.max_by(|one, other| one.excess().total_cmp(&other.excess()))
}

/// Multiple of its squared error that a map is expected to have to tolerate to pass the tail check at its end: where the shape of its tail
/// is above the limit of infinite variance by as much as is on the safe side. Otherwise 1. (Of 8 maps in the proving ground whose tails the
/// check would have refused before the target was met, with shapes of 0.4 to 0.65, none was refused when it was met.)
pub fn spare_for_tail(parts: [ScoreEvidence; 2]) -> f64 {
    let is_surely_heavy = |tail: &HeavyTail| {
        let surely = INFINITE_VARIANCE + uncertainty_of_shape(tail.part.tail);
        tail.part.shape.is_some_and(|shape| shape > surely)
    };
    heaviest_tail(&parts).filter(is_surely_heavy).map_or(1.0, |tail| tail.spare)
}

/// The largest scores must not fall off like those of a distribution without variance. Exceptions: they hardly matter, or the map is so far
/// below its target that it tolerates what its spread cannot show.
fn tail_check(parts: [ScoreEvidence; 2], spare: f64) -> StatisticalCheck {
    let explanation =
        "a few very large scores dominate the map, and more of them must be expected: its variance may be infinite";
    match heaviest_tail(&parts) {
        Some(tail) => {
            let passed = !tail.is_heavy() || spare >= tail.spare;
            check("tail", tail.part.shape, tail.limit, passed, explanation)
        }
        None => check(
            "tail",
            None,
            INFINITE_VARIANCE,
            parts.iter().all(|part| part.weighted_variance.is_finite()),
            explanation,
        ),
    }
}

/// Enough scores must carry the variance: n = (Σx²)²/Σx⁴. Its inverse is what transport codes call the variance of the variance.
///
/// The relative uncertainty of the squared error from single scores is 1/√n. A map that tolerates `spare` times its squared error needs to
/// know it less well by that factor, so the limit falls with the square of `spare`.
fn scores_check(parts: [ScoreEvidence; 2], spare: f64, has_waited: bool) -> StatisticalCheck {
    let explanation = "too few scores determine the map's error, so it is not known well";
    let limit = ENOUGH_SCORES / (spare * spare);
    match effective_scores(parts) {
        Some(effective) => check("scores", Some(effective), limit, has_waited || effective >= limit, explanation),
        None => check("scores", None, limit, true, explanation),
    }
}

/// Number of scores that effectively carry the variance of a map. `None` if the map has no variance.
pub fn effective_scores(parts: [ScoreEvidence; 2]) -> Option<f64> {
    let variance: f64 = parts.iter().map(|part| part.weighted_variance).sum();
    let fourth: f64 = parts.iter().map(|part| part.fourth).sum();
    (variance != 0.0).then(|| variance * variance / fourth)
}

/// Quantile of Student's t over the replicas.
pub(super) fn student_quantile(probability: f64) -> f64 {
    StudentsT::new(0.0, 1.0, (REPLICAS - 1) as f64).map_or(f64::INFINITY, |t| t.inverse_cdf(probability))
}

#[cfg(test)]
#[path = "checks_tests.rs"]
mod tests;
