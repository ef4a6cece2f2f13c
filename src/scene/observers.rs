//! Reads the receivers with directions of view: luminance and glare.

use glam::{DQuat, DVec3};

use super::elements::part_corners;
use super::error::SceneError;
use super::grid_frame::refuse_too_many;
use super::keys::{COUNT, Form, Key, NOT_EMPTY, NUMBER, TEXT, TYPE, VECTOR, ValueShape, form, needed, optional};
use super::model::{GlareObserver, ReceiverLayout, ReceiverPoint};
use super::quantity::{Background, Quantity};
use super::reader::{Fields, Node};
use super::requirements;
use super::surfaces::Surfaces;
use super::unique_names::name;
use super::units::LengthUnit;

/// Height in m of a seated observer's eye above the floor.
pub(super) const SEATED_EYE_M: f64 = 1.2;
/// Key of the position of an eye.
const EYE: Key = needed("position", VECTOR, "[1, 3, 1.2]", "Position of the eye.");
/// Directions, at least one.
const DIRECTIONS: ValueShape = ValueShape::List(&VECTOR, NOT_EMPTY);

/// A receiver of luminance.
#[rustfmt::skip]
pub(super) const LUMINANCE: Form = form("luminance",
    "Luminance seen from a point, in one of: given directions, a fan of them, a picture, the elements of a surface.", &[&[
    name("Name of the receivers."),
    TYPE,
    EYE,
    optional("directions", DIRECTIONS, "Directions of view.").such_as("[[1, 0, 0]]"),
    optional("fan", ValueShape::Object(&FAN), "Directions in a fan about an axis."),
    optional("view", ValueShape::Object(&VIEW), "A picture on a flat screen."),
    optional("surface", TEXT, "A geometry or a part of one: the luminance of each of its elements towards the eye."),
]]);

#[rustfmt::skip]
const FAN: Form = form("Fan", "Directions of view turned evenly about an axis, counter-clockwise seen from its tip.", &[&[
    needed("direction", VECTOR, "[1, 0, 0]", "The direction at 0°."),
    optional("axis", VECTOR, "Axis of the fan (default [0, 0, 1])."),
    needed("from_deg", NUMBER, "-60", "Angle of the first direction."),
    needed("to_deg", NUMBER, "60", "Angle of the last direction."),
    needed("count", COUNT, "25", "Number of directions."),
]]);

#[rustfmt::skip]
const VIEW: Form = form("View", "A picture on a flat screen: one direction through the middle of each cell, row by row from the upper left.", &[&[
    needed("direction", VECTOR, "[1, 0, 0]", "Direction of the middle of the picture."),
    optional("up", VECTOR, "Upward direction in the picture (default [0, 0, 1])."),
    needed("field_deg", ValueShape::List(&NUMBER, [2, 2]), "[90, 60]", "Full angles of view in degrees, across and upright, at most 170."),
    needed("columns", COUNT, "96", "Cells in a row."),
    needed("rows", COUNT, "64", "Rows."),
]]);

/// An observer.
#[rustfmt::skip]
pub(super) const UGR: Form = form("ugr", "Unified glare rating of an observer (CIE 117).", &[&[
    name("Name of the receiver."),
    TYPE,
    EYE,
    needed("view_direction", VECTOR, "[1, 0, 0]", "Line of sight."),
    background(
        "Where the background luminance is determined: at the eye (\"observer\", default), or as a mean over the walls between eye and \
         luminaires (\"tabular\", as in UGR tables)."),
    REQUIREMENTS,
]]);

/// Keys of a grid of observers besides its points.
#[rustfmt::skip]
pub(super) const OBSERVING: &[Key] = &[
    optional("view_directions", DIRECTIONS, "Lines of sight; by default eight horizontal ones all around."),
    background("Where the background luminance is determined."),
    REQUIREMENTS,
];

const REQUIREMENTS: Key =
    optional("requirements", ValueShape::Object(&requirements::FORM), "Requirements of the ratings.");

