//! How many walks each point takes in a pass: more where walks scatter more.
//!
//! Of a number of walks least variance is left if each point takes them in proportion to the standard deviation of one (Neyman 1934, "On
//! the two different aspects of the representative method"). What walks have said decides about those to come and is then given up, so
//! that no sum holds the chance that shared it out.

use serde::{Deserialize, Serialize};

/// A share of the mean variance of all points that each counts as its own beside what its walks say: rare bright walks may still come.
const OF_ALL_POINTS: f64 = 0.125;
/// Walks of one point in a pass at most.
const MOST_WALKS: f64 = 32.0;
/// Walks are shared out anew where that takes so many times less work, as either half says of what the other proposes, and what is given
/// up counted.
const WORTHWHILE: f64 = 1.15;

/// Walks of each point in a pass.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Allotment {
    /// Empty where all points take one.
    walks: Vec<u16>,
}

impl Allotment {
    /// Walks that a point takes in a pass.
    #[inline]
    pub fn of(&self, point: usize) -> u64 {
        self.walks.get(point).map_or(1, |walks| u64::from(*walks))
    }

    /// Walks that so many points take in a pass.
    pub fn of_all(&self, points: usize) -> u64 {
        (0..points).map(|point| self.of(point)).sum()
    }

    /// Variance of a pass over the map's points, over that of one walk from each.
    pub fn variance_of_a_pass(&self, variances: &[[f64; 2]]) -> f64 {
        let both = of_both(variances);
        let all: f64 = both.iter().sum();
        if all > 0.0 { self.left(&both) / all } else { 1.0 }
    }

    /// How many times less work a better one takes, where the even and the odd half each know the variance of a walk from every point,
    /// times the point's weight: either half judges what the other proposes.
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

    /// A better one and how many times less work it takes, if that is far less. This share of the work to come would be done by now,
    /// and is given up.
    pub fn improved(&self, variances: &[[f64; 2]], done: f64) -> Option<(Allotment, f64)> {
        let gain = self.gain(variances);
        ((1.0 - done) * gain > WORTHWHILE).then(|| (Allotment::fitting(&of_both(variances)), gain))
    }

    /// The one of least work for points of such variances.
    fn fitting(variances: &[f64]) -> Allotment {
        let mean = variances.iter().sum::<f64>() / variances.len().max(1) as f64;
        let safe: Vec<f64> = variances.iter().map(|variance| variance + OF_ALL_POINTS * mean).collect();
        let most = safe.iter().copied().fold(0.0, f64::max).sqrt();
        let with_most = |walks: f64| {
            let walks_of = |variance: &f64| (walks * variance.sqrt() / most).round().clamp(1.0, walks) as u16;
            Allotment { walks: safe.iter().map(walks_of).collect() }
        };
        // Whole numbers fit the better the larger they are, but cost where the least would be a part of a walk.
        let steps = 2.0 * MOST_WALKS.log2();
        let candidates = (1..=steps as i32).map(|step| with_most(f64::from(step).exp2().sqrt()));
        let best = candidates.min_by(|one, other| one.work(&safe).total_cmp(&other.work(&safe)));
        best.filter(|_| most > 0.0).unwrap_or_default()
    }

    /// Work to a fixed variance, but for a factor: walks of a pass times the variance that it leaves.
    fn work(&self, variances: &[f64]) -> f64 {
        self.of_all(variances.len()) as f64 * self.left(variances)
    }

    /// Variance that a pass leaves, summed over the points.
    fn left(&self, variances: &[f64]) -> f64 {
        variances.iter().enumerate().map(|(point, variance)| variance / self.of(point) as f64).sum()
    }
}

/// Variances as both halves tell them together.
fn of_both(variances: &[[f64; 2]]) -> Vec<f64> {
    variances.iter().map(|[even, odd]| 0.5 * (even + odd)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::random::{Purpose, Stream};

    /// What a half of eight replicas says of the variance 1 of a normal walk: χ² of 7 degrees of freedom over 7.
    fn as_a_half_says(stream: &mut Stream) -> f64 {
        let normal = |stream: &mut Stream| {
            let [u, v] = stream.pair();
            (-2.0 * (1.0 - u).ln()).sqrt() * (std::f64::consts::TAU * v).cos()
        };
        (0..7).map(|_| normal(stream).powi(2)).sum::<f64>() / 7.0
    }

    #[test]
    fn few_points_that_scatter_most_take_most_walks() {
        // Ten points of a hundred scatter twenty times as much: Neyman's allotment takes 100 · (10 · 400 + 90) / (10 · 20 + 90)² = 4.9
        // times less work; what whole numbers and caution leave of that is more than 3.
        let variances: Vec<f64> = (0..100).map(|point| if point % 10 == 3 { 400.0 } else { 1.0 }).collect();
        let of_halves: Vec<[f64; 2]> = variances.iter().map(|variance| [*variance; 2]).collect();
        let (allotment, _) = Allotment::default().improved(&of_halves, 0.05).expect("far better");
        assert!(allotment.of(3) >= 5 && allotment.of(4) == 1, "{allotment:?}");
        assert!(Allotment::default().work(&variances) > 3.0 * allotment.work(&variances));
        // Where most of the work is done it is not worth giving up; and it is not improved upon by what it was made of.
        assert_eq!(Allotment::default().improved(&of_halves, 0.8), None);
        assert_eq!(allotment.improved(&of_halves, 0.0), None);
    }

    #[test]
    fn chance_of_what_halves_say_is_no_reason_to_share_out_anew() {
        // 80 points alike, 200 sets, seed 4: what one half proposes by chance the other does not find better. Believed by themselves
        // (the planted fault) the same numbers would promise a gain.
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
