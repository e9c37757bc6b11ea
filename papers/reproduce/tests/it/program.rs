//! `erard-reproduce` as a user runs it.

use std::fs;
use std::path::PathBuf;
use std::process::{Command, Output, Stdio};
use std::time::Duration;

use serde_json::Value;

use crate::schema::faults;

/// A folder of its own for a test, gone at its end.
struct Folder(PathBuf);

impl Folder {
    fn new(test: &str) -> Self {
        let folder = std::env::temp_dir().join(format!("erard-reproduce-{test}-{}", std::process::id()));
        let _ = fs::remove_dir_all(&folder);
        fs::create_dir_all(&folder).unwrap();
        Folder(folder)
    }

    fn erard(&self, arguments: &[&str]) -> Output {
        let mut command = Command::new(env!("CARGO_BIN_EXE_erard-reproduce"));
        command.current_dir(&self.0).args(arguments).output().unwrap()
    }

    fn report(&self, out: &str) -> String {
        fs::read_to_string(self.0.join(out).join("report.html")).unwrap()
    }
}

fn folder(test: &str) -> Folder {
    Folder::new(test)
}

/// The page that a run left behind.
fn report(folder: &Folder, out: &str) -> String {
    folder.report(out)
}

/// One subject alone: its figures, its claims with verdicts, the command that makes it again; the same bytes twice, and
/// nothing fetched from anywhere.
#[test]
fn one_subject() {
    let folder = folder("one");
    for out in ["a", "b"] {
        let output = folder.erard(&["--only", "paper3-levers", "--out", out]);
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        assert!(String::from_utf8(output.stdout).unwrap().contains("9 of 9 claims hold."));
    }
    let page = report(&folder, "a");
    assert_eq!(page, report(&folder, "b"));
    assert_eq!(page.matches("<svg ").count(), 2);
    assert_eq!(page.matches("Again: <code>erard-reproduce --only paper3-levers</code>").count(), 1);
    assert_eq!(page.matches("<b>Holds.</b>").count(), 9);
    assert!(page.contains("cos(k)") || page.contains("cos k"), "the equations as generated");
    assert!(!page.contains("NaN") && !page.contains("src=") && !page.contains("https://"));
    let files: Vec<_> = fs::read_dir(folder.0.join("a")).unwrap().collect();
    assert_eq!(files.len(), 2, "the report needs nothing beside it; whose it is stands in the folder's mark");
}

/// The beginning of a name selects all subjects that begin with it.
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
    assert_eq!(text.lines().count(), 32);
    assert!(text.contains("conformance ") && text.contains("scheme-order"));
}

/// Tables come in place of claims, with their headings.
#[test]
fn tables_in_place_of_claims() {
    let output = folder("tables").erard(&["--only", "laid-weight", "--tables"]);
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(
        text.contains("contact") && text.contains("it by") && text.contains(" 300 ") && !text.contains("asked of"),
        "{text}"
    );
}

/// The answer with `--json` has what its schema requires, of the types that it says, and names the program's own
/// command. Its exit code is 0 where every claim holds, although misses were to fail.
#[test]
fn answers_have_their_schemas() {
    let folder = Folder::new("json");
    for (schema, arguments) in [
        ("reproduce", &["--only", "paper2-rest", "--fail-on-miss", "--json"][..]),
        ("reproduce-list", &["--list", "--json"]),
    ] {
        let output = folder.erard(arguments);
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let answer: Value = serde_json::from_slice(&output.stdout).unwrap();
        let home = format!("{}/schemas/{schema}.schema.json", env!("CARGO_MANIFEST_DIR"));
        let schema: Value = serde_json::from_str(&fs::read_to_string(home).unwrap()).unwrap();
        let mut found = Vec::new();
        faults(&answer, &schema, "", &mut found);
        assert!(found.is_empty(), "{arguments:?}: {found:#?}");
        faults(&Value::Object(serde_json::Map::new()), &schema, "", &mut found);
        assert!(!found.is_empty(), "{arguments:?}: an empty object conforms");
        assert!(answer["made_by"]["command"].as_str().unwrap().starts_with("erard-reproduce "), "{answer}");
    }
}

/// Control-C while subjects are computed: code 130, and nothing is left.
#[cfg(unix)]
#[test]
fn control_c_is_heard() {
    crate::signals::as_at_a_terminal();
    let folder = Folder::new("control-c");
    let mut child = Command::new(env!("CARGO_BIN_EXE_erard-reproduce"))
        .current_dir(&folder.0)
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    crate::signals::until_it_listens(&mut child);
    std::thread::sleep(Duration::from_millis(300));
    assert!(child.try_wait().unwrap().is_none(), "it had finished");
    assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
    assert_eq!(child.wait().unwrap().code(), Some(130));
    assert_eq!(fs::read_dir(&folder.0).unwrap().count(), 0);
}
