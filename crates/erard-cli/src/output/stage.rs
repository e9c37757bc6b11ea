//! A folder of an unpredictable name in which files are written before they appear.
//!
//! ```text
//! .NAME.XXXXXX.erard.part/   beside the folder NAME, or .erard.XXXXXX.erard.part/ within it
//!     lock                held while its process lives: who can take it may clear the stage away
//!     results/            what is to appear
//!     old/                what was there before
//!     journal.json        there while files are renamed one by one
//! ```

use std::fs::{self, File, TryLockError};
use std::io;
use std::path::{Path, PathBuf};

use tempfile::TempDir;

use super::exchange::exchange;
use super::journal::{self, OLD};
use crate::stages::{LOCK, Stages, remove_empty};

/// How its name ends: a user's folder is not likely to be called so, and what a stage does not hold is checked too.
const END: &str = ".erard.part";
/// How a stage within a folder begins.
const WITHIN: &str = ".erard.";
const RESULTS: &str = "results";

/// A stage of a session. Dropping it removes its folder.
#[derive(Debug)]
pub(crate) struct Stage {
    stages: Stages,
    folder: TempDir,
    /// Held open for its lock.
    _lock: File,
    beside: bool,
    /// Folders that did not exist before, outermost first: taken away again if nothing comes of it.
    made: Vec<PathBuf>,
}

impl Stage {
    /// Beside a folder, which need not exist yet.
    pub(crate) fn beside(stages: &Stages, folder: &Path) -> io::Result<Self> {
        let parent = parent(folder);
        let mut made: Vec<PathBuf> = parent
            .ancestors()
            .take_while(|f| !f.as_os_str().is_empty() && !f.exists())
            .map(Path::to_path_buf)
            .collect();
        made.reverse();
        let mut open = stages.open();
        let stage = fs::create_dir_all(&parent).and_then(|()| Self::new(stages, &prefix(folder), &parent, &mut open));
        let mut stage = stage.inspect_err(|_| remove_empty(&made))?;
        open.extend(made.iter().cloned());
        drop(open);
        stage.beside = true;
        stage.made = made;
        if let Ok(found) = fs::metadata(folder) {
            fs::set_permissions(stage.results(), found.permissions())?;
        }
        Ok(stage)
    }

    /// Within a folder that exists.
    pub(crate) fn within(stages: &Stages, folder: &Path) -> io::Result<Self> {
        Self::new(stages, WITHIN, folder, &mut stages.open())
    }

    /// What a stage beside a folder holds, within it.
    pub(crate) fn moved_into(folder: &Path, other: &Stage) -> io::Result<Self> {
        let stage = Self::within(&other.stages, folder)?;
        fs::remove_dir(stage.results())?;
        fs::rename(other.results(), stage.results())?;
        Ok(stage)
    }

    fn new(stages: &Stages, prefix: &str, parent: &Path, open: &mut Vec<PathBuf>) -> io::Result<Self> {
        loop {
            let folder = tempfile::Builder::new().prefix(prefix).suffix(END).tempdir_in(parent)?;
            let path = folder.path().join(LOCK);
            // Somebody who clears up may take it for one that a killed process left, until it is locked.
            let lock = match File::create_new(&path) {
                Ok(lock) => lock,
                Err(error) if error.kind() != io::ErrorKind::AlreadyExists && folder.path().exists() => {
                    return Err(io::Error::other("a temporary folder cannot be written to"));
                }
                Err(_) => continue,
            };
            // Where files cannot be locked, nobody clears up either.
            let _ = lock.lock();
            if !path.exists() {
                continue;
            }
            open.push(folder.path().to_path_buf());
            // Made by the usual rules, whatever those for temporary folders are: it is to stay.
            fs::create_dir(folder.path().join(RESULTS))?;
            return Ok(Stage { stages: stages.clone(), folder, _lock: lock, beside: false, made: Vec::new() });
        }
    }

    /// The stage's own folder.
    pub(crate) fn path(&self) -> &Path {
        self.folder.path()
    }

    /// Where files are written.
    pub(crate) fn results(&self) -> PathBuf {
        self.folder.path().join(RESULTS)
    }

    /// Whether it lies beside the folder.
    pub(crate) fn is_beside(&self) -> bool {
        self.beside
    }

