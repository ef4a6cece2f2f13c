//! Grids and flat surfaces in their plane, as map plots draw them.

use std::collections::HashMap;

use glam::DVec3;

use super::contour::Field;
use super::picture::PagePoint;
use super::texts::{say, separator, words};
use crate::maps::{Estimate, MapKind, MapResult, TableKind, TableRow};
use crate::scene::elements::part_corners;
use crate::scene::{Elements, Quantity, ReceiverLayout, ReceiverSet, Scene, Side, SurfaceId};

/// Approximate number of pieces in which the sloped elements of a surface are drawn.
const MOST_PIECES: f64 = 8_000.0;
/// Triangles lie in one plane if their unit normals differ by less than this. Rounding of f64 coordinates stays far below.
const FLAT_NORMAL: f64 = 1e-6;
/// A corner lies in the plane if its distance from it is below this share of the surface's size.
const FLAT_OFFSET: f64 = 1e-6;
/// A direction runs along an axis if it differs from it by less than this.
const ALONG_AXIS: f64 = 1e-9;

/// An axis of a plane: its label, and the number at each coordinate.
#[derive(Clone, Debug, PartialEq)]
pub struct PlaneAxis {
    /// Label with its unit.
    pub label: String,
    sign: f64,
    offset_m: f64,
}

impl PlaneAxis {
    /// Number in m at a coordinate of the plane.
    pub fn number_m(&self, coordinate_m: f64) -> f64 {
        self.offset_m + self.sign * coordinate_m
    }

    /// Coordinate of the plane at a number in m.
    pub fn coordinate_m(&self, number_m: f64) -> f64 {
        (number_m - self.offset_m) / self.sign
    }
}

/// A plane in the view of its drawing. Horizontal planes are seen from above with x to the right and y up, as plans are drawn.
/// Upright planes are seen from the lit side, with z up.
#[derive(Clone, Debug)]
pub struct Plane {
    right: DVec3,
    up: DVec3,
    /// Horizontal and vertical axis of the drawing.
    pub axes: [PlaneAxis; 2],
    /// Position and view of the plane, in words.
    pub view: String,
}

impl Plane {
    /// The plane through `corners_m` with a normal.
    fn new(normal: DVec3, corners_m: impl Iterator<Item = DVec3>) -> Plane {
        let corners_m: Vec<DVec3> = corners_m.collect();
        let first_m = corners_m.first().copied().unwrap_or(DVec3::ZERO);
        if normal.z.abs() > 1.0 - ALONG_AXIS {
            let axes = ["x", "y"].map(|name| PlaneAxis { label: format!("{name} / m"), sign: 1.0, offset_m: 0.0 });
            let facing = if normal.z > 0.0 { say!("upward") } else { say!("downward") };
            let view = say!("horizontal, facing {}, z = {} m; seen from above", facing, trim(first_m.z));
            return Plane { right: DVec3::X, up: DVec3::Y, axes, view };
        }
        let right = DVec3::Z.cross(normal).normalize();
        let up = normal.cross(right);
        let axes = [named_axis(right, say!("along"), &corners_m), named_axis(up, say!("upward"), &corners_m)];
        let place = if normal.z.abs() > ALONG_AXIS {
            say!("inclined").to_owned()
        } else if (normal.x.abs() - 1.0).abs() < ALONG_AXIS {
            say!("upright, x = {} m", trim(first_m.x))
        } else if (normal.y.abs() - 1.0).abs() < ALONG_AXIS {
            say!("upright, y = {} m", trim(first_m.y))
        } else {
            say!("upright").to_owned()
        };
        Plane { right, up, axes, view: say!("{}; seen from its lit side", place) }
    }

    /// Coordinates of a point in the plane, in m.
    pub fn spot(&self, point_m: DVec3) -> PagePoint {
        [point_m.dot(self.right), point_m.dot(self.up)]
    }
}

fn named_axis(direction: DVec3, other: &str, corners_m: &[DVec3]) -> PlaneAxis {
    for (name, axis) in [("x", DVec3::X), ("y", DVec3::Y), ("z", DVec3::Z)] {
        let along = direction.dot(axis);
        if along.abs() > 1.0 - ALONG_AXIS {
            return PlaneAxis { label: format!("{name} / m"), sign: along.signum(), offset_m: 0.0 };
        }
    }
    let lowest = corners_m.iter().map(|corner| corner.dot(direction)).fold(f64::INFINITY, f64::min);
    PlaneAxis { label: format!("{other} / m"), sign: 1.0, offset_m: if lowest.is_finite() { -lowest } else { 0.0 } }
}

