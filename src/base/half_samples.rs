//! Errors of anything that is made of sixteen replicas: by all ways to part them in halves that know nothing of each other.
//!
//! A Hadamard matrix of order 16 has fifteen rows with eight +1 and eight −1, orthogonal to each other. Each parts the replicas; what the
//! halves are off the mean by, ±δ_j, has for linear results the variance of the mean in its own mean square (docs/methods.md (38)). For results that are
//! not linear, such as counts of hours, the halves are taken through the same computation.

/// Replicas that are parted.
pub const PARTED: usize = 16;
/// Ways to part them.
pub const PARTINGS: usize = PARTED - 1;

/// Mean of the replicas, and what the first half of each parting is off it by; the second is off by as much the other way.
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

/// Standard error of a result by what it is for both halves of each parting.
pub fn standard_error(of_halves: impl Iterator<Item = [f64; 2]>) -> f64 {
    let mut sum = 0.0;
    for [one, other] in of_halves {
        sum += 0.25 * (one - other) * (one - other);
    }
    (sum / PARTINGS as f64).sqrt()
}

/// The same of a linear result: by what the first half of each parting is off its mean.
pub fn error_of_mean(off: &[f64; PARTINGS]) -> f64 {
    standard_error(off.iter().map(|off| [*off, -*off]))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of a linear result the error is that of the mean of sixteen numbers; with a sign wrong, the planted fault, it is not. Halves are means of
    /// eight replicas each.
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
        // The last parting by the bits that place and number have in common.
        let plus = (0..16usize).filter(|place| (place & 15).count_ones() % 2 == 0).map(|place| replicas[place]);
        assert!((mean + halves[14] - plus.sum::<f64>() / 8.0).abs() < 1e-12);
    }
}
