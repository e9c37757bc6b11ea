//! Imports go downward, between crates and within them: no circle of folders, and no circle of files, in any crate and
//! in the Python package; in some crates two files may import each other. Dependencies of development are no exception.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

/// The crates from bottom to top: one may depend on those before it.
const FLOORS: [&str; 18] = [
    "moreau",
    "moreau-kernels",
    "moreau-rigid",
    "moreau-conformance",
    "erard-midi",
    "erard-core",
    "erard",
    "erard-kinematics",
    "erard-workshop",
    "erard-live",
    "erard-piece",
    "erard-figures",
    "erard-cli",
    "erard-c",
    "erard-python",
    "erard-bench",
    "erard-reproduce",
    "erard-firmware",
];

/// Crates in which two files may import each other.
const PAIRED: [&str; 7] =
    ["moreau", "moreau-kernels", "moreau-rigid", "erard-core", "erard-kinematics", "erard-c", "erard-reproduce"];

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// The crates' folders.
pub(crate) fn crates() -> Vec<PathBuf> {
    let rooms = ["crates", "bindings", "papers"];
    let folders = rooms.iter().flat_map(|room| fs::read_dir(root().join(room)).unwrap()).map(|e| e.unwrap().path());
    let mut crates: Vec<PathBuf> = folders.filter(|folder| folder.join("Cargo.toml").is_file()).collect();
    crates.sort();
    crates
}

/// A manifest, its name, and the names of what one of its tables depends on.
pub(crate) fn manifest(folder: &Path) -> toml::Table {
    fs::read_to_string(folder.join("Cargo.toml")).unwrap().parse().unwrap()
}

fn name(manifest: &toml::Table) -> &str {
    manifest["package"]["name"].as_str().unwrap()
}

/// The packages that one of a manifest's tables names, whatever it calls them.
fn dependencies(folder_manifest: &toml::Table, table: &str) -> Vec<String> {
    let workspace = manifest(&root());
    let shared = &workspace["workspace"]["dependencies"];
    let named = |(key, value): (&String, &toml::Value)| {
        let given = if value.get("workspace").is_some() { &shared[key] } else { value };
        given.get("package").and_then(toml::Value::as_str).unwrap_or(key).to_owned()
    };
    folder_manifest.get(table).and_then(toml::Value::as_table).into_iter().flatten().map(named).collect()
}

/// Modules by their path, e.g. `osnsp::relay`, with their source. A directory's `mod.rs` is the module itself; `lib.rs`
/// is the empty path.
fn modules(directory: &Path, path: &str, found: &mut BTreeMap<String, String>) {
    for entry in fs::read_dir(directory).unwrap() {
        let entry = entry.unwrap().path();
        let stem = entry.file_stem().unwrap().to_str().unwrap().to_owned();
        let inner = if path.is_empty() { stem.clone() } else { format!("{path}::{stem}") };
        if entry.is_dir() {
            modules(&entry, &inner, found);
        } else if entry.extension().is_some_and(|e| e == "rs") {
            let module = if stem == "mod" || stem == "lib" { path.to_owned() } else { inner };
            if stem != "main" {
                found.insert(module, fs::read_to_string(&entry).unwrap());
            }
        }
    }
}

/// A source without the items that are compiled for its tests only, wherever they stand.
fn without_tests(source: &str) -> String {
    let (mut kept, mut lines) = (String::new(), source.lines());
    while let Some(line) = lines.next() {
        if line.trim() != "#[cfg(test)]" {
            kept.push_str(line);
            kept.push('\n');
            continue;
        }
        // As rustfmt writes it, an item ends with its first line that ends a statement or closes a brace at its own
        // depth.
        let depth = line.len() - line.trim_start().len();
        for item in lines.by_ref() {
            let own = item.len() - item.trim_start().len() == depth;
            if own && (item.ends_with(';') || item.ends_with('}')) {
                break;
            }
        }
    }
    kept
}

/// The paths of `use` declarations, braces resolved, without those of tests.
fn uses(source: &str) -> Vec<(bool, String)> {
    let source = without_tests(source);
    let source = source.as_str();
    let mut found = Vec::new();
    let mut rest = source;
    while let Some(at) = rest.find("use ") {
        let before = rest[..at].rsplit('\n').next().unwrap().trim();
        let (declaration, after) = rest[at + 4..].split_once(';').unwrap_or(("", ""));
        // Not within a comment or a word; `pub use` hands a name on and depends on nothing.
        let is_a_word = !rest[..at].ends_with(|c: char| c.is_alphanumeric() || c == '_');
        if is_a_word && (before.is_empty() || before.starts_with("pub")) {
            let flat: String = declaration.split_whitespace().collect::<Vec<_>>().join(" ");
            expand("", &flat, before.starts_with("pub"), &mut found);
            rest = after;
        } else {
            rest = &rest[at + 4..];
        }
    }
    found.extend(written_out(source).map(|path| (false, path)));
    found
}