fn trim(length_m: f64) -> String {
    super::numbers::tick((length_m * 1e3).round() / 1e3)
}

/// A cell of a map in its plane.
#[derive(Clone, Debug)]
pub struct FlatCell {
    /// Corners in m.
    pub ring: Vec<PagePoint>,
    /// Value of the map, in the unit of `quantity` or of the plot; `None` inside a solid or under contact with one.
    pub value: Option<f64>,
}

/// A point of a grid in its plane.
#[derive(Clone, Copy, Debug)]
pub struct FlatPoint {
    /// Column and row.
    pub place: [u32; 2],
    /// Position in m.
    pub spot: PagePoint,
    /// Value of the map, in the unit of `quantity` or of the plot.
    pub value: f64,
    /// Standard error of the value.
    pub standard_error: f64,
}

impl FlatPoint {
    /// Value with its error.
    pub fn estimate(&self) -> Estimate {
        Estimate { value: self.value, standard_error: self.standard_error }
    }
}

/// Illuminance on a grid or on one side of a flat surface.
#[derive(Clone, Debug)]
pub struct FlatMap<'a> {
    /// Table row of the grid or surface side.
    pub row: &'a TableRow,
    /// The quantity that is shown.
    pub quantity: Quantity,
    /// The plane and its view.
    pub plane: Plane,
    /// Its cells.
    pub cells: Vec<FlatCell>,
    /// Values between which isolux lines run; positions in m.
    pub field: Field,
    /// Points of a grid that are not inside solids; empty for a surface.
    pub points: Vec<FlatPoint>,
    /// Words for the number of points or elements: `32 × 24 points`, `480 elements`.
    pub count: String,
    /// The map's stated error as a fraction.
    pub estimated_error: f64,
}

impl FlatMap<'_> {
    /// Lowest and highest coordinates in m.
    pub fn bounds_m(&self) -> [PagePoint; 2] {
        let mut bounds = [[f64::INFINITY; 2], [f64::NEG_INFINITY; 2]];
        for spot in self.cells.iter().flat_map(|cell| &cell.ring) {
            for axis in 0..2 {
                bounds[0][axis] = bounds[0][axis].min(spot[axis]);
                bounds[1][axis] = bounds[1][axis].max(spot[axis]);
            }
        }
        bounds
    }
}

/// Name of a receiver's quantity, in words.
pub fn quantity_words(quantity: Quantity) -> &'static str {
    match quantity {
        Quantity::Perpendicular => words!("Illuminance"),
        Quantity::Cylindrical => words!("Cylindrical illuminance"),
        Quantity::SemiCylindrical { .. } => words!("Semi-cylindrical illuminance"),
        Quantity::Luminance => words!("Luminance"),
        Quantity::Glare(_) => words!("Indirect illuminance of the eye"),
        Quantity::Intensity { .. } => words!("Luminous intensity"),
    }
}

/// Unit of an illuminance, as in legends.
pub fn unit_words(quantity: Quantity) -> &'static str {
    match quantity {
        Quantity::Cylindrical => say!("lx, cylindrical"),
        Quantity::SemiCylindrical { .. } => say!("lx, semi-cylindrical"),
        _ => "lx",
    }
}

/// Describes what receives the light at the points of a grid, unless it is the grid's own plane.
fn receiving_words(set: &ReceiverSet, normal: DVec3) -> Option<String> {
    let towards = |direction: DVec3| {
        let named = [
            ("+x", DVec3::X),
            ("−x", -DVec3::X),
            ("+y", DVec3::Y),
            ("−y", -DVec3::Y),
            ("+z", DVec3::Z),
            ("−z", -DVec3::Z),
        ];
        let along = named.iter().find(|(_, axis)| direction.dot(*axis) > 1.0 - ALONG_AXIS);
        let numbers = || format!("({})", direction.to_array().map(trim).join(separator()));
        along.map_or_else(numbers, |(name, _)| (*name).to_owned())
    };
    match set.quantity {
        Quantity::Cylindrical => Some(say!("small upright cylinders").to_owned()),
        Quantity::SemiCylindrical { direction } => {
            Some(say!("small upright half cylinders that look towards {}", towards(direction)))
        }
        Quantity::Perpendicular => {
            let own = set.points.first().map(|point| point.normal)?;
            (own.dot(normal) < 1.0 - ALONG_AXIS).then(|| say!("planes that look towards {}", towards(own)))
        }
        Quantity::Luminance | Quantity::Glare(_) | Quantity::Intensity { .. } => None,
    }
}

