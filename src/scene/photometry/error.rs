//! Errors of photometric files.

use std::path::{Path, PathBuf};

/// Why a photometric file was refused: position, content, expectation and remedy.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum PhotometricError {
    /// The file cannot be read at all.
    #[error("{}: {reason}; {remedy}", path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// Reason from the operating system, or the limit that the file exceeds.
        reason: String,
        /// Remedy.
        remedy: String,
    },
    /// The file violates its format.
    #[error("{}line {line}: found {got}, expected {expected}; {remedy}", place(path))]
    Malformed {
        /// The file, if the text came from one.
        path: Option<PathBuf>,
        /// Line, from 1.
        line: usize,
        /// The token in the file, or the end of the file.
        got: String,
        /// What is expected instead.
        expected: String,
        /// Remedy.
        remedy: String,
    },
}

impl PhotometricError {
    /// Makes an error for a malformed line. `got` is shortened, so that a binary file does not flood the terminal.
    pub(super) fn malformed(line: usize, got: &str, expected: impl Into<String>, remedy: impl Into<String>) -> Self {
        const SHOWN_CHARACTERS: usize = 40;
        let short: String = got.chars().take(SHOWN_CHARACTERS).map(|c| if c.is_control() { '�' } else { c }).collect();
        let dots = if got.chars().count() > SHOWN_CHARACTERS { "…" } else { "" };
        let got = if got.is_empty() { "nothing".to_string() } else { format!("`{short}{dots}`") };
        PhotometricError::Malformed { path: None, line, got, expected: expected.into(), remedy: remedy.into() }
    }

    /// Makes an error for a text that ends too early.
    pub(super) fn ended(line: usize, expected: impl Into<String>) -> Self {
        PhotometricError::Malformed {
            path: None,
            line,
            got: "the end of the file".to_string(),
            expected: expected.into(),
            remedy: "the file is cut off, or its counts announce more values than it contains; get it again from the manufacturer or correct the counts"
                .to_string(),
        }
    }

    /// The same error with the file's name.
    pub(super) fn in_file(self, file: &Path) -> Self {
        match self {
            PhotometricError::Malformed { path: None, line, got, expected, remedy } => {
                PhotometricError::Malformed { path: Some(file.to_path_buf()), line, got, expected, remedy }
            }
            other => other,
        }
    }
}

fn place(path: &Option<PathBuf>) -> String {
    path.as_ref().map(|path| format!("{}: ", path.display())).unwrap_or_default()
}
