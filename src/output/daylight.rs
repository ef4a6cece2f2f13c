//! Tables of daylight factors: a file, and the table of the report.

use serde_json::{Value, json};

use super::daylight_factors::daylight_factors;
use super::html::{HtmlTable, with_error};
use super::numbers::{lux, percent, percents_with_error, tick};
use super::picture::escaped;
use super::sheet::{Sheet, SheetCell};
use super::texts::say;
use super::verdicts::probability_words;
use super::{OutputError, StreamedFile};
use crate::maps::{
    ComponentMeans, DaylightFactors, Estimate, MapValues, NO_SKY_PERCENT, SHARES_WANTED, TableKind, TableRow,
};
use crate::scene::Scene;
use crate::solver::Solution;

/// Columns that `receivers.csv` and `tables.csv` have in addition if all light comes from the sky.
pub(super) const DAYLIGHT_FACTOR_COLUMNS: &[&str] =
    &["daylight_factor_percent", "daylight_factor_standard_error_percent"];

/// Columns of the components of the daylight factor, in files of runs and of years.
pub(super) const COMPONENT_COLUMNS: [&str; 6] = [
    "sky_component_percent",
    "sky_component_standard_error_percent",
    "externally_reflected_percent",
    "externally_reflected_standard_error_percent",
    "internally_reflected_percent",
    "internally_reflected_standard_error_percent",
];

const COLUMNS: &[&str] = &[
    "receiver",
    "outside_illuminance_lx",
    "average_percent",
    "average_standard_error_percent",
    "minimum_percent",
    "minimum_standard_error_percent",
    "median_percent",
    "median_standard_error_percent",
    "target_percent",
    "share_above_target",
    "share_above_target_standard_error",
    "target_certainty",
    "minimum_target_percent",
    "share_above_minimum_target",
    "share_above_minimum_target_standard_error",
    "minimum_target_certainty",
];

/// Makes `daylight.csv`, if there are daylight factors.
///
/// # Errors
///
/// A number that is not finite; no table may hold one.
pub(super) fn daylight_file<'a>(
    scene: &'a Scene,
    solution: &'a Solution,
) -> Result<Vec<StreamedFile<'a>>, OutputError> {
    let factors = daylight_factors(scene, solution);
    if factors.is_empty() {
        return Ok(Vec::new());
    }
    let mut sheet = Sheet::new("daylight.csv", &columns());
    for set in &factors {
        let mut fields = vec![SheetCell::Text(&set.name)];
        fields.extend(numbers(set).into_iter().map(number_or_nothing));
        sheet.row(&fields)?;
    }
    Ok(vec![sheet.finish().into()])
}

fn columns() -> Vec<&'static str> {
    [COLUMNS, &COMPONENT_COLUMNS, &["share_without_sky", "share_without_sky_standard_error"]].concat()
}

/// The values of the columns after the set's name; `None` for an unknown value.
fn numbers(set: &DaylightFactors) -> Vec<Option<f64>> {
    let both = |estimate: Estimate| [estimate.value, estimate.standard_error].map(Some);
    let mut numbers = vec![Some(set.outside_lx)];
    numbers.extend([set.average_percent, set.minimum_percent, set.median_percent].into_iter().flat_map(both));
    for which in 0..2 {
        let share = set.shares_above[which];
        numbers
            .extend([set.targets_percent[which], share.value, share.standard_error, set.certainties[which]].map(Some));
    }
    match &set.components {
        Some(means) => numbers.extend(means.percents.into_iter().chain([means.without_sky]).flat_map(both)),
        None => numbers.extend([None; 8]),
    }
    numbers
}

fn number_or_nothing<'a>(number: Option<f64>) -> SheetCell<'a> {
    number.map_or(SheetCell::Text(""), SheetCell::Number)
}

/// The entries of `summary.json`: one object for each set, whose keys are the columns of `daylight.csv`.
pub(super) fn daylight_entries(scene: &Scene, solution: &Solution) -> Vec<Value> {
    let entry = |set: &DaylightFactors| {
        let names = columns().into_iter().map(str::to_owned);
        let values = std::iter::once(json!(set.name)).chain(numbers(set).into_iter().map(|number| json!(number)));
        Value::Object(names.zip(values).collect())
    };
    daylight_factors(scene, solution).iter().map(entry).collect()
}

