//! Growth of a cost with a size: straight lines on logarithmic axes.

/// cost ∝ size^slope.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Slope {
    /// Exponent over all sizes, by least squares.
    pub fitted: f64,
    /// Standard error of the exponent, from the scatter about the line; 0 for two sizes, which leave no scatter.
    pub standard_error: f64,
    /// Exponent between the largest size and the next smaller one that differs by a factor of [`APART`] or more. A line through all
    /// sizes hides this exponent if small sizes cost little more than the start.
    pub last: f64,
}

/// Minimum factor between the sizes of the last exponent. Closer sizes would mostly show noise.
pub const APART: f64 = 8.0;

impl Slope {
    /// Fits a line through `(size, cost)`, in order of size; `None` for fewer than two points above 0.
    pub fn through(places: &[(f64, f64)]) -> Option<Slope> {
        let logs: Vec<(f64, f64)> = places
            .iter()
            .filter(|(size, cost)| *size > 0.0 && *cost > 0.0)
            .map(|(size, cost)| (size.ln(), cost.ln()))
            .collect();
        let count = logs.len() as f64;
        let (x, y) = (
            logs.iter().map(|place| place.0).sum::<f64>() / count,
            logs.iter().map(|place| place.1).sum::<f64>() / count,
        );
        let squares: f64 = logs.iter().map(|place| (place.0 - x).powi(2)).sum();
        if logs.len() < 2 || squares == 0.0 {
            return None;
        }
        let fitted = logs.iter().map(|place| (place.0 - x) * (place.1 - y)).sum::<f64>() / squares;
        let rest: f64 = logs.iter().map(|place| (place.1 - y - fitted * (place.0 - x)).powi(2)).sum();
        let variance = if logs.len() > 2 { rest / (count - 2.0) / squares } else { 0.0 };
        let largest = logs[logs.len() - 1];
        let before = logs.iter().rev().find(|place| largest.0 - place.0 >= APART.ln()).unwrap_or(&logs[0]);
        let last = (largest.1 - before.1) / (largest.0 - before.0);
        Some(Slope { fitted, standard_error: variance.sqrt(), last })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_slope_is_that_of_the_law_and_its_error_that_of_the_scatter() {
        let law: Vec<(f64, f64)> = (0..7).map(|k| (10f64.powi(k), 3.0 * 10f64.powi(k).powf(0.7))).collect();
        let slope = Slope::through(&law).expect("seven places");
        assert!((slope.fitted - 0.7).abs() < 1e-12 && slope.standard_error < 1e-12 && (slope.last - 0.7).abs() < 1e-12);

        // Costs scatter by e^±0.1 alternately over seven decades. Standard error by hand: se = √(Σr²/(n−2)/Σ(x−x̄)²). The residuals
        // are ±0.1 minus their mean of 1/70, which has no slope. So Σr² = 0.07 − 7/70² and Σ(x−x̄)² = 28 ln²10.
        let noisy: Vec<(f64, f64)> = law
            .iter()
            .enumerate()
            .map(|(k, (x, y))| (*x, y * (if k % 2 == 0 { 0.1f64 } else { -0.1 }).exp()))
            .collect();
        let slope = Slope::through(&noisy).expect("seven places");
        let by_hand = ((0.07 - 7.0 / 4900.0) / 5.0 / (28.0 * 10f64.ln().powi(2))).sqrt();
        assert!((slope.fitted - 0.7).abs() < 1e-12, "{slope:?}");
        assert!((slope.standard_error - by_hand).abs() < 1e-12, "{slope:?} {by_hand}");

        // A constant start of 1e4 hides the linear end from the line through all sizes, but not from the last exponent.
        let started: Vec<(f64, f64)> = (0..7).map(|k| (10f64.powi(k), 1e4 + 10f64.powi(k))).collect();
        let slope = Slope::through(&started).expect("seven places");
        assert!(slope.fitted < 0.5 && slope.last > 0.95, "{slope:?}");
        assert_eq!(Slope::through(&law[..1]), None);
    }
}
