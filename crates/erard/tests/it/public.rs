//! The stored lists of promised names (docs/compatibility.md) equal the names that the crates re-export.
//! `.ci/regenerate --check public` compares every field and signature, too, where rustdoc writes JSON.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

/// The names of a crate's `lib.rs`: what it re-exports, and its public modules.
fn shown(source: &str) -> BTreeSet<String> {
    let lines = source.lines().filter(|line| !line.trim_start().starts_with("//"));
    let code: String = lines.collect::<Vec<_>>().join(" ");
    let mut names = BTreeSet::new();
    for declaration in code.split(';') {
        if let Some(at) = declaration.find("pub use ") {
            let path = &declaration[at + 8..];
            let inner = path.split_once('{').map_or(path, |(_, inner)| inner.trim_end_matches([' ', '}']));
            let last = |name: &str| name.trim().rsplit("::").next().unwrap_or_default().to_owned();
            names.extend(inner.split(',').map(last).filter(|name| !name.is_empty()));
        } else if let Some(at) = declaration.find("pub mod ") {
            names.insert(declaration[at + 8..].trim().to_owned());
        }
    }
    names
}

/// The names at the root of a list.
fn listed(krate: &str, list: &str) -> BTreeSet<String> {
    let heads = ["struct", "enum", "fn", "const fn", "const", "type", "trait", "mod"];
    let promised = list.lines().take_while(|line| !line.starts_with("# Not promised"));
    let name = |line: &str| {
        let path = heads.iter().find_map(|head| line.strip_prefix(&format!("pub {head} {krate}::")))?;
        let end = path.find(|c: char| !(c.is_alphanumeric() || c == '_')).unwrap_or(path.len());
        (!path[end..].starts_with("::")).then(|| path[..end].to_owned())
    };
    promised.filter_map(name).collect()
}

#[test]
fn the_lists_have_the_names_of_the_crates() {
    for (krate, least, most) in [("erard", 55, 80), ("moreau", 60, 120)] {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(krate);
        let source = fs::read_to_string(folder.join("src/lib.rs")).unwrap();
        let list = fs::read_to_string(folder.join("public.txt")).unwrap();
        let (shown, listed) = (shown(&source), listed(krate, &list));
        let gone: Vec<_> = listed.difference(&shown).collect();
        let new: Vec<_> = shown.difference(&listed).collect();
        assert!(
            gone.is_empty() && new.is_empty(),
            "crates/{krate}/public.txt is stale: new {new:?}, gone {gone:?}. `.ci/regenerate public` rewrites it; a name \
             that goes is deprecated first (docs/compatibility.md)"
        );
        assert!((least..=most).contains(&listed.len()), "{krate}: {} names", listed.len());
    }
}

/// Both readers find what they should.
#[test]
fn names_are_found() {
    let source = "mod a;\npub mod b;\n// pub use x::Not;\npub use a::{One,\n    two};\npub use c::d::Three;\n";
    assert_eq!(shown(source), ["One", "Three", "b", "two"].map(str::to_owned).into());
    let list = "# head\npub struct k::One<T>\npub k::One::field: f64\npub fn k::One::new() -> Self\npub fn k::two(x: f64)\npub mod k::b\n\
                # Not promised: x\npub struct k::Other\n";
    assert_eq!(listed("k", list), ["One", "b", "two"].map(str::to_owned).into());
}
