//! The position index of CIE 117: how much brighter than on the line of sight a luminaire must be to cause the same discomfort.

use glam::DVec3;

/// The variant of the position index, as text.
pub const POSITION_INDEX: &str = "table 4.1 of CIE 117:1995, interpolated; a luminaire outside of it does not count";

/// Step of both ratios in the table.
const STEP: f64 = 0.1;
/// Rows: T/R from 0 to 3.
const ROWS: usize = 31;
/// Columns: H/R from 0 to 1.9.
const COLUMNS: usize = 20;
/// Marks entries for which the table has no index.
const NO: f64 = f64::NAN;

/// Why a luminaire has no position index and therefore does not count.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Outside {
    /// It stands beside or behind the observer.
    Behind,
    /// It stands below the line of sight.
    Below,
    /// T/R is above 3.
    Aside,
    /// H/R is above 1.9, or beyond the end of its row.
    Above,
}

impl Outside {
    /// Returns the reason as text.
    pub fn explanation(self) -> &'static str {
        match self {
            Outside::Behind => "beside or behind the observer",
            Outside::Below => "below the line of sight",
            Outside::Aside => "too far aside (T/R above 3)",
            Outside::Above => "too steeply above the eye (H/R beyond the table, at most 1.9)",
        }
    }
}

/// Returns the position index of a source.
///
/// `view` is the line of sight. `towards` is the offset or the direction of the source. Up is +z. R is the distance along the line of
/// sight, T the distance aside and H the height above it. The index is interpolated linearly in T/R and H/R.
///
/// Range: 1 or more.
///
/// # Errors
///
/// The reason why the source has no index.
///
/// Source: CIE 117:1995, table 4.1, as published (7.50 at T/R = 2.7, H/R = 0.6, where its neighbours suggest 7.05).
pub fn position_index(view: DVec3, towards: DVec3) -> Result<f64, Outside> {
    let along = view.dot(towards);
    if along <= 0.0 {
        return Err(Outside::Behind);
    }
    let upwards = (DVec3::Z - view.z * view).normalize_or_zero();
    let height = towards.dot(upwards) / along;
    let aside = (towards - along * view).dot(view.cross(upwards)).abs() / along;
    if height < -ON_LINE_OF_SIGHT {
        return Err(Outside::Below);
    }
    let (row, down) = place(aside, ROWS).ok_or(Outside::Aside)?;
    let (column, across) = place(height.max(0.0), COLUMNS).ok_or(Outside::Above)?;
    // A corner without an index matters only if its weight is above 0.
    let corner = |i: usize, j: usize, weight: f64| if weight > 0.0 { weight * TABLE[row + i][column + j] } else { 0.0 };
    let index = corner(0, 0, (1.0 - down) * (1.0 - across))
        + corner(1, 0, down * (1.0 - across))
        + corner(0, 1, (1.0 - down) * across)
        + corner(1, 1, down * across);
    if index.is_nan() { Err(Outside::Above) } else { Ok(index) }
}

/// A source this far below the line of sight, as H/R, still counts as on it, because directions are rounded.
const ON_LINE_OF_SIGHT: f64 = 1e-9;

/// Returns the entry at or before a ratio and the ratio's distance from it in steps; `None` beyond the table.
fn place(ratio: f64, count: usize) -> Option<(usize, f64)> {
    let steps = ratio / STEP;
    let last = (count - 1) as f64;
    // Rounding must not push a ratio at the table's last entry beyond it.
    if steps > last * (1.0 + ON_LINE_OF_SIGHT) {
        return None;
    }
    let entry = (steps.min(last) as usize).min(count - 2);
    Some((entry, steps.min(last) - entry as f64))
}

