//! Arrays of luminaires: `columns` × `rows` copies, spanned by `u` and `v` like the points of a grid.

use std::rc::Rc;

use glam::DVec3;

use super::error::SceneError;
use super::limits::MOST_LUMINAIRES;
use super::model::Luminaire;
use super::reader::Fields;
use super::unique_names::Names;
use super::units::LengthUnit;

/// Positions of the copies of a luminaire.
pub(super) struct CopiesInRows {
    columns: u32,
    rows: u32,
    u_m: DVec3,
    v_m: DVec3,
}

/// Reads the array of a luminaire, or returns `None` if its keys give none.
pub(super) fn read(fields: &Fields, unit: LengthUnit) -> Result<Option<CopiesInRows>, SceneError> {
    let keys = ["columns", "rows", "u", "v"].map(|key| fields.get(key));
    if keys.iter().all(Option::is_none) {
        return Ok(None);
    }
    let [columns, rows, ..] = keys;
    let columns_count = columns.as_ref().map_or(Ok(1), |node| node.count("the number of columns"))?;
    let rows_count = rows.as_ref().map_or(Ok(1), |node| node.count("the number of rows"))?;
    let along = |count: u32, key: &str| match fields.get(key) {
        None if count == 1 => Ok(DVec3::ZERO),
        _ => Ok(unit.point_m(fields.need(key)?.vector()?)),
    };
    let array = CopiesInRows {
        columns: columns_count,
        rows: rows_count,
        u_m: along(columns_count, "u")?,
        v_m: along(rows_count, "v")?,
    };
    for (key, count, along_m) in [("u", columns_count, array.u_m), ("v", rows_count, array.v_m)] {
        if count > 1 && along_m == DVec3::ZERO {
            return Err(fields.need(key)?.refuse_as(
                format!("the array puts {count} luminaires in one place"),
                "a vector of length 0",
                "the vector from the first to the last luminaire",
                "give it a length, or give the luminaire more light instead",
            ));
        }
    }
    if u64::from(columns_count) * u64::from(rows_count) > MOST_LUMINAIRES {
        let blamed = columns.or(rows).unwrap_or_else(|| fields.node().clone());
        let expected = format!("at most {MOST_LUMINAIRES}");
        return Err(blamed.refuse("the array has too many luminaires", expected, "ask for fewer"));
    }
    Ok(Some(array))
}

impl CopiesInRows {
    /// Number of luminaires.
    pub fn len(&self) -> u64 {
        u64::from(self.columns) * u64::from(self.rows)
    }

    /// Adds the copies to `luminaires`, row by row: "NAME 1", "NAME 2", …
    pub fn fill(
        &self,
        fields: &Fields,
        luminaire: &Luminaire,
        names: &mut Names,
        luminaires: &mut Vec<Luminaire>,
    ) -> Result<(), SceneError> {
        let share = |index: u32, count: u32| if count > 1 { f64::from(index) / f64::from(count - 1) } else { 0.5 };
        let path: Rc<str> = fields.node().json_path().into();
        let count = self.len() as usize;
        names.reserve(count);
        // A large array allocates its memory once. Small ones share the usual growth of the list.
        if count > luminaires.len() {
            luminaires.reserve_exact(count);
        }
        for row in 0..self.rows {
            for column in 0..self.columns {
                let number = row * self.columns + column + 1;
                let name = format!("{} {number}", luminaire.name);
                if let Some(first) = names.insert(name.clone(), path.clone()) {
                    return Err(fields.need("name")?.refuse_as(
                        format!("the name {name:?} is given twice"),
                        format!("an array that contains {name:?}; {first} has that name already"),
                        "a name of its own",
                        "rename one of the two",
                    ));
                }
                let offset_m = share(column, self.columns) * self.u_m + share(row, self.rows) * self.v_m;
                let mut copy = Luminaire { name, ..luminaire.clone() };
                copy.emission.shift(offset_m);
                luminaires.push(copy);
            }
        }
        Ok(())
    }
}
