//! Reads `receivers`: grids and lists of points, and observers.

use std::collections::HashMap;
use std::path::Path;

use super::error::SceneError;
use super::grid_frame::{GridFrame, refuse_too_many};
use super::limits::MOST_POINTS;
use super::model::{ReceiverLayout, ReceiverPoint, ReceiverSet};
use super::observers::{self, SEATED_EYE_M};
use super::quantity::{self, Quantity};
use super::reader::{Fields, Node};
use super::surface_grid::{self, PointSpacing};
use super::surfaces::Surfaces;
use super::unique_names::{Names, unique_name};
use super::units::LengthUnit;
use super::vectors::span_a_plane;
use super::{given, intensity, parse, points_file, requirements, room_receivers, surroundings};

/// The receiver types; names as in files.
pub(super) const TYPES: [&str; 7] = ["grid", "points", "luminance", "ugr", "ugr_grid", "intensity", "room"];

/// Keys that several receiver types share.
const NAMED: &[&str] = &["name", "type"];
const BY_CORNERS: &[&str] = &["origin", "u", "v", "columns", "rows"];
const OVER_A_SURFACE: &[&str] = &["surface", "height", "margin", "spacing"];
const MEASURING: &[&str] = &["quantity", "direction", "requirements"];
/// Key that only grids have.
const ABOUT: &[&str] = &[surroundings::KEY];
const OBSERVING: &[&str] = &["view_directions", "background", "requirements"];

/// Keys of a receiver type. `kind` is the index in [`TYPES`]. Grids have the keys of both their forms.
pub(super) fn keys(kind: usize) -> Vec<&'static str> {
    match TYPES[kind] {
        "grid" => [NAMED, BY_CORNERS, OVER_A_SURFACE, MEASURING, ABOUT].concat(),
        "points" => [NAMED, &["file", "points"], MEASURING].concat(),
        "luminance" => [NAMED, &["position", "directions", "fan", "view", "surface"]].concat(),
        "ugr" => [NAMED, &["position", "view_direction", "background", "requirements"]].concat(),
        "ugr_grid" => [NAMED, BY_CORNERS, OVER_A_SURFACE, OBSERVING].concat(),
        "room" => [NAMED, room_receivers::OWN_KEYS].concat(),
        _ => [NAMED, intensity::OWN_KEYS].concat(),
    }
}

/// The rule that `spacing` can name.
pub(super) const SPACING_RULES: [&str; 1] = ["EN 12464-1"];

/// Data that receivers refer to.
pub(super) struct ReceiverContext<'a> {
    pub unit: LengthUnit,
    pub base_dir: &'a Path,
    pub surfaces: &'a Surfaces,
}

/// Reads all receivers. A later step finds which points lie inside solids.
pub(super) fn read(node: &Node, around: &ReceiverContext) -> Result<Vec<ReceiverSet>, SceneError> {
    let mut names = HashMap::new();
    let mut sets: Vec<ReceiverSet> = Vec::new();
    let mut left = MOST_POINTS;
    for item in node.items("receivers")? {
        let fields = item.fields("a receiver")?;
        if let Some(made) = room_receivers::read(&item, &fields, around.unit, around.surfaces, &mut names, left)? {
            left -= made.iter().map(|set| set.points.len() as u64).sum::<u64>();
            sets.extend(made);
            continue;
        }
        let set = read_one(&item, around, &mut names, left)?;
        // Lists of points and of directions need no limit: the file contains each entry.
        let is_made = set.layout != ReceiverLayout::Points || set.observers.len() > 1;
        if is_made {
            left -= set.points.len() as u64;
        }
        let about = surroundings::read(&fields, around.unit, around.surfaces, &set, &mut names, left)?;
        left -= about.iter().map(|set| set.points.len() as u64).sum::<u64>();
        sets.push(set);
        sets.extend(about);
    }
    Ok(sets)
}

fn read_one(node: &Node, around: &ReceiverContext, names: &mut Names, most: u64) -> Result<ReceiverSet, SceneError> {
    let kind = node.fields("a receiver")?.need("type", "\"grid\"")?.choice(&TYPES)?;
    let what = format!("a {} receiver", TYPES[kind]);
    let fields = node.fields(&what)?;
    fields.only(&keys(kind))?;
    let name = unique_name(&fields, names)?;
    if TYPES[kind] == "intensity" {
        let (quantity, layout, points) = intensity::read(&fields, around.unit, most)?;
        return Ok(ReceiverSet { name, quantity, layout, points, observers: Vec::new(), requirements: Vec::new() });
    }
    if let Some((quantity, layout, points)) = observers::read(TYPES[kind], &fields, around.unit, around.surfaces, most)?
    {
        let observers =
            if matches!(quantity, Quantity::Glare(_)) { observers::observers_at(&points) } else { Vec::new() };
        let requirements = requirements::read(&fields, quantity)?;
        return Ok(ReceiverSet { name, quantity, layout, points, observers, requirements });
    }
    let by_surface = fields.get("surface").is_some();
    if TYPES[kind] == "ugr_grid" {
        let (_, places) = match by_surface {
            true => {
                let height_m = fields.get("height").is_none().then_some(SEATED_EYE_M);
                read_surface_grid(node, around, most, &[NAMED, OVER_A_SURFACE, OBSERVING].concat(), height_m)?
            }
            false => read_corner_grid(node, around.unit, most, &[NAMED, BY_CORNERS, OBSERVING].concat())?,
        };
        let (background, points) = observers::views_around(&fields, &places, most)?;
        let observers = observers::observers_at(&points);
        let quantity = Quantity::Glare(background);
        let requirements = requirements::read(&fields, quantity)?;
        return Ok(ReceiverSet { name, quantity, layout: ReceiverLayout::Points, points, observers, requirements });
    }
    let (layout, mut points) = match TYPES[kind] {
        "grid" if by_surface => {
            read_surface_grid(node, around, most, &[NAMED, OVER_A_SURFACE, MEASURING, ABOUT].concat(), None)?
        }
        "grid" => read_corner_grid(node, around.unit, most, &[NAMED, BY_CORNERS, MEASURING, ABOUT].concat())?,
        _ => read_points(&fields, around)?,
    };
    let (quantity, turned) = quantity::read(&fields)?;
    if let Some(normal) = turned {
        points.iter_mut().for_each(|point| point.normal = normal);
    }
    let requirements = requirements::read(&fields, quantity)?;
    Ok(ReceiverSet { name, quantity, layout, points, observers: Vec::new(), requirements })
}

