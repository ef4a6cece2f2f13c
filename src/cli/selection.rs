//! Which maps of a scene `--maps` names.

use super::exit::Failure;
use crate::maps::MapKind;
use crate::scene::{ReceiversPart, Scene};
use crate::solver::{MapSelection, map_requests};

/// Converts the option's text into maps of the scene.
///
/// # Errors
///
/// A name that the scene does not have, or receivers if there are none.
pub fn select_maps(text: Option<&str>, scene: &Scene) -> Result<MapSelection, Failure> {
    let Some(text) = text else {
        return Ok(MapSelection::Default);
    };
    let is_set = |name: &str| scene.receivers.iter().any(|set| set.name == name);

    // A set whose own name contains a comma can still be named alone.
    let names: Vec<&str> = if is_set(text) { vec![text] } else { text.split(',').map(str::trim).collect() };

    match names.as_slice() {
        ["all"] => return Ok(MapSelection::All),
        ["elements"] => return Ok(MapSelection::Elements),
        ["receivers"] if !scene.receivers.is_empty() => return Ok(MapSelection::Receivers),
        _ => {}
    }
    let mut selected: Vec<String> = Vec::new();
    for name in names {
        match name {
            "all" => return Ok(MapSelection::All),
            "elements" => selected.push(name.to_owned()),
            "receivers" if !scene.receivers.is_empty() => {
                selected.extend(scene.receivers.iter().map(|set| set.name.clone()));
            }
            _ if is_set(name) => selected.push(name.to_owned()),
            _ => return Err(unknown(name, scene)),
        }
    }
    Ok(MapSelection::Named(selected))
}

/// Returns the maps of a run with a part of the receivers: the selected sets of which the part has points.
///
/// # Errors
///
/// The element map is named, which no run divides; or the part has no points.
pub fn maps_of_part(part: ReceiversPart, maps: &MapSelection, scene: &Scene) -> Result<MapSelection, Failure> {
    let request = format!("--receivers-part {}/{}", part.number, part.of);
    let kinds = map_requests(scene, maps).into_iter().map(|(kind, _)| kind);
    if *maps != MapSelection::Default && kinds.clone().any(|kind| kind == MapKind::Elements) {
        return Err(Failure::Usage {
            what: "elements cannot be divided: each of them lights the others".to_owned(),
            got: format!("{request} with --maps that name the element map"),
            expected: "receiver sets only".to_owned(),
            remedy: "compute the element map in a separate run, and name receiver sets here, or leave out --maps"
                .to_owned(),
        });
    }
    let sets = kinds.filter_map(|kind| match kind {
        MapKind::Receivers(index) => Some((index, &scene.receivers[index])),
        MapKind::Elements => None,
    });
    let with_points = sets.filter(|(index, set)| part.points_of(set, *index) > 0);
    let names: Vec<String> = with_points.map(|(_, set)| set.name.clone()).collect();
    if names.is_empty() {
        return Err(Failure::Usage {
            what: "this part has no receivers".to_owned(),
            got: request,
            expected: "fewer parts than the sets have points".to_owned(),
            remedy: "divide them among fewer runs".to_owned(),
        });
    }
    Ok(MapSelection::Named(names))
}

fn unknown(name: &str, scene: &Scene) -> Failure {
    let mut known = vec!["all".to_owned(), "elements".to_owned()];
    if !scene.receivers.is_empty() {
        known.push("receivers".to_owned());
    }
    known.extend(scene.receivers.iter().map(|set| format!("\"{}\"", set.name)));
    let what = if name == "receivers" { "the scene has no receivers" } else { "no map has this name" };
    Failure::Usage {
        what: what.to_owned(),
        got: format!("\"{name}\" in --maps"),
        expected: known.join(", "),
        remedy: "name one or more of those, separated by commas".to_owned(),
    }
}
