//! Refusals as Python's exceptions. Each exit code of the program has its own class.

use pyo3::prelude::*;

/// Module that contains the classes of exceptions.
const ERRORS: &str = "luxmc._errors";

/// An exception of the class for a failure's exit code, with the program's message.
pub fn raised(py: Python<'_>, failure: impl Into<luxmc::Failure>) -> PyErr {
    let failure = failure.into();
    let class = match failure.exit().number() {
        4 => "UnwrittenError",
        _ => "RefusedError",
    };
    let made = py.import(ERRORS).and_then(|errors| errors.getattr(class)?.call1((failure.to_string(),)));
    made.map_or_else(|error| error, PyErr::from_value)
}
