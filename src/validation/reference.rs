//! Reference numbers from a CSV file beside the case.

use std::path::{Path, PathBuf};

use super::error::CaseError;
use super::exact::TruthSite;

/// Maximum distance in m between a point of the reference and the receiver, per coordinate, and between a row of a
/// stored run and its point or element: the rounding of the files.
pub(super) const SAME_PLACE_M: f64 = 1e-6;

/// A table of reference numbers. Columns `x,y,z`, if present, must match the receivers' positions. A column `surface` names the
/// surface of an average.
#[derive(Debug)]
pub(super) struct ReferenceTable {
    path: PathBuf,
    header: Vec<String>,
    rows: Vec<Vec<String>>,
}

impl ReferenceTable {
    /// Reads a table. With `set` only the rows with this text in the column `set` are kept.
    pub fn read(path: &Path, set: Option<&str>) -> Result<ReferenceTable, CaseError> {
        let refuse = |error: csv::Error| {
            let remedy = "correct the file, or write it again with the program beside it";
            CaseError::new(path, "the reference cannot be read", error.to_string(), "a CSV file with a header", remedy)
        };
        let mut reader =
            csv::ReaderBuilder::new().trim(csv::Trim::All).comment(Some(b'#')).from_path(path).map_err(refuse)?;
        let header: Vec<String> = reader.headers().map_err(refuse)?.iter().map(str::to_owned).collect();
        let mut rows = Vec::new();
        for record in reader.records() {
            rows.push(record.map_err(refuse)?.iter().map(str::to_owned).collect::<Vec<_>>());
        }
        if let Some(set) = set {
            let column = header.iter().position(|name| name == "set").ok_or_else(|| {
                let what = "the reference has no column \"set\"";
                CaseError::new(path, what, header.join(","), "a column \"set\"", "add it, or leave \"set\" out")
            })?;
            rows.retain(|row| row[column] == set);
        }
        if rows.is_empty() {
            let expected = "at least one row";
            return Err(CaseError::new(path, "the reference is empty", "no row", expected, "write the file again"));
        }
        Ok(ReferenceTable { path: path.to_path_buf(), header, rows })
    }

    /// The number of a column at a site; `None` for an empty cell.
    pub fn number(&self, column: &str, site: &TruthSite) -> Result<Option<f64>, String> {
        let at = self.column(column).ok_or_else(|| format!("{} has no column {column}", self.path.display()))?;
        let row = self.row(site)?;
        let cell = row[at].as_str();
        if cell.is_empty() {
            return Ok(None);
        }
        let number = cell.parse::<f64>().ok().filter(|number| number.is_finite());
        number
            .map(Some)
            .ok_or_else(|| format!("{}: \"{cell}\" in column {column} is not a number", self.path.display()))
    }

    fn column(&self, name: &str) -> Option<usize> {
        self.header.iter().position(|known| known == name)
    }

    fn row(&self, site: &TruthSite) -> Result<&[String], String> {
        let at = self.path.display();
        match site {
            TruthSite::Point { index, position_m, .. } => {
                let row = self.rows.get(*index).ok_or_else(|| format!("{at} has no row for point {index}"))?;
                for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
                    let Some(column) = self.column(name) else { continue };
                    let there = row[column].parse::<f64>().unwrap_or(f64::NAN);
                    let near = (there - position_m[axis]).abs() <= SAME_PLACE_M;
                    if !near {
                        return Err(format!(
                            "{at}, point {index}: {name} is {}, the receiver's is {}",
                            row[column], position_m[axis]
                        ));
                    }
                }
                Ok(row)
            }
            TruthSite::Element { index, .. } => {
                self.rows.get(*index).map(Vec::as_slice).ok_or_else(|| format!("{at} has no row for element {index}"))
            }
            TruthSite::Average { surface } => {
                let Some(column) = self.column("surface") else {
                    return Ok(&self.rows[0]);
                };
                let name = surface.unwrap_or("");
                let row = self.rows.iter().find(|row| row[column] == name);
                row.map(Vec::as_slice).ok_or_else(|| format!("{at} has no row for the surface \"{name}\""))
            }
        }
    }
}
