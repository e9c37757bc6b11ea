//! Generated files of the repository, which tests compare with what the program makes now.

use std::path::{Path, PathBuf};

/// Folder below which a test writes its generated files instead of comparing them: the repository for
/// `.ci/regenerate`, an empty folder for `.ci/regenerate --check`.
pub fn rewritten_below() -> Option<PathBuf> {
    std::env::var_os("ERARD_REGENERATE").map(PathBuf::from)
}

/// Writes a file below a folder; `path` is its path in the repository.
pub fn write(folder: &Path, path: &str, made: &[u8]) {
    let file = folder.join(path);
    std::fs::create_dir_all(file.parent().expect("in a folder")).expect("a folder");
    std::fs::write(&file, made).unwrap_or_else(|error| panic!("{}: {error}", file.display()));
}

/// Compares a file of the repository with what the program makes now, or rewrites it for `.ci/regenerate`. `name` is
/// the file's name there.
#[track_caller]
pub fn is_current(path: &str, made: impl AsRef<[u8]>, name: &str) {
    if let Some(folder) = rewritten_below() {
        write(&folder, path, made.as_ref());
        return;
    }
    let kept = std::fs::read(Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").join(path)).unwrap_or_default();
    assert!(kept == made.as_ref(), "{path} is stale: `.ci/regenerate {name}` rewrites it");
}
