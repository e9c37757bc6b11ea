//! The page.

use std::fmt::Write;

use erard_lab::reproduce::{Section, Subject, Table};

use super::chart_svg;
use erard_figures::svg::escape;

const STYLE: &str = include_str!("report.css");

/// A subject with what came of it.
pub struct Reproduced {
    /// What it is.
    pub subject: Subject,
    /// What came of it.
    pub section: Section,
}

/// The page. `what` says what was run on what, e.g. the instrument's name.
pub fn page(instrument: &str, all: &[Reproduced]) -> String {
    let mut out = format!(
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<meta http-equiv=\"Content-Security-Policy\" \
         content=\"default-src 'none'; style-src 'unsafe-inline'\">\n<meta name=\"viewport\" content=\"width=device-width, \
         initial-scale=1\">\n<title>The papers, reproduced</title>\n<style>\n{STYLE}</style>\n</head>\n<body>\n<main>\n\
         <h1>The papers, reproduced</h1>\n<p>Instrument: {}. Program: erard {}.</p>\n",
        escape(instrument),
        env!("CARGO_PKG_VERSION")
    );
    out.push_str(
        "<p>Every number below was computed when this page was written; nothing is kept from one time to the next. Each section names the \
         command that makes just it again. Times on the clock differ from run to run and stand in tables that say so; everything else, \
         and every figure, is the same each time.</p>\n<p class=\"sources\">[T12] Thorin, Boutillon, Lozada, Merlhiot, <i>Simulation of a \
         non-smooth dynamical model of the piano key</i>. [T13] Thorin, Boutillon, Merlhiot, Lozada, <i>A non-smooth simulation of the \
         dynamics of the grand piano action</i>, Waves 2013. [H] Hirschkorn, Birkett, McPhee, <i>Kinematic model of a piano action \
         mechanism</i>.</p>\n",
    );
    overview(&mut out, all);
    for one in all {
        section(&mut out, one);
    }
    out.push_str("</main>\n</body>\n</html>\n");
    out
}

fn overview(out: &mut String, all: &[Reproduced]) {
    let claims = || all.iter().flat_map(|one| &one.section.claims);
    let (held, count) = (claims().filter(|c| c.holds).count(), claims().count());
    let _ = write!(
        out,
        "<h2 id=\"claims\">Claims</h2>\n<p>{held} of {count} hold.</p>\n<table class=\"claims\">\n<thead><tr><th>where</th><th>the claim</th>\
         <th>measured here</th><th>holds</th><th>again</th></tr></thead>\n<tbody>\n"
    );
    for one in all {
        for claim in &one.section.claims {
            let _ = writeln!(
                out,
                "<tr class=\"{class}\"><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td><a href=\"#{name}\"><code>--only {name}</code></a></td></tr>",
                escape(claim.source),
                escape(&claim.says),
                escape(&claim.measured),
                if claim.holds { "yes" } else { "NO" },
                class = if claim.holds { "holds" } else { "fails" },
                name = escape(one.subject.name),
            );
        }
    }
    out.push_str("</tbody>\n</table>\n");
}

fn section(out: &mut String, one: &Reproduced) {
    let (subject, section) = (&one.subject, &one.section);
    let name = escape(subject.name);
    let _ = write!(
        out,
        "<section id=\"{name}\">\n<h2>{}</h2>\n<p class=\"again\">Again: <code>erard reproduce --only {name}</code></p>\n",
        escape(subject.title)
    );
    for paragraph in &section.text {
        let _ = writeln!(out, "<p>{}</p>", with_code(paragraph));
    }
    for claim in &section.claims {
        let (class, verdict) = if claim.holds { ("holds", "Holds.") } else { ("fails", "Does not hold.") };
        let _ = writeln!(
            out,
            "<div class=\"claim {class}\"><p><b>{}</b>: {}.</p><p>Measured: {}. <b>{verdict}</b></p></div>",
            escape(claim.source),
            with_code(&claim.says),
            with_code(&claim.measured)
        );
    }
    for (caption, text) in &section.listings {
        let _ = writeln!(
            out,
            "<figure><pre>{}</pre><figcaption>{}</figcaption></figure>",
            escape_lines(text),
            escape(caption)
        );
    }
    for (index, chart) in section.charts.iter().enumerate() {
        let svg = chart_svg(chart, &format!("{name}-{index}"));
        let _ = writeln!(out, "<figure>{}<figcaption>{}</figcaption></figure>", svg.trim_end(), escape(&chart.caption));
    }
    for one in &section.tables {
        table(out, one);
    }
    out.push_str("</section>\n");
}

