//! What a manifest tells Cargo not to look for is not there: a library with `test = false` has no unit tests, one with
//! `doctest = false` no examples in its documentation. Each would be compiled once more to find none.

use std::fs;
use std::path::Path;

use crate::imports::{crates, manifest};

/// Languages of blocks that are no examples in Rust.
const NO_RUST: [&str; 4] = ["text", "sh", "toml", "json"];

/// The sources below a folder.
fn sources(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    entries
        .flat_map(|path| match path.is_dir() {
            true => sources(&path),
            false if path.extension().is_some_and(|end| end == "rs") => vec![fs::read_to_string(&path).unwrap()],
            false => Vec::new(),
        })
        .collect()
}

/// The first line of every block in the documentation.
fn blocks(source: &str) -> impl Iterator<Item = &str> {
    let lines = source.lines().map(str::trim_start);
    let documentation = lines.filter_map(|line| line.strip_prefix("///").or(line.strip_prefix("//!")));
    documentation.filter_map(|line| line.trim_start().strip_prefix("```")).step_by(2)
}

#[test]
fn what_cargo_does_not_look_for_is_not_there() {
    let mut looked = [0, 0];
    for folder in crates() {
        let manifest = manifest(&folder);
        let off = |key: &str| manifest.get("lib").and_then(|lib| lib.get(key)?.as_bool()) == Some(false);
        let (tests, examples) = (off("test"), off("doctest"));
        looked = [looked[0] + u32::from(tests), looked[1] + u32::from(examples)];
        // The kernels' own test knows of a file whose unit tests are compiled elsewhere.
        let tests = tests && !folder.ends_with("moreau-kernels");
        for source in sources(&folder.join("src")) {
            assert!(!(tests && source.contains("#[test]")), "{}: unit tests that nothing runs", folder.display());
            let rust = blocks(&source).find(|language| !NO_RUST.contains(language));
            assert!(!examples || rust.is_none(), "{}: examples that nothing runs", folder.display());
        }
    }
    assert!(looked[0] >= 3 && looked[1] >= 7, "{looked:?}");
}
