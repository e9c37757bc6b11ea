//! Pages that are printed: their paper, and what stands at their head.

use clap::{Args, ValueEnum};
use maud::{Markup, PreEscaped, html};

/// Sizes of paper.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, ValueEnum)]
pub enum Paper {
    /// 210 mm x 297 mm
    #[default]
    A4,
    /// 8.5 in x 11 in
    Letter,
}

impl Paper {
    /// The size as style sheets name it.
    #[must_use]
    pub fn css(self) -> &'static str {
        match self {
            Paper::A4 => "A4",
            Paper::Letter => "letter",
        }
    }
}

/// What stands at the head of a printed page. A page names no day by itself: the same work makes the same page.
#[derive(Debug, Clone, Default, Args)]
pub struct Headed {
    /// Serial number of the piano, for the head of the printed page
    #[arg(long, value_name = "TEXT", value_parser = words)]
    pub serial: Option<String>,
    /// Date for the head of the printed page
    #[arg(long, value_name = "TEXT", value_parser = words)]
    pub date: Option<String>,
    /// A note for the printed page, at most 400 characters
    #[arg(long, value_name = "TEXT", value_parser = words)]
    pub note: Option<String>,
    /// Paper of the printed page
    #[arg(long, value_enum, default_value_t = Paper::A4)]
    pub paper: Paper,
}

/// Longest text, characters: the page has room for no more.
const LONGEST: usize = 400;

fn words(text: &str) -> Result<String, String> {
    match text.chars().count() {
        count if count > LONGEST => Err(format!("{count} characters; expected at most {LONGEST}")),
        _ if text.chars().any(char::is_control) => Err("expected one line of text".to_owned()),
        _ => Ok(text.trim().to_owned()),
    }
}

/// The head of a page: what it may load (pictures that it holds itself, and nothing else), its title and its style sheet.
#[must_use]
pub fn html_head(title: &str, style: &str) -> Markup {
    html! {
        head {
            meta charset="utf-8";
            meta http-equiv="Content-Security-Policy"
                content="default-src 'none'; style-src 'unsafe-inline'; img-src data:";
            meta name="viewport" content="width=device-width, initial-scale=1";
            title { (title) }
            style { (PreEscaped(style)) }
        }
    }
}
