//! Exact solutions, photometric files and the scene file's schema.

use std::path::PathBuf;

use luxmc::analytic::sobolev::sobolev_at_radii;
use luxmc::scene::photometry::read_photometric_file;
use luxmc::{SobolevPlane, SobolevProblem};
use numpy::{PyArray1, PyReadonlyArray1};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::failure::raised;

/// Columns of numbers, as Python gets them.
type Columns<'py> = Vec<Bound<'py, PyArray1<f64>>>;

/// Direct, reflected and total illuminance and the error of the exact solution between two planes.
#[pyfunction]
pub fn sobolev<'py>(
    py: Python<'py>,
    h1: f64,
    rho1: f64,
    rho2: f64,
    r: PyReadonlyArray1<'py, f64>,
    plane: u32,
) -> PyResult<Columns<'py>> {
    let plane = match plane {
        1 => SobolevPlane::One,
        2 => SobolevPlane::Two,
        _ => return Err(PyValueError::new_err("write 1 or 2 for the plane")),
    };
    let radii: Vec<f64> = r.as_array().to_vec();
    let problem = SobolevProblem { h1, rho1, rho2 };
    let found = py.detach(|| sobolev_at_radii(&problem, plane, &radii)).map_err(|error| raised(py, error))?;
    let column = |of: fn(&luxmc::analytic::sobolev::SobolevValue) -> f64| PyArray1::from_iter(py, found.iter().map(of));
    Ok(vec![
        column(|value| value.direct_lx),
        column(|value| value.reflected_lx),
        column(|value| value.total_lx),
        column(|value| value.estimated_error_lx),
    ])
}

/// A photometric file: the output of `luxmc inspect --json`, and its intensities, plane by plane.
#[pyfunction]
pub fn photometry(py: Python<'_>, path: PathBuf) -> PyResult<(String, Bound<'_, PyArray1<f64>>)> {
    let file = py.detach(|| read_photometric_file(&path)).map_err(|error| raised(py, error))?;
    let facts = luxmc::cli::photometric_json(&file).to_string();
    Ok((facts, PyArray1::from_slice(py, &file.web.intensity_cd)))
}

/// The JSON Schema of the scene file.
#[pyfunction]
pub fn schema() -> String {
    luxmc::scene::scene_schema().to_string()
}