/// Rows T/R = 0, 0.1 … 3, columns H/R = 0, 0.1 … 1.9.
#[rustfmt::skip]
const TABLE: [[f64; COLUMNS]; ROWS] = [
    [1.0, 1.26, 1.53, 1.9, 2.35, 2.86, 3.5, 4.2, 5.0, 6.0, 7.0, 8.1, 9.25, 10.35, 11.7, 13.15, 14.7, 16.2, NO, NO],
    [1.05, 1.22, 1.46, 1.8, 2.2, 2.75, 3.4, 4.1, 4.8, 5.8, 6.8, 8.0, 9.1, 10.3, 11.6, 13.0, 14.6, 16.1, NO, NO],
    [1.12, 1.3, 1.5, 1.8, 2.2, 2.66, 3.18, 3.88, 4.6, 5.5, 6.5, 7.6, 8.75, 9.85, 11.2, 12.7, 14.0, 15.7, NO, NO],
    [1.22, 1.38, 1.6, 1.97, 2.25, 2.7, 3.25, 3.9, 4.6, 5.45, 6.45, 7.4, 8.4, 9.5, 10.85, 12.1, 13.7, 15.0, NO, NO],
    [1.32, 1.47, 1.7, 1.96, 2.35, 2.8, 3.3, 3.9, 4.6, 5.4, 6.4, 7.3, 8.3, 9.4, 10.6, 11.9, 13.2, 14.6, 16.0, NO],
    [1.43, 1.6, 1.82, 2.1, 2.48, 2.91, 3.4, 3.98, 4.7, 5.5, 6.4, 7.3, 8.3, 9.4, 10.5, 11.75, 13.0, 14.4, 15.7, NO],
    [1.55, 1.72, 1.98, 2.3, 2.65, 3.1, 3.6, 4.1, 4.8, 5.5, 6.4, 7.35, 8.4, 9.4, 10.5, 11.7, 13.0, 14.1, 15.4, NO],
    [1.7, 1.88, 2.12, 2.48, 2.87, 3.3, 3.78, 4.3, 4.88, 5.6, 6.5, 7.4, 8.5, 9.5, 10.5, 11.7, 12.85, 14.0, 15.2, NO],
    [1.82, 2.0, 2.32, 2.7, 3.08, 3.5, 3.92, 4.5, 5.1, 5.75, 6.6, 7.5, 8.6, 9.5, 10.6, 11.75, 12.8, 14.0, 15.1, NO],
    [1.96, 2.2, 2.54, 2.9, 3.3, 3.7, 4.2, 4.75, 5.3, 6.0, 6.75, 7.7, 8.7, 9.65, 10.75, 11.8, 12.9, 14.0, 15.0, 16.0],
    [2.11, 2.4, 2.75, 3.1, 3.5, 3.91, 4.4, 5.0, 5.6, 6.2, 7.0, 7.9, 8.8, 9.75, 10.8, 11.9, 12.95, 14.0, 15.0, 16.0],
    [2.3, 2.55, 2.92, 3.3, 3.72, 4.2, 4.7, 5.25, 5.8, 6.55, 7.2, 8.15, 9.0, 9.9, 10.95, 12.0, 13.0, 14.0, 15.0, 16.0],
    [2.4, 2.75, 3.12, 3.5, 3.9, 4.35, 4.85, 5.5, 6.05, 6.7, 7.5, 8.3, 9.2, 10.0, 11.02, 12.1, 13.1, 14.0, 15.0, 16.0],
    [2.55, 2.9, 3.3, 3.7, 4.2, 4.65, 5.2, 5.7, 6.3, 7.0, 7.7, 8.55, 9.35, 10.2, 11.2, 12.25, 13.2, 14.0, 15.0, 16.0],
    [2.7, 3.1, 3.5, 3.9, 4.35, 4.85, 5.35, 5.85, 6.5, 7.25, 8.0, 8.7, 9.5, 10.4, 11.4, 12.4, 13.25, 14.05, 15.0, 16.0],
    [2.85, 3.15, 3.65, 4.1, 4.55, 5.0, 5.5, 6.2, 6.8, 7.5, 8.2, 8.85, 9.7, 10.55, 11.5, 12.5, 13.3, 14.05, 15.02, 16.0],
    [2.95, 3.4, 3.8, 4.25, 4.75, 5.2, 5.75, 6.3, 7.0, 7.65, 8.4, 9.0, 9.8, 10.8, 11.75, 12.6, 13.4, 14.2, 15.1, 16.0],
    [3.1, 3.55, 4.0, 4.5, 4.9, 5.4, 5.95, 6.5, 7.2, 7.8, 8.5, 9.2, 10.0, 10.85, 11.85, 12.75, 13.45, 14.2, 15.1, 16.0],
    [3.25, 3.7, 4.2, 4.65, 5.1, 5.6, 6.1, 6.75, 7.4, 8.0, 8.65, 9.35, 10.1, 11.0, 11.9, 12.8, 13.5, 14.2, 15.1, 16.0],
    [3.43, 3.86, 4.3, 4.75, 5.2, 5.7, 6.3, 6.9, 7.5, 8.17, 8.8, 9.5, 10.2, 11.0, 12.0, 12.82, 13.55, 14.2, 15.1, 16.0],
    [3.5, 4.0, 4.5, 4.9, 5.35, 5.8, 6.4, 7.1, 7.7, 8.3, 8.9, 9.6, 10.4, 11.1, 12.0, 12.85, 13.6, 14.3, 15.1, 16.0],
    [3.6, 4.17, 4.65, 5.05, 5.5, 6.0, 6.6, 7.2, 7.82, 8.45, 9.0, 9.75, 10.5, 11.2, 12.1, 12.9, 13.7, 14.35, 15.1, 16.0],
    [3.75, 4.25, 4.72, 5.2, 5.6, 6.1, 6.7, 7.35, 8.0, 8.55, 9.15, 9.85, 10.6, 11.3, 12.1, 12.9, 13.7, 14.4, 15.15, 16.0],
    [3.85, 4.35, 4.8, 5.25, 5.7, 6.22, 6.8, 7.4, 8.1, 8.65, 9.3, 9.9, 10.7, 11.4, 12.2, 12.95, 13.7, 14.4, 15.2, 16.0],
    [3.95, 4.4, 4.9, 5.35, 5.8, 6.3, 6.9, 7.5, 8.2, 8.8, 9.4, 10.0, 10.8, 11.5, 12.25, 13.0, 13.75, 14.45, 15.2, 16.0],
    [4.0, 4.5, 4.96, 5.4, 5.85, 6.4, 6.95, 7.55, 8.25, 8.85, 9.5, 10.05, 10.85, 11.55, 12.3, 13.0, 13.8, 14.5, 15.25, 16.0],
    [4.07, 4.55, 5.05, 5.47, 5.95, 6.46, 7.0, 7.65, 8.35, 8.95, 9.55, 10.1, 10.9, 11.6, 12.32, 13.0, 13.8, 14.5, 15.25, 16.0],
    [4.1, 4.6, 5.1, 5.53, 6.0, 6.5, 7.5, 7.7, 8.4, 9.0, 9.6, 10.16, 10.92, 11.63, 12.35, 13.0, 13.8, 14.5, 15.25, 16.0],
    [4.15, 4.62, 5.15, 5.56, 6.05, 6.55, 7.08, 7.73, 8.45, 9.05, 9.65, 10.2, 10.95, 11.65, 12.35, 13.0, 13.8, 14.5, 15.25, 16.0],
    [4.2, 4.65, 5.17, 5.6, 6.07, 6.57, 7.12, 7.75, 8.5, 9.1, 9.7, 10.23, 10.95, 11.65, 12.35, 13.0, 13.8, 14.5, 15.25, 16.0],
    [4.22, 4.67, 5.2, 5.65, 6.12, 6.6, 7.15, 7.8, 8.55, 9.12, 9.7, 10.23, 10.95, 11.65, 12.35, 13.0, 13.8, 14.5, 15.25, 16.0],
];

