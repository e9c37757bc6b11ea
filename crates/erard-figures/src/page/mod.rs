//! The run as one page that opens from disk: the action moving, the curves beside it.
//!
//! The page holds no physics. Poses and forces are the run's; the script turns outlines, joins frames by straight lines
//! and draws arrows.

mod data;
mod frames;

use crate::drawing::{self, gradients, parts, placements, shapes};
use crate::svg::{escape, number};
use erard::instrument::{Instrument, Part};
use erard::run::Run;
use std::fmt::Write;

/// The script, in the order of its parts: later ones use earlier ones.
const SCRIPTS: [&str; 5] = [
    include_str!("read.js"),
    include_str!("action.js"),
    include_str!("curves.js"),
    include_str!("numbers.js"),
    include_str!("transport.js"),
];
const STYLE: &str = include_str!("page.css");
const BODY: &str = include_str!("body.html");

/// The page. `summary` is what the command prints, as pairs of a name and a value with its unit.
///
/// Nothing is fetched, and the page's own policy forbids it. Without JavaScript it shows the action at rest, the summary,
/// and says what is missing.
pub fn page_html(instrument: &Instrument, run: &Run, summary: &[(String, String)]) -> String {
    let angles = drawing::angles_at(run, 0);
    let placed = placements(instrument, &angles);
    let parts = parts(instrument);
    let whole = drawing::view(instrument, &parts, &placed);
    let close_up = close_up(instrument, &parts, &placed);
    let data = data::data(instrument, run, close_up, whole);
    let mut rows = String::new();
    for (name, value) in summary {
        let _ = write!(rows, "<tr><th scope=\"row\">{}</th><td>{}</td></tr>", escape(name), escape(value));
    }
    let picture = format!(
        "<svg id=\"action\" tabindex=\"0\" role=\"img\" aria-label=\"The action, {}\" viewBox=\"{} {} {} {}\" \
         preserveAspectRatio=\"xMaxYMid meet\"><style>{}</style><defs>{}</defs>{}<g class=\"forces\" id=\"forces\"></g></svg>",
        escape(&instrument.name),
        number(whole[0]),
        number(whole[1]),
        number(whole[2] - whole[0]),
        number(whole[3] - whole[1]),
        drawing::STYLE,
        gradients(),
        shapes(instrument, &parts, &placed),
    );
    let title = escape(&run.instrument);
    let mut out = format!(
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; style-src 'unsafe-inline'; \
         script-src 'unsafe-inline'\">\n<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <meta name=\"color-scheme\" content=\"light dark\">\n<title>{title}</title>\n<style>\n{STYLE}</style>\n</head>\n"
    );
    let doubts = doubts(run);
    let marks = [("{title}", title.as_str()), ("{doubts}", &doubts), ("{summary}", &rows), ("{picture}", &picture)];
    out.push_str(&filled(BODY, &marks));
    let _ = write!(out, "<script type=\"application/json\" id=\"data\">{}</script>\n<script>\n", inline(&data));
    out.push_str("\"use strict\";\n(() => {\n");
    for script in SCRIPTS {
        out.push_str(script);
    }
    out.push_str("})();\n</script>\n</body>\n</html>\n");
    out
}

/// Why the run is not to be trusted; nothing where nothing speaks against it.
fn doubts(run: &Run) -> String {
    if run.is_trusted() {
        return String::new();
    }
    let each: String = run.warnings.iter().map(|w| format!("<li>{}</li>", escape(&w.what))).collect();
    format!(
        "<section class=\"warning\" id=\"doubts\" role=\"alert\"><strong>This run is not to be trusted</strong><ul>{each}</ul></section>\n"
    )
}

/// A template with its marks replaced. What replaces them is not looked at again: a name may hold a mark.
fn filled(template: &str, marks: &[(&str, &str)]) -> String {
    let (mut out, mut rest) = (String::new(), template);
    let first = |rest: &str| marks.iter().filter_map(|(mark, by)| Some((rest.find(mark)?, *mark, *by))).min();
    while let Some((at, mark, by)) = first(rest) {
        out.push_str(&rest[..at]);
        out.push_str(by);
        rest = &rest[at + mark.len()..];
    }
    out + rest
}

