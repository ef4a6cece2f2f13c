//! Scenes, read from files or from text.

use std::path::{Path, PathBuf};
use std::time::Instant;

use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;

use crate::failure::raised;

/// A scene that was read and is valid.
#[pyclass(frozen, module = "luxmc._core")]
pub struct Scene {
    pub scene: luxmc::Scene,
    /// Name in messages and files.
    #[pyo3(get)]
    pub name: String,
    /// Seconds that reading took.
    pub read_s: f64,
}

#[pymethods]
impl Scene {
    /// Reads a scene file.
    #[staticmethod]
    fn load(py: Python<'_>, path: PathBuf) -> PyResult<Scene> {
        let started = Instant::now();
        let scene = py.detach(|| luxmc::read_scene(&path)).map_err(|error| raised(py, error))?;
        Ok(Scene { scene, name: path.display().to_string(), read_s: started.elapsed().as_secs_f64() })
    }

    /// Reads the text of a scene file. Files that it names are relative to `folder`.
    #[staticmethod]
    fn from_json(py: Python<'_>, text: &str, base_dir: PathBuf, name: String) -> PyResult<Scene> {
        let started = Instant::now();
        let read = py.detach(|| luxmc::scene_from_json(text, Some(Path::new(&name)), &base_dir));
        let scene = read.map_err(|error| raised(py, error))?;
        Ok(Scene { scene, name, read_s: started.elapsed().as_secs_f64() })
    }

    /// The scene's title.
    #[getter]
    fn title(&self) -> &str {
        &self.scene.title
    }

    /// Warnings of the reader for the user.
    #[getter]
    fn warnings(&self) -> Vec<String> {
        self.scene.warnings.clone()
    }

    /// Names of the receiver sets.
    #[getter]
    fn receivers(&self) -> Vec<String> {
        self.scene.receivers.iter().map(|set| set.name.clone()).collect()
    }

    /// Names of the surfaces.
    #[getter]
    fn surfaces(&self) -> Vec<String> {
        self.scene.surfaces.iter().map(|surface| surface.name.clone()).collect()
    }

    /// Names of the luminaires.
    #[getter]
    fn luminaires(&self) -> Vec<String> {
        self.scene.luminaires.iter().map(|luminaire| luminaire.name.clone()).collect()
    }

    /// The output of `luxmc inspect --json`, as JSON.
    fn inspect(&self, py: Python<'_>) -> PyResult<String> {
        let told = py.detach(|| serde_json::to_string(&luxmc::check::inspect(&self.scene)));
        told.map_err(|error| PyRuntimeError::new_err(error.to_string()))
    }
}