fn read_corner_grid(
    node: &Node,
    unit: LengthUnit,
    most: u64,
    keys: &[&str],
) -> Result<(ReceiverLayout, Vec<ReceiverPoint>), SceneError> {
    let fields = node.fields("a grid given by its corner")?;
    fields.only(keys)?;
    let origin = fields.need("origin", "[0.25, 0.25, 0.8], or \"surface\": \"room/floor\"")?.vector()?;
    let u = fields.need("u", "[7.5, 0, 0]")?.vector()?;
    let v_node = fields.need("v", "[0, 5.5, 0]")?;
    let v = v_node.vector()?;
    let columns_node = fields.need("columns", "32")?;
    let columns = columns_node.count("the number of columns")?;
    let rows = fields.need("rows", "24")?.count("the number of rows")?;
    if !span_a_plane(u, v) {
        let expected = "two vectors that span an area: the grid's normal is u × v";
        let got = "\"u\" and \"v\" that are parallel or 0";
        return Err(v_node.refuse_as("the grid has no normal", got, expected, "correct \"u\" or \"v\""));
    }
    if u64::from(columns) * u64::from(rows) > most {
        return Err(refuse_too_many(&columns_node, u64::from(columns) * u64::from(rows)));
    }
    let frame = GridFrame { columns, rows, origin_m: unit.point_m(origin), u_m: unit.point_m(u), v_m: unit.point_m(v) };
    if !(frame.u_m.cross(frame.v_m).length().is_normal() && (frame.origin_m + frame.u_m + frame.v_m).is_finite()) {
        let expected = "lengths in length_unit";
        return Err(v_node.refuse("the grid's size is far out of range", expected, "check the numbers"));
    }
    Ok(frame.points())
}

fn read_surface_grid(
    node: &Node,
    around: &ReceiverContext,
    most: u64,
    keys: &[&str],
    default_height_m: Option<f64>,
) -> Result<(ReceiverLayout, Vec<ReceiverPoint>), SceneError> {
    let fields = node.fields("a grid on a surface")?;
    fields.only(keys)?;
    let surface_node = fields.need("surface", "\"room/floor\"")?;
    let surfaces = around.surfaces.named(&surface_node)?;
    let length_m = |key: &str, quantity: &str| {
        let length = fields.get(key).map_or(Ok(0.0), |node| node.at_least_zero(quantity))?;
        Ok(around.unit.length_m(length))
    };
    let height_m = default_height_m.map_or_else(|| length_m("height", "the height"), Ok)?;
    let margin_m = length_m("margin", "the margin")?;
    let spacing_node = fields.get("spacing");
    let spacing = match &spacing_node {
        None => PointSpacing::En12464,
        Some(node) if node.is_text() => {
            node.choice(&SPACING_RULES)?;
            PointSpacing::En12464
        }
        Some(node) => PointSpacing::Distance(around.unit.length_m(node.above_zero("the spacing")?)),
    };

    let rectangle = surface_grid::Rectangle::of(around.surfaces, &surfaces).map_err(|reason| {
        surface_node.refuse(
            format!("a grid needs a rectangle, but this surface is not one: {reason}"),
            "a flat rectangular surface, such as a box's floor",
            "give the grid by \"origin\", \"u\", \"v\", \"columns\" and \"rows\" (several grids for an L-shaped floor)",
        )
    })?;
    let Some(field) = rectangle.shrunk(margin_m) else {
        let blamed = fields.get("margin").unwrap_or(surface_node);
        let [long_m, short_m] = rectangle.sides_m();
        let expected = format!("less than half of the shorter side of {long_m:.4} m × {short_m:.4} m");
        return Err(blamed.refuse("the margin leaves nothing of the surface", expected, "give a smaller margin"));
    };
    let [columns, rows] = field.counts(spacing);
    if columns * rows > most as f64 {
        return Err(refuse_too_many(&spacing_node.unwrap_or(surface_node), (columns * rows) as u64));
    }
    Ok(field.grid(columns as u32, rows as u32, height_m).points())
}

fn read_points(fields: &Fields, around: &ReceiverContext) -> Result<(ReceiverLayout, Vec<ReceiverPoint>), SceneError> {
    if let Some(points) = given::points(fields, around.unit)? {
        return Ok((ReceiverLayout::Points, points));
    }
    let node = fields.need("file", "\"probes.csv\", or \"points\": [[x, y, z, nx, ny, nz], …]")?;
    let path = around.base_dir.join(node.name()?);
    let points = parse::read_text(&path, "the points file")
        .and_then(|text| points_file::read(&text, &path, around.unit))
        .map_err(|error| error.named_by(node.as_namer()))?;
    Ok((ReceiverLayout::Points, points))
}
