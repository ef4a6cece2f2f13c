//! The tables for observers: luminances and glare ratings.

use std::io::Write;

use super::OutputError;
use super::sheet::{Sheet, SheetCell};
use super::streamed::StreamedFile;
use crate::maps::{MapKind, MapResult};
use crate::scene::{GlareObserver, Quantity, ReceiverSet, Scene};
use crate::solver::Solution;

pub(super) const LUMINANCES: &str = "luminance.csv";
const LUMINANCE_COLUMNS: &[&str] =
    &["receiver", "index", "x", "y", "z", "dx", "dy", "dz", "luminance_cd_m2", "standard_error_cd_m2"];
const UGR_COLUMNS: &[&str] =
    &["receiver", "x", "y", "z", "dx", "dy", "dz", "ugr", "standard_error", "background_luminance_cd_m2"];

/// The first columns of files of points: set, number, position, direction, value and error of a point.
pub(super) fn point_fields<'a>(map: &'a MapResult, set: &ReceiverSet, index: usize) -> [SheetCell<'a>; 10] {
    let point = &set.points[index];
    let [[x, y, z], [dx, dy, dz]] =
        [point.position_m, point.normal].map(|vector| vector.to_array().map(SheetCell::Number));
    let [value, error] = [&map.values.value, &map.values.standard_error].map(|all| SheetCell::Number(all[index]));
    let number = SheetCell::Count(set.index_of(index) as u64);
    [SheetCell::Text(&map.name), number, x, y, z, dx, dy, dz, value, error]
}

/// Maps of the receiver sets with a quantity, each with the index of its set.
pub(super) fn maps_of<'a>(
    scene: &'a Scene,
    solution: &'a Solution,
    is_wanted: fn(Quantity) -> bool,
) -> Vec<(&'a MapResult, usize)> {
    let maps = solution.maps.iter().filter_map(|map| match map.kind {
        MapKind::Receivers(set) => Some((map, set)),
        MapKind::Elements => None,
    });
    maps.filter(|(_, set)| is_wanted(scene.receivers[*set].quantity)).collect()
}

/// Makes `luminance.csv` and `ugr.csv`, each if there are values for it.
///
/// # Errors
///
/// A number that is not finite; no table may hold one.
pub(super) fn observer_files<'a>(
    scene: &'a Scene,
    solution: &'a Solution,
) -> Result<Vec<StreamedFile<'a>>, OutputError> {
    let mut files: Vec<StreamedFile> = Vec::new();
    let luminances = maps_of(scene, solution, |quantity| quantity == Quantity::Luminance);
    if !luminances.is_empty() {
        files.push(StreamedFile::new(LUMINANCES, move |writer| write_luminances(scene, &luminances, writer)));
    }
    if !solution.glare.is_empty() {
        let mut sheet = Sheet::new("ugr.csv", UGR_COLUMNS);
        for rating in &solution.glare {
            let set = &scene.receivers[rating.set];
            let Some(ugr) = rating.ugr else {
                continue;
            };
            let GlareObserver { eye_m, view, .. } = set.observers[rating.observer];
            sheet.row(&[
                SheetCell::Text(&set.name),
                SheetCell::Number(eye_m.x),
                SheetCell::Number(eye_m.y),
                SheetCell::Number(eye_m.z),
                SheetCell::Number(view.x),
                SheetCell::Number(view.y),
                SheetCell::Number(view.z),
                SheetCell::Number(ugr.value),
                SheetCell::Number(ugr.standard_error),
                SheetCell::Number(rating.background_cd_m2.value),
            ])?;
        }
        files.push(sheet.finish().into());
    }
    Ok(files)
}

fn write_luminances(scene: &Scene, maps: &[(&MapResult, usize)], writer: &mut dyn Write) -> Result<(), OutputError> {
    let mut sheet = Sheet::to(LUMINANCES, LUMINANCE_COLUMNS, writer)?;
    for (map, set) in maps {
        let set = &scene.receivers[*set];
        for index in 0..set.points.len() {
            sheet.row(&point_fields(map, set, index))?;
        }
    }
    sheet.end()
}
