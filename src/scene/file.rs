//! The scene file as a whole: text → syntax tree → one valid [`Scene`].

use std::path::{Path, PathBuf};

use glam::DVec3;

use super::advice::{advise, names};
use super::error::SceneError;
use super::fitted_openings::fit_openings;
use super::insides::Solids;
use super::mesh_faults::{MESH, warn_of_faults};
use super::model::{Background, Emission, Luminaire, Quantity, Scene};
use super::names::listed;
use super::openings::find_openings;
use super::overlaps::{overlaps, overlaps_budget};
use super::reader::{Node, Source};
use super::rooms_outward::refuse_rooms_outward;
use super::shells::{self, Shell, bounds_m, closed_shells_of_geometries};
use super::surfaces::Surfaces;
use super::units::{LengthUnit, UNIT_NAMES};
use super::walls::place_backgrounds;
use super::whiteness::{LEAST_ABSORBED, least_loss};
use super::{luminaires, materials, parse, receivers, sky, surfaces};

/// Keys of the file.
pub(super) const KEYS: [&str; 7] =
    ["version", "title", "length_unit", "materials", "geometry", "luminaires", "receivers"];

/// The version of the file format that this program reads.
pub(super) const VERSION: f64 = 1.0;

/// A lit scene larger than this, in m, is likely one in other units.
const SUSPICIOUSLY_LARGE_M: f64 = 1000.0;
/// A lit scene smaller than this, in m, is likely one in other units.
const SUSPICIOUSLY_SMALL_M: f64 = 0.01;
/// The same of a scene whose file does not say metres: it may have been drawn in them.
const SUSPICIOUSLY_SMALL_IN_OTHER_UNITS_M: f64 = 0.1;

/// Reads a scene file and the mesh, points and photometric files that it names.
///
/// # Errors
///
/// Anything that the file format refuses, with the place, what was expected and a remedy.
pub fn read_scene(path: &Path) -> Result<Scene, SceneError> {
    let text = parse::read_text(path, "the scene file")?;
    let base_dir = path.parent().map_or_else(PathBuf::new, Path::to_path_buf);
    scene_from_json(&text, Some(path), &base_dir)
}

/// Reads a scene from the text of its file; files that it names are relative to `base_dir`.
///
/// # Errors
///
/// As [`read_scene`].
pub fn scene_from_json(text: &str, path: Option<&Path>, base_dir: &Path) -> Result<Scene, SceneError> {
    // Editors on Windows like to begin a text with a byte-order mark.
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let source = Source { text, path: path.unwrap_or(Path::new("scene")) };
    let value = parse::parse(&source)?;
    let root = Node::root(&source, &value);
    let fields = root.fields("a scene file")?;

    // The version first: what else is wrong with a file of another version is beside the point.
    let version = fields.need("version", "1")?;
    if version.number()? != VERSION {
        let what = "a scene file of another version";
        return Err(version.refuse(
            what,
            "version 1",
            "write 1, or use the version of luxmc that the file was made for",
        ));
    }
    fields.only(&KEYS)?;
    let title = fields.get("title").map_or(Ok(""), |node| node.text())?.to_string();
    let unit = LengthUnit::of(fields.get("length_unit").map_or(Ok(0), |node| node.choice(&UNIT_NAMES))?);

    let mut warnings = Vec::new();
    let materials = materials::read(
        &fields.need("materials", "{ \"plaster\": { \"type\": \"diffuse\", \"reflectance\": 0.7 } }")?,
    )?;
    let geometry_node = fields.need("geometry", "[ … ]: the scene has no geometry")?;
    let around = surfaces::Around::of(unit, base_dir, &materials);
    let surfaces = Surfaces::read(&geometry_node, &around, &mut warnings)?;
    let luminaires_node = fields.need("luminaires", "[ … ]: the scene has no luminaire")?;
    let around = luminaires::Around { unit, base_dir, surfaces: &surfaces };
    let luminaires = luminaires::read(&luminaires_node, &around, &mut warnings)?;
    let receivers = match fields.get("receivers") {
        Some(node) => receivers::read(&node, &receivers::Around { unit, base_dir, surfaces: &surfaces })?,
        None => Vec::new(),
    };

    sky::refuse_glare(&root, &luminaires, &receivers)?;
    let mut scene = Scene {
        title,
        path: path.map(Path::to_path_buf),
        materials,
        vertices_m: surfaces.vertices_m,
        triangles: surfaces.triangles,
        divisions: surfaces.divisions,
        triangle_surfaces: surfaces.triangle_surfaces,
        surfaces: surfaces.surfaces,
        luminaires,
        receivers,
        warnings,
    };
    let losses = least_loss(&scene);
    if !losses.all_looked_at {
        scene
            .warnings
            .push("too many white rooms to look which of them lose next to nothing of their light".to_owned());
    }
    if let Some(loss) = losses.least.filter(|loss| loss.share < LEAST_ABSORBED) {
        let share = if loss.share > 0.0 { format!("{:.1e}", loss.share) } else { "nothing".to_owned() };
        let (what, got) = if loss.openings_m2 > 0.0 {
            (
                "a room in which next to nothing absorbs, with openings that let next to nothing out",
                format!(
                    "what stands around a luminaire loses {share} of what falls on it, by absorption and through openings of {:.1e} m²: light meets some {:.0e} surfaces",
                    loss.openings_m2,
                    loss.share.recip()
                ),
            )
        } else {
            (
                "a closed room in which next to nothing absorbs",
                format!("what stands around a luminaire absorbs {share} of what falls on it, and no light can leave"),
            )
        };
        return Err(geometry_node.refuse_as(
            what,
            got,
            format!(
                "surfaces that absorb {LEAST_ABSORBED:.0e} or more on average, or an opening of as much of their area"
            ),
            "lower a reflectance: the light would go on for ever, or nearly so; the whitest paints have 0.99",
        ));
    }
    let shells = closed_shells_of_geometries(&scene);
    refuse_rooms_outward(&geometry_node, &scene, &shells)?;
    place_backgrounds(&mut scene, &shells);
    mark_inside_points(&mut scene, &shells);
    find_openings(&mut scene, &shells);
    warn_of_proportions(&mut scene, unit);
    fit_openings(&mut scene);
    advise(&mut scene, &shells);
    warn_of_faults(&mut scene);
    warn_of_overlaps(&mut scene, &shells);
    super::warnings::arrange(&mut scene);
    Ok(scene)
}

