//! Which receivers have something near in front of them.

use glam::DVec3;
use rayon::prelude::*;

use crate::chain::Stage;
use crate::estimators::local::Anchors;
use crate::scene::{Quantity, Scene};

/// Pairs of receivers and triangles that are looked through at most; with more, everything counts as near.
const MOST_PAIRS: usize = 50_000_000;
/// What lies in front of a receiver by less than this many times the tracer's accuracy is its own surface.
const OWN_SURFACE: f64 = 4.0;

/// Distance in m from every anchor to the nearest surface before it; 0 where looking would take too long.
pub(super) fn nearest_m(scene: &Scene, stage: &Stage, quantity: Quantity, anchors: &Anchors) -> Vec<f64> {
    if anchors.len() * scene.triangles.len() > MOST_PAIRS {
        return vec![0.0; anchors.len()];
    }
    let tolerance_m = OWN_SURFACE * stage.tracer.position_accuracy_m();
    let all_round = matches!(quantity, Quantity::Cylindrical | Quantity::SemiCylindrical { .. });
    (0..anchors.len())
        .into_par_iter()
        .map(|anchor| {
            let (point_m, normal) = anchors.place(anchor);
            let mut nearest = f64::INFINITY;
            for triangle in 0..scene.triangles.len() as u32 {
                let corners = scene.corners_m(triangle).map(|corner| corner - point_m);
                let is_before = all_round || corners.iter().any(|corner| corner.dot(normal) > tolerance_m);
                if is_before {
                    nearest = nearest.min(distance_m(&corners));
                }
            }
            nearest
        })
        .collect()
}

/// Distance from the origin to a triangle.
fn distance_m(corners: &[DVec3; 3]) -> f64 {
    let [a, b, c] = *corners;
    let normal = (b - a).cross(c - a);
    let is_over = [(a, b), (b, c), (c, a)].iter().all(|(from, to)| (*to - *from).cross(-*from).dot(normal) >= 0.0);
    if is_over {
        return (a.dot(normal) / normal.length()).abs();
    }
    let to_edge = |from: DVec3, to: DVec3| {
        let along = to - from;
        let share = (-from.dot(along) / along.length_squared()).clamp(0.0, 1.0);
        (from + share * along).length()
    };
    to_edge(a, b).min(to_edge(b, c)).min(to_edge(c, a))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances_to_faces_edges_and_corners() {
        let at = |x: f64, y: f64, z: f64| {
            let point = DVec3::new(x, y, z);
            distance_m(&[DVec3::ZERO, DVec3::X, DVec3::Y].map(|corner| corner - point))
        };
        assert!((at(0.2, 0.2, 0.5) - 0.5).abs() < 1e-12);
        assert!((at(0.5, -0.3, 0.4) - 0.5).abs() < 1e-12);
        assert!((at(2.0, 0.0, 0.0) - 1.0).abs() < 1e-12);
        assert!((at(1.0, 1.0, 0.0) - 0.5f64.sqrt()).abs() < 1e-12);
    }
}
