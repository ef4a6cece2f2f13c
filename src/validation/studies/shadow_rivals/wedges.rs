//! Soft shadows of a ball from the silhouettes of solids.
//!
//! Soft shadow volumes (Assarsson and Akenine-Möller 2003, "A geometry-based soft shadow volume algorithm using graphics
//! hardware"): each edge of the silhouette seen from the lamp's centre makes a wedge, within which it hides a part of the lamp. For
//! a point on the ground the edges are projected on the lamp's disk. The shadow volumes of the centre are corrected by the area
//! between each chord and its arc. The method has two errors of its own. Silhouettes are those of the centre, and where two solids
//! hide the same part both are counted.
//!
//! Outward shadows (Parker, Shirley and Smits 1998, "Single sample soft shadows"): points that the centre does not light are black.
//! Outside of them the light increases over the width of the ball. The 2001 paper on light meshes claims to improve on this method.

use std::collections::HashMap;
use std::f64::consts::PI;

use glam::DVec3;

use crate::scene::Side;
use crate::validation::studies::study_scene::StudyScene;

/// Number of ground cells along an edge. Each cell stores the silhouette edges whose shadows may fall there.
const CELLS: usize = 64;
/// Edges are clipped at this share of the distance from the ground point to the lamp.
const CLIPPED_AT: f64 = 1e-6;
/// Outward shadows extend over the whole ball: twice its radius on the lamp's disk.
const REACH: f64 = 2.0;

/// A lamp's silhouette edges over level ground.
pub struct Wedges<'a> {
    study: &'a StudyScene,
    lamp_m: DVec3,
    radius_m: f64,
    size_m: [f64; 2],
    edges: Vec<[DVec3; 2]>,
    of_cell: Vec<Vec<u32>>,
}

/// Visible share of a lamp from a point by each of the two methods.
pub struct SeenShares {
    /// Share by wedges.
    pub wedges: f64,
    /// Share by outward shadows.
    pub outward: f64,
}

