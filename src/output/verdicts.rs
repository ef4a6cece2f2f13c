//! The verdicts on a scene's requirements: `verdicts.csv`, the entries of `summary.json` and the table of the report.

use serde_json::{Value, json};

use super::html::{HtmlTable, with_error};
use super::numbers::{UNKNOWN, lux, significant, uncertainty, uniformity, uniformity_digits};
use super::picture::escaped;
use super::sheet::{Sheet, SheetCell};
use super::texts::{decimal, said, say};
use super::{OutputError, StreamedFile};
use crate::base::glare::rating_text;
use crate::control::Ruling;
use crate::maps::Estimate;
use crate::scene::{Area, Measure, Requirement, Scene, StandardEntry};
use crate::solver::{Finding, Solution, Verdict, verdicts};

const COLUMNS: &[&str] = &[
    "receiver",
    "requirement",
    "allowed",
    "limit",
    "asked_by",
    "value",
    "standard_error",
    "interval_low",
    "interval_high",
    "probability_met",
    "verdict",
];

/// Makes `verdicts.csv`, if a receiver set has requirements.
///
/// # Errors
///
/// A number that is not finite; no table may hold one.
pub(super) fn verdict_file<'a>(scene: &'a Scene, solution: &'a Solution) -> Result<Vec<StreamedFile<'a>>, OutputError> {
    let verdicts = verdicts(scene, solution);
    if verdicts.is_empty() {
        return Ok(Vec::new());
    }
    let mut sheet = Sheet::new("verdicts.csv", COLUMNS);
    for verdict in &verdicts {
        let requirement = &verdict.requirement;
        let required_by = required_by(requirement);
        let mut cells = vec![
            SheetCell::Text(&scene.receivers[verdict.set].name),
            SheetCell::Text(requirement.measure.key()),
            SheetCell::Text(if requirement.measure.is_at_least() { "at least" } else { "at most" }),
            SheetCell::Number(requirement.limit),
            SheetCell::Text(&required_by),
        ];
        match &verdict.finding {
            Finding::Value { estimate, certainty, .. } => cells.extend([
                SheetCell::Number(estimate.value),
                SheetCell::Number(estimate.standard_error),
                SheetCell::Number(certainty.interval[0]),
                SheetCell::Number(certainty.interval[1]),
                SheetCell::Number(certainty.probability_met),
            ]),
            Finding::BelowScale | Finding::Nothing(_) => cells.extend((0..5).map(|_| SheetCell::Text(""))),
        }
        cells.push(SheetCell::Text(verdict.ruling().name()));
        sheet.row(&cells)?;
    }
    Ok(vec![sheet.finish().into()])
}

/// Entries of `summary.json`.
pub(super) fn verdict_entries(scene: &Scene, solution: &Solution) -> Vec<Value> {
    let entry = |verdict: &Verdict| {
        let requirement = &verdict.requirement;
        let (estimate, certainty) = match &verdict.finding {
            Finding::Value { estimate, certainty, .. } => (Some(estimate), Some(certainty)),
            Finding::BelowScale | Finding::Nothing(_) => (None, None),
        };
        json!({
            "receiver": scene.receivers[verdict.set].name,
            "requirement": requirement.measure.key(),
            "allowed": if requirement.measure.is_at_least() { "at least" } else { "at most" },
            "limit": requirement.limit,
            "asked_by": required_by(requirement),
            "value": estimate.map(|estimate| estimate.value),
            "standard_error": estimate.map(|estimate| estimate.standard_error),
            "interval": certainty.map(|certainty| certainty.interval),
            "probability_met": certainty.map(|certainty| certainty.probability_met),
            "verdict": verdict.ruling().name(),
            "doubt": verdict.doubt(),
        })
    };
    verdicts(scene, solution).iter().map(entry).collect()
}

