//! `erard fmu`: what is in the unit, and what it says when there is none. That simulators take it, the tests of
//! `erard-c` show.

use std::collections::BTreeMap;
use std::io::Read;
use std::path::Path;

use crate::common::Folder;
use erard::instrument::Instrument;
use erard::keyboard::Keyboard;
use erard_workshop::fmu::{INSTRUMENT, KEYBOARD, Unit};
use flate2::read::DeflateDecoder;
use rawzip::{CompressionMethod, ZipArchive};

/// What passes for the library: the header of an ELF file, a segment that holds all, and the names looked for.
pub fn library() -> Vec<u8> {
    let text = b"some code, fmi2DoStep, some code, erard_action_new, some code";
    let mut bytes = vec![0; 120];
    bytes[..7].copy_from_slice(b"\x7fELF\x02\x01\x01");
    let machine = if cfg!(target_arch = "aarch64") { 183 } else { 62 };
    let length = (bytes.len() + text.len()) as u8;
    // Kind, machine, table of segments and size of its entries, their number; kind and size of the segment.
    for (at, byte) in [(16, 3), (18, machine), (32, 64), (54, 56), (56, 1), (64, 1), (96, length)] {
        bytes[at] = byte;
    }
    bytes.extend(text);
    bytes
}

/// A folder with a file that passes for the library.
fn folder(test: &str) -> Folder {
    let folder = Folder::for_command("fmu", test);
    std::fs::write(folder.0.join("liberard.so"), library()).unwrap();
    folder
}

/// The texts of an archive by their names; what is compressed has the size and the checksum that the archive states.
fn unpacked(path: &Path) -> BTreeMap<String, String> {
    let archive = ZipArchive::from_slice(std::fs::read(path).unwrap()).unwrap();
    let mut entries = archive.entries();
    let mut texts = BTreeMap::new();
    while let Some(entry) = entries.next_entry().unwrap() {
        let (name, packed) = (entry.file_path().as_ref().to_vec(), archive.get_entry(entry.wayfinder()).unwrap());
        let mut text = Vec::new();
        let read = match entry.compression_method() {
            CompressionMethod::STORE => packed.verifying_reader(packed.data()).read_to_end(&mut text),
            CompressionMethod::DEFLATE => {
                packed.verifying_reader(DeflateDecoder::new(packed.data())).read_to_end(&mut text)
            }
            other => panic!("{other:?}"),
        };
        read.unwrap();
        texts.insert(String::from_utf8(name).unwrap(), String::from_utf8_lossy(&text).into_owned());
    }
    texts
}

/// The archive holds the description, the instrument and the library, nothing else; twice the same bytes.
#[test]
fn a_unit_is_packed() {
    let folder = folder("packed");
    let said = folder.good(&["heavy-touch", "-o", "a.fmu", "--library", "liberard.so"]);
    assert!(said.contains("FMI 2.0") && said.contains("a.fmu"), "{said}");
    let texts = unpacked(&folder.0.join("a.fmu"));
    let text = Instrument::builtin_text("heavy-touch").unwrap();
    assert_eq!(texts[INSTRUMENT], text);
    assert_eq!(texts["modelDescription.xml"], Unit::of_instrument(text).unwrap().model_description());
    let names: Vec<&String> = texts.keys().collect();
    assert_eq!(names.len(), 3, "{names:?}");
    assert!(names.iter().any(|name| name.starts_with("binaries/") && name.contains("/erard.")), "{names:?}");

    // A file of one's own, with the default name; the same bytes again.
    folder.file("mine.toml", text);
    folder.good(&["mine.toml", "--library", "liberard.so"]);
    assert_eq!(std::fs::read(folder.0.join("mine.fmu")).unwrap(), std::fs::read(folder.0.join("a.fmu")).unwrap());
    folder.good(&["concert-grand:key=1", "--library", "liberard.so"]);
    assert!(folder.0.join("concert-grand-key-1.fmu").exists());
}

/// A keyboard by name or from a file is packed with the text of its base instrument, wherever that was.
#[test]
fn a_keyboard_is_packed() {
    let folder = folder("keyboard");
    let said = folder.good(&["--keyboard", "concert-grand", "--library", "liberard.so"]);
    assert!(said.contains("353 inputs"), "{said}");
    let text = Keyboard::builtin_text("concert-grand").unwrap();
    let base = Instrument::builtin_text("concert-grand").unwrap();
    // Around a file of one's own, in a folder below.
    std::fs::create_dir(folder.0.join("own")).unwrap();
    let mine = text.replace("instrument = \"concert-grand\"", "instrument = \"mine.toml\"");
    folder.file("own/keys.toml", &mine);
    folder.file("own/mine.toml", base);
    folder.good(&["--keyboard", "own/keys.toml", "--library", "liberard.so"]);
    for (unit, keyboard) in [("concert-grand-keyboard.fmu", text), ("keys-keyboard.fmu", mine.as_str())] {
        let texts = unpacked(&folder.0.join(unit));
        assert_eq!((texts[KEYBOARD].as_str(), texts[INSTRUMENT].as_str()), (keyboard, base), "{unit}");
        let unit = Unit::of_keyboard(keyboard, base).unwrap();
        assert_eq!(texts["modelDescription.xml"], unit.model_description());
    }
}

