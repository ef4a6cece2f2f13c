//! Receiver sets as sensor grids of Radiance: points in `.pts`, illuminances in `.res`, and the list that honeybee reads.

use serde_json::json;

use super::observers::maps_of;
use super::plots::{Stems, plotted_sets};
use super::sheet::shortest;
use super::streamed::{StreamedFile, unwritable};
use super::{OutputError, ResultFile, file_name_part};
use crate::scene::{Quantity, ReceiverPoint, Scene};
use crate::solver::Solution;

/// Name of the list of grids.
pub(super) const GRIDS_INFO: &str = "grids_info.json";

/// Two files for each set (for the first sets if there are very many), and their list. Each has one line for each point, in the
/// order of `receivers.csv`: `x y z nx ny nz` with positions in m, or the illuminance in lx.
///
/// The numbers are those of `receivers.csv`, which refuses numbers that are not finite.
pub(super) fn grid_files<'a>(scene: &'a Scene, solution: &'a Solution) -> Result<Vec<StreamedFile<'a>>, OutputError> {
    let maps = maps_of(scene, solution, Quantity::is_illuminance);
    let mut stems = Stems::default();
    let mut files: Vec<StreamedFile> = Vec::new();
    let mut list = Vec::new();
    for (map, set) in maps.iter().take(plotted_sets(maps.len())) {
        let points = &scene.receivers[*set].points;
        let stem = stems.fresh(&format!("grid-{}", file_name_part(&map.name)));
        let place = |point: &ReceiverPoint| {
            let numbers: Vec<String> =
                [point.position_m, point.normal].iter().flat_map(|vector| vector.to_array()).map(shortest).collect();
            numbers.join(" ") + "\n"
        };
        files.push(lines(format!("{stem}.pts"), move || points.iter().map(place)));
        let values = &map.values.value;
        files.push(lines(format!("{stem}.res"), move || values.iter().map(|lx| shortest(*lx) + "\n")));
        list.push(json!({ "name": map.name, "identifier": stem, "count": points.len(), "group": "", "full_id": stem }));
    }
    if !list.is_empty() {
        let list = format!("{:#}\n", serde_json::Value::Array(list));
        files.push(ResultFile { name: GRIDS_INFO.to_owned(), bytes: list.into_bytes() }.into());
    }
    Ok(files)
}

/// A file whose lines are made while it is written.
fn lines<'a, I: Iterator<Item = String>>(name: String, lines: impl Fn() -> I + Send + Sync + 'a) -> StreamedFile<'a> {
    let path_name = name.clone();
    StreamedFile::new(name, move |writer| {
        lines().try_for_each(|line| writer.write_all(line.as_bytes())).map_err(|error| unwritable(&path_name, &error))
    })
}