/// The table of the report with its heading; empty if there are no requirements.
pub(super) fn verdict_section(scene: &Scene, solution: &Solution) -> String {
    let verdicts = verdicts(scene, solution);
    if verdicts.is_empty() {
        return String::new();
    }
    let mut table = HtmlTable::new(
        "",
        &[
            (say!("Where"), true),
            (say!("Verdict"), true),
            (say!("Required"), true),
            (say!("Found"), false),
            (say!("95 % interval"), false),
            (say!("Probability<br>that it is met"), false),
        ],
    );
    for verdict in &verdicts {
        let [found, error, interval, probability] = finding_words(verdict);
        let doubt = verdict.doubt().map_or(String::new(), |reason| format!("<small>, {}</small>", said(reason)));
        let (class, sign) = match verdict.ruling() {
            Ruling::Met => ("met", "✓"),
            Ruling::NotMet => ("not-met", "✗"),
            Ruling::Undecided => ("undecided", "?"),
        };
        let required_by = verdict.requirement.entry.map_or(String::new(), |entry| {
            let area = area_words(verdict.requirement.area).map_or(String::new(), |words| format!(", {words}"));
            format!(" <small class=\"soft\">{}{area}</small>", entry.name())
        });
        table.row(vec![
            escaped(&scene.receivers[verdict.set].name),
            format!("<span class=\"verdict {class}\">{sign} {}</span>{doubt}", said(verdict.ruling().name())),
            with_indices(&escaped(&requirement_words(&verdict.requirement))) + &required_by,
            if error == UNKNOWN { escaped(&found) } else { with_error(&found, &error) },
            interval,
            escaped(&probability),
        ]);
    }
    format!(
        "<h2>{}</h2>\n{}<p class=\"soft small\">{}{}</p>\n",
        say!("Verdicts"),
        table.markup(),
        say!(
            "<b>met</b>, <b>not met</b>: the whole interval, which contains the exact value in 95 cases of 100, lies \
             on one side of the limit. <b>undecided</b>: the limit lies within the interval; a longer run can \
             decide. Each ± includes possible errors of the method, not only chance. The ± of a minimum or maximum \
             is that of its point alone, since the verdict takes the number of points into account; it may be \
             smaller than under Results. The authority for requirements is the standards themselves."
        ),
        entries_required(&verdicts)
    )
}

/// The tasks of the standard's entries, their required colour rendering of the luminaires (which is not computed), and the sources
/// of their numbers. Empty if there are no entries.
fn entries_required(verdicts: &[Verdict]) -> String {
    let mut listed: Vec<&StandardEntry> = Vec::new();
    for entry in verdicts.iter().filter_map(|verdict| verdict.requirement.entry) {
        if !listed.contains(&entry) {
            listed.push(entry);
        }
    }
    let items = listed.into_iter().map(|entry| {
        let task = format!("{}: {}", entry.name(), said(entry.task));
        let rendering = entry
            .colour_rendering_ra
            .map(|ra| say!("; it also requires R<sub>a</sub> ≥ {} of the luminaires, which is not computed", ra));
        format!(" {task}{}.", rendering.unwrap_or_default())
    });
    let items: String = items.collect();
    if items.is_empty() {
        return items;
    }
    let source = say!(
        "The numbers of entries were written down from knowledge of the standards; a number given in the scene file \
         replaces that of its entry."
    );
    format!("{items} {source}")
}

/// The part of the room, if it is not the task area.
fn area_words(area: Area) -> Option<&'static str> {
    match area {
        Area::Task => None,
        Area::Surroundings => Some(say!("immediate surroundings")),
        Area::Background => Some(say!("background")),
        Area::Walls => Some(say!("walls")),
        Area::Ceiling => Some(say!("ceiling")),
        Area::Cylinders => Some(say!("cylindrical")),
    }
}

/// Symbols with their indices as subscripts.
pub(super) fn with_indices(words: &str) -> String {
    ["Emin", "Emax", "U0", "Ud"].iter().fold(words.to_owned(), |words, symbol| {
        words.replace(symbol, &format!("{}<sub>{}</sub>", &symbol[..1], &symbol[1..]))
    })
}

