//! Rooms with openings: pieces of surface that are connected, along T-junctions too, and the open parts of these rooms.

use std::collections::HashMap;
use std::f64::consts::PI;

use glam::DVec3;

use super::box_tree::{Box3, BoxTree, Budget};
use super::faults::{MeshFaults, RimEdge};
use super::mesh_faults::rim_area_m2;
use super::shells::{Shell, sorted_edges};
use super::t_junctions::closed_at_t_junctions;
use super::winding::WindingTree;
use crate::scene::Scene;

/// An open piece lies around a point if it covers more than this share of all directions at the point.
const AROUND: f64 = 0.5;

/// Open pieces of surface. Pieces that share an edge, or a part of one, form one room.
pub(super) struct OpenRooms<'s> {
    scene: &'s Scene,
    vertex_of: &'s [u32],
    rooms: Vec<OpenRoom>,
    boxes: BoxTree,
    /// Built on demand, because most open pieces are single sheets.
    trees: HashMap<u32, WindingTree>,
}

struct OpenRoom {
    shells: Vec<u32>,
    triangles: Vec<u32>,
    rim: Vec<RimEdge>,
    bounds_m: Box3,
}

impl<'s> OpenRooms<'s> {
    /// Makes rooms from the shells that have a boundary and let no light through. There are none if the budget does not suffice.
    pub fn of(scene: &'s Scene, shells: &[Shell], vertex_of: &'s [u32], budget: &mut Budget) -> OpenRooms<'s> {
        let lets_through = |triangle: &u32| {
            let material = scene.surface_of(*triangle).material;
            scene.materials[material as usize].bsdf.lets_through()
        };
        let is_open = |shell: &Shell| !shell.closed && !shell.triangles.iter().any(lets_through);
        let open: Vec<u32> = (0u32..).zip(shells).filter(|(_, shell)| is_open(shell)).map(|(id, _)| id).collect();
        let triangles_of = |id: u32| shells[id as usize].triangles.iter().copied();
        let shell_of: HashMap<u32, u32> =
            open.iter().flat_map(|id| triangles_of(*id).map(move |triangle| (triangle, *id))).collect();
        let triangles: Vec<u32> = open.iter().flat_map(|id| triangles_of(*id)).collect();
        let corners = |triangle: u32| scene.triangles[triangle as usize].map(|vertex| vertex_of[vertex as usize]);
        let edges = sorted_edges(&triangles, corners);
        let rim = edges.chunk_by(|one, other| one.0 == other.0).filter(|same| same.len() % 2 == 1);
        let rim = rim.map(|same| RimEdge { ends: same[0].0, triangle: same[0].2 }).collect();
        let closed = closed_at_t_junctions(scene, rim, budget, &mut MeshFaults::default());

        // Shells joined by T-junctions are one room.
        let mut first_of: HashMap<u32, u32> = open.iter().map(|id| (*id, *id)).collect();
        let root = |first_of: &mut HashMap<u32, u32>, mut id: u32| {
            while first_of[&id] != id {
                let next = first_of[&first_of[&id]];
                first_of.insert(id, next);
                id = next;
            }
            id
        };
        for joined in &closed.joined {
            let [one, other] = joined.map(|triangle| shell_of[&triangle]);
            let (one, other) = (root(&mut first_of, one), root(&mut first_of, other));
            first_of.insert(one.max(other), one.min(other));
        }
        let mut place_of: HashMap<u32, usize> = HashMap::new();
        let mut rooms: Vec<OpenRoom> = Vec::new();
        for id in open {
            let place = *place_of.entry(root(&mut first_of, id)).or_insert_with(|| {
                let bounds_m = [DVec3::INFINITY, DVec3::NEG_INFINITY];
                rooms.push(OpenRoom { shells: Vec::new(), triangles: Vec::new(), rim: Vec::new(), bounds_m });
                rooms.len() - 1
            });
            let ([low_m, high_m], room) = (shells[id as usize].bounds_m(), &mut rooms[place]);
            room.shells.push(id);
            room.triangles.extend(triangles_of(id));
            room.bounds_m = [room.bounds_m[0].min(low_m), room.bounds_m[1].max(high_m)];
        }
        for edge in closed.open {
            let place = place_of[&root(&mut first_of, shell_of[&edge.triangle])];
            rooms[place].rim.push(edge);
        }
        if budget.is_spent() {
            rooms.clear();
        }
        let boxes = BoxTree::of(rooms.iter().map(|room| room.bounds_m));
        OpenRooms { scene, vertex_of, rooms, boxes, trees: HashMap::new() }
    }

    /// Returns the room that covers the largest share of all directions at a point, if that is more than half.
    pub fn around(&mut self, point_m: DVec3, budget: &mut Budget) -> Option<u32> {
        let mut about: Vec<u32> = Vec::new();
        self.boxes.around(point_m, 0.0, budget, |number| about.push(number));
        about.sort_unstable();
        let skies: Vec<(u32, f64)> =
            about.into_iter().map(|room| (room, self.sky_share(room, point_m, budget))).collect();
        let most = skies.into_iter().max_by(|one, other| one.1.total_cmp(&other.1))?;
        (most.1 > AROUND).then_some(most.0)
    }

    /// Returns the share of all directions at a point that a room covers: 1 inside a closed room, less by the share of its openings.
    pub fn sky_share(&mut self, room: u32, point_m: DVec3, budget: &mut Budget) -> f64 {
        let OpenRoom { triangles, bounds_m: [low_m, high_m], .. } = &self.rooms[room as usize];
        if point_m.cmplt(*low_m).any() || point_m.cmpgt(*high_m).any() {
            return 0.0;
        }
        let (scene, vertex_of) = (self.scene, self.vertex_of);
        let tree = self.trees.entry(room).or_insert_with(|| {
            budget.take(triangles.len() as u64);
            let corners = |triangle: &u32| scene.triangles[*triangle as usize].map(|vertex| vertex_of[vertex as usize]);
            WindingTree::of(triangles.iter().map(corners).collect(), |vertex| scene.vertices_m[vertex as usize])
        });
        tree.solid_angle_sr(point_m, budget).abs() / (4.0 * PI)
    }

    /// Returns the lowest and highest coordinates of a room in m.
    pub fn bounds_m(&self, room: u32) -> Box3 {
        self.rooms[room as usize].bounds_m
    }

    /// Whether a shell belongs to a room.
    pub fn has(&self, room: u32, shell: u32) -> bool {
        self.rooms[room as usize].shells.binary_search(&shell).is_ok()
    }

    /// Returns the area of a room's openings in m², each taken as flat.
    pub fn openings_m2(&self, room: u32) -> f64 {
        rim_area_m2(self.scene, &self.rooms[room as usize].rim)
    }
}