/// Key of where the background of a glare rating is taken.
const fn background(doc: &'static str) -> Key {
    optional("background", ValueShape::Choice(&["observer", "tabular"]), doc)
}

/// Default directions of view for a grid of observers: eight, counter-clockwise from +x.
const VIEWS_AROUND: [DVec3; 8] = [
    DVec3::X,
    DVec3::new(1.0, 1.0, 0.0),
    DVec3::Y,
    DVec3::new(-1.0, 1.0, 0.0),
    DVec3::NEG_X,
    DVec3::new(-1.0, -1.0, 0.0),
    DVec3::NEG_Y,
    DVec3::new(1.0, -1.0, 0.0),
];

/// Widest field of a picture on a flat screen, in degrees. Beyond it the cells at the edge cover almost no solid angle.
const WIDEST_FIELD_DEG: f64 = 170.0;
/// A line of sight to an element begins just before the element. Its distance from the surface is the first share of the element's edge.
/// It is at least the second share of the scene's size. So rounding never puts it behind the surface.
const BEFORE_ELEMENT: f64 = 1e-3;
const BEFORE_SURFACE: f64 = 1e-5;
/// Least cosine between an element's normal and the direction to the eye for the eye to see that side.
const GRAZING: f64 = 0.01;
/// Least sine between a direction and the axis that it must not be parallel to.
const PARALLEL: f64 = 1e-6;

/// Reads a receiver type with directions of view: its quantity, its layout, and one point per direction. Returns `None` for the types
/// with points on planes. `most` limits the number of points of a fan or a view.
pub(super) fn read(
    kind: &str,
    fields: &Fields,
    unit: LengthUnit,
    surfaces: &Surfaces,
    most: u64,
) -> Result<Option<(Quantity, ReceiverLayout, Vec<ReceiverPoint>)>, SceneError> {
    if kind != "luminance" && kind != "ugr" {
        return Ok(None);
    }
    let position_m = unit.point_m(fields.need("position")?.vector()?);
    let facing = |directions: Vec<DVec3>| {
        let point = |normal: DVec3| ReceiverPoint { position_m, normal, weight: 1.0, inside: false };
        directions.into_iter().map(point).collect()
    };
    if kind == "ugr" {
        let view = fields.need("view_direction")?.direction()?;
        // If the background is that of walls, the points move there once the walls are known.
        let quantity = Quantity::Glare(read_background(fields)?);
        return Ok(Some((quantity, ReceiverLayout::Points, facing(vec![view]))));
    }
    let given: Vec<&str> =
        ["directions", "fan", "view", "surface"].into_iter().filter(|key| fields.get(key).is_some()).collect();
    if given[..] == ["surface"] {
        let points = towards_elements(&fields.need("surface")?, surfaces, position_m, most)?;
        return Ok(Some((Quantity::Luminance, ReceiverLayout::Towards { eye_m: position_m }, points)));
    }
    let (layout, directions) = match given[..] {
        ["fan"] => read_fan(&fields.need("fan")?, most)?,
        ["view"] => read_view(&fields.need("view")?, most)?,
        ["directions"] | [] => (ReceiverLayout::Points, read_list(&fields.need("directions")?)?),
        _ => {
            return Err(fields.node().refuse_as(
                "a luminance receiver has one set of directions",
                given.join(", "),
                "one of \"directions\", \"fan\", \"view\" and \"surface\"",
                "make a separate receiver of each",
            ));
        }
    };
    Ok(Some((Quantity::Luminance, layout, facing(directions))))
}

fn read_background(fields: &Fields) -> Result<Background, SceneError> {
    Ok(match fields.get("background").map_or(Ok(0), |node| node.choice())? {
        0 => Background::Observer,
        _ => Background::Tabular,
    })
}

