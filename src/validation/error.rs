//! Why a validation case could not be used.

use std::path::{Path, PathBuf};

/// A case that was refused before anything ran.
#[derive(Debug, thiserror::Error)]
#[error("{what}\n  in {}\n  got:      {got}\n  expected: {expected}\n  remedy:   {remedy}", path.display())]
pub struct CaseError {
    /// File or directory.
    pub path: PathBuf,
    /// What is wrong, in one sentence.
    pub what: String,
    /// What stands there.
    pub got: String,
    /// What could stand there.
    pub expected: String,
    /// What to do about it.
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
