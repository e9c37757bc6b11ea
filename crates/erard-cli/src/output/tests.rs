use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use super::journal;
use super::stage::recover;
use super::{Mark, Output, Written, mark};
use crate::failure::Failure;
use crate::session::Session;

/// A folder of its own, gone at the end.
fn root() -> tempfile::TempDir {
    tempfile::tempdir().unwrap()
}

fn write(output: &mut Output, name: &str, text: &str) -> Result<(), Failure> {
    output.stage(&Session::silent(), name, |w| w.write_all(text.as_bytes()))
}

/// Writes these files as a command does.
fn put(folder: &Path, command: &'static str, force: bool, files: &[(&str, &str)]) -> Result<Written, Failure> {
    let names: Vec<&str> = files.iter().map(|(name, _)| *name).collect();
    let mut output = Output::results(&Session::silent(), folder, command, force, &names)?;
    for (name, text) in files {
        write(&mut output, name, text)?;
    }
    output.commit(&Session::silent())
}

/// Names and texts of a folder's files, without the mark.
fn held(folder: &Path) -> Vec<(String, String)> {
    let mut held: Vec<(String, String)> = fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap())
        .filter(|entry| entry.file_name() != mark::NAME)
        .map(|entry| {
            (entry.file_name().into_string().unwrap(), fs::read_to_string(entry.path()).unwrap_or("a folder".into()))
        })
        .collect();
    held.sort();
    held
}

fn files(files: &[(&str, &str)]) -> Vec<(String, String)> {
    files.iter().map(|(name, text)| ((*name).to_owned(), (*text).to_owned())).collect()
}

/// What is dropped before the commit leaves nothing behind, not even the folders that were made for it.
#[test]
fn nothing_or_all() {
    let root = root();
    let folder = root.path().join("a/b");
    let mut output = Output::results(&Session::silent(), &folder, "press", false, &[]).unwrap();
    write(&mut output, "x.txt", "x").unwrap();
    assert!(!folder.exists());
    drop(output);
    assert_eq!(held(root.path()), []);

    put(&folder, "press", false, &[("x.txt", "x")]).unwrap();
    let mut output = Output::results(&Session::silent(), &folder, "press", false, &[]).unwrap();
    output.stage(&Session::silent(), "x.txt", |_| Err(io::Error::other("disk full"))).unwrap_err();
    drop(output);
    assert_eq!(held(&folder), files(&[("x.txt", "x")]), "the old file is still whole");
    assert_eq!(fs::read_dir(root.path().join("a")).unwrap().count(), 1, "nothing beside it");
}

/// A folder that Erard made holds the last run's files and none of the run before.
#[test]
fn a_folder_of_its_own_is_exchanged_whole() {
    let root = root();
    let folder = root.path().join("out");
    put(&folder, "study", false, &[("a", "1"), ("figure", "1")]).unwrap();
    assert!(Mark::read(&folder).unwrap().made_folder);
    #[cfg(unix)]
    let inode = |path: &Path| std::os::unix::fs::MetadataExt::ino(&fs::metadata(path).unwrap());
    #[cfg(unix)]
    let before = inode(&folder);
    put(&folder, "study", false, &[("a", "2")]).unwrap();
    assert_eq!(held(&folder), files(&[("a", "2")]));
    #[cfg(target_os = "linux")]
    assert_ne!(before, inode(&folder), "another folder has taken its place");
    assert_eq!(fs::read_dir(root.path()).unwrap().count(), 1);
}

/// In a folder with files of the user's only the command's own are replaced and taken away.
#[test]
fn among_others() {
    let root = root();
    let folder = root.path();
    fs::write(folder.join("mine"), "mine").unwrap();
    put(folder, "study", false, &[("a", "1"), ("figure", "1")]).unwrap();
    assert!(!Mark::read(folder).unwrap().made_folder);
    put(folder, "study", false, &[("a", "2"), ("b", "2")]).unwrap();
    assert_eq!(held(folder), files(&[("a", "2"), ("b", "2"), ("mine", "mine")]));
    // What was put into a folder of its own is as safe.
    let own = folder.join("own");
    put(&own, "press", false, &[("a", "1")]).unwrap();
    fs::write(own.join("note"), "mine").unwrap();
    put(&own, "press", false, &[("a", "2")]).unwrap();
    assert_eq!(held(&own), files(&[("a", "2"), ("note", "mine")]));
}

/// Commands that run side by side write into one folder: files of their own, one that they share, and results.
#[test]
fn side_by_side() {
    let root = root();
    let folder = root.path();
    std::thread::scope(|scope| {
        for n in 0..4 {
            scope.spawn(move || {
                for _ in 0..50 {
                    let own = format!("{n}.csv");
                    for name in [own.as_str(), "shared.csv"] {
                        let mut output = Output::files(&Session::silent(), folder, true, &[name]).unwrap();
                        write(&mut output, name, name).unwrap();
                        output.commit(&Session::silent()).unwrap();
                    }
                    put(&folder.join("out"), "press", false, &[("a", "1"), ("b", "2")]).unwrap();
                }
            });
        }
    });
    let mut all: Vec<(String, String)> = (0..4).map(|n| (format!("{n}.csv"), format!("{n}.csv"))).collect();
    all.extend(files(&[("out", "a folder"), ("shared.csv", "shared.csv")]));
    assert_eq!(held(folder), all);
    assert_eq!(held(&folder.join("out")), files(&[("a", "1"), ("b", "2")]));
}

