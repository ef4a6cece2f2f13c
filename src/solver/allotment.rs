//! How many walks each point takes in a pass: more where walks scatter more. Light samples of elements and gathering rays are shared out in
//! the same way.
//! A fixed number of walks has the least variance if each point takes walks in proportion to the standard deviation of one walk. (Neyman
//! 1934, "On the two different aspects of the representative method".) Past walks decide on future walks and stay in the map, with one
//! weight for all points. That weight is computed from all walks together, so it hardly depends on the chance of any point. (Gathering rays
//! that decided are dropped from the map.)

use serde::{Deserialize, Serialize};

/// Share of the mean variance of all points that is added to the variance of each point's own walks: rare bright walks may still come.
const OF_ALL_POINTS: f64 = 0.125;
/// Most walks of one point in a pass.
const MOST_WALKS: f64 = 32.0;
/// Walks are shared out anew if that takes less work by this factor. Each half estimates the gain of what the other half proposes.
const WORTHWHILE: f64 = 1.15;

/// So many passes that whole ones make no difference.
const MANY_PASSES: f64 = 1e6;
/// Fewest passes as which earlier walks count. Their number is rounded, which must make little difference.
const FEWEST_CARRIED: f64 = 2.0;

/// Walks of each point in a pass.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Allotment {
    /// Empty if all points take one.
    walks: Vec<u16>,
}

/// Walks of earlier allotments, which count as passes of the present one.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Carried {
    /// Number of passes as which they count.
    pub passes: u64,
    /// Walks of every point in each replica, and the variance of its sum over these passes in units of the variance of one walk from it.
    /// Empty if there are none.
    of_points: Vec<(u64, f64)>,
}

impl Carried {
    fn of(&self, point: usize) -> (u64, f64) {
        self.of_points.get(point).copied().unwrap_or_default()
    }

    /// Walks in each replica.
    pub fn walks(&self) -> u64 {
        self.of_points.iter().map(|(walks, _)| walks).sum()
    }

    /// Number of a point's first walk in a pass of `walks` walks from it.
    #[inline]
    pub fn first_walk(&self, point: usize, pass: u64, walks: u64) -> u64 {
        self.of(point).0 + (pass - self.passes) * walks
    }

    /// Variance of a point's sum over `passes` passes, the carried ones among them, in units of the variance of one walk from it.
    pub fn scatter(&self, allotment: &Allotment, point: usize, passes: u64) -> f64 {
        self.of(point).1 + (passes - self.passes) as f64 / allotment.of(point) as f64
    }

    /// The walks of `passes` passes over `points` points, the carried ones among them, as `as_passes` passes.
    pub fn counted_as(&self, as_passes: u64, (allotment, points, passes): (&Allotment, usize, u64)) -> Carried {
        let scale = as_passes as f64 / passes as f64;
        let of_point = |point: usize| {
            let walks = self.first_walk(point, passes, allotment.of(point));
            (walks, scale * scale * self.scatter(allotment, point, passes))
        };
        Carried { passes: as_passes, of_points: (0..points).map(of_point).collect() }
    }
}

impl Allotment {
    /// Walks that a point takes in a pass.
    #[inline]
    pub fn of(&self, point: usize) -> u64 {
        self.walks.get(point).map_or(1, |walks| u64::from(*walks))
    }

    /// Whether all points take one.
    pub fn is_even(&self) -> bool {
        self.walks.is_empty()
    }

    /// Walks that `points` points take in a pass.
    pub fn of_all(&self, points: usize) -> u64 {
        (0..points).map(|point| self.of(point)).sum()
    }

    /// The allotment of least work for entries of these variances, each times the entry's weight, if one sample of each would take `passes`
    /// passes to the target.
    pub fn to_target(variances: &[f64], passes: f64) -> Allotment {
        if passes > 1.0 { Allotment::default().fitting(variances, u64::MAX, passes) } else { Allotment::default() }
    }

    /// Variance of a pass over the map's points, relative to that of one walk from each.
    pub fn variance_of_a_pass(&self, variances: &[[f64; 2]]) -> f64 {
        let both = of_both(variances);
        let all: f64 = both.iter().sum();
        if all > 0.0 { self.left(&both) / all } else { 1.0 }
    }

    /// A better allotment, and the factor of work that it saves, if that is large enough. `variances` has, from the even and the odd half,
    /// the variance of a walk from every point times the point's weight. The target takes `passes` more passes of the present allotment
    /// after `done`. Each half judges what the other proposes.
    pub fn improved(&self, variances: &[[f64; 2]], done: u64, passes: f64) -> Option<(Allotment, f64)> {
        let gain = self.gain(variances, done, passes);
        // Without any variance there is nothing to gain, and the comparison is false.
        (gain > WORTHWHILE).then(|| (self.fitting(&of_both(variances), done, passes), gain))
    }

