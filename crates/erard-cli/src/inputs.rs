//! The files that a session reads: every file is opened once, so that a pipe can be one, and remembered, so that it
//! is never replaced.

use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

pub use erard::files::{clipped, shown};
use erard::instrument::{FileError, file_bytes};
use same_file::Handle;

/// Most bytes of a library.
const MAX_LIBRARY_BYTES: u64 = 256 << 20;

/// Files that have been opened for reading.
#[derive(Debug, Default)]
pub struct Inputs {
    read: Vec<Handle>,
}

impl Inputs {
    /// Opens a file to be read, once.
    ///
    /// # Errors
    /// Of the file system.
    pub(crate) fn open(&mut self, path: &Path) -> io::Result<File> {
        let file = File::open(path)?;
        self.read.push(Handle::from_file(file.try_clone()?)?);
        Ok(file)
    }

    /// The first bytes of a file, so many at most.
    ///
    /// # Errors
    /// Of the file system.
    pub(crate) fn beginning(&mut self, path: &Path, most: u64) -> io::Result<Vec<u8>> {
        let mut bytes = Vec::new();
        self.open(path)?.take(most).read_to_end(&mut bytes)?;
        Ok(bytes)
    }

    /// The bytes of a text file (instrument, keyboard, linkage), and its name as messages show it.
    ///
    /// # Errors
    /// Where it cannot be read, or is longer than any such file; then no more of it is read.
    pub fn bytes(&mut self, path: &Path) -> Result<(String, Vec<u8>), Box<FileError>> {
        let name = shown(path);
        let bytes = file_bytes(self.open(path), &name)?;
        Ok((name, bytes))
    }

    /// The bytes of a library.
    ///
    /// # Errors
    /// Why it cannot be one: no file, too large, or an error of the file system.
    pub(crate) fn library(&mut self, path: &Path) -> Result<Vec<u8>, String> {
        let found = path.metadata().map_err(|error| error.to_string())?;
        if !found.is_file() {
            return Err("is not a file; expected the library liberard".into());
        }
        if found.len() > MAX_LIBRARY_BYTES {
            return Err(format!("larger than {} MiB: this is not liberard", MAX_LIBRARY_BYTES >> 20));
        }
        self.beginning(path, MAX_LIBRARY_BYTES).map_err(|error| error.to_string())
    }

    /// Remembers standard input, where it is a file.
    pub(crate) fn standard_input(&mut self) {
        self.read.extend(Handle::stdin().ok());
    }

    /// Remembers a file that somebody else reads for this session.
    pub(crate) fn remember(&mut self, path: &Path) {
        if let Ok(handle) = handle(path) {
            self.read.push(handle);
        }
    }

    /// Whether a path leads, by whatever links, to a file that this session reads.
    #[must_use]
    pub(crate) fn is_one(&self, path: &Path) -> bool {
        handle(path).is_ok_and(|handle| self.read.contains(&handle))
    }
}

fn handle(path: &Path) -> io::Result<Handle> {
    // To open a pipe would be to wait for it.
    if !path.metadata()?.is_file() {
        return Err(io::ErrorKind::InvalidInput.into());
    }
    Handle::from_path(path)
}
