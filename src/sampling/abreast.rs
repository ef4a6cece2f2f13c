//! Loops over eight numbers, which the compiler turns into one vector of eight.

/// Number of values that are computed at a time.
pub const ABREAST: usize = 8;

/// Returns the larger one in one instruction, because neither is a NaN.
#[inline(always)]
pub fn larger(one: f32, other: f32) -> f32 {
    if one > other { one } else { other }
}

/// Returns the smaller one in the same way.
#[inline(always)]
pub fn smaller(one: f32, other: f32) -> f32 {
    if one < other { one } else { other }
}
