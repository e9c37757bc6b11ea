//! Files that are renamed one by one into a folder that holds others too, so that all of them arrive or none.
//!
//! Before the first is renamed all stand whole in the stage, and a journal beside them says what is to be done. From
//! then on it is decided: who finds the journal finishes, or where that cannot be, undoes. A failure undoes at once.

use std::fs;
use std::io::{self, Write};
use std::path::Path;

use serde::{Deserialize, Serialize};

use super::mark::is_plain;

/// What was there before.
pub(super) const OLD: &str = "old";
const NAME: &str = "journal.json";
/// Name until it is whole.
const DRAFT: &str = "journal.draft";
const FORMAT: &str = "erard-journal/1";

/// What is to be done.
#[derive(Debug, Serialize, Deserialize)]
struct Journal {
    format: String,
    /// Files that come from the stage.
    install: Vec<String>,
    /// Files that go, and nothing in their place.
    remove: Vec<String>,
}

/// Whether a file of a stage is a journal.
pub(crate) fn is_file(name: &str) -> bool {
    [NAME, DRAFT].contains(&name)
}

/// Renames the files of a stage into a folder. A failure names the file, and leaves the folder as it was.
pub(crate) fn publish(
    stage: &Path,
    folder: &Path,
    install: &[String],
    remove: &[String],
) -> Result<(), (String, io::Error)> {
    let journal = Journal { format: FORMAT.into(), install: install.to_vec(), remove: remove.to_vec() };
    journal.write(stage).map_err(|error| (String::new(), error))?;
    journal.finish(stage, folder).inspect_err(|_| {
        let _ = journal.undo(stage, folder).and_then(|()| fs::remove_file(stage.join(NAME)));
    })?;
    fs::remove_file(stage.join(NAME)).map_err(|error| (String::new(), error))
}

/// Finishes or undoes what a killed process had begun.
pub(crate) fn recover(stage: &Path, folder: &Path) -> io::Result<()> {
    let Ok(text) = fs::read_to_string(stage.join(NAME)) else { return Ok(()) };
    let journal: Journal = serde_json::from_str(&text)?;
    if journal.format != FORMAT || !journal.names().all(|name| is_plain(name)) {
        return Err(io::Error::other(format!("{}: not a journal of this program", stage.join(NAME).display())));
    }
    journal.finish(stage, folder).or_else(|_| journal.undo(stage, folder))
}

impl Journal {
    fn names(&self) -> impl Iterator<Item = &String> {
        self.remove.iter().chain(&self.install)
    }

    /// Appears whole or not at all.
    fn write(&self, stage: &Path) -> io::Result<()> {
        fs::create_dir(stage.join(OLD))?;
        let draft = stage.join(DRAFT);
        let mut file = fs::File::create_new(&draft)?;
        file.write_all(&serde_json::to_vec(self)?)?;
        file.sync_all()?;
        fs::rename(draft, stage.join(NAME))
    }

    /// Can be called again where it was cut off.
    fn finish(&self, stage: &Path, folder: &Path) -> Result<(), (String, io::Error)> {
        for name in &self.remove {
            set_aside(stage, folder, name).map_err(|error| (name.clone(), error))?;
        }
        for name in &self.install {
            let new = stage.join("results").join(name);
            if new.symlink_metadata().is_ok() {
                set_aside(stage, folder, name)
                    .and_then(|()| fs::rename(&new, folder.join(name)))
                    .map_err(|error| (name.clone(), error))?;
            }
        }
        Ok(())
    }

    fn undo(&self, stage: &Path, folder: &Path) -> io::Result<()> {
        for name in self.names() {
            let (new, old, place) = (stage.join("results").join(name), stage.join(OLD).join(name), folder.join(name));
            let arrived = self.install.contains(name) && new.symlink_metadata().is_err();
            if arrived {
                fs::rename(&place, &new)?;
            }
            if old.symlink_metadata().is_ok() {
                fs::rename(&old, &place)?;
            }
        }
        Ok(())
    }
}

/// What stands under a name goes into the stage, unless it has gone before.
fn set_aside(stage: &Path, folder: &Path, name: &str) -> io::Result<()> {
    let (old, place) = (stage.join(OLD).join(name), folder.join(name));
    match place.symlink_metadata() {
        Ok(found) if found.is_dir() => Err(io::Error::from(io::ErrorKind::IsADirectory)),
        // Another command may have set it aside meanwhile.
        Ok(_) if old.symlink_metadata().is_err() => unless_gone(fs::rename(place, old)),
        _ => Ok(()),
    }
}

/// A result, or none where what it was about has gone meanwhile.
fn unless_gone(result: io::Result<()>) -> io::Result<()> {
    result.or_else(|error| if error.kind() == io::ErrorKind::NotFound { Ok(()) } else { Err(error) })
}
