//! The run as one page that opens from disk: the action moving, the curves beside it.
//!
//! The page holds no physics. Poses and forces are the run's; the script turns outlines, joins frames by straight lines
//! and draws arrows.

mod data;
mod frames;
mod scene;

pub use scene::scene;

use crate::HOUSE_STYLE;
use crate::drawing::{self, ChangedNote, Drawing, GRADIENTS, Piece, changed_marks, shapes};
use crate::figure::{self, Figure};
use crate::picture::{gradients, nodes};
use crate::svg::{escape, number};
use erard::instrument::{Instrument, Placement};
use erard::player::PinSeries;
use erard::run::Run;
use std::fmt::Write;

/// The script, in the order of its parts: later ones use earlier ones.
const SCRIPTS: [&str; 8] = [
    include_str!("read.js"),
    include_str!("moving.js"),
    include_str!("action.js"),
    include_str!("names.js"),
    include_str!("curves.js"),
    include_str!("numbers.js"),
    include_str!("save.js"),
    include_str!("transport.js"),
];
const STYLE: &str = include_str!("page.css");
const BODY: &str = include_str!("body.html");

/// A run, and what it was played on.
#[derive(Debug, Clone)]
pub struct Shown<'a> {
    /// Name that distinguishes it from the other one, e.g. `heavy-touch`.
    pub name: String,
    /// The instrument.
    pub instrument: &'a Instrument,
    /// The run.
    pub run: &'a Run,
    /// Forces in the pins, body by body, if they were recorded: arrows and a table.
    pub pins: &'a [PinSeries],
    /// Numbers whose notes speak of what they were: marked in the picture, and listed below it.
    pub changed: &'a [ChangedNote],
    /// File beside the page that holds its sound, if there is one.
    pub sound: Option<&'a str>,
}

impl<'a> Shown<'a> {
    /// A run under its instrument's name, without what need not be there.
    #[must_use]
    pub fn new(instrument: &'a Instrument, run: &'a Run) -> Self {
        Shown { name: run.instrument.clone(), instrument, run, pins: &[], changed: &[], sound: None }
    }
}

/// Content of the page's table: a heading for each column of values (none if there is one column), and rows of a name
/// and its values.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct SummaryTable {
    /// Headings.
    pub heads: Vec<String>,
    /// Names with their values, units included.
    pub rows: Vec<(String, Vec<String>)>,
}

/// What the page may look at, in picture millimetres: `[left, top, right, bottom]`.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Views {
    whole: [f64; 4],
    close: Option<[f64; 4]>,
}

/// The page. `stroke` is what was played; `summary` is what the command prints, as pairs of a name and a value with its
/// unit.
///
/// Nothing is fetched, and the page's own policy forbids it. Without JavaScript it shows the action at rest, the
/// summary, and says what is missing.
pub fn page_html(shown: &Shown<'_>, stroke: &str, summary: &[(String, String)]) -> String {
    let figure = figure::run_figure(shown.run, stroke);
    let rows = summary.iter().map(|(name, value)| (name.clone(), vec![value.clone()])).collect();
    page(std::slice::from_ref(shown), &figure, &SummaryTable { heads: Vec::new(), rows })
}

