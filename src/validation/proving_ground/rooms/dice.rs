//! The random choices for a room: the same for the same kind and seed on every machine.

use std::f64::consts::TAU;

use glam::DVec3;
use rand_philox::splitmix64;

/// Step of the counter between two draws: the odd number closest to 2⁶⁴ over the golden ratio.
const STEP: u64 = 0x9E37_79B9_7F4A_7C15;
/// Spacing of the variates: 2⁻⁵³.
const SPACING: f64 = 1.0 / 9_007_199_254_740_992.0;
/// Lengths, shares and angles are rounded to this, so that files are short and readable.
const GRAIN: f64 = 1e-3;

/// A sequence of random choices.
#[derive(Clone, Debug)]
pub struct Dice {
    counter: u64,
}

impl Dice {
    /// The choices for one kind and seed. Different kinds have independent choices.
    pub fn new(kind: &str, seed: u64) -> Dice {
        let key = kind.bytes().fold(splitmix64(seed ^ STEP), |key, letter| splitmix64(key ^ u64::from(letter)));
        Dice { counter: key }
    }

    /// A uniform variate in [0, 1).
    pub fn unit(&mut self) -> f64 {
        self.counter = self.counter.wrapping_add(STEP);
        (splitmix64(self.counter) >> 11) as f64 * SPACING
    }

    /// A uniform number between two others, rounded to a thousandth.
    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        rounded(low + (high - low) * self.unit())
    }

    /// A number between two others with uniformly distributed logarithm.
    pub fn log_between(&mut self, low: f64, high: f64) -> f64 {
        low * (high / low).powf(self.unit())
    }

    /// A whole number between two others, both included.
    pub fn count(&mut self, low: usize, high: usize) -> usize {
        low + (self.unit() * (high - low + 1) as f64) as usize
    }

    /// Returns `true` with this probability.
    pub fn chance(&mut self, probability: f64) -> bool {
        self.unit() < probability
    }

    /// A unit vector with uniformly distributed direction.
    pub fn direction(&mut self) -> DVec3 {
        let z = 2.0 * self.unit() - 1.0;
        let angle = TAU * self.unit();
        let radius = (1.0 - z * z).sqrt();
        DVec3::new(radius * angle.cos(), radius * angle.sin(), z)
    }

    /// A random element of a list.
    pub fn one_of<'a, T>(&mut self, things: &'a [T]) -> &'a T {
        &things[self.count(0, things.len() - 1)]
    }
}

/// Rounds a number to a thousandth.
pub fn rounded(value: f64) -> f64 {
    // Division gives the f64 nearest to the decimal number, which files then show with three digits.
    (value / GRAIN).round() / (1.0 / GRAIN).round()
}