/// Text with what stands between backticks as code.
fn with_code(text: &str) -> String {
    let mut out = String::new();
    for (i, part) in text.split('`').enumerate() {
        let part = escape(part);
        out.push_str(&if i % 2 == 1 { format!("<code>{part}</code>") } else { part });
    }
    out
}

/// Text of several lines: [`escape`] would join them.
fn escape_lines(text: &str) -> String {
    text.lines().map(escape).collect::<Vec<_>>().join("\n")
}

fn table(out: &mut String, table: &Table) {
    // A column of numbers is set flush right.
    let numbers: Vec<bool> = (0..table.header.len())
        .map(|k| k > 0 && table.rows.iter().filter_map(|row| row.get(k)).all(|cell| is_number(cell)))
        .collect();
    let class = if table.clock { " class=\"clock\"" } else { "" };
    let _ =
        write!(out, "<div class=\"wide\"><table{class}>\n<caption>{}</caption>\n<thead><tr>", escape(&table.caption));
    let class = |k: usize| if numbers.get(k) == Some(&true) { " class=\"n\"" } else { "" };
    for (k, cell) in table.header.iter().enumerate() {
        let _ = write!(out, "<th{}>{}</th>", class(k), escape(cell));
    }
    out.push_str("</tr></thead>\n<tbody>\n");
    for row in &table.rows {
        out.push_str("<tr>");
        for (k, cell) in row.iter().enumerate() {
            let _ = write!(out, "<td{}>{}</td>", class(k), with_code(cell));
        }
        out.push_str("</tr>\n");
    }
    out.push_str("</tbody>\n</table></div>\n");
}

/// Whether a cell is empty, a dash, or begins like a number.
fn is_number(cell: &str) -> bool {
    let digits = cell.trim_start_matches(['+', '-']);
    digits.is_empty() || digits.starts_with(|c: char| c.is_ascii_digit()) && cell.len() < 28
}

#[cfg(test)]
mod tests {
    use super::*;
    use erard_lab::reproduce::{Claim, subjects};

    fn reproduced() -> Vec<Reproduced> {
        let section = Section {
            text: vec!["<script>".into()],
            claims: vec![Claim { source: "[T12]", says: "a < b".into(), measured: "1 & 2".into(), holds: false }],
            listings: vec![("c".into(), "x < 1\ny".into())],
            tables: vec![Table {
                caption: "t".into(),
                header: vec!["h".into()],
                rows: vec![vec!["-1.5 N".into()]],
                clock: true,
            }],
            ..Section::default()
        };
        vec![Reproduced { subject: subjects()[0], section }]
    }

    /// Nothing can break out, a claim that fails says so in both places, and nothing is fetched.
    #[test]
    fn the_page_is_whole() {
        let page = page("a <b>", &reproduced());
        assert!(!page.contains("<script>") && page.contains("a &lt;b&gt;") && page.contains("x &lt; 1\ny"));
        assert!(page.contains("0 of 1 hold") && page.contains("Does not hold."));
        assert!(page.contains("erard reproduce --only paper1-drives"));
        for word in ["http://", "https://", "src=", "@import", "url("] {
            assert!(!page.contains(word), "{word}");
        }
        assert!(page.ends_with("</html>\n"));
    }
}
