//! The directory for the results: proven writable before the run, and filled in one step after it.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use rayon::prelude::*;
use tempfile::{NamedTempFile, TempPath};

use super::texts::{in_language, language};
use super::{OutputError, ResultFile, StreamedFile};

/// Bytes that are written or read at a time.
pub(super) const BLOCK: usize = 1 << 20;
/// Beginnings and end of temporary names: for the staged files of a run, and for files that are written one by one.
const STAGED: &str = ".luxmc-result-";
const WRITTEN: &str = ".luxmc-";
const TEMPORARY: &str = ".tmp";
/// The file whose presence shows that the others are complete.
const SUMMARY: &str = "summary.json";

/// Closed files on the disk under temporary names, each with its final name. The system would not allow thousands of them to be
/// open. They are removed unless a directory [takes](ResultDirectory::take) them.
#[derive(Debug, Default)]
pub struct StagedFiles(Vec<(String, TempPath)>);

/// A directory for the results of one run.
///
/// Files are staged under temporary names. They appear under their own names only when all are safely on the disk; `summary.json`
/// comes last.
#[derive(Debug)]
pub struct ResultDirectory {
    path: PathBuf,
    /// Lock that is held as long as the run lasts, if the system can lock a directory. The system releases it with the process.
    _lock: Option<std::fs::File>,
    staged: StagedFiles,
    /// Whether the directory was made for this run.
    is_new: bool,
    _opened: Opened,
    /// Time that it took to write a file to the disk.
    probe: Duration,
}

impl ResultDirectory {
    /// Makes the directory if it is missing, and proves that files can be made in it.
    ///
    /// # Errors
    ///
    /// A path that is no directory, cannot be made, cannot be written to, or receives another run's results.
    pub fn open(path: &Path) -> Result<ResultDirectory, OutputError> {
        let is_new = !path.exists();
        make(path)?;
        let lock = locked(path)?;
        if lock.is_some() {
            // With the lock held, nobody else writes here: staged files are left over from a run that was killed.
            remove_staged(path);
        }
        let opened = Opened::new(path);
        let probed = Instant::now();
        let mut probe = temporary(path, STAGED)?;
        probe
            .write_all(b"luxmc")
            .and_then(|()| probe.as_file().sync_all())
            .and_then(|()| probe.close())
            .map_err(|error| OutputError::unwritable(path, "a file in it cannot be written", &error))?;
        let probe = probed.elapsed();
        for name in super::fixed_names().chain([SUMMARY]) {
            refuse_directory(&path.join(name))?;
        }
        let (path, staged) = (path.to_path_buf(), StagedFiles::default());
        Ok(ResultDirectory { path, _lock: lock, staged, is_new, _opened: opened, probe })
    }

    /// Removes a directory that was made for a run without results.
    pub fn withdraw(self) {
        let ResultDirectory { path, staged, is_new, .. } = self;
        drop(staged);
        if is_new {
            std::fs::remove_dir(path).ok();
        }
    }

    /// Time that it took to write a file of a few bytes to the disk and to remove it.
    pub fn took_a_file(&self) -> Duration {
        self.probe
    }

    /// Path of the directory.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Names of the files staged so far.
    pub fn names(&self) -> Vec<String> {
        self.staged.0.iter().map(|(name, _)| name.clone()).collect()
    }

    /// Writes a file to the disk under a temporary name.
    ///
    /// # Errors
    ///
    /// The disk does not accept it; no part of it is left.
    pub fn stage(&mut self, file: &ResultFile) -> Result<(), OutputError> {
        self.stage_streamed(&StreamedFile::of(file))
    }

    /// Writes a file to the disk under a temporary name while its content is made.
    ///
    /// # Errors
    ///
    /// As [`ResultDirectory::stage`], and a number that no table may hold.
    pub fn stage_streamed(&mut self, file: &StreamedFile) -> Result<(), OutputError> {
        let staged = self.on_disk(file)?;
        self.staged.0.push((file.name.clone(), staged));
        Ok(())
    }

