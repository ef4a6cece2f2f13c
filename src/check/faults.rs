//! Faults of a mesh: their numbers and positions.

use glam::DVec3;
use serde::Serialize;

/// Number of positions that are listed for each fault.
const MOST_PLACES: usize = 8;

/// Faults of a scene's triangles that closed rooms and solids do not have.
#[derive(Clone, Debug, Default, Serialize)]
pub struct MeshFaults {
    /// Rims of pieces of surface that are not flat, longest first. A room that should be closed has none. Rims that meet along T-junctions
    /// are closed. If there are very many, only the longest are listed.
    pub holes: Vec<Hole>,
    /// Number of holes.
    pub hole_count: usize,
    /// Number of small holes, which are probably unintended.
    pub small_hole_count: usize,
    /// Area of all holes in m².
    #[serde(skip)]
    pub(super) hole_area_m2: f64,
    /// The longest small hole.
    #[serde(skip)]
    pub(super) longest_small_hole: Option<Hole>,
    /// Vertices that lie in the middle of another triangle's edge. Light may not pass there, but the triangles share no edge.
    pub t_junctions: Faults,
    /// Triangles with exactly the corners of an earlier one that face the same way. Each is hit by half of the rays, at random.
    pub duplicate_triangles: Faults,
    /// Pairs of triangles that partly cover each other in one plane and face the same way. Which one is hit there is random.
    pub overlapping_triangles: Faults,
    /// Edges that two neighbours run along in the same direction: one of the two has a reversed normal.
    pub turned_edges: Faults,
    /// Edges that belong to three, five, … triangles.
    pub odd_edges: Faults,
    /// Whether T-junctions were searched. In very large open meshes they are not.
    #[serde(rename = "t_junctions_looked_for")]
    pub t_junctions_searched: bool,
    /// Whether all pairs of coplanar triangles were tested.
    #[serde(rename = "overlaps_looked_for")]
    pub overlaps_searched: bool,
    /// Number of tests of boxes and triangles in both searches.
    #[serde(skip)]
    pub(super) steps: u64,
}

/// The number of occurrences of a fault, and their positions.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Faults {
    /// Number of occurrences.
    pub count: usize,
    /// The first few positions in m (middles of edges and triangles).
    pub places_m: Vec<[f64; 3]>,
    /// Names of the surfaces concerned.
    pub surfaces: Vec<String>,
}

/// One kind of fault with its wording.
pub struct KindOfFault<'f> {
    /// Number and positions.
    pub faults: &'f Faults,
    /// Whether the search for this kind was complete.
    pub all_searched: bool,
    /// Words for one fault.
    pub one: &'static str,
    /// Words for many faults.
    pub many: &'static str,
    /// What to do, after a semicolon; empty if there is nothing to say.
    pub remedy: &'static str,
}

impl KindOfFault<'_> {
    /// Returns the number of faults and what they are, as text.
    pub fn words(&self) -> String {
        let what = if self.faults.count == 1 { self.one } else { self.many };
        format!("{}{} {what}", if self.all_searched { "" } else { "at least " }, self.faults.count)
    }
}

/// A closed or open line of edges that belong to only one triangle.
#[derive(Clone, Debug, Serialize)]
pub struct Hole {
    /// Length of the line in m.
    pub length_m: f64,
    /// Area of the surface that would close it, as if flat, in m².
    pub area_m2: f64,
    /// Number of its edges.
    pub edges: usize,
    /// Lowest coordinates in m.
    pub min_m: [f64; 3],
    /// Highest coordinates in m.
    pub max_m: [f64; 3],
    /// Its first corners in m, in order.
    pub corners_m: Vec<[f64; 3]>,
    /// Names of the surfaces along it.
    pub surfaces: Vec<String>,
}

impl MeshFaults {
    /// Returns all kinds of faults that are counted.
    pub fn kinds(&self) -> [KindOfFault<'_>; 5] {
        let kind = |faults, one, many, remedy| KindOfFault { faults, all_searched: true, one, many, remedy };
        [
            kind(
                &self.duplicate_triangles,
                "triangle has the same corners as another",
                "triangles have the same corners as others",
                "; rays hit either of the two, so delete one",
            ),
            KindOfFault {
                all_searched: self.overlaps_searched,
                ..kind(
                    &self.overlapping_triangles,
                    "pair of triangles cover each other in one plane",
                    "pairs of triangles cover each other in one plane",
                    "; rays hit either of the two, so move them a millimetre apart or cut one",
                )
            },
            kind(
                &self.turned_edges,
                "edge lies between triangles that face opposite ways",
                "edges lie between triangles that face opposite ways",
                "; light that hits a back is absorbed, so flip one",
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
                "; rounding can open a gap there that light passes, so split that edge",
            ),
        ]
    }

    /// Whether there is no fault.
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

/// An edge of a rim: its ends and its triangle.
#[derive(Clone, Copy, Debug)]
pub(super) struct RimEdge {
    pub ends: [u32; 2],
    pub triangle: u32,
}
