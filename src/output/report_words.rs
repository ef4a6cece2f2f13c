//! What a report says in whole sentences.

use super::numbers::percent;
use crate::solver::{Solution, StopReason};

/// What was aimed at and what came out.
pub fn target_words(solution: &Solution) -> String {
    let stated = percent(solution.estimated_error);
    let meaning = "It is the root mean square of the deviations of all values of a map from the exact ones, over the map's \
                   average, as estimated from two independent halves of the computation";
    match solution.target_error {
        Some(target) => format!(
            "The computation was to go on until the stated error of every map asked for is at most {}; the largest is {stated}. {meaning}.",
            percent(target)
        ),
        None => format!("The largest stated error of the maps asked for is {stated}. {meaning}."),
    }
}

/// How the values came about, and what their errors rest on.
pub fn method_words(solution: &Solution) -> String {
    match solution.replicas {
        0 => "The light that surfaces throw to each other was computed from the luminaires' data and the reflectances, as often as it is \
              thrown back, without a limit to their number. The error of the values was estimated beside them."
            .to_owned(),
        replicas => format!(
            "Light was followed on its ways from the luminaires, as often as surfaces throw it back, without a limit to their number. All of \
             it was computed {replicas} times over, independently; what these computations differ by gives the error of every value."
        ),
    }
}

/// Why the run ended.
pub fn stop_words(solution: &Solution) -> String {
    let why = solution.why_unmet().map_or(String::new(), |why| format!(", and {why}"));
    match (solution.stop_reason, solution.target_met) {
        (StopReason::Exact, _) => "Every value follows from formulas: nothing is left to chance.".to_owned(),
        (StopReason::Interrupted, _) => {
            "The run was interrupted; the values are as exact as they had become by then.".to_owned()
        }
        (StopReason::VerdictsDecided, _) => {
            "The computation went on until every requirement was decided, met or not, and ended there.".to_owned()
        }
        (StopReason::Undecided, _) => {
            "Some verdicts stay undecided: the values lie nearer to their limits than the least error that was to be gone to.".to_owned()
        }
        (_, Some(true)) => "The target was met.".to_owned(),
        (StopReason::Shares, Some(false)) => format!("The target was not met by the shares that were merged{why}."),
        (StopReason::Shares, None) => "All shares of the computation are in these values.".to_owned(),
        (StopReason::TimeLimit, Some(false)) => {
            format!("The target was not met: the time granted was used up before{why}.")
        }
        (_, Some(false)) => format!("The target was not met: the light paths granted were used up before{why}."),
        (StopReason::TimeLimit, None) => "The run ended with the time granted to it.".to_owned(),
        (_, None) => "The run ended with the light paths granted to it.".to_owned(),
    }
}

/// Terms of the report and what they mean, as markup.
pub fn explanations() -> Vec<(String, String)> {
    [
        ("Illuminance E", "the light that falls on a surface, in lux: lumens per square metre"),
        ("Ē, E<sub>min</sub>, E<sub>max</sub>", "average, least and greatest illuminance of a grid's points, or of the cells of a grid by EN 12464-1 on a surface; a surface that is not flat, or has coarser elements than that grid, has no least and greatest"),
        ("U<sub>0</sub>, U<sub>d</sub>", "uniformities: the least illuminance over the average, and over the greatest"),
        ("–, &lt; x", "not known: there is nothing to tell it of, or it lies under its own error and is below x in nineteen cases of twenty"),
        ("Maintained", "what is left when lamps have aged and dust has settled: all values hold with the maintenance factors of the schedule"),
        ("Stated error", "how far the values of a map lie from the exact ones: a root mean square over the map, relative to its average. Single values may be off by two or three times as much"),
        ("± (standard error)", "how far one number, such as an average, is likely to be off by chance. An average over many points is far more exact than each of them"),
        ("Isolux line", "a line along which illuminance is the same"),
        ("Reflectance", "the share of incident light that a surface throws back"),
        ("W/m² for 100 lx", "the electric power that 100 lx take on each square metre of floor: less is better"),
    ]
    .map(|(term, meaning)| (term.to_owned(), meaning.to_owned()))
    .to_vec()
}