fn warn_of_overlaps(scene: &mut Scene, shells: &[Shell]) {
    let found = overlaps(scene, shells, shells::size_m(scene), &mut overlaps_budget(shells.len()));
    if let Some(([one, other], place_m)) = &found.first {
        let at_least = if found.all_looked_at { "" } else { "at least " };
        scene.warnings.push(format!(
            "{MESH}{at_least}{} pairs of solids stand in one another, first {one} and {other} at {place_m} m; what lies inside is dark",
            found.count
        ));
    } else if !found.all_looked_at {
        scene.warnings.push(format!("{MESH}too many solids about each other to look which stand in one another"));
    }
}

fn mark_inside_points(scene: &mut Scene, shells: &[Shell]) {
    let solids = Solids::of(shells, shells::size_m(scene));
    let places_m = scene.receivers.iter().flat_map(|set| {
        let eyes_m = set.observers.iter().map(|observer| observer.eye_m);
        set.points.iter().map(|point| point.position_m).chain(eyes_m)
    });
    let points_m: Vec<DVec3> = places_m.collect();
    let (held, _) = solids.holding(&points_m);
    let mut warnings = Vec::new();
    if held.len() < points_m.len() {
        warnings.push(format!(
            "{} of {} receiver points were not looked at, whether they lie inside of solids: there are too many solids about them; they count in tables and errors",
            points_m.len() - held.len(),
            points_m.len()
        ));
    }
    let mut held = held.into_iter();
    for set in &mut scene.receivers {
        let all = set.points.len();
        set.points.iter_mut().zip(held.by_ref()).for_each(|(point, is_inside)| point.inside = is_inside);
        set.observers.iter_mut().zip(held.by_ref()).for_each(|(eye, is_inside)| eye.inside = is_inside);
        let inside = set.points.iter().filter(|point| point.inside).count();
        if set.quantity == Quantity::Glare(Background::Tabular) {
            let [inside, all] = [set.observers.iter().filter(|eye| eye.inside).count(), set.observers.len()];
            if inside > 0 {
                let what = "observers look from inside of a closed solid; they are not rated";
                warnings.push(format!("{}: {inside} of {all} {what}", set.name));
            }
        } else if inside > 0 {
            let what = "lie inside of a closed solid; they are left out of tables and errors";
            let remedy =
                if inside == all { "; if the solid is a room, let it have \"facing\": \"inward\"" } else { "" };
            warnings.push(format!("{}: {inside} of {all} points {what}{remedy}", set.name));
        }
    }
    scene.warnings.extend(warnings);
}

fn warn_of_proportions(scene: &mut Scene, unit: LengthUnit) {
    let [low_m, high_m] = bounds_m(scene);
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
        let place_m = match luminaire.emission {
            Emission::Isotropic { position_m, .. }
            | Emission::Lambertian { position_m, .. }
            | Emission::Photometric { position_m, .. } => position_m,
            Emission::Sphere { center_m, .. } => center_m,
            Emission::Area { .. } | Emission::Sky { .. } => continue,
        };
        if place_m.cmplt(low_m).any() || place_m.cmpgt(high_m).any() {
            outside.push((luminaire, place_m));
        }
    }
    let box_m = format!("the box goes from {low_m} to {high_m} m");
    match outside.as_slice() {
        [] => {}
        [(luminaire, place_m)] => scene.warnings.push(format!(
            "{}: this luminaire is outside of the scene's bounding box ({place_m} m; {box_m})",
            luminaire.name
        )),
        [(_, place_m), ..] => scene.warnings.push(format!(
            "{}: these luminaires are outside of the scene's bounding box (the first at {place_m} m; {box_m})",
            names(outside.iter().map(|(luminaire, _)| *luminaire))
        )),
    }

    // Names that the command line uses for itself, or cannot tell from a list of names.
    for set in &scene.receivers {
        if ["all", "elements", "receivers"].contains(&set.name.as_str()) || set.name.contains(',') {
            scene.warnings.push(format!("{}: a receiver of this name cannot be chosen by --maps", set.name));
        }
    }
}