/// The flat map of a grid; `None` for receivers that form no grid.
pub fn grid_map<'a>(scene: &Scene, map: &'a MapResult) -> Option<FlatMap<'a>> {
    let MapKind::Receivers(set) = map.kind else { return None };
    let set = &scene.receivers[set];
    let ReceiverLayout::Grid { columns, rows, u_m, v_m, .. } = set.layout else { return None };
    let row = map.tables.iter().find(|row| row.kind == TableKind::Grid)?;
    let normal = u_m.cross(v_m).normalize();
    let mut plane = Plane::new(normal, set.points.iter().map(|point| point.position_m));
    if let Some(receiving) = receiving_words(set, normal) {
        let at = set.points.first().map_or(0.0, |point| point.position_m.z);
        let is_level = normal.z.abs() > 1.0 - ALONG_AXIS;
        plane.view = match is_level {
            true => say!("on {}, z = {} m; seen from above", receiving, trim(at)),
            false => say!("on {}; {}", receiving, plane.view),
        };
    }

    // Every point represents a cell whose sides equal the distances between points.
    let half = |span_m: DVec3, count: u32| 0.5 * span_m / f64::from(count.max(2) - 1);
    let (half_u_m, half_v_m) = (half(u_m, columns), half(v_m, rows));
    let corners_m = |middle_m: DVec3| {
        [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(|(i, j)| middle_m + i * half_u_m + j * half_v_m)
    };
    let values = &map.values.value;
    let cells = set.points.iter().zip(values).map(|(point, value)| FlatCell {
        ring: corners_m(point.position_m).map(|corner| plane.spot(corner)).to_vec(),
        value: (!point.inside).then_some(*value),
    });
    let points = set.points.iter().zip(values).enumerate().filter(|(_, (point, _))| !point.inside);
    let points = points.map(|(index, (point, value))| FlatPoint {
        place: [index as u32 % columns, index as u32 / columns],
        spot: plane.spot(point.position_m),
        value: *value,
        standard_error: map.values.standard_error.get(index).copied().unwrap_or(0.0),
    });
    Some(FlatMap {
        row,
        quantity: set.quantity,
        cells: cells.collect(),
        points: points.collect(),
        field: grid_field(&plane, map, set, columns, rows),
        count: say!("{} × {} points", columns, rows),
        estimated_error: map.error.estimated,
        plane,
    })
}

/// Bilinear field between the points: every square of four is divided into four triangles about its middle.
fn grid_field(plane: &Plane, map: &MapResult, set: &ReceiverSet, columns: u32, rows: u32) -> Field {
    let mut field = Field {
        nodes: set.points.iter().map(|point| plane.spot(point.position_m)).collect(),
        values: map.values.value.clone(),
        triangles: Vec::new(),
    };
    for j in 0..rows.saturating_sub(1) {
        for i in 0..columns.saturating_sub(1) {
            let first = j * columns + i;
            let ring = [first, first + 1, first + columns + 1, first + columns];
            if ring.iter().any(|point| set.points[*point as usize].inside) {
                continue;
            }
            let mean = |of: &dyn Fn(usize) -> f64| ring.iter().map(|point| of(*point as usize)).sum::<f64>() / 4.0;
            let middle = field.nodes.len() as u32;
            let spot = [0, 1].map(|axis| mean(&|point| field.nodes[point][axis]));
            let value = mean(&|point| field.values[point]);
            field.nodes.push(spot);
            field.values.push(value);
            field.triangles.extend((0..4).map(|k| [ring[k], ring[(k + 1) % 4], middle]));
        }
    }
    field
}

/// The rows of surface sides in a map's tables, by surface and side. There may be a hundred thousand of them.
pub struct RowsOfSides<'a>(HashMap<(&'a str, &'a str), &'a TableRow>);

impl<'a> RowsOfSides<'a> {
    /// Indexes the rows of a map.
    pub fn of(map: &'a MapResult) -> RowsOfSides<'a> {
        RowsOfSides(map.tables.iter().rev().map(|row| ((row.name.as_str(), row.side), row)).collect())
    }
}

/// The flat maps of a flat surface's lit sides; none for a curved surface.
pub fn surface_maps<'a>(
    scene: &Scene,
    elements: &Elements,
    (map, rows): (&'a MapResult, &RowsOfSides<'a>),
    surface: SurfaceId,
) -> Vec<FlatMap<'a>> {
    let Some(front) = flat_normal(scene, surface) else { return Vec::new() };
    let name = scene.surfaces[surface as usize].name.as_str();
    let sides = [(Side::Front, front), (Side::Back, -front)];
    sides
        .into_iter()
        .filter_map(|(side, normal)| {
            let row = *rows.0.get(&(name, side.name()))?;
            (row.average.value > 0.0).then(|| side_map(scene, elements, map, surface, (side, normal), row))
        })
        .collect()
}

