//! The equations of the book: each is typeset, numbered, has its symbols in the glossary, and what refers to it says
//! its number. That links lead to an anchor is tested with the other links (`erard-cli`, module `book`).

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

use erard_equations::{Equation, equations, typeset, typeset_book};
use serde_json::json;

fn book() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../src")
}

/// Markdown below a folder, as (path below it with slashes, text).
fn pages(folder: &Path) -> BTreeMap<String, String> {
    let mut pages = BTreeMap::new();
    for entry in fs::read_dir(folder).expect("the folder is there").map(|entry| entry.expect("readable")) {
        let (path, name) = (entry.path(), entry.file_name().into_string().expect("a name in UTF-8"));
        if path.is_dir() {
            pages.extend(self::pages(&path).into_iter().map(|(below, text)| (format!("{name}/{below}"), text)));
        } else if name.ends_with(".md") {
            pages.insert(name, fs::read_to_string(&path).expect("a page in UTF-8"));
        }
    }
    pages
}

/// The pages with equations.
fn with_equations() -> BTreeMap<String, Vec<Equation>> {
    let found = |(name, text): (String, String)| {
        let equations = equations(&text).unwrap_or_else(|reason| panic!("{name}:{reason}"));
        (!equations.is_empty()).then_some((name, equations))
    };
    let found: BTreeMap<_, _> = pages(&book()).into_iter().filter_map(found).collect();
    assert!(found.len() > 5, "{:?}", found.keys());
    found
}

#[test]
fn every_equation_is_typeset() {
    for (name, text) in pages(&book()) {
        let page = typeset(&text).unwrap_or_else(|reason| panic!("{name}:{reason}"));
        assert!(!page.contains("```math") && !page.contains("\\tag"), "{name}");
    }
    for (name, equations) in with_equations() {
        for equation in equations {
            let html = equation.html().unwrap();
            // What LaTeX has left would be read as letters.
            let bare = html.split('<').filter_map(|piece| piece.split_once('>')).map(|(_, text)| text);
            let bare: String = bare.collect();
            assert!(!bare.contains(['\\', '$']), "{name}, ({}): {bare}", equation.number);
            // A blank line would end the block of HTML.
            assert!(!html.contains('\n'), "{name}, ({})", equation.number);
            assert!(is_balanced(&html), "{name}, ({}): {html}", equation.number);
            // To a browser a cell of an operator and words is one operator, and the words touch it.
            let quantity = ["<mi", "<mn", "<mfrac", "<msub", "<msup", "<munder", "<mover", "<msqrt"];
            let cells = html.split("<mtd").skip(1).filter_map(|cell| cell.split("</mtd>").next());
            for cell in cells.filter(|cell| cell.contains("<mo") && cell.contains("<mtext")) {
                assert!(quantity.iter().any(|tag| cell.contains(tag)), "{name}, ({}): {cell}", equation.number);
            }
        }
    }
}

/// Whether every element is closed, the last opened first.
fn is_balanced(html: &str) -> bool {
    let mut open = Vec::new();
    for tag in html.split('<').skip(1).filter_map(|piece| piece.split_once('>')).map(|(tag, _)| tag) {
        let name = tag.trim_start_matches('/').split_whitespace().next().unwrap_or_default();
        if tag.starts_with('/') {
            if open.pop() != Some(name) {
                return false;
            }
        } else if !tag.ends_with('/') {
            open.push(name);
        }
    }
    open.is_empty()
}

/// A letter for each chapter, and numbers from 1 in their order.
#[test]
fn equations_are_numbered_by_chapter() {
    let mut letters = BTreeSet::new();
    let glossary = fs::read_to_string(book().join("glossary.md")).unwrap();
    for (name, equations) in with_equations() {
        let letter = &equations[0].number[..1];
        for (i, equation) in equations.iter().enumerate() {
            assert_eq!(equation.number, format!("{letter}{}", i + 1), "{name}:{}", equation.line);
        }
        assert!(letters.insert(letter.to_owned()), "{name}: another chapter has the letter {letter}");
        let said = glossary.replace('\n', " ");
        assert!(
            said.contains(&format!(" {letter} [")),
            "{name}: the glossary lists no chapter with the letter {letter}"
        );
        assert!(glossary.contains(&format!("]({name})")), "{name}: the glossary does not name it");
    }
}

