//! How many walks each point takes in a pass: more where walks scatter more.
//! A fixed number of walks has the least variance if each point takes walks in proportion to the standard deviation of one walk. (Neyman
//! 1934, "On the two different aspects of the representative method".) Past walks decide on future walks and are then given up. So no sum
//! contains the random error that determined the allotment.

use serde::{Deserialize, Serialize};

/// Share of the mean variance of all points that is added to the variance of each point's own walks: rare bright walks may still come.
const OF_ALL_POINTS: f64 = 0.125;
/// Most walks of one point in a pass.
const MOST_WALKS: f64 = 32.0;
/// Walks are shared out anew if that takes less work by this factor. Each half estimates the gain of what the other half proposes, and the
/// work given up is included.
const WORTHWHILE: f64 = 1.15;

/// Walks of each point in a pass.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Allotment {
    /// Empty if all points take one.
    walks: Vec<u16>,
}

impl Allotment {
    /// Walks that a point takes in a pass.
    #[inline]
    pub fn of(&self, point: usize) -> u64 {
        self.walks.get(point).map_or(1, |walks| u64::from(*walks))
    }

    /// Walks that `points` points take in a pass.
    pub fn of_all(&self, points: usize) -> u64 {
        (0..points).map(|point| self.of(point)).sum()
    }

    /// Variance of a pass over the map's points, relative to that of one walk from each.
    pub fn variance_of_a_pass(&self, variances: &[[f64; 2]]) -> f64 {
        let both = of_both(variances);
        let all: f64 = both.iter().sum();
        if all > 0.0 { self.left(&both) / all } else { 1.0 }
    }

    /// Ratio of the work of this allotment to that of a better one. `variances` has, from the even and the odd half, the variance of a walk
    /// from every point times the point's weight. Each half judges what the other proposes.
    pub fn gain(&self, variances: &[[f64; 2]]) -> f64 {
        let halves = [0, 1].map(|half| -> Vec<f64> { variances.iter().map(|of_point| of_point[half]).collect() });
        let of_half = |half: usize| {
            let judge = &halves[1 - half];
            self.work(judge) / Allotment::fitting(&halves[half]).work(judge)
        };
        let gain = (of_half(0) * of_half(1)).sqrt();
        // Without any variance there is nothing to gain.
        if gain.is_nan() { 1.0 } else { gain }
    }

    /// A better allotment and the factor of work that it saves, if that is large enough. `done` is the share of the work to come that would
    /// be done by now and is given up.
    pub fn improved(&self, variances: &[[f64; 2]], done: f64) -> Option<(Allotment, f64)> {
        let gain = self.gain(variances);
        ((1.0 - done) * gain > WORTHWHILE).then(|| (Allotment::fitting(&of_both(variances)), gain))
    }

    /// The allotment of least work for points with these variances.
    fn fitting(variances: &[f64]) -> Allotment {
        let mean = variances.iter().sum::<f64>() / variances.len().max(1) as f64;
        let safe: Vec<f64> = variances.iter().map(|variance| variance + OF_ALL_POINTS * mean).collect();
        let most = safe.iter().copied().fold(0.0, f64::max).sqrt();
        let with_most = |walks: f64| {
            let walks_of = |variance: &f64| (walks * variance.sqrt() / most).round().clamp(1.0, walks) as u16;
            Allotment { walks: safe.iter().map(walks_of).collect() }
        };
        // Larger whole numbers fit better, but cost more where the best number would be a part of a walk.
        let steps = 2.0 * MOST_WALKS.log2();
        let candidates = (1..=steps as i32).map(|step| with_most(f64::from(step).exp2().sqrt()));
        let best = candidates.min_by(|one, other| one.work(&safe).total_cmp(&other.work(&safe)));
        best.filter(|_| most > 0.0).unwrap_or_default()
    }

    /// Work to a fixed variance, up to a constant factor: walks of a pass times the variance that remains after it.
    fn work(&self, variances: &[f64]) -> f64 {
        self.of_all(variances.len()) as f64 * self.left(variances)
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
        let (allotment, _) = Allotment::default().improved(&of_halves, 0.05).expect("far better");
        assert!(allotment.of(3) >= 5 && allotment.of(4) == 1, "{allotment:?}");
        assert!(Allotment::default().work(&variances) > 3.0 * allotment.work(&variances));
        // If most of the work is done, it is not worth giving up. The data that an allotment was made of do not improve on it.
        assert_eq!(Allotment::default().improved(&of_halves, 0.8), None);
        assert_eq!(allotment.improved(&of_halves, 0.0), None);
    }

    #[test]
    fn chance_of_what_halves_say_is_no_reason_to_share_out_anew() {
        // 80 equal points, 200 sets, seed 4: what one half proposes by chance, the other does not find better. Planted fault: used alone,
        // the same numbers would promise a gain.
        let mut stream = Stream::new(4, Purpose::Pilot, 0, 0);
        let mut promised = 0.0;
        for set in 0..200 {
            stream.seek(set);
            let halves: Vec<[f64; 2]> = (0..80).map(|_| [0, 1].map(|_| as_a_half_says(&mut stream))).collect();
            assert_eq!(Allotment::default().improved(&halves, 0.0), None);
            let even: Vec<f64> = halves.iter().map(|half| half[0]).collect();
            promised += Allotment::default().work(&even) / Allotment::fitting(&even).work(&even) / 200.0;
        }
        assert!(promised > 1.01, "{promised}");
    }

    #[test]
    fn dark_points_take_one_walk_each() {
        assert_eq!(Allotment::default().improved(&[[0.0; 2]; 5], 0.0), None);
        assert_eq!(Allotment::default().of_all(5), 5);
    }
}
