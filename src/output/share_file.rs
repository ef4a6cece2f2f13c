//! `share.luxmc`: what one share of a run leaves for a merge.
//!
//! A line with the format's name and the digest of the next line; that line, JSON, which tells what was run and ends with the digest of
//! all that follows; and the sums: little-endian f64, map by map, replica by replica, first of direct, then of indirect light.

use std::fs::File;
use std::io::{BufRead, BufReader, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use super::ResultFile;
use crate::maps::REPLICAS;
use crate::solver::{MapOfShare, MapSums, Share, ShareRecord};

/// Name of the file.
pub const SHARE_FILE: &str = "share.luxmc";
/// Begins the file.
const FORMAT: &str = "luxmc share 1";
/// A longer line is no header.
const LONGEST_HEADER: u64 = 1 << 28;
/// No run counts further.
const MOST_COUNTED: u64 = 1 << 53;
/// No sum of illuminances comes to more: the brightest luminaire has 1e30 lm. Its fourth power is a number.
const MOST_SUMMED: f64 = 1e70;

/// What a share tells of itself.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct ShareHeader {
    /// Version of the program.
    pub luxmc: String,
    /// Scene file as the user named it.
    pub scene: String,
    /// The same from the root of the file system.
    pub scene_path: PathBuf,
    /// What tells the scene from others.
    pub scene_digest: String,
    /// Method asked for.
    pub method: String,
    /// Seed of the run.
    pub seed: u64,
    /// Which share it is.
    pub share: Share,
    /// Target of the merged maps, if one was set.
    pub target_error: Option<f64>,
    /// The command, without output and share.
    pub command: String,
    /// Why the share ended.
    pub stop_reason: String,
    /// Worker threads.
    pub threads: usize,
    /// What it did.
    pub record: ShareRecord,
    /// Digest of the sums.
    pub sums_sha256: String,
}

/// A share's file, of which the header is read.
#[derive(Clone, Debug)]
pub struct ShareFile {
    /// Where it lies.
    pub path: PathBuf,
    /// What it tells.
    pub header: ShareHeader,
    /// Bytes before the sums.
    begin: u64,
}

/// A share that cannot be merged.
#[derive(Debug, thiserror::Error)]
#[error("{what}\n  in {}\n  got:      {got}\n  expected: {expected}\n  remedy:   {remedy}", path.display())]
pub struct ShareError {
    /// File or directory.
    pub path: PathBuf,
    /// What is wrong.
    pub what: String,
    /// What was found.
    pub got: String,
    /// What could have been.
    pub expected: String,
    /// What to do.
    pub remedy: String,
}

const COMPUTE_AGAIN: &str = "compute this share again: luxmc solve SCENE --share k/n --out DIR";

impl ShareError {
    /// A file that is no whole share.
    fn damaged(path: &Path, got: impl Into<String>) -> ShareError {
        ShareError {
            path: path.to_path_buf(),
            what: "the file is no whole share of a run".to_owned(),
            got: got.into(),
            expected: "a file that luxmc solve --share wrote, byte for byte".to_owned(),
            remedy: COMPUTE_AGAIN.to_owned(),
        }
    }

    fn unreadable(path: &Path, error: &std::io::Error) -> ShareError {
        ShareError {
            path: path.to_path_buf(),
            what: "the share cannot be read".to_owned(),
            got: error.to_string(),
            expected: format!("a directory with a file {SHARE_FILE}, which luxmc solve --share writes"),
            remedy: COMPUTE_AGAIN.to_owned(),
        }
    }
}

/// The file of a share; the digest of its sums is filled in.
pub fn share_file(header: ShareHeader, sums: &[MapSums]) -> ResultFile {
    let slabs = || sums.iter().flat_map(slabs_of);
    let mut digest = Sha256::new();
    let mut slab_bytes: Vec<u8> = Vec::new();
    for slab in slabs() {
        slab_bytes.clear();
        slab_bytes.extend(slab.iter().flat_map(|value| value.to_le_bytes()));
        digest.update(&slab_bytes);
    }
    let header = ShareHeader { sums_sha256: hexadecimal(digest), ..header };
    let header = serde_json::to_string(&header).expect("a header has text keys alone");
    let first = format!("{FORMAT} {}\n{header}\n", hexadecimal(Sha256::new_with_prefix(&header)));
    let mut bytes = Vec::with_capacity(first.len() + 8 * slabs().map(Vec::len).sum::<usize>());
    bytes.extend(first.into_bytes());
    slabs().flatten().for_each(|value| bytes.extend(value.to_le_bytes()));
    ResultFile { name: SHARE_FILE.to_owned(), bytes }
}

fn slabs_of(sums: &MapSums) -> impl Iterator<Item = &Vec<f64>> {
    sums.direct.iter().chain(&sums.indirect).chain([&sums.cells_profile])
}

