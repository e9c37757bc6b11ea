//! The folder in which command lines are played: inputs of every kind, and what stands in the way of outputs.

use std::cell::Cell;
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::process::{Child, Command};

use serde_json::Value;

use super::line::Line;
use crate::common::Folder;
use crate::common::tree::{Look, Thing, look};

const GRAND: &str = include_str!("../../../../erard-core/instruments/concert-grand-rigid.toml");
const STROKE: &str = "time_s,force_N,position_m\n0,0,0\n0.01,3,0.001\n0.02,3,0.003\n";

/// Input files.
pub const INPUTS: [&str; 31] = [
    "in/good.toml",
    "in/good.csv",
    "in/empty.toml",
    "in/empty.csv",
    "in/bytes.csv",
    "in/bytes.toml",
    "in/half.toml",
    "in/nan.csv",
    "in/digits.csv",
    "in/titles.csv",
    "in/keys.csv",
    "in/wide.csv",
    "in/utf16.csv",
    "in/keyboard.toml",
    "in/link.toml",
    "in/loop.toml",
    "in/\u{1b}[2J.toml",
    "in/none.csv",
    "in",
    "/dev/null",
    "/dev/zero",
    "in/pipe.csv",
    "earlier/run.csv",
    "earlier/summary.json",
    "in/piece.mid",
    "in/cut.mid",
    "in/tracks.mid",
    "in/tone.wav",
    "in/cut.wav",
    "in/readings.csv",
    "in/library.so",
];

/// Where results are to go.
pub const OUTPUTS: [&str; 16] = [
    "new",
    "new/er/est",
    "earlier",
    "mine",
    "in",
    ".",
    "",
    "mine/note.txt",
    "mine/note.txt/below",
    "/dev/full",
    "/proc/no/such",
    "in/good.toml",
    "new.toml",
    "new.fmu",
    "mine/.erard.backup.part",
    "linked",
];

/// A folder with all that.
pub struct World {
    folder: Folder,
    /// What stands there at first; the folder is made anew where it has changed.
    first: Look,
    changed: Cell<bool>,
}

impl World {
    pub fn new() -> Self {
        let folder = Folder::new("attack");
        make(&folder);
        let first = look(&folder.0);
        World { folder, first, changed: Cell::new(false) }
    }

    /// As it was at first.
    pub fn restore(&self) {
        if self.changed.take() {
            for entry in fs::read_dir(&self.folder.0).unwrap() {
                let path = entry.unwrap().path();
                if path.is_dir() && !path.is_symlink() { fs::remove_dir_all(path) } else { fs::remove_file(path) }
                    .unwrap();
            }
            make(&self.folder);
        }
    }

    pub fn look(&self) -> Look {
        look(&self.folder.0)
    }

    /// The command within so much address space.
    pub fn command(&self, room_kib: u32, arguments: &[String]) -> Command {
        let plain = self.folder.command(&[]);
        let mut command = Command::new("bash");
        command.args(["-c", &format!("ulimit -v {room_kib}; exec \"$0\" \"$@\""), crate::PROGRAM]).args(arguments);
        command.current_dir(&self.folder.0);
        command.envs(plain.get_envs().filter_map(|(name, value)| Some((name, value?))));
        command
    }

