//! Reads files as bytes: only regular files, and only up to a size limit against errors and attacks.

use std::fs::{File, Metadata};
use std::io::{Error, ErrorKind, Read, Result};
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};

/// Whether the user has allowed large files. It holds for all files of a process.
static ALLOWS_LARGE: AtomicBool = AtomicBool::new(false);

/// Allows files of any size that fit into memory.
pub fn allow_large_files() {
    ALLOWS_LARGE.store(true, Ordering::Relaxed);
}

/// Returns the bytes of a regular file of at most `most_bytes` bytes, or of any size once large files are allowed.
///
/// Devices and pipes are never opened: a device has no end, and a pipe may never begin. Files in `/proc` and `/sys` are not opened
/// either: their size is missing or wrong, and some never end. The size at opening limits the reading. A file that grows for ever
/// therefore ends there too.
///
/// # Errors
///
/// A file that is missing, cannot be read, is not a regular file, is too large, or does not fit into memory.
pub(super) fn read_plain_file(path: &Path, most_bytes: u64) -> Result<Vec<u8>> {
    read_at_most(path, largest_bytes(most_bytes))
}

/// Returns `most_bytes`, or no limit once large files are allowed.
pub(super) fn largest_bytes(most_bytes: u64) -> u64 {
    if ALLOWS_LARGE.load(Ordering::Relaxed) { u64::MAX } else { most_bytes }
}

fn read_at_most(path: &Path, largest_bytes: u64) -> Result<Vec<u8>> {
    let metadata = std::fs::metadata(path)?;
    if metadata.is_dir() {
        return Err(Error::from(ErrorKind::IsADirectory));
    }
    if !metadata.is_file() {
        return Err(Error::other("this is a device or a pipe, not a plain file"));
    }
    if is_of_the_system(&metadata) {
        return Err(Error::other(
            "this is a file of the system in /proc or /sys, whose size is unknown, not a plain file",
        ));
    }
    let size = metadata.len();
    if size > largest_bytes {
        let what = format!("{size} bytes are more than the {largest_bytes} that are read without --allow-large");
        return Err(Error::new(ErrorKind::FileTooLarge, what));
    }
    whole(File::open(path)?, &metadata)
}

/// Whether a file belongs to `/proc` or `/sys`, under any name.
#[cfg(unix)]
fn is_of_the_system(metadata: &Metadata) -> bool {
    use std::os::unix::fs::MetadataExt;
    let devices = ["/proc/self", "/sys/kernel"].into_iter().filter_map(|folder| std::fs::metadata(folder).ok());
    devices.into_iter().any(|folder| folder.dev() == metadata.dev())
}

#[cfg(not(unix))]
fn is_of_the_system(_: &Metadata) -> bool {
    false
}

/// Reads all bytes of an opened file. It fails if the file was cut off or changed since `before`, because its content is then uncertain.
fn whole(mut file: File, before: &Metadata) -> Result<Vec<u8>> {
    let size = before.len();
    let mut bytes = Vec::new();
    if bytes.try_reserve_exact(usize::try_from(size).unwrap_or(usize::MAX)).is_err() {
        return Err(Error::new(ErrorKind::OutOfMemory, format!("{size} bytes do not fit into memory")));
    }
    file.by_ref().take(size).read_to_end(&mut bytes)?;
    let after = file.metadata()?;
    let is_same = bytes.len() as u64 == size && after.len() == size && after.modified().ok() == before.modified().ok();
    if is_same { Ok(bytes) } else { Err(Error::new(ErrorKind::ResourceBusy, "the file changed while it was read")) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn devices_and_files_beyond_the_limit_are_not_read() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("file");
        std::fs::write(&path, b"0123456789").expect("written");
        assert_eq!(read_at_most(&path, 10).expect("small enough"), b"0123456789");
        let error = read_at_most(&path, 9).expect_err("too large");
        assert!(error.kind() == ErrorKind::FileTooLarge && error.to_string().contains("--allow-large"), "{error}");
        #[cfg(target_os = "linux")]
        for endless in ["/dev/zero", "/dev/kmsg", "/dev/stdin", "/proc/kmsg", "/proc/cpuinfo", "/proc/self/mem"] {
            // A missing file is refused as missing. `/dev/stdin` of a test may be a regular file.
            let read = read_at_most(Path::new(endless), u64::MAX);
            assert!(read.is_err() || endless == "/dev/stdin", "{endless}: {read:?}");
        }
        #[cfg(target_os = "linux")]
        {
            // A link does not change the result, and an empty regular file is valid.
            let link = folder.path().join("mesh.obj");
            std::os::unix::fs::symlink("/proc/version", &link).expect("a link");
            let error = read_at_most(&link, 10).expect_err("of the system");
            assert!(error.to_string().contains("/proc"), "{error}");
            std::fs::write(&path, b"").expect("written");
            assert_eq!(read_at_most(&path, 10).expect("empty"), b"");
        }
    }

    #[test]
    fn a_file_that_is_cut_off_or_grows_while_it_is_read_is_refused() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("file");
        for now in [&b"01234"[..], b"0123456789", b"0123456789ab"] {
            std::fs::write(&path, b"0123456789").expect("written");
            let before = std::fs::metadata(&path).expect("there");
            std::fs::write(&path, now).expect("written");
            // For a file of the same size only the time of its last change differs. Both changes may fall in the same tick of the clock.
            let read = whole(File::open(&path).expect("opened"), &before);
            assert!(now.len() == 10 || read.is_err_and(|error| error.kind() == ErrorKind::ResourceBusy));
        }
    }
}
