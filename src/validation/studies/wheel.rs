//! The numbers that place things in scenes made for studies and examples.

/// A fixed sequence of numbers in [0, 1), so that the scenes are always the same.
pub struct Wheel(pub u64);

impl Wheel {
    /// Returns the next number.
    pub fn turn(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 40) as f64 / (1u64 << 24) as f64
    }
}