    /// Writes files to the disk under temporary names, on all threads.
    ///
    /// # Errors
    ///
    /// As [`ResultDirectory::stage_streamed`], for the first file that fails. No file is left then.
    pub fn written(&self, files: &[StreamedFile]) -> Result<StagedFiles, OutputError> {
        let spoken = language();
        let write =
            |file: &StreamedFile| in_language(spoken, || self.on_disk(file)).map(|staged| (file.name.clone(), staged));
        let written: Vec<Result<(String, TempPath), OutputError>> =
            files.par_iter().with_max_len(1).map(write).collect();
        written.into_iter().collect::<Result<Vec<_>, _>>().map(StagedFiles)
    }

    /// Adds files to the results, in the order in which they get their names.
    pub fn take(&mut self, files: StagedFiles) {
        self.staged.0.extend(files.0);
    }

    fn on_disk(&self, file: &StreamedFile) -> Result<TempPath, OutputError> {
        let mut staged = temporary(&self.path, STAGED)?;
        let mut writer = std::io::BufWriter::with_capacity(BLOCK, staged.as_file_mut());
        let unwritable = |error: &std::io::Error| super::streamed::unwritable(&file.name, error);
        let written = file.write_to(&mut writer).and_then(|()| writer.flush().map_err(|error| unwritable(&error)));
        // If a write failed, the rest of the buffer is dropped and not written.
        drop(writer.into_parts());
        let synced = written.and_then(|()| staged.as_file().sync_all().map_err(|error| unwritable(&error)));
        synced.map_err(|error| error.within(&self.path))?;
        Ok(staged.into_temp_path())
    }

    /// Gives all staged files their names, in the order of staging.
    ///
    /// Files that an earlier run lists in its summary and that this one does not write are removed, so that a directory never mixes
    /// two runs. All other files stay.
    ///
    /// # Errors
    ///
    /// A file cannot be renamed. Files that have not been renamed yet leave nothing behind.
    pub fn commit(self) -> Result<(), OutputError> {
        for (name, _) in &self.staged.0 {
            refuse_directory(&self.path.join(name))?;
        }
        let stale = files_of_an_earlier_run(&self.path);

        // From here on the directory is between two runs and has no summary.
        remove(&self.path.join(SUMMARY))?;
        for name in stale.iter().filter(|name| self.staged.0.iter().all(|(staged, _)| staged != *name)) {
            remove(&self.path.join(name))?;
        }
        for (name, staged) in self.staged.0 {
            let path = self.path.join(name);
            staged
                .persist(&path)
                .map_err(|error| OutputError::unwritable(&path, "the file cannot be renamed", &error.error))?;
        }

        // A rename lasts once the directory is on the disk. Some systems cannot sync a directory; the files themselves are safe by
        // now.
        if let Ok(directory) = std::fs::File::open(&self.path) {
            directory.sync_all().ok();
        }
        Ok(())
    }
}

/// Writes files into a directory, which is made if it is missing. Each file appears complete or not at all.
///
/// # Errors
///
/// The directory or a file cannot be made.
pub fn write_files(directory: &Path, files: &[ResultFile]) -> Result<(), OutputError> {
    make(directory)?;
    for file in files {
        let path = directory.join(&file.name);
        refuse_directory(&path)?;
        let mut staged = temporary(directory, WRITTEN)?;
        staged
            .write_all(&file.bytes)
            .and_then(|()| staged.as_file().sync_all())
            .map_err(|error| OutputError::unwritable(&path, "the file cannot be written", &error))?;
        staged
            .persist(&path)
            .map_err(|error| OutputError::unwritable(&path, "the file cannot be renamed", &error.error))?;
    }
    Ok(())
}