    /// A better allotment, and the factor of work that it saves, if samples are to begin anew for it. Then `done` passes of single samples are
    /// given up, of `passes` that the target takes in all.
    pub fn anew(variances: &[[f64; 2]], done: f64, passes: f64) -> Option<(Allotment, f64)> {
        let better = Allotment::default().improved(variances, u64::MAX, passes)?;
        (WORTHWHILE * passes / better.1 < passes - done).then_some(better)
    }

    /// The factor of work that allotments to come will save far from the target; 1 if none.
    pub fn gain_to_come(&self, variances: &[[f64; 2]]) -> f64 {
        self.gain(variances, u64::MAX, MANY_PASSES).max(1.0)
    }

    fn gain(&self, variances: &[[f64; 2]], done: u64, passes: f64) -> f64 {
        let halves = [0, 1].map(|half| -> Vec<f64> { variances.iter().map(|of_point| of_point[half]).collect() });
        let of_half = |half: usize| {
            let (own, judge) = (&halves[half], &halves[1 - half]);
            let goal = self.left(judge) / passes;
            self.work(judge, goal) / self.fitting(own, done, passes).work(judge, goal)
        };
        (of_half(0) * of_half(1)).sqrt()
    }

    /// The allotment of least work for points with these variances, after `done` passes of this one and instead of `passes` more.
    fn fitting(&self, variances: &[f64], done: u64, passes: f64) -> Allotment {
        let mean = variances.iter().sum::<f64>() / variances.len().max(1) as f64;
        let safe: Vec<f64> = variances.iter().map(|variance| variance + OF_ALL_POINTS * mean).collect();
        let most = safe.iter().copied().fold(0.0, f64::max).sqrt();
        let with_most = |walks: f64| {
            let walks_of = |variance: &f64| (walks * variance.sqrt() / most).round().clamp(1.0, walks) as u16;
            Allotment { walks: safe.iter().map(walks_of).collect() }
        };
        // Larger whole numbers fit better, but cost more where the best number would be a part of a walk, and end in longer passes.
        let steps = 2.0 * MOST_WALKS.log2();
        let candidates = (1..=steps as i32).map(|step| with_most(f64::from(step).exp2().sqrt()));
        let carries =
            |candidate: &Allotment| candidate.left(variances) * done as f64 >= FEWEST_CARRIED * self.left(variances);
        let goal = self.left(&safe) / passes;
        let best =
            candidates.filter(carries).min_by(|one, other| one.work(&safe, goal).total_cmp(&other.work(&safe, goal)));
        best.filter(|_| most > 0.0).unwrap_or_default()
    }

    /// Walks of whole passes to a variance summed over the points.
    fn work(&self, variances: &[f64], goal: f64) -> f64 {
        self.of_all(variances.len()) as f64 * (self.left(variances) / goal).ceil()
    }

    /// Variance that remains after a pass, summed over the points.
    fn left(&self, variances: &[f64]) -> f64 {
        variances.iter().enumerate().map(|(point, variance)| variance / self.of(point) as f64).sum()
    }
}

