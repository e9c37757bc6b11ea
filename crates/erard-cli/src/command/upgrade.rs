//! `erard check --upgrade`: names of earlier versions in a file, rewritten as this version writes them.
//!
//! What was called otherwise is still read (docs/compatibility.md); the rewritten file is the same in every other byte.

use std::fs;
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};

use erard::stroke::MAX_BYTES;

use crate::failure::Failure;
use crate::inputs::shown;
use crate::print_line;
use crate::session::Session;
use crate::table::beside;

/// Titles in the tables that earlier versions wrote, and in those of this one.
const TITLES: [(&str, &str); 2] = [("hammer_head_m", "hammer_rise_m"), ("hammer_head_m_per_s", "hammer_rise_m_per_s")];

/// Beginnings of comments in tables.
const COMMENTS: [&str; 3] = ["#", "%", "//"];

/// A name that was rewritten.
#[derive(Debug, PartialEq)]
struct Renamed {
    /// Line, from 1.
    line: usize,
    old: &'static str,
    new: &'static str,
}

/// Refuses what cannot be rewritten, before anything is read.
///
/// # Errors
/// [`Failure::Usage`].
pub(super) fn refuse(file: &Path) -> Result<(), Failure> {
    let expected = if !file.is_file() {
        "--upgrade expects a file that can be rewritten, not a built-in name or a pipe"
    } else if ends_in(file, "parquet") {
        "--upgrade rewrites text; earlier names in Parquet are read as they are"
    } else {
        return Ok(());
    };
    Err(Failure::Usage(format!("{}: {expected}", shown(file))))
}

fn ends_in(file: &Path, ending: &str) -> bool {
    file.extension().is_some_and(|own| own.eq_ignore_ascii_case(ending))
}

/// Rewrites a file that has been checked, and says so; returns what was written.
///
/// # Errors
/// [`Failure::Usage`] where a table has a quantity under both names; [`Failure::Write`].
pub(super) fn upgrade(session: &mut Session, file: &Path) -> Result<Vec<PathBuf>, Failure> {
    let name = shown(file);
    // Other kinds of files have no names that were ever called otherwise.
    let is_table = ["csv", "tsv", "txt", "dat"].into_iter().any(|ending| ends_in(file, ending));
    let text = if is_table { read(session, file).map_err(|error| unread(&name, &error))? } else { Vec::new() };
    let (new, renamed) = rewritten(&text).map_err(|fault| Failure::Usage(format!("{name}:{fault}")))?;
    print_line!(session);
    if renamed.is_empty() {
        print_line!(session, "  Nothing to upgrade: all names are those of this version.");
        return Ok(Vec::new());
    }
    // The file itself, wherever links lead.
    let file = fs::canonicalize(file).map_err(|error| unread(&name, &error))?;
    let mut written = Vec::new();
    let metadata = file.with_file_name(beside(&file.file_name().unwrap_or_default().to_string_lossy()));
    if let Ok(text) = fs::read_to_string(&metadata) {
        // Before the table: after an end between the two, the next time does both.
        replace(session, &metadata, with_names(&text, &renamed).as_bytes())?;
        written.push(metadata);
    }
    replace(session, &file, &new)?;
    written.push(file);
    for Renamed { line, old, new } in renamed {
        print_line!(session, "  line {line}: `{old}` is `{new}` now");
    }
    Ok(written)
}

fn unread(name: &str, error: &io::Error) -> Failure {
    Failure::Usage(format!("{name}: cannot be read: {error}"))
}

fn read(session: &mut Session, file: &Path) -> io::Result<Vec<u8>> {
    let mut text = Vec::new();
    session.inputs.open(file)?.take(MAX_BYTES).read_to_end(&mut text)?;
    Ok(text)
}

