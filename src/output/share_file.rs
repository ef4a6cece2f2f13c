//! `share.luxmc`: the result of one share of a run, for a merge.
//!
//! The file has a header with the settings of the run ([`super::sealed`]), and the sums: little-endian f64, map by map, replica by
//! replica, first of direct, then of indirect light.

use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use super::sealed::{Format, Sealed, SealedError, hexadecimal};
use super::streamed::{StreamedFile, unwritable};
use crate::maps::REPLICAS;
use crate::solver::{MapOfShare, MapSums, Share, ShareRecord};

/// Name of the file.
pub const SHARE_FILE: &str = "share.luxmc";
/// Largest count of chains or rays of any run.
const MOST_COUNTED: u64 = 1 << 53;
/// Largest sum of illuminances: the brightest luminaire has 1e30 lm. The fourth power of this is still a finite number.
const MOST_SUMMED: f64 = 1e70;

/// The header of a share.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct ShareHeader {
    /// Version of the program.
    pub luxmc: String,
    /// Scene file as the user named it.
    pub scene: String,
    /// Absolute path of the scene file.
    pub scene_path: PathBuf,
    /// Digest that identifies the scene.
    pub scene_digest: String,
    /// Requested method.
    pub method: String,
    /// Seed of the run.
    pub seed: u64,
    /// Which share this is.
    pub share: Share,
    /// Target error of the merged maps as a fraction, if one was set.
    pub target_error: Option<f64>,
    /// The command, without output and share.
    pub command: String,
    /// Why the share ended.
    pub stop_reason: String,
    /// Worker threads.
    pub threads: usize,
    /// Record of its work.
    pub record: ShareRecord,
    /// Digest of the sums.
    pub sums_sha256: String,
}

/// The file of a share whose header has been read.
#[derive(Clone, Debug)]
pub struct ShareFile {
    /// Path of the file.
    pub path: PathBuf,
    /// Its header.
    pub header: ShareHeader,
    /// Number of bytes before the sums.
    begin: u64,
}

const SHARES: Format = Format {
    name: "luxmc share 1",
    is_no: "the file is not a complete share of a run",
    is_unreadable: "the share cannot be read",
    expected_there: "a directory with a file share.luxmc, which luxmc solve --share writes",
    expected: "a file that luxmc solve --share wrote, byte for byte",
    remedy: "compute this share again: luxmc solve SCENE --share k/n --out DIR",
};

/// Makes the file of a share; the digest of its sums is filled in.
pub fn share_file(header: ShareHeader, sums: &[MapSums]) -> StreamedFile<'_> {
    let mut digest = Sha256::new();
    let taken = for_each_slab(sums, |bytes| {
        digest.update(bytes);
        Ok(())
    });
    taken.expect("a digest takes everything");
    let header = ShareHeader { sums_sha256: hexadecimal(digest), ..header };
    let first = SHARES.lines(&header);
    StreamedFile::new(SHARE_FILE, move |writer| {
        let written =
            writer.write_all(first.as_bytes()).and_then(|()| for_each_slab(sums, |bytes| writer.write_all(bytes)));
        written.map_err(|error| unwritable(SHARE_FILE, &error))
    })
}

/// Passes the bytes of all sums to `take`, one slab at a time.
fn for_each_slab(sums: &[MapSums], mut take: impl FnMut(&[u8]) -> std::io::Result<()>) -> std::io::Result<()> {
    let mut bytes: Vec<u8> = Vec::new();
    for slab in sums.iter().flat_map(slabs_of) {
        bytes.clear();
        bytes.extend(slab.iter().flat_map(|value| value.to_le_bytes()));
        take(&bytes)?;
    }
    Ok(())
}

fn slabs_of(sums: &MapSums) -> impl Iterator<Item = &Vec<f64>> {
    sums.direct.iter().chain(&sums.indirect).chain([&sums.cells_profile])
}

/// Reads the header of the share in a directory.
///
/// # Errors
///
/// No such file, or one that is damaged or of another format.
pub fn read_share(directory: &Path) -> Result<ShareFile, SealedError> {
    let path = directory.join(SHARE_FILE);
    let Sealed { header, begin, length } = SHARES.read::<ShareHeader>(&path)?;
    let wanted = header.record.maps.iter().try_fold(begin, |sum, map| sum.checked_add(values_of(map)?.checked_mul(8)?));
    if wanted != Some(length) {
        let wanted = wanted.map_or("an impossible number".to_owned(), |bytes| bytes.to_string());
        return Err(SHARES.damaged(&path, format!("{length} bytes, where its header states {wanted}")));
    }
    let record = &header.record;
    let of_maps = record.maps.iter().flat_map(|map| [map.chains, map.rays]);
    if let Some(count) = of_maps.chain([record.chains, record.rays]).find(|count| *count > MOST_COUNTED) {
        return Err(SHARES.damaged(&path, format!("a header that counts {count} chains or rays")));
    }
    let part = record.part;
    if !(1..=part.of).contains(&part.number) {
        return Err(SHARES.damaged(&path, format!("a header that states part {} of {}", part.number, part.of)));
    }
    Ok(ShareFile { path, header, begin })
}

/// Number of values in the sums of a map.
fn values_of(map: &MapOfShare) -> Option<u64> {
    let slabs = 2 * REPLICAS as u64 + u64::from(map.cells_error.is_some());
    slabs.checked_mul(map.entries as u64)
}

impl ShareFile {
    /// Reads the sums of all maps.
    ///
    /// # Errors
    ///
    /// The sums are not those that were written.
    pub fn sums(&self) -> Result<Vec<MapSums>, SealedError> {
        let unreadable = |error: std::io::Error| SHARES.unreadable(&self.path, &error);
        let mut reader = File::open(&self.path).map_err(unreadable)?;
        reader.seek(SeekFrom::Start(self.begin)).map_err(unreadable)?;
        let mut digest = Sha256::new();
        let mut slab = |entries: usize| -> Result<Vec<f64>, SealedError> {
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
            return Err(SHARES.damaged(&self.path, "sums that do not match the digest in the header"));
        }
        // This form of the comparison also refuses NaN.
        if !all.iter().flat_map(slabs_of).flatten().all(|value| value.abs() <= MOST_SUMMED) {
            return Err(
                SHARES.damaged(&self.path, format!("sums that are not numbers, or are larger than {MOST_SUMMED:e}"))
            );
        }
        Ok(all)
    }
}
