//! A stored run as truth: the result directory of a long `luxmc solve`. Its standard errors add to those of the judged run.

use std::path::{Path, PathBuf};

use glam::DVec3;
use serde_json::Value;

use super::comparison::ELEMENT_MAP;
use super::error::CaseError;
use super::exact::{Exact, LightPart, TruthSite};
use super::fields::read_text;
use super::reference::SAME_PLACE_M;
use super::statistics::SAME_SUM;
use super::words::percent;
use crate::scene::Scene;

/// Number of seeds that `luxmc compare` may use for a ladder, following the run's seed: up to 64 doublings of four seeds each.
const SEEDS_OF_A_LADDER: u64 = 256;

/// The results of a stored run for one map.
#[derive(Debug)]
pub(super) struct StoredRun {
    folder: PathBuf,
    summary: Value,
    map: String,
    rows: Vec<StoredRow>,
    /// Name, area in m², average in lx and its standard error in lx of each row of `tables.csv` for a front side.
    tables: Vec<(String, f64, f64, f64)>,
}

/// A row of the stored map: a point or an element side.
#[derive(Debug)]
struct StoredRow {
    surface: String,
    position_m: DVec3,
    illuminance_lx: f64,
    direct_lx: f64,
    indirect_lx: f64,
    standard_error_lx: f64,
}

impl StoredRun {
    /// Reads the results of a map from a result directory, and checks that they belong to the same scene.
    ///
    /// # Errors
    ///
    /// A directory without results, a map that was not computed, or results of another scene.
    pub fn read(folder: &Path, map: &str, scene: &Scene) -> Result<StoredRun, CaseError> {
        let path = folder.join("summary.json");
        let text = read_text(&path, "the stored run cannot be read")?;
        let summary: Value = serde_json::from_str(&text).map_err(|error| {
            let remedy = "compute the run again: luxmc solve SCENE --out DIR";
            CaseError::new(&path, "the stored run's summary is not valid JSON", error.to_string(), "a summary", remedy)
        })?;
        check_scene(&path, &summary, scene)?;
        let rows = if map == ELEMENT_MAP {
            read_rows(&folder.join("elements.csv"), "surface", None)?
        } else {
            read_rows(&folder.join("receivers.csv"), "receiver", Some(map))?
        };
        if rows.is_empty() {
            let remedy = "compute it with --maps, or leave out the comparison of this map";
            return Err(CaseError::new(&path, "the stored run has no such map", map, "a map that it computed", remedy));
        }
        let table = CsvTable::read(&folder.join("tables.csv"))?;
        let tables = table
            .records
            .iter()
            .filter(|record| table.text(record, "side").is_ok_and(|side| side == "front"))
            .map(|record| {
                Ok((
                    table.text(record, "name")?.to_owned(),
                    table.number(record, "area_m2")?,
                    table.number(record, "average_lx")?,
                    table.number(record, "average_standard_error_lx")?,
                ))
            })
            .collect::<Result<_, CaseError>>()?;
        Ok(StoredRun { folder: folder.to_path_buf(), summary, map: map.to_owned(), rows, tables })
    }

    /// Refuses a run that uses the same random numbers as the truth. Deviations would otherwise look smaller than they are.
    ///
    /// # Errors
    ///
    /// The truth's seed is among those of the run or of a ladder that starts from it.
    pub fn check_seed(&self, seed: u64) -> Result<(), CaseError> {
        let own = self.summary["seed"].as_u64().unwrap_or(0);
        if (seed..seed.saturating_add(SEEDS_OF_A_LADDER)).contains(&own) {
            return Err(CaseError::new(
                &self.folder.join("summary.json"),
                "the stored run shares its random numbers with the runs that are compared with it",
                format!("seed {own}, and runs with seeds from {seed} on"),
                format!("a run whose seed is above {own}, or at least {SEEDS_OF_A_LADDER} below it"),
                "give the runs another \"seed\"",
            ));
        }
        Ok(())
    }

    /// The value at a site, with its standard error as uncertainty. The error of a part of the light is at most that of the whole.
    pub fn exact(&self, site: &TruthSite, light: LightPart) -> Result<Exact, String> {
        let row = match site {
            TruthSite::Point { index, position_m, .. } => self.row(*index, *position_m)?,
            TruthSite::Element { index, corners_m: [a, b, c], surface } => {
                let row = self.row(*index, (*a + *b + *c) / 3.0)?;
                if row.surface != *surface {
                    return Err(self.misfit(*index, &row.surface, surface));
                }
                row
            }
            TruthSite::Average { surface } => return self.average(surface.unwrap_or(&self.map), light),
        };
        let value_lx = match light {
            LightPart::Total => row.illuminance_lx,
            LightPart::Direct => row.direct_lx,
            LightPart::Indirect => row.indirect_lx,
        };
        Ok(Exact { value: value_lx, uncertainty: row.standard_error_lx, ..Exact::default() })
    }

    /// Standard error of the mean over a map, or over the surfaces for which `counts` is true. For several surfaces it is an upper
    /// limit: the mean of their errors.
    pub fn average_error_lx(&self, counts: impl Fn(&str) -> bool) -> f64 {
        let rows = || self.tables.iter().filter(|(name, ..)| *name == self.map || counts(name));
        let weight = |area_m2: f64| if area_m2 > 0.0 { area_m2 } else { 1.0 };
        let area_m2: f64 = rows().map(|(_, area_m2, ..)| weight(*area_m2)).sum();
        rows().map(|(_, area_m2, _, error_lx)| weight(*area_m2) * error_lx).sum::<f64>() / area_m2
    }

