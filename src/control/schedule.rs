//! When to judge the error next.

/// Looks may not come closer than this share of the work done: more looks mean more chances to stop on a dip.
const CLOSEST_LOOK: f64 = 0.01;

/// Samples at which a map is judged next, when the forecast says it needs `needed` times the present `samples`.
///
/// Far from the goal the work at most doubles, so that a poor early forecast costs little; near it the run goes to
/// where the forecast says, and from there on by steps of one hundredth.
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

/// A map that met the target but failed a statistical check takes so many times its work to the next look: enough more to tell
/// whether it was by chance.
pub const GROWTH_AFTER_REFUSAL: f64 = 1.5;

/// Samples at which such a map is judged next.
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
