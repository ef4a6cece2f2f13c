//! Statistics of deviations: worst and RMS, in per cent and in standard errors, and their sources.

use statrs::distribution::{Binomial, ContinuousCDF, DiscreteCDF, StudentsT};

use super::exact::Exact;

/// Relative differences and errors up to this are rounding of sums, not random: values that differ less are equal.
pub(super) const SAME_SUM: f64 = 1e-9;

/// A measured value with its exact value.
#[derive(Clone, Debug, Default)]
pub struct ComparedEntry {
    /// Name of the run that measured it.
    pub run: String,
    /// Name of the point, element or surface.
    pub label: String,
    /// Index in the map.
    pub index: usize,
    /// Position along the axis of the plot in m.
    pub along_m: Option<f64>,
    /// Weight in means: an area in m², or 1.
    pub weight: f64,
    /// Measured value, in the unit of the map's quantity.
    pub measured: f64,
    /// Standard error of the measured value, in the same unit.
    pub standard_error: f64,
    /// The exact value.
    pub exact: Exact,
    /// A published number in the same unit, if there is one.
    pub beside: Option<f64>,
}

impl ComparedEntry {
    /// Measured minus exact value.
    pub fn deviation(&self) -> f64 {
        self.measured - self.exact.value
    }

    /// Returns whether the value has no random error.
    pub fn is_exact(&self) -> bool {
        self.standard_error <= SAME_SUM * self.measured.abs()
    }

    /// Known differences between the truth and the model.
    pub fn allowance(&self) -> f64 {
        self.exact.uncertainty + self.exact.unaccounted + self.exact.truncation
    }

    /// Deviation in standard errors. Known differences between truth and model are added to the error in quadrature. `None` if the
    /// value has no random error.
    pub fn z(&self) -> Option<f64> {
        (!self.is_exact()).then(|| self.deviation() / self.standard_error.hypot(self.allowance()))
    }
}

/// The numbers of one comparison.
#[derive(Clone, Debug, Default)]
pub struct EntrySet {
    /// Measured and exact values.
    pub entries: Vec<ComparedEntry>,
    /// Standard error of the weighted mean, in the unit of the values, if it is known from the replicas.
    pub average_error: Option<f64>,
    /// Effective number of independent values among the entries.
    pub independent: f64,
    /// Degrees of freedom of the standard errors.
    pub degrees_of_freedom: f64,
    /// Source of the exact numbers in words.
    pub truth_in_words: String,
    /// Standard error of the weighted mean of the exact values, in the unit of the values, if they are random themselves (a stored run).
    pub truth_average_error: Option<f64>,
    /// Whether entries belong to different runs. Each is then judged relative to its own exact value.
    pub across_runs: bool,
}

/// A largest deviation and its entry.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Worst {
    /// Size of the deviation.
    pub value: f64,
    /// Label of the entry.
    pub label: String,
}

/// Statistics of deviations. All errors are fractions.
#[derive(Clone, Debug, Default)]
pub struct Statistics {
    /// Number of entries.
    pub count: usize,
    /// Number of entries with error bars.
    pub noisy: usize,
    /// Largest |deviation| over the exact value (over the mean if the exact value is 0).
    pub worst: Worst,
    /// Largest |deviation| in standard errors.
    pub worst_z: Option<Worst>,
    /// True relative RMS error.
    pub rms: f64,
    /// RMS of the deviations in standard errors.
    pub rms_z: Option<f64>,
    /// Share of the entries with error bars within one and two standard errors.
    pub within: Option<[f64; 2]>,
    /// Expected shares within one and two standard errors by Student's t.
    pub expected_within: [f64; 2],
    /// Mean deviation over mean exact value.
    pub bias: f64,
    /// Standard error of the bias.
    pub bias_error: f64,
    /// RMS of the standard errors: the part of the deviation explained by random errors.
    pub random: f64,
    /// RMS of the change by the discretisation.
    pub discretisation: f64,
    /// RMS of the part of the discretisation that the exact values do not account for.
    pub unaccounted: f64,
    /// RMS of the light that the finite model lacks.
    pub truncation: f64,
    /// RMS of the truth's own error.
    pub truth: f64,
    /// Possible shift of the mean by the truth's own error.
    pub truth_shift: f64,
}