fn hexadecimal(digest: Sha256) -> String {
    digest.finalize().iter().map(|byte| format!("{byte:02x}")).collect()
}

/// Reads the header of the share in a directory.
///
/// # Errors
///
/// No such file, or one that is damaged or of another format.
pub fn read_share(directory: &Path) -> Result<ShareFile, ShareError> {
    let path = directory.join(SHARE_FILE);
    let unreadable = |error: std::io::Error| ShareError::unreadable(&path, &error);
    let damaged = |got: &str| ShareError::damaged(&path, got);
    // A pipe would keep one waiting when it is opened already.
    if !std::fs::metadata(&path).map_err(unreadable)?.is_file() {
        return Err(unreadable(std::io::Error::other("a directory, device or pipe")));
    }
    let file = File::open(&path).map_err(unreadable)?;
    let length = file.metadata().map_err(unreadable)?.len();
    let mut reader = BufReader::new(file);
    let mut line = || -> Result<Vec<u8>, ShareError> {
        let mut bytes = Vec::new();
        reader.by_ref().take(LONGEST_HEADER).read_until(b'\n', &mut bytes).map_err(unreadable)?;
        bytes.pop().filter(|last| *last == b'\n').ok_or_else(|| damaged("a file that is cut off in its header"))?;
        Ok(bytes)
    };
    let (first, text) = (line()?, line()?);
    let digest = first.strip_prefix(FORMAT.as_bytes()).and_then(|rest| rest.strip_prefix(b" "));
    let digest = digest.ok_or_else(|| damaged("a file that begins otherwise, or of another version of the format"))?;
    if digest != hexadecimal(Sha256::new_with_prefix(&text)).as_bytes() {
        return Err(damaged("a header whose digest is not the one that stands before it"));
    }
    let header: ShareHeader =
        serde_json::from_slice(&text).map_err(|error| damaged(&format!("a header that cannot be read: {error}")))?;
    let begin = (first.len() + text.len() + 2) as u64;
    let wanted = header.record.maps.iter().try_fold(begin, |sum, map| sum.checked_add(values_of(map)?.checked_mul(8)?));
    if wanted != Some(length) {
        let wanted = wanted.map_or("more than there can be".to_owned(), |bytes| bytes.to_string());
        return Err(damaged(&format!("{length} bytes, where its header tells of {wanted}")));
    }
    let record = &header.record;
    let of_maps = record.maps.iter().flat_map(|map| [map.chains, map.rays]);
    if let Some(count) = of_maps.chain([record.chains, record.rays]).find(|count| *count > MOST_COUNTED) {
        return Err(damaged(&format!("a header that counts {count} chains or rays")));
    }
    Ok(ShareFile { path, header, begin })
}

/// Numbers that the sums of a map are.
fn values_of(map: &MapOfShare) -> Option<u64> {
    let slabs = 2 * REPLICAS as u64 + u64::from(map.cells_error.is_some());
    slabs.checked_mul(map.entries as u64)
}

impl ShareFile {
    /// The sums of all maps.
    ///
    /// # Errors
    ///
    /// Sums that are not those that were written.
    pub fn sums(&self) -> Result<Vec<MapSums>, ShareError> {
        let unreadable = |error: std::io::Error| ShareError::unreadable(&self.path, &error);
        let mut reader = File::open(&self.path).map_err(unreadable)?;
        reader.seek(SeekFrom::Start(self.begin)).map_err(unreadable)?;
        let mut digest = Sha256::new();
        let mut slab = |entries: usize| -> Result<Vec<f64>, ShareError> {
            let mut bytes = vec![0; 8 * entries];
            reader.read_exact(&mut bytes).map_err(unreadable)?;
            digest.update(&bytes);
            let value = |bytes: &[u8]| bytes.try_into().map_or(f64::NAN, f64::from_le_bytes);
            Ok(bytes.chunks_exact(8).map(value).collect())
        };
        let mut all = Vec::new();
        for map in &self.header.record.maps {
            let mut slabs = || (0..REPLICAS).map(|_| slab(map.entries)).collect::<Result<Vec<_>, _>>();
            let (direct, indirect) = (slabs()?, slabs()?);
            let cells_profile = if map.cells_error.is_some() { slab(map.entries)? } else { Vec::new() };
            all.push(MapSums { direct, indirect, cells_profile });
        }
        if hexadecimal(digest) != self.header.sums_sha256 {
            return Err(ShareError::damaged(&self.path, "sums whose digest is not the one in the header"));
        }
        // What is no number is no less.
        if !all.iter().flat_map(slabs_of).flatten().all(|value| value.abs() <= MOST_SUMMED) {
            return Err(ShareError::damaged(
                &self.path,
                format!("sums that are no numbers, or beyond {MOST_SUMMED:e}"),
            ));
        }
        Ok(all)
    }
}
