//! Simulated runs: sound ones must pass, heavy tails and repeated samples must not.

use super::*;
use crate::maps::{Levels, PartScores};
use crate::sampling::random::{Purpose, Stream};

/// Distribution of a score: maps a uniform variate in (0, 1] to the score.
type Score = fn(f64) -> f64;

/// When a simulated run ends.
#[derive(Clone, Copy, PartialEq)]
enum SimulatedEnd {
    /// At the first look that meets the target.
    AtFirst,
    /// When the checks pass too, as in real runs.
    WhenPassed,
    /// Also at the first look that meets the target, but no check is applied: a planted fault.
    Unchecked,
}

/// Result of a simulated run to a target error.
struct Simulated {
    passed: bool,
    /// Relative root-mean-square error of the points.
    true_error: f64,
    failed: Vec<&'static str>,
}

/// Runs `points` points with one distribution of scores up to the target or to `most` samples. It checks its error as real runs do. From
/// `repeats_after` samples on it draws the same numbers again.
fn simulated(seed: u64, points: usize, score: Score, target: f64, most: u64, repeats_after: u64) -> Simulated {
    simulated_to(SimulatedEnd::AtFirst, seed, points, score, target, most, repeats_after)
}

/// Runs the same simulation with a choice of when it ends.
fn simulated_to(
    end: SimulatedEnd,
    seed: u64,
    points: usize,
    score: Score,
    target: f64,
    most: u64,
    repeats_after: u64,
) -> Simulated {
    let mut held_since = None;
    let exact = law_mean(score);
    let mut history = History::default();
    let (mut scores, mut levels) = (PartScores::default(), Levels::default());
    let mut sums = vec![[0.0f64; REPLICAS]; points];
    let mut goal = 4;
    let mut samples = 0u64;
    let mut streams: [Stream; REPLICAS] =
        std::array::from_fn(|replica| Stream::new(seed, Purpose::Pilot, 7, replica as u32));
    loop {
        let first =
            |point: usize| (samples > 0).then(|| sums[point].iter().sum::<f64>() / (samples * REPLICAS as u64) as f64);
        levels.fix(0..points, points, first);
        for (point, sums) in sums.iter_mut().enumerate() {
            for (replica, stream) in streams.iter_mut().enumerate() {
                let mut entry = scores.of_entry(1.0, levels.of(point));
                for number in samples..goal {
                    stream.seek(((point as u64) << 32) | (number % repeats_after));
                    let value = score(1.0 - stream.fine_unit());
                    entry.add(value);
                    sums[replica] += value;
                }
            }
        }
        samples = goal;
        let count = samples as f64;
        let mean_of = |of: &dyn Fn(&[f64; REPLICAS]) -> f64| sums.iter().map(of).sum::<f64>() / points as f64;
        let means = std::array::from_fn(|replica| mean_of(&|sums| sums[replica] / count));
        let mean = means.iter().sum::<f64>() / REPLICAS as f64;
        let squared_error = mean_of(&|sums| {
            let mean = sums.iter().sum::<f64>() / REPLICAS as f64;
            sums.iter().map(|sum| ((sum - mean) / count).powi(2)).sum::<f64>() / (REPLICAS * (REPLICAS - 1)) as f64
        });
        let degrees_of_freedom = points as f64;
        let rays = samples * points as u64;
        history.add(PastJudgement { samples, rays, squared_error, degrees_of_freedom, means });
        let expected_error = squared_error.sqrt() / mean;
        let judgement = Judgement {
            mean,
            expected_error,
            halves_error: expected_error,
            degrees_of_freedom,
            ..Judgement::default()
        };
        let accepted = super::super::accepts(target, &judgement);
        if accepted || samples >= most {
            let samples_an_entry = count * REPLICAS as f64;
            let parts = [ScoreEvidence::default(), scores.evidence(samples_an_entry, samples_an_entry * points as f64)];
            let checks = statistical_checks(&history, parts, &judgement, held_since, Some(target));
            let failed: Vec<&str> = checks.iter().filter(|check| !check.passed).map(|check| check.name).collect();
            let passed = failed.is_empty() || end == SimulatedEnd::Unchecked;
            if passed || end == SimulatedEnd::AtFirst || samples >= most {
                let deviation = |sums: &[f64; REPLICAS]| {
                    (sums.iter().sum::<f64>() / (count * REPLICAS as f64) / exact - 1.0).powi(2)
                };
                return Simulated { passed, true_error: mean_of(&deviation).sqrt(), failed };
            }
            held_since.get_or_insert(samples);
            goal = super::super::after_refusal(samples).min(most);
            continue;
        }
        goal = super::super::next_judgement(
            samples,
            super::super::needed_work(target, &judgement, super::super::EXPONENT_OF_INDEPENDENT_SAMPLES),
        )
        .min(most);
    }
}

fn exponential(u: f64) -> f64 {
    -u.ln()
}

