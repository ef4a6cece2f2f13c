//! The χ² test that draws follow their distribution.

use statrs::distribution::{ChiSquared, ContinuousCDF};

/// Returns the p-value of the numbers of draws in bins, against the numbers expected there. Neighbouring bins are pooled until 20 draws are
/// expected.
pub fn chi_square_p(counts: &[f64], expected: &[f64]) -> f64 {
    assert_eq!(counts.len(), expected.len());
    let (mut pooled, mut pool) = (Vec::new(), (0.0, 0.0));
    for (count, expected) in counts.iter().zip(expected) {
        pool = (pool.0 + count, pool.1 + expected);
        if pool.1 >= 20.0 {
            pooled.push(std::mem::take(&mut pool));
        }
    }
    let last = pooled.len() - 1;
    pooled[last] = (pooled[last].0 + pool.0, pooled[last].1 + pool.1);
    let statistic: f64 = pooled.iter().map(|(count, expected)| (count - expected).powi(2) / expected).sum();
    ChiSquared::new(last as f64).expect("two bins or more").sf(statistic)
}

#[test]
fn the_p_value_is_that_of_tables() {
    // The quantile at 0.05 is 3.841 with one degree of freedom, 5.991 with two. The last two bins count as one.
    let one = (3.841_459_f64 * 50.0 / 2.0).sqrt();
    assert!((chi_square_p(&[50.0 + one, 50.0 - one], &[50.0, 50.0]) - 0.05).abs() < 1e-6);
    let two = (5.991_465_f64 * 100.0 / 2.0).sqrt();
    let counts = [100.0 + two, 100.0 - two, 100.0, 7.0];
    assert!((chi_square_p(&counts[..3], &[100.0; 3]) - 0.05).abs() < 1e-6);
    assert_eq!(chi_square_p(&counts, &[100.0, 100.0, 100.0, 7.0]), chi_square_p(&counts[..3], &[100.0; 3]));
}
