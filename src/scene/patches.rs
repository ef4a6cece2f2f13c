//! Patches: where chains remember the light that they brought, for gathering rays to look up.
//!
//! Unlike elements, patches are all of about one size, whatever the mesh: a large triangle is cut into `n²` congruent
//! parts, small ones that lie together and face alike are joined.

use std::collections::HashMap;

use glam::DVec3;

use super::elements::{part_at, part_corners};
use super::{Scene, Side};

/// A triangle is joined with its neighbours below this share of the area of a patch.
const SMALL: f64 = 0.5;
/// Divisions of a triangle, at most: a needle's patches would else be as many as its length over its width.
const MOST_DIVISIONS: f64 = 512.0;
/// Places where rays asked a patch of joined triangles that are expected, were they even, on triangles of one weight, at least.
const PLACES_TOGETHER: f64 = 1.0;
/// Steps in which the components of normals are told apart when triangles are joined. No component that is usual, 1, 0.71, 0.58 or 0.5,
/// lies at an edge of the rounding.
const NORMAL_STEPS: f64 = 1.4;

/// Patches of a scene.
#[derive(Clone, Debug, Default)]
pub struct Patches {
    triangles: Vec<PatchedTriangle>,
    area_m2: Vec<f64>,
    /// What each patch is made of.
    content: Vec<Content>,
    /// Places of joined patches where rays asked them; empty before these are known.
    asked: Vec<Vec<(u32, [f64; 2])>>,
    /// Number of the surface's part that faces one way, for each patch.
    face: Vec<u32>,
    faces: u32,
    next_face: u32,
    /// Triangles of joined patches with the area of the patch up to and including each.
    joined: Vec<Vec<(u32, f64)>>,
}

/// A place: triangle, barycentric coordinates, side.
pub type Spot = (u32, [f64; 2], Side);

/// What a patch is made of.
#[derive(Clone, Copy, Debug)]
enum Content {
    /// A part of a triangle's side.
    Part { triangle: u32, part: u32, side: Side },
    /// Whole triangles that face one way: the place of their list.
    Joined { list: u32, side: Side },
}

/// How a triangle is patched: cut where `divisions > 0`, joined where it is 0. `first` counts for front and back.
#[derive(Clone, Copy, Debug)]
struct PatchedTriangle {
    divisions: u32,
    first: [u32; 2],
    /// Weight of a joined triangle in its patch over that of its area, front and back.
    weight: [f64; 2],
}

/// Where something met a patch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PatchPlace {
    /// The patch.
    pub patch: u32,
    /// Weights of the second and third corner of the patch, less ⅓ each; 0 in a patch of joined triangles.
    pub offset: [f64; 2],
}

impl Patches {
    /// Patches with edges of about `edge_m`.
    pub fn of(scene: &Scene, edge_m: f64) -> Patches {
        let mut patches = Patches::default();
        let mut joined: HashMap<Group, u32> = HashMap::new();
        let mut faces: HashMap<(u32, [i8; 3]), u32> = HashMap::new();
        for triangle in 0..scene.triangles.len() as u32 {
            let two_sided = scene.surface_of(triangle).two_sided;
            let area_m2 = scene.triangle_area_m2(triangle);
            let divisions = (longest_edge_m(scene, triangle) / edge_m).ceil().clamp(1.0, MOST_DIVISIONS);
            let is_small = divisions == 1.0 && area_m2 < SMALL * 0.5 * edge_m * edge_m;
            let first = [Side::Front, Side::Back].map(|side| {
                if side == Side::Back && !two_sided {
                    return u32::MAX;
                }
                let count = faces.len() as u32;
                patches.next_face =
                    *faces.entry((scene.surface_id_of(triangle), facing_of(scene, triangle, side))).or_insert(count);
                if is_small {
                    let group = group_of(scene, triangle, side, edge_m);
                    let patch = *joined.entry(group).or_insert_with(|| patches.push_joined(side));
                    patches.join(patch, triangle, area_m2);
                    patch
                } else {
                    patches.push_parts(triangle, side, divisions as u32, area_m2)
                }
            });
            patches.triangles.push(PatchedTriangle {
                divisions: if is_small { 0 } else { divisions as u32 },
                first,
                weight: [1.0; 2],
            });
        }
        patches.faces = faces.len() as u32;
        patches
    }