    /// Forbidden changes: see the rules of `erard_cli::output`. A user's folder may have a stage's name: what was there
    /// before is not a stage.
    pub fn faults(&self, before: &Look, line: &Line, code: Option<i32>) -> Vec<String> {
        let after = self.look();
        self.changed.set(after != self.first);
        let is_done = code.map_or_else(|| is_whole(before, &after, line.command()), |code| code != 2);
        let mut faults = Vec::new();
        let mut fault = |path: &Path, what: &str| faults.push(format!("{} {what} (code {code:?})", path.display()));
        for path in before.keys().chain(after.keys().filter(|path| !before.contains_key(*path))) {
            let (old, new) = (before.get(path), after.get(path));
            if old == new {
                continue;
            }
            let name = path.to_string_lossy();
            if let Some(Thing::File(bytes)) = new
                && let Some(none) = no_number(&name, bytes)
            {
                fault(path, &format!("holds `{none}`, which is no number"));
            }
            if !is_done {
                fault(path, "has changed");
            } else if path.ancestors().any(|own| is_stage(own) && !before.contains_key(own)) {
                fault(path, "is left");
            } else if old.is_some() && is_read(line, &name) {
                fault(path, "is an input, and has changed");
            } else if old.is_some_and(|old| *old != Thing::Folder)
                && !line.may_force()
                && !is_mark(path)
                && owner(before, path).as_deref() != Some(line.command())
            {
                fault(path, "belongs to somebody else, and has changed");
            } else if old.is_some_and(|old| *old != Thing::Folder)
                && !is_mark(path)
                && new.is_none()
                && owner(before, path).as_deref() != Some(line.command())
            {
                fault(path, "is gone");
            } else if old.is_some_and(|old| *old != Thing::Folder)
                && line.may_force()
                && !is_mark(path)
                && owner(&after, path).as_deref() != Some(line.command())
                && !line.arguments.iter().any(|one| one.ends_with(&*name))
                && line.command() != "man"
            {
                fault(path, "is no result, and has changed");
            }
        }
        faults
    }
}

/// What stands in a table or in JSON where a number belongs, and is none.
fn no_number<'a>(name: &str, bytes: &'a [u8]) -> Option<&'a str> {
    let text = std::str::from_utf8(bytes).ok()?;
    let is_none = |cell: &&str| ["nan", "inf", "-inf", "infinity", "-infinity"].contains(&&cell.to_lowercase()[..]);
    match name.rsplit_once('.')?.1 {
        "csv" => text.lines().flat_map(|line| line.split(',')).find(is_none),
        // JSON has no word for them.
        "json" => serde_json::from_str::<Value>(text).is_err().then_some(&text[..text.len().min(60)]),
        _ => None,
    }
}

/// Asks a process to end.
pub fn end(child: &Child) {
    let pid = child.id().to_string();
    // It may have ended meanwhile.
    let _ = Command::new("kill").args(["-TERM", &pid]).output();
}

/// Whether a path is one of the inputs that the line names.
fn is_read(line: &Line, path: &str) -> bool {
    let names = |one: &String| one == path || one.ends_with(&format!("={path}"));
    let out = line.arguments.iter().position(|one| one == "--out" || one == "--out-file");
    let given = line.arguments.iter().enumerate().any(|(i, one)| names(one) && out.is_none_or(|out| i != out + 1));
    given && !line.arguments.iter().any(|one| *one == format!("--out={path}") || *one == format!("--out-file={path}"))
}

/// Whether a stage would be called so.
fn is_stage(path: &Path) -> bool {
    path.extension().is_some_and(|ending| ending == "part")
}

fn is_mark(path: &Path) -> bool {
    path.file_name().is_some_and(|name| name == ".erard.json")
}

/// Results of each command in a file's folder, by the mark there.
fn results(look: &Look, beside: &Path) -> BTreeMap<String, Vec<String>> {
    let Some(Thing::File(bytes)) = look.get(&beside.with_file_name(".erard.json")) else { return BTreeMap::new() };
    let mut mark: Value = serde_json::from_slice(bytes).unwrap_or_default();
    serde_json::from_value(mark["results"].take()).unwrap_or_default()
}

/// The command whose result a file is, by the mark beside it.
fn owner(look: &Look, path: &Path) -> Option<String> {
    let name = path.file_name()?.to_str()?;
    results(look, path).into_iter().find(|(_, files)| files.iter().any(|one| one == name)).map(|(command, _)| command)
}

/// Whether all that has changed is one whole result of the command, every file of it new: the command was asked to end
/// when it had only to end.
fn is_whole(before: &Look, after: &Look, command: &str) -> bool {
    let is_new = |path: &Path| matches!(after.get(path), Some(Thing::File(_))) && before.get(path) != after.get(path);
    let belongs = |path: &Path| {
        let results = results(after, path).remove(command).unwrap_or_default();
        (is_mark(path) || results.iter().any(|one| path.ends_with(one)))
            && !results.is_empty()
            && results.iter().all(|one| is_new(&path.with_file_name(one)))
    };
    let changed = after.iter().filter(|(path, thing)| before.get(*path) != Some(*thing));
    let mut files = changed.filter(|(_, thing)| **thing != Thing::Folder).peekable();
    // A folder alone is no result.
    files.peek().is_some() && files.all(|(path, _)| belongs(path)) && before.keys().all(|path| after.contains_key(path))
}

