//! The sheets as one page that opens from disk and prints well: nothing is fetched, and there is no script.

use std::fmt::Write;

use erard_workshop::measure::TimingRow;
use erard_workshop::measure::norms::{GROUPS, Line};
use erard_workshop::measure::range::MIDI_MAP;

use super::Measured;
use super::figures::Drawn;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use erard_figures::svg::escape;

const STYLE: &str = include_str!("page.css");

/// The page: flags first, then the table, the pictures and the timing sheets.
pub fn html(measured: &[Measured], drawings: &[Drawn], figures: &[Drawn]) -> String {
    let names: Vec<String> = measured.iter().map(|one| escape(&one.label)).collect();
    let title = names.join(" beside ");
    let mut out = format!(
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; style-src 'unsafe-inline'; \
         img-src data:\">\n<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <title>{title}: protocol sheet</title>\n<style>\n{STYLE}</style>\n</head>\n<body>\n<h1>{title}</h1>\n\
         <p class=\"soft\">Protocol sheet. Everything is measured in simulation, in the way in which a technician measures it. \
         Grams on the key are gram weights on the key front.</p>\n"
    );
    for one in measured {
        flags(&mut out, one, measured.len() > 1);
    }
    table(&mut out, measured);
    out.push_str("<h2>Pictures</h2>\n");
    for drawn in drawings.iter().chain(figures) {
        picture(&mut out, drawn);
    }
    for one in measured {
        let whose = if measured.len() > 1 { format!(": {}", escape(&one.label)) } else { String::new() };
        timing(&mut out, &one.sheet.timing, &whose);
    }
    out.push_str("</body>\n</html>\n");
    out
}

fn flags(out: &mut String, one: &Measured, named: bool) {
    let whose = if named { format!("{}: ", escape(&one.label)) } else { String::new() };
    // Writing to a string does not fail.
    if one.sheet.flags.is_empty() {
        let _ = writeln!(out, "<p>{whose}nothing is out of the norm.</p>");
        return;
    }
    let _ = writeln!(out, "<p class=\"out\">{whose}out of the norm</p>\n<ul class=\"flags\">");
    for flag in &one.sheet.flags {
        let _ = writeln!(out, "<li>{}</li>", escape(&flag.message));
    }
    out.push_str("</ul>\n");
}

fn table(out: &mut String, measured: &[Measured]) {
    out.push_str("<h2>Measures</h2>\n<table>\n<thead><tr><th></th>");
    for one in measured {
        let _ = write!(out, "<th scope=\"col\">{}</th>", escape(&one.label));
    }
    out.push_str("<th scope=\"col\">usual</th><th scope=\"col\" class=\"source\">source</th></tr></thead>\n<tbody>\n");
    for group in &GROUPS {
        let columns = measured.len() + 3;
        let heading = escape(group.heading);
        let _ = writeln!(out, "<tr class=\"group\"><th colspan=\"{columns}\" scope=\"rowgroup\">{heading}</th></tr>");
        for line in group.lines {
            if measured.iter().all(|one| (line.value)(&one.sheet).is_none()) && line.norm.is_none() {
                continue;
            }
            row(out, line, measured);
        }
    }
    out.push_str("</tbody>\n</table>\n");
}

fn row(out: &mut String, line: &Line, measured: &[Measured]) {
    let _ = write!(out, "<tr><th scope=\"row\">{}</th>", escape(line.label));
    for one in measured {
        let value = escape(&line.text((line.value)(&one.sheet)));
        // Colour alone says nothing on a grey print.
        let _ = match line.is_out(&one.sheet) {
            true => write!(out, "<td class=\"out\">{value} !</td>"),
            false => write!(out, "<td>{value}</td>"),
        };
    }
    let source = line.norm.map_or("", |norm| norm.source);
    let _ = writeln!(out, "<td>{}</td><td class=\"source\">{}</td></tr>", escape(&line.usual()), escape(source));
}

/// A picture as data: in a document of its own its names cannot clash with another's.
fn picture(out: &mut String, drawn: &Drawn) {
    let alt = escape(&drawn.alt);
    let data = STANDARD.encode(drawn.svg.as_bytes());
    let _ = writeln!(
        out,
        "<figure><img alt=\"{alt}\" src=\"data:image/svg+xml;base64,{data}\"><figcaption>{alt}</figcaption></figure>"
    );
}

fn timing(out: &mut String, rows: &[TimingRow], whose: &str) {
    let _ = write!(
        out,
        "<h2>Timing sheet{whose}</h2>\n<p class=\"soft\">Milliseconds after key start; built-in strokes, force driven. {}</p>\n\
         <table>\n<thead><tr><th></th>",
        escape(MIDI_MAP)
    );
    for heading in
        ["peak force (N)", "let-off", "hammer", "key bottom", "free flight", "hammer ahead", "speed (m/s)", "MIDI"]
    {
        let _ = write!(out, "<th scope=\"col\">{heading}</th>");
    }
    out.push_str("</tr></thead>\n<tbody>\n");
    let number =
        |value: Option<f64>, decimals: usize| value.map_or("-".to_owned(), |x| format!("{:.decimals$}", x + 0.0));
    for row in rows {
        let _ = write!(out, "<tr><th scope=\"row\">{} {}</th>", row.nuance, row.touch);
        let cells = [
            number(Some(row.peak_force_N), 1),
            number(row.let_off_ms, 1),
            number(row.hammer_contact_ms, 1),
            number(row.key_bottom_ms, 1),
            number(row.free_flight_ms, 1),
            number(row.hammer_before_bottom_ms, 1),
            number(row.hammer_speed_m_s, 2),
            number(row.midi_velocity.map(f64::from), 0),
        ];
        for cell in cells {
            let _ = write!(out, "<td>{cell}</td>");
        }
        out.push_str("</tr>\n");
    }
    out.push_str("</tbody>\n</table>\n");
}
