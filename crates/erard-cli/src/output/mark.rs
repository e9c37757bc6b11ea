//! The file that says whose results a folder holds.

use std::collections::BTreeMap;
use std::fs;
use std::io::{Read, Write};
use std::path::Path;

use serde::{Deserialize, Serialize};

/// Its name.
pub(crate) const NAME: &str = ".erard.json";
const FORMAT: &str = "erard-results/1";
/// Most bytes that are read of it: thousands of names.
const MAX_BYTES: u64 = 1 << 20;

/// Whose results a folder holds.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Mark {
    format: String,
    /// Whether the folder was not there before.
    pub made_folder: bool,
    /// The results of every command, by their names.
    results: BTreeMap<String, Vec<String>>,
}

impl Mark {
    /// The same after a command has written these files, and no others of its own any more.
    pub(crate) fn with(before: Option<Self>, made_folder: bool, command: &str, files: &[String]) -> Self {
        let mut results = before.map(|mark| mark.results).unwrap_or_default();
        for others in results.values_mut() {
            others.retain(|name| !files.contains(name));
        }
        results.insert(command.into(), files.to_vec());
        results.retain(|_, files| !files.is_empty());
        Mark { format: FORMAT.into(), made_folder, results }
    }

    /// A command's results.
    #[must_use]
    pub(crate) fn of(&self, command: &str) -> &[String] {
        self.results.get(command).map_or(&[], Vec::as_slice)
    }

    /// The command that wrote a file.
    #[must_use]
    pub(crate) fn owner(&self, name: &str) -> Option<&str> {
        self.results
            .iter()
            .find(|(_, files)| files.iter().any(|file| file == name))
            .map(|(command, _)| command.as_str())
    }

    /// Whether it knows of no other command.
    #[must_use]
    pub(crate) fn is_only(&self, command: &str) -> bool {
        self.results.keys().all(|known| known == command)
    }

    /// A folder's; `None` where it has none that can be understood: then nothing in it is known to be Erard's.
    #[must_use]
    pub(crate) fn read(folder: &Path) -> Option<Self> {
        let path = folder.join(NAME);
        // A pipe of this name would be waited for.
        path.symlink_metadata().ok().filter(|found| found.is_file())?;
        let mut text = String::new();
        fs::File::open(path).ok()?.take(MAX_BYTES).read_to_string(&mut text).ok()?;
        let mark: Mark = serde_json::from_str(&text).ok()?;
        (mark.format == FORMAT && mark.results.values().flatten().all(|name| is_plain(name))).then_some(mark)
    }

    /// Writes it.
    ///
    /// # Errors
    /// Of the file system.
    pub(crate) fn write(&self, path: &Path) -> std::io::Result<()> {
        let mut text = serde_json::to_string_pretty(self)?;
        text.push('\n');
        let mut file = fs::File::create_new(path)?;
        file.write_all(text.as_bytes())?;
        file.sync_all()
    }
}

/// Whether a name is that of a file in the folder itself, and not a way out of it.
pub(crate) fn is_plain(name: &str) -> bool {
    let mut parts = Path::new(name).components();
    matches!((parts.next(), parts.next()), (Some(std::path::Component::Normal(part)), None) if part == name)
}