/// Non-zero in one sample of ten, then uniformly distributed.
fn now_and_then(u: f64) -> f64 {
    if u < 0.1 { 10.0 * u } else { 0.0 }
}

fn uniform(u: f64) -> f64 {
    u
}

/// The square of an exponential variate: skewed, with all moments.
fn skewed(u: f64) -> f64 {
    u.ln().powi(2)
}

fn pareto_2(u: f64) -> f64 {
    u.powf(-1.0 / 2.0)
}

/// Has just no fourth moment, so no number of scores determines the variance well.
fn pareto_2_5(u: f64) -> f64 {
    u.powf(-1.0 / 2.5)
}

fn pareto_4(u: f64) -> f64 {
    u.powf(-1.0 / 4.0)
}

fn pareto_1_5(u: f64) -> f64 {
    u.powf(-1.0 / 1.5)
}

fn pareto_1_2(u: f64) -> f64 {
    u.powf(-1.0 / 1.2)
}

/// Mean of a distribution of scores, by the midpoint rule in −ln u.
fn law_mean(score: Score) -> f64 {
    // u = exp(−t): the mean is ∫ score(exp(−t)) exp(−t) dt. The integrand is negligible at t = 80.
    let (strips, end) = (20_000, 80.0);
    let width = end / f64::from(strips);
    (0..strips).map(|strip| (f64::from(strip) + 0.5) * width).map(|t| score((-t).exp()) * (-t).exp() * width).sum()
}

#[test]
fn sound_runs_pass_but_for_one_in_a_thousand() {
    // 300 runs (3,000 in the slow test) to 2% or more: 3 distributions of scores; 1, 4 and 60 points. At most 3 (8) are refused (Poisson of
    // mean 0.3 and 3, α = 0.03% and 0.4%; a planted refusal rate of 2% gives 6 and 60).
    let slow = std::env::var_os("LUXMC_SLOW_TESTS").is_some_and(|value| value == "1");
    let (seeds, most) = if slow { (1000, 8) } else { (100, 3) };
    let mut refused = Vec::new();
    for seed in 0..seeds {
        for (law, score) in
            [("exponential", exponential as Score), ("now and then", now_and_then), ("uniform", uniform)]
        {
            let points = [1, 4, 60][seed as usize % 3];
            let run = simulated(seed, points, score, 0.02 * (points as f64).sqrt().min(4.0), 1 << 20, u64::MAX);
            if !run.passed {
                refused.push((law, seed, points, run.failed));
            }
        }
    }
    assert!(refused.len() <= most, "{refused:?}");
}

#[test]
fn heavy_tails_are_caught() {
    // 20 runs of each index (200 in the slow test): Pareto 2 (just infinite), 1.5 and 1.2. Each has 32 points and at most 4,096 samples a
    // replica. At least 95% are refused.
    let slow = std::env::var_os("LUXMC_SLOW_TESTS").is_some_and(|value| value == "1");
    let seeds: u64 = if slow { 200 } else { 20 };
    for (law, score) in [("2", pareto_2 as Score), ("1.5", pareto_1_5), ("1.2", pareto_1_2)] {
        let caught = (0..seeds).filter(|seed| !simulated(*seed, 32, score, 0.05, 4096, u64::MAX).passed).count() as u64;
        assert!(100 * caught >= 95 * seeds, "index {law}: {caught} of {seeds}");
    }
}

#[test]
fn tails_that_have_a_variance_hold_few_runs_up() {
    // 40 runs of 32 points to 0.5 %, whose scores fall off with index 4 (shape ¼). At most 2 are held up for their tail; the chance of each
    // is about 5e-4. With a quarter of the largest scores (the planted fault) the limit lies at that shape, and 19 wait.
    let held_up = |seed: &u64| simulated(*seed, 32, pareto_4, 0.005, 1 << 14, u64::MAX).failed.contains(&"tail");
    let count = (0..40).filter(held_up).count();
    assert!(count <= 2, "{count}");
}

#[test]
fn samples_that_repeat_are_caught() {
    // 40 runs of 60 points whose samples repeat after 16: their error stops falling. All must be refused.
    let caught = (0..40).filter(|seed| !simulated(*seed, 60, exponential, 1e-3, 1024, 16).passed).count();
    assert_eq!(caught, 40);
    let sound = (0..40).filter(|seed| !simulated(*seed, 60, exponential, 1e-3, 1024, u64::MAX).passed).count();
    assert_eq!(sound, 0);
}

#[test]
fn skewed_scores_are_either_sampled_enough_or_refused() {
    // One point, scores of kurtosis about 90, target 10%: runs that pass have had enough scores.
    for seed in 0..100 {
        let run = simulated(seed, 1, skewed, 0.1, 1 << 20, u64::MAX);
        assert!(run.passed || run.failed.contains(&"scores") || run.failed.contains(&"tail"), "{:?}", run.failed);
    }
}