/// Makes a directory if it is missing.
fn make(path: &Path) -> Result<(), OutputError> {
    // For a dangling link the system reports only that it exists.
    if let (Ok(target), false) = (std::fs::read_link(path), path.exists()) {
        return Err(OutputError::Unwritable {
            path: path.to_path_buf(),
            what: "the directory is a link to a missing directory",
            got: format!("a link to {}, which does not exist", target.display()),
            remedy: "make the directory that the link points to, or name another one with --out",
        });
    }
    if path.exists() && !path.is_dir() {
        return Err(OutputError::Unwritable {
            path: path.to_path_buf(),
            what: "the directory cannot be made",
            got: "a file that has this name".to_owned(),
            remedy: "move that file, or name another directory with --out",
        });
    }
    std::fs::create_dir_all(path).map_err(|error| OutputError::unwritable(path, "the directory cannot be made", &error))
}

/// Keeps a second run out of the directory, on systems that can lock one.
fn locked(path: &Path) -> Result<Option<std::fs::File>, OutputError> {
    let Ok(directory) = std::fs::File::open(path) else { return Ok(None) };
    match directory.try_lock() {
        Ok(()) => Ok(Some(directory)),
        Err(std::fs::TryLockError::WouldBlock) => {
            let error = std::io::Error::from(std::io::ErrorKind::ResourceBusy);
            Err(OutputError::unwritable(path, "another run is writing its results there", &error))
        }
        Err(std::fs::TryLockError::Error(_)) => Ok(None),
    }
}

/// Directories that are open for results.
static OPENED: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

/// Keeps a directory in the list `OPENED` during its lifetime.
#[derive(Debug)]
struct Opened(PathBuf);

impl Opened {
    fn new(path: &Path) -> Opened {
        OPENED.lock().unwrap_or_else(PoisonError::into_inner).push(path.to_path_buf());
        Opened(path.to_path_buf())
    }
}

impl Drop for Opened {
    fn drop(&mut self) {
        let mut opened = OPENED.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(index) = opened.iter().position(|path| *path == self.0) {
            opened.swap_remove(index);
        }
    }
}

/// Removes files without their final names, for a process that ends at once and runs no destructors.
pub fn remove_unfinished_results() {
    if let Ok(opened) = OPENED.try_lock() {
        opened.iter().for_each(|path| remove_staged(path));
    }
}

/// Removes the staged files of a directory, as far as the system permits.
fn remove_staged(directory: &Path) {
    let Ok(entries) = std::fs::read_dir(directory) else {
        return;
    };
    let is_staged = |name: &str| name.starts_with(STAGED) && name.ends_with(TEMPORARY);
    let staged = entries.flatten().filter(|entry| entry.file_name().to_str().is_some_and(is_staged));
    staged.for_each(|entry| drop(std::fs::remove_file(entry.path())));
}

fn temporary(directory: &Path, prefix: &str) -> Result<NamedTempFile, OutputError> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(prefix).suffix(TEMPORARY);

    // Temporary files are private by default. Results are readable for all who may read this user's files.
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    builder
        .tempfile_in(directory)
        .map_err(|error| OutputError::unwritable(directory, "a file in it cannot be made", &error))
}

fn refuse_directory(path: &Path) -> Result<(), OutputError> {
    if !path.is_dir() {
        return Ok(());
    }
    let error = std::io::Error::from(std::io::ErrorKind::IsADirectory);
    Err(OutputError::unwritable(path, "a directory has the name of a result file", &error))
}

fn remove(path: &Path) -> Result<(), OutputError> {
    match std::fs::remove_file(path) {
        Err(error) if error.kind() != std::io::ErrorKind::NotFound => {
            Err(OutputError::unwritable(path, "a file of an earlier run cannot be removed", &error))
        }
        _ => Ok(()),
    }
}

/// Files that an earlier run's summary lists, if their names are names of luxmc's results.
fn files_of_an_earlier_run(directory: &Path) -> Vec<String> {
    let Ok(bytes) = std::fs::read(directory.join(SUMMARY)) else {
        return Vec::new();
    };
    let Ok(summary) = serde_json::from_slice::<serde_json::Value>(&bytes) else {
        return Vec::new();
    };
    let listed = summary["files"].as_array().cloned().unwrap_or_default();
    listed.iter().filter_map(|name| name.as_str()).filter(|name| is_own(name)).map(str::to_owned).collect()
}

