//! A value together with the rays that were traced for it.

use std::ops::{Add, AddAssign, Div, Mul};

/// What rays have found, and how many there were. Sums and multiples of values keep count of all rays.
#[derive(Clone, Copy, Debug, Default)]
pub struct Traced {
    /// One sample, or another result of these rays, in the unit of the quantity that is estimated.
    pub value: f64,
    /// Number of rays traced for the value.
    pub rays: u64,
}

impl Add for Traced {
    type Output = Traced;

    #[inline]
    fn add(self, other: Traced) -> Traced {
        Traced { value: self.value + other.value, rays: self.rays + other.rays }
    }
}

impl AddAssign for Traced {
    #[inline]
    fn add_assign(&mut self, other: Traced) {
        *self = *self + other;
    }
}

impl Mul<Traced> for f64 {
    type Output = Traced;

    #[inline]
    fn mul(self, traced: Traced) -> Traced {
        Traced { value: self * traced.value, ..traced }
    }
}

impl Div<f64> for Traced {
    type Output = Traced;

    #[inline]
    fn div(self, divisor: f64) -> Traced {
        Traced { value: self.value / divisor, ..self }
    }
}
