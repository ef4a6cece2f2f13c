//! Straight lines through a scene, traced in f64 by testing all triangles.

use std::ops::Range;

use glam::DVec3;
use rayon::prelude::*;

use crate::scene::Scene;

/// A start this near to a surface in m lies on the surface.
pub(super) const ON_SURFACE_M: f64 = 1e-6;
/// With more triangles times luminaires than this, the aims of luminaires are not traced: one second's work.
pub(super) const MOST_LINE_TESTS: usize = 200_000_000;

/// Number of triangles that one thread tests at a time.
const PIECE: u32 = 1 << 16;

/// The first surface on a straight line.
pub(super) struct FirstMet {
    /// Distance in m.
    pub distance_m: f64,
    /// Whether it is the back of a one-sided surface.
    pub is_dead_back: bool,
}

/// Returns the first triangle along a direction, in f64, by testing all triangles. A triangle on which the start lies does not count where
/// the direction leaves it.
pub(super) fn first_met(scene: &Scene, start_m: DVec3, direction: DVec3) -> Option<FirstMet> {
    let all = 0..scene.triangles.len() as u32;
    first_met_among(scene, all, &[(start_m, direction)]).pop().flatten()
}

/// Does the same along many lines, each given by its start and direction.
pub(super) fn first_met_each(scene: &Scene, ways: &[(DVec3, DVec3)]) -> Vec<Option<FirstMet>> {
    let count = scene.triangles.len() as u32;
    let nearer = |one: Option<FirstMet>, other: Option<FirstMet>| match (one, other) {
        (Some(one), Some(other)) => Some(if other.distance_m < one.distance_m { other } else { one }),
        (one, other) => one.or(other),
    };
    (0..count.div_ceil(PIECE))
        .into_par_iter()
        .map(|piece| first_met_among(scene, piece * PIECE..count.min((piece + 1) * PIECE), ways))
        .reduce_with(|one, other| one.into_iter().zip(other).map(|(one, other)| nearer(one, other)).collect())
        .unwrap_or_else(|| ways.iter().map(|_| None).collect())
}

fn first_met_among(scene: &Scene, triangles: Range<u32>, ways: &[(DVec3, DVec3)]) -> Vec<Option<FirstMet>> {
    let mut nearest: Vec<Option<FirstMet>> = ways.iter().map(|_| None).collect();
    for triangle in triangles {
        let [a, b, c] = scene.corners_m(triangle);
        let twice_area = (b - a).cross(c - a);
        for ((start_m, direction), nearest) in ways.iter().zip(&mut nearest) {
            let slope = twice_area.dot(*direction);
            let distance_m = twice_area.dot(a - *start_m) / slope;
            let is_candidate =
                distance_m > ON_SURFACE_M || (distance_m >= -ON_SURFACE_M && slope < 0.0 && distance_m.is_finite());
            if !is_candidate || nearest.as_ref().is_some_and(|met| met.distance_m <= distance_m) {
                continue;
            }
            let hit_m = *start_m + distance_m * *direction;
            let is_left = |from: DVec3, to: DVec3| (to - from).cross(hit_m - from).dot(twice_area) >= 0.0;
            if is_left(a, b) && is_left(b, c) && is_left(c, a) {
                let is_dead_back = slope > 0.0 && !scene.surface_of(triangle).two_sided;
                *nearest = Some(FirstMet { distance_m, is_dead_back });
            }
        }
    }
    nearest
}
