//! Finds cases at run time: every folder with a `case.json` is a case, without further registration.

use std::path::{Path, PathBuf};

use super::case::{CASE_FILE, Case};
use super::error::CaseError;

/// Name of the folder that contains the cases.
const CASES_FOLDER: &str = "validation";
/// Groups that may have no case yet. They do not count as misspelt names.
const KNOWN_GROUPS: [&str; 4] = ["all", "quick", "hard", "calibration"];

/// Result of a search for cases.
#[derive(Debug)]
pub struct FoundCases {
    /// The cases, each once, sorted by name.
    pub cases: Vec<Case>,
    /// Known groups that have no case.
    pub empty_groups: Vec<String>,
}

/// Finds the cases for a list of names: cases, groups, or paths of case folders. An empty list means the group `all`.
///
/// Cases are in `cases_dir`, otherwise in `./validation`, otherwise in a `validation` folder beside or above the executable.
///
/// # Errors
///
/// An unknown name, a missing folder, a malformed case.
pub fn find_cases(names: &[String], cases_dir: Option<&Path>) -> Result<FoundCases, CaseError> {
    let names = if names.is_empty() { vec!["all".to_owned()] } else { names.to_vec() };
    let mut folders: Vec<PathBuf> = Vec::new();
    let mut empty_groups = Vec::new();
    let mut library: Option<Vec<Case>> = None;
    let mut cases: Vec<Case> = Vec::new();
    for name in &names {
        let path = Path::new(name);
        if is_case(path) && cases_dir.is_none_or(|folder| !is_case(&folder.join(name))) {
            folders.push(path.to_path_buf());
            continue;
        }
        let folder = cases_folder(cases_dir)?;
        if is_case(&folder.join(name)) {
            folders.push(folder.join(name));
            continue;
        }

        // Only a group requires every case to be read.
        if library.is_none() {
            library = Some(case_folders(&folder)?.iter().map(|folder| Case::read(folder)).collect::<Result<_, _>>()?);
        }
        let library = library.as_deref().unwrap_or_default();
        let members: Vec<PathBuf> =
            library.iter().filter(|case| case.groups.contains(name)).map(|case| case.folder.clone()).collect();
        if !members.is_empty() {
            folders.extend(members);
        } else if KNOWN_GROUPS.contains(&name.as_str()) {
            empty_groups.push(name.clone());
        } else {
            let known: Vec<&str> = library.iter().map(|case| case.name.as_str()).collect();
            return Err(CaseError::new(
                &folder,
                "no such validation case or group",
                name.as_str(),
                format!("one of {}; or a group: {}", known.join(", "), KNOWN_GROUPS.join(", ")),
                "correct the name, or name the cases' folder with --cases",
            ));
        }
    }
    let mut read = library.unwrap_or_default();
    for folder in folders {
        let same = |case: &Case| same_folder(&case.folder, &folder);
        if cases.iter().any(same) {
            continue;
        }
        match read.iter().position(same) {
            Some(index) => cases.push(read.swap_remove(index)),
            None => cases.push(Case::read(&folder)?),
        }
    }
    cases.sort_by(|a, b| a.name.cmp(&b.name));
    Ok(FoundCases { cases, empty_groups })
}

fn is_case(folder: &Path) -> bool {
    folder.join(CASE_FILE).is_file()
}

fn same_folder(a: &Path, b: &Path) -> bool {
    match (a.canonicalize(), b.canonicalize()) {
        (Ok(a), Ok(b)) => a == b,
        _ => a == b,
    }
}

fn cases_folder(named: Option<&Path>) -> Result<PathBuf, CaseError> {
    if let Some(folder) = named {
        if folder.is_dir() {
            return Ok(folder.to_path_buf());
        }
        let expected = "a folder that contains case folders";
        return Err(CaseError::new(folder, "the cases' folder is missing", "no folder", expected, "correct --cases"));
    }
    let executable = std::env::current_exe().unwrap_or_default();
    let beside = executable.ancestors().skip(1).map(|folder| folder.join(CASES_FOLDER));
    std::iter::once(PathBuf::from(CASES_FOLDER))
        .chain(beside)
        .find(|folder| case_folders(folder).is_ok_and(|cases| !cases.is_empty()))
        .ok_or_else(|| {
            CaseError::new(
                Path::new(CASES_FOLDER),
                "the validation cases are not found",
                "no folder with cases in this directory, or beside or above the program",
                "./validation",
                "go to luxmc's folder, or name the cases' folder with --cases",
            )
        })
}

fn case_folders(folder: &Path) -> Result<Vec<PathBuf>, CaseError> {
    let entries = std::fs::read_dir(folder).map_err(|error| {
        let remedy = "check the name and the right to read it";
        CaseError::new(folder, "the cases' folder cannot be read", error.to_string(), "a folder", remedy)
    })?;
    let mut folders: Vec<PathBuf> =
        entries.filter_map(|entry| entry.ok().map(|entry| entry.path())).filter(|path| is_case(path)).collect();
    folders.sort();
    Ok(folders)
}
