//! Files from which work is continued: shares of a run, and its checkpoints. All have one layout and one reader.
//!
//! The first line has the format's name and the digest of the second line. The second line is JSON; it describes the rest and has
//! its digest. The numbers follow.

use std::fs::File;
use std::io::{BufRead, BufReader, Read};
use std::path::{Path, PathBuf};

use serde::Serialize;
use serde::de::DeserializeOwned;
use sha2::{Digest, Sha256};

/// Largest length of a header's line, in bytes.
const LONGEST_HEADER: u64 = 1 << 28;

/// A file from which work cannot be continued.
#[derive(Debug, thiserror::Error)]
#[error("{what}\n  in {}\n  got:      {got}\n  expected: {expected}\n  remedy:   {remedy}", path.display())]
pub struct SealedError {
    /// File or directory.
    pub path: PathBuf,
    /// What is wrong.
    pub what: String,
    /// What was found.
    pub got: String,
    /// What was expected.
    pub expected: String,
    /// The remedy.
    pub remedy: String,
}

/// A kind of sealed file, with the texts of its error messages.
pub(super) struct Format {
    /// Beginning of the file.
    pub name: &'static str,
    /// Message for a damaged file.
    pub is_no: &'static str,
    /// Message for a file that cannot be read.
    pub is_unreadable: &'static str,
    /// What was expected to be there, if the file cannot be read.
    pub expected_there: &'static str,
    /// Description of an undamaged file.
    pub expected: &'static str,
    /// The remedy.
    pub remedy: &'static str,
}

impl Format {
    /// The error for a file that is incomplete or not of this format.
    pub fn damaged(&self, path: &Path, got: impl Into<String>) -> SealedError {
        SealedError {
            path: path.to_path_buf(),
            what: self.is_no.to_owned(),
            got: got.into(),
            expected: self.expected.to_owned(),
            remedy: self.remedy.to_owned(),
        }
    }

    /// The error for a file that the system does not let read.
    pub fn unreadable(&self, path: &Path, error: &std::io::Error) -> SealedError {
        SealedError {
            path: path.to_path_buf(),
            what: self.is_unreadable.to_owned(),
            got: error.to_string(),
            expected: self.expected_there.to_owned(),
            remedy: self.remedy.to_owned(),
        }
    }

    /// Both lines of a header.
    pub fn lines(&self, header: &impl Serialize) -> String {
        let header = serde_json::to_string(header).expect("a header has text keys alone");
        format!("{} {}\n{header}\n", self.name, hexadecimal(Sha256::new_with_prefix(&header)))
    }

    /// Reads the header of a file.
    ///
    /// # Errors
    ///
    /// No such file, or one that is damaged or of another format.
    pub fn read<T: DeserializeOwned>(&self, path: &Path) -> Result<Sealed<T>, SealedError> {
        let unreadable = |error: std::io::Error| self.unreadable(path, &error);
        let damaged = |got: &str| self.damaged(path, got);
        // Opening a pipe would already wait for its other end.
        if !std::fs::metadata(path).map_err(unreadable)?.is_file() {
            return Err(unreadable(std::io::Error::other("a directory, device or pipe")));
        }
        let file = File::open(path).map_err(unreadable)?;
        let length = file.metadata().map_err(unreadable)?.len();
        let mut reader = BufReader::new(file);
        let mut line = || -> Result<Vec<u8>, SealedError> {
            let mut bytes = Vec::new();
            reader.by_ref().take(LONGEST_HEADER).read_until(b'\n', &mut bytes).map_err(unreadable)?;
            bytes.pop().filter(|last| *last == b'\n').ok_or_else(|| damaged("a file that ends within its header"))?;
            Ok(bytes)
        };
        let first = line()?;
        let digest = first.strip_prefix(self.name.as_bytes()).and_then(|rest| rest.strip_prefix(b" "));
        let digest =
            digest.ok_or_else(|| damaged("a file with another beginning, or of another version of the format"))?;
        let text = line()?;
        if digest != hexadecimal(Sha256::new_with_prefix(&text)).as_bytes() {
            return Err(damaged("a header that does not match the digest before it"));
        }
        let header = serde_json::from_slice(&text)
            .map_err(|error| damaged(&format!("a header that cannot be read: {error}")))?;
        Ok(Sealed { header, begin: (first.len() + text.len() + 2) as u64, length })
    }
}

/// The result of the reader.
pub(super) struct Sealed<T> {
    /// Header of the file.
    pub header: T,
    /// Bytes before the numbers, and bytes in all.
    pub begin: u64,
    pub length: u64,
}

/// A digest in hexadecimal digits.
pub(super) fn hexadecimal(digest: Sha256) -> String {
    digest.finalize().iter().map(|byte| format!("{byte:02x}")).collect()
}
