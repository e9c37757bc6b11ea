//! The outputs of a command: files in a folder, all of them or none.
//!
//! One rule for all commands: **a result belongs to the command that wrote it.** A small file in the folder, its mark,
//! says which results are whose. A command replaces its own, and takes away those that it no longer makes. What another
//! command wrote, or nobody that is known, is replaced with `--force` only; what a command reads is never replaced.
//!
//! Files are written in a `Stage`, a folder of an unpredictable name beside the results. When all are whole they
//! appear: a folder that Erard made and that holds nothing else changes places with the stage in one operation of the
//! file system; in any other the files are renamed one by one, under a `journal` that lets the next command finish what
//! a killed one began.

mod exchange;
mod journal;
mod mark;
mod stage;

use std::collections::BTreeSet;
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};

use erard_figures::Picture;
use serde::Serialize;

use crate::failure::Failure;
use crate::identity;
use crate::inputs::{self, Inputs};
use crate::session::Session;
use crate::table::{TABLE, Table, as_parquet, beside, is_beside_a_table};
pub(crate) use mark::Mark;
use stage::Stage;

/// Files that a command collects for a folder. Nothing stands there under its own name before [`Output::commit`].
#[derive(Debug)]
pub struct Output {
    /// As the user named it.
    folder: PathBuf,
    /// Whose results these are; `None` for files that belong to the user at once, which are never replaced without
    /// `force`.
    command: Option<&'static str>,
    force: bool,
    names: Vec<String>,
    stage: Stage,
}

/// Writes a file's contents.
type Writes<'a> = dyn FnMut(&mut dyn Write) -> std::io::Result<()> + 'a;

impl Output {
    /// Results of a command. Makes sure, before any long work, that the folder can be written to and that nothing
    /// stands in the way of the files that are certain to come.
    ///
    /// # Errors
    /// [`Failure::Write`]; [`Failure::Usage`] where something stands in the way.
    pub(crate) fn results(
        session: &Session,
        folder: &Path,
        command: &'static str,
        force: bool,
        certain: &[&str],
    ) -> Result<Self, Failure> {
        Self::prepare(session, folder, Some(command), force, certain)
    }

    /// Files for the user to keep, among others of theirs.
    ///
    /// # Errors
    /// As [`Output::results`].
    pub(crate) fn files(session: &Session, folder: &Path, force: bool, certain: &[&str]) -> Result<Self, Failure> {
        Self::prepare(session, folder, None, force, certain)
    }

    fn prepare(
        session: &Session,
        folder: &Path,
        command: Option<&'static str>,
        force: bool,
        certain: &[&str],
    ) -> Result<Self, Failure> {
        let refused = |source| Failure::write(folder, source);
        stage::recover(folder).map_err(refused)?;
        // A loop of links, or what may not be looked at: found before any work.
        if let Err(error) = folder.metadata()
            && error.kind() != std::io::ErrorKind::NotFound
        {
            return Err(refused(error));
        }
        if folder.exists() && !folder.is_dir() {
            return Err(refused(std::io::Error::other("this is a file; expected a folder")));
        }
        let place = Place { folder, command, force, inputs: &session.inputs };
        let tables = certain.iter().filter(|name| name.ends_with(TABLE));
        let tables = tables
            .flat_map(|name| [beside(name), as_parquet(name)].into_iter().take(1 + usize::from(command.is_some())));
        place.check(&certain.iter().map(|name| (*name).to_owned()).chain(tables).collect::<Vec<_>>())?;
        let stage = if place.is_whole() || !folder.exists() {
            // Where nothing can be made beside the folder, there may be room within it.
            match Stage::beside(&session.stages, folder) {
                Err(_) if folder.exists() => Stage::within(&session.stages, folder),
                stage => stage,
            }
        } else {
            Stage::within(&session.stages, folder)
        };
        Ok(Output { folder: folder.to_path_buf(), command, force, names: Vec::new(), stage: stage.map_err(refused)? })
    }

