//! Files of earlier versions are read by this one, and by every later one (docs/compatibility.md):
//! `crates/erard/tests/formats` holds those of the preview 2228d5e4 and of 0.1.0. A version adds a folder; what is in
//! the folders is never changed.

use std::fs;
use std::path::{Path, PathBuf};

use serde_json::Value;

use crate::common::Folder;

/// Each file, what it is, and a number that its reader counts.
const FILES: [(&str, &str, &str, u64); 28] = [
    ("2228d5e4/concert-grand-rigid.toml", "instrument", "numbers", 178),
    ("2228d5e4/concert-grand-strings.toml", "instrument", "numbers", 309),
    ("2228d5e4/escapement.toml", "instrument", "numbers", 32),
    ("2228d5e4/heavier-f.csv", "stroke", "rows", 598),
    ("2228d5e4/kawai-kg-3c-struck-1.csv", "stroke", "rows", 900),
    ("2228d5e4/keyboard.toml", "keyboard", "points", 49),
    ("2228d5e4/linkage.toml", "linkage", "", 0),
    ("2228d5e4/piece.mid", "MIDI file", "notes", 252),
    ("2228d5e4/readings.csv", "readings of keys", "readings", 5),
    ("2228d5e4/sensors.toml", "profile of sensors", "keys", 1),
    ("2228d5e4/steinway-o.toml", "instrument", "numbers", 239),
    ("2228d5e4/stream.csv", "stream of sensors", "samples", 4),
    ("2228d5e4/stroke.csv", "stroke", "rows", 791),
    ("2228d5e4/weights.csv", "readings of keys", "readings", 4),
    ("0.1.0/concert-grand.toml", "instrument", "numbers", 251),
    ("0.1.0/contact-table.csv", "table of contacts", "", 0),
    ("0.1.0/contacts.toml", "profile of sensors", "contacts", 2),
    ("0.1.0/hammers.toml", "profile of sensors", "keys", 1),
    ("0.1.0/keyboard.toml", "keyboard", "points", 44),
    ("0.1.0/law.csv", "law of velocities", "", 0),
    ("0.1.0/linkage.toml", "linkage", "", 0),
    ("0.1.0/readings.csv", "readings of keys", "readings", 6),
    ("0.1.0/recording.csv", "stroke", "rows", 5),
    ("0.1.0/ruler.csv", "law of a sensor", "", 0),
    ("0.1.0/run.csv", "stroke", "rows", 31),
    ("0.1.0/sensors.toml", "profile of sensors", "keys", 1),
    ("0.1.0/stream.csv", "stream of sensors", "samples", 4),
    ("0.1.0/units.toml", "instrument", "numbers", 32),
];

/// A saved state, which a test of the crate `erard` continues.
const STATE: &str = "0.1.0/state.bin";

fn kept() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../erard/tests/formats")
}

/// Checks files, or upgrades them: copies in a folder of their own. A file that is not read must be refused by a
/// sentence that says how it is rewritten.
fn are_read(
    test: &str,
    arguments: &[&str],
    files: impl Iterator<Item = &'static (&'static str, &'static str, &'static str, u64)>,
) -> Folder {
    let folder = Folder::new(test);
    for (file, kind, counted, count) in files {
        let name = file.replace('/', "-");
        fs::copy(kept().join(file), folder.0.join(&name)).unwrap();
        let output = folder.erard(&[&["check", "--json", name.as_str()], arguments].concat());
        let said = String::from_utf8(output.stderr).unwrap();
        if !output.status.success() {
            assert!(said.contains(&format!("`erard check --upgrade {name}`")), "{file}: {said}");
            continue;
        }
        let answer: Value = serde_json::from_slice(&output.stdout).unwrap();
        assert_eq!(answer["kind"], **kind, "{file}: {answer}");
        assert!(counted.is_empty() || answer["counts"][counted] == *count, "{file}: {answer}");
    }
    folder
}

#[test]
fn files_of_earlier_versions_are_read() {
    // None is forgotten, and none has gone.
    let mut there: Vec<String> = ["2228d5e4", "0.1.0"]
        .iter()
        .flat_map(|version| fs::read_dir(kept().join(version)).unwrap().map(move |e| (version, e.unwrap().file_name())))
        .map(|(version, name)| format!("{version}/{}", name.to_str().unwrap()))
        .collect();
    let mut known: Vec<&str> = FILES.iter().map(|(file, ..)| *file).chain([STATE]).collect();
    there.sort();
    known.sort_unstable();
    assert_eq!(there, known);
    are_read("formats", &[], FILES.iter().filter(|(_, kind, ..)| *kind != "keyboard"));
}

#[test]
#[ignore = "ci: keyboards of 88 keys"]
fn keyboards_of_earlier_versions_are_read() {
    are_read("formats-keyboards", &[], FILES.iter().filter(|(_, kind, ..)| *kind == "keyboard"));
}

/// `check --upgrade` rewrites what was called otherwise, once, and leaves every other byte and file as it was.
#[test]
fn an_upgrade_rewrites_old_names_once() {
    let files = || FILES.iter().filter(|(_, kind, ..)| ["stroke", "linkage", "readings of keys"].contains(kind));
    let folder = are_read("upgrade", &["--upgrade"], files());
    for (file, ..) in files() {
        let (old, new) = (fs::read_to_string(kept().join(file)).unwrap(), folder.read(&file.replace('/', "-")));
        let changes = *file == "2228d5e4/heavier-f.csv";
        assert_eq!(old != new, changes, "{file}");
        assert_eq!(new, old.replacen("hammer_head_m\n", "hammer_rise_m\n", 1), "{file}");
    }
    // Nothing is left beside the files, and a second time there is nothing to do.
    assert_eq!(folder.names().len(), files().count());
    let said = folder.good_words(&["check", "--upgrade", "2228d5e4-heavier-f.csv"]);
    assert!(said.contains("Nothing to upgrade"), "{said}");

    // A table of a run with its metadata: both, and what was written is named.
    folder.file(
        "run.csv",
        "# hammer_head_m is old\ntime_s,force_N,hammer_head_m,hammer_head_m_per_s\n0,0,0,0\n1,1,0,0\n",
    );
    folder.file("run.csv-metadata.json", "{\"titles\": [\"time_s\", \"hammer_head_m\", \"hammer_head_m_per_s\"]}\n");
    let answer: Value = serde_json::from_str(&folder.good(&["check", "--json", "--upgrade", "run.csv"])).unwrap();
    assert_eq!(answer["written"].as_array().map(Vec::len), Some(2), "{answer}");
    assert!(
        folder
            .read("run.csv")
            .starts_with("# hammer_head_m is old\ntime_s,force_N,hammer_rise_m,hammer_rise_m_per_s\n")
    );
    assert!(!folder.read("run.csv-metadata.json").contains("hammer_head"));
}

/// What cannot be rewritten is refused, and a file that cannot be read stays as it was.
#[test]
fn an_upgrade_refuses_what_it_cannot_rewrite() {
    let folder = Folder::new("upgrade-bad");
    let broken = "time_s,force_N,hammer_head_m\n0,0,0\n1,one,0\n";
    folder.file("broken.csv", broken);
    folder.file("it.parquet", "PAR1");
    for (file, part) in [
        ("broken.csv", "`one`"),
        ("it.parquet", "rewrites text"),
        ("concert-grand", "built-in name"),
        ("no.csv", "expects a file"),
    ] {
        let said = folder.bad(&["check", "--upgrade", file]);
        assert!(said.contains(part), "{file}: {said}");
    }
    assert_eq!(folder.read("broken.csv"), broken);
}
