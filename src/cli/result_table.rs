//! The table that a solved scene prints.

use super::number_text::significant;
use super::text_table::text_table;
use crate::maps::{TableKind, TableRow};
use crate::scene::Scene;
use crate::solver::Solution;

const HEADER: &[&str] = &["name", "side", "Ē/lx", "±/lx", "Emin/lx", "±/lx", "Emax/lx", "U0", "±", "Ud", "error/%"];

const LUMINANCE_HEADER: &[&str] = &["name", "mean L/(cd/m²)", "±", "Lmin/(cd/m²)", "Lmax/(cd/m²)", "error/%"];
const GLARE_HEADER: &[&str] = &["name", "UGR", "±", "Lb/(cd/m²)", "±"];

/// One row a surface side or receiver set: average, minimum, maximum and uniformities, with standard errors. What
/// observers see follows in tables of its own.
pub fn result_table(scene: &Scene, solution: &Solution) -> String {
    let rows_of = |is_wanted: fn(TableKind) -> bool| {
        solution.maps.iter().flat_map(|map| &map.tables).filter(move |row| is_wanted(row.kind))
    };
    let mut tables = Vec::new();
    if rows_of(TableKind::is_illuminance).next().is_some() {
        tables.push(illuminance_table(rows_of(TableKind::is_illuminance)));
    }
    if rows_of(|kind| kind == TableKind::Luminance).next().is_some() {
        let rows = rows_of(|kind| kind == TableKind::Luminance).map(|row| {
            vec![
                row.name.clone(),
                significant(row.average_lx.value, 4),
                significant(row.average_lx.standard_error, 2),
                significant(row.minimum_lx.value, 4),
                significant(row.maximum_lx, 4),
                significant(100.0 * row.estimated_error, 3),
            ]
        });
        tables.push(text_table(LUMINANCE_HEADER, &[0], rows));
    }
    if !solution.glare.is_empty() {
        let rows = solution.glare.iter().map(|rating| {
            let [ugr, error] = match rating.ugr {
                _ if rating.is_low() => ["< 10".to_owned(), "–".to_owned()],
                Some(ugr) => [format!("{:.2}", ugr.value), significant(ugr.standard_error, 2)],
                None => ["–".to_owned(), "–".to_owned()],
            };
            let background = rating.background_cd_m2;
            let [value, spread] = [significant(background.value, 4), significant(background.standard_error, 2)];
            vec![scene.receivers[rating.set].name.clone(), ugr, error, value, spread]
        });
        tables.push(text_table(GLARE_HEADER, &[0], rows));
    }
    tables.join("\n")
}

fn illuminance_table<'a>(rows: impl Iterator<Item = &'a TableRow>) -> String {
    let rows = rows.map(|row| {
        vec![
            row.name.clone(),
            row.side.to_owned(),
            significant(row.average_lx.value, 4),
            significant(row.average_lx.standard_error, 2),
            significant(row.minimum_lx.value, 4),
            significant(row.minimum_lx.standard_error, 2),
            significant(row.maximum_lx, 4),
            significant(row.uniformity_u0.value, 3),
            significant(row.uniformity_u0.standard_error, 2),
            significant(row.uniformity_ud, 3),
            significant(100.0 * row.estimated_error, 3),
        ]
    });
    text_table(HEADER, &[0, 1], rows)
}
