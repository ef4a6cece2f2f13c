//! Sums that keep the digits that a plain loop would lose.

/// A compensated sum after Neumaier: the rounding error of every addition is kept and added at the end.
///
/// Accuracy: the result equals that of a sum in about twice the working precision, rounded once.
/// Source: A. Neumaier, "Rundungsfehleranalyse einiger Verfahren zur Summation endlicher Summen", 1974.
///
/// ```
/// use luxmc::base::sum::CompensatedSum;
///
/// let mut sum = CompensatedSum::new();
/// for term in [1.0, 1e100, 1.0, -1e100] {
///     sum.add(term);
/// }
/// assert_eq!(sum.value(), 2.0);
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CompensatedSum {
    sum: f64,
    lost: f64,
}

impl CompensatedSum {
    /// An empty sum, 0.
    pub const fn new() -> CompensatedSum {
        CompensatedSum { sum: 0.0, lost: 0.0 }
    }

    /// Adds one term.
    #[inline]
    pub fn add(&mut self, term: f64) {
        let next = self.sum + term;
        // The part that the addition lost can be recovered exactly from the larger of the two operands. Once the sum is infinite or NaN,
        // nothing can be recovered, and the difference would turn infinity into NaN.
        if next.is_finite() {
            self.lost += if self.sum.abs() >= term.abs() { (self.sum - next) + term } else { (term - next) + self.sum };
        }
        self.sum = next;
    }

    /// Adds another sum, including its lost part.
    pub fn merge(&mut self, other: CompensatedSum) {
        self.add(other.sum);
        self.lost += other.lost;
    }

    /// Returns the sum so far.
    #[inline]
    pub fn value(&self) -> f64 {
        self.sum + self.lost
    }
}

impl Extend<f64> for CompensatedSum {
    fn extend<I: IntoIterator<Item = f64>>(&mut self, terms: I) {
        for term in terms {
            self.add(term);
        }
    }
}

impl FromIterator<f64> for CompensatedSum {
    fn from_iter<I: IntoIterator<Item = f64>>(terms: I) -> CompensatedSum {
        let mut sum = CompensatedSum::new();
        sum.extend(terms);
        sum
    }
}

/// Returns the compensated sum of some terms.
pub fn compensated_sum(terms: impl IntoIterator<Item = f64>) -> f64 {
    terms.into_iter().collect::<CompensatedSum>().value()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_plain_sum_loses_is_kept() {
        let terms = [1.0, 1e100, 1.0, -1e100];
        assert_eq!(terms.iter().sum::<f64>(), 0.0);
        assert_eq!(compensated_sum(terms), 2.0);
    }

    #[test]
    fn ten_million_tenths_are_a_million() {
        let sum = compensated_sum((0..10_000_000).map(|_| 0.1));
        // The f64 nearest to a tenth is 0.1 + 5.55e-18. The exact sum is therefore 1e6 + 5.55e-11, and 1e6 is the nearest f64.
        assert_eq!(sum, 1e6);
    }

    #[test]
    fn merged_sums_are_one_sum() {
        let mut first: CompensatedSum = [1.0, 1e100].into_iter().collect();
        first.merge([1.0, -1e100].into_iter().collect());
        assert_eq!(first.value(), 2.0);
    }

    #[test]
    fn infinity_and_nan_pass_through() {
        assert_eq!(compensated_sum([1.0, f64::INFINITY, 2.0]), f64::INFINITY);
        assert!(compensated_sum([1.0, f64::NAN]).is_nan());
    }
}