fn make(folder: &Folder) {
    fs::create_dir(folder.0.join("in")).unwrap();
    fs::create_dir(folder.0.join("mine")).unwrap();
    let write = |name: &str, bytes: &[u8]| fs::write(folder.0.join(name), bytes).unwrap();
    write("in/good.toml", GRAND.as_bytes());
    write("in/good.csv", STROKE.as_bytes());
    write("in/empty.toml", b"");
    write("in/empty.csv", b"");
    let bytes: Vec<u8> = (0..4000_u32).map(|i| (i.wrapping_mul(2_654_435_761) >> 13) as u8).collect();
    write("in/bytes.csv", &bytes);
    write("in/bytes.toml", &bytes);
    write("in/half.toml", &GRAND.as_bytes()[..GRAND.len() / 2]);
    write("in/nan.csv", b"time_s,force_N\n0,nan\n0.1,inf\n");
    write("in/digits.csv", format!("time_s,force_N\n0,{}\n0.1,1\n", "9".repeat(60_000)).as_bytes());
    write("in/titles.csv", format!("time_s,{}\n0,1\n0.1,1\n", "k".repeat(60_000)).as_bytes());
    write("in/keys.csv", b"key,down_g,up_g\nC4,52,28\nA0,10,90\n99,1,1\n");
    let wide = |cell: &dyn Fn(usize) -> String| (0..4000).map(cell).collect::<Vec<_>>().join(",");
    let rows =
        format!("time_s,{}\n0,{}\n0.1,{}\n", wide(&|i| format!("c{i}")), wide(&|_| "1".into()), wide(&|_| "2".into()));
    write("in/wide.csv", rows.as_bytes());
    let utf16: Vec<u8> = STROKE.encode_utf16().flat_map(u16::to_le_bytes).collect();
    write("in/utf16.csv", &[&[0xff, 0xfe], &utf16[..]].concat());
    let keyboard = "format = \"erard-keyboard/1\"\nname = \"K\"\ninstrument = \"concert-grand\"\ninstrument_key = 40\n";
    write("in/keyboard.toml", keyboard.as_bytes());
    write("in/\u{1b}[2J.toml", GRAND.as_bytes());
    // A piece; one cut short; one that announces 65 535 tracks; a sound; one cut in its header; what a sensor reads;
    // the beginning of a library.
    let piece = crate::play::two_notes();
    write("in/piece.mid", &piece);
    write("in/cut.mid", &piece[..piece.len() - 9]);
    write("in/tracks.mid", b"MThd\0\0\0\x06\0\x01\xff\xff\0\x60MTrk\0\0\0\x04\0\xff\x2f\0");
    let tone = crate::listen::two_stages(0.3);
    write("in/tone.wav", &tone);
    write("in/cut.wav", &tone[..40]);
    write("in/readings.csv", crate::live::sensed("mm", 0.0, 9.9).as_bytes());
    write("in/library.so", b"\x7fELF\x02\x01\x01\0\0\0\0\0\0\0\0\0\x03\0\x3e\0");
    write("mine/note.txt", b"keep me");
    for name in ["run.csv", "summary.json", "action.svg", "study.csv", "measure.json", "press-erard.1"] {
        write(&format!("mine/{name}"), b"mine");
    }
    fs::create_dir(folder.0.join("mine/.erard.backup.part")).unwrap();
    write("mine/.erard.backup.part/kept", b"mine");
    fs::create_dir(folder.0.join(".mine.backup.part")).unwrap();
    write(".mine.backup.part/kept", b"mine");
    std::os::unix::fs::symlink("good.toml", folder.0.join("in/link.toml")).unwrap();
    std::os::unix::fs::symlink("loop.toml", folder.0.join("in/loop.toml")).unwrap();
    std::os::unix::fs::symlink("mine", folder.0.join("linked")).unwrap();
    assert!(Command::new("mkfifo").arg(folder.0.join("in/pipe.csv")).status().unwrap().success());
    folder.good(&["press", "--duration", "0.005", "--out", "earlier"]);
}