/// The page of two runs on one clock: both actions over each other in two tints or side by side, their curves, and a
/// table of what differs.
pub fn pair_html(title: &str, shown: &[Shown<'_>; 2], summary: &SummaryTable) -> String {
    let runs = [0, 1].map(|index| (shown[index].name.as_str(), shown[index].run));
    page(shown, &figure::pair_figure(title, runs), summary)
}

fn page(shown: &[Shown<'_>], figure: &Figure<'_>, summary: &SummaryTable) -> String {
    let drawings: Vec<Drawing> = shown.iter().map(|one| drawing::drawing(one.instrument)).collect();
    let mut views: Option<Views> = None;
    let mut groups = String::new();
    for (index, (one, drawing)) in shown.iter().zip(&drawings).enumerate() {
        let placed = one.instrument.placements(&drawing::angles_at(one.run, 0));
        let whole = drawing::view(one.instrument, &drawing.pieces, &placed);
        let close = close_up(one.instrument, &drawing.pieces, &placed);
        views = Some(match views {
            None => Views { whole, close },
            Some(other) => Views {
                whole: around(other.whole, whole),
                close: other.close.zip(close).map(|(a, b)| around(a, b)).or(other.close).or(close),
            },
        });
        let tint = if shown.len() > 1 { format!(" a{index}") } else { String::new() };
        let shapes = nodes(&shapes(drawing, &placed));
        let marks = nodes(&changed_marks(one.instrument, one.changed, &placed));
        let _ = write!(groups, "<g class=\"action{tint}\" data-action=\"{index}\">{shapes}{marks}</g>");
    }
    let views = views.unwrap_or(Views { whole: [0.0, 0.0, 1.0, 1.0], close: None });
    let data = data::data(shown, &drawings, figure, views);
    let mut rows = String::new();
    if !summary.heads.is_empty() {
        let heads: String =
            summary.heads.iter().map(|head| format!("<th scope=\"col\">{}</th>", escape(head))).collect();
        let _ = write!(rows, "<thead><tr><th scope=\"col\">measure</th>{heads}</tr></thead>");
    }
    rows.push_str("<tbody>");
    for (name, values) in &summary.rows {
        let values: String = values.iter().map(|value| format!("<td>{}</td>", escape(value))).collect();
        let _ = write!(rows, "<tr><th scope=\"row\">{}</th>{values}</tr>", escape(name));
    }
    rows.push_str("</tbody>");
    let whole = views.whole;
    let picture = format!(
        "<svg id=\"action\" tabindex=\"0\" role=\"img\" aria-label=\"The action, {}\" viewBox=\"{} {} {} {}\" \
         preserveAspectRatio=\"xMaxYMid meet\"><style>{}</style><defs>{}</defs>{groups}<g id=\"names\"></g>\
         <g class=\"forces\" id=\"forces\"></g><g id=\"numbers\"></g></svg>",
        escape(&figure.title),
        number(whole[0]),
        number(whole[1]),
        number(whole[2] - whole[0]),
        number(whole[3] - whole[1]),
        drawing::style(),
        gradients(GRADIENTS),
    );
    // Two actions can be hidden one by one, and say which is which.
    let mut which = String::new();
    if shown.len() > 1 {
        for (index, one) in shown.iter().enumerate() {
            let _ = writeln!(
                which,
                "<label><input type=\"checkbox\" id=\"see-{index}\" checked><span class=\"swatch a{index}\"></span>{}</label>",
                escape(&one.name)
            );
        }
        which.push_str("<label><input type=\"checkbox\" id=\"beside\" checked> side by side</label>\n");
    }
    if shown.iter().any(|one| !one.pins.is_empty()) {
        which.push_str("<label><input type=\"checkbox\" id=\"pin-forces\" checked> pin forces</label>\n");
    }
    let title = escape(&figure.title);
    let mut out = format!(
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; style-src 'unsafe-inline'; \
         script-src 'unsafe-inline'; img-src data: blob:; media-src 'self' file:\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <meta name=\"color-scheme\" content=\"light dark\">\n<title>{title}</title>\n<style>\n{HOUSE_STYLE}{STYLE}</style>\n</head>\n"
    );
    let doubts: String = shown.iter().map(|one| doubts(one, shown.len() > 1)).collect();
    let sound: String = shown.iter().filter_map(|one| one.sound).map(audio).collect();
    let changed: String = shown.iter().map(|one| changed_list(one, shown.len() > 1)).collect();
    let marks = [
        ("{title}", title.as_str()),
        ("{doubts}", &doubts),
        ("{summary}", &rows),
        ("{picture}", &picture),
        ("{which}", &which),
        ("{changed}", &changed),
        ("{sound}", &sound),
    ];
    out.push_str(&filled(BODY, &marks));
    let _ = write!(out, "<script type=\"application/json\" id=\"data\">{}</script>\n<script>\n", inline(&data));
    out.push_str("\"use strict\";\n(() => {\n");
    for script in SCRIPTS {
        // One of them is a module for other pages.
        out.push_str(&script.replace("\nexport const ", "\nconst "));
    }
    out.push_str("})();\n</script>\n</body>\n</html>\n");
    out
}

/// What plays a file beside a page, for the page's policy `media-src 'self' file:`.
#[must_use]
pub fn audio(file: &str) -> String {
    let address: String = file
        .bytes()
        .map(|byte| match byte {
            b'a'..=b'z' | b'A'..=b'Z' | b'0'..=b'9' | b'-' | b'_' | b'.' => char::from(byte).to_string(),
            _ => format!("%{byte:02X}"),
        })
        .collect();
    format!(
        "<p><audio controls preload=\"none\" src=\"{address}\"></audio> Before the soundboard, without a room; where no board moves, the strings\u{2019} force on the bridge.</p>\n"
    )
}

/// Why a run cannot be trusted; nothing where nothing speaks against it. Of two, it says which.
fn doubts(shown: &Shown<'_>, of_two: bool) -> String {
    let run = shown.run;
    if run.is_trusted() {
        return String::new();
    }
    let each: String = run.warnings.iter().map(|w| format!("<li>{}</li>", escape(&w.what))).collect();
    let which = if of_two { format!("{}: t", escape(&shown.name)) } else { "T".to_owned() };
    format!(
        "<section class=\"warning\" role=\"alert\"><strong>{which}his run cannot be trusted</strong><ul>{each}</ul></section>\n"
    )
}

/// The numbers that were changed under their notes; nothing where there are none. Of two, it says whose.
fn changed_list(shown: &Shown<'_>, of_two: bool) -> String {
    if shown.changed.is_empty() {
        return String::new();
    }
    let each: String = shown
        .changed
        .iter()
        .enumerate()
        .map(|(index, note)| format!("<li value=\"{}\">{}</li>", index + 1, escape(&note.text)))
        .collect();
    let whose = if of_two { format!("{}: c", escape(&shown.name)) } else { "C".to_owned() };
    format!(
        "<section class=\"changed\"><p>{whose}hanged, while the note beside it still speaks of a built-in instrument's value \
         (marked in the picture):</p><ol>{each}</ol></section>\n"
    )
}

/// The smallest rectangle around two.
fn around(a: [f64; 4], b: [f64; 4]) -> [f64; 4] {
    [a[0].min(b[0]), a[1].min(b[1]), a[2].max(b[2]), a[3].max(b[3])]
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
fn close_up(instrument: &Instrument, pieces: &[Piece], placed: &[Placement]) -> Option<[f64; 4]> {
    let key = instrument.roles.key?;
    let small: Vec<Piece> =
        pieces.iter().filter(|piece| piece.carrier.body().is_some_and(|body| body != key)).cloned().collect();
    let whole = drawing::view(instrument, pieces, placed);
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
        let page = page_html(&Shown::new(&instrument, &run), "mf", &summary());
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
        let page = page_html(&Shown::new(&two_levers(), &run), "", &summary());
        assert_eq!(page.matches("id=\"action\"").count(), 1);
        assert_eq!(page.matches("1 &amp; 2 m/s").count(), 1);
        assert!(page.contains("<title>A {picture} {summary} {title}</title>"));
        let shown = page.split("<body").nth(1).unwrap();
        assert!(shown.contains("A {picture} {summary} {title}"));
    }

    #[test]
    fn nothing_is_fetched() {
        let page = page_html(&Shown::new(&two_levers(), &two_levers_run(200)), "mf", &summary());
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
        assert_eq!(
            page_html(&Shown::new(&instrument, &run), "mf", &summary()),
            page_html(&Shown::new(&instrument, &run), "mf", &summary())
        );
    }

    #[test]
    fn odd_runs_still_give_a_page() {
        let mut broken = two_levers_run(50);
        broken.force_n.fill(f64::NAN);
        broken.bodies.pop();
        for run in [two_levers_run(0), two_levers_run(1), broken] {
            assert!(page_html(&Shown::new(&two_levers(), &run), "mf", &[]).ends_with("</html>\n"));
        }
    }

    /// Off without a record of the pins; with one, a box to switch them off and both components of every pin.
    #[test]
    fn pins_have_arrows_where_they_were_recorded() {
        let (instrument, run) = (two_levers(), two_levers_run(50));
        let shown = Shown::new(&instrument, &run);
        assert!(!page_html(&shown, "mf", &[]).contains("id=\"pin-forces\""));
        let pin = |name: &str| PinSeries {
            name: name.into(),
            acceleration_rad_per_s2: vec![0.0; 50],
            pin_x_n: vec![1.5; 50],
            pin_y_n: vec![-2.5; 50],
        };
        let pins: Vec<PinSeries> = instrument.bodies.iter().map(|body| pin(&body.name)).collect();
        let page = page_html(&Shown { pins: &pins, ..shown }, "mf", &[]);
        assert!(page.contains("id=\"pin-forces\""));
        let data = page.split("id=\"data\">").nth(1).unwrap().split("</script>").next().unwrap();
        let data: serde_json::Value = serde_json::from_str(data).unwrap();
        let written = data["actions"][0]["pins"].as_array().unwrap();
        assert_eq!(written.len(), instrument.bodies.len());
        for (index, pin) in written.iter().enumerate() {
            assert_eq!(pin["body"], index);
            for (component, value) in [("x", 1.5_f32), ("y", -2.5)] {
                use base64::Engine;
                let bytes = base64::engine::general_purpose::STANDARD.decode(pin[component].as_str().unwrap()).unwrap();
                assert_eq!(bytes.len(), 4 * 50);
                assert!(bytes.chunks(4).all(|four| four == value.to_le_bytes()));
            }
        }
    }

    /// Two actions can stand side by side; one alone has no such box.
    #[test]
    fn two_actions_can_stand_side_by_side() {
        let (instrument, run) = (two_levers(), two_levers_run(50));
        let pair = [Shown::new(&instrument, &run), Shown::new(&instrument, &run)];
        assert!(pair_html("two", &pair, &SummaryTable::default()).contains("id=\"beside\" checked"));
        assert!(!page_html(&pair[0], "mf", &[]).contains("id=\"beside\""));
    }
}