fn side_map<'a>(
    scene: &Scene,
    elements: &Elements,
    map: &MapResult,
    surface: SurfaceId,
    (side, normal): (Side, DVec3),
    row: &'a TableRow,
) -> FlatMap<'a> {
    let triangles = scene.surfaces[surface as usize].triangles.clone();
    let plane = Plane::new(normal, triangles.flat_map(|triangle| scene.corners_m(triangle)));
    let mut cells = Vec::new();
    let mut areas_m2 = Vec::new();
    let mut count = 0;
    let range = elements.of_surface(scene, surface);
    let is_sloped = !map.values.slopes_lx.is_empty();
    let pieces = if is_sloped { (MOST_PIECES / range.len() as f64).sqrt().clamp(1.0, 8.0) as u32 } else { 1 };
    for index in range {
        let element = elements.element(index);
        if element.side == side {
            count += 1;
            let corners = elements.corners_m(scene, element);
            let area_m2 = elements.area_m2(scene, element) / f64::from(pieces * pieces);
            for piece in 0..pieces * pieces {
                // A sloped element is drawn in pieces, each in the colour of the value at its middle.
                let inner = part_corners(pieces, piece);
                let middle = [0, 1].map(|k| (inner[0][k] + inner[1][k] + inner[2][k]) / 3.0);
                let ring = inner.map(|[u, v]| {
                    plane.spot(corners[0] + u * (corners[1] - corners[0]) + v * (corners[2] - corners[0]))
                });
                let lx = map.values.at_lx(index as usize, middle).max(0.0);
                let in_contact = map.values.in_contact.get(index as usize).is_some_and(|in_contact| *in_contact);
                cells.push(FlatCell { ring: ring.to_vec(), value: (!in_contact).then_some(lx) });
                areas_m2.push(area_m2);
            }
        }
    }
    FlatMap {
        row,
        quantity: Quantity::Perpendicular,
        field: element_field(&cells, &areas_m2),
        count: say!("{} elements", count),
        estimated_error: row.estimated_error,
        points: Vec::new(),
        cells,
        plane,
    }
}

/// The field of a surface: linear over the elements, between their corners. A corner has the mean of the elements around it. If the
/// elements on the other side of an edge are finer, their corners on that edge count too, so that lines continue.
fn element_field(cells: &[FlatCell], areas_m2: &[f64]) -> Field {
    let mut nodes = PlaneCorners::of(cells);
    let mut weights: Vec<f64> = Vec::new();
    let mut rings: Vec<[u32; 3]> = Vec::new();
    for (cell, area_m2) in cells.iter().zip(areas_m2) {
        let Some(lx) = cell.value else {
            continue;
        };
        let ring = std::array::from_fn(|corner| nodes.add(cell.ring[corner]));
        weights.resize(nodes.field.nodes.len(), 0.0);
        for node in ring {
            nodes.field.values[node as usize] += area_m2 * lx;
            weights[node as usize] += area_m2;
        }
        rings.push(ring);
    }
    let mut field = std::mem::take(&mut nodes.field);
    for (value, weight) in field.values.iter_mut().zip(&weights) {
        *value /= weight;
    }
    for ring in rings {
        let mut around = Vec::new();
        for k in 0..3 {
            around.push(ring[k]);
            nodes.on_edge([ring[k], ring[(k + 1) % 3]], &field, &mut around);
        }
        if around.len() == 3 {
            field.triangles.push(ring);
            continue;
        }
        let mean = |of: &dyn Fn(usize) -> f64| ring.iter().map(|node| of(*node as usize)).sum::<f64>() / 3.0;
        let middle = field.nodes.len() as u32;
        let (spot, value) =
            ([0, 1].map(|axis| mean(&|node| field.nodes[node][axis])), mean(&|node| field.values[node]));
        field.nodes.push(spot);
        field.values.push(value);
        let count = around.len();
        field.triangles.extend((0..count).map(|k| [around[k], around[(k + 1) % count], middle]));
    }
    field
}

/// Corners by position. Corners that differ only by f64 rounding are one.
struct PlaneCorners {
    field: Field,
    places: HashMap<[i64; 2], u32>,
    grain: f64,
}

impl PlaneCorners {
    fn of(cells: &[FlatCell]) -> PlaneCorners {
        let extent = cells.iter().flat_map(|cell| &cell.ring).flatten().fold(0.0f64, |most, x| most.max(x.abs()));
        let grain = (extent * 1e-9).max(f64::MIN_POSITIVE);
        PlaneCorners { field: Field::default(), places: HashMap::new(), grain }
    }

