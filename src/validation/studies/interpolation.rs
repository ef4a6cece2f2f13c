//! Interpolation of the values of mesh points at a receiver point: which points are used, and with which weights.
//!
//! Debelov and Sevastyanov (2001) average direct light with a weight φ₄(x, y) and indirect light with a weight φ₅(x, y) of the mesh
//! point x for the point y (their eqs. 3 and 6). They use 1 for both and leave other weights to experiments.

use glam::DVec3;

use crate::light_mesh::{Index, Lattice, RADIUS_PER_STEP};

/// Form in which a mesh point stores direct light.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DirectForm {
    /// The visible luminaires (2009).
    Visibility,
    /// One number for all luminaires together (2001, eqs. 1 to 3).
    Scalar,
}

impl DirectForm {
    /// Both forms.
    pub const ALL: [DirectForm; 2] = [DirectForm::Visibility, DirectForm::Scalar];

    /// Name in tables and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            DirectForm::Visibility => "visibility",
            DirectForm::Scalar => "scalar",
        }
    }
}

/// Interpolation from the surrounding mesh points that are free and in front of the receiver point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Interpolation {
    /// Value of the nearest corner of its cell.
    Nearest,
    /// Trilinear interpolation from all corners of its cell.
    Trilinear,
    /// Mean of all points within the radius, with the weight 1 of the 2001 paper.
    Sphere,
    /// Mean of all points within the radius, weighted by 1 − distance/radius.
    Cone,
}

impl Interpolation {
    /// All interpolations.
    pub const ALL: [Interpolation; 4] =
        [Interpolation::Nearest, Interpolation::Trilinear, Interpolation::Sphere, Interpolation::Cone];

