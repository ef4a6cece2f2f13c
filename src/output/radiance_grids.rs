//! Receiver sets as sensor grids of Radiance: places in `.pts`, illuminances in `.res`, and the list that honeybee reads.

use serde_json::json;

use super::plots::Stems;
use super::sheet::shortest;
use super::{ResultFile, file_name_part};
use crate::maps::MapResult;
use crate::scene::{ReceiverPoint, Scene};

/// Name of the list of grids.
pub(super) const GRIDS_INFO: &str = "grids_info.json";

/// Two files a set, a line a point in the order of `receivers.csv`: `x y z nx ny nz` in m, and the illuminance in lx; and their list.
///
/// Numbers are those of `receivers.csv`, which refuses what is not finite.
pub(super) fn grid_files(scene: &Scene, maps: &[(&MapResult, usize)]) -> Vec<ResultFile> {
    let mut stems = Stems::default();
    let mut files = Vec::new();
    let mut list = Vec::new();
    for (map, set) in maps {
        let points = &scene.receivers[*set].points;
        let stem = stems.fresh(&format!("grid-{}", file_name_part(&map.name)));
        let place = |point: &ReceiverPoint| {
            let numbers: Vec<String> =
                [point.position_m, point.normal].iter().flat_map(|vector| vector.to_array()).map(shortest).collect();
            numbers.join(" ") + "\n"
        };
        let places: String = points.iter().map(place).collect();
        let values: String = map.values.illuminance_lx.iter().map(|lx| shortest(*lx) + "\n").collect();
        files.push(ResultFile { name: format!("{stem}.pts"), bytes: places.into_bytes() });
        files.push(ResultFile { name: format!("{stem}.res"), bytes: values.into_bytes() });
        list.push(json!({ "name": map.name, "identifier": stem, "count": points.len(), "group": "", "full_id": stem }));
    }
    if !list.is_empty() {
        let list = format!("{:#}\n", serde_json::Value::Array(list));
        files.push(ResultFile { name: GRIDS_INFO.to_owned(), bytes: list.into_bytes() });
    }
    files
}
