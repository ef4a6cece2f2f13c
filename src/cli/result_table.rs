//! The table that is printed for a solved scene.

use super::number_text::significant;
use super::text_table::text_table;
use crate::base::glare::rating_text;
use crate::maps::{DaylightFactors, Estimate, TableKind, TableRow};
use crate::output::numbers::UNKNOWN;
use crate::output::texts::{decimal, said, say, words};
use crate::output::{LeavingLight, daylight_factors, finding_words, leaving_light, observer_words, requirement_words};
use crate::scene::Scene;
use crate::solver::{Solution, Verdict, verdicts, worst_of_sets};

const HEADER: &[&str] = &[
    words!("name"),
    words!("side"),
    "Ē/lx",
    "±/lx",
    "Emin/lx",
    "±/lx",
    "Emax/lx",
    "±/lx",
    "U0",
    "±",
    "Ud",
    "±",
    words!("error/%"),
];

const LUMINANCE_HEADER: &[&str] =
    &[words!("name"), words!("mean L/(cd/m²)"), "±", "Lmin/(cd/m²)", "Lmax/(cd/m²)", words!("error/%")];
const INTENSITY_HEADER: &[&str] =
    &[words!("name"), "Φ/lm", "±", words!("of lamps/%"), "Imax/cd", "±", "C/°", "γ/°", words!("error/%")];
const GLARE_HEADER: &[&str] = &[words!("name"), "UGR", "±", "Lb/(cd/m²)", "±"];
const GRID_GLARE_HEADER: [&str; 6] = [words!("name"), "UGR", "±", "Lb/(cd/m²)", "±", words!("observer")];

/// Largest number of rows of illuminances. A terminal shows the last of thousands only, and laying out the others would be wasted.
const MOST_ROWS: usize = 200;

const VERDICT_HEADER: &[&str] = &[
    words!("name"),
    words!("required"),
    words!("found"),
    "±",
    words!("95 % interval"),
    words!("probability"),
    words!("verdict"),
];

/// The tables of a solution: one row for each surface side or receiver set, with average, minimum, maximum, uniformities and
/// standard errors. Tables for observers follow, then the verdicts on the scene's requirements.
pub fn result_table(scene: &Scene, solution: &Solution) -> String {
    let rows_of = |is_wanted: fn(TableKind) -> bool| {
        solution.maps.iter().flat_map(|map| &map.tables).filter(move |row| is_wanted(row.kind))
    };
    let mut tables = Vec::new();
    let is_reported = |row: &&TableRow| row.kind != TableKind::Surface || (scene.is_reported(&row.name) && row.shows());
    if rows_of(TableKind::is_illuminance).any(|row| is_reported(&row)) {
        tables.push(illuminance_table(rows_of(TableKind::is_illuminance).filter(is_reported)));
    }
    let luminances = || rows_of(|kind| kind == TableKind::Luminance);
    if luminances().next().is_some() {
        tables.push(luminance_table(luminances()));
    }
    let intensities = leaving_light(scene, solution);
    if !intensities.is_empty() {
        tables.push(intensity_table(&intensities));
    }
    let factors = daylight_factors(scene, solution);
    if let Some(first) = factors.first() {
        tables.push(daylight_table(&factors, first));
    }
    if !solution.glare.is_empty() {
        tables.push(glare_table(scene, solution));
    }
    let verdicts = verdicts(scene, solution);
    if !verdicts.is_empty() {
        tables.push(verdict_table(scene, &verdicts));
    }
    tables.join("\n")
}

fn luminance_table<'a>(rows: impl Iterator<Item = &'a TableRow>) -> String {
    let rows = rows.map(|row| {
        vec![
            row.name.clone(),
            number(row.average.value, 4),
            number(row.average.standard_error, 2),
            number(row.minimum.value, 4),
            number(row.maximum.value, 4),
            number(100.0 * row.estimated_error, 3),
        ]
    });
    table_of(LUMINANCE_HEADER, &[0], rows)
}

fn intensity_table(intensities: &[LeavingLight]) -> String {
    let rows = intensities.iter().map(|light| {
        let mut cells = vec![light.map.name.clone()];
        cells.extend(value_and_error(light.luminous_flux_lm));
        cells.push(number(100.0 * light.light_output_ratio, 4));
        cells.extend(value_and_error(light.maximum_cd));
        cells.extend(light.maximum_at_deg.map(|angle_deg| angle_deg.to_string()));
        cells.push(number(100.0 * light.map.error.estimated, 3));
        cells
    });
    table_of(INTENSITY_HEADER, &[0], rows)
}

