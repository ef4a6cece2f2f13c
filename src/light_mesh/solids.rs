//! Finds points inside solids (MU4), and walls too thin for this test to separate their two sides.

use std::collections::HashMap;
use std::ops::Range;

use glam::DVec3;
use rayon::prelude::*;

use super::lattice::{Index, Lattice};
use super::options::Stop;
use crate::check::{Shell, all_luminaires_are_shut_in, closed_shells_of_geometries, shells_of_scene};
use crate::geometry::{Crossed, Tracer};
use crate::scene::{Scene, Side};
use crate::transport::World;

/// Marks a triangle that belongs to no closed solid.
const OPEN: u32 = u32::MAX;
/// Direction of the rays whose crossings are counted. It is parallel to no edge or diagonal that people usually draw.
const PARITY_DIRECTION: DVec3 = DVec3::new(0.356_822_089_773_09, 0.540_772_640_217_21, 0.761_749_023_160_17);
/// Largest number of positions on a triangle at which the wall behind it is measured.
const MOST_SOUNDINGS: f64 = 64.0;
/// Largest number of crossings for which shells are found by a linear search.
const MOST_LOOKED_THROUGH: usize = 64;

/// The closed solids and rooms of a scene.
pub struct Solids {
    /// Closed shell of every triangle, or [`OPEN`].
    shell_of: Vec<u32>,
    shells: Vec<Closed>,
    /// Whether nothing outside the rooms is lit or computed.
    outside_counts_as_solid: bool,
    balls: Vec<(DVec3, f64)>,
    open_triangles: usize,
}

#[derive(Clone, Copy)]
struct Closed {
    /// Whether it is a solid seen from outside. Otherwise it is a room seen from inside.
    outward: bool,
    volume_m3: f64,
}

impl Solids {
    /// Finds the closed shells of a scene. A shell counts under two conditions. Every edge is passed equally often in both directions, so
    /// that parity is meaningful. All its triangles are one-sided.
    pub fn of(scene: &Scene) -> Solids {
        let mut shell_of = vec![OPEN; scene.triangles.len()];
        let mut shells = Vec::new();
        let mut add = |shell: &Shell| {
            let is_taken = |triangle: &u32| shell_of[*triangle as usize] != OPEN;
            let one_sided = shell.triangles.iter().all(|triangle| !scene.surface_of(*triangle).two_sided);
            if !shell.closed || !one_sided || shell.volume_m3 == 0.0 || shell.triangles.iter().any(is_taken) {
                return;
            }
            for triangle in &shell.triangles {
                shell_of[*triangle as usize] = shells.len() as u32;
            }
            shells.push(Closed { outward: shell.volume_m3 > 0.0, volume_m3: shell.volume_m3.abs() });
        };
        closed_shells_of_geometries(scene).iter().for_each(&mut add);
        shells_of_scene(scene).iter().for_each(&mut add);
        let outside_counts_as_solid = shells.iter().any(|shell| !shell.outward) && all_luminaires_are_shut_in(scene);
        let balls = scene.luminaires.iter().filter_map(|luminaire| luminaire.emission.black_ball_m());
        let open_triangles = shell_of.iter().filter(|shell| **shell == OPEN).count();
        Solids { balls: balls.collect(), shell_of, shells, outside_counts_as_solid, open_triangles }
    }

    /// Returns the number of triangles that belong to no closed solid. Local visibility is tested near them.
    pub fn open_triangles(&self) -> usize {
        self.open_triangles
    }

    /// Whether a point lies in solid matter, and the number of rays used.
    ///
    /// A ray crosses a closed shell alternately from outside and from inside. Of two crossings of the same kind in sequence, as at an edge
    /// that two triangles share, one counts. A shell with an odd number of crossings encloses the point. The smallest enclosing shell
    /// decides between solid and room.
    pub fn holds(&self, tracer: &Tracer, point_m: DVec3) -> (bool, u64) {
        if self.balls.iter().any(|(center_m, radius_m)| center_m.distance(point_m) < *radius_m) {
            return (true, 0);
        }
        if self.shells.is_empty() {
            return (false, 0);
        }
        let crossed = tracer.crossings(&tracer.free_origin(point_m), PARITY_DIRECTION);
        let smallest = self.enclosing(&crossed).min_by(|one, other| one.volume_m3.total_cmp(&other.volume_m3));
        (smallest.map_or(self.outside_counts_as_solid, |shell| shell.outward), 1)
    }

    fn enclosing(&self, crossed: &[Crossed]) -> impl Iterator<Item = Closed> {
        let mut met: Vec<(u32, Side, bool)> = Vec::new();
        // With few crossings a linear search finds the shell.
        let mut place_of: HashMap<u32, usize> = HashMap::new();
        let is_crowded = crossed.len() > MOST_LOOKED_THROUGH;
        for one in crossed {
            let shell = self.shell_of[one.triangle as usize];
            if shell == OPEN {
                continue;
            }
            let place = match is_crowded {
                true => place_of.get(&shell).copied(),
                false => met.iter().position(|(known, ..)| *known == shell),
            };
            match place.map(|place| &mut met[place]) {
                Some((_, last, odd)) if *last != one.side => (*last, *odd) = (one.side, !*odd),
                Some(_) => {}
                None => {
                    if is_crowded {
                        place_of.insert(shell, met.len());
                    }
                    met.push((shell, one.side, true));
                }
            }
        }
        met.into_iter().filter(|(.., odd)| *odd).map(|(shell, ..)| self.shells[shell as usize])
    }

