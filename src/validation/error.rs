//! Errors of validation cases that cannot be used.

use std::path::{Path, PathBuf};

/// A case that is refused before any run.
#[derive(Debug, thiserror::Error)]
#[error("{what}\n  in {}\n  got:      {got}\n  expected: {expected}\n  remedy:   {remedy}", path.display())]
pub struct CaseError {
    /// File or directory with the problem.
    pub path: PathBuf,
    /// What is wrong, in one sentence.
    pub what: String,
    /// What was found.
    pub got: String,
    /// What was expected.
    pub expected: String,
    /// What the user can do about it.
    pub remedy: String,
}

impl CaseError {
    pub(super) fn new(
        path: &Path,
        what: impl Into<String>,
        got: impl Into<String>,
        expected: impl Into<String>,
        remedy: impl Into<String>,
    ) -> CaseError {
        CaseError {
            path: path.to_path_buf(),
            what: what.into(),
            got: got.into(),
            expected: expected.into(),
            remedy: remedy.into(),
        }
    }
}