/// `[(T3)](model/time-stepping.md#t3)`: the text says the number to which the link leads.
#[test]
fn references_say_the_number() {
    let anchors: BTreeSet<String> =
        with_equations().into_values().flatten().map(|equation| equation.anchor()).collect();
    let notes = book().join("../../docs/notes");
    let mut count = 0;
    for (name, text) in pages(&book()).into_iter().chain(pages(&notes)) {
        for (before, after) in text.split("](").collect::<Vec<_>>().windows(2).map(|pair| (pair[0], pair[1])) {
            let target = after.split(')').next().unwrap_or_default();
            let Some((_, anchor)) = target.split_once('#').filter(|(_, anchor)| anchors.contains(*anchor)) else {
                continue;
            };
            let said = before.rsplit('[').next().unwrap_or_default();
            assert_eq!(said, format!("({})", anchor.to_uppercase()), "{name}: the link to {target}");
            count += 1;
        }
    }
    assert!(count > 3, "{count} references");
}

/// `(T3) of the book` in a source is an equation of the book.
#[test]
fn sources_refer_to_equations_that_are_there() {
    fn sources(folder: &Path, found: &mut Vec<PathBuf>) {
        for entry in fs::read_dir(folder).expect("the folder is there").map(|entry| entry.expect("readable").path()) {
            if entry.is_dir() {
                sources(&entry, found);
            } else if entry.extension().is_some_and(|end| end == "rs") {
                found.push(entry);
            }
        }
    }
    let numbers: BTreeSet<String> = with_equations().into_values().flatten().map(|equation| equation.number).collect();
    let crates = book().join("../../crates");
    let mut files = Vec::new();
    for one in fs::read_dir(crates).expect("crates").map(|entry| entry.expect("readable").path().join("src")) {
        if one.is_dir() {
            sources(&one, &mut files);
        }
    }
    let mut named = BTreeSet::new();
    for file in files {
        let text = fs::read_to_string(&file).expect("a source in UTF-8");
        // A line of a comment may end between the words.
        let text =
            text.split_whitespace().filter(|word| *word != "//!" && *word != "///").collect::<Vec<_>>().join(" ");
        for (before, _) in text.match_indices(") of the book").map(|(at, _)| text.split_at(at)) {
            let number = before.rsplit('(').next().unwrap_or_default();
            assert!(numbers.contains(number), "{}: ({number}) is no equation of the book", file.display());
            named.insert(number.to_owned());
        }
    }
    assert!((1..=5).all(|n| named.contains(&format!("T{n}"))) && named.len() > 12, "{named:?}");
}

/// Single letters of LaTeX without indices, words and functions.
fn letters(latex: &str) -> BTreeSet<char> {
    let mut found = BTreeSet::new();
    let mut rest = latex.replace("e^{-", "{-");
    for command in ["\\text{", "\\operatorname{", "\\mathrm{", "\\mathsf{", "_{", "\\begin{", "\\end{"] {
        while let Some((head, tail)) = rest.clone().split_once(command) {
            rest = format!("{head}_{}", tail.split_once('}').expect("it is closed").1);
        }
    }
    let chars: Vec<char> = rest.chars().collect();
    let mut at = 0;
    while at < chars.len() {
        match chars[at] {
            '\\' => {
                let name: String = chars[at + 1..].iter().take_while(|c| c.is_ascii_alphabetic()).collect();
                let greek = GREEK.iter().find(|(command, _)| *command == name);
                found.extend(greek.map(|(_, letter)| *letter));
                at += name.len().max(1);
            }
            // An index of one sign, or of one command.
            '_' if chars.get(at + 1) == Some(&'\\') => {
                at += 1;
                at += chars[at + 1..].iter().take_while(|c| c.is_ascii_alphabetic()).count();
            }
            '_' => at += usize::from(chars.get(at + 1).is_some_and(|c| c.is_alphanumeric())),
            c if c.is_alphabetic() => {
                found.insert(c);
            }
            _ => {}
        }
        at += 1;
    }
    found
}

const GREEK: [(&str, char); 13] = [
    ("alpha", 'α'),
    ("beta", 'β'),
    ("varepsilon", 'ε'),
    ("eta", 'η'),
    ("theta", 'θ'),
    ("mu", 'μ'),
    ("rho", 'ρ'),
    ("sigma", 'σ'),
    ("tau", 'τ'),
    ("omega", 'ω'),
    ("Omega", 'Ω'),
    ("lambda", 'λ'),
    ("kappa", 'κ'),
];

