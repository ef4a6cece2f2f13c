//! The immediate surroundings and the background of a task area by EN 12464-1: a band about the task, and a wider band about that.
//!
//! Both bands are cut into cells. The width of a cell is about the point distance of the standard's rule, and each band is at least one
//! cell wide. In every cell the part on the floor that bounds the room counts, with a point at its centroid. Other task areas within the
//! bands are part of them.

use glam::{DVec2, DVec3};

use super::error::SceneError;
use super::evaluation_grid::overlap;
use super::grid_frame::refuse_too_many;
use super::keys::{FROM_ZERO, Form, Key, TEXT, ValueShape, form, optional};
use super::model::{ReceiverLayout, ReceiverPoint, ReceiverSet};
use super::quantity::Quantity;
use super::reader::{Fields, Node};
use super::requirements;
use super::standard::Area;
use super::surface_grid::en_12464_distance_m;
use super::surfaces::Surfaces;
use super::unique_names::{Names, made_name};
use super::units::LengthUnit;
use super::vectors::direction;

/// Key of a grid for its surroundings.
pub(super) const KEY: Key =
    optional("surroundings", ValueShape::Object(&FORM), "Receivers around the task area, by the rule of EN 12464-1.");

/// Keys of the value.
#[rustfmt::skip]
const FORM: Form = form("Surroundings", "Receivers around a task area by the rule of EN 12464-1: in a band, and in a wider one around that.", &[&[
    optional("within", TEXT, "The floor that bounds the room: a geometry or a part of one; by default the surface on which the grid lies."),
    optional("band", FROM_ZERO, "Width of the immediate surroundings; 0.5 m by default, 0 for none."),
    optional("background", FROM_ZERO, "Width of the background; 3 m by default, 0 for none."),
]]);

/// Default widths in m of the band and of the background: the least values of EN 12464-1.
const USUAL_WIDTHS_M: [f64; 2] = [0.5, 3.0];
/// Least cosine between the normals of floor and task for the floor to face the same way.
const SAME_WAY: f64 = 0.5;
/// Largest sine of the angle by which a grid may differ from a rectangle.
const SKEWNESS: f64 = 1e-6;

/// A rectangle in a task's plane, with its axes.
struct TaskRectangle {
    origin_m: DVec3,
    axes: [DVec3; 2],
    sides_m: [f64; 2],
}

/// Reads the sets about a task area, if its grid has the key.
pub(super) fn read(
    fields: &Fields,
    unit: LengthUnit,
    surfaces: &Surfaces,
    task: &ReceiverSet,
    names: &mut Names,
    most: u64,
) -> Result<Vec<ReceiverSet>, SceneError> {
    let Some(node) = fields.get(KEY.name) else { return Ok(Vec::new()) };
    let given = node.object("the surroundings of a task area", &FORM)?;
    let floor_node = match given.get("within") {
        Some(node) => node,
        None => fields
            .need_as("surface", "\"within\": \"room/floor\" in \"surroundings\": the floor that bounds the room")?,
    };
    let (Some(rectangle), true) = (TaskRectangle::of(&task.layout), task.quantity == Quantity::Perpendicular) else {
        return Err(node.refuse(
            "surroundings need a rectangular task area and the illuminance on its own plane",
            "a grid with \"u\" at right angles to \"v\" and without another \"quantity\"",
            "leave out \"surroundings\", or write receiver sets around the task area yourself",
        ));
    };
    let floor = floor_triangles(surfaces, &floor_node, &rectangle)?;
    let widths_m = [("band", USUAL_WIDTHS_M[0]), ("background", USUAL_WIDTHS_M[1])].map(|(key, usual_m)| {
        let node = given.get(key);
        node.map_or(Ok(usual_m), |node| Ok(unit.length_m(node.amount("the width")?)))
    });
    let [band_m, background_m] = widths_m;
    let (band_m, background_m) = (band_m?, background_m?);
    let [width_m, depth_m] = rectangle.sides_m;
    let rings = [
        (Area::Surroundings, [0.0, 0.0], [width_m, depth_m], band_m),
        (Area::Background, [-band_m; 2], [width_m + band_m, depth_m + band_m], background_m),
    ];
    let (mut sets, mut left) = (Vec::new(), most);
    for (area, low_m, high_m, broad_m) in rings.into_iter().filter(|(.., broad_m)| *broad_m > 0.0) {
        let Some(requirements) = requirements::about(&task.requirements, area) else {
            return Err(node.refuse(
                "the requirements of surroundings follow from the average that the task area requires, but it requires none",
                "\"requirements\" of the task area with an entry of EN 12464-1, or with \"average_lx\"",
                "name the entry, or leave out \"surroundings\"",
            ));
        };
        let ring = RingCells::about(area, low_m, high_m, broad_m, rectangle.sides_m);
        if ring.cells() > left {
            return Err(refuse_too_many(&node, ring.cells()));
        }
        let points = ring.points(&rectangle, &floor);
        if points.is_empty() {
            continue;
        }
        left -= points.len() as u64;
        let name = made_name(format!("{} {}", task.name, area.name()), &node, names)?;
        sets.push(ReceiverSet {
            name,
            quantity: task.quantity,
            layout: ReceiverLayout::Points,
            points,
            observers: Vec::new(),
            requirements,
        });
    }
    if sets.is_empty() {
        return Err(node.refuse(
            "no floor is left around the task area",
            "a task area that is smaller than the floor in \"within\", and widths above 0",
            "leave out \"surroundings\", or give the task area a margin",
        ));
    }
    Ok(sets)
}

