//! What can be wrong with a mesh: how often, and where.

use glam::DVec3;
use serde::Serialize;

/// Places that are listed of each fault.
const MOST_PLACES: usize = 8;

/// What a scene's triangles do that closed rooms and solids don't.
#[derive(Clone, Debug, Default, Serialize)]
pub struct MeshFaults {
    /// Rims of pieces of surface that are not flat, longest first: a room that should be closed has none. Rims that
    /// meet along T-junctions are closed. Of very many only the longest are here.
    pub holes: Vec<Hole>,
    /// How many holes there are.
    pub hole_count: usize,
    /// How many of them are small, which was hardly meant.
    pub small_hole_count: usize,
    /// Area of all holes in m².
    #[serde(skip)]
    pub(super) hole_area_m2: f64,
    /// The longest of the small ones.
    #[serde(skip)]
    pub(super) longest_small_hole: Option<Hole>,
    /// Vertices that lie in the middle of another triangle's edge. Light may not pass there, yet the triangles share no
    /// edge.
    pub t_junctions: Faults,
    /// Triangles with the very corners of an earlier one, facing the same way: both are hit by half of the rays, at random.
    pub duplicate_triangles: Faults,
    /// Pairs of triangles that cover each other in part in one plane and face the same way: which is hit there is chance.
    pub overlapping_triangles: Faults,
    /// Edges that two neighbours pass the same way: one of them has its normal turned over.
    pub turned_edges: Faults,
    /// Edges of three, five, … triangles.
    pub odd_edges: Faults,
    /// Whether T-junctions were looked for; in very large open meshes they are not.
    pub t_junctions_looked_for: bool,
    /// Whether all pairs of triangles in one plane were looked at.
    pub overlaps_looked_for: bool,
    /// Looks at boxes and triangles that both searches took.
    #[serde(skip)]
    pub(super) steps: u64,
}

/// How often a fault was found, and where.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Faults {
    /// How often.
    pub count: usize,
    /// The first few places in m (middles of edges and triangles).
    pub places_m: Vec<[f64; 3]>,
    /// Surfaces concerned.
    pub surfaces: Vec<String>,
}

/// Faults of a kind in words.
pub struct KindOfFault<'f> {
    /// How many, and where.
    pub faults: &'f Faults,
    /// Whether all of them were looked for.
    pub all_looked_for: bool,
    /// What is said of one.
    pub one: &'static str,
    /// What is said of many.
    pub many: &'static str,
    /// What to do, behind a semicolon; empty where nothing is to be said.
    pub remedy: &'static str,
}

impl KindOfFault<'_> {
    /// How many there are and what they are.
    pub fn words(&self) -> String {
        let what = if self.faults.count == 1 { self.one } else { self.many };
        format!("{}{} {what}", if self.all_looked_for { "" } else { "at least " }, self.faults.count)
    }
}

/// A closed or open line of edges that only one triangle has.
#[derive(Clone, Debug, Serialize)]
pub struct Hole {
    /// Length of the line in m.
    pub length_m: f64,
    /// Area of the surface that would close it, as a plane sees it, in m².
    pub area_m2: f64,
    /// Edges in it.
    pub edges: usize,
    /// Lowest coordinates in m.
    pub min_m: [f64; 3],
    /// Highest coordinates in m.
    pub max_m: [f64; 3],
    /// Its first corners in m, in order.
    pub corners_m: Vec<[f64; 3]>,
    /// Surfaces along it.
    pub surfaces: Vec<String>,
}

impl MeshFaults {
    /// All kinds of faults that are counted.
    pub fn kinds(&self) -> [KindOfFault<'_>; 5] {
        let kind = |faults, one, many, remedy| KindOfFault { faults, all_looked_for: true, one, many, remedy };
        [
            kind(
                &self.duplicate_triangles,
                "triangle has the very corners of another",
                "triangles have the very corners of others",
                "; rays hit either of the two, so take one away",
            ),
            KindOfFault {
                all_looked_for: self.overlaps_looked_for,
                ..kind(
                    &self.overlapping_triangles,
                    "pair of triangles cover each other in one plane",
                    "pairs of triangles cover each other in one plane",
                    "; rays hit either of the two, so part them by a millimetre or cut one",
                )
            },
            kind(
                &self.turned_edges,
                "edge lies between triangles that face opposite ways",
                "edges lie between triangles that face opposite ways",
                "; light that meets a back is absorbed, so turn one",
            ),
            kind(
                &self.odd_edges,
                "edge has three triangles, or another odd number",
                "edges have three triangles, or another odd number",
                "",
            ),
            kind(
                &self.t_junctions,
                "vertex lies in the middle of another triangle's edge (T-junction)",
                "vertices lie in the middle of another triangle's edge (T-junctions)",
                "; where rounding parts them light may pass, so split that edge",
            ),
        ]
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        let faults = [
            &self.t_junctions,
            &self.duplicate_triangles,
            &self.overlapping_triangles,
            &self.turned_edges,
            &self.odd_edges,
        ];
        self.holes.is_empty() && faults.iter().all(|faults| faults.count == 0)
    }
}

impl Faults {
    pub(super) fn add(&mut self, place_m: DVec3, surface: &str) {
        self.count += 1;
        if self.places_m.len() < MOST_PLACES {
            self.places_m.push(place_m.to_array());
        }
        self.name(surface);
    }

    pub(super) fn name(&mut self, surface: &str) {
        if self.surfaces.len() < MOST_PLACES && !self.surfaces.iter().any(|name| name == surface) {
            self.surfaces.push(surface.to_string());
        }
    }
}

/// An edge of the rim: its ends and the triangle that it belongs to.
#[derive(Clone, Copy, Debug)]
pub(super) struct RimEdge {
    pub ends: [u32; 2],
    pub triangle: u32,
}
