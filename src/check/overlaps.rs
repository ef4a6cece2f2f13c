//! Solids that intersect each other.

use glam::DVec3;

use super::box_tree::{BoxTree, Budget};
use super::shells::Shell;
use crate::scene::Scene;

/// Largest number of corners of a solid that are tested against another.
const CORNERS_TESTED: usize = 32;
/// Tests of boxes and triangles in all, and additional tests per solid: one second's work for any scene.
const TESTS: u64 = 10_000_000;
const TESTS_A_SOLID: u64 = 200;
/// A corner this near to the other solid's surface, as a fraction of the scene's size, only touches it.
const TOUCHES: f64 = 1e-6;

/// Pairs of solids of which one has a corner inside the other.
#[derive(Debug, Default)]
pub(super) struct Overlaps {
    /// Number of pairs found.
    pub count: usize,
    /// The surfaces of the first pair, and the corner in m.
    pub first: Option<([String; 2], DVec3)>,
    /// Whether all pairs were tested.
    pub all_examined: bool,
}

/// Returns the budget of tests of boxes and triangles for this number of solids.
pub(super) fn overlaps_budget(solids: usize) -> Budget {
    Budget::of_steps(TESTS + TESTS_A_SOLID * solids as u64)
}

/// Finds solids that intersect each other. `shells` are the closed shells of geometries; those that face outward are solids.
pub(super) fn overlaps(scene: &Scene, shells: &[Shell], scene_size_m: f64, budget: &mut Budget) -> Overlaps {
    let solids: Vec<&Shell> = shells.iter().filter(|shell| shell.volume_m3 > 0.0).collect();
    let tolerance_m = TOUCHES * scene_size_m;
    let corner_in = |inner: &Shell, outer: &Shell, budget: &mut Budget| {
        let step = inner.triangles.len().div_ceil(CORNERS_TESTED).max(1);
        let mut corners = inner.triangles.iter().step_by(step).map(|triangle| scene.corners_m(*triangle)[0]);
        corners.find(|corner| outer.encloses(*corner, tolerance_m, budget))
    };
    let mut count = 0;
    let mut first: Option<([u32; 2], DVec3)> = None;
    let boxes = BoxTree::of(solids.iter().map(|solid| solid.bounds_m()));
    boxes.pairs(tolerance_m, budget, |one, other, budget| {
        let pair = [one.min(other), one.max(other)];
        let [low, high] = pair.map(|number| solids[number as usize]);
        let corner_m = corner_in(high, low, budget).or_else(|| corner_in(low, high, budget));
        if let (Some(corner_m), false) = (corner_m, budget.is_spent()) {
            count += 1;
            if first.is_none_or(|(known, _)| pair < known) {
                first = Some((pair, corner_m));
            }
        }
    });
    let name = |number: u32| scene.surface_of(solids[number as usize].triangles[0]).name.clone();
    Overlaps {
        count,
        first: first.map(|(pair, corner_m)| (pair.map(name), corner_m)),
        all_examined: !budget.is_spent(),
    }
}