/// Paths that stand in the code itself, `crate::a::b`; the declarations of `use` are among them once more, but for
/// their braces.
fn written_out(source: &str) -> impl Iterator<Item = String> {
    let code = source.lines().map(|line| line.split("//").next().unwrap_or("")).collect::<Vec<_>>().join("\n");
    let public = |before: &str| {
        let line = before.rsplit('\n').next().unwrap().trim();
        line.starts_with("pub") && line.ends_with("use")
    };
    let found: Vec<String> = code
        .match_indices("crate::")
        .filter(|(at, _)| !code[..*at].ends_with(|c: char| c.is_alphanumeric() || c == '_' || c == '$'))
        .filter(|(at, _)| !public(code[..*at].trim_end()))
        .map(|(at, _)| {
            let path = &code[at..];
            let end = path.find(|c: char| !(c.is_alphanumeric() || c == '_' || c == ':')).unwrap_or(path.len());
            path[..end].trim_end_matches(':').to_owned()
        })
        .collect();
    found.into_iter()
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

/// The graph of the folders and files in a folder (the crate's own: ""): from each to those beside it that it imports
/// from.
fn of_modules(graph: &BTreeMap<String, BTreeSet<String>>, folder: &str) -> BTreeMap<String, BTreeSet<String>> {
    let inside = |file: &str| {
        let inner = if folder.is_empty() { file } else { file.strip_prefix(folder)?.strip_prefix("::")? };
        inner.split("::").next().filter(|top| !top.is_empty()).map(str::to_owned)
    };
    let mut modules: BTreeMap<String, BTreeSet<String>> =
        graph.keys().filter_map(|file| inside(file)).map(|top| (top, BTreeSet::new())).collect();
    for (file, imports) in graph {
        let Some(top) = inside(file) else { continue };
        let others = imports.iter().filter_map(|import| inside(import)).filter(|other| *other != top);
        let others: Vec<String> = others.collect();
        modules.entry(top).or_default().extend(others);
    }
    modules
}

/// What of a graph of files goes in a circle that it should not; `most` files may.
fn faults(graph: &BTreeMap<String, BTreeSet<String>>, most: usize) -> Vec<String> {
    let mut faults: Vec<String> =
        circles(graph).iter().filter(|circle| circle.len() > most).map(|circle| format!("files {circle:?}")).collect();
    let is_folder = |module: &str| graph.keys().any(|file| file.starts_with(&format!("{module}::")));
    for folder in graph.keys().filter(|file| file.is_empty() || is_folder(file)) {
        let modules = of_modules(graph, folder);
        let within = |module: &str| if folder.is_empty() { module.to_owned() } else { format!("{folder}::{module}") };
        let bad = |circle: &BTreeSet<&str>| circle.iter().any(|module| is_folder(&within(module)));
        let circles = circles(&modules);
        faults.extend(circles.iter().filter(|circle| bad(circle)).map(|circle| match folder.as_str() {
            "" => format!("modules {circle:?}"),
            folder => format!("modules of {folder} {circle:?}"),
        }));
    }
    faults
}

#[test]
fn imports_go_downward_within_every_crate() {
    let crates = crates();
    assert!(crates.len() >= FLOORS.len(), "{crates:?}");
    let mut faults_found = Vec::new();
    for folder in crates.iter().filter(|folder| folder.join("src").is_dir()) {
        let mut found = BTreeMap::new();
        modules(&folder.join("src"), "", &mut found);
        let graph = graph(&found);
        if folder.ends_with("moreau") {
            // The reading works: some edges that are there for certain, one of them through a re-export.
            for (from, to) in
                [("step", "workspace"), ("workspace", "osnsp::system"), ("osnsp::relay", "osnsp::delassus")]
            {
                assert!(graph[from].contains(to), "{from} imports from {to}: {:?}", graph[from]);
            }
        }
        let most = if PAIRED.contains(&name(&manifest(folder))) { 2 } else { 1 };
        faults_found.extend(faults(&graph, most).into_iter().map(|fault| format!("{}: {fault}", folder.display())));
    }
    assert!(faults_found.is_empty(), "{faults_found:#?}");
}

#[test]
fn crates_depend_on_those_below_them() {
    let floor = |name: &str| FLOORS.iter().position(|floor| *floor == name);
    for folder in crates() {
        let manifest = manifest(&folder);
        let own = name(&manifest);
        let Some(here) = floor(own) else {
            // A workspace that measures others shares nothing with them.
            let shared: Vec<String> =
                dependencies(&manifest, "dependencies").into_iter().filter(|d| floor(d).is_some()).collect();
            assert!(shared.is_empty(), "{own} stands on no floor and depends on {shared:?}");
            continue;
        };
        for table in ["dependencies", "build-dependencies", "dev-dependencies"] {
            for other in dependencies(&manifest, table) {
                let Some(there) = floor(&other) else { continue };
                // For its tests a crate may ask for features of its own.
                let is_own = table == "dev-dependencies" && other == own;
                assert!(there < here || is_own, "{own}: [{table}] names {other}, which stands above it");
            }
        }
    }
}

/// The planar linkages of `erard-kinematics` are of the engine's level: they import nothing beside themselves, no piano
/// among it. The three levers, which are one of them, import linkages only.
#[test]
fn linkages_know_nothing_of_pianos() {
    let mut found = BTreeMap::new();
    modules(&root().join("crates/erard-kinematics/src"), "", &mut found);
    let imports = graph(&found);
    let mut looked = 0;
    for (module, source) in &found {
        let Some(room) = ["linkage", "three_lever"].into_iter().find(|room| module.split("::").next() == Some(room))
        else {
            continue;
        };
        looked += 1;
        let allowed = |other: &str| other == room || (room, other) == ("three_lever", "linkage");
        for file in &imports[module] {
            assert!(file.split("::").next().is_some_and(allowed), "{module} imports {file}");
        }
        for other in ["erard", "moreau", "schemars", "serde"] {
            assert!(!without_tests(source).contains(&format!("{other}::")), "{module} names {other}");
        }
    }
    assert!(
        looked > 15 && imports["three_lever::train"].contains("linkage::mechanism"),
        "the reading works: {imports:?}"
    );
    assert!(found["derive"].contains("erard::"), "what knows pianos is beside them");
}

/// What a module of the Python package imports from its siblings, wherever in the file.
fn python_imports(source: &str, modules: &BTreeSet<String>) -> BTreeSet<String> {
    let mut imports = BTreeSet::new();
    for line in source.lines().map(str::trim) {
        let Some(rest) = line.strip_prefix("from .") else { continue };
        let Some((module, names)) = rest.split_once(" import ") else { continue };
        if module.is_empty() {
            for name in names.split(',').map(|name| name.split_whitespace().next().unwrap_or("").trim_matches('(')) {
                let own = if modules.contains(name) { name } else { "__init__" };
                // The extension is no file of the package.
                if name != "_erard" && !name.is_empty() {
                    imports.insert(own.to_owned());
                }
            }
        } else if modules.contains(module) {
            imports.insert(module.to_owned());
        }
    }
    imports
}

#[test]
fn imports_go_downward_within_the_python_package() {
    let folder = root().join("bindings/python/python/erard");
    let files = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let sources: BTreeMap<String, String> = files
        .filter(|path| path.extension().is_some_and(|e| e == "py"))
        .map(|path| (path.file_stem().unwrap().to_str().unwrap().to_owned(), fs::read_to_string(&path).unwrap()))
        .collect();
    let names: BTreeSet<String> = sources.keys().cloned().collect();
    let graph = sources.iter().map(|(name, source)| (name.clone(), python_imports(source, &names))).collect();
    let circles = circles(&graph);
    assert!(circles.is_empty(), "{circles:#?}");
    assert!(graph["_many"].contains("_instrument") && graph["_fit"].contains("_plot"), "the reading works: {graph:#?}");
}

/// The search finds a circle where there is one.
#[test]
fn a_circle_is_found() {
    let source = |uses: &str| uses.to_owned();
    let files = [
        ("a", source("use crate::b::{self, Thing};\n")),
        ("b", source("use crate::{One, d::{Two, Three as Third}};\n")),
        // What follows an item for tests counts.
        ("c", source("#[cfg(test)]\nuse crate::d::Not;\nuse super::a::Other;\n")),
        ("d", source("// use crate::a::Not;\nuse core::fmt;\n#[cfg(test)]\nmod tests {\n    use crate::a;\n}\n")),
        ("", source("mod c;\npub use c::One;\n")),
    ];
    let files = files.map(|(name, source)| (name.to_owned(), source)).into();
    let graph = graph(&files);
    assert_eq!(graph["b"], BTreeSet::from(["c".to_owned(), "d".to_owned()]));
    assert_eq!(circles(&graph), [BTreeSet::from(["a", "b", "c"])]);
    assert_eq!(faults(&graph, 2), [r#"files {"a", "b", "c"}"#]);
    let pair = BTreeMap::from([("a", "b"), ("b", "a")]);
    let pair = pair.iter().map(|(from, to)| ((*from).to_owned(), BTreeSet::from([(*to).to_owned()]))).collect();
    assert_eq!((faults(&pair, 1).len(), faults(&pair, 2).len()), (1, 0));
}

/// A folder in a circle is a fault although each of its files goes one way; a path in the code counts as an import.
#[test]
fn a_circle_of_folders_is_found() {
    let files = [
        ("low", "pub mod inner;\n"),
        ("low::inner", "fn f() { crate::high::g() }\n"),
        ("low::plain", "// crate::high::g\n"),
        ("high", "use crate::low::plain::Plain;\n"),
        ("", "mod low; mod high;\n"),
    ];
    let graph = graph(&files.map(|(name, source)| (name.to_owned(), source.to_owned())).into());
    assert_eq!(faults(&graph, 2), [r#"modules {"high", "low"}"#]);

    let within = [
        ("room", "mod low; mod high;\n"),
        ("room::low::inner", "fn f() { crate::room::high::g() }\n"),
        ("room::low::plain", "\n"),
        ("room::high", "use super::low::plain::Plain;\n"),
        ("", "mod room;\n"),
    ];
    let graph = self::graph(&within.map(|(name, source)| (name.to_owned(), source.to_owned())).into());
    assert_eq!(faults(&graph, 2), [r#"modules of room {"high", "low"}"#]);
}
