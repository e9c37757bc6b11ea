//! Everything below a folder, to be compared before and after.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

/// A file or folder under a path.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Thing {
    Folder,
    File(Vec<u8>),
    Link(PathBuf),
    Other,
}

/// Everything below a folder, by its path there.
pub type Look = BTreeMap<PathBuf, Thing>;

/// Looks at a folder. Links are not followed: what they lead to within the folder stands there, too.
pub fn look(folder: &Path) -> Look {
    fn below(folder: &Path, root: &Path, found: &mut Look) {
        for entry in fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            let kind = path.symlink_metadata().unwrap().file_type();
            let thing = if kind.is_symlink() {
                Thing::Link(fs::read_link(&path).unwrap())
            } else if kind.is_dir() {
                below(&path, root, found);
                Thing::Folder
            } else if kind.is_file() {
                Thing::File(fs::read(&path).unwrap())
            } else {
                Thing::Other
            };
            found.insert(path.strip_prefix(root).unwrap().to_path_buf(), thing);
        }
    }
    let mut found = Look::new();
    below(folder, folder, &mut found);
    found
}