fn daylight_table(factors: &[DaylightFactors], first: &DaylightFactors) -> String {
    let [target, least] = first.targets_percent.map(|percent| format!("A ≥ {} %", number(percent, 2)));
    let header = [say!("name"), "D̄/%", "±", "Dmin/%", "±", say!("median/%"), "±", &target, "±", &least, "±"];
    let rows = factors.iter().map(|factors| {
        let [average, minimum, median] = [&factors.average_percent, &factors.minimum_percent, &factors.median_percent];
        let mut cells = vec![factors.name.clone()];
        [average, minimum, median].into_iter().for_each(|percent| cells.extend(value_and_error(*percent)));
        for share in factors.shares_above {
            let [value, error] =
                [share.value, share.standard_error].map(|share| decimal(format!("{:.1} %", 100.0 * share)));
            cells.extend([value, error]);
        }
        cells
    });
    let outside = number(first.outside_lx, 5);
    let table = text_table(&header, &[0], rows);
    say!("Daylight factors, {} lx on an open horizontal plane; A: share of the area", outside) + "\n" + &table
}

fn glare_table(scene: &Scene, solution: &Solution) -> String {
    let worst = worst_of_sets(&solution.glare);
    let has_grids = worst.iter().any(|(rating, _)| scene.receivers[rating.set].observers.len() > 1);
    let rows = worst.into_iter().map(|(rating, observers)| {
        let [ugr, error] = match rating.ugr {
            _ if rating.is_low() => [rating_text(None), UNKNOWN.to_owned()],
            Some(ugr) => [decimal(format!("{:.2}", ugr.value)), number(ugr.standard_error, 2)],
            None => [UNKNOWN.to_owned(), UNKNOWN.to_owned()],
        };
        let background = rating.background_cd_m2;
        let [value, spread] = [number(background.value, 4), number(background.standard_error, 2)];
        let set = &scene.receivers[rating.set];
        let mut cells = vec![set.name.clone(), ugr, error, value, spread];
        if has_grids {
            let place = observer_words(&set.observers[rating.observer]);
            cells.push(if set.observers.len() > 1 { say!("worst of {}, {}", observers, place) } else { place });
        }
        cells
    });
    let header = if has_grids { &GRID_GLARE_HEADER[..] } else { GLARE_HEADER };
    table_of(header, &[0, 5], rows)
}

fn verdict_table(scene: &Scene, verdicts: &[Verdict]) -> String {
    let rows = verdicts.iter().map(|verdict| {
        let [value, error, interval, probability] = finding_words(verdict);
        let doubt = verdict.doubt().map_or(String::new(), |reason| format!(", {}", said(reason)));
        vec![
            scene.receivers[verdict.set].name.clone(),
            requirement_words(&verdict.requirement),
            value,
            error,
            interval,
            probability,
            format!("{}{doubt}", said(verdict.ruling().name())),
        ]
    });
    table_of(VERDICT_HEADER, &[0, 1, 6], rows)
}