fn is_own(name: &str) -> bool {
    let is_of_series = |(start, ends): &(&str, &[&str])| {
        let rest = name.strip_prefix(start);
        let part = rest.and_then(|rest| ends.iter().find_map(|end| rest.strip_suffix(end)));
        part.is_some_and(|part| part == super::file_name_part(part))
    };
    super::fixed_names().any(|fixed| fixed == name) || super::SERIES.iter().any(is_of_series)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file(name: &str, text: &str) -> ResultFile {
        ResultFile { name: name.into(), bytes: text.into() }
    }

    fn listing(path: &Path) -> Vec<String> {
        let entries = std::fs::read_dir(path).expect("the directory is there");
        let mut names: Vec<String> =
            entries.map(|entry| entry.expect("readable").file_name().to_string_lossy().into_owned()).collect();
        names.sort();
        names
    }

    /// The staged files of an interrupted run are removed when it ends with a message, or else by the next run. A file of another
    /// program, or an unfinished checkpoint, stays.
    #[test]
    fn what_a_killed_run_left_is_removed() {
        let home = tempfile::tempdir().expect("a temporary directory");
        let others = [".luxmc-a1B2c3.tmp", ".luxmc-result-notes.txt"];
        others.iter().for_each(|name| std::fs::write(home.path().join(name), "").expect("written"));
        let mut directory = ResultDirectory::open(home.path()).expect("writable");
        directory.stage(&file("receivers.csv", "old")).expect("staged");
        assert_eq!(listing(home.path()).len(), 3);
        // Other tests have directories open, too.
        let is_reported = || OPENED.lock().expect("whole").iter().any(|path| path == home.path());
        assert!(is_reported());
        remove_staged(home.path());
        assert_eq!(listing(home.path()), others);
        directory.stage(&file("receivers.csv", "old")).expect("staged");
        // A killed process runs no destructors.
        directory.staged.0.drain(..).for_each(|(_, staged)| drop(staged.keep().expect("kept")));
        drop(directory);
        assert!(!is_reported());
        assert_eq!(listing(home.path()).len(), 3);
        drop(ResultDirectory::open(home.path()).expect("writable"));
        assert_eq!(listing(home.path()), others);
    }

    fn run(path: &Path, files: &[ResultFile]) {
        let mut directory = ResultDirectory::open(path).expect("writable");
        for file in files {
            directory.stage(file).expect("staged");
        }
        directory.commit().expect("committed");
    }

    #[test]
    fn nothing_shows_before_the_commit_and_nothing_stays_without_it() {
        let home = tempfile::tempdir().expect("a temporary directory");
        let path = home.path().join("a/b");
        let mut directory = ResultDirectory::open(&path).expect("writable");
        assert!(listing(&path).is_empty());
        directory.stage(&file("tables.csv", "x\n")).expect("staged");
        assert!(!path.join("tables.csv").exists());
        drop(directory);
        assert!(listing(&path).is_empty());
    }

    /// Files that several threads write are in the order in which they were named, in the current language. If one file fails, none
    /// of them stays.
    #[test]
    fn files_written_at_a_time_keep_their_order_or_leave_nothing() {
        let home = tempfile::tempdir().expect("a temporary directory");
        let mut directory = ResultDirectory::open(home.path()).expect("writable");
        let german = crate::output::Language::of_code("de").expect("there is German");
        let told = |number: usize| StreamedFile::later(format!("map-{number}.svg"), || file("", language().code()));
        let files: Vec<StreamedFile> = (0..100).map(told).collect();
        let staged = in_language(german, || directory.written(&files)).expect("written");
        directory.take(staged);
        assert_eq!(directory.names(), (0..100).map(|number| format!("map-{number}.svg")).collect::<Vec<_>>());
        let refused = StreamedFile::new("tables.csv", |_| {
            Err(super::super::streamed::unwritable("tables.csv", &std::io::ErrorKind::StorageFull.into()))
        });
        let files = [told(100), refused, told(101)];
        assert!(directory.written(&files).is_err());
        directory.commit().expect("committed");
        let listed = listing(home.path());
        assert_eq!(listed.len(), 100, "{listed:?}");
        assert_eq!(std::fs::read_to_string(home.path().join("map-7.svg")).expect("there"), "de");
    }

    /// Staged files are closed: a system lets a process open a thousand files or fewer, and each receiver set may bring some.
    #[cfg(target_os = "linux")]
    #[test]
    fn staged_files_are_not_kept_open() {
        let home = tempfile::tempdir().expect("a temporary directory");
        let open_in_it = || {
            let all = std::fs::read_dir("/proc/self/fd").expect("told").flatten();
            all.filter_map(|entry| std::fs::read_link(entry.path()).ok())
                .filter(|to| to.starts_with(home.path()))
                .count()
        };
        let mut directory = ResultDirectory::open(home.path()).expect("writable");
        let before = open_in_it();
        for number in 0..40 {
            directory.stage(&file(&format!("map-{number}.svg"), "x")).expect("staged");
        }
        assert_eq!(open_in_it(), before);
        directory.commit().expect("committed");
        assert_eq!(listing(home.path()).len(), 40);
    }

    #[test]
    fn a_second_run_takes_away_its_own_stale_files_and_no_others() {
        let home = tempfile::tempdir().expect("a temporary directory");
        let path = home.path();
        std::fs::write(path.join("report.html"), "of someone else").expect("written");
        std::fs::write(path.join("notes.txt"), "foreign").expect("written");
        let listed = r#"{"files": ["elements.csv", "map-a.svg", "grid-a.pts", "intensity.csv", "intensity-a.ies", "tables.csv",
            "notes.txt", "../notes.txt"]}"#;
        let names = ["elements.csv", "map-a.svg", "grid-a.pts", "intensity.csv", "intensity-a.ies", "tables.csv"];
        let first: Vec<ResultFile> =
            names.map(|name| file(name, "1")).into_iter().chain([file(SUMMARY, listed)]).collect();
        run(path, &first);
        run(path, &[file("tables.csv", "2"), file(SUMMARY, "{}")]);
        assert_eq!(listing(path), ["notes.txt", "report.html", SUMMARY, "tables.csv"]);
        assert_eq!(std::fs::read_to_string(path.join("tables.csv")).expect("there"), "2");
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn a_directory_in_use_is_refused_and_free_again_after_it() {
        let home = tempfile::tempdir().expect("a temporary directory");
        let first = ResultDirectory::open(home.path()).expect("writable");
        let error = ResultDirectory::open(home.path()).expect_err("in use").to_string();
        assert!(error.contains("another run") && error.contains("wait"), "{error}");
        drop(first);
        assert!(ResultDirectory::open(home.path()).is_ok());
    }

    #[cfg(unix)]
    #[test]
    fn a_link_that_leads_nowhere_is_reported_as_one() {
        let home = tempfile::tempdir().expect("a temporary directory");
        let link = home.path().join("link");
        std::os::unix::fs::symlink(home.path().join("absent"), &link).expect("linked");
        let error = ResultDirectory::open(&link).expect_err("it leads nowhere").to_string();
        assert!(error.contains("link to a missing directory") && error.contains("absent"), "{error}");
        std::fs::create_dir(home.path().join("absent")).expect("made");
        assert!(ResultDirectory::open(&link).is_ok());
    }

    #[test]
    fn a_path_below_a_file_is_refused() {
        let home = tempfile::tempdir().expect("a temporary directory");
        std::fs::write(home.path().join("f"), "").expect("written");
        assert!(ResultDirectory::open(&home.path().join("f")).is_err());
        assert!(ResultDirectory::open(&home.path().join("f/below")).is_err());
    }
}
