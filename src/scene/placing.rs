//! Placement of geometry: a scale, three rotations and a shift.

use glam::{DMat3, DVec3};

use super::error::SceneError;
use super::keys::{ABOVE_ZERO, Form, VECTOR, form, optional};
use super::reader::Node;

/// Keys of a transform.
#[rustfmt::skip]
pub(super) const FORM: Form = form("Transform", "p′ = T·R_z·R_y·R_x·s·p.", &[&[
    optional("scale", ABOVE_ZERO, "Scale, applied first."),
    optional("rotate_deg", VECTOR, "Rotations about the fixed x, y and z axes in degrees, counter-clockwise seen from the axis' tip."),
    optional("translate", VECTOR, "Translation, applied last."),
]]);

/// A placement p′ = T·R_z·R_y·R_x·s·p, in the file's unit.
#[derive(Clone, Copy, Debug)]
pub(super) struct Placing {
    /// s: factor of all lengths.
    pub scale: f64,
    linear: DMat3,
    translate: DVec3,
}

impl Placing {
    /// Placement that changes nothing.
    pub const HERE: Placing = Placing { scale: 1.0, linear: DMat3::IDENTITY, translate: DVec3::ZERO };

    /// Reads a `transform`.
    pub fn read(node: &Node) -> Result<Placing, SceneError> {
        let fields = node.object("a transform", &FORM)?;
        let scale = fields.get("scale").map_or(Ok(1.0), |node| node.amount("the scale"))?;
        let angles = fields.get("rotate_deg").map_or(Ok(DVec3::ZERO), |node| node.vector())?;
        let translate = fields.get("translate").map_or(Ok(DVec3::ZERO), |node| node.vector())?;
        Ok(Placing { scale, linear: turns(angles) * scale, translate })
    }

    /// The rotations alone.
    pub fn turn(&self) -> DMat3 {
        self.linear * self.scale.recip()
    }

    /// Applies the placement to a point.
    pub fn apply(&self, point: DVec3) -> DVec3 {
        self.linear * point + self.translate
    }
}

/// R_z·R_y·R_x: rotations about the fixed axes, counter-clockwise as seen from the axis' tip.
fn turns(angles_deg: DVec3) -> DMat3 {
    let [x, y, z] = angles_deg.to_array().map(sin_cos_deg);
    let about_x = DMat3::from_cols(DVec3::X, DVec3::new(0.0, x.1, x.0), DVec3::new(0.0, -x.0, x.1));
    let about_y = DMat3::from_cols(DVec3::new(y.1, 0.0, -y.0), DVec3::Y, DVec3::new(y.0, 0.0, y.1));
    let about_z = DMat3::from_cols(DVec3::new(z.1, z.0, 0.0), DVec3::new(-z.0, z.1, 0.0), DVec3::Z);
    about_z * about_y * about_x
}

/// Sine and cosine of an angle in degrees. They are exact for quarter turns, so that boxes turned by 90° still meet.
pub(super) fn sin_cos_deg(angle_deg: f64) -> (f64, f64) {
    let quarter = angle_deg / 90.0;
    if quarter.fract() != 0.0 {
        return (angle_deg % 360.0).to_radians().sin_cos();
    }
    match quarter.rem_euclid(4.0) as u8 {
        0 => (0.0, 1.0),
        1 => (1.0, 0.0),
        2 => (0.0, -1.0),
        _ => (-1.0, 0.0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn turns_are_counter_clockwise_seen_from_the_tip_and_x_comes_first() {
        assert_eq!(turns(DVec3::new(90.0, 0.0, 0.0)) * DVec3::Y, DVec3::Z);
        assert_eq!(turns(DVec3::new(0.0, 90.0, 0.0)) * DVec3::Z, DVec3::X);
        assert_eq!(turns(DVec3::new(0.0, 0.0, 90.0)) * DVec3::X, DVec3::Y);
        // A turn about x takes y to z, and a turn about y takes z to x.
        assert_eq!(turns(DVec3::new(90.0, 90.0, 0.0)) * DVec3::Y, DVec3::X);
        assert_eq!(turns(DVec3::new(0.0, -270.0, 450.0)) * DVec3::Z, DVec3::Y);
    }

    #[test]
    fn any_turn_keeps_lengths_and_handedness() {
        let matrix = turns(DVec3::new(12.0, 345.0, -1000.0));
        assert!((matrix.determinant() - 1.0).abs() < 1e-14);
        assert!(
            (matrix * matrix.transpose() - DMat3::IDENTITY).to_cols_array().iter().all(|entry| entry.abs() < 1e-15)
        );
    }
}
