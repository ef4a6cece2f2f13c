//! Comparison of a run's map with the reference: its true error, and the number of its error bars that hold.

use crate::validation::calibration::student_within;
use crate::validation::statistics::SAME_SUM;

/// Probability level at which single error bars are judged.
pub const LEVEL: f64 = 0.95;

/// Values of a run and of the reference at a receiver.
#[derive(Clone, Copy, Debug, Default)]
pub struct JudgedEntry {
    /// Illuminance of the run in lx.
    pub value_lx: f64,
    /// Standard error of the run's value in lx.
    pub standard_error_lx: f64,
    /// Illuminance of the reference in lx.
    pub reference_lx: f64,
    /// Standard error of the reference's value in lx.
    pub reference_error_lx: f64,
    /// Weight in the map's error.
    pub weight: f64,
}

/// Judgement of a map. Errors are fractions of the reference's mean.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RoomJudgement {
    /// True error: the root of the mean square deviation minus the reference's own mean square error; 0 if the difference is
    /// negative.
    pub true_error: f64,
    /// The reference's own error.
    pub reference_error: f64,
    /// Number of error bars that can be judged.
    pub bars: usize,
    /// Number of these that contain the truth.
    pub held: usize,
}

/// Judges a map; `None` if the reference found no light or no receiver has a weight.
///
/// The error bars have the given degrees of freedom. A value stated as exact must agree within the reference's error bar alone.
pub fn judge(entries: &[JudgedEntry], degrees_of_freedom: f64) -> Option<RoomJudgement> {
    let sum = |of: fn(&JudgedEntry) -> f64| entries.iter().map(|entry| entry.weight * of(entry)).sum::<f64>();
    let weight = sum(|_| 1.0);
    let mean_lx = sum(|entry| entry.reference_lx) / weight;
    if weight <= 0.0 || mean_lx <= 0.0 {
        return None;
    }
    let mean_square_lx2 = sum(|entry| (entry.value_lx - entry.reference_lx).powi(2)) / weight;
    let noise_lx2 = sum(|entry| entry.reference_error_lx.powi(2)) / weight;

    let within = student_within(LEVEL, degrees_of_freedom);
    let bar_lx = |entry: &JudgedEntry| within * entry.standard_error_lx.hypot(entry.reference_error_lx);
    let holds = |entry: &&JudgedEntry| {
        (entry.value_lx - entry.reference_lx).abs() <= bar_lx(entry) + SAME_SUM * entry.reference_lx.abs()
    };
    let has_bar =
        |entry: &&JudgedEntry| entry.weight > 0.0 && (bar_lx(entry) > 0.0 || entry.value_lx != entry.reference_lx);
    Some(RoomJudgement {
        true_error: (mean_square_lx2 - noise_lx2).max(0.0).sqrt() / mean_lx,
        reference_error: noise_lx2.sqrt() / mean_lx,
        bars: entries.iter().filter(has_bar).count(),
        held: entries.iter().filter(has_bar).filter(holds).count(),
    })
}

#[cfg(test)]
mod tests {
    use super::super::rooms::Dice;
    use super::*;

    /// Approximately normal variate with variance 1: twelve uniform variates minus six.
    fn normal(dice: &mut Dice) -> f64 {
        (0..12).map(|_| dice.unit()).sum::<f64>() - 6.0
    }

    /// 20,000 receivers of 100 lx. The run has an error of 2 lx, the reference of 1 lx (seed 1). `off` multiplies the run's
    /// deviations but not its stated errors.
    fn entries(off: f64) -> Vec<JudgedEntry> {
        let mut dice = Dice::new("judgement", 1);
        let entry = |_| JudgedEntry {
            value_lx: 100.0 + 2.0 * off * normal(&mut dice),
            standard_error_lx: 2.0,
            reference_lx: 100.0 + normal(&mut dice),
            reference_error_lx: 1.0,
            weight: 1.0,
        };
        (0..20_000).map(entry).collect()
    }

    /// The mean square of n deviations has a relative standard error of √(2/n) = 1%. That of √5 lx minus 1 lx has 1.25% of 4 lx²,
    /// or 0.63% of its root. The bound is four of these, 2.5% of 2 lx.
    #[test]
    fn the_true_error_leaves_out_the_references_own() {
        let error = |off: f64| judge(&entries(off), 1e6).unwrap().true_error;
        assert!((error(1.0) - 0.02).abs() < 0.025 * 0.02, "{}", error(1.0));
        assert!((error(1.05) - 0.02).abs() > 0.025 * 0.02, "the planted fault of 5% passed: {}", error(1.05));
        // Error of 1 lx relative to a mean with a random deviation of 0.007%; the bound is four of these.
        assert!((judge(&entries(1.0), 1e6).unwrap().reference_error - 0.01).abs() < 3e-6);
    }

    /// A share of 95% of 20,000 has a standard error of 0.15%; the bound is four of these. Deviations 5% larger than stated hold in
    /// 93.7%.
    #[test]
    fn error_bars_hold_at_their_level() {
        let share = |off: f64| {
            let judgement = judge(&entries(off), 1e6).unwrap();
            judgement.held as f64 / judgement.bars as f64
        };
        assert!((share(1.0) - LEVEL).abs() < 0.0062, "{}", share(1.0));
        assert!((share(1.05) - LEVEL).abs() > 0.0062, "the planted fault of 5% passed: {}", share(1.05));
    }

    #[test]
    fn weights_count_and_dark_maps_have_no_error() {
        let bright = JudgedEntry { value_lx: 110.0, reference_lx: 100.0, weight: 1.0, ..JudgedEntry::default() };
        let left_out = JudgedEntry { value_lx: 900.0, reference_lx: 1.0, weight: 0.0, ..JudgedEntry::default() };
        let judgement = judge(&[bright, left_out], 15.0).unwrap();
        assert!((judgement.true_error - 0.1).abs() < 1e-12);
        // It is stated as exact but is not.
        assert_eq!((judgement.bars, judgement.held), (1, 0));
        assert_eq!(judge(&[JudgedEntry { weight: 1.0, ..JudgedEntry::default() }], 15.0), None);
        // Both values are 0 with certainty, so there is no error bar to judge.
        let dark = JudgedEntry { weight: 1.0, ..JudgedEntry::default() };
        assert_eq!(judge(&[bright, dark], 15.0).unwrap().bars, 1);
    }
}
