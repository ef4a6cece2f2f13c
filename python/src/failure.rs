//! Refusals as Python's exceptions, one class an exit code of the program.

use pyo3::prelude::*;

/// Where the classes of exceptions are.
const ERRORS: &str = "luxmc._errors";

/// An exception of the class that belongs to a failure's exit code, with the program's words.
pub fn raised(py: Python<'_>, failure: impl Into<luxmc::Failure>) -> PyErr {
    let failure = failure.into();
    let class = match failure.exit().number() {
        4 => "UnwrittenError",
        _ => "RefusedError",
    };
    let made = py.import(ERRORS).and_then(|errors| errors.getattr(class)?.call1((failure.to_string(),)));
    made.map_or_else(|error| error, PyErr::from_value)
}
