//! Reads and checks a scene file. This file refuses, marks and warns of what depends on the scene as a whole.

use std::path::Path;

use glam::DVec3;

use super::advice::advise;
use super::fitted_openings::fit_openings;
use super::insides::SolidLookup;
use super::inspect::{Inspection, inspect};
use super::mesh_faults::{MESH, warn_of_faults, warnings_of};
use super::overlaps::{overlaps, overlaps_budget};
use super::rooms_outward::refuse_rooms_outward;
use super::shells::{Shell, closed_shells_of_geometries, size_m};
use super::skipped::{MeshCheck, words_on_skipped};
use super::sky_openings::find_openings;
use super::walls::place_backgrounds;
use super::warnings::{arrange, names};
use super::whiteness::refuse_white_rooms;
use crate::scene::{
    Background, LengthUnit, Luminaire, Quantity, Scene, SceneError, UNIT_NAMES, WrittenGeometry, from_json_with,
    listed, place_words, read_with, under_way,
};

/// A lit scene larger than this, in m, probably has another unit.
const SUSPICIOUSLY_LARGE_M: f64 = 1000.0;
/// A lit scene smaller than this, in m, probably has another unit.
const SUSPICIOUSLY_SMALL_M: f64 = 0.01;
/// The same limit for a scene whose file has a unit other than metres: it may have been drawn in metres.
const SUSPICIOUSLY_SMALL_IN_OTHER_UNITS_M: f64 = 0.1;

/// Reads a scene file and the mesh, points and photometric files that it names.
///
/// # Errors
///
/// Anything that the file format refuses, with the position, what was expected and a remedy.
pub fn read_scene(path: &Path) -> Result<Scene, SceneError> {
    read_with(path, complete)
}

/// Reads a scene file and returns it with its facts. Mesh faults are searched once, and longer than in [`read_scene`]. `more` may add
/// warnings.
///
/// # Errors
///
/// As [`read_scene`].
pub fn read_and_inspect(path: &Path, more: impl FnOnce(&mut Scene)) -> Result<(Scene, Inspection), SceneError> {
    let mut scene = read_with(path, |scene, written| complete_with(scene, written, false))?;
    more(&mut scene);
    let mut inspection = inspect(&scene);
    if !MeshCheck::Faults.is_skipped() {
        scene.warnings.extend(warnings_of(&inspection.mesh));
        arrange(&mut scene);
        inspection.warnings.clone_from(&scene.warnings);
    }
    Ok((scene, inspection))
}

/// Reads a scene from the text of its file. Files that it names are relative to `base_dir`.
///
/// # Errors
///
/// As [`read_scene`].
pub fn scene_from_json(text: &str, path: Option<&Path>, base_dir: &Path) -> Result<Scene, SceneError> {
    from_json_with(text, path, base_dir, complete)
}

/// Refuses what cannot be computed, marks points inside of solids, finds the openings to the sky, and warns.
fn complete(scene: &mut Scene, written: &WrittenGeometry) -> Result<(), SceneError> {
    complete_with(scene, written, !MeshCheck::Faults.is_skipped())
}

/// Does the same, with or without the search for mesh faults.
fn complete_with(scene: &mut Scene, written: &WrittenGeometry, finds_faults: bool) -> Result<(), SceneError> {
    under_way::begin("checks of the whole scene", 0);
    refuse_white_rooms(&written.geometry, scene)?;
    let shells = closed_shells_of_geometries(scene);
    refuse_rooms_outward(&written.geometry, scene, &shells)?;
    place_backgrounds(scene, &shells);
    if !MeshCheck::Insides.is_skipped() {
        mark_inside_points(scene, &shells);
    }
    find_openings(scene, &shells);
    warn_of_proportions(scene, written.unit);
    fit_openings(scene);
    if !MeshCheck::Advice.is_skipped() {
        advise(scene, &shells);
    }
    if finds_faults {
        warn_of_faults(scene);
    }
    if !MeshCheck::Overlaps.is_skipped() {
        warn_of_overlaps(scene, &shells);
    }
    scene.warnings.extend(words_on_skipped());
    arrange(scene);
    Ok(())
}

fn warn_of_overlaps(scene: &mut Scene, shells: &[Shell]) {
    let found = overlaps(scene, shells, size_m(scene), &mut overlaps_budget(shells.len()));
    if let Some(([one, other], place_m)) = &found.first {
        let solids = match found.count {
            1 if found.all_examined => "two solids intersect:".to_owned(),
            count if found.all_examined => format!("{count} pairs of solids intersect, first"),
            count => format!("at least {count} pairs of solids intersect, first"),
        };
        scene
            .warnings
            .push(format!("{MESH}{solids} {one} and {other} at {}; the parts inside are dark", place_words(*place_m)));
    } else if !found.all_examined {
        scene.warnings.push(format!("{MESH}too many solids near each other to check which solids intersect"));
    }
}

