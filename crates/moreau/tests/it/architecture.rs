//! What ARCHITECTURE.md says is there: the files it names, and the functions on the way of a press; and that one build
//! of the command serves its tests, too, and holds nothing that serves no product.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::imports::{crates, manifest};

/// Most files that a press may pass through, and most methods of `Mechanism`.
const MAX_FILES: usize = 18;
const MAX_METHODS: usize = 12;

/// Members of the workspace that serve no product: a second step, textbook problems, benchmarks, the papers' programs,
/// digests of another machine, the book's equations. `.ci/run` builds and tests them; `cargo run` and `cargo test` do
/// not compile them.
const NO_PRODUCTS: [&str; 6] =
    ["moreau-rigid", "moreau-conformance", "erard-bench", "erard-reproduce", "erard-wasm-digests", "erard-equations"];

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// What stands between backquotes.
fn quoted(text: &str) -> impl Iterator<Item = &str> {
    text.split('`').skip(1).step_by(2)
}

/// The cells of the rows of the table that begins after a heading.
fn table<'a>(page: &'a str, heading: &str) -> Vec<Vec<&'a str>> {
    let (_, after) = page.split_once(heading).unwrap_or_else(|| panic!("ARCHITECTURE has no `{heading}`"));
    let rows = after.lines().skip_while(|line| !line.starts_with('|')).take_while(|line| line.starts_with('|'));
    rows.skip(2).map(|row| row.trim_matches('|').split('|').map(str::trim).collect()).collect()
}

fn page() -> String {
    fs::read_to_string(root().join("ARCHITECTURE.md")).unwrap()
}

/// Each row of the way of a press is a file, and its functions are in it.
#[test]
fn the_way_of_a_press_is_as_it_says() {
    let page = page();
    let rows = table(&page, "## The way of a press");
    assert!(!rows.is_empty() && rows.len() <= MAX_FILES, "{} files", rows.len());
    for row in rows {
        let file = quoted(row[1]).next().unwrap();
        let (folder, inner) = file.split_once('/').unwrap();
        let source = fs::read_to_string(root().join("crates").join(folder).join(inner))
            .unwrap_or_else(|error| panic!("{file}: {error}"));
        for function in quoted(row[2]) {
            let (owner, name) = function.rsplit_once("::").unwrap_or(("", function));
            let declared = |(at, _): (usize, &str)| {
                !source[at..].starts_with(|c: char| c.is_alphanumeric() || c == '_')
                    && source[..at].ends_with(&format!("fn {name}"))
            };
            let found = source.match_indices(['(', '<']).any(declared);
            // A type is only named.
            let is_type = name.starts_with(char::is_uppercase);
            assert!((found || is_type) && source.contains(owner), "{file} has no {function}");
        }
    }
}

#[test]
fn mechanism_has_no_more_methods_than_it_says() {
    let source = fs::read_to_string(root().join("crates/moreau-kernels/src/mechanism.rs")).unwrap();
    let (_, after) = source.split_once("pub trait Mechanism").unwrap();
    let methods = after.split("\n}").next().unwrap().matches("    fn ").count();
    assert!(methods > 0 && methods <= MAX_METHODS, "{methods}");
    assert!(page().contains(&format!("`Mechanism` ({methods} methods)")), "{methods}");
}

/// Files of the table of changes, and folders of the rooms.
#[test]
fn the_files_it_names_are_there() {
    let page = page();
    let mut missing = Vec::new();
    for row in table(&page, "## Where to change what") {
        // A path without its crate is in the folder of the one before it.
        let mut before = PathBuf::new();
        for path in
            quoted(row[1]).filter(|path| path.ends_with(".rs") || path.ends_with('/') || path.ends_with(".toml"))
        {
            let folders = before.ancestors().map(|folder| folder.join(path));
            let places = [root().join("crates").join(path), root().join(path)].into_iter().chain(folders);
            match places.into_iter().find(|place| place.exists()) {
                Some(found) => before = found,
                None => missing.push(path),
            }
        }
    }
    for row in table(&page, "(module `architecture`).\n") {
        missing.extend(quoted(row[0]).filter(|path| !root().join(path).exists()));
    }
    assert!(missing.is_empty(), "{missing:?}");
}

/// Every package of a build with its features, as cargo resolves them, a line each.
fn packages(of: &[&str]) -> BTreeSet<String> {
    let tree = ["tree", "--offline", "--locked", "--prefix", "none", "--format", "{p} {f}"];
    let output = Command::new(env!("CARGO")).args(tree).args(of).current_dir(root()).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap().lines().map(|line| line.trim_end_matches(" (*)").to_owned()).collect()
}

/// The names of the packages in folders of the workspace.
fn names(folders: &toml::Value) -> BTreeSet<String> {
    let folders = folders.as_array().unwrap().iter().map(|folder| folder.as_str().unwrap());
    let manifests = folders.map(|folder| manifest(&root().join(folder)));
    manifests.map(|manifest| manifest["package"]["name"].as_str().unwrap().to_owned()).collect()
}

/// `cargo run` and `cargo test` compile products only: a member of the workspace is a default one, or serves no
/// product. No product needs one of these, not even for its tests.
#[test]
fn products_need_products_only() {
    let workspace = manifest(&root());
    let [members, products] =
        ["members", "default-members"].map(|which| names(&workspace["workspace"].as_table().unwrap()[which]));
    let others: BTreeSet<String> = NO_PRODUCTS.map(str::to_owned).into();
    assert_eq!(members.difference(&products).cloned().collect::<BTreeSet<_>>(), others);
    assert!(products.is_subset(&members) && products.contains("erard-cli"), "{products:?}");
    // The tests' dependencies are among them.
    let tests = packages(&[]);
    assert!(tests.iter().any(|package| package.starts_with("allocation-counter ")), "{tests:?}");
    let named = |name: &str| tests.iter().any(|package| package.split(' ').next() == Some(name));
    let needed: Vec<&String> = others.iter().filter(|other| named(other)).collect();
    assert!(needed.is_empty(), "`cargo test --release` compiles {needed:?}, which serve no product");
    // Benchmarks share workloads: they are in one crate above all others.
    for folder in crates() {
        let is_theirs = folder.ends_with("papers/bench");
        let has = folder.join("benches").exists() || manifest(&folder).contains_key("bench");
        assert_eq!(has, is_theirs, "{}: benchmarks belong to papers/bench", folder.display());
    }
}

/// What the command is made of has the same features in the tests: else they compile it again, from the first library
/// that differs up to the command.
#[test]
fn tests_compile_nothing_of_the_command_again() {
    let command = packages(&["--package", "erard-cli", "--edges", "no-dev"]);
    let tests = packages(&[]);
    assert!(command.len() > 100, "{command:?}");
    let again: Vec<&String> = command.difference(&tests).collect();
    assert!(again.is_empty(), "other features in the tests: {again:#?}");
}
