//! The commit that the program is built from, for its results to name. Unknown where there is no repository, as in a package.

use std::path::Path;
use std::process::Command;

fn git(arguments: &[&str]) -> Option<String> {
    let output = Command::new("git").args(arguments).output().ok().filter(|output| output.status.success())?;
    Some(String::from_utf8(output.stdout).ok()?.trim().to_owned())
}

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    // A repository that happens to hold an unpacked package is none of ours.
    if !Path::new("../moreau").is_dir() {
        return;
    }
    let Some(commit) = git(&["rev-parse", "--short=12", "HEAD"]) else { return };
    for moves in ["HEAD", "index"].into_iter().filter_map(|name| git(&["rev-parse", "--git-path", name])) {
        println!("cargo::rerun-if-changed={moves}");
    }
    if let Some(branch) = git(&["symbolic-ref", "-q", "HEAD"]).and_then(|name| git(&["rev-parse", "--git-path", &name]))
    {
        if Path::new(&branch).exists() {
            println!("cargo::rerun-if-changed={branch}");
        }
    }
    // What is compiled in, and is not as it was committed.
    println!("cargo::rerun-if-changed=src");
    let changed = git(&["status", "--porcelain", "--untracked-files=no", "--", "..", "../../Cargo.lock"]);
    let mark = if changed.is_some_and(|changed| changed.is_empty()) { "" } else { "+" };
    println!("cargo::rustc-env=ERARD_COMMIT={commit}{mark}");
}