/// What another command wrote, and what nobody knows, is replaced when that is asked for only.
#[test]
fn results_do_not_mix() {
    let root = root();
    let folder = root.path().join("out");
    put(&folder, "press", false, &[("summary", "press"), ("run", "press")]).unwrap();
    let refused = put(&folder, "kinematics", false, &[("summary", "kinematics")]).unwrap_err().to_string();
    assert!(refused.contains("is a result of `erard press`") && refused.contains("--force"), "{refused}");
    assert_eq!(held(&folder), files(&[("run", "press"), ("summary", "press")]));
    // Beside each other they may stand, and each command takes care of its own.
    put(&folder, "draw", false, &[("action", "draw"), ("figure", "draw")]).unwrap();
    put(&folder, "press", false, &[("run", "again"), ("summary", "again")]).unwrap();
    put(&folder, "draw", false, &[("action", "again")]).unwrap();
    assert_eq!(held(&folder), files(&[("action", "again"), ("run", "again"), ("summary", "again")]));
    put(&folder, "kinematics", true, &[("summary", "kinematics")]).unwrap();
    assert_eq!(held(&folder), files(&[("action", "again"), ("run", "again"), ("summary", "kinematics")]));
    assert!(put(&folder, "press", false, &[("summary", "press")]).is_err(), "it is no longer its own");

    let foreign = root.path().join("foreign");
    fs::create_dir(&foreign).unwrap();
    fs::write(foreign.join("run"), "mine").unwrap();
    let refused = put(&foreign, "press", false, &[("run", "press")]).unwrap_err().to_string();
    assert!(refused.contains("was not written by `erard press`"), "{refused}");
    // Not even where it has come while the command ran, under a name that was not foreseen.
    let mut output = Output::results(&Session::silent(), &foreign, "press", false, &[]).unwrap();
    write(&mut output, "run", "press").unwrap();
    output.commit(&Session::silent()).unwrap_err();
    assert_eq!(held(&foreign), files(&[("run", "mine")]));
    put(&foreign, "press", true, &[("run", "press")]).unwrap();
    assert_eq!(held(&foreign), files(&[("run", "press")]));
}

/// A folder under one of the names is refused before anything is renamed.
#[test]
fn a_folder_in_the_way() {
    let root = root();
    for folder in [root.path().to_path_buf(), root.path().join("own")] {
        put(&folder, "press", false, &[("a", "1"), ("b", "1"), ("c", "1")]).unwrap();
        fs::remove_file(folder.join("b")).unwrap();
        fs::create_dir(folder.join("b")).unwrap();
        for force in [false, true] {
            let refused = put(&folder, "press", force, &[("a", "2"), ("b", "2"), ("c", "2")]).unwrap_err().to_string();
            assert!(refused.contains("is a folder"), "{refused}");
        }
        assert_eq!(held(&folder)[..3], files(&[("a", "1"), ("b", "a folder"), ("c", "1")]));
    }
}

/// A mark cannot lead out of its folder, and one that cannot be read marks nothing.
#[test]
fn marks_are_not_trusted() {
    let root = root();
    let folder = root.path().join("out");
    fs::create_dir(&folder).unwrap();
    fs::write(root.path().join("precious"), "mine").unwrap();
    for files in ["\"../precious\"", "\"/etc/passwd\"", "\"..\"", "\"a/b\"", "\"\""] {
        let text =
            format!("{{\"format\":\"erard-results/1\",\"made_folder\":true,\"results\":{{\"press\":[{files}]}}}}");
        fs::write(folder.join(mark::NAME), text).unwrap();
        assert_eq!(Mark::read(&folder), None, "{files}");
    }
    fs::write(folder.join(mark::NAME), "nonsense").unwrap();
    assert_eq!(Mark::read(&folder), None);
    // The mark itself is then a file in the way of nobody's.
    put(&folder, "press", false, &[("a", "1")]).unwrap();
    assert_eq!(fs::read_to_string(root.path().join("precious")).unwrap(), "mine");
}

const OLD: [(&str, &str); 4] = [("a", "1"), ("b", "1"), ("mine", "mine"), ("stale", "1")];
const NEW: [(&str, &str); 4] = [("a", "2"), ("b", "2"), ("c", "2"), ("mine", "mine")];