/// What cannot be packed is said, and nothing is written; what is there is replaced with --force only.
#[test]
fn what_is_refused() {
    let folder = folder("refused");
    folder.file("other.so", "some code");
    folder.file("empty.toml", "");
    folder.file("instrument.toml", Instrument::builtin_text("heavy-touch").unwrap());
    let keyboard = Keyboard::builtin_text("concert-grand").unwrap();
    folder.file("keyboard.toml", keyboard);
    folder.file("lost.toml", &keyboard.replace("instrument = \"concert-grand\"", "instrument = \"nowhere.toml\""));
    for (arguments, words) in [
        (&["concert-gong", "--library", "liberard.so"][..], "concert-gong"),
        (&["--library", "no.so"], "no.so"),
        (&["--library", "other.so"], "fmi2DoStep"),
        (&["-o", "unit.zip", "--library", "liberard.so"], ".fmu"),
        (&["-o", ".", "--library", "liberard.so"], "folder"),
        (&["--keyboard", "clavichord", "--library", "liberard.so"], "concert-grand-strings"),
        (&["--keyboard", "empty.toml", "--library", "liberard.so"], "empty.toml"),
        (&["--keyboard", "instrument.toml", "--library", "liberard.so"], "instrument.toml"),
        (&["--keyboard", "lost.toml", "--library", "liberard.so"], "nowhere.toml"),
        (&["--keyboard", "no.toml", "--library", "liberard.so"], "no.toml"),
        (&["keyboard.toml", "--library", "liberard.so"], "--keyboard keyboard.toml"),
        (&["heavy-touch", "--keyboard", "heavy-touch", "--library", "liberard.so"], "cannot be used with"),
    ] {
        let said = folder.bad(arguments);
        assert!(said.contains(words), "{said}");
    }
    folder.good(&["-o", "a.fmu", "--library", "liberard.so"]);
    assert!(folder.bad(&["-o", "a.fmu", "--library", "liberard.so"]).contains("--force"));
    folder.good(&["-o", "a.fmu", "--library", "liberard.so", "--force"]);
}

/// Without a library beside the command the error says how to build one.
#[test]
fn where_the_library_comes_from() {
    let folder = folder("beside");
    let command = folder.0.join("erard");
    std::fs::copy(env!("CARGO_BIN_EXE_erard"), &command).unwrap();
    // A process that another test starts meanwhile holds the copy open for writing, until it is the program it becomes.
    let run = || loop {
        match std::process::Command::new(&command).current_dir(&folder.0).args(["fmu", "-o", "a.fmu"]).output() {
            Err(error) if error.kind() == std::io::ErrorKind::ExecutableFileBusy => {
                std::thread::sleep(std::time::Duration::from_millis(10));
            }
            ended => break ended.unwrap(),
        }
    };
    let said = String::from_utf8(run().stderr).unwrap();
    assert!(said.contains("cargo build --release -p erard-c") && said.contains("--library"), "{said}");
    assert!(!folder.0.join("a.fmu").exists());
    let end = if cfg!(target_os = "macos") { "dylib" } else { "so" };
    std::fs::copy(folder.0.join("liberard.so"), folder.0.join(format!("liberard_c.{end}"))).unwrap();
    let output = run();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert!(folder.0.join("a.fmu").exists());
}

/// A library that is cut short, shifted by a byte, of another machine or no library at all is refused before anything
/// is written: a simulator that loads it dies of a signal.
#[test]
fn a_library_that_no_simulator_can_load() {
    let folder = folder("cut");
    let whole = library();
    let changed = |at: usize, byte: u8| {
        let mut other = whole.clone();
        other[at] = byte;
        other
    };
    let shifted = [b"x", &whole[..]].concat();
    for (bytes, words) in [
        (whole[..whole.len() - 1].to_vec(), "cut short"),
        (shifted, "does not begin as a library does"),
        (changed(18, 40), "another machine"),
        (changed(16, 2), "no shared library"),
        (changed(56, 0), "has no segments"),
        (changed(100, 1), "cut short"),
    ] {
        std::fs::write(folder.0.join("cut.so"), &bytes).unwrap();
        let said = folder.bad(&["-o", "cut.fmu", "--library", "cut.so"]);
        assert!(said.contains(words) && said.contains("cut.so"), "{said}");
        assert!(!folder.0.join("cut.fmu").exists());
    }
}
