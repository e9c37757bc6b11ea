//! The commit that the program is built from, for its results to name: unknown where there is no repository, as in a
//! package. And the studio's page, where ERARD_STUDIO names the folder that `studio/build` made.

use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::process::Command;

/// All files of a folder, by their paths in it, in order.
fn files(folder: &Path, within: &str, found: &mut Vec<(String, PathBuf)>) {
    let entries =
        std::fs::read_dir(folder).unwrap_or_else(|error| panic!("ERARD_STUDIO: {}: {error}", folder.display()));
    for entry in entries.flatten() {
        let (path, name) = (entry.path(), format!("{within}{}", entry.file_name().to_string_lossy()));
        if path.is_dir() {
            files(&path, &format!("{name}/"), found);
        } else {
            found.push((name, path));
        }
    }
    found.sort();
}

/// Writes down the page's files, none where there is no page.
fn studio() {
    println!("cargo::rerun-if-env-changed=ERARD_STUDIO");
    let mut found = Vec::new();
    if let Some(folder) = std::env::var_os("ERARD_STUDIO").filter(|folder| !folder.is_empty()) {
        let folder = std::path::absolute(folder).expect("ERARD_STUDIO names a folder");
        println!("cargo::rerun-if-changed={}", folder.display());
        files(&folder, "", &mut found);
        assert!(
            found.iter().any(|(name, _)| name == "engine.bin"),
            "ERARD_STUDIO: {}: is no built studio",
            folder.display()
        );
    }
    let mut text = String::from("pub static FILES: &[(&str, &[u8])] = &[\n");
    for (name, path) in &found {
        let _ = writeln!(text, "    ({name:?}, include_bytes!({:?})),", path.display().to_string());
    }
    text.push_str("];\n");
    let out = PathBuf::from(std::env::var_os("OUT_DIR").expect("cargo sets OUT_DIR")).join("studio.rs");
    std::fs::write(&out, text).expect("OUT_DIR can be written");
}

fn git(arguments: &[&str]) -> Option<String> {
    let output = Command::new("git").args(arguments).output().ok().filter(|output| output.status.success())?;
    Some(String::from_utf8(output.stdout).ok()?.trim().to_owned())
}

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    studio();
    // A repository that happens to hold an unpacked package is none of ours.
    if !Path::new("../moreau").is_dir() {
        return;
    }
    let Some(commit) = git(&["rev-parse", "--short=12", "HEAD"]) else { return };
    for moves in ["HEAD", "index"].into_iter().filter_map(|name| git(&["rev-parse", "--git-path", name])) {
        println!("cargo::rerun-if-changed={moves}");
    }
    if let Some(branch) = git(&["symbolic-ref", "-q", "HEAD"]).and_then(|name| git(&["rev-parse", "--git-path", &name]))
        && Path::new(&branch).exists()
    {
        println!("cargo::rerun-if-changed={branch}");
    }
    // What is compiled in, and is not as it was committed.
    println!("cargo::rerun-if-changed=src");
    let changed = git(&["status", "--porcelain", "--untracked-files=no", "--", "..", "../../Cargo.lock"]);
    let mark = if changed.is_some_and(|changed| changed.is_empty()) { "" } else { "+" };
    println!("cargo::rustc-env=ERARD_COMMIT={commit}{mark}");
}
