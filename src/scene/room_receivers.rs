//! Receivers of a whole room for an entry of EN 12464-1: its task area, people's heads, its walls, its ceiling, and observers.

use super::error::SceneError;
use super::grid_frame::refuse_too_many;
use super::keys::{FROM_ZERO, Form, TEXT, TYPE, ValueShape, form, needed, optional};
use super::model::{ReceiverLayout, ReceiverPoint, ReceiverSet};
use super::observers::{self, SEATED_EYE_M, observers_at};
use super::quantity::Quantity;
use super::reader::{Fields, Node};
use super::requirements::{ROOM_FORM, RoomEntry};
use super::standard::{Area, Requirement};
use super::surface_grid::{PointSpacing, Rectangle};
use super::surfaces::Surfaces;
use super::unique_names::{Names, made_name, name, unique_name};
use super::units::LengthUnit;

/// The receivers of a room.
#[rustfmt::skip]
pub(super) const FORM: Form = form("room",
    "A whole room for an entry of EN 12464-1: task area, cylinders at the height of people's heads, walls, ceiling and observers.", &[&[
    name("Name of the room; the names of its receiver sets begin with it."),
    TYPE,
    needed("surface", TEXT, "\"room\": a box with \"facing\": \"inward\"",
        "The room: a box that faces inward, or a mesh whose parts are rectangles."),
    optional("height", FROM_ZERO, "Height of the task area over the floor; 0.8 m by default."),
    optional("eye_height", FROM_ZERO, "Height of people's eyes over the floor; 1.2 m by default."),
    optional("margin", FROM_ZERO, "Width of a strip along the walls that is left out of the task area; 0.5 m by default."),
    needed("requirements", ValueShape::Object(&ROOM_FORM), "{ \"en_12464_1\": \"34.2\" }", "The entry of EN 12464-1."),
]]);

/// Default height of the task area above the floor, and default distance from the walls, in m.
const USUAL_HEIGHT_M: f64 = 0.8;
const USUAL_MARGIN_M: f64 = 0.5;
/// Distance of observers from each other in m.
const OBSERVERS_APART_M: f64 = 2.0;
/// Cosines to the vertical: surfaces above the first face upward or downward, and surfaces below the second are walls.
const LEVEL: f64 = 0.99;
const UPRIGHT: f64 = 0.1;

/// Reads the sets of a room. `None` if the receiver has another type.
pub(super) fn read(
    node: &Node,
    fields: &Fields,
    unit: LengthUnit,
    surfaces: &Surfaces,
    names: &mut Names,
    most: u64,
) -> Result<Option<Vec<ReceiverSet>>, SceneError> {
    let is_room = fields.get("type").is_some_and(|node| node.text().is_ok_and(|kind| kind == "room"));
    if !is_room {
        return Ok(None);
    }
    let fields = &fields.clone().of(&FORM)?;
    let name = unique_name(fields, names)?;
    let entry = RoomEntry::read(fields)?;
    let shell = RoomShell::read(&fields.need("surface")?, surfaces)?;
    let length_m = |key: &str, usual_m: f64| {
        let node = fields.get(key);
        node.map_or(Ok(usual_m), |node| Ok(unit.length_m(node.amount("a length")?)))
    };
    let (height_m, eye_m) = (length_m("height", USUAL_HEIGHT_M)?, length_m("eye_height", SEATED_EYE_M)?);
    let margin_m = length_m("margin", USUAL_MARGIN_M)?;
    let Some(field) = shell.floor.shrunk(margin_m) else {
        return Err(fields.get("margin").as_ref().unwrap_or(node).refuse(
            "the margin leaves nothing of the floor",
            "less than half of the floor's shorter side",
            "give a smaller \"margin\"",
        ));
    };

    let mut made = Made { name, node, names, most, sets: Vec::new() };
    let task = grid(&[field], PointSpacing::En12464, height_m);
    made.push("task", Quantity::Perpendicular, task, entry.of(Area::Task))?;
    let heads = grid(&[field], PointSpacing::En12464, eye_m);
    made.push("cylindrical", Quantity::Cylindrical, heads, entry.of(Area::Cylinders))?;
    made.push("walls", Quantity::Perpendicular, grid(&shell.walls, PointSpacing::En12464, 0.0), entry.of(Area::Walls))?;
    made.push(
        "ceiling",
        Quantity::Perpendicular,
        grid(&shell.ceilings, PointSpacing::En12464, 0.0),
        entry.of(Area::Ceiling),
    )?;
    let (_, places) = grid(&[field], PointSpacing::Distance(OBSERVERS_APART_M), eye_m);
    let (background, points) = observers::views_around(fields, &places, most)?;
    made.push("observers", Quantity::Glare(background), (ReceiverLayout::Points, points), entry.of_observers())?;
    Ok(Some(made.sets))
}