/// The table of symbols has every letter of a chapter's equations in a row that names the chapter.
#[test]
fn the_glossary_has_every_symbol() {
    assert_eq!(
        letters(r"c_{d,i}\,\dot\theta_\theta+\tfrac12m_pv_\mathrm{pivot}"),
        BTreeSet::from(['c', 'θ', 'm', 'v'])
    );
    let glossary = fs::read_to_string(book().join("glossary.md")).unwrap();
    let (_, table) = glossary.split_once("| symbol |").expect("a table of symbols");
    let rows: Vec<(&str, &str)> = table
        .lines()
        .filter_map(|row| {
            let cells: Vec<&str> = row.strip_prefix("| ")?.strip_suffix(" |")?.split(" | ").collect();
            Some((cells[0], *cells.get(3)?))
        })
        .collect();
    let mut missing = Vec::new();
    for (name, equations) in with_equations() {
        let of_chapter = rows.iter().filter(|(_, chapters)| chapters.contains(&format!("]({name})")));
        let symbols = of_chapter.map(|(symbols, _)| symbols.replace('ẑ', "z")).collect::<String>();
        let known: BTreeSet<char> = symbols.chars().collect();
        for equation in equations {
            let unknown: String = letters(&equation.latex).difference(&known).collect();
            // The indices of sums, the imaginary unit.
            let unknown = unknown.replace('i', "");
            if !unknown.is_empty() {
                missing.push(format!("{name}, ({}): {unknown}", equation.number));
            }
        }
    }
    assert!(missing.is_empty(), "symbols without a row in the glossary: {missing:#?}");
}

/// No equation is left as plain text: a number in brackets at the end of a line of a block.
#[test]
fn no_equation_is_plain_text() {
    for (name, text) in pages(&book()) {
        let mut code = false;
        for (i, line) in text.lines().enumerate() {
            code ^= line.starts_with("```");
            let last = line.trim_end().rsplit(' ').next().unwrap_or_default();
            let number = last.strip_prefix('(').and_then(|number| number.strip_suffix(')')).unwrap_or_default();
            let is_number = number.len() > 1
                && number.starts_with(|c: char| c.is_ascii_uppercase())
                && number[1..].bytes().all(|byte| byte.is_ascii_digit());
            assert!(!(code && is_number && line.contains('=')), "{name}:{}: {line}", i + 1);
        }
    }
}

#[test]
fn what_is_no_equation_is_refused() {
    let good = "a\n<a id=\"t1\"></a>\n```math\nx^2\n\\tag{T1}\n```\n";
    let page = typeset(good).unwrap();
    assert!(page.starts_with("a\n\n<div class=\"equation\" id=\"t1\"><math") && page.contains("(T1)"), "{page}");
    assert!(page.contains("<msup><mi>x</mi><mn>2</mn></msup>"), "{page}");
    for (from, to, said) in [
        ("\\tag{T1}\n", "", "3: the last line"),
        ("T1}", "1}", "3: `1` is no number"),
        ("t1", "t2", "3: (T1) has no anchor"),
        ("x^2", "\\unheard{x}", "3: (T1):"),
        ("x^2", "\\frac{x", "3: (T1):"),
        ("\\tag{T1}\n```", "\\tag{T1}", "3: the block is not closed"),
    ] {
        let reason = typeset(&good.replace(from, to)).unwrap_err();
        assert!(reason.starts_with(said), "{reason}");
    }
}

/// The book as mdBook writes it, with chapters below chapters.
#[test]
fn every_chapter_of_a_book_is_typeset() {
    let text = "<a id=\"t1\"></a>\n```math\nx\n\\tag{T1}\n```\n";
    let chapter = |below| json!({ "Chapter": { "name": "a", "content": text, "path": "a.md", "sub_items": below } });
    let mut book = json!({ "items": ["Separator", chapter(json!([chapter(json!([]))]))] });
    typeset_book(&mut book).unwrap();
    let book = book.to_string();
    assert_eq!((book.matches("<math").count(), book.matches("```").count()), (2, 0), "{book}");
    let mut wrong = chapter(json!([]));
    wrong["Chapter"]["content"] = "```math\nx\n```\n".into();
    assert!(typeset_book(&mut wrong).unwrap_err().starts_with("a.md:1: "));
}