impl TaskRectangle {
    /// Returns the rectangle of all cells of a grid; `None` if it is no rectangle.
    fn of(layout: &ReceiverLayout) -> Option<TaskRectangle> {
        let ReceiverLayout::Grid { columns, rows, origin_m, u_m, v_m, .. } = *layout else { return None };
        if direction(u_m).dot(direction(v_m)).abs() > SKEWNESS {
            return None;
        }
        // A row of one point stands in the middle of its cell.
        let cells = |span_m: DVec3, count: u32| match count {
            1 => (span_m, DVec3::ZERO),
            _ => (span_m * (f64::from(count) / f64::from(count - 1)), -0.5 * span_m / f64::from(count - 1)),
        };
        let [(whole_u_m, to_u_m), (whole_v_m, to_v_m)] = [cells(u_m, columns), cells(v_m, rows)];
        Some(TaskRectangle {
            origin_m: origin_m + to_u_m + to_v_m,
            axes: [direction(whole_u_m), direction(whole_v_m)],
            sides_m: [whole_u_m.length(), whole_v_m.length()],
        })
    }

    fn normal(&self) -> DVec3 {
        self.axes[0].cross(self.axes[1])
    }
}

/// The triangles of a floor that face the same way as the task, in m along the task's axes from its corner.
fn floor_triangles(surfaces: &Surfaces, node: &Node, task: &TaskRectangle) -> Result<Vec<[DVec2; 3]>, SceneError> {
    let mut triangles = Vec::new();
    for surface in surfaces.named(node)? {
        for triangle in surfaces.surfaces[surface as usize].triangles.clone() {
            let corners_m = surfaces.triangles[triangle as usize].map(|vertex| surfaces.vertices_m[vertex as usize]);
            let [a_m, b_m, c_m] = corners_m;
            if direction((b_m - a_m).cross(c_m - a_m)).dot(task.normal()) > SAME_WAY {
                triangles.push(corners_m.map(|corner_m| {
                    let from_m = corner_m - task.origin_m;
                    DVec2::new(from_m.dot(task.axes[0]), from_m.dot(task.axes[1]))
                }));
            }
        }
    }
    if triangles.is_empty() {
        return Err(node.refuse(
            "no part of this surface faces the same way as the task area",
            "the floor below a horizontal task area, or the wall behind an upright one",
            "name that surface",
        ));
    }
    Ok(triangles)
}