    /// Describes the run for a reader.
    pub fn in_words(&self) -> String {
        format!(
            "a stored run of luxmc itself (method {}, seed {}, stated error {}); its standard errors are added to those of the compared run",
            self.summary["method"].as_str().unwrap_or("unknown"),
            self.summary["seed"],
            percent(self.summary["estimated_error"].as_f64().unwrap_or(f64::NAN))
        )
    }

    fn row(&self, index: usize, position_m: DVec3) -> Result<&StoredRow, String> {
        let there = || self.folder.display();
        let row = self.rows.get(index).ok_or_else(|| format!("{}: \"{}\" has no row {index}", there(), self.map))?;
        let near = row.position_m.distance(position_m) <= SAME_PLACE_M;
        if near { Ok(row) } else { Err(self.misfit(index, row.position_m, position_m)) }
    }

    fn misfit(&self, index: usize, got: impl std::fmt::Display, expected: impl std::fmt::Display) -> String {
        format!("{}, \"{}\", row {index}: {got}, the scene has {expected}", self.folder.display(), self.map)
    }

    fn average(&self, name: &str, light: LightPart) -> Result<Exact, String> {
        if light != LightPart::Total {
            return Err("a stored run has averages of the total only".to_owned());
        }
        let row = self.tables.iter().find(|(known, ..)| known == name);
        let (.., value_lx, error_lx) = row.ok_or_else(|| format!("its table has no row \"{name}\""))?;
        Ok(Exact { value: *value_lx, uncertainty: *error_lx, ..Exact::default() })
    }
}

fn check_scene(path: &Path, summary: &Value, scene: &Scene) -> Result<(), CaseError> {
    let flux_lm: f64 = scene.luminaires.iter().map(|luminaire| luminaire.luminous_flux_lm).sum();
    let numbers = [
        ("surfaces", scene.surfaces.len() as f64),
        ("triangles", scene.triangles.len() as f64),
        ("luminous_flux_lm", flux_lm),
    ];
    for (key, ours) in numbers {
        let theirs = summary[key].as_f64().unwrap_or(f64::NAN);
        let is_same = (theirs - ours).abs() <= SAME_SUM * ours.abs();
        if !is_same {
            return Err(CaseError::new(
                path,
                "the stored run computed another scene",
                format!("{key} {theirs}"),
                format!("{ours}, as the scene has"),
                "compute the run again: luxmc solve SCENE --out DIR",
            ));
        }
    }
    Ok(())
}

fn read_rows(path: &Path, name_column: &str, name: Option<&str>) -> Result<Vec<StoredRow>, CaseError> {
    let table = CsvTable::read(path)?;
    let mut rows = Vec::new();
    for record in &table.records {
        let owner = table.text(record, name_column)?;
        if name.is_some_and(|name| owner != name) {
            continue;
        }
        let number = |column: &str| table.number(record, column);
        rows.push(StoredRow {
            surface: owner.to_owned(),
            position_m: DVec3::new(number("x")?, number("y")?, number("z")?),
            illuminance_lx: number("illuminance_lx")?,
            direct_lx: number("direct_lx")?,
            indirect_lx: number("indirect_lx")?,
            standard_error_lx: number("standard_error_lx")?,
        });
    }
    Ok(rows)
}

/// A CSV table of a result directory.
struct CsvTable {
    path: PathBuf,
    header: csv::StringRecord,
    records: Vec<csv::StringRecord>,
}

impl CsvTable {
    fn read(path: &Path) -> Result<CsvTable, CaseError> {
        let refuse = |error: csv::Error| {
            let remedy = "compute the run again: luxmc solve SCENE --out DIR";
            CaseError::new(path, "the stored run cannot be read", error.to_string(), "a table of results", remedy)
        };
        let mut reader = csv::Reader::from_path(path).map_err(refuse)?;
        let header = reader.headers().map_err(refuse)?.clone();
        let records = reader.records().collect::<Result<_, _>>().map_err(refuse)?;
        Ok(CsvTable { path: path.to_path_buf(), header, records })
    }

    fn text<'r>(&self, record: &'r csv::StringRecord, column: &str) -> Result<&'r str, CaseError> {
        let at = self.header.iter().position(|name| name == column);
        at.and_then(|at| record.get(at)).ok_or_else(|| {
            let remedy = "compute the run again: luxmc solve SCENE --out DIR";
            CaseError::new(
                &self.path,
                "the stored run lacks a column",
                column,
                "the columns of docs/formats.md",
                remedy,
            )
        })
    }

    fn number(&self, record: &csv::StringRecord, column: &str) -> Result<f64, CaseError> {
        let text = self.text(record, column)?;
        text.parse::<f64>().ok().filter(|number| number.is_finite()).ok_or_else(|| {
            let remedy = "compute the run again: luxmc solve SCENE --out DIR";
            CaseError::new(&self.path, format!("no number in column {column}"), text, "a finite number", remedy)
        })
    }
}
