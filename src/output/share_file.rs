//! `share.luxmc`: what one share of a run leaves for a merge.
//!
//! A header that tells what was run ([`super::sealed`]), and the sums: little-endian f64, map by map, replica by replica, first of direct,
//! then of indirect light.

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

const SHARES: Format = Format {
    name: "luxmc share 1",
    is_no: "the file is no whole share of a run",
    is_unreadable: "the share cannot be read",
    expected_there: "a directory with a file share.luxmc, which luxmc solve --share writes",
    expected: "a file that luxmc solve --share wrote, byte for byte",
    remedy: "compute this share again: luxmc solve SCENE --share k/n --out DIR",
};

/// The file of a share; the digest of its sums is filled in.
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

/// Hands on the bytes of all sums, one slab at a time.
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
        let wanted = wanted.map_or("more than there can be".to_owned(), |bytes| bytes.to_string());
        return Err(SHARES.damaged(&path, format!("{length} bytes, where its header tells of {wanted}")));
    }
    let record = &header.record;
    let of_maps = record.maps.iter().flat_map(|map| [map.chains, map.rays]);
    if let Some(count) = of_maps.chain([record.chains, record.rays]).find(|count| *count > MOST_COUNTED) {
        return Err(SHARES.damaged(&path, format!("a header that counts {count} chains or rays")));
    }
    let part = record.part;
    if !(1..=part.of).contains(&part.number) {
        return Err(SHARES.damaged(&path, format!("a header that tells of part {} of {}", part.number, part.of)));
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
            return Err(SHARES.damaged(&self.path, "sums whose digest is not the one in the header"));
        }
        // What is no number is no less.
        if !all.iter().flat_map(slabs_of).flatten().all(|value| value.abs() <= MOST_SUMMED) {
            return Err(SHARES.damaged(&self.path, format!("sums that are no numbers, or beyond {MOST_SUMMED:e}")));
        }
        Ok(all)
    }
}
