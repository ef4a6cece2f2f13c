//! Standard errors of any result that is computed from sixteen replicas, from fifteen ways to split the replicas into independent halves.
//!
//! A Hadamard matrix of order 16 has fifteen rows with eight +1 and eight −1, orthogonal to each other. Each row splits the replicas into
//! two halves, whose means differ from the total mean by ±δ_j. For a linear result the mean square of δ_j is the variance of the mean
//! (docs/methods.md (38)). For a nonlinear result, for example a count of hours, both halves go through the same computation.

/// Number of replicas that are split.
pub const PARTED: usize = 16;
/// Number of ways to split them.
pub const PARTINGS: usize = PARTED - 1;

/// Returns the mean of the replicas, and for each split the deviation of its first half from the mean. The second half has the opposite
/// deviation.
#[inline]
pub fn mean_and_halves(replicas: &[f64; PARTED]) -> (f64, [f64; PARTINGS]) {
    let mut sums = *replicas;
    let mut step = 1;
    while step < PARTED {
        for first in (0..PARTED).step_by(2 * step) {
            for place in first..first + step {
                let (one, other) = (sums[place], sums[place + step]);
                (sums[place], sums[place + step]) = (one + other, one - other);
            }
        }
        step *= 2;
    }
    let share = 1.0 / PARTED as f64;
    (share * sums[0], std::array::from_fn(|parting| share * sums[parting + 1]))
}

/// Returns the standard error of a result from its values for both halves of each split.
pub fn standard_error(of_halves: impl Iterator<Item = [f64; 2]>) -> f64 {
    let mut sum = 0.0;
    for [one, other] in of_halves {
        sum += 0.25 * (one - other) * (one - other);
    }
    (sum / PARTINGS as f64).sqrt()
}

/// Returns the standard error of a linear result from the deviations of each split's first half from the mean.
pub fn error_of_mean(off: &[f64; PARTINGS]) -> f64 {
    standard_error(off.iter().map(|off| [*off, -*off]))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// For a linear result the error equals that of the mean of sixteen numbers. With one wrong sign, the planted fault, it does not. Each
    /// half is a mean of eight replicas.
    #[test]
    fn partings_give_the_error_of_the_mean() {
        let replicas: [f64; PARTED] = std::array::from_fn(|k| ((k * k * 7 + 3 * k) % 11) as f64 + 0.1 * k as f64);
        let (mean, halves) = mean_and_halves(&replicas);
        let exact = replicas.iter().sum::<f64>() / 16.0;
        let squares: f64 = replicas.iter().map(|value| (value - exact).powi(2)).sum();
        let error = (squares / (16.0 * 15.0)).sqrt();
        let found = standard_error(halves.iter().map(|half| [mean + half, mean - half]));
        assert!((mean - exact).abs() < 1e-12 && (found - error).abs() < 1e-12, "{found}, {error}");
        let faulty = standard_error(halves.iter().map(|half| [mean + half, mean]));
        assert!((faulty - error).abs() > 1e-3, "the planted fault passed");
        // The last split separates indices by the parity of their set bits.
        let plus = (0..16usize).filter(|place| (place & 15).count_ones() % 2 == 0).map(|place| replicas[place]);
        assert!((mean + halves[14] - plus.sum::<f64>() / 8.0).abs() < 1e-12);
    }
}
