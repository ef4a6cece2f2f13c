//! Indirect illuminance on the faces: exact at the Chebyshev points for every mesh, interpolated by polynomials between them.

use std::f64::consts::PI;

use rayon::prelude::*;

use super::faces::RoomFace;
use super::mesh::{RoomMesh, extrapolated};

/// Intervals between the points on an axis without breaks.
const INTERVALS: usize = 16;
/// Intervals between the points of each panel on an axis with breaks.
const INTERVALS_BETWEEN_BREAKS: usize = 8;
/// Share of the interpolation error of half the points that is stated as the error of all points. For a function with weak
/// singularities at its ends, the remaining error falls by 1/16 with every doubling. For a smooth function it falls much faster.
const INTERPOLATION_SHARE: f64 = 0.125;

/// Number of interpolation points on each side of a point, along each axis, whose largest error is stated.
const NEIGHBOURS: usize = 2;

/// Interpolation points along an axis: panels between the breaks, each with Chebyshev points from end to end.
#[derive(Clone, Debug)]
pub(super) struct AxisPoints {
    panels: Vec<Vec<f64>>,
}

impl AxisPoints {
    pub fn new(breaks: &[f64]) -> AxisPoints {
        let intervals = if breaks.len() > 2 { INTERVALS_BETWEEN_BREAKS } else { INTERVALS };
        let panel = |ends: &[f64]| -> Vec<f64> {
            let node = |k: usize| {
                let share = (0.5 * PI * k as f64 / intervals as f64).sin().powi(2);
                if k == intervals { ends[1] } else { ends[0] + (ends[1] - ends[0]) * share }
            };
            (0..=intervals).map(node).collect()
        };
        AxisPoints { panels: breaks.windows(2).map(panel).collect() }
    }

    /// All points. Points at breaks appear once for each side.
    pub fn points(&self) -> Vec<f64> {
        self.panels.concat()
    }

    /// Number of the first point of the panel that contains `place`, and the weights of the panel's points. With `step` 2 every
    /// other point has weight 0.
    fn weights(&self, place: f64, step: usize) -> (usize, Vec<f64>) {
        let panel = self.panels.iter().position(|p| place <= p[p.len() - 1]).unwrap_or(self.panels.len() - 1);
        let points = &self.panels[panel];
        let last = points.len() - 1;
        let mut weights = vec![0.0; points.len()];
        let hit = (0..=last).step_by(step).find(|k| points[*k] == place);
        if let Some(hit) = hit {
            weights[hit] = 1.0;
        } else {
            // The barycentric formula of Chebyshev points of the second kind.
            for k in (0..=last).step_by(step) {
                let sign = if (k / step).is_multiple_of(2) { 1.0 } else { -1.0 };
                let half = if k == 0 || k == last { 0.5 } else { 1.0 };
                weights[k] = sign * half / (place - points[k]);
            }
            let sum: f64 = weights.iter().sum();
            weights.iter_mut().for_each(|weight| *weight /= sum);
        }
        (panel * points.len(), weights)
    }

    /// Length of the shortest panel, m.
    pub fn shortest_m(&self) -> f64 {
        self.panels.iter().map(|p| p[p.len() - 1] - p[0]).fold(f64::INFINITY, f64::min)
    }
}

/// The interpolation points of all faces.
pub(super) struct FacePoints {
    pub lines: [AxisPoints; 3],
}

impl FacePoints {
    /// Indirect illuminance in lx at all points of every face, from one mesh.
    pub fn indirect_lx(&self, mesh: &RoomMesh, size_m: [f64; 3]) -> [Vec<f64>; 6] {
        RoomFace::ALL.map(|face| {
            let [u, v] = face.other_axes().map(|axis| self.lines[axis].points());
            let at = |u: f64, v: f64| mesh.indirect_at_lx(face.position(size_m, [u, v]), face.normal());
            let places: Vec<(f64, f64)> = u.iter().flat_map(|u| v.iter().map(move |v| (*u, *v))).collect();
            places.into_par_iter().map(|(u, v)| at(u, v)).collect()
        })
    }
}

/// Indirect illuminance everywhere on the faces, with its estimated error.
pub(super) struct IndirectField<'a> {
    nodes: &'a FacePoints,
    indirect_lx: [Vec<f64>; 6],
    error_lx: [Vec<f64>; 6],
}

impl<'a> IndirectField<'a> {
    /// Builds the field from the values at the points on three meshes, coarse to fine.
    pub fn new(nodes: &'a FacePoints, meshes: [&[Vec<f64>; 6]; 3]) -> IndirectField<'a> {
        let mut field = IndirectField { nodes, indirect_lx: Default::default(), error_lx: Default::default() };
        for face in 0..6 {
            let limits = (0..meshes[0][face].len()).map(|point| extrapolated(meshes.map(|mesh| mesh[face][point])));
            (field.indirect_lx[face], field.error_lx[face]) = limits.unzip();
        }
        field
    }

    /// Indirect illuminance and its estimated error at a point of a face, in lx.
    pub fn at_lx(&self, face: RoomFace, place: [f64; 2]) -> (f64, f64) {
        let value_lx = self.interpolated_lx(face, place, 1);
        let coarse_lx = self.interpolated_lx(face, place, 2);
        (value_lx, self.largest_near_lx(face, place) + INTERPOLATION_SHARE * (value_lx - coarse_lx).abs())
    }

    fn interpolated_lx(&self, face: RoomFace, place: [f64; 2], step: usize) -> f64 {
        let [u, v] = face.other_axes().map(|axis| &self.nodes.lines[axis]);
        let ((first_u, weights_u), (first_v, weights_v)) = (u.weights(place[0], step), v.weights(place[1], step));
        let across = v.panels.len() * v.panels[0].len();
        let values = &self.indirect_lx[face.index()];
        let row = |i: usize| {
            let start = (first_u + i) * across + first_v;
            values[start..start + weights_v.len()].iter().zip(&weights_v).map(|(e, w)| e * w).sum::<f64>()
        };
        weights_u.iter().enumerate().filter(|(_, w)| **w != 0.0).map(|(i, w)| w * row(i)).sum()
    }

    /// The largest error at the interpolation points around a point. An error that changes its sign looks too small between them.
    fn largest_near_lx(&self, face: RoomFace, place: [f64; 2]) -> f64 {
        let [u, v] = face.other_axes().map(|axis| self.nodes.lines[axis].points());
        let around = |points: &[f64], x: f64| {
            let after = points.partition_point(|p| *p < x);
            after.saturating_sub(NEIGHBOURS)..(after + NEIGHBOURS).min(points.len())
        };
        let (rows, columns) = (around(&u, place[0]), around(&v, place[1]));
        let errors = &self.error_lx[face.index()];
        let row = |i: usize| errors[i * v.len() + columns.start..i * v.len() + columns.end].iter().copied();
        rows.flat_map(row).fold(0.0, f64::max)
    }
}
