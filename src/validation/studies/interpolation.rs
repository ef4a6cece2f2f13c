//! How a place takes what mesh points keep: which of them, and with which weights.
//!
//! Debelov and Sevastyanov (2001) average direct light with a weight φ₄(x, y) and indirect light with a weight φ₅(x, y) of the mesh point x
//! for the place y (their eqs. 3 and 6). They take 1 for both, and leave others to experiments.

use glam::DVec3;

use crate::light_mesh::{Index, Lattice, RADIUS_PER_STEP};

/// What a mesh point keeps of direct light.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DirectForm {
    /// Which luminaires are in sight (2009).
    Visibility,
    /// One number, which knows no luminaire (2001, eqs. 1 to 3).
    Scalar,
}

impl DirectForm {
    /// Both.
    pub const ALL: [DirectForm; 2] = [DirectForm::Visibility, DirectForm::Scalar];

    /// In a table, and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            DirectForm::Visibility => "visibility",
            DirectForm::Scalar => "scalar",
        }
    }
}

/// How a place takes what the points about it keep, of those that are free and in front of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Interpolation {
    /// The nearest corner of its cell.
    Nearest,
    /// All corners of its cell, trilinear.
    Trilinear,
    /// All points within the radius, with the weight 1 of the 2001 paper.
    Sphere,
    /// The same, weighted by 1 − distance/radius.
    Cone,
}

impl Interpolation {
    /// All of them.
    pub const ALL: [Interpolation; 4] =
        [Interpolation::Nearest, Interpolation::Trilinear, Interpolation::Sphere, Interpolation::Cone];

    /// In a table.
    pub fn name(self) -> &'static str {
        match self {
            Interpolation::Nearest => "nearest point",
            Interpolation::Trilinear => "trilinear",
            Interpolation::Sphere => "sphere, φ = 1",
            Interpolation::Cone => "sphere, φ = 1 − d/R",
        }
    }

    /// The word that asks for it on the command line; both weights of a sphere have the same.
    pub fn word(self) -> &'static str {
        match self {
            Interpolation::Nearest => "nearest",
            Interpolation::Trilinear => "trilinear",
            Interpolation::Sphere | Interpolation::Cone => "sphere",
        }
    }

    /// Weight of a point that lies so many steps off along the axes; of the nearest point alone it only tells which that is.
    fn weight(self, off: DVec3) -> f64 {
        let distance = off.length();
        match self {
            Interpolation::Nearest => 1.0,
            Interpolation::Trilinear => (1.0 - off.abs()).max(DVec3::ZERO).element_product(),
            Interpolation::Sphere => f64::from(u8::from(distance < RADIUS_PER_STEP)),
            Interpolation::Cone => (1.0 - distance / RADIUS_PER_STEP).max(0.0),
        }
    }

    /// The points that a place which faces up takes light from, each with what it keeps and its weight, which add up to 1; none where all
    /// are hidden in solids. `of_point` tells what a point keeps, if it is free.
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

    /// Weights of φ₄ and φ₅ by hand. With a step of 1 m the place (0.25, 0, 0.5) of a cell has over it the layer at 1, half a step
    /// up: trilinear 0.75 and 0.25; within R = 1.25 there (0, 0), (1, 0) and, at √(0.0625 + 1 + 0.25) = 1.146, (0, ±1); (−1, 0) is 1.346 off. The
    /// layer at 2 is 1.5 off. Cone weights are 1 − d/1.25 over their sum. A radius of 1.1 steps, the planted fault, would lose the
    /// points at (0, ±1).
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

        // d² of the points of the layer: (0,0) 0.3125, (1,0) 0.8125, (0,±1) 1.3125; (−1,0) and (1,±1) are 1.8125, beyond 1.5625.
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

    /// What lies in solids is left out, and the weights of the rest add up to 1 again.
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
