//! Errors of writing results.

use std::path::PathBuf;

/// Results that could not be written, or must not be.
#[derive(Debug, thiserror::Error)]
pub enum OutputError {
    /// The directory or a file in it cannot be written.
    #[error("cannot write results: {what}\n  in {}\n  got:      {got}\n  expected: a directory in which files can be created\n  remedy:   {remedy}", path.display())]
    Unwritable {
        /// Directory or file.
        path: PathBuf,
        /// The action that failed.
        what: &'static str,
        /// The answer of the system.
        got: String,
        /// The remedy.
        remedy: &'static str,
    },
    /// A number that no table may hold.
    #[error(
        "cannot write results: a number that is not finite\n  in {file}, row {row}, column {column}\n  got:      {got}\n  expected: only finite numbers\n  remedy:   this is a fault of luxmc; please report it together with the scene"
    )]
    NotFinite {
        /// File that would hold it.
        file: &'static str,
        /// Row, counted from 1 below the header.
        row: usize,
        /// Column's header.
        column: &'static str,
        /// The number.
        got: f64,
    },
}

impl OutputError {
    /// The same error with the file's path completed by its directory.
    pub(super) fn within(self, directory: &std::path::Path) -> OutputError {
        match self {
            OutputError::Unwritable { path, what, got, remedy } => {
                OutputError::Unwritable { path: directory.join(path), what, got, remedy }
            }
            other => other,
        }
    }

    pub(super) fn unwritable(path: impl Into<PathBuf>, what: &'static str, error: &std::io::Error) -> OutputError {
        use std::io::ErrorKind;
        let remedy = match error.kind() {
            ErrorKind::PermissionDenied => "allow writing there, or name another directory with --out",
            ErrorKind::StorageFull | ErrorKind::QuotaExceeded | ErrorKind::FileTooLarge => {
                "free some disk space, or name a directory on another disk with --out"
            }
            ErrorKind::ResourceBusy => "wait until the other run has ended, or name another directory with --out",
            ErrorKind::ReadOnlyFilesystem => "name a directory on a disk that can be written, with --out",
            _ => "name another directory with --out",
        };
        OutputError::Unwritable { path: path.into(), what, got: error.to_string(), remedy }
    }
}