    fn place(&self, spot: PagePoint) -> [i64; 2] {
        spot.map(|x| (x / self.grain).round() as i64)
    }

    fn add(&mut self, spot: PagePoint) -> u32 {
        let place = self.place(spot);
        let field = &mut self.field;
        *self.places.entry(place).or_insert_with(|| {
            field.nodes.push(spot);
            field.values.push(0.0);
            field.nodes.len() as u32 - 1
        })
    }

    /// Collects the nodes inside an edge, in order. Elements are repeatedly halved, so nodes lie at midpoints.
    fn on_edge(&self, [from, to]: [u32; 2], field: &Field, found: &mut Vec<u32>) {
        let [a, b] = [from, to].map(|node| field.nodes[node as usize]);
        let [x, y] = self.place([0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])]);
        // The midpoint of two rounded positions may round to either side.
        let near = [0, -1, 1].into_iter().flat_map(|i| [0, -1, 1].map(|j| [x + i, y + j]));
        let Some(middle) = near.filter_map(|place| self.places.get(&place)).next().copied() else {
            return;
        };
        if middle != from && middle != to {
            self.on_edge([from, middle], field, found);
            found.push(middle);
            self.on_edge([middle, to], field, found);
        }
    }
}

/// The normal of a surface, if all its triangles lie in one plane and face one way.
pub fn flat_normal(scene: &Scene, surface: SurfaceId) -> Option<DVec3> {
    let triangles = scene.surfaces[surface as usize].triangles.clone();
    let first = triangles.start;
    let (normal, origin_m) = (scene.triangle_normal(first), scene.corners_m(first)[0]);
    let mut size_m = 0.0f64;
    let mut off_m = 0.0f64;
    for triangle in triangles {
        if scene.triangle_normal(triangle).distance(normal) > FLAT_NORMAL {
            return None;
        }
        for corner_m in scene.corners_m(triangle) {
            size_m = size_m.max(corner_m.distance(origin_m));
            off_m = off_m.max((corner_m - origin_m).dot(normal).abs());
        }
    }
    (off_m <= FLAT_OFFSET * size_m).then_some(normal)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A square of two triangles; one is divided into four, and one of these again. Every edge inside the square then belongs to
    /// two triangles of the field, so that no line ends there. If the division is left out (the planted fault), some edges belong
    /// to one triangle only.
    #[test]
    fn fields_have_no_gaps_where_fine_elements_meet_coarse_ones() {
        let cut = |ring: [PagePoint; 3]| -> Vec<[PagePoint; 3]> {
            let part = |number: u32| {
                part_corners(2, number).map(|[u, v]| {
                    [0, 1].map(|k| ring[0][k] + u * (ring[1][k] - ring[0][k]) + v * (ring[2][k] - ring[0][k]))
                })
            };
            (0..4).map(part).collect()
        };
        let (upper, lower) = ([[0.0, 0.0], [3.1, 2.0], [0.0, 2.0]], [[0.0, 0.0], [3.1, 0.0], [3.1, 2.0]]);
        let mut rings = vec![upper];
        let fine = cut(lower);
        rings.extend(&fine[1..]);
        rings.extend(cut(fine[0]));
        let cell = |ring: &[PagePoint; 3]| FlatCell { ring: ring.to_vec(), value: Some(ring[0][0] + 2.0 * ring[1][1]) };
        let cells: Vec<FlatCell> = rings.iter().map(cell).collect();
        let on_rim =
            |a: PagePoint, b: PagePoint| (0..2).any(|k| a[k] == b[k] && (a[k] == 0.0 || a[k] == [3.1, 2.0][k]));
        let gaps = |field: &Field, triangles: &[[u32; 3]]| {
            let mut edges: HashMap<[u32; 2], u32> = HashMap::new();
            for triangle in triangles {
                for k in 0..3 {
                    let (a, b) = (triangle[k], triangle[(k + 1) % 3]);
                    *edges.entry([a.min(b), a.max(b)]).or_default() += 1;
                }
            }
            let spot = |node: u32| field.nodes[node as usize];
            edges.iter().filter(|([a, b], count)| **count != 2 && !on_rim(spot(*a), spot(*b))).count()
        };
        let field = element_field(&cells, &vec![1.0; cells.len()]);
        assert_eq!(gaps(&field, &field.triangles), 0);
        let mut nodes = PlaneCorners::of(&cells);
        let uncut: Vec<[u32; 3]> =
            cells.iter().map(|cell| std::array::from_fn(|corner| nodes.add(cell.ring[corner]))).collect();
        assert!(gaps(&nodes.field, &uncut) > 0, "the planted fault passed");
    }
}
