//! State of a program lives in what is passed along, not in statics: those that are left have a reason.

use std::fs;
use std::path::{Path, PathBuf};

/// Statics that change, by file and name, each with its reason.
const ALLOWED: &[(&str, &str)] = &[
    // The last error of each thread is the C interface: `erard_last_error`.
    ("bindings/c/src/status.rs", "LAST"),
    // The outlines of the bundled face are read once.
    ("crates/erard-figures/src/picture/face.rs", "FACE"),
    // The counter of a benchmark's own number type.
    ("papers/bench/benches/operations.rs", "COUNTS"),
];

/// Types whose values change behind a shared reference.
const MUTABLE: [&str; 6] = ["Mutex", "RwLock", "Atomic", "Cell", "Once", "mut "];

/// The names of the statics in a source that change. A `LazyLock` is a constant, unless it holds one of them.
fn mutable(source: &str) -> Vec<String> {
    let declared = source.match_indices("static ").filter_map(|(at, word)| {
        let line = &source[..at];
        let line = line.rsplit('\n').next().unwrap_or_default().trim();
        let is_declaration = line.is_empty() || line == "pub" || line.starts_with("pub(") && line.ends_with(')');
        let rest = &source[at + word.len()..];
        let kind = &rest[..rest.find([';', '=']).unwrap_or(rest.len())];
        let (name, _) = kind.trim_start_matches("mut ").split_once(':')?;
        let is_name = name.trim().chars().all(|c| c.is_ascii_uppercase() || c.is_ascii_digit() || c == '_');
        let changes = MUTABLE.iter().any(|one| kind.contains(one));
        (is_declaration && is_name && changes).then(|| name.trim().to_owned())
    });
    declared.collect()
}

#[test]
fn a_static_that_changes_is_found() {
    let source = "static A: Mutex<u8> = Mutex::new(1);\n    pub(crate) static B: LazyLock<\n Vec<RefCell<u8>>> = LazyLock::new(f);\n\
                  static mut C: u8 = 1;\n static D: LazyLock<u8> = LazyLock::new(|| 1);\nfn f(x: &'static Mutex<u8>) {}\n\
                  // static E: Mutex<u8> = 1;\npub static F: AtomicBool = AtomicBool::new(true);";
    assert_eq!(mutable(source), ["A", "B", "C", "F"]);
}

/// Sources of the folder, without tests.
fn sources(folder: &Path, all: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).into_iter().flatten() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        if path.is_dir() {
            if !["tests", "target", "node_modules"].contains(&&name[..]) && !name.starts_with('.') {
                sources(&path, all);
            }
        } else if name.ends_with(".rs") && name != "tests.rs" {
            all.push(path);
        }
    }
}

#[test]
fn no_other_static_changes() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let mut files = Vec::new();
    for folder in ["crates", "papers", "bindings", "studio"] {
        sources(&root.join(folder), &mut files);
    }
    assert!(files.len() > 300, "{} sources", files.len());
    let mut found: Vec<(String, String)> = Vec::new();
    for file in files {
        let name = file.strip_prefix(&root).unwrap().to_string_lossy().replace('\\', "/");
        found.extend(mutable(&fs::read_to_string(&file).unwrap()).into_iter().map(|one| (name.clone(), one)));
    }
    found.sort();
    let mut allowed: Vec<_> = ALLOWED.iter().map(|(file, name)| ((*file).to_owned(), (*name).to_owned())).collect();
    allowed.sort();
    assert_eq!(found, allowed, "pass state along (in the command: `Session`), or give a reason here");
}