    fn push_parts(&mut self, triangle: u32, side: Side, divisions: u32, area_m2: f64) -> u32 {
        let first = self.area_m2.len() as u32;
        let parts = divisions * divisions;
        self.area_m2.extend((0..parts).map(|_| area_m2 / f64::from(parts)));
        self.content.extend((0..parts).map(|part| Content::Part { triangle, part, side }));
        self.face.resize(self.content.len(), self.next_face);
        first
    }

    fn push_joined(&mut self, side: Side) -> u32 {
        self.area_m2.push(0.0);
        self.content.push(Content::Joined { list: self.joined.len() as u32, side });
        self.joined.push(Vec::new());
        self.face.push(self.next_face);
        self.area_m2.len() as u32 - 1
    }

    fn join(&mut self, patch: u32, triangle: u32, area_m2: f64) {
        self.area_m2[patch as usize] += area_m2;
        if let Content::Joined { list, .. } = self.content[patch as usize] {
            self.joined[list as usize].push((triangle, self.area_m2[patch as usize]));
        }
    }

    /// Makes joined patches tell of where they are asked: at places where rays met them, and anywhere with the weight of one such place.
    ///
    /// What is told is then the mean over what is seen of such a patch, not over what lies hidden between things.
    pub fn tell_of(&mut self, places: impl Iterator<Item = Spot>) {
        self.tell_of_places(places, PLACES_TOGETHER);
    }

    fn tell_of_places(&mut self, places: impl Iterator<Item = Spot>, together: f64) {
        self.asked = vec![Vec::new(); self.joined.len()];
        let mut asks = vec![[0.0; 2]; self.triangles.len()];
        for (triangle, barycentric, side) in places {
            if let Some(place) = self.place(triangle, barycentric, side)
                && let Content::Joined { list, .. } = self.content[place.patch as usize]
            {
                self.asked[list as usize].push((triangle, barycentric));
                asks[triangle as usize][usize::from(side == Side::Back)] += 1.0;
            }
        }
        for (patch, content) in self.content.iter().enumerate() {
            let Content::Joined { list, side } = *content else {
                continue;
            };
            let (area_m2, places) = (self.area_m2[patch], self.asked[list as usize].len() as f64);
            let side = usize::from(side == Side::Back);
            // Which of far smaller triangles were asked is chance: those next to each other in the mesh have one weight.
            let least_m2 = together * area_m2 / places;
            let triangles = &self.joined[list as usize];
            let (mut first, mut until_m2, mut asked) = (0, 0.0, 0.0);
            for (number, (triangle, reached_m2)) in triangles.iter().enumerate() {
                asked += asks[*triangle as usize][side];
                let is_last = number + 1 == triangles.len();
                if is_last || (reached_m2 - until_m2 >= least_m2 && area_m2 - reached_m2 >= least_m2) {
                    let own_m2 = reached_m2 - until_m2;
                    let weight = (asked * area_m2 + own_m2) / ((places + 1.0) * own_m2);
                    for (triangle, _) in &triangles[first..=number] {
                        self.triangles[*triangle as usize].weight[side] = weight;
                    }
                    (first, until_m2, asked) = (number + 1, *reached_m2, 0.0);
                }
            }
        }
    }

    /// Weight of what arrives on a side of a triangle in what its patch tells: 1 but where that tells of where it is asked.
    #[inline]
    pub fn weight(&self, triangle: u32, side: Side) -> f64 {
        self.triangles[triangle as usize].weight[usize::from(side == Side::Back)]
    }

    /// A point of a patch by two variates and a third: uniform over its area, or where it was asked.
    pub fn point(&self, patch: u32, [u, v]: [f64; 2], choice: f64) -> Spot {
        match self.content[patch as usize] {
            Content::Part { triangle, part, side } => {
                let corners = part_corners(self.triangles[triangle as usize].divisions, part);
                let at = |k: usize| {
                    corners[0][k] + u * (corners[1][k] - corners[0][k]) + v * (corners[2][k] - corners[0][k])
                };
                (triangle, [at(0), at(1)], side)
            }
            Content::Joined { list, side } => {
                let asked = self.asked.get(list as usize).map_or(&[][..], |asked| asked);
                let choice = choice * (asked.len() + 1) as f64;
                if let Some((triangle, barycentric)) = asked.get(choice as usize) {
                    return (*triangle, *barycentric, side);
                }
                let triangles = &self.joined[list as usize];
                let aim = choice.fract() * self.area_m2[patch as usize];
                let chosen = triangles.partition_point(|(_, area_m2)| *area_m2 <= aim).min(triangles.len() - 1);
                (triangles[chosen].0, [u, v], side)
            }
        }
    }

