//! Page with all subjects.

use erard_figures::HOUSE_STYLE;
use erard_figures::figure::chart_picture;
use maud::{DOCTYPE, Markup, PreEscaped, html};

use crate::subjects::{Claim, Section, Subject, Table};

const STYLE: &str = include_str!("page.css");

/// A subject with its section.
pub(crate) struct Reproduced {
    /// Subject.
    pub subject: Subject,
    /// Its section of the report.
    pub section: Section,
}

/// Makes the page. `instrument` is the name of the instrument used.
pub(crate) fn page(instrument: &str, all: &[Reproduced]) -> String {
    let page = html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta http-equiv="Content-Security-Policy" content="default-src 'none'; style-src 'unsafe-inline'";
                meta name="viewport" content="width=device-width, initial-scale=1";
                title { "The papers, reproduced" }
                style { (PreEscaped(HOUSE_STYLE)) (PreEscaped(STYLE)) }
            }
            body {
                div.indexed {
                    nav.index aria-label="Contents" {
                        a href="#claims" { "Claims" }
                        @for one in all { a href={ "#" (one.subject.name) } { (one.subject.title) } }
                    }
                    main {
                        h1 { "The papers, reproduced" }
                        (overview(all))
                        (introduction(instrument))
                        @for one in all { (section(one)) }
                    }
                }
            }
        }
    };
    page.into_string() + "\n"
}

fn introduction(instrument: &str) -> Markup {
    html! {
        p {
            "Instrument: " (instrument) ". Program: erard " (env!("CARGO_PKG_VERSION")) ". Every number was computed when this \
             page was written. Each section names the command that computes it again. Times on the clock differ from run to \
             run, and their tables say so; everything else, and every figure, is the same each time."
        }
        p.soft {
            "[T12] Thorin, Boutillon, Lozada, Merlhiot, "
            i { "Simulation of a non-smooth dynamical model of the piano key" }
            ". [T13] Thorin, Boutillon, Merlhiot, Lozada, "
            i { "A non-smooth simulation of the dynamics of the grand piano action" }
            ", Waves 2013. [H] Hirschkorn, Birkett, McPhee, "
            i { "Kinematic model of a piano action mechanism" }
            "."
        }
    }
}

/// Verdict: how many claims hold, those that do not, and the count of every subject.
fn overview(all: &[Reproduced]) -> Markup {
    let claims = || all.iter().flat_map(|one| one.section.claims.iter().map(move |claim| (one, claim)));
    let (held, count) = (claims().filter(|(_, claim)| claim.holds).count(), claims().count());
    html! {
        h2 #claims { "Claims" }
        p { b { (held) " of " (count) " hold." } @if held < count { " These do not:" } }
        @if held < count {
            div.wide tabindex="0" role="region" aria-label="Claims that do not hold" { table {
                thead { tr { @for heading in ["where", "the claim", "measured here", "section"] { th scope="col" { (heading) } } } }
                tbody {
                    @for (one, claim) in claims().filter(|(_, claim)| !claim.holds) {
                        tr {
                            td { (claim.source) }
                            td { (with_code(&claim.says)) }
                            td.out { (with_code(&claim.measured)) }
                            td { a href={ "#" (one.subject.name) } { (one.subject.title) } }
                        }
                    }
                }
            } }
        }
        div.wide tabindex="0" role="region" aria-label="Claims by section" { table {
            thead { tr { th scope="col" { "section" } th.n scope="col" { "claims that hold" } th scope="col" { "to compute it again" } } }
            tbody {
                @for one in all.iter().filter(|one| !one.section.claims.is_empty()) {
                    @let holds = one.section.claims.iter().filter(|claim| claim.holds).count();
                    tr {
                        td { a href={ "#" (one.subject.name) } { (one.subject.title) } }
                        td.n { (holds) " of " (one.section.claims.len()) }
                        td { code { "erard-reproduce --only " (one.subject.name) } }
                    }
                }
            }
        } }
    }
}

/// Class of the element that shows a claim.
fn verdict(claim: &Claim) -> &'static str {
    if claim.holds { "holds" } else { "fails" }
}

fn section(one: &Reproduced) -> Markup {
    let (name, section) = (one.subject.name, &one.section);
    html! {
        section id=(name) {
            h2 { (one.subject.title) }
            p.soft.again { "Again: " code { "erard-reproduce --only " (name) } }
            @for paragraph in &section.text { p { (with_code(paragraph)) } }
            @for claim in &section.claims {
                div class={ "claim " (verdict(claim)) } {
                    p { b { (claim.source) } ": " (with_code(&claim.says)) "." }
                    p {
                        "Measured: " (with_code(&claim.measured)) ". "
                        b { @if claim.holds { "Holds." } @else { "Does not hold." } }
                    }
                }
            }
            @if !section.charts.is_empty() {
                div.figures {
                    @for (index, chart) in section.charts.iter().enumerate() {
                        figure {
                            div.drawn tabindex="0" role="group" aria-label="Figure" {
                                (PreEscaped(chart_picture(chart, &format!("{name}-{index}")).svg().trim_end()))
                            }
                            figcaption { (chart.caption) }
                        }
                    }
                }
            }
            @for (caption, text) in &section.listings { figure { pre tabindex="0" { (text) } figcaption { (caption) } } }
            @for one in &section.tables { (table(one)) }
        }
    }
}

/// Text with parts between backticks as code.
fn with_code(text: &str) -> Markup {
    html! {
        @for (i, part) in text.split('`').enumerate() {
            @if i % 2 == 1 { code { (part) } } @else { (part) }
        }
    }
}

fn table(table: &Table) -> Markup {
    // Columns of numbers are right-aligned.
    let numbers: Vec<bool> = (0..table.header.len())
        .map(|k| k > 0 && table.rows.iter().filter_map(|row| row.get(k)).all(|cell| is_number(cell)))
        .collect();
    let class = |k: usize| (numbers.get(k) == Some(&true)).then_some("n");
    html! {
        div.wide tabindex="0" role="region" aria-label=(table.caption) {
            table class=[table.clock.then_some("clock")] {
                caption { (table.caption) }
                thead { tr { @for (k, cell) in table.header.iter().enumerate() { th scope="col" class=[class(k)] { (cell) } } } }
                tbody {
                    @for row in &table.rows {
                        tr { @for (k, cell) in row.iter().enumerate() { td class=[class(k)] { (with_code(cell)) } } }
                    }
                }
            }
        }
    }
}

/// Whether a cell is empty, a dash, or begins like a number.
fn is_number(cell: &str) -> bool {
    let digits = cell.trim_start_matches(['+', '-']);
    digits.is_empty() || digits.starts_with(|c: char| c.is_ascii_digit()) && cell.len() < 28
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::subjects::subjects;

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

    /// Text cannot inject markup, a failed claim is shown in both places, and nothing is fetched.
    #[test]
    fn the_page_is_whole() {
        let page = page("a <b>", &reproduced());
        assert!(!page.contains("<script>") && page.contains("a &lt;b&gt;") && page.contains("x &lt; 1\ny"));
        assert!(page.contains("0 of 1 hold") && page.contains("Does not hold."));
        assert!(page.contains("erard-reproduce --only paper1-drives"));
        for word in ["http://", "https://", "src=", "@import", "url("] {
            assert!(!page.contains(word), "{word}");
        }
        assert!(page.ends_with("</html>\n"));
    }
}
