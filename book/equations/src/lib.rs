//! Equations of the book: blocks of LaTeX in Markdown, typeset as MathML, which browsers show without a network.
//!
//! An equation is a fenced block `math` that ends with its number, below a line with its anchor:
//!
//! ````text
//! <a id="t1"></a>
//! ```math
//! M(q)\,\mathrm{d}v+F(t,q,v)\,\mathrm{d}t=\mathrm{d}i
//! \tag{T1}
//! ```
//! ````
//!
//! GitHub, GitLab and editors typeset the same block themselves.

use std::ops::Range;

use math_core::{LatexToMathML, MathCoreConfig, MathDisplay};
use serde_json::Value;

/// An equation of a page.
#[derive(Debug, Clone, PartialEq)]
pub struct Equation {
    /// Line of the opening fence, from 1.
    pub line: usize,
    /// Letter of the chapter and number: `T1`.
    pub number: String,
    /// LaTeX without the number.
    pub latex: String,
    /// Lines of anchor and block, from 0.
    lines: Range<usize>,
}

impl Equation {
    /// Anchor on its page: the number in lower case.
    pub fn anchor(&self) -> String {
        self.number.to_lowercase()
    }

    /// A line of HTML with anchor, MathML and number.
    ///
    /// # Errors
    ///
    /// The line and the converter's message, if the LaTeX is invalid or has a command that the converter lacks.
    pub fn html(&self) -> Result<String, String> {
        let converter = LatexToMathML::new(MathCoreConfig::default()).expect("it has no macros");
        let made = converter.convert_with_local_state(&self.latex, MathDisplay::Block);
        let mathml = made.map_err(|error| format!("{}: ({}): {error}", self.line, self.number))?.mathml;
        Ok(format!(
            "<div class=\"equation\" id=\"{}\">{}<span class=\"number\">({})</span></div>",
            self.anchor(),
            mathml.replace('\n', ""),
            self.number
        ))
    }
}

/// The equations of a page, in order.
///
/// # Errors
///
/// Line and reason: a block without a number or without its anchor, or one that is not closed.
pub fn equations(page: &str) -> Result<Vec<Equation>, String> {
    let lines: Vec<&str> = page.lines().collect();
    let mut found = Vec::new();
    let mut at = 0;
    while at < lines.len() {
        let Some(info) = lines[at].strip_prefix("```") else {
            at += 1;
            continue;
        };
        let length = lines[at + 1..].iter().position(|line| *line == "```");
        let end = at + 1 + length.ok_or_else(|| format!("{}: the block is not closed", at + 1))?;
        if info == "math" {
            found.push(equation(&lines, at, end).map_err(|reason| format!("{}: {reason}", at + 1))?);
        }
        at = end + 1;
    }
    Ok(found)
}

/// The equation between two fences.
fn equation(lines: &[&str], open: usize, close: usize) -> Result<Equation, String> {
    let block = &lines[open + 1..close];
    let number = block.last().and_then(|last| last.strip_prefix("\\tag{")?.strip_suffix('}'));
    let number = number.ok_or("the last line of an equation is its number, `\\tag{LETTER NUMBER}`")?;
    let is_number = number.starts_with(|c: char| c.is_ascii_uppercase())
        && number.len() > 1
        && number[1..].bytes().all(|b| b.is_ascii_digit());
    if !is_number {
        return Err(format!("`{number}` is no number; expected one like T1"));
    }
    let anchor = format!("<a id=\"{}\"></a>", number.to_lowercase());
    if open == 0 || lines[open - 1] != anchor {
        return Err(format!("({number}) has no anchor; expected the line `{anchor}` above the block"));
    }
    let latex = block[..block.len() - 1].join("\n");
    Ok(Equation { line: open + 1, number: number.to_owned(), latex, lines: open - 1..close + 1 })
}

/// A page with its equations typeset.
///
/// # Errors
///
/// As of [`equations`] and [`Equation::html`].
pub fn typeset(page: &str) -> Result<String, String> {
    let mut lines: Vec<String> = page.lines().map(str::to_owned).collect();
    for equation in equations(page)?.into_iter().rev() {
        // Blank lines around a block of HTML.
        let html = ["".to_owned(), equation.html()?, "".to_owned()];
        lines.splice(equation.lines, html);
    }
    Ok(lines.join("\n") + "\n")
}

/// Typesets every chapter of a book as mdBook hands it to a preprocessor.
///
/// # Errors
///
/// The chapter's path, the line and the reason.
pub fn typeset_book(book: &mut Value) -> Result<(), String> {
    if let Some(chapter) = book.get_mut("Chapter").and_then(Value::as_object_mut) {
        let path = chapter.get("path").and_then(Value::as_str).unwrap_or("a chapter without a file").to_owned();
        if let Some(Value::String(content)) = chapter.get_mut("content") {
            *content = typeset(content).map_err(|reason| format!("{path}:{reason}"))?;
        }
    }
    match book {
        Value::Array(parts) => parts.iter_mut().try_for_each(typeset_book),
        Value::Object(parts) => parts.values_mut().try_for_each(typeset_book),
        _ => Ok(()),
    }
}
