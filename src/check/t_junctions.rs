//! T-junctions: vertices of rims in the middle of other rims' edges. The rims count as closed there.

use std::collections::{BTreeMap, HashSet};

use super::box_tree::{BoxTree, Budget};
use super::faults::{MeshFaults, RimEdge};
use super::shells::size_m;
use crate::scene::Scene;

/// A vertex nearer to an edge than this fraction of the scene's size lies on it. This is far above the rounding of coordinates and far
/// below the details of a drawing.
const ON_EDGE: f64 = 1e-7;

/// Steps for a vertex on an edge: it is sorted in, and creates a piece that is kept.
const STEPS_A_STOP: u64 = 32;

/// A rim after it was cut at its T-junctions.
pub(super) struct ClosedRim {
    /// Edges that remain open.
    pub open: Vec<RimEdge>,
    /// Pairs of triangles that share a piece of an edge.
    pub joined: Vec<[u32; 2]>,
}

/// Cuts the edges of rims where vertices of rims lie on them, and removes pieces that then coincide.
///
/// If the budget ends first, the rim stays as it is and `faults` records that.
pub(super) fn closed_at_t_junctions(
    scene: &Scene,
    rim: Vec<RimEdge>,
    budget: &mut Budget,
    faults: &mut MeshFaults,
) -> ClosedRim {
    let place_m = |vertex: u32| scene.vertices_m[vertex as usize];
    let mut vertices: Vec<u32> = rim.iter().flat_map(|edge| edge.ends).collect();
    vertices.sort_unstable();
    vertices.dedup();
    let rank_of = |vertex: u32| vertices.binary_search(&vertex).unwrap_or_default();
    let tolerance_m = ON_EDGE * size_m(scene);
    let tree = BoxTree::of_points(vertices.iter().map(|vertex| place_m(*vertex)));

    // A vertex at the end of an edge is identified with that end, so that pieces have the same ends.
    let mut stands_for: Vec<usize> = Vec::with_capacity(vertices.len());
    for (rank, vertex) in vertices.iter().enumerate() {
        let mut first = rank;
        tree.around(place_m(*vertex), tolerance_m, budget, |other| {
            let is_near = || place_m(*vertex).distance(place_m(vertices[other as usize])) <= tolerance_m;
            if (other as usize) < first && is_near() {
                first = other as usize;
            }
        });
        stands_for.push(if first < rank { stands_for[first] } else { rank });
    }
    let mut junctions: Vec<(u32, u32)> = Vec::new();
    let mut reported: HashSet<usize> = HashSet::new();
    let mut pieces: BTreeMap<[u32; 2], Vec<u32>> = BTreeMap::new();
    for RimEdge { ends, triangle } in &rim {
        let [from, to] = ends.map(|end| stands_for[rank_of(end)]);
        let [a, b] = [from, to].map(|rank| place_m(vertices[rank]));
        let mut stops: Vec<(f64, usize)> = Vec::new();
        tree.along([a, b], tolerance_m, budget, |rank| {
            let rank = rank as usize;
            if stands_for[rank] != rank || [from, to].contains(&rank) {
                return;
            }
            let place_m = place_m(vertices[rank]);
            let share = (place_m - a).dot(b - a) / a.distance_squared(b);
            if (0.0..=1.0).contains(&share) && place_m.distance(a.lerp(b, share)) <= tolerance_m {
                stops.push((share, rank));
            }
        });
        if !budget.take(STEPS_A_STOP * stops.len() as u64) {
            faults.t_junctions_searched = false;
            faults.steps += budget.taken();
            return ClosedRim { open: rim, joined: Vec::new() };
        }
        stops.sort_by(|one, other| one.0.total_cmp(&other.0).then(one.1.cmp(&other.1)));
        let new = stops.iter().filter(|(_, rank)| reported.insert(*rank));
        junctions.extend(new.map(|(_, rank)| (vertices[*rank], *triangle)));
        let mut before = from;
        for next in stops.into_iter().map(|(_, rank)| rank).chain([to]) {
            if before != next {
                let [low, high] = [before.min(next), before.max(next)].map(|rank| vertices[rank]);
                pieces.entry([low, high]).or_default().push(*triangle);
            }
            before = next;
        }
    }
    faults.steps += budget.taken();
    for (vertex, triangle) in junctions {
        faults.t_junctions.add(place_m(vertex), scene.surface_of(triangle).name.as_str());
    }
    let mut closed = ClosedRim { open: Vec::new(), joined: Vec::new() };
    for (ends, triangles) in pieces {
        closed.joined.extend(triangles.windows(2).map(|pair| [pair[0], pair[1]]));
        if triangles.len() % 2 == 1 {
            closed.open.push(RimEdge { ends, triangle: triangles[0] });
        }
    }
    closed
}
