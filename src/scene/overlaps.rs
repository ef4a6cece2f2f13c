//! Solids that stand in one another.

use glam::DVec3;

use super::model::Scene;
use super::shells::Shell;

/// Corners of a solid that are held against another.
const MOST_CORNERS: usize = 32;
/// Tests of corners in all: a second's work, whatever the scene.
const MOST_TESTS: usize = 100_000;
/// A corner this near to the other solid's surface, as a fraction of the scene's size, only touches it.
const TOUCHES: f64 = 1e-6;

/// Pairs of solids of which one has a corner within the other: how many, the surfaces of the first pair, and the corner.
pub(super) struct Overlaps {
    /// Pairs.
    pub count: usize,
    /// Surfaces of the first.
    pub first: [String; 2],
    /// The corner in m.
    pub place_m: DVec3,
}

/// Looks for solids in one another; `shells` are the closed shells of geometries, of which those that face outward are solids.
pub(super) fn overlaps(scene: &Scene, shells: &[Shell], scene_size_m: f64) -> Option<Overlaps> {
    let solids: Vec<&Shell> = shells.iter().filter(|shell| shell.volume_m3 > 0.0).collect();
    let tolerance_m = TOUCHES * scene_size_m;
    let mut tests = 0;
    let mut found: Option<Overlaps> = None;
    for (index, one) in solids.iter().enumerate() {
        for other in &solids[..index] {
            if tests > MOST_TESTS {
                return found;
            }
            if !one.boxes_overlap(other, tolerance_m) {
                tests += 1;
                continue;
            }
            tests += 2 * MOST_CORNERS;
            let corner_in = |inner: &Shell, outer: &Shell| {
                let step = inner.triangles.len().div_ceil(MOST_CORNERS).max(1);
                let mut corners = inner.triangles.iter().step_by(step).map(|triangle| scene.corners_m(*triangle)[0]);
                corners.find(|corner| outer.encloses(*corner, tolerance_m))
            };
            if let Some(place_m) = corner_in(one, other).or_else(|| corner_in(other, one)) {
                let name = |shell: &Shell| scene.surface_of(shell.triangles[0]).name.clone();
                let overlaps =
                    found.get_or_insert_with(|| Overlaps { count: 0, first: [name(other), name(one)], place_m });
                overlaps.count += 1;
            }
        }
    }
    found
}
