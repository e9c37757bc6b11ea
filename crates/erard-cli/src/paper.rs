//! Pages that are printed: their paper, and what stands at their head.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use clap::Args;
use erard_figures::HOUSE_STYLE;
use maud::{DOCTYPE, Markup, PreEscaped, html};

use crate::names::{Name, one_of};

/// Sizes of paper by their names on the command line, as style sheets name them.
const PAPERS: [Name<&str>; 2] = [("a4", "210 mm x 297 mm", "A4"), ("letter", "8.5 in x 11 in", "letter")];

/// What stands at the head of a printed page. A page names no day by itself: the same work makes the same page.
#[derive(Debug, Clone, Default, Args)]
pub(crate) struct PageHeader {
    /// Serial number of the piano, for the head of the page to print
    #[arg(long, value_name = "TEXT", value_parser = words)]
    pub serial: Option<String>,
    /// Date for the head of the page to print
    #[arg(long, value_name = "TEXT", value_parser = words)]
    pub date: Option<String>,
    /// Note for the page to print, at most 400 characters
    #[arg(long, value_name = "TEXT", value_parser = words)]
    pub note: Option<String>,
    /// Paper of the page to print
    #[arg(long, value_parser = one_of(&PAPERS), default_value = "a4")]
    pub paper: &'static str,
}

/// Longest text, characters: the page has room for no more.
const MAX_CHARACTERS: usize = 400;

fn words(text: &str) -> Result<String, String> {
    match text.chars().count() {
        count if count > MAX_CHARACTERS => Err(format!("{count} characters; expected at most {MAX_CHARACTERS}")),
        _ if text.chars().any(char::is_control) => Err("expected one line of text".to_owned()),
        _ => Ok(text.trim().to_owned()),
    }
}

/// A page that opens from disk and prints well: nothing is fetched, and there is no script. `style` is what it adds to
/// the style of every page.
pub(crate) fn page(title: &str, style: &str, body: &Markup) -> String {
    let page = html! {
        (DOCTYPE)
        html lang="en" {
            (html_head(title, style))
            body { main { (body) } }
        }
    };
    page.into_string() + "\n"
}

/// A picture as data: in a document of its own its names cannot clash with another's. On a phone it keeps its size, so
/// that its letters can be read, and is moved sideways, by the keyboard too.
pub(crate) fn picture(alt: &str, svg: &str) -> Markup {
    html! {
        div.drawn tabindex="0" role="group" aria-label="Picture" {
            img alt=(alt) src={ "data:image/svg+xml;base64," (STANDARD.encode(svg)) };
        }
    }
}

/// The head of a page: what it may load (pictures that it holds itself, and nothing else), its title and its style
/// sheet.
fn html_head(title: &str, style: &str) -> Markup {
    html! {
        head {
            meta charset="utf-8";
            meta http-equiv="Content-Security-Policy"
                content="default-src 'none'; style-src 'unsafe-inline'; img-src data:; media-src 'self' file:";
            meta name="viewport" content="width=device-width, initial-scale=1";
            title { (title) }
            style { (PreEscaped(HOUSE_STYLE)) (PreEscaped(style)) }
        }
    }
}