/// Cells of a plane about a rectangle: cell boundaries along both axes in m, and the ranges of cells that belong to the rectangle itself.
struct RingCells {
    lines_m: [Vec<f64>; 2],
    inner: [std::ops::Range<usize>; 2],
}

impl RingCells {
    /// Makes the cells about the rectangle from `low_m` to `high_m`, in a band of width `broad_m`.
    fn about(area: Area, low_m: [f64; 2], high_m: [f64; 2], broad_m: f64, task_m: [f64; 2]) -> RingCells {
        let whole_m = match area {
            // The band has the same point distance as the task.
            Area::Surroundings => task_m,
            _ => [0, 1].map(|axis| high_m[axis] - low_m[axis] + 2.0 * broad_m),
        };
        let apart_m = en_12464_distance_m([whole_m[0].max(whole_m[1]), whole_m[0].min(whole_m[1])]);
        let cells = |span_m: f64| (span_m / apart_m).round().max(1.0);
        let strip = cells(broad_m);
        let axis = |axis: usize| {
            let (low_m, high_m) = (low_m[axis], high_m[axis]);
            let middle = cells(high_m - low_m);
            let span = |from_m: f64, to_m: f64, count: f64| {
                (0..count as usize).map(move |index| from_m + (to_m - from_m) * index as f64 / count)
            };
            let lines_m: Vec<f64> = span(low_m - broad_m, low_m, strip)
                .chain(span(low_m, high_m, middle))
                .chain(span(high_m, high_m + broad_m, strip))
                .chain([high_m + broad_m])
                .collect();
            (lines_m, strip as usize..(strip + middle) as usize)
        };
        let [(along_m, inner_along), (across_m, inner_across)] = [axis(0), axis(1)];
        RingCells { lines_m: [along_m, across_m], inner: [inner_along, inner_across] }
    }

    fn cells(&self) -> u64 {
        self.lines_m.iter().map(|lines_m| lines_m.len() as u64 - 1).product()
    }

    /// Makes a point for the part of each cell on the floor, row by row.
    fn points(&self, task: &TaskRectangle, floor: &[[DVec2; 3]]) -> Vec<ReceiverPoint> {
        let columns = self.lines_m[0].len() - 1;
        // For every cell: area in m², and area times position.
        let mut filled = vec![(0.0, DVec2::ZERO); self.cells() as usize];
        for corners_m in floor {
            let range = |axis: usize| {
                let lines_m = &self.lines_m[axis];
                let (low_m, high_m) = corners_m
                    .iter()
                    .fold((f64::MAX, f64::MIN), |(low_m, high_m), at| (low_m.min(at[axis]), high_m.max(at[axis])));
                let first = lines_m.partition_point(|line_m| *line_m <= low_m).saturating_sub(1);
                first..lines_m.partition_point(|line_m| *line_m < high_m).min(lines_m.len() - 1)
            };
            for row in range(1) {
                for column in range(0) {
                    if self.inner[0].contains(&column) && self.inner[1].contains(&row) {
                        continue;
                    }
                    let low_m = DVec2::new(self.lines_m[0][column], self.lines_m[1][row]);
                    let size_m = DVec2::new(self.lines_m[0][column + 1], self.lines_m[1][row + 1]) - low_m;
                    let corners = corners_m.map(|corner_m| ((corner_m - low_m) / size_m).to_array());
                    let Some((share, middle)) = overlap(corners, [0.0; 2]) else { continue };
                    let area_m2 = share * size_m.x * size_m.y;
                    let cell = &mut filled[row * columns + column];
                    cell.0 += area_m2;
                    cell.1 += area_m2 * (low_m + DVec2::from(middle) * size_m);
                }
            }
        }
        let point = |(area_m2, moment): (f64, DVec2)| {
            let at_m = moment / area_m2;
            ReceiverPoint {
                position_m: task.origin_m + at_m.x * task.axes[0] + at_m.y * task.axes[1],
                normal: task.normal(),
                weight: area_m2,
                inside: false,
            }
        };
        filled.into_iter().filter(|(area_m2, _)| *area_m2 > 0.0).map(point).collect()
    }
}
