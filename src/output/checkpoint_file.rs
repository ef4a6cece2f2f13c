//! A checkpoint: the file that a run writes while it computes, so that another process can resume it.
//!
//! The file has a header with the run and its progress ([`super::sealed`]), and the state in the format of the crate postcard. The
//! file gets its name only when all of it is safely on the disk, so that there is always a complete one.

use std::cell::Cell;
use std::fs::File;
use std::io::{BufReader, BufWriter, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use tempfile::NamedTempFile;

use super::directory::BLOCK;
use super::sealed::{Format, Sealed, SealedError, hexadecimal};
use crate::solver::{KeptRun, RunState};

const CHECKPOINTS: Format = Format {
    name: "luxmc checkpoint 1",
    is_no: "the file is not a complete checkpoint of a run",
    is_unreadable: "the checkpoint cannot be read",
    expected_there: "a file that luxmc solve --checkpoint writes",
    expected: "a file that luxmc solve --checkpoint wrote, byte for byte",
    remedy: "name another checkpoint, or start the run again: luxmc solve SCENE --out DIR --checkpoint FILE",
};

/// Placeholder for the digits of a digest that is not known yet.
const NO_DIGEST: &str = "0000000000000000000000000000000000000000000000000000000000000000";

/// The header of a checkpoint.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct CheckpointHeader {
    /// Version of the program.
    pub luxmc: String,
    /// Scene file as the user named it.
    pub scene: String,
    /// Absolute path of the scene file.
    pub scene_path: PathBuf,
    /// Digest that identifies the scene.
    pub scene_digest: String,
    /// Absolute path of the directory of the results.
    pub out: PathBuf,
    /// The options of the run, as the command line keeps them.
    pub arguments: serde_json::Value,
    /// Why the run ended; `None` as long as it goes on.
    pub stop_reason: Option<String>,
    /// Number of rays so far.
    pub rays: u64,
    /// Worst stated error of the bound maps as a fraction, once it is known.
    pub estimated_error: Option<f64>,
    /// Seconds that the run has taken.
    pub wall_s: f64,
    /// Digest of the state.
    pub state_sha256: String,
}

/// A checkpoint whose header has been read.
#[derive(Clone, Debug)]
pub struct CheckpointFile {
    /// Path of the file.
    pub path: PathBuf,
    /// Its header.
    pub header: CheckpointHeader,
    /// Number of bytes before the state.
    begin: u64,
}

/// A writer that digests the bytes that pass through it.
struct Digesting<'a> {
    inner: &'a mut File,
    digest: Sha256,
    /// The system's error if it did not accept the bytes. The serialiser itself does not pass this error on.
    refusal: &'a Cell<Option<std::io::Error>>,
}

impl Write for Digesting<'_> {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        let count = self.inner.write(bytes).map_err(|error| {
            let kind = error.kind();
            self.refusal.set(Some(error));
            std::io::Error::from(kind)
        })?;
        self.digest.update(&bytes[..count]);
        Ok(count)
    }

    fn flush(&mut self) -> std::io::Result<()> {
        self.inner.flush()
    }
}

/// Writes a checkpoint in place of the previous one; the digest is filled in.
///
/// # Errors
///
/// The disk does not accept it. The previous checkpoint then stays.
pub fn write_checkpoint(path: &Path, header: &CheckpointHeader, state: &RunState) -> std::io::Result<()> {
    let mut staged = new_file_beside(path)?;
    // The digest is known once the state is written. The header then has the same length as before.
    write_lines(staged.as_file_mut(), header, NO_DIGEST)?;
    let refusal = Cell::new(None);
    let to_disk = Digesting { inner: staged.as_file_mut(), digest: Sha256::new(), refusal: &refusal };
    let written = match postcard::to_io(state, BufWriter::with_capacity(BLOCK, to_disk)) {
        Ok(written) => written,
        Err(error) => return Err(refusal.take().unwrap_or_else(|| std::io::Error::other(error))),
    };
    let Digesting { digest, .. } = written.into_inner().map_err(|error| error.into_error())?;
    write_lines(staged.as_file_mut(), header, &hexadecimal(digest))?;
    staged.as_file().sync_all()?;
    staged.persist(path)?;
    // A rename lasts once the directory is on the disk. Some systems cannot sync a directory.
    if let Ok(directory) = File::open(folder_of(path)) {
        directory.sync_all().ok();
    }
    Ok(())
}

fn new_file_beside(path: &Path) -> std::io::Result<NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(".luxmc-").suffix(".tmp");
    // Temporary files are private by default. Checkpoints are readable for all who may read this user's files.
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    builder.tempfile_in(folder_of(path))
}

/// Writes the header's lines at the beginning of a file.
fn write_lines(file: &mut File, header: &CheckpointHeader, digest: &str) -> std::io::Result<()> {
    let header = CheckpointHeader { state_sha256: digest.to_owned(), ..header.clone() };
    file.seek(SeekFrom::Start(0))?;
    file.write_all(CHECKPOINTS.lines(&header).as_bytes())
}

/// Proves that a checkpoint can be written at this path.
///
/// # Errors
///
/// The directory does not exist or is not writable.
pub fn prove_checkpoint(path: &Path) -> std::io::Result<()> {
    let mut probe = new_file_beside(path)?;
    probe.write_all(b"luxmc")?;
    probe.close()
}

fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// Reads the header of a checkpoint.
///
/// # Errors
///
/// No such file, or one that is damaged or of another format.
pub fn read_checkpoint(path: &Path) -> Result<CheckpointFile, SealedError> {
    let Sealed { header, begin, .. } = CHECKPOINTS.read(path)?;
    Ok(CheckpointFile { path: path.to_path_buf(), header, begin })
}

impl CheckpointFile {
    /// Reads the state.
    ///
    /// # Errors
    ///
    /// The state is not the one that was written.
    pub fn state(&self) -> Result<KeptRun, SealedError> {
        let unreadable = |error: std::io::Error| CHECKPOINTS.unreadable(&self.path, &error);
        let damaged = |got: &str| CHECKPOINTS.damaged(&self.path, got);
        let mut file = File::open(&self.path).map_err(unreadable)?;
        file.seek(SeekFrom::Start(self.begin)).map_err(unreadable)?;
        let (mut digest, mut block) = (Sha256::new(), vec![0; BLOCK]);
        loop {
            let count = file.read(&mut block).map_err(unreadable)?;
            if count == 0 {
                break;
            }
            digest.update(&block[..count]);
        }
        if hexadecimal(digest) != self.header.state_sha256 {
            return Err(damaged(
                "a state that does not match the digest in the header: the file is truncated or was changed",
            ));
        }
        file.seek(SeekFrom::Start(self.begin)).map_err(unreadable)?;
        let reader = BufReader::with_capacity(BLOCK, file);
        let (state, _) = postcard::from_io((reader, &mut block))
            .map_err(|error| damaged(&format!("a state that cannot be read: {error}")))?;
        Ok(state)
    }
}
