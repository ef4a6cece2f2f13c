//! Solves a room on finer and finer meshes (docs/methods.md (11)), and computes its maps from them.

use std::sync::OnceLock;

use glam::DVec3;
use rayon::prelude::*;

use super::error::{NotARoom, out_of_time};
use super::faces::{RoomFace, triangle_rule};
use super::field::{AxisPoints, FacePoints, IndirectField};
use super::mesh::{RoomMesh, extrapolated, graded_edges};
use super::room::BoxedRoom;
use crate::maps::{
    MapKind, MapResult, MapValues, StatedValues, TableKind, grid_places, grid_slopes, stated_row, worst_case_error,
};
use crate::scene::{
    ElementSizes, Elements, EvaluationGrid, ReceiverLayout, ReceiverPoint, Scene, Side, evaluation_grid,
};

/// Divisions of a face without breaks on each mesh, from the coarsest. The last three meshes are extrapolated.
const DIVISIONS: [usize; 5] = [2, 4, 8, 16, 32];
/// Maximum number of rectangles of the finest mesh: about 300 MB of exchange areas.
const MOST_RECTANGLES: usize = 9000;
/// An element larger than this share of the shortest interpolation panel is integrated in parts.
const ELEMENT_SHARE: f64 = 0.125;
/// Maximum number of parts along an element's edge.
const MOST_PARTS: f64 = 32.0;
/// A normal counts as along an axis if its component there differs from 1 by less than this.
const ALONG_AXIS: f64 = 1e-12;

/// A scene that radiosity can solve, with the meshes solved so far.
///
/// ```
/// # use luxmc::radiosity::Radiosity;
/// # use luxmc::check::scene_from_json;
/// let scene = r#"{ "version": 1, "materials": { "paint": { "type": "diffuse", "reflectance": 0.5 } },
///     "geometry": [ { "name": "room", "type": "box", "min": [0,0,0], "max": [4,4,4], "facing": "inward",
///                     "material": "paint" } ],
///     "luminaires": [ { "name": "lamp", "type": "point", "position": [2,2,2], "luminous_flux_lm": 10000 } ] }"#;
/// let scene = scene_from_json(scene, None, std::path::Path::new(".")).unwrap();
/// let radiosity = Radiosity::new(&scene).unwrap();
/// let map = radiosity.map(luxmc::maps::MapKind::Elements);
/// let (value, error) = (map.values.value[0], map.values.standard_error[0]);
/// assert!((value - 625.0 / 3.0).abs() < error && error < 2.0);
/// ```
pub struct Radiosity<'a> {
    scene: &'a Scene,
    room: BoxedRoom,
    nodes: FacePoints,
    /// The meshes so far, from the coarsest. Each has its values at the interpolation points, computed on first use.
    meshes: Vec<(RoomMesh, OnceLock<[Vec<f64>; 6]>)>,
}

/// Flux that the surfaces absorb according to a map, and its estimated error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AbsorbedFlux {
    /// Σ (1 − ρ)EA in lm.
    pub absorbed_lm: f64,
    /// Its estimated error in lm.
    pub estimated_error_lm: f64,
}

impl<'a> Radiosity<'a> {
    /// Checks that a scene is a room that radiosity can solve.
    ///
    /// # Errors
    /// Fails with the part of the scene that it cannot compute, and names a method that can.
    pub fn check(scene: &Scene) -> Result<(), NotARoom> {
        BoxedRoom::of(scene).map(|_| ())
    }