    /// Whether a patch is made of whole triangles that lie together.
    pub fn is_joined(&self, patch: u32) -> bool {
        matches!(self.content[patch as usize], Content::Joined { .. })
    }

    /// Number of the part of a surface that faces one way, to which a patch belongs.
    #[inline]
    pub fn face(&self, patch: usize) -> usize {
        self.face[patch] as usize
    }

    /// How many of these there are.
    pub fn faces(&self) -> usize {
        self.faces as usize
    }

    /// Number of patches.
    pub fn len(&self) -> usize {
        self.area_m2.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.area_m2.is_empty()
    }

    /// Area of a patch in m².
    #[inline]
    pub fn area_m2(&self, patch: u32) -> f64 {
        self.area_m2[patch as usize]
    }

    /// Area of all patches in m².
    pub fn all_area_m2(&self) -> f64 {
        self.area_m2.iter().sum()
    }

    /// The patch on a side of a triangle at barycentric coordinates `(u, v)`; `None` for the back of a one-sided one.
    #[inline]
    pub fn place(&self, triangle: u32, [u, v]: [f64; 2], side: Side) -> Option<PatchPlace> {
        let PatchedTriangle { divisions, first, .. } = self.triangles[triangle as usize];
        let first = first[usize::from(side == Side::Back)];
        if first == u32::MAX {
            return None;
        }
        if divisions == 0 {
            return Some(PatchPlace { patch: first, offset: [0.0; 2] });
        }
        let n = f64::from(divisions);
        let row = ((v * n) as u32).min(divisions - 1);
        let column = ((u * n) as u32).min(divisions - 1 - row);
        let (a, b) = (u * n - f64::from(column), v * n - f64::from(row));
        let part = part_at(divisions, u, v);
        // Parts of a row stand upright and upside down in turn.
        let upside_down = (part - row * (2 * divisions - row)) % 2 == 1;
        let offset = if upside_down { [2.0 / 3.0 - a, 2.0 / 3.0 - b] } else { [a - 1.0 / 3.0, b - 1.0 / 3.0] };
        let patch = first + part;
        Some(PatchPlace { patch, offset })
    }
}

fn longest_edge_m(scene: &Scene, triangle: u32) -> f64 {
    let [a, b, c] = scene.corners_m(triangle);
    a.distance(b).max(b.distance(c)).max(c.distance(a))
}

/// Surface, cube of the lattice, and facing of triangles that are joined.
type Group = (u32, [i64; 3], [i8; 3]);

/// Small triangles of a surface are joined where their middles lie in one cube of a lattice and they face about one way.
fn group_of(scene: &Scene, triangle: u32, side: Side, edge_m: f64) -> Group {
    let [a, b, c] = scene.corners_m(triangle);
    let cube = ((a + b + c) / (3.0 * edge_m)).floor();
    (scene.surface_id_of(triangle), cube.to_array().map(|step| step as i64), facing_of(scene, triangle, side))
}

