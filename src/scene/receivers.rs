//! Reads `receivers`: grids and lists of points, and observers.

use std::collections::HashMap;
use std::path::Path;

use super::error::SceneError;
use super::grid_frame::{GridFrame, refuse_too_many};
use super::keys::{
    ABOVE_ZERO, ANY_LENGTH, COUNT, FROM_ZERO, Form, Key, NOT_EMPTY, NUMBER, ObjectKinds, TEXT, TYPE, VECTOR,
    ValueShape, form, needed, optional,
};
use super::limits::MOST_POINTS;
use super::model::{ReceiverLayout, ReceiverPoint, ReceiverSet};
use super::observers::{self, SEATED_EYE_M};
use super::quantity::{self, QUANTITIES, Quantity};
use super::reader::{Fields, Node};
use super::surface_grid::{self, PointSpacing};
use super::surfaces::Surfaces;
use super::unique_names::{Names, name, unique_name};
use super::units::LengthUnit;
use super::vectors::span_a_plane;
use super::{given, intensity, parse, points_file, requirements, room_receivers, surroundings};

/// The receivers; grids have two forms.
pub(super) const KINDS: ObjectKinds = ObjectKinds {
    name: "Receiver",
    doc: "Receivers.",
    forms: &[
        GRID_BY_CORNERS,
        GRID_ON_SURFACE,
        POINTS,
        observers::LUMINANCE,
        observers::UGR,
        UGR_GRID_BY_CORNERS,
        UGR_GRID_ON_SURFACE,
        intensity::FORM,
        room_receivers::FORM,
    ],
};

/// Grids: by their corner, on a surface, and with the keys of both.
#[rustfmt::skip]
const GRID_BY_CORNERS: Form = form("grid",
    "A grid given by its corner: points at origin + (c/(columns−1))·u + (r/(rows−1))·v; its normal is u × v.",
    &[NAMED, BY_CORNERS, MEASURING, ABOUT]);
#[rustfmt::skip]
const GRID_ON_SURFACE: Form = form("grid",
    "A grid on a flat rectangular surface: points at the centres of its cells, facing the same way as its front.",
    &[NAMED, &GRID_OVER, MEASURING, ABOUT]);
const GRID: Form = form("grid", "", &[NAMED, BY_CORNERS, &GRID_OVER, MEASURING, ABOUT]);
const GRID_OVER: [Key; 4] = over_a_surface("Distance from the front of the surface.");

#[rustfmt::skip]
const POINTS: Form = form("points",
    "Points from a CSV file with the header x,y,z,nx,ny,nz and optionally area, or points given here.", &[NAMED, &[
    optional("file", TEXT, "The CSV file.").such_as("\"probes.csv\", or \"points\": [[x, y, z, nx, ny, nz], …]"),
    optional("points", ValueShape::List(&ValueShape::List(&NUMBER, ANY_LENGTH), NOT_EMPTY),
        "Points instead of a file: [x, y, z, nx, ny, nz], or with an area as seventh number in all."),
], MEASURING]).either(&[&["file"], &["points"]]);

/// Grids of observers, as grids.
#[rustfmt::skip]
const UGR_GRID_BY_CORNERS: Form = form("ugr_grid",
    "Unified glare ratings of observers over a parallelogram, each looking in all directions of view.",
    &[NAMED, BY_CORNERS, observers::OBSERVING]);
#[rustfmt::skip]
const UGR_GRID_ON_SURFACE: Form = form("ugr_grid",
    "Unified glare ratings of observers over a flat rectangular surface, each looking in all directions of view.",
    &[NAMED, &UGR_GRID_OVER, observers::OBSERVING]);
const UGR_GRID: Form = form("ugr_grid", "", &[NAMED, BY_CORNERS, &UGR_GRID_OVER, observers::OBSERVING]);
const UGR_GRID_OVER: [Key; 4] = over_a_surface("Distance of the eyes from the front of the surface; 1.2 m by default.");

/// Keys that several receivers share.
const NAMED: &[Key] = &[name("Name of the receivers."), TYPE];
#[rustfmt::skip]
const BY_CORNERS: &[Key] = &[
    needed("origin", VECTOR, "[0.25, 0.25, 0.8], or \"surface\": \"room/floor\"", "First point."),
    needed("u", VECTOR, "[7.5, 0, 0]", "Vector from the first to the last column."),
    needed("v", VECTOR, "[0, 5.5, 0]", "Vector from the first to the last row."),
    needed("columns", COUNT, "32", "Points in a row."),
    needed("rows", COUNT, "24", "Rows."),
];
#[rustfmt::skip]
const MEASURING: &[Key] = &[
    optional("quantity", ValueShape::Choice(&QUANTITIES),
        "Illuminance that is computed: on the grid's (or points') own plane (default), horizontal, vertical, cylindrical or semi-cylindrical."),
    optional("direction", VECTOR,
        "Horizontal direction that the plane of vertical, or the half cylinder of semi-cylindrical, illuminance faces.")
        .such_as("[1, 0, 0]: the direction that the plane or half cylinder faces"),
    optional("requirements", ValueShape::Object(&requirements::FORM), "Requirements of the receivers."),
];
/// Key that only grids have.
const ABOUT: &[Key] = &[surroundings::KEY];
/// The rule that `spacing` can name.
const SPACING_RULES: [&str; 1] = ["EN 12464-1"];
const SPACINGS: &[(&str, ValueShape)] = &[
    ("A rule: p = 0.2·5^(log₁₀ d) m, at most 10 m.", ValueShape::Choice(&SPACING_RULES)),
    ("A distance.", ABOVE_ZERO),
];