    /// Solves a scene on the three coarsest meshes.
    ///
    /// # Errors
    /// As [`Radiosity::check`].
    pub fn new(scene: &'a Scene) -> Result<Radiosity<'a>, NotARoom> {
        Radiosity::new_within(scene, &|| false)
    }

    /// Like [`Radiosity::new`], but fails if the time is over first. Hundreds of luminaires with measured distributions take long.
    ///
    /// # Errors
    /// As [`Radiosity::check`], and if the time is over.
    pub fn new_within(scene: &'a Scene, is_over: &dyn Fn() -> bool) -> Result<Radiosity<'a>, NotARoom> {
        let room = BoxedRoom::of(scene)?;
        let nodes = FacePoints { lines: [0, 1, 2].map(|axis| AxisPoints::new(&room.breaks[axis])) };
        let mut radiosity = Radiosity { scene, room, nodes, meshes: Vec::new() };
        for _ in 0..3 {
            radiosity.add_mesh(is_over);
            if is_over() {
                return Err(out_of_time());
            }
        }
        Ok(radiosity)
    }

    /// Adds a mesh twice as fine, which takes about 16 times as long as the one before. Returns `false` if the finest mesh is
    /// reached.
    pub fn refine(&mut self) -> bool {
        let Some(divisions) = DIVISIONS.get(self.meshes.len()) else { return false };
        let parts = [0, 1, 2].map(|axis| graded_edges(&self.room.breaks[axis], *divisions).len() - 1);
        if 2 * (parts[0] * parts[1] + parts[1] * parts[2] + parts[2] * parts[0]) > MOST_RECTANGLES {
            return false;
        }
        self.add_mesh(&|| false);
        true
    }

    /// Number of rectangles of the finest mesh so far.
    pub fn rectangles(&self) -> usize {
        self.meshes.last().map_or(0, |(mesh, _)| mesh.len())
    }

    /// Adds a mesh. If the time is over in between, the mesh is useless.
    fn add_mesh(&mut self, is_over: &dyn Fn() -> bool) {
        let room = &self.room;
        let divisions = DIVISIONS[self.meshes.len()];
        let edges = [0, 1, 2].map(|axis| graded_edges(&room.breaks[axis], divisions));
        let mesh = RoomMesh::solved(
            room.size_m,
            edges,
            |face, [u, v]| room.reflectance(face, [0.5 * (u[0] + u[1]), 0.5 * (v[0] + v[1])]),
            |face, stretches| if is_over() { 0.0 } else { room.direct_over_rectangle_lx(face, stretches) },
        );
        self.meshes.push((mesh, OnceLock::new()));
    }

    fn last_three(&self) -> [&(RoomMesh, OnceLock<[Vec<f64>; 6]>); 3] {
        let first = self.meshes.len() - 3;
        [0, 1, 2].map(|level| &self.meshes[first + level])
    }

    /// Computes a map from the meshes so far. The `standard_error` of each value is its estimated error.
    pub fn map(&self, kind: MapKind) -> MapResult {
        match kind {
            MapKind::Elements => self.element_map(),
            MapKind::Receivers(set) => self.receiver_map(set),
        }
    }

    fn element_map(&self) -> MapResult {
        let (scene, elements) = (self.scene, Elements::of(self.scene));
        let at_nodes = |mesh: &RoomMesh| self.nodes.indirect_lx(mesh, self.room.size_m);
        let values = self.last_three().map(|(mesh, values)| values.get_or_init(|| at_nodes(mesh)));
        let field = IndirectField::new(&self.nodes, values);
        let entries: Vec<(f64, f64, f64)> =
            (0..elements.len() as u32).into_par_iter().map(|index| self.element_lx(&field, &elements, index)).collect();
        let values = values_of(&entries);
        let weights: Vec<f64> =
            (0..elements.len() as u32).map(|index| elements.area_m2(scene, elements.element(index))).collect();
        let tables = (0..scene.surfaces.len() as u32)
            .map(|surface| {
                let range = elements.of_surface(scene, surface);
                let range = range.start as usize..range.end as usize;
                let area_m2 = weights[range.clone()].iter().sum();
                let part = StatedValues::of(&values, &weights, range.clone());
                let entries: Vec<usize> = range.collect();
                let halves_lx = |entry: usize| [values.value[entry]; 2];
                let slopes = |grid: &EvaluationGrid| grid_slopes(scene, &elements, &entries, grid, |_| true, halves_lx);
                let grid = evaluation_grid(scene, &elements, surface, Side::Front, |_| (1.0, 1.0), ElementSizes::Fine);
                let places = grid_places(&values, grid.as_ref(), slopes);
                let name = &scene.surfaces[surface as usize].name;
                stated_row(name, TableKind::Surface, "front", area_m2, &part, &places)
            })
            .collect();
        let error = worst_case_error(&StatedValues::of(&values, &weights, 0..entries.len()));
        result(self.scene, MapKind::Elements, values, error, tables)
    }

    /// Mean direct and indirect illuminance over an element, and the error of their sum, in lx.
    fn element_lx(&self, field: &IndirectField, elements: &Elements, index: u32) -> (f64, f64, f64) {
        let element = elements.element(index);
        let triangle = element.triangle;
        let face = self.room.faces[triangle as usize];
        let corners = elements.corners_m(self.scene, element).map(|corner| self.room.settle(corner));
        let (direct_lx, direct_error_lx) = self.room.direct_over_triangle_lx(face, corners);
        let [a, b, c] = corners.map(|corner| face.place(corner));
        let extent = |axis: usize| {
            let places = [a[axis], b[axis], c[axis]];
            places.into_iter().fold(0.0, f64::max) - places.into_iter().fold(f64::INFINITY, f64::min)
        };
        let shortest = face.other_axes().map(|axis| self.nodes.lines[axis].shortest_m());
        let share = (extent(0) / shortest[0]).max(extent(1) / shortest[1]);
        let parts = (share / ELEMENT_SHARE).ceil().clamp(1.0, MOST_PARTS) as u32;
        let at = |s: f64, t: f64| [0, 1].map(|k| a[k] + (b[k] - a[k]) * s + (c[k] - a[k]) * t);
        let (mut indirect_lx, mut error_lx) = (0.0, 0.0);
        let step = 1.0 / f64::from(parts);
        for i in 0..parts {
            for j in 0..parts - i {
                let corner = [f64::from(i) * step, f64::from(j) * step];
                for ([along, across], weight) in triangle_rule() {
                    let (s, t) = (along * (1.0 - across) * step, along * across * step);
                    let mut take = |place: [f64; 2]| {
                        let (value_lx, one_error_lx) = field.at_lx(face, place);
                        indirect_lx += weight * step * step * value_lx;
                        error_lx += weight * step * step * one_error_lx;
                    };
                    take(at(corner[0] + s, corner[1] + t));
                    // Adds the adjacent triangle that is turned by half a turn, except at the end of a row.
                    if j + 1 < parts - i {
                        take(at(corner[0] + step - s, corner[1] + step - t));
                    }
                }
            }
        }
        (direct_lx, indirect_lx, error_lx + direct_error_lx)
    }

    fn receiver_map(&self, set: usize) -> MapResult {
        let receivers = &self.scene.receivers[set];
        let points: Vec<(f64, f64, f64)> = receivers.points.par_iter().map(|point| self.point_lx(point)).collect();
        let values = values_of(&points);
        let weights: Vec<f64> = receivers.points.iter().map(|p| if p.inside { 0.0 } else { p.weight }).collect();
        let (kind, area_m2) = match receivers.layout {
            ReceiverLayout::Grid { area_m2, .. } => (TableKind::Grid, area_m2),
            _ => (TableKind::Points, 0.0),
        };
        let all = StatedValues::of(&values, &weights, 0..points.len());
        let (error, tables) =
            (worst_case_error(&all), vec![stated_row(&receivers.name, kind, "front", area_m2, &all, &all.places())]);
        result(self.scene, MapKind::Receivers(set), values, error, tables)
    }

    fn point_lx(&self, point: &ReceiverPoint) -> (f64, f64, f64) {
        if point.inside {
            return (0.0, 0.0, 0.0);
        }
        let position = self.room.settle(point.position_m);
        let along = (0..3).find(|axis| point.normal[*axis].abs() > 1.0 - ALONG_AXIS);
        let normal = along.map_or(point.normal, |axis| DVec3::AXES[axis] * point.normal[axis].signum());
        let own = self.room.face_at(position).filter(|face: &RoomFace| face.normal().dot(normal) > 0.5);
        let direct_lx = self.room.direct_at_lx(position, normal, own);
        let (indirect_lx, error_lx) =
            extrapolated(self.last_three().map(|(mesh, _)| mesh.indirect_at_lx(position, normal)));
        (direct_lx, indirect_lx, error_lx)
    }

    /// Σ (1 − ρ)EA from an element map of this scene.
    pub fn absorbed_flux(&self, elements_map: &MapResult) -> AbsorbedFlux {
        let elements = Elements::of(self.scene);
        let mut sum = AbsorbedFlux { absorbed_lm: 0.0, estimated_error_lm: 0.0 };
        for index in 0..elements.len() as u32 {
            let place = elements.element(index);
            let corners = elements.corners_m(self.scene, place).map(|corner| self.room.settle(corner));
            let face = self.room.faces[place.triangle as usize];
            let reflectance = self.room.reflectance(face, face.place(corners.iter().sum::<DVec3>() / 3.0));
            let share_m2 = (1.0 - reflectance) * elements.area_m2(self.scene, place);
            sum.absorbed_lm += share_m2 * elements_map.values.value[index as usize];
            sum.estimated_error_lm += share_m2 * elements_map.values.standard_error[index as usize];
        }
        sum
    }
}

fn values_of(entries: &[(f64, f64, f64)]) -> MapValues {
    MapValues {
        value: entries.iter().map(|(direct, indirect, _)| direct + indirect).collect(),
        standard_error: entries.iter().map(|(_, _, error)| *error).collect(),
        direct: entries.iter().map(|(direct, _, _)| *direct).collect(),
        indirect: entries.iter().map(|(_, indirect, _)| *indirect).collect(),
        ..MapValues::default()
    }
}

fn result(
    scene: &Scene,
    kind: MapKind,
    values: MapValues,
    error: crate::maps::MapError,
    tables: Vec<crate::maps::TableRow>,
) -> MapResult {
    MapResult {
        name: kind.name(scene).to_owned(),
        kind,
        quantity: kind.quantity(scene),
        method: "radiosity".to_owned(),
        method_reason: "requested".to_owned(),
        chains: 0,
        values,
        error,
        bound: false,
        target_met: None,
        refusals: 0,
        checks: Vec::new(),
        tables,
    }
}