    /// Writes a file, to appear under this name; with what made it in it where its kind can hold that
    /// ([`identity::stamped`]).
    ///
    /// # Errors
    /// [`Failure::Write`].
    pub(crate) fn stage(
        &mut self,
        session: &Session,
        name: &str,
        write: impl FnOnce(&mut dyn Write) -> std::io::Result<()>,
    ) -> Result<(), Failure> {
        // What follows is compiled once, not for each caller.
        let mut write = Some(write);
        self.put(session, name, &mut |writer| write.take().map_or(Ok(()), |write| write(writer)))
    }

    /// Writes a table as CSV, and beside it the units of its columns and what made it, which a CSV cannot hold. Results
    /// of a command are written as Parquet, too; a file that the user has named is that file alone.
    ///
    /// # Errors
    /// [`Failure::Write`].
    pub fn table(&mut self, session: &Session, name: &str, table: &Table<'_>) -> Result<(), Failure> {
        self.stage(session, name, |writer| table.write_csv(writer))?;
        self.json(session, &beside(name), &table.metadata(name))?;
        if self.command.is_some() {
            let title = name.strip_suffix(TABLE).unwrap_or(name);
            let made_by = session.provenance.made_by();
            self.stage(session, &as_parquet(name), |writer| table.write_parquet(title, &made_by, writer))?;
        }
        Ok(())
    }

    /// A file without a name beside the results, for what is too long to be held; gone with its handle. It may be made
    /// on any thread.
    pub(crate) fn spools(&self) -> impl Fn() -> std::io::Result<fs::File> + Sync + use<> {
        let folder = self.stage.path().to_path_buf();
        move || tempfile::tempfile_in(&folder)
    }

    /// Writes text.
    ///
    /// # Errors
    /// [`Failure::Write`].
    pub fn text(&mut self, session: &Session, name: &str, text: &str) -> Result<(), Failure> {
        self.stage(session, name, |writer| writer.write_all(text.as_bytes()))
    }

    /// Writes a value as JSON, indented.
    ///
    /// # Errors
    /// [`Failure::Write`].
    pub fn json(&mut self, session: &Session, name: &str, value: &impl Serialize) -> Result<(), Failure> {
        self.stage(session, name, |writer| {
            serde_json::to_writer_pretty(&mut *writer, value)?;
            writer.write_all(b"\n")
        })
    }

    /// Writes a figure twice: `NAME.svg`, and `NAME.png` of twice its size.
    ///
    /// # Errors
    /// [`Failure::Write`]; [`Failure::Internal`] where it cannot be drawn.
    pub fn figure(&mut self, session: &Session, name: &str, picture: &Picture) -> Result<(), Failure> {
        self.picture(session, name, picture, 2.0)
    }

    /// Writes a picture twice: `NAME.svg`, and `NAME.png` of so many times its size.
    ///
    /// # Errors
    /// [`Failure::Write`]; [`Failure::Internal`] where it cannot be drawn.
    pub fn picture(&mut self, session: &Session, name: &str, picture: &Picture, scale: f64) -> Result<(), Failure> {
        let png = picture.png(scale).map_err(|error| Failure::Internal(error.to_string()))?;
        self.text(session, &format!("{name}.svg"), &picture.svg())?;
        self.stage(session, &format!("{name}.png"), |writer| writer.write_all(&png))
    }

    fn put(&mut self, session: &Session, name: &str, write: &mut Writes) -> Result<(), Failure> {
        let refused = |source| Failure::write(&self.folder.join(name), source);
        let file = fs::File::create_new(self.stage.results().join(name)).map_err(refused)?;
        let mut writer = std::io::BufWriter::new(file);
        if identity::is_stamped(name) {
            let mut bytes = Vec::new();
            write(&mut bytes).map_err(refused)?;
            let bytes = identity::stamped(&session.provenance.made_by(), name, bytes);
            writer.write_all(&bytes).and_then(|()| writer.flush()).map_err(refused)?;
        } else {
            write(&mut writer).and_then(|()| writer.flush()).map_err(refused)?;
        }
        // Some file systems find out that they are full no earlier.
        writer.get_ref().sync_all().map_err(refused)?;
        self.names.push(name.to_owned());
        Ok(())
    }

