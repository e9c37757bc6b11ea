//! `erard reproduce` as a user runs it.

use std::fs;

use crate::common::Folder;

fn folder(test: &str) -> Folder {
    Folder::for_command("reproduce", test)
}

/// The page that a run left behind.
fn report(folder: &Folder, out: &str) -> String {
    folder.read(&format!("{out}/report.html"))
}

/// One subject alone: its figures, its claims with verdicts, the command that makes it again; the same bytes twice, and nothing
/// fetched from anywhere.
#[test]
fn one_subject() {
    let folder = folder("one");
    for out in ["a", "b"] {
        let output = folder.erard(&["--only", "paper3-levers", "--out", out]);
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        assert!(String::from_utf8(output.stdout).unwrap().contains("6 of 6 claims hold."));
    }
    let page = report(&folder, "a");
    assert_eq!(page, report(&folder, "b"));
    assert_eq!(page.matches("<svg ").count(), 2);
    assert_eq!(page.matches("Again: <code>erard reproduce --only paper3-levers</code>").count(), 1);
    assert_eq!(page.matches("<b>Holds.</b>").count(), 6);
    assert!(page.contains("cos(k)") || page.contains("cos k"), "the equations as generated");
    assert!(!page.contains("NaN") && !page.contains("src=") && !page.contains("https://"));
    let files: Vec<_> = fs::read_dir(folder.0.join("a")).unwrap().collect();
    assert_eq!(files.len(), 2, "the report needs nothing beside it; whose it is stands in the folder's mark");
}

/// The beginning of a name stands for all subjects that begin so.
#[test]
fn several_subjects() {
    let folder = folder("several");
    let output = folder.erard(&["--only", "paper2-f", "--only", "outlook"]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let page = report(&folder, "erard-out-reproduce");
    let sections: Vec<&str> = page.split("<section id=\"").skip(1).filter_map(|s| s.split('"').next()).collect();
    assert_eq!(sections, ["paper2-felt", "paper2-finger", "outlook"]);
}

/// What does not exist is named, with what does; code 2, and nothing is written.
#[test]
fn unknown_subjects_are_named() {
    let folder = folder("unknown");
    for arguments in [&["--only", "paper4"][..], &["--only", ""], &["--only", "outlook", "--instrument", "none"]] {
        let output = folder.erard(arguments);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}");
        assert!(output.stdout.is_empty() && !folder.0.join("erard-out-reproduce").exists(), "{arguments:?}");
    }
    let error = String::from_utf8(folder.erard(&["--only", "paper4"]).stderr).unwrap();
    assert!(error.contains("paper4") && error.contains("paper2-convergence"), "{error}");
}

/// `--list` names every subject.
#[test]
fn the_list() {
    let folder = folder("list");
    let output = folder.erard(&["--list"]);
    let text = String::from_utf8(output.stdout).unwrap();
    assert_eq!(text.lines().count(), 22);
    assert!(text.contains("conformance ") && text.contains("scheme-order"));
}