/// Makes observers at some points, each looking in all directions of a grid of observers, point by point. `most` limits their number.
pub(super) fn views_around(
    fields: &Fields,
    places: &[ReceiverPoint],
    most: u64,
) -> Result<(Background, Vec<ReceiverPoint>), SceneError> {
    let views = match fields.get("view_directions") {
        Some(node) => read_list(&node)?,
        None => VIEWS_AROUND.map(DVec3::normalize).to_vec(),
    };
    let count = places.len() as u64 * views.len() as u64;
    if count > most {
        return Err(refuse_too_many(fields.node(), count));
    }
    let facing = |place: &ReceiverPoint, normal: DVec3| ReceiverPoint { normal, weight: 1.0, ..*place };
    let points = places.iter().flat_map(|place| views.iter().map(move |view| facing(place, *view))).collect();
    Ok((read_background(fields)?, points))
}

/// Makes lines of sight from an eye to the middles of all elements that turn a side to it. They begin just before the element. Obstacles
/// in between therefore hide nothing: the result is the luminance of the element, not of the view.
fn towards_elements(
    node: &Node,
    surfaces: &Surfaces,
    eye_m: DVec3,
    most: u64,
) -> Result<Vec<ReceiverPoint>, SceneError> {
    let low_m = surfaces.vertices_m.iter().copied().fold(DVec3::INFINITY, DVec3::min);
    let high_m = surfaces.vertices_m.iter().copied().fold(DVec3::NEG_INFINITY, DVec3::max);
    let least_m = BEFORE_SURFACE * low_m.distance(high_m);
    let named = surfaces.named(node)?;
    let triangles = || {
        named
            .iter()
            .map(|surface| &surfaces.surfaces[*surface as usize])
            .flat_map(|surface| surface.triangles.clone().map(|triangle| (triangle as usize, surface.two_sided)))
    };
    let parts = |triangle: usize| u64::from(surfaces.divisions[triangle]).pow(2);
    let count: u64 = triangles().map(|(triangle, _)| parts(triangle)).sum();
    if count > most {
        return Err(refuse_too_many(node, count));
    }
    let mut points = Vec::new();
    for (triangle, two_sided) in triangles() {
        let [a, b, c] = surfaces.triangles[triangle].map(|vertex| surfaces.vertices_m[vertex as usize]);
        let twice_area = (b - a).cross(c - a);
        let front = twice_area.normalize();
        let divisions = surfaces.divisions[triangle];
        let area_m2 = 0.5 * twice_area.length() / parts(triangle) as f64;
        for side in [front, -front].into_iter().take(if two_sided { 2 } else { 1 }) {
            for part in 0..divisions * divisions {
                let corners = part_corners(divisions, part);
                let [u, v] = [0, 1].map(|k| corners.iter().map(|corner| corner[k]).sum::<f64>() / 3.0);
                let middle_m = a + u * (b - a) + v * (c - a);
                let offset_m = eye_m - middle_m;
                let distance_m = offset_m.length();
                let towards = offset_m / distance_m;
                if distance_m > 0.0 && towards.dot(side) > GRAZING {
                    let before_m = (BEFORE_ELEMENT * area_m2.sqrt()).max(least_m) / towards.dot(side);
                    let position_m = middle_m + before_m.min(0.5 * distance_m) * towards;
                    points.push(ReceiverPoint { position_m, normal: -towards, weight: area_m2, inside: false });
                }
            }
        }
    }
    if points.is_empty() {
        let remedy = "move \"position\" to where its front is seen, or set \"two_sided\": true";
        return Err(node.refuse(
            "no reflecting side of this surface faces the eye",
            "a surface that faces the eye",
            remedy,
        ));
    }
    Ok(points)
}

fn read_list(node: &Node) -> Result<Vec<DVec3>, SceneError> {
    let directions = node.items("directions")?;
    if directions.is_empty() {
        return Err(node.refuse("no direction to look in", "at least one direction", "add [x, y, z]"));
    }
    directions.iter().map(Node::direction).collect()
}

