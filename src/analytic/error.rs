//! The error for invalid input to an exact solution.

use thiserror::Error;

/// A quantity for which an exact solution is not defined.
#[derive(Clone, Debug, Error, PartialEq)]
#[error("{what} is {got}, expected {expected}; {remedy}")]
pub struct AnalyticError {
    /// The quantity, in words.
    pub what: String,
    /// The given value.
    pub got: String,
    /// The valid range.
    pub expected: String,
    /// What the user can do about it.
    pub remedy: String,
}

/// Refuses a value unless `holds` is true. Callers write conditions that are false for NaN.
pub(crate) fn require(holds: bool, what: &str, got: f64, expected: &str, remedy: &str) -> Result<(), AnalyticError> {
    if holds {
        return Ok(());
    }
    Err(AnalyticError {
        what: what.to_string(),
        got: got.to_string(),
        expected: expected.to_string(),
        remedy: remedy.to_string(),
    })
}

/// Refuses a reflectance outside 0 to 1.
pub(crate) fn require_reflectance(what: &str, reflectance: f64) -> Result<(), AnalyticError> {
    require(
        (0.0..=1.0).contains(&reflectance),
        what,
        reflectance,
        "a reflectance from 0 to 1",
        "give the share of the light that is reflected",
    )
}

/// Refuses a length that is not positive and finite.
pub(crate) fn require_length(what: &str, length_m: f64) -> Result<(), AnalyticError> {
    require(
        length_m > 0.0 && length_m.is_finite(),
        what,
        length_m,
        "a positive finite length",
        "give the length in metres",
    )
}

/// Refuses a photometric quantity that is negative or not finite.
pub(crate) fn require_light(what: &str, quantity: f64) -> Result<(), AnalyticError> {
    require(
        quantity >= 0.0 && quantity.is_finite(),
        what,
        quantity,
        "a finite quantity of at least 0",
        "give the emitted light as a non-negative number",
    )
}