/// The rectangles that bound a room.
struct RoomShell {
    floor: Rectangle,
    walls: Vec<Rectangle>,
    ceilings: Vec<Rectangle>,
}

impl RoomShell {
    /// Sorts the surfaces of a geometry by their orientation.
    fn read(node: &Node, surfaces: &Surfaces) -> Result<RoomShell, SceneError> {
        let [mut floors, mut walls, mut ceilings] = [const { Vec::new() }; 3];
        for surface in surfaces.named(node)? {
            let rectangle = Rectangle::of(surfaces, &[surface]).map_err(|reason| {
                let name = &surfaces.surfaces[surface as usize].name;
                node.refuse(
                    format!("a room consists of rectangles, but {name} is not one: {reason}"),
                    "a box with \"facing\": \"inward\", or parts of a mesh that are flat rectangles",
                    "give grids on its floor, walls and ceiling, with \"area\" in their requirements",
                )
            })?;
            match rectangle.normal().z {
                z if z > LEVEL => floors.push(rectangle),
                z if z < -LEVEL => ceilings.push(rectangle),
                z if z.abs() < UPRIGHT => walls.push(rectangle),
                _ => {}
            }
        }
        match floors[..] {
            [floor] => Ok(RoomShell { floor, walls, ceilings }),
            _ => Err(node.refuse(
                format!("a room has one floor, but {} rectangles of this room face upward", floors.len()),
                "a box with \"facing\": \"inward\"",
                "name the room's box, or give grids of their own",
            )),
        }
    }
}

/// Makes the points on rectangles: a grid on a single one, a list on several.
fn grid(rectangles: &[Rectangle], spacing: PointSpacing, height_m: f64) -> (ReceiverLayout, Vec<ReceiverPoint>) {
    let on_one = |rectangle: &Rectangle| {
        let [columns, rows] = rectangle.counts(spacing);
        rectangle.grid(columns as u32, rows as u32, height_m).points()
    };
    match rectangles {
        [one] => on_one(one),
        all => (ReceiverLayout::Points, all.iter().flat_map(|rectangle| on_one(rectangle).1).collect()),
    }
}

/// The sets made so far.
struct Made<'a, 'b> {
    name: String,
    node: &'a Node<'b>,
    names: &'a mut Names,
    most: u64,
    sets: Vec<ReceiverSet>,
}

impl Made<'_, '_> {
    /// Adds a set, unless it has no points.
    fn push(
        &mut self,
        of: &str,
        quantity: Quantity,
        (layout, points): (ReceiverLayout, Vec<ReceiverPoint>),
        requirements: Vec<Requirement>,
    ) -> Result<(), SceneError> {
        if points.is_empty() {
            return Ok(());
        }
        let all = points.len() as u64 + self.sets.iter().map(|set| set.points.len() as u64).sum::<u64>();
        if all > self.most {
            return Err(refuse_too_many(self.node, all));
        }
        let name = made_name(format!("{} {of}", self.name), self.node, self.names)?;
        let observers = if matches!(quantity, Quantity::Glare(_)) { observers_at(&points) } else { Vec::new() };
        self.sets.push(ReceiverSet { name, quantity, layout, points, observers, requirements });
        Ok(())
    }
}
