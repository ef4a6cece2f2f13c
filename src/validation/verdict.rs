//! Conditions for a comparison to pass, in words and in numbers.

use super::comparison::Criterion;
use super::statistics::{ComparedEntry, EntrySet, Statistics, binomial_p_value, largest_expected_z};
use super::words::{percent, sigmas};

/// Significance level: a comparison allows deviations that are likely by its error bars. It gives one false alarm in 1/`ALPHA`
/// comparisons.
const ALPHA: f64 = 1e-4;
/// Factor allowed on a stated bias. The bias is measured at some points of a map, and others may have half as much more.
const ROOM_FOR_THE_STATED: f64 = 1.5;
/// Relative agreement required of values without random error: seven digits, the accuracy that an f32 shadow test leaves in a
/// position.
const EXACT_AGREEMENT: f64 = 1e-6;

/// One condition and whether it holds.
#[derive(Clone, Debug, PartialEq)]
pub struct Check {
    /// The condition in words.
    pub condition: String,
    /// What was found.
    pub found: String,
    /// Whether it holds.
    pub holds: bool,
}

/// Judges a comparison by the conditions of its criterion, and always by whether deviations are consistent with their error bars.
pub fn judge(set: &EntrySet, statistics: &Statistics, criterion: &Criterion) -> Vec<Check> {
    let mut checks = Vec::new();
    if let Some(worst) = criterion.worst {
        checks.push(Check {
            condition: format!("no value deviates by more than {}", percent(worst.0)),
            found: format!("worst {} ({})", percent(statistics.worst.value), statistics.worst.label),
            holds: statistics.worst.value <= worst.0,
        });
    }
    if let Some(most) = criterion.worst_difference {
        let size = |entry: &&ComparedEntry| entry.deviation().abs();
        let worst = set.entries.iter().max_by(|one, other| size(one).total_cmp(&size(other)));
        let worst = worst.map_or(String::new(), |entry| format!("worst {:.3} ({})", size(&entry), entry.label));
        checks.push(Check {
            condition: format!("no value deviates by more than {most}"),
            found: worst,
            holds: set.entries.iter().all(|entry| size(&entry) <= most),
        });
    }
    if let Some(true_error) = criterion.true_error {
        checks.push(Check {
            condition: format!("the true relative RMS error is at most {}", percent(true_error.0)),
            found: percent(statistics.rms),
            holds: statistics.rms <= true_error.0,
        });
    }
    if set.states_a_bias() {
        checks.push(is_within_what_is_stated(statistics));
        return checks;
    }
    if let (Some(alpha), Some(within)) = (criterion.coverage_alpha, statistics.within) {
        for (index, name) in ["one standard error", "two standard errors"].into_iter().enumerate() {
            let expected = statistics.expected_within[index];
            let independent = set.independent.min(statistics.noisy as f64);
            let p_value = binomial_p_value(within[index], expected, independent);
            checks.push(Check {
                condition: format!(
                    "{} of the values lie within {name}, tested at {} on {independent:.0} independent values",
                    percent(expected),
                    percent(alpha)
                ),
                found: format!("{} (p = {p_value:.2})", percent(within[index])),
                holds: p_value >= alpha,
            });
        }
    }
    checks.extend(fits_error_bars(set, statistics));
    checks
}

/// Checks that deviations are no larger than the bias that a method measured at some points and states.
fn is_within_what_is_stated(statistics: &Statistics) -> Check {
    let stated = statistics.random;
    Check {
        condition: format!("the true error is at most {ROOM_FOR_THE_STATED} times the stated one"),
        found: format!("{} against {}", percent(statistics.rms), percent(stated)),
        holds: statistics.rms <= ROOM_FOR_THE_STATED * stated + statistics.known_shift() + EXACT_AGREEMENT,
    }
}

fn fits_error_bars(set: &EntrySet, statistics: &Statistics) -> Vec<Check> {
    let mut checks = Vec::new();
    if let Some(worst_z) = &statistics.worst_z {
        let most = largest_expected_z(ALPHA, statistics.noisy, set.degrees_of_freedom);
        checks.push(Check {
            condition: format!(
                "no deviation exceeds {}, which happens by chance once in {:.0} such comparisons",
                sigmas(most),
                1.0 / ALPHA
            ),
            found: format!("worst {} ({})", sigmas(worst_z.value), worst_z.label),
            holds: worst_z.value <= most,
        });
        let bias_error = statistics.bias_error.hypot(statistics.known_shift());
        let bias_z = if statistics.bias == 0.0 { 0.0 } else { statistics.bias.abs() / bias_error };
        let most = largest_expected_z(ALPHA, 1, set.degrees_of_freedom);
        if statistics.count > 1 {
            checks.push(Check {
                condition: format!("the mean deviation is within {} of 0", sigmas(most)),
                found: format!("{} ({})", percent(statistics.bias), sigmas(bias_z)),
                holds: bias_z <= most,
            });
        }
    }
    if let Some(deviation) = set.worst_exact_deviation() {
        checks.push(Check {
            condition: format!("values without random error agree to {EXACT_AGREEMENT:.0e}"),
            found: if deviation == 0.0 { "they do".to_owned() } else { format!("worst {deviation:.1e}") },
            holds: deviation <= EXACT_AGREEMENT,
        });
    }
    checks
}

impl Statistics {
    /// Possible shift of the mean for known reasons, as a fraction.
    fn known_shift(&self) -> f64 {
        self.truncation + self.truth_shift + self.unaccounted
    }
}