    /// Name in tables.
    pub fn name(self) -> &'static str {
        match self {
            Interpolation::Nearest => "nearest point",
            Interpolation::Trilinear => "trilinear",
            Interpolation::Sphere => "sphere, φ = 1",
            Interpolation::Cone => "sphere, φ = 1 − d/R",
        }
    }

    /// Word on the command line. Both weights of a sphere have the same word.
    pub fn word(self) -> &'static str {
        match self {
            Interpolation::Nearest => "nearest",
            Interpolation::Trilinear => "trilinear",
            Interpolation::Sphere | Interpolation::Cone => "sphere",
        }
    }

    /// Weight of a point at an offset in steps along the axes. For `Nearest` the weight is constant, and only the nearest point is
    /// kept.
    fn weight(self, off: DVec3) -> f64 {
        let distance = off.length();
        match self {
            Interpolation::Nearest => 1.0,
            Interpolation::Trilinear => (1.0 - off.abs()).max(DVec3::ZERO).element_product(),
            Interpolation::Sphere => f64::from(u8::from(distance < RADIUS_PER_STEP)),
            Interpolation::Cone => (1.0 - distance / RADIUS_PER_STEP).max(0.0),
        }
    }

    /// The mesh points from which an upward-facing point takes light, with their values and weights, which add up to 1. Empty if
    /// all are inside solids. `of_point` returns the value of a point if it is free.
    pub fn about<T>(self, lattice: &Lattice, place_m: DVec3, of_point: impl Fn(Index) -> Option<T>) -> Vec<(T, f64)> {
        let (cell, rest) = lattice.cell_of(place_m);
        let of_cell = matches!(self, Interpolation::Nearest | Interpolation::Trilinear);
        let reach = if of_cell { 0..=1 } else { -1..=2 };
        let mut found = Vec::new();
        let mut nearest = f64::INFINITY;
        for k in reach.clone() {
            for j in reach.clone() {
                for i in reach.clone() {
                    let index = [cell[0] + i, cell[1] + j, cell[2] + k];
                    if !lattice.contains(index) || lattice.position_m(index).z <= place_m.z {
                        continue;
                    }
                    let off = DVec3::new(f64::from(i), f64::from(j), f64::from(k)) - rest;
                    let weight = self.weight(off);
                    let is_nearer = self != Interpolation::Nearest || off.length() < nearest;
                    if weight <= 0.0 || !is_nearer {
                        continue;
                    }
                    let Some(kept) = of_point(index) else { continue };
                    if self == Interpolation::Nearest {
                        nearest = off.length();
                        found.clear();
                    }
                    found.push((kept, weight));
                }
            }
        }
        let all: f64 = found.iter().map(|(_, weight)| weight).sum();
        found.iter_mut().for_each(|(_, weight)| *weight /= all);
        found
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Checks the weights φ₄ and φ₅ by hand. With a step of 1 m, the layer at 1 is half a step above the point (0.25, 0, 0.5) of a
    /// cell. Trilinear weights are 0.75 and 0.25. Within R = 1.25 there are (0, 0), (1, 0) and (0, ±1), the latter at 1.146 =
    /// √(0.0625 + 1 + 0.25). (−1, 0) is at 1.346, and the layer at 2 is 1.5 above. Cone weights are 1 − d/1.25 over their sum. Planted
    /// fault: a radius of 1.1 steps loses the points (0, ±1).
    #[test]
    fn weights_are_those_by_hand() {
        let lattice = Lattice { origin_m: DVec3::ZERO, step_m: 1.0, counts: [9; 3] };
        let place_m = DVec3::new(4.25, 4.0, 4.5);
        let found = |interpolation: Interpolation| -> Vec<([i32; 3], f64)> {
            let mut found = interpolation.about(&lattice, place_m, |index| Some(index.map(|i| i - 4)));
            found.retain(|(_, weight)| *weight > 0.0);
            found.sort_by_key(|(index, _)| *index);
            found
        };
        let agree = |found: &[([i32; 3], f64)], by_hand: &[([i32; 3], f64)]| {
            found.len() == by_hand.len()
                && found.iter().zip(by_hand).all(|(a, b)| a.0 == b.0 && (a.1 - b.1).abs() < 1e-12)
        };
        assert_eq!(found(Interpolation::Nearest), [([0, 0, 1], 1.0)]);
        assert!(agree(&found(Interpolation::Trilinear), &[([0, 0, 1], 0.75), ([1, 0, 1], 0.25)]));

        // d² of the layer's points: (0,0) 0.3125, (1,0) 0.8125, (0,±1) 1.3125. (−1,0) and (1,±1) have 1.8125, beyond 1.5625.
        let by_hand = [([0, -1, 1], 1.3125f64), ([0, 0, 1], 0.3125), ([0, 1, 1], 1.3125), ([1, 0, 1], 0.8125)];
        let even = by_hand.map(|(index, _)| (index, 0.25));
        let of_radius = |radius: f64| {
            let weights = by_hand.map(|(index, square)| (index, (1.0 - square.sqrt() / radius).max(0.0)));
            let all: f64 = weights.iter().map(|(_, weight)| weight).sum();
            weights.map(|(index, weight)| (index, weight / all))
        };
        assert!(agree(&found(Interpolation::Sphere), &even), "{:?}", found(Interpolation::Sphere));
        let cone = found(Interpolation::Cone);
        assert!(agree(&cone, &of_radius(1.25)), "{cone:?}");
        assert!(!agree(&cone, &of_radius(1.1)) && !agree(&cone, &even), "the planted faults passed");
    }

    /// Points inside solids are left out, and the weights of the rest add up to 1 again.
    #[test]
    fn hidden_points_are_left_out() {
        let lattice = Lattice { origin_m: DVec3::ZERO, step_m: 1.0, counts: [9; 3] };
        for interpolation in Interpolation::ALL {
            let place_m = DVec3::new(4.25, 4.0, 4.5);
            let is_free = |index: Index| (index != [4, 4, 5]).then_some(index);
            let found = interpolation.about(&lattice, place_m, is_free);
            assert!(!found.is_empty() && found.iter().all(|(index, _)| *index != [4, 4, 5]));
            assert!((found.iter().map(|(_, weight)| weight).sum::<f64>() - 1.0).abs() < 1e-12);
            assert!(interpolation.about(&lattice, place_m, |_| None::<Index>).is_empty());
        }
    }
}
