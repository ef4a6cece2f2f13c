//! The directions of an intensity distribution in C planes, and the cells of the sphere that belong to them.

use std::f64::consts::{PI, TAU};

use glam::DVec3;

/// The directions of an intensity distribution: evenly turned planes through its axis, and evenly spaced angles γ from the axis.
///
/// Every direction stands for a cell of the sphere about it. At both ends of the axis all planes share one entry. A single plane stands
/// for all planes: the distribution is then the mean over C.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct IntensityTable {
    /// C planes.
    pub planes: u32,
    /// Steps of γ from 0 to 180°.
    pub steps: u32,
    /// Unit vectors of C0 (γ = 90°), C90 (γ = 90°) and γ = 0.
    pub frame: [DVec3; 3],
    /// Luminous opening as written to photometric files: extents in m along C0–C180, C90–C270 and the axis.
    pub opening_m: [f64; 3],
}

impl IntensityTable {
    /// Number of entries: one for each end of the axis, and one per plane at each γ between.
    pub fn entries(&self) -> usize {
        2 + self.planes as usize * (self.steps as usize - 1)
    }

    /// Index of the entry of a plane and a step of γ.
    pub fn entry(&self, plane: u32, step: u32) -> usize {
        match step {
            0 => 0,
            step if step >= self.steps => self.entries() - 1,
            step => 1 + (step as usize - 1) * self.planes as usize + (plane % self.planes) as usize,
        }
    }

    /// Angle of a plane in degrees.
    pub fn c_deg(&self, plane: u32) -> f64 {
        360.0 * f64::from(plane) / f64::from(self.planes)
    }

    /// γ at a step in degrees.
    pub fn gamma_deg(&self, step: u32) -> f64 {
        180.0 * f64::from(step) / f64::from(self.steps)
    }

    /// Index of the entry whose cell contains a unit direction.
    pub fn entry_towards(&self, direction: DVec3) -> usize {
        let [x, y, z] = self.frame.map(|axis| direction.dot(axis));
        let step = (x.hypot(y).atan2(z) / PI * f64::from(self.steps)).round() as u32;
        let plane = (y.atan2(x) / TAU * f64::from(self.planes)).round() as i64;
        self.entry(plane.rem_euclid(i64::from(self.planes)) as u32, step)
    }

    /// Unit direction of a plane at a step of γ.
    pub fn direction(&self, plane: u32, step: u32) -> DVec3 {
        let (sin_c, cos_c) = self.c_deg(plane).to_radians().sin_cos();
        let (sin_gamma, cos_gamma) = self.gamma_deg(step).to_radians().sin_cos();
        let [c0, c90, axis] = self.frame;
        (sin_gamma * (cos_c * c0 + sin_c * c90) + cos_gamma * axis).normalize()
    }

    /// Solid angle in sr of the cell of an entry at a step of γ, docs/methods.md (29).
    pub fn solid_angle_sr(&self, step: u32) -> f64 {
        let half = 0.5 * PI / f64::from(self.steps);
        let gamma = PI * f64::from(step) / f64::from(self.steps);
        match step {
            0 => TAU * 2.0 * (0.5 * half).sin().powi(2),
            step if step >= self.steps => TAU * 2.0 * (0.5 * half).sin().powi(2),
            _ => TAU / f64::from(self.planes) * 2.0 * gamma.sin() * half.sin(),
        }
    }

    /// Plane and step of every entry, in the order of the entries.
    pub fn places(&self) -> impl Iterator<Item = (u32, u32)> + '_ {
        let between = (1..self.steps).flat_map(|step| (0..self.planes).map(move |plane| (plane, step)));
        std::iter::once((0, 0)).chain(between).chain(std::iter::once((0, self.steps)))
    }

    /// The axis of a distribution with a single plane that stands for all planes.
    pub fn turned_about(&self) -> Option<DVec3> {
        (self.planes == 1).then_some(self.frame[2])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::vectors::photometric_frame;

    fn table(planes: u32, steps: u32) -> IntensityTable {
        IntensityTable { planes, steps, frame: photometric_frame(-DVec3::Z, 20.0), opening_m: [0.0; 3] }
    }

    #[test]
    fn cells_fill_the_sphere_and_hold_their_own_direction() {
        for (planes, steps) in [(1, 4), (24, 36), (7, 10), (2, 180)] {
            let table = table(planes, steps);
            let sum_sr: f64 = table.places().map(|(_, step)| table.solid_angle_sr(step)).sum();
            assert!((sum_sr / (4.0 * PI) - 1.0).abs() < 1e-12, "{planes} {steps}: {sum_sr}");
            for (index, (plane, step)) in table.places().enumerate() {
                assert_eq!(table.entry(plane, step), index);
                assert_eq!(
                    table.entry_towards(table.direction(plane, step)),
                    index,
                    "{planes} {steps}: {plane} {step}"
                );
            }
        }
    }

    #[test]
    fn directions_fall_into_the_nearest_cell() {
        let table = table(4, 18);
        let towards = |c_deg: f64, gamma_deg: f64| {
            let (sin_c, cos_c) = c_deg.to_radians().sin_cos();
            let (sin_gamma, cos_gamma) = gamma_deg.to_radians().sin_cos();
            let [c0, c90, axis] = table.frame;
            table.entry_towards(sin_gamma * (cos_c * c0 + sin_c * c90) + cos_gamma * axis)
        };
        assert_eq!(towards(170.0, 4.9), table.entry(0, 0));
        assert_eq!(towards(44.0, 5.1), table.entry(0, 1));
        assert_eq!(towards(46.0, 94.9), table.entry(1, 9));
        assert_eq!(towards(-46.0, 95.1), table.entry(3, 10));
        assert_eq!(towards(10.0, 179.0), table.entry(2, 18));
    }
}