/// Which way a side of a triangle faces, in steps.
fn facing_of(scene: &Scene, triangle: u32, side: Side) -> [i8; 3] {
    let turned = if side == Side::Front { 1.0 } else { -1.0 };
    let normal: DVec3 = scene.triangle_normal(triangle) * turned;
    (normal * NORMAL_STEPS).round().to_array().map(|step| step as i8)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::scene_from_json;

    fn room() -> Scene {
        let text = r#"{ "version": 1, "materials": { "m": { "type": "diffuse", "reflectance": 0.5 } },
            "geometry": [ { "name": "room", "type": "box", "min": [0,0,0], "max": [3,2,1], "facing": "inward", "material": "m" },
                          { "name": "ball", "type": "sphere", "center": [1,1,0.5], "radius": 0.05, "facing": "outward", "material": "m" } ],
            "luminaires": [ { "name": "lamp", "type": "point", "position": [2,1,0.9], "intensity_cd": 1 } ] }"#;
        scene_from_json(text, None, std::path::Path::new(".")).expect("the room is valid")
    }

    #[test]
    fn patches_share_out_the_whole_area_and_places_lie_in_their_own_patch() {
        let scene = room();
        let patches = Patches::of(&scene, 0.3);
        let area_m2: f64 = (0..scene.triangles.len() as u32).map(|triangle| scene.triangle_area_m2(triangle)).sum();
        let patched_m2: f64 = (0..patches.len() as u32).map(|patch| patches.area_m2(patch)).sum();
        assert!((patched_m2 / area_m2 - 1.0).abs() < 1e-12);

        // A regular lattice in each triangle meets every patch as often as its area says, and its offsets cancel.
        const STEPS: u32 = 120;
        let mut counts = vec![0u32; patches.len()];
        let mut sums = vec![[0.0f64; 2]; patches.len()];
        for triangle in 0..12 {
            for (i, j) in (0..STEPS).flat_map(|i| (0..STEPS - i).map(move |j| (i, j))) {
                for third in [1.0 / 3.0, 2.0 / 3.0] {
                    let at = [f64::from(i) + third, f64::from(j) + third].map(|step| step / f64::from(STEPS));
                    if at[0] + at[1] < 1.0
                        && let Some(place) = patches.place(triangle, at, Side::Front)
                    {
                        counts[place.patch as usize] += 1;
                        (0..2).for_each(|k| sums[place.patch as usize][k] += place.offset[k]);
                    }
                }
            }
            assert_eq!(patches.place(triangle, [0.2, 0.2], Side::Back), None);
        }
        let met = counts.iter().filter(|count| **count > 0).count();
        assert!(met > 200 && patches.len() - met < 60, "{met} of {}", patches.len());
        for (count, [a, b]) in counts.iter().zip(&sums).filter(|(count, _)| **count > 0) {
            assert!(a.abs().max(b.abs()) < 0.05 * f64::from(*count), "{count}: {a} {b}");
        }
    }

    #[test]
    fn small_triangles_are_joined_by_place_and_facing() {
        let scene = room();
        let patches = Patches::of(&scene, 0.3);
        let ball: Vec<u32> = (12..scene.triangles.len() as u32)
            .filter_map(|triangle| patches.place(triangle, [0.3, 0.3], Side::Front))
            .map(|place| place.patch)
            .collect();
        let mut different = ball.clone();
        different.sort_unstable();
        different.dedup();
        assert!(ball.len() > 100 && different.len() < 60, "{} {}", ball.len(), different.len());
    }

    /// Twenty places on a ball of some hundred triangles in few patches: what arrives anywhere counts no more than some times as much as
    /// elsewhere, and in all as before. Weights of single triangles (planted) make a few of them the whole patch.
    #[test]
    fn what_arrives_where_few_rays_asked_has_even_weights() {
        let scene = room();
        let patches = Patches::of(&scene, 1.0);
        let ball = 12..scene.triangles.len() as u32;
        // Squares in a ring of numbers lie as unevenly as chance would have them.
        let places: Vec<Spot> =
            (1..=20u32).map(|k| (ball.start + 37 * k * k % ball.len() as u32, [0.3, 0.3], Side::Front)).collect();
        let told = |together: f64| {
            let mut patches = patches.clone();
            patches.tell_of_places(places.iter().copied(), together);
            let mut sums_m2 = vec![0.0; patches.len()];
            let weights: Vec<f64> = ball.clone().map(|triangle| patches.weight(triangle, Side::Front)).collect();
            for (triangle, weight) in ball.clone().zip(&weights) {
                let patch = patches.place(triangle, [0.3, 0.3], Side::Front).expect("a patch").patch;
                sums_m2[patch as usize] += weight * scene.triangle_area_m2(triangle);
            }
            for (patch, sum_m2) in sums_m2.iter().enumerate().filter(|(_, sum_m2)| **sum_m2 > 0.0) {
                assert!((sum_m2 / patches.area_m2(patch as u32) - 1.0).abs() < 1e-9);
            }
            weights.iter().copied().fold(0.0, f64::max)
        };
        let (even, planted) = (told(PLACES_TOGETHER), told(0.0));
        assert!(even < 4.0 && planted > 2.0 * even, "{even} {planted}");
    }
}
