//! The native part of luxmc's Python package: scenes, runs and results as Python objects. The convenient interface of the package is
//! written in Python, in `luxmc/`. The library computes.

mod failure;
mod progress;
mod result;
mod scene;
mod solve;
mod words;

use pyo3::prelude::*;

/// The module `luxmc._core`.
#[pymodule]
mod _core {
    #[pymodule_export]
    use super::result::Solution;
    #[pymodule_export]
    use super::scene::Scene;
    #[pymodule_export]
    use super::solve::solve;
    #[pymodule_export]
    use super::words::{photometry, schema, sobolev};

    use super::*;

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }
}