impl EntrySet {
    /// Returns whether the error bars are those of a measured bias: there are no replicas and no degrees of freedom.
    pub fn states_a_bias(&self) -> bool {
        self.degrees_of_freedom == 0.0 && self.entries.iter().any(|entry| !entry.is_exact())
    }

    /// Computes the statistics.
    pub fn statistics(&self) -> Statistics {
        let weight: f64 = self.entries.iter().map(|entry| entry.weight).sum();
        let mean_lx = self.entries.iter().map(|entry| entry.weight * entry.exact.value).sum::<f64>() / weight;

        // A map is judged relative to its mean, as everywhere in luxmc. Averages of different runs are judged relative to their own
        // values.
        let size_lx = |entry: &ComparedEntry| if self.across_runs { entry.exact.value } else { mean_lx };
        let rms = |of: &dyn Fn(&ComparedEntry) -> f64| {
            let square = |entry: &ComparedEntry| entry.weight * part(of(entry), size_lx(entry)).powi(2);
            (self.entries.iter().map(square).sum::<f64>() / weight).sqrt()
        };
        let own_size_lx = |entry: &ComparedEntry| if entry.exact.value > 0.0 { entry.exact.value } else { mean_lx };
        let worst = self
            .entries
            .iter()
            .map(|entry| Worst { value: part(entry.deviation().abs(), own_size_lx(entry)), label: entry.label.clone() })
            .max_by(|a, b| a.value.total_cmp(&b.value));
        let noisy: Vec<(f64, &ComparedEntry)> =
            self.entries.iter().filter_map(|entry| entry.z().map(|z| (z, entry))).collect();
        let count = noisy.len() as f64;
        let share_within = |sigmas: f64| noisy.iter().filter(|(z, _)| z.abs() <= sigmas).count() as f64 / count;
        let worst_z = noisy.iter().max_by(|a, b| a.0.abs().total_cmp(&b.0.abs()));
        let signed = |entry: &ComparedEntry| entry.weight * part(entry.deviation(), size_lx(entry));
        let truth = rms(&|entry| entry.exact.uncertainty);
        Statistics {
            count: self.entries.len(),
            noisy: noisy.len(),
            worst: worst.unwrap_or_default(),
            worst_z: worst_z.map(|(z, entry)| Worst { value: z.abs(), label: entry.label.clone() }),
            rms: rms(&|entry| entry.deviation()),
            rms_z: (!noisy.is_empty()).then(|| (noisy.iter().map(|(z, _)| z * z).sum::<f64>() / count).sqrt()),
            within: (!noisy.is_empty()).then(|| [share_within(1.0), share_within(2.0)]),
            expected_within: [1.0, 2.0].map(|sigmas| probability_within(sigmas, self.degrees_of_freedom)),
            bias: self.entries.iter().map(signed).sum::<f64>() / weight,
            bias_error: self.bias_error(weight, mean_lx),
            random: rms(&|entry| entry.standard_error),
            discretisation: rms(&|entry| entry.exact.discretisation),
            unaccounted: rms(&|entry| entry.exact.unaccounted),
            truncation: rms(&|entry| entry.exact.truncation),
            truth,
            truth_shift: self.truth_average_error.map_or(truth, |error_lx| part(error_lx, mean_lx)),
        }
    }

    /// Standard error of the mean deviation: from the replicas if they give it, otherwise from independent entries.
    fn bias_error(&self, weight: f64, mean_lx: f64) -> f64 {
        if let Some(average_error_lx) = self.average_error {
            return part(average_error_lx, mean_lx);
        }
        let square = |entry: &ComparedEntry| {
            let size_lx = if self.across_runs { entry.exact.value } else { mean_lx };
            (entry.weight * part(entry.standard_error, size_lx)).powi(2)
        };
        self.entries.iter().map(square).sum::<f64>().sqrt() / weight
    }

    /// Largest deviation beyond the allowance among entries without random error, relative to the exact value.
    pub fn worst_exact_deviation(&self) -> Option<f64> {
        self.entries
            .iter()
            .filter(|entry| entry.is_exact())
            .map(|entry| {
                let beyond_lx = (entry.deviation().abs() - entry.allowance()).max(0.0);
                if beyond_lx == 0.0 { 0.0 } else { beyond_lx / entry.exact.value.max(f64::MIN_POSITIVE) }
            })
            .reduce(f64::max)
    }
}

