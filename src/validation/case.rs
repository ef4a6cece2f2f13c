//! A validation case read from its folder: a scene, its runs, and what is compared with which reference (truth).

use std::path::{Path, PathBuf};

use serde::Deserialize;
use serde::de::DeserializeOwned;
use serde_json::{Map, Value};

use super::comparison::{Comparison, ELEMENT_MAP, What};
use super::error::CaseError;
use super::exact::LightPart;
use super::fields::{Fraction, fill_in, read_text};
use super::run_method::{RunMethod, indirect_form, method_names};
use super::truth::Truth;
use super::truth_room::RoomCache;
use crate::check::scene_from_json;
use crate::methods::MeshChoice;
use crate::scene::{Scene, SceneError};

/// The file that marks a folder as a case.
pub const CASE_FILE: &str = "case.json";

/// A case, read and checked. Every run has its scene and its comparisons.
#[derive(Debug)]
pub struct Case {
    /// The folder's name.
    pub name: String,
    /// Path of the folder.
    pub folder: PathBuf,
    /// One line for the heading.
    pub title: String,
    /// The physics in two sentences.
    pub physics: String,
    /// Further remarks for the reader, such as where a published table is wrong.
    pub remarks: Vec<String>,
    /// Sources of the truth and of the geometry.
    pub sources: Vec<String>,
    /// Groups that the case belongs to.
    pub groups: Vec<String>,
    /// The runs in order, at least one.
    pub runs: Vec<CaseRun>,
    /// Index of the run on which `luxmc compare` climbs its ladder.
    pub ladder_run: usize,
    /// Cache of rooms that its truths have solved.
    pub(super) rooms: RoomCache,
}

