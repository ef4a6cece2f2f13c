//! The result of a run as Python sees it: maps as arrays, tables and summary as texts.

use std::path::PathBuf;
use std::sync::Mutex;

use luxmc::maps::MapKind;
use luxmc::output::result_files;
use luxmc::scene::{Quantity, ReceiverLayout, Side};
use luxmc::{MapResult, RunStory, SceneRun};
use numpy::{PyArray1, PyArray2, PyArray3, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};

use crate::failure::raised;

/// A solved run.
#[pyclass(frozen, module = "luxmc._core")]
pub struct Solution {
    run: SceneRun,
    solution: luxmc::Solution,
    story: RunStory,
    /// `summary.json` of the last time that files were written, or of a run without files.
    summary: Mutex<String>,
}

impl Solution {
    /// Keeps everything of a run.
    pub fn new(run: SceneRun, solution: luxmc::Solution, story: RunStory) -> Solution {
        let summary = text(&story.summary(run.scene(), &solution, Vec::new(), 0.0).bytes);
        Solution { run, solution, story, summary: Mutex::new(summary) }
    }
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

#[pymethods]
impl Solution {
    /// The program's exit code: 0 done, 3 target missed, 130 interrupted.
    #[getter]
    fn exit_code(&self) -> u8 {
        luxmc::cli::exit_of(&self.solution).number()
    }

    /// How the run ended, in the program's words.
    #[getter]
    fn closing_words(&self) -> String {
        let words = luxmc::cli::closing_lines(&self.solution, "", self.story.computed_s);
        words.trim_end().trim_end_matches("results in").trim_end().to_owned()
    }

    /// The table that the program prints.
    #[getter]
    fn table(&self) -> String {
        luxmc::cli::result_table(self.run.scene(), &self.solution)
    }

    /// Warnings of the scene and of the run.
    #[getter]
    fn warnings(&self) -> Vec<String> {
        self.run.scene().warnings.iter().chain(&self.solution.warnings).cloned().collect()
    }

    /// `summary.json`.
    #[getter]
    fn summary(&self) -> String {
        self.summary.lock().map_or_else(|_| String::new(), |summary| summary.clone())
    }

    /// The tables of the run by their file names.
    fn files<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let made = py.detach(|| result_files(self.run.scene(), &self.solution)).map_err(|error| raised(py, error))?;
        let files = PyDict::new(py);
        for file in made {
            files.set_item(file.name, PyBytes::new(py, &file.bytes))?;
        }
        Ok(files)
    }

    /// Writes the program's files into a directory.
    fn save(&self, py: Python<'_>, directory: PathBuf, plots: &str) -> PyResult<()> {
        let plots = luxmc::cli::plots_named(plots).map_err(|failure| raised(py, failure))?;
        let story = RunStory { plots: Some(plots), ..self.story.clone() };
        let saved = py.detach(|| story.save(self.run.scene(), &self.solution, &directory));
        let summary = saved.map_err(|failure| raised(py, failure))?;
        if let Ok(mut kept) = self.summary.lock() {
            *kept = text(&summary.bytes);
        }
        Ok(())
    }

    /// Names of the maps, elements first.
    #[getter]
    fn map_names(&self) -> Vec<String> {
        self.solution.maps.iter().map(|map| map.name.clone()).collect()
    }

    /// A map by its index: facts and arrays by their names.
    fn map<'py>(&self, py: Python<'py>, index: usize) -> PyResult<Bound<'py, PyDict>> {
        let found = self.solution.maps.get(index);
        let map = found.ok_or_else(|| pyo3::exceptions::PyIndexError::new_err("there is no such map"))?;
        let told = PyDict::new(py);
        told.set_item("name", &map.name)?;
        told.set_item("method", &map.method)?;
        told.set_item("bound", map.bound)?;
        told.set_item("target_met", map.target_met)?;
        told.set_item("estimated_error", map.error.estimated)?;
        told.set_item("random_error", map.error.random)?;
        told.set_item("bias", map.error.bias)?;
        told.set_item("discretisation_error", map.error.discretisation)?;
        values(py, map, &told)?;
        match map.kind {
            MapKind::Elements => self.elements(py, &told)?,
            MapKind::Receivers(set) => self.receivers(py, set, &told)?,
        }
        Ok(told)
    }
}

