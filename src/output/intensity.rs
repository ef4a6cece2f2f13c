//! The intensity distribution of all light that leaves a scene: a table, and IES and EULUMDAT files that reproduce it when read.

use super::leaving_light::leaving_light;
use super::photometric_writer::{eulumdat_text, ies_text};
use super::sheet::{Sheet, SheetCell};
use super::streamed::StreamedFile;
use super::{OutputError, ResultFile, file_name_part};
use crate::scene::Scene;
use crate::solver::Solution;

const COLUMNS: &[&str] =
    &["receiver", "c_deg", "gamma_deg", "intensity_cd", "standard_error_cd", "direct_cd", "indirect_cd"];

/// Makes `intensity.csv`, and an IES and an EULUMDAT file for every distribution; no files if there are none.
///
/// # Errors
///
/// A number that is not finite; no table may hold one.
pub(super) fn intensity_files<'a>(
    scene: &'a Scene,
    solution: &'a Solution,
) -> Result<Vec<StreamedFile<'a>>, OutputError> {
    let all = leaving_light(scene, solution);
    if all.is_empty() {
        return Ok(Vec::new());
    }
    let mut sheet = Sheet::new("intensity.csv", COLUMNS);
    let mut files = Vec::new();
    for light in &all {
        let values = &light.map.values;
        for (plane, step) in
            (0..light.table.planes).flat_map(|plane| (0..=light.table.steps).map(move |step| (plane, step)))
        {
            let entry = light.table.entry(plane, step);
            sheet.row(&[
                SheetCell::Text(&light.map.name),
                SheetCell::Number(light.table.c_deg(plane)),
                SheetCell::Number(light.table.gamma_deg(step)),
                SheetCell::Number(values.value[entry]),
                SheetCell::Number(values.standard_error[entry]),
                SheetCell::Number(values.direct[entry]),
                SheetCell::Number(values.indirect[entry]),
            ])?;
        }
        let stem = format!("intensity-{}", file_name_part(&light.map.name));
        files.push(ResultFile { name: format!("{stem}.ies"), bytes: ies_text(scene, light).into_bytes() });
        files.push(ResultFile { name: format!("{stem}.ldt"), bytes: eulumdat_text(scene, light).into_bytes() });
    }
    files.insert(0, sheet.finish());
    Ok(files.into_iter().map(StreamedFile::from).collect())
}
