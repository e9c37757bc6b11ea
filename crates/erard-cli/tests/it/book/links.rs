//! Links and pictures of a page.

use super::{BOOK, NOTES, Page, root};

/// Targets of all links and pictures outside code, in order.
pub fn targets(text: &str) -> Vec<String> {
    // Inline code may hold brackets too, and lines end anywhere.
    let prose = prose(text).collect::<Vec<_>>().join("\n");
    let plain = prose.split('`').step_by(2).collect::<Vec<_>>().join("_");
    let after = plain.split("](").skip(1).filter_map(|piece| piece.split_once(')'));
    after.map(|(target, _)| target.split_whitespace().next().unwrap_or_default().to_owned()).collect()
}

/// Pictures of a page, as paths below its home.
pub fn pictures(text: &str) -> Vec<String> {
    let is_picture = |t: &String| t.ends_with(".svg") || t.ends_with(".png");
    targets(text).into_iter().filter(is_picture).map(|t| t.trim_start_matches("../").to_owned()).collect()
}

/// Links of a page that lead nowhere, or out of the book; notes that it names and that are not there.
pub fn faults(page: &Page, pages: &[Page]) -> Vec<String> {
    let mut faults = Vec::new();
    for target in targets(&page.text) {
        if target.starts_with("https://") {
            continue;
        }
        let (file, anchor) = target.split_once('#').unwrap_or((&target, ""));
        let path = resolve(&page.path(), file);
        if !root().join(&path).is_file() {
            faults.push(format!("{}: {target} is not there", page.path()));
        } else if page.home == BOOK && !path.starts_with(BOOK) {
            faults.push(format!("{}: {target} is not in the book; name its path in backticks", page.path()));
        } else if !anchor.is_empty() {
            let there =
                pages.iter().find(|p| p.path() == path).is_some_and(|p| anchors(&p.text).contains(&anchor.to_owned()));
            if !there {
                faults.push(format!("{}: {target}: no such heading", page.path()));
            }
        }
    }
    // A chapter cannot link to them: the book is read without the repository.
    for (name, _) in page.text.split(&format!("`{NOTES}/")).skip(1).filter_map(|rest| rest.split_once('`')) {
        if !root().join(NOTES).join(name).is_file() {
            faults.push(format!("{}: {NOTES}/{name} is not there", page.path()));
        }
    }
    faults
}

/// Lines outside fenced blocks.
fn prose(text: &str) -> impl Iterator<Item = &str> {
    let mut code = false;
    text.lines().filter(move |line| {
        let fence = line.starts_with("```");
        code ^= fence;
        !code && !fence
    })
}

/// A relative target as a path below the root.
fn resolve(from: &str, target: &str) -> String {
    if target.is_empty() {
        return from.to_owned();
    }
    let mut path: Vec<&str> = from.split('/').collect();
    path.pop();
    for step in target.split('/') {
        match step {
            ".." => {
                path.pop();
            }
            "." => {}
            step => path.push(step),
        }
    }
    path.join("/")
}

/// The anchors that mdBook gives to a chapter's headings, and those above its equations.
fn anchors(text: &str) -> Vec<String> {
    let equations = prose(text).filter_map(|line| line.strip_prefix("<a id=\"")?.strip_suffix("\"></a>"));
    let headings = prose(text).filter_map(|line| line.strip_prefix('#')).map(|line| {
        let title = line.trim_start_matches('#').trim().to_lowercase();
        title
            .chars()
            .filter_map(|c| match c {
                c if c.is_alphanumeric() || c == '_' || c == '-' => Some(c),
                c if c.is_whitespace() => Some('-'),
                _ => None,
            })
            .collect()
    });
    headings.chain(equations.map(str::to_owned)).collect()
}

#[test]
fn links_are_found_outside_code() {
    let text = "[a](b.md) and ![p](../pictures/x/y.svg) `[no](c.md)`\n```text\n[no](d.md)\n```\n[e](f.md#g)\n";
    assert_eq!(targets(text), ["b.md", "../pictures/x/y.svg", "f.md#g"]);
    assert_eq!(pictures(text), ["pictures/x/y.svg"]);
    assert_eq!(resolve("model/a.md", "../b.md"), "b.md");
    assert_eq!(anchors("# One, two: `x`\n<a id=\"t1\"></a>\n## F = k g^r\n"), ["one-two-x", "f--k-gr", "t1"]);
}