#[cfg(test)]
mod tests {
    use super::*;

    fn at(aside: f64, height: f64) -> Result<f64, Outside> {
        position_index(DVec3::X, DVec3::new(1.0, aside, height))
    }

    #[test]
    fn the_entries_and_what_lies_between_them_come_out() {
        assert!((at(0.0, 0.0).expect("ahead") - 1.0).abs() < 1e-12);
        assert!((at(1.0, 1.0).expect("a node") - 7.0).abs() < 1e-9);
        assert!((at(-3.0, 1.9).expect("the last node") - 16.0).abs() < 1e-9);
        assert!((at(0.55, 0.95).expect("between") - 0.25 * (5.50 + 6.40 + 5.50 + 6.40)).abs() < 1e-9);
        assert!((at(0.9, 1.85).expect("the last one of its row") - 15.5).abs() < 1e-9);
        // The line of sight may be tilted.
        let view = DVec3::new(0.8, 0.0, -0.6);
        let tilted = position_index(view, view + 0.3 * DVec3::new(0.6, 0.0, 0.8)).expect("above");
        assert!((tilted - 1.90).abs() < 1e-9, "{tilted}");
    }

    #[test]
    fn what_lies_outside_of_the_table_is_reported() {
        assert_eq!(at(0.0, 1.75), Err(Outside::Above));
        assert_eq!(at(0.3, 1.75), Err(Outside::Above));
        assert_eq!(at(2.0, 1.95), Err(Outside::Above));
        assert_eq!(at(3.05, 0.1), Err(Outside::Aside));
        assert_eq!(at(0.0, -0.1), Err(Outside::Below));
        assert_eq!(position_index(DVec3::X, DVec3::NEG_X), Err(Outside::Behind));
        assert_eq!(position_index(DVec3::X, DVec3::Y), Err(Outside::Behind));
    }

    /// The table agrees with the one that the reference values of the standard rooms are computed from.
    #[test]
    fn the_table_is_that_of_the_reference() {
        let text = include_str!("../../validation/ugr-tables/position_index.csv");
        let rows = text.lines().skip(1).map(|line| line.split(',').skip(1).map(|cell| cell.parse().unwrap_or(NO)));
        let given: Vec<Vec<f64>> = rows.map(Iterator::collect).collect();
        assert_eq!(given.len(), ROWS);
        for (own, given) in TABLE.iter().zip(&given) {
            assert!(own.iter().zip(given).all(|(a, b)| a == b || (a.is_nan() && b.is_nan())));
            assert_eq!(given.len(), COLUMNS);
        }
    }
}