/// JSON that cannot end the script element it stands in: `<` occurs within strings only, where it may be written so.
fn inline(data: &serde_json::Value) -> String {
    data.to_string().replace('<', "\\u003c").replace('\u{2028}', "\\u2028").replace('\u{2029}', "\\u2029")
}

/// The part of the picture where the small things happen: from the first thing carried by a body other than the key,
/// to the end, and as high as the whole. `None` where that is nearly all.
fn close_up(instrument: &Instrument, parts: &[Part], placed: &[drawing::Placement]) -> Option<[f64; 4]> {
    let key = instrument.roles.key?;
    let small: Vec<Part> = parts.iter().filter(|part| part.body.is_some_and(|body| body != key)).cloned().collect();
    let whole = drawing::view(instrument, parts, placed);
    let mut close = drawing::view(instrument, &small, placed);
    [_, close[1], close[2], close[3]] = whole;
    (!small.is_empty() && close[2] - close[0] < 0.8 * (whole[2] - whole[0])).then_some(close)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::drawing::fixture::{two_levers, two_levers_drawn, two_levers_run};

    fn summary() -> Vec<(String, String)> {
        vec![("speed <i>".into(), "1 & 2 m/s".into())]
    }

    /// Names from files reach the page in text, attributes and JSON; none may end an element early.
    #[test]
    fn names_cannot_break_out_of_the_page() {
        let instrument = two_levers_drawn();
        let mut run = two_levers_run(200);
        run.instrument = "</title><script>alert(1)</script>".into();
        run.zones[0].label = "</script><script>alert(2)</script>".into();
        let page = page_html(&instrument, &run, &summary());
        assert!(!page.contains("alert(1)</script>") && !page.contains("alert(2)</script>"));
        assert!(!page.contains("speed <i>") && page.contains("1 &amp; 2 m/s"));
        assert_eq!(page.matches("<script").count(), 2);
        assert_eq!(page.matches("</script>").count(), 2);
    }

    /// A name is no template, whatever it holds.
    #[test]
    fn names_are_not_filled_in() {
        let mut run = two_levers_run(200);
        run.instrument = "A {picture} {summary} {title}".into();
        let page = page_html(&two_levers(), &run, &summary());
        assert_eq!(page.matches("id=\"action\"").count(), 1);
        assert_eq!(page.matches("1 &amp; 2 m/s").count(), 1);
        assert!(page.contains("<title>A {picture} {summary} {title}</title>"));
        let shown = page.split("<body").nth(1).unwrap();
        assert!(shown.contains("A {picture} {summary} {title}"));
    }

    #[test]
    fn nothing_is_fetched() {
        let page = page_html(&two_levers(), &two_levers_run(200), &summary());
        for word in ["http://", "https://", "src=", "@import", "url(//", "fetch(", "XMLHttpRequest"] {
            let found = page.matches(word).count();
            // the one address allowed is the name of SVG's namespace
            let allowed = page.matches("http://www.w3.org/2000/svg").count();
            assert_eq!(found, if word == "http://" { allowed } else { 0 }, "{word}");
        }
        assert!(page.contains("default-src 'none'"));
    }

    #[test]
    fn the_same_run_gives_the_same_page() {
        let (instrument, run) = (two_levers(), two_levers_run(9000));
        assert_eq!(page_html(&instrument, &run, &summary()), page_html(&instrument, &run, &summary()));
    }

    #[test]
    fn odd_runs_still_give_a_page() {
        let mut broken = two_levers_run(50);
        broken.force_n.fill(f64::NAN);
        broken.bodies.pop();
        for run in [two_levers_run(0), two_levers_run(1), broken] {
            assert!(page_html(&two_levers(), &run, &[]).ends_with("</html>\n"));
        }
    }
}
