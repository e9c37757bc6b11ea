//! The book under `book/` and the notes under `docs/notes/`: their commands run, their files are valid, their links
//! lead somewhere, their pictures were drawn by their own commands (or by one for the reader that names the picture),
//! and the book's command-line reference is the program's.
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

/// Folder of the book's chapters.
const BOOK: &str = "book/src";
/// Folder of the notes for those who change the code.
const NOTES: &str = "docs/notes";
/// The folders, each with its table of contents.
const HOMES: [(&str, &str); 2] = [(BOOK, "SUMMARY.md"), (NOTES, "README.md")];

/// A chapter or a note.
struct Page {
    /// `BOOK` or `NOTES`.
    home: &'static str,
    /// Path below its home, with slashes.
    name: String,
    text: String,
}

impl Page {
    /// Path below the project's root, with slashes.
    fn path(&self) -> String {
        format!("{}/{}", self.home, self.name)
    }
}

/// The project's root.
fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// All chapters and notes, sorted; not the tables of contents.
fn pages() -> Vec<Page> {
    let mut pages = Vec::new();
    for (home, contents) in HOMES {
        let folder = root().join(home);
        for name in files(&folder).into_iter().filter(|name| name.ends_with(".md") && name != contents) {
            pages.push(Page { home, text: fs::read_to_string(folder.join(&name)).expect("a page in UTF-8"), name });
        }
        assert!(pages.iter().filter(|page| page.home == home).count() > 3, "the pages of {home} are found");
    }
    pages.sort_by_cached_key(Page::path);
    pages
}

/// Files below a folder, as paths with slashes.
fn files(folder: &Path) -> Vec<String> {
    let mut names = Vec::new();
    for entry in fs::read_dir(folder).expect("the folder is there").map(|e| e.expect("readable")) {
        let name = entry.file_name().into_string().expect("a name in UTF-8");
        if entry.path().is_dir() {
            names.extend(files(&entry.path()).into_iter().map(|below| format!("{name}/{below}")));
        } else {
            names.push(name);
        }
    }
    names
}

/// Pages with a command that takes half a minute or more: a fit, a reproduction, a sheet with its list of work, a
/// piece on two keyboards, a keyboard weighed, the sensitivities of all numbers, a validation, a study of samples.
const LONG: [&str; 11] = [
    "book/src/bench.md",
    "book/src/concert-grand.md",
    "book/src/keyboard.md",
    "book/src/measured.md",
    "book/src/morning.md",
    "book/src/piece.md",
    "book/src/real.md",
    "book/src/seminar.md",
    "book/src/study.md",
    "docs/notes/evidence.md",
    "docs/notes/strings.md",
];

/// The blocks of all pages but the long ones.
#[test]
#[ignore = "ci: the commands of the book"]
fn commands_run_and_print_what_the_book_says() {
    follow(|path| !LONG.contains(&path));
}

mod nightly {
    /// The blocks of the long pages.
    #[test]
    #[ignore = "nightly: the book's commands that take minutes"]
    fn long_commands_run_and_print_what_the_book_says() {
        let long = super::pages().iter().filter(|page| super::LONG.contains(&page.path().as_str())).count();
        assert_eq!(long, super::LONG.len(), "each is a page");
        super::follow(|path| super::LONG.contains(&path));
    }
}

/// Every chosen page's blocks in order, each page in a folder of its own; then its pictures. `ERARD_PAGE=morning.md`
/// leaves the other pages out.
fn follow(is_chosen: impl Fn(&str) -> bool) {
    let only = std::env::var("ERARD_PAGE").unwrap_or_default();
    let pages: Vec<Page> = pages().into_iter().filter(|page| is_chosen(&page.path())).collect();
    let pages: Vec<Page> = pages.into_iter().filter(|page| page.path().ends_with(&only)).collect();
    assert!(!pages.is_empty(), "no page {only}");
    let faults: Vec<String> = std::thread::scope(|scope| {
        let running: Vec<_> = pages.iter().map(|page| scope.spawn(|| play(page))).collect();
        running.into_iter().flat_map(|r| r.join().expect("a page's run does not panic")).collect()
    });
    assert!(
        faults.is_empty(),
        "\n{}\n`.ci/regenerate book book-long` rewrites outputs and pictures",
        faults.join("\n")
    );
}