    /// Whether the wall behind a triangle is thinner than a length at some position. It is measured along the normal at positions spread
    /// over the triangle: one per square of that length, 64 at most. A triangle of no closed solid counts as thin.
    fn is_thin(&self, world: &World, scene: &Scene, triangle: u32, length_m: f64) -> bool {
        let shell = self.shell_of[triangle as usize];
        if shell == OPEN {
            return true;
        }
        let no_end = self.outside_counts_as_solid && !self.shells[shell as usize].outward;
        let soundings = (scene.triangle_area_m2(triangle) / (length_m * length_m)).ceil().clamp(1.0, MOST_SOUNDINGS);
        let inward = -scene.triangle_normal(triangle);
        let is_thin_at = |number: u32| {
            let barycentric = spread_over_triangle(number);
            let origin = world.tracer.surface_origin(triangle, barycentric, Side::Back);
            match world.tracer.crossings(&origin, inward).first() {
                Some(first) => first.side == Side::Front || first.distance_m < length_m,
                None => !no_end,
            }
        };
        (0..soundings as u32).any(is_thin_at)
    }
}

/// Returns one position of a sequence that covers a triangle evenly (Roberts' R2 sequence, folded). The first is the centre.
fn spread_over_triangle(number: u32) -> [f64; 2] {
    const PLASTIC: [f64; 2] = [0.754_877_666_246_692_8, 0.569_840_290_998_053_3];
    let [u, v] = PLASTIC.map(|step| (1.0 / 3.0 + step * f64::from(number)).fract());
    if u + v > 1.0 { [1.0 - u, 1.0 - v] } else { [u, v] }
}

/// Cells along the edge of a block. Each block has one list of walls.
const BLOCK: i32 = 4;

/// A triangle of a thin wall: its corners and its bounding box.
struct ThinWall {
    corners_m: [DVec3; 3],
    box_m: [DVec3; 2],
}

/// Thin walls near each part of a mesh: the indices of the walls near each block of cells.
pub struct Walls {
    blocks: HashMap<u64, Vec<u32>>,
    walls: Vec<ThinWall>,
    radius_m: f64,
}

impl Walls {
    /// Lists open surfaces and walls thinner than the radius, within the radius of each block of cells. It adds no more once the run is
    /// abandoned.
    pub fn of(solids: &Solids, world: &World, scene: &Scene, lattice: &Lattice, radius_m: f64, give_up: Stop) -> Walls {
        let thin: Vec<u32> = (0..scene.triangles.len() as u32)
            .into_par_iter()
            .filter(|triangle| !give_up() && solids.is_thin(world, scene, *triangle, radius_m))
            .collect();
        let mut blocks: HashMap<u64, Vec<u32>> = HashMap::new();
        let edge_m = f64::from(BLOCK) * lattice.step_m;
        let half_diagonal_m = 0.5 * 3f64.sqrt() * edge_m;
        let mut walls: Vec<ThinWall> = Vec::with_capacity(thin.len());
        for triangle in &thin {
            let corners_m = scene.corners_m(*triangle);
            let normal = scene.triangle_normal(*triangle);
            let number = walls.len() as u32;
            let box_m =
                [corners_m[0].min(corners_m[1]).min(corners_m[2]), corners_m[0].max(corners_m[1]).max(corners_m[2])];
            walls.push(ThinWall { corners_m, box_m });
            let (low_m, high_m) = (box_m[0] - radius_m, box_m[1] + radius_m);
            let range = |axis: usize| -> Range<i32> {
                let count = lattice.counts[axis] as i32 / BLOCK;
                let at = |place_m: DVec3| ((place_m - lattice.origin_m)[axis] / edge_m).floor() as i32;
                at(low_m).max(0)..at(high_m).min(count) + 1
            };
            for k in range(2) {
                for j in range(1) {
                    for i in range(0) {
                        let middle = DVec3::new(f64::from(i), f64::from(j), f64::from(k)) + 0.5;
                        let middle_m = lattice.origin_m + edge_m * middle;
                        if normal.dot(middle_m - corners_m[0]).abs() <= radius_m + half_diagonal_m {
                            blocks.entry(lattice.key([i, j, k])).or_default().push(number);
                        }
                    }
                }
            }
        }
        Walls { blocks, walls, radius_m }
    }

    /// Whether a thin wall may hide a point of the half ball over a receiver point from it. A wall with no corner in front of the
    /// receiver's plane cannot.
    #[inline]
    pub fn may_hide(&self, lattice: &Lattice, cell: Index, place_m: DVec3, normal: DVec3, least_height_m: f64) -> bool {
        let Some(near) = self.blocks.get(&lattice.key(cell.map(|number| number.div_euclid(BLOCK)))) else {
            return false;
        };
        near.iter().any(|number| {
            let ThinWall { corners_m, box_m: [low_m, high_m] } = &self.walls[*number as usize];
            place_m.clamp(*low_m, *high_m).distance_squared(place_m) < self.radius_m * self.radius_m
                && corners_m.iter().any(|corner_m| normal.dot(*corner_m - place_m) > least_height_m)
        })
    }
}