    /// Gives all files their names; returns what to say of them.
    ///
    /// # Errors
    /// [`Failure::Write`]; [`Failure::Usage`] where something has come to stand in the way. Either leaves the folder as
    /// it was.
    pub fn commit(mut self, session: &Session) -> Result<Written, Failure> {
        // Whoever wants to end the program now waits until this is done.
        let _undisturbed = session.stop.hold();
        let folder = self.folder.clone();
        let refused = |source| Failure::write(&folder, source);
        let place = Place { folder: &folder, command: self.command, force: self.force, inputs: &session.inputs };
        loop {
            place.check(&self.names)?;
            let whole = self.stage.is_beside() && (place.is_whole() || !folder.exists());
            if let Some(command) = self.command {
                let before = Mark::read(&folder);
                let made_folder = whole || before.as_ref().is_some_and(|mark| mark.made_folder);
                let mark = Mark::with(before, made_folder, command, &self.names);
                mark.write(&self.stage.results().join(mark::NAME)).map_err(refused)?;
            }
            if whole {
                match self.stage.take_the_place_of(&folder) {
                    // Another command has made the folder since it was looked at.
                    Err(error) if error.kind() == std::io::ErrorKind::DirectoryNotEmpty => {
                        let _ = fs::remove_file(self.stage.results().join(mark::NAME));
                        continue;
                    }
                    placed => placed.map_err(refused)?,
                }
            } else {
                if self.stage.is_beside() {
                    // Something of the user's has come into the folder since.
                    self.stage = Stage::moved_into(&folder, &self.stage).map_err(refused)?;
                }
                let mark = self.command.map(|_| mark::NAME.to_owned());
                let install: Vec<String> = mark.into_iter().chain(self.names.iter().cloned()).collect();
                let remove = place.stale(&self.names);
                journal::publish(self.stage.path(), &folder, &install, &remove)
                    .map_err(|(name, source)| Failure::write(&folder.join(name), source))?;
            }
            break;
        }
        self.stage.keep_parents();
        Ok(Written { folder, names: std::mem::take(&mut self.names) })
    }
}

/// The files that a command wrote.
#[derive(Debug)]
pub struct Written {
    folder: PathBuf,
    names: Vec<String>,
}

impl Written {
    /// All of them, with the tables' metadata.
    pub(crate) fn paths(&self) -> impl Iterator<Item = PathBuf> {
        self.names.iter().map(|name| self.folder.join(name))
    }
}

impl Written {
    /// The file to open first, and how many there are beside it.
    pub(crate) fn brief(&self) -> String {
        let names: Vec<&String> = self.names.iter().filter(|name| !is_beside_a_table(name)).collect();
        let first = [".html", ".csv"].iter().find_map(|end| names.iter().find(|name| name.ends_with(end)));
        let Some(first) = first.filter(|_| names.len() > 3) else { return self.to_string() };
        format!("Written to {}: {first} and {} more files", inputs::shown(&self.folder), names.len() - 1)
    }
}

impl std::fmt::Display for Written {
    /// Without the tables' metadata: nobody opens those by hand.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let names: Vec<&String> = self.names.iter().filter(|name| !is_beside_a_table(name)).collect();
        write!(f, "Written to {}: {}", inputs::shown(&self.folder), shortened(&names).join(", "))
    }
}

/// From so many files on whose names differ in digits only, the first and the last of them are named.
const MANY: usize = 6;

