//! The engine's files form layers: no circle of imports has more than two files.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

/// Modules by their path, e.g. `osnsp::relay`, with their source. A directory's `mod.rs` is the module itself; `lib.rs` is the empty path.
fn modules(directory: &Path, path: &str, found: &mut BTreeMap<String, String>) {
    for entry in fs::read_dir(directory).unwrap() {
        let entry = entry.unwrap().path();
        let stem = entry.file_stem().unwrap().to_str().unwrap().to_owned();
        let inner = if path.is_empty() { stem.clone() } else { format!("{path}::{stem}") };
        if entry.is_dir() {
            modules(&entry, &inner, found);
        } else if entry.extension().is_some_and(|e| e == "rs") {
            let module = if stem == "mod" || stem == "lib" { path.to_owned() } else { inner };
            found.insert(module, fs::read_to_string(&entry).unwrap());
        }
    }
}

/// The paths of `use` declarations, braces resolved, without those of test modules, which stand at a file's end.
fn uses(source: &str) -> Vec<(bool, String)> {
    let source = source.split("#[cfg(test)]").next().unwrap();
    let mut found = Vec::new();
    let mut rest = source;
    while let Some(at) = rest.find("use ") {
        let before = rest[..at].rsplit('\n').next().unwrap().trim();
        let (declaration, after) = rest[at + 4..].split_once(';').unwrap_or(("", ""));
        // Not within a comment or a word; `pub use` hands a name on and depends on nothing.
        if before.is_empty() || before.starts_with("pub") {
            let flat: String = declaration.split_whitespace().collect::<Vec<_>>().join(" ");
            expand("", &flat, before.starts_with("pub"), &mut found);
            rest = after;
        } else {
            rest = &rest[at + 4..];
        }
    }
    found
}

fn expand(prefix: &str, tree: &str, public: bool, found: &mut Vec<(bool, String)>) {
    let Some(open) = tree.find('{') else {
        let path = tree.split(" as ").next().unwrap().trim();
        let path = if path == "self" { prefix.trim_end_matches("::").to_owned() } else { format!("{prefix}{path}") };
        found.push((public, path));
        return;
    };
    let inner = tree[open + 1..].trim_end().strip_suffix('}').expect("balanced braces");
    let prefix = format!("{prefix}{}", tree[..open].trim());
    let (mut depth, mut start) = (0, 0);
    for (i, c) in inner.char_indices().chain([(inner.len(), ',')]) {
        match c {
            '{' => depth += 1,
            '}' => depth -= 1,
            ',' if depth == 0 => {
                if !inner[start..i].trim().is_empty() {
                    expand(&prefix, inner[start..i].trim(), public, found);
                }
                start = i + 1;
            }
            _ => {}
        }
    }
}

/// `super::` and `crate::` made absolute; `None` for other crates.
fn absolute(module: &str, path: &str, modules: &BTreeMap<String, String>) -> Option<String> {
    if let Some(path) = path.strip_prefix("crate::") {
        return Some(path.to_owned());
    }
    if let Some(mut path) = path.strip_prefix("super::") {
        let mut parts: Vec<&str> = module.split("::").collect();
        parts.pop();
        while let Some(rest) = path.strip_prefix("super::") {
            parts.pop();
            path = rest;
        }
        parts.push(path);
        return Some(parts.join("::"));
    }
    // A child, named from its parent's file.
    let child = if module.is_empty() { path.to_owned() } else { format!("{module}::{path}") };
    modules.contains_key(&file_of(&child, modules)?).then_some(child)
}

/// The longest prefix of a path that is a file.
fn file_of(path: &str, modules: &BTreeMap<String, String>) -> Option<String> {
    let mut parts: Vec<&str> = path.split("::").collect();
    while !parts.is_empty() {
        if modules.contains_key(&parts.join("::")) {
            return Some(parts.join("::"));
        }
        parts.pop();
    }
    None
}

