//! The table that a solved scene prints.

use super::number_text::significant;
use super::text_table::text_table;
use crate::solver::Solution;

const HEADER: &[&str] = &["name", "side", "Ē/lx", "±/lx", "Emin/lx", "±/lx", "Emax/lx", "U0", "±", "Ud", "error/%"];

/// One row a surface side or receiver set: average, minimum, maximum and uniformities, with standard errors.
pub fn result_table(solution: &Solution) -> String {
    let rows = solution.maps.iter().flat_map(|map| &map.tables).map(|row| {
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
