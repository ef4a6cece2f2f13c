//! Where the suns of a year shine on the surfaces: small cells, each sampled once by shadow rays from a random point of its own.
//!
//! A walk that meets a surface takes the suns of the cell there. Each replica has its own random points, so effects that cells
//! cannot resolve differ between replicas and are part of the error. One effect is not: the light's path to the receiver changes
//! within a cell. The small size of cells keeps it small.
//!
//! A cell traces shadow rays to the nodes of the suns' paths and to a sample of the hours' own suns. The difference of a sampled
//! sun from the value interpolated from nodes, divided by its sampling probability, corrects the interpolation without bias
//! (docs/methods.md (40)). Sampling is densest where only some of the surrounding nodes are visible.

use std::sync::OnceLock;
use std::sync::atomic::{AtomicU64, Ordering};

use glam::DVec3;

use super::sun_nodes::SunNodes;
use crate::base::half_samples::PARTED;
use crate::estimators::receiver::Receiver;
use crate::estimators::sunlight::Suns;
use crate::sampling::random::{Purpose, Stream};
use crate::sampling::warp::uniform_triangle;
use crate::scene::elements::{part_at, part_corners};
use crate::scene::{Openings, Scene, Side};
use crate::transport::{TriangleSide, World};

/// Approximate number of cells of a replica at an error of 3 %, and its maximum. Cells are placed where walks meet surfaces.
const CELLS: f64 = 8192.0;
const MOST_CELLS: f64 = 16_384.0;
const AT_ERROR: f64 = 0.03;
/// Minimum edge of a cell in m.
const LEAST_M: f64 = 0.02;
/// Number of steps to store a share of the sun's light.
const SHARE_STEPS: f64 = 65_535.0;

/// One of this many suns is sampled at its own position: where only some of the surrounding nodes are visible, and elsewhere.
const IN_PART: usize = 2;
const ALIKE: usize = 32;

/// A node's number and its illuminance for 1 lx perpendicular to its rays, in steps of 1/65535.
type NodeShare = (u16, u16);

/// A sun that was sampled at its own position.
pub(super) struct OwnSun {
    /// Number of the sun.
    pub sun: u16,
    /// One over the probability that it is sampled.
    pub times: u16,
    /// Illuminance for 1 lx perpendicular to its rays. `off` is its difference from the value interpolated from nodes, over the
    /// sampling probability. Both in steps.
    share: u16,
    off: i32,
}

impl OwnSun {
    /// Illuminance in lx for 1 lx perpendicular to the sun's rays.
    pub fn lx(&self) -> f64 {
        f64::from(self.share) * (1.0 / SHARE_STEPS)
    }

    /// Difference in lx from the value interpolated from nodes, over the sampling probability.
    #[inline]
    pub fn off_lx(&self) -> f64 {
        f64::from(self.off) * (1.0 / SHARE_STEPS)
    }
}

/// The suns that a cell sees.
pub(super) struct CellView {
    nodes: Box<[NodeShare]>,
    /// The sampled suns, in the order of the suns' fields.
    pub own: Box<[OwnSun]>,
}

impl CellView {
    /// The nodes that shine on the cell: their numbers, and the illuminance in lx that each gives for 1 lx perpendicular to its
    /// rays.
    #[inline]
    pub fn nodes(&self) -> impl Iterator<Item = (usize, f64)> {
        self.nodes.iter().map(|(node, share)| (usize::from(*node), f64::from(*share) * (1.0 / SHARE_STEPS)))
    }

    /// The illuminance in lx that a node gives; 0 if the cell does not see it.
    pub fn of_node_lx(&self, node: usize) -> f64 {
        let place = self.nodes.binary_search_by_key(&node, |(node, _)| usize::from(*node));
        place.map_or(0.0, |place| f64::from(self.nodes[place].1) * (1.0 / SHARE_STEPS))
    }
}

/// The suns of all cells. Each cell is sampled on first use.
pub(super) struct SunCells<'a> {
    scene: &'a Scene,
    world: &'a World,
    /// The hours' own suns.
    suns: &'a Suns,
    nodes: &'a SunNodes,
    openings: Option<&'a Openings>,
    seed: u64,
    /// Parts along the edges of each side of each triangle.
    parts: Vec<u32>,
    /// Number of the first cell of each side.
    firsts: Vec<u32>,
    cells: [Vec<OnceLock<CellView>>; PARTED],
    rays: AtomicU64,
}