/// A folder and a stage within it as they are when a process is killed after so many renames, none of them locked.
fn killed_after(folder: &Path, renames: usize) -> PathBuf {
    for (name, text) in OLD {
        fs::write(folder.join(name), text).unwrap();
    }
    let stage = folder.join(".erard.AbCd12.erard.part");
    for below in ["results", "old"] {
        fs::create_dir_all(stage.join(below)).unwrap();
    }
    fs::write(stage.join("lock"), "").unwrap();
    for name in ["a", "b", "c"] {
        fs::write(stage.join("results").join(name), "2").unwrap();
    }
    let text = "{\"format\":\"erard-journal/1\",\"install\":[\"a\",\"b\",\"c\"],\"remove\":[\"stale\"]}";
    fs::write(stage.join("journal.json"), text).unwrap();
    let (results, old) = (stage.join("results"), stage.join("old"));
    let steps = [
        (folder.join("stale"), old.join("stale")),
        (folder.join("a"), old.join("a")),
        (results.join("a"), folder.join("a")),
        (folder.join("b"), old.join("b")),
        (results.join("b"), folder.join("b")),
        (results.join("c"), folder.join("c")),
    ];
    for (from, to) in &steps[..renames] {
        fs::rename(from, to).unwrap();
    }
    stage
}

/// Wherever a process is killed among its renames, the next one finishes.
#[test]
fn what_was_decided_is_finished() {
    for renames in 0..=6 {
        let root = root();
        let stage = killed_after(root.path(), renames);
        recover(root.path()).unwrap();
        assert_eq!(held(root.path()), files(&NEW), "after {renames} renames");
        assert!(!stage.exists());
    }
    // Before the journal was whole nothing was decided.
    let root = root();
    fs::remove_file(killed_after(root.path(), 0).join("journal.json")).unwrap();
    recover(root.path()).unwrap();
    assert_eq!(held(root.path()), files(&OLD));
}

/// Where it cannot be finished it is undone.
#[test]
fn what_cannot_be_finished_is_undone() {
    for renames in 0..=5 {
        let root = root();
        killed_after(root.path(), renames);
        fs::create_dir(root.path().join("c")).unwrap();
        recover(root.path()).unwrap();
        fs::remove_dir(root.path().join("c")).unwrap();
        assert_eq!(held(root.path()), files(&OLD), "after {renames} renames");
    }
    // The same within the process: a rename fails at last.
    let root = root();
    let stage = killed_after(root.path(), 0);
    fs::remove_file(stage.join("journal.json")).unwrap();
    fs::remove_dir(stage.join("old")).unwrap();
    fs::create_dir(root.path().join("c")).unwrap();
    let (install, remove) = (["a", "b", "c"].map(String::from), ["stale".to_owned()]);
    let (name, _) = journal::publish(&stage, root.path(), &install, &remove).unwrap_err();
    assert_eq!(name, "c");
    fs::remove_dir(root.path().join("c")).unwrap();
    fs::remove_dir_all(&stage).unwrap();
    assert_eq!(held(root.path()), files(&OLD));
}

/// Where folders cannot change places in one operation, a process killed between the two renames leaves what the next
/// one puts back.
#[test]
fn a_folder_that_went_aside_comes_back() {
    let root = root();
    let folder = root.path().join("out");
    put(&folder, "press", false, &[("a", "1")]).unwrap();
    let stage = root.path().join(".out.AbCd12.erard.part");
    fs::create_dir_all(stage.join("results")).unwrap();
    fs::write(stage.join("lock"), "").unwrap();
    fs::rename(&folder, stage.join("old")).unwrap();
    recover(&folder).unwrap();
    assert_eq!(held(&folder), files(&[("a", "1")]));
    assert!(!stage.exists());
}

/// Who lives is not cleared away, nor is what only looks like a stage.
#[test]
fn stages_of_the_living_stay() {
    let root = root();
    let folder = root.path().join("out");
    let mut one = Output::results(&Session::silent(), &folder, "press", false, &[]).unwrap();
    write(&mut one, "a", "one").unwrap();
    // Names that a user may have chosen, the last one of a stage's own form.
    let users = [".out.mine.part", ".out.backup.part", ".out.backup.erard.part"].map(|name| root.path().join(name));
    for folder in &users {
        fs::create_dir(folder).unwrap();
        fs::write(folder.join("kept"), "mine").unwrap();
    }
    put(&folder, "press", false, &[("a", "two")]).unwrap();
    assert_eq!(held(&folder), files(&[("a", "two")]));
    one.commit(&Session::silent()).unwrap();
    assert_eq!(held(&folder), files(&[("a", "one")]));
    assert!(users.iter().all(|folder| fs::read_to_string(folder.join("kept")).unwrap() == "mine"));
}

/// A folder that the journal would have to follow out of its own is refused.
#[test]
fn journals_are_not_trusted() {
    let root = root();
    let folder = root.path().join("in");
    fs::create_dir(&folder).unwrap();
    fs::write(root.path().join("precious"), "mine").unwrap();
    let stage = killed_after(&folder, 0);
    let text = "{\"format\":\"erard-journal/1\",\"install\":[],\"remove\":[\"../precious\"]}";
    fs::write(stage.join("journal.json"), text).unwrap();
    recover(&folder).unwrap_err();
    assert_eq!(fs::read_to_string(root.path().join("precious")).unwrap(), "mine");
}
