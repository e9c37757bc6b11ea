//! The book under `book/`: its commands run, its files are valid, its links lead somewhere, its pictures were drawn by
//! its own commands (or by one for the reader that names the picture), and its command-line reference is the program's.
//!
//! `.ci/regenerate book book-long` draws the pictures and prints the outputs again.

mod blocks;
#[path = "../../../examples/cli_reference/page.rs"]
mod cli_reference;
mod links;
mod session;

use std::fs;
use std::path::{Path, PathBuf};

use blocks::{Block, Kind};
use session::Session;

use crate::common::Folder;
use crate::generated;

/// A chapter.
struct Page {
    /// Path below `book/src`, with slashes.
    name: String,
    text: String,
}

fn source() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../book/src")
}

/// All chapters, sorted; not the table of contents.
fn pages() -> Vec<Page> {
    let mut pages: Vec<Page> = files(&source())
        .into_iter()
        .filter(|name| name.ends_with(".md") && name != "SUMMARY.md")
        .map(|name| Page { text: fs::read_to_string(source().join(&name)).expect("a chapter in UTF-8"), name })
        .collect();
    pages.sort_by(|a, b| a.name.cmp(&b.name));
    assert!(pages.len() > 5, "the chapters are found");
    pages
}

/// Files below a folder, as paths with slashes.
fn files(folder: &Path) -> Vec<String> {
    let mut names = Vec::new();
    for entry in fs::read_dir(folder).expect("the book is there").map(|e| e.expect("readable")) {
        let name = entry.file_name().into_string().expect("a name in UTF-8");
        if entry.path().is_dir() {
            names.extend(files(&entry.path()).into_iter().map(|below| format!("{name}/{below}")));
        } else {
            names.push(name);
        }
    }
    names
}

/// Chapters with a command that takes half a minute or more: a fit, a reproduction, a sheet with its list of work, a
/// piece on two keyboards, a keyboard weighed, the sensitivities of all numbers, a validation.
const LONG: [&str; 10] = [
    "bench.md",
    "gives.md",
    "keyboard.md",
    "measured.md",
    "model/strings.md",
    "morning.md",
    "piece.md",
    "real.md",
    "study.md",
    "validate.md",
];

/// The blocks of all chapters but the long ones.
#[test]
#[ignore = "ci: the commands of the book"]
fn commands_run_and_print_what_the_book_says() {
    follow(|name| !LONG.contains(&name));
}

mod nightly {
    /// The blocks of the long chapters.
    #[test]
    #[ignore = "nightly: the book's commands that take minutes"]
    fn long_commands_run_and_print_what_the_book_says() {
        let long = super::pages().iter().filter(|page| super::LONG.contains(&page.name.as_str())).count();
        assert_eq!(long, super::LONG.len(), "each is a chapter");
        super::follow(|name| super::LONG.contains(&name));
    }
}

/// Every chosen chapter's blocks in order, each chapter in a folder of its own; then its pictures.
fn follow(is_chosen: impl Fn(&str) -> bool) {
    let pages: Vec<Page> = pages().into_iter().filter(|page| is_chosen(&page.name)).collect();
    let faults: Vec<String> = std::thread::scope(|scope| {
        let running: Vec<_> = pages.iter().map(|page| scope.spawn(|| play(page))).collect();
        running.into_iter().flat_map(|r| r.join().expect("a chapter's run does not panic")).collect()
    });
    assert!(
        faults.is_empty(),
        "\n{}\n`.ci/regenerate book book-long` rewrites outputs and pictures",
        faults.join("\n")
    );
}