#[test]
fn few_scores_are_asked_for_where_the_target_is_near() {
    // One point whose scores have a variance but no fourth moment, target 10%, 400 runs. With the checks at least 91% of the passing runs
    // keep the target; without them (the planted fault) fewer do.
    let kept = |end: SimulatedEnd| {
        let runs = (0..400).map(|seed| simulated_to(end, seed, 1, pareto_2_5, 0.1, 1 << 13, u64::MAX));
        let passed: Vec<Simulated> = runs.filter(|run| run.passed).collect();
        passed.iter().filter(|run| run.true_error <= 0.1).count() as f64 / passed.len() as f64
    };
    let (checked, unchecked) = (kept(SimulatedEnd::WhenPassed), kept(SimulatedEnd::Unchecked));
    assert!(checked >= 0.91 && unchecked < 0.91, "{checked} {unchecked}");
}

#[test]
fn a_map_far_under_its_target_needs_fewer_scores() {
    // 20 scores of one size are just enough for a map that needs all of its target. A map with four times its squared error to spare needs
    // 1.25, since 20 / 4² = 1.25.
    let part = |scores: f64| ScoreEvidence { weighted_variance: 1.0, fourth: 1.0 / scores, ..ScoreEvidence::default() };
    let passes = |scores: f64, spare: f64| scores_check([ScoreEvidence::default(), part(scores)], spare, false).passed;
    assert!(passes(20.1, 1.0) && !passes(19.9, 1.0));
    assert!(passes(1.3, 4.0) && !passes(1.2, 4.0));
}

#[test]
fn a_heavy_tail_does_not_matter_far_under_the_target() {
    // A tail of shape 1 is refused if the target is near. If it carries all the variance, it passes when the map tolerates nine times its
    // squared error; with half the variance, five times.
    let tail = |share: f64| ScoreEvidence {
        weighted_variance: 1.0,
        fourth: 1e-3,
        tail: 255,
        tail_variance: share,
        shape: Some(1.0),
    };
    for (share, needed) in [(1.0, 9.0), (0.5, 5.0)] {
        let parts = [ScoreEvidence::default(), tail(share)];
        let passes = |spare: f64| tail_check(parts, spare).passed;
        assert!(!passes(1.0) && !passes(needed - 0.1) && passes(needed));
        assert_eq!(spare_for_tail(parts), needed);
    }
    assert_eq!(spare_for_tail([ScoreEvidence::default(), ScoreEvidence { shape: Some(0.1), ..tail(1.0) }]), 1.0);
    // A shape of 0.6 of 255 scores is refused now, but not surely without variance: no delay is expected.
    let unsure = [ScoreEvidence::default(), ScoreEvidence { shape: Some(0.6), ..tail(1.0) }];
    assert!(!tail_check(unsure, 1.0).passed && spare_for_tail(unsure) == 1.0);
}

/// An exponential score, and once in 500 times a score without variance. The tail carries a part of the variance that samples show.
fn now_and_then_without_variance(u: f64) -> f64 {
    if u < 0.002 { 8.0 * (0.002 / u).powf(1.0 / 1.5) } else { -((u - 0.002) / 0.998).ln() }
}

#[test]
fn tails_that_are_let_pass_keep_the_target() {
    // 300 runs of 8 points to 5 %. Some of their scores have a tail of shape 2/3. Of the runs that pass at least 95 % keep the target (299
    // of 300 did). Without the checks (the planted fault) fewer do (91 %).
    let kept = |end: SimulatedEnd| {
        let runs =
            (0..300).map(|seed| simulated_to(end, seed, 8, now_and_then_without_variance, 0.05, 1 << 14, u64::MAX));
        let passed: Vec<Simulated> = runs.filter(|run| run.passed).collect();
        let kept = passed.iter().filter(|run| run.true_error <= 0.05).count() as f64 / passed.len() as f64;
        (kept, passed.len())
    };
    let ((checked, passed), (unchecked, all)) = (kept(SimulatedEnd::WhenPassed), kept(SimulatedEnd::Unchecked));
    assert!(checked >= 0.95 && unchecked < 0.95, "{checked} of {passed}, {unchecked} of {all}");
}

#[test]
fn what_exceeds_a_look_without_any_error_is_reported_as_a_number() {
    let look = |samples: u64, squared_error: f64| PastJudgement {
        samples,
        rays: samples,
        squared_error,
        degrees_of_freedom: 15.0,
        means: [1.0; REPLICAS],
    };
    let grown = growth_check("error", &look(20, 1e9), Some(&look(10, 0.0)), |look| look.samples as f64, 1e-12);
    assert_eq!((grown.passed, grown.value), (false, Some(MOST_REPORTED)));
    let settled = growth_check("error", &look(20, 1.0), Some(&look(10, 2.0)), |look| look.samples as f64, 1e-12);
    assert_eq!((settled.passed, settled.value), (true, Some(1.0)));
}