impl<'a> Wedges<'a> {
    /// Finds the silhouettes seen from a ball's centre over the ground from (0, 0, 0) to a far corner. The ball itself is not part
    /// of the study's geometry, and nothing else reaches up to it.
    pub fn of(study: &'a StudyScene, lamp_m: DVec3, radius_m: f64, size_m: [f64; 2]) -> Wedges<'a> {
        let edges = silhouette(study, lamp_m);
        let mut of_cell = vec![Vec::new(); CELLS * CELLS];
        for (number, edge) in edges.iter().enumerate() {
            let [low, high] = footprint(edge, lamp_m, REACH * radius_m).map(|corner_m| {
                [corner_m.x / size_m[0], corner_m.y / size_m[1]]
                    .map(|share| (share * CELLS as f64).floor().clamp(0.0, CELLS as f64 - 1.0) as usize)
            });
            for row in low[1]..=high[1] {
                (low[0]..=high[0]).for_each(|column| of_cell[row * CELLS + column].push(number as u32));
            }
        }
        Wedges { study, lamp_m, radius_m, size_m, edges, of_cell }
    }

    /// Number of edges of the silhouettes.
    pub fn edge_count(&self) -> usize {
        self.edges.len()
    }

    /// Visible share of the lamp from a point on the ground.
    pub fn seen_from(&self, place_m: DVec3) -> SeenShares {
        let way_m = self.lamp_m - place_m;
        let distance_m = way_m.length();
        let axis = way_m / distance_m;
        let (u, v) = axis.any_orthonormal_pair();
        let hidden = self.solids_before_center(place_m, axis, distance_m);
        let (mut covered, mut nearest_m) = (f64::from(hidden), f64::INFINITY);
        for edge in self.edges_near(place_m) {
            // Coordinates in m of the projection on the lamp's disk.
            let mut ends = edge.map(|end_m| end_m - place_m);
            let depth = |end_m: &DVec3| end_m.dot(axis) / distance_m;
            ends.sort_by(|a, b| depth(a).total_cmp(&depth(b)));
            let is_turned = ends[0] != edge[0] - place_m;
            if depth(&ends[1]) <= CLIPPED_AT {
                continue;
            }
            if depth(&ends[0]) < CLIPPED_AT {
                let share = (CLIPPED_AT - depth(&ends[0])) / (depth(&ends[1]) - depth(&ends[0]));
                ends[0] = ends[0].lerp(ends[1], share);
            }
            let on_disk = |end_m: DVec3| [end_m.dot(u), end_m.dot(v)].map(|across_m| across_m / depth(&end_m));
            let [a, b] = if is_turned { [ends[1], ends[0]] } else { ends }.map(on_disk);
            covered += chord_less_arc_m2(a, b, self.radius_m) / (PI * self.radius_m * self.radius_m);
            nearest_m = nearest_m.min(distance_to_segment_m(a, b));
        }
        let share = (nearest_m / (REACH * self.radius_m)).min(1.0);
        let outward = if hidden > 0 { 0.0 } else { share * share * (3.0 - 2.0 * share) };
        SeenShares { wedges: (1.0 - covered).clamp(0.0, 1.0), outward }
    }

    /// Number of solids between a point and the lamp's centre: one for each back face that the line crosses. A stencil buffer
    /// counts shadow volumes this way.
    fn solids_before_center(&self, place_m: DVec3, axis: DVec3, distance_m: f64) -> u32 {
        let tracer = &self.study.world.tracer;
        let crossed = tracer.crossings(&tracer.side_origin(place_m, DVec3::Z), axis);
        let before = crossed.iter().filter(|one| one.side == Side::Back && one.distance_m < distance_m);
        before.count() as u32
    }

    fn edges_near(&self, place_m: DVec3) -> impl Iterator<Item = [DVec3; 2]> {
        let [column, row] = [place_m.x / self.size_m[0], place_m.y / self.size_m[1]]
            .map(|share| ((share * CELLS as f64) as usize).min(CELLS - 1));
        self.of_cell[row * CELLS + column].iter().map(|number| self.edges[*number as usize])
    }
}

/// Edges between a face lit by the lamp's centre and one that is not, counter-clockwise around the lit face.
fn silhouette(study: &StudyScene, lamp_m: DVec3) -> Vec<[DVec3; 2]> {
    let key = |corner_m: DVec3| corner_m.to_array().map(f64::to_bits);
    let mut edges: HashMap<[[u64; 3]; 2], [DVec3; 2]> = HashMap::new();
    for triangle in 0..study.scene.triangles.len() as u32 {
        let corners_m = study.scene.corners_m(triangle);
        let is_ground = corners_m.iter().all(|corner_m| corner_m.z <= 0.0);
        if is_ground || study.scene.triangle_normal(triangle).dot(lamp_m - corners_m[0]) <= 0.0 {
            continue;
        }
        for k in 0..3 {
            let [from_m, to_m] = [corners_m[k], corners_m[(k + 1) % 3]];
            // An edge shared by two lit faces occurs in both directions and cancels.
            if edges.remove(&[key(to_m), key(from_m)]).is_none() {
                edges.insert([key(from_m), key(to_m)], [from_m, to_m]);
            }
        }
    }
    let mut edges: Vec<_> = edges.into_iter().collect();
    edges.sort_by_key(|(key, _)| *key);
    edges.into_iter().map(|(_, edge)| edge).collect()
}

/// Low and high corner of the ground area where an edge may hide something within `reach_m` of the lamp's centre.
fn footprint(edge: &[DVec3; 2], lamp_m: DVec3, reach_m: f64) -> [DVec3; 2] {
    let mut bounds_m = [DVec3::INFINITY, DVec3::NEG_INFINITY];
    for end_m in edge {
        for corner in 0..8 {
            let off = [0, 1, 2].map(|axis| if corner >> axis & 1 == 1 { reach_m } else { -reach_m });
            let from_m = lamp_m + DVec3::from_array(off);
            let shadow_m = from_m + (*end_m - from_m) * (from_m.z / (from_m.z - end_m.z));
            bounds_m = [bounds_m[0].min(shadow_m), bounds_m[1].max(shadow_m)];
        }
    }
    bounds_m
}

/// For the part of a segment inside a disk about the origin: its triangle with the centre minus its sector, with the sign of the
/// direction of rotation.
fn chord_less_arc_m2(a: [f64; 2], b: [f64; 2], radius_m: f64) -> f64 {
    let along = [b[0] - a[0], b[1] - a[1]];
    let square = along[0] * along[0] + along[1] * along[1];
    let half = a[0] * along[0] + a[1] * along[1];
    let rest = half * half - square * (a[0] * a[0] + a[1] * a[1] - radius_m * radius_m);
    if rest <= 0.0 || square <= 0.0 {
        return 0.0;
    }
    let [from, to] = [-half - rest.sqrt(), -half + rest.sqrt()].map(|way| (way / square).clamp(0.0, 1.0));
    if from >= to {
        return 0.0;
    }
    let [p, q] = [from, to].map(|way| [a[0] + way * along[0], a[1] + way * along[1]]);
    let cross = p[0] * q[1] - p[1] * q[0];
    let angle = cross.atan2(p[0] * q[0] + p[1] * q[1]);
    0.5 * (cross - radius_m * radius_m * angle)
}

/// Distance from the origin to a segment.
fn distance_to_segment_m(a: [f64; 2], b: [f64; 2]) -> f64 {
    let along = [b[0] - a[0], b[1] - a[1]];
    let square = along[0] * along[0] + along[1] * along[1];
    let way = if square > 0.0 { (-(a[0] * along[0] + a[1] * along[1]) / square).clamp(0.0, 1.0) } else { 0.0 };
    (a[0] + way * along[0]).hypot(a[1] + way * along[1])
}
