//! Error bars of entries whose scores are skewed.
//!
//! Where few walks or packets bring most of the light, the mean and its spread rise and fall together: means that came
//! out low have bars that are too short. By Edgeworth's expansion (Hall, P., 1992, "The Bootstrap and Edgeworth
//! Expansion", section 2.6) a t interval of ±z standard errors loses about 2 φ(z) z (z⁴ + 2z² − 3)/18 · g² of its
//! coverage, g the skewness of the mean; bars longer by a share of (z⁴ + 2z² − 3)/18 · g² give it back.

use super::{HALF, REPLICAS};

/// (z⁴ + 2z² − 3)/18 − 1.3 (z² − 3)/12 at z = 2.17, Student's quantile of 95.4% for 15 degrees of freedom: the second
/// part is what the kurtosis of compound Poisson scores, some 1.3 times the square of their skewness, gives back.
const PER_SQUARED_SKEWNESS: f64 = 1.4;
/// Beyond this skewness of the mean the expansion says nothing more.
const MOST_SKEWNESS: f64 = 1.5;

/// What is known of an entry.
pub(super) struct Spread {
    /// Its indirect part in lx.
    scale_lx: f64,
    /// Third central moment of a replica times the indirect part, in lx⁴, without bias.
    third_lx4: f64,
    /// Squared variance of a replica in lx⁴, without bias.
    fourth_lx4: f64,
}

impl Spread {
    /// Takes an entry's value and indirect part in lx from every replica. Products of even and odd replicas have no bias, since these
    /// are independent.
    pub fn of(value_lx: impl Fn(usize) -> f64, indirect_lx: impl Fn(usize) -> f64) -> Spread {
        let halves = [0, 1].map(|parity| {
            let replicas = || (parity..REPLICAS).step_by(2);
            let mean = |of: &dyn Fn(usize) -> f64| replicas().map(of).sum::<f64>() / HALF as f64;
            let mean_lx = mean(&value_lx);
            let power = |power: i32| mean(&|replica| (value_lx(replica) - mean_lx).powi(power));
            let n = HALF as f64;
            (mean(&indirect_lx), power(2) * n / (n - 1.0), power(3) * n * n / ((n - 1.0) * (n - 2.0)))
        });
        let [(even_lx, even_variance, even_third), (odd_lx, odd_variance, odd_third)] = halves;
        Spread {
            scale_lx: 0.5 * (even_lx + odd_lx),
            third_lx4: 0.5 * (even_third * odd_lx + odd_third * even_lx),
            fourth_lx4: even_variance * odd_variance,
        }
    }
}

/// The skewness of a mean over its relative standard error, one number for a map.
///
/// Sixteen replicas cannot tell one entry's skewness. But scores of one kind have a skewness in proportion to their relative
/// spread, as counts have: g = c · s/E, E the indirect part, with one c for the map, which the third moments of all entries give.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Skewness(f64);

impl Skewness {
    /// That of a map with these entries.
    pub(super) fn of<'a>(spreads: impl Iterator<Item = &'a Spread>) -> Skewness {
        let (mut thirds, mut fourths) = (0.0, 0.0);
        for spread in spreads.filter(|spread| spread.scale_lx > 0.0) {
            thirds += spread.third_lx4 / spread.scale_lx.powi(3);
            fourths += spread.fourth_lx4 / spread.scale_lx.powi(3);
        }
        Skewness(if fourths > 0.0 { (thirds / fourths).max(0.0) } else { 0.0 })
    }

    /// The factor by which the bar of a mean grows, given its standard error and its indirect part.
    ///
    /// Source: docs/methods.md (9).
    pub(super) fn widening(self, standard_error_lx: f64, indirect_lx: f64) -> f64 {
        if indirect_lx <= 0.0 {
            return 1.0;
        }
        let skewness = (self.0 * standard_error_lx / indirect_lx).min(MOST_SKEWNESS);
        1.0 + PER_SQUARED_SKEWNESS * skewness * skewness
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::maps::standard_error;
    use crate::sampling::random::{Purpose, Stream};

    /// Quantile of 95.4% of Student's t with 15 degrees of freedom.
    const T: f64 = 2.174;

    /// Share of 40,000 entries (1,000 maps of 40; seed 1) whose bar holds the truth, plain and widened: scores come `mean_count`
    /// times in a replica in the mean, exponential to a power.
    fn coverage(mean_count: f64, power: i32) -> [f64; 2] {
        let mut stream = Stream::new(1, Purpose::Pilot, 0, 0);
        let exponential = |stream: &mut Stream| -(1.0 - stream.unit()).ln();
        let truth = mean_count * (1..=power).map(f64::from).product::<f64>();
        let mut held = [0.0; 2];
        for map in 0..1000 {
            stream.seek(map);
            let entries: Vec<[f64; REPLICAS]> = (0..40)
                .map(|_| {
                    std::array::from_fn(|_| {
                        let (mut time, mut sum) = (exponential(&mut stream), 0.0);
                        while time < mean_count {
                            sum += exponential(&mut stream).powi(power);
                            time += exponential(&mut stream);
                        }
                        sum
                    })
                })
                .collect();
            let spreads: Vec<Spread> = entries
                .iter()
                .map(|values| {
                    let value = |replica: usize| values[replica];
                    Spread::of(value, value)
                })
                .collect();
            let skewness = Skewness::of(spreads.iter());
            for (spread, values) in spreads.iter().zip(&entries) {
                let deviation = (spread.scale_lx - truth).abs();
                let error = standard_error(|replica| values[replica]);
                let factor = skewness.widening(error, spread.scale_lx);
                held[0] += f64::from(u8::from(deviation <= T * error));
                held[1] += f64::from(u8::from(deviation <= T * factor * error));
            }
        }
        held.map(|count| count / 40_000.0)
    }

    /// The plain bars are the planted fault: they must fail where the widened ones pass.
    #[test]
    fn widened_bars_hold_what_plain_ones_lose() {
        for (mean_count, power) in [(2.0, 1), (3.0, 2)] {
            let [plain, widened] = coverage(mean_count, power);
            assert!(plain < 0.934, "{mean_count} {power}: {plain}");
            assert!((0.934..0.974).contains(&widened), "{mean_count} {power}: {plain} {widened}");
        }
    }

    #[test]
    fn bars_of_many_scores_stay() {
        let [plain, widened] = coverage(200.0, 0);
        assert!((plain - 0.954).abs() < 0.006 && (widened - plain).abs() < 0.004, "{plain} {widened}");
    }
}