/// Reads directions turned about an axis, counter-clockwise as seen from its tip.
fn read_fan(node: &Node, most: u64) -> Result<(ReceiverLayout, Vec<DVec3>), SceneError> {
    let fields = node.object("a fan of directions", &FAN)?;
    let direction = fields.need("direction")?.direction()?;
    let axis = fields.get("axis").map_or(Ok(DVec3::Z), |axis| axis.direction())?;
    check_not_parallel(node, direction, axis, "axis")?;
    let from_deg = fields.need("from_deg")?.number()?;
    let to_deg = fields.need("to_deg")?.number()?;
    let count_node = fields.need("count")?;
    let count = count_node.count("the number of directions")?;
    if u64::from(count) > most {
        return Err(refuse_too_many(&count_node, u64::from(count)));
    }
    let share = |index: u32| if count > 1 { f64::from(index) / f64::from(count - 1) } else { 0.5 };
    let turned = |index: u32| {
        let angle = (from_deg + share(index) * (to_deg - from_deg)).to_radians();
        (DQuat::from_axis_angle(axis, angle) * direction).normalize()
    };
    Ok((ReceiverLayout::Fan { from_deg, to_deg }, (0..count).map(turned).collect()))
}

/// Reads directions through the middles of the cells of a flat screen.
fn read_view(node: &Node, most: u64) -> Result<(ReceiverLayout, Vec<DVec3>), SceneError> {
    let fields = node.object("a view", &VIEW)?;
    let direction = fields.need("direction")?.direction()?;
    let up = fields.get("up").map_or(Ok(DVec3::Z), |up| up.direction())?;
    check_not_parallel(node, direction, up, "up")?;
    let field_node = fields.need("field_deg")?;
    let angles = field_node.items("angles of view")?;
    let [across, upright] = &angles[..] else {
        let expected = "two angles: across the picture and upright";
        return Err(field_node.refuse_as("a field of view", format!("{} numbers", angles.len()), expected, "[90, 60]"));
    };
    let angle = |node: &Node| {
        let angle_deg = node.above_zero("an angle of view")?;
        if angle_deg > WIDEST_FIELD_DEG {
            let expected = format!("at most {WIDEST_FIELD_DEG}°");
            return Err(node.refuse(
                "the field is too wide for a flat picture",
                expected,
                "use several views, or a fan",
            ));
        }
        Ok(angle_deg)
    };
    let field_deg = [angle(across)?, angle(upright)?];
    let columns_node = fields.need("columns")?;
    let columns = columns_node.count("the number of columns")?;
    let rows = fields.need("rows")?.count("the number of rows")?;
    if u64::from(columns) * u64::from(rows) > most {
        return Err(refuse_too_many(&columns_node, u64::from(columns) * u64::from(rows)));
    }
    let right = direction.cross(up).normalize();
    let upwards = right.cross(direction);
    let half = field_deg.map(|angle_deg| (0.5 * angle_deg).to_radians().tan());
    let middle = |index: u32, count: u32| 2.0 * (f64::from(index) + 0.5) / f64::from(count) - 1.0;
    let directions = (0..rows)
        .flat_map(|row| (0..columns).map(move |column| (column, row)))
        .map(|(column, row)| {
            let (x, y) = (half[0] * middle(column, columns), -half[1] * middle(row, rows));
            (direction + x * right + y * upwards).normalize()
        })
        .collect();
    Ok((ReceiverLayout::View { columns, rows, field_deg }, directions))
}

fn check_not_parallel(node: &Node, direction: DVec3, other: DVec3, key: &str) -> Result<(), SceneError> {
    if direction.cross(other).length() > PARALLEL {
        return Ok(());
    }
    Err(node.refuse_as(
        format!("\"direction\" and \"{key}\" are parallel"),
        format!("[{}, {}, {}]", direction.x, direction.y, direction.z),
        format!("an \"{key}\" that is not parallel to \"direction\""),
        format!("give \"{key}\" another direction"),
    ))
}

/// Makes an observer at each point, looking along its normal.
pub(super) fn observers_at(points: &[ReceiverPoint]) -> Vec<GlareObserver> {
    points.iter().map(|point| GlareObserver { eye_m: point.position_m, view: point.normal, inside: false }).collect()
}
