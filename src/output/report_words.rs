//! Whole sentences of a report.

use super::numbers::percent;
use super::texts::say;
use crate::solver::{Solution, StopReason};

/// The target and the error that was reached.
pub fn target_words(solution: &Solution) -> String {
    let meaning = say!(
        "It is the root mean square of the deviations of all values of a map from the exact ones, over the map's \
                   average, as estimated from two independent halves of the computation"
    );
    match (solution.target_error, solution.stated_error().map(percent)) {
        (Some(target), Some(stated)) => say!(
            "The computation was to go on until the stated error of every map asked for is at most {}; the largest is {}. {}.",
            percent(target),
            stated,
            meaning
        ),
        (Some(target), None) => say!(
            "The computation was to go on until the stated error of every map asked for is at most {}; a map that no light has reached has none. {}.",
            percent(target),
            meaning
        ),
        (None, Some(stated)) => say!("The largest stated error of the maps asked for is {}. {}.", stated, meaning),
        (None, None) => say!("Light has not reached every map asked for, and there no error is stated. {}.", meaning),
    }
}

/// How the values were computed, and the basis of their errors.
pub fn method_words(solution: &Solution) -> String {
    match solution.replicas {
        0 => say!("The light that surfaces throw to each other was computed from the luminaires' data and the reflectances, as often as it is \
              thrown back, without a limit to their number. The error of the values was estimated beside them.")
            .to_owned(),
        replicas => say!("Light was followed on its ways from the luminaires, as often as surfaces throw it back, without a limit to their number. All of \
             it was computed {} times over, independently; what these computations differ by gives the error of every value.", replicas),
    }
}

/// Why the run ended.
pub fn stop_words(solution: &Solution) -> String {
    let why = solution.why_unmet().map_or(String::new(), |why| say!(", and {}", why));
    match (solution.stop_reason, solution.target_met) {
        (StopReason::Exact, _) => say!("Every value follows from formulas: nothing is left to chance.").to_owned(),
        (StopReason::Interrupted, _) => {
            say!("The run was interrupted; the values are as exact as they had become by then.").to_owned()
        }
        (StopReason::VerdictsDecided, _) => {
            say!("The computation went on until every requirement was decided, met or not, and ended there.").to_owned()
        }
        (StopReason::Undecided, _) => {
            say!("Some verdicts stay undecided: the values lie nearer to their limits than the least error that was to be gone to.").to_owned()
        }
        (_, Some(true)) => say!("The target was met.").to_owned(),
        (StopReason::Shares, Some(false)) => say!("The target was not met by the shares that were merged{}.", why),
        (StopReason::Shares, None) => say!("All shares of the computation are in these values.").to_owned(),
        (StopReason::TimeLimit, Some(false)) => {
            say!("The target was not met: the time granted was used up before{}.", why)
        }
        (_, Some(false)) => say!("The target was not met: the light paths granted were used up before{}.", why),
        (StopReason::TimeLimit, None) => say!("The run ended with the time granted to it.").to_owned(),
        (_, None) => say!("The run ended with the light paths granted to it.").to_owned(),
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
            say!("average, least and greatest illuminance of a grid's points, or of the cells of a grid by EN 12464-1 on a surface; a surface that is not flat, or has coarser elements than that grid, has no least and greatest"),
        ),
        (
            say!("U<sub>0</sub>, U<sub>d</sub>"),
            say!("uniformities: the least illuminance over the average, and over the greatest"),
        ),
        (
            say!("–, &lt; x"),
            say!("not known: there is nothing to tell it of, or it lies under its own error and is below x in nineteen cases of twenty"),
        ),
        (
            say!("Maintained"),
            say!("what is left when lamps have aged and dust has settled: all values hold with the maintenance factors of the schedule"),
        ),
        (
            say!("Stated error"),
            say!("how far the values of a map lie from the exact ones: a root mean square over the map, relative to its average. Single values may be off by two or three times as much"),
        ),
        (
            say!("± (standard error)"),
            say!("how far one number, such as an average, is likely to be off by chance. An average over many points is far more exact than each of them"),
        ),
        (
            say!("Isolux line"),
            say!("a line along which illuminance is the same"),
        ),
        (
            say!("Reflectance"),
            say!("the share of incident light that a surface throws back"),
        ),
        (
            say!("W/m² for 100 lx"),
            say!("the electric power that 100 lx take on each square metre of floor: less is better"),
        ),
    ]
    .map(|(term, meaning)| (term.to_owned(), meaning.to_owned()))
    .to_vec()
}