/// One scene with settings, and what is compared after the run.
#[derive(Debug)]
pub struct CaseRun {
    /// Name in tables.
    pub name: String,
    /// The scene.
    pub scene: Scene,
    /// Seed of the random numbers.
    pub seed: u64,
    /// Target for the stated error, if the run has one.
    pub target_error: Option<f64>,
    /// Number of chains for every map, if fixed.
    pub chains: Option<u64>,
    /// Time limit in s.
    pub time_limit_s: Option<f64>,
    /// Method, if the run names one; otherwise forward chains and walks.
    pub method: Option<RunMethod>,
    /// What is compared.
    pub comparisons: Vec<Comparison>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct CaseFile {
    title: String,
    physics: String,
    #[serde(default)]
    remarks: Vec<String>,
    #[serde(default)]
    sources: Vec<String>,
    groups: Vec<String>,
    scene: Option<Value>,
    scene_file: Option<String>,
    runs: Vec<RunSpec>,
    compare: Vec<Value>,
    ladder_run: Option<String>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RunSpec {
    name: String,
    #[serde(default)]
    with: Map<String, Value>,
    #[serde(default)]
    seed: u64,
    target_error: Option<Fraction>,
    chains: Option<u64>,
    time_limit_s: Option<f64>,
    method: Option<String>,
    mesh_step_m: Option<f64>,
    mesh_radius_m: Option<f64>,
    mesh_indirect: Option<String>,
}

impl Case {
    /// Reads the case in a folder.
    ///
    /// # Errors
    ///
    /// Anything missing, malformed or unknown in the case, its scene or its reference. The error names a remedy.
    pub fn read(folder: &Path) -> Result<Case, CaseError> {
        let path = folder.join(CASE_FILE);
        let text = read_text(&path, "the case cannot be read")?;
        let value: Value = serde_json::from_str(&text).map_err(|error| {
            CaseError::new(
                &path,
                "the case is not valid JSON",
                error.to_string(),
                "a JSON object",
                "correct the named place",
            )
        })?;
        Case::of_value(folder_name(folder), folder, &path, value)
    }

    /// Builds a case from its JSON. `folder` contains the files that it names; `path` appears in errors.
    pub(super) fn of_value(name: String, folder: &Path, path: &Path, value: Value) -> Result<Case, CaseError> {
        let file: CaseFile = typed(path, "", value)?;
        check_file(path, &file)?;
        let scene_text = match (&file.scene, &file.scene_file) {
            (Some(scene), None) => scene.clone(),
            (None, Some(name)) => {
                let scene_path = folder.join(name);
                let text = read_text(&scene_path, "the scene of the case cannot be read")?;
                serde_json::from_str(&text).map_err(|error| {
                    let remedy = "correct the named place";
                    CaseError::new(&scene_path, "the scene is not valid JSON", error.to_string(), "a scene", remedy)
                })?
            }
            _ => {
                let expected = "either \"scene\" or \"scene_file\"";
                return Err(CaseError::new(
                    path,
                    "a case needs one scene",
                    "none or two",
                    expected,
                    "give one of them",
                ));
            }
        };
        let base_dir = file.scene_file.as_ref().map_or_else(
            || folder.to_path_buf(),
            |name| folder.join(name).parent().map_or_else(|| folder.to_path_buf(), Path::to_path_buf),
        );
        let runs = file
            .runs
            .iter()
            .map(|run| read_run(path, folder, &base_dir, run, &scene_text, &file.compare))
            .collect::<Result<Vec<_>, _>>()?;
        let ladder_run = match &file.ladder_run {
            None => 0,
            Some(name) => runs.iter().position(|run| run.name == *name).ok_or_else(|| {
                let expected = "the name of one of the runs";
                CaseError::new(path, "\"ladder_run\" does not name a run", name.as_str(), expected, "correct the name")
            })?,
        };
        Ok(Case {
            name,
            folder: folder.to_path_buf(),
            title: file.title,
            physics: file.physics,
            remarks: file.remarks,
            sources: file.sources,
            groups: file.groups,
            runs,
            ladder_run,
            rooms: RoomCache::default(),
        })
    }
}

/// Name of a folder; for `.` its real name.
pub fn folder_name(folder: &Path) -> String {
    let real = folder.canonicalize().unwrap_or_else(|_| folder.to_path_buf());
    real.file_name().map_or_else(|| "case".to_owned(), |name| name.to_string_lossy().into_owned())
}

fn typed<T: DeserializeOwned>(path: &Path, place: &str, value: Value) -> Result<T, CaseError> {
    serde_path_to_error::deserialize(value).map_err(|error| {
        let inner = error.path().to_string();
        let place = match (place, inner.as_str()) {
            (place, ".") => place.to_owned(),
            ("", inner) => inner.to_owned(),
            (place, inner) => format!("{place}.{inner}"),
        };
        let what =
            if place.is_empty() { "a malformed case".to_owned() } else { format!("a malformed case, at {place}") };
        let got = error.into_inner().to_string();
        CaseError::new(path, what, got, "the form that docs/validation.md describes", "correct this place of the case")
    })
}

fn check_file(path: &Path, file: &CaseFile) -> Result<(), CaseError> {
    let refuse =
        |what: &str, got: String, expected: &str| Err(CaseError::new(path, what, got, expected, "correct the case"));
    if file.runs.is_empty() || file.compare.is_empty() {
        return refuse(
            "a case without runs or comparisons shows nothing",
            "an empty list".into(),
            "at least one of each",
        );
    }
    if file.title.trim().is_empty() || file.physics.trim().is_empty() {
        return refuse(
            "a case needs a title and a description for its reader",
            "an empty text".into(),
            "a title and the physics",
        );
    }
    for (index, run) in file.runs.iter().enumerate() {
        if file.runs[..index].iter().any(|other| other.name == run.name) {
            return refuse("two runs have the same name", run.name.clone(), "a name for each run");
        }
        if run.target_error.is_none() && run.chains.is_none() && run.mesh_step_m.is_none() {
            let got = format!("run \"{}\" has neither", run.name);
            return refuse("a run needs \"target_error\" or \"chains\"", got, "one of them, or both (or a mesh step)");
        }
        if run.time_limit_s.is_some_and(|limit_s| limit_s.is_nan() || limit_s <= 0.0) {
            return refuse("a time limit must be above 0", format!("{:?}", run.time_limit_s), "seconds above 0");
        }
    }
    Ok(())
}

fn read_run(
    path: &Path,
    folder: &Path,
    base_dir: &Path,
    run: &RunSpec,
    scene: &Value,
    compare: &[Value],
) -> Result<CaseRun, CaseError> {
    let filled = |value: &Value| {
        fill_in(value, &run.with).map_err(|name| {
            let what = format!("the run \"{}\" does not give ${name}", run.name);
            let expected = format!("\"with\": {{ \"{name}\": … }} in each run");
            CaseError::new(path, what, "nothing of that name", expected, "give it, or write the number itself")
        })
    };
    let scene_text = filled(scene)?.to_string();
    let scene = scene_from_json(&scene_text, None, base_dir).map_err(|error| refused_scene(path, run, &error))?;
    let mut comparisons = Vec::new();
    for (index, value) in compare.iter().enumerate() {
        let comparison: Comparison = typed(path, &format!("compare[{index}]"), filled(value)?)?;
        check_comparison(path, &scene, &comparison)?;
        let rooms = RoomCache::default();
        Truth::prepare(&comparison, &scene, &rooms, folder)?.check_seed(run.seed)?;
        if comparison.runs.as_ref().is_none_or(|names| names.contains(&run.name)) {
            comparisons.push(comparison);
        }
    }
    Ok(CaseRun {
        name: run.name.clone(),
        scene,
        seed: run.seed,
        target_error: run.target_error.map(|fraction| fraction.0),
        chains: run.chains,
        time_limit_s: run.time_limit_s,
        method: method_of(path, run)?,
        comparisons,
    })
}

/// The method that a run names, with its mesh.
fn method_of(path: &Path, run: &RunSpec) -> Result<Option<RunMethod>, CaseError> {
    let refuse = |what: &str, got: String, expected: String| {
        let what = format!("the run \"{}\": {what}", run.name);
        Err(CaseError::new(path, what, got, expected, "correct the case"))
    };
    let Some(name) = &run.method else {
        if run.mesh_step_m.or(run.mesh_radius_m).is_some() || run.mesh_indirect.is_some() {
            return refuse("a mesh without its method", "no \"method\"".into(), "\"method\": \"light-mesh\"".into());
        }
        return Ok(None);
    };
    let mut mesh = MeshChoice { step_m: run.mesh_step_m, radius_m: run.mesh_radius_m, ..MeshChoice::default() };
    if let Some(form) = &run.mesh_indirect {
        let Some(form) = indirect_form(form) else {
            return refuse("unknown \"mesh_indirect\"", form.clone(), "\"scalar\" or \"directional\"".into());
        };
        mesh.form = form;
    }
    if let Err((got, expected)) = mesh.check() {
        return refuse("the mesh has unusable proportions", got, expected);
    }
    let method = RunMethod::named(name, mesh);
    if method.is_none() {
        return refuse("unknown \"method\"", name.clone(), method_names());
    }
    Ok(method)
}

fn refused_scene(path: &Path, run: &RunSpec, error: &SceneError) -> CaseError {
    let place = error.place.as_ref().map_or_else(String::new, |place| format!(", at {}", place.json_path));
    let what = format!("the scene of the run \"{}\" is refused: {}{place}", run.name, error.what);
    CaseError::new(path, what, error.got.as_str(), error.expected.as_str(), error.remedy.as_str())
}

fn check_comparison(path: &Path, scene: &Scene, comparison: &Comparison) -> Result<(), CaseError> {
    let refuse = |what: &str, got: String, expected: &str| {
        let what = format!("the comparison \"{}\": {what}", comparison.name);
        Err(CaseError::new(path, what, got, expected, "correct the case"))
    };
    let set = scene.receivers.iter().find(|set| set.name == comparison.map);
    match (comparison.what, set) {
        (What::Points, None) => {
            return refuse(
                "points can be compared only for a receiver set",
                comparison.map.clone(),
                "\"map\": the name of a receiver set",
            );
        }
        (What::Ugr, set) if set.is_none_or(|set| set.observers.len() != 1) => {
            return refuse(
                "a rating can be compared only for an observer",
                comparison.map.clone(),
                "\"map\": the name of a ugr receiver",
            );
        }
        (What::Ugr, _) if comparison.light != LightPart::Total => {
            let got = comparison.light.name().to_owned();
            return refuse("a rating is known for total light only", got, "no \"light\", or \"total\"");
        }
        (What::Elements, Some(_)) => {
            return refuse(
                "elements can be compared only in the element map",
                comparison.map.clone(),
                "no \"map\", or \"elements\"",
            );
        }
        (_, None) if comparison.map != ELEMENT_MAP => {
            return refuse("the scene has no such map", comparison.map.clone(), "\"elements\" or a receiver set");
        }
        (What::Points, Some(set))
            if comparison.labels.as_ref().is_some_and(|names| names.len() != set.points.len()) =>
        {
            let got = format!("{} points", set.points.len());
            return refuse("there must be a label for every point", got, "as many labels as points");
        }
        _ => {}
    }
    if let Some(surface) = &comparison.surface
        && !scene.surfaces.iter().any(|known| known.name == *surface || known.geometry == *surface)
    {
        return refuse("the scene has no such surface", surface.clone(), "a surface or a geometry of the scene");
    }
    let criterion = &comparison.criterion;
    if criterion.coverage_alpha.is_some_and(|alpha| !(1e-12..=0.1).contains(&alpha)) {
        return refuse(
            "the level of significance is out of range",
            format!("{:?}", criterion.coverage_alpha),
            "1e-12 to 0.1",
        );
    }
    if criterion.worst_difference.is_some_and(|most| !(most > 0.0 && most.is_finite())) {
        let got = format!("{:?}", criterion.worst_difference);
        return refuse("\"worst_difference\" must be above 0", got, "a number above 0");
    }
    let names_none = criterion.worst.is_none() && criterion.worst_difference.is_none();
    if names_none && criterion.true_error.is_none() && criterion.coverage_alpha.is_none() {
        let expected = "\"worst\", \"worst_difference\", \"true_error\" or \"coverage_alpha\"";
        return refuse("no criterion", "{}".into(), expected);
    }
    Ok(())
}