/// Index of a triangle's side in lists of sides.
pub(super) fn side_index((triangle, side): TriangleSide) -> usize {
    2 * triangle as usize + side as usize
}

impl<'a> SunCells<'a> {
    /// Creates cells in proportion to how often walks met each side.
    pub fn new(
        (scene, world): (&'a Scene, &'a World),
        (suns, nodes): (&'a Suns, &'a SunNodes),
        openings: Option<&'a Openings>,
        meetings: &[u32],
        (target_error, seed): (f64, u64),
    ) -> SunCells<'a> {
        let cells = (CELLS * AT_ERROR / target_error).min(MOST_CELLS);
        let can_shine = |index: usize| {
            let side = if index.is_multiple_of(2) { Side::Front } else { Side::Back };
            let normal = world.normal((index / 2) as u32, side);
            suns.towards.iter().any(|towards| normal.dot(*towards) > -suns.disk[0])
        };
        let lit: Vec<f64> = (meetings.iter().enumerate())
            .map(|(index, count)| if *count > 0 && can_shine(index) { f64::from(*count) } else { 0.0 })
            .collect();
        let all: f64 = lit.iter().sum::<f64>().max(1.0);
        let parts: Vec<u32> = lit
            .iter()
            .enumerate()
            .map(|(index, count)| {
                let [a, b, c] = scene.corners_m((index / 2) as u32);
                let longest_m = a.distance(b).max(b.distance(c)).max(c.distance(a));
                let wanted = (cells * count / all).sqrt().ceil();
                wanted.min((longest_m / LEAST_M).ceil()).clamp(1.0, 1024.0) as u32
            })
            .collect();
        let mut firsts = Vec::with_capacity(parts.len() + 1);
        firsts.push(0);
        for count in &parts {
            firsts.push(firsts[firsts.len() - 1] + count * count);
        }
        let count = firsts[firsts.len() - 1] as usize;
        let cells = std::array::from_fn(|_| std::iter::repeat_with(OnceLock::new).take(count).collect());
        SunCells { scene, world, suns, nodes, openings, seed, parts, firsts, cells, rays: AtomicU64::new(0) }
    }

    /// The suns that a surface point sees in a replica.
    #[inline]
    pub fn suns_on(&self, replica: usize, spot: TriangleSide, barycentric: [f64; 2]) -> &CellView {
        let side = side_index(spot);
        let cell = self.firsts[side] + part_at(self.parts[side], barycentric[0], barycentric[1]);
        self.cells[replica][cell as usize].get_or_init(|| self.view_of(replica, spot, cell))
    }

    /// Number of shadow rays traced.
    pub fn rays(&self) -> u64 {
        self.rays.load(Ordering::Relaxed)
    }

    /// Traces shadow rays from a point of a cell to all nodes and to some suns.
    #[cold]
    fn view_of(&self, replica: usize, (triangle, side): TriangleSide, cell: u32) -> CellView {
        let index = side_index((triangle, side));
        let mut stream = Stream::new(self.seed, Purpose::SunPlaces, 0, replica as u32);
        stream.seek(u64::from(cell));
        let [a, b, c] = part_corners(self.parts[index], cell - self.firsts[index]);
        let [second, third] = uniform_triangle(stream.pair());
        let barycentric = [0, 1].map(|k| a[k] + second * (b[k] - a[k]) + third * (c[k] - a[k]));
        let origin = self.world.tracer.surface_origin(triangle, barycentric, side);
        let normal: DVec3 = self.world.normal_on(triangle, barycentric, side);
        let place = Receiver { point_m: self.world.tracer.position_m(&origin), normal, origin: &origin };
        let mut nodes = Vec::new();
        let around = (self.scene, self.world);
        let mut rays = self.nodes.suns.find_all(around, &place, self.openings, &mut stream, |node, lx| {
            let steps = (SHARE_STEPS * lx.min(1.0)).round() as u16;
            if steps > 0 {
                nodes.push((node as u16, steps));
            }
        });
        let mut seen = CellView { nodes: nodes.into(), own: Box::default() };
        if !self.nodes.fields.is_empty() {
            rays += self.find_own(&mut seen, &place, &mut stream);
        }
        self.rays.fetch_add(rays, Ordering::Relaxed);
        seen
    }

    /// Traces shadow rays to some of the hours' own suns; returns the number of rays.
    fn find_own(&self, seen: &mut CellView, place: &Receiver, stream: &mut Stream) -> u64 {
        let mut node_lx = vec![0.0; self.nodes.suns.towards.len()];
        seen.nodes().for_each(|(node, lx)| node_lx[node] = lx);
        let [first_in_part, first_alike] = stream.pair();
        // Takes every `step`-th sun, starting at a random one. Each sun has the same probability.
        let mut in_part = Every { step: IN_PART, next: (IN_PART as f64 * first_in_part) as usize };
        let mut alike = Every { step: ALIKE, next: (ALIKE as f64 * first_alike) as usize };
        let (mut chosen, mut times) = (Vec::new(), Vec::new());
        for field in &self.nodes.fields {
            let is_seen = field.corners.map(|corner| corner.is_some_and(|node| node_lx[node as usize] > 0.0));
            let every = if is_seen.contains(&!is_seen[0]) { &mut in_part } else { &mut alike };
            let suns = self.nodes.suns_in(field);
            for place in every.take(suns.len()) {
                chosen.push(usize::from(suns[place]));
                times.push(every.step as u16);
            }
        }
        let mut shining = Vec::new();
        let around = (self.scene, self.world);
        let found = |sun: usize, lx: f64| shining.push((sun, lx));
        let rays = self.suns.find_some(chosen.iter().copied(), around, place, (self.openings, stream), found);
        let mut shining = shining.into_iter().peekable();
        let own = chosen.iter().zip(times).filter_map(|(sun, times)| {
            let lx = shining.next_if(|(shines, _)| shines == sun).map_or(0.0, |(_, lx)| lx);
            let between_lx = self.nodes.between(*sun, |node| node_lx[node]);
            let off = (SHARE_STEPS * f64::from(times) * (lx - between_lx)).round() as i32;
            let share = (SHARE_STEPS * lx.min(1.0)).round() as u16;
            (lx > 0.0 || between_lx > 0.0).then_some(OwnSun { sun: *sun as u16, times, share, off })
        });
        seen.own = own.collect();
        rays
    }
}

