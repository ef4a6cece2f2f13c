//! Which maps `--maps` names in a scene.

use super::exit::Failure;
use crate::scene::Scene;
use crate::solver::MapSelection;

/// Turns the option's text into maps of the scene.
///
/// # Errors
///
/// A name that the scene does not know, or receivers where there are none.
pub fn select_maps(text: Option<&str>, scene: &Scene) -> Result<MapSelection, Failure> {
    let Some(text) = text else {
        return Ok(MapSelection::Default);
    };
    let is_set = |name: &str| scene.receivers.iter().any(|set| set.name == name);

    // A set whose own name holds a comma can still be asked for alone.
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
        remedy: "name one or more of those, with commas between".to_owned(),
    }
}