    /// The results become the folder; what it held before goes into the stage.
    pub(crate) fn take_the_place_of(&self, folder: &Path) -> io::Result<()> {
        let results = self.results();
        if !folder.exists() {
            return fs::rename(results, folder);
        }
        if exchange(&results, folder)? {
            return Ok(());
        }
        let old = self.folder.path().join(OLD);
        fs::rename(folder, &old)?;
        fs::rename(&results, folder).inspect_err(|_| {
            let _ = fs::rename(&old, folder);
        })
    }

    /// Something has come of it.
    pub(crate) fn keep_parents(&mut self) {
        let made = std::mem::take(&mut self.made);
        self.stages.open().retain(|folder| !made.contains(folder));
    }
}

impl Drop for Stage {
    fn drop(&mut self) {
        // What cannot be removed now, the next command clears away.
        let _ = fs::remove_dir_all(self.folder.path());
        remove_empty(&self.made);
        self.stages.open().retain(|folder| folder != self.folder.path() && !self.made.contains(folder));
    }
}

/// Clears up after processes that were killed while they wrote results for a folder: finishes what they had decided,
/// and removes the rest.
///
/// # Errors
/// Of the file system, where a decided exchange can be neither finished nor undone.
pub(crate) fn recover(folder: &Path) -> io::Result<()> {
    for stage in stages(&parent(folder), &prefix(folder)) {
        let Some(_lock) = take_over(&stage) else { continue };
        let old = stage.join(OLD);
        if old.exists() && !folder.exists() {
            fs::rename(&old, folder)?;
        }
        clear(&stage)?;
    }
    for stage in stages(folder, WITHIN) {
        let Some(_lock) = take_over(&stage) else { continue };
        journal::recover(&stage, folder)?;
        clear(&stage)?;
    }
    Ok(())
}

/// Removes a stage that was taken over. Its process, or another that clears up, may be about to do the same: what is
/// gone is done, and what has come meanwhile is theirs.
fn clear(stage: &Path) -> io::Result<()> {
    match fs::remove_dir_all(stage) {
        Err(error) if [io::ErrorKind::NotFound, io::ErrorKind::DirectoryNotEmpty].contains(&error.kind()) => Ok(()),
        cleared => cleared,
    }
}

/// Whether a folder holds nothing but what a stage may hold: nothing of a user's is removed with it.
fn is_stage(folder: &Path) -> bool {
    let known = |name: &str| [LOCK, RESULTS, OLD].contains(&name) || journal::is_file(name);
    let Ok(mut entries) = fs::read_dir(folder) else { return false };
    entries.all(|entry| entry.is_ok_and(|entry| entry.file_name().to_str().is_some_and(known)))
}

/// The lock of a stage whose process lives no more; `None` where it lives, or where nobody can tell.
fn take_over(stage: &Path) -> Option<File> {
    let path = stage.join(LOCK);
    let lock = match File::open(&path) {
        // Its process died before it made one; or it lives, and finds that it must try another name.
        Err(error) if error.kind() == io::ErrorKind::NotFound => File::create_new(&path),
        found => found,
    }
    .ok()?;
    match lock.try_lock() {
        Ok(()) => Some(lock),
        Err(TryLockError::WouldBlock | TryLockError::Error(_)) => None,
    }
}

fn stages(folder: &Path, prefix: &str) -> Vec<PathBuf> {
    let Ok(entries) = fs::read_dir(folder) else { return Vec::new() };
    let named = entries.filter_map(Result::ok).filter(|entry| {
        let name = entry.file_name();
        let random = name.to_str().and_then(|name| name.strip_prefix(prefix)?.strip_suffix(END));
        random.is_some_and(|random| random.len() == 6 && random.chars().all(|c| c.is_ascii_alphanumeric()))
            && entry.file_type().is_ok_and(|kind| kind.is_dir())
            && is_stage(&entry.path())
    });
    named.map(|entry| entry.path()).collect()
}

/// How the stages beside a folder begin.
fn prefix(folder: &Path) -> String {
    format!(".{}.", folder.file_name().unwrap_or_default().to_string_lossy())
}

fn parent(folder: &Path) -> PathBuf {
    folder.parent().filter(|f| !f.as_os_str().is_empty()).unwrap_or(Path::new(".")).to_path_buf()
}