/// Selects every `step`-th item of a sequence that comes in batches.
struct Every {
    step: usize,
    /// Number of items to skip before the next one.
    next: usize,
}

impl Every {
    /// Indices of the selected items in a batch of `count` items.
    fn take(&mut self, count: usize) -> std::iter::StepBy<std::ops::Range<usize>> {
        let first = self.next.min(count);
        let places = (first..count).step_by(self.step);
        self.next = match places.len() {
            0 => self.next - count,
            taken => first + taken * self.step - count,
        };
        places
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::solar_position::{Moment, direction_of, solar_position_deg};
    use crate::base::sun::Sun;
    use serde_json::{Value, json};

    /// Checks the floor of a room with a window and a building opposite, in the hours of two winter months. Nodes together with a
    /// few sampled suns agree with all suns sampled themselves, from the same points of cells. Half of the points give the sign of
    /// the nodes' error for each hour. The other half is summed with these signs. Seed 1, 4,608 sums with 16 replicas, within 4
    /// standard errors (α 6e-5). Planted fault: nodes alone deviate by more than 10 standard errors.
    #[test]
    fn a_few_suns_make_up_for_what_nodes_have_wrong() {
        const PLACES: usize = 24;
        let part = |name: &str, origin: [f64; 3], u: [f64; 3], v: [f64; 3]| -> Value {
            json!({ "name": name, "type": "rectangle", "origin": origin, "u": u, "v": v, "material": "paint" })
        };
        let geometry = json!([
            part("floor", [0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]),
            part("front 1", [-9.0, 0.0, 0.0], [0.0, 0.0, 3.0], [9.5, 0.0, 0.0]),
            part("front 2", [3.5, 0.0, 0.0], [0.0, 0.0, 3.0], [9.5, 0.0, 0.0]),
            part("front 3", [0.5, 0.0, 0.0], [0.0, 0.0, 1.0], [3.0, 0.0, 0.0]),
            part("front 4", [0.5, 0.0, 2.5], [0.0, 0.0, 9.5], [3.0, 0.0, 0.0]),
            part("opposite", [-3.0, -9.0, -4.0], [0.0, 0.0, 7.0], [7.0, 0.0, 0.0]),
        ]);
        let scene = json!({ "version": 1, "materials": { "paint": { "type": "diffuse", "reflectance": 0.6 } }, "geometry": geometry,
            "luminaires": [{ "name": "sky", "type": "sky", "luminance_distribution": "overcast", "horizontal_illuminance_lx": 1000 }],
            "receivers": [{ "name": "plane", "type": "grid", "origin": [1, 1, 0.85], "u": [1, 0, 0], "v": [0, 1, 0], "columns": 2, "rows": 2 }] });
        let scene = crate::scene_from_json(&scene.to_string(), None, std::path::Path::new(".")).expect("a scene");
        let world = World::new(&scene);
        let at = |day: u32, hour: u32| {
            let moment = Moment::of_date(2026, 1 + day / 31, 1 + day % 31, f64::from(hour) + 0.5);
            let [elevation_deg, azimuth_deg] = solar_position_deg(52.0, 13.0, moment);
            (elevation_deg > 0.0).then(|| direction_of(elevation_deg, azimuth_deg))
        };
        let towards: Vec<DVec3> = (0..59).flat_map(|day| (6..18).filter_map(move |hour| at(day, hour))).collect();
        let disk = Sun::of_normal(DVec3::Z, 1.0);
        let suns = Suns { towards, disk: [disk.sine(), disk.one_minus_cosine()] };
        let (nodes, themselves) = (SunNodes::of(&suns, 52.0), SunNodes::themselves(&suns));
        assert!(2 * nodes.suns.towards.len() < suns.towards.len());
        let meetings = vec![1; 2 * scene.triangles.len()];
        let cells = |nodes| SunCells::new((&scene, &world), (&suns, nodes), None, &meetings, (0.03, 1));
        let (few, all) = (cells(&nodes), cells(&themselves));
        // For a point, a replica and each sun: the error of nodes alone, and the error that remains.
        let wrong = |replica: usize, place: usize| -> Vec<[f64; 2]> {
            let across = |number: usize| 0.5 * (number as f64 + 0.5) / PLACES as f64;
            let barycentric = [across(place % PLACES), across(place / PLACES)];
            let [seen, exact] = [&few, &all].map(|cells| cells.suns_on(replica, (0, Side::Front), barycentric));
            let mut wrong: Vec<[f64; 2]> = (0..suns.towards.len())
                .map(|sun| [nodes.between(sun, |node| seen.of_node_lx(node)) - exact.of_node_lx(sun); 2])
                .collect();
            seen.own.iter().for_each(|own| wrong[usize::from(own.sun)][1] += own.off_lx());
            wrong
        };
        let mut signs = vec![0.0; suns.towards.len()];
        let in_half = |half: usize| (half..PLACES * PLACES).step_by(2);
        for (place, replica) in in_half(0).flat_map(|place| (0..PARTED).map(move |replica| (place, replica))) {
            signs.iter_mut().zip(wrong(replica, place)).for_each(|(sign, [of_nodes, _])| *sign += of_nodes);
        }
        let (mut sums, mut squares, mut count) = ([0.0; 2], [0.0; 2], 0.0f64);
        for (place, replica) in in_half(1).flat_map(|place| (0..PARTED).map(move |replica| (place, replica))) {
            let wrong = wrong(replica, place);
            for of in 0..2 {
                let sum: f64 = signs.iter().zip(&wrong).map(|(sign, wrong)| sign.signum() * wrong[of]).sum();
                sums[of] += sum;
                squares[of] += sum * sum;
            }
            count += 1.0;
        }
        let scores = [0, 1].map(|of| sums[of] / (squares[of] - sums[of] * sums[of] / count).sqrt());
        assert!(scores[1].abs() < 4.0, "{scores:?}");
        assert!(scores[0] > 10.0, "the planted fault passed: {scores:?}");
    }
}