/// The file that defines what a path names: re-exports are followed.
fn definition(path: &str, modules: &BTreeMap<String, String>, handed_on: &BTreeMap<String, String>) -> Option<String> {
    let mut path = path.to_owned();
    while let Some(next) = handed_on.get(&path) {
        path.clone_from(next);
    }
    file_of(&path, modules)
}

/// From each file to those that it imports from.
fn graph(modules: &BTreeMap<String, String>) -> BTreeMap<String, BTreeSet<String>> {
    let mut handed_on = BTreeMap::new();
    for (module, source) in modules {
        for (_, path) in uses(source).into_iter().filter(|(public, _)| *public) {
            let Some(target) = absolute(module, &path, modules) else { continue };
            let name = path.rsplit("::").next().unwrap();
            let handed = if module.is_empty() { name.to_owned() } else { format!("{module}::{name}") };
            if handed != target {
                handed_on.insert(handed, target);
            }
        }
    }
    let mut graph = BTreeMap::new();
    for (module, source) in modules {
        let imports: BTreeSet<String> = uses(source)
            .into_iter()
            .filter(|(public, _)| !public)
            .filter_map(|(_, path)| absolute(module, &path, modules))
            .filter_map(|path| definition(&path, modules, &handed_on))
            .filter(|file| file != module)
            .collect();
        graph.insert(module.clone(), imports);
    }
    graph
}

/// All that can be reached from a file.
fn reach<'a>(graph: &'a BTreeMap<String, BTreeSet<String>>, from: &'a str) -> BTreeSet<&'a str> {
    let (mut reached, mut left) = (BTreeSet::new(), vec![from]);
    while let Some(file) = left.pop() {
        for next in &graph[file] {
            if reached.insert(next.as_str()) {
                left.push(next);
            }
        }
    }
    reached
}

/// The files that a file reaches and that reach it: its circle.
fn circles(graph: &BTreeMap<String, BTreeSet<String>>) -> Vec<BTreeSet<&str>> {
    let reached: BTreeMap<&str, BTreeSet<&str>> =
        graph.keys().map(|file| (file.as_str(), reach(graph, file))).collect();
    let mut circles: Vec<BTreeSet<&str>> = Vec::new();
    for (&file, others) in &reached {
        let circle: BTreeSet<&str> = others.iter().copied().filter(|other| reached[other].contains(file)).collect();
        if circle.len() > 1 && !circles.contains(&circle) {
            circles.push(circle);
        }
    }
    circles
}

#[test]
fn no_circle_of_imports_has_more_than_two_files() {
    let mut found = BTreeMap::new();
    modules(&Path::new(env!("CARGO_MANIFEST_DIR")).join("src"), "", &mut found);
    let graph = graph(&found);
    // The reading works: some edges that are there for certain, one of them through a re-export.
    for (from, to) in [("step", "workspace"), ("workspace", "osnsp::system"), ("osnsp::relay", "osnsp::delassus")] {
        assert!(graph[from].contains(to), "{from} imports from {to}: {:?}", graph[from]);
    }
    let circles = circles(&graph);
    assert!(circles.iter().all(|circle| circle.len() <= 2), "{circles:#?}");
}

/// The search finds a circle where there is one.
#[test]
fn a_circle_is_found() {
    let source = |uses: &str| uses.to_owned();
    let files = [
        ("a", source("use crate::b::{self, Thing};\n")),
        ("b", source("use crate::{One, d::{Two, Three as Third}};\n")),
        ("c", source("use super::a::Other;\n")),
        ("d", source("// use crate::a::Not;\nuse core::fmt;\n")),
        ("", source("mod c;\npub use c::One;\n")),
    ];
    let files = files.map(|(name, source)| (name.to_owned(), source)).into();
    let graph = graph(&files);
    assert_eq!(graph["b"], BTreeSet::from(["c".to_owned(), "d".to_owned()]));
    assert_eq!(circles(&graph), [BTreeSet::from(["a", "b", "c"])]);
}
