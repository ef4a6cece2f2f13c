//! The scene file as a whole: text → syntax tree → one valid [`Scene`].

use std::path::{Path, PathBuf};

use glam::DVec3;
use rayon::prelude::*;

use super::advice::{advise, names};
use super::error::SceneError;
use super::mesh_faults::{MESH, warn_of_faults};
use super::model::{Emission, Luminaire, Scene};
use super::names::listed;
use super::overlaps::overlaps;
use super::reader::{Node, Source};
use super::shells::{self, Shell, bounds_m, closed_shells_of_geometries};
use super::surfaces::Surfaces;
use super::units::{LengthUnit, UNIT_NAMES};
use super::whiteness::{LEAST_ABSORBED, absorbed_share};
use super::{luminaires, materials, parse, receivers, surfaces};

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

/// Reads a scene file and the OBJ, points and photometric files that it names.
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
    let around = surfaces::Around { unit, base_dir, materials: &materials };
    let surfaces = Surfaces::read(&geometry_node, &around, &mut warnings)?;
    let luminaires_node = fields.need("luminaires", "[ … ]: the scene has no luminaire")?;
    let around = luminaires::Around { unit, base_dir, surfaces: &surfaces };
    let luminaires = luminaires::read(&luminaires_node, &around, &mut warnings)?;
    let receivers = match fields.get("receivers") {
        Some(node) => receivers::read(&node, &receivers::Around { unit, base_dir, surfaces: &surfaces })?,
        None => Vec::new(),
    };

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
    if let Some(absorbed) = absorbed_share(&scene).filter(|absorbed| *absorbed < LEAST_ABSORBED) {
        return Err(geometry_node.refuse_as(
            "a closed room in which next to nothing absorbs",
            format!(
                "what stands around a luminaire absorbs {} of what falls on it, and no light can leave",
                if absorbed > 0.0 { format!("{absorbed:.1e}") } else { "nothing".to_owned() }
            ),
            format!("surfaces that absorb {LEAST_ABSORBED:.0e} or more on average, or an opening"),
            "lower a reflectance: the light would go on for ever, or nearly so; the whitest paints have 0.99",
        ));
    }
    let shells = closed_shells_of_geometries(&scene);
    mark_inside_points(&mut scene, &shells);
    warn_of_proportions(&mut scene, unit);
    advise(&mut scene, &shells);
    warn_of_faults(&mut scene);
    if let Some(found) = overlaps(&scene, &shells, shells::size_m(&scene)) {
        let [one, other] = &found.first;
        scene.warnings.push(format!(
            "{MESH}{} pairs of solids stand in one another, first {one} and {other} at {} m; what lies inside is dark",
            found.count, found.place_m
        ));
    }
    Ok(scene)
}

fn mark_inside_points(scene: &mut Scene, shells: &[Shell]) {
    let size_m = shells::size_m(scene);
    let mut receivers = std::mem::take(&mut scene.receivers);
    for set in &mut receivers {
        set.points.par_iter_mut().for_each(|point| {
            point.inside = shells::is_inside_solid(shells, point.position_m, size_m);
        });
        let inside = set.points.iter().filter(|point| point.inside).count();
        if inside > 0 {
            let all = set.points.len();
            let what = "lie inside of a closed solid; they are left out of tables and errors";
            let remedy =
                if inside == all { "; if the solid is a room, let it have \"facing\": \"inward\"" } else { "" };
            scene.warnings.push(format!("{}: {inside} of {all} points {what}{remedy}", set.name));
        }
    }
    scene.receivers = receivers;
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
            Emission::Area { .. } => continue,
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