/// Mean of the variances of both halves.
fn of_both(variances: &[[f64; 2]]) -> Vec<f64> {
    variances.iter().map(|[even, odd]| 0.5 * (even + odd)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::random::{Purpose, Stream};

    /// The estimate by a half of eight replicas of the variance 1 of a normal walk: χ² of 7 degrees of freedom over 7.
    fn as_a_half_says(stream: &mut Stream) -> f64 {
        let normal = |stream: &mut Stream| {
            let [u, v] = stream.pair();
            (-2.0 * (1.0 - u).ln()).sqrt() * (std::f64::consts::TAU * v).cos()
        };
        (0..7).map(|_| normal(stream).powi(2)).sum::<f64>() / 7.0
    }

    #[test]
    fn few_points_that_scatter_most_take_most_walks() {
        // Ten points of a hundred scatter twenty times as much. Neyman's allotment takes 100 · (10 · 400 + 90) / (10 · 20 + 90)² = 4.9
        // times less work. With whole numbers and caution more than 3 remains of that.
        let variances: Vec<f64> = (0..100).map(|point| if point % 10 == 3 { 400.0 } else { 1.0 }).collect();
        let of_halves: Vec<[f64; 2]> = variances.iter().map(|variance| [*variance; 2]).collect();
        let (allotment, _) = Allotment::default().improved(&of_halves, 20, 50.0).expect("far better");
        assert!(allotment.of(3) >= 5 && allotment.of(4) == 1, "{allotment:?}");
        let goal = variances.iter().sum::<f64>() / 50.0;
        assert!(Allotment::default().work(&variances, goal) > 3.0 * allotment.work(&variances, goal));
        // Less than one pass is never better than one of single walks. The data that an allotment was made of do not improve on it.
        assert_eq!(Allotment::default().improved(&of_halves, 20, 0.9), None);
        assert_eq!(allotment.improved(&of_halves, 20, 50.0), None);
    }

    #[test]
    fn chance_of_what_halves_say_is_no_reason_to_share_out_anew() {
        // 80 equal points, 200 sets, seed 4: what one half proposes by chance, the other does not find better. Planted fault: used alone,
        // the same numbers would promise a gain.
        let mut stream = Stream::new(4, Purpose::Pilot, 0, 0);
        let (mut promised, single) = (0.0, Allotment::default());
        for set in 0..200 {
            stream.seek(set);
            let halves: Vec<[f64; 2]> = (0..80).map(|_| [0, 1].map(|_| as_a_half_says(&mut stream))).collect();
            assert_eq!(Allotment::default().improved(&halves, 20, 50.0), None);
            let even: Vec<f64> = halves.iter().map(|half| half[0]).collect();
            let goal = even.iter().sum::<f64>() / MANY_PASSES;
            promised += single.work(&even, goal) / single.fitting(&even, 20, MANY_PASSES).work(&even, goal) / 200.0;
        }
        assert!(promised > 1.01, "{promised}");
    }

    #[test]
    fn dark_points_take_one_walk_each() {
        assert_eq!(Allotment::default().improved(&[[0.0; 2]; 5], 20, 50.0), None);
        assert_eq!(Allotment::default().of_all(5), 5);
    }

    /// Three points, four passes of single walks that count as two, and three passes of one, two and four walks.
    #[test]
    fn carried_walks_scatter_as_their_weights_say() {
        let single = Allotment::default();
        let carried = Carried::default().counted_as(2, (&single, 3, 4));
        let allotment = Allotment { walks: vec![1, 2, 4] };
        assert_eq!((carried.walks(), carried.first_walk(2, 2, 4), carried.first_walk(2, 4, 4)), (12, 4, 12));
        for (point, walks) in [(0, 1.0), (1, 2.0), (2, 4.0)] {
            // Sum of the first four walks times ½, and of three means.
            let scatter = 4.0 * 0.25 + 3.0 / walks;
            assert!((carried.scatter(&allotment, point, 5) - scatter).abs() < 1e-12);
        }
        let again = carried.counted_as(10, (&allotment, 3, 5));
        assert_eq!((again.walks(), again.first_walk(1, 10, 3)), (4 + 3 + 4 + 6 + 4 + 12, 10));
        assert!((again.scatter(&single, 1, 10) - 4.0 * (1.0 + 1.5)).abs() < 1e-12);
    }

    /// Walks of a rare bright kind from 32 equal points, whose variances decide on the walks to come: 3,000 runs, seed 5. Carried with one
    /// weight for all points they bring the mean 1 within 4.5 standard errors (α = 7e-6). The planted fault, a mean over all walks of each
    /// point, is too low by more.
    #[test]
    fn carried_walks_bring_no_bias() {
        const POINTS: usize = 32;
        let mut stream = Stream::new(5, Purpose::Pilot, 0, 0);
        let mut sums = [[0.0f64; 2]; 2];
        let runs = 3000;
        for run in 0..runs {
            stream.seek(run);
            let mut walk = || if stream.pair()[0] < 0.1 { 10.0 } else { 0.0 };
            let first: Vec<Vec<f64>> = (0..POINTS).map(|_| (0..8).map(|_| walk()).collect()).collect();
            let means: Vec<f64> = first.iter().map(|walks| walks.iter().sum::<f64>() / 8.0).collect();
            let variances = first
                .iter()
                .zip(&means)
                .map(|(walks, mean)| walks.iter().map(|lx| (lx - mean).powi(2)).sum::<f64>() / 7.0);
            let variances: Vec<f64> = variances.collect();
            let single = Allotment::default();
            let allotment = single.fitting(&variances, 8, 50.0);
            let carried = (8.0 * allotment.left(&variances) / single.left(&variances)).round().max(1.0);
            let (mut as_passes, mut by_walks) = (0.0, 0.0);
            for (point, mean) in means.iter().enumerate() {
                let walks = 4 * allotment.of(point);
                let new = (0..walks).map(|_| walk()).sum::<f64>() / walks as f64;
                as_passes += (carried * mean + 4.0 * new) / (carried + 4.0) / POINTS as f64;
                by_walks += (8.0 * mean + walks as f64 * new) / (8.0 + walks as f64) / POINTS as f64;
            }
            for (sums, mean) in sums.iter_mut().zip([as_passes, by_walks]) {
                *sums = [sums[0] + mean, sums[1] + mean * mean];
            }
        }
        let sigmas = sums.map(|[sum, squares]| {
            let mean = sum / runs as f64;
            (mean - 1.0) / ((squares / runs as f64 - mean * mean) / runs as f64).sqrt()
        });
        assert!(sigmas[0].abs() < 4.5 && sigmas[1] < -4.5, "{sigmas:?}");
    }
}