/// Keys of a grid on a surface.
const fn over_a_surface(height_doc: &'static str) -> [Key; 4] {
    [
        needed("surface", TEXT, "\"room/floor\"", "A geometry or a part of one."),
        optional("height", FROM_ZERO, height_doc),
        optional("margin", FROM_ZERO, "Width of the strip along the boundary that is left out."),
        optional("spacing", ValueShape::AnyOf(SPACINGS), "The rule \"EN 12464-1\" (default), or a distance."),
    ]
}

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
    let kind = KINDS.forms[node.fields("a receiver")?.kind(&KINDS)?].name;
    let form = match kind {
        "grid" => GRID,
        "ugr_grid" => UGR_GRID,
        "points" => POINTS,
        "luminance" => observers::LUMINANCE,
        "ugr" => observers::UGR,
        _ => intensity::FORM,
    };
    let fields = node.object(&format!("a {kind} receiver"), &form)?;
    let name = unique_name(&fields, names)?;
    if kind == "intensity" {
        let (quantity, layout, points) = intensity::read(&fields, around.unit, most)?;
        return Ok(ReceiverSet { name, quantity, layout, points, observers: Vec::new(), requirements: Vec::new() });
    }
    if let Some((quantity, layout, points)) = observers::read(kind, &fields, around.unit, around.surfaces, most)? {
        let observers =
            if matches!(quantity, Quantity::Glare(_)) { observers::observers_at(&points) } else { Vec::new() };
        let requirements = requirements::read(&fields, quantity)?;
        return Ok(ReceiverSet { name, quantity, layout, points, observers, requirements });
    }
    let by_surface = fields.get("surface").is_some();
    if kind == "ugr_grid" {
        let (_, places) = match by_surface {
            true => {
                let height_m = fields.get("height").is_none().then_some(SEATED_EYE_M);
                read_surface_grid(node, around, most, &UGR_GRID_ON_SURFACE, height_m)?
            }
            false => read_corner_grid(node, around.unit, most, &UGR_GRID_BY_CORNERS)?,
        };
        let (background, points) = observers::views_around(&fields, &places, most)?;
        let observers = observers::observers_at(&points);
        let quantity = Quantity::Glare(background);
        let requirements = requirements::read(&fields, quantity)?;
        return Ok(ReceiverSet { name, quantity, layout: ReceiverLayout::Points, points, observers, requirements });
    }
    let (layout, mut points) = match kind {
        "grid" if by_surface => read_surface_grid(node, around, most, &GRID_ON_SURFACE, None)?,
        "grid" => read_corner_grid(node, around.unit, most, &GRID_BY_CORNERS)?,
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
    form: &Form,
) -> Result<(ReceiverLayout, Vec<ReceiverPoint>), SceneError> {
    let fields = node.object("a grid given by its corner", form)?;
    let origin = fields.need("origin")?.vector()?;
    let u = fields.need("u")?.vector()?;
    let v_node = fields.need("v")?;
    let v = v_node.vector()?;
    let columns_node = fields.need("columns")?;
    let columns = columns_node.count("the number of columns")?;
    let rows = fields.need("rows")?.count("the number of rows")?;
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
    form: &Form,
    default_height_m: Option<f64>,
) -> Result<(ReceiverLayout, Vec<ReceiverPoint>), SceneError> {
    let fields = node.object("a grid on a surface", form)?;
    let surface_node = fields.need("surface")?;
    let surfaces = around.surfaces.named(&surface_node)?;
    let length_m = |key: &str, quantity: &str| {
        let length = fields.get(key).map_or(Ok(0.0), |node| node.amount(quantity))?;
        Ok(around.unit.length_m(length))
    };
    let height_m = default_height_m.map_or_else(|| length_m("height", "the height"), Ok)?;
    let margin_m = length_m("margin", "the margin")?;
    let spacing_node = fields.get("spacing");
    let spacing = match &spacing_node {
        None => PointSpacing::En12464,
        Some(node) if node.is_text() => {
            node.choice_of(&SPACING_RULES)?;
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
    let node = fields.need("file")?;
    let path = around.base_dir.join(node.name()?);
    let points = parse::read_text(&path, "the points file")
        .and_then(|text| points_file::read(&text, &path, around.unit))
        .map_err(|error| error.named_by(node.as_namer()))?;
    Ok((ReceiverLayout::Points, points))
}