/// Runs a chapter; what is wrong with it, a line each.
fn play(page: &Page) -> Vec<String> {
    let blocks = match blocks::read(&page.text) {
        Ok(blocks) => blocks,
        Err(fault) => return vec![format!("book/src/{}:{fault}", page.name)],
    };
    let mut session = Session::new(&page.name);
    let mut printed: Vec<(&Block, String)> = Vec::new();
    for block in &blocks {
        match session.play(block) {
            Ok(None) => {}
            Ok(Some(output)) => printed.push((block, output)),
            // What follows may need it.
            Err(fault) => return vec![format!("book/src/{}:{}: {fault}", page.name, block.line)],
        }
    }
    let by_the_reader = |picture: &String| {
        blocks.iter().any(|b| b.kind == Kind::NoRun && b.text.contains(&format!("book/src/{picture}")))
    };
    let pictures: Vec<String> = links::pictures(&page.text).into_iter().filter(|p| !by_the_reader(p)).collect();
    if let Some(root) = generated::rewritten_below() {
        let chapter = blocks::with_outputs(&page.text, &printed);
        generated::write(&root, &format!("book/src/{}", page.name), chapter.as_bytes());
        pictures.iter().filter_map(|picture| session.keep(picture, &root.join("book/src")).err()).collect()
    } else {
        pictures.iter().filter_map(|picture| session.compare(picture, &source()).err()).collect()
    }
}

/// mdBook leaves out what the table of contents does not name.
#[test]
fn every_chapter_is_in_the_table_of_contents() {
    let summary = fs::read_to_string(source().join("SUMMARY.md")).expect("a table of contents");
    let listed = links::targets(&summary);
    for page in pages() {
        let times = listed.iter().filter(|target| **target == page.name).count();
        assert_eq!(times, 1, "SUMMARY.md names {} {times} times", page.name);
    }
    for target in listed {
        assert!(source().join(&target).is_file(), "SUMMARY.md names {target}, which is not there");
    }
}

#[test]
fn links_and_pictures_lead_somewhere() {
    let pages = pages();
    let faults: Vec<String> = pages.iter().flat_map(|page| links::faults(page, &pages)).collect();
    assert!(faults.is_empty(), "\n{}", faults.join("\n"));
    let shown: Vec<String> = pages.iter().flat_map(|page| links::pictures(&page.text)).collect();
    for file in files(&source()).iter().filter(|f| !f.ends_with(".md")) {
        assert!(shown.contains(file), "book/src/{file} is shown nowhere");
    }
}

#[test]
fn the_command_line_reference_is_the_generated_one() {
    generated::is_current("book/src/cli.md", cli_reference::markdown(erard_cli::command::definition()), "cli");
}

#[test]
fn the_picture_of_the_readme_is_drawn_by_the_program() {
    let folder = Folder::new("readme-picture");
    folder.good(&["draw", "--labels", "--out", "docs"]);
    for name in ["action.svg", "action.png"] {
        let (drawn, path) = (fs::read(folder.0.join("docs").join(name)).expect("it is drawn"), format!("docs/{name}"));
        // Its commit is that of the program that drew it.
        let kept = fs::read(Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").join(&path)).unwrap_or_default();
        if generated::rewritten_below().is_some() || picture(&kept) != picture(&drawn) {
            generated::is_current(&path, drawn, "readme-picture");
        }
    }
}

/// What is seen of an SVG or PNG file: without the metadata.
fn picture(file: &[u8]) -> Vec<u8> {
    if !file.starts_with(b"\x89PNG") {
        let text = String::from_utf8_lossy(file);
        let (head, rest) = text.split_once("<metadata>").unwrap_or((&text, ""));
        return [head, rest.split_once("</metadata>").map_or("", |(_, tail)| tail)].concat().into_bytes();
    }
    let (mut seen, mut rest) = (Vec::new(), &file[8..]);
    while let Some((length, after)) = rest.split_first_chunk::<4>() {
        let length = u32::from_be_bytes(*length) as usize;
        let Some(chunk) = after.get(..4 + length) else { break };
        if [&b"IHDR"[..], b"IDAT"].contains(&&chunk[..4]) {
            seen.extend_from_slice(chunk);
        }
        rest = after.get(8 + length..).unwrap_or_default();
    }
    seen
}