/// A table with its titles of today, and what was rewritten; every other byte as it was. The titles are the first line
/// with a cell `time_s`, as all tables of this program have it.
///
/// # Errors
/// A line that has a quantity under both names.
fn rewritten(text: &[u8]) -> Result<(Vec<u8>, Vec<Renamed>), String> {
    let mut start = 0;
    for (index, line) in text.split_inclusive(|byte| *byte == b'\n').enumerate() {
        let range = start..start + line.len();
        start = range.end;
        // A title of another encoding is none of ours.
        let Ok(titles) = str::from_utf8(line) else { continue };
        let begins = titles.trim_start_matches('\u{feff}').trim_start();
        if COMMENTS.iter().any(|comment| begins.starts_with(comment))
            || !cells(titles).any(|(_, cell)| cell == "time_s")
        {
            continue;
        }
        let (mut new, mut renamed) = (text[..range.start].to_vec(), Vec::new());
        let mut copied = 0;
        for (at, cell) in cells(titles) {
            let Some((old, now)) = TITLES.into_iter().find(|(old, _)| *old == cell) else { continue };
            if cells(titles).any(|(_, other)| other == now) {
                return Err(format!("{}: the titles have `{old}` and `{now}`; expected one of them", index + 1));
            }
            new.extend_from_slice(&titles.as_bytes()[copied..at]);
            new.extend_from_slice(now.as_bytes());
            copied = at + cell.len();
            renamed.push(Renamed { line: index + 1, old, new: now });
        }
        new.extend_from_slice(&titles.as_bytes()[copied..]);
        new.extend_from_slice(&text[range.end..]);
        return Ok((new, renamed));
    }
    Ok((text.to_vec(), Vec::new()))
}

/// The cells of a line of titles without blanks and quotes, and where each begins.
fn cells(line: &str) -> impl Iterator<Item = (usize, &str)> {
    let spare = |c: char| c.is_whitespace() || c == '"' || c == '\u{feff}';
    line.split([',', ';', '\t']).map(move |cell| {
        let inner = cell.trim_matches(spare);
        (inner.as_ptr() as usize - line.as_ptr() as usize, inner)
    })
}

/// Metadata of a table with these names: its columns are strings of JSON.
fn with_names(metadata: &str, renamed: &[Renamed]) -> String {
    let quoted = |name: &str| format!("\"{name}\"");
    renamed.iter().fold(metadata.to_owned(), |text, one| text.replace(&quoted(one.old), &quoted(one.new)))
}

/// Puts a whole new text in the place of a file, with its permissions; the file is the old one or the new one.
fn replace(session: &Session, file: &Path, text: &[u8]) -> Result<(), Failure> {
    let write = || {
        let mut new = tempfile::NamedTempFile::new_in(file.parent().unwrap_or(Path::new(".")))?;
        new.write_all(text)?;
        new.as_file().sync_all()?;
        fs::set_permissions(new.path(), file.metadata()?.permissions())?;
        let _undisturbed = session.stop.hold();
        new.persist(file).map_err(|error| error.error)?;
        Ok(())
    };
    write().map_err(|source| Failure::write(file, source))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Titles are rewritten where they are titles, and every other byte stays: comments, line ends, quotes, blanks, and
    /// what only looks like a title.
    #[test]
    fn only_titles_are_rewritten() {
        let old = "\u{feff}# hammer_head_m, time_s\r\nmine,hammer_head_m\r\n\"time_s\"; hammer_head_m ;\"hammer_head_m_per_s\";hammer_head_mm\r\n0;hammer_head_m;1;2";
        let (new, renamed) = rewritten(old.as_bytes()).unwrap();
        let expected = "\u{feff}# hammer_head_m, time_s\r\nmine,hammer_head_m\r\n\"time_s\"; hammer_rise_m ;\"hammer_rise_m_per_s\";hammer_head_mm\r\n0;hammer_head_m;1;2";
        assert_eq!(String::from_utf8(new).unwrap(), expected);
        let lines: Vec<_> = renamed.iter().map(|one| (one.line, one.old)).collect();
        assert_eq!(lines, [(3, "hammer_head_m"), (3, "hammer_head_m_per_s")]);
        // A second time there is nothing to do.
        let (again, renamed) = rewritten(expected.as_bytes()).unwrap();
        assert!(again == expected.as_bytes() && renamed.is_empty());
        for text in ["", "\n", "force_N,hammer_head_m\n", "\u{fffd}\n"] {
            assert_eq!(rewritten(text.as_bytes()).unwrap(), (text.as_bytes().to_vec(), Vec::new()), "{text:?}");
        }
        let both = "time_s,hammer_rise_m,hammer_head_m\n";
        assert!(rewritten(both.as_bytes()).unwrap_err().starts_with("1: the titles have"));
    }

    /// The names of today are what runs are written and recordings are read by.
    #[test]
    fn the_new_names_are_those_of_today() {
        use erard::stroke::Role;
        assert_eq!(TITLES.map(|(_, new)| new), [Role::HammerHead.title(), Role::HammerSpeed.title()]);
    }
}