/// The ratio of a part to a whole, and 0 if the part is 0. A dark map of a dark room therefore has no error.
fn part(amount: f64, whole: f64) -> f64 {
    if amount == 0.0 { 0.0 } else { amount / whole }
}

/// Probability that Student's t stays within this number of standard errors.
pub fn probability_within(sigmas: f64, degrees_of_freedom: f64) -> f64 {
    StudentsT::new(0.0, 1.0, degrees_of_freedom.max(1.0)).map_or(f64::NAN, |t| 2.0 * t.cdf(sigmas) - 1.0)
}

/// The |t| that any of `values` deviations exceeds with probability at most `alpha` (Bonferroni).
pub fn largest_expected_z(alpha: f64, values: usize, degrees_of_freedom: f64) -> f64 {
    let tail = alpha / (2.0 * values.max(1) as f64);
    StudentsT::new(0.0, 1.0, degrees_of_freedom.max(1.0)).map_or(f64::NAN, |t| -t.inverse_cdf(tail))
}

/// Two-sided p-value: the probability that the share deviates at least this far from the expected share, for this number of
/// independent values.
pub fn binomial_p_value(share: f64, expected: f64, independent: f64) -> f64 {
    let n = independent.round().max(1.0) as u64;
    let hits = (share * n as f64).round() as u64;
    let Ok(binomial) = Binomial::new(expected, n) else {
        return f64::NAN;
    };
    let at_most = binomial.cdf(hits);
    let at_least = if hits == 0 { 1.0 } else { 1.0 - binomial.cdf(hits - 1) };
    (2.0 * at_most.min(at_least)).min(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn entry(measured: f64, standard_error: f64) -> ComparedEntry {
        let exact = Exact { value: 100.0, ..Exact::default() };
        ComparedEntry {
            label: measured.to_string(),
            weight: 1.0,
            measured,
            standard_error,
            exact,
            ..ComparedEntry::default()
        }
    }

    #[test]
    fn deviations_are_summed_up_as_by_hand() {
        let entries = vec![entry(101.0, 1.0), entry(97.0, 1.0), entry(100.0, 0.0)];
        let set = EntrySet { entries, degrees_of_freedom: 15.0, independent: 3.0, ..EntrySet::default() };
        let statistics = set.statistics();
        assert!((statistics.worst.value - 0.03).abs() < 1e-12 && statistics.worst.label == "97");
        assert!((statistics.rms - (10.0f64 / 3.0).sqrt() / 100.0).abs() < 1e-12);
        assert!((statistics.rms_z.unwrap_or(0.0) - 5f64.sqrt()).abs() < 1e-12);
        assert_eq!(statistics.within, Some([0.5, 0.5]));
        assert!((statistics.bias + 0.02 / 3.0).abs() < 1e-12);
        assert_eq!(statistics.noisy, 2);
        assert_eq!(set.worst_exact_deviation(), Some(0.0));
    }

    #[test]
    fn quantiles_are_those_of_the_tables() {
        // Student's t at 15 degrees of freedom: P(|t| < 1) = 0.6668, t(97.5%) = 2.1314.
        assert!((probability_within(1.0, 15.0) - 0.6668).abs() < 2e-4);
        assert!((largest_expected_z(0.05, 1, 15.0) - 2.1314).abs() < 1e-3);
        assert!(largest_expected_z(1e-4, 3000, 15.0) > 8.0);
        assert!(binomial_p_value(0.5, 0.5, 100.0) > 0.9);
        // 65 of 100 at one half: two-sided 0.0035 (exact binomial).
        assert!((binomial_p_value(0.65, 0.5, 100.0) - 0.0035).abs() < 2e-4);
    }

    #[test]
    fn known_differences_count_before_chance_is_blamed() {
        let mut shifted = entry(101.0, 0.6);
        shifted.exact.truncation = 0.8;
        assert!(shifted.z().is_some_and(|z| (z - 1.0).abs() < 1e-12));
    }
}