fn mark_inside_points(scene: &mut Scene, shells: &[Shell]) {
    let solids = SolidLookup::of(shells, size_m(scene));
    let places_m = scene.receivers.iter().flat_map(|set| {
        let eyes_m = set.observers.iter().map(|observer| observer.eye_m);
        set.placed_points().iter().map(|point| point.position_m).chain(eyes_m)
    });
    let points_m: Vec<DVec3> = places_m.collect();
    let (held, _) = solids.holding(&points_m);
    let mut warnings = Vec::new();
    if held.len() < points_m.len() {
        warnings.push(format!(
            "{} of {} receiver points were not checked for lying inside of solids: too many solids surround them; tables and errors include them",
            points_m.len() - held.len(),
            points_m.len()
        ));
    }
    let mut held = held.into_iter();
    for set in scene.receivers.iter_mut().filter(|set| !set.is_far_field()) {
        let all = set.points.len();
        set.points.iter_mut().zip(held.by_ref()).for_each(|(point, is_inside)| point.inside = is_inside);
        set.observers.iter_mut().zip(held.by_ref()).for_each(|(eye, is_inside)| eye.inside = is_inside);
        let inside = set.points.iter().filter(|point| point.inside).count();
        if set.quantity == Quantity::Glare(Background::Tabular) {
            let [inside, all] = [set.observers.iter().filter(|eye| eye.inside).count(), set.observers.len()];
            if inside > 0 {
                let what = match inside {
                    1 => "observers looks from inside of a closed solid and is not rated",
                    _ => "observers look from inside of a closed solid; they are not rated",
                };
                warnings.push(format!("{}: {inside} of {all} {what}", set.name));
            }
        } else if inside > 0 {
            let what = match inside {
                1 => "points lies inside of a closed solid and is left out of tables and errors",
                _ => "points lie inside of a closed solid; they are left out of tables and errors",
            };
            let remedy = if inside == all { "; if the solid is a room, give it \"facing\": \"inward\"" } else { "" };
            warnings.push(format!("{}: {inside} of {all} {what}{remedy}", set.name));
        }
    }
    scene.warnings.extend(warnings);
}

fn warn_of_proportions(scene: &mut Scene, unit: LengthUnit) {
    let [low_m, high_m] = scene.bounds_m();
    let size_m = low_m.distance(high_m);
    let least_m = if unit.name == "m" { SUSPICIOUSLY_SMALL_M } else { SUSPICIOUSLY_SMALL_IN_OTHER_UNITS_M };
    if !(least_m..=SUSPICIOUSLY_LARGE_M).contains(&size_m) {
        let others = listed(UNIT_NAMES.into_iter().filter(|name| *name != unit.name));
        scene.warnings.push(format!(
            "the scene is {size_m:.4} m across, as its length_unit is \"{}\"; is {others} meant?",
            unit.name
        ));
    }
    let mut outside: Vec<(&Luminaire, DVec3)> = Vec::new();
    for luminaire in &scene.luminaires {
        let Some(place_m) = luminaire.emission.place_m() else {
            continue;
        };
        if place_m.cmplt(low_m).any() || place_m.cmpgt(high_m).any() {
            outside.push((luminaire, place_m));
        }
    }
    let box_m = format!("the box goes from {} to {}", place_words(low_m), place_words(high_m));
    match outside.as_slice() {
        [] => {}
        [(luminaire, place_m)] => scene.warnings.push(format!(
            "{}: this luminaire is outside of the scene's bounding box ({}; {box_m})",
            luminaire.name,
            place_words(*place_m)
        )),
        [(_, place_m), ..] => scene.warnings.push(format!(
            "{}: these luminaires are outside of the scene's bounding box (the first at {}; {box_m})",
            names(outside.iter().map(|(luminaire, _)| *luminaire)),
            place_words(*place_m)
        )),
    }

    // These names have a meaning on the command line, or look like a list of names there.
    for set in &scene.receivers {
        if ["all", "elements", "receivers"].contains(&set.name.as_str()) {
            scene.warnings.push(format!("{}: a receiver of this name cannot be chosen by --maps", set.name));
        } else if set.name.contains(',') {
            scene.warnings.push(format!("{}: a name with a comma can only stand alone in --maps", set.name));
        }
    }
}