/// A table with its headings in the current language.
fn table_of(header: &[&'static str], left: &[usize], rows: impl IntoIterator<Item = Vec<String>>) -> String {
    let header: Vec<&str> = header.iter().map(|heading| said(heading)).collect();
    text_table(&header, left, rows)
}

/// A number with this many significant digits and the decimal sign of the current language.
fn number(value: f64, digits: usize) -> String {
    decimal(significant(value, digits))
}

/// An estimate and its standard error. An estimate below its own error is shown as an upper bound.
fn value_and_error(estimate: Estimate) -> [String; 2] {
    match estimate.is_known() {
        true => [number(estimate.value, 4), number(estimate.standard_error, 2)],
        false => [format!("< {}", number(estimate.upper_bound(), 2)), UNKNOWN.to_owned()],
    }
}

fn illuminance_table<'a>(mut rows: impl Iterator<Item = &'a TableRow>) -> String {
    let shown = rows.by_ref().take(MOST_ROWS).map(|row| {
        let unknown = || [UNKNOWN.to_owned(), UNKNOWN.to_owned()];
        let extreme = |extreme: Option<Estimate>| extreme.map_or_else(unknown, value_and_error);
        let uniformity = |ratio: Option<Estimate>| {
            ratio.map_or_else(unknown, |ratio| [number(ratio.value, 3), number(ratio.standard_error, 2)])
        };
        let [average, average_error] = value_and_error(row.average);
        let ([minimum, minimum_error], [maximum, maximum_error]) = (extreme(row.least()), extreme(row.greatest()));
        let ([u0, u0_error], [ud, ud_error]) = (uniformity(row.u0()), uniformity(row.ud()));
        let error = match row.average.is_known() {
            true if row.estimated_error > 1.0 => "> 100".to_owned(),
            true => number(100.0 * row.estimated_error, 3),
            false => UNKNOWN.to_owned(),
        };
        vec![
            row.name.clone(),
            row.side.to_owned(),
            average,
            average_error,
            minimum,
            minimum_error,
            maximum,
            maximum_error,
            u0,
            u0_error,
            ud,
            ud_error,
            error,
        ]
    });
    let table = table_of(HEADER, &[0, 1], shown);
    match rows.count() {
        0 => table,
        more => table + &say!("{} more rows: see tables.csv", more) + "\n",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(average_lx: [f64; 2], minimum_lx: [f64; 2]) -> String {
        row_of(average_lx, minimum_lx, [30.0, 1.0], 0.01)
    }

    fn row_of(average_lx: [f64; 2], minimum_lx: [f64; 2], maximum_lx: [f64; 2], estimated_error: f64) -> String {
        let row = table_row(average_lx, minimum_lx, maximum_lx, estimated_error);
        illuminance_table(std::iter::once(&row)).lines().last().unwrap_or_default().to_owned()
    }

    fn table_row(average_lx: [f64; 2], minimum_lx: [f64; 2], maximum_lx: [f64; 2], estimated_error: f64) -> TableRow {
        let estimate = |[value, standard_error]: [f64; 2]| Estimate { value, standard_error };
        TableRow {
            name: "ceiling".to_owned(),
            kind: TableKind::Surface,
            side: "front",
            average: estimate(average_lx),
            minimum: estimate(minimum_lx),
            maximum: estimate(maximum_lx),
            uniformity_u0: Estimate { value: 1.0, standard_error: 41.63 },
            uniformity_ud: Estimate { value: 0.5, standard_error: 0.1 },
            pulled: [0.0; 2],
            places: 4,
            area_m2: 1.0,
            covered_area_m2: 0.0,
            estimated_error,
            replica_averages: Vec::new(),
        }
    }

    #[test]
    fn of_very_many_rows_the_first_are_shown_and_the_rest_is_reported() {
        let row = table_row([20.0, 1.0], [10.0, 2.0], [30.0, 1.0], 0.01);
        let lines_of = |count: usize| {
            let table = illuminance_table(std::iter::repeat_n(&row, count));
            (table.lines().filter(|line| line.starts_with("ceiling")).count(), table.lines().last().map(str::to_owned))
        };
        let (shown, last) = lines_of(MOST_ROWS);
        assert!(shown == MOST_ROWS && last.is_some_and(|last| last.starts_with("ceiling")));
        assert_eq!(lines_of(MOST_ROWS + 30), (MOST_ROWS, Some("30 more rows: see tables.csv".to_owned())));
    }

    /// An estimate below its own error is shown as an upper bound, and no ratio of it is shown.
    #[test]
    fn numbers_that_cannot_be_are_not_printed() {
        let dark = row([-0.26, 5.0], [0.0, 5.0]);
        assert!(dark.contains("< 10") && !dark.contains("-0.26") && !dark.contains("41.63"), "{dark}");
        assert!(!dark.contains("1.00"), "no uniformity and no stated error of nothing: {dark}");
        let shaded = row([20.0, 1.0], [0.5, 2.0]);
        assert!(shaded.contains("20.00") && shaded.contains("< 4.5") && !shaded.contains("41.63"), "{shaded}");
        assert!(
            row_of([0.23, 0.22], [0.0, 4.0], [30.0, 1.0], 10.19).ends_with("> 100"),
            "an error of 1,019 % says that nothing is known"
        );
        // The greatest value is unknown, while the average is known: the table shows no bound of it, and no Ud.
        let stray = row_of([20.0, 1.0], [10.0, 2.0], [7300.0, 7330.0], 0.01);
        assert!(stray.contains("1.00") && !stray.contains('<') && !stray.contains("0.500"), "{stray}");
        let lit = row([20.0, 1.0], [10.0, 2.0]);
        assert!(lit.contains("10.00") && lit.contains("1.00") && !lit.contains('<'), "{lit}");
    }
}
