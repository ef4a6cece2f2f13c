//! Whole sentences of a report.

use super::numbers::percent;
use super::texts::say;
use crate::solver::{Solution, StopReason};

/// The target and the error that was reached.
pub fn target_words(solution: &Solution) -> String {
    let meaning = say!(
        "The stated error is the root mean square deviation of all values of a map from the exact ones, divided by \
         the map's average. It is estimated from two independent halves of the computation"
    );
    match (solution.target_error, solution.stated_error().map(percent)) {
        (Some(target), Some(stated)) => say!(
            "The target was a stated error of at most {} for every requested map; the largest stated error is {}. {}.",
            percent(target),
            stated,
            meaning
        ),
        (Some(target), None) => say!(
            "The target was a stated error of at most {} for every requested map; a map that no light has reached has no stated error. {}.",
            percent(target),
            meaning
        ),
        (None, Some(stated)) => say!("The largest stated error of the requested maps is {}. {}.", stated, meaning),
        (None, None) => say!("Light has not reached every requested map, so no error is stated. {}.", meaning),
    }
}

/// How the values were computed, and the basis of their errors.
pub fn method_words(solution: &Solution) -> String {
    match solution.replicas {
        0 => say!(
            "The light that surfaces reflect to each other was computed from the luminaires' data and the \
            reflectances, with no limit on the number of reflections. The error of the values was estimated \
            along with them."
        )
        .to_owned(),
        replicas => say!(
            "Light was followed along its paths from the luminaires, with no limit on the number of \
            reflections. The whole computation was done {} times, independently; the differences between these \
            computations give the error of every value.",
            replicas
        ),
    }
}

/// Why the run ended.
pub fn stop_words(solution: &Solution) -> String {
    let why = solution.why_unmet().map_or(String::new(), |why| say!(", and {}", why));
    match (solution.stop_reason, solution.target_met) {
        (StopReason::Exact, _) => say!("Every value was computed by formulas, without random sampling.").to_owned(),
        (StopReason::Interrupted, _) => {
            say!("The run was interrupted; the values are as accurate as they were by then.").to_owned()
        }
        (StopReason::VerdictsDecided, _) => {
            say!("The computation ended as soon as every requirement was decided, met or not met.").to_owned()
        }
        (StopReason::Undecided, _) => {
            say!("Some verdicts stay undecided: the values lie closer to their limits than the smallest error that the run was allowed to compute to.").to_owned()
        }
        (_, Some(true)) => say!("The target was met.").to_owned(),
        (StopReason::Shares, Some(false)) => say!("The target was not met with the merged shares{}.", why),
        (StopReason::Shares, None) => say!("These values contain all shares of the computation.").to_owned(),
        (StopReason::TimeLimit, Some(false)) => {
            say!("The target was not met: the time limit was reached first{}.", why)
        }
        (_, Some(false)) => say!("The target was not met: the limit of light paths was reached first{}.", why),
        (StopReason::TimeLimit, None) => say!("The run ended at its time limit.").to_owned(),
        (_, None) => say!("The run ended after the requested number of light paths.").to_owned(),
    }
}

/// Terms of the report and their meanings, as markup.
pub fn explanations() -> Vec<(String, String)> {
    [
        (
            say!("Illuminance E"),
            say!("the light that falls on a surface, in lux: lumens per square metre"),
        ),
        (
            say!("Ē, E<sub>min</sub>, E<sub>max</sub>"),
            say!("average, minimum and maximum illuminance of a grid's points, or of the cells of an EN 12464-1 grid on a surface. A surface that is not flat, or has coarser elements than that grid, has no minimum and maximum"),
        ),
        (
            say!("U<sub>0</sub>, U<sub>d</sub>"),
            say!("uniformities: the minimum illuminance divided by the average, and by the maximum"),
        ),
        (
            say!("–, &lt; x"),
            say!("–: there is no value. &lt; x: the value is smaller than its own error, and below x in nineteen cases of twenty"),
        ),
        (
            say!("Maintained"),
            say!("the value that remains when lamps have aged and dust has settled: all values include the maintenance factors of the schedule"),
        ),
        (
            say!("Stated error"),
            say!("how far the values of a map lie from the exact ones: a root mean square over the map, relative to its average. Single values may be off by two or three times as much"),
        ),
        (
            say!("± (standard error)"),
            say!("how far one number, such as an average, is likely to be off by chance. An average over many points is far more accurate than each of them"),
        ),
        (
            say!("Isolux line"),
            say!("a line along which illuminance is the same"),
        ),
        (
            say!("Reflectance"),
            say!("the share of incident light that a surface reflects"),
        ),
        (
            say!("W/m² for 100 lx"),
            say!("the electric power needed for 100 lx on each square metre of floor: less is better"),
        ),
    ]
    .map(|(term, meaning)| (term.to_owned(), meaning.to_owned()))
    .to_vec()
}
