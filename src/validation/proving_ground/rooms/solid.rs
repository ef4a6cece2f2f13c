//! Closed solids: their surfaces, and tests for points inside.

use std::f64::consts::TAU;

use glam::DVec3;

use super::dice::rounded;

/// A closed solid.
#[derive(Clone, Copy, Debug)]
pub enum Solid {
    /// A box that may be rotated about the vertical.
    Block {
        /// Lowest corner in m, before rotation.
        low_m: DVec3,
        /// Highest corner in m, before rotation.
        high_m: DVec3,
        /// Rotation about the vertical through its centre in radians.
        turn_rad: f64,
    },
    /// An upright cylinder with flat sides.
    Column {
        /// Centre of its foot in m.
        foot_m: DVec3,
        /// Radius of its corners in m.
        radius_m: f64,
        /// Height in m.
        height_m: f64,
        /// Number of its sides.
        sides: usize,
    },
    /// A ball.
    Ball {
        /// Centre in m.
        center_m: DVec3,
        /// Radius in m.
        radius_m: f64,
    },
}

/// Corners of a box's faces, counter-clockwise as seen from outside. Bit k of a corner's number is set if the corner is high along
/// axis k.
const BOX_FACES: [[usize; 4]; 6] = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];

impl Solid {
    /// A box along the axes, rounded to whole millimetres.
    pub fn block(low_m: DVec3, high_m: DVec3) -> Solid {
        Solid::Block { low_m: low_m.map(rounded), high_m: high_m.map(rounded), turn_rad: 0.0 }
    }

    /// Lowest and highest corner in m of the bounding box along the axes.
    pub fn bounds_m(&self) -> [DVec3; 2] {
        match *self {
            Solid::Ball { center_m, radius_m } => {
                [center_m - DVec3::splat(radius_m), center_m + DVec3::splat(radius_m)]
            }
            _ => {
                let (corners_m, _) = self.surface();
                let none = [DVec3::INFINITY, DVec3::NEG_INFINITY];
                corners_m.iter().fold(none, |[low, high], corner| [low.min(*corner), high.max(*corner)])
            }
        }
    }

    /// Returns whether a point in m is inside.
    pub fn contains(&self, place_m: DVec3) -> bool {
        match *self {
            Solid::Block { low_m, high_m, turn_rad } => {
                let local_m = turned(place_m, 0.5 * (low_m + high_m), -turn_rad);
                local_m.cmpgt(low_m).all() && local_m.cmplt(high_m).all()
            }
            Solid::Column { foot_m, radius_m, height_m, sides } => {
                let local_m = place_m - foot_m;
                // The flat sides are nearer to the axis than the corners.
                let to_side_m = radius_m * (0.5 * TAU / sides as f64).cos();
                local_m.z > 0.0 && local_m.z < height_m && local_m.x.hypot(local_m.y) < to_side_m
            }
            Solid::Ball { center_m, radius_m } => place_m.distance(center_m) < radius_m,
        }
    }

    /// Corners and outward-facing faces. A ball has none, because the scene file has its own type for it.
    pub fn surface(&self) -> (Vec<DVec3>, Vec<Vec<usize>>) {
        match *self {
            Solid::Block { low_m, high_m, turn_rad } => {
                let corner = |corner: usize| {
                    let pick = |axis: usize| if corner >> axis & 1 == 1 { high_m[axis] } else { low_m[axis] };
                    turned(DVec3::new(pick(0), pick(1), pick(2)), 0.5 * (low_m + high_m), turn_rad)
                };
                ((0..8).map(corner).collect(), BOX_FACES.iter().map(|face| face.to_vec()).collect())
            }
            Solid::Column { foot_m, radius_m, height_m, sides } => {
                let ring = |z_m: f64| {
                    (0..sides).map(move |side| {
                        let angle = TAU * side as f64 / sides as f64;
                        foot_m + DVec3::new(radius_m * angle.cos(), radius_m * angle.sin(), z_m)
                    })
                };
                let next = |side: usize| (side + 1) % sides;
                let mut faces: Vec<Vec<usize>> =
                    (0..sides).map(|side| vec![side, next(side), sides + next(side), sides + side]).collect();
                faces.push((0..sides).rev().collect());
                faces.push((sides..2 * sides).collect());
                (ring(0.0).chain(ring(height_m)).collect(), faces)
            }
            Solid::Ball { .. } => (Vec::new(), Vec::new()),
        }
    }
}

/// Rotates a point about the vertical through a centre.
fn turned(place_m: DVec3, center_m: DVec3, angle_rad: f64) -> DVec3 {
    // Points without rotation keep every digit, so that touching faces lie in one plane.
    if angle_rad == 0.0 {
        return place_m;
    }
    let (sin, cos) = angle_rad.sin_cos();
    let DVec3 { x, y, z } = place_m - center_m;
    center_m + DVec3::new(cos * x - sin * y, sin * x + cos * y, z)
}