fn values<'py>(py: Python<'py>, map: &MapResult, told: &Bound<'py, PyDict>) -> PyResult<()> {
    let column = |numbers: &[f64]| PyArray1::from_slice(py, numbers);
    let half = |which: usize| {
        (!map.values.halves.is_empty())
            .then(|| PyArray1::from_iter(py, map.values.halves.iter().map(|halves| halves[which])))
    };
    told.set_item("value", column(&map.values.value))?;
    told.set_item("standard_error", column(&map.values.standard_error))?;
    told.set_item("direct", column(&map.values.direct))?;
    told.set_item("indirect", column(&map.values.indirect))?;
    told.set_item("even", half(0))?;
    told.set_item("odd", half(1))
}

/// A table with three numbers per row.
fn triples<'py>(py: Python<'py>, rows: Vec<[f64; 3]>) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let count = rows.len();
    PyArray1::from_vec(py, rows.into_flattened()).reshape([count, 3])
}

impl Solution {
    fn receivers<'py>(&self, py: Python<'py>, set: usize, told: &Bound<'py, PyDict>) -> PyResult<()> {
        let set = &self.run.scene().receivers[set];
        let (kind, shape) = match set.layout {
            ReceiverLayout::Grid { columns, rows, .. } => ("grid", Some((rows, columns))),
            ReceiverLayout::View { columns, rows, .. } => ("view", Some((rows, columns))),
            ReceiverLayout::Fan { .. } => ("fan", None),
            ReceiverLayout::Points => ("points", None),
            ReceiverLayout::Part(_) => ("part", None), // of a run for a part of the receivers
            ReceiverLayout::Towards { .. } => ("elements of a surface", None),
            ReceiverLayout::Intensity(_) => ("intensity", None),
        };
        told.set_item("kind", kind)?;
        told.set_item("shape", shape)?;
        told.set_item("quantity", set.quantity.name())?;
        told.set_item("unit", set.quantity.unit())?;
        let places = set.points.iter().map(|point| [point.position_m.x, point.position_m.y, point.position_m.z]);
        told.set_item("positions", triples(py, places.collect())?)?;
        let normals = set.points.iter().map(|point| [point.normal.x, point.normal.y, point.normal.z]);
        told.set_item("normals", triples(py, normals.collect())?)?;
        told.set_item("inside", PyArray1::from_iter(py, set.points.iter().map(|point| point.inside)))?;
        told.set_item("weights", PyArray1::from_iter(py, set.points.iter().map(|point| point.weight)))
    }

    fn elements<'py>(&self, py: Python<'py>, told: &Bound<'py, PyDict>) -> PyResult<()> {
        let (scene, elements) = (self.run.scene(), &self.solution.elements);
        told.set_item("kind", "elements")?;
        told.set_item("shape", py.None())?;
        told.set_item("quantity", Quantity::Perpendicular.name())?;
        told.set_item("unit", "lx")?;
        let count = elements.len();
        let (mut places, mut normals, mut corners) = (Vec::with_capacity(count), Vec::with_capacity(count), Vec::new());
        let (mut areas, mut surfaces) = (Vec::with_capacity(count), Vec::with_capacity(count));
        let mut backs = Vec::with_capacity(count);
        for index in 0..count {
            let element = elements.element(index as u32);
            let [a, b, c] = elements.corners_m(scene, element);
            let centroid = (a + b + c) / 3.0;
            places.push([centroid.x, centroid.y, centroid.z]);
            let front = scene.triangle_normal(element.triangle);
            let normal = if element.side == Side::Front { front } else { -front };
            normals.push([normal.x, normal.y, normal.z]);
            corners.extend([a, b, c].map(|corner| [corner.x, corner.y, corner.z]));
            areas.push(elements.area_m2(scene, element));
            surfaces.push(scene.triangle_surfaces[element.triangle as usize]);
            backs.push(element.side == Side::Back);
        }
        told.set_item("positions", triples(py, places)?)?;
        told.set_item("normals", triples(py, normals)?)?;
        let corners: Bound<'py, PyArray3<f64>> =
            PyArray1::from_vec(py, corners.into_flattened()).reshape([count, 3, 3])?;
        told.set_item("corners", corners)?;
        told.set_item("weights", PyArray1::from_vec(py, areas))?;
        told.set_item("surface_numbers", PyArray1::from_vec(py, surfaces))?;
        let names: Vec<&str> = scene.surfaces.iter().map(|surface| surface.name.as_str()).collect();
        told.set_item("surface_names", names)?;
        told.set_item("is_back", PyArray1::from_vec(py, backs))
    }
}