/// Mean daylight factor and its components in %, each with its error, to extend a receiver set's row of `tables.csv`. Empty cells
/// if the row has none.
pub(super) fn mean_fields(factors: &[DaylightFactors], row: &TableRow) -> Vec<SheetCell<'static>> {
    let is_set = matches!(row.kind, TableKind::Grid | TableKind::Points);
    let Some(set) = factors.iter().find(|set| is_set && set.name == row.name) else {
        let columns = DAYLIGHT_FACTOR_COLUMNS.len() + COMPONENT_COLUMNS.len();
        return (0..columns).map(|_| SheetCell::Text("")).collect();
    };
    let percents = set.components.map(|means| means.percents);
    let components = [0, 1, 2].map(|which| percents.map(|percents| percents[which]));
    let estimates = std::iter::once(Some(set.average_percent)).chain(components);
    let both = |estimate: Option<Estimate>| {
        [estimate.map(|estimate| estimate.value), estimate.map(|estimate| estimate.standard_error)]
    };
    estimates.flat_map(both).map(number_or_nothing).collect()
}

/// Components of a point's daylight factor in %, each with its error; empty cells if they are unknown.
pub(super) fn component_fields(values: &MapValues, index: usize, outside_lx: f64) -> [SheetCell<'static>; 6] {
    let Some(components) = values.sky_components_lx.get(index) else {
        return [const { SheetCell::Text("") }; 6];
    };
    let numbers = components.map(|component| [component.value, component.standard_error]);
    std::array::from_fn(|place| SheetCell::Number(100.0 * numbers[place / 2][place % 2] / outside_lx))
}

/// The report's table; empty if there are no daylight factors.
pub(super) fn daylight_table(scene: &Scene, solution: &Solution) -> String {
    let factors = daylight_factors(scene, solution);
    let Some(first) = factors.first() else {
        return String::new();
    };
    let [target, least] = first.targets_percent.map(|percent| say!("Area above {} %", lux(percent)));
    let mut table = HtmlTable::new(
        "",
        &[
            (say!("Receivers"), true),
            (say!("Mean<small>%</small>"), false),
            (say!("Least<small>%</small>"), false),
            (say!("Median<small>%</small>"), false),
            (&target, false),
            (&least, false),
        ],
    );
    for set in &factors {
        let share = |which: usize| {
            let wanted = percent(SHARES_WANTED[which]);
            let certainty = probability_words(set.certainties[which], set.shares_above[which].standard_error > 0.0);
            format!(
                "{}<br><small>{}</small>",
                percent(set.shares_above[which].value),
                escaped(&say!("≥ {}: {} certain", wanted, certainty))
            )
        };
        table.row(vec![
            escaped(&set.name),
            percents_cell(set.average_percent),
            percents_cell(set.minimum_percent),
            percents_cell(set.median_percent),
            share(0),
            share(1),
        ]);
    }
    let parts = component_table(&factors);
    format!(
        "<h2>{}</h2>\n<p>{}</p>\n{}{parts}",
        say!("Daylight factors"),
        say!(
            "Illuminance divided by the {} lx of an open horizontal plane under the same sky. Targets after EN 17037.",
            lux(first.outside_lx)
        ),
        table.markup()
    )
}

/// A percentage with its error, formatted as in the plots. A value below its own error is shown as an upper bound.
fn percents_cell(percents: Estimate) -> String {
    if percents.is_known() || percents.standard_error <= 0.0 {
        return percents_with_error(percents, with_error);
    }
    escaped(&percents_with_error(percents, |value, _| value.to_owned()))
}

/// Table of mean components of the daylight factor; empty if they are unknown.
fn component_table(factors: &[DaylightFactors]) -> String {
    let without = say!("Area without sky<small>sky component below {} %</small>", tick(NO_SKY_PERCENT));
    let mut table = HtmlTable::new(
        "",
        &[
            (say!("Receivers"), true),
            (say!("Sky component<small>mean, %</small>"), false),
            (say!("Externally reflected<small>mean, %</small>"), false),
            (say!("Internally reflected<small>mean, %</small>"), false),
            (&without, false),
        ],
    );
    let known: Vec<(&str, &ComponentMeans)> =
        factors.iter().filter_map(|set| Some((set.name.as_str(), set.components.as_ref()?))).collect();
    if known.is_empty() {
        return String::new();
    }
    for (name, means) in known {
        let mut cells = vec![escaped(name)];
        cells.extend(means.percents.map(percents_cell));
        cells.push(percent(means.without_sky.value));
        table.row(cells);
    }
    table.markup()
}