/// The names, with a line of numbered pages as its ends and their number.
fn shortened(names: &[&String]) -> Vec<String> {
    let kind = |name: &str| name.replace(|c: char| c.is_ascii_digit(), "");
    let mut kinds: Vec<(String, Vec<&str>)> = Vec::new();
    for name in names {
        match kinds.iter_mut().find(|(known, _)| *known == kind(name)) {
            Some((_, alike)) => alike.push(name),
            None => kinds.push((kind(name), vec![name])),
        }
    }
    let shown = kinds.into_iter().flat_map(|(_, alike)| match &alike[..] {
        [first, .., last] if alike.len() >= MANY => vec![format!("{first} to {last} ({} files)", alike.len())],
        _ => alike.into_iter().map(str::to_owned).collect(),
    });
    shown.collect()
}

/// A folder and who wants to write into it.
struct Place<'a> {
    folder: &'a Path,
    command: Option<&'static str>,
    force: bool,
    inputs: &'a Inputs,
}

impl Place<'_> {
    /// Refuses where a file of these names would replace what it must not.
    fn check(&self, names: &[String]) -> Result<(), Failure> {
        let wrong = |path: &Path, why: &str| Err(Failure::Usage(format!("{}: {why}", inputs::shown(path))));
        for name in names.iter().chain(&self.stale(names)) {
            let path = self.folder.join(name);
            if self.inputs.is_one(&path) {
                return wrong(
                    &path,
                    "is an input of this command and is never overwritten; name another folder with --out",
                );
            }
        }
        let there = names.iter().map(|name| (name, self.folder.join(name)));
        let there: Vec<_> =
            there.filter_map(|(name, path)| Some((name, path.symlink_metadata().ok()?, path))).collect();
        // Read afterwards: what another command puts there meanwhile never comes before its mark.
        let mark = Mark::read(self.folder);
        for (name, found, path) in there {
            if found.is_dir() {
                return wrong(&path, "is a folder; expected a file or nothing there. Name another folder with --out");
            }
            let owner = mark.as_ref().and_then(|mark| mark.owner(name));
            if !(self.force || self.command.is_some() && owner == self.command) {
                let whose = match (self.command, owner) {
                    (None, _) => "exists".to_owned(),
                    (Some(_), Some(owner)) => format!("is a result of `erard {owner}`"),
                    (Some(command), None) => format!("exists and was not written by `erard {command}`"),
                };
                return wrong(&path, &format!("{whose}; name another folder with --out, or add --force to replace it"));
            }
        }
        Ok(())
    }

    /// Results that stand here and would be those of another run than the files of these names.
    fn stale(&self, names: &[String]) -> Vec<String> {
        let (Some(command), Some(mark)) = (self.command, Mark::read(self.folder)) else { return Vec::new() };
        let there = |name: &String| self.folder.join(name).symlink_metadata().is_ok_and(|found| !found.is_dir());
        mark.of(command).iter().filter(|name| !names.contains(name) && there(name)).cloned().collect()
    }

    /// Whether the command made the folder and knows all that stands in it, so that it can be exchanged. Not where
    /// somebody who stands in it would be left in a folder that is gone.
    fn is_whole(&self) -> bool {
        let (Some(command), Some(mark)) = (self.command, Mark::read(self.folder)) else { return false };
        let link = self.folder.symlink_metadata().is_ok_and(|found| found.is_symlink());
        let inside = match (std::env::current_dir(), self.folder.canonicalize()) {
            (Ok(here), Ok(folder)) => here.starts_with(folder),
            _ => true,
        };
        if !mark.made_folder || !mark.is_only(command) || link || inside {
            return false;
        }
        let known: BTreeSet<&str> = mark.of(command).iter().map(String::as_str).chain([mark::NAME]).collect();
        let Ok(mut entries) = fs::read_dir(self.folder) else { return false };
        entries.all(|entry| {
            entry.is_ok_and(|entry| {
                entry.file_type().is_ok_and(|kind| kind.is_file())
                    && entry.file_name().to_str().is_some_and(|name| known.contains(name))
            })
        })
    }
}

#[cfg(test)]
mod tests;
