//! Reads receivers of type `intensity`: the far-field intensity distribution of all that leaves a scene, in C planes.

use std::f64::consts::{PI, TAU};

use glam::DVec3;

use super::error::SceneError;
use super::grid_frame::refuse_too_many;
use super::model::{Quantity, ReceiverLayout, ReceiverPoint};
use super::reader::{Fields, Node};
use super::units::LengthUnit;
use super::vectors::photometric_frame;

/// Keys of such a receiver.
pub(super) const KEYS: &[&str] =
    &["name", "type", "aim", "rotation_deg", "c_planes", "gamma_step_deg", "luminous_opening"];

/// C planes and step of γ where a scene does not say.
const USUAL_PLANES: u32 = 24;
const USUAL_STEP_DEG: f64 = 5.0;
/// Steps of γ from 0 to 180°, at least and at most.
const FEWEST_STEPS: f64 = 4.0;
const MOST_STEPS: f64 = 360.0;
/// C planes at most.
const MOST_PLANES: u32 = 720;
/// Extents of a luminous opening that photometric files may have, in m.
const LARGEST_OPENING_M: f64 = 100.0;
/// How far 180° may be off a whole number of steps.
const ROUNDING: f64 = 1e-9;

/// The directions of an intensity distribution: planes through its axis, evenly turned, and angles γ from the axis, evenly spaced.
///
/// Every direction stands for a cell of the sphere about it. At both ends of the axis all planes share one entry. A single plane
/// stands for all: the distribution is then the mean over C.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct IntensityTable {
    /// C planes.
    pub planes: u32,
    /// Steps of γ from 0 to 180°.
    pub steps: u32,
    /// Unit vectors of C0 (γ = 90°), C90 (γ = 90°) and γ = 0.
    pub frame: [DVec3; 3],
    /// What the files say of the luminous opening: extents in m along C0–C180, C90–C270 and the axis.
    pub opening_m: [f64; 3],
}

impl IntensityTable {
    /// Number of entries: one for each end of the axis, and one for every plane at each γ between.
    pub fn entries(&self) -> usize {
        2 + self.planes as usize * (self.steps as usize - 1)
    }

    /// The entry of a plane and a step of γ.
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

    /// The entry whose cell a unit direction lies in.
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

    /// Solid angle in sr of the cell of an entry at a step of γ.
    pub fn solid_angle_sr(&self, step: u32) -> f64 {
        let half = 0.5 * PI / f64::from(self.steps);
        let gamma = PI * f64::from(step) / f64::from(self.steps);
        match step {
            0 => TAU * 2.0 * (0.5 * half).sin().powi(2),
            step if step >= self.steps => TAU * 2.0 * (0.5 * half).sin().powi(2),
            _ => TAU / f64::from(self.planes) * 2.0 * gamma.sin() * half.sin(),
        }
    }

    /// Plane and step of every entry, in order.
    pub fn places(&self) -> impl Iterator<Item = (u32, u32)> + '_ {
        let between = (1..self.steps).flat_map(|step| (0..self.planes).map(move |plane| (plane, step)));
        std::iter::once((0, 0)).chain(between).chain(std::iter::once((0, self.steps)))
    }

    /// The axis about which a single plane that stands for all is turned.
    pub fn turned_about(&self) -> Option<DVec3> {
        (self.planes == 1).then_some(self.frame[2])
    }
}

/// What such a receiver asks for, its directions, and a point for each; `most` is how many there may be.
pub(super) fn read(
    fields: &Fields,
    unit: LengthUnit,
    most: u64,
) -> Result<(Quantity, ReceiverLayout, Vec<ReceiverPoint>), SceneError> {
    let aim = fields.get("aim").map_or(Ok(-DVec3::Z), |node| node.direction())?;
    let rotation_deg = fields.get("rotation_deg").map_or(Ok(0.0), |node| node.number())?;
    let planes_node = fields.get("c_planes");
    let planes = planes_node.as_ref().map_or(Ok(USUAL_PLANES), |node| node.count("the number of C planes"))?;
    if let Some(node) = planes_node.as_ref().filter(|_| planes > MOST_PLANES) {
        return Err(node.refuse("too many C planes", format!("at most {MOST_PLANES}"), "24 are usual"));
    }
    let steps = fields.get("gamma_step_deg").map_or(Ok((180.0 / USUAL_STEP_DEG) as u32), |node| read_steps(&node))?;
    let opening_m = fields.get("luminous_opening").map_or(Ok([0.0; 3]), |node| read_opening(&node, unit))?;
    let table = IntensityTable { planes, steps, frame: photometric_frame(aim, rotation_deg), opening_m };
    if table.entries() as u64 > most {
        return Err(refuse_too_many(fields.node(), table.entries() as u64));
    }
    let point = |(plane, step): (u32, u32)| ReceiverPoint {
        position_m: DVec3::ZERO,
        normal: table.direction(plane, step),
        weight: table.solid_angle_sr(step),
        inside: false,
    };
    let points = table.places().map(point).collect();
    Ok((Quantity::Intensity { turned_about: table.turned_about() }, ReceiverLayout::Intensity(table), points))
}

fn read_steps(node: &Node) -> Result<u32, SceneError> {
    let step_deg = node.above_zero("the step of gamma")?;
    let steps = 180.0 / step_deg;
    if (steps - steps.round()).abs() > ROUNDING * steps || !(FEWEST_STEPS..=MOST_STEPS).contains(&steps.round()) {
        let expected = format!("a whole part of 180°, from {} to {}", 180.0 / MOST_STEPS, 180.0 / FEWEST_STEPS);
        return Err(node.refuse("no such step of gamma", expected, "5 is usual, 2.5 or 1 for narrow beams"));
    }
    Ok(steps.round() as u32)
}

fn read_opening(node: &Node, unit: LengthUnit) -> Result<[f64; 3], SceneError> {
    let extents = node.items("extents")?;
    let [c0, c90, height] = &extents[..] else {
        let expected = "three extents: along C0–C180, along C90–C270, and the height";
        return Err(node.refuse_as(
            "a luminous opening",
            format!("{} numbers", extents.len()),
            expected,
            "[0.6, 0.3, 0]",
        ));
    };
    let extent_m = |node: &Node| {
        let extent_m = unit.length_m(node.at_least_zero("an extent")?);
        if extent_m > LARGEST_OPENING_M {
            let expected = format!("at most {LARGEST_OPENING_M} m");
            return Err(node.refuse("an opening that photometric files cannot have", expected, "check the unit"));
        }
        Ok(extent_m)
    };
    Ok([extent_m(c0)?, extent_m(c90)?, extent_m(height)?])
}

#[cfg(test)]
mod tests {
    use super::*;

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