/// How many requirements are met, in a sentence.
pub(super) fn verdict_sentence(verdicts: &[Verdict]) -> String {
    let count = |ruling: Ruling| verdicts.iter().filter(|verdict| verdict.ruling() == ruling).count();
    let [met, not_met, undecided] = [Ruling::Met, Ruling::NotMet, Ruling::Undecided].map(count);
    match (verdicts.len(), not_met, undecided) {
        (1, 0, 0) => say!("The requirement is met.").to_owned(),
        (all, 0, 0) => say!("All {} requirements are met.", all),
        (all, _, 0) => say!("{} of {} requirements are met, {} not.", met, all, not_met),
        (all, _, _) => say!("{} of {} requirements are met, {} not, {} undecided.", met, all, not_met, undecided),
    }
}

/// A requirement for reading: `Ē ≥ 500 lx`.
pub fn requirement_words(requirement: &Requirement) -> String {
    let (symbol, unit) = match requirement.measure {
        Measure::AverageLx => ("Ē", " lx"),
        Measure::MinimumLx => ("Emin", " lx"),
        Measure::MaximumLx => ("Emax", " lx"),
        Measure::UniformityU0 => ("U0", ""),
        Measure::UniformityUd => ("Ud", ""),
        Measure::DirectMinimumLx => (say!("direct Emin"), " lx"),
        Measure::DirectUniformityUd => (say!("direct Emin:Emax"), ""),
        Measure::Ugr => ("UGR", ""),
    };
    if requirement.measure == Measure::DirectUniformityUd && requirement.entry.is_some() {
        return format!("{symbol} ≥ 1:{}", (1.0 / requirement.limit).round());
    }
    let sign = if requirement.measure.is_at_least() { '≥' } else { '≤' };
    format!("{symbol} {sign} {}{unit}", decimal(requirement.limit.to_string()))
}

/// Value, standard error, interval and probability for reading.
pub fn finding_words(verdict: &Verdict) -> [String; 4] {
    let unknown = || UNKNOWN.to_owned();
    match &verdict.finding {
        Finding::Value { estimate, certainty, .. } => {
            let Estimate { value, standard_error } = *estimate;
            let number = |value: f64| match verdict.requirement.measure {
                Measure::Ugr => decimal(format!("{value:.1}")),
                measure if measure.is_illuminance() => lux(value),
                Measure::DirectUniformityUd => decimal(significant(value, 2)),
                _ => uniformity(value),
            };
            let error = match verdict.requirement.measure {
                Measure::DirectUniformityUd | Measure::Ugr => uncertainty(standard_error),
                measure if measure.is_illuminance() => uncertainty(standard_error),
                _ => uniformity_digits(*estimate)[1].clone(),
            };
            // A value below its own error is shown by its interval only.
            let [value, error] = if estimate.is_known() { [number(value), error] } else { [unknown(), unknown()] };
            let [low, high] = certainty.interval.map(number);
            [
                value,
                error,
                format!("{low} … {high}"),
                probability_words(certainty.probability_met, standard_error > 0.0),
            ]
        }
        Finding::BelowScale => [rating_text(None), unknown(), unknown(), unknown()],
        Finding::Nothing(_) => [unknown(), unknown(), unknown(), unknown()],
    }
}

/// A probability for reading. It is never shown as certain if chance is involved.
pub(super) fn probability_words(probability: f64, has_chance: bool) -> String {
    match probability {
        p if has_chance && p < 0.001 => decimal("< 0.1 %"),
        p if has_chance && p > 0.999 => decimal("> 99.9 %"),
        p => decimal(format!("{:.1} %", 100.0 * p)),
    }
}

fn required_by(requirement: &Requirement) -> String {
    match requirement.entry {
        Some(entry) if requirement.area == Area::Task => entry.name(),
        Some(entry) => format!("{}, {}", entry.name(), requirement.area.name()),
        None => "scene".to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::probability_words;

    #[test]
    fn chance_is_never_told_as_certain() {
        assert_eq!(
            [1.0, 0.9999, 0.999, 0.5, 0.0002].map(|probability| probability_words(probability, true)),
            ["> 99.9 %", "> 99.9 %", "99.9 %", "50.0 %", "< 0.1 %"]
        );
        assert_eq!([1.0, 0.0].map(|probability| probability_words(probability, false)), ["100.0 %", "0.0 %"]);
    }
}
