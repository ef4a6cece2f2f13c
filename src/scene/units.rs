//! Length units of a scene file.

use glam::DVec3;

/// The unit of all lengths of a scene file and of the OBJ and point files that it names.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct LengthUnit {
    pub name: &'static str,
    numerator: f64,
    denominator: f64,
}

/// Names of the units, as files write them.
pub(crate) const UNIT_NAMES: [&str; 5] = ["m", "mm", "cm", "in", "ft"];

impl LengthUnit {
    /// The unit with an index in [`UNIT_NAMES`].
    pub fn of(index: usize) -> LengthUnit {
        // Fractions of whole numbers: 2700 mm then become the same double as 2.7 m.
        let (numerator, denominator) =
            [(1.0, 1.0), (1.0, 1000.0), (1.0, 100.0), (127.0, 5000.0), (381.0, 1250.0)][index];
        LengthUnit { name: UNIT_NAMES[index], numerator, denominator }
    }

    /// Converts a length to m.
    pub fn length_m(self, length: f64) -> f64 {
        length * self.numerator / self.denominator
    }

    /// Converts a point to m.
    pub fn point_m(self, point: DVec3) -> DVec3 {
        point * self.numerator / self.denominator
    }

    /// Converts a point in m to the unit.
    pub fn point_of_m(self, point_m: DVec3) -> DVec3 {
        point_m * self.denominator / self.numerator
    }

    /// Converts an area to m².
    pub fn area_m2(self, area: f64) -> f64 {
        self.length_m(self.length_m(area))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whole_millimetres_are_the_doubles_that_decimals_are() {
        for millimetres in 1..20_000 {
            let written: f64 = format!("{}.{:03}", millimetres / 1000, millimetres % 1000).parse().expect("a number");
            assert_eq!(LengthUnit::of(1).length_m(f64::from(millimetres)), written);
        }
    }

    #[test]
    fn an_inch_is_25_4_mm_and_a_foot_is_304_8_mm() {
        assert_eq!(LengthUnit::of(3).length_m(1.0), 0.0254);
        assert_eq!(LengthUnit::of(4).length_m(1.0), 0.3048);
    }
}