/// Runs a page; what is wrong with it, a line each.
fn play(page: &Page) -> Vec<String> {
    let blocks = match blocks::read(&page.text) {
        Ok(blocks) => blocks,
        Err(fault) => return vec![format!("{}:{fault}", page.path())],
    };
    let mut session = Session::new(&page.path());
    let mut printed: Vec<(&Block, String)> = Vec::new();
    for block in &blocks {
        match session.play(block) {
            Ok(None) => {}
            Ok(Some(output)) => printed.push((block, output)),
            // What follows may need it.
            Err(fault) => return vec![format!("{}:{}: {fault}", page.path(), block.line)],
        }
    }
    let by_the_reader = |picture: &String| {
        blocks.iter().any(|b| b.kind == Kind::NoRun && b.text.contains(&format!("{}/{picture}", page.home)))
    };
    let pictures: Vec<String> = links::pictures(&page.text).into_iter().filter(|p| !by_the_reader(p)).collect();
    let faults: Vec<String> = if let Some(written) = generated::rewritten_below() {
        let text = blocks::with_outputs(&page.text, &printed);
        generated::write(&written, &page.path(), text.as_bytes());
        pictures.iter().filter_map(|picture| session.keep(picture, &written.join(page.home)).err()).collect()
    } else {
        pictures.iter().filter_map(|picture| session.compare(picture, &root().join(page.home)).err()).collect()
    };
    faults.into_iter().map(|fault| format!("{}: {fault}", page.path())).collect()
}

/// mdBook leaves out what the table of contents does not name.
#[test]
fn every_page_is_in_its_table_of_contents() {
    let pages = pages();
    for (home, contents) in HOMES {
        let folder = root().join(home);
        let listed = links::targets(&fs::read_to_string(folder.join(contents)).expect("a table of contents"));
        for page in pages.iter().filter(|page| page.home == home) {
            let times = listed.iter().filter(|target| **target == page.name).count();
            assert_eq!(times, 1, "{home}/{contents} names {} {times} times", page.name);
        }
        for target in listed {
            assert!(folder.join(&target).is_file(), "{home}/{contents} names {target}, which is not there");
        }
    }
}

/// Most words of the reader's path, commands and outputs among them: what only a developer needs goes into a note.
const PATH_WORDS: usize = 35_000;

#[test]
fn the_readers_path_is_short() {
    let summary = fs::read_to_string(root().join(BOOK).join("SUMMARY.md")).expect("a table of contents");
    let (_, path) = summary.split_once("# Begin").expect("its first part");
    let (path, _) = path.split_once("# Look up").expect("its last part");
    let words = |chapter: String| {
        let text = fs::read_to_string(root().join(BOOK).join(chapter)).expect("a chapter in UTF-8");
        text.split_whitespace().count()
    };
    let words: usize = links::targets(path).into_iter().map(words).sum();
    assert!((1000..=PATH_WORDS).contains(&words), "{words} words from Begin to Understand; at most {PATH_WORDS}");
}

#[test]
fn links_and_pictures_lead_somewhere() {
    let pages = pages();
    let faults: Vec<String> = pages.iter().flat_map(|page| links::faults(page, &pages)).collect();
    assert!(faults.is_empty(), "\n{}", faults.join("\n"));
    for (home, _) in HOMES {
        let of_home = pages.iter().filter(|page| page.home == home);
        let shown: Vec<String> = of_home.flat_map(|page| links::pictures(&page.text)).collect();
        for file in files(&root().join(home)).iter().filter(|f| !f.ends_with(".md")) {
            assert!(shown.contains(file), "{home}/{file} is shown nowhere");
        }
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
        let kept = fs::read(root().join(&path)).unwrap_or_default();
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
