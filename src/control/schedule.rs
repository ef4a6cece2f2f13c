//! When to judge the error (look at it) next.

/// Shortest step between two looks (error checks), as a share of the work done. More looks give more chances to stop on a dip of the error.
const CLOSEST_LOOK: f64 = 0.01;

/// Number of samples at which a map is judged next. The forecast requires `needed` times the present `samples`.
///
/// Far from the goal the work at most doubles, so a poor early forecast costs little. Closer to the goal the run covers 0.7 of the forecast
/// distance. Within 20 % it goes to the goal itself, by steps of at least one hundredth.
pub fn next_judgement(samples: u64, needed: f64) -> u64 {
    let now = samples as f64;
    let goal = now * needed;
    let next = if !needed.is_finite() || goal > 2.5 * now {
        2.0 * now
    } else if goal > 1.2 * now {
        now + 0.7 * (goal - now)
    } else {
        goal.max(now * (1.0 + CLOSEST_LOOK))
    };
    (next.ceil() as u64).max(samples + 1)
}

/// Factor on the work up to the next look, for a map that met the target but failed a statistical check. The added work is enough to show
/// whether the failure was chance.
pub const GROWTH_AFTER_REFUSAL: f64 = 1.5;

/// Number of samples at which a map that failed a statistical check is judged next.
pub fn after_refusal(samples: u64) -> u64 {
    (GROWTH_AFTER_REFUSAL * samples as f64).ceil() as u64
}

#[cfg(test)]
mod tests {
    use super::next_judgement;

    #[test]
    fn looks_double_then_approach_then_creep() {
        assert_eq!(next_judgement(100, 50.0), 200);
        assert_eq!(next_judgement(100, f64::NAN), 200);
        assert_eq!(next_judgement(1000, 2.0), 1700);
        assert_eq!(next_judgement(1000, 1.1), 1100);
        assert_eq!(next_judgement(1000, 0.9), 1010);
        assert_eq!(next_judgement(3, 0.5), 4);
    }
}
